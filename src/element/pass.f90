!> What one pass over the particles does (`hampm_particle_pass`): the words in which the schemes are written (`hampm_motion`).
module hampm_pass
   use hampm_kinds, only: dp, name_len
   use hampm_nodal_fields, only: v_n
   implicit none
   private
   public :: pass_t, scheme_t

   !> What a pass does with each particle, in this order.
   type :: pass_t
      logical :: locate = .false.                !! find the local coordinates; else they are those of the last pass
      logical :: kick = .false.                  !! v <- v + a dt
      real(dp) :: strain_fraction = 0            !! part of the step over which to strain, 0: not at all
      integer :: strain_by = v_n                 !! which nodal velocity strains the particles
      logical :: keeps_history = .true.          !! after straining: laws with a history remember the state
      logical :: move = .false.                  !! u <- u + v^(n+1) dt
      logical :: map_mass = .false.              !! lumped mass to the grid
      logical :: map_momentum = .false.          !! momentum to the grid
      logical :: map_matrix = .false.            !! mass matrix to the cells
      logical :: map_force = .false.             !! internal force to the grid
      logical :: audit = .false.                 !! sum what the energy audit asks for
   end type pass_t

   !> A scheme as passes. After the last pass of a step the cells hold what `map_at_start` maps.
   type :: scheme_t
      character(name_len) :: name = ''           !! 'usf', 'usl', 'usavg' or 'musl'
      logical :: remaps = .false.                !! whether velocities are mapped anew after the kick
      type(pass_t) :: map_at_start               !! what the first node values of a step need
      type(pass_t), allocatable :: passes(:)     !! the step
   end type scheme_t
end module hampm_pass
