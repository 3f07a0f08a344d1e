!> Sets that are joined one by one, of things that are numbered: which are connected when pairs of them are. Each set is known by
!> its least member.
!>
!> Source: Cormen, Leiserson, Rivest and Stein, Introduction to Algorithms (2009), chapter 21.
module hampm_disjoint_sets
   implicit none
   private
   public :: disjoint_sets_t, singletons

   !> Sets of 1 to n.
   type :: disjoint_sets_t
      integer, allocatable, private :: next(:)   !! a lesser member of the same set, or the same one where it is the least
   contains
      procedure :: join
      procedure :: least_of
      procedure :: how_many
   end type disjoint_sets_t

contains

   !> A set for each of 1 to n.
   pure subroutine singletons(n, sets)
      integer, intent(in) :: n
      type(disjoint_sets_t), intent(out) :: sets
      integer :: k
      sets%next = [(k, k=1, n)]
   end subroutine singletons

   !> Merge the sets of `a` and `b`; the paths from both to the least member become short.
   pure subroutine join(self, a, b)
      class(disjoint_sets_t), intent(inout) :: self
      integer, intent(in) :: a, b
      integer :: one, two
      one = self%least_of(a)
      two = self%least_of(b)
      self%next(max(one, two)) = min(one, two)
      self%next(a) = min(one, two)
      self%next(b) = min(one, two)
   end subroutine join

   !> The least member of the set of `k`.
   pure integer function least_of(self, k) result(least)
      class(disjoint_sets_t), intent(in) :: self
      integer, intent(in) :: k
      least = k
      do while (self%next(least) < least)
         least = self%next(least)
      end do
   end function least_of

   !> Number of sets, or of those that have a member less than `below`.
   pure integer function how_many(self, below)
      class(disjoint_sets_t), intent(in) :: self
      integer, intent(in), optional :: below
      integer :: k, most
      most = size(self%next)
      if (present(below)) most = min(most, below - 1)
      how_many = count([(self%next(k) == k, k=1, most)])
   end function how_many
end module hampm_disjoint_sets
