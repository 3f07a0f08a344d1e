!> Crack nucleation by the coupled criterion (Leguillon, European Journal of Mechanics A 21 (2002) 61-72): before, the stress across
!> the whole crack is at least the strength; and the change of equilibrium, under the same loads and grips, releases at least its
!> toughness. With its length the first needs more load and the second, at first, less. The crack appears at the least load at which
!> both hold for some length.
!>
!> In a linear body under held and scaled loads stress is linear in the load factor l and energy quadratic.
module hampm_onset
   use hampm_kinds, only: dp
   implicit none
   private
   public :: load_for_stress, parabola_through, load_for_energy, find_least, never

   real(dp), parameter :: never = huge(1.0_dp)   !! load factor where none is enough

contains

   !> Load factor l at which held + l scaled is the strength: 0 if reached without load, `never` if no load opens the place.
   elemental real(dp) function load_for_stress(held, scaled, strength) result(load)
      real(dp), intent(in) :: held, scaled, strength !! [Pa]
      load = never
      if (scaled > 0) load = max(0.0_dp, (strength - held)/scaled)
      if (.not. scaled > 0 .and. held >= strength .and. held > 0) load = 0
   end function load_for_stress

   !> Coefficients of 1, l and l**2 from values at three load factors; one value suffices for a term proportional to l**2.
   pure function parabola_through(load, value) result(c)
      real(dp), intent(in) :: load(:), value(:)  !! (1 or 3)
      real(dp) :: c(0:2)
      real(dp) :: slopes(2)
      c = 0
      if (size(load) == 1) then
         c(2) = value(1)/load(1)**2
         return
      end if
      slopes = (value(2:3) - value(1:2))/(load(2:3) - load(1:2))
      c(2) = (slopes(2) - slopes(1))/(load(3) - load(1))
      c(1) = slopes(1) - c(2)*(load(1) + load(2))
      c(0) = value(1) - load(1)*(c(1) + c(2)*load(1))
   end function parabola_through

   !> The load factor from which on a parabola rises above a value.
   pure real(dp) function load_for_energy(c, value) result(load)
      real(dp), intent(in) :: c(0:2), value
      real(dp) :: root
      load = never
      root = c(1)**2 - 4*c(2)*(c(0) - value)
      if (c(2) > 0 .and. root >= 0) load = max(0.0_dp, (sqrt(root) - c(1))/(2*c(2)))
   end function load_for_energy

   !> The least load at which both criteria hold, and its length: a tried one or, by log-log interpolation, one between two at which
   !> strength and energy change places. `tried`: number of the tried length at or before it.
   pure subroutine find_least(length, by_stress, by_energy, load, at, tried)
      real(dp), intent(in) :: length(:)          !! ascending [m]
      real(dp), intent(in) :: by_stress(:), by_energy(:) !! load factors
      real(dp), intent(out) :: load, at          !! [-], [m]
      integer, intent(out) :: tried
      real(dp) :: off(2), part
      integer :: k
      tried = minloc(max(by_stress, by_energy), dim=1)
      load = max(by_stress(tried), by_energy(tried))
      at = length(tried)
      do k = 1, size(length) - 1
         if (min(minval(by_stress(k:k + 1)), minval(by_energy(k:k + 1))) <= 0) cycle
         if (max(by_stress(k + 1), by_energy(k)) >= never) cycle
         off = log(by_energy(k:k + 1)/by_stress(k:k + 1))
         if (off(1) <= 0 .or. off(2) >= 0) cycle
         part = off(1)/(off(1) - off(2))
         if (by_energy(k)**(1 - part)*by_energy(k + 1)**part >= load) cycle
         load = by_energy(k)**(1 - part)*by_energy(k + 1)**part
         at = length(k)**(1 - part)*length(k + 1)**part
         tried = k
      end do
   end subroutine find_least
end module hampm_onset
