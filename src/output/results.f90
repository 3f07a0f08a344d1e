!> The result file of a run: the history (one column a quantity, one value a sample), texts that say where the
!> numbers come from, and snapshots where they are asked for.
!>
!> It is written under a partial name. A flush renames it, whole and closed, over the last one; so the file with the name of the
!> result can be read at any moment, also after the program was killed. The last one is kept, completed and written on: two files
!> take turns. So everything is written twice, but nothing is copied that grows with the run.
module hampm_results
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t, exit_file
   use hampm_file_moves, only: partial_name, replace_file, give_second_name, rename_file, copy_file, remove_file
   use hampm_folders, only: is_folder
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_hdf5_series, only: hdf5_series_t, real_values, long_values
   use hampm_run_lock, only: run_lock_t
   use hampm_snapshots, only: snapshots_t, piece_t
   implicit none
   private
   public :: results_t, last_name

   integer, parameter :: most_attached = 4000    !! columns to the time, whose list of them HDF5 keeps in 64 KB
   integer, parameter :: chunk = 512      !! values of a column stored together
   integer, parameter :: capacity = 512   !! samples kept in memory at most
   real(dp), parameter :: patience = 10   !! time after which new samples and snapshots are flushed [s]
   character(*), parameter :: last_ending = '.last' !! of the second name of the last file while a new one takes its place

   !> A result file that is being written.
   type :: results_t
      character(:), allocatable :: path          !! name of the result
      type(run_lock_t) :: lock                   !! held from the beginning, until other runs may write this result
      type(hdf5_file_t), private :: file
      type(snapshots_t), private :: snapshots
      type(hdf5_series_t), allocatable, private :: columns(:) !! of the history, with room for more
      integer, private :: n_columns = 0                   !! how many there are
      real(dp), allocatable, private :: samples(:, :)     !! samples not yet in the file, shape (capacity, columns)
      integer, private :: waiting = 0                     !! number of samples not yet in the file
      logical, private :: broken = .false.                !! writing has failed: nothing more is tried or reported
      logical, private :: is_begun = .false.              !! whether there is a file under the partial name, by this run
      logical, private :: is_published = .false.          !! whether a file of this run is there
      integer(long), private :: kept = -1                 !! samples that are kept where a result is continued, else -1
      integer(long), private :: clock_last = 0            !! ticks at the last flush
   contains
      procedure :: create
      procedure :: write_nothing
      procedure :: resume
      procedure :: lengths
      procedure :: add_column
      procedure :: add_attribute
      procedure :: add_text
      procedure :: add_table
      procedure :: append
      procedure :: write_snapshot
      procedure :: flush => flush_results
      procedure :: close => close_results
   end type results_t

