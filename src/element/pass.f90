!> A pass over the particles (`hampm_particle_pass`), and the schemes of a step, which are lists of passes.
!>
!> The schemes differ in when the stress, that is H, is updated:
!>
!>   usf    first, with the velocities mapped from the particles at the start;
!>   usl    last, with the updated nodal velocities: unstable where a node has little mass, so at free edges;
!>   musl   last, with velocities mapped anew from the updated particles (Sulsky, Zhou & Schreyer 1995);
!>   usavg  half of it first as in usf and half of it last as in musl (Bardenhagen 2002; Nairn 2003).
module hampm_pass
   use hampm_kinds, only: dp, name_len
   use hampm_nodal_fields, only: v_n, v_next, v_mapped
   implicit none
   private
   public :: pass_t, scheme_t, new_scheme, new_scheme_of_domains

   !> Operations of a pass on each particle, in this order.
   type :: pass_t
      logical :: locate = .false.                !! find the local coordinates; else they are of the last pass
      logical :: kick = .false.                  !! v <- v + a dt
      real(dp) :: strain_fraction = 0            !! part of the step over which to strain, 0: not at all
      integer :: strain_by = v_n                 !! which nodal velocity strains the particles
      logical :: updates_state = .true.          !! after straining: update the state of history-dependent laws
      logical :: move = .false.                  !! u <- u + v^(n+1) dt
      logical :: map_mass = .false.              !! lumped mass to the grid
      logical :: map_momentum = .false.          !! momentum to the grid
      logical :: momentum_later = .false.        !! but not by element operators: unused before particles are up to date
      logical :: map_matrix = .false.            !! mass matrix to the cells
      logical :: map_force = .false.             !! internal force to the grid
      logical :: audit = .false.                 !! sum the terms of the energy balance
   end type pass_t

   !> A scheme as passes. After the last pass of a step the cells hold the sums of `map_at_start`.
   type :: scheme_t
      character(name_len) :: name = ''           !! 'usf', 'usl', 'usavg' or 'musl'
      logical :: remaps = .false.                !! whether velocities are mapped anew after the kick
      type(pass_t) :: map_at_start               !! for the first node values of a step
      type(pass_t), allocatable :: passes(:)     !! the step
   end type scheme_t

contains

   !> The scheme of a name: 'usf', 'usl', 'usavg' or 'musl', with the mapping of a mass matrix where there is one. Where the
   !> particles stay where they are in the grid, masses are mapped only once, and momenta only when velocities have changed.
   pure function new_scheme(name, has_matrix, particles_stay) result(scheme)
      character(*), intent(in) :: name
      logical, intent(in) :: has_matrix, particles_stay
      type(scheme_t) :: scheme
      type(pass_t) :: strain_and_map_force, kick_and_map
      scheme%name = name
      kick_and_map = pass_t(kick=.true., map_momentum=.true.)
      strain_and_map_force = pass_t(strain_fraction=1.0_dp, strain_by=v_n, map_force=.true.)
      scheme%remaps = .false.
      select case (name)
      case ('usf')
         scheme%passes = [strain_and_map_force, pass_t(kick=.true., move=.true., map_momentum=.true.)]
      case ('usl')
         scheme%map_at_start%map_force = .true.
         scheme%passes = [pass_t(kick=.true., strain_fraction=1.0_dp, strain_by=v_next, move=.true., &
                                  map_momentum=.true., map_force=.true.)]
      case ('usavg')
         scheme%remaps = .true.
         strain_and_map_force%strain_fraction = 0.5_dp
         scheme%passes = [strain_and_map_force, kick_and_map, &
                          pass_t(strain_fraction=0.5_dp, strain_by=v_mapped, move=.true., &
                                  map_momentum=.not. particles_stay)]
      case default
         scheme%remaps = .true.
         scheme%map_at_start%map_force = .true.
         scheme%passes = [kick_and_map, &
                          pass_t(strain_fraction=1.0_dp, strain_by=v_mapped, move=.true., &
                                  map_momentum=.not. particles_stay, map_force=.true.)]
      end select
      scheme%map_at_start%locate = .true.
      scheme%map_at_start%map_mass = .true.
      scheme%map_at_start%map_momentum = .true.
      scheme%map_at_start%map_matrix = has_matrix
      associate (last => scheme%passes(size(scheme%passes)))
         last%map_mass = .not. particles_stay
         last%map_matrix = has_matrix .and. .not. particles_stay
      end associate
   end function new_scheme

   !> The scheme of that name where particles have domains (`hampm_domain_pass`). As the corners that tell the strain move with it,
   !> stress and positions are always of one time, and usf, usavg and musl are the same leapfrog: they drift, kick and drift by the
   !> whole and nothing, by halves, or by nothing and the whole of a step. Every step begins with a map,
   !> and where it has drifted before the kick, velocities are mapped anew to where the forces act.
   pure function new_scheme_of_domains(name, has_matrix) result(scheme)
      character(*), intent(in) :: name           !! 'usf', 'usl', 'usavg' or 'musl'
      logical, intent(in) :: has_matrix
      type(scheme_t) :: scheme
      type(pass_t) :: drift_and_map_force, kick_and_map
      scheme%name = name
      scheme%remaps = name == 'usavg' .or. name == 'musl'
      scheme%map_at_start = pass_t(map_mass=.true., map_momentum=.true., map_matrix=has_matrix)
      scheme%map_at_start%map_force = name == 'usl' .or. name == 'musl'
      kick_and_map = pass_t(kick=.true., map_momentum=.true.)
      drift_and_map_force = pass_t(strain_fraction=1.0_dp, strain_by=v_n, map_mass=.true., map_momentum=.true., &
                                   map_matrix=has_matrix, map_force=.true.)
      select case (name)
      case ('usf')
         scheme%passes = [drift_and_map_force, pass_t(kick=.true.)]
      case ('usl')
         scheme%passes = [pass_t(kick=.true., strain_fraction=1.0_dp, strain_by=v_next)]
      case ('usavg')
         drift_and_map_force%strain_fraction = 0.5_dp
         scheme%passes = [drift_and_map_force, kick_and_map, pass_t(strain_fraction=0.5_dp, strain_by=v_mapped)]
      case default
         scheme%passes = [kick_and_map, pass_t(strain_fraction=1.0_dp, strain_by=v_mapped)]
      end select
   end function new_scheme_of_domains
end module hampm_pass
