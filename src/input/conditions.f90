!> Conditions on a model as text: `&crack kind = 'line' | 'path' and &crack contact /= 'none' or cells that are cut`. Words between `and`
!> and `or` are a group that is present (`&growth`), a key that the user has set to something else than its default (`&load times`), a key
!> with one of some values (`=`), with none of them (`/=`), above or below a number (`>`, `<`), or a feature.
!>
!> Features of a model that no single key tells: predicates with names, by which rows of the table of rules (`hampm_rules`) mean them.
module hampm_conditions
   use hampm_choice_sets, only: expanded
   use hampm_keys, only: keys, find_key, first_key, default_count, default_value, is_text
   use hampm_kinds, only: ndim, plane, dp
   use hampm_model, only: model_t, cuts_cells, has_shapes, cracks_cut_cells, mass_acts, path_of
   use hampm_settings, only: row_of, settings_t, setting_t
   use hampm_values, only: parse_real
   use hampm_load_placement, only: is_on_faces
   implicit none
   private
   public :: atom_t, parse_condition, next_break, holds, shown_atom, features, is_present, is_named

   !> The names of the features.
   character(*), parameter :: features(*) = [character(48) :: &
      'cells that are cut', 'cracks that cut cells', 'tips at no nodes', 'several cracks', 'several bodies', &
      'edges that are no grid lines', 'growth by laws of both kinds', 'something that growth scales', &
      'growth scales forces beside motions', &
      'a shear of the eigenstrain', 'a fourth value of the eigenstrain', &
      'a pressed path that grows in motion', 'samples apart from load steps', 'a body of it', &
      'another body of that group', 'a mass matrix that acts', 'quadratic cells at an axis', 'cohesion all along it', &
      'a load that is recorded', 'a solid', 'a plane', 'a pin without an axis']

   integer, parameter :: most_atoms = 6, most_choices = 8, word_len = 24
   integer, parameter :: is_present = 1, is_set = 2, is_one_of = 3, is_none_of = 4, is_above = 5, is_below = 6, is_named = 7

   !> One of the words of a condition.
   type :: atom_t
      integer :: alternative = 1                 !! number of the part between `or` in which it is
      integer :: kind = 0                        !! how it is told, one of the above
      character(word_len) :: group = ''          !! '' for a feature
      character(word_len) :: key = ''            !! '' for a group or a feature
      integer :: choices = 0                     !! number of values
      character(word_len) :: values(most_choices) = '' !! without quotes
      character(6*word_len) :: text = ''         !! as it stands in the condition
   end type atom_t

