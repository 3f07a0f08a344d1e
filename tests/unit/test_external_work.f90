!> The work of the loads is that of theory, to second order in the time step, whatever the history, the scheme and the frame.
program test_external_work
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_time_history, only: time_history_t
   use loading, only: load_on_points
   use hampm_loads, only: load_on_particles
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, thickness
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp), force = 1.0e-3_dp
   integer, parameter :: halvings = 3
   real(dp) :: error(halvings)
   integer :: k, n, frame

   do frame = 1, 2
      do k = 1, size(schemes)
         error = [(work_on_rigid_body(trim(schemes(k)), frame == 2, 80*2**n) - 1, n=0, halvings - 1)]
         call check_order(schemes(k)//' '//frame_name(frame)//', a rigid body', error)
         if (schemes(k) == 'usl') cycle          ! it takes energy of its own, in proportion to the time step
         error = [(work_at_end_of_bar(trim(schemes(k)), frame == 2, 10*2**n, 0.25_dp) - 1, n=0, halvings - 1)]
         call check_order(schemes(k)//' '//frame_name(frame)//', end of a bar, with cells and steps halved', error)
         error = [(work_at_end_of_bar(trim(schemes(k)), frame == 2, 20, 0.8_dp/2**n), n=0, halvings - 1)]
         call check(abs(log((error(2) - error(1))/(error(3) - error(2)))/log(2.0_dp) - 2) < 0.25_dp, &
                    schemes(k)//' '//frame_name(frame)//': the work in the same cells is of second order in the time step')
      end do
   end do
   do k = 1, size(schemes)
      if (schemes(k) == 'usl') cycle
      call force_at_a_corner(trim(schemes(k)))
   end do
   call finish()

contains

   function frame_name(frame) result(name)
      integer, intent(in) :: frame
      character(7) :: name
      name = merge('updated', 'total  ', frame == 1)
   end function frame_name

   !> Errors that fall to a fourth with half the time step.
   subroutine check_order(what, error)
      character(*), intent(in) :: what
      real(dp), intent(in) :: error(:)
      real(dp) :: order
      order = log(abs(error(halvings - 1)/error(halvings)))/log(2.0_dp)
      write (*, '(2a,3es10.2,a,f6.2)') what, ': errors of the work', error, ', order', order
      call check(order > 1.8_dp .and. order < 2.3_dp, what//': the work is of second order in the time step')
      call check(abs(error(halvings)) < 0.01_dp, what//': the work is that of theory')
   end subroutine check_order

   !> A body that the force F sin(w t) moves as a whole through the cells, until the force is at its largest: its work is the kinetic
   !> energy of a mass point, (F/w)**2/(2 m). Returns the work over that.
   real(dp) function work_on_rigid_body(scheme, total, steps) result(ratio)
      character(*), intent(in) :: scheme
      logical, intent(in) :: total
      integer, intent(in) :: steps
      real(dp), parameter :: end_time = 2.0_dp, frequency = 0.125_dp
      type(problem_t) :: m
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 0.1_dp, [12, 8]), new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, &
                        1.0_dp), [rectangle_t([0.21_dp, 0.33_dp], [0.71_dp, 0.63_dp], [10, 6])], m)
      allocate (m%loads(1))
      m%loads(1)%force = [40*force, 0.0_dp]
      m%loads(1)%history = time_history_t(kind='sine', frequency=frequency)
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], [1.0_dp, 1.0_dp], m%loads(1))
      m%particles%total_frame = total
      call start(m, scheme)
      call run_steps(m, end_time/steps, steps)
      ratio = m%energies%external_work/((40*force/(2*pi*frequency))**2/(2*sum(m%particles%mass(:m%particles%n))))
   end function work_on_rigid_body

   !> A bar of the wave speed 1 whose end a force F sin(w t) pushes for two periods: as long as nothing comes back, its velocity is
   !> F/Z with the impedance Z = A sqrt(E rho), and its work F**2 T/(2 Z). Returns the work over that.
   real(dp) function work_at_end_of_bar(scheme, total, cells, courant) result(ratio)
      character(*), intent(in) :: scheme
      logical, intent(in) :: total
      integer, intent(in) :: cells               !! in a wave length
      real(dp), intent(in) :: courant
      real(dp), parameter :: end_time = 2.0_dp
      type(problem_t) :: m
      real(dp) :: cell
      integer :: steps
      cell = 1.0_dp/cells
      call place_bodies(forest_t([-4*cell, -cell], cell, [2*cells, 3]), new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, &
                        1.0_dp), [rectangle_t([0.0_dp, 0.0_dp], [1.5_dp, cell], [3*cells, 2])], m)
      allocate (m%loads(1))
      m%loads(1)%force = [force*cell, 0.0_dp]
      m%loads(1)%history = time_history_t(kind='sine', frequency=1.0_dp)
      call load_on_points(m%matter_t, reshape([0.0_dp, cell/4, 0.0_dp, 3*cell/4], [ndim, 2]), [0.0_dp, cell/4], m%loads(1))
      m%particles%total_frame = total
      call start(m, scheme)
      steps = nint(end_time/(courant*cell))
      call run_steps(m, end_time/steps, steps)
      ratio = m%energies%external_work/((force*cell)**2*end_time/(2*cell*thickness))
   end function work_at_end_of_bar

   !> A force that rises slowly on the corner of a held plate: but for the little that the damping takes, its work is the strain
   !> energy, and nothing is lost by the method, though the displacement is singular there.
   subroutine force_at_a_corner(scheme)
      character(*), intent(in) :: scheme
      real(dp), parameter :: cell = 0.1_dp, rise = 100.0_dp
      type(problem_t) :: m
      call place_bodies(forest_t([-2*cell, -2*cell], cell, [10, 8]), new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, &
                        1.0_dp), [rectangle_t([0.0_dp, 0.0_dp], [4*cell, 4*cell], [8, 8])], m)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [0.0_dp, 4*cell], [.true., .true.])
      allocate (m%loads(1))
      m%loads(1)%force = [0.3_dp*force, force]
      m%loads(1)%history = time_history_t(kind='ramp', rise_time=rise)
      call load_on_points(m%matter_t, reshape([4*cell, 4*cell], [ndim, 1]), [0.0_dp, 0.0_dp], m%loads(1))
      m%damping_rate = 2
      m%particles%total_frame = .true.
      m%audit = .true.
      call start(m, scheme)
      call run_steps(m, 0.04_dp, nint(1.5_dp*rise/0.04_dp))
      write (*, '(2a,es10.2)') scheme, ', force at a corner: loss by the method over work', &
         m%energies%numerical_loss/m%energies%external_work
      call check_close(m%energies%numerical_loss/m%energies%external_work, 0.0_dp, 1.0e-5_dp, &
                       scheme//': a slow force on a corner loses nothing')
   end subroutine force_at_a_corner
end program test_external_work
