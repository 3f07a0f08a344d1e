!> Checkpoint of a problem, so that a run goes on as if it had never stopped. Each type archives itself, by one list of items for
!> writing and reading; this module fixes their order.
!>
!> The grid follows from the forest and the cracks, the blocks of cells from the order of the particles, nodes around crack tips,
!> constraints and room for the fields from the grid: none of these is stored. History is stored, down to the start values of
!> solvers and the numbers of an old factorisation: the last digits depend on them.
module hampm_problem_checkpoint
   use hampm_kinds, only: dp, ndim
   use hampm_body_contact, only: archive_body_contact
   use hampm_checkpoint, only: checkpoint_t
   use hampm_cracks, only: cracks_t
   use hampm_crack_lines, only: line_t
   use hampm_element_operators, only: archive_gains
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_plane_cuts, only: plane_cut_t
   use hampm_loads, only: archive_loads
   use hampm_interface_step, only: archive_faces
   use hampm_mass_solver, only: archive_solver
   use hampm_problem, only: problem_t, rebuild_on_grid, rebuild_operators, assemble_sums, is_weighed
   use hampm_nodal_fields, only: archive_fields
   use hampm_particles, only: archive_particles
   use hampm_outline, only: outline_t
   use hampm_quadratic_points, only: correct_points
   use hampm_sorting, only: take_order
   use hampm_supports, only: archive_supports
   use hampm_text, only: to_text
   use hampm_interface_points, only: archive_interfaces
   implicit none
   private
   public :: keep_problem

