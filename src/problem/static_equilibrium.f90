!> Distance of a motion from static equilibrium, and the time to reach it.
!>
!> A motion under constant loads swings around, or creeps towards, the state in which forces balance. The energy still to be
!> released is its kinetic energy and the energy of the missing deformation: with the residual r, internal force and loads together,
!> the displacement to equilibrium is K^-1 r, and its energy r . K^-1 r/2. So a strongly damped run that hardly moves is recognised
!> as far from equilibrium.
module hampm_static_equilibrium
   use hampm_kinds, only: dp, ndim
   use hampm_problem, only: problem_t, refresh_grid, update_particles, stored_energy, kinetic_energy
   use hampm_nodal_state, only: unbalanced_force
   use hampm_rigid_motions, only: free_motions_t, find_free_motions, take_motion_as_whole
   use hampm_stiffness, only: stiffness_t, is_larger, kind_at_rest, new_stiffness, full_loads
   implicit none
   private
   public :: find_distance_to_equilibrium, find_lowest_frequency, time_to_equilibrium

   !> Unknowns of the largest stiffness that is factorised for this: a few seconds and 1 GB; if not requested: a few MB; for a
   !> proposal how to reach equilibrium: a second and 0.2 GB.
   integer, parameter :: most_unknowns = 500000, most_unasked = 10000, most_proposed = 100000
   integer, parameter :: turns = 4               !! of inverse iteration, at most
   real(dp), parameter :: converged = 1e-3_dp    !! relative change of the frequency at which it ends

   !> Critically damped, (1 + t w) exp(-t w) of a mode is left: a ten-thousandth after this many 1/w.
   real(dp), parameter :: radians_to_equilibrium = 12.0_dp

contains

   !> Distance from equilibrium: the square root of the energy to be released, over the strain energy at equilibrium, |u + w|**2 K/2
   !> with the displacement w to it: E - f . w + r . w/2, f being the internal forces. It is the relative distance of displacements;
   !> G, J and the energies have about twice the error, K the same. If no load is left at the end, a part of the present strain
   !> energy replaces that at equilibrium. Negative if unknown: strains are zero up to rounding, the model is too large, or memory
   !> is insufficient.
   subroutine find_distance_to_equilibrium(m, distance)
      type(problem_t), intent(inout) :: m
      real(dp), intent(out) :: distance
      type(stiffness_t) :: k
      real(dp), parameter :: least = 1e-6_dp     ! of the present strain energy
      real(dp), allocatable :: force(:, :), internal(:, :), du(:, :)
      real(dp) :: stored, missing
      logical :: done
      distance = -1
      if (m%body_contact%wanted) return          ! contacts of bodies in equilibrium are not known in advance
      call update_particles(m)
      stored = stored_energy(m)
      if (.not. stored > epsilon(1.0_dp)*kinetic_energy(m)) return
      call unbalanced_force(m, force, internal)
      call new_stiffness(m, merge(most_unknowns, most_unasked, m%damping_rate > 0), k, done)
      if (done) then
         call k%solve(m, force, du)
         missing = sum(force*du)/2
         distance = sqrt((kinetic_energy(m) + max(0.0_dp, missing)) &
                         /max(least*stored, stored - sum(internal*du) + missing))
         if (.not. distance <= huge(distance)) distance = -1
      end if
      call k%release()
   end subroutine find_distance_to_equilibrium

   !> The lowest angular frequency that the loads excite [1/s], by inverse iteration from the static solution under them.
   !> 0 where it is not known: the loads move a body as a whole or nothing at all, there is neither load nor motion, or the model is
   !> too large.
   !>
   !> A few turns only: the deflection by the loads is near the mode that is sought. Motions as a whole that nothing holds, of which
   !> rounding leaves a part that would grow with each turn, are taken out. Loads that do work on them lead to no equilibrium.
   subroutine find_lowest_frequency(m, k, frequency)
      type(problem_t), intent(inout) :: m
      type(stiffness_t), intent(inout) :: k      !! that of the static solution, if it is there
      real(dp), intent(out) :: frequency
      real(dp), parameter :: balanced = 1e-6_dp  ! part of the forces that may push a piece that nothing holds
      type(free_motions_t) :: free
      real(dp), allocatable :: x(:, :), y(:, :), mass(:, :), force(:, :)
      real(dp) :: square, last
      logical :: done
      integer :: turn, i
      frequency = 0
      if (is_larger(m, most_proposed)) return
      call refresh_grid(m)                       ! nodes have their masses now
      call full_loads(m, force)
      if (.not. any(abs(force) > 0)) return
      call find_free_motions(m, free)
      if (free%are_pushed(force, balanced)) return
      call new_stiffness(m, most_proposed, k, done, kind_at_rest(m, free%rigid_constraints))
      if (done) then
         allocate (mass(ndim, m%grid%n_points), source=0.0_dp)
         do i = 1, m%fields%mass_matrix%all%n_nodes
            associate (node => m%fields%mass_matrix%all%nodes(i))
               mass(:, node) = m%fields%mass_matrix%lumped(node)
            end associate
         end do
         call k%solve(m, force, x)
         call take_motion_as_whole(free, x)
         last = 0
         square = 0
         do turn = 1, turns
            if (.not. sum(mass*x**2) > 0) exit   ! the loads act on nodes that are held
            x = x/sqrt(sum(mass*x**2))
            call k%solve(m, mass*x, y)
            call take_motion_as_whole(free, y)
            square = sum(mass*x*y)/sum(mass*y**2) - k%point
            x = y
            if (abs(square - last) <= converged*square) exit
            last = square
         end do
         if (square > 100*k%point) frequency = sqrt(square)
      end if
   end subroutine find_lowest_frequency

   !> How long it takes until a ten-thousandth of the lowest mode is left, where it is damped critically, with a rate of twice its
   !> angular frequency [s].
   pure real(dp) function time_to_equilibrium(frequency) result(time)
      real(dp), intent(in) :: frequency          !! [1/s]
      time = radians_to_equilibrium/frequency
   end function time_to_equilibrium
end module hampm_static_equilibrium
