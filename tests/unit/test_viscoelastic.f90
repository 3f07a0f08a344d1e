!> Viscoelasticity: steps that are exact for constant rates, relaxation and creep by closed forms, a tangent that is the
!> derivative of the stress, and energy that is stored or dissipated.
program test_viscoelastic
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_kinds, only: dp, ndim
   use hampm_law, only: constant
   use hampm_material, only: material_t, new_material
   implicit none

   real(dp), parameter :: young = 3.0e9_dp, poisson = 0.35_dp, moduli(2) = [0.6e9_dp, 0.2e9_dp], times(2) = [0.1_dp, 7.0_dp]
   character(*), parameter :: planes(2) = [character(12) :: 'plane stress', 'plane strain']
   integer :: k

   call repeat_random_numbers()
   do k = 1, 2
      call constant_rate(planes(k) == 'plane stress', trim(planes(k)))
      call tangent(planes(k) == 'plane stress', trim(planes(k)))
      call energy(planes(k) == 'plane stress', trim(planes(k)))
   end do
   call relaxation()
   call uniaxial_creep()
   call finish()

contains

   !> A polymer.
   type(material_t) function polymer(plane_stress) result(m)
      logical, intent(in) :: plane_stress
      m = new_material('polymer', 'viscoelastic', plane_stress, young, poisson, 1200.0_dp, &
                       [constant('moduli', moduli), constant('relaxation_times', times)])
      m%is_trial = .true.
   end function polymer

   !> One step of a constant rate from a state is many; in plane stress the strain across does not go at a constant rate, and many
   !> steps tend to one as their length squared.
   subroutine constant_rate(plane_stress, plane)
      logical, intent(in) :: plane_stress
      character(*), intent(in) :: plane
      type(material_t) :: m
      real(dp) :: differences(3), one(ndim, ndim), dissipated(2)
      integer :: i
      m = polymer(plane_stress)
      call drive(m, 1000, one, dissipated(1))
      do i = 1, 3
         differences(i) = difference(m, 2**(i - 1), one)
      end do
      write (*, '(2a,3es10.2)') plane, ', differences by steps of a constant rate:', differences
      if (plane_stress) then
         call check(differences(3) < differences(1)/14, plane//': of the second order')
      else
         call check(maxval(differences) < 1.0e-12_dp, plane//': one step is exact')
         call drive(m, 1, one, dissipated(2))
         call check_close(dissipated(2)/dissipated(1), 1.0_dp, 1.0e-11_dp, plane//': and so is what the dashpots take')
      end if
   end subroutine constant_rate

   !> Difference of the stress after n steps from one, over Young's modulus times the strain.
   real(dp) function difference(m, n, one)
      type(material_t), intent(inout) :: m
      integer, intent(in) :: n
      real(dp), intent(in) :: one(ndim, ndim)
      real(dp) :: stress(ndim, ndim), dissipated
      call drive(m, n, stress, dissipated)
      difference = maxval(abs(stress - one))/(0.01_dp*young)
   end function difference

   !> Strain suddenly, wait, and strain on at a constant rate by n steps in half a second.
   subroutine drive(m, n, stress, dissipated)
      type(material_t), intent(inout) :: m
      integer, intent(in) :: n
      real(dp), intent(out) :: stress(ndim, ndim), dissipated
      real(dp) :: old_state(m%columns), h(ndim, ndim), rate(ndim, ndim)
      integer :: i
      old_state = 0
      h = 0.01_dp*reshape([1.0_dp, 0.3_dp, 0.1_dp, -0.4_dp], [ndim, ndim])
      rate = 0.02_dp*reshape([-0.5_dp, 1.0_dp, 0.0_dp, 0.7_dp], [ndim, ndim])
      call m%update_state(h, 0.0_dp, old_state)
      call m%update_state(h, 0.03_dp, old_state)
      m%time_increment = 0.5_dp/n
      do i = 1, n
         stress = m%kirchhoff_stress(h + 0.5_dp*i/n*rate, old_state)
         call m%update_state(h + 0.5_dp*i/n*rate, m%time_increment, old_state)
      end do
      m%time_increment = 0
      dissipated = m%dissipation(h + 0.5_dp*rate, old_state)
   end subroutine drive

   !> The tangent is the derivative of the stress at the end of a step.
   subroutine tangent(plane_stress, plane)
      logical, intent(in) :: plane_stress
      character(*), intent(in) :: plane
      type(material_t) :: m
      real(dp), allocatable :: old_state(:)
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), difference(ndim, ndim)
      m = polymer(plane_stress)
      allocate (old_state(m%columns), source=0.0_dp)
      call random_number(h)
      call random_number(dh)
      call m%update_state(h, 0.2_dp, old_state)
      m%time_increment = 0.4_dp
      difference = (m%kirchhoff_stress(2*h + dh, old_state) - m%kirchhoff_stress(2*h - dh, old_state))/2
      call check(maxval(abs(difference - m%first_piola_change(h, dh, old_state))) < 1.0e-13_dp*young, plane//': tangent')
   end subroutine tangent

   !> Work of the stress by the rule of trapezoids is stored or dissipated, to the second order of the steps.
   subroutine energy(plane_stress, plane)
      logical, intent(in) :: plane_stress
      character(*), intent(in) :: plane
      real(dp) :: missing(2)
      missing = [missing_work(polymer(plane_stress), 50), missing_work(polymer(plane_stress), 200)]
      write (*, '(2a,2es10.2)') plane, ', work that is neither stored nor dissipated:', missing
      call check_close(log(missing(1)/missing(2))/log(4.0_dp), 2.0_dp, 0.1_dp, plane//': of the second order')
      call check(abs(missing(2)) < 1.0e-4_dp, plane//': work is stored or dissipated')
   end subroutine energy

   !> Work that is missing after two seconds, over all of it.
   real(dp) function missing_work(m, n)
      type(material_t), intent(in) :: m
      integer, intent(in) :: n
      real(dp), allocatable :: old_state(:)
      real(dp) :: h(ndim, ndim), next(ndim, ndim), stress(ndim, ndim), work, t
      integer :: i
      allocate (old_state(m%columns), source=0.0_dp)
      h = 0
      work = 0
      do i = 1, n
         t = 2*real(i, dp)/n
         next = 0.01_dp*reshape([sin(t), 0.3_dp*t*(2 - t), 0.1_dp*t, 1 - cos(2*t)], [ndim, ndim])
         stress = m%kirchhoff_stress(h, old_state)
         call m%update_state(next, 2.0_dp/n, old_state)
         work = work + sum((stress + m%kirchhoff_stress(next, old_state))*(next - h))/2
         h = next
      end do
      missing_work = (work - m%energy_density(h, old_state) - m%dissipation(h, old_state))/work
   end function missing_work

   !> A sudden shear relaxes by the series, and what is no longer stored has been dissipated.
   subroutine relaxation()
      type(material_t) :: m
      real(dp) :: h(ndim, ndim), stress(ndim, ndim), t, at_once
      real(dp), allocatable :: old_state(:)
      integer :: i
      m = polymer(.false.)
      allocate (old_state(m%columns), source=0.0_dp)
      h = 0
      h(1, 2) = 0.01_dp
      call m%update_state(h, 0.0_dp, old_state)
      at_once = m%energy_density(h, old_state)
      t = 0
      do i = 1, 5
         call m%update_state(h, 0.2_dp*i, old_state)
         t = t + 0.2_dp*i
         stress = m%kirchhoff_stress(h, old_state)
         call check_close(stress(1, 2)/(0.01_dp*(m%mu - sum(moduli) + sum(moduli*exp(-t/times)))), 1.0_dp, 1.0e-13_dp, &
                          'a sudden shear relaxes')
         call check_close((m%energy_density(h, old_state) + m%dissipation(h, old_state))/at_once, 1.0_dp, 1.0e-13_dp, &
                          'its energy is stored or dissipated')
      end do
   end subroutine relaxation

   !> A bar under a constant uniaxial stress in plane stress: Maxwell material, which keeps nothing, creeps by
   !> eps = s (1/E + t/(3 eta)), eta = mu tau.
   subroutine uniaxial_creep()
      real(dp), parameter :: stress = 1.0e6_dp, tau = 2.0_dp
      type(material_t) :: m
      real(dp), allocatable :: old_state(:)
      real(dp) :: h(ndim, ndim), expected, mu
      integer :: i
      mu = young/(2*(1 + poisson))
      m = new_material('pitch', 'viscoelastic', .true., young, poisson, 1200.0_dp, &
                       [constant('moduli', [mu]), constant('relaxation_times', [tau])])
      m%is_trial = .true.
      allocate (old_state(m%columns), source=0.0_dp)
      h = 0
      call pull(m, stress, old_state, h)
      call check_close(h(1, 1)*young/stress, 1.0_dp, 1.0e-12_dp, 'a sudden stress strains by E')
      call m%update_state(h, 0.0_dp, old_state)
      m%time_increment = 0.05_dp
      do i = 1, 200
         call pull(m, stress, old_state, h)
         call m%update_state(h, m%time_increment, old_state)
      end do
      expected = stress*(1/young + 10/(3*mu*tau))
      call check_close(h(1, 1)/expected, 1.0_dp, 1.0e-10_dp, 'Maxwell material creeps')
      call check_close(3*(h(1, 1) - old_state(1))*3*(young/(3*(1 - 2*poisson)))/stress, 1.0_dp, 1.0e-8_dp, &
                       'but not in its volume')
   end subroutine uniaxial_creep

   !> Find the strains at which there is a stress in the first direction only.
   subroutine pull(m, goal, old_state, h)
      type(material_t), intent(in) :: m
      real(dp), intent(in) :: goal, old_state(:)
      real(dp), intent(inout) :: h(ndim, ndim)
      real(dp) :: a(ndim, ndim), b(ndim, ndim), r(ndim, ndim)
      r = -m%kirchhoff_stress(h, old_state)
      r(1, 1) = r(1, 1) + goal
      a = m%first_piola_change(h, reshape([1.0_dp, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim]), old_state)
      b = m%first_piola_change(h, reshape([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [ndim, ndim]), old_state)
      associate (det => a(1, 1)*b(2, 2) - b(1, 1)*a(2, 2))
         h(1, 1) = h(1, 1) + (r(1, 1)*b(2, 2) - b(1, 1)*r(2, 2))/det
         h(2, 2) = h(2, 2) + (a(1, 1)*r(2, 2) - a(2, 2)*r(1, 1))/det
      end associate
   end subroutine pull
end program test_viscoelastic
