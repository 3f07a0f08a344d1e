!> The table of material laws.
module hampm_laws
   use hampm_j2_plastic, only: new_j2_plastic
   use hampm_law, only: law_row_t
   use hampm_mooney_rivlin, only: new_mooney_rivlin, check_mooney_rivlin
   use hampm_neo_hookean, only: new_neo_hookean
   use hampm_orthotropic, only: check_orthotropic
   use hampm_viscoelastic, only: new_viscoelastic, check_viscoelastic
   implicit none
   private
   public :: laws, law_row

contains

   !> All rows. The linear laws have no law in space: `hampm_material` makes their moduli in the plane of their constants.
   pure function laws() result(rows)
      type(law_row_t), allocatable :: rows(:)
      allocate (rows, source=[ &
         law_row_t('linear_elastic'), &
         law_row_t('neo_hookean', is_finite=.true., make=new_neo_hookean), &
         law_row_t('mooney_rivlin', is_finite=.true., make=new_mooney_rivlin, check=check_mooney_rivlin), &
         law_row_t('j2_plastic', has_history=.true., make=new_j2_plastic), &
         law_row_t('viscoelastic', has_history=.true., make=new_viscoelastic, check=check_viscoelastic), &
         law_row_t('orthotropic', check=check_orthotropic)])
   end function laws

   !> The row of a name; a row without a name if absent.
   pure type(law_row_t) function law_row(name) result(row)
      character(*), intent(in) :: name
      type(law_row_t), allocatable :: rows(:)
      integer :: k
      allocate (rows, source=laws())
      do k = 1, size(rows)
         if (rows(k)%name == name) row = rows(k)
      end do
   end function law_row
end module hampm_laws
