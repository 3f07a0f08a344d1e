!> Checks of the constants of materials against each other.
module hampm_material_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_key_table, only: material_constants
   use hampm_law, only: flaw_t, law_row_t, value_of
   use hampm_laws, only: law_row
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_constants

contains

   !> Check all materials of which there is a body, where each constant is as its key asks.
   pure subroutine check_constants(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      type(law_row_t) :: row
      type(flaw_t), allocatable :: flaws(:)
      integer :: k, i, entry
      do k = 1, size(model%materials)
         associate (m => model%materials(k))
            entry = settings%find('material', m%number)
            if (.not. (settings%good(entry, 'law') .and. settings%good(settings%find('run', 1), 'plane'))) cycle
            row = law_row(m%law)
            if (.not. associated(row%check)) cycle
            if (.not. all([settings%good(entry, 'young'), settings%good(entry, 'poisson'), &
                           [(settings%good(entry, trim(material_constants(i)%name)), i=1, size(material_constants))]])) cycle
            call row%check(m%young, m%poisson, ndim == 2 .and. model%run%plane == 'stress', m%constants, flaws)
            do i = 1, size(flaws)
               call settings%complain(entry, trim(flaws(i)%key), flaws(i)%what)
            end do
            associate (angle => value_of(m%constants, 'angle', 0.0_dp))
               if (model%is_half() .and. abs(angle - 90*anint(angle/90)) > 0) &
                  call settings%complain(entry, 'angle', 'must be a multiple of 90 degrees with &crack kind = '// &
                                         '''symmetry'': else the other half is no mirror image. Use kind = ''plane''')
            end associate
         end associate
      end do
   end subroutine check_constants
end module hampm_material_consistency
