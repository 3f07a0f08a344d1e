!> Refined meshes, and what must hold of particles in them, for the unit tests.
module hampm_refined
   use hampm_kinds, only: dp, ndim
   use hampm_forest, only: forest_t
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: refine_box, misplaced, is_balanced, spans_lattice

contains

   !> Refine the leaves of which the middle is in a box, level by level.
   subroutine refine_box(forest, lower, upper, levels)
      type(forest_t), intent(inout) :: forest
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      integer, intent(in) :: levels
      integer, allocatable :: change(:)
      integer :: k, leaf
      do k = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         do leaf = 1, size(change)
            associate (x => forest%position(forest%place_of(leaf)) + 0.5_dp*forest%size_of(leaf))
               if (all(x >= lower .and. x <= upper) .and. forest%level_of(leaf) < k) change(leaf) = 1
            end associate
         end do
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
   end subroutine refine_box

   !> Number of particles that are not counted in exactly one leaf, the one within whose edges they are, or are coarser than it.
   pure integer function misplaced(m)
      type(problem_t), intent(in) :: m
      integer :: leaf, e, i, counted(m%particles%n)
      real(dp) :: lower(ndim)
      logical :: is_inside
      counted = 0
      misplaced = 0
      associate (p => m%particles, blocks => m%blocks, grid => m%grid)
         do leaf = 1, grid%forest%leaf_count()
            lower = grid%forest%position(grid%forest%place_of(leaf))
            do e = grid%leaf_element(leaf), grid%leaf_element(leaf + 1) - 1
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  counted(i) = counted(i) + 1
                  is_inside = all(p%place_in_grid(i) >= lower - 1.0e-12_dp .and. &
                                  p%place_in_grid(i) <= lower + grid%forest%size_of(leaf) + 1.0e-12_dp)
                  if (.not. is_inside .or. p%level(i) < grid%forest%level_of(leaf) .or. &
                      grid%element_leaf(p%cell(i)) /= leaf) misplaced = misplaced + 1
               end do
            end do
         end do
      end associate
      misplaced = misplaced + count(counted /= 1)
   end function misplaced

   !> Whether leaves that touch, at an edge or a corner, differ by one level at most: every pair of them is looked at.
   pure logical function is_balanced(forest)
      type(forest_t), intent(in) :: forest
      real(dp) :: middle(ndim, forest%leaf_count()), edge(forest%leaf_count())
      integer :: level(forest%leaf_count()), a, b
      do a = 1, size(level)
         level(a) = forest%level_of(a)
         edge(a) = forest%size_of(a)
         middle(:, a) = forest%position(forest%place_of(a)) + 0.5_dp*edge(a)
      end do
      is_balanced = .true.
      do a = 1, size(level)
         do b = a + 1, size(level)
            if (abs(level(a) - level(b)) < 2) cycle
            if (maxval(abs(middle(:, a) - middle(:, b))) < 0.5_dp*(edge(a) + edge(b))*(1 + 1.0e-9_dp)) is_balanced = .false.
         end do
      end do
   end function is_balanced

   !> Whether the leaves cover the lattice without gap or overlap: their middles are their own and the areas add up.
   pure logical function spans_lattice(forest)
      type(forest_t), intent(in) :: forest
      integer :: leaf
      real(dp) :: area
      area = 0
      spans_lattice = .true.
      do leaf = 1, forest%leaf_count()
         area = area + forest%size_of(leaf)**ndim
         if (forest%leaf_at(forest%position(forest%place_of(leaf)) + 0.5_dp*forest%size_of(leaf)) /= leaf) spans_lattice = .false.
      end do
      spans_lattice = spans_lattice .and. abs(area/(product(forest%cells)*forest%cell**ndim) - 1) < 1.0e-13_dp
   end function spans_lattice
end module hampm_refined
