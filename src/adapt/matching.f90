!> Particles as fine as the cells in which they are: split where their cell is finer than they are, recombined where all
!> siblings are in coarser cells. So a body that moves through a fine patch is split on entry and recombined behind it.
!>
!> A particle through whose middle a crack runs belongs to both of its sides: it is split into two, one on each.
!>
!> Domains of particles (`hampm_domains`) that have become much longer than their cell are split, too.
!>
!> The kinetic and strain energy that this gains or loses is booked in the energy balance.
module hampm_matching
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_basis, only: n_hourglasses
   use hampm_crack_lines, only: line_t
   use hampm_domains, only: longest_edge
   use hampm_energy, only: kinetic_energy
   use hampm_failure, only: failure_t
   use hampm_grading, only: give_materials_of_places
   use hampm_forest, only: forest_t, outside
   use hampm_grid_building, only: build_grid, add_points
   use hampm_plane_cuts, only: plane_cut_t
   use hampm_interface_points, only: interfaces_t
   use hampm_load_following, only: follow_split, follow_recombination
   use hampm_loads, only: share_by_mass
   use hampm_problem, only: problem_t, rebuild_on_grid, sort_particles, sort_anew, weigh_particles, stored_energy, dissipated_energy
   use hampm_nodal_transfer, only: old_mesh_t, leave_mesh, carry_nodes
   use hampm_outline, only: outline_t
   use hampm_quadratic_children, only: values_of_children, values_of_parents, give_to_children, give_to_parents
   use hampm_splitting, only: start_families, split, recombine
   use hampm_children, only: middle_of_parent, times_split
   use hampm_leaf_fields, only: is_on_crack, displacement_hourglasses, velocity_gradients
   implicit none
   private
   public :: match_particles, are_matched, adopt_forest, adopt_lines, complete_mesh

   !> Edges of domains over the size of their cell, above which they are split, and below which a parent's must be for its children
   !> to recombine
   real(dp), parameter :: longest = 1.5_dp, shortest = 1.2_dp
   integer, parameter :: most_on_crack = 3       !! how often more than others a particle on a crack may be split

