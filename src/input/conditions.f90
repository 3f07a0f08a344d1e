!> Conditions on a model: `&crack kind = 'line' | 'path' and &crack contact /= 'none' or cells that are cut`. Words between `and`
!> and `or`: a present group (`&growth`), a key that differs from its default (`&load times`), a key with one of some values (`=`),
!> with none of them (`/=`), above or below a number (`>`, `<`), or a feature.
!>
!> Features of a model that no single key gives: named predicates for the rules of src/input/schema.
module hampm_conditions
   use hampm_choice_sets, only: is_among
   use hampm_key_rows, only: key_t
   use hampm_keys, only: keys, first_key, default_count, default_value, is_text
   use hampm_kinds, only: ndim, plane, dp
   use hampm_model, only: model_t, cuts_cells, has_shapes, mass_acts, path_of
   use hampm_rule_table, only: cells_that_are_cut, tips_at_no_nodes, several_cracks, several_bodies, &
                               edges_that_are_no_grid_lines, growth_by_laws_of_both_kinds, something_that_growth_scales, &
                               growth_scales_forces_beside_motions, a_shear_of_the_eigenstrain, &
                               a_fourth_value_of_the_eigenstrain, a_pressed_path_that_grows_in_motion, &
                               samples_apart_from_load_steps, a_body_of_it, another_body_of_that_group, &
                               a_mass_matrix_that_acts, quadratic_cells_at_an_axis, cohesion_all_along_it, &
                               a_load_that_is_recorded, a_solid, a_plane, a_pin_without_an_axis, features, values
   use hampm_rules, only: atom_t, is_present, is_set, is_one_of, is_none_of, is_above, is_below, is_named
   use hampm_settings, only: settings_t, setting_t
   use hampm_values, only: parse_real
   use hampm_load_placement, only: is_on_faces
   implicit none
   private
   public :: holds, shown_atom

