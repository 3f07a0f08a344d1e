!> Small tensors: of the dimension of the model, and of three-dimensional space, for material laws.
module hampm_tensors
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: identity, trace, determinant, inverse_transpose, product_of, n_voigt, voigt, name_of_component, quarter_turn, in_plane
   public :: space, unit_tensor, trace_of, symmetric, deviator, volume_change, determinant_of, inverse_transpose_of, cofactors, &
             change_of_cofactors
   public :: n_symmetric, n_deviator, components_of, tensor_of, deviator_of, in_space, norm, edge_of

   integer, parameter :: space = 3               !! dimensions of space
   real(dp), parameter :: unit_tensor(space, space) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [space, space])
   real(dp), parameter :: identity(ndim, ndim) = unit_tensor(:ndim, :ndim)
   integer, parameter :: n_voigt = ndim*(ndim + 1)/2 !! components of a symmetric tensor of the model: normal ones, then 12, 13, 23
   integer, parameter :: both(13) = [1, 3, 3, 2, 1, 4, 5, 4, 2, 6, 5, 6, 3]
   integer, parameter :: voigt(ndim, ndim) = reshape(both(4*ndim - 7:), [ndim, ndim]) !! number of each component
   integer, parameter :: n_symmetric = 2*ndim    !! components of a symmetric tensor that are not zero by the dimension of the model
   integer, parameter :: n_deviator = n_symmetric - 1 !! components of a deviator: the last follows from the trace
   integer, parameter :: row(6) = [1, 2, 1, merge(3, 1, ndim == 2), 2, 3], column(6) = [1, 2, 2, 3, 3, 3] !! of components

   interface norm
      module procedure norm_of_vector, norm_of_tensor
   end interface norm

