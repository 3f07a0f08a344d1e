!> Exercises everything in src/output: `results_driver FOLDER [killed | progress | quiet]`. What is checked here is what
!> Fortran can see; test_results_file.py reads the files with other programs.
program results_driver
   use, intrinsic :: iso_fortran_env, only: input_unit, output_unit
   use hampm_kinds, only: dp, long, path_len
   use hampm_failure, only: failure_t, exit_file, exit_computation
   use hampm_folders, only: ensure_folder
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_results, only: results_t
   use hampm_snapshots, only: piece_t, add_field, vtk_quad
   use hampm_progress, only: progress_t, standing_t
   implicit none
   character(path_len) :: folder, mode
   integer :: failures = 0

   call get_command_argument(1, folder)
   call get_command_argument(2, mode)
   select case (mode)
   case ('killed')
      call write_and_wait(trim(folder)//'/killed.h5')
   case ('progress')
      call run_progress(quiet=.false.)
   case ('quiet')
      call run_progress(quiet=.true.)
   case default
      call test_folders(trim(folder))
      call test_results(trim(folder)//'/results.h5', with_snapshots=.true.)
      call test_results(trim(folder)//'/plain.h5', with_snapshots=.false.)
      call test_datasets(trim(folder)//'/whole.h5')
      call test_paths_that_fail(trim(folder))
      call test_file_survives_failed_run(trim(folder)//'/failed_run.h5')
      if (failures > 0) error stop 'results_driver failed'
      write (output_unit, '(a)') 'results_driver passed'
   end select

contains

   !> Folders are made with those above them, twice without harm, and not where a file stands.
   subroutine test_folders(path)
      character(*), intent(in) :: path
      type(failure_t) :: failure
      integer :: unit
      call ensure_folder(path//'/a/b//c/', failure)
      call ensure_folder(path//'/a/b/c', failure)
      call check_none(failure, 'a chain of folders is made')
      open (newunit=unit, file=path//'/a/file', action='write')
      close (unit)
      call ensure_folder(path//'/a/file/d', failure)
      call check_report(failure, 'a file has this name')
   end subroutine test_folders

   !> Write a complete result file.
   subroutine test_results(path, with_snapshots)
      character(*), intent(in) :: path
      logical, intent(in) :: with_snapshots
      type(results_t) :: results
      type(failure_t) :: failure
      integer :: sample
      call results%create(path, failure)
      call declare_columns(results, failure)
      call results%add_text('/input/namelist', "&run title = 'Schälversuch'"//new_line('a')//'/', failure)
      call results%add_text('/input/empty', '', failure)
      do sample = 1, 1300
         call take_sample(results, sample, failure)
         if (mod(sample, 100) == 0) call results%flush(failure)
         if (with_snapshots .and. mod(sample, 500) == 1) call take_snapshot(results, sample/500, failure)
      end do
      call results%close(failure)
      call results%close(failure)
      call results%lock%release()
      call check_none(failure, 'a result file is written')
   end subroutine test_results

   !> What is put into a file whole is got from it.
   subroutine test_datasets(path)
      character(*), intent(in) :: path
      type(hdf5_file_t) :: file
      type(failure_t) :: failure
      real(dp) :: vector(2)
      integer(long) :: longs(1), none(0)
      integer :: n(3)
      call file%create(path, failure)
      call file%put('/vector', [1.0_dp, -2.0_dp], failure)
      call file%put('/none', [integer(long) ::], failure)
      call file%put('/longs', [2_long**40], failure)
      call file%close(failure)
      call file%open(path, failure)
      call file%get('/vector', vector, n(1), failure)
      call file%get('/none', none, n(2), failure)
      call file%get('/longs', longs, n(3), failure)
      call check_none(failure, 'datasets are put and got')
      call check(all(abs(vector - [1.0_dp, -2.0_dp]) <= 0.0_dp), 'the vector is the same')
      call check(all(n == [2, 0, 1]), 'they have as many values')
      call file%get('/vector', none, n(1), failure)
      call check(n(1) == 2, 'of a vector of another length that is told')
      call check(all(longs == 2_long**40), '64-bit integers are the same')
      call file%get('/nothing', vector, n(1), failure)
      call check_report(failure, 'there is no /nothing')
      call file%close(failure)
   end subroutine test_datasets

   !> A file that cannot be made or read says why, with the exit code of file errors.
   subroutine test_paths_that_fail(path)
      character(*), intent(in) :: path
      type(failure_t) :: failure(4)
      type(results_t) :: results(3)
      type(hdf5_file_t) :: file
      call results(1)%create(path//'/missing/dcb.h5', failure(1))
      call check_report(failure(1), path//'/missing/dcb.h5.part: cannot be written')
      call check_report(failure(1), 'No such file or directory')
      call results(2)%create(path, failure(2))
      call check_report(failure(2), 'Is a directory')
      call declare_columns(results(2), failure(2))
      call take_sample(results(2), 1, failure(2))
      call results(2)%close(failure(2))
      call results(2)%lock%release()
      call check(index(failure(2)%message, new_line('a')) == 0, 'one cause is reported once')
      call results(3)%create('/proc/dcb.h5', failure(3))
      call check_report(failure(3), '/proc/dcb.h5.part: cannot be written')
      call file%open(path//'/missing.h5', failure(4))
      call check_report(failure(4), 'cannot be read')
   end subroutine test_paths_that_fail

   !> The history of a run that has failed already is still written to its end.
   subroutine test_file_survives_failed_run(path)
      character(*), intent(in) :: path
      type(results_t) :: results
      type(failure_t) :: failure
      call results%create(path, failure)
      call declare_columns(results, failure)
      call take_sample(results, 1, failure)
      call failure%report(exit_computation, 'the energy grows')
      call results%close(failure)
      call results%lock%release()
      call check(failure%code == exit_computation .and. failure%message == 'the energy grows', &
                 'closing does not hide the failure of the run')
   end subroutine test_file_survives_failed_run

   !> Flush 100 samples, take more, and wait to be killed.
   subroutine write_and_wait(path)
      character(*), intent(in) :: path
      type(results_t) :: results
      type(failure_t) :: failure
      integer :: sample
      call results%create(path, failure)
      call declare_columns(results, failure)
      do sample = 1, 100
         call take_sample(results, sample, failure)
      end do
      call take_snapshot(results, 0, failure)
      call take_snapshot(results, 1, failure)
      call results%flush(failure)
      do sample = 101, 200
         call take_sample(results, sample, failure)
      end do
      write (output_unit, '(a)') 'flushed'
      flush (output_unit)
      read (input_unit, *)
   end subroutine write_and_wait

   !> Show a run of half a second.
   subroutine run_progress(quiet)
      logical, intent(in) :: quiet
      type(progress_t) :: progress
      integer(long) :: begin, now, rate, step
      call progress%start(1.0e-3_dp, quiet)
      call system_clock(begin, rate)
      now = begin
      step = 0
      do while (2*(now - begin) < rate)
         call progress%show(standing_t(real(now - begin, dp)/real(rate, dp)*2.0e-3_dp, step, 720, 2880, 4, -1.2e-6_dp, &
                                          1.287_dp, 1.0_dp), last=.false.)
         step = step + 1
         call system_clock(now)
      end do
      call progress%show(standing_t(1.0e-3_dp, step, 720, 2880, 4), last=.true.)
   end subroutine run_progress

   !> Three columns and their attributes.
   subroutine declare_columns(results, failure)
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
      call results%add_column('time', 's', 'time', failure)
      call results%add_column('step', '1', 'step', failure, integer_valued=.true.)
      call results%add_column('G_domain_I', 'J/m2', 'energy release rate, mode I', failure)
      call results%add_attribute('/history', 'G_ref', 0.5_dp, failure)
      call results%add_attribute('/history', 'G_ref', 0.25_dp, failure)
      call results%add_attribute('/history', 'threads', 2, failure)
      call results%add_attribute('/input', 'title', 'Schälversuch', failure)
   end subroutine declare_columns

   !> A sample of the history that can be computed again from its number.
   subroutine take_sample(results, sample, failure)
      type(results_t), intent(inout) :: results
      integer, intent(in) :: sample
      type(failure_t), intent(inout) :: failure
      call results%append([1.0e-6_dp*sample, real(2_long**40 + sample, dp), 1.0_dp/sample], failure)
   end subroutine take_sample

   !> Snapshot `k`: 5 + 3 k particles and 2 + k cells in a row, with fields that can be computed again.
   subroutine take_snapshot(results, k, failure)
      type(results_t), intent(inout) :: results
      integer, intent(in) :: k
      type(failure_t), intent(inout) :: failure
      type(piece_t) :: pieces(2)
      real(dp) :: row(5 + 3*k)
      integer :: i, cells
      row = [(real(i, dp), i=1, 5 + 3*k)]
      call pieces(1)%set_vertices('particles', reshape([(row(i), row(i) + 10*k, i=1, size(row))], [2, size(row)]))
      call add_field(pieces(1)%point_fields, 'velocity', reshape([(row(i), -row(i), i=1, size(row))], [2, size(row)]))
      call add_field(pieces(1)%point_fields, 'mass', reshape(100*k + row, [1, size(row)]))
      cells = 2 + k
      pieces(2)%name = 'mesh'
      pieces(2)%points = reshape([(real(i, dp), 0.0_dp, real(i, dp), 1.0_dp, i=0, cells)], [2, 2*cells + 2])
      pieces(2)%connectivity = [(2*i, 2*i + 2, 2*i + 3, 2*i + 1, i=0, cells - 1)]
      pieces(2)%offsets = [(4*i, i=0, cells)]
      pieces(2)%cell_types = spread(vtk_quad, 1, cells)
      call add_field(pieces(2)%cell_fields, 'level', reshape([(real(10*k + i, dp), i=1, cells)], [1, cells]))
      call results%write_snapshot(1.0e-3_dp*k, pieces, failure)
   end subroutine take_snapshot

   !> Count and print what does not hold.
   subroutine check(holds, what)
      logical, intent(in) :: holds
      character(*), intent(in) :: what
      if (holds) return
      failures = failures + 1
      write (output_unit, '(a)') 'FAILED: '//what
   end subroutine check

   !> Nothing has failed.
   subroutine check_none(failure, what)
      type(failure_t), intent(in) :: failure
      character(*), intent(in) :: what
      call check(.not. failure%failed(), what)
      if (failure%failed()) write (output_unit, '(a)') failure%message
   end subroutine check_none

   !> A file error was reported whose message contains a text.
   subroutine check_report(failure, text)
      type(failure_t), intent(in) :: failure
      character(*), intent(in) :: text
      call check(failure%code == exit_file, 'a file error is reported: '//text)
      if (.not. failure%failed()) return
      call check(index(failure%message, text) > 0, '"'//text//'" is in: '//failure%message)
   end subroutine check_report
end program results_driver
