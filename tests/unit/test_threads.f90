!> The same bytes with any number of threads, for every scheme and with particles that cross cells.
program test_threads
   use hampm_kinds, only: dp, ndim, long
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_loads, only: load_on_particles
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps
   use hampm_threads, only: use_threads, thread_count
   implicit none

   integer, parameter :: cells = 30              !! enough nodes and cells for several blocks of work
   real(dp), parameter :: cell = 0.1_dp
   real(dp) :: noise(ndim, 4*cells**2)
   type(problem_t) :: alone, together
   integer :: k, threads

   call repeat_random_numbers()
   call random_number(noise)
   do k = 1, size(schemes)
      call run(trim(schemes(k)), 1, alone)
      do threads = 2, 3
         call run(trim(schemes(k)), threads, together)
         call check(same_bytes(alone%particles, together%particles), &
                    trim(schemes(k))//': particles have the same bytes with 1 and more threads')
         call check(all(transfer([alone%energies%external_work, alone%energies%damping_loss, alone%energies%numerical_loss], &
                                 [0_long]) == &
                        transfer([together%energies%external_work, together%energies%damping_loss, &
                                  together%energies%numerical_loss], [0_long])), &
                    trim(schemes(k))//': so has the energy audit')
      end do
      call check(any(alone%particles%id /= [(threads, threads=1, alone%particles%n)]), trim(schemes(k))//': particles crossed')
   end do
   call finish()

contains

   !> Some steps of a loaded, damped body with random velocities.
   subroutine run(scheme, threads, m)
      character(*), intent(in) :: scheme
      integer, intent(in) :: threads
      type(problem_t), intent(out) :: m
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [cells + 4, cells + 4]), &
                        new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.12_dp, 0.12_dp], [0.12_dp, 0.12_dp] + cells*cell, [2*cells, 2*cells])], m)
      m%particles%velocity = 0.1_dp + 0.1_dp*transpose(noise)
      allocate (m%loads(1))
      m%loads(1)%force = [0.1_dp, 0.2_dp]
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], [2.0_dp, 2.0_dp], m%loads(1))
      m%damping_rate = 0.1_dp
      m%audit = .true.
      call use_threads(threads, m%particles%n)
      call check(thread_count() == threads, 'as many threads as wanted')
      call start(m, scheme)
      call run_steps(m, 0.2_dp*cell, 8)
   end subroutine run

   logical function same_bytes(a, b)
      type(particles_t), intent(in) :: a, b
      same_bytes = all(a%id == b%id) .and. all(a%cell == b%cell) &
                   .and. all(transfer(a%displacement, [0_long]) == transfer(b%displacement, [0_long])) &
                   .and. all(transfer(a%velocity, [0_long]) == transfer(b%velocity, [0_long])) &
                   .and. all(transfer(a%gradient, [0_long]) == transfer(b%gradient, [0_long]))
   end function same_bytes
end program test_threads
