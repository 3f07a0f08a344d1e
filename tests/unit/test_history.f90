!> The history: the first pass through the calls of `record` finds the columns, every pass fills a row.
program test_history
   use hampm_kinds, only: dp, long
   use hampm_harness, only: check, check_close, finish
   use hampm_history, only: history_t
   implicit none
   type(history_t) :: history
   integer, parameter :: many = 1000
   integer :: i

   do i = 1, 3
      call take_row(real(i, dp))
   end do
   call check(size(history%columns) == 7 + many .and. size(history%row) == 7 + many, 'any number of columns is found, once')
   call check_column(1, 'time', 's', 'time', .false., 3.0_dp)
   call check_column(2, 'step', '1', 'steps done', .true., 3*2.0_dp**40)
   call check_column(3, 'cells', '1', 'number of cells', .true., 3.0_dp)
   call check_column(4, 'K_I', 'Pa m^0.5', 'stress intensity factor, mode I', .false., 30.0_dp)
   call check_column(5, 'K_II', 'Pa m^0.5', 'stress intensity factor, mode II', .false., -30.0_dp)
   call check_column(6, 'J_1', 'J/m2', 'J integral, radius 0.002 m', .false., 31.0_dp)
   call check_column(7, 'J_2', 'J/m2', 'J integral, radius 0.004 m', .false., 32.0_dp)
   call check_close(history%row(7 + many), 3.0_dp + many, 0.0_dp, 'the last value is in the last column')
   call finish()

contains

   !> Pass once through the list.
   subroutine take_row(t)
      real(dp), intent(in) :: t
      integer :: k
      call history%begin_row()
      call history%record('time', 's', 'time', t)
      call history%record('step', '1', 'steps done', nint(t, long)*2_long**40)
      call history%record('cells', '1', 'number of cells', nint(t))
      call history%record_modes('K_', 'Pa m^0.5', 'stress intensity factor', [10*t, -10*t])
      call history%record_radii('J_', 'J/m2', 'J integral', [2.0e-3_dp, 4.0e-3_dp], [10*t + 1, 10*t + 2])
      do k = 1, many
         call history%record('other', '1', 'a further column', t + k)
      end do
      call history%end_row()
   end subroutine take_row

   !> Check what a column is, and its latest value.
   subroutine check_column(n, name, unit, meaning, integer_valued, value)
      integer, intent(in) :: n
      character(*), intent(in) :: name, unit, meaning
      logical, intent(in) :: integer_valued
      real(dp), intent(in) :: value
      associate (column => history%columns(n))
         call check(column%name == name, name//' has its name: '//column%name)
         call check(column%unit == unit, name//' has its unit: '//column%unit)
         call check(column%meaning == meaning, name//' has its meaning: '//column%meaning)
         call check(column%integer_valued .eqv. integer_valued, name//' is of integers or not')
      end associate
      call check_close(history%row(n), value, 0.0_dp, name//' has the value of the last pass')
   end subroutine check_column
end program test_history
