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

   !> A scheme as sweeps. The last sweep of a step maps the particles as `map_at_start` does, from where they have moved.
   type :: scheme_t
      character(name_len) :: name = ''           !! 'usf', 'usl', 'usavg' or 'musl'
      type(sweep_t) :: map_at_start              !! what the first node values of a step need
      type(sweep_t), allocatable :: sweeps(:)    !! the step
   end type scheme_t

contains

   !> The scheme of a name: 'usf', 'usl', 'usavg' or 'musl', with the mapping of a mass matrix where there is one: at every
   !> step, or only at the start where the particles stay where they are in the grid.
   pure function new_scheme(name, has_matrix, matrix_stays) result(scheme)
      character(*), intent(in) :: name
      logical, intent(in) :: has_matrix, matrix_stays
      type(scheme_t) :: scheme
      type(sweep_t) :: strain_and_map_force, kick_and_map
      scheme%name = name
      kick_and_map = sweep_t(kick=.true., map_motion=.true.)
      strain_and_map_force = sweep_t(strain_fraction=1.0_dp, strain_by=at_start, map_force=.true.)
      select case (name)
      case ('usf')
         scheme%map_at_start = sweep_t(map_motion=.true.)
         allocate (scheme%sweeps, source=[strain_and_map_force, &
                                          sweep_t(kick=.true., move=.true., map_moved_motion=.true.)])
      case ('usl')
         scheme%map_at_start = sweep_t(map_motion=.true., map_force=.true.)
         allocate (scheme%sweeps, source=[sweep_t(kick=.true., strain_fraction=1.0_dp, strain_by=new, move=.true., &
                                                  map_moved_motion=.true., map_moved_force=.true.)])
      case ('usavg')
         strain_and_map_force%strain_fraction = 0.5_dp
         scheme%map_at_start = sweep_t(map_motion=.true.)
         allocate (scheme%sweeps, source=[strain_and_map_force, kick_and_map, &
                                          sweep_t(strain_fraction=0.5_dp, strain_by=mapped, move=.true., &
                                                  map_moved_motion=.true.)])
      case default
         scheme%map_at_start = sweep_t(map_motion=.true., map_force=.true.)
         allocate (scheme%sweeps, source=[kick_and_map, &
                                          sweep_t(strain_fraction=1.0_dp, strain_by=mapped, move=.true., &
                                                  map_moved_motion=.true., map_moved_force=.true.)])
      end select
      scheme%map_at_start%map_matrix = has_matrix
      scheme%sweeps(size(scheme%sweeps))%map_moved_matrix = has_matrix .and. .not. matrix_stays
   end function new_scheme
end module hampm_schemes
