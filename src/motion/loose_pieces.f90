!> The look whether a piece of a cell, as a crack or the edge of a body leaves it, holds by next to nothing: then the load on it has strained it
!> far more than the cells beside it, and nothing that depends on it has a meaning.
!>
!> A measure, whatever has let it loose: in a piece that holds, strains are those beside it but for a factor that the place tells (2.6 in slivers at
!> rings under pressure), while loose ones have hundreds of times these.
module hampm_loose_pieces
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t, exit_computation
   use hampm_ghost_penalty, only: fills_of_pieces, enough
   use hampm_motion, only: motion_t
   use hampm_text, only: to_text, three_digits
   implicit none
   private
   public :: check_pieces

   real(dp), parameter :: most = 20              !! strain of a piece over the largest beside it

contains

   !> Fail where a piece is loose, and name the place.
   subroutine check_pieces(m, now, failure)
      type(motion_t), intent(in) :: m
      character(*), intent(in) :: now            !! time, in words
      type(failure_t), intent(inout) :: failure
      real(dp) :: fill(m%grid%n_elements), strain(m%grid%n_elements), beside
      integer :: i, e
      fill = fills_of_pieces(m%grid, m%particles)
      strain = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            strain(first) = max(strain(first), strain_of(m%particles%gradient_of(i)))
         end associate
      end do
      do e = 1, m%grid%n_elements
         if (.not. fill(e) > 0 .or. fill(e) >= enough .or. .not. m%grid%is_cut(m%grid%element_leaf(e))) cycle
         beside = largest_beside(m, e, fill, strain)
         if (.not. (beside > 0 .and. strain(e) > most*beside)) cycle
         associate (x => m%grid%element_lower(:, e) + m%grid%leaf_size(e)/2)
            call failure%report(exit_computation, now//'material in the cell around ('//to_text(x(1))//', '//to_text(x(2))// &
                                ') m, of which a crack or an edge leaves '//three_digits(100*fill(e))//' %, has a strain of '// &
                                three_digits(strain(e))//', '//three_digits(strain(e)/beside)//' times that of the cells '// &
                                'beside it: hardly anything holds it. Move the crack, the edge or the load, or use smaller '// &
                                '&grid cell')
         end associate
         return
      end do
   end subroutine check_pieces

   !> The largest strain in fuller pieces that have a node in common with a piece; 0 where there are none.
   pure real(dp) function largest_beside(m, e, fill, strain) result(largest)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: e                   !! the first element of the piece
      real(dp), intent(in) :: fill(:), strain(:) !! by the first element of each piece
      integer :: element, c, k, other
      largest = 0
      do element = e, m%grid%last_of_piece(e)
         do c = 1, size(m%grid%element_nodes, 1)
            associate (around => m%grid%dofs%elements_at(m%grid%element_nodes(c, element)))
               do k = 1, size(around)
                  other = m%grid%first_of_piece(around(k))
                  if (fill(other) > fill(e)) largest = max(largest, strain(other))
               end do
            end associate
         end do
      end do
   end function largest_beside

   !> Norm of the strain of Green and Lagrange [-].
   pure real(dp) function strain_of(gradient) result(strain)
      real(dp), intent(in) :: gradient(ndim, ndim) !! of the displacement [-]
      strain = norm2(gradient + transpose(gradient) + matmul(transpose(gradient), gradient))/2
   end function strain_of
end module hampm_loose_pieces
