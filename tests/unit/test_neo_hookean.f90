!> Laws for any strain, neo-Hookean and Mooney-Rivlin: an energy, a stress that is its derivative, and no notice of rotations.
program test_neo_hookean
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_law, only: constant
   use hampm_material, only: material_t, new_material
   use hampm_tensors, only: identity, determinant
   implicit none

   real(dp), parameter :: young = 1.0_dp, poisson = 0.3_dp
   character(*), parameter :: planes(2) = [character(12) :: 'plane stress', 'plane strain']
   type(material_t) :: m
   character(*), parameter :: laws(2) = [character(13) :: 'neo_hookean', 'mooney_rivlin']
   integer :: k, law

   call repeat_random_numbers()
   do law = 1, 2
      do k = 1, 2
         m = new_material('rubber', trim(laws(law)), planes(k) == 'plane stress', young, poisson, 1.0_dp, &
                          [constant('c01', [0.1_dp])])
         call derivative_of_energy(trim(laws(law))//', '//planes(k))
         call tangent(trim(laws(law))//', '//planes(k))
         call rotations(trim(laws(law))//', '//planes(k))
         call digits_of_small_strains(trim(laws(law))//', '//planes(k))
         call turned_inside_out(trim(laws(law))//', '//planes(k))
      end do
   end do
   call limits_of_mooney_rivlin()
   call uniaxial_stress()
   call stress_out_of_plane()
   call uniaxial_strain()
   call finish()

contains

   !> A displacement gradient with stretches of some ten per cent.
   function some_gradient() result(h)
      real(dp) :: h(ndim, ndim)
      call random_number(h)
      h = 0.5_dp*(h - 0.5_dp)
   end function some_gradient

   pure function rotation(angle) result(q)
      real(dp), intent(in) :: angle
      real(dp) :: q(ndim, ndim)
      q = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [ndim, ndim])
   end function rotation

   !> Largest difference between the conjugate stress and central differences of the energy of width `step`.
   real(dp) function difference_error(h, step) result(error)
      real(dp), intent(in) :: h(ndim, ndim), step
      real(dp) :: change(ndim, ndim), stress(ndim, ndim)
      integer :: i, j
      error = 0
      stress = m%first_piola_stress(h)
      do j = 1, ndim
         do i = 1, ndim
            change = 0
            change(i, j) = step
            error = max(error, abs((m%energy_density(h + change) - m%energy_density(h - change))/(2*step) - stress(i, j)))
         end do
      end do
   end function difference_error

   !> The tangent is the derivative of the stress, and symmetric, as the second derivative of an energy is.
   subroutine tangent(plane)
      character(*), intent(in) :: plane
      real(dp), parameter :: step = 1e-5_dp
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), other(ndim, ndim), difference(ndim, ndim)
      integer :: i
      do i = 1, 10
         h = some_gradient()
         dh = some_gradient()
         other = some_gradient()
         difference = (m%first_piola_stress(h + step*dh) - m%first_piola_stress(h - step*dh))/(2*step)
         call check_close(norm2(m%first_piola_change(h, dh) - difference), 0.0_dp, 1e-8_dp, &
                          plane//': the tangent is the derivative of the stress')
         call check_close(sum(m%first_piola_change(h, dh)*other), sum(m%first_piola_change(h, other)*dh), 1e-14_dp, &
                          plane//': the tangent is symmetric')
      end do
   end subroutine tangent

   subroutine derivative_of_energy(plane)
      character(*), intent(in) :: plane
      real(dp) :: h(ndim, ndim), error(2), order, tau(ndim, ndim), piola(ndim, ndim)
      h = some_gradient()
      error = [difference_error(h, 2.0e-3_dp), difference_error(h, 1.0e-3_dp)]
      order = log(error(1)/error(2))/log(2.0_dp)
      write (*, '(2a,f7.4)') plane, ': differences of the energy against the stress: order', order
      call check_close(order, 2.0_dp, 0.01_dp, plane//': the stress is the derivative of the energy')
      tau = m%kirchhoff_stress(h)
      piola = m%first_piola_stress(h)
      call check_close(maxval(abs(matmul(piola, transpose(identity + h)) - tau)), 0.0_dp, 1.0e-15_dp, &
                       plane//': Kirchhoff stress = first Piola stress F^T')
      call check_close(tau(1, 2), tau(2, 1), 1.0e-16_dp, plane//': the Kirchhoff stress is symmetric')
   end subroutine derivative_of_energy

   subroutine rotations(plane)
      character(*), intent(in) :: plane
      real(dp) :: h(ndim, ndim), turned(ndim, ndim), q(ndim, ndim), stress(ndim, ndim), expected(ndim, ndim)
      q = rotation(2.0_dp)
      stress = m%kirchhoff_stress(q - identity)
      call check_close(maxval(abs(stress)), 0.0_dp, 1.0e-15_dp, plane//': a rotation causes no stress')
      call check_close(m%energy_density(q - identity), 0.0_dp, 1.0e-15_dp, plane//': nor energy')
      h = some_gradient()
      turned = matmul(q, identity + h) - identity
      stress = m%kirchhoff_stress(turned)
      expected = matmul(q, matmul(m%kirchhoff_stress(h), transpose(q)))
      call check_close(maxval(abs(stress - expected)), 0.0_dp, 2.0e-15_dp, plane//': the stress turns with the material')
      call check_close(m%energy_density(turned), m%energy_density(h), 1.0e-15_dp, plane//': the energy does not change')
   end subroutine rotations

   !> At 1e-12 the law is linear to 12 digits.
   subroutine digits_of_small_strains(plane)
      character(*), intent(in) :: plane
      type(material_t) :: linear
      real(dp) :: h(ndim, ndim), stress(ndim, ndim), expected(ndim, ndim)
      linear = new_material('', 'linear_elastic', m%plane_stress, young, poisson, 1.0_dp)
      h = 1.0e-12_dp*some_gradient()
      stress = m%kirchhoff_stress(h)
      expected = linear%kirchhoff_stress(h)
      call check_close(maxval(abs(stress - expected))/maxval(abs(expected)), 0.0_dp, 1.0e-11_dp, &
                       plane//': the stress of a strain of 1e-12 keeps its digits')
      h = 1.0e-18_dp*some_gradient()
      call check_close(m%energy_density(h)/linear%energy_density(h), 1.0_dp, 1.0e-13_dp, &
                       plane//': the energy of a strain of 1e-18 keeps its digits')
      h = 1.0e-6_dp*some_gradient()
      call check_close(m%energy_density(h)/linear%energy_density(h), 1.0_dp, 1.0e-5_dp, &
                       plane//': the energy of a strain of 1e-6 is that of the linear law but for the third power')
   end subroutine digits_of_small_strains

   subroutine turned_inside_out(plane)
      character(*), intent(in) :: plane
      real(dp) :: h(ndim, ndim)
      h = reshape([-2.0_dp, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim])
      call check_close(maxval(abs(m%kirchhoff_stress(h))), 0.0_dp, 0.0_dp, plane//': material turned inside out has no stress')
      call check_close(maxval(abs(m%first_piola_stress(h))), 0.0_dp, 0.0_dp, plane//': neither conjugate stress')
      call check_close(m%energy_density(h), 0.0_dp, 0.0_dp, plane//': nor energy')
   end subroutine turned_inside_out

   !> In a bar in tension the stretches across are equal, t, and mu (t**2 - 1) + lambda ln(s t**2) = 0 gives the stretch
   !> s along it; its stress is then mu (s**2 - t**2).
   subroutine uniaxial_stress()
      real(dp), parameter :: t = 0.95_dp
      real(dp) :: s, mu, lambda, h(ndim, ndim), stress(ndim, ndim)
      m = new_material('rubber', 'neo_hookean', .true., young, poisson, 1.0_dp)
      mu = young/(2*(1 + poisson))
      lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
      s = exp(-mu*(t**2 - 1)/lambda)/t**2
      h = reshape([s - 1, 0.0_dp, 0.0_dp, t - 1], [ndim, ndim])
      stress = m%kirchhoff_stress(h)
      call check_close(stress(1, 1), mu*(s**2 - t**2), 1.0e-14_dp, 'plane stress: the closed form of a bar in tension')
      call check_close(stress(2, 2), 0.0_dp, 1.0e-14_dp, 'plane stress: no stress across the bar')
   end subroutine uniaxial_stress

   !> Without its second modulus the law of Mooney and Rivlin is the neo-Hookean one. In a bar of next to no change of volume it has the closed form of one of
   !> none, (lambda**2 - 1/lambda) (2 c10 + 2 c01/lambda), within 1.5 times the part 3 (1 - 2 nu) that its volume may change by.
   subroutine limits_of_mooney_rivlin()
      real(dp), parameter :: nu = 0.49999_dp, c01 = 0.1_dp, stretch = 1.6_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim), c10, expected
      type(material_t) :: other
      integer :: i
      do k = 1, 2
         m = new_material('rubber', 'mooney_rivlin', planes(k) == 'plane stress', young, poisson, 1.0_dp, &
                          [constant('c01', [0.0_dp])])
         other = new_material('rubber', 'neo_hookean', planes(k) == 'plane stress', young, poisson, 1.0_dp)
         h = some_gradient()
         call check_close(maxval(abs(m%kirchhoff_stress(h) - other%kirchhoff_stress(h))), 0.0_dp, 2.0e-15_dp, &
                          trim(planes(k))//': without a second modulus it is the neo-Hookean law')
      end do
      m = new_material('rubber', 'mooney_rivlin', .true., young, nu, 1.0_dp, &
                       [constant('c01', [c01])])
      h = 0
      h(1, 1) = stretch - 1
      h(2, 2) = 1/sqrt(stretch) - 1
      do i = 1, 30
         stress = m%first_piola_stress(h)
         expected = dot_product([0.0_dp, 1.0_dp], matmul(m%first_piola_change(h, reshape([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], &
                                                                                         [ndim, ndim])), [0.0_dp, 1.0_dp]))
         h(2, 2) = h(2, 2) - stress(2, 2)/expected
      end do
      stress = m%kirchhoff_stress(h)
      c10 = young/(4*(1 + nu)) - c01
      expected = (stretch**2 - 1/stretch)*2*(c10 + c01/stretch)
      write (*, '(a,es9.1)') 'mooney_rivlin, a bar of next to no change of volume: ', stress(1, 1)/expected - 1
      call check_close(stress(1, 1)/expected, 1.0_dp, 4.5_dp*(1 - 2*nu), 'mooney_rivlin: the closed form of a bar in tension')
   end subroutine limits_of_mooney_rivlin

   !> From the trace of the stress, mu (tr b - 2) + 2 lambda ln J, follows ln J, and from that the stress across.
   subroutine stress_out_of_plane()
      real(dp) :: h(ndim, ndim), f(ndim, ndim), stress(ndim, ndim), log_j, across, error
      integer :: n
      error = 0
      do n = 1, 100
         h = some_gradient()
         f = identity + h
         stress = m%kirchhoff_stress(h)
         log_j = (stress(1, 1) + stress(2, 2) - m%mu*(sum(f**2) - 2))/(2*m%lambda)
         across = m%mu*((exp(log_j)/determinant(f))**2 - 1) + m%lambda*log_j
         error = max(error, abs(across))
      end do
      call check_close(error, 0.0_dp, 2.0e-14_dp, 'plane stress: no stress across the plane')
   end subroutine stress_out_of_plane

   subroutine uniaxial_strain()
      real(dp), parameter :: s = 1.3_dp
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      m = new_material('rubber', 'neo_hookean', .false., young, poisson, 1.0_dp)
      h = reshape([s - 1, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim])
      stress = m%kirchhoff_stress(h)
      call check_close(stress(1, 1), m%mu*(s**2 - 1) + m%lambda*log(s), 1.0e-14_dp, 'plane strain: uniaxial strain along')
      call check_close(stress(2, 2), m%lambda*log(s), 1.0e-14_dp, 'plane strain: uniaxial strain across')
      call check_close(m%energy_density(h), 0.5_dp*m%mu*(s**2 - 1 - 2*log(s)) + 0.5_dp*m%lambda*log(s)**2, 1.0e-14_dp, &
                       'plane strain: the energy of uniaxial strain')
   end subroutine uniaxial_strain
end program test_neo_hookean
