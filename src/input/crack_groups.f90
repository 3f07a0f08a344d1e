!> The groups &crack, &growth and &energy_release: their rows in the table of groups, their keys, and their values in a model.
module hampm_crack_groups
   use hampm_kinds, only: dp, ndim, plane, name_len
   use hampm_estimator, only: estimator_t
   use hampm_estimators, only: estimators
   use hampm_front, only: crack_shape_t, plane_axes
   use hampm_growth_laws, only: growth_law_t, growth_laws, growth_law_keys
   use hampm_key_rows, only: group_t, key_t, type_logical, type_real, type_name, type_text, repeats, is_optional, any_number, &
                             not_negative, max_values, positive, once, is_assumed, along_x, near_side
   use hampm_law, only: constant_t, value_of
   use hampm_settings, only: settings_t
   use hampm_toughness, only: advance_t, factors_t, table_t, toughness_keys
   implicit none
   private
   public :: crack_group, crack_keys, path_spec_t, fill_paths, plane_spec_t, fill_planes, growth_group, growth_keys, growth_t, &
             fill_growth, energy_release_group, energy_release_keys, energy_release_t, fill_energy_release

   type(group_t), parameter :: crack_group = group_t('crack', repeats, is_optional, &
      'a crack; without this group the model has none. Those of the kinds line and path may be several')

   type(key_t), parameter :: crack_keys(*) = [ &
      key_t('kind', type_name, 'along the constrained edge of a symmetric half, or straight to a tip, or along points; '// &
            'of solids also in a plane inside', default='symmetry', allowed='symmetry|line|path|plane'), &
      key_t('tip', type_real, 'crack tip, at a symmetry plane a node of the lattice; of two tips the one that direction '// &
            'points out of', example='0.05, 0.0'//near_side, unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('direction', type_real, 'from the crack out of its tip; at a symmetry plane along it', default=along_x, &
            allowed=any_number, fewest=ndim, most=ndim), &
      key_t('normal', type_name, 'of solids: axis across the plane of the crack', default='z', allowed='x|y|z', &
            example=merge(' ', 'y', ndim == 2)), &
      key_t('front', type_name, 'of solids: of a half plane, through tip; of a disc, an ellipse or a polygon, which is cracked', &
            default='straight', allowed='straight|disc|ellipse|polygon'), &
      key_t('center', type_real, 'of a disc or an ellipse', unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('radii', type_real, 'one of a disc; two of an ellipse, along the axes of its plane in the order x, y, z', unit='m', &
            allowed=positive, fewest=0, most=2), &
      key_t('length', type_real, 'of a line with two tips: from one to the other; 0: it reaches the edge of the material', &
            default='0.0', unit='m', allowed=not_negative), &
      key_t('contact', type_name, 'of a line, a path or a plane: whether faces press on each other or go through', default='none', &
            allowed='none|frictionless|friction'), &
      key_t('friction', type_real, 'with contact = ''friction'': coefficient', default='0.0', allowed=not_negative), &
      key_t('points', type_real, 'of a path: x1, y1, x2, y2, ..., as one walks along it; ends inside are tips. Of a '// &
            'polygon: corners', unit='m', allowed=any_number, fewest=0, most=max_values), &
      key_t('name', type_text, 'by which other groups mean it')]

   !> &crack.
   type :: path_spec_t
      character(name_len) :: kind = ''           !! 'symmetry', 'line' or 'path'
      character(name_len) :: key = 'points'      !! which tells where it is
      real(dp) :: direction(ndim) = 0            !! of a line, and on a symmetry plane: out of its tip; a unit vector where it is placed
      real(dp) :: length = 0                     !! of a line: between its two tips, 0: it reaches the edge of the material [m]
      character(name_len) :: name = ''           !! '' for none
      logical :: contact = .false.               !! whether its faces press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: held_from = 0                  !! way along its points from which on cohesion holds its faces: there its tip is at first; 0:
                                                 !! none does, or all along it [m]
      logical :: at_nodes = .false.              !! whether it runs along grid lines, with its tips at nodes, and stays there
      real(dp), allocatable :: points(:, :)      !! [m], (ndim, points)
   end type path_spec_t

   !> &crack of solids.
   type, extends(crack_shape_t) :: plane_spec_t
      character(name_len) :: name = ''           !! '' for none
      logical :: contact = .false.               !! whether its faces press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
   end type plane_spec_t

   type(group_t), parameter :: growth_group = group_t('growth', repeats, is_optional, &
      'how a crack grows; without this group cracks stay as they are', is_apart=.true.)

   type(key_t), parameter :: constant_keys(*) = [ &
      key_t('toughness', type_real, &
            'energy release rate at which the crack grows by quasi_static and toughness; by fatigue: at which it breaks', &
            default='0.0', example='100.0', unit='J/m2', allowed=not_negative), &
      key_t('limit_speed', type_real, &
            'of law = toughness, which at speed v is toughness/(1 - (v/limit_speed)**exponent); 0: it is constant', default='0.0', &
            unit='m/s', allowed=not_negative), &
      key_t('exponent', type_real, 'of that', default='1.0', allowed=positive)]

   type(key_t), parameter :: growth_keys(*) = [ &
      key_t('crack', type_text, 'name of the crack; may be left out where there is one crack', example='a'), &
      key_t('law', type_name, &
            'at rest by increments, under loads that are scaled or in load cycles; in motion, at a speed or by the toughness', &
            default='quasi_static', allowed='{growth laws}'), &
      key_t('direction', type_name, 'where tips go to; path: along points', default='hoop_stress', &
            allowed='straight|hoop_stress|local_symmetry|max_energy|path'), &
      key_t('points', type_real, 'of direction = path: x, y of each point, in the order in which the tip comes to them', unit='m', &
            allowed=any_number, fewest=0, most=max_values), &
      constant_keys, growth_law_keys, toughness_keys, &
      key_t('rate', type_name, 'of law = fatigue: whose law the way in a load cycle follows', default='paris', &
            allowed='paris|walker|forman'), &
      key_t('start', type_real, 'from when on this &growth applies, in motion', default='0.0', unit='s', allowed=not_negative), &
      key_t('end', type_real, 'until when; 0: to the end of the run', default='0.0', unit='s', allowed=not_negative), &
      key_t('increment', type_real, 'by which a tip advances in a load step at rest; of fatigue '// &
            'that which is the first to', default='0.0', &
            example='1e-3', unit='m', allowed=not_negative), &
      key_t('max_length', type_real, 'length of the whole crack at which it stops; 0: none', default='0.0', unit='m', &
            allowed=not_negative), &
      key_t('tips', type_name, &
            'which tips go on: all; at rest, of all with this, that with the largest G over toughness; in motion that at an end', &
            default='all', allowed='all|largest|last|first')]

   !> &growth: how a crack grows.
   type :: growth_t
      character(name_len) :: crack = ''          !! name of the crack; '' where there is one
      integer :: path = 0                        !! number of the path, or 1 of a crack on a symmetry plane; 0: there is no such one
      type(growth_law_t) :: law                  !! without a name where there is none of the one given
      character(name_len) :: rate = ''           !! of load cycles: 'paris', 'walker' or 'forman'
      type(constant_t) :: constants(size(constant_keys) + size(growth_law_keys)) !! of it
      type(factors_t) :: factors                 !! of its toughness
      character(name_len) :: direction = ''      !! 'straight', 'hoop_stress', 'local_symmetry', 'max_energy' or 'path'
      real(dp), allocatable :: points(:, :)      !! of 'path' [m], (ndim, any)
      real(dp) :: start = 0                      !! from when on it applies [s]
      real(dp) :: end = huge(1.0_dp)             !! until when [s]
      real(dp) :: increment = 0                  !! [m]
      real(dp) :: max_length = 0                 !! 0: none [m]
      logical :: only_largest = .false.          !! whether only the tip with the largest G advances
      logical :: of_end(2) = .true.              !! whether the tip at the first and that at the last point do
   contains
      procedure :: toughness_at
      procedure :: depends_on_speed
      procedure :: speed_at
      procedure :: rate_at
      procedure :: yield_stress
      procedure :: turns
   end type growth_t

   type(group_t), parameter :: energy_release_group = group_t('energy_release', once, is_assumed, &
      'which energy quantities are recorded')

   integer, parameter :: most_radii = 10           !! most radii of the domain integral
   integer, parameter :: most_estimators = 9

   type(key_t), parameter :: energy_release_keys(*) = [ &
      key_t('estimators', type_name, 'of the energy release rate and of K, which the history records; none by default', &
            example=merge('vcct, stress_closure, domain_integral', 'vcct, domain_integral                ', ndim == 2), &
            allowed='{estimators}', fewest=0, most=most_estimators), &
      key_t('energy_balance', type_logical, 'whether the history records the energy that the method itself loses, numerical_loss', &
            default='.false.', example='.true.'), &
      key_t('radii', type_real, 'of domain_integral: increasing; by default 0.4, 0.6, 0.8 of what fits, of two cells or more; '// &
            'of solids 4, 5 and 6 cells', example='4.0e-3, 6.0e-3, 8.0e-3', unit='m', allowed=positive, &
            fewest=0, most=most_radii), &
      key_t('t_stress', type_logical, 'whether the history records the T-stress, by domain_integral', default='.false.', &
            example=merge('.true. ', '.false.', ndim == 2)), &
      key_t('phase_length', type_real, &
            'of tips between two materials: distance ahead at which K_I and K_II are those of the stress; 0: no K there', &
            default='0.0', unit='m', allowed=not_negative), &
      key_t('reference', type_name, &
            'where the reference value G_ref comes from: nowhere, double cantilever beam theory, or a key', default='none', &
            example=merge('dcb ', 'none', ndim == 2), allowed='none|dcb|value'), &
      key_t('reference_value', type_real, 'G_ref where reference = ''value''; needed there', default='0.0', unit='J/m2', &
            allowed=not_negative)]

   !> &energy_release: what is recorded of energy.
   type :: energy_release_t
      type(estimator_t), allocatable :: chosen(:) !! estimators of G and K, the best one first
      logical :: energy_balance = .false.        !! whether the loss of the method is recorded
      logical :: t_stress = .false.              !! whether the T-stress is
      real(dp), allocatable :: radii(:)          !! of the domain integral, ascending [m]
      real(dp) :: phase_length = 0               !! at which K of an interface is, 0: it is not recorded [m]
      character(name_len) :: reference = ''      !! 'none', 'dcb' or 'value'
      real(dp) :: reference_value = 0            !! G_ref where reference = 'value' [J/m2]
   end type energy_release_t

contains

   !> Take all groups of this name. An odd number of coordinates leaves the last one out. All but paths have their tip alone, where that is
   !> good, as long as it is not known how far they reach.
   pure subroutine fill_paths(settings, paths)
      type(settings_t), intent(in) :: settings
      type(path_spec_t), allocatable, intent(out) :: paths(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, entry
      allocate (paths(merge(settings%count_of('crack'), 0, ndim == plane)))
      do k = 1, size(paths)
         entry = settings%find('crack', k)
         paths(k)%kind = settings%text(entry, 'kind')
         paths(k)%name = settings%text(entry, 'name')
         paths(k)%contact = settings%text(entry, 'contact') /= 'none'
         if (settings%text(entry, 'contact') == 'friction') paths(k)%friction = settings%number(entry, 'friction')
         if (any(paths(k)%kind == ['symmetry', 'line    '])) paths(k)%key = 'tip'
         numbers = settings%numbers(entry, 'points')
         if (paths(k)%key == 'tip') numbers = settings%numbers(entry, 'tip')
         paths(k)%points = reshape(numbers, [ndim, size(numbers)/ndim])
         paths(k)%direction = settings%vector(entry, 'direction')
         paths(k)%length = settings%number(entry, 'length')
      end do
   end subroutine fill_paths

   !> Take all groups of this name, of solids. What is wrong or missing is 0 or empty.
   pure subroutine fill_planes(settings, planes)
      type(settings_t), intent(in) :: settings
      type(plane_spec_t), allocatable, intent(out) :: planes(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, entry, along(2)
      allocate (planes(merge(0, settings%count_of('crack'), ndim == plane)))
      do k = 1, size(planes)
         associate (spec => planes(k))
            entry = settings%find('crack', k)
            spec%name = settings%text(entry, 'name')
            spec%front = settings%text(entry, 'front')
            spec%axis = max(1, index('xyz', trim(settings%text(entry, 'normal'))))
            spec%is_symmetry = settings%text(entry, 'kind') == 'symmetry'
            spec%contact = settings%text(entry, 'contact') /= 'none'
            if (settings%text(entry, 'contact') == 'friction') spec%friction = settings%number(entry, 'friction')
            spec%direction = settings%vector(entry, 'direction')
            numbers = settings%numbers(entry, 'center')
            if (spec%front == 'straight') numbers = settings%numbers(entry, 'tip')
            if (size(numbers) == ndim) spec%center = numbers
            spec%radii = settings%numbers(entry, 'radii')
            along = plane_axes(spec%axis)
            if (size(spec%radii) == 2 .and. along(1) > along(2)) spec%radii = spec%radii([2, 1]) ! in cyclic order
            numbers = settings%numbers(entry, 'points')
            spec%points = reshape(numbers, [ndim, size(numbers)/ndim])
            if (spec%front == 'polygon' .and. size(numbers) >= ndim) spec%center = numbers(:ndim)
         end associate
      end do
   end subroutine fill_planes

   !> Whether the crack turns by itself, as its modes have it.
   pure logical function turns(self)
      class(growth_t), intent(in) :: self
      turns = self%direction /= 'straight' .and. self%direction /= 'path'
   end function turns

   !> Toughness that a tip meets [J/m2]: that of the law, with the toughness of the body in place of that of the group, by all factors. Along a seam the
   !> least tough body has its say.
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

   !> Whether that changes with the speed of a tip.
   pure logical function depends_on_speed(self, advance)
      class(growth_t), intent(in) :: self
      type(advance_t), intent(in) :: advance
      type(advance_t) :: slow, fast
      slow = advance
      slow%speed = 0
      fast = advance
      fast%speed = huge(fast%speed)
      depends_on_speed = self%factors%of_speed%is_there() .or. self%toughness_at(fast) > self%toughness_at(slow)
   end function depends_on_speed

   !> Speed that is given at a time [m/s].
   pure real(dp) function speed_at(self, time)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      speed_at = 0
      if (self%law%gives_speed()) speed_at = self%law%speed(self%constants, time)
   end function speed_at

   !> Way in a load cycle [m].
   pure real(dp) function rate_at(self, range, ratio, part)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: range              !! of K [Pa sqrt(m)]
      real(dp), intent(in) :: ratio              !! least over largest K [-]
      real(dp), intent(in) :: part               !! largest K over that of the toughness [-]
      rate_at = 0
      if (self%law%is_cyclic()) rate_at = self%law%rate(self%constants, trim(self%rate), range, ratio, part)
   end function rate_at

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
         growth(k)%crack = settings%text(entry, 'crack')
         i = findloc(laws%name == settings%text(entry, 'law'), .true., dim=1)
         if (i > 0) growth(k)%law = laws(i)
         growth(k)%constants = settings%constants(entry, [constant_keys%name, growth_law_keys%name])
         call fill_factors(settings, entry, growth(k)%factors)
         growth(k)%rate = settings%text(entry, 'rate')
         growth(k)%direction = settings%text(entry, 'direction')
         numbers = settings%numbers(entry, 'points')
         growth(k)%points = reshape(numbers, [ndim, size(numbers)/ndim])
         growth(k)%start = settings%number(entry, 'start')
         if (settings%number(entry, 'end') > 0) growth(k)%end = settings%number(entry, 'end')
         growth(k)%increment = settings%number(entry, 'increment')
         growth(k)%max_length = settings%number(entry, 'max_length')
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
      energy_release%radii = settings%numbers(entry, 'radii')
      energy_release%energy_balance = settings%flag(entry, 'energy_balance')
      energy_release%t_stress = settings%flag(entry, 't_stress')
      energy_release%phase_length = settings%number(entry, 'phase_length')
      energy_release%reference = settings%text(entry, 'reference')
      energy_release%reference_value = settings%number(entry, 'reference_value')
   end subroutine fill_energy_release
end module hampm_crack_groups
