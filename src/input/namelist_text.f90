!> Models as namelist text: the template with every key, and the canonical text of the settings.
module hampm_namelist_text
   use hampm_kinds, only: ndim
   use hampm_key_rows, only: group_t, key_t, type_integer, type_logical, is_required
   use hampm_keys, only: groups, keys, first_key, key_count, allowed_text, default_count, default_value, is_text
   use hampm_settings, only: settings_t, setting_t
   use hampm_text, only: append, to_text
   use hampm_version, only: program_name
   implicit none
   private
   public :: template_text, canonical_text, example_list

   character, parameter :: line_feed = new_line('a')
   integer, parameter :: comment_column = 48       !! column of the comments of the template

contains

   !> A complete, commented namelist: every group and key with unit, range, default and meaning. It is a model that runs; groups not
   !> allowed with the others are comments.
   pure function template_text() result(text)
      character(:), allocatable :: text, start
      integer :: g, k
      text = '! A model for '//program_name//', with every group and key. Numbers are in SI units. '// &
             'A comment gives: meaning [unit];'//line_feed &
             //'! what is allowed; the default. Keys and groups may stand in any order.'//line_feed
      do g = 1, size(groups)
         start = ''
         if (groups(g)%is_apart) start = '! '
         text = text//line_feed//start//'&'//trim(groups(g)%name)//'  ! '//trim(groups(g)%meaning)//group_note(groups(g))//line_feed
         do k = first_key(g), first_key(g) + key_count(g) - 1
            text = text//start//template_line(keys(k))//line_feed
         end do
         text = text//start//'/'//line_feed
      end do
   end function template_text

   !> How often a group stands in a model.
   pure function group_note(group) result(note)
      type(group_t), intent(in) :: group
      character(:), allocatable :: note
      note = ' ('
      if (group%presence == is_required) note = note//'required'
      if (group%presence /= is_required) note = note//'optional'
      if (group%repeats) note = note//', may stand several times'
      note = note//')'
   end function group_note

   !> One key of the template: `   young = 70e9   ! Young's modulus [Pa]; (0, inf); required`.
   pure function template_line(key) result(line)
      type(key_t), intent(in) :: key
      character(:), allocatable :: line, allowed
      allowed = allowed_text(key, '', ' | ')
      if (allowed == '') allowed = 'text'
      if (key%value_type == type_integer) allowed = 'integer in '//allowed
      line = '   '//trim(key%name)//' ='//example_list(key, .true.)
      line = line//repeat(' ', max(comment_column - len(line), 1))//' ! '//trim(key%meaning)
      if (key%unit /= '') line = line//' ['//trim(key%unit)//']'
      line = line//'; '//allowed
      if (key%required) then
         line = line//'; required'
      else if (key%default /= '') then
         line = line//'; default'//example_list(key, .false.)
      end if
   end function template_line

   !> The values of a key in the template or its defaults, each behind a blank.
   pure function example_list(key, as_example) result(text)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, default_count(key, as_example)
         if (i > 1) text = text//','
         if (is_text(key)) text = text//' '//in_quotes(default_value(key, as_example, i))
         if (.not. is_text(key)) text = text//' '//default_value(key, as_example, i)
      end do
   end function example_list

   !> The complete namelist of a validated model, every key with its effective value. It reads back as the same model.
   pure function canonical_text(settings) result(text)
      type(settings_t), intent(in) :: settings
      character(:), allocatable :: text
      integer :: g, entry, k, length
      length = 0
      allocate (character(4096) :: text)
      do g = 1, size(groups)
         do entry = 1, settings%count
            if (settings%entries(entry)%group /= g) cycle
            call append(text, length, '&'//trim(groups(g)%name)//line_feed)
            do k = 1, key_count(g)
               if (ndim > 2 .and. any(keys(first_key(g) + k - 1)%name == [character(9) :: 'plane', 'thickness'])) cycle ! of planes
               call append_key(text, length, keys(first_key(g) + k - 1), settings%entries(entry)%settings(k))
            end do
            call append(text, length, '/'//line_feed)
         end do
      end do
      text = text(:length)
   end function canonical_text

   !> Add one key to the canonical text: `   young = 7.0e10`.
   pure subroutine append_key(text, length, key, setting)
      character(:), allocatable, intent(inout) :: text
      integer, intent(inout) :: length
      type(key_t), intent(in) :: key
      type(setting_t), intent(in) :: setting
      integer :: i
      call append(text, length, '   '//trim(key%name)//' =')
      do i = 1, setting%count
         if (i > 1) call append(text, length, ',')
         if (is_text(key)) then
            call append(text, length, ' '//in_quotes(setting%values(i)%text))
         else if (key%value_type == type_logical) then
            call append(text, length, ' '//trim(merge('.true. ', '.false.', setting%numbers(i) > 0)))
         else if (key%value_type == type_integer) then
            call append(text, length, ' '//to_text(nint(setting%numbers(i))))
         else
            call append(text, length, ' '//to_text(setting%numbers(i)))
         end if
      end do
      call append(text, length, line_feed)
   end subroutine append_key

   !> Text in quotes, quotes in it doubled.
   pure function in_quotes(text) result(quoted)
      character(*), intent(in) :: text
      character(:), allocatable :: quoted
      integer :: i
      quoted = ''''
      do i = 1, len(text)
         quoted = quoted//text(i:i)
         if (text(i:i) == '''') quoted = quoted//''''
      end do
      quoted = quoted//''''
   end function in_quotes
end module hampm_namelist_text
