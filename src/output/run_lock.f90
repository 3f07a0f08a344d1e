!> One run at a time writes a result: it holds a lock from its beginning to its end.
!>
!> The lock is on an empty file beside the result and not on the result itself, which is replaced again and again. The system takes
!> the lock from a program that ends, however it ends; the empty file that a killed one leaves behind keeps nobody out.
module hampm_run_lock
   use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_int64_t, c_null_char, c_ptr
   use hampm_file_moves, only: c_open, c_close, remove_file
   implicit none
   private
   public :: run_lock_t, lock_name

   character(*), parameter :: ending = '.lock'
   integer(c_int), parameter :: read_only = int(o'2000000', c_int) !! O_RDONLY and O_CLOEXEC
   integer(c_int), parameter :: alone_at_once = 2 + 4   !! LOCK_EX and LOCK_NB
   integer(c_int), parameter :: taken = 11              !! EWOULDBLOCK: another program has the lock
   integer, parameter :: room = 64                      !! of `struct stat`, in words of 8 bytes: more than any system takes
   integer, parameter :: identity = 2                   !! words that `struct stat` begins with: device and file

   !> The lock of a run.
   type :: run_lock_t
      character(:), allocatable, private :: path
      integer(c_int), private :: descriptor = -1        !! below 0: no lock is held
   contains
      procedure :: take
      procedure :: release
   end type run_lock_t

   interface
      integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
         import :: c_int
         integer(c_int), value :: descriptor, operation
      end function c_flock

      integer(c_int) function c_stat(path, status) bind(c, name='stat')
         import :: c_char, c_int, c_int64_t
         character(c_char), intent(in) :: path(*)
         integer(c_int64_t), intent(out) :: status(*)
      end function c_stat

      integer(c_int) function c_fstat(descriptor, status) bind(c, name='fstat')
         import :: c_int, c_int64_t
         integer(c_int), value :: descriptor
         integer(c_int64_t), intent(out) :: status(*)
      end function c_fstat

      type(c_ptr) function c_errno_location() bind(c, name='__errno_location')
         import :: c_ptr
      end function c_errno_location
   end interface

contains

   !> Name of the file that is locked while a result is written.
   pure function lock_name(path) result(name)
      character(*), intent(in) :: path           !! of the result
      character(:), allocatable :: name
      name = path//ending
   end function lock_name

   !> Take the lock of the result `path`. `others` is true if another program has it. If the folder is read-only, or its file system
   !> has no locks, the run continues without.
   subroutine take(self, path, others)
      class(run_lock_t), intent(inout) :: self
      character(*), intent(in) :: path
      logical, intent(out) :: others
      self%path = lock_name(path)
      do
         call open_and_lock(self, others)
         if (self%descriptor < 0) return
         if (is_its_name(self)) return
         call drop(self)                         ! the program that had it has removed it meanwhile
      end do
   end subroutine take

   !> Open the file, created if absent, and lock it if that can be done at once.
   subroutine open_and_lock(self, others)
      class(run_lock_t), intent(inout) :: self
      logical, intent(out) :: others
      integer(c_int), pointer :: errno
      integer :: unit, status
      others = .false.
      open (newunit=unit, file=self%path, access='stream', action='readwrite', status='unknown', iostat=status)
      if (status /= 0) return
      close (unit)
      self%descriptor = c_open(self%path//c_null_char, read_only)
      if (self%descriptor < 0) return
      if (c_flock(self%descriptor, alone_at_once) == 0) return
      call c_f_pointer(c_errno_location(), errno)
      others = errno == taken
      call drop(self)
   end subroutine open_and_lock

   !> Whether the file that is open still has its name.
   logical function is_its_name(self)
      class(run_lock_t), intent(in) :: self
      integer(c_int64_t) :: of_name(room), of_file(room)
      is_its_name = .false.
      if (c_stat(self%path//c_null_char, of_name) /= 0) return
      if (c_fstat(self%descriptor, of_file) /= 0) return
      is_its_name = all(of_name(:identity) == of_file(:identity))
   end function is_its_name

   !> Release the lock; its file is removed first, so that nobody gets a lock on a file without a name and believes to be alone.
   subroutine release(self)
      class(run_lock_t), intent(inout) :: self
      if (self%descriptor < 0) return
      call remove_file(self%path)
      call drop(self)
   end subroutine release

   !> Close the file, and with it the lock.
   subroutine drop(self)
      class(run_lock_t), intent(inout) :: self
      integer(c_int) :: status
      status = c_close(self%descriptor)
      self%descriptor = -1
   end subroutine drop
end module hampm_run_lock
