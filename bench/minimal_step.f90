!> The program beside the least that a plain step needs (`minimal_kernel.f90`): first both must agree, then both are measured in
!> one run, with waves, denormal numbers and particles that change their cell. One thread. See docs/evidence/performance.md.
program minimal_step
   use, intrinsic :: iso_fortran_env, only: output_unit
   use, intrinsic :: ieee_arithmetic, only: ieee_set_underflow_mode
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: kinetic_energy, strain_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_minimal_kernel, only: blocks_t, set_up, step, place_of, energy, w, bytes
   use hampm_problem, only: problem_t
   use hampm_plain_scene, only: plain_scene, soft_body, start, turn, time_step
   use hampm_step, only: advance
   use hampm_threads, only: use_threads
   use hampm_critical_step, only: stable_time_step
   use hampm_timing, only: seconds => processor_seconds, time_to_move, median
   implicit none
   type(problem_t) :: problem

   call use_threads(1, 1)
   call compare()
   print '(a)', 'particles  motion  gradual     w  library     minimal       copy of the same bytes'
   call measure(50, 'smooth', .true.)
   call measure(158, 'smooth', .true.)
   call measure(500, 'smooth', .true.)
   call measure(500, 'wave', .true.)
   call measure(500, 'wave', .false.)
   call measure(256, 'turning', .true.)

contains

   !> The plain model or, where `fast`, the soft body that turns and flies.
   subroutine build(cells, fast)
      integer, intent(in) :: cells
      logical, intent(in) :: fast
      if (fast) then
         call start(soft_body(cells), problem)
         call turn(problem)
      else
         call start(plain_scene(cells), problem)
      end if
   end subroutine build

   !> Compare with the library after some steps of a flying, turning, vibrating block.
   subroutine compare()
      type(blocks_t) :: g
      type(failure_t) :: failure
      real(dp) :: dt, u, worst_u, worst_v, worst_h, momentum(ndim)
      integer :: k, i, e, s, by_id(4096)
      call build(32, .true.)
      dt = stable_time_step(1.0e-3_dp, problem%materials, 0.4_dp, 'dilatational')
      call set_up(dt, problem, g)
      do k = 1, 500
         call advance(problem, dt, failure)
         if (failure%failed()) error stop 'the library has failed'
         call step(dt, problem%grid, g)
      end do
      associate (p => problem%particles)
         by_id(p%id) = [(i, i=1, p%n)]
         u = maxval(abs(p%displacement))
         worst_u = 0
         worst_v = 0
         worst_h = 0
         momentum = 0
         do e = 1, problem%grid%n_elements
            do s = 1, g%count_of(e)
               associate (q => g%p(place_of(g, e, s), :))
                  i = by_id(g%id(place_of(g, e, s)))
                  if (p%cell(i) /= e) error stop 'a particle stands in another cell than in the library'
                  worst_u = max(worst_u, maxval(abs(q(3:4) - p%displacement(i, :))))
                  worst_v = max(worst_v, maxval(abs(q(5:6) - p%velocity(i, :))))
                  worst_h = max(worst_h, maxval(abs(q(7:10) - [p%gradient(i, :, :)])))
                  momentum = momentum + q(11)*q(5:6)
               end associate
            end do
         end do
         print '(a, i3, a, i0, a, i0, a, 4es9.1)', 'w =', w, ': particles ', p%n, ', changes of cell ', g%moved, &
            ', |u| max, worst difference of u, v, H', u, worst_u, worst_v, worst_h
         print '(a, 3es24.15)', '  momentum, energy  ', linear_momentum(p), kinetic_energy(p) + strain_energy(p, problem%materials)
         print '(a, 3es24.15)', '  minimal           ', momentum, energy(g)
      end associate
   end subroutine compare

   !> Measure one size of model: the library and the kernel, beside the speed of a copy.
   subroutine measure(cells, motion_kind, gradual)
      integer, intent(in) :: cells
      character(*), intent(in) :: motion_kind           !! 'smooth'; 'wave': one that runs into material at rest; or 'turning':
                                                        !! 2 % of the particles change their cell in each step
      logical, intent(in) :: gradual                    !! whether numbers below the smallest normal one are kept
      integer, parameter :: repetitions = 9
      type(blocks_t) :: g
      real(dp) :: t(repetitions, 3), dt
      type(failure_t) :: failure
      integer :: r, steps, j
      call build(cells, motion_kind == 'turning')
      if (motion_kind == 'wave') where (problem%particles%reference(:, 1) > 0.01_dp) problem%particles%velocity(:, 1) = 0
      if (motion_kind == 'wave') problem%particles%velocity(:, 2) = 0
      dt = time_step(problem)
      call set_up(dt, problem, g)
      steps = max(10, 2000000/problem%particles%n)
      call ieee_set_underflow_mode(gradual)
      if (motion_kind == 'wave') then
         do j = 1, 200
            call advance(problem, dt, failure)
            call step(dt, problem%grid, g)
         end do
      end if
      do r = 1, repetitions
         t(r, 1) = seconds()
         do j = 1, steps
            call advance(problem, dt, failure)
         end do
         t(r, 1) = seconds() - t(r, 1)
         t(r, 2) = seconds()
         do j = 1, steps
            call step(dt, problem%grid, g)
         end do
         t(r, 2) = seconds() - t(r, 2)
         t(r, 3) = steps*time_to_move(problem%particles%n, bytes, steps, seconds)
      end do
      t = 1e9_dp*t/steps/problem%particles%n
      call ieee_set_underflow_mode(.true.)
      print '(i9, 2x, a7, l8, i6, 3(f9.1, f6.1))', problem%particles%n, motion_kind, gradual, w, &
         (median(t(:, j)), minval(t(:, j)), j=1, 3)
      if (g%moved > 0) print '(a, f6.2, a, f6.2)', '  changes of cell per particle and step [%]', &
         100*real(g%moved, dp)/(real(steps, dp)*repetitions*problem%particles%n), &
         ', places per particle', sum(real(w*g%rows, dp))/problem%particles%n
      flush (output_unit)
   end subroutine measure
end program minimal_step
