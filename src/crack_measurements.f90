!> What the history records of a crack: its columns, and the values of one row, in the same order.
module hampm_crack_measurements
   use hampm_kinds, only: dp
   use hampm_crack, only: crack_t
   use hampm_crack_closure, only: crack_opening, stress_closure, nodal_force_closure
   use hampm_crack_placement, only: body_at, domain_radii
   use hampm_crack_tip_field, only: modes
   use hampm_domain_integral, only: tip_domain_t, domain_integrals, shares_of_modes
   use hampm_failure, only: failure_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_motion, only: motion_t, refresh_grid
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state
   use hampm_placement, only: length_text
   use hampm_results, only: results_t
   use hampm_row, only: row_t
   use hampm_scene, only: scene_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: declare_crack_columns, measure_crack

contains

   !> Declare the columns in the results. On a symmetry plane there is only mode I.
   subroutine declare_crack_columns(scene, results, failure)
      type(scene_t), intent(in) :: scene
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: radii(:)
      logical :: both_modes
      integer :: i
      both_modes = scene%crack%kind == 'line'
      associate (chosen => scene%energy_release)
         if (chosen%nodal_force) call add_modes('G_nodal_force_', 'J/m2', 'energy release rate, nodal force closure')
         if (chosen%stress_closure) call add_modes('G_stress_closure_', 'J/m2', 'energy release rate, stress closure')
         if (chosen%domain_integral) then
            call add_modes('G_domain_', 'J/m2', 'energy release rate, part of J')
            call add_modes('K_', 'Pa m^0.5', 'stress intensity factor, interaction integral')
            if (both_modes) call results%add_column('mode_mixity', 'rad', 'angle of (K_I, K_II)', failure)
            call results%add_column('J', 'J/m2', 'J integral, mean over the domains', failure)
            call results%add_column('J_spread', 'J/m2', 'largest less smallest J of the domains', failure)
            allocate (radii, source=domain_radii(scene))
            do i = 1, size(radii)
               call results%add_column('J_'//to_text(i), 'J/m2', 'J integral, radius '//length_text(radii(i))//' m', failure)
            end do
         end if
      end associate
      call results%add_column('crack_opening', 'm', 'opening one cell behind the tip', failure)
      if (both_modes) call results%add_column('crack_sliding', 'm', 'sliding one cell behind the tip', failure)
      call results%add_column('mouth_opening', 'm', 'opening at the mouth; with two tips at a root node half way or next to it', &
                              failure)
      if (both_modes) call results%add_column('mouth_sliding', 'm', 'sliding there', failure)
      call results%add_column('tip_cell', 'm', 'size of the cells at the tip', failure)
      if (size(scene%constraints) > 0) then
         call results%add_column('reaction_x', 'N', 'force of the constraints on the bodies', failure)
         call results%add_column('reaction_y', 'N', 'force of the constraints on the bodies', failure)
      end if
   contains
      !> Declare a column for each mode.
      subroutine add_modes(name, unit, meaning)
         character(*), intent(in) :: name, unit, meaning
         call results%add_column(name//'I', unit, meaning//', mode I', failure)
         if (both_modes) call results%add_column(name//'II', unit, meaning//', mode II', failure)
      end subroutine add_modes
   end subroutine declare_crack_columns

   !> Append the values to a row, and find the first of the chosen energy release rates, of both modes together [J/m2]; not
   !> allocated where none is chosen. Fails where the nodal equations cannot be solved.
   subroutine measure_crack(scene, motion, crack, extrapolation, row, first_g, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      type(crack_t), intent(in) :: crack
      type(mass_solver_t), intent(inout) :: extrapolation !! solver without held components
      type(row_t), intent(inout) :: row
      real(dp), allocatable, intent(out) :: first_g
      type(failure_t), intent(inout) :: failure
      type(nodal_state_t) :: state
      real(dp) :: g(modes)
      integer :: recorded
      recorded = merge(1, modes, crack%line%is_half())
      associate (p => motion%particles, grid => motion%grid, chosen => scene%energy_release)
         if (chosen%domain_integral .or. size(scene%constraints) > 0) call find_nodal_state(motion, state, failure)
         if (failure%failed()) return
         if (chosen%nodal_force) then
            g = nodal_force_closure(crack, grid, p, motion%blocks, motion%materials, scene%run%thickness)
            call row%add(g(:recorded))
            call keep_first(g, first_g)
         end if
         if (chosen%stress_closure) then
            call refresh_grid(motion)
            call stress_closure(crack, grid, p, motion%materials, motion%fields%mass_matrix, extrapolation, g, failure)
            call row%add(g(:recorded))
            call keep_first(g, first_g)
         end if
         if (chosen%domain_integral) then
            call measure_domain(scene, motion, crack, state, recorded, row, g)
            call keep_first(g, first_g)
         end if
         associate (behind => crack_opening(crack, crack%behind, grid, p, motion%blocks), &
                    mouth => crack_opening(crack, crack%mouth, grid, p, motion%blocks))
            call row%add(behind(:recorded))
            call row%add(mouth(:recorded))
         end associate
         call row%add(crack%step)
         if (size(scene%constraints) > 0) call row%add(state%reaction)
      end associate
   end subroutine measure_crack

   !> Keep an energy release rate, of both modes together, where it is the first: the sign of mode II tells only which way the
   !> faces slide.
   pure subroutine keep_first(g, first_g)
      real(dp), intent(in) :: g(modes)           !! [J/m2]
      real(dp), allocatable, intent(inout) :: first_g
      if (.not. allocated(first_g)) first_g = g(1) + abs(g(2))
   end subroutine keep_first

   !> Append what the domain integrals give: means over the domains, and J of each.
   subroutine measure_domain(scene, motion, crack, state, recorded, row, g)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(in) :: motion
      type(crack_t), intent(in) :: crack
      type(nodal_state_t), intent(in) :: state
      integer, intent(in) :: recorded            !! number of modes
      type(row_t), intent(inout) :: row
      real(dp), intent(out) :: g(modes)          !! [J/m2]
      type(tip_domain_t) :: domain
      real(dp), allocatable :: j(:), k(:, :)
      real(dp) :: mean_k(modes)
      domain%tip = crack%line%tip
      domain%direction = crack%line%axis(:, 1)
      domain%cell = crack%step
      domain%half = crack%line%is_half()
      domain%thickness = scene%run%thickness
      domain%material = motion%materials(scene%bodies(body_at(scene, crack%line%tip))%material_index)
      domain%radius = domain_radii(scene)
      allocate (j(size(domain%radius)), k(modes, size(domain%radius)))
      call domain_integrals(domain, motion%grid, motion%particles, motion%blocks, motion%materials, state, j, k)
      mean_k = sum(k, dim=2)/size(j)
      g = shares_of_modes(sum(j)/size(j), mean_k)
      call row%add(g(:recorded))
      call row%add(mean_k(:recorded))
      if (recorded > 1) call row%add(atan2(mean_k(2), mean_k(1)))
      call row%add(sum(j)/size(j))
      call row%add(maxval(j) - minval(j))
      call row%add(j)
   end subroutine measure_domain
end module hampm_crack_measurements
