!> Reference of all groups and keys: Markdown for `--keys` and docs/reference/keys.md, `--json` for programs.
module hampm_key_reference
   use hampm_json, only: array, item, json_null, json_of, member, object
   use hampm_key_rows, only: group_t, key_t, type_integer, type_logical, is_required, is_assumed
   use hampm_keys, only: groups, keys, first_key, key_count, allowed_text, choices, default_count, default_value, is_text
   use hampm_kinds, only: name_len
   use hampm_namelist_text, only: example_list
   use hampm_text, only: line, paragraph, to_text
   implicit none
   private
   public :: reference_text, keys_json

contains

   !> Meaning of each group, whether it is optional, an example, and a table of its keys. The examples of all groups together are a
   !> model that runs.
   pure function reference_text() result(text)
      character(:), allocatable :: text
      integer :: g, k
      text = line('# Groups and keys of a model')//line('') &
             //paragraph('The output of `hampm --keys`, from the table by which models are validated. Units are SI. '// &
                         'A real number is 0 or in size from 1e-100 to 1e100. How keys depend on each other is in '// &
                         '[key_rules.md](key_rules.md). The examples together, but for those of groups marked as requiring '// &
                         'other choices, are a model that runs; `hampm --template` prints one with every key.', 0)
      do g = 1, size(groups)
         text = text//line('')//line('## &'//trim(groups(g)%name))//line('') &
                //paragraph(sentence(trim(groups(g)%meaning))//' '//presence(groups(g)), 0)//line('') &
                //example(g)//line('')//line('| key | values | unit | default | allowed | meaning |') &
                //line('|---|---|---|---|---|---|')
         do k = first_key(g), first_key(g) + key_count(g) - 1
            text = text//table_row(keys(k))
         end do
      end do
   end function reference_text

   !> Whether a group may be absent, and whether it repeats.
   pure function presence(group) result(text)
      type(group_t), intent(in) :: group
      character(:), allocatable :: text
      text = 'Optional'
      if (group%presence == is_required) text = 'Must be given'
      if (group%presence == is_assumed) text = 'Where it is absent, its defaults hold'
      if (group%repeats) text = text//'; may stand several times'
      if (group%is_apart) text = text//'; requires other choices than the examples here'
      text = text//'.'
   end function presence

   !> A group with its required keys, and keys whose example differs from the default, as code.
   pure function example(group) result(text)
      integer, intent(in) :: group               !! row of the group
      character(:), allocatable :: text
      integer :: k
      text = line('```fortran')//line('&'//trim(groups(group)%name))
      do k = first_key(group), first_key(group) + key_count(group) - 1
         if (keys(k)%example /= '') text = text//line('   '//trim(keys(k)%name)//' ='//example_list(keys(k), .true.))
      end do
      text = text//line('/')//line('```')
   end function example

   !> A key's row of the table.
   pure function table_row(key) result(text)
      type(key_t), intent(in) :: key
      character(:), allocatable :: text, default, allowed
      allowed = allowed_text(key, '`', ', ')
      if (allowed == '') allowed = 'any'
      default = 'none'
      if (key%default /= '') default = '`'//trim(adjustl(example_list(key, .false.)))//'`'
      if (key%required) default = 'must be given'
      text = line('| `'//trim(key%name)//'` | '//number_and_type(key)//' | '//trim(key%unit)//' | '//default//' | '// &
                  allowed//' | '//trim(key%meaning)//' |')
   end function table_row

   !> How many values of which type: `real`, `2 integers`, `0 to 10 reals`.
   pure function number_and_type(key) result(text)
      type(key_t), intent(in) :: key
      character(:), allocatable :: text
      text = 'real'
      if (key%value_type == type_integer) text = 'integer'
      if (key%value_type == type_logical) text = 'logical'
      if (is_text(key)) text = 'text'
      if (key%most > 1) text = to_text(key%most)//' '//text//'s'
      if (key%fewest < key%most) text = to_text(key%fewest)//' to '//text
   end function number_and_type

   !> All groups and keys as JSON.
   pure function keys_json() result(text)
      character(:), allocatable :: text, list
      integer :: g, k
      text = ''
      do g = 1, size(groups)
         list = ''
         do k = first_key(g), first_key(g) + key_count(g) - 1
            list = list//item(new_line('a')//'  '//key_json(keys(k)))
         end do
         text = text//item(new_line('a')//' '//object(member('group', trim(groups(g)%name))// &
            member('meaning', trim(groups(g)%meaning))//member('required', groups(g)%presence == is_required)// &
            member('assumed', groups(g)%presence == is_assumed)//member('repeats', groups(g)%repeats)// &
            member('keys', array(list), raw=.true.)))
      end do
      text = line(array(text))
   end function keys_json

   !> A key as JSON: its `type`, number of values, and their range: an interval `allowed`, or `choices`; `also` has its common
   !> names.
   pure function key_json(key) result(json)
      type(key_t), intent(in) :: key
      character(:), allocatable :: json, list
      character(name_len), allocatable :: names(:)
      integer :: k
      json = 'real'
      if (key%value_type == type_integer) json = 'integer'
      if (key%value_type == type_logical) json = 'logical'
      if (is_text(key)) json = 'text'
      json = member('key', trim(key%name))//member('type', json)//member('fewest', key%fewest)//member('most', key%most)// &
             member('required', key%required)//member('default', values_json(key, .false.), raw=.true.)// &
             member('example', values_json(key, .true.), raw=.true.)//member('unit', trim(key%unit))
      if (is_text(key)) then
         call choices(key, names)
         list = ''
         do k = 1, size(names)
            list = list//item(json_of(trim(names(k))))
         end do
         if (size(names) > 0) json = json//member('choices', array(list), raw=.true.)
      else if (key%value_type /= type_logical) then
         json = json//member('allowed', trim(key%allowed))
      end if
      if (key%also /= '') json = json//member('also', trim(key%also))
      json = object(json//member('meaning', trim(key%meaning)))
   end function key_json

   !> The default of a key, or its value in the template: a list if several are allowed, null if there is none.
   pure function values_json(key, as_example) result(json)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      character(:), allocatable :: json, value
      integer :: i
      json = ''
      do i = 1, default_count(key, as_example)
         value = default_value(key, as_example, i)
         if (is_text(key)) then
            value = json_of(value)
         else if (key%value_type == type_logical) then
            value = json_of(value == '.true.')
         end if
         json = json//item(value)
      end do
      json = array(json)
      if (key%most == 1) json = json(2:len(json) - 1)
      if (len(json) == 0 .or. (key%required .and. .not. as_example)) json = json_null
   end function values_json

   !> A text with a capital letter at its beginning and a full stop.
   pure function sentence(text)
      character(*), intent(in) :: text
      character(:), allocatable :: sentence
      sentence = achar(iachar(text(1:1)) - iachar('a') + iachar('A'))//text(2:)//'.'
   end function sentence
end module hampm_key_reference
