!> What the history records: which columns a scene has, and one row of their values.
module hampm_measurements
   use hampm_kinds, only: dp
   use hampm_constraints, only: constraints_t
   use hampm_crack, only: crack_t
   use hampm_crack_closure, only: crack_opening, stress_closure, nodal_force_closure
   use hampm_dcb, only: dcb_energy_release_rate, chi_foundation
   use hampm_energy, only: kinetic_energy, strain_energy
   use hampm_failure, only: failure_t
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver
   use hampm_particles, only: smallest_occupied_cell
   use hampm_results, only: results_t
   use hampm_scene, only: scene_t
   use hampm_step, only: motion_t, refresh_grid
   implicit none
   private
   public :: measurements_t, new_measurements, fit_extrapolation, measure, declare_columns, energy_residual

   !> The latest row, with what is needed to take the next one.
   type :: measurements_t
      real(dp) :: initial_energy = 0             !! kinetic energy of the bodies at the start [J]
      real(dp) :: largest_energy = 0             !! largest of kinetic + strain energy and external work so far [J]
      real(dp) :: kinetic_energy = 0             !! [J]
      real(dp) :: strain_energy = 0              !! [J]
      real(dp) :: g_ref = 0                      !! reference value, 0 where there is none [J/m2]
      real(dp) :: g_beam_on_foundation = 0       !! (33) with chi = 2/3, 0 where it does not apply [J/m2]
      real(dp), allocatable :: g_ratio           !! first of the chosen estimators over `g_ref`, where there are both [-]
      type(mass_solver_t) :: extrapolation       !! solver of the extrapolations, without held components
      real(dp) :: indicator = 0                  !! largest R, or estimated relative error, when the mesh was last looked at [-]
      integer :: n = 0                           !! number of columns
      real(dp) :: row(20) = 0                    !! values of the columns, (n)
   end type measurements_t

