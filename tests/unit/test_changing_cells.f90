!> Steps in tiles move particles as steps in stages do, whether or not they change their cells.
program test_changing_cells
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: fill_rectangle
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_particles, only: new_particles
   use hampm_samples, only: schemes, start, thickness
   use hampm_sorting, only: sort_into_cells
   use hampm_step, only: explicit_t
   use hampm_threads, only: use_threads
   use hampm_thickness, only: thickness_t
   implicit none
   type(explicit_t) :: explicit

   real(dp), parameter :: coarse = 0.1_dp                !! cell size [m]
   real(dp), parameter :: rounding = 1.0e-10_dp          !! over the largest value
   integer :: k

   call use_threads(1, 0)
   call repeat_random_numbers()
   do k = 1, size(schemes)
      call as_in_stages(trim(schemes(k)), 0.0_dp, 1, 300)
      call as_in_stages(trim(schemes(k)), 1.0_dp, 1, 300)
   end do
   call as_in_stages('musl', 0.0_dp, 5, 30)
   call as_in_stages('usf', 20.0_dp, 5, 60)
   call same_bytes_with_two_threads('musl', 1)
   call same_bytes_with_two_threads('usf', 5)
   call who_leaves_the_grid_is_named()
   call who_jumps_is_named()
   call finish()

