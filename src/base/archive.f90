!> Store of the items that a run has to save: one list of items serves writing and reading, where each item gets its stored value.
!> Types list their items without knowing the kind of store; `hampm_checkpoint` is one, a file.
module hampm_archive
   use hampm_kinds, only: dp, long
   use hampm_column_visitor, only: column_visitor_t
   use hampm_failure, only: failure_t
   implicit none
   private
   public :: archive_t

   !> An archive that is being written or read. It visits the columns of a table to keep them.
   type, abstract, extends(column_visitor_t) :: archive_t
      logical :: is_read = .false.               !! whether it is read, else it is written
      type(failure_t) :: failure                 !! the first thing that went wrong; nothing is done after it
   contains
      procedure :: serialise
      procedure :: archive_logicals
      procedure :: reals
      procedure :: integers
      procedure :: longs
      procedure(archive_text), deferred :: archive_text
      procedure(archive_reals), deferred :: archive_reals
      procedure :: archive_integers
      procedure(archive_longs), deferred :: archive_longs
      procedure(section), deferred :: section
      procedure(refuse), deferred :: refuse
   end type archive_t

   abstract interface
      !> Keep a text.
      subroutine archive_text(self, name, text)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         character(*), intent(in) :: name
         character(:), allocatable, intent(inout) :: text
      end subroutine archive_text

      !> Keep the first `n` elements of an array of real numbers of any shape.
      subroutine archive_reals(self, name, n, values)
         import :: archive_t, dp
         class(archive_t), intent(inout) :: self
         character(*), intent(in) :: name
         integer, intent(in) :: n
         real(dp), intent(inout) :: values(n)
      end subroutine archive_reals

      !> Keep the first `n` elements of an array of long integers of any shape.
      subroutine archive_longs(self, name, n, values)
         import :: archive_t, long
         class(archive_t), intent(inout) :: self
         character(*), intent(in) :: name
         integer, intent(in) :: n
         integer(long), intent(inout) :: values(n)
      end subroutine archive_longs

      !> The items that follow belong together.
      subroutine section(self, name)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         character(*), intent(in) :: name
      end subroutine section

      !> Report that the values read cannot be right.
      subroutine refuse(self, why)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         character(*), intent(in) :: why
      end subroutine refuse
   end interface

contains

   !> Keep a column of real numbers.
   subroutine reals(self, n, width, values)
      class(archive_t), intent(inout) :: self
      integer, intent(in) :: n, width
      real(dp), intent(inout) :: values(n, width)
      call self%archive_reals(trim(self%name), n*width, values)
   end subroutine reals

   !> Keep a column of integers.
   subroutine integers(self, n, values)
      class(archive_t), intent(inout) :: self
      integer, intent(in) :: n
      integer, intent(inout) :: values(n)
      call self%archive_integers(trim(self%name), n, values)
   end subroutine integers

   !> Keep a column of long integers.
   subroutine longs(self, n, values)
      class(archive_t), intent(inout) :: self
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      call self%archive_longs(trim(self%name), n, values)
   end subroutine longs

   !> Keep a real number, an integer of any kind, or a logical value.
   subroutine serialise(self, name, value)
      class(archive_t), intent(inout) :: self
      character(*), intent(in) :: name
      class(*), intent(inout) :: value
      real(dp) :: reals(1)
      integer(long) :: longs(1)
      select type (value)
       type is (real(dp))
         reals = value
         call self%archive_reals(name, 1, reals)
         value = reals(1)
       type is (integer(long))
         longs = value
         call self%archive_longs(name, 1, longs)
         value = longs(1)
       type is (integer)
         longs = value
         call self%archive_longs(name, 1, longs)
         value = int(longs(1))
       type is (logical)
         longs = merge(1, 0, value)
         call self%archive_longs(name, 1, longs)
         value = longs(1) == 1
      end select
   end subroutine serialise

   !> Keep the first `n` elements of an array of integers of any shape.
   subroutine archive_integers(self, name, n, values)
      class(archive_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      integer, intent(inout) :: values(n)
      integer(long), allocatable :: wide(:)
      allocate (wide, source=int(values, long))
      call self%archive_longs(name, n, wide)
      values = int(wide)
   end subroutine archive_integers

   !> Keep the first `n` elements of an array of logical values of any shape.
   subroutine archive_logicals(self, name, n, values)
      class(archive_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      logical, intent(inout) :: values(n)
      integer, allocatable :: numbers(:)
      allocate (numbers(n))
      numbers = merge(1, 0, values)
      call self%archive_integers(name, n, numbers)
      values = numbers == 1
   end subroutine archive_logicals
end module hampm_archive
