!> What the passes do with a batch of blocks, against the shape functions and their gradients, at random points of each cell.
program test_particle_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_cell_blocks, only: of_mass, of_momentum, of_force, n_sums, lanes
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_particle_kernels, only: most_rows, n_across, clear, take_corners, add_field, add_gradient, add_mass, add_momentum, &
                                     add_matrix, add_stress, divergence
   implicit none

   integer, parameter :: runs = 200, blocks = 3, rows = 3, cells = lanes*blocks, places = lanes*most_rows, used = cells*rows
   real(dp), parameter :: rounding = 20*rows*epsilon(1.0_dp)
   integer, parameter :: points = 40
   logical, parameter :: in_row(blocks) = [.false., .true., .false.]
   real(dp) :: xi(places, ndim), field(ndim, points), of_corners(lanes, corners, ndim, blocks)
   integer :: nodes(corners, cells), k

   call repeat_random_numbers()
   nodes(:, :4) = reshape([5, 9, 1, 13, 2, 6, 14, 10, 3, 11, 7, 15, 16, 12, 8, 4], [corners, lanes])
   nodes(:, 5:8) = reshape([20, 21, 30, 31, 21, 22, 31, 32, 22, 23, 32, 33, 23, 24, 33, 34], [corners, lanes])
   nodes(:, 9:) = points + 1 - nodes(:, :4)
   do k = 1, 2
      call fields_at_particles(merge(1.0_dp, 0.37_dp, k == 1))
   end do
   call contributions_to_corners()
   call divergence_of_stress()
   call clearing()
   call finish()

