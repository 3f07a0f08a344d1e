!> Every group and key of the namelist file, by the tables of `hampm_key_table`: the source of validation, `--template`, the
!> canonical text of a model and the reference.
module hampm_keys
   use hampm_kinds, only: name_len
   use hampm_choice_sets, only: expanded
   use hampm_key_rows, only: key_t, list_len, type_name, type_text, type_logical
   use hampm_key_table, only: groups, keys, key_count
   use hampm_settings, only: group_entry_t
   use hampm_text, only: did_you_mean, joined, printable
   implicit none
   private
   public :: groups, keys, renamed, find_group, find_key, first_key, key_count, choices, allowed_text, default_count, &
             default_value, unknown_group, unknown_key, is_text, new_entry

   !> A name of version 1.
   type :: renamed_t
      character(name_len) :: group = ''
      character(name_len) :: key = ''            !! its present name if `value` is given, else the old name
      character(name_len) :: value = ''          !! an old value of the key, '' where the key itself is meant
      character(name_len) :: new = ''            !! replacement, '' where there is none
   end type renamed_t

   type(renamed_t), parameter :: renames(*) = [ &
      renamed_t('material', 'dilatation', '', 'volumetric'), renamed_t('material', 'volumetric', 'point', '''standard'''), &
      renamed_t('material', 'volumetric', 'cell', '''b_bar'''), &
      renamed_t('material', 'kinematic', '', 'kinematic_hardening'), renamed_t('body', 'part', '', 'contact_group'), &
      renamed_t('constraint', 'push_only', '', 'unilateral'), renamed_t('contact', 'bodies', 'joined', '''bonded'''), &
      renamed_t('method', 'functions', '', 'shape_functions'), renamed_t('method', 'blend', '', 'lumped_fraction'), &
      renamed_t('method', 'mass', 'full', '''consistent'''), renamed_t('method', 'mass', 'blend', '''weighted'''), &
      renamed_t('method', 'solver', 'umfpack', '''direct'''), renamed_t('method', 'solver', 'banded', '''direct'''), &
      renamed_t('method', 'full_region', '', 'consistent_region'), renamed_t('method', 'full_lower', '', 'consistent_lower'), &
      renamed_t('method', 'full_upper', '', 'consistent_upper'), renamed_t('method', 'time_steps', '', ''), &
      renamed_t('energy_release', 'estimators', 'nodal_force', '''vcct'''), &
      renamed_t('energy_release', 'estimators', 'crack_closure', '''domain_integral'''), &
      renamed_t('energy_release', 'estimators', 'series_fit', '''domain_integral'''), &
      renamed_t('energy_release', 'estimators', 'energy_balance', 'energy_balance = .true. beside the estimators')]

