!> What integrators with time steps that fit the size of the cells have in common: a coarse step is 2**largest finest ones, and
!> cells of group g (`hampm_step_groups`) take 2**g of these at once.
module hampm_local_steps
   use hampm_kinds, only: dp, long
   use hampm_cell_blocks, only: cell_blocks_t, smallest_occupied_cell
   use hampm_integrator, only: integrator_t, steps_for
   use hampm_motion, only: motion_t
   implicit none
   private
   public :: local_steps_t

   real(dp), parameter :: farthest = 0.5_dp      !! that particles may move in a coarse step, in smallest cells

   !> Steps that fit the size of the cells.
   type, abstract, extends(integrator_t) :: local_steps_t
      real(dp) :: time_between_outputs = 0       !! of which times to the next one are multiples, by steps of one length; 0 else [s]
   contains
      procedure :: choose_steps
   end type local_steps_t

contains

   !> Choose how many finest steps a coarse one takes, and how many coarse ones fill a time: those that do the least work.
   subroutine choose_steps(self, m, time, limit, steps, dt)
      class(local_steps_t), intent(inout) :: self
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! longest that a finest step may be [s]
      integer(long), intent(out) :: steps        !! coarse ones
      real(dp), intent(out) :: dt                !! finest step [s]
      real(dp) :: work, least, part
      integer(long) :: k, parts
      integer :: g
      call divide(self, time, parts, part)
      self%largest = 0
      steps = steps_for(part, limit)
      least = steps*turns(m%blocks, 0)
      do g = 1, m%blocks%groups%largest
         if (.not. moves_little(m, 2**g*limit)) exit
         k = steps_for(part, 2**g*limit)
         work = k*turns(m%blocks, g)
         if (work >= least) cycle
         least = work
         self%largest = g
         steps = k
      end do
      dt = part/(steps*2**self%largest)
      steps = parts*steps
   end subroutine choose_steps

   !> Divide a time into parts for which steps are chosen, always the same where it is a multiple of that between outputs.
   subroutine divide(self, time, parts, part)
      class(local_steps_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      integer(long), intent(out) :: parts
      real(dp), intent(out) :: part              !! [s]
      real(dp), parameter :: rounding = 1e-6_dp  ! of a part, that is no time of its own
      parts = 1
      part = time
      if (.not. self%time_between_outputs > 0) return
      parts = max(1_long, nint(time/self%time_between_outputs, long))
      if (abs(parts*self%time_between_outputs - time) <= rounding*self%time_between_outputs) then
         part = self%time_between_outputs
      else
         parts = 1
      end if
   end subroutine divide

   !> How many turns the blocks have in all in a coarse step of 2**largest finest ones.
   pure real(dp) function turns(blocks, largest)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: largest
      integer :: b
      turns = 0
      do b = 1, blocks%n
         turns = turns + 2.0_dp**(largest - min(largest, blocks%groups%by_size(blocks%cells(1, b))))
      end do
   end function turns

   !> Whether no particle moves further in the grid than it may in a time.
   pure logical function moves_little(m, time) result(little)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      little = m%particles%total_frame
      if (.not. little) little = maxval(abs(m%particles%velocity))*time <= farthest*smallest_occupied_cell(m%grid, m%blocks)
   end function moves_little
end module hampm_local_steps
