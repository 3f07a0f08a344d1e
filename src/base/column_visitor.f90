!> Something that visits the columns of a table one after the other, such as the fields of the particles, and does with each the
!> same.
module hampm_column_visitor
   use hampm_kinds, only: dp, long, name_len
   implicit none
   private
   public :: column_visitor_t

   !> Action on each column, independent of its meaning.
   type, abstract :: column_visitor_t
      character(name_len) :: name = ''                  !! of the field that is visited
   contains
      procedure(visit_reals), deferred :: reals
      procedure(visit_integers), deferred :: integers
      procedure(visit_longs), deferred :: longs
   end type column_visitor_t

   abstract interface
      !> Visit a field of real numbers.
      subroutine visit_reals(self, n, width, values)
         import :: column_visitor_t, dp
         class(column_visitor_t), intent(inout) :: self
         integer, intent(in) :: n, width            ! number of particles, and of components
         real(dp), intent(inout) :: values(n, width)
      end subroutine visit_reals

      !> Visit a field of integers.
      subroutine visit_integers(self, n, values)
         import :: column_visitor_t
         class(column_visitor_t), intent(inout) :: self
         integer, intent(in) :: n
         integer, intent(inout) :: values(n)
      end subroutine visit_integers

      !> Visit a field of long integers.
      subroutine visit_longs(self, n, values)
         import :: column_visitor_t, long
         class(column_visitor_t), intent(inout) :: self
         integer, intent(in) :: n
         integer(long), intent(inout) :: values(n)
      end subroutine visit_longs
   end interface
end module hampm_column_visitor
