!> An estimator of the energy release rate: its name, requirements, and the procedure that finds G of each mode at a tip.
!>
!> A new estimator is a file with such a procedure and a row in the table of `hampm_estimators`, for its choice in
!> `&energy_release`, columns with estimated errors, part of G, summary and checkpoints, and rules on its requirements.
module hampm_estimator
   use hampm_kinds, only: dp, name_len
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_estimated_errors, only: error_t
   use hampm_failure, only: failure_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: estimator_t, estimate_t, total

   !> A row of the table.
   type :: estimator_t
      character(name_len) :: name = ''           !! in model files; its columns are G_<name>_I and G_<name>_II
      character(64) :: meaning = ''              !! of these
      logical :: needs_radii = .false.           !! whether it uses the material within the radii of a tip
      logical :: needs_nodes = .false.           !! whether it needs a node at the tip, and others around it
      logical :: needs_two_points = .false.      !! whether it is 14 to 24 % off with one particle a cell
      logical :: needs_mass = .false.            !! whether it extrapolates to nodes with the mass matrix
      logical :: needs_elasticity = .false.      !! whether it takes material for elastic
      logical :: needs_isotropy = .false.        !! and for isotropic
      logical :: needs_free_faces = .false.      !! whether it takes crack faces for free of tractions
      logical :: needs_tip_at_rest = .false.     !! whether it takes a tip for one that does not grow
      logical :: differs_from_j = .false.        !! whether its error is at least its difference from J's part of its mode
      procedure(find_rates), pointer, nopass :: find => null() !! of the domain integral none, whose values are more than these
   end type estimator_t

   !> Result of an estimator at a tip.
   type :: estimate_t
      type(estimator_t) :: by
      real(dp) :: rate(modes) = 0, uncertainty(modes) = 0 !! of `find_rates`
      type(error_t) :: error(modes)
   end type estimate_t

   abstract interface
      !> Find G of each mode, of the whole crack also in a half model. Fails where it cannot be found.
      subroutine find_rates(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
         import :: problem_t, dp, crack_tip_t, particles_t, mass_solver_t, failure_t, modes
         type(problem_t), intent(in) :: problem  !! its loads at their places in the grid
         real(dp), intent(in) :: factors(:)      !! of the loads [-]
         type(crack_tip_t), intent(in) :: tip
         type(particles_t), intent(in) :: p      !! at the places of the motion's particles
         type(mass_solver_t), intent(inout) :: extrapolation !! solver without fixed components
         real(dp), intent(inout) :: rate(modes)  !! signed like opening and sliding [J/m2]
         real(dp), intent(inout) :: uncertainty(modes) !! the least that the errors of these are [J/m2]
         type(failure_t), intent(inout) :: failure
      end subroutine find_rates
   end interface

contains

   !> Energy release rate of both modes together [J/m2]: the signs of the modes are only directions of opening and sliding.
   pure real(dp) function total(g)
      real(dp), intent(in) :: g(modes)           !! [J/m2]
      total = sum(abs(g))
   end function total
end module hampm_estimator
