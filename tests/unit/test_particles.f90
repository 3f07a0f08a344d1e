!> Sorting particles into cells loses and changes nothing, and says where a particle has gone wrong.
program test_particles
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_set_flag, ieee_invalid
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_particles, only: particles_t, new_particles, add_history
   use hampm_sorting, only: sorting_t, sort_into_cells
   implicit none

   integer, parameter :: n = 700
   real(dp), parameter :: extent(ndim) = [1.2_dp, 0.8_dp]
   type(grid_t) :: grid
   type(cell_blocks_t) :: blocks
   type(sorting_t) :: sorted
   type(failure_t) :: failure

   call repeat_random_numbers()
   call build_grid(forest_t(lower=[0.0_dp, 0.0_dp], cell=0.2_dp, cells=[6, 4]), grid, failure)
   call sorting()
   call gone_astray()
   call finish()

contains

   !> Particles at random places, each with data that follow from its number.
   subroutine scatter(p)
      type(particles_t), intent(out) :: p
      integer :: i
      call new_particles(n, p, failure)
      call add_history(p, 2)
      call random_number(p%reference)
      do i = 1, n
         p%reference(i, :) = 0.5_dp*extent*p%reference(i, :)
         p%displacement(i, :) = 0.5_dp*extent*modulo(real([i, 3*i], dp)/n, 1.0_dp)
         p%id(i) = i
         p%material(i) = 2*i
         p%body(i) = 3*i
         p%mass(i) = i
         p%volume(i) = 2*i
         p%velocity(i, :) = [3*i, 4*i]
         p%gradient(i, :, :) = reshape([5*i, 6*i, 7*i, 8*i], [ndim, ndim])
         p%history(i, :) = [9*i, 10*i]
      end do
   end subroutine scatter

   subroutine sorting()
      type(particles_t), allocatable :: before
      type(particles_t) :: p
      integer :: round
      call scatter(p)
      do round = 1, 3
         allocate (before, source=p)
         call sort_into_cells(sorted, p, grid, blocks, failure)
         call check(.not. failure%failed(), 'particles within the grid are sorted')
         call compare(before, p)
         call check_cells(p)
         p%displacement = 0.9_dp*p%displacement
         deallocate (before)
      end do
   end subroutine sorting

   !> `p` holds the particles of `before`, each at its `new_place`, and keeps their order within a cell.
   subroutine compare(before, p)
      type(particles_t), intent(in) :: before, p
      real(dp) :: difference
      integer :: i, wrong
      associate (to => sorted%new_place)
         difference = max(maxval(abs(p%mass(to) - before%mass)), maxval(abs(p%volume(to) - before%volume)), &
                          maxval(abs(p%reference(to, :) - before%reference)), &
                          maxval(abs(p%displacement(to, :) - before%displacement)), &
                          maxval(abs(p%velocity(to, :) - before%velocity)), &
                          maxval(abs(p%gradient(to, :, :) - before%gradient)), &
                          maxval(abs(p%history(to, :) - before%history)))
         call check_close(difference, 0.0_dp, 0.0_dp, 'every particle is there, once, with its numbers')
         call check(all(p%id(to) == before%id) .and. all(p%material(to) == before%material) .and. &
                    all(p%body(to) == before%body), 'and its indices')
         wrong = 0
         do i = 1, n - 1
            if (any(p%cell(to(i + 1:)) == p%cell(to(i)) .and. to(i + 1:) < to(i))) wrong = wrong + 1
         end do
      end associate
      call check(wrong == 0, 'particles of a cell keep their order')
   end subroutine compare

   subroutine check_cells(p)
      type(particles_t), intent(in) :: p
      integer :: e, i, wrong, n_occupied, visits(n), visits_before
      wrong = 0
      visits = 0
      n_occupied = 0
      do e = 1, grid%n_elements
         visits_before = sum(visits)
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            visits(i) = visits(i) + 1
            if (p%cell(i) /= e .or. grid%forest%leaf_at(p%position(i)) /= e) wrong = wrong + 1
         end do
         if (sum(visits) - visits_before /= blocks%count_in(e)) wrong = wrong + 1
         if (blocks%count_in(e) == 0) then
            if (any([blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)] /= [1, 0, 1])) wrong = wrong + 1
            cycle
         end if
         n_occupied = n_occupied + 1
         if (blocks%occupied(n_occupied) /= e) wrong = wrong + 1
      end do
      call check(wrong == 0, 'the particles of a cell stand in it and are counted, and the occupied cells are listed')
      call check(n_occupied == blocks%n_occupied, 'no other cell is listed')
      call check(all(visits == 1), 'the cells share all particles')
   end subroutine check_cells

   subroutine gone_astray()
      type(particles_t) :: p
      call scatter(p)
      p%displacement(42, :) = [1.5_dp, 0.25_dp] - p%reference(42, :)
      call sort_into_cells(sorted, p, grid, blocks, failure)
      call check(failure%code == exit_computation, 'a particle that left the grid is a failure of the computation')
      call check(index(failure%message, 'particle 42 left the grid at (1.5, 0.25) m') > 0, 'that names particle and place')
      call check(index(failure%message, '&grid') > 0, 'and says what to do')

      failure = failure_t()
      call scatter(p)
      p%displacement(7, 2) = ieee_value(1.0_dp, ieee_quiet_nan)
      call ieee_set_halting_mode(ieee_invalid, .false.)
      call sort_into_cells(sorted, p, grid, blocks, failure)
      call ieee_set_flag(ieee_invalid, .false.)
      call check(failure%code == exit_computation, 'a position that is not a number is a failure of the computation')
      call check(index(failure%message, 'particle 7 is no longer a number') > 0, 'that names the particle')
   end subroutine gone_astray
end program test_particles