contains

   !> The cell of a place, and its lane and block.
   pure integer function cell_of(place)
      integer, intent(in) :: place
      cell_of = lanes*((place - 1)/(lanes*rows)) + mod(place - 1, lanes) + 1
   end function cell_of
   pure integer function lane_of(cell)
      integer, intent(in) :: cell
      lane_of = mod(cell - 1, lanes) + 1
   end function lane_of
   pure integer function block_of(cell)
      integer, intent(in) :: cell
      block_of = (cell - 1)/lanes + 1
   end function block_of

   !> Where a particle stands in its cell.
   pure function local(i)
      integer, intent(in) :: i
      real(dp) :: local(ndim)
      local = xi(i, :)
   end function local

   !> What is interpolated from the nodes, and its gradient.
   subroutine fields_at_particles(factor)
      real(dp), intent(in) :: factor
      real(dp) :: v(places, ndim), h(places, ndim, ndim), g(places, ndim, ndim), before(places, ndim, ndim), l(ndim, ndim), error(3)
      real(dp) :: factors(lanes, blocks)
      integer :: n, i
      error = 0
      factors = factor
      do n = 1, runs
         call random_number(xi)
         call random_number(field)
         call take_corners(blocks, factors, field, nodes, in_row, of_corners)
         v = 2
         h = 3
         call add_field(blocks, rows, places, xi, of_corners, v)
         call add_gradient(blocks, rows, places, .false., xi, of_corners, h)
         call random_number(before)
         g = before
         call add_gradient(blocks, rows, places, .true., xi, of_corners, g)
         do i = 1, used
            associate (at_corner => factor*field(:, nodes(:, cell_of(i))))
               error(1) = max(error(1), maxval(abs(v(i, :) - 2 - matmul(at_corner, shape_functions(local(i))))))
               l = matmul(at_corner, shape_gradients(local(i), 1.0_dp))
               error(2) = max(error(2), maxval(abs(h(i, :, :) - 3 - l)))
               error(3) = max(error(3), maxval(abs(g(i, :, :) - before(i, :, :) - l - matmul(l, before(i, :, :)))))
            end associate
         end do
      end do
      call check_close(error(1), 0.0_dp, rounding, 'add_field sums the corners by the shape functions')
      call check_close(error(2), 0.0_dp, rounding, 'add_gradient sums the corners by the gradients')
      call check_close(error(3), 0.0_dp, rounding, 'add_gradient adds L (I + H)')
      call check_close(maxval(abs(v(used + 1:, :) - 2)), 0.0_dp, 0.0_dp, 'no other rows are touched')
   end subroutine fields_at_particles

   !> Masses, momenta and mass matrices.
   subroutine contributions_to_corners()
      real(dp) :: mass(places), v(places, ndim), sums(lanes, corners, n_sums, blocks), matrix(lanes, corners, corners)
      real(dp) :: masses(corners, cells), momenta(corners, ndim, cells), matrices(corners, corners, cells), error(3)
      real(dp) :: shape(corners)
      integer :: n, i, d, c, l
      error = 0
      do n = 1, runs
         call random_number(xi)
         call random_number(mass)
         call random_number(v)
         sums(:, :, of_mass, :) = 1
         sums(:, :, of_momentum:of_momentum + ndim - 1, :) = 2
         matrix = 3
         masses = 1
         momenta = 2
         matrices = 3
         call add_mass(blocks, rows, places, xi, mass, sums)
         call add_momentum(blocks, rows, places, xi, mass, v, sums)
         call add_matrix(rows, places, xi, mass, matrix)
         do i = 1, used
            c = cell_of(i)
            shape = shape_functions(local(i))
            masses(:, c) = masses(:, c) + mass(i)*shape
            do d = 1, ndim
               momenta(:, d, c) = momenta(:, d, c) + mass(i)*v(i, d)*shape
            end do
            do d = 1, corners
               matrices(:, d, c) = matrices(:, d, c) + mass(i)*shape(d)*shape
            end do
         end do
         do c = 1, cells
            associate (of_cell => sums(lane_of(c), :, :, block_of(c)))
               error(1) = max(error(1), maxval(abs(of_cell(:, of_mass) - masses(:, c))))
               error(2) = max(error(2), maxval(abs(of_cell(:, of_momentum:of_momentum + ndim - 1) - momenta(:, :, c))))
            end associate
         end do
         do l = 1, lanes
            error(3) = max(error(3), maxval(abs(matrix(l, :, :) - matrices(:, :, l))))
         end do
      end do
      call check_close(error(1), 0.0_dp, rounding, 'add_mass adds the masses times the shape functions')
      call check_close(error(2), 0.0_dp, rounding, 'add_momentum adds the momenta times the shape functions')
      call check_close(error(3), 0.0_dp, rounding, 'add_matrix adds the masses times two shape functions')
   end subroutine contributions_to_corners

   !> Internal forces, the gradients being those in cells of a size.
   subroutine divergence_of_stress()
      real(dp) :: t(lanes, ndim*ndim, rows, blocks), moments(lanes, ndim*ndim, n_across, blocks)
      real(dp) :: contribution(lanes, corners, n_sums, blocks), expected(ndim, corners, cells), inverse_size(lanes, blocks), error
      integer :: n, i, c, row
      error = 0
      do n = 1, runs
         call random_number(xi)
         call random_number(t)
         call random_number(inverse_size)
         moments = 0
         expected = 0
         call add_stress(blocks, rows, places, xi, t, moments)
         call divergence(blocks, inverse_size, moments, contribution)
         do i = 1, used
            c = cell_of(i)
            row = mod((i - 1)/lanes, rows) + 1
            expected(:, :, c) = expected(:, :, c) &
                                - matmul(reshape(t(lane_of(c), :, row, block_of(c)), [ndim, ndim]), &
                                         transpose(shape_gradients(local(i), inverse_size(lane_of(c), block_of(c)))))
         end do
         do c = 1, cells
            associate (force => contribution(lane_of(c), :, of_force:of_force + ndim - 1, block_of(c)))
               error = max(error, maxval(abs(force - transpose(expected(:, :, c)))))
            end associate
         end do
      end do
      call check_close(error, 0.0_dp, rounding, 'divergence gives minus the stress times the gradients')
   end subroutine divergence_of_stress

   !> Some sums of each block, and no others.
   subroutine clearing()
      real(dp) :: sums(lanes, 5, blocks)
      sums = 1
      call clear(blocks, 3, 5, spread(0.0_dp, 1, lanes), sums)
      call check(all(abs(sums(:, :3, :)) <= 0) .and. all(abs(sums(:, 4:, :) - 1) <= 0), 'clear touches what it is asked to')
   end subroutine clearing
end program test_particle_kernels
