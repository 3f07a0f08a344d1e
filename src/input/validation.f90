!> Each key by itself, against the table of keys: is it there, how many values, of which type, in which range.
!> Keys that are not given get their defaults here.
module hampm_validation
   use hampm_kinds, only: dp, ndim, name_len, path_len
   use hampm_key_rows, only: key_t, max_values, type_integer, type_real, type_logical, type_name, is_required, is_assumed
   use hampm_keys, only: groups, keys, renamed, first_key, choices, allowed_text, default_count, default_value, is_text, new_entry
   use hampm_settings, only: settings_t, setting_t, group_entry_t, value_t
   use hampm_text, only: to_text, lower_case, did_you_mean, printable
   use hampm_values, only: parse_real, parse_integer, is_number, is_extreme, is_no_number
   use hampm_version, only: program_name
   implicit none
   private
   public :: validate, must_be

   character(7), parameter :: truths(*) = [character(7) :: '.true.', '.t.', 'true', 't']      !! as namelists have them
   character(7), parameter :: untruths(*) = [character(7) :: '.false.', '.f.', 'false', 'f']

contains

   !> Check all groups and keys, convert their values, fill in defaults.
   pure subroutine validate(settings)
      type(settings_t), intent(inout) :: settings
      integer :: entry
      call check_presence(settings)
      do entry = 1, settings%count
         call validate_entry(settings, entry)
      end do
   end subroutine validate

   !> Groups that are absent: refused, or assumed.
   pure subroutine check_presence(settings)
      type(settings_t), intent(inout) :: settings
      type(group_entry_t) :: assumed
      integer :: g
      do g = 1, size(groups)
         if (settings%count_of(trim(groups(g)%name)) > 0) cycle
         if (groups(g)%presence == is_required) call settings%errors%add( &
            'the group &'//trim(groups(g)%name)//' is missing: '//trim(groups(g)%meaning)//'; '// &
            program_name//' --template shows one', &
            settings%file, trim(groups(g)%name), subject='')
         if (groups(g)%presence /= is_assumed) cycle
         assumed = new_entry(g, settings%file)
         call settings%add_entry(assumed)
      end do
   end subroutine check_presence

   !> Check the keys of one group.
   pure subroutine validate_entry(settings, entry)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      character(:), allocatable :: message
      integer :: k, i, first
      first = first_key(settings%entries(entry)%group)
      do k = 1, size(settings%entries(entry)%settings)
         associate (key => keys(first + k - 1))
            call set_nulls(key, settings%entries(entry)%settings(k))
            if (.not. settings%entries(entry)%settings(k)%given) then
               if (key%required) then
                  settings%entries(entry)%settings(k)%good = .false.
                  message = trim(key%example)
                  if (is_text(key)) message = ''''//message//''''
                  call settings%errors%add('is missing: '//trim(key%meaning)//'; for example '//trim(key%name)//' = '// &
                                           message//'; '//must_be(key), settings%entries(entry)%location, &
                                           trim(settings%entries(entry)%name), trim(key%name))
                  cycle
               end if
               do i = 1, default_count(key, .false.)
                  call settings%entries(entry)%settings(k)%append(default_value(key, .false., i), is_text(key))
               end do
            end if
            if (.not. settings%entries(entry)%settings(k)%good) cycle
            call validate_setting(settings%entries(entry)%name, key, settings%entries(entry)%settings(k), message)
            settings%entries(entry)%settings(k)%good = message == ''
            if (message /= '') call settings%complain(entry, trim(key%name), message)
         end associate
      end do
   end subroutine validate_entry

   !> A key whose values are all null is not given; null values among others are the defaults, as the reader of Fortran leaves them.
   pure subroutine set_nulls(key, setting)
      type(key_t), intent(in) :: key
      type(setting_t), intent(inout) :: setting
      integer :: i, n
      if (.not. (setting%given .and. setting%good)) return
      n = min(setting%count, max_values)
      setting%given = .not. all([(setting%values(i)%is_null(), i=1, n)])
      if (.not. setting%given) setting%count = 0
      do i = 1, min(setting%count, default_count(key, .false.))
         if (setting%values(i)%is_null()) setting%values(i) = value_t(default_value(key, .false., i), is_text(key))
      end do
   end subroutine set_nulls

   !> Check one key; numbers are converted, choices brought to lower case.
   pure subroutine validate_setting(group, key, setting, message)
      character(*), intent(in) :: group
      type(key_t), intent(in) :: key
      type(setting_t), intent(inout) :: setting
      character(:), allocatable, intent(out) :: message   !! error message, '' for none; all errors of texts
      character(:), allocatable :: wrong
      integer :: i
      message = wrong_count(key, setting%count)
      if (message /= '') return
      allocate (setting%numbers(merge(0, setting%count, is_text(key))))
      do i = 1, setting%count
         wrong = ''
         if (setting%values(i)%is_null()) then
            wrong = 'is missing and has no default: '//must_be(key)
         else if (is_text(key)) then
            call validate_text(group, key, setting%values(i), wrong)
         else
            call validate_number(key, setting%values(i), setting%numbers(i), wrong)
         end if
         if (wrong == '') cycle
         if (setting%count > 1) wrong = 'value '//to_text(i)//' '//wrong
         if (message /= '') wrong = '; '//wrong
         message = message//wrong
         if (.not. is_text(key)) return
      end do
   end subroutine validate_setting

   !> Error of a number of values, '' for none.
   pure function wrong_count(key, n) result(message)
      type(key_t), intent(in) :: key
      integer, intent(in) :: n
      character(:), allocatable :: message
      logical :: is_point                        ! or a vector, that may be left out
      is_point = key%value_type == type_real .and. key%fewest == 0 .and. key%most == ndim
      message = ''
      if (n >= key%fewest .and. n <= key%most .and. .not. (is_point .and. mod(n, ndim) /= 0)) return
      if (is_point .and. n < key%most) then
         message = 'must have '//values_text(key%most)//', or none, not '//to_text(n)
      else if (key%fewest == key%most) then
         message = 'must have '//values_text(key%most)//', not '//to_text(n)
      else if (n > key%most) then
         message = 'may have at most '//values_text(key%most)
      else
         message = 'must have at least '//values_text(key%fewest)//', not '//to_text(n)
      end if
      message = message//'; each '//must_be(key)
   end function wrong_count

   !> `1 value`, `2 values`.
   pure function values_text(n) result(text)
      integer, intent(in) :: n
      character(:), allocatable :: text
      text = to_text(n)//' values'
      if (n == 1) text = '1 value'
   end function values_text

   !> Read a number and check its range; `message` stays where nothing is wrong.
   pure subroutine validate_number(key, value, number, message)
      type(key_t), intent(in) :: key
      type(value_t), intent(in) :: value
      real(dp), intent(out) :: number
      character(:), allocatable, intent(inout) :: message
      integer :: status
      if (key%value_type == type_logical) then
         number = merge(1, 0, any(lower_case(value%text) == truths))
         if (value%quoted .or. .not. any(lower_case(value%text) == [truths, untruths])) message = must_be(key)
         return
      end if
      if (key%value_type == type_integer) then
         call parse_integer(value%text, number, status)
      else
         call parse_real(value%text, number, status)
      end if
      if (value%quoted) status = is_no_number
      if (status == is_number .and. .not. in_range(number, key)) then
         message = must_be(key)
      else if (status == is_extreme .and. key%value_type == type_integer) then
         message = must_be(key)//' and at most '//to_text(huge(1))
      else if (status == is_extreme) then
         message = must_be(key)//', finite and in size 0 or from 1e-100 to 1e100'
      else if (status == is_no_number) then
         message = must_be(key)//' (it is no '//trim(merge('integer', 'number ', key%value_type == type_integer))//')'
      end if
   end subroutine validate_number

   !> Whether a number is in the interval of a key.
   pure logical function in_range(number, key)
      real(dp), intent(in) :: number
      type(key_t), intent(in) :: key
      in_range = merge(number > key%lowest, number >= key%lowest, key%above) .and. &
                 merge(number < key%highest, number <= key%highest, key%below)
   end function in_range

   !> Check a text or choice; `message` stays where nothing is wrong.
   pure subroutine validate_text(group, key, value, message)
      character(*), intent(in) :: group
      type(key_t), intent(in) :: key
      type(value_t), intent(inout) :: value
      character(:), allocatable, intent(inout) :: message
      character(name_len), allocatable :: list(:)
      integer :: longest, i
      value%text = trim(value%text)
      longest = merge(name_len, path_len, key%value_type == type_name)
      if (.not. value%quoted) then
         message = 'must be in quotes: '''//printable(value%text, 40)//''''
      else if (len(value%text) > longest) then
         message = 'must not be longer than '//to_text(longest)//' characters'
      else if (any([(iachar(value%text(i:i)) < 32, i=1, len(value%text))])) then
         message = 'must not contain control characters'
      else if (index(value%text, char(255)) > 0) then
         message = 'must be text of UTF-8, which has no byte 255'
      else if (key%allowed /= '') then
         call choices(key, list)
         value%text = lower_case(value%text)
         if (any(list == value%text)) return
         message = must_be(key)//renamed(group, key%name, value%text)
         if (renamed(group, key%name, value%text) == '') message = message//did_you_mean(value%text, list)
      else if (key%required .and. value%text == '') then
         message = 'must not be empty'
      end if
   end subroutine validate_text

   !> Required values of a key: `must be in (0, inf) [Pa]`, `must be 'stress' or 'strain'`.
   pure function must_be(key) result(text)
      type(key_t), intent(in) :: key
      character(:), allocatable :: text
      integer :: last
      if (is_text(key)) then
         text = 'must be '//allowed_text(key, '''', ', ')
         last = index(text, ', ', back=.true.)
         if (last > 0) text = text(:last - 1)//' or'//text(last + 1:)
         if (key%allowed == '') text = 'must be text in quotes'
      else
         text = 'must be in '//trim(key%allowed)
         if (key%value_type == type_logical) text = 'must be .true. or .false., without quotes'
         if (key%value_type == type_integer) text = 'must be an integer in '//trim(key%allowed)
         if (key%unit /= '') text = text//' ['//trim(key%unit)//']'
      end if
   end function must_be
end module hampm_validation
