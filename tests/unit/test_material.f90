!> What holds for every law: agreement at small strains, and the wave speeds.
program test_material
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   implicit none

   real(dp), parameter :: young = 70.0e9_dp, poisson = 0.3_dp, density = 2700.0_dp
   logical, parameter :: plane_stress(2) = [.true., .false.]
   integer :: k

   call repeat_random_numbers()
   do k = 1, 2
      call small_strains(plane_stress(k))
   end do
   call wave_speeds()
   call finish()

contains

   !> The laws differ by the square of the strain.
   subroutine small_strains(stress_free_across)
      logical, intent(in) :: stress_free_across
      real(dp) :: direction(ndim, ndim), difference(2), order
      call random_number(direction)
      difference = [law_difference(stress_free_across, 1.0e-4_dp*direction), &
                    law_difference(stress_free_across, 1.0e-5_dp*direction)]
      order = log10(difference(1)/difference(2))
      write (*, '(a,f7.4)') 'difference of the two laws: order', order
      call check_close(order, 2.0_dp, 0.01_dp, 'linear and neo-Hookean stress agree to first order in the strain')
   end subroutine small_strains

   !> Largest difference between the stresses of the two laws [Pa].
   real(dp) function law_difference(stress_free_across, h)
      logical, intent(in) :: stress_free_across
      real(dp), intent(in) :: h(ndim, ndim)
      type(material_t) :: linear, neo_hookean
      linear = new_material('', 'linear_elastic', stress_free_across, young, poisson, density)
      neo_hookean = new_material('', 'neo_hookean', stress_free_across, young, poisson, density)
      law_difference = maxval(abs(linear%kirchhoff_stress(h) - neo_hookean%kirchhoff_stress(h)))
   end function law_difference

   !> sqrt(E / (2 (1 + nu) rho)); sqrt(E / ((1 - nu**2) rho)) in plane stress, and in plane strain
   !> sqrt((1 - nu) E / ((1 + nu)(1 - 2 nu) rho)).
   subroutine wave_speeds()
      character(*), parameter :: laws(2) = [character(14) :: 'linear_elastic', 'neo_hookean']
      type(material_t) :: stress, strain
      integer :: law
      do law = 1, size(laws)
         stress = new_material('', laws(law), .true., young, poisson, density)
         strain = new_material('', laws(law), .false., young, poisson, density)
         call check_close(stress%shear_wave_speed()/sqrt(young/(2*(1 + poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          laws(law)//': shear waves in plane stress')
         call check_close(strain%shear_wave_speed()/stress%shear_wave_speed(), 1.0_dp, 1.0e-15_dp, &
                          laws(law)//': are as fast in plane strain')
         call check_close(stress%dilatational_wave_speed()/sqrt(young/((1 - poisson**2)*density)), 1.0_dp, 1.0e-15_dp, &
                          laws(law)//': dilatational waves in plane stress')
         call check_close(strain%dilatational_wave_speed() &
                          /sqrt((1 - poisson)*young/((1 + poisson)*(1 - 2*poisson)*density)), 1.0_dp, 1.0e-15_dp, &
                          laws(law)//': dilatational waves in plane strain')
      end do
      call check(strain%dilatational_wave_speed() > stress%dilatational_wave_speed(), 'plane strain is stiffer')
   end subroutine wave_speeds
end program test_material