contains

   !> The second name of the last file of a result while a new one takes its place.
   pure function last_name(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name
      name = path//last_ending
   end function last_name

   !> Begin a file, with the groups /history and /input. `exit_file` where that is impossible.
   subroutine create(self, path, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      call begin(self, path, fault)
      if (.not. fault%failed()) call self%file%create(partial_name(path), fault)
      self%is_begun = .not. fault%failed()
      if (.not. fault%failed()) call self%file%make_group('/history', fault)
      if (.not. fault%failed()) call self%file%make_group('/input', fault)
      call pass_on(self, fault, failure)
   end subroutine create

   !> Take all, and write nothing.
   subroutine write_nothing(self)
      class(results_t), intent(inout) :: self
      self%path = ''
      self%broken = .true.
   end subroutine write_nothing

   !> Continue the result of a model, where it had certain `lengths`; it is declared as at its beginning. `exit_file` where there is
   !> no result of this model or it is shorter.
   subroutine resume(self, path, model, lengths, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: path
      character(*), intent(in) :: model          !! the namelist, as the result has it
      integer(long), intent(in) :: lengths(:)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      type(hdf5_file_t) :: old
      character(:), allocatable :: other
      call begin(self, path, fault)
      if (.not. fault%failed()) call old%open(path, fault)
      if (.not. fault%failed()) call old%get('/input/namelist', other, fault)
      call old%close(fault)
      if (.not. fault%failed()) then
         if (other /= model) call fault%report(exit_file, path//': is the result of another model than the checkpoint; '// &
                                               'the result has to be where the checkpoint is')
      end if
      if (.not. fault%failed()) call copy_file(path, partial_name(path), fault)
      if (.not. fault%failed()) call self%file%open(partial_name(path), fault, writable=.true.)
      self%is_begun = .not. fault%failed()
      self%is_published = self%is_begun
      self%kept = lengths(1)
      call self%snapshots%keep_only(lengths(2:))
      call pass_on(self, fault, failure)
   end subroutine resume

   !> No columns yet, and the clock runs. Fails if the name is of a folder, or if another run is writing this result; remains of a
   !> killed run are removed.
   subroutine begin(self, path, fault)
      type(results_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: fault
      logical :: others
      self%path = path
      allocate (self%columns(0))
      call system_clock(self%clock_last)
      if (is_folder(path)) then
         call fault%report(exit_file, path//': cannot be written: Is a directory')
         return
      end if
      call self%lock%take(path, others)
      if (others) then
         call fault%report(exit_file, path//': cannot be written: another run is writing it')
      else
         call remove_file(last_name(path))
      end if
   end subroutine begin

   !> Numbers of samples and of entries of each dataset of the snapshots: arguments of `resume`.
   function lengths(self)
      class(results_t), intent(inout) :: self
      integer(long), allocatable :: lengths(:)
      lengths = [int(self%columns(1)%length, long) + self%waiting, self%snapshots%lengths()]
   end function lengths

   !> Declare the next column of the history, before the first sample. The first one, the time, is the dimension of all.
   subroutine add_column(self, name, unit, long_name, failure, integer_valued, along_front)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: name           !! the dataset is /history/<name>, or /front/<name>
      character(*), intent(in) :: unit           !! SI unit, '1' for a pure number
      character(*), intent(in) :: long_name      !! label of the axis in a plot
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: integer_valued
      integer, intent(in), optional :: along_front !! how many values of nodes of a front it has a sample
      type(hdf5_series_t) :: column
      type(hdf5_series_t), allocatable :: columns(:)
      integer :: stored, rows
      type(failure_t) :: fault
      character(:), allocatable :: path
      logical :: is_new
      if (self%broken) return
      path = '/history/'//name
      rows = 1
      if (present(along_front)) then
         path = '/front/'//name
         rows = along_front
         call self%file%make_group('/front', fault)
      end if
      is_new = .not. self%file%holds(path)
      stored = real_values
      if (present(integer_valued)) stored = merge(long_values, real_values, integer_valued)
      call column%create(self%file, path, stored, rows, max(1, chunk/rows), fault)
      if (self%kept >= 0 .and. .not. fault%failed()) call column%shorten(self%file, int(self%kept, long), fault)
      call self%file%put_attribute(path, 'units', unit, fault)
      call self%file%put_attribute(path, 'long_name', long_name, fault)
      if (self%n_columns == size(self%columns)) then ! not a copy of all for each
         allocate (columns(2*self%n_columns + 16))
         columns(:self%n_columns) = self%columns
         call move_alloc(columns, self%columns)
      end if
      self%n_columns = self%n_columns + 1
      self%columns(self%n_columns) = column
      if (is_new .and. .not. fault%failed() .and. self%n_columns <= most_attached) &
         call column%attach_to(self%columns(1), self%file, fault)
      call pass_on(self, fault, failure)
   end subroutine add_column

   !> Attach a text, a real number or an integer to the group or dataset `group`, or replace it.
   subroutine add_attribute(self, group, name, value, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: group, name
      class(*), intent(in) :: value
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%file%put_attribute(group, name, value, fault)
      call pass_on(self, fault, failure)
   end subroutine add_attribute

   !> Write a text as the dataset `path`, such as /input/namelist; the group exists. A result that is continued has it.
   subroutine add_text(self, path, text, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: path, text
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      if (self%kept < 0) call self%file%put(path, text, fault)
      call pass_on(self, fault, failure)
   end subroutine add_text

   !> Write a table as the dataset `name` of a group, which is made where it is not there. A result that is continued has it.
   subroutine add_table(self, group, name, unit, long_name, values, failure)
      class(results_t), intent(inout) :: self
      character(*), intent(in) :: group, name
      character(*), intent(in) :: unit           !! SI unit, '1' for a pure number
      character(*), intent(in) :: long_name      !! label of the axis in a plot
      real(dp), intent(in) :: values(:, :)       !! (components, entries)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      type(hdf5_series_t) :: table
      if (self%broken .or. self%kept >= 0) return
      call self%file%make_group(group, fault)
      if (.not. fault%failed()) &
         call table%create(self%file, group//'/'//name, real_values, size(values, 1), max(1, size(values, 2)), fault)
      if (fault%failed()) then
         continue
      else if (size(values, 1) == 1) then
         call table%append(self%file, values(1, :), fault)
      else
         call table%append(self%file, values, fault)
      end if
      call self%file%put_attribute(table%path, 'units', unit, fault)
      call self%file%put_attribute(table%path, 'long_name', long_name, fault)
      call pass_on(self, fault, failure)
   end subroutine add_table

   !> Take a sample of the history.
   subroutine append(self, values, failure)
      class(results_t), intent(inout) :: self
      real(dp), intent(in) :: values(:)          !! of the columns, in the order of their declaration
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      if (.not. allocated(self%samples)) allocate (self%samples(capacity, size(values)))
      self%waiting = self%waiting + 1
      self%samples(self%waiting, :) = values
      if (self%waiting == capacity) call write_samples(self, fault)
      call pass_on(self, fault, failure)
      call flush_if_due(self, failure)
   end subroutine append

   !> Write particles and mesh as they are at `time`.
   subroutine write_snapshot(self, time, pieces, failure)
      class(results_t), intent(inout) :: self
      real(dp), intent(in) :: time               !! [s]
      type(piece_t), intent(in) :: pieces(:)     !! the same pieces with the same fields every time
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (self%broken) return
      call self%snapshots%write(self%file, time, pieces, fault)
      call pass_on(self, fault, failure)
      call flush_if_due(self, failure)
   end subroutine write_snapshot

   !> Flush where the last time is long enough ago.
   subroutine flush_if_due(self, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      integer(long) :: now, rate
      call system_clock(now, rate)
      if (now - self%clock_last >= patience*rate) call self%flush(failure)
   end subroutine flush_if_due

   !> Write out all samples and snapshots: they are then in the file of the result, even if the program is killed.
   subroutine flush_results(self, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      logical :: has_last
      if (self%broken .or. .not. self%file%is_open()) return
      has_last = .false.
      if (self%is_published) has_last = give_second_name(self%path, last_name(self%path))
      call publish(self, fault)
      if (has_last) has_last = rename_file(last_name(self%path), partial_name(self%path))
      if (has_last .and. .not. fault%failed()) call bring_up_to_date(self, has_last)
      if (.not. has_last .and. .not. fault%failed()) call copy_file(self%path, partial_name(self%path), fault)
      if (.not. fault%failed()) call reopen(self, fault)
      call system_clock(self%clock_last)
      call pass_on(self, fault, failure)
   end subroutine flush_results

   !> Write out all samples and put the file in the place of the last one.
   subroutine publish(self, fault)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: fault
      call write_samples(self, fault)
      call self%file%close(fault)
      if (fault%failed()) return
      call replace_file(self%path, fault)
      self%is_published = .not. fault%failed()
   end subroutine publish

   !> Add the missing part of the present file to the last one; `done` is false if that is impossible, as a reader may have it open.
   subroutine bring_up_to_date(self, done)
      class(results_t), intent(inout) :: self
      logical, intent(out) :: done
      type(failure_t) :: fault
      type(hdf5_file_t) :: donor
      integer :: i
      call self%file%open(partial_name(self%path), fault, writable=.true.)
      if (.not. fault%failed()) call donor%open(self%path, fault)
      done = .not. fault%failed()
      if (done) done = self%snapshots%can_catch_up(self%file)
      if (done) then
         call find_series(self, fault)
         do i = 1, self%n_columns
            if (.not. fault%failed()) call self%columns(i)%catch_up(self%file, donor, fault)
         end do
         if (.not. fault%failed()) call self%snapshots%catch_up(self%file, donor, fault)
         done = .not. fault%failed()
      end if
      call donor%close(fault)
      if (.not. done) call self%file%close(fault)
   end subroutine bring_up_to_date

   !> Open the file to be written on, unless it is open.
   subroutine reopen(self, fault)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: fault
      if (self%file%is_open()) return
      call self%file%open(partial_name(self%path), fault, writable=.true.)
      if (.not. fault%failed()) call find_series(self, fault)
   end subroutine reopen

   !> Find all datasets again in a file that has been opened anew.
   subroutine find_series(self, fault)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: fault
      integer :: i
      do i = 1, self%n_columns
         if (.not. fault%failed()) call self%columns(i)%reopen(self%file, fault)
      end do
      if (.not. fault%failed()) call self%snapshots%reopen(self%file, fault)
   end subroutine find_series

   !> Write out all samples and close the file. Nothing happens where the file could not be made; where it could not be written to
   !> its end, the last one stays in its place. No other run may write it before it is released.
   subroutine close_results(self, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: fault
      if (.not. self%broken .and. self%file%is_open()) call publish(self, fault)
      call pass_on(self, fault, failure)
      ! Open until the program ends: HDF5 1.14 ends by a signal in closing a file of which a dataset cannot be written out
      if (self%broken .and. self%is_begun) call remove_file(partial_name(self%path))
   end subroutine close_results

   !> Add the waiting samples to the columns.
   subroutine write_samples(self, fault)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(inout) :: fault
      real(dp), allocatable :: by_sample(:, :)   ! gfortran gives a contiguous dummy a transposed array of the wrong shape
      integer :: i, first, last
      if (self%waiting == 0) return
      last = 0
      do i = 1, self%n_columns
         first = last + 1
         last = last + int(self%columns(i)%rows)
         if (last == first) then
            call self%columns(i)%append(self%file, self%samples(:self%waiting, first), fault) ! HDF5 makes integers of whole numbers
         else
            by_sample = transpose(self%samples(:self%waiting, first:last))
            call self%columns(i)%append(self%file, by_sample, fault)
         end if
         if (fault%failed()) return
      end do
      self%waiting = 0
   end subroutine write_samples

   !> Pass a fault of the file on: the first one only, since all that follow have the same cause.
   subroutine pass_on(self, fault, failure)
      class(results_t), intent(inout) :: self
      type(failure_t), intent(in) :: fault
      type(failure_t), intent(inout) :: failure
      if (fault%failed() .and. .not. self%broken) call failure%report(fault%code, fault%message)
      self%broken = self%broken .or. fault%failed()
   end subroutine pass_on
end module hampm_results
