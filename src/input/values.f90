!> Numbers from text. Refused: text that is not wholly a number, infinity, NaN, and magnitudes beyond any model in SI units:
!> products of a few numbers can then not overflow.
module hampm_values
   use hampm_kinds, only: dp
   use hampm_text, only: lower_case, to_text
   implicit none
   private
   public :: parse_real, parse_integer, least_magnitude, is_number, is_extreme, is_no_number

   integer, parameter :: is_number = 0             !! the text is a number
   integer, parameter :: is_extreme = 1            !! infinite, undefined, or of an extreme magnitude
   integer, parameter :: is_no_number = 2          !! no number at all
   integer, parameter :: most_decades = 100
   real(dp), parameter :: least_magnitude = 1e-100_dp   !! a number is 0 or in size from this to its inverse

contains

   !> Read a real number: `1`, `.5`, `1.`, `-1.5e-3`, `1d3`.
   !> It is taken apart before it is converted, because converting 1e999 raises a floating point exception.
   pure subroutine parse_real(text, number, status)
      character(*), intent(in) :: text
      real(dp), intent(out) :: number
      integer, intent(out) :: status               !! `is_number`, `is_extreme` or `is_no_number`
      character(:), allocatable :: word, digits
      integer :: mark, exponent, decade, point, first, ios
      number = 0
      status = is_no_number
      word = unsigned(lower_case(text))
      if (word == 'inf' .or. word == 'infinity' .or. word == 'nan') status = is_extreme
      mark = scan(word//'e', 'ed')
      call parse_exponent(word(mark:), exponent, status)
      if (status /= is_number) return
      digits = word(:mark - 1)
      point = index(digits//'.', '.')
      digits = digits(:point - 1)//digits(min(point, len(digits)) + 1:)
      if (len(digits) == 0 .or. verify(digits, '0123456789') > 0) status = is_no_number
      if (len(digits) > 80) status = is_no_number
      first = verify(digits, '0')
      if (first == 0 .or. status /= is_number) return
      decade = point - 1 - first + exponent
      if (decade < -most_decades .or. decade >= most_decades) then
         status = is_extreme
         return
      end if
      word = text(:len(text) - len(word))//word(:mark - 1)//'e'//to_text(exponent)  ! the exponent as short as can be
      read (word, '(f200.0)', iostat=ios) number
      if (ios /= 0) status = is_no_number
   end subroutine parse_real

   !> The exponent of a number, from the letter on; 0 for no exponent.
   pure subroutine parse_exponent(text, exponent, status)
      character(*), intent(in) :: text
      integer, intent(out) :: exponent
      integer, intent(inout) :: status
      character(:), allocatable :: digits
      integer :: i
      exponent = 0
      if (status == is_extreme) return
      if (len(text) > 0) then
         digits = unsigned(text(2:))
         if (len(digits) == 0 .or. verify(digits, '0123456789') > 0) return
         do i = 1, len(digits)
            exponent = min(10*exponent + iachar(digits(i:i)) - iachar('0'), 10000)
         end do
         if (text(2:2) == '-') exponent = -exponent
      end if
      status = is_number
   end subroutine parse_exponent

   !> Text without a leading sign.
   pure function unsigned(text)
      character(*), intent(in) :: text
      character(:), allocatable :: unsigned
      unsigned = text
      if (len(text) > 0) then
         if (scan(text(1:1), '+-') > 0) unsigned = text(2:)
      end if
   end function unsigned

   !> Read an integer that an integer variable can hold, into a real number, which holds it exactly.
   pure subroutine parse_integer(text, number, status)
      character(*), intent(in) :: text
      real(dp), intent(out) :: number
      integer, intent(out) :: status
      number = 0
      status = is_no_number
      if (len(text) == 0 .or. verify(unsigned(text), '0123456789') > 0) return
      call parse_real(text, number, status)
      if (abs(number) > huge(1)) status = is_extreme
   end subroutine parse_integer
end module hampm_values
