!> Whether the constants of materials fit their laws, and whether the rest of a scene can be followed with laws that have a history:
!> what would go on from another state than the last is refused.
module hampm_history_consistency
   use hampm_kinds, only: dp, name_len
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_laws, has_history

   !> The laws with a history.
   character(*), parameter :: with_history(*) = [character(name_len) :: 'j2_plastic', 'viscoelastic']

contains

   !> Whether a law has a history.
   elemental logical function has_history(law)
      character(*), intent(in) :: law
      has_history = any(with_history == law)
   end function has_history

   !> Check the laws of a scene.
   pure subroutine check_laws(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%materials)
         if (.not. settings%good(settings%find('material', k), 'law')) cycle
         call check_plastic(scene, settings, k, mistakes)
         call check_viscous(scene, settings, k, mistakes)
         call check_dilatation(scene, settings, k, mistakes)
      end do
      k = findloc(has_history(scene%materials%law), .true., dim=1)
      if (k > 0) call check_rest(scene, settings, '&material law = '''//trim(scene%materials(k)%law)//'''', mistakes)
   end subroutine check_laws

   !> Check the constants of plasticity.
   pure subroutine check_plastic(scene, settings, k, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k                     !! of the material
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry
      entry = settings%find('material', k)
      associate (m => scene%materials(k))
         if (m%law == 'j2_plastic') then
            if (settings%good(entry, 'yield_stress') .and. .not. m%yield_stress > 0) call settings%complain(mistakes, entry, &
               'yield_stress', 'must be given, above 0, with law = ''j2_plastic''')
            return
         end if
         if (m%yield_stress > 0) call settings%complain(mistakes, entry, 'yield_stress', 'goes with law = ''j2_plastic'' only')
         if (m%hardening > 0) call settings%complain(mistakes, entry, 'hardening', 'goes with law = ''j2_plastic'' only')
      end associate
   end subroutine check_plastic

   !> Check the constants of viscoelasticity: no more can relax than there is.
   pure subroutine check_viscous(scene, settings, k, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k                     !! of the material
      type(mistakes_t), intent(inout) :: mistakes
      real(dp), parameter :: decimals = 1.0e-6_dp  ! of constants that are given by their decimals
      real(dp) :: mu
      integer :: entry
      entry = settings%find('material', k)
      if (.not. (settings%good(entry, 'moduli') .and. settings%good(entry, 'relaxation_times'))) return
      associate (m => scene%materials(k))
         if (m%law /= 'viscoelastic') then
            if (size(m%moduli) > 0) call settings%complain(mistakes, entry, 'moduli', 'goes with law = ''viscoelastic'' only')
            if (size(m%relaxation_times) > 0) call settings%complain(mistakes, entry, 'relaxation_times', &
                                                                     'goes with law = ''viscoelastic'' only')
            return
         end if
         if (size(m%moduli) == 0) then
            call settings%complain(mistakes, entry, 'moduli', 'must be given with law = ''viscoelastic''')
         else if (size(m%moduli) /= size(m%relaxation_times)) then
            call settings%complain(mistakes, entry, 'relaxation_times', 'must be as many as moduli: '//to_text(size(m%moduli)))
         end if
         if (.not. (settings%good(entry, 'young') .and. settings%good(entry, 'poisson'))) return
         mu = m%young/(2*(1 + m%poisson))
         if (sum(m%moduli) > (1 + decimals)*mu) call settings%complain(mistakes, entry, 'moduli', 'must have a sum of at most '// &
            to_text(mu)//' [Pa], the shear modulus at once, young/(2 (1 + poisson)); theirs is '//to_text(sum(m%moduli)))
      end associate
   end subroutine check_viscous

   !> The mean dilatation of a cell is there for some laws, in the plane in which volume may be hard to change, where material
   !> stays in its cell.
   pure subroutine check_dilatation(scene, settings, k, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k                     !! of the material
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: key = 'dilatation', intro = '''cell'' goes with '
      integer :: entry
      entry = settings%find('material', k)
      if (scene%materials(k)%dilatation /= 'cell') return
      if (.not. has_history(scene%materials(k)%law)) call settings%complain(mistakes, entry, key, intro// &
         'law = ''j2_plastic'' or ''viscoelastic'' only')
      if (scene%run%plane /= 'strain') call settings%complain(mistakes, entry, key, intro//'&run plane = ''strain'' only: in '// &
         'plane stress the thickness gives way, and no cell locks')
      if (scene%method%frame /= 'total') call settings%complain(mistakes, entry, key, intro//'&method frame = ''total'' only')
      if (scene%energy_release%energy_balance .and. scene%method%time == 'explicit') call settings%complain(mistakes, entry, key, &
         'must be ''point'' with the estimator ''energy_balance'' of explicit steps: the audit books the work of each point')
   end subroutine check_dilatation

   !> Check what else there is in a scene.
   pure subroutine check_rest(scene, settings, law, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      character(*), intent(in) :: law              !! one that has a history, as it is given
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k, method
      method = settings%find('method', 1)
      call settings%demand(mistakes, method, 'time_steps', 'global', 'with '//law//': what a particle remembers is kept after '// &
                           'steps that are the same for all')
      if (size(scene%growth) > 0) call settings%complain(mistakes, settings%find('growth', 1), 'law', 'does not go with '//law// &
         ': the energy release rate of a crack that grows is not known where energy is dissipated around it')
      associate (release => scene%energy_release)
         if (release%nodal_force .or. release%stress_closure .or. release%crack_closure) call settings%complain(mistakes, &
            settings%find('energy_release', 1), 'estimators', 'must be others than ''nodal_force'', ''stress_closure'' and '// &
            '''crack_closure'' with '//law//': closing a crack does not give back what its opening took')
      end associate
      if (scene%method%time /= 'static') return
      if (.not. any(scene%refine%indicator == [character(4) :: 'none', 'tip'])) call settings%complain(mistakes, &
         settings%find('refine', 1), 'indicator', 'must be ''tip'' or ''none'' with time = ''static'' and '//law// &
         ': another mesh begins from material without loads, and forgets what has been')
      if (scene%crack%contact) call settings%complain(mistakes, settings%find('crack', 1), 'contact', 'must be ''none'' with '// &
         'time = ''static'' and '//law//'. time = ''explicit'' follows faces that touch')
      do k = 1, size(scene%paths)
         if (scene%paths(k)%contact) call settings%complain(mistakes, settings%find('crack', scene%paths(k)%number), 'contact', &
            'must be ''none'' with time = ''static'' and '//law//'. time = ''explicit'' follows faces that touch')
      end do
      do k = 1, size(scene%constraints)
         if (scene%constraints(k)%motion%push_only) call settings%complain(mistakes, settings%find('constraint', k), &
            'push_only', 'must be .false. with time = ''static'' and '//law//': which supports push is tried by turns')
      end do
   end subroutine check_rest
end module hampm_history_consistency
