!> Linear elasticity against closed forms.
program test_linear_elastic
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   implicit none

   real(dp), parameter :: young = 70.0e9_dp, poisson = 0.3_dp
   type(material_t) :: plane_stress, plane_strain

   call repeat_random_numbers()
   plane_stress = new_material('aluminium', 'linear_elastic', .true., young, poisson, 2700.0_dp)
   plane_strain = new_material('aluminium', 'linear_elastic', .false., young, poisson, 2700.0_dp)
   call uniaxial_stress()
   call uniaxial_strain()
   call stress_out_of_plane()
   call work_and_energy(plane_stress)
   call work_and_energy(plane_strain)
   call digits_of_small_strains()
   call small_rotation()
   call finish()

contains

   subroutine uniaxial_stress()
      real(dp), parameter :: strain = 1.0e-3_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      h = reshape([strain, 0.0_dp, 0.0_dp, -poisson*strain], [ndim, ndim])
      stress = plane_stress%kirchhoff_stress(h)
      call check_close(stress(1, 1), young*strain, 1.0e-14_dp*young*strain, 'plane stress: a bar in tension has E eps')
      call check_close(stress(2, 2), 0.0_dp, 1.0e-14_dp*young*strain, 'plane stress: and no stress across')
      call check_close(plane_stress%energy_density(h), 0.5_dp*young*strain**2, 1.0e-14_dp*young*strain**2, &
                       'plane stress: and the energy E eps**2 / 2')
      h(2, 2) = -poisson/(1 - poisson)*strain
      stress = plane_strain%kirchhoff_stress(h)
      call check_close(stress(1, 1), young/(1 - poisson**2)*strain, 1.0e-14_dp*young*strain, &
                       'plane strain: a bar in tension has E / (1 - nu**2) eps')
      call check_close(stress(2, 2), 0.0_dp, 1.0e-14_dp*young*strain, 'plane strain: and no stress across')
   end subroutine uniaxial_stress

   subroutine uniaxial_strain()
      real(dp), parameter :: strain = 1.0e-3_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      h = reshape([strain, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim])
      stress = plane_strain%kirchhoff_stress(h)
      call check_close(stress(1, 1), young*(1 - poisson)/((1 + poisson)*(1 - 2*poisson))*strain, 1.0e-13_dp*young*strain, &
                       'plane strain: the confined modulus')
      h = reshape([0.0_dp, 0.0_dp, strain, 0.0_dp], [ndim, ndim])
      stress = plane_stress%kirchhoff_stress(h)
      call check_close(stress(1, 2), young/(2*(1 + poisson))*strain, 1.0e-14_dp*young*strain, 'simple shear: mu gamma')
      call check_close(stress(2, 1), stress(1, 2), 0.0_dp, 'the stress is symmetric')
   end subroutine uniaxial_strain

   !> Plane stress is the three-dimensional law with the strain across the plane that leaves it free of stress.
   subroutine stress_out_of_plane()
      real(dp) :: h(ndim, ndim), stress(ndim, ndim), full(ndim, ndim), lambda, mu, across, error
      integer :: k
      lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
      mu = young/(2*(1 + poisson))
      error = 0
      do k = 1, 100
         call random_number(h)
         across = -lambda*(h(1, 1) + h(2, 2))/(lambda + 2*mu)
         full = mu*(h + transpose(h))
         full(1, 1) = full(1, 1) + lambda*(h(1, 1) + h(2, 2) + across)
         full(2, 2) = full(2, 2) + lambda*(h(1, 1) + h(2, 2) + across)
         stress = plane_stress%kirchhoff_stress(h)
         error = max(error, maxval(abs(stress - full)))
      end do
      call check_close(error, 0.0_dp, 1.0e-14_dp*young, 'plane stress: no stress across the plane')
   end subroutine stress_out_of_plane

   !> The energy is quadratic: central differences of any width give its derivative.
   subroutine work_and_energy(m)
      type(material_t), intent(in) :: m
      real(dp), parameter :: step = 0.1_dp
      real(dp) :: h(ndim, ndim), change(ndim, ndim), stress(ndim, ndim), error
      integer :: i, j
      error = 0
      call random_number(h)
      stress = m%first_piola_stress(h)
      do j = 1, ndim
         do i = 1, ndim
            change = 0
            change(i, j) = step
            error = max(error, abs((m%energy_density(h + change) - m%energy_density(h - change))/(2*step) - stress(i, j)))
         end do
      end do
      call check_close(error, 0.0_dp, 1.0e-14_dp*young/step, 'the stress is the derivative of the energy')
   end subroutine work_and_energy

   subroutine digits_of_small_strains()
      real(dp), parameter :: strain = 1.0e-12_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      h = reshape([strain, 0.0_dp, 0.0_dp, -poisson*strain], [ndim, ndim])
      stress = plane_stress%kirchhoff_stress(h)
      call check_close(stress(1, 1)/(young*strain), 1.0_dp, 1.0e-14_dp, 'a strain of 1e-12 keeps its digits')
   end subroutine digits_of_small_strains

   !> cos(angle) - 1 counts as strain.
   subroutine small_rotation()
      real(dp), parameter :: angle = 1.0e-3_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      h = reshape([cos(angle) - 1, sin(angle), -sin(angle), cos(angle) - 1], [ndim, ndim])
      stress = plane_stress%kirchhoff_stress(h)
      call check_close(stress(1, 1), -young/(1 - poisson)*angle**2/2, 1.0e-6_dp*young*angle**2, &
                       'a rotation counts as strain to second order')
   end subroutine small_rotation
end program test_linear_elastic
