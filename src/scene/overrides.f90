!> `--set group.key=value`: values from the command line that replace those in the file.
module hampm_overrides
   use hampm_key_rows, only: key_t, max_values
   use hampm_keys, only: groups, keys, find_group, find_key, first_key, unknown_group, unknown_key, is_text, new_entry
   use hampm_namelist_file, only: scan_value_text
   use hampm_settings, only: settings_t, setting_t, group_entry_t, mistakes_t
   use hampm_text, only: to_text, lower_case, printable
   implicit none
   private
   public :: override

contains

   !> Apply one override, `group.key=value` or `group(2).key=value` for the second group of a name.
   !> A group that the file does not have is added.
   pure subroutine override(text, settings)
      character(*), intent(in) :: text
      type(settings_t), intent(inout) :: settings
      character(:), allocatable :: source, name, message
      type(setting_t) :: setting
      integer :: equals, dot, group, key, instance, entry
      source = '--set '//printable(text, 60)
      equals = index(text, '=')
      dot = index(text(:max(equals, 1)), '.')
      if (equals < 2 .or. dot < 2) then
         call settings%mistakes%add(source// &
                                    ': must have the form group.key=value, or group(2).key=value for the second of its name')
         return
      end if
      call split_instance(trim(adjustl(text(:dot - 1))), name, instance)
      group = find_group(name)
      if (group == 0) then
         call settings%mistakes%add(source//': '//unknown_group(name))
         return
      end if
      name = lower_case(trim(adjustl(text(dot + 1:equals - 1))))
      key = find_key(group, name)
      if (key == 0) then
         call settings%mistakes%add(source//': '//unknown_key(group, name))
         return
      end if
      call choose_entry(settings, group, instance, source, entry, message)
      if (message /= '') then
         call settings%mistakes%add(source//': '//message)
         return
      end if
      setting%given = .true.
      setting%location = source
      call take_values(keys(first_key(group) + key - 1), text(equals + 1:), group, setting, settings%mistakes)
      settings%entries(entry)%settings(key) = setting
   end subroutine override

   !> Split `group(2)` into name and number; the number is 0 where there is none and -1 where it is wrong.
   pure subroutine split_instance(text, name, instance)
      character(*), intent(in) :: text
      character(:), allocatable, intent(out) :: name
      integer, intent(out) :: instance
      character(:), allocatable :: digits
      integer :: bracket
      bracket = index(text, '(')
      instance = 0
      name = lower_case(text)
      if (bracket == 0) return
      name = lower_case(trim(text(:bracket - 1)))
      digits = text(bracket + 1:max(len(text) - 1, bracket))
      instance = -1
      if (len(digits) < 1 .or. len(digits) > 6 .or. verify(digits, '0123456789') > 0) return
      if (text(len(text):) /= ')') return
      read (digits, '(i6)') instance
      if (instance == 0) instance = -1
   end subroutine split_instance

   !> The group that is meant; it is added where the scene has none of this name.
   pure subroutine choose_entry(settings, group, instance, source, entry, message)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: group, instance
      character(*), intent(in) :: source
      integer, intent(out) :: entry
      character(:), allocatable, intent(out) :: message   !! what is wrong, '' for nothing
      type(group_entry_t) :: added
      character(:), allocatable :: name
      integer :: present
      name = trim(groups(group)%name)
      present = settings%count_of(name)
      message = ''
      entry = 0
      if (instance == -1) then
         message = 'the number of a group must be an integer in [1, inf): '//name//'(2)'
      else if (instance > max(present, 1)) then
         message = 'there is no &'//name//'('//to_text(instance)//'), the number of &'//name//' is '//to_text(present)
      else if (instance == 0 .and. present > 1) then
         message = 'there are '//to_text(present)//' of &'//name//': say which, for example '//name//'(2)'
      else if (present == 0) then
         added = new_entry(group, source)
         call settings%add_entry(added)
         entry = settings%count
      else
         entry = settings%find(name, max(instance, 1))
      end if
   end subroutine choose_entry

   !> The values behind the `=`. Quotes may be missing, since a shell takes them away.
   pure subroutine take_values(key, text, group, setting, mistakes)
      type(key_t), intent(in) :: key
      character(*), intent(in) :: text
      integer, intent(in) :: group
      type(setting_t), intent(inout) :: setting
      type(mistakes_t), intent(inout) :: mistakes
      integer :: i
      if (is_text(key) .and. key%most == 1 .and. scan(adjustl(text//' '), '''"') /= 1) then
         call setting%append(trim(adjustl(text)), .true.)
      else
         call scan_value_text(setting%location, text, group, setting, mistakes)
         do i = 1, min(setting%count, max_values)
            setting%values(i)%quoted = setting%values(i)%quoted .or. is_text(key)
         end do
      end if
   end subroutine take_values
end module hampm_overrides
