!> Namelist syntax: `&group key = value, value ... /`. The compiler's own namelist reader passes over misspelt groups and
!> half of a group where its `/` is missing without a word; this scanner reports every error, with its line.
!>
!> A text read from its beginning to its end: the next character, word or name, and its line.
module hampm_namelist_file
   use hampm_failure, only: failure_t, exit_input, exit_file
   use hampm_key_rows, only: max_values
   use hampm_kinds, only: dp
   use hampm_keys, only: groups, find_group, find_key, unknown_group, unknown_key, new_entry
   use hampm_settings, only: setting_t, group_entry_t, settings_t, input_errors_t
   use hampm_text, only: to_text, lower_case, printable, is_letter, is_digit
   use hampm_values, only: parse_integer
   implicit none
   private
   public :: read_text, scan_namelist, scan_value_text

   character, parameter :: line_feed = achar(10)
   character(*), parameter :: blanks = ' '//achar(9)//achar(13)//line_feed
   character(*), parameter :: ends_word = blanks//',/!=''"&'   !! ends of words without quotes

   !> A text, and where its reader stands.
   type :: scanner_t
      character(:), allocatable :: text
      character(:), allocatable :: source          !! path of the file, or the option on the command line
      logical :: counts_lines = .true.             !! whether locations carry a line number
      integer :: at = 1                            !! position in `text`
      integer :: line = 1
   end type scanner_t

   integer, parameter :: most_bytes = 2**22        !! longer than any input file
   integer, parameter :: most_groups = 10000
   integer, parameter :: most_errors = 1000        !! more than anybody reads: the rest of the file is passed over