contains

   !> Whether a word holds for a model, and for one of its groups if it names that. A setting with an error does not hold.
   pure logical function holds(atom, model, settings, entry)
      type(atom_t), intent(in) :: atom
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of the group, 0 for none
      holds = .false.
      if (atom%kind == is_named) then
         holds = has_feature(model, settings, atom%feature, entry)
         return
      end if
      if (entry == 0) return
      if (settings%entries(entry)%group /= atom%group) return
      holds = atom%kind == is_present
      if (holds) return
      associate (setting => settings%entries(entry)%settings(atom%key))
         if (.not. setting%good) return
         select case (atom%kind)
          case (is_set)
            holds = setting%given .and. .not. is_default(setting, keys(first_key(atom%group) + atom%key - 1))
          case (is_one_of, is_none_of)
            holds = position(atom, setting) > 0 .eqv. atom%kind == is_one_of
          case (is_above)
            holds = any(setting%numbers > atom%number)
          case (is_below)
            holds = any(setting%numbers < atom%number)
         end select
      end associate
   end function holds

   !> Index of the first value of a setting among those of a word, 0 for none.
   pure integer function position(atom, setting)
      type(atom_t), intent(in) :: atom
      type(setting_t), intent(in) :: setting
      do position = setting%count, 1, -1
         if (size(setting%numbers) == 0) then
            if (is_among(setting%values(position)%text, values(atom%first:atom%last))) return
         else if (abs(setting%numbers(position) - atom%number) <= 0) then
            return
         end if
      end do
   end function position

   !> A number or a truth as the table has it.
   pure real(dp) function number(text)
      character(*), intent(in) :: text
      integer :: status
      if (text == '.true.') then
         number = 1
      else if (text == '.false.') then
         number = 0
      else
         call parse_real(trim(text), number, status)
      end if
   end function number

   !> Whether a setting is equal to the default of its key.
   pure logical function is_default(setting, key)
      type(setting_t), intent(in) :: setting
      type(key_t), intent(in) :: key
      integer :: i
      is_default = setting%count == default_count(key, .false.)
      do i = 1, setting%count
         if (.not. is_default) return
         if (is_text(key)) then
            is_default = setting%values(i)%text == default_value(key, .false., i)
         else
            is_default = abs(setting%numbers(i) - number(default_value(key, .false., i))) <= 0
         end if
      end do
   end function is_default

   !> A word with the name of its group and the value that the model has: `&crack 'b' contact = 'friction'`.
   pure function shown_atom(atom, settings, entry) result(text)
      type(atom_t), intent(in) :: atom
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of its group
      character(:), allocatable :: text
      integer :: k
      if (atom%kind == is_named) then
         text = trim(features(atom%feature))
         return
      end if
      text = '&'//settings%title(entry)
      if (atom%kind == is_present) return
      associate (setting => settings%entries(entry)%settings(atom%key))
         text = text//' '//trim(settings%entries(entry)%keys(atom%key))//' = '
         k = 0
         if (atom%kind == is_one_of) k = position(atom, setting)
         if (k > 0 .and. setting%count > 1) then
            text = text//''''//setting%values(k)%text//''''
         else
            text = text//setting%shown()
         end if
      end associate
   end function shown_atom

   !> Whether a model, or one of its groups where the feature is about such, has a feature.
   pure logical function has_feature(model, settings, feature, entry) result(has)
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: feature
      integer, intent(in) :: entry               !! position of the group that the rule is about
      real(dp), allocatable :: strain(:)
      integer :: k
      has = .false.
      select case (feature)
       case (cells_that_are_cut)
         has = cuts_cells(model)
       case (a_solid)
         has = ndim > 2
       case (a_pin_without_an_axis)
         has = ndim > 2 .and. any([(model%constraints(k)%motion%turns .and. count(model%constraints(k)%fixed) /= 2, &
                                    k=1, size(model%constraints))])
       case (a_plane)
         has = ndim == 2
       case (tips_at_no_nodes)
         has = .not. all(model%paths%at_nodes)
       case (a_mass_matrix_that_acts)
         has = mass_acts(model)
       case (quadratic_cells_at_an_axis)
         has = model%run%thickness%is_ring .and. model%grid%order > 1 .and. .not. model%grid%lower(1) > 0
       case (several_cracks)
         has = settings%count_of('crack') > 1
       case (several_bodies)
         has = size(model%bodies) > 1
       case (edges_that_are_no_grid_lines)
         has = has_shapes(model) .and. ndim == plane
       case (growth_by_laws_of_both_kinds)
         has = any(model%growth%law%is_static) .and. .not. all(model%growth%law%is_static) .or. &
               any(model%growth%law%is_cyclic()) .and. .not. all(model%growth%law%is_cyclic()) .or. &
               any(model%growth%law%is_in_time) .and. .not. all(model%growth%law%is_in_time)
       case (something_that_growth_scales)
         has = has_scaled_forces(model) .or. has_scaled_motions(model) .or. .not. all(model%bodies%held)
       case (growth_scales_forces_beside_motions)
         has = has_scaled_forces(model) .and. has_scaled_motions(model)
       case (a_load_that_is_recorded)
         has = any(model%growth%law%is_static .and. .not. model%growth%law%has_rate()) .or. size(model%nucleations) > 0 .or. &
               any(model%constraints%name /= '')
       case (a_body_of_it)
         has = any(model%materials%name == settings%text(entry, 'name'))
       case (cohesion_all_along_it)
         do k = 1, size(model%cohesive)
            if (model%cohesive(k)%path == 0 .or. model%cohesive(k)%from > 0) cycle
            has = has .or. settings%find('crack', model%cohesive(k)%path) == entry
         end do
       case (another_body_of_that_group)
         has = count(model%bodies%contact_group == settings%text(entry, 'contact_group')) > 1
       case (a_shear_of_the_eigenstrain, a_fourth_value_of_the_eigenstrain)
         strain = settings%numbers(entry, 'eigenstrain')
         k = merge(3, 4, feature == a_shear_of_the_eigenstrain)
         if (size(strain) >= k) has = abs(strain(k)) > 0
       case (a_pressed_path_that_grows_in_motion)
         do k = 1, size(model%loads)
            if (.not. is_on_faces(model%loads(k)) .or. path_of(model, model%loads(k)%crack) == 0) cycle
            has = has .or. any(model%growth%path == path_of(model, model%loads(k)%crack) .and. &
                               .not. model%growth%law%is_static) &
                           .and. .not. model%is_half() .and. ndim == plane
         end do
       case (samples_apart_from_load_steps)
         has = model%method%time == 'static' .and. asks_for_other_samples(settings, settings%find('output', 1))
      end select
   end function has_feature

   !> Whether a load is not held.
   pure logical function has_scaled_forces(model) result(has)
      type(model_t), intent(in) :: model
      has = .not. all([model%loads%history%held, .true.])
   end function has_scaled_forces

   !> Whether a prescribed motion is not held.
   pure logical function has_scaled_motions(model) result(has)
      type(model_t), intent(in) :: model
      integer :: k
      has = .false.
      do k = 1, size(model%constraints)
         associate (motion => model%constraints(k)%motion)
            has = has .or. .not. motion%history%held .and. any(abs(motion%displacement) + abs(motion%velocity) > 0)
         end associate
      end do
   end function has_scaled_motions

   !> Whether the interval of the samples differs from the load steps, which replace it.
   pure logical function asks_for_other_samples(settings, output) result(asks)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: output              !! position of the group, 0 for none
      real(dp), parameter :: alike = 1e-9_dp
      real(dp) :: wanted
      integer :: status
      asks = .false.
      if (.not. (settings%given(output, 'history_interval') .and. settings%good(output, 'history_interval'))) return
      call parse_real(settings%text(output, 'history_interval'), wanted, status)
      asks = wanted > 0 .and. abs(wanted - settings%number(output, 'history_interval')) > alike*wanted
   end function asks_for_other_samples
end module hampm_conditions
