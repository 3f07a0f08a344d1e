!> Which mass matrix a run uses: how much of each cell is lumped, and how the equations are solved.
module hampm_mass_choice
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_nodal_rows, only: pattern_of_grid
   use hampm_mass_solver, only: by_lumped, by_fmpm, by_cg, by_umfpack, by_banded
   implicit none
   private
   public :: mass_choice_t, new_mass_choice, choose_cells

   !> What a scene asks for: kind of the mass matrix, its parameters, and the solver.
   type :: mass_choice_t
      integer :: by = by_lumped                  !! way of solution
      integer :: order = 1                       !! of fmpm
      logical :: refined_only = .false.          !! whether a partial one is full in the refined cells, else in the box
      real(dp) :: blend_inside = 0               !! lumped part of the cells within the box [-]
      real(dp) :: blend_outside = 0              !! and of the others [-]
      real(dp) :: lower(ndim) = -huge(1.0_dp)    !! box of a partial mass matrix [m]
      real(dp) :: upper(ndim) = huge(1.0_dp)
   end type mass_choice_t

contains

   !> A mass matrix by name: 'lumped', 'full', 'partial' (full within the box, lumped elsewhere), 'fmpm' of an order, or
   !> 'blend' with a lumped part.
   pure function new_mass_choice(mass, solver, order, blend, lower, upper, refined_only) result(choice)
      character(*), intent(in) :: mass
      character(*), intent(in) :: solver         !! 'cg', 'umfpack' or 'banded'
      integer, intent(in) :: order
      real(dp), intent(in) :: blend
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      logical, intent(in), optional :: refined_only !! instead of the box
      type(mass_choice_t) :: choice
      select case (solver)
      case ('cg')
         choice%by = by_cg
      case ('umfpack')
         choice%by = by_umfpack
      case ('banded')
         choice%by = by_banded
      end select
      select case (mass)
      case ('lumped')
         choice%by = by_lumped
      case ('fmpm')
         choice%by = by_fmpm
         choice%order = order
      case ('blend')
         choice%blend_inside = blend
         choice%blend_outside = blend
      case ('partial')
         choice%blend_outside = 1
         choice%lower = lower
         choice%upper = upper
         if (present(refined_only)) choice%refined_only = refined_only
      end select
   end function new_mass_choice

   !> Room for the cell matrices of a choice, and how much of each cell is lumped. A cell is within the box where its middle
   !> is. Fails where the memory does not suffice.
   subroutine choose_cells(choice, grid, matrix, failure)
      type(mass_choice_t), intent(in) :: choice
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      type(failure_t), intent(inout) :: failure
      real(dp) :: middle(ndim)
      integer :: e, status
      if (choice%by == by_lumped) return
      call pattern_of_grid(grid, matrix%pattern, status)
      associate (width => matrix%pattern%width, m => grid%n_elements, n => grid%n_points)
         if (status == 0) allocate (matrix%cell(corners, corners, m), matrix%blend(m), matrix%is_quarter(m), &
                                    matrix%cell_lumped(corners, m), matrix%row(width, n), stat=status)
         if (status == 0 .and. choice%by == by_cg) allocate (matrix%cell_inverse(corners, corners, m), &
                                                             matrix%inverse_row(width, n), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of cells')
         return
      end if
      matrix%is_solved = choice%by /= by_fmpm
      do e = 1, grid%n_elements
         matrix%is_quarter(e) = grid%is_transition(grid%element_leaf(e))
         matrix%blend(e) = choice%blend_outside
         middle = grid%element_lower(:, e) + 0.5_dp*grid%element_size(e)
         if (choice%refined_only) then
            if (grid%forest%level_of(grid%element_leaf(e)) > 0) matrix%blend(e) = choice%blend_inside
         else if (all(middle >= choice%lower .and. middle <= choice%upper)) then
            matrix%blend(e) = choice%blend_inside
         end if
      end do
   end subroutine choose_cells
end module hampm_mass_choice
