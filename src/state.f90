!> What a run has to remember to go on as if it had never stopped: the one list of it, for writing checkpoints and for reading them.
!>
!> What is not here follows from the scene and from what is: the grid from the forest, the blocks of cells from the order of the
!> particles, crack, constraints and room for the fields from the grid. What depends on more of the past is here, down to guesses
!> of solvers and the numbers of an old factorisation: the last digits depend on them.
module hampm_state
   use hampm_kinds, only: dp, ndim
   use hampm_checkpoint, only: checkpoint_t
   use hampm_contact, only: keep_contact
   use hampm_cuts, only: cut_t
   use hampm_element_operators, only: keep_gains
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t, build_grid
   use hampm_loads, only: keep_loads
   use hampm_mass_solver, only: mass_solver_t
   use hampm_measurements, only: measurements_t
   use hampm_motion, only: motion_t, fit_to_grid, fit_operators
   use hampm_nodal_fields, only: keep_fields
   use hampm_particles, only: keep_particles
   use hampm_refinement, only: refinement_t
   use hampm_sorting, only: take_order
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
      call keep_particles(m%particles, c)
      call keep_loads(m%loads, c)
      if (c%is_read .and. .not. c%failure%failed()) call form_order(c, m)
      if (c%is_read .and. .not. c%failure%failed()) call fit_to_grid(m, c%failure)
      if (c%failure%failed()) return
      call keep_fields(m%fields, m%blocks%n, m%mapped, c)
      if (m%mapped .and. .not. c%failure%failed()) then
         if (c%is_read) call fit_operators(m)
         call keep_gains(m%operators, c)
      end if
      call keep_contact(m%contact, c)
      call keep_solver(c, 'solver', m%grid, m%solver)
   end subroutine keep_motion

   !> Form the blocks of cells for particles that stand in their order.
   subroutine form_order(c, m)
      type(checkpoint_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      logical :: fits
      call take_order(m%sorting, m%particles, m%grid, m%blocks, fits, c%failure)
      if (.not. fits) call c%refuse('its particles do not stand in the order of their cells')
   end subroutine form_order

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

end module hampm_state
