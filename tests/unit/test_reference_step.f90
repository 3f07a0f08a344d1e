!> Every way in which the program takes a step against the reference step: after 100 steps particles, work and loss are the same but
!> for rounding, for all schemes, in both frames, with and without hanging nodes, with one and two threads, whether the energy is
!> audited or not. Bodies of two laws that no cell fits are loaded, held and damped, and particles change cells.
program test_reference_step
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: fill_rectangle
   use hampm_builds, only: is_slow
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_time_history, only: time_history_t
   use loading, only: load_on_points
   use hampm_loads, only: load_on_particles
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, update_particles
   use hampm_particles, only: new_particles
   use hampm_reference_step, only: reference_t
   use hampm_refined, only: refine_box
   use hampm_samples, only: schemes, start, run_steps, thickness
   use hampm_sorting, only: sort_into_cells
   use hampm_threads, only: use_threads
   use hampm_thickness, only: thickness_t
   implicit none

   real(dp), parameter :: cell = 0.1_dp, dt = 0.05_dp*cell
   real(dp), parameter :: rounding = 1.0e-12_dp          !! over the largest value
   character(*), parameter :: paths(3) = ['element operators', 'tiles            ', 'stages           ']
   real(dp) :: largest(3, 2)                             !! by path; in the total and in the updated frame
   integer :: steps, scheme, levels

   call repeat_random_numbers()
   steps = merge(10, 100, is_slow())
   largest = -1
   do scheme = 1, size(schemes)
      do levels = 0, 1
         call in_a_frame(trim(schemes(scheme)), .true., levels)
         call in_a_frame(trim(schemes(scheme)), .false., levels)
      end do
   end do
   write (*, '(a)') 'largest difference of v, u or H over the largest value, of all schemes, meshes, threads:'
   write (*, '(a)') 'path                total frame  updated frame  (-1: not taken)'
   do scheme = 1, size(paths)
      write (*, '(a, 2es13.1)') paths(scheme), largest(scheme, :)
   end do
   call finish()

contains

   !> Take the steps by the reference, and by every path that a motion can take in a frame on a mesh.
   subroutine in_a_frame(scheme, total_frame, levels)
      character(*), intent(in) :: scheme
      logical, intent(in) :: total_frame
      integer, intent(in) :: levels
      type(problem_t) :: first, reference, m
      type(reference_t) :: by_reference
      type(failure_t) :: failure
      integer :: k, threads, audited
      call place(scheme, total_frame, levels, first)
      reference = first
      do k = 1, steps
         call by_reference%advance(reference, dt, failure)
      end do
      do threads = 1, 2
         call use_threads(threads, 0)
         do audited = 0, 1
            m = first
            m%audit = audited == 1
            call run_steps(m, dt, steps)
            call compare(m, reference, scheme)
         end do
      end do
      call use_threads(1, 0)
   end subroutine in_a_frame

   !> Check that a motion is that of the reference, particle by particle.
   subroutine compare(m, reference, scheme)
      type(problem_t), intent(in) :: m, reference
      character(*), intent(in) :: scheme
      integer :: of(m%particles%n), theirs(m%particles%n), path, k
      character(:), allocatable :: what
      real(dp) :: error(3)
      of(m%particles%id) = [(k, k=1, m%particles%n)]
      theirs(reference%particles%id) = [(k, k=1, m%particles%n)]
      associate (p => m%particles, r => reference%particles)
         error(1) = maxval(abs(p%velocity(of, :) - r%velocity(theirs, :)))/maxval(abs(r%velocity))
         error(2) = maxval(abs(p%displacement(of, :) - r%displacement(theirs, :)))/maxval(abs(r%displacement))
         error(3) = maxval(abs(p%gradient(of, :, :) - r%gradient(theirs, :, :)))/maxval(abs(r%gradient))
      end associate
      path = 3
      if (m%grid%dofs%n_hanging == 0 .and. .not. m%audit) path = 2
      if (m%cache%operators%is_active) path = 1
      associate (worst => largest(path, merge(1, 2, m%particles%total_frame)))
         worst = max(worst, maxval(error))
      end associate
      what = scheme//', '//trim(paths(path))//merge(', total frame  ', ', updated frame', m%particles%total_frame)// &
             merge(', hanging nodes', ', uniform      ', m%grid%dofs%n_hanging > 0)
      call check_close(maxval(error), 0.0_dp, rounding, what//': the motion is that of the reference step')
      call check_close(m%energies%external_work, reference%energies%external_work, &
                       rounding*abs(reference%energies%external_work), what//': work of the loads')
      call check_close(m%energies%damping_loss, reference%energies%damping_loss, rounding*reference%energies%damping_loss, &
                       what//': loss by damping')
   end subroutine compare

   !> Two bodies, one on the other, loaded at an edge, at a point and in a box, held at one side and damped.
   subroutine place(scheme, total_frame, levels, m)
      character(*), intent(in) :: scheme
      logical, intent(in) :: total_frame
      integer, intent(in) :: levels
      type(problem_t), intent(out) :: m
      integer, parameter :: points(ndim) = [24, 12]
      real(dp), parameter :: x(2) = [0.2_dp, 0.8_dp], y(3) = [0.2_dp, 0.5_dp, 0.8_dp]
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: k
      forest = forest_t([0.0_dp, 0.0_dp], cell, [10, 10])
      call refine_box(forest, [0.3_dp, 0.4_dp], [0.5_dp, 0.7_dp], levels)
      call build_grid(forest, m%grid, failure)
      call new_particles(2*product(points), m%particles, failure)
      allocate (m%materials(2))
      m%materials(1) = new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp)
      m%materials(2) = new_material('', 'neo_hookean', .true., 2.0_dp, 0.2_dp, 1.5_dp)
      do k = 1, 2
         call fill_rectangle(m%particles, 1 + (k - 1)*product(points), points, [x(1), y(k)], [x(2), y(k + 1)], &
                             thickness_t(thickness), &
                             m%materials(k)%density, [0.0_dp, 0.0_dp], k, k)
      end do
      m%particles%id = [(k, k=1, m%particles%n)]
      call random_number(m%particles%velocity)
      m%particles%velocity = 0.02_dp*(m%particles%velocity - 0.2_dp)
      m%particles%total_frame = total_frame
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      allocate (m%loads(3))
      m%loads(1)%force = [1.0e-3_dp, -2.0e-3_dp]
      m%loads(1)%history = time_history_t(kind='ramp', rise_time=80*dt)
      call load_on_points(m%matter_t, reshape([x(1), 0.25_dp, x(1), 0.45_dp], [ndim, 2]), [0.0_dp, 0.1_dp], m%loads(1))
      m%loads(2)%force = [-3.0e-4_dp, 1.0e-4_dp]
      m%loads(2)%history = time_history_t(kind='sine', frequency=0.02_dp/dt)
      call load_on_points(m%matter_t, reshape([0.55_dp, y(3)], [ndim, 1]), [0.0_dp, 0.0_dp], m%loads(2))
      m%loads(3)%force = [0.0_dp, -1.0e-3_dp]
      call load_on_particles(m%particles, [0.3_dp, 0.5_dp], [0.6_dp, 0.8_dp], m%loads(3))
      call constrain_box(m%constraints, m%grid, [0.75_dp, 0.0_dp], [1.0_dp, 1.0_dp], [.true., .false.])
      m%damping_rate = 0.3_dp
      call start(m, scheme)
      call check(.not. failure%failed(), 'the bodies are in the grid')
   end subroutine place
end program test_reference_step
