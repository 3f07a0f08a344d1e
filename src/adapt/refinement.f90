!> Cells and particles that refine and recombine by themselves: an indicator marks leaves, the forest follows and is balanced, and
!> grid and particles follow the forest.
module hampm_refinement
   use hampm_kinds, only: dp, ndim, long, name_len
   use hampm_archive, only: archive_t
   use hampm_cell_values, only: mean_of_nodes, is_occupied
   use hampm_error_indicator, only: estimate_errors
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, outside
   use hampm_gradient_indicator, only: nodal_field, refinement_parameter
   use hampm_grid, only: grid_t
   use hampm_matching, only: adopt_forest, match_particles, are_matched
   use hampm_problem, only: problem_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: refine_t, refinement_t, refine_at_start, refine, follow_particles, archive_refinement

   real(dp), parameter :: marked_part = 0.5_dp   !! of the squared error, in the cells that are refined at once (Doerfler 1996)
   real(dp), parameter :: most_static = 0.8_dp   !! the same where each mesh takes a solution: few of them cost less than few cells

   !> What tells cells to refine, its thresholds and limits: the keys of &refine.
   type :: refine_t
      character(name_len) :: indicator = 'none'  !! 'none', 'gradient', 'zz' or 'tip'; 'none' where the group is absent
      character(name_len) :: field = ''          !! of gradient: 'energy_density', 'stress_norm' or 'speed'
      real(dp) :: r_crit = 0                     !! of gradient: mean R of a cell above which it refines [-]
      real(dp) :: r_coarsen = 0                  !! of gradient: R below which families recombine, 0: never [-]
      real(dp) :: tolerance = 0                  !! of zz: relative error in the energy norm [-]
      integer :: rings = 0                       !! of tip: distance from the tip, in cells of each level
      integer :: max_level = 0                   !! level of the finest cells, 0: the root cells
      real(dp) :: energy_floor = 0               !! of gradient: part of its largest value below which the field is not looked at
      real(dp) :: region_lower(ndim) = -huge(1.0_dp)   !! box in which cells may refine [m]; -huge and huge where it has no
      real(dp) :: region_upper(ndim) = huge(1.0_dp)    !! limit: compare with them, their difference overflows
      real(dp) :: start = 0                      !! time of the first look at gradient or zz [s]
      integer :: interval = 1                    !! steps between looks at the indicator
      integer :: max_particles = huge(1)         !! refinement ends where there would be more particles
   end type refine_t

   !> The same in a run, and what was found at the last look.
   type, extends(refine_t) :: refinement_t
      logical :: is_static = .false.             !! whether each mesh takes a solution
      logical :: tips_move = .false.             !! whether tips move through the grid
      logical :: reached_max_level = .false.     !! whether a leaf would have been refined further
      logical :: reached_max_particles = .false. !! whether refinement has ended
      real(dp) :: largest_r = 0                  !! largest mean R of a leaf in the box at the last look
      real(dp) :: relative_error = 0             !! estimated at the last look, of 'zz'
   contains
      procedure :: is_active
      procedure :: follows_motion
      procedure :: is_due
      procedure :: warning
   end type refinement_t

