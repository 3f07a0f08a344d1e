!> The bilinear shape functions hold what convergence and conservation rest on, at random points of a cell.
program test_basis
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients, interpolate_gradient, inside_cell, edge_margin
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   implicit none

   integer, parameter :: points = 2000
   real(dp), parameter :: rounding = 20*epsilon(1.0_dp)
   real(dp), parameter :: size_of_cell = 0.37_dp

   call repeat_random_numbers()
   call sums_of_functions()
   call values_at_corners()
   call linear_fields()
   call finite_differences()
   call agreement_of_gradients()
   call margin_at_edges()
   call finish()

contains

   !> Place of a corner in local coordinates.
   pure function corner_place(c) result(xi)
      integer, intent(in) :: c
      real(dp) :: xi(ndim)
      xi = real([ibits(c - 1, 0, 1), ibits(c - 1, 1, 1)], dp)
   end function corner_place

   subroutine sums_of_functions()
      real(dp) :: xi(ndim), of_functions, of_gradients, least
      integer :: k
      of_functions = 0
      of_gradients = 0
      least = 1
      do k = 1, points
         call random_number(xi)
         of_functions = max(of_functions, abs(sum(shape_functions(xi)) - 1))
         of_gradients = max(of_gradients, maxval(abs(sum(shape_gradients(xi, 1.0_dp), dim=1))))
         least = min(least, minval(shape_functions(xi)))
      end do
      call check_close(of_functions, 0.0_dp, rounding, 'shape functions sum to one')
      call check_close(of_gradients, 0.0_dp, rounding, 'their gradients sum to zero')
      call check(least >= 0, 'shape functions are not negative inside the cell')
   end subroutine sums_of_functions

   subroutine values_at_corners()
      real(dp) :: expected(corners)
      integer :: c
      do c = 1, corners
         expected = 0
         expected(c) = 1
         call check_close(maxval(abs(shape_functions(corner_place(c)) - expected)), 0.0_dp, 0.0_dp, &
                          'at a corner its own function is one and the others zero')
      end do
   end subroutine values_at_corners

   subroutine linear_fields()
      real(dp) :: xi(ndim), value(ndim), slope(ndim, ndim), field(ndim, corners), gradient(corners, ndim), error(3)
      integer :: k, c
      error = 0
      do k = 1, points
         call random_number(xi)
         call random_number(value)
         call random_number(slope)
         do c = 1, corners
            field(:, c) = value + matmul(slope, size_of_cell*corner_place(c))
         end do
         gradient = shape_gradients(xi, 1/size_of_cell)
         error(1) = max(error(1), maxval(abs(matmul(field, shape_functions(xi)) - value - matmul(slope, size_of_cell*xi))))
         error(2) = max(error(2), maxval(abs(interpolate_gradient(xi, field)/size_of_cell - slope)))
         error(3) = max(error(3), maxval(abs(matmul(field, gradient) - slope)))
      end do
      call check_close(error(1), 0.0_dp, rounding, 'a linear field is interpolated exactly')
      call check_close(error(2), 0.0_dp, rounding, 'the gradient of a linear field is exact')
      call check_close(error(3), 0.0_dp, 2*rounding, 'so is the one from the gradients of the shape functions')
   end subroutine linear_fields

   !> Central differences of a bilinear function have no truncation error.
   subroutine finite_differences()
      real(dp), parameter :: h = 0.01_dp
      real(dp) :: xi(ndim), shift(ndim), gradient(corners, ndim), error
      integer :: k, d
      error = 0
      do k = 1, points
         call random_number(xi)
         gradient = shape_gradients(xi, 1.0_dp)
         do d = 1, ndim
            shift = 0
            shift(d) = h
            error = max(error, maxval(abs((shape_functions(xi + shift) - shape_functions(xi - shift))/(2*h) - gradient(:, d))))
         end do
      end do
      call check_close(error, 0.0_dp, rounding/h, 'gradients are the differences of the functions')
   end subroutine finite_differences

   subroutine agreement_of_gradients()
      real(dp) :: xi(ndim), field(ndim, corners), error
      integer :: k
      error = 0
      do k = 1, points
         call random_number(xi)
         call random_number(field)
         error = max(error, maxval(abs(interpolate_gradient(xi, field) - matmul(field, shape_gradients(xi, 1.0_dp)))))
      end do
      call check_close(error, 0.0_dp, rounding, 'interpolate_gradient sums the corners by the gradients')
   end subroutine agreement_of_gradients

   subroutine margin_at_edges()
      real(dp) :: xi(ndim)
      call random_number(xi)
      call check_close(maxval(abs(inside_cell(xi) - xi)), 0.0_dp, 0.0_dp, 'a particle inside the cell stays where it is')
      call check(all(shape_functions(inside_cell([0.0_dp, 1.0_dp])) > 0), &
                 'a particle on the edge of its cell gives mass to every corner')
      call check_close(maxval(abs(inside_cell([-1.0e-9_dp, 1.0_dp]) - [0.0_dp, 1.0_dp])), 0.0_dp, 2*edge_margin, &
                       'and is moved by rounding only')
   end subroutine margin_at_edges
end program test_basis
