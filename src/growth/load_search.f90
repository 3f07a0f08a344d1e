!> Load factor of crack growth in static equilibrium: the largest ratio of G to toughness of a tip is 1.
!>
!> If all loads are scaled, the root of that ratio r is proportional to the load factor l in a linear body; in others the secant
!> rule finds it. Held loads and eigenstrains add a field, u = u_held + l u_scaled, so that in a linear body r of each tip is a
!> polynomial of second degree in l, from three solutions with one matrix:
!>
!>    r(l) = |K_held + l K_scaled|**2/(E' toughness).
!>
!> At its larger root r rises with l: loads open the crack further. At the smaller root, with less load, held loads press the faces
!> together until they interpenetrate. Each tip has its l at r = 1; the least counts. In nonlinear bodies the last three solutions
!> serve: Muller, Math. Tables Aids Comput. 10 (1956) 208.
module hampm_load_search
   use hampm_kinds, only: dp
   implicit none
   private
   public :: load_search_t, by_secant

   integer, parameter :: kept = 3                !! solutions
   real(dp), parameter :: near = 1e-6_dp         !! of the load factor, at which it is found
   real(dp), parameter :: distinct = 1e-4_dp     !! least relative difference of load factors of distinct solutions
   real(dp), parameter :: farthest = 100         !! largest factor or divisor of the load factor
   real(dp), parameter, public :: nothing = 1e-20_dp !! ratio that is zero up to rounding, as of a closed crack

   !> The solutions so far.
   type :: load_search_t
      logical :: is_proportional = .true.        !! whether all that drives the body is scaled
      integer, private :: n = 0                  !! solutions that are kept
      integer, private :: attempts = 0           !! all of them
      real(dp), private :: load(kept) = 0        !! load factor, the last one last [-]
      real(dp), allocatable, private :: ratio(:, :) !! r of each tip that grows, (tips, kept) [-]
   contains
      procedure :: note
      procedure :: choose
   end type load_search_t

contains

   !> Note a solution.
   pure subroutine note(self, load, ratio)
      class(load_search_t), intent(inout) :: self
      real(dp), intent(in) :: load               !! [-]
      real(dp), intent(in) :: ratio(:)           !! of each tip that grows [-]
      integer :: old
      if (.not. allocated(self%ratio)) allocate (self%ratio(size(ratio), kept), source=0.0_dp)
      self%attempts = self%attempts + 1
      old = 0                                    ! one that the new one replaces
      if (self%n > 0) then
         if (minval(abs(self%load(:self%n) - load)) <= distinct*abs(load)) old = minloc(abs(self%load(:self%n) - load), dim=1)
      end if
      if (old == 0 .and. self%n == kept) old = 1
      if (old == 0) self%n = self%n + 1
      if (old > 0) self%load(old:self%n - 1) = self%load(old + 1:self%n)
      if (old > 0) self%ratio(:, old:self%n - 1) = self%ratio(:, old + 1:self%n)
      self%load(self%n) = load
      self%ratio(:, self%n) = ratio
   end subroutine note

   !> Choose the next load factor. `is_found`: it is the last one.
   pure subroutine choose(self, next, is_found)
      class(load_search_t), intent(in) :: self
      real(dp), intent(out) :: next
      logical, intent(out) :: is_found
      real(dp), parameter :: aside = 1.05_dp, widened = 10
      real(dp) :: largest(kept), changed
      integer :: k
      is_found = .false.
      next = self%load(self%n)
      largest = [(maxval([0.0_dp, self%ratio(:, k)]), k=1, kept)]
      if (self%is_proportional) then
         if (largest(self%n) > nothing) next = self%load(self%n)/sqrt(largest(self%n))
         is_found = self%attempts > 1 .and. abs(next - self%load(self%n)) < near*abs(self%load(self%n))
         if (self%n > 1 .and. .not. is_found) next = by_secant(self%load(self%n - 1:self%n), sqrt(largest(self%n - 1:self%n)))
      else if (self%n < kept) then
         next = aside*self%load(self%n)
         if (self%n == 1) return
         changed = maxval(abs(self%ratio(:, 2) - self%ratio(:, 1)))
         next = by_secant(self%load(:2), sqrt(largest(:2)))
         if (any(abs(self%load(:2) - next) <= 10*distinct*abs(next))) next = aside**2*self%load(2)
         if (changed <= distinct*max(maxval(self%ratio(:, 1)), nothing)) next = widened*self%load(2) ! scaled loads hardly count yet
      else
         next = by_parabolas(self)
         is_found = abs(next - self%load(self%n)) < near*abs(self%load(self%n))
      end if
   end subroutine choose

   !> The least load factor at which a tip reaches its toughness, by the parabolas through its last ratios.
   pure real(dp) function by_parabolas(self) result(next)
      class(load_search_t), intent(in) :: self
      real(dp) :: way                            ! to there from the last one
      integer :: k
      associate (x => self%load, y => self%ratio)
         way = huge(way)
         do k = 1, size(y, 1)
            way = min(way, way_to_one(x(:2) - x(3), y(k, :) - 1))
         end do
         next = x(3) + way
         next = max(x(3)/farthest, min(farthest*x(3), next))
      end associate
   end function by_parabolas

   !> From 0 to the larger root of the parabola through some points; to where it is least where it has none.
   pure real(dp) function way_to_one(x, y) result(way)
      real(dp), intent(in) :: x(2)               !! of the first two; the third is at 0
      real(dp), intent(in) :: y(3)
      real(dp) :: slopes(2), slope, curvature, root
      slopes = (y(:2) - y(3))/x
      curvature = (slopes(1) - slopes(2))/(x(1) - x(2))
      slope = slopes(2) - curvature*x(2)
      way = huge(way)
      if (.not. curvature > 0) then              ! zero up to rounding in a linear body
         if (slope > 0) way = -y(3)/slope
         return
      end if
      root = sqrt(max(0.0_dp, slope**2 - 4*curvature*y(3)))
      way = (root - slope)/(2*curvature)
      if (slope > 0 .and. root > 0) way = -2*y(3)/(root + slope)
   end function way_to_one

   !> The load factor at which the root of the ratio is 1, by the secant through two: by
   !> no more than threefold and no less than a third, and never less of a load that does not suffice, where it closes a tip.
   pure real(dp) function by_secant(load, root) result(next)
      real(dp), intent(in) :: load(2)            !! the last one last [-]
      real(dp), intent(in) :: root(2)            !! of the ratios [-]
      real(dp), parameter :: most = 3
      real(dp) :: rise, change
      next = load(2)
      if (root(2) > sqrt(nothing)) next = load(2)/root(2)
      rise = root(2) - root(1)
      if (abs(rise) < epsilon(rise)) return
      change = (1 - root(2))*(1 - load(1)/load(2))/rise ! of the load, in parts of it
      if (root(2) > 1 .or. change > 0) next = load(2)*max(1/most, min(most, 1 + change))
   end function by_secant
end module hampm_load_search
