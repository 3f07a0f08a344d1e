!> Plasticity: closed forms of uniaxial stress, shear and hardening, work on the plastic strain, and a tangent that is the
!> derivative of the stress, with which Newton's iteration converges quadratically.
program test_j2_plastic
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_kinds, only: dp, ndim
   use hampm_law, only: constant
   use hampm_material, only: material_t, new_material
   implicit none

   real(dp), parameter :: young = 200.0e9_dp, poisson = 0.3_dp, yield = 400.0e6_dp, hardening = 10.0e9_dp, &
                          saturation = 100.0e6_dp, saturation_strain = 0.002_dp, kinematic = 20.0e9_dp
   integer, parameter :: columns = 4
   character(*), parameter :: planes(2) = [character(12) :: 'plane stress', 'plane strain']
   type(material_t) :: m
   integer :: k

   call repeat_random_numbers()
   do k = 1, 2
      m = new_material('steel', 'j2_plastic', planes(k) == 'plane stress', young, poisson, 7800.0_dp, &
                       [constant('yield_stress', [yield]), constant('hardening', [hardening])])
      m%is_trial = .true.
      call stays_on_the_yield_surface(trim(planes(k)))
      call tangent(trim(planes(k)))
      call quadratic_convergence(trim(planes(k)))
      call shear(trim(planes(k)))
      call work_is_stored_or_dissipated(trim(planes(k)))
      m = new_material('steel', 'j2_plastic', planes(k) == 'plane stress', young, poisson, 7800.0_dp, &
                       [constant('yield_stress', [yield]), constant('hardening', [hardening]), &
                        constant('saturation', [saturation]), constant('saturation_strain', [saturation_strain]), &
                        constant('kinematic_hardening', [kinematic])])
      m%is_trial = .true.
      call tangent(trim(planes(k))//', all hardening')
      call quadratic_convergence(trim(planes(k))//', all hardening')
      call work_is_stored_or_dissipated(trim(planes(k))//', all hardening')
   end do
   call uniaxial_stress()
   call no_stress_across()
   call all_kinds_of_hardening()
   call finish()

contains

   !> Strains of a few times that of yielding.
   function some_gradient() result(h)
      real(dp) :: h(ndim, ndim)
      call random_number(h)
      h = 0.02_dp*(h - 0.5_dp)
   end function some_gradient

   !> Von Mises' equivalent of a stress with its normal component across the plane [Pa].
   real(dp) function mises(h, old_state) result(equivalent)
      real(dp), intent(in) :: h(ndim, ndim), old_state(columns)
      real(dp) :: s(ndim, ndim), across
      s = m%kirchhoff_stress(h, old_state)
      across = 0
      ! plane strain: the pressure is elastic, so that the stress across follows from it
      if (.not. m%plane_stress) across = young/(1 - 2*poisson)*(h(1, 1) + h(2, 2)) - s(1, 1) - s(2, 2)
      equivalent = sqrt(((s(1, 1) - s(2, 2))**2 + (s(2, 2) - across)**2 + (across - s(1, 1))**2)/2 + 3*s(1, 2)**2)
   end function mises

   !> A step to any strain ends within the yield surface, on it where the material flows; a state that is kept is the same state.
   subroutine stays_on_the_yield_surface(plane)
      character(*), intent(in) :: plane
      real(dp) :: h(ndim, ndim), old_state(columns), stress(ndim, ndim), alpha
      integer :: i, flowed
      old_state = 0
      flowed = 0
      do i = 1, 50
         h = some_gradient()
         stress = m%kirchhoff_stress(h, old_state)
         alpha = old_state(4)
         call m%update_state(h, 0.0_dp, old_state)
         call check(maxval(abs(m%kirchhoff_stress(h, old_state) - stress)) < 1.0e-12_dp*young, plane// &
                    ': a kept state has its stress')
         if (old_state(4) > alpha) then
            flowed = flowed + 1
            call check_close(mises(h, old_state)/(yield + hardening*old_state(4)), 1.0_dp, 1.0e-11_dp, plane// &
                             ': flow ends on the surface')
         else
            call check(mises(h, old_state) <= (yield + hardening*old_state(4))*(1 + 1.0e-12_dp), plane// &
                       ': elastic steps end within it')
         end if
      end do
      call check(flowed > 10 .and. flowed < 50, plane//': both kinds of steps were taken')
   end subroutine stays_on_the_yield_surface

   !> Steps in plane stress from any state: no stress is left across the plane, so that a kept state has the same stress and energy. (Tangents
   !> of a law that yields may lead Newton's iteration to H_33 round in circles.)
   subroutine no_stress_across()
      integer, parameter :: steps = 3000
      real(dp) :: h(ndim, ndim), old_state(columns), stress(ndim, ndim), energy, error
      integer :: i
      m = new_material('steel', 'j2_plastic', .true., young, 0.0_dp, 7800.0_dp, &
                       [constant('yield_stress', [yield]), constant('hardening', [hardening])])
      m%is_trial = .true.
      error = 0
      do i = 1, steps
         old_state = some_past()
         h = some_gradient()
         stress = m%kirchhoff_stress(h, old_state)
         energy = m%energy_density(h, old_state) + m%dissipation(h, old_state)
         call m%update_state(h, 0.0_dp, old_state)
         error = max(error, maxval(abs(m%kirchhoff_stress(h, old_state) - stress))/yield, &
                     abs(m%energy_density(h, old_state) + m%dissipation(h, old_state) - energy)/energy)
      end do
      write (*, '(a,es9.1)') 'plane stress without Poisson''s effect, kept states differ by', error
      call check(error < 1.0e-9_dp, 'plane stress: a state has one strain across the plane')
   end subroutine no_stress_across

   !> A state with plastic strain.
   function some_past() result(old_state)
      real(dp) :: old_state(columns)
      old_state = 0
      call m%update_state(some_gradient(), 0.0_dp, old_state)
   end function some_past

   !> The tangent is the derivative of the stress, by central differences, and symmetric.
   subroutine tangent(plane)
      character(*), intent(in) :: plane
      real(dp), parameter :: step = 1.0e-7_dp
      real(dp) :: h(ndim, ndim), old_state(columns), dh(ndim, ndim), other(ndim, ndim), change(ndim, ndim), &
                  difference(ndim, ndim), error
      integer :: i
      error = 0
      do i = 1, 20
         old_state = some_past()
         h = some_gradient()
         call random_number(dh)
         call random_number(other)
         change = m%first_piola_change(h, dh, old_state)
         difference = (m%first_piola_stress(h + step*dh, old_state) - m%first_piola_stress(h - step*dh, old_state))/(2*step)
         error = max(error, maxval(abs(change - difference))/young)
         call check_close(sum(change*other)/sum(m%first_piola_change(h, other, old_state)*dh), 1.0_dp, 1.0e-9_dp, &
                          plane//': the tangent is symmetric')
      end do
      write (*, '(2a,es9.1)') plane, ', tangent from differences, over E:', error
      call check(error < 1.0e-6_dp, plane//': the tangent is the derivative of the stress')
   end subroutine tangent

   !> Newton's iteration to the strain that has a given stress: each error is the square of the one before.
   subroutine quadratic_convergence(plane)
      character(*), intent(in) :: plane
      real(dp) :: old_state(columns), goal(3), h(ndim, ndim), r(3), errors(12), matrix(3, 3)
      integer :: i, n
      old_state = 0
      goal = voigt(m%kirchhoff_stress(reshape([0.006_dp, 0.002_dp, 0.002_dp, -0.001_dp], [ndim, ndim]), old_state))
      h = 0
      n = 0
      do i = 1, size(errors)
         r = goal - voigt(m%kirchhoff_stress(h, old_state))
         errors(i) = norm2(r)/norm2(goal)
         if (errors(i) < 1.0e-13_dp) exit
         n = i
         matrix(:, 1) = voigt(m%first_piola_change(h, reshape([1.0_dp, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim]), old_state))
         matrix(:, 2) = voigt(m%first_piola_change(h, reshape([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [ndim, ndim]), old_state))
         matrix(:, 3) = voigt(m%first_piola_change(h, reshape([0.0_dp, 0.5_dp, 0.5_dp, 0.0_dp], [ndim, ndim]), old_state))
         r = solution(matrix, r)
         h = h + reshape([r(1), r(3)/2, r(3)/2, r(2)], [ndim, ndim])
      end do
      write (*, '(2a,12es9.1)') plane, ', residuals of Newton''s iteration:', errors(:n)
      call check(n < size(errors), plane//': Newton''s iteration converges')
      call check(errors(n) < 10*errors(n - 1)**2 .or. errors(n) < 1.0e-10_dp, plane//': quadratically')
   end subroutine quadratic_convergence

   !> 11, 22 and 12 of a symmetric tensor.
   pure function voigt(s)
      real(dp), intent(in) :: s(ndim, ndim)
      real(dp) :: voigt(3)
      voigt = [s(1, 1), s(2, 2), s(1, 2)]
   end function voigt

   !> Solution of three equations, by Cramer's rule.
   pure function solution(a, b) result(x)
      real(dp), intent(in) :: a(3, 3), b(3)
      real(dp) :: x(3), replaced(3, 3)
      integer :: i
      do i = 1, 3
         replaced = a
         replaced(:, i) = b
         x(i) = determinant(replaced)/determinant(a)
      end do
   end function solution

   pure real(dp) function determinant(a)
      real(dp), intent(in) :: a(3, 3)
      determinant = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
                    + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
   end function determinant

   !> In shear the stress rises with mu to yield/sqrt(3), and from there with mu h/(3 mu + h).
   subroutine shear(plane)
      character(*), intent(in) :: plane
      real(dp) :: old_state(columns), h(ndim, ndim), stress(ndim, ndim), expected, angle, at_yield
      h = 0
      angle = 0.013_dp
      h(1, 2) = angle
      old_state = 0
      stress = m%kirchhoff_stress(h, old_state)
      at_yield = yield/(sqrt(3.0_dp)*m%mu)
      expected = m%mu*at_yield + m%mu*hardening/(3*m%mu + hardening)*(angle - at_yield)
      call check_close(stress(1, 2)/expected, 1.0_dp, 1.0e-12_dp, plane//': shear with hardening')
      call check_close(abs(stress(1, 1)) + abs(stress(2, 2)), 0.0_dp, 1.0e-3_dp, plane//': has no normal stress')
   end subroutine shear

   !> Along a way through strains, in n steps: the work of the stress is stored or dissipated but for what the rule of trapezoids
   !> misses, of the second order.
   subroutine work_is_stored_or_dissipated(plane)
      character(*), intent(in) :: plane
      real(dp) :: missing(3)
      integer :: i
      missing = [(missing_work(100*4**i), i=1, 3)]
      write (*, '(2a,3es10.2)') plane, ', work that is neither stored nor dissipated:', missing
      call check(abs(missing(2)) < 1.0e-3_dp .and. abs(missing(3)) < abs(missing(1))/16**1.5_dp, &
                 plane//': work is stored or dissipated')
   end subroutine work_is_stored_or_dissipated

   !> Work that is missing, over all of it.
   real(dp) function missing_work(n)
      integer, intent(in) :: n
      real(dp) :: old_state(columns), h(ndim, ndim), next(ndim, ndim), stress(ndim, ndim), work, t
      integer :: i
      old_state = 0
      h = 0
      work = 0
      do i = 1, n
         t = 3*real(i, dp)/n
         next = 0.01_dp*reshape([sin(t), 0.3_dp*t*(2 - t), 0.1_dp*t, 1 - cos(2*t)], [ndim, ndim])
         stress = m%kirchhoff_stress(h, old_state)
         call m%update_state(next, 0.0_dp, old_state)
         work = work + sum((stress + m%kirchhoff_stress(next, old_state))*(next - h))/2
         h = next
      end do
      missing_work = (work - m%energy_density(h, old_state) - m%dissipation(h, old_state))/work
   end function missing_work

   !> Uniaxial tension in plane stress, to a strain and back into compression: bilinear.
   subroutine uniaxial_stress()
      real(dp) :: old_state(columns), h(ndim, ndim), stress(ndim, ndim), slope, alpha, expected
      m = new_material('steel', 'j2_plastic', .true., young, poisson, 7800.0_dp, &
                       [constant('yield_stress', [yield]), constant('hardening', [hardening])])
      m%is_trial = .true.
      slope = young*hardening/(young + hardening)
      old_state = 0
      call stretch(0.01_dp, old_state, h, stress)
      expected = yield + slope*(0.01_dp - yield/young)
      call check_close(stress(1, 1)/expected, 1.0_dp, 1.0e-10_dp, 'tension with hardening')
      call m%update_state(h, 0.0_dp, old_state)
      alpha = 0.01_dp - expected/young
      call check_close(old_state(4)/alpha, 1.0_dp, 1.0e-10_dp, 'equivalent plastic strain of tension')
      call check_close(m%dissipation(h, old_state)/(yield*alpha + hardening*alpha**2/2), 1.0_dp, 1.0e-9_dp, &
                       'work on the plastic strain of tension')
      call stretch(-0.005_dp, old_state, h, stress)
      ! elastic from +expected to -expected, as hardening is isotropic, and from there with the slope
      expected = -expected + slope*(-0.005_dp - (0.01_dp - 2*expected/young))
      call check_close(stress(1, 1)/expected, 1.0_dp, 1.0e-10_dp, 'compression after tension')
   end subroutine uniaxial_stress

   !> Uniaxial tension in plane stress and back: stress = Y(alpha) + kinematic eps_p going there, and kinematic eps_p - Y(alpha) coming back.
   subroutine all_kinds_of_hardening()
      real(dp) :: old_state(columns), h(ndim, ndim), stress(ndim, ndim), plastic, alpha
      m = new_material('steel', 'j2_plastic', .true., young, poisson, 7800.0_dp, &
                       [constant('yield_stress', [yield]), constant('hardening', [hardening]), &
                        constant('saturation', [saturation]), constant('saturation_strain', [saturation_strain]), &
                        constant('kinematic_hardening', [kinematic])])
      m%is_trial = .true.
      old_state = 0
      call stretch(0.01_dp, old_state, h, stress)
      call m%update_state(h, 0.0_dp, old_state)
      alpha = old_state(4)
      plastic = 0.01_dp - stress(1, 1)/young
      call check_close(plastic/alpha, 1.0_dp, 1.0e-10_dp, 'all hardening: equivalent plastic strain of tension')
      call check_close(stress(1, 1)/(radius(alpha) + kinematic*plastic), 1.0_dp, 1.0e-10_dp, 'all hardening: tension')
      call check_close(m%dissipation(h, old_state)/(yield*alpha + hardening*alpha**2/2 + saturation*(alpha - saturation_strain &
                                                            *(1 - exp(-alpha/saturation_strain)))), 1.0_dp, 1.0e-9_dp, &
                       'all hardening: work on the plastic strain')
      call stretch(-0.005_dp, old_state, h, stress)
      call m%update_state(h, 0.0_dp, old_state)
      plastic = -0.005_dp - stress(1, 1)/young
      call check_close(stress(1, 1)/(kinematic*plastic - radius(old_state(4))), 1.0_dp, 1.0e-10_dp, &
                       'all hardening: compression after it')
      call check(old_state(4) > alpha, 'all hardening: it flows again')
   end subroutine all_kinds_of_hardening

   !> Y [Pa].
   pure real(dp) function radius(alpha)
      real(dp), intent(in) :: alpha
      radius = yield + hardening*alpha + saturation*(1 - exp(-alpha/saturation_strain))
   end function radius

   !> Stretch in one direction by a strain without stress in the other.
   subroutine stretch(strain, old_state, h, stress)
      real(dp), intent(in) :: strain, old_state(columns)
      real(dp), intent(out) :: h(ndim, ndim), stress(ndim, ndim)
      real(dp) :: change(ndim, ndim)
      integer :: i
      h = 0
      h(1, 1) = strain
      do i = 1, 30
         stress = m%kirchhoff_stress(h, old_state)
         change = m%first_piola_change(h, reshape([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [ndim, ndim]), old_state)
         h(2, 2) = h(2, 2) - stress(2, 2)/change(2, 2)
      end do
   end subroutine stretch
end program test_j2_plastic
