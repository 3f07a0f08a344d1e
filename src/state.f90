!> What a run has to remember to go on as if it had never stopped: the one list of it, for writing checkpoints and for reading them.
!>
!> What is not here follows from the scene and from what is: the grid from the forest, the blocks of cells from the order of the
!> particles, crack, constraints and room for the fields from the grid. What depends on more of the past is here, down to guesses
!> of solvers, the numbers of an old factorisation, and how well the order of a step has been planned: the last digits
!> depend on them.
module hampm_state
   use hampm_kinds, only: dp, ndim
   use hampm_checkpoint, only: checkpoint_t
   use hampm_contact, only: contact_t
   use hampm_cuts, only: cut_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t, build_grid
   use hampm_loads, only: load_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_measurements, only: measurements_t
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_particles, only: particles_t, new_particles, take_order
   use hampm_pipeline, only: plan_pipeline
   use hampm_refinement, only: refinement_t
   use hampm_splitting, only: start_families
   use hampm_step, only: motion_t, fit_to_grid, fit_to_cells
   use hampm_text, only: to_text
   implicit none
   private
   public :: keep_motion, keep_refinement, keep_measurements

contains

   !> Keep all that moves. When it is read, the motion is the one that the scene begins with.
   subroutine keep_motion(c, m)
      type(checkpoint_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      call c%section('motion')
      call c%keep('time', m%time)
      call c%keep('steps', m%steps)
      call c%keep('external_work', m%external_work)
      call c%keep('damping_loss', m%damping_loss)
      call c%keep('numerical_loss', m%numerical_loss)
      call keep_grid(c, m%grid)
      call keep_particles(c, m%grid, m%particles)
      call keep_loads(c, m%loads)
      if (c%is_read .and. .not. c%failure%failed()) call fit_to_grid(m, c%failure)
      if (c%failure%failed()) return
      call keep_fields(c, m%fields, m%mapped)
      if (m%mapped .and. .not. c%failure%failed()) call keep_response(c, m)
      call keep_contact(c, m%contact)
      call keep_solver(c, 'solver', m%grid, m%solver)
      call keep_plan(c, m)
   end subroutine keep_motion

   !> Keep how cells are refined.
   subroutine keep_refinement(c, r)
      type(checkpoint_t), intent(inout) :: c
      type(refinement_t), intent(inout) :: r
      call c%section('refinement')
      call c%keep('reached_max_level', r%reached_max_level)
      call c%keep('reached_max_particles', r%reached_max_particles)
      call c%keep('largest_r', r%largest_r)
      call c%keep('relative_error', r%relative_error)
   end subroutine keep_refinement

   !> Keep what rows of the history need of the rows before.
   subroutine keep_measurements(c, grid, m)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(measurements_t), intent(inout) :: m
      call c%section('measurements')
      call c%keep('initial_energy', m%initial_energy)
      call c%keep('largest_energy', m%largest_energy)
      call c%keep('kinetic_energy', m%kinetic_energy)
      call c%keep('strain_energy', m%strain_energy)
      call c%keep('initial_moment', m%initial_moment)
      call c%keep('largest_inner_energy', m%largest_inner_energy)
      call keep_solver(c, 'extrapolation', grid, m%extrapolation)
   end subroutine keep_measurements

   !> Keep the forest, and build its grid.
   subroutine keep_grid(c, grid)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(inout) :: grid
      type(forest_t) :: forest
      type(cut_t), allocatable :: cuts(:)
      integer :: leaves
      forest = grid%forest
      leaves = 0
      if (.not. forest%is_uniform()) leaves = forest%leaf_count()
      call c%section('forest')
      call c%keep('leaves', leaves)
      if (leaves == 0 .or. c%failure%failed()) return
      if (c%is_read) then
         if (allocated(forest%level)) deallocate (forest%level, forest%place, forest%first_leaf)
         allocate (forest%level(leaves), forest%place(ndim, leaves), forest%first_leaf(product(forest%cells) + 1))
      end if
      call c%keep_integers('level', size(forest%level), forest%level)
      call c%keep_longs('place', size(forest%place), forest%place)
      call c%keep_integers('first_leaf', size(forest%first_leaf), forest%first_leaf)
      if (.not. c%is_read .or. c%failure%failed()) return
      cuts = grid%cuts
      call build_grid(forest, grid, c%failure, cuts)
   end subroutine keep_grid

   !> Keep the particles in their order, and form the blocks of this order.
   subroutine keep_particles(c, grid, p)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(inout) :: p
      integer :: n
      logical :: has_families, fits
      n = p%n
      has_families = allocated(p%level)
      call c%section('particles')
      call c%keep('number', n)
      call c%keep('have_families', has_families)
      if (c%is_read .and. .not. c%failure%failed()) call make_room(c, n, has_families, grid, p)
      if (c%failure%failed()) return
      call c%keep_reals('mass', n, p%mass)
      call c%keep_reals('volume', n, p%volume)
      call c%keep_reals('reference', size(p%reference), p%reference)
      call c%keep_reals('displacement', size(p%displacement), p%displacement)
      call c%keep_reals('velocity', size(p%velocity), p%velocity)
      call c%keep_reals('gradient', size(p%gradient), p%gradient)
      call c%keep_reals('local', size(p%local), p%local)
      call c%keep_integers('material', n, p%material)
      call c%keep_integers('body', n, p%body)
      call c%keep_integers('id', n, p%id)
      call c%keep_integers('cell', n, p%cell)
      if (has_families) then
         call c%keep_integers('level', n, p%level)
         call c%keep_longs('path', n, p%path)
      end if
      if (.not. c%is_read .or. c%failure%failed()) return
      call take_order(p, grid, fits)
      if (.not. fits) call c%refuse('its particles do not stand in the order of their cells')
   end subroutine keep_particles

   !> Room for another number of particles.
   subroutine make_room(c, n, has_families, grid, p)
      type(checkpoint_t), intent(inout) :: c
      integer, intent(in) :: n
      logical, intent(in) :: has_families
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(inout) :: p
      type(particles_t) :: fresh
      call new_particles(n, grid%n_elements, fresh, c%failure)
      if (c%failure%failed()) return
      fresh%total_frame = p%total_frame
      fresh%by_group = p%by_group
      if (allocated(p%spacing)) fresh%spacing = p%spacing
      if (has_families) call start_families(fresh)
      p = fresh
   end subroutine make_room

   !> Keep which particles carry the loads, and how far these have moved.
   subroutine keep_loads(c, loads)
      type(checkpoint_t), intent(inout) :: c
      type(load_t), intent(inout) :: loads(:)
      integer :: l, n
      do l = 1, size(loads)
         associate (load => loads(l))
            n = size(load%host)
            call c%section('load_'//to_text(l))
            call c%keep('points', n)
            if (c%failure%failed()) return
            if (c%is_read) then
               deallocate (load%share, load%host, load%offset, load%half, load%moved)
               allocate (load%share(n), load%host(n), load%offset(ndim, n), load%half(ndim, n), load%moved(ndim, n))
            end if
            call c%keep_reals('share', n, load%share)
            call c%keep_integers('host', n, load%host)
            call c%keep_reals('offset', size(load%offset), load%offset)
            call c%keep_reals('half', size(load%half), load%half)
            call c%keep_reals('moved', size(load%moved), load%moved)
         end associate
      end do
   end subroutine keep_loads

   !> Keep what the next step needs of the nodal values of the last one, and what it has left in the cells.
   subroutine keep_fields(c, f, mapped)
      type(checkpoint_t), intent(inout) :: c
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(inout) :: mapped           !! whether the cells hold the sums for the next step
      logical :: has_past
      call c%section('fields')
      call c%keep_reals('velocity', size(f%velocity), f%velocity)
      call c%keep_reals('acceleration', size(f%acceleration), f%acceleration)
      has_past = allocated(f%past)
      call c%keep('have_past', has_past)
      if (has_past .and. .not. allocated(f%past)) allocate (f%past(ndim, size(f%acceleration, 2), 2))
      if (has_past) call c%keep_reals('past', size(f%past), f%past)
      call c%keep('are_mapped', mapped)
      if (.not. mapped) return
      call c%keep_reals('share', size(f%share(:, :, :, 1))*f%n_blocks, f%share(1, 1, 1, 1))
      associate (matrix => f%mass_matrix)
         if (.not. allocated(matrix%cell)) return
         call c%keep_reals('matrix', size(matrix%cell), matrix%cell)
         call c%keep_reals('lumped_matrix', size(matrix%cell_lumped), matrix%cell_lumped)
      end associate
   end subroutine keep_fields

   !> Keep what particles of cells that are swept without them have not got yet.
   subroutine keep_response(c, m)
      type(checkpoint_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      if (c%is_read) call fit_to_cells(m)
      call c%section('response')
      call c%keep('is_behind', m%response%is_behind)
      if (.not. m%response%is_behind) return
      call c%keep_reals('kick', size(m%response%kick), m%response%kick)
      call c%keep_reals('move', size(m%response%move), m%response%move)
      call c%keep_reals('strain', size(m%response%strain), m%response%strain)
   end subroutine keep_response

   !> Keep the gaps of faces that may touch.
   subroutine keep_contact(c, contact)
      type(checkpoint_t), intent(inout) :: c
      type(contact_t), intent(inout) :: contact
      integer :: n
      n = contact%n
      call c%section('contact')
      call c%keep('pairs', n)
      if (n /= contact%n) call c%refuse('it has '//to_text(n)//' pairs of nodes on faces, the grid has '//to_text(contact%n))
      if (n == 0 .or. c%failure%failed()) return
      call c%keep_reals('gap', size(contact%gap), contact%gap)
      call c%keep_logicals('touches', size(contact%touches), contact%touches)
   end subroutine keep_contact

   !> Keep what a solver has factorised, and its counts.
   subroutine keep_solver(c, name, grid, solver)
      type(checkpoint_t), intent(inout) :: c
      character(*), intent(in) :: name
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      call c%section(name)
      call c%keep('factorised', solver%factorised)
      if (solver%factorised) call keep_factorisation(c, grid, solver)
      call c%keep('solutions', solver%solutions)
      call c%keep('iterations', solver%iterations)
      call c%keep('analyses', solver%direct%analyses)
      call c%keep('factorisations', solver%direct%factorisations)
   end subroutine keep_solver

   !> Keep the numbers that a solver has factorised, and factorise them.
   subroutine keep_factorisation(c, grid, solver)
      type(checkpoint_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      integer, allocatable :: coupled(:)
      real(dp), allocatable :: values(:)
      integer :: n_coupled, n_values
      logical :: fits
      allocate (coupled(0), values(0))
      if (.not. c%is_read) then
         coupled = solver%direct%coupled
         values = solver%direct%factorised_values()
      end if
      n_coupled = size(coupled)
      n_values = size(values)
      call c%keep('number_coupled', n_coupled)
      call c%keep('number_values', n_values)
      if (c%is_read) then
         deallocate (coupled, values)
         allocate (coupled(n_coupled), values(n_values))
      end if
      call c%keep_integers('coupled', n_coupled, coupled)
      call c%keep_reals('values', n_values, values)
      if (.not. c%is_read .or. c%failure%failed()) return
      call solver%factorise_values(grid, coupled, values, fits, c%failure)
      if (.not. fits) call c%refuse('the factorised matrix does not fit the grid')
   end subroutine keep_factorisation

   !> Keep how well the order of steps has been planned: sums depend on it.
   subroutine keep_plan(c, m)
      type(checkpoint_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: times, k
      times = m%plan%times_planned(m%fields)
      call c%section('plan')
      call c%keep('times_planned', times)
      if (.not. c%is_read .or. c%failure%failed()) return
      do k = 1, times
         if (.not. m%plan%fits(m%fields)) call plan_pipeline(m%fields, size(m%scheme%sweeps), m%plan)
      end do
   end subroutine keep_plan
end module hampm_state
