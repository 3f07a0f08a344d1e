!> The groups &crack, &growth and &energy_release: the values of their keys in a model.
module hampm_crack_groups
   use hampm_kinds, only: dp, ndim, plane, name_len
   use hampm_estimator, only: estimator_t
   use hampm_estimators, only: estimators
   use hampm_front, only: plane_axes
   use hampm_growth_laws, only: growth_law_t, growth_laws
   use hampm_group_values, only: crack_keys_t, energy_release_keys_t, growth_keys_t, take_crack, take_energy_release, take_growth
   use hampm_law, only: value_of
   use hampm_settings, only: settings_t
   use hampm_toughness, only: advance_t, factors_t, table_t
   implicit none
   private
   public :: crack_spec_t, fill_cracks, growth_t, fill_growth, energy_release_t, fill_energy_release

   !> &crack: in the plane a polyline, which those of other kinds become; of solids a part of a plane of the grid.
   type, extends(crack_keys_t) :: crack_spec_t
      character(name_len) :: key = 'points'      !! key of its place
      logical :: contact = .false.           !! whether its faces press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: held_from = 0                  !! distance along its points at which cohesion begins to hold its faces,
                                                 !! the initial tip; 0: no cohesion, or along its whole length [m]
      logical :: at_nodes = .false.              !! whether it runs along grid lines, with its tips at nodes, and stays there
   end type crack_spec_t

   !> &growth: how a crack grows.
   type, extends(growth_keys_t) :: growth_t
      integer :: path = 0                        !! number of the path, or 1 of a crack on a symmetry plane; 0: there is no such one
      type(growth_law_t) :: law                  !! without a name if its name is unknown
      type(factors_t) :: factors                 !! of its toughness
      real(dp), allocatable :: points(:, :)      !! of 'path' [m], (ndim, any)
      real(dp) :: end = huge(1.0_dp)             !! until when [s]
      logical :: only_largest = .false.          !! whether only the tip with the largest G advances
      logical :: of_end(2) = .true.              !! whether the tip at the first and that at the last point do
   contains
      procedure :: toughness_at
      procedure :: speed_at
      procedure :: rate_at
      procedure :: largest_part
      procedure :: yield_stress
      procedure :: turns
   end type growth_t

   !> &energy_release: recorded energy quantities.
   type, extends(energy_release_keys_t) :: energy_release_t
      type(estimator_t), allocatable :: chosen(:) !! estimators of G and K, the best one first
   end type energy_release_t

