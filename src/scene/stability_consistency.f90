!> Whether the time step of a scene can be stable at all, as far as its keys tell before it is run.
module hampm_stability_consistency
   use hampm_kinds, only: dp
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t, material_spec_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_stability

   !> Cells that a dilatational wave may pass in a step. With the lumped mass matrix a bar with n particles a cell and direction
   !> allows 2 sqrt(1 - (n**2 - 1)/(3 n**2)), which is 2 for n = 1; with any other matrix it allows less (docs/mass.md).
   real(dp), parameter :: most_cells_a_step = 2.0_dp
   !> `rate*dt` above which `v <- v - rate*dt*v` turns the velocity around in a step; from 2 on it grows.
   real(dp), parameter :: most_damping_a_step = 1.0_dp

contains

   !> Refuse time steps that no scheme and mass matrix makes stable.
   pure subroutine check_stability(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      real(dp) :: shear, dilatational, chosen, dt
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. (settings%good(entry, 'courant') .and. settings%good(entry, 'wave_speed'))) return
      if (.not. materials_good(scene, settings)) return
      call largest_speeds(scene%materials, scene%run%plane == 'stress', shear, dilatational)
      chosen = dilatational
      if (scene%method%wave_speed == 'shear') chosen = shear
      if (scene%method%courant*(dilatational/chosen) > most_cells_a_step) then
         call settings%complain(mistakes, entry, 'courant', 'must be at most '//to_text(most_cells_a_step*(chosen/dilatational))// &
                                ', not '//to_text(scene%method%courant)//', with wave_speed = '''// &
                                trim(scene%method%wave_speed)//''': above it dilatational waves, '// &
                                to_text(dilatational/shear)//' times as fast as shear waves here, pass two cells in a step, '// &
                                'which is unstable with every scheme and mass matrix'//other_speed(scene))
         return
      end if
      if (.not. (settings%good(settings%find('damping', 1), 'rate') .and. settings%good(settings%find('grid', 1), 'cell'))) return
      dt = scene%method%courant*smallest_cell(scene)/chosen
      if (scene%output%history_interval > 0) dt = min(dt, scene%output%history_interval)
      if (scene%damping%rate*dt <= most_damping_a_step) return
      call settings%complain(mistakes, settings%find('damping', 1), 'rate', 'must be at most '//to_text(most_damping_a_step/dt)// &
                             ' [1/s] with a time step of '//to_text(dt)//' s: above it the damping reverses velocities '// &
                             'within a step. Reduce it or &method courant')
   end subroutine check_stability

   !> Advice where the other wave speed makes the time step fit.
   pure function other_speed(scene) result(text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: text
      text = ''
      if (scene%method%wave_speed == 'shear' .and. scene%method%courant <= 1) text = '; or use wave_speed = ''dilatational'''
   end function other_speed

   !> Whether all constants that wave speeds depend on are known.
   pure logical function materials_good(scene, settings)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer :: i, entry
      materials_good = size(scene%materials) > 0 .and. settings%good(settings%find('run', 1), 'plane')
      do i = 1, size(scene%materials)
         entry = settings%find('material', i)
         materials_good = materials_good .and. settings%good(entry, 'young') .and. settings%good(entry, 'poisson') &
                          .and. settings%good(entry, 'density')
      end do
   end function materials_good

   !> The largest wave speeds of any material [m/s].
   pure subroutine largest_speeds(materials, plane_stress, shear, dilatational)
      type(material_spec_t), intent(in) :: materials(:)
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(out) :: shear, dilatational
      real(dp) :: modulus
      integer :: i
      shear = 0
      dilatational = 0
      do i = 1, size(materials)
         associate (e => materials(i)%young, nu => materials(i)%poisson, rho => materials(i)%density)
            modulus = e/(1 - nu**2)
            if (.not. plane_stress) modulus = e*(1 - nu)/((1 + nu)*(1 - 2*nu))
            shear = max(shear, sqrt(e/(2*(1 + nu))/rho))
            dilatational = max(dilatational, sqrt(modulus/rho))
         end associate
      end do
   end subroutine largest_speeds

   !> Size of the cells that the first step is for: those around a tip are there from the start, and with subcycling the
   !> largest cells take the longest step [m].
   pure real(dp) function smallest_cell(scene) result(cell)
      type(scene_t), intent(in) :: scene
      cell = scene%grid%cell
      if (scene%refine%indicator == 'tip' .and. scene%method%time_steps == 'global') cell = scale(cell, -scene%refine%max_level)
   end function smallest_cell
end module hampm_stability_consistency
