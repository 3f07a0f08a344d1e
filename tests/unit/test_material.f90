!> What holds for every law: agreement at small strains, and the wave speeds.
program test_material
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_kinds, only: dp, ndim
   use hampm_law, only: constant, law_row_t
   use hampm_laws, only: laws
   use hampm_material, only: material_t, new_material
   implicit none

   real(dp), parameter :: young = 70.0e9_dp, poisson = 0.3_dp, density = 2700.0_dp
   logical, parameter :: plane_stress(2) = [.true., .false.]
   character(*), parameter :: planes(3) = [character(12) :: 'strain', 'stress', 'axisymmetric']
   type(law_row_t), allocatable :: rows(:)
   integer :: k, law

   allocate (rows, source=laws())
   call kinds_of_laws()
   call repeat_random_numbers()
   do law = 1, size(rows)
      call hoops(trim(rows(law)%name))
      do k = 1, size(planes)
         call tangent(trim(rows(law)%name), trim(planes(k)))
      end do
   end do
   do k = 1, 2
      do law = 1, size(rows)
         call eigenstrain(trim(rows(law)%name), plane_stress(k))
      end do
      do law = 2, size(rows)
         if (trim(rows(law)%name) == 'orthotropic') cycle   ! it is linear: test_orthotropic
         call small_strains(trim(rows(law)%name), plane_stress(k))
      end do
   end do
   call wave_speeds()
   deallocate (rows)
   call finish()

