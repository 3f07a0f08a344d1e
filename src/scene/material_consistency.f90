!> Whether the constants of materials are those of solids, and as many as belong together.
module hampm_material_consistency
   use hampm_kinds, only: dp
   use hampm_mistakes, only: mistakes_t
   use hampm_orthotropic, only: why_not_definite
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_constants

   real(dp), parameter :: most_apart = 1e10_dp   !! the largest of moduli, over the least

contains

   !> Check all materials of which there is a body.
   pure subroutine check_constants(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k, entry
      do k = 1, size(scene%materials)
         entry = settings%find('material', scene%materials(k)%number)
         select case (merge(scene%materials(k)%law, repeat(' ', len(scene%materials%law)), settings%good(entry, 'law')))
          case ('orthotropic')
            call check_orthotropic(scene, settings, k, entry, mistakes)
          case ('mooney_rivlin')
            call check_rubber(scene, settings, k, entry, mistakes)
          case ('viscoelastic')
            call check_viscous(scene, settings, k, entry, mistakes)
         end select
      end do
   end subroutine check_constants

   !> With the constants of an orthotropic material no strain releases energy.
   pure subroutine check_orthotropic(scene, settings, k, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k, entry              !! number of the material, and position of its group, here and below
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: keys(*) = [character(10) :: 'young_1', 'young_2', 'young_3', 'shear_12', 'poisson_12', &
                                            'poisson_13', 'poisson_23']
      character(:), allocatable :: why
      logical :: plane_stress
      integer :: i
      if (.not. (settings%good(settings%find('run', 1), 'plane') .and. &
                 all([(settings%good(entry, trim(keys(i))), i=1, size(keys))]))) return
      plane_stress = scene%run%plane == 'stress'
      associate (of => scene%materials(k)%orthotropic)
         if (minval(of%young(:merge(2, 3, plane_stress))) <= 0 .or. of%shear_12 <= 0) return
         associate (moduli => [of%young(:merge(2, 3, plane_stress)), of%shear_12])
            if (maxval(moduli) > most_apart*minval(moduli)) then
               call settings%complain(mistakes, entry, 'young_1', 'and the other moduli must be within a factor of 1e10 of '// &
                                      'each other: else rounding hides the least of them')
               return
            end if
         end associate
         why = why_not_definite(of, plane_stress)
         if (why /= '') call settings%complain(mistakes, entry, 'poisson_12', why//': else a strain would release energy')
         if (scene%crack%present .and. scene%crack%kind == 'symmetry' .and. abs(of%angle - 90*anint(of%angle/90)) > 0) &
            call settings%complain(mistakes, entry, 'angle', 'must be a multiple of 90 degrees with &crack kind = '// &
                                   '''symmetry'': else the other half is no mirror image. Use kind = ''line''')
      end associate
   end subroutine check_orthotropic

   !> The modulus of the second invariant leaves that of the first, and the volume stiff however it changes.
   pure subroutine check_rubber(scene, settings, k, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k, entry
      type(mistakes_t), intent(inout) :: mistakes
      real(dp) :: most
      if (.not. (settings%good(entry, 'c01') .and. settings%good(entry, 'young') .and. settings%good(entry, 'poisson'))) return
      associate (m => scene%materials(k))
         most = m%young/(4*(1 + m%poisson))*min(1.0_dp, m%poisson/(1 - 2*m%poisson))
         if (m%c01 > most) call settings%complain(mistakes, entry, 'c01', 'must be at most '//to_text(max(most, 0.0_dp))// &
            ' [Pa], the less of mu/2 and lambda/4 of young and poisson: else c10, or the stiffness of the volume, is below 0')
      end associate
   end subroutine check_rubber

   !> Of a viscoelastic material no more can relax than there is.
   pure subroutine check_viscous(scene, settings, k, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k, entry
      type(mistakes_t), intent(inout) :: mistakes
      real(dp), parameter :: decimals = 1.0e-6_dp  ! of constants that are given by their decimals
      real(dp) :: mu
      if (.not. (settings%good(entry, 'moduli') .and. settings%good(entry, 'relaxation_times'))) return
      associate (m => scene%materials(k))
         if (size(m%moduli) /= size(m%relaxation_times)) &
            call settings%complain(mistakes, entry, 'relaxation_times', 'must be as many as moduli: '//to_text(size(m%moduli)))
         if (.not. (settings%good(entry, 'young') .and. settings%good(entry, 'poisson'))) return
         mu = m%young/(2*(1 + m%poisson))
         if (sum(m%moduli) > (1 + decimals)*mu) call settings%complain(mistakes, entry, 'moduli', 'must have a sum of at most '// &
            to_text(mu)//' [Pa], the shear modulus at once, young/(2 (1 + poisson)); theirs is '//to_text(sum(m%moduli)))
      end associate
   end subroutine check_viscous
end module hampm_material_consistency
