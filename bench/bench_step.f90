!> Time per particle and step of a plain elastic scene: a box filled with four particles a cell, no loads, no crack.
!> Beside it stands the time that the same machine needs, in the same run, to move the bytes that a step reads and
!> writes. Prints one line for each number of particles, scheme and number of threads; see bench/README.md.
program bench_step
   use, intrinsic :: iso_fortran_env, only: output_unit
   use hampm_kinds, only: dp, long, ndim
   use hampm_assembly, only: assemble
   use hampm_failure, only: failure_t
   use hampm_particles, only: smallest_occupied_cell
   use hampm_refinement, only: refinement_t
   use hampm_scene, only: scene_t
   use hampm_step, only: motion_t, advance, stable_time_step
   use hampm_threads, only: use_threads, processor_count
   use hampm_timing, only: time_to_move, median
   implicit none
   integer, parameter :: cells(3) = [50, 158, 500]          ! cells along an edge: 10k, 100k, 1M particles
   character(5), parameter :: schemes(4) = ['usl  ', 'usf  ', 'musl ', 'usavg']
   integer, parameter :: repetitions = 5                    ! of which the median is printed
   integer :: k, s, n

   print '(a)', 'particles  scheme  threads  ns/particle/step  ns to move the same bytes  ratio  bytes'
   do k = 1, size(cells)
      do s = 1, size(schemes)
         do n = 1, processor_count(), max(1, processor_count() - 1)
            call measure_case(cells(k), schemes(s), n)
         end do
      end do
   end do

contains

   !> Measure one case and print its line.
   subroutine measure_case(cells, scheme, threads)
      integer, intent(in) :: cells, threads
      character(*), intent(in) :: scheme
      type(motion_t) :: motion
      real(dp) :: step_time(repetitions), move_time(repetitions), dt
      integer :: r, steps, k, bytes
      type(failure_t) :: failure
      call filled_box(cells, scheme, motion)
      call use_threads(threads, motion%particles%n)
      dt = stable_time_step(smallest_occupied_cell(motion%grid, motion%particles), motion%materials, 0.1_dp, 'shear')
      steps = max(2, 1000000/motion%particles%n)
      bytes = bytes_per_step(scheme)
      do r = 1, repetitions
         step_time(r) = seconds()
         do k = 1, steps
            call advance(motion, dt, failure)
            if (failure%failed()) error stop 'the benchmark scene has failed'
         end do
         step_time(r) = (seconds() - step_time(r))/steps/motion%particles%n
         move_time(r) = time_to_move(motion%particles%n, bytes, steps, seconds)/motion%particles%n
      end do
      print '(i9, 2x, a6, i9, f18.1, f27.1, f7.1, i7)', motion%particles%n, scheme, threads, &
         1e9_dp*median(step_time), 1e9_dp*median(move_time), median(step_time/move_time), bytes
      flush (output_unit)
   end subroutine measure_case

   !> A box of cells filled with particles in a smooth small motion.
   subroutine filled_box(cells, scheme, motion)
      integer, intent(in) :: cells
      character(*), intent(in) :: scheme
      type(motion_t), intent(out) :: motion
      type(scene_t) :: scene
      type(refinement_t) :: refinement
      type(failure_t) :: failure
      real(dp), parameter :: cell = 1.0e-3_dp
      scene%run%plane = 'stress'
      scene%run%thickness = 1
      scene%grid%cell = cell
      scene%grid%cells = cells
      scene%method%scheme = scheme
      allocate (scene%materials(1), scene%bodies(1), scene%constraints(0), scene%loads(0))
      scene%materials(1)%law = 'linear_elastic'
      scene%materials(1)%young = 70e9_dp
      scene%materials(1)%poisson = 0.3_dp
      scene%materials(1)%density = 2700
      scene%bodies(1)%material_index = 1
      scene%bodies(1)%upper = cells*cell
      scene%bodies(1)%points_per_cell = 2
      call assemble(scene, motion, refinement, failure)
      if (failure%failed()) error stop 'the benchmark scene cannot be built'
      motion%particles%velocity = 1.0e-3_dp*sin(200*motion%particles%reference)
   end subroutine filled_box

   !> Bytes of particle data that the sweeps of a step read and write, 8 a real and 4 for the material: the least that has
   !> to be moved where the particles do not fit into the caches.
   pure integer function bytes_per_step(scheme) result(bytes)
      character(*), intent(in) :: scheme
      integer, parameter :: x = ndim, u = ndim, v = ndim, h = ndim*ndim, m = 1, volume = 1
      integer :: reals
      select case (scheme)
      case ('usl')
         reals = x + 2*u + 2*v + 2*h + m + volume
      case ('usf')
         reals = (x + u + 2*h + volume) + (x + 2*u + 2*v + m)
      case ('musl')
         reals = (x + u + 2*v + m) + (x + 2*u + v + 2*h + m + volume)
      case default
         reals = (x + u + 2*h + volume) + (x + u + 2*v + m) + (x + 2*u + v + 2*h + m)
      end select
      bytes = 8*reals + 4
   end function bytes_per_step

   !> Wall time [s]. With one thread on a busy machine prefer ratios of one run.
   real(dp) function seconds()
      integer(long) :: ticks, rate
      call system_clock(ticks, rate)
      seconds = real(ticks, dp)/real(rate, dp)
   end function seconds
end program bench_step
