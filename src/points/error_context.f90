!> When and where something went wrong, for messages.
module hampm_error_context
   use hampm_kinds, only: dp, long
   use hampm_grid, only: grid_t
   use hampm_particles, only: particles_t
   use hampm_text, only: to_text, point_text, without_rounding
   implicit none
   private
   public :: when, origin

contains

   !> Step and time.
   function when(step, time) result(text)
      integer(long), intent(in) :: step
      real(dp), intent(in) :: time               !! [s]
      character(:), allocatable :: text
      text = 'step '//to_text(step)//', t = '//to_text(without_rounding(time, time))//' s: '
   end function when

   !> Where a particle started, and the cell in which it was sorted last.
   function origin(grid, p, i) result(text)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      character(:), allocatable :: text
      text = point_text(p%reference(i, :))//' m'
      if (p%cell(i) == 0) return
      associate (e => p%cell(i), width => grid%element_size(p%cell(i)))
         text = text//' (in the cell of level '//to_text(grid%forest%level_of(grid%element_leaf(e)))//', '//to_text(width)// &
                ' m wide, around '//point_text(grid%element_lower(:, e) + width/2)//' m)'
      end associate
   end function origin
end module hampm_error_context