contains

   !> Ready for the first row.
   subroutine new_measurements(scene, motion, crack, m)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(in) :: motion
      type(crack_t), intent(in) :: crack
      type(measurements_t), intent(inout) :: m
      real(dp) :: force, length, depth
      m%initial_energy = kinetic_energy(motion%particles)
      select case (scene%energy_release%reference)
      case ('value')
         m%g_ref = scene%energy_release%reference_value
      case ('dcb')
         call dcb_dimensions(scene, crack, force, length, depth)
         m%g_ref = dcb_energy_release_rate(force, length, depth, scene%run%thickness, scene%materials(1)%young, 0.0_dp)
         m%g_beam_on_foundation = dcb_energy_release_rate(force, length, depth, scene%run%thickness, &
                                                          scene%materials(1)%young, chi_foundation)
      end select
   end subroutine new_measurements

   !> Make the solver of the extrapolations fit a new mesh. Fails where the memory does not suffice.
   subroutine fit_extrapolation(motion, m, failure)
      type(motion_t), intent(in) :: motion
      type(measurements_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      call new_mass_solver(motion%mass%by, motion%mass%order, motion%grid, constraints_t(), m%extrapolation, failure)
   end subroutine fit_extrapolation

   !> Load, crack length and depth of a double cantilever beam, from the scene: the resultant of the loads normal to the
   !> crack, the distance from the first load to the tip, and the size of the body normal to the crack.
   pure subroutine dcb_dimensions(scene, crack, force, length, depth)
      type(scene_t), intent(in) :: scene
      type(crack_t), intent(in) :: crack
      real(dp), intent(out) :: force, length, depth
      integer :: k
      force = 0
      do k = 1, size(scene%loads)
         force = force + scene%loads(k)%force(crack%normal)
      end do
      associate (load => scene%loads(1), body => scene%bodies(1))
         length = abs(dot_product(scene%crack%tip - (load%lower + load%upper)/2, scene%crack%direction))
         depth = body%upper(crack%normal) - body%lower(crack%normal)
      end associate
   end subroutine dcb_dimensions

   !> Declare the columns in the results, in the order of `measure`, with what belongs to them.
   subroutine declare_columns(scene, m, results, failure)
      type(scene_t), intent(in) :: scene
      type(measurements_t), intent(in) :: m
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
      call results%add_column('time', 's', 'time', failure)
      call results%add_column('step', '1', 'steps done', failure, integer_valued=.true.)
      call results%add_column('dt', 's', 'time step', failure)
      call results%add_column('particles', '1', 'number of particles', failure, integer_valued=.true.)
      call results%add_column('cells', '1', 'number of cells', failure, integer_valued=.true.)
      call results%add_column('finest_cell', 'm', 'size of the smallest occupied cell', failure)
      call results%add_column('kinetic_energy', 'J', 'kinetic energy', failure)
      call results%add_column('strain_energy', 'J', 'strain energy', failure)
      call results%add_column('external_work', 'J', 'work of the loads', failure)
      call results%add_column('damping_loss', 'J', 'energy taken by the damping', failure)
      associate (chosen => scene%energy_release)
         if (chosen%energy_balance) call results%add_column('numerical_loss', 'J', 'energy lost by the method', failure)
         if (chosen%nodal_force) call results%add_column('G_nodal_force_I', 'J/m2', &
                                                         'energy release rate, mode I, nodal force closure', failure)
         if (chosen%stress_closure) call results%add_column('G_stress_closure_I', 'J/m2', &
                                                            'energy release rate, mode I, stress closure', failure)
      end associate
      if (scene%crack%present) call results%add_column('crack_opening', 'm', 'opening one cell behind the tip', failure)
      if (scene%refine%indicator == 'zz') call results%add_column('error_estimate', '1', &
                                                                  'estimated relative error in the energy norm', failure)
      if (scene%refine%indicator == 'gradient') call results%add_column('largest_R', '1', &
                                                                        'largest mean R of the cells in the region', failure)
      if (m%g_ref > 0) call results%add_attribute('/history', 'G_ref', m%g_ref, failure)
      if (m%g_beam_on_foundation > 0) call results%add_attribute('/history', 'G_beam_on_foundation', &
                                                                 m%g_beam_on_foundation, failure)
   end subroutine declare_columns

   !> Take one row.
   subroutine measure(scene, motion, crack, dt, m, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      type(crack_t), intent(in) :: crack
      real(dp), intent(in) :: dt                 !! length of the last step [s]
      type(measurements_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      real(dp) :: g
      associate (p => motion%particles, grid => motion%grid, chosen => scene%energy_release)
         m%kinetic_energy = kinetic_energy(p)
         m%strain_energy = strain_energy(p, motion%materials)
         m%largest_energy = max(m%largest_energy, m%kinetic_energy + m%strain_energy, abs(motion%external_work))
         m%n = 0
         if (allocated(m%g_ratio)) deallocate (m%g_ratio)
         call add(m, motion%time)
         call add(m, real(motion%steps, dp))
         call add(m, dt)
         call add(m, real(p%n, dp))
         call add(m, real(grid%forest%leaf_count(), dp))
         call add(m, smallest_occupied_cell(grid, p))
         call add(m, m%kinetic_energy)
         call add(m, m%strain_energy)
         call add(m, motion%external_work)
         call add(m, motion%damping_loss)
         if (chosen%energy_balance) call add(m, motion%numerical_loss)
         if (chosen%nodal_force) call add_g(m, nodal_force_closure(crack, grid, p, motion%materials, scene%run%thickness))
         if (chosen%stress_closure) then
            call refresh_grid(motion)
            call stress_closure(crack, grid, p, motion%materials, motion%fields%mass_matrix, m%extrapolation, g, failure)
            call add_g(m, g)
         end if
         if (scene%crack%present) call add(m, crack_opening(crack, grid, p))
         if (scene%refine%indicator == 'zz' .or. scene%refine%indicator == 'gradient') call add(m, m%indicator)
      end associate
   end subroutine measure

   !> Append a value to the row.
   pure subroutine add(m, value)
      type(measurements_t), intent(inout) :: m
      real(dp), intent(in) :: value
      m%n = m%n + 1
      m%row(m%n) = value
   end subroutine add

   !> Append an energy release rate to the row; the first is the one that the progress line shows.
   pure subroutine add_g(m, value)
      type(measurements_t), intent(inout) :: m
      real(dp), intent(in) :: value              !! [J/m2]
      call add(m, value)
      if (m%g_ref > 0 .and. .not. allocated(m%g_ratio)) m%g_ratio = value/m%g_ref
   end subroutine add_g

   !> What is missing in the energy balance, over the largest energy so far; without the audit it is the numerical loss [-].
   pure real(dp) function energy_residual(motion, m) result(residual)
      type(motion_t), intent(in) :: motion
      type(measurements_t), intent(in) :: m
      residual = 0
      if (m%largest_energy > 0) residual = (motion%external_work + m%initial_energy - m%kinetic_energy - m%strain_energy &
                                            - motion%damping_loss - motion%numerical_loss)/m%largest_energy
   end function energy_residual
end module hampm_measurements
