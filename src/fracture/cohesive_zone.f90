!> Cohesive zones of cracks: the cut part held by cohesion, between the mathematical tip, the end of the cut, and the physical tip,
!> up to which damage is 1. The tip of the crack is the physical one.
module hampm_cohesive_zone
   use hampm_kinds, only: dp
   use hampm_cracks, only: cracks_t, last_point
   use hampm_interface_points, only: interfaces_t, cohesive, is_half
   use hampm_problem, only: problem_t
   use hampm_text, only: add_line, to_text
   implicit none
   private
   public :: follow_zones, zone_length, root_opening, check_zones

contains

   !> Advance the tips of cracks with cohesion ahead to the end of its failed part. A last bit of the cut stays ahead of them.
   pure subroutine follow_zones(cracks, m)
      type(cracks_t), intent(inout) :: cracks
      type(problem_t), intent(inout) :: m
      real(dp), parameter :: last_bit = 1e-3_dp  ! cells of the lattice of roots
      real(dp) :: parted, left, way
      integer :: k
      logical :: have_moved
      have_moved = .false.
      do k = 1, size(cracks%tips)
         if (.not. cracks%tips(k)%has_zone) cycle
         associate (tip => cracks%tips(k), all => m%interfaces%list(:m%interfaces%n))
            parted = minval(all%way, mask=all%law == cohesive .and. all%line == tip%crack .and. all%damage < 1)
            left = cracks%crack(tip%crack)%bonded(last_point) - last_bit*m%grid%forest%cell
            way = min(parted - tip%grown, left)
            if (.not. way > 0) cycle
            call cracks%move_tip(k, way, m%grid%cut_cells%lines)
            have_moved = .true.
         end associate
      end do
      if (have_moved) m%grid%cut_cells%lines = cracks%lines()
   end subroutine follow_zones

   !> Length of the part of a crack whose faces are damaged and hold each other still [m].
   pure real(dp) function zone_length(interfaces, line) result(length)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: line                !! number of the crack
      associate (all => interfaces%list(:interfaces%n))
         length = sum(all%length, mask=all%law == cohesive .and. all%line == line .and. all%damage > 0 .and. all%damage < 1)
      end associate
   end function zone_length

   !> Opening of the faces of a crack where its cohesion begins, along the normal: a line through the first two points of that [m].
   pure real(dp) function root_opening(interfaces, line) result(opening)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: line                !! number of the crack
      real(dp) :: gap(2), half(2), behind
      integer :: k, next
      gap = 0
      half = 1
      behind = -huge(behind)
      associate (all => interfaces%list(:interfaces%n))
         do k = 1, 2
            next = minloc(all%way, dim=1, mask=all%law == cohesive .and. all%line == line .and. all%way > behind)
            if (next == 0) exit
            gap(k:) = dot_product(all(next)%opening, all(next)%normal)*merge(2, 1, is_half(all(next)))
            half(k:) = 0.5_dp*all(next)%length
            behind = all(next)%way
         end do
      end associate
      opening = gap(1) + (gap(1) - gap(2))*half(1)/sum(half)
   end function root_opening

   !> Warn once if a zone is longer than the smallest disc around its tip: J leaves out the dissipation beyond.
   pure subroutine check_zones(cracks, interfaces, message)
      type(cracks_t), intent(in) :: cracks
      type(interfaces_t), intent(in) :: interfaces
      character(:), allocatable, intent(inout) :: message
      character(*), parameter :: what = 'J leaves out the dissipation of its cohesive zone outside of an integration domain'
      integer :: k
      do k = 1, size(cracks%tips)
         associate (tip => cracks%tips(k))
            if (.not. tip%has_zone .or. size(tip%radii) == 0) cycle
            if (zone_length(interfaces, tip%crack) <= minval(tip%radii)) cycle
            if (index(message, what) > 0) return
            call add_line(message, 'tip '//to_text(k)//': '//what//': the zone has become longer than the smallest radius, '// &
                          to_text(minval(tip%radii))//' m; use larger &energy_release radii, or take J from the loads')
         end associate
      end do
   end subroutine check_zones
end module hampm_cohesive_zone
