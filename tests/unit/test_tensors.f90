!> The small tensors obey the rules of algebra.
program test_tensors
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: identity, trace, determinant, inverse_transpose, product_of, edge_of
   use hampm_harness, only: check_close, finish, repeat_random_numbers
   implicit none

   real(dp), parameter :: rounding = 50*epsilon(1.0_dp)
   real(dp) :: a(ndim, ndim), b(ndim, ndim), inverse(ndim, ndim), error(6), size
   integer :: k

   call repeat_random_numbers()
   error = 0
   do k = 1, 500
      call random_number(a)
      call random_number(b)
      a = a + identity
      error(1) = max(error(1), abs(trace(product_of(a, b)) - trace(product_of(b, a))))
      error(2) = max(error(2), maxval(abs(product_of(a, b) - matmul(a, b))))
      error(3) = max(error(3), abs(determinant(product_of(a, b)) - determinant(a)*determinant(b)))
      inverse = transpose(inverse_transpose(a))
      error(4) = max(error(4), maxval(abs(product_of(a, inverse) - identity))*abs(determinant(a)))
      error(5) = max(error(5), maxval(abs(product_of(a, identity) - a)))
      error(6) = max(error(6), abs(edge_of(a(1, 1)**ndim)/a(1, 1) - 1))
   end do
   call check_close(error(1), 0.0_dp, rounding, 'tr(A B) = tr(B A)')
   call check_close(error(2), 0.0_dp, rounding, 'product_of is the matrix product')
   call check_close(error(3), 0.0_dp, rounding, 'det(A B) = det A det B')
   call check_close(error(4), 0.0_dp, rounding, 'A A^-1 = I')
   call check_close(error(5), 0.0_dp, 0.0_dp, 'A I = A')
   call check_close(error(6), 0.0_dp, rounding, 'the edge of a square or cube has its size')
   size = 0.3_dp
   call check_close(maxval(abs(edge_of([(scale(size, k*ndim), k=-5, 5)]) - edge_of(size)*[(2.0_dp**k, k=-5, 5)])), 0.0_dp, 0.0_dp, &
                    'its digits are the same in units of powers of two')
   call finish()
end program test_tensors