contains

   !> The table of laws tells which have a history, and which are for any strain.
   subroutine kinds_of_laws()
      type(material_t) :: m
      do law = 1, size(rows)
         m = new_material('', trim(rows(law)%name), .true., young, poisson, density)
         call check(m%has_history .eqv. rows(law)%has_history, trim(rows(law)%name)//': has a history, or none')
         call check(m%is_finite .eqv. rows(law)%is_finite, trim(rows(law)%name)//': is for any strain, or not')
      end do
   end subroutine kinds_of_laws

   !> Every law differs from the linear one by the square of the strain; those of small strains that remember nothing yet, not at
   !> all.
   subroutine small_strains(law, stress_free_across)
      character(*), intent(in) :: law
      logical, intent(in) :: stress_free_across
      real(dp) :: direction(ndim, ndim), difference(2), order
      type(material_t) :: other
      call random_number(direction)
      other = new_material('', law, stress_free_across, young, poisson, density, &
                           [constant('c01', [0.1_dp*young])])
      if (other%has_history) then
         call check(difference_to_linear(law, stress_free_across, 1.0e-4_dp*direction) < 1.0e-14_dp*young, &
                    law//' begins with the linear stress')
         return
      end if
      difference = [difference_to_linear(law, stress_free_across, 1.0e-4_dp*direction), &
                    difference_to_linear(law, stress_free_across, 1.0e-5_dp*direction)]
      order = log10(difference(1)/difference(2))
      write (*, '(2a,f7.4)') law, ', difference to the linear law: order', order
      call check_close(order, 2.0_dp, 0.01_dp, law//' and linear stress agree to first order in the strain')
   end subroutine small_strains

   !> Material that has taken its eigenstrain has neither stress nor energy. With one, too, stress is the derivative of the energy, and the tangent that of the
   !> stress. At small strain every law has the stress of the linear one, also where the eigenstrain across the plane is kept from it.
   subroutine eigenstrain(law, stress_free_across)
      character(*), intent(in) :: law
      logical, intent(in) :: stress_free_across
      real(dp), parameter :: step = 1.0e-5_dp, free(4) = [0.02_dp, -0.01_dp, 0.015_dp, 0.01_dp]
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), work, stress(ndim, ndim), change(ndim, ndim)
      real(dp), allocatable :: nothing(:)
      type(material_t) :: m, linear
      m = new_material('', law, stress_free_across, young, poisson, density, &
                       [constant('c01', [0.1_dp*young])])
      call m%give_eigenstrain([free(:3), 0.0_dp])
      allocate (nothing(m%columns), source=0.0_dp)
      h = reshape([free(1), free(3), free(3), free(2)], [ndim, ndim])
      call check(maxval(abs(m%first_piola_stress(h, nothing))) < 1.0e-14_dp*young, law//': no stress in what has its eigenstrain')
      call check(abs(m%energy_density(h, nothing)) < 1.0e-14_dp*young, law//': nor energy')
      call m%give_eigenstrain(free)
      call random_number(h)
      call random_number(dh)
      h = 0.05_dp*(h - 0.5_dp)
      work = (m%energy_density(h + step*dh, nothing) - m%energy_density(h - step*dh, nothing))/(2*step)
      stress = m%first_piola_stress(h, nothing)
      call check(abs(work - sum(stress*dh)) < 1.0e-9_dp*young, law//': with an eigenstrain stress is the derivative of the energy')
      change = (m%first_piola_stress(h + step*dh, nothing) - m%first_piola_stress(h - step*dh, nothing))/(2*step)
      call check(maxval(abs(change - m%first_piola_change(h, dh, nothing))) < 1.0e-8_dp*young, &
                 law//': and the tangent that of the stress')
      call check(maxval(abs(m%stress_at_first() - m%first_piola_stress(0*h, nothing))) <= 0, &
                 law//': stress where nothing is displaced')
      linear = new_material('', 'linear_elastic', stress_free_across, young, poisson, density)
      m = new_material('', law, stress_free_across, young, poisson, density, &
                       [constant('c01', [0.1_dp*young])])
      call linear%give_eigenstrain(1.0e-5_dp*free)
      call m%give_eigenstrain(1.0e-5_dp*free)
      h = 1.0e-5_dp*h
      call check(maxval(abs(m%first_piola_stress(h, nothing) - linear%first_piola_stress(h))) < 1.0e-12_dp*young, &
                 law//': at small strain the stress of the linear law with the same eigenstrain')
      call check_close(m%energy_density(h, nothing)/linear%energy_density(h), 1.0_dp, 1.0e-5_dp, law//': and its energy')
   end subroutine eigenstrain

   !> In axisymmetric material, at the end of a step in which plastic material yields: what stretches along the axis and around it exchanges the stresses along
   !> it and around it, and stress and hoop stress are the derivatives of the energy where nothing is dissipated. With H_33 = 0 stress is that of plane strain; where
   !> none is given it is no number.
   subroutine hoops(law)
      character(*), intent(in) :: law
      real(dp), parameter :: step = 1.0e-5_dp
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), exchanged(ndim, ndim), stress(ndim, ndim), hoop, dhoop, work
      real(dp), allocatable :: nothing(:)
      type(material_t) :: m, plane
      plane = new_material('', law, .false., young, poisson, density, &
                           [constant('yield_stress', [1.0e-3_dp*young]), constant('hardening', [0.1_dp*young]), &
                            constant('kinematic_hardening', [0.05_dp*young]), constant('moduli', [0.1_dp*young]), &
                            constant('relaxation_times', [1.0_dp]), constant('c01', [0.1_dp*young])])
      m = plane
      m%is_ring = .true.
      m%is_trial = .true.
      m%time_increment = 0.7_dp
      plane%is_trial = .true.
      plane%time_increment = 0.7_dp
      allocate (nothing(m%columns), source=0.0_dp)
      call random_number(h)
      call random_number(dh)
      h = 0.05_dp*(h - 0.5_dp)
      hoop = 0.013_dp
      dhoop = 0.4_dp
      stress = m%first_piola_stress(h, nothing, 0.0_dp)
      call check(maxval(abs(stress - plane%first_piola_stress(h, nothing))) < 1.0e-13_dp*young, &
                 law//': without a hoop as in plane strain')
      if (m%linear) then                         ! others stop here where invalid numbers are trapped
         stress = m%kirchhoff_stress(h, nothing)
         call check(all(ieee_is_nan(stress)), law//': a hoop that is forgotten is noticed')
      end if
      exchanged = h
      exchanged(1, 2) = 0
      exchanged(2, 1) = 0
      stress = m%first_piola_stress(exchanged, nothing, hoop)
      work = stress(2, 2)
      exchanged(2, 2) = hoop
      call check(abs(m%hoop_stress(exchanged, nothing, h(2, 2)) - work) < 1.0e-13_dp*young, &
                 law//': stress around the axis is that along it of exchanged stretches')
      stress = m%first_piola_stress(h, nothing, hoop)
      if (.not. m%has_history) then
         work = (m%energy_density(h + step*dh, nothing, hoop + step*dhoop) &
                 - m%energy_density(h - step*dh, nothing, hoop - step*dhoop))/(2*step)
         call check(abs(work - sum(stress*dh) - m%hoop_stress(h, nothing, hoop)*dhoop) < 1.0e-9_dp*young, &
                    law//': stresses are the derivatives of the energy')
      end if
   end subroutine hoops

   !> The tangent at the end of a step is the derivative of the stresses, of the hoop stress too, by central differences, of material that has come to where the
   !> step begins by others, in which it has yielded and relaxed.
   subroutine tangent(law, plane)
      character(*), intent(in) :: law, plane
      integer, parameter :: cases = 50, steps = 3
      real(dp), parameter :: part = 1.0e-6_dp, dt = 0.7_dp
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), forth(ndim, ndim), back(ndim, ndim), hoop, dhoop, error
      real(dp), allocatable :: old_state(:)
      type(material_t) :: m
      integer :: i, k
      m = new_material('', law, plane == 'stress', young, poisson, density, &
                       [constant('yield_stress', [3.0e-3_dp*young]), constant('hardening', [0.05_dp*young]), &
                        constant('saturation', [1.0e-3_dp*young]), constant('saturation_strain', [0.01_dp]), &
                        constant('kinematic_hardening', [0.05_dp*young]), constant('moduli', [0.1_dp, 0.05_dp]*young), &
                        constant('relaxation_times', [1.0_dp, 5.0_dp]), constant('c01', [0.1_dp*young])])
      m%is_ring = plane == 'axisymmetric'
      m%is_trial = .true.
      m%time_increment = dt
      allocate (old_state(m%columns))
      error = 0
      do i = 1, cases
         old_state = 0
         do k = 1, steps
            call draw(h, hoop)
            if (k < steps) call m%update_state(h, dt, old_state, hoop)
         end do
         call draw(dh, dhoop)
         dh = part*dh
         dhoop = part*dhoop
         forth = m%first_piola_stress(h + dh, old_state, hoop + dhoop)
         back = m%first_piola_stress(h - dh, old_state, hoop - dhoop)
         error = max(error, maxval(abs((forth - back)/2 - m%first_piola_change(h, dh, old_state, hoop, dhoop))) &
                            /maxval(abs(forth - back)/2))
         if (.not. m%is_ring) cycle
         error = max(error, abs((m%hoop_stress(h + dh, old_state, hoop + dhoop) &
                                 - m%hoop_stress(h - dh, old_state, hoop - dhoop))/2 &
                                - m%hoop_change(h, dh, old_state, hoop, dhoop))/maxval(abs(forth - back)/2))
      end do
      write (*, '(4a,es9.1)') law, ', ', plane, ', tangent from differences:', error
      call check(error < 1.0e-6_dp, law//', '//plane//': the tangent is the derivative of the stress')
   end subroutine tangent

   !> A displacement gradient and a hoop at random, of some percent.
   subroutine draw(h, hoop)
      real(dp), intent(out) :: h(ndim, ndim), hoop
      call random_number(h)
      call random_number(hoop)
      h = 0.04_dp*(h - 0.5_dp)
      hoop = 0.04_dp*(hoop - 0.5_dp)
   end subroutine draw

   !> Largest difference between the stress of a law and the linear stress [Pa].
   real(dp) function difference_to_linear(law, stress_free_across, h) result(difference)
      character(*), intent(in) :: law
      logical, intent(in) :: stress_free_across
      real(dp), intent(in) :: h(ndim, ndim)
      type(material_t) :: linear, other
      real(dp), allocatable :: nothing(:)
      linear = new_material('', 'linear_elastic', stress_free_across, young, poisson, density)
      other = new_material('', law, stress_free_across, young, poisson, density, &
                           [constant('c01', [0.1_dp*young])])
      allocate (nothing(other%columns), source=0.0_dp)
      difference = maxval(abs(linear%kirchhoff_stress(h) - other%kirchhoff_stress(h, nothing)))
   end function difference_to_linear

   !> sqrt(E / (2 (1 + nu) rho)); sqrt(E / ((1 - nu**2) rho)) in plane stress, and in plane strain
   !> sqrt((1 - nu) E / ((1 + nu)(1 - 2 nu) rho)).
   subroutine wave_speeds()
      type(material_t) :: stress, strain
      integer :: law
      do law = 1, size(rows)
         stress = new_material('', trim(rows(law)%name), .true., young, poisson, density)
         strain = new_material('', trim(rows(law)%name), .false., young, poisson, density)
         call check_close(stress%shear_wave_speed()/sqrt(young/(2*(1 + poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(rows(law)%name)//': shear waves in plane stress')
         call check_close(strain%shear_wave_speed()/stress%shear_wave_speed(), 1.0_dp, 1.0e-15_dp, &
                          trim(rows(law)%name)//': are as fast in plane strain')
         call check_close(stress%dilatational_wave_speed()/sqrt(young/((1 - poisson**2)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(rows(law)%name)//': dilatational waves in plane stress')
         call check_close(strain%dilatational_wave_speed() &
                          /sqrt((1 - poisson)*young/((1 + poisson)*(1 - 2*poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(rows(law)%name)//': dilatational waves in plane strain')
      end do
      call check(strain%dilatational_wave_speed() > stress%dilatational_wave_speed(), 'plane strain is stiffer')
   end subroutine wave_speeds
end program test_material
