!> What has its turns together where time steps fit the size of the cells (`hampm_step_groups`): blocks of cells side by side, which
!> a sweep takes at once, and points in the order of how often their velocities change.
module hampm_step_runs
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_particles, only: particles_t, lanes
   use hampm_step_groups, only: plain
   implicit none
   private
   public :: run_t, find_runs, order_by_rate

   !> Blocks side by side whose cells have their turns together.
   type :: run_t
      integer :: group = 0
      integer :: kind = plain                    !! the largest of the kinds of its cells, as which all are treated
      integer :: kick_rate = 0                   !! when the first of its cells get forces
      integer :: velocity_rate = 0               !! and when the velocity of the first of their corners changes
      integer :: blocks(2) = 0                   !! the first and the last
   end type run_t

contains

   !> Find the runs of the blocks.
   pure subroutine find_runs(p, f, runs)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      type(run_t), allocatable, intent(out) :: runs(:)
      type(run_t), allocatable :: found(:)
      type(run_t) :: next
      integer :: b, n
      allocate (found(p%n_blocks))
      n = 0
      do b = 1, p%n_blocks
         next = run_of_block(p, f, b)
         if (n > 0) then
            if (found(n)%group == next%group .and. found(n)%kind == next%kind) then
               found(n)%blocks(2) = b
               found(n)%kick_rate = min(found(n)%kick_rate, next%kick_rate)
               found(n)%velocity_rate = min(found(n)%velocity_rate, next%velocity_rate)
               cycle
            end if
         end if
         n = n + 1
         found(n) = next
      end do
      runs = found(:n)
   end subroutine find_runs

   !> A run of one block.
   pure type(run_t) function run_of_block(p, f, b) result(run)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: b
      integer :: l, e
      run%blocks = b
      run%group = p%groups%of_cell(p%block_cells(1, b))
      run%kick_rate = run%group
      run%velocity_rate = run%group
      do l = 1, lanes
         e = p%block_cells(l, b)
         if (e == 0) exit
         run%kind = max(run%kind, p%groups%kind(e))
         run%kick_rate = min(run%kick_rate, p%groups%kick_rate(e))
         run%velocity_rate = min(run%velocity_rate, minval(p%groups%velocity_rate(f%block_nodes(:, l, b))))
      end do
   end function run_of_block

   !> Order points by a rate, and count those up to each.
   pure subroutine order_by_rate(points, rate, largest, ordered, until)
      integer, intent(in) :: points(:)
      integer, intent(in) :: rate(:)             !! by point
      integer, intent(in) :: largest             !! of the rates
      integer, allocatable, intent(out) :: ordered(:), until(:)
      integer :: k, g
      allocate (ordered(size(points)), until(0:largest))
      until = 0
      do k = 1, size(points)
         until(rate(points(k))) = until(rate(points(k))) + 1
      end do
      do g = 1, largest
         until(g) = until(g) + until(g - 1)
      end do
      do k = size(points), 1, -1
         associate (place => until(rate(points(k))))
            ordered(place) = points(k)
            place = place - 1
         end associate
      end do
      until(:largest - 1) = until(1:)
      until(largest) = size(points)
   end subroutine order_by_rate
end module hampm_step_runs