contains

   !> Length of a vector. The last digits of the intrinsic `norm2` depend on the units: it scales by components from 1 on.
   pure real(dp) function norm_of_vector(x) result(norm)
      real(dp), intent(in) :: x(:)
      norm = sqrt(sum(x**2))
   end function norm_of_vector

   !> The same of the components of a tensor.
   pure real(dp) function norm_of_tensor(x) result(norm)
      real(dp), intent(in) :: x(:, :)
      norm = sqrt(sum(x**2))
   end function norm_of_tensor

   !> Edge of a square with an area, of a cube with a volume [m], whose digits are the same in units of powers of two.
   pure elemental real(dp) function edge_of(size) result(edge)
      real(dp), intent(in) :: size               !! area [m2] or volume [m3]
      integer :: powers
      powers = (exponent(size) - modulo(exponent(size), ndim))/ndim
      edge = scale(scale(size, -ndim*powers)**(1.0_dp/ndim), powers)
   end function edge_of

   !> Trace of a second-order tensor.
   pure real(dp) function trace(f)
      real(dp), intent(in) :: f(ndim, ndim)
      integer :: i
      trace = 0
      do i = 1, ndim
         trace = trace + f(i, i)
      end do
   end function trace

   !> A vector turned to the left by a quarter of a turn, in the plane of the first two directions.
   pure function quarter_turn(v) result(left)
      real(dp), intent(in) :: v(ndim)
      real(dp) :: left(ndim)
      left = in_plane(-v(2), v(1))
   end function quarter_turn

   !> The vector with two components, in the plane of the first two directions.
   pure function in_plane(x, y) result(v)
      real(dp), intent(in) :: x, y
      real(dp) :: v(ndim)
      v = 0
      v(1) = x
      v(2) = y
   end function in_plane

   !> Name of a component of a symmetric tensor of the model, by its number in `voigt`.
   pure function name_of_component(k) result(name)
      integer, intent(in) :: k
      character(2) :: name
      character(2), parameter :: names(6) = ['xx', 'yy', 'zz', 'xy', 'xz', 'yz']
      name = names(merge(k, k + space - ndim, k <= ndim))
   end function name_of_component

   !> Determinant of a second-order tensor.
   pure real(dp) function determinant(f)
      real(dp), intent(in) :: f(ndim, ndim)
      if (ndim == 2) then
         determinant = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
      else
         determinant = determinant_of(in_space(f))
      end if
   end function determinant

   !> Product of two second-order tensors.
   pure function product_of(a, b) result(c)
      real(dp), intent(in) :: a(ndim, ndim), b(ndim, ndim)
      real(dp) :: c(ndim, ndim)
      integer :: j, k
      do j = 1, ndim
         c(:, j) = a(:, 1)*b(1, j)
         do k = 2, ndim
            c(:, j) = c(:, j) + a(:, k)*b(k, j)
         end do
      end do
   end function product_of

   !> Transposed inverse of a second-order tensor whose determinant is not zero.
   pure function inverse_transpose(f) result(g)
      real(dp), intent(in) :: f(ndim, ndim)
      real(dp) :: g(ndim, ndim)
      real(dp) :: of_space(space, space)
      if (ndim == 2) then
         g(1, 1) = f(2, 2)
         g(2, 1) = -f(1, 2)
         g(1, 2) = -f(2, 1)
         g(2, 2) = f(1, 1)
         g = g/determinant(f)
      else
         of_space = inverse_transpose_of(in_space(f))
         g = of_space(:ndim, :ndim)
      end if
   end function inverse_transpose

   !> A tensor of the dimension of the model as one of space, with 1 where it has nothing.
   pure function in_space(f)
      real(dp), intent(in) :: f(ndim, ndim)
      real(dp) :: in_space(space, space)
      in_space = unit_tensor
      in_space(:ndim, :ndim) = f
   end function in_space

   !> Trace of a tensor of space.
   pure real(dp) function trace_of(t)
      real(dp), intent(in) :: t(space, space)
      trace_of = t(1, 1) + t(2, 2) + t(3, 3)
   end function trace_of

   !> Symmetric part of a tensor of space.
   pure function symmetric(t)
      real(dp), intent(in) :: t(space, space)
      real(dp) :: symmetric(space, space)
      symmetric = (t + transpose(t))/2
   end function symmetric

   !> A tensor of space less its mean normal component.
   pure function deviator(t)
      real(dp), intent(in) :: t(space, space)
      real(dp) :: deviator(space, space)
      deviator = t - trace_of(t)/3*unit_tensor
   end function deviator

   !> det(I + H) - 1, with all digits of a small H.
   pure real(dp) function volume_change(h)
      real(dp), intent(in) :: h(space, space)
      volume_change = trace_of(h) + second_invariant(h) + determinant_of(h)
   end function volume_change

   !> Determinant of a tensor of space.
   pure real(dp) function determinant_of(h)
      real(dp), intent(in) :: h(space, space)
      determinant_of = sum(h(:, 1)*cofactors_of_first(h))
   end function determinant_of

   !> Second invariant of a tensor of space.
   pure real(dp) function second_invariant(h)
      real(dp), intent(in) :: h(space, space)
      second_invariant = h(1, 1)*h(2, 2) - h(1, 2)*h(2, 1) + h(2, 2)*h(3, 3) - h(2, 3)*h(3, 2) + h(3, 3)*h(1, 1) - h(3, 1)*h(1, 3)
   end function second_invariant

   !> Cofactors of the first column of a tensor of space.
   pure function cofactors_of_first(f) result(c)
      real(dp), intent(in) :: f(space, space)
      real(dp) :: c(space)
      c = [f(2, 2)*f(3, 3) - f(2, 3)*f(3, 2), f(3, 2)*f(1, 3) - f(1, 2)*f(3, 3), f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3)]
   end function cofactors_of_first

   !> Transposed inverse of a tensor of space whose determinant is not zero.
   pure function inverse_transpose_of(f) result(g)
      real(dp), intent(in) :: f(space, space)
      real(dp) :: g(space, space)
      g = cofactors(f)/determinant_of(f)
   end function inverse_transpose_of

   !> Cofactors of a tensor of space.
   pure function cofactors(f) result(g)
      real(dp), intent(in) :: f(space, space)
      real(dp) :: g(space, space)
      g(:, 1) = cofactors_of_first(f)
      g(:, 2) = cofactors_of_first(f(:, [2, 3, 1]))
      g(:, 3) = cofactors_of_first(f(:, [3, 1, 2]))
   end function cofactors

   !> Change of the cofactors of F by dF, to the first order, for dF of any size.
   pure function change_of_cofactors(f, df) result(g)
      real(dp), intent(in) :: f(space, space), df(space, space)
      real(dp) :: g(space, space)
      g = at(f, 1, 1)*at(df, 2, 2) + at(df, 1, 1)*at(f, 2, 2) - at(f, 1, 2)*at(df, 2, 1) - at(df, 1, 2)*at(f, 2, 1)

   contains

      !> The components so many rows and columns further.
      pure function at(t, rows, columns) result(moved)
         real(dp), intent(in) :: t(space, space)
         integer, intent(in) :: rows, columns
         real(dp) :: moved(space, space)
         moved = cshift(cshift(t, rows, 1), columns, 2)
      end function at
   end function change_of_cofactors

   !> Components of a deviator of space but the last, 33: 11, 22, 12 and, in solids, 13 and 23.
   pure function components_of(t) result(c)
      real(dp), intent(in) :: t(space, space)
      real(dp) :: c(n_deviator)
      integer :: k
      c = [(t(row(k), column(k)), k=1, n_deviator)]
   end function components_of

   !> The symmetric tensor of space of such components and 33 at last.
   pure function tensor_of(c) result(t)
      real(dp), intent(in) :: c(n_symmetric)
      real(dp) :: t(space, space)
      integer :: k
      t = 0
      do k = 1, n_symmetric
         t(row(k), column(k)) = c(k)
         t(column(k), row(k)) = c(k)
      end do
   end function tensor_of

   !> The deviator of its components but the last.
   pure function deviator_of(c) result(t)
      real(dp), intent(in) :: c(n_deviator)
      real(dp) :: t(space, space)
      t = tensor_of([c, -(c(1) + c(2))])
   end function deviator_of
end module hampm_tensors
