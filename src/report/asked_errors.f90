!> Errors that are asked of columns of the history (&accuracy), and those that rows tell.
module hampm_asked_errors
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t, exit_input
   use hampm_group_values, only: accuracy_keys_t
   use hampm_history, only: history_t
   implicit none
   private
   public :: asked_error_t, new_asked_errors, worst_ratio, worst_difference, no_value

   real(dp), parameter :: last_rows = 0.2_dp     !! part of the time whose rows are compared with the last one
   real(dp), parameter :: no_value = 1e30_dp     !! relative error of a value that is 0 [-]

   !> What &accuracy asks of one quantity, and what the rows so far tell of it. Of a front and of all tips the largest count.
   type :: asked_error_t
      type(accuracy_keys_t) :: keys
      integer, allocatable, private :: of_value(:), of_error(:) !! columns, in pairs
      real(dp), private :: value = 0             !! of the row that counts: the last one, or that with the largest value
      real(dp), private :: error = 0             !! of that, or the largest of all rows, or their mean
      real(dp), private :: squares = 0, rows = 0 !! of the errors of all rows, and their number
      integer, private :: n = 0                  !! rows so far
      real(dp), allocatable, private :: times(:), values(:) !! of these [s], with room for more
   contains
      procedure :: take
      procedure :: estimated
      procedure :: serialise
   end type asked_error_t