contains

   !> Keep all that moves, with the grid cut along the cracks. When it is read, the motion is the one that the model begins with.
   subroutine keep_problem(c, cracks, m)
      type(checkpoint_t), intent(inout) :: c
      type(cracks_t), intent(in) :: cracks
      type(problem_t), intent(inout) :: m
      logical :: mapped, weighed
      call c%section('motion')
      call c%serialise('time', m%state%time)
      call c%serialise('steps', m%state%steps)
      call c%serialise('last_dt', m%state%last_dt)
      call c%serialise('external_work', m%energies%external_work)
      call c%serialise('driven_dt', m%energies%prescribed%dt)
      call c%serialise('driven_work', m%energies%prescribed%work)
      call c%serialise('damping_loss', m%energies%damping_loss)
      call c%serialise('absorbed_energy', m%energies%absorbed_energy)
      call c%serialise('fracture_energy', m%energies%fracture_energy)
      call c%serialise('numerical_loss', m%energies%numerical_loss)
      call archive_grid(c, cracks, m%grid)
      call archive_particles(m%particles, c)
      call archive_loads(m%loads, c)
      if (c%is_read .and. .not. c%failure%failed()) call form_order(c, m)
      if (c%is_read .and. .not. c%failure%failed()) call rebuild_on_grid(m, c%failure)
      if (c%failure%failed()) return
      mapped = m%cache%mapped .and. .not. m%has_domains() ! corners of domains are mapped anew, to the same bytes
      call archive_fields(m%fields, m%grid, m%blocks%n, mapped, c)
      if (c%is_read) m%cache%mapped = mapped
      if (mapped .and. .not. c%failure%failed()) then
         if (c%is_read) call rebuild_operators(m)
         call archive_gains(m%cache%operators, c)
      end if
      weighed = is_weighed(m)
      call c%serialise('weighed', weighed)
      if (c%failure%failed()) return
      if (c%is_read .and. weighed) call assemble_sums(m, mass=.true., momentum=.false., force=.false.)
      if (c%is_read) m%cache%weighed = weighed
      call c%serialise('velocity_after', m%cache%velocity_after)
      call c%serialise('acceleration_after', m%cache%acceleration_after)
      call archive_body_contact(m%body_contact, c)
      call archive_supports(m%constraints, c)
      call archive_interfaces(m%interfaces, c)
      call archive_faces(m%interface_step, c)
      call archive_solver(m%solver, 'solver', m%grid, weighed, m%fields%mass_matrix, c)
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
   subroutine archive_grid(c, cracks, grid)
      type(checkpoint_t), intent(inout) :: c
      type(cracks_t), intent(in) :: cracks
      type(grid_t), intent(inout) :: grid
      type(forest_t) :: forest
      type(line_t), allocatable :: lines(:)
      type(outline_t), allocatable :: bodies(:)
      integer, allocatable :: velocity_fields(:)
      real(dp), allocatable :: solids(:, :, :)
      type(plane_cut_t), allocatable :: planes(:)
      integer :: leaves
      forest = grid%forest
      leaves = 0
      if (.not. forest%is_uniform()) leaves = forest%leaf_count()
      call c%section('forest')
      call c%serialise('leaves', leaves)
      if (leaves > 0 .and. .not. c%failure%failed()) call archive_leaves(c, leaves, forest)
      lines = cracks%lines()
      call archive_lines(c, grid, lines)
      if (allocated(grid%planes)) call archive_outlines(c, grid%planes)
      if (.not. c%is_read .or. c%failure%failed()) return
      if (allocated(grid%bodies)) allocate (bodies, source=grid%bodies)
      if (allocated(grid%field_of_body)) allocate (velocity_fields, source=grid%field_of_body)
      if (grid%is_quadratic()) allocate (solids, source=grid%solids)
      if (allocated(grid%planes)) allocate (planes, source=grid%planes)
      if (leaves > 0 .or. size(cracks%crack) > 0 .or. allocated(planes)) &
         call build_grid(forest, grid, c%failure, lines, bodies, velocity_fields, solids, planes=planes)
   end subroutine archive_grid

   !> Keep the outlines of cracks in planes, whose fronts may have moved.
   subroutine archive_outlines(c, planes)
      type(checkpoint_t), intent(inout) :: c
      type(plane_cut_t), intent(inout) :: planes(:)
      integer :: k, n
      do k = 1, size(planes)
         associate (plane => planes(k))
            call c%section('plane_'//to_text(k))
            n = size(plane%outline, 2)
            call c%serialise('corners', n)
            if (c%failure%failed()) return
            if (c%is_read) then
               deallocate (plane%outline, plane%may_be_front, plane%is_corner)
               allocate (plane%outline(2, n), plane%may_be_front(n), plane%is_corner(n))
            end if
            call c%archive_reals('outline', 2*n, plane%outline)
            call c%serialise('beyond', plane%beyond)
            call c%archive_logicals('may_be_front', n, plane%may_be_front)
            call c%archive_logicals('is_corner', n, plane%is_corner)
         end associate
      end do
   end subroutine archive_outlines

   !> Keep where lines are in a grid, and their tips when cells were cut last; those that are read are the ones in `lines`.
   subroutine archive_lines(c, grid, lines)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(line_t), intent(inout) :: lines(:)
      integer :: k
      call c%section('lines')
      do k = 1, size(lines)
         if (.not. c%is_read) lines(k) = grid%cut_cells%lines(k)
         call c%archive_reals('points_'//to_text(k), size(lines(k)%points), lines(k)%points)
         call c%archive_reals('bonded_'//to_text(k), size(lines(k)%bonded), lines(k)%bonded)
         call c%archive_reals('grown_'//to_text(k), size(lines(k)%grown), lines(k)%grown)
      end do
   end subroutine archive_lines

   !> Keep the leaves of a forest, of which not every root is one.
   subroutine archive_leaves(c, leaves, forest)
      type(checkpoint_t), intent(inout) :: c
      integer, intent(in) :: leaves
      type(forest_t), intent(inout) :: forest
      if (c%is_read) then
         if (allocated(forest%level)) deallocate (forest%level, forest%place, forest%first_leaf)
         allocate (forest%level(leaves), forest%place(ndim, leaves), forest%first_leaf(product(forest%cells) + 1))
      end if
      call c%archive_integers('level', size(forest%level), forest%level)
      call c%archive_longs('place', size(forest%place), forest%place)
      call c%archive_integers('first_leaf', size(forest%first_leaf), forest%first_leaf)
   end subroutine archive_leaves

end module hampm_problem_checkpoint
