!> Numbers survive as text; misspelt names find what was meant.
program test_text
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf, ieee_negative_inf
   use hampm_kinds, only: dp, long
   use hampm_text, only: to_text, lower_case, nearest_name, did_you_mean, paragraph, printable
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   implicit none

   character(*), parameter :: names(5) = [character(12) :: 'young', 'poisson', 'density', 'history', 'end_time']

   call repeat_random_numbers()
   call round_trips()
   call forms_of_numbers()
   call misspelt_names()
   call plain_text()
   call lines_of_paragraphs()
   call finish()

contains

   subroutine lines_of_paragraphs()
      character, parameter :: end = new_line('a')
      character(*), parameter :: word = repeat('w', 59)
      call check(paragraph('one line', 2) == 'one line'//end, 'a short paragraph is a line')
      call check(paragraph(word//' '//word(2:), 2) == word//' '//word(2:)//end, 'of at most 118 characters')
      call check(paragraph(word//' '//word, 2) == word//end//'  '//word//end, 'what is more begins a line')
      call check(paragraph(word//' '//word//' w', 58) == word//end//repeat(' ', 58)//word//end//repeat(' ', 58)//'w'//end, &
                 'whose blanks count')
      call check(paragraph('a `'//word//' > '//word//'` b', 0) == 'a'//end//'`'//word//' > '//word//'`'//end//'b'//end, &
                 'code stays together')
   end subroutine lines_of_paragraphs

   subroutine round_trips()
      real(dp) :: mantissa, power, number, back
      character(:), allocatable :: text
      integer :: k, wrong
      wrong = 0
      do k = 1, 2000
         call random_number(mantissa)
         call random_number(power)
         number = (mantissa - 0.5_dp)*10.0_dp**(600*power - 300)
         text = to_text(number)
         read (text, *) back
         if (abs(back - number) > 0) wrong = wrong + 1
      end do
      call check(wrong == 0, 'a number written as text reads back as the same number')
      text = to_text(huge(mantissa))
      read (text, *) back
      call check_close(back/huge(back), 1.0_dp, 0.0_dp, 'the largest number too')
      text = to_text(tiny(mantissa))
      read (text, *) back
      call check_close(back/tiny(back), 1.0_dp, 0.0_dp, 'and the smallest')
   end subroutine round_trips

   subroutine forms_of_numbers()
      call check(to_text(0.00125_dp) == '0.00125', 'a small number has no exponent')
      call check(to_text(7.0e10_dp) == '7.0e10', 'a large one has')
      call check(to_text(-1.5e-7_dp) == '-1.5e-7', 'a tiny one has')
      call check(to_text(0.1_dp) == '0.1', 'no digits beyond what identifies the number')
      call check(to_text(0.0_dp) == '0.0' .and. to_text(100.0_dp) == '100.0', 'a whole number keeps its point')
      call check(to_text(ieee_value(1.0_dp, ieee_quiet_nan)) == 'nan', 'not a number')
      call check(to_text(ieee_value(1.0_dp, ieee_positive_inf)) == 'inf', 'infinity')
      call check(to_text(ieee_value(1.0_dp, ieee_negative_inf)) == '-inf', 'minus infinity')
      call check(to_text(-huge(1) - 1) == '-2147483648', 'the lowest integer')
      call check(to_text(huge(1_long)) == '9223372036854775807', 'the highest long integer')
   end subroutine forms_of_numbers

   subroutine misspelt_names()
      call check(nearest_name('youngs', names) == 'young', 'a letter too many')
      call check(nearest_name('poison', names) == 'poisson', 'a letter missing')
      call check(nearest_name('densiyt', names) == 'density', 'two letters swapped')
      call check(nearest_name('HISTORIE', names) == 'history', 'capitals do not count')
      call check(nearest_name('end', names) == 'end_time', 'the beginning of a name')
      call check(nearest_name('velocity', names) == '', 'no name is near')
      call check(nearest_name('', names) == '', 'nothing is near to nothing')
      call check(did_you_mean('yung', names) == '; did you mean ''young''?', 'the question to the user')
      call check(did_you_mean('velocity', names) == '', 'no question where no name is near')
   end subroutine misspelt_names

   subroutine plain_text()
      call check(lower_case('Young_1 Z') == 'young_1 z', 'lower case')
      call check(printable('a'//achar(27)//'b', 10) == 'a?b', 'control characters do not reach the terminal')
      call check(printable('abcdef', 3) == 'abc...', 'long text is cut')
   end subroutine plain_text
end program test_text
