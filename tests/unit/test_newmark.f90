!> An implicit step of a body of any law: the tangent with inertia is the change of what is out of balance, Newton's iteration converges
!> quadratically, and the step that is then finished satisfies the equations of Newmark and of Hilber, Hughes and Taylor.
program test_newmark
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constrain_box, hold
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_matching, only: adopt_forest
   use hampm_law, only: constant
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t, stored_energy, dissipated_energy, kinetic_energy
   use hampm_newmark, only: newmark_t
   use hampm_newton, only: displace, residual
   use hampm_outer_forces, only: loading_t
   use hampm_particles, only: add_history
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness
   implicit none

   character(*), parameter :: cases(4) = [character(13) :: 'neo_hookean', 'j2_plastic', 'shared', 'viscoelastic']
   real(dp), parameter :: length = 4.0_dp, depth = 1.0_dp, dt = 0.6_dp, alphas(2) = [0.0_dp, -0.2_dp]
   integer :: k, a

   call repeat_random_numbers()
   do k = 1, size(cases)
      do a = 1, size(alphas)
         call tangent_is_change(cases(k), alphas(a))
         call converges_quadratically(cases(k), alphas(a))
      end do
      call steps_balance_energy(cases(k))
   end do
   call finish()

contains

   !> A cantilever with smaller cells in a part of it, which swings: bent by half of its length in a step of neo-Hookean material, and beyond
   !> the yield stress in one of plastic material.
   subroutine build(name, m)
      character(*), intent(in) :: name
      type(problem_t), intent(out) :: m
      type(forest_t) :: forest
      type(material_t) :: material
      type(failure_t) :: failure
      real(dp) :: speed
      integer :: i
      select case (name)
       case ('neo_hookean')
         material = new_material('', name, .false., 1.0_dp, 0.3_dp, 1.0_dp)
       case ('viscoelastic')
         material = new_material('', name, .false., 1.0_dp, 0.3_dp, 1.0_dp, &
                                 [constant('moduli', [0.1_dp, 0.2_dp]), constant('relaxation_times', [0.5_dp, 3.0_dp])])
       case default
         material = new_material('', 'j2_plastic', .false., 1.0_dp, 0.3_dp, 1.0_dp, &
                                 [constant('yield_stress', [2e-3_dp]), constant('hardening', [0.05_dp])])
         material%mean_dilatation = name == 'shared'
      end select
      material%is_trial = .true.
      forest = forest_t([-1.0_dp, -2.0_dp], 0.5_dp, [14, 10])
      call place_bodies(forest, material, [rectangle_t([0.0_dp, 0.0_dp], [length, depth], [16, 4])], m)
      m%particles%total_frame = .true.
      if (material%has_history) call add_history(m%particles, material%columns)
      call start(m, 'musl')
      call refine_box(forest, [1.1_dp, 0.1_dp], [1.9_dp, 0.9_dp], 2)
      call adopt_forest(m, forest, failure)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .true.])
      speed = merge(1.0_dp, 0.02_dp, name == 'neo_hookean')
      do i = 1, m%particles%n
         m%particles%velocity(i, 2) = speed*(m%particles%reference(i, 1)/length)**2
      end do
      m%damping_rate = 0.1_dp
   end subroutine build

   !> Begin a step of it.
   subroutine begin(name, alpha, m, newmark)
      character(*), intent(in) :: name
      real(dp), intent(in) :: alpha
      type(problem_t), intent(out) :: m
      type(newmark_t), intent(out) :: newmark
      type(failure_t) :: failure
      type(loading_t) :: drive
      call build(name, m)
      newmark%alpha = alpha
      call newmark%initialise(m, dt, failure)
      call check(.not. failure%failed(), 'the motion of the nodes is found')
      call newmark%begin(m, dt, dt, drive, failure)
      m%materials%time_increment = dt
   end subroutine begin

   !> Factorise the tangent.
   subroutine factorise(m, newmark, k)
      type(problem_t), intent(in) :: m
      type(newmark_t), intent(in) :: newmark
      type(stiffness_t), intent(inout) :: k
      type(failure_t) :: failure
      call factorise_stiffness(m, stiffness_kind_t(.true., .false., mass_factor=newmark%outer%mass_factor), k, failure)
      call check(.not. failure%failed(), 'the tangent is factorised')
   end subroutine factorise

   !> A displacement is found again from the difference of what is out of balance for a small part of it forth and back, from a state in
   !> the middle of a step.
   subroutine tangent_is_change(name, alpha)
      character(*), intent(in) :: name
      real(dp), intent(in) :: alpha
      real(dp), parameter :: part = 1e-6_dp
      type(problem_t) :: m
      type(newmark_t) :: newmark
      type(stiffness_t) :: k
      real(dp), allocatable :: u(:, :), du(:, :), forth(:, :), back(:, :), found(:, :)
      integer :: i
      call begin(name, alpha, m, newmark)
      u = dt*m%state%velocity
      call displace(m, u)
      call factorise(m, newmark, k)
      allocate (du, mold=u)
      du = 0
      associate (all => m%fields%mass_matrix%all)
         do i = 1, all%n_nodes
            call random_number(du(:, all%nodes(i)))
         end do
         call hold(m%constraints, du)
         call m%grid%dofs%distribute(all, ndim, du)
      end associate
      call displace(m, part*du)
      call residual(m, newmark%outer, u + part*du, forth)
      call displace(m, -2*part*du)
      call residual(m, newmark%outer, u - part*du, back)
      call k%solve(m, (back - forth)/(2*part), found)
      call check_close(maxval(abs(found - du)), 0.0_dp, 1e-6_dp, trim(name)//': displacement from what is out of balance')
      call k%release()
   end subroutine tangent_is_change

   !> What is out of balance falls as its square, from iteration to iteration, down to rounding; of the plastic law once it is known which
   !> particles yield.
   subroutine converges_quadratically(name, alpha)
      character(*), intent(in) :: name
      real(dp), intent(in) :: alpha
      integer, parameter :: most = 12
      type(problem_t) :: m
      type(newmark_t) :: newmark
      type(stiffness_t) :: k
      real(dp), allocatable :: u(:, :), du(:, :), r(:, :)
      real(dp) :: left(0:most)                   ! largest force out of balance, over that at first
      integer :: i
      call begin(name, alpha, m, newmark)
      allocate (u, source=0*m%state%velocity)
      left = 0
      do i = 0, most
         call displace(m, 0*u)
         call residual(m, newmark%outer, u, r)
         call factorise(m, newmark, k)
         left(i) = maxval(abs(k%unknowns%gather(r)))
         if (left(i) < 1e-13_dp*left(0)) exit
         call k%solve(m, r, du)
         u = u + du
         call displace(m, du)
      end do
      call k%release()
      left(1:) = left(1:)/left(0)
      print '(2a, f5.1, a, *(es9.1))', name, ', alpha', alpha, ', out of balance:', left(1:min(i, most))
      call check(i <= 8, trim(name)//': Newton''s iteration ends soon')
      do i = 1, most - 1
         if (left(i) < 1e-3_dp .and. left(i) > 1e-7_dp) &
            call check(left(i + 1) < max(100*left(i)**2, 1e-13_dp), trim(name)//': it converges quadratically')
      end do
   end subroutine converges_quadratically

   !> The kinetic energy of some steps by the solver gains the work of the means of the internal forces, so that the energy is kept but for
   !> what the rule of trapezoids has of the law: it falls as the square of the step.
   subroutine steps_balance_energy(name)
      character(*), intent(in) :: name
      real(dp) :: missing(3)
      integer :: k
      do k = 1, 3
         missing(k) = missing_energy(name, 8*2**k)
      end do
      print '(2a, *(es10.2))', name, ', missing energy with 16, 32 and 64 steps:', missing
      call check(abs(missing(3)) < 1e-3_dp, trim(name)//': energy is balanced')
      call check(abs(missing(3)) < 0.35_dp*abs(missing(2)), trim(name)//': the less so the longer the steps, as their square')
   end subroutine steps_balance_energy

   !> What is missing in the energy after a number of steps through a time, over the energy at first.
   real(dp) function missing_energy(name, steps) result(missing)
      character(*), intent(in) :: name
      integer, intent(in) :: steps
      real(dp), parameter :: time = 4.0_dp
      type(problem_t) :: m
      type(newmark_t) :: newmark
      type(failure_t) :: failure
      real(dp) :: at_first
      integer :: i
      call build(name, m)
      call newmark%initialise(m, time/steps, failure)
      at_first = kinetic_energy(m)
      do i = 1, steps
         call newmark%advance_to(m, i*time/steps, failure)
      end do
      call check(.not. failure%failed(), 'the steps are done')
      missing = (kinetic_energy(m) + stored_energy(m) + dissipated_energy(m) + m%energies%damping_loss - at_first)/at_first
      call newmark%newton%release()
   end function missing_energy
end program test_newmark
