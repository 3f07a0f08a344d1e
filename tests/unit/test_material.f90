!> What holds for every law: agreement at small strains, and the wave speeds.
program test_material
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_keys, only: choices, find_group, find_key, first_key, keys
   use hampm_kinds, only: dp, name_len, ndim
   use hampm_material, only: laws, material_t, new_material, remembers, is_for_any_strain
   use hampm_rules, only: with_history, for_any_strain
   implicit none

   real(dp), parameter :: young = 70.0e9_dp, poisson = 0.3_dp, density = 2700.0_dp
   logical, parameter :: plane_stress(2) = [.true., .false.]
   integer :: k, law

   call names()
   call kinds_of_laws()
   call repeat_random_numbers()
   do k = 1, 2
      do law = 2, size(laws)
         if (trim(laws(law)) == 'orthotropic') cycle   ! it is linear: test_orthotropic
         call small_strains(trim(laws(law)), plane_stress(k))
      end do
   end do
   call wave_speeds()
   call finish()

contains

   !> Scenes name the laws that there are.
   subroutine names()
      character(name_len), allocatable :: named(:)
      integer :: group
      group = find_group('material')
      call choices(keys(first_key(group) + find_key(group, 'law') - 1), named)
      call check(size(named) == size(laws), 'as many laws in the table of keys as there are')
      if (size(named) == size(laws)) call check(all(named == laws), 'laws have the names that the table of keys allows')
   end subroutine names

   !> The table of rules knows which laws have a history, and which are for any strain.
   subroutine kinds_of_laws()
      integer :: i
      do i = 1, size(laws)
         call check((index(with_history, ''''//trim(laws(i))//'''') > 0) .eqv. remembers(trim(laws(i))), &
                    trim(laws(i))//': has a history, or none, in the table of rules')
         call check((index(for_any_strain, ''''//trim(laws(i))//'''') > 0) .eqv. is_for_any_strain(trim(laws(i))), &
                    trim(laws(i))//': is for any strain, or not, in the table of rules')
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
      other = new_material('', law, stress_free_across, young, poisson, density, c01=0.1_dp*young)
      if (other%has_history()) then
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

   !> Largest difference between the stress of a law and the linear stress [Pa].
   real(dp) function difference_to_linear(law, stress_free_across, h) result(difference)
      character(*), intent(in) :: law
      logical, intent(in) :: stress_free_across
      real(dp), intent(in) :: h(ndim, ndim)
      type(material_t) :: linear, other
      real(dp), allocatable :: nothing(:)
      linear = new_material('', laws(1), stress_free_across, young, poisson, density)
      other = new_material('', law, stress_free_across, young, poisson, density, c01=0.1_dp*young)
      allocate (nothing(other%columns), source=0.0_dp)
      difference = maxval(abs(linear%kirchhoff_stress(h) - other%kirchhoff_stress(h, nothing)))
   end function difference_to_linear

   !> sqrt(E / (2 (1 + nu) rho)); sqrt(E / ((1 - nu**2) rho)) in plane stress, and in plane strain
   !> sqrt((1 - nu) E / ((1 + nu)(1 - 2 nu) rho)).
   subroutine wave_speeds()
      type(material_t) :: stress, strain
      integer :: law
      do law = 1, size(laws)
         stress = new_material('', laws(law), .true., young, poisson, density)
         strain = new_material('', laws(law), .false., young, poisson, density)
         call check_close(stress%shear_wave_speed()/sqrt(young/(2*(1 + poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(laws(law))//': shear waves in plane stress')
         call check_close(strain%shear_wave_speed()/stress%shear_wave_speed(), 1.0_dp, 1.0e-15_dp, &
                          trim(laws(law))//': are as fast in plane strain')
         call check_close(stress%dilatational_wave_speed()/sqrt(young/((1 - poisson**2)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(laws(law))//': dilatational waves in plane stress')
         call check_close(strain%dilatational_wave_speed() &
                          /sqrt((1 - poisson)*young/((1 + poisson)*(1 - 2*poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          trim(laws(law))//': dilatational waves in plane strain')
      end do
      call check(strain%dilatational_wave_speed() > stress%dilatational_wave_speed(), 'plane strain is stiffer')
   end subroutine wave_speeds
end program test_material