contains

   !> Build the grid of another forest, and make the particles fit it. Fails where the memory does not suffice or a particle has
   !> left the grid.
   subroutine adopt_forest(m, forest, failure, new_lines)
      type(problem_t), intent(inout) :: m
      type(forest_t), intent(in) :: forest
      type(failure_t), intent(inout) :: failure
      type(line_t), allocatable, intent(in), optional :: new_lines(:) !! of its cut cells; absent: the last ones
      type(line_t), allocatable :: lines(:)
      type(interfaces_t), allocatable :: left    ! points of faces of cracks before
      real(dp) :: energy
      call start_families(m%particles)
      energy = total_energy(m)
      call split_marked(m, coarser_than(m, forest), failure)
      if (failure%failed()) return
      call split_marked(m, are_on_cracks(m), failure) ! both halves are to know of which side of the mesh that is left they are
      if (failure%failed()) return
      if (present(new_lines)) then
         lines = new_lines
      else if (m%grid%cut_cells%are_there()) then
         lines = m%grid%cut_cells%lines
      end if
      if (allocated(lines) .or. allocated(m%grid%planes)) left = m%interfaces
      call change_grid(m, forest, lines, failure)
      if (failure%failed()) return
      m%energies%numerical_loss = m%energies%numerical_loss + (energy - total_energy(m))
      call match_particles(m, failure, left)
   end subroutine adopt_forest

   !> Cut the cells of the grid along other lines. Fails as `adopt_forest`.
   subroutine adopt_lines(m, lines, failure)
      type(problem_t), intent(inout) :: m
      type(line_t), allocatable, intent(in) :: lines(:)
      type(failure_t), intent(inout) :: failure
      type(forest_t) :: forest
      type(interfaces_t) :: left
      real(dp) :: energy
      energy = total_energy(m)
      forest = m%grid%forest
      left = m%interfaces
      call change_grid(m, forest, lines, failure)
      if (failure%failed()) return
      m%energies%numerical_loss = m%energies%numerical_loss + (energy - total_energy(m))
      if (.not. are_matched(m)) call match_particles(m, failure, left)
   end subroutine adopt_lines

   !> Build the grid of a forest, cut along lines where there are any, and sort the particles into it.
   subroutine change_grid(m, forest, lines, failure)
      type(problem_t), intent(inout) :: m
      type(forest_t), intent(in) :: forest
      type(line_t), allocatable, intent(in) :: lines(:)
      type(failure_t), intent(inout) :: failure
      type(old_mesh_t), allocatable :: old
      type(outline_t), allocatable :: bodies(:)
      integer, allocatable :: velocity_fields(:)
      real(dp), allocatable :: solids(:, :, :)
      type(plane_cut_t), allocatable :: planes(:)
      call leave_mesh(m, old)
      if (allocated(m%grid%bodies)) allocate (bodies, source=m%grid%bodies)
      if (allocated(m%grid%field_of_body)) allocate (velocity_fields, source=m%grid%field_of_body)
      if (m%grid%is_quadratic()) allocate (solids, source=m%grid%solids)
      if (allocated(m%grid%planes)) allocate (planes, source=m%grid%planes)
      call build_grid(forest, m%grid, failure, lines, bodies, velocity_fields, solids, m%cache%is_provisional, planes)
      if (.not. failure%failed()) call sort_particles(m, failure)
      if (.not. failure%failed()) call rebuild_on_grid(m, failure)
      if (allocated(old) .and. .not. failure%failed()) call carry_nodes(old, m)
   end subroutine change_grid

   !> Complete a provisional mesh: the nodes of its cells, the weights of its particles, and all that depends on both.
   subroutine complete_mesh(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      real(dp) :: energy
      m%cache%is_provisional = .false.
      energy = total_energy(m)
      if (m%grid%n_points == 0) call add_points(m%grid, failure)
      if (failure%failed()) return
      if (m%grid%is_quadratic()) call weigh_particles(m)
      call rebuild_on_grid(m, failure)
      m%energies%numerical_loss = m%energies%numerical_loss + (energy - total_energy(m))
   end subroutine complete_mesh

   !> Split and recombine until every particle fits its cell. Fails where the memory does not suffice. Interface points placed while
   !> a particle on a crack was on one of its sides are placed again, from those of the mesh that was left: the sides are alike.
   subroutine match_particles(m, failure, left)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(interfaces_t), intent(in), optional :: left !! interface points before the mesh was changed
      logical, allocatable :: marked(:)
      logical :: at_lines                        ! whether pieces of cells get other particles, which interface points follow
      real(dp) :: energy
      integer :: families
      call start_families(m%particles)
      marked = coarser_than_cell(m)
      if (.not. any(marked) .and. .not. any(finer_than_cell(m))) return
      energy = total_energy(m)
      at_lines = .false.
      do while (any(marked))
         at_lines = at_lines .or. .not. are_matched(m)
         call split_marked(m, marked, failure)
         if (failure%failed()) return
         marked = coarser_than_cell(m)
      end do
      do
         call recombine_marked(m, finer_than_cell(m), families, failure)
         if (failure%failed() .or. families == 0) exit
      end do
      if (at_lines .and. present(left)) m%interfaces = left
      if ((at_lines .or. has_fuller_cells(m)) .and. .not. failure%failed()) call rebuild_on_grid(m, failure)
      m%energies%numerical_loss = m%energies%numerical_loss + (energy - total_energy(m))
   end subroutine match_particles

   !> Which particles are coarser than their leaf of a forest, or have domains that are much longer. Particles on the lines that
   !> quarter a bilinear leaf beside finer ones are split while it is whole: velocity gradients differ between its quarters.
   pure function coarser_than(m, forest) result(coarser)
      type(problem_t), intent(in) :: m
      type(forest_t), intent(in) :: forest
      logical, allocatable :: coarser(:)
      integer :: i, leaf
      allocate (coarser(m%particles%n), source=.false.)
      do i = 1, m%particles%n
         leaf = forest%leaf_at(m%particles%place_in_grid(i))
         if (leaf == outside) cycle
         coarser(i) = times_split(m%particles, i) < level_in(m, forest, leaf, m%particles%body(i))
         if (m%has_domains() .and. .not. coarser(i)) coarser(i) = longest_edge(m%particles, i) > longest*forest%size_of(leaf)
      end do
   end function coarser_than

   !> Which particles are coarser than they have to be in the leaf in which they stand.
   pure function coarser_than_cell(m) result(coarser)
      type(problem_t), intent(in) :: m
      logical, allocatable :: coarser(:)
      integer :: i
      coarser = coarser_than(m, m%grid%forest)
      if (.not. (has_fuller_cells(m) .or. m%grid%cut_cells%are_there())) return
      do i = 1, m%particles%n
         if (times_split(m%particles, i) < level_for(m, i)) coarser(i) = .true.
      end do
      coarser = coarser .or. are_on_cracks(m)
   end function coarser_than_cell

   !> Which particles are to be split as cracks run through their middles.
   pure function are_on_cracks(m) result(on)
      type(problem_t), intent(in) :: m
      logical, allocatable :: on(:)
      integer :: i
      allocate (on(m%particles%n), source=.false.)
      if (.not. m%grid%cut_cells%are_there()) return
      do i = 1, m%particles%n
         if (m%particles%level(i) < level_for(m, i) + most_on_crack) on(i) = is_on_crack(m, i)
      end do
   end function are_on_cracks

   !> Whether particles fit their cells without a check of each: no cell must have more of them than others, and no crack runs
   !> through a particle.
   pure logical function are_matched(m)
      type(problem_t), intent(in) :: m
      integer :: i
      are_matched = .not. has_fuller_cells(m)
      if (are_matched .and. m%grid%cut_cells%are_there() .and. .not. m%has_domains()) &
         are_matched = .not. any([(is_on_crack(m, i), i=1, m%particles%n)])
   end function are_matched

   !> Whether some cells are to have more particles than others: quadratic ones that are cut, or bilinear ones beside finer ones.
   pure logical function has_fuller_cells(m)
      type(problem_t), intent(in) :: m
      integer :: i
      if (m%grid%is_quadratic()) then
         has_fuller_cells = m%grid%cut_cells%are_there() .or. allocated(m%grid%bodies)
      else
         has_fuller_cells = .not. m%grid%forest%is_uniform() .and. any([(is_odd(m, i), i=1, size(m%particles%spacing, 2))])
      end if
   end function has_fuller_cells

   !> Whether cells are quadratic and uncut (lines along their edges do not cut), so that their particles have all children.
   pure logical function has_whole_cells(m)
      type(problem_t), intent(in) :: m
      integer :: leaf
      has_whole_cells = m%grid%is_quadratic() .and. .not. allocated(m%grid%bodies)
      if (has_whole_cells) has_whole_cells = .not. any([(m%grid%is_cut(leaf), leaf=1, m%grid%forest%leaf_count())])
   end function has_whole_cells

   !> Whether the number of particles of a body along a cell is odd: then some stand on the lines that quarter it. Domains may cross
   !> these, and for a body that does not fill its cells exactly the number is not whole.
   pure logical function is_odd(m, body)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: body
      real(dp), parameter :: rounding = 1e-6_dp
      real(dp) :: number(ndim)
      number = m%grid%forest%cell/m%particles%spacing(:, body)
      is_odd = .not. m%has_domains() .and. any(mod(nint(number), 2) == 1 .and. abs(number - nint(number)) < rounding)
   end function is_odd

   !> Number of splits of a particle in its leaf: one for each level, and one more if the leaf is a cut quadratic one, or a bilinear
   !> one stored as its quarters, each of which needs particles.
   pure integer function level_for(m, i) result(level)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i                   !! particle
      associate (leaf => m%grid%element_leaf(m%particles%cell(i)))
         level = m%grid%forest%level_of(leaf)
         if (m%grid%is_quadratic()) then
            if (m%grid%is_cut(leaf)) level = level + 1
         else if (m%grid%is_transition(leaf)) then
            if (is_odd(m, m%particles%body(i))) level = level + 1
         end if
      end associate
   end function level_for

   !> How often a particle of a body is to be split in a leaf of a forest that is not cut.
   pure integer function level_in(m, forest, leaf, body) result(level)
      type(problem_t), intent(in) :: m
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf, body
      level = forest%level_of(leaf)
      if (forest%is_uniform() .or. m%grid%is_quadratic()) return
      if (is_odd(m, body)) level = level + merge(1, 0, forest%meets_finer(leaf))
   end function level_in

   !> Which particles are finer than their cell and not separated by a crack from the middle of their parent, nor that middle on a
   !> crack: siblings on both sides of a crack stay apart.
   pure function finer_than_cell(m) result(finer)
      type(problem_t), intent(in) :: m
      logical, allocatable :: finer(:)
      real(dp) :: x(ndim), middle(ndim)
      integer :: i
      allocate (finer(m%particles%n))
      associate (grid => m%grid, p => m%particles)
         do i = 1, p%n
            finer(i) = times_split(p, i) > level_for(m, i)
            if (finer(i) .and. m%has_domains()) finer(i) = 2*longest_edge(p, i) < shortest*grid%leaf_size(p%cell(i))
            if (.not. finer(i) .or. .not. grid%cut_cells%are_there()) cycle
            x = p%reference(i, :)
            middle = middle_of_parent(p, i)
            finer(i) = .not. (grid%cut_cells%divide(x, middle) .or. grid%cut_cells%is_on_line(grid%element_leaf(p%cell(i)), middle))
         end do
      end associate
   end function finer_than_cell

   !> Split the marked particles and sort.
   subroutine split_marked(m, marked, failure)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: marked(:)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: first_child(:)
      real(dp), allocatable :: gradients(:, :, :), hourglasses(:, :, :), values(:, :, :), normal(:, :), from(:, :)
      logical, allocatable :: on(:)
      if (.not. any(marked)) return
      allocate (gradients(ndim, ndim, count(marked)), hourglasses(ndim, n_hourglasses, count(marked)), source=0.0_dp)
      if (.not. (m%has_domains() .or. m%grid%is_quadratic() .or. m%cache%is_provisional)) then ! own fields, or none
         if (any(abs(m%particles%velocity(:m%particles%n, :)) > 0)) gradients = velocity_gradients(m, marked)
         hourglasses = displacement_hourglasses(m, marked)
      end if
      if (has_whole_cells(m) .and. .not. m%cache%is_provisional) values = values_of_children(m, marked)
      normal = normals_of_cracks(m, marked)
      from = m%particles%reference
      on = are_on_cracks(m)
      call split(m%particles, marked, gradients, hourglasses, normal, first_child, failure)
      if (failure%failed()) return
      if (m%particles%total_frame .and. m%grid%cut_cells%are_there() .and. .not. m%cache%is_provisional) &
         call change_sides(m, from, on, first_child)
      if (allocated(values)) call give_to_children(values, marked, first_child, m)
      if (.not. any(m%materials%has_history)) call give_materials_of_places(m%particles, m%materials)
      call follow_split(m%loads, m%grid%forest%tolerance(), m%particles, marked, first_child)
      call share_by_mass(m%loads, m%particles)
      call sort_anew(m, failure)
   end subroutine split_marked

   !> Displace and strain children on the other side of a crack than their parent, or whose parent was on it, as the nearest other
   !> particle on their side, or the mean of those equally near. History-dependent material is unchanged.
   pure subroutine change_sides(m, from, on, first_child)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: from(:, :)         !! where the parents stood [m], (parents, ndim)
      logical, intent(in) :: on(:)               !! whether a crack runs through them: a mirror image swaps their side
      integer, intent(in) :: first_child(:)      !! of each, and behind the last
      real(dp), parameter :: alike = 1e-9_dp     ! relative difference of distances that count as equal
      real(dp) :: x(ndim), at(ndim), away, least, u(ndim), h(ndim, ndim)
      logical, allocatable :: crosses(:)
      integer :: i, j, k, n
      allocate (crosses(m%particles%n))
      associate (p => m%particles, cuts => m%grid%cut_cells)
         do i = 1, size(from, 1)
            at = from(i, :)
            do k = first_child(i), first_child(i + 1) - 1
               x = p%reference(k, :)
               crosses(k) = first_child(i + 1) > first_child(i) + 1
               if (crosses(k) .and. .not. on(i)) crosses(k) = cuts%divide(x, at)
            end do
         end do
         do k = 1, p%n
            if (.not. crosses(k)) cycle
            x = p%reference(k, :)
            least = huge(least)
            n = 0
            do j = 1, p%n                        ! from the child itself on: those in its cell are near, and few others are nearer
               i = mod(k + j - 2, p%n) + 1
               at = p%reference(i, :)
               away = norm(at - x)
               if (crosses(i) .or. p%material(i) /= p%material(k) .or. away > least + alike*away) cycle
               if (m%grid%velocity_field_of(p%body(i)) /= m%grid%velocity_field_of(p%body(k)) .or. cuts%divide(x, at)) cycle
               if (away < least - alike*away) n = 0
               if (n == 0) u = 0
               if (n == 0) h = 0
               least = away
               n = n + 1
               h = h + (p%gradient_of(i) - h)/n
               u = u + (p%displacement(i, :) + matmul(p%gradient_of(i), x - at) - u)/n
            end do
            if (n == 0) cycle
            if (allocated(p%widening)) p%widening(k) = p%widening(k) + u(1) - p%displacement(k, 1)
            p%displacement(k, :) = u
            if (.not. m%materials(p%material(k))%has_history) p%gradient(k, :, :) = h
         end do
      end associate
   end subroutine change_sides

   !> Normals of the cracks through the middles of the marked particles, 0 if there is none; (ndim, marked).
   pure function normals_of_cracks(m, marked) result(normal)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: marked(:)
      real(dp) :: normal(ndim, count(marked))
      integer :: i, k
      normal = 0
      k = 0
      do i = 1, m%particles%n
         if (.not. marked(i)) cycle
         k = k + 1
         if (.not. is_on_crack(m, i) .or. m%has_domains()) cycle
         if (m%particles%level(i) < level_for(m, i)) cycle ! its children may stand beside it
         normal(:, k) = m%grid%cut_cells%normal_at(m%grid%element_leaf(m%particles%cell(i)), m%particles%reference(i, :))
      end do
   end function normals_of_cracks

   !> Recombine the families of which all are marked, and sort.
   subroutine recombine_marked(m, marked, families, failure)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: marked(:)
      integer, intent(out) :: families
      type(failure_t), intent(inout) :: failure
      logical :: ready(size(marked))
      integer, allocatable :: new_number(:), level(:)
      real(dp), allocatable :: reference(:, :), values(:, :, :)
      families = 0
      if (.not. any(marked)) return
      reference = m%particles%reference
      level = m%particles%level
      ready = marked
      if (has_whole_cells(m) .and. .not. m%cache%is_provisional) call values_of_parents(m, ready, values)
      call recombine(m%particles, ready, m%grid%forest, families, new_number, failure)
      if (families == 0 .or. failure%failed()) return
      if (allocated(values)) call give_to_parents(values, ready, level, new_number, m)
      if (.not. any(m%materials%has_history)) call give_materials_of_places(m%particles, m%materials)
      call follow_recombination(m%loads, m%grid%forest%tolerance(), m%particles, reference, level, new_number)
      call share_by_mass(m%loads, m%particles)
      call sort_anew(m, failure)
   end subroutine recombine_marked

   !> Kinetic and strain energy of the particles, and energy of interface points [J], for the energy balance; where nodes keep their
   !> velocity without the kinetic energy, which is theirs.
   real(dp) function total_energy(m) result(energy)
      type(problem_t), intent(in) :: m
      energy = 0
      if (.not. m%audit) return
      energy = stored_energy(m) + dissipated_energy(m)
      if (.not. allocated(m%state%velocity)) energy = energy + kinetic_energy(m%particles)
   end function total_energy
end module hampm_matching