contains

   !> What is asked of the columns of a history. Fails where a quantity has no column, or one without an estimated error.
   subroutine new_asked_errors(keys, history, asked, failure)
      type(accuracy_keys_t), intent(in) :: keys(:)
      type(history_t), intent(in) :: history     !! after its first pass
      type(asked_error_t), allocatable, intent(inout) :: asked(:) !! of a run that goes on with what its rows have estimated
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: with_error
      integer :: k, i, error
      if (.not. allocated(asked)) allocate (asked(size(keys)))
      with_error = ''
      do i = 1, size(history%columns)
         if (error_of(history, i) > 0) with_error = with_error//history%columns(i)%name//', '
      end do
      if (with_error == '') with_error = 'none  '
      do k = 1, size(keys)
         asked(k)%keys = keys(k)
         allocate (asked(k)%of_value(0), asked(k)%of_error(0), asked(k)%times(0), asked(k)%values(0))
         do i = 1, size(history%columns)
            error = error_of(history, i)
            if (error == 0 .or. .not. is_of(history%columns(i)%name, trim(keys(k)%quantity))) cycle
            asked(k)%of_value = [asked(k)%of_value, i]
            asked(k)%of_error = [asked(k)%of_error, error]
         end do
         associate (n => history%columns(asked(k)%of_value)%n) ! K of a front as a row has it is its mean
            if (any(n == 1)) then
               asked(k)%of_error = pack(asked(k)%of_error, n == 1)
               asked(k)%of_value = pack(asked(k)%of_value, n == 1)
            end if
         end associate
         if (size(asked(k)%of_value) == 0) call failure%report(exit_input, '&accuracy quantity = '''//trim(keys(k)%quantity)// &
            ''': the history has no such column with an estimated error; those that it has: '//with_error(:len(with_error) - 2))
      end do
   end subroutine new_asked_errors

   !> Whether a column is of a quantity: by its name, or of any tip or front.
   pure logical function is_of(name, quantity)
      character(*), intent(in) :: name, quantity
      is_of = name == quantity .or. index(name, quantity//'_tip') == 1 .or. index(name, quantity//'_front') == 1 .or. &
              index(name, quantity//'_crack') == 1
   end function is_of

   !> The column with the estimated error of another: `K_I_error_tip2` of `K_I_tip2`; 0 where there is none.
   pure integer function error_of(history, column) result(error)
      type(history_t), intent(in) :: history
      integer, intent(in) :: column
      integer :: behind
      associate (name => history%columns(column)%name)
         behind = len(name)
         if (index(name, '_tip') > 0) behind = index(name, '_tip', back=.true.) - 1
         if (index(name, '_front') > 1) behind = index(name, '_front', back=.true.) - 1
         if (index(name, '_crack') > 1 .and. index(name, '_front') == 0) behind = index(name, '_crack', back=.true.) - 1
         do error = 1, size(history%columns)
            if (history%columns(error)%name == name(:behind)//'_error'//name(behind + 1:) .and. &
                history%columns(error)%n == history%columns(column)%n) return
         end do
      end associate
      error = 0
   end function error_of

   !> Take the latest row.
   elemental subroutine take(self, history)
      class(asked_error_t), intent(inout) :: self
      type(history_t), intent(in) :: history
      real(dp) :: value, error
      integer :: k
      value = 0
      error = 0
      do k = 1, size(self%of_value)
         associate (of_value => history%columns(self%of_value(k)), of_error => history%columns(self%of_error(k)))
            value = max(value, largest(history%row(of_value%first:of_value%first + of_value%n - 1)))
            error = max(error, largest(history%row(of_error%first:of_error%first + of_error%n - 1)))
         end associate
      end do
      if (self%n == size(self%times)) then
         self%times = [self%times, spread(0.0_dp, 1, self%n + 16)]
         self%values = [self%values, spread(0.0_dp, 1, self%n + 16)]
      end if
      self%n = self%n + 1
      self%times(self%n) = history%latest('time')
      self%values(self%n) = value
      select case (self%keys%at)
       case ('end')
         self%value = value
         self%error = error
       case ('largest')
         if (value >= self%value) self%error = error
         self%value = max(self%value, value)
       case ('mean')
         self%value = max(self%value, value)
         self%squares = self%squares + error**2
         self%rows = self%rows + 1
         self%error = sqrt(self%squares/self%rows)
       case default
         self%value = max(self%value, value)
         self%error = max(self%error, error)
      end select
   end subroutine take

   !> What the rows so far have estimated goes into a checkpoint, or comes from it.
   subroutine serialise(self, archive, name)
      class(asked_error_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      character(*), intent(in) :: name
      call archive%serialise(name//'_value', self%value)
      call archive%serialise(name//'_error', self%error)
      call archive%serialise(name//'_squares', self%squares)
      call archive%serialise(name//'_rows', self%rows)
   end subroutine serialise

   !> The largest size of numbers, of a tip that has ended 0.
   pure real(dp) function largest(numbers)
      real(dp), intent(in) :: numbers(:)
      largest = maxval(abs(numbers), mask=ieee_is_finite(numbers))
      largest = max(largest, 0.0_dp)
   end function largest

   !> The error that the rows so far estimate, as part of the value [-]; `no_value` where that is 0.
   pure real(dp) function estimated(self)
      class(asked_error_t), intent(in) :: self
      estimated = no_value
      if (self%value > 0) estimated = self%error/self%value
   end function estimated

   !> The difference of the values of two runs, as part of the value of the second [-], in the rows of the one that has fewer. Waves
   !> of the cells pass the last row at any phase, so that rows before it count with it.
   pure real(dp) function difference(a, b)
      type(asked_error_t), intent(in) :: a, b
      difference = no_value
      if (.not. b%value > 0) return
      if (b%keys%at == 'largest') difference = abs(a%value - b%value)
      if (b%keys%at /= 'largest' .and. a%n <= b%n) difference = norm_of_gaps(a, b, b%keys%at)
      if (b%keys%at /= 'largest' .and. a%n > b%n) difference = norm_of_gaps(b, a, b%keys%at)
      difference = difference/b%value
   end function difference

   !> The largest difference of the values of two runs in the rows of the first, or in the last ones, or their root mean square.
   pure real(dp) function norm_of_gaps(a, b, at) result(norm)
      type(asked_error_t), intent(in) :: a, b
      character(*), intent(in) :: at             !! of &accuracy
      associate (gap => abs(gaps(a, b)), times => a%times(:a%n))
         norm = maxval(gap)
         if (at == 'mean') norm = sqrt(sum(gap**2)/max(1, a%n))
         if (at == 'end') norm = maxval(gap, mask=times >= (1 - last_rows)*maxval(times))
      end associate
   end function norm_of_gaps

   !> The differences of the values of two runs in the rows of the first. Values between rows are those of a line.
   pure function gaps(a, b)
      type(asked_error_t), intent(in) :: a, b
      real(dp) :: gaps(a%n)
      real(dp) :: part
      integer :: i, j
      gaps = 0
      j = 1
      do i = 1, a%n
         do while (j < b%n - 1 .and. b%times(min(j + 1, b%n)) < a%times(i))
            j = j + 1
         end do
         if (j == b%n) exit
         part = min(max(a%times(i) - b%times(j), 0.0_dp), b%times(j + 1) - b%times(j))
         if (part > 0) part = part/(b%times(j + 1) - b%times(j))
         gaps(i) = a%values(i) - (1 - part)*b%values(j) - part*b%values(j + 1)
      end do
   end function gaps

   !> The largest difference of two runs over the errors asked [-].
   pure real(dp) function worst_difference(a, b) result(ratio)
      type(asked_error_t), intent(in) :: a(:), b(:)
      integer :: k
      ratio = maxval([0.0_dp, (difference(a(k), b(k))/b(k)%keys%error, k=1, size(b))])
   end function worst_difference

   !> The largest of the estimated errors over those asked [-].
   pure real(dp) function worst_ratio(asked) result(ratio)
      type(asked_error_t), intent(in) :: asked(:)
      integer :: k
      ratio = maxval([0.0_dp, (asked(k)%estimated()/asked(k)%keys%error, k=1, size(asked))])
   end function worst_ratio
end module hampm_asked_errors
