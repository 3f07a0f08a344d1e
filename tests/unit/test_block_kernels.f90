!> What the sweeps do with a block of cells, against the shape functions and their gradients, at random points of each cell.
program test_block_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_block_kernels, only: most_rows, take_corners, add_field, add_gradient, add_gradient_product, add_mass, add_momentum, &
                                  add_matrix, add_stress, divergence
   use hampm_harness, only: check_close, finish, repeat_random_numbers
   use hampm_particles, only: lanes
   implicit none

   integer, parameter :: blocks = 500, rows = 3, places = lanes*most_rows
   real(dp), parameter :: rounding = 20*rows*epsilon(1.0_dp)
   real(dp) :: xi(places, ndim), field(ndim, corners*lanes), of_corners(lanes, corners, ndim)
   integer, parameter :: nodes(corners, lanes) = reshape([5, 9, 1, 13, 2, 6, 14, 10, 3, 11, 7, 15, 16, 12, 8, 4], [corners, lanes])
   integer :: k

   call repeat_random_numbers()
   do k = 1, 2
      call fields_at_particles(merge(1.0_dp, 0.37_dp, k == 1))
   end do
   call shares_of_corners()
   call divergence_of_stress()
   call finish()

contains

   !> The lane of a place.
   pure integer function lane_of(place)
      integer, intent(in) :: place
      lane_of = mod(place - 1, lanes) + 1
   end function lane_of

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
      integer :: n, i
      error = 0
      do n = 1, blocks
         call random_number(xi)
         call random_number(field)
         call take_corners(spread(factor, 1, lanes), field, nodes, of_corners)
         v = 2
         h = 3
         call add_field(rows, places, xi, of_corners, v)
         call add_gradient(rows, places, xi, of_corners, h)
         call random_number(before)
         g = before
         call add_gradient_product(rows, places, xi, of_corners, g)
         do i = 1, lanes*rows
            associate (at_corner => factor*field(:, nodes(:, lane_of(i))))
               error(1) = max(error(1), maxval(abs(v(i, :) - 2 - matmul(at_corner, shape_functions(local(i))))))
               l = matmul(at_corner, shape_gradients(local(i), 1.0_dp))
               error(2) = max(error(2), maxval(abs(h(i, :, :) - 3 - l)))
               error(3) = max(error(3), maxval(abs(g(i, :, :) - before(i, :, :) - l - matmul(l, before(i, :, :)))))
            end associate
         end do
      end do
      call check_close(error(1), 0.0_dp, rounding, 'add_field sums the corners by the shape functions')
      call check_close(error(2), 0.0_dp, rounding, 'add_gradient sums the corners by the gradients')
      call check_close(error(3), 0.0_dp, rounding, 'add_gradient_product adds L (I + H)')
      call check_close(maxval(abs(v(lanes*rows + 1:, :) - 2)), 0.0_dp, 0.0_dp, 'no other rows are touched')
   end subroutine fields_at_particles

   !> Masses, momenta and mass matrices.
   subroutine shares_of_corners()
      real(dp) :: mass(places), v(places, ndim), m(lanes, corners), p(lanes, corners, ndim), matrix(corners, corners, lanes)
      real(dp) :: of_mass(corners, lanes), of_momentum(corners, ndim, lanes), of_matrix(corners, corners, lanes), error(3)
      real(dp) :: shape(corners)
      integer :: n, i, d, l
      error = 0
      do n = 1, blocks
         call random_number(xi)
         call random_number(mass)
         call random_number(v)
         m = 1
         p = 2
         matrix = 0
         of_mass = 1
         of_momentum = 2
         of_matrix = 0
         call add_mass(rows, places, xi, mass, m)
         call add_momentum(rows, places, xi, mass, v, p)
         call add_matrix(rows, places, xi, mass, [2, 0, 1, 4], matrix)
         do i = 1, lanes*rows
            l = lane_of(i)
            shape = shape_functions(local(i))
            of_mass(:, l) = of_mass(:, l) + mass(i)*shape
            do d = 1, ndim
               of_momentum(:, d, l) = of_momentum(:, d, l) + mass(i)*v(i, d)*shape
            end do
            do d = 1, corners
               of_matrix(:, d, l) = of_matrix(:, d, l) + mass(i)*shape(d)*shape
            end do
         end do
         error(1) = max(error(1), maxval(abs(m - transpose(of_mass))))
         do l = 1, lanes
            error(2) = max(error(2), maxval(abs(p(l, :, :) - of_momentum(:, :, l))))
         end do
         error(3) = max(error(3), maxval(abs(matrix(:, :, [2, 1, 4]) - of_matrix(:, :, [1, 3, 4]))), maxval(abs(matrix(:, :, 3))))
      end do
      call check_close(error(1), 0.0_dp, rounding, 'add_mass adds the masses times the shape functions')
      call check_close(error(2), 0.0_dp, rounding, 'add_momentum adds the momenta times the shape functions')
      call check_close(error(3), 0.0_dp, rounding, 'add_matrix adds the masses times two shape functions')
   end subroutine shares_of_corners

   !> Internal forces, the gradients being those in cells of a size.
   subroutine divergence_of_stress()
      real(dp) :: t(lanes, ndim*ndim, most_rows), total(lanes, ndim*ndim), moment(lanes, ndim*ndim), force(lanes, corners, ndim)
      real(dp) :: expected(ndim, corners, lanes), inverse_size(lanes), error
      integer :: n, i, l
      error = 0
      do n = 1, blocks
         call random_number(xi)
         call random_number(t)
         call random_number(inverse_size)
         total = 0
         moment = 0
         expected = 0
         call add_stress(rows, places, xi, t, total, moment)
         call divergence(inverse_size, total, moment, force)
         do i = 1, lanes*rows
            l = lane_of(i)
            expected(:, :, l) = expected(:, :, l) - matmul(reshape(t(l, :, (i - 1)/lanes + 1), [ndim, ndim]), &
                                                           transpose(shape_gradients(local(i), inverse_size(l))))
         end do
         do l = 1, lanes
            error = max(error, maxval(abs(force(l, :, :) - transpose(expected(:, :, l)))))
         end do
      end do
      call check_close(error, 0.0_dp, rounding, 'divergence gives minus the stress times the gradients')
   end subroutine divergence_of_stress
end program test_block_kernels
