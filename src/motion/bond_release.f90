!> How the bonds ahead of a tip that grows in motion (`hampm_face_springs`) let go, and what this takes.
!>
!> A node that were let go at once would ring. A bond that the tip has come to keeps the force that it has then, and this falls
!>
!>    given speed    linearly with the way of the tip, to 0 where that is two cells further;
!>    toughness      with the opening u since, by -du f/(2 (G A - U)), with f the force and U the energy that the bond had when it let go, A its
!>                   area and G the toughness at the speed of the tip: so what a bond takes meanwhile is G times the area for which it has.
!>
!> The work of these forces is what the new faces take: the fracture term of the energy balance. In a step it is that of the force that acts in it, on the way of the mean of the velocities
!> before and after.
module hampm_bond_release
   use hampm_kinds, only: dp, ndim
   use hampm_face_springs, only: face_springs_t, bond, force_of, energy_of
   use hampm_spring_placement, only: release_length
   implicit none
   private
   public :: let_go_behind, let_go_beyond, way_at, soften_released, work_of_release, foremost_released

contains

   !> Let the bonds go that a tip has passed; the force of those that have fades with its way and, once it has come to rest, goes on doing so.
   !> `taken` is the energy that they had stored.
   pure subroutine let_go_behind(springs, tip, way, further, taken)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: way                !! that it has moved so far [m]
      real(dp), intent(in) :: further            !! by which forces fade beyond that [m]
      real(dp), intent(out) :: taken             !! [J]
      integer :: k
      taken = 0
      do k = 1, springs%n
         if (springs%tip(k) /= tip .or. springs%way(k) > way) cycle
         if (.not. springs%lets_go(k)) call let_go(springs, k, taken)
         springs%kept(k) = min(springs%kept(k), max(0.0_dp, 1 - (way + further - springs%way(k)) &
                                                                /(release_length*springs%cell(k))))
      end do
   end subroutine let_go_behind

   !> Let the bonds of a tip go whose traction is beyond a strength, up to a way of the tip. `taken` is the energy that they had stored. Beyond
   !> that way bonds hold: the tip has to come near first. `overload` is the largest traction over the strength of those.
   pure subroutine let_go_beyond(springs, tip, strength, last, taken, overload)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: strength           !! times the root of the size of the cell [Pa sqrt(m)]
      real(dp), intent(in) :: last               !! way up to which bonds let go [m]
      real(dp), intent(out) :: taken             !! [J]
      real(dp), intent(out) :: overload          !! [-]
      real(dp) :: force(ndim), across, traction
      integer :: k
      taken = 0
      overload = 0
      do k = 1, springs%n
         if (springs%tip(k) /= tip .or. springs%lets_go(k)) cycle
         force = force_of(springs, k)
         across = dot_product(force, springs%normal(:, k))
         force = force - min(across, 0.0_dp)*springs%normal(:, k)
         traction = norm2(force)/(springs%thickness%at(springs%place(:, k))*springs%length(k)*strength/sqrt(springs%cell(k)))
         if (springs%way(k) > last) then
            overload = max(overload, traction)
         else if (traction > 1) then
            call let_go(springs, k, taken)
         end if
      end do
   end subroutine let_go_beyond

   !> Let a bond go.
   pure subroutine let_go(springs, k, taken)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: k
      real(dp), intent(inout) :: taken           !! [J]
      real(dp) :: force(ndim)
      force = force_of(springs, k)
      springs%stored(k) = energy_of(springs, k)
      taken = taken + springs%stored(k)
      springs%held(:, k) = force
      springs%start(:, k) = springs%opening(:, k)
      springs%reached(k) = 0
      springs%lets_go(k) = .true.
   end subroutine let_go

   !> Length of crack for which the bonds of a tip that have let go would take a toughness now, by how they have opened since the step before [m]:
   !> a bond that keeps a part of its force has taken 1 less the square of this part.
   pure real(dp) function way_at(springs, tip, toughness) result(way)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: toughness          !! [J/m2]
      integer :: k
      way = 0
      do k = 1, springs%n
         if (springs%tip(k) /= tip .or. .not. springs%lets_go(k)) cycle
         way = way + springs%length(k)*(springs%kept(k)**2 - kept_at(springs, k, toughness)**2)
      end do
   end function way_at

   !> Part of its force that a bond keeps now.
   pure real(dp) function kept_at(springs, k, toughness) result(kept)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp), intent(in) :: toughness          !! [J/m2]
      real(dp) :: further, all
      kept = springs%kept(k)
      if (.not. kept > 0) return
      associate (held => norm2(springs%held(:, k)))
         all = 2*(toughness*springs%thickness%at(springs%place(:, k))*springs%length(k) - springs%stored(k))
         if (.not. (held > 0 .and. all > 0)) then
            kept = 0
            return
         end if
         further = opening_along(springs, k) - springs%reached(k)
         if (further > 0) kept = max(0.0_dp, kept - held*further/all)
      end associate
   end function kept_at

   !> How far a bond has opened along its force since it has let go [m].
   pure real(dp) function opening_along(springs, k) result(opening)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      opening = dot_product(springs%opening(:, k) - springs%start(:, k), springs%held(:, k))/norm2(springs%held(:, k))
   end function opening_along

   !> Let the forces of bonds that have let go follow their openings, at a toughness. `has_parted` tells whether any
   !> has lost all of its force.
   pure subroutine soften_released(springs, tip, toughness, has_parted)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: toughness          !! [J/m2]
      logical, intent(out) :: has_parted
      integer :: k
      has_parted = .false.
      do k = 1, springs%n
         if (springs%tip(k) /= tip .or. .not. springs%lets_go(k)) cycle
         springs%kept(k) = kept_at(springs, k, toughness)
         if (norm2(springs%held(:, k)) > 0) springs%reached(k) = max(springs%reached(k), opening_along(springs, k))
         has_parted = has_parted .or. .not. springs%kept(k) > 0
      end do
   end subroutine soften_released

   !> What the forces of bonds that have let go take in a step [J].
   pure real(dp) function work_of_release(springs, before, after, dt) result(work)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: before(:, :), after(:, :) !! velocities of the nodes that the forces of the step have changed [m/s],
                                                 !! (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      real(dp) :: way(ndim)
      integer :: k, j
      work = 0
      do k = 1, springs%n
         if (.not. springs%lets_go(k) .or. .not. springs%kept(k) > 0) cycle
         way = 0
         do j = 1, size(springs%node, 1)
            associate (node => springs%node(j, k))
               if (node > 0) way = way + dt*springs%share(j, k)*(before(:, node) + after(:, node))/2
            end associate
         end do
         work = work + dot_product(force_of(springs, k), way)
      end do
   end function work_of_release

   !> Way of a tip to the foremost bond that has let go [m]; 0 where none has.
   pure real(dp) function foremost_released(springs, tip) result(way)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: tip                 !! its number
      integer :: k
      way = 0
      do k = 1, springs%n
         if (springs%tip(k) == tip .and. springs%lets_go(k)) way = max(way, springs%way(k) + springs%length(k)/2)
      end do
   end function foremost_released
end module hampm_bond_release
