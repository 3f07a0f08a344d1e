!> The table of estimators of the energy release rate. G is by the first chosen one in its order.
module hampm_estimators
   use hampm_crack_closure, only: virtual_crack_closure, stress_closure
   use hampm_estimator, only: estimator_t
   use hampm_material_force, only: material_force
   implicit none
   private
   public :: estimators

contains

   !> All rows.
   pure function estimators() result(rows)
      type(estimator_t), allocatable :: rows(:)
      rows = [ &
         estimator_t('domain_integral', needs_radii=.true.), &
         estimator_t('vcct', 'energy release rate, virtual crack closure', needs_nodes=.true., needs_two_points=.true., &
                     needs_elasticity=.true., differs_from_j=.true., find=virtual_crack_closure), &
         estimator_t('material_force', 'energy release rate, material forces of the nodes', needs_radii=.true., &
                     needs_free_faces=.true., needs_tip_at_rest=.true., differs_from_j=.true., find=material_force), &
         estimator_t('stress_closure', 'energy release rate, stress closure', needs_nodes=.true., needs_mass=.true., &
                     needs_elasticity=.true., differs_from_j=.true., find=stress_closure)]
   end function estimators
end module hampm_estimators
