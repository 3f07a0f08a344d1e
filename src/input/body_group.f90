!> The group &body: its row in the table of groups, its keys, and their values in a model.
module hampm_body_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_body_shape, only: body_shape_t, rectangle_ring
   use hampm_key_rows, only: zeros, along_x, near_side, far_side, group_t, key_t, type_real, type_integer, type_name, &
                             type_text, repeats, &
                             is_required, any_number, not_negative, positive, type_logical, max_values
   use hampm_outline, only: ring_t, polygon_ring, circle_ring, cylinder_ring
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: body_group, body_keys, body_t, profile_t, hole_t, fill_bodies, fill_holes

   type(group_t), parameter :: body_group = group_t('body', repeats, is_required, &
      'a piece of material, or a hole in one; bodies must not overlap')

   integer, parameter :: n_spins = merge(1, 3, ndim == 2) !! components of an angular velocity
   character(*), parameter :: no_spin = '0.0'//repeat(', 0.0', n_spins - 1)

   type(key_t), parameter :: body_keys(*) = [ &
      key_t('material', type_text, 'name of its material; none of a hole', example='aluminium'), &
      key_t('shape', type_name, 'a rectangle along the grid lines, a polygon or a circle; a solid is a box, cylinder or sphere', &
            default='rectangle', allowed='rectangle|polygon|circle|cylinder|sphere'), &
      key_t('lower', type_real, 'lower corner of a rectangle or box; lower end of the axis of a cylinder', unit='m', &
            example='0.0, 0.0'//near_side, allowed=any_number, fewest=0, most=ndim), &
      key_t('upper', type_real, 'upper corner of a rectangle or box; upper end of the axis of a cylinder', unit='m', &
            example='0.1, 0.01'//far_side, allowed=any_number, fewest=0, most=ndim), &
      key_t('points', type_real, 'corners of a polygon: x1, y1, x2, y2, ..., as one walks around it', unit='m', &
            allowed=any_number, fewest=0, most=max_values), &
      key_t('center', type_real, 'center of a circle or sphere', unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('radius', type_real, 'radius of a circle, cylinder or sphere', default='0.0', unit='m', allowed=not_negative), &
      key_t('hole', type_logical, 'whether it is a hole, in the body that it lies in; holes come after all bodies', &
            default='.false.'), &
      key_t('points_per_cell', type_integer, 'material points per root cell in each direction; even where cells may refine', &
            default='2', allowed='[1, 16]'), &
      key_t('velocity', type_real, 'initial velocity of its middle', default=zeros, unit='m/s', allowed=any_number, &
            fewest=ndim, most=ndim), &
      key_t('spin', type_real, 'initial angular velocity around its middle, anticlockwise; of a solid around x, y and z', &
            default=no_spin, unit='rad/s', allowed=any_number, fewest=n_spins, most=n_spins), &
      key_t('eigenstrain', type_real, 'strain xx, yy, xy and zz (0) at which there is no stress; heat: alpha dT in xx, yy and zz', &
            default='0.0, 0.0, 0.0', allowed='[-0.05, 0.05]', fewest=3, most=4), &
      key_t('held', type_logical, 'whether its eigenstrain stays where growth at rest scales loads, instead of being scaled too', &
            default='.true.'), &
      key_t('toughness', type_real, 'energy release rate at which a crack grows in it, in place of that of &growth; 0: that', &
            default='0.0', unit='J/m2', allowed=not_negative), &
      key_t('profile_direction', type_real, 'of a graded body: the direction in which its material changes', &
            default=along_x, allowed=any_number, fewest=ndim, most=ndim), &
      key_t('profile_at', type_real, 'of a graded body: places along that, from the origin of coordinates on, increasing', &
            unit='m', allowed=any_number, fewest=0, most=max_values), &
      key_t('profile_stiffness', type_real, 'factors of all moduli and strengths at these; exponential between', &
            allowed=positive, fewest=0, most=max_values), &
      key_t('profile_density', type_real, 'factors of the density at these; exponential between', allowed=positive, &
            fewest=0, most=max_values), &
      key_t('profile_eigenstrain', type_real, 'factors of the eigenstrain at these; linear between', allowed=any_number, &
            fewest=0, most=max_values), &
      key_t('contact_group', type_text, 'with &contact: bodies of the same part are one; without a name a body is one by itself')]

   !> How the material of a graded body changes.
   type :: profile_t
      real(dp) :: direction(ndim) = 0            !! of any length
      real(dp), allocatable :: at(:)             !! places along it from the origin on [m]; none of a body that is not graded
      real(dp), allocatable :: stiffness(:), density(:), eigenstrain(:) !! factors there [-]
   end type profile_t

   !> &body: a piece of material.
   type, extends(body_shape_t) :: body_t
      character(name_len) :: material = ''       !! name of its material
      integer :: material_index = 0              !! position of that material in `model_t%materials`
      character(name_len) :: shape = ''          !! 'rectangle', 'polygon', 'circle', 'cylinder' or 'sphere'
      integer :: points_per_cell = 0             !! material points per cell and direction
      real(dp) :: velocity(ndim) = 0             !! initial velocity of its middle [m/s]
      real(dp) :: spin(n_spins) = 0              !! initial angular velocity around that [rad/s]
      real(dp) :: toughness = 0                  !! of a crack in it; 0: that of &growth [J/m2]
      character(name_len) :: contact_group = ''  !! those of the same group are one, and do not slide on each other
      real(dp) :: eigenstrain(4) = 0             !! components xx, yy, xy and zz of the strain without stress [-]
      logical :: held = .true.                   !! whether growth at rest does not scale it
      type(profile_t) :: profile                 !! of a graded body
   end type body_t

   !> &body with hole = .true.
   type :: hole_t
      integer :: number = 0                      !! of the group, among all &body
      integer :: body = 0                        !! in which it is, 0 for none
      character(name_len) :: shape = ''          !! as that of a body
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

   !> Take all that are holes, and let the bodies in which they are know of them.
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
      body%material = settings%text(entry, 'material')
      body%shape = settings%text(entry, 'shape')
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
      body%points_per_cell = nint(settings%number(entry, 'points_per_cell'))
      body%velocity = settings%vector(entry, 'velocity')
      associate (numbers => settings%numbers(entry, 'spin'))
         if (size(numbers) == n_spins) body%spin = numbers
      end associate
      body%toughness = settings%number(entry, 'toughness')
      body%contact_group = settings%text(entry, 'contact_group')
      body%held = settings%flag(entry, 'held')
      body%profile%direction = settings%vector(entry, 'profile_direction')
      body%profile%at = settings%numbers(entry, 'profile_at')
      body%profile%stiffness = factors(settings%numbers(entry, 'profile_stiffness'))
      body%profile%density = factors(settings%numbers(entry, 'profile_density'))
      body%profile%eigenstrain = factors(settings%numbers(entry, 'profile_eigenstrain'))
      associate (numbers => settings%numbers(entry, 'eigenstrain'))
         body%eigenstrain(:size(numbers)) = numbers
      end associate

   contains

      !> The values of a key, 1 where it is not given.
      pure function factors(given)
         real(dp), intent(in) :: given(:)
         real(dp), allocatable :: factors(:)
         factors = given
         if (size(given) == 0) factors = spread(1.0_dp, 1, size(body%profile%at))
      end function factors
   end subroutine fill_body
end module hampm_body_group