contains

   !> Take a condition apart. An empty text has no words.
   pure subroutine parse_condition(condition, atoms)
      character(*), intent(in) :: condition
      type(atom_t), allocatable, intent(out) :: atoms(:)
      type(atom_t) :: found(most_atoms)
      character(:), allocatable :: text
      integer :: n, alternative, from, behind
      text = expanded(condition, '''', ' | ')
      n = 0
      alternative = 1
      from = 1
      do while (from <= len_trim(text))
         behind = next_break(text(from:)) + from - 1
         n = n + 1
         found(n) = atom_of(trim(adjustl(text(from:behind - 1))))
         found(n)%alternative = alternative
         if (behind > len_trim(text)) exit
         if (text(behind:behind + 3) == ' or ') alternative = alternative + 1
         from = behind + merge(4, 5, text(behind:behind + 3) == ' or ')
      end do
      atoms = found(:n)
   end subroutine parse_condition

   !> Where the next `and` or `or` is with the blank before it; past the end for none.
   pure integer function next_break(text)
      character(*), intent(in) :: text
      integer :: i, at(2)
      at = [index(text, ' and '), index(text, ' or ')]
      next_break = minval([(merge(at(i), len_trim(text) + 1, at(i) > 0), i=1, 2)])
   end function next_break

   !> One word of a condition.
   pure function atom_of(text) result(atom)
      character(*), intent(in) :: text
      type(atom_t) :: atom
      character(:), allocatable :: rest, value
      integer :: blank
      atom%text = text
      atom%kind = is_named
      if (index(text, '&') /= 1) return
      blank = index(text//' ', ' ')
      atom%group = text(2:blank - 1)
      atom%kind = is_present
      if (blank > len(text)) return
      rest = text(blank + 1:)
      blank = index(rest//' ', ' ')
      atom%key = rest(:blank - 1)
      atom%kind = is_set
      if (blank > len(rest)) return
      rest = rest(blank + 1:)
      blank = index(rest//' ', ' ')
      select case (rest(:blank - 1))
       case ('=')
         atom%kind = is_one_of
       case ('/=')
         atom%kind = is_none_of
       case ('>')
         atom%kind = is_above
       case ('<')
         atom%kind = is_below
       case default
         atom%kind = 0
         return
      end select
      rest = rest(blank + 1:)//' |'
      do while (index(rest, '|') > 0)
         atom%choices = atom%choices + 1
         value = trim(adjustl(rest(:index(rest, '|') - 1)))
         if (index(value, '''') == 1) value = value(2:len(value) - 1) ! without the quotes around it
         atom%values(atom%choices) = value
         rest = rest(index(rest, '|') + 1:)
      end do
   end function atom_of

   !> Whether a word holds of a model, and of one of its groups where it is about such. What has an error in it does not hold.
   pure logical function holds(atom, model, settings, entry)
      type(atom_t), intent(in) :: atom
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of the group, 0 for none
      logical :: same
      holds = .false.
      if (atom%kind == is_named) then
         holds = has_feature(model, settings, trim(atom%text), entry)
         return
      end if
      if (entry == 0) return
      if (settings%entries(entry)%name /= atom%group) return
      holds = atom%kind == is_present
      if (holds) return
      if (.not. settings%good(entry, trim(atom%key))) return
      associate (setting => settings%entries(entry)%settings(row_of(settings%entries(entry), atom%key)))
         select case (atom%kind)
          case (is_set)
            holds = setting%given .and. .not. is_default(setting, settings%entries(entry)%group, trim(atom%key))
          case (is_one_of, is_none_of)
            same = position(atom, setting) > 0
            holds = same .eqv. atom%kind == is_one_of
          case (is_above)
            holds = any(setting%numbers > number(atom%values(1)))
          case (is_below)
            holds = any(setting%numbers < number(atom%values(1)))
         end select
      end associate
   end function holds

   !> Which of the values of a setting is one of those of a word, 0 for none.
   pure integer function position(atom, setting)
      type(atom_t), intent(in) :: atom
      type(setting_t), intent(in) :: setting
      integer :: k
      do position = setting%count, 1, -1
         do k = 1, atom%choices
            if (size(setting%numbers) == 0) then
               if (setting%values(position)%text == atom%values(k)) return
            else if (abs(setting%numbers(position) - number(atom%values(k))) <= 0) then
               return
            end if
         end do
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

   !> Whether a setting says what holds without it.
   pure logical function is_default(setting, group, name)
      type(setting_t), intent(in) :: setting
      integer, intent(in) :: group               !! row of the group
      character(*), intent(in) :: name           !! of the key
      integer :: i
      associate (key => keys(first_key(group) + find_key(group, name) - 1))
         is_default = setting%count == default_count(key, .false.)
         if (.not. is_default) return
         do i = 1, setting%count
            if (is_text(key)) then
               is_default = is_default .and. setting%values(i)%text == default_value(key, .false., i)
            else
               is_default = is_default .and. abs(setting%numbers(i) - number(default_value(key, .false., i))) <= 0
            end if
         end do
      end associate
   end function is_default

   !> A word with the name of its group and the value that the model has: `&crack 'b' contact = 'friction'`.
   pure function shown_atom(atom, settings, entry) result(text)
      type(atom_t), intent(in) :: atom
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of its group, 0 for none
      character(:), allocatable :: text
      integer :: k
      text = trim(atom%text)
      if (entry == 0 .or. atom%kind == is_named) return
      text = '&'//settings%title(entry)
      if (atom%kind == is_present) return
      associate (setting => settings%entries(entry)%settings(row_of(settings%entries(entry), atom%key)))
         k = 0
         if (atom%kind == is_one_of) k = position(atom, setting)
         if (k > 0 .and. setting%count > 1) then
            text = text//' '//trim(atom%key)//' = '''//setting%values(k)%text//''''
         else
            text = text//' '//trim(atom%key)//' = '//setting%shown()
         end if
      end associate
   end function shown_atom

   !> Whether a model, or one of its groups where the feature is about such, has a feature.
   pure logical function has_feature(model, settings, name, entry) result(has)
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      character(*), intent(in) :: name           !! one of `features`
      integer, intent(in) :: entry               !! position of the group that the rule is about
      real(dp), allocatable :: strain(:)
      integer :: k
      has = .false.
      select case (name)
       case ('cells that are cut')               ! by cracks that cut cells, polygons, circles and holes
         has = cuts_cells(model)
       case ('cracks that cut cells')
         has = cracks_cut_cells(model)
       case ('a solid')                          ! which another build is for
         has = ndim > 2
       case ('a pin without an axis')
         has = ndim > 2 .and. any([(model%constraints(k)%motion%turns .and. count(model%constraints(k)%fixed) /= 2, &
                                    k=1, size(model%constraints))])
       case ('a plane')
         has = ndim == 2
       case ('tips at no nodes')
         has = .not. all(model%paths%at_nodes)
       case ('a mass matrix that acts')
         has = mass_acts(model)
       case ('quadratic cells at an axis')
         has = model%run%thickness%is_ring .and. model%grid%order > 1 .and. .not. model%grid%lower(1) > 0
       case ('several cracks')
         has = settings%count_of('crack') > 1
       case ('several bodies')
         has = size(model%bodies) > 1
       case ('edges that are no grid lines')
         has = has_shapes(model) .and. ndim == plane
       case ('growth by laws of both kinds')
         has = any(model%growth%law%is_static) .and. .not. all(model%growth%law%is_static) .or. &
               any(model%growth%law%is_cyclic()) .and. .not. all(model%growth%law%is_cyclic())
       case ('something that growth scales')
         has = has_scaled_forces(model) .or. has_scaled_motions(model) .or. .not. all(model%bodies%held)
       case ('growth scales forces beside motions')
         has = has_scaled_forces(model) .and. has_scaled_motions(model)
       case ('a load that is recorded')
         has = any(model%growth%law%is_static .and. .not. model%growth%law%is_cyclic()) .or. size(model%nucleations) > 0 .or. &
               any(model%constraints%name /= '')
       case ('a body of it')                     ! of a material
         has = any(model%materials%name == settings%text(entry, 'name'))
       case ('cohesion all along it')            ! along a crack
         do k = 1, size(model%cohesive)
            if (model%cohesive(k)%path == 0 .or. model%cohesive(k)%from > 0) cycle
            has = has .or. settings%find('crack', model%cohesive(k)%path) == entry
         end do
       case ('another body of that group')
         has = count(model%bodies%contact_group == settings%text(entry, 'contact_group')) > 1
       case ('a shear of the eigenstrain', 'a fourth value of the eigenstrain')
         strain = settings%numbers(entry, 'eigenstrain')
         k = merge(3, 4, name == 'a shear of the eigenstrain')
         if (size(strain) >= k) has = abs(strain(k)) > 0
       case ('a pressed path that grows in motion')
         do k = 1, size(model%loads)
            if (.not. is_on_faces(model%loads(k)) .or. path_of(model, model%loads(k)%crack) == 0) cycle
            has = has .or. any(model%growth%path == path_of(model, model%loads(k)%crack) .and. &
                               .not. model%growth%law%is_static) &
                           .and. .not. model%is_half()
         end do
       case ('samples apart from load steps')
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

   !> Whether the interval of the samples is not that of the load steps, by which it was replaced.
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
