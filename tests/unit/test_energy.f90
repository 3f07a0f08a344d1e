!> Energies and extremes of simple states.
program test_energy
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: kinetic_energy, strain_energy, linear_momentum, largest_gradient, most_crushed_particle, &
                           determinant_of
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, thickness
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: young = 200.0_dp, poisson = 0.25_dp, density = 3.0_dp, strain = 1.0e-3_dp
   real(dp), parameter :: volume = 2*1*thickness, mass = density*volume
   type(problem_t) :: m
   real(dp) :: alone(2), together(2)
   integer :: i

   call repeat_random_numbers()
   ! More than one block of the sums
   call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [3, 2]), &
                     new_material('', 'linear_elastic', .true., young, poisson, density), &
                     [rectangle_t([0.1_dp, 0.1_dp], [2.1_dp, 1.1_dp], [120, 60], [3.0_dp, -4.0_dp])], m)
   associate (p => m%particles)
      call check_close(kinetic_energy(p), 0.5_dp*mass*25, 1.0e-12_dp*mass*25, 'kinetic energy = M v**2 / 2')
      call check_close(maxval(abs(linear_momentum(p) - mass*[3, -4])), 0.0_dp, 1.0e-12_dp*mass, 'momentum = M v')
      call check_close(strain_energy(p, m%materials), 0.0_dp, 0.0_dp, 'no strain, no strain energy')
      do i = 1, p%n
         p%gradient(i, :, :) = reshape([strain, 0.0_dp, 0.0_dp, -poisson*strain], [ndim, ndim])
      end do
      call check_close(strain_energy(p, m%materials)/(0.5_dp*volume*young*strain**2), 1.0_dp, 1.0e-12_dp, &
                       'strain energy of a bar in tension = V E eps**2 / 2')
      call check_close(largest_gradient(p, m%materials), strain, 0.0_dp, 'the largest displacement gradient')
      call check(most_crushed_particle(p, m%materials) == 0, 'the linear law has no determinant to watch')

      call random_number(p%velocity)
      alone = [kinetic_energy(p), strain_energy(p, m%materials)]
      call use_threads(3, p%n)
      together = [kinetic_energy(p), strain_energy(p, m%materials)]
      call check(all(transfer(alone, [0]) == transfer(together, [0])), 'the sums do not depend on the number of threads')

      m%materials(1) = new_material('', 'neo_hookean', .true., young, poisson, density)
      call check_close(largest_gradient(p, m%materials), 0.0_dp, 0.0_dp, 'the neo-Hookean law has no largest gradient')
      p%gradient(33, :, :) = reshape([-0.5_dp, 0.1_dp, 0.2_dp, 0.0_dp], [ndim, ndim])
      call check(most_crushed_particle(p, m%materials) == 33, 'the smallest determinant of F is found')
      call check_close(determinant_of(p, 33), 0.48_dp, 1.0e-15_dp, 'the determinant of F')
      p%gradient(77, :, :) = reshape([0.0_dp, 0.0_dp, 0.0_dp, -1.5_dp], [ndim, ndim])
      call check(most_crushed_particle(p, m%materials) == 77, 'one inverted particle is seen')
   end associate
   call finish()
end program test_energy
