!> Numbers as text, names without regard to case, the name that a misspelt word was meant to be.
module hampm_text
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use hampm_kinds, only: dp, long, name_len
   implicit none
   private
   public :: string_t, to_text, lower_case, nearest_name, printable, did_you_mean, is_letter, is_digit, decimal, &
             line, paragraph, add_line, append, joined, three_digits, digits_text, without_rounding, point_text, length_text

   integer, parameter :: widest = 118              !! characters in a line of a paragraph

   !> Text of any length, so that arrays may hold texts of different lengths.
   type :: string_t
      character(:), allocatable :: text
   end type string_t

   !> Shortest text that reads back as the same number.
   interface to_text
      procedure :: integer_text, long_text, real_text
   end interface to_text

contains

   !> Add a part to the text of a buffer, which doubles where it is full: a long text is not copied for each part.
   pure subroutine append(buffer, length, part)
      character(:), allocatable, intent(inout) :: buffer
      integer, intent(inout) :: length             !! of the text in it
      character(*), intent(in) :: part
      character(:), allocatable :: longer
      if (length + len(part) > len(buffer)) then
         allocate (character(2*len(buffer) + len(part)) :: longer)
         longer(:length) = buffer(:length)
         call move_alloc(longer, buffer)
      end if
      buffer(length + 1:length + len(part)) = part
      length = length + len(part)
   end subroutine append

   !> A text as a line.
   pure function line(text)
      character(*), intent(in) :: text
      character(:), allocatable :: line
      line = text//new_line('a')
   end function line

   !> A text as lines that are no longer than `widest` where it has blanks outside of code, which is between backticks.
   pure function paragraph(text, indent) result(lines)
      character(*), intent(in) :: text
      integer, intent(in) :: indent                !! blanks before every line but the first
      character(:), allocatable :: lines
      integer :: from, last, k, margin
      logical :: in_code
      lines = ''
      from = 1
      last = 0                                     ! the last blank at which the line may end
      margin = 0
      in_code = .false.
      do k = 1, len(text) + 1
         if (k <= len(text)) then
            if (text(k:k) == '`') in_code = .not. in_code
            if (in_code .or. text(k:k) /= ' ') cycle
         end if
         if (k - from + margin > widest .and. last > from) then
            lines = lines//line(repeat(' ', margin)//text(from:last - 1))
            from = last + 1
            margin = indent
         end if
         last = k
      end do
      lines = lines//line(repeat(' ', margin)//text(from:))
   end function paragraph

   !> An integer as text, without blanks.
   pure function integer_text(number) result(text)
      integer, intent(in) :: number
      character(:), allocatable :: text
      text = long_text(int(number, long))
   end function integer_text

   !> The same of a long one.
   pure function long_text(number) result(text)
      integer(long), intent(in) :: number
      character(:), allocatable :: text
      character(24) :: buffer
      write (buffer, '(i0)') number
      text = trim(buffer)
   end function long_text

   !> Shortest decimal text that reads back as the same number: `0.00125`, `7.0e10`.
   pure function real_text(number) result(text)
      real(dp), intent(in) :: number
      character(:), allocatable :: text, digits, sign
      character(32) :: buffer, form
      real(dp) :: back
      integer :: decimals, least, exponent, mark
      text = 'nan'
      if (ieee_is_nan(number)) return
      sign = ''
      if (number < 0) sign = '-'
      text = sign//'inf'
      if (.not. ieee_is_finite(number)) return
      least = merge(14, 0, abs(number) >= tiny(number))  ! 15 digits end in zeros where fewer digits are exact, unless denormal
      if (abs(number) > 0.5_dp*huge(number)) least = 16  ! rounded up, it would overflow
      do decimals = least, 16
         write (form, '(a,i0,a)') '(es32.', decimals, 'e3)'
         write (buffer, form) abs(number)
         read (buffer, '(f32.0)') back
         if (abs(back - abs(number)) <= 0) exit
      end do
      buffer = adjustl(buffer)
      mark = index(buffer, 'E')
      read (buffer(mark + 1:mark + 4), '(i4)') exponent
      digits = buffer(1:1)//buffer(3:mark - 1)
      text = sign//decimal_text(digits(:max(1, verify(digits, '0', back=.true.))), exponent)
   end function real_text

   !> The number d.ddd * 10**exponent, as `0.00ddd`, `ddd.d` or `d.ddde12`, whichever reads best.
   pure function decimal_text(digits, exponent) result(text)
      character(*), intent(in) :: digits           !! significant digits, the first stands before the point
      integer, intent(in) :: exponent
      character(:), allocatable :: text
      integer :: whole
      whole = exponent + 1
      if (exponent >= -3 .and. exponent < 0) then
         text = '0.'//repeat('0', -whole)//digits
      else if (exponent >= 0 .and. exponent <= 5) then
         if (len(digits) > whole) then
            text = digits(:whole)//'.'//digits(whole + 1:)
         else
            text = digits//repeat('0', whole - len(digits))//'.0'
         end if
      else if (len(digits) == 1) then
         text = digits//'.0e'//integer_text(exponent)
      else
         text = digits(1:1)//'.'//digits(2:)//'e'//integer_text(exponent)
      end if
   end function decimal_text

   !> Text with small letters for capital ones; other characters stay.
   pure function lower_case(text) result(lower)
      character(*), intent(in) :: text
      character(len(text)) :: lower
      integer :: i
      do i = 1, len(text)
         lower(i:i) = text(i:i)
         if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lower(i:i) = achar(iachar(text(i:i)) + 32)
      end do
   end function lower_case

   !> Whether a character is one of a to z or A to Z.
   elemental logical function is_letter(c)
      character, intent(in) :: c
      is_letter = (c >= 'a' .and. c <= 'z') .or. (c >= 'A' .and. c <= 'Z')
   end function is_letter

   !> Whether a character is one of 0 to 9.
   elemental logical function is_digit(c)
      character, intent(in) :: c
      is_digit = c >= '0' .and. c <= '9'
   end function is_digit

   !> Text that can be shown on a terminal: one line of bounded length, anything else than plain characters as `?`.
   pure function printable(text, most) result(shown)
      character(*), intent(in) :: text
      integer, intent(in) :: most                  !! longest text wanted
      character(:), allocatable :: shown
      integer :: i
      shown = text(:min(len(text), most))
      do i = 1, len(shown)
         if (iachar(shown(i:i)) < 32 .or. iachar(shown(i:i)) > 126) shown(i:i) = '?'
      end do
      if (len(text) > most) shown = shown//'...'
   end function printable

   !> The candidate that a misspelt word was probably meant to be, or '' where none is close.
   !> Close is: the beginning of one candidate alone; few changes of a letter over the length of the word; the beginning of several.
   pure function nearest_name(word, candidates) result(nearest)
      character(*), intent(in) :: word
      character(*), intent(in) :: candidates(:)
      character(:), allocatable :: nearest
      logical :: begins(size(candidates))
      integer :: i, distance, least
      nearest = ''
      if (len(word) == 0 .or. len(word) > name_len) return
      begins = len(word) > 2 .and. candidates /= word .and. &
               [(index(candidates(i), lower_case(word)) == 1, i=1, size(candidates))]
      if (count(begins) == 1) then
         nearest = trim(candidates(findloc(begins, .true., dim=1)))
         return
      end if
      least = (len(word) + 2)/3
      do i = 1, size(candidates)
         if (candidates(i) == word) cycle
         distance = edit_distance(lower_case(word), lower_case(trim(candidates(i))))
         if (distance <= least .and. distance < max(len(word), len_trim(candidates(i)))) then
            nearest = trim(candidates(i))
            least = distance - 1
         end if
      end do
      if (nearest == '' .and. any(begins)) nearest = trim(candidates(findloc(begins, .true., dim=1, back=.true.)))
   end function nearest_name

   !> The question to put behind the complaint about a misspelt word; '' where no candidate is close.
   pure function did_you_mean(word, candidates) result(question)
      character(*), intent(in) :: word
      character(*), intent(in) :: candidates(:)
      character(:), allocatable :: question
      question = nearest_name(word, candidates)
      if (question /= '') question = '; did you mean '''//printable(question, name_len)//'''?'
   end function did_you_mean

   !> Number of letters inserted, removed, changed or swapped with their neighbour that lead from one word to the
   !> other (optimal string alignment).
   pure integer function edit_distance(a, b)
      character(*), intent(in) :: a, b
      integer :: d(0:len(a), 0:len(b)), i, j
      d(:, 0) = [(i, i=0, len(a))]
      d(0, :) = [(j, j=0, len(b))]
      do j = 1, len(b)
         do i = 1, len(a)
            d(i, j) = min(d(i - 1, j), d(i, j - 1)) + 1
            d(i, j) = min(d(i, j), d(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
            if (swapped(i, j)) d(i, j) = min(d(i, j), d(max(i, 2) - 2, max(j, 2) - 2) + 1)
         end do
      end do
      edit_distance = d(len(a), len(b))

   contains

      !> Whether the last two letters of both words are swapped.
      pure logical function swapped(i, j)
         integer, intent(in) :: i, j
         swapped = .false.
         if (i > 1 .and. j > 1) swapped = a(i - 1:i) == b(j:j)//b(j - 1:j - 1)
      end function swapped
   end function edit_distance

   !> Add a line to a text of lines.
   pure subroutine add_line(text, line)
      character(:), allocatable, intent(inout) :: text
      character(*), intent(in) :: line
      if (text /= '') text = text//new_line('a')
      text = text//line
   end subroutine add_line

   !> A number as people read it.
   pure function three_digits(x) result(text)
      real(dp), intent(in) :: x
      character(:), allocatable :: text
      text = digits_text(x, 3)
   end function three_digits

   !> A number with so many of its digits, at most nine.
   pure function digits_text(x, digits) result(text)
      real(dp), intent(in) :: x
      integer, intent(in) :: digits
      character(:), allocatable :: text
      text = to_text(0.0_dp)
      if (abs(x) > 0) text = to_text(decimal(x, 10.0_dp**(10 - digits)*abs(x)))
   end function digits_text

   !> A number rounded to the 13 leading digits of a scale; the digits beyond are rounding of its operands.
   elemental real(dp) function without_rounding(x, scale)
      real(dp), intent(in) :: x
      real(dp), intent(in) :: scale              !! not below 0, in the unit of x
      without_rounding = x
      if (scale > 0) without_rounding = decimal(x, 1e-3_dp*scale)
   end function without_rounding

   !> Names in one text, with a separator between them.
   pure function joined(names, separator) result(text)
      character(*), intent(in) :: names(:), separator
      character(:), allocatable :: text
      integer :: k
      text = ''
      do k = 1, size(names)
         text = text//trim(names(k))//separator
      end do
      text = text(:max(len(text) - len(separator), 0))
   end function joined

   !> A position as text, without the rounding of its operands.
   pure function point_text(point) result(text)
      real(dp), intent(in) :: point(:)
      character(:), allocatable :: text
      integer :: d
      text = '('
      do d = 1, size(point)
         text = text//to_text(without_rounding(point(d), maxval(abs(point))))//', '
      end do
      text = text(:len(text) - 2)//')'
   end function point_text

   !> A number rounded to a decimal one, nine digits below the leading one of `scale`.
   elemental real(dp) function decimal(x, scale)
      real(dp), intent(in) :: x
      real(dp), intent(in) :: scale              !! above 0, in the unit of x
      real(dp) :: unit
      unit = 10.0_dp**(9 - floor(log10(scale)))
      decimal = anint(x*unit)/unit + 0.0_dp       ! no -0.0
   end function decimal

   !> A length that is a difference of others, in text, without the rounding of these.
   pure function length_text(length) result(text)
      real(dp), intent(in) :: length             !! not below 0 [m]
      character(:), allocatable :: text
      text = to_text(0.0_dp)
      if (length > 0) text = to_text(decimal(length, length))
   end function length_text
end module hampm_text
