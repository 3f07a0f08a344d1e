!> JSON for programs that read the output of hampm: values as text, members and items, the parts of objects and arrays.
module hampm_json
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use hampm_kinds, only: dp
   use hampm_text, only: to_text
   implicit none
   private
   public :: json_of, member, item, object, array, message_record, json_null

   character(*), parameter :: json_null = 'null', separator = ', '

   !> A value as JSON: a text in quotes, a number (null where it is not finite) or a truth value.
   interface json_of
      procedure :: text_value, real_value, integer_value, logical_value
   end interface json_of

   !> A member of an object, behind a comma. A value that is JSON already goes through `raw`.
   interface member
      procedure :: text_member, real_member, integer_member, logical_member
   end interface member

contains

   !> A text in quotes.
   pure function text_value(text) result(json)
      character(*), intent(in) :: text
      character(:), allocatable :: json
      character(:), allocatable :: quoted        ! one copy, however long the text is
      integer :: i, n
      allocate (character(6*len(text) + 1) :: quoted)
      quoted(1:1) = '"'
      n = 1
      do i = 1, len(text)
         select case (iachar(text(i:i)))
          case (34, 92)                          ! the quote and the backslash
            quoted(n + 1:n + 2) = '\'//text(i:i)
            n = n + 2
          case (0:31)
            write (quoted(n + 1:n + 6), '(a, z4.4)') '\u', iachar(text(i:i))
            n = n + 6
          case default
            quoted(n + 1:n + 1) = text(i:i)
            n = n + 1
         end select
      end do
      json = quoted(:n)//'"'
   end function text_value

   !> A real number.
   pure function real_value(number) result(json)
      real(dp), intent(in) :: number
      character(:), allocatable :: json
      json = json_null
      if (ieee_is_finite(number)) json = to_text(number)
   end function real_value

   !> A whole number.
   pure function integer_value(number) result(json)
      integer, intent(in) :: number
      character(:), allocatable :: json
      json = to_text(number)
   end function integer_value

   !> A truth value.
   pure function logical_value(truth) result(json)
      logical, intent(in) :: truth
      character(:), allocatable :: json
      json = trim(merge('true ', 'false', truth))
   end function logical_value

   !> A member whose value is a text, or with `raw` JSON.
   pure function text_member(name, text, raw) result(json)
      character(*), intent(in) :: name, text
      logical, intent(in), optional :: raw       !! whether it is JSON already
      character(:), allocatable :: json
      json = text_value(text)
      if (present(raw)) json = text
      json = item(text_value(name)//': '//json)
   end function text_member

   !> A member whose value is a real number.
   pure function real_member(name, number) result(json)
      character(*), intent(in) :: name
      real(dp), intent(in) :: number
      character(:), allocatable :: json
      json = text_member(name, real_value(number), raw=.true.)
   end function real_member

   !> A member whose value is a whole number.
   pure function integer_member(name, number) result(json)
      character(*), intent(in) :: name
      integer, intent(in) :: number
      character(:), allocatable :: json
      json = text_member(name, to_text(number), raw=.true.)
   end function integer_member

   !> A member whose value is a truth value.
   pure function logical_member(name, truth) result(json)
      character(*), intent(in) :: name
      logical, intent(in) :: truth
      character(:), allocatable :: json
      json = text_member(name, logical_value(truth), raw=.true.)
   end function logical_member

   !> An item of an array, behind a comma.
   pure function item(json)
      character(*), intent(in) :: json
      character(:), allocatable :: item
      item = separator//json
   end function item

   !> An object of members.
   pure function object(members) result(json)
      character(*), intent(in) :: members
      character(:), allocatable :: json
      json = '{'//members(len(separator) + 1:)//'}'
   end function object

   !> An array of items, a line each.
   pure function array(items) result(json)
      character(*), intent(in) :: items
      character(:), allocatable :: json
      json = '['//items(len(separator) + 1:)//']'
   end function array

   !> A message on a model as an item: `file` and `line` or `option`, `group`, `key`, `value` and `reason`, where known.
   pure function message_record(reason, location, group, key, value) result(json)
      character(*), intent(in) :: reason
      character(*), intent(in) :: location       !! 'case.nml:12', 'case.nml', '--set group.key=value' or 'chosen for ...'
      character(*), intent(in) :: group, key, value
      character(:), allocatable :: json
      integer :: colon
      colon = index(location, ':', back=.true.)
      if (colon > 0) then
         if (verify(location(colon + 1:), '0123456789') > 0 .or. colon == len(location)) colon = 0
      end if
      if (index(location, '--') == 1 .or. index(location, 'chosen for') == 1) then
         json = member('option', location)
      else if (colon > 0) then
         json = member('file', location(:colon - 1))//member('line', location(colon + 1:), raw=.true.)
      else
         json = known('file', location)
      end if
      json = item(object(json//known('group', group)//known('key', key)//known('value', value)//member('reason', reason)))

   contains

      !> A member, unless there is no text.
      pure function known(name, text) result(json)
         character(*), intent(in) :: name, text
         character(:), allocatable :: json
         json = ''
         if (text /= '') json = member(name, text)
      end function known
   end function message_record
end module hampm_json
