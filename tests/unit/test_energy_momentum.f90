!> What a particle adds to the integrals around tips and fronts, in the plane and in space: the terms are those of the formulas,
!> a field interacts with itself by twice its energy-momentum, a pressure on faces is taken off them, and a rotation of the
!> material changes nothing.
program test_energy_momentum
   use hampm_kinds, only: dp, ndim
   use hampm_energy_momentum, only: ways, frame_t, sample_t, take_sample, energy_momentum, interaction, weight_at
   use hampm_forest, only: forest_t
   use hampm_harness, only: check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies
   use hampm_tensors, only: identity
   implicit none

   real(dp), parameter :: rounding = 1e-13_dp, pressure = 0.7_dp
   real(dp), dimension(ndim, ndim) :: h, p, rotation
   real(dp) :: flux(ways, ndim), source(ways), other(ways, ndim), other_source(ways), acceleration(ndim)
   type(material_t) :: material                  ! linear, then of large strain
   type(problem_t) :: m
   type(sample_t) :: s, turned
   type(frame_t) :: frame
   integer :: k, n

   call repeat_random_numbers()
   call random_number(h)
   call random_number(acceleration)
   h = 0.1_dp*h
   do k = 1, 2
      material = new_material('', merge('linear_elastic', 'neo_hookean   ', k == 1), .false., 2.0_dp, 0.3_dp, 1.5_dp)
      call place_bodies(forest_t(0*acceleration, 1.0_dp, [(1, n=1, ndim)]), material, &
                        [rectangle_t(0*acceleration, 0*acceleration + 1, [(2, n=1, ndim)])], m)
      m%particles%total_frame = .true.
      m%particles%gradient(1, :, :) = h
      p = material%first_piola_stress(h)
      frame = frame_t()
      call take_sample(frame, material, m%particles, 1, acceleration, s)
      call energy_momentum(s, flux, source)
      other = matmul(transpose(h(:, :ways)), p) - material%energy_density(h)*identity(:ways, :)
      call check_close(maxval(abs(flux - other)), 0.0_dp, rounding*maxval(abs(p)), 'the factor of q,J is w P - W')
      call check_close(maxval(abs(source - material%density*matmul(acceleration, h(:, :ways)))), 0.0_dp, rounding, &
                       'the factor of q is div P w')
      call interaction(s, frame, material, h, p, other, other_source)
      call check_close(maxval(abs(other_source - source)), 0.0_dp, rounding, 'the other field is balanced')
      if (k == 1) call check_close(maxval(abs(other - 2*flux)), 0.0_dp, rounding*maxval(abs(p)), 'a field interacts with itself')

      frame%across = spread(identity(:, 2), 1, ndim)*spread(identity(:, 2), 2, ndim)
      frame%pressure = -p(2, 2)
      if (k == 1) then
         call take_sample(frame, material, m%particles, 1, acceleration, s)
         call check_close(s%stress(2, 2), 0.0_dp, rounding*maxval(abs(p)), 'the pressure is off the faces')
         call check_close(s%energy - material%energy_density(h), -p(2, 2)*h(2, 2), rounding*maxval(abs(p)), 'with its work')
      end if
      if (k == 1 .or. ndim > 2) cycle         ! fronts turn along themselves: no frame turns with the material in space
      rotation = identity
      rotation(:2, 1) = [cos(0.4_dp), sin(0.4_dp)]
      rotation(:2, 2) = [-sin(0.4_dp), cos(0.4_dp)]
      m%particles%gradient(1, :, :) = matmul(rotation, identity + h) - identity
      frame = frame_t(turn=rotation - identity, pressure=pressure)
      call take_sample(frame, material, m%particles, 1, matmul(rotation, acceleration), turned)
      call energy_momentum(turned, other, other_source)
      frame%turn = 0
      m%particles%gradient(1, :, :) = h
      call take_sample(frame, material, m%particles, 1, acceleration, s)
      call energy_momentum(s, flux, source)
      call check_close(maxval(abs(other - flux)), 0.0_dp, rounding*maxval(abs(p)), 'a rotation changes nothing')
      call check_close(maxval(abs(other_source - source)), 0.0_dp, rounding, 'nor that of inertia')
   end do
   call check_close(maxval(abs(weight_at([0.0_dp, 0.4_dp, 0.7_dp, 1.0_dp, 2.0_dp], 1.0_dp, 0.4_dp) &
                               - [1.0_dp, 1.0_dp, 0.5_dp, 0.0_dp, 0.0_dp])), 0.0_dp, rounding, 'a weight falls from 1 to 0')
   call finish()
end program test_energy_momentum