contains

   !> How a name of version 1 is written now, for complaints; '' for a name that never was.
   pure function renamed(group, key, value) result(text)
      character(*), intent(in) :: group, key       !! the key under its present name, for an old value
      character(*), intent(in) :: value            !! '' for the key itself
      character(:), allocatable :: text
      integer :: row
      text = ''
      do row = 1, size(renames)
         if (renames(row)%group /= group .or. renames(row)%key /= key .or. renames(row)%value /= value) cycle
         text = '; it is called '//trim(renames(row)%new)//' now: python3 tools/upgrade.py FILE prints the file with the new names'
         if (renames(row)%new == '') text = '; version 3 has none of it: leave it out'
      end do
   end function renamed

   !> A group of which no key is set yet.
   pure function new_entry(group, location) result(entry)
      integer, intent(in) :: group                 !! its row
      character(*), intent(in) :: location         !! place of its beginning
      type(group_entry_t) :: entry
      integer :: first
      first = first_key(group)
      entry%group = group
      entry%name = groups(group)%name
      entry%location = location
      allocate (entry%keys(key_count(group)), entry%settings(key_count(group)))
      entry%keys = keys(first:first + key_count(group) - 1)%name
   end function new_entry

   !> Row of a group in the table, 0 for an unknown name.
   pure integer function find_group(name)
      character(*), intent(in) :: name             !! in lower case
      find_group = findloc(groups%name == name, .true., dim=1)
   end function find_group

   !> Position of a key among the keys of its group, 0 for an unknown name.
   pure integer function find_key(group, name)
      integer, intent(in) :: group                 !! row of the group
      character(*), intent(in) :: name             !! in lower case
      find_key = findloc(keys(first_key(group):first_key(group) + key_count(group) - 1)%name == name, .true., dim=1)
   end function find_key

   !> Row of the first key of a group; the keys of a group stand together.
   pure integer function first_key(group)
      integer, intent(in) :: group
      first_key = sum(key_count(:group - 1)) + 1
   end function first_key

   !> Whether the values of a key are text.
   pure logical function is_text(key)
      type(key_t), intent(in) :: key
      is_text = key%value_type == type_name .or. key%value_type == type_text
   end function is_text

   !> The texts that a key allows; none where it allows any text.
   pure subroutine choices(key, list)
      type(key_t), intent(in) :: key
      character(name_len), allocatable, intent(out) :: list(:)
      character(:), allocatable :: allowed
      integer :: i
      allowed = expanded(key%allowed, '', '|')
      allocate (list(part_count(allowed, '|')))
      do i = 1, size(list)
         list(i) = part(allowed, '|', i)
      end do
   end subroutine choices

   !> Allowed values of a key: the interval of a number, or choices, each between quotes; '' if any text is allowed.
   pure function allowed_text(key, quote, separator) result(text)
      type(key_t), intent(in) :: key
      character(*), intent(in) :: quote, separator
      character(:), allocatable :: text
      character(name_len), allocatable :: names(:)
      text = trim(key%allowed)
      call choices(key, names)
      if (key%value_type == type_logical) names = [character(name_len) :: '.true.', '.false.']
      if (size(names) > 0 .and. (is_text(key) .or. key%value_type == type_logical)) &
         text = quote//joined(names, quote//separator//quote)//quote
   end function allowed_text

   !> Number of values of an absent key, or of its values in the template.
   pure integer function default_count(key, as_example)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example            !! whether the template is meant
      default_count = 1
      if (key%most > 1 .or. key%fewest == 0) default_count = part_count(default_list(key, as_example), ',')
   end function default_count

   !> One of these values.
   pure function default_value(key, as_example, i) result(text)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      integer, intent(in) :: i
      character(:), allocatable :: text
      text = trim(default_list(key, as_example))
      if (key%most > 1) text = part(text, ',', i)
   end function default_value

   !> These values in one text.
   pure character(list_len) function default_list(key, as_example)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      default_list = key%default
      if (as_example .and. key%example /= '') default_list = key%example
   end function default_list

   !> How many parts a text has between separators; an empty text has none.
   pure integer function part_count(text, separator)
      character(*), intent(in) :: text
      character, intent(in) :: separator
      integer :: i
      part_count = 0
      if (text /= '') part_count = count([(text(i:i) == separator, i=1, len(text))]) + 1
   end function part_count

   !> The n-th part of a text between separators, without the blanks around it.
   pure function part(text, separator, n)
      character(*), intent(in) :: text
      character, intent(in) :: separator
      integer, intent(in) :: n
      character(:), allocatable :: part
      integer :: i
      part = text//separator
      do i = 2, n
         part = part(index(part, separator) + 1:)
      end do
      part = trim(adjustl(part(:index(part, separator) - 1)))
   end function part

   !> Complaint about a group that does not exist.
   pure function unknown_group(name) result(message)
      character(*), intent(in) :: name
      character(:), allocatable :: message
      character(name_len) :: names(size(groups))
      names = groups%name
      message = did_you_mean(name, names)
      if (message == '') message = '; groups are '//joined(names, ', ')
      message = 'there is no group &'//printable(name, 40)//message
      if (name == '') message = 'the name of a group is missing behind ''&'''
   end function unknown_group

   !> Complaint about a key that does not exist in a group; names the group that has one of this name.
   pure function unknown_key(group, name) result(message)
      integer, intent(in) :: group
      character(*), intent(in) :: name
      character(:), allocatable :: message, question
      character(name_len) :: names(key_count(group))
      integer :: first, i
      first = first_key(group)
      names = keys(first:first + size(names) - 1)%name
      question = did_you_mean(name, names)
      do i = 1, size(names)
         if (name /= '' .and. index('|'//trim(keys(first + i - 1)%also)//'|', '|'//name//'|') > 0) &
            question = '; it is '''//trim(names(i))//''' here'
      end do
      if (question == '') question = '; its keys are '//joined(names, ', ')
      do i = size(groups), 1, -1
         if (find_key(i, name) > 0) question = '; '''//name//''' is a key of &'//trim(groups(i)%name)
      end do
      if (renamed(groups(group)%name, name, '') /= '') question = renamed(groups(group)%name, name, '')
      message = '&'//trim(groups(group)%name)//' has no key '''//printable(name, 40)//''''//question
   end function unknown_key
end module hampm_keys