contains

   !> Two bodies of different materials beside each other, neither of which fits to the cells, at small random velocities,
   !> damped and held on one side; with a `speed` they are free, fly and turn. With 5 times as fine cells and particles there are several
   !> regions.
   subroutine place(scheme, speed, finer, m, cells)
      character(*), intent(in) :: scheme
      real(dp), intent(in) :: speed
      integer, intent(in) :: finer
      type(problem_t), intent(out) :: m
      integer, intent(in), optional :: cells(ndim)
      integer :: points(ndim)
      real(dp), parameter :: x(3) = [0.63_dp, 1.27_dp, 1.92_dp], y(2) = [0.86_dp, 1.43_dp]
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: k
      points = finer*[15, 13]
      forest = forest_t([0.0_dp, 0.0_dp], coarse/finer, finer*[31, 26])
      if (.not. speed > 0) forest = forest_t([0.6_dp, 0.8_dp], coarse/finer, finer*[14, 7]) ! to the edges of the grid
      if (present(cells)) forest = forest_t([0.0_dp, 0.0_dp], coarse/finer, cells)
      call build_grid(forest, m%grid, failure)
      call new_particles(2*product(points), m%particles, failure)
      m%materials = [new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                     new_material('', 'linear_elastic', .true., 3.0_dp, 0.1_dp, 2.0_dp)]
      do k = 1, 2
         call fill_rectangle(m%particles, 1 + (k - 1)*product(points), points, [x(k), y(1)], [x(k + 1), y(2)], &
                             thickness_t(thickness), &
                             m%materials(k)%density, [0.0_dp, 0.0_dp], k, k)
      end do
      associate (p => m%particles)
         call random_number(p%velocity)
         p%velocity = 0.01_dp*(p%velocity - 0.5_dp)
         do k = 1, p%n
            p%velocity(k, :) = p%velocity(k, :) + speed*([0.2_dp, 0.1_dp] + [y(1) - p%reference(k, 2), p%reference(k, 1) - x(2)])
         end do
         p%total_frame = .false.
      end associate
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      if (.not. speed > 0) call constrain_box(m%constraints, m%grid, [1.8_dp, 0.0_dp], [2.0_dp, 2.0_dp], [.true., .false.])
      m%damping_rate = 0.3_dp
      call start(m, scheme)
      call check(.not. failure%failed(), 'the bodies are in the grid')
   end subroutine place

   !> Do steps.
   subroutine run(m, steps)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: steps
      type(failure_t) :: failure
      integer :: k
      do k = 1, steps
         call explicit%advance(m, time_step(m), failure)
      end do
      call check(.not. failure%failed(), 'the steps are done: '//failure%message)
   end subroutine run

   !> A length of steps that is stable [s].
   pure real(dp) function time_step(m)
      type(problem_t), intent(in) :: m
      time_step = 0.05_dp*m%grid%element_size(1)/4
   end function time_step

   !> With the audit steps are done in stages.
   subroutine as_in_stages(scheme, speed, finer, steps)
      character(*), intent(in) :: scheme
      real(dp), intent(in) :: speed
      integer, intent(in) :: finer, steps
      type(problem_t) :: m, other
      real(dp) :: error(3)
      integer, allocatable :: of_id(:)
      integer :: changes, i
      call place(scheme, speed, finer, m)
      other = m
      other%audit = .true.
      call run(m, steps)
      call check(m%cache%tiling%n_tiles > 0, scheme//': steps are done in tiles')
      if (.not. speed > 0) call check((m%cache%tiling%n_regions > 1) .eqv. finer > 1, &
                                      scheme//': in as many regions as there should be')
      call run(other, steps)
      call check(other%cache%tiling%n_tiles == 0, scheme//': those of the other are not')
      allocate (of_id(other%particles%n))
      of_id(other%particles%id) = [(i, i=1, other%particles%n)]
      associate (a => m%particles, b => other%particles, j => of_id(m%particles%id))
         error(1) = maxval(abs(a%velocity - b%velocity(j, :)))/maxval(abs(b%velocity))
         error(2) = maxval(abs(a%displacement - b%displacement(j, :)))/maxval(abs(b%displacement))
         error(3) = maxval(abs(a%gradient - b%gradient(j, :, :)))/maxval(abs(b%gradient))
         changes = count(a%cell /= [(m%grid%element_at(a%reference(i, :)), i=1, a%n)])
         call check(all(a%cell == b%cell(j)), scheme//': all are in the same cells')
         call check(all(a%cell == [(m%grid%element_at(a%position(i)), i=1, a%n)]), scheme//': in which they stand')
      end associate
      write (*, '(2a,3es9.1,a,i0)') scheme, ': differences of v, u and H, over the largest', error, '; in other cells ', &
         changes
      call check((changes > m%particles%n/2) .eqv. speed > 0, scheme//': bodies that fly and turn change their cells')
      call check_close(maxval(error), 0.0_dp, rounding, scheme//': particles move as those of the other do')
      call check_close(m%energies%damping_loss, other%energies%damping_loss, rounding*abs(other%energies%damping_loss), &
                       scheme//': loss by damping')
      call check(abs(m%state%time - other%state%time) <= 0 .and. m%state%steps == other%state%steps, &
                 scheme//': and in the same steps')
   end subroutine as_in_stages

   !> The order of all sums is that of the blocks.
   subroutine same_bytes_with_two_threads(scheme, finer)
      character(*), intent(in) :: scheme
      integer, intent(in) :: finer
      type(problem_t) :: one, two
      call place(scheme, 1.0_dp*finer, finer, one)
      two = one
      call run(one, 150/finer)
      call use_threads(2, 0)
      call run(two, 150/finer)
      call use_threads(1, 0)
      call check(all(one%particles%id == two%particles%id) .and. all(abs(one%particles%velocity - two%particles%velocity) <= 0) &
                 .and. all(abs(one%particles%gradient - two%particles%gradient) <= 0) &
                 .and. abs(one%energies%damping_loss - two%energies%damping_loss) <= 0, scheme//': the same bytes on two threads')
   end subroutine same_bytes_with_two_threads

   !> A body that flies out of its grid.
   subroutine who_leaves_the_grid_is_named()
      type(problem_t) :: m
      type(failure_t) :: failure
      integer :: k
      call place('usf', 1.0_dp, 1, m, [22, 18])
      do k = 1, 3000
         if (failure%failed()) exit
         call explicit%advance(m, time_step(m), failure)
      end do
      call check(index(failure%message, 'left the grid') > 0, 'a particle has left the grid: '//failure%message)
   end subroutine who_leaves_the_grid_is_named

   !> A step that takes particles past the cell beside theirs.
   subroutine who_jumps_is_named()
      type(problem_t) :: m
      type(failure_t) :: failure
      integer :: k
      call place('musl', 1.0_dp, 1, m)
      do k = 1, 20
         call explicit%advance(m, time_step(m), failure)
      end do
      call explicit%advance(m, 1000*time_step(m), failure)
      call check(index(failure%message, 'moved by more than a cell') > 0, 'a particle has jumped: '//failure%message)
   end subroutine who_jumps_is_named
end program test_changing_cells