contains

   !> The bytes of a file. Fails where it cannot be read or is far too long.
   !> They are read one by one: that serves pipes, which have no size, as well.
   subroutine read_text(path, text, failure)
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: text
      type(failure_t), intent(inout) :: failure
      integer :: unit, status, n
      character(256) :: reason
      character(:), allocatable :: buffer
      character :: byte
      text = ''
      if (len_trim(path) < len(path)) then       ! Fortran would omit it
         call failure%report(exit_file, path//': cannot be read: its name ends with a blank')
         return
      end if
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', &
            iostat=status, iomsg=reason)
      if (status /= 0) then
         call failure%report(exit_file, path//': cannot be read: '//trim(reason))
         return
      end if
      allocate (character(4096) :: buffer)
      n = 0
      do
         read (unit, iostat=status, iomsg=reason) byte
         if (status /= 0 .or. n == most_bytes) exit
         if (n == len(buffer)) buffer = buffer//repeat(' ', n)
         n = n + 1
         buffer(n:n) = byte
      end do
      close (unit)
      text = buffer(:n)
      if (index(text, char(137)//'HDF') == 1) then
         call failure%report(exit_input, path//': is a file of HDF5, no namelist: a result keeps its model as the text '// &
                             '/input/namelist, which `h5dump -d /input/namelist` prints; --resume goes on from a checkpoint')
         return
      end if
      if (index(text, achar(0)) > 0) call failure%report(exit_input, path//': is no text file: it has bytes of value 0')
      if (status == 0) call failure%report(exit_input, path//': is longer than '//to_text(most_bytes)//' bytes: no namelist file')
      if (status > 0) call failure%report(exit_file, path//': cannot be read: '//trim(reason))
   end subroutine read_text

   !> The groups of a namelist text.
   pure subroutine scan_namelist(path, text, settings)
      character(*), intent(in) :: path             !! for messages
      character(*), intent(in) :: text
      type(settings_t), intent(inout) :: settings
      type(scanner_t) :: s
      s%text = text
      s%source = path
      if (index(text, char(239)//char(187)//char(191)) == 1) s%at = 4   ! byte order mark of UTF-8
      do
         call skip_blanks(s)
         if (at_end(s) .or. settings%errors%count > most_errors) exit
         if (settings%count == most_groups) then
            call settings%errors%add('there may be at most '//to_text(most_groups)//' groups', location(s))
            exit
         end if
         if (peek(s) == '&') then
            call scan_group(s, settings)
         else
            call settings%errors%add(excerpt(s)//' stands outside of the groups (a group is &name key = value /)', location(s))
            do while (.not. at_end(s) .and. peek(s) /= '&')
               call advance(s)
               call skip_blanks(s)
            end do
         end if
      end do
   end subroutine scan_namelist

   !> The values of one key, given without a file.
   pure subroutine scan_value_text(source, text, group, setting, errors)
      character(*), intent(in) :: source           !! location of the text, for messages
      character(*), intent(in) :: text
      integer, intent(in) :: group
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      type(scanner_t) :: s
      s%text = text
      s%source = source
      s%counts_lines = .false.
      call scan_values(s, group, setting, errors)
      if (at_end(s)) return
      setting%good = .false.
      call errors%add(excerpt(s)//' is no value', source)
   end subroutine scan_value_text

   !> One group, from its `&` to its `/`.
   pure subroutine scan_group(s, settings)
      type(scanner_t), intent(inout) :: s
      type(settings_t), intent(inout) :: settings
      character(:), allocatable :: name, start
      type(group_entry_t) :: entry
      logical :: ended
      integer :: group, earlier
      start = location(s)
      call advance(s)
      call take_name(s, name)
      group = find_group(name)
      if (group == 0) then
         call settings%errors%add(unknown_group(name), start, name, subject='')
         call skip_group(s)
         return
      end if
      entry = new_entry(group, start)
      do
         call check_end(s, start, name, settings%errors, ended)
         if (ended .or. settings%errors%count > most_errors) exit
         if (is_letter(peek(s))) then
            call scan_assignment(s, entry, settings%errors)
         else
            call settings%errors%add(excerpt(s)//' stands where a key is expected', location(s), name)
            call skip_word(s)
         end if
      end do
      if (.not. groups(group)%repeats) then
         earlier = settings%find(name, 1)
         if (earlier > 0) then
            call settings%errors%add('&'//name//' stands a second time, it may only once (first: ' &
                                     //settings%entries(earlier)%location//')', start, name, subject='')
            return
         end if
      end if
      call settings%add_entry(entry)
   end subroutine scan_group

   !> Whether the group is over: with its `/`, which is consumed, or because another group or the end of the file comes first.
   pure subroutine check_end(s, start, name, errors, ended)
      type(scanner_t), intent(inout) :: s
      character(*), intent(in) :: start, name
      type(input_errors_t), intent(inout) :: errors
      logical, intent(out) :: ended
      type(scanner_t) :: ahead
      character(:), allocatable :: next
      call skip_blanks(s)
      ended = .true.
      if (at_end(s)) then
         call errors%add('its ''/'' is missing: the file ends before', start, name)
      else if (peek(s) == '&') then
         ahead = s
         call advance(ahead)
         call take_name(ahead, next)
         if (next == 'end') then                 ! with which groups ended before Fortran 90
            call errors%add('a group ends with ''/'', not with ''&end''', location(s), name)
            s = ahead
         else
            call errors%add('its ''/'' is missing: line '//to_text(s%line)//' begins another group', start, name)
         end if
      else if (peek(s) == '/') then
         call advance(s)
      else
         ended = .false.
      end if
   end subroutine check_end

   !> `key = values`.
   pure subroutine scan_assignment(s, entry, errors)
      type(scanner_t), intent(inout) :: s
      type(group_entry_t), intent(inout) :: entry
      type(input_errors_t), intent(inout) :: errors
      character(:), allocatable :: name, start
      type(setting_t) :: setting
      integer :: key
      start = location(s)
      call take_name(s, name)
      key = find_key(entry%group, name)
      setting%given = .true.
      setting%location = start
      call take_equals(s, trim(entry%name), name, setting, errors)
      call scan_values(s, entry%group, setting, errors)
      if (key == 0) then
         call errors%add(unknown_key(entry%group, name), start, trim(entry%name), name, setting%shown(), subject='')
      else if (entry%settings(key)%given) then
         call errors%add('is given twice in this group (first: '//entry%settings(key)%location//')', start, trim(entry%name), name)
      else
         entry%settings(key) = setting
      end if
   end subroutine scan_assignment

   !> The `=` behind a key, past the subscript that some namelist files have there.
   pure subroutine take_equals(s, group, key, setting, errors)
      type(scanner_t), intent(inout) :: s
      character(*), intent(in) :: group, key       !! their names
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      call skip_blanks(s)
      if (peek(s) == '(' .or. peek(s) == '%') then
         setting%good = .false.
         call errors%add('subscripts and components are not read here; give all values as one list: key = 1.0, 2.0', &
                         setting%location, group, key)
         do while (.not. at_end(s) .and. index('=/&'//line_feed, peek(s)) == 0)
            call advance(s)
         end do
      else if (peek(s) /= '=') then
         setting%good = .false.
         call errors%add('''='' is missing behind the key', setting%location, group, key)
      end if
      if (peek(s) == '=') call advance(s)
   end subroutine take_equals

   !> The values behind a `=`, up to the next key or the end of the group. Where none stands before a comma, there is a null value.
   pure subroutine scan_values(s, group, setting, errors)
      type(scanner_t), intent(inout) :: s
      integer, intent(in) :: group
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      logical :: after_comma
      after_comma = .true.
      do
         call skip_blanks(s)
         if (at_end(s)) exit
         if (index('/&=', peek(s)) > 0 .or. key_ahead(s, group)) exit
         if (peek(s) == ',') then
            if (after_comma) call setting%append('', .false.)
            after_comma = .true.
            call advance(s)
         else
            after_comma = .false.
            call scan_value(s, setting, errors)
         end if
      end do
   end subroutine scan_values

   !> One value: a word, a quoted text, or a repeat such as `3*0.0`, or `3*` of null values.
   pure subroutine scan_value(s, setting, errors)
      type(scanner_t), intent(inout) :: s
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      character(:), allocatable :: start, word, value
      logical :: quoted
      integer :: star, times, i
      start = location(s)
      call take_word(s, word)
      star = scan(word, '*')
      times = 1
      if (star == 1) star = 0
      if (star > 1) times = repeat_count(word(:star - 1))
      if (times == 0) then
         setting%good = .false.
         call errors%add(printable(word, 40)//': the count of a repeat must be an integer in [1, '//to_text(max_values)//']', start)
         times = 1
      end if
      value = word(star + 1:)
      quoted = len(value) == 0 .and. index('''"', peek(s)) > 0
      if (quoted) then
         call take_quoted(s, value, setting, errors)
      end if
      do i = 1, times
         call setting%append(value, quoted)
      end do
   end subroutine scan_value

   !> The number before the `*` of a repeat, 0 if it is not allowed.
   pure integer function repeat_count(digits)
      character(*), intent(in) :: digits
      real(dp) :: number
      integer :: status
      call parse_integer(digits, number, status)
      repeat_count = 0
      if (verify(digits, '0123456789') == 0 .and. number <= max_values) repeat_count = nint(number)
   end function repeat_count

   !> The text between quotes; a doubled quote is a quote.
   pure subroutine take_quoted(s, text, setting, errors)
      type(scanner_t), intent(inout) :: s
      character(:), allocatable, intent(out) :: text
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      character(:), allocatable :: start
      character :: quote
      integer :: last, n
      start = location(s)
      quote = peek(s)
      call advance(s)
      text = repeat(' ', 80)
      n = 0
      do
         if (at_end(s) .or. peek(s) == line_feed) exit
         if (peek(s) == quote) then
            call advance(s)
            if (peek(s) /= quote) then
               text = text(:n)
               return
            end if
         end if
         if (n == len(text)) text = text//repeat(' ', n)
         n = n + 1
         text(n:n) = peek(s)
         call advance(s)
      end do
      text = text(:n)
      setting%good = .false.
      call errors%add('the closing '//quote//' of '//quote//printable(text, 40)//' is missing on this line', start)
      ! The '/' at the end of such a line was meant to end the group, most likely.
      last = len_trim(s%text(:s%at - 1))
      if (s%text(last:last) == '/') s%at = last
   end subroutine take_quoted

   !> Whether a key comes next: a name before `=`, `(` or `%`, or the name of a key of this group that lacks its `=`.
   pure logical function key_ahead(s, group)
      type(scanner_t), intent(in) :: s
      integer, intent(in) :: group
      integer :: i, j
      key_ahead = .false.
      if (.not. is_letter(peek(s))) return
      do i = s%at, len(s%text) - 1
         if (.not. is_name_character(s%text(i + 1:i + 1))) exit
      end do
      i = min(i, len(s%text))
      j = verify(s%text(i + 1:), blanks)
      if (j > 0) key_ahead = index('=(%', s%text(i + j:i + j)) > 0
      if (key_ahead .or. i - s%at > 64) return
      if (j > 1) key_ahead = find_key(group, lower_case(s%text(s%at:i))) > 0
   end function key_ahead

   !> Pass over the rest of a group whose name is unknown.
   pure subroutine skip_group(s)
      type(scanner_t), intent(inout) :: s
      type(setting_t) :: ignored
      type(input_errors_t) :: nobody
      logical :: ended
      do
         call check_end(s, '', '', nobody, ended)
         if (ended) return
         if (index('''"', peek(s)) > 0) then
            call scan_value(s, ignored, nobody)
         else
            call skip_word(s)
         end if
      end do
   end subroutine skip_group

   !> Pass over blanks, ends of lines and comments.
   pure subroutine skip_blanks(s)
      type(scanner_t), intent(inout) :: s
      logical :: comment
      comment = .false.
      do while (.not. at_end(s))
         if (peek(s) == '!') comment = .true.
         if (peek(s) == line_feed) comment = .false.
         if (.not. comment .and. index(blanks, peek(s)) == 0) return
         call advance(s)
      end do
   end subroutine skip_blanks

   !> The characters up to the end of a word; none where the next character cannot begin one.
   pure subroutine take_word(s, word)
      type(scanner_t), intent(inout) :: s
      character(:), allocatable, intent(out) :: word
      integer :: n
      n = scan(s%text(s%at:), ends_word) - 1
      if (n < 0) n = len(s%text) - s%at + 1
      word = s%text(s%at:s%at + n - 1)
      s%at = s%at + n
   end subroutine take_word

   !> Pass over a word, or over one character that cannot begin a word.
   pure subroutine skip_word(s)
      type(scanner_t), intent(inout) :: s
      character(:), allocatable :: word
      call take_word(s, word)
      if (len(word) == 0) call advance(s)
   end subroutine skip_word

   !> The name that comes next, in lower case.
   pure subroutine take_name(s, name)
      type(scanner_t), intent(inout) :: s
      character(:), allocatable, intent(out) :: name
      integer :: begin
      begin = s%at
      do while (.not. at_end(s) .and. is_name_character(peek(s)))
         call advance(s)
      end do
      name = lower_case(s%text(begin:s%at - 1))
   end subroutine take_name

   !> The next character; the end of a line at the end of the text.
   pure character function peek(s)
      type(scanner_t), intent(in) :: s
      peek = line_feed
      if (s%at <= len(s%text)) peek = s%text(s%at:s%at)
   end function peek

   !> Whether nothing is left.
   pure logical function at_end(s)
      type(scanner_t), intent(in) :: s
      at_end = s%at > len(s%text)
   end function at_end

   !> Advance by a character, unless at the end.
   pure subroutine advance(s)
      type(scanner_t), intent(inout) :: s
      if (at_end(s)) return
      if (peek(s) == line_feed) s%line = s%line + 1
      s%at = s%at + 1
   end subroutine advance

   !> Whether a character may be part of the name of a group or key.
   pure logical function is_name_character(c)
      character, intent(in) :: c
      is_name_character = is_letter(c) .or. is_digit(c) .or. c == '_'
   end function is_name_character

   !> Location of the scanner: `case.nml:12`.
   pure function location(s)
      type(scanner_t), intent(in) :: s
      character(:), allocatable :: location
      location = s%source
      if (s%counts_lines) location = location//':'//to_text(s%line)
   end function location

   !> The text that comes next, for messages.
   pure function excerpt(s) result(text)
      type(scanner_t), intent(in) :: s
      character(:), allocatable :: text
      integer :: n
      text = s%text(s%at:min(s%at + 60, len(s%text)))
      n = scan(text//line_feed, achar(13)//line_feed) - 1
      text = ''''//printable(text(:n), 40)//''''
   end function excerpt
end module hampm_namelist_file
