!> Cells and particles that refine and recombine by themselves: an indicator marks leaves, the forest follows and is balanced, and
!> grid and particles follow the forest.
module hampm_refinement
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_crack_lines, only: line_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, outside
   use hampm_indicator, only: refinement_t, indicator_row_t
   use hampm_indicators, only: indicators
   use hampm_matching, only: adopt_forest, match_particles, are_matched, complete_mesh
   use hampm_part_supports, only: keep_cells_at_ends
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: refine_at_start, refine, follow_particles, archive_refinement

contains

   !> Refine before the first step as far as that does not depend on the motion. Cut quadratic cells have more particles from the
   !> start, and particles with a crack through them are split. For material at rest no fields are transferred: only the last mesh
   !> is completed.
   subroutine refine_at_start(r, m, tips, failure)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)         !! places of the crack tips, here and below [m], (ndim, number)
      type(failure_t), intent(inout) :: failure
      logical :: adapted
      integer :: before
      before = m%particles%n
      m%cache%is_provisional = .not. (any(abs(m%particles%velocity(:before, :)) > 0) .or. m%has_domains())
      if (.not. are_matched(m)) call match_particles(m, failure)
      adapted = r%is_active() .and. r%by%is_of_places
      do while (adapted .and. .not. failure%failed())
         call refine(r, m, tips, adapted, failure)
      end do
      if (m%particles%n > before .and. m%cache%is_provisional .and. .not. failure%failed()) call complete_mesh(m, failure)
      m%cache%is_provisional = .false.
   end subroutine refine_at_start

   !> After a step in which particles have moved to other cells: split and recombine those that no longer fit.
   subroutine follow_particles(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      if (.not. m%grid%forest%is_uniform() .or. m%has_domains()) call match_particles(m, failure)
   end subroutine follow_particles

   !> Evaluate the indicator and adapt the grid by one level where it requires it. `adapted` tells whether anything changed; only
   !> then cells are cut along other lines.
   subroutine refine(r, m, tips, adapted, failure, lines)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      logical, intent(out) :: adapted
      type(failure_t), intent(inout) :: failure
      type(line_t), allocatable, intent(in), optional :: lines(:) !! where cells are to be cut along others than before
      type(forest_t) :: forest
      type(indicator_row_t), allocatable :: rows(:)
      integer, allocatable :: change(:)
      integer :: k
      adapted = .false.
      allocate (change(m%grid%forest%leaf_count()), source=0)
      allocate (rows, source=indicators())
      k = findloc(rows%name == r%by%name, .true., dim=1)
      call rows(k)%mark(r, m, tips, change)
      if (m%interfaces%are_moving) call keep_cells_at_ends(m%grid%forest, m%grid%is_quadratic(), m%constraints, change)
      if (all(change == 0)) return
      forest = m%grid%forest
      call forest%adapt(change)
      if (forest%same_leaves(m%grid%forest)) return
      call forest%balance()
      call even_out(tips, forest)
      if (forest%same_leaves(m%grid%forest)) return
      if (would_exceed(r, m, forest)) return
      call adopt_forest(m, forest, failure, lines)
      adapted = .true.
   end subroutine refine

   !> Refine until the cells at each tip and those around them are of one size, so that the nodes behind and ahead of it are at the
   !> same distance.
   subroutine even_out(tips, forest)
      real(dp), intent(in) :: tips(:, :)
      type(forest_t), intent(inout) :: forest
      integer, allocatable :: change(:)
      integer :: k
      do
         allocate (change(forest%leaf_count()), source=0)
         do k = 1, size(tips, 2)
            call mark_coarse_at_tip(tips(:, k), forest, change)
         end do
         if (all(change == 0)) return
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
   end subroutine even_out

   !> Mark the leaves at a tip that are coarser than the finest at the cells at the tip.
   subroutine mark_coarse_at_tip(tip, forest, change)
      real(dp), intent(in) :: tip(ndim)          !! [m]
      type(forest_t), intent(in) :: forest
      integer, intent(inout) :: change(:)        !! by leaf: 1 where it is to be refined
      integer :: leaf, finest
      real(dp) :: distance(size(change)), reach, tolerance
      tolerance = forest%tolerance()
      reach = 0
      finest = 0
      do leaf = 1, size(change)                  ! the coarsest cell at the tip, and the finest at the cells at the tip
         distance(leaf) = maxval(abs(forest%middle_of(leaf) - tip)) - 0.5_dp*forest%size_of(leaf)
         if (distance(leaf) <= tolerance) reach = max(reach, forest%size_of(leaf))
      end do
      do leaf = 1, size(change)
         if (distance(leaf) <= reach + tolerance) finest = max(finest, forest%level_of(leaf))
      end do
      do leaf = 1, size(change)
         if (distance(leaf) <= tolerance .and. forest%level_of(leaf) < finest) change(leaf) = 1
      end do
   end subroutine mark_coarse_at_tip

   !> Whether a forest would need more particles than allowed; refinement then ends.
   logical function would_exceed(r, m, forest) result(exceeds)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(in) :: m
      type(forest_t), intent(in) :: forest
      real(dp) :: particles
      integer :: i, leaf
      particles = 0
      associate (p => m%particles)
         do i = 1, p%n
            leaf = forest%leaf_at(p%place_in_grid(i))
            if (leaf == outside) cycle
            particles = particles + real(2**ndim, dp)**max(0, forest%level_of(leaf) - level_of_particle(i))
         end do
      end associate
      exceeds = particles > r%max_particles
      r%reached_max_particles = r%reached_max_particles .or. exceeds
   contains
      !> Level of the cells that a particle was made for; 0 where none was ever split.
      pure integer function level_of_particle(i) result(level)
         integer, intent(in) :: i
         level = 0
         if (allocated(m%particles%level)) level = m%particles%level(i)
      end function level_of_particle
   end function would_exceed

   !> Keep how cells are refined.
   subroutine archive_refinement(r, archive)
      type(refinement_t), intent(inout) :: r
      class(archive_t), intent(inout) :: archive
      call archive%section('refinement')
      call archive%serialise('reached_max_level', r%reached_max_level)
      call archive%serialise('reached_max_particles', r%reached_max_particles)
      call archive%serialise('value', r%value)
   end subroutine archive_refinement
end module hampm_refinement
