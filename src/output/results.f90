!> The result file of a run: the history (one column a quantity, one value a sample), texts that say where the
!> numbers come from, and snapshots where they are asked for.
module hampm_results
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_hdf5_series, only: hdf5_series_t, real_values, long_values
   use hampm_snapshots, only: snapshots_t, block_t
   implicit none
   private
   public :: results_t

   integer, parameter :: chunk = 512      !! values of a column stored together
   integer, parameter :: capacity = 512   !! samples kept in memory at most

   type :: column_t
      type(hdf5_series_t) :: series              !! the dataset
      logical :: integer_valued = .false.        !! stored as 64-bit integers
   end type column_t

   type :: results_t
      private
      type(hdf5_file_t) :: file
      type(snapshots_t) :: snapshots
      type(column_t), allocatable :: columns(:)
      real(dp), allocatable :: samples(:, :)     !! samples not yet in the file, shape (capacity, columns)
      integer :: waiting = 0                     !! number of samples not yet in the file
      logical :: broken = .false.                !! writing has failed: nothing more is tried or reported
   contains
      procedure :: create
      procedure :: add_column
      generic :: add_attribute => add_attribute_text, add_attribute_real, add_attribute_integer
      procedure :: add_text
      procedure :: append
      procedure :: write_snapshot
      procedure :: flush => flush_results
      procedure :: close => close_results
      procedure, private :: add_attribute_text, add_attribute_real, add_attribute_integer
   end type results_t

contains

   !> Make the file, in place of an old one, with the groups /history and /input. `exit_file` where that is impossible.
   subroutine create(self, path, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      allocate (self%columns(0))
      call self%file%create(path, fault)
      if (.not. fault%failed()) call self%file%make_group('/history', fault)
      if (.not. fault%failed()) call self%file%make_group('/input', fault)
      call settle(self, fault, failure)
   end subroutine create

   !> Declare the next column of the history, before the first sample.
   subroutine add_column(self, name, unit, long_name, failure, integer_valued)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: name           !! the dataset is /history/<name>
      character(*), intent(in) :: unit           !! SI unit, '1' for a pure number
      character(*), intent(in) :: long_name      !! what a plot writes at the axis
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: integer_valued
      type(column_t) :: column
      type(failure_t) :: fault
      character(:), allocatable :: path
      if (self%broken) return
      path = '/history/'//name
      if (present(integer_valued)) column%integer_valued = integer_valued
      call column%series%create(self%file, path, merge(long_values, real_values, column%integer_valued), &
                                1, chunk, fault)
      call self%file%put_attribute(path, 'units', unit, fault)
      call self%file%put_attribute(path, 'long_name', long_name, fault)
      call settle(self, fault, failure)
      self%columns = [self%columns, column]
   end subroutine add_column

   !> Attach a text to the group or dataset `group`, or replace it.
   subroutine add_attribute_text(self, group, name, value, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: group, name, value
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%file%put_attribute(group, name, value, fault)
      call settle(self, fault, failure)
   end subroutine add_attribute_text

   !> Attach a real number to the group or dataset `group`, or replace it.
   subroutine add_attribute_real(self, group, name, value, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: group, name
      real(dp), intent(in) :: value
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%file%put_attribute(group, name, value, fault)
      call settle(self, fault, failure)
   end subroutine add_attribute_real

   !> Attach an integer to the group or dataset `group`, or replace it.
   subroutine add_attribute_integer(self, group, name, value, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: group, name
      integer, intent(in) :: value
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%file%put_attribute(group, name, value, fault)
      call settle(self, fault, failure)
   end subroutine add_attribute_integer

   !> Write a text as the dataset `path`, such as /input/namelist; the group exists.
   subroutine add_text(self, path, text, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: path, text
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%file%put(path, text, fault)
      call settle(self, fault, failure)
   end subroutine add_text

   !> Take a sample of the history. It reaches the file with the next flush, at the latest when the memory for
   !> samples is full.
   subroutine append(self, values, failure)
      class(results_t), intent(inout) :: self
      real(dp), intent(in) :: values(:)          !! one value a column, in the order of their declaration
      type(failure_t), intent(inout) :: failure
      if (self%broken) return
      if (.not. allocated(self%samples)) allocate (self%samples(capacity, size(self%columns)))
      self%waiting = self%waiting + 1
      self%samples(self%waiting, :) = values
      if (self%waiting == capacity) call self%flush(failure)
   end subroutine append

   !> Write particles and mesh as they are at `time`, and flush.
   subroutine write_snapshot(self, time, blocks, failure)
      class(results_t), intent(inout) :: self
      real(dp), intent(in) :: time               !! [s]
      type(block_t), intent(in) :: blocks(:)     !! the same blocks with the same fields every time
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%snapshots%write(self%file, time, blocks, fault)
      call settle(self, fault, failure)
      call self%flush(failure)
   end subroutine write_snapshot

   !> Write out all samples: they are then readable in the file even if the program is killed.
   subroutine flush_results(self, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken .or. .not. self%file%is_open()) return
      call write_samples(self, fault)
      if (.not. fault%failed()) call self%file%flush(fault)
      call settle(self, fault, failure)
   end subroutine flush_results

   !> Write out all samples and close the file. Nothing happens where the file could not be made.
   subroutine close_results(self, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      call self%flush(failure)
      call self%file%close(fault)
      call settle(self, fault, failure)
   end subroutine close_results

   !> Add the waiting samples to the columns.
   subroutine write_samples(self, fault)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: fault
      integer :: i
      if (self%waiting == 0) return
      do i = 1, size(self%columns)
         associate (column => self%columns(i), values => self%samples(:self%waiting, i))
            if (column%integer_valued) then
               call column%series%append(self%file, nint(values, long), fault)
            else
               call column%series%append(self%file, values, fault)
            end if
         end associate
         if (fault%failed()) return
      end do
      self%waiting = 0
   end subroutine write_samples

   !> Pass a fault of the file on: the first one only, since all that follow have the same cause.
   subroutine settle(self, fault, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(in) :: fault
      type(failure_t), intent(inout) :: failure
      if (fault%failed() .and. .not. self%broken) call failure%report(fault%code, fault%message)
      self%broken = self%broken .or. fault%failed()
   end subroutine settle
end module hampm_results
