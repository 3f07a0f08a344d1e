!> The group &body: the values of its keys in a model.
module hampm_body_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_body_shape, only: rectangle_ring
   use hampm_group_values, only: body_keys_t, take_body
   use hampm_outline, only: ring_t, polygon_ring, circle_ring, cylinder_ring
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: body_t, profile_t, hole_t, fill_bodies, fill_holes

   !> How the material of a graded body changes.
   type :: profile_t
      real(dp) :: direction(ndim) = 0            !! of any length
      real(dp), allocatable :: at(:)             !! places along it from the origin on [m]; none if not graded
      real(dp), allocatable :: stiffness(:), density(:), eigenstrain(:) !! factors there [-]
   end type profile_t

   !> &body: a piece of material.
   type, extends(body_keys_t) :: body_t
      integer :: material_index = 0              !! position of its material in `model_t%materials`
      real(dp) :: eigenstrain(4) = 0             !! components xx, yy, xy and zz of the strain without stress [-]
      type(profile_t) :: profile                 !! of a graded body
   end type body_t

   !> &body with hole = .true.
   type :: hole_t
      integer :: number = 0                      !! of the group, among all &body
      integer :: body = 0                        !! in which it is, 0 for none
      character(name_len) :: shape = ''          !! as the shape of a body
      type(ring_t) :: ring
   end type hole_t

contains

   !> Take all groups of this name that are no holes.
   pure subroutine fill_bodies(settings, bodies)
      type(settings_t), intent(in) :: settings
      type(body_t), allocatable, intent(out) :: bodies(:)
      integer :: i, n
      allocate (bodies(count([(.not. is_hole(settings, i), i=1, settings%count_of('body'))])))
      n = 0
      do i = 1, settings%count_of('body')
         if (is_hole(settings, i)) cycle
         n = n + 1
         call fill_body(settings, settings%find('body', i), bodies(n))
      end do
   end subroutine fill_bodies

   !> Take all groups of holes, and register them in their bodies.
   pure subroutine fill_holes(settings, bodies, holes)
      type(settings_t), intent(in) :: settings
      type(body_t), intent(inout) :: bodies(:)
      type(hole_t), allocatable, intent(out) :: holes(:)
      integer :: i, k, n
      allocate (holes(count([(is_hole(settings, i), i=1, settings%count_of('body'))])))
      n = 0
      do i = 1, settings%count_of('body')
         if (.not. is_hole(settings, i)) cycle
         n = n + 1
         holes(n)%number = i
         holes(n)%shape = settings%text(settings%find('body', i), 'shape')
         call take_ring(settings, settings%find('body', i), holes(n)%ring)
         if (.not. is_ring(holes(n)%ring)) cycle
         do k = 1, size(bodies)
            if (bodies(k)%surrounds(holes(n)%ring)) holes(n)%body = k
         end do
         if (holes(n)%body > 0) call bodies(holes(n)%body)%add_hole(holes(n)%ring)
      end do
   end subroutine fill_holes

   !> Whether the i-th group is a hole.
   pure logical function is_hole(settings, i)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: i
      integer :: entry
      entry = settings%find('body', i)
      is_hole = settings%flag(entry, 'hole')
   end function is_hole

   !> Whether a ring has an inside.
   pure logical function is_ring(ring)
      type(ring_t), intent(in) :: ring
      is_ring = ring%is_circle .and. ring%radius > 0
      if (ring%axis > 0) is_ring = is_ring .and. ring%ends(2) > ring%ends(1)
      if (allocated(ring%points)) is_ring = size(ring%points, 2) > 4 - ndim
   end function is_ring

   !> The ring that a group describes; one without an inside where keys are missing or wrong.
   pure subroutine take_ring(settings, entry, ring)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of the group
      type(ring_t), intent(out) :: ring
      real(dp), allocatable :: numbers(:), upper(:)
      select case (settings%text(entry, 'shape'))
       case ('rectangle', 'cylinder')
         numbers = settings%numbers(entry, 'lower')
         upper = settings%numbers(entry, 'upper')
         if (size(numbers) /= ndim .or. size(upper) /= ndim) return
         ring = rectangle_ring(numbers, upper)
         if (settings%text(entry, 'shape') == 'cylinder') ring = cylinder_ring(numbers, upper, settings%number(entry, 'radius'))
       case ('polygon')
         numbers = settings%numbers(entry, 'points')
         if (size(numbers) >= 3*ndim) ring = polygon_ring(reshape(numbers, [ndim, size(numbers)/ndim]))
       case ('circle', 'sphere')
         numbers = settings%numbers(entry, 'center')
         if (size(numbers) == ndim) ring = circle_ring(numbers, settings%number(entry, 'radius'))
      end select
   end subroutine take_ring

   !> Take the values of the keys of one; 0, '' or empty where they are wrong.
   pure subroutine fill_body(settings, entry, body)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(body_t), intent(inout) :: body
      type(ring_t) :: ring
      call take_body(settings, entry, body)
      if (body%shape == 'rectangle') then
         if (size(settings%numbers(entry, 'lower')) == ndim) body%lower = settings%vector(entry, 'lower')
         if (size(settings%numbers(entry, 'upper')) == ndim) body%upper = settings%vector(entry, 'upper')
      else
         call take_ring(settings, entry, ring)
         if (is_ring(ring)) then
            body%lower = ring%lower()
            body%upper = ring%upper()
            allocate (body%outline%rings(1))
            body%outline%rings(1) = ring
         end if
      end if
      body%profile%direction = settings%vector(entry, 'profile_direction')
      body%profile%at = settings%numbers(entry, 'profile_at')
      body%profile%stiffness = factors(settings%numbers(entry, 'profile_stiffness'))
      body%profile%density = factors(settings%numbers(entry, 'profile_density'))
      body%profile%eigenstrain = factors(settings%numbers(entry, 'profile_eigenstrain'))
      associate (numbers => settings%numbers(entry, 'eigenstrain'))
         body%eigenstrain(:size(numbers)) = numbers
      end associate

   contains

      !> The values of a key, 1 where it is not given, or not for each place, which is refused elsewhere.
      pure function factors(given)
         real(dp), intent(in) :: given(:)
         real(dp), allocatable :: factors(:)
         factors = given
         if (size(given) /= size(body%profile%at)) factors = spread(1.0_dp, 1, size(body%profile%at))
      end function factors
   end subroutine fill_body
end module hampm_body_group
