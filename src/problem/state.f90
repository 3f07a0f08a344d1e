!> The state of a problem beside its particles: time, nodal values kept between steps, and energy balance.
module hampm_state
   use hampm_kinds, only: dp, long
   use hampm_prescribed_nodes, only: prescribed_work_t
   use hampm_error_context, only: when
   implicit none
   private
   public :: state_t, energies_t

   !> Time of a problem. Nodal fields are allocated if nodes keep them between equilibria or implicit steps.
   type :: state_t
      real(dp) :: time = 0                       !! [s]
      integer(long) :: steps = 0                 !! steps done
      real(dp) :: last_dt = 0                    !! length of the last step [s]
      real(dp), allocatable :: displacement(:, :) !! since the start; static: from unloaded material [m], (ndim, n_points)
      real(dp), allocatable :: velocity(:, :)    !! [m/s]
      real(dp), allocatable :: acceleration(:, :) !! [m/s2]
   contains
      procedure :: when => time_and_step
   end type state_t

   !> Work and losses since the start, for the balance of energy.
   type :: energies_t
      real(dp) :: external_work = 0              !! of the loads and of constraints that move [J]
      type(prescribed_work_t) :: prescribed      !! preliminary part of the latter
      real(dp) :: damping_loss = 0               !! taken by the damping [J]
      real(dp) :: absorbed_energy = 0            !! taken by absorbing edges [J]
      real(dp) :: fracture_energy = 0            !! taken by the new faces of cracks that grow [J]
      real(dp) :: numerical_loss = 0             !! lost by the method, booked with an energy balance [J]
   end type energies_t

contains

   !> The time and the step, to begin a message with.
   function time_and_step(self) result(text)
      class(state_t), intent(in) :: self
      character(:), allocatable :: text
      text = when(self%steps, self%time)
   end function time_and_step
end module hampm_state
