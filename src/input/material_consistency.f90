!> Checks of the constants of materials against each other.
module hampm_material_consistency
   use hampm_kinds, only: dp
   use hampm_law, only: value_of, values_of
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   use hampm_orthotropic, only: why_not_definite, orthotropic_keys
   implicit none
   private
   public :: check_constants

   real(dp), parameter :: most_apart = 1e10_dp   !! the largest of moduli, over the least

contains

   !> Check all materials of which there is a body.
   pure subroutine check_constants(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: k, entry
      do k = 1, size(model%materials)
         entry = settings%find('material', model%materials(k)%number)
         select case (merge(model%materials(k)%law, repeat(' ', len(model%materials%law)), settings%good(entry, 'law')))
          case ('orthotropic')
            call check_orthotropic(model, settings, k, entry)
          case ('mooney_rivlin')
            call check_hyperelastic(model, settings, k, entry)
          case ('viscoelastic')
            call check_viscous(model, settings, k, entry)
         end select
      end do
   end subroutine check_constants

   !> With the constants of an orthotropic material no strain releases energy.
   pure subroutine check_orthotropic(model, settings, k, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k, entry              !! number of the material, and position of its group, here and below
      character(:), allocatable :: why
      logical :: plane_stress
      integer :: i
      if (.not. (settings%good(settings%find('run', 1), 'plane') .and. &
                 all([(settings%good(entry, trim(orthotropic_keys(i)%name)), i=1, size(orthotropic_keys))]))) return
      plane_stress = model%run%plane == 'stress'
      associate (of => model%materials(k)%orthotropic)
         if (minval(of%young(:merge(2, 3, plane_stress))) <= 0 .or. of%shear_12 <= 0) return
         associate (moduli => [of%young(:merge(2, 3, plane_stress)), of%shear_12])
            if (maxval(moduli) > most_apart*minval(moduli)) then
               call settings%complain(entry, 'young_1', 'and the other moduli must be within a factor of 1e10 of '// &
                                      'each other: else rounding hides the least of them')
               return
            end if
         end associate
         why = why_not_definite(of, plane_stress)
         if (why /= '') call settings%complain(entry, 'poisson_12', why//': else a strain would release energy')
         if (model%is_half() .and. abs(of%angle - 90*anint(of%angle/90)) > 0) &
            call settings%complain(entry, 'angle', 'must be a multiple of 90 degrees with &crack kind = '// &
                                   '''symmetry'': else the other half is no mirror image. Use kind = ''line''')
      end associate
   end subroutine check_orthotropic

   !> The modulus of the second invariant leaves that of the first, and the volume stiff however it changes.
   pure subroutine check_hyperelastic(model, settings, k, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k, entry
      real(dp) :: most
      if (.not. (settings%good(entry, 'c01') .and. settings%good(entry, 'young') .and. settings%good(entry, 'poisson'))) return
      associate (m => model%materials(k))
         most = m%young/(4*(1 + m%poisson))*min(1.0_dp, m%poisson/(1 - 2*m%poisson))
         if (value_of(m%constants, 'c01', 0.0_dp) > most) call settings%complain(entry, 'c01', 'must be at most '// &
            to_text(max(most, 0.0_dp))//' [Pa], the less of mu/2 and lambda/4 of young and poisson: else c10, or '// &
            'the stiffness of the volume, is below 0')
      end associate
   end subroutine check_hyperelastic

   !> Of a viscoelastic material no more can relax than there is.
   pure subroutine check_viscous(model, settings, k, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k, entry
      real(dp), parameter :: decimals = 1.0e-6_dp  ! of constants that are given by their decimals
      real(dp) :: mu
      if (.not. (settings%good(entry, 'moduli') .and. settings%good(entry, 'relaxation_times'))) return
      associate (m => model%materials(k), moduli => values_of(model%materials(k)%constants, 'moduli'))
         if (size(moduli) /= size(values_of(m%constants, 'relaxation_times'))) &
            call settings%complain(entry, 'relaxation_times', 'must be as many as moduli: '//to_text(size(moduli)))
         if (.not. (settings%good(entry, 'young') .and. settings%good(entry, 'poisson'))) return
         mu = m%young/(2*(1 + m%poisson))
         if (sum(moduli) > (1 + decimals)*mu) call settings%complain(entry, 'moduli', 'must have a sum of at most '// &
            to_text(mu)//' [Pa], the instantaneous shear modulus, young/(2 (1 + poisson)); theirs is '//to_text(sum(moduli)))
      end associate
   end subroutine check_viscous
end module hampm_material_consistency
