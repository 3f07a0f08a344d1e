!> The schemes of a step. They differ in when the stress, that is H, is updated:
!>
!>   usf    first, with the velocities mapped from the particles at the start;
!>   usl    last, with the updated nodal velocities: unstable where a node has little mass, so at free edges;
!>   musl   last, with velocities mapped anew from the updated particles (Sulsky, Zhou & Schreyer 1995);
!>   usavg  half of it first as in usf and half of it last as in musl (Bardenhagen 2002; Nairn 2003).
module hampm_schemes
   use hampm_kinds, only: dp, name_len
   use hampm_nodal_fields, only: at_start, new, mapped
   use hampm_sweep, only: sweep_t
   implicit none
   private
   public :: scheme_t, new_scheme

   !> A scheme as sweeps. After the last sweep of a step the cells hold what `map_at_start` maps.
   type :: scheme_t
      character(name_len) :: name = ''           !! 'usf', 'usl', 'usavg' or 'musl'
      logical :: remaps = .false.                !! whether velocities are mapped anew after the kick
      type(sweep_t) :: map_at_start              !! what the first node values of a step need
      type(sweep_t), allocatable :: sweeps(:)    !! the step
   end type scheme_t

contains

   !> The scheme of a name: 'usf', 'usl', 'usavg' or 'musl', with the mapping of a mass matrix where there is one. Where the
   !> particles stay where they are in the grid, masses are mapped only once, and momenta only when velocities have changed.
   pure function new_scheme(name, has_matrix, particles_stay) result(scheme)
      character(*), intent(in) :: name
      logical, intent(in) :: has_matrix, particles_stay
      type(scheme_t) :: scheme
      type(sweep_t) :: strain_and_map_force, kick_and_map
      scheme%name = name
      kick_and_map = sweep_t(kick=.true., map_momentum=.true.)
      strain_and_map_force = sweep_t(strain_fraction=1.0_dp, strain_by=at_start, map_force=.true.)
      scheme%remaps = .false.
      select case (name)
      case ('usf')
         allocate (scheme%sweeps, source=[strain_and_map_force, sweep_t(kick=.true., move=.true., map_momentum=.true.)])
      case ('usl')
         scheme%map_at_start%map_force = .true.
         allocate (scheme%sweeps, source=[sweep_t(kick=.true., strain_fraction=1.0_dp, strain_by=new, move=.true., &
                                                  map_momentum=.true., map_force=.true.)])
      case ('usavg')
         scheme%remaps = .true.
         strain_and_map_force%strain_fraction = 0.5_dp
         allocate (scheme%sweeps, source=[strain_and_map_force, kick_and_map, &
                                          sweep_t(strain_fraction=0.5_dp, strain_by=mapped, move=.true., &
                                                  map_momentum=.not. particles_stay)])
      case default
         scheme%remaps = .true.
         scheme%map_at_start%map_force = .true.
         allocate (scheme%sweeps, source=[kick_and_map, &
                                          sweep_t(strain_fraction=1.0_dp, strain_by=mapped, move=.true., &
                                                  map_momentum=.not. particles_stay, map_force=.true.)])
      end select
      scheme%map_at_start%locate = .true.
      scheme%map_at_start%map_mass = .true.
      scheme%map_at_start%map_momentum = .true.
      scheme%map_at_start%map_matrix = has_matrix
      associate (last => scheme%sweeps(size(scheme%sweeps)))
         last%map_mass = .not. particles_stay
         last%map_matrix = has_matrix .and. .not. particles_stay
      end associate
   end function new_scheme
end module hampm_schemes