contains

   !> Take all groups of this name. Wrong or missing values are 0 or empty; an odd number of coordinates leaves the last one out.
   !> Straight cracks of the plane have only their tip until their length is known.
   pure subroutine fill_cracks(settings, cracks)
      type(settings_t), intent(in) :: settings
      type(crack_spec_t), allocatable, intent(out) :: cracks(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, i, entry, along(2)
      allocate (cracks(settings%count_of('crack')))
      do k = 1, size(cracks)
         associate (crack => cracks(k))
            entry = settings%find('crack', k)
            call take_crack(settings, entry, crack)
            crack%is_symmetry = crack%kind == 'symmetry'
            crack%contact = settings%text(entry, 'contact') /= 'none'
            if (settings%text(entry, 'contact') == 'friction') crack%friction = settings%number(entry, 'friction')
            crack%front = settings%text(entry, 'front')
            crack%axis = max(1, index('xyz', trim(settings%text(entry, 'normal'))))
            crack%direction = settings%vector(entry, 'direction')
            crack%length = settings%number(entry, 'length')
            crack%key = 'points'
            if (crack%kind /= 'path' .and. crack%front == 'straight') crack%key = 'tip'
            if (any(crack%front == ['disc   ', 'ellipse'])) crack%key = 'center'
            numbers = settings%numbers(entry, trim(crack%key))
            if (size(numbers) >= ndim) crack%center = numbers(:ndim)
            crack%points = reshape(numbers, [ndim, size(numbers)/ndim])
            crack%radii = settings%numbers(entry, 'radii')
            if (ndim == plane .and. crack%front == 'disc') then
               crack%direction = [(merge(0, 1, i == crack%axis), i=1, ndim)]
               if (size(crack%radii) == 1 .and. size(numbers) == ndim) &
                  crack%points = reshape([crack%center - crack%radii(1)*crack%direction, &
                                          crack%center + crack%radii(1)*crack%direction], [ndim, 2])
            end if
            along = plane_axes(crack%axis)
            if (size(crack%radii) == 2 .and. along(1) > along(2)) crack%radii = crack%radii([2, 1]) ! in cyclic order
         end associate
      end do
   end subroutine fill_cracks

   !> Whether the crack turns by itself, as its modes have it.
   pure logical function turns(self)
      class(growth_t), intent(in) :: self
      turns = self%direction /= 'straight' .and. self%direction /= 'path'
   end function turns

   !> Toughness at a tip [J/m2]: of the law, with the body's toughness in place of the group's, times all factors. On a seam the
   !> least tough body counts.
   pure real(dp) function toughness_at(self, advance)
      class(growth_t), intent(in) :: self
      type(advance_t), intent(in) :: advance
      toughness_at = 0
      if (.not. associated(self%law%toughness)) return
      toughness_at = self%law%toughness(self%constants, advance%speed, advance%length)*self%factors%product_at(advance)
      if (.not. advance%of_body > 0) return
      associate (part => advance%of_body/value_of(self%constants, 'toughness', 0.0_dp))
         toughness_at = toughness_at*merge(min(part, 1.0_dp), part, advance%or_of_growth)
      end associate
   end function toughness_at

   !> Prescribed speed at a time [m/s].
   pure real(dp) function speed_at(self, time)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      speed_at = 0
      if (self%law%gives_speed()) speed_at = self%law%speed(self%constants, time)
   end function speed_at

   !> Way in a load cycle [m], or in a second [m/s]: by the toughness the least speed at which that is G.
   pure real(dp) function rate_at(self, range, ratio, part)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: range              !! of K, in time K [Pa sqrt(m)]
      real(dp), intent(in) :: ratio              !! least over largest K [-]
      real(dp), intent(in) :: part               !! largest K over K_c [-]
      real(dp) :: high
      integer :: i
      rate_at = 0
      if (.not. self%law%has_rate()) return
      if (.not. self%factors%of_speed%is_there()) then
         rate_at = self%law%rate(self%constants, trim(self%rate), range, ratio, part)
      else if (part > 1) then
         high = value_of(self%constants, 'limit_speed', 0.0_dp)
         if (.not. high > 0) high = self%factors%of_speed%x(size(self%factors%of_speed%x))
         do i = 1, digits(high)
            associate (middle => (rate_at + high)/2)
               if (times_at_rest(self, middle) < part**2) then
                  rate_at = middle
               else
                  high = middle
               end if
            end associate
         end do
      end if
   end function rate_at

   !> Largest K over K_c at which a tip grows by a rate: where it reaches that it breaks [-].
   pure real(dp) function largest_part(self)
      class(growth_t), intent(in) :: self
      largest_part = 1
      if (.not. (self%law%is_in_time .and. self%rate == 'toughness')) return
      largest_part = huge(largest_part)
      if (value_of(self%constants, 'limit_speed', 0.0_dp) > 0) return
      associate (speeds => self%factors%of_speed%x)
         largest_part = sqrt(times_at_rest(self, speeds(size(speeds))))
      end associate
   end function largest_part

   !> Toughness at a speed over that at rest [-].
   pure real(dp) function times_at_rest(self, speed) result(times)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: speed              !! [m/s]
      times = self%law%toughness(self%constants, speed, 0.0_dp)*self%factors%of_speed%at(speed) &
              /(self%law%toughness(self%constants, 0.0_dp, 0.0_dp)*self%factors%of_speed%at(0.0_dp))
   end function times_at_rest

   !> Yield stress for the zones of overloads; 0 where they do not count [Pa].
   pure real(dp) function yield_stress(self)
      class(growth_t), intent(in) :: self
      yield_stress = value_of(self%constants, 'wheeler_stress', 0.0_dp)
   end function yield_stress

   !> Take all groups of this name.
   pure subroutine fill_growth(settings, growth)
      type(settings_t), intent(in) :: settings
      type(growth_t), allocatable, intent(out) :: growth(:)
      type(growth_law_t), allocatable :: laws(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, i, entry
      allocate (laws, source=growth_laws())
      allocate (growth(settings%count_of('growth')))
      do k = 1, size(growth)
         entry = settings%find('growth', k)
         call take_growth(settings, entry, growth(k))
         i = findloc(laws%name == settings%text(entry, 'law'), .true., dim=1)
         if (i > 0) growth(k)%law = laws(i)
         call fill_factors(settings, entry, growth(k)%factors)
         numbers = settings%numbers(entry, 'points')
         growth(k)%points = reshape(numbers, [ndim, size(numbers)/ndim])
         if (settings%number(entry, 'end') > 0) growth(k)%end = settings%number(entry, 'end')
         growth(k)%only_largest = settings%text(entry, 'tips') == 'largest'
         growth(k)%of_end = [settings%text(entry, 'tips') /= 'last', settings%text(entry, 'tips') /= 'first']
      end do
   end subroutine fill_growth

   !> Take the factors of a toughness. Where a mix of modes has no effect it is left out.
   pure subroutine fill_factors(settings, entry, factors)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(factors_t), intent(out) :: factors
      factors%of_extension = table_t(settings%numbers(entry, 'extensions'), settings%numbers(entry, 'extension_factors'))
      factors%of_speed = table_t(settings%numbers(entry, 'speeds'), settings%numbers(entry, 'speed_factors'))
      factors%of_angle = table_t(settings%numbers(entry, 'angles'), settings%numbers(entry, 'angle_factors'))
      factors%mixed_mode = settings%text(entry, 'mixed_mode')
      factors%lambda = settings%number(entry, 'lambda')
      factors%exponent = settings%number(entry, 'mixed_mode_exponent')
      associate (of_opening => settings%number(entry, 'toughness'))
         if (of_opening > 0) factors%of_shear = settings%number(entry, 'toughness_shear')/of_opening
      end associate
   end subroutine fill_factors

   !> Take the values of the keys; 0, '' or empty where they are absent or wrong.
   pure subroutine fill_energy_release(settings, energy_release)
      type(settings_t), intent(in) :: settings
      type(energy_release_t), intent(inout) :: energy_release
      integer :: entry, k
      entry = settings%find('energy_release', 1)
      associate (rows => estimators())
         energy_release%chosen = pack(rows, [(settings%texts(entry, 'estimators', trim(rows(k)%name)), k=1, size(rows))])
      end associate
      call take_energy_release(settings, entry, energy_release)
   end subroutine fill_energy_release
end module hampm_crack_groups
