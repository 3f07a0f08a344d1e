!> A text that is read from its beginning to its end: the next character, word or name, and the line it is on.
module hampm_scanner
   use hampm_text, only: to_text, lower_case, printable, is_letter, is_digit
   implicit none
   private
   public :: scanner_t, blanks, line_feed, peek, at_end, advance, skip_blanks, take_word, skip_word, take_name, &
             is_name_character, location, excerpt

   character, parameter :: line_feed = achar(10)
   character(*), parameter :: blanks = ' '//achar(9)//achar(13)//line_feed
   character(*), parameter :: ends_word = blanks//',/!=''"&'   !! what a word without quotes cannot hold

   !> A text, and where its reader stands.
   type :: scanner_t
      character(:), allocatable :: text
      character(:), allocatable :: source          !! path of the file, or the option on the command line
      logical :: counts_lines = .true.             !! whether locations carry a line number
      integer :: at = 1                            !! position in `text`
      integer :: line = 1
   end type scanner_t

contains

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

   !> Go on by a character, unless nothing is left.
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

   !> Where the scanner stands: `case.nml:12`.
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
end module hampm_scanner
