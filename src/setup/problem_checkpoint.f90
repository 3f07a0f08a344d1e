!> Keeping a problem in a checkpoint, so that a run goes on as if it had never stopped. Each type keeps itself, by one list of items
!> for writing and for reading; here is their order.
!>
!> What is not kept follows from the scene and from what is: the grid from the forest and the cracks, the blocks of cells from the
!> order of the particles, nodes around crack tips, constraints and room for the fields from the grid. What depends on more of the
!> past is kept, down to guesses of solvers and the numbers of an old factorisation: the last digits depend on them.
module hampm_problem_checkpoint
   use hampm_kinds, only: dp, ndim
   use hampm_body_contact, only: keep_body_contact
   use hampm_checkpoint, only: checkpoint_t
   use hampm_cracks, only: cracks_t
   use hampm_cut_cells, only: line_t
   use hampm_element_operators, only: keep_gains
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t, build_grid
   use hampm_loads, only: keep_loads
   use hampm_mass_solver, only: keep_solver
   use hampm_problem, only: problem_t, rebuild_on_grid, rebuild_operators
   use hampm_nodal_fields, only: keep_fields
   use hampm_particles, only: keep_particles
   use hampm_outline, only: outline_t
   use hampm_quadratic_points, only: correct_points
   use hampm_sorting, only: take_order
   use hampm_supports, only: keep_supports
   use hampm_text, only: to_text
   use hampm_interface_points, only: keep_interfaces
   implicit none
   private
   public :: keep_problem

contains

   !> Keep all that moves, with the grid cut along the cracks. When it is read, the motion is the one that the scene begins with.
   subroutine keep_problem(c, cracks, m)
      type(checkpoint_t), intent(inout) :: c
      type(cracks_t), intent(in) :: cracks
      type(problem_t), intent(inout) :: m
      logical :: mapped
      call c%section('motion')
      call c%keep('time', m%state%time)
      call c%keep('steps', m%state%steps)
      call c%keep('last_dt', m%state%last_dt)
      call c%keep('external_work', m%energies%external_work)
      call c%keep('driven_dt', m%energies%driven%dt)
      call c%keep('driven_work', m%energies%driven%work)
      call c%keep('damping_loss', m%energies%damping_loss)
      call c%keep('fracture_energy', m%energies%fracture_energy)
      call c%keep('numerical_loss', m%energies%numerical_loss)
      call keep_grid(c, cracks, m%grid)
      call keep_particles(m%particles, c)
      call keep_loads(m%loads, c)
      if (c%is_read .and. .not. c%failure%failed()) call form_order(c, m)
      if (c%is_read .and. .not. c%failure%failed()) call rebuild_on_grid(m, c%failure)
      if (c%failure%failed()) return
      mapped = m%cache%mapped .and. .not. m%has_domains() ! corners of domains are mapped anew, to the same bytes
      call keep_fields(m%fields, m%blocks%n, mapped, c)
      if (c%is_read) m%cache%mapped = mapped
      if (mapped .and. .not. c%failure%failed()) then
         if (c%is_read) call rebuild_operators(m)
         call keep_gains(m%cache%operators, c)
      end if
      if (c%failure%failed()) return
      call keep_body_contact(m%body_contact, c)
      call keep_supports(m%constraints, c)
      call keep_interfaces(m%interfaces, c)
      call keep_solver(m%solver, 'solver', m%grid, c)
   end subroutine keep_problem

   !> Form the blocks of cells for particles that stand in their order.
   subroutine form_order(c, m)
      type(checkpoint_t), intent(inout) :: c
      type(problem_t), intent(inout) :: m
      logical :: fits
      call take_order(m%cache%sorting, m%particles, m%grid, m%blocks, fits, c%failure)
      if (.not. fits) call c%refuse('its particles do not stand in the order of their cells')
      if (fits .and. m%grid%is_quadratic()) call correct_points(m%matter_t)
   end subroutine form_order

   !> Keep the forest, and build its grid.
   subroutine keep_grid(c, cracks, grid)
      type(checkpoint_t), intent(inout) :: c
      type(cracks_t), intent(in) :: cracks
      type(grid_t), intent(inout) :: grid
      type(forest_t) :: forest
      type(line_t), allocatable :: lines(:)
      type(outline_t), allocatable :: bodies(:)
      integer, allocatable :: sheets(:)
      real(dp), allocatable :: solids(:, :, :)
      integer :: leaves
      forest = grid%forest
      leaves = 0
      if (.not. forest%is_uniform()) leaves = forest%leaf_count()
      call c%section('forest')
      call c%keep('leaves', leaves)
      if (leaves > 0 .and. .not. c%failure%failed()) call keep_leaves(c, leaves, forest)
      lines = cracks%lines()
      if (cracks%spacing > 0) call keep_lines(c, grid, lines)
      if (.not. c%is_read .or. c%failure%failed()) return
      if (allocated(grid%bodies)) allocate (bodies, source=grid%bodies)
      if (allocated(grid%sheet_of_body)) allocate (sheets, source=grid%sheet_of_body)
      if (grid%is_quadratic()) allocate (solids, source=grid%solids)
      if (leaves > 0 .or. size(cracks%crack) > 0) call build_grid(forest, grid, c%failure, lines, bodies, sheets, solids)
   end subroutine keep_grid

   !> Keep where lines that the material carries are in a grid; those that are read are the ones in `lines`.
   subroutine keep_lines(c, grid, lines)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(line_t), intent(inout) :: lines(:)
      integer :: k
      call c%section('lines')
      do k = 1, size(lines)
         if (.not. allocated(lines(k)%origin)) cycle
         if (.not. c%is_read) lines(k)%points = grid%cut_cells%lines(k)%points
         call c%keep_reals('points_'//to_text(k), size(lines(k)%points), lines(k)%points)
      end do
   end subroutine keep_lines

   !> Keep the leaves of a forest, of which not every root is one.
   subroutine keep_leaves(c, leaves, forest)
      type(checkpoint_t), intent(inout) :: c
      integer, intent(in) :: leaves
      type(forest_t), intent(inout) :: forest
      if (c%is_read) then
         if (allocated(forest%level)) deallocate (forest%level, forest%place, forest%first_leaf)
         allocate (forest%level(leaves), forest%place(ndim, leaves), forest%first_leaf(product(forest%cells) + 1))
      end if
      call c%keep_integers('level', size(forest%level), forest%level)
      call c%keep_longs('place', size(forest%place), forest%place)
      call c%keep_integers('first_leaf', size(forest%first_leaf), forest%first_leaf)
   end subroutine keep_leaves

end module hampm_problem_checkpoint