contains

   !> Whether cells refine at all.
   pure logical function is_active(self)
      class(refinement_t), intent(in) :: self
      is_active = self%indicator /= 'none' .and. self%max_level > 0
   end function is_active

   !> Whether the mesh may change during the run: cells around a tip stay where the tip does.
   pure logical function follows_motion(self)
      class(refinement_t), intent(in) :: self
      follows_motion = self%is_active() .and. (self%indicator /= 'tip' .or. self%tips_move)
   end function follows_motion

   !> Whether after a step, or several at once, it is time to look.
   pure logical function is_due(self, time, before, steps)
      class(refinement_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      integer(long), intent(in) :: before        !! steps done before
      integer(long), intent(in) :: steps         !! and now
      is_due = self%follows_motion() .and. time >= self%start .and. steps/self%interval > before/self%interval
   end function is_due

   !> Refine before the first step as far as that does not depend on the motion. Quadratic cells that are cut have more particles from the
   !> start, and particles through which a crack runs are split.
   subroutine refine_at_start(r, m, tips, failure)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)         !! places of the crack tips, here and below [m], (ndim, number)
      type(failure_t), intent(inout) :: failure
      logical :: adapted
      if (.not. are_matched(m)) call match_particles(m, failure)
      adapted = r%is_active() .and. r%indicator == 'tip'
      do while (adapted .and. .not. failure%failed())
         call refine(r, m, tips, adapted, failure)
      end do
   end subroutine refine_at_start

   !> After a step in which particles have moved to other cells: split and recombine those that no longer fit.
   subroutine follow_particles(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      if (.not. m%grid%forest%is_uniform() .or. m%has_domains()) call match_particles(m, failure)
   end subroutine follow_particles

   !> Look at the indicator and adapt the grid by one level where it asks for it. `adapted` tells whether anything changed.
   subroutine refine(r, m, tips, adapted, failure)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      logical, intent(out) :: adapted
      type(failure_t), intent(inout) :: failure
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      adapted = .false.
      allocate (change(m%grid%forest%leaf_count()), source=0)
      select case (r%indicator)
      case ('tip')
         call mark_around_tips(r, m, tips, change)
      case ('gradient')
         call mark_by_gradient(r, m, change)
      case ('zz')
         call mark_by_error(r, m, change)
      end select
      if (all(change == 0)) return
      forest = m%grid%forest
      call forest%adapt(change)
      if (forest%same_leaves(m%grid%forest)) return
      call forest%balance()
      call even_out(tips, forest)
      if (forest%same_leaves(m%grid%forest)) return
      if (would_exceed(r, m, forest)) return
      call adopt_forest(m, forest, failure)
      adapted = .true.
   end subroutine refine

   !> Whether a leaf may be refined; where only its level stands against it, that is noted.
   logical function may_refine(r, m, leaf) result(may)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(in) :: m
      integer, intent(in) :: leaf
      may = is_occupied(m%grid, m%blocks, leaf) .and. is_in_box(r, m, leaf)
      if (.not. may) return
      may = m%grid%forest%level_of(leaf) < r%max_level
      r%reached_max_level = r%reached_max_level .or. .not. may
   end function may_refine

   !> Whether the middle of a leaf is in the box.
   pure logical function is_in_box(r, m, leaf)
      type(refinement_t), intent(in) :: r
      type(problem_t), intent(in) :: m
      integer, intent(in) :: leaf
      associate (x => m%grid%forest%middle_of(leaf))
         is_in_box = all(x >= r%region_lower .and. x <= r%region_upper)
      end associate
   end function is_in_box

   !> Refine the leaves that are within `rings` cells of their own size of a tip. Behind tips that move, recombine those that are further
   !> away than what is refined around these by a cell of the next size.
   subroutine mark_around_tips(r, m, tips, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: tips(:, :)
      integer, intent(inout) :: change(:)
      real(dp), parameter :: rounding = 1e-9_dp  ! of distances, in cells: that of a tip in the middle of one from others is a whole number
      real(dp) :: distance, edge
      integer :: leaf, k
      do leaf = 1, size(change)
         distance = minval([(maxval(abs(m%grid%forest%middle_of(leaf) - tips(:, k))), k=1, size(tips, 2))])
         edge = m%grid%forest%size_of(leaf)
         if (r%tips_move .and. distance > (r%rings + 1)*2*edge*(1 + rounding)) change(leaf) = -1
         if (distance >= r%rings*edge*(1 - rounding) .or. m%grid%forest%level_of(leaf) >= r%max_level) cycle
         if (may_refine(r, m, leaf)) change(leaf) = 1
      end do
   end subroutine mark_around_tips

   !> Refine the leaves with a mean R above `r_crit`, and recombine those with one below `r_coarsen`.
   subroutine mark_by_gradient(r, m, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      integer, intent(inout) :: change(:)
      real(dp), allocatable :: phi(:), parameter(:)
      real(dp) :: mean, least
      integer :: leaf
      call nodal_field(m, r%field, phi)
      call refinement_parameter(m, r%field, phi, parameter)
      least = max(r%energy_floor*maxval(phi), rounding_of(m, r%field))
      r%largest_r = 0
      do leaf = 1, size(change)
         if (.not. is_occupied(m%grid, m%blocks, leaf)) then
            if (r%r_coarsen > 0) change(leaf) = -1
            cycle
         end if
         mean = mean_of_nodes(m%grid, leaf, parameter)
         if (mean_of_nodes(m%grid, leaf, phi) <= least) mean = 0
         if (is_in_box(r, m, leaf)) r%largest_r = max(r%largest_r, mean)
         if (mean > r%r_crit) then
            if (may_refine(r, m, leaf)) change(leaf) = 1
         else if (mean < r%r_coarsen) then
            change(leaf) = -1
         end if
      end do
   end subroutine mark_by_gradient

   !> As long as the estimated relative error is above `tolerance`, refine the leaves with the largest errors, as few as hold a
   !> part `marked_part` of its square, and those whose errors are as large as the least of them but for rounding: of two leaves that are
   !> mirror images of each other rounding would choose one.
   subroutine mark_by_error(r, m, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      integer, intent(inout) :: change(:)
      real(dp), allocatable :: squared(:)
      logical, allocatable :: open(:)
      real(dp), parameter :: alike = sqrt(epsilon(1.0_dp))  ! squares that differ by less, as a part of them, are the same
      real(dp) :: norm, total, part, low, high, middle
      integer :: leaf, k
      call estimate_errors(m, squared, norm)
      total = sum(squared)
      r%relative_error = 0
      if (norm + total > sum(m%particles%volume(:m%particles%n))*rounding_of(m, 'energy_density')) &
         r%relative_error = sqrt(total/(norm + total))
      if (r%relative_error <= r%tolerance) return
      allocate (open(size(squared)))
      do leaf = 1, size(squared)
         open(leaf) = squared(leaf) > 0 .and. is_in_box(r, m, leaf)
      end do
      if (.not. any(open)) return                ! no material in the box, or none strained there
      total = sum(squared, mask=open)
      part = part_to_mark(r)
      low = 0
      high = maxval(squared, mask=open)
      do k = 1, digits(high)                     ! the leaves above `low` hold the part, those above `high` do not
         middle = (low + high)/2
         if (sum(squared, mask=open .and. squared >= middle) >= part*total) then
            low = middle
         else
            high = middle
         end if
      end do
      do leaf = 1, size(squared)
         if (open(leaf) .and. squared(leaf) >= (1 - alike)*low) then
            if (may_refine(r, m, leaf)) change(leaf) = 1
         end if
      end do
   end subroutine mark_by_error

   !> What rounding of where particles have moved to, and of strains without stress, makes of a field of the gradient indicator: cells are not to refine by
   !> that, as those of a body that falls freely would.
   pure real(dp) function rounding_of(m, field) result(value)
      type(problem_t), intent(in) :: m
      character(*), intent(in) :: field
      real(dp), parameter :: rounding = 1e-12_dp ! over many steps
      real(dp) :: strain, speed
      integer :: k
      associate (p => m%particles)
         strain = rounding*(maxval(abs(p%displacement(:p%n, :)))/m%grid%finest_cell &
                            + maxval([(maxval(abs(m%materials(k)%free)), k=1, size(m%materials))]))
         speed = maxval([(m%materials(k)%shear_wave_speed(), k=1, size(m%materials))])
         value = strain*speed
         if (field /= 'speed') value = strain*speed**2*maxval(p%mass(:p%n)/p%volume(:p%n))
         if (field == 'energy_density') value = strain*value
      end associate
   end function rounding_of

   !> Part of the squared error in the cells that are refined at once. At rest no more than it takes: of what halved cells hold a quarter
   !> is left, where the solution is smooth.
   pure real(dp) function part_to_mark(r) result(part)
      type(refinement_t), intent(in) :: r
      part = marked_part
      if (r%is_static) part = min(most_static, max(0.3_dp, (1 - (r%tolerance/r%relative_error)**2)*4/3))
   end function part_to_mark

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
      real(dp) :: reach, tolerance
      tolerance = forest%tolerance()
      reach = 0
      finest = 0
      do leaf = 1, forest%leaf_count()           ! the coarsest cell at the tip, and the finest at the cells at the tip
         if (distance_to(leaf) <= tolerance) reach = max(reach, forest%size_of(leaf))
      end do
      do leaf = 1, forest%leaf_count()
         if (distance_to(leaf) <= reach + tolerance) finest = max(finest, forest%level_of(leaf))
      end do
      do leaf = 1, size(change)
         if (distance_to(leaf) <= tolerance .and. forest%level_of(leaf) < finest) change(leaf) = 1
      end do
   contains
      !> Distance of the tip from a leaf [m].
      pure real(dp) function distance_to(leaf) result(distance)
         integer, intent(in) :: leaf
         distance = maxval(abs(forest%middle_of(leaf) - tip)) - 0.5_dp*forest%size_of(leaf)
      end function distance_to
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

   !> What the user should know at the end; '' where there is nothing.
   function warning(self, steps, refined) result(text)
      class(refinement_t), intent(in) :: self
      integer(long), intent(in) :: steps         !! that the run has taken, 0 where the model is only checked
      logical, intent(in) :: refined             !! whether there are cells that are refined
      character(:), allocatable :: text
      text = ''
      if (self%reached_max_particles) then
         text = 'refinement ended at &refine max_particles = '//to_text(self%max_particles)// &
                ': cells that would have been refined further were not. '//advice(self)
      else if (self%reached_max_level) then
         text = 'refinement reached &refine max_level = '//to_text(self%max_level)// &
                ': cells that would have been refined further were not'
      else if (self%follows_motion() .and. self%indicator /= 'tip' .and. .not. self%is_static .and. &
               steps > 0 .and. steps < self%interval) then
         text = 'no cell has refined: &refine interval = '//to_text(self%interval)//' is more than the '//to_text(int(steps))// &
                ' steps of the run'
      else if (self%indicator == 'tip' .and. self%max_level > 0 .and. .not. refined) then
         text = 'no cell has refined: there is none within &refine rings = '//to_text(self%rings)// &
                ' cells of a crack tip in the box from region_lower to region_upper'
      end if
   end function warning

   !> What to do where refinement has come to more particles than it may have.
   function advice(self) result(text)
      class(refinement_t), intent(in) :: self
      character(:), allocatable :: text
      select case (self%indicator)
       case ('gradient')
         text = 'a larger r_crit'
       case ('zz')
         text = 'a larger tolerance'
       case default
         text = 'fewer rings'
      end select
      text = 'Give '//text//' or a smaller max_level, or allow more'
   end function advice

   !> Keep how cells are refined.
   subroutine archive_refinement(r, archive)
      type(refinement_t), intent(inout) :: r
      class(archive_t), intent(inout) :: archive
      call archive%section('refinement')
      call archive%serialise('reached_max_level', r%reached_max_level)
      call archive%serialise('reached_max_particles', r%reached_max_particles)
      call archive%serialise('largest_r', r%largest_r)
      call archive%serialise('relative_error', r%relative_error)
   end subroutine archive_refinement
end module hampm_refinement
