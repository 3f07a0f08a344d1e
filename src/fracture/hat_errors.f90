!> What a sequence of means over hat functions along a front tells of its own errors, of solids only.
module hampm_hat_errors
   use hampm_kinds, only: dp
   implicit none
   private
   public :: ends_t, lost_in_hats, scatter_along

   !> How a sequence goes on beyond its ends.
   type :: ends_t
      logical :: is_closed = .false.             !! whether the last value is followed by the first
      logical :: is_mirror(2) = .false.          !! whether the first and the last value are at planes of symmetry
      logical :: is_odd(2) = .false.             !! whether the mirror image there has the other sign
   end type ends_t

   integer, parameter :: reach = 2               !! values to each side that are needed

contains

   !> What the mean over a hat function differs by from the value in its middle: a twelfth of the second difference, as the square
   !> of the distance has a mean of a sixth. Beside a free end that of the next hat.
   pure function lost_in_hats(values, ends) result(lost)
      real(dp), intent(in) :: values(:)
      type(ends_t), intent(in) :: ends
      real(dp) :: lost(size(values)), v(1 - reach:size(values) + reach)
      integer :: i
      lost = 0
      if (size(values) < 2*reach) return
      v = continued(values, ends)
      do i = 1, size(values)
         associate (j => within(i, 1, size(values), ends))
            lost(i) = abs(v(j - 1) - 2*v(j) + v(j + 1))/12
         end associate
      end do
   end function lost_in_hats

   !> By what values scatter about a smooth curve, twice their standard deviation: that of fourth differences is sqrt(70) times that
   !> of values independent of each other. From three places, beside a free end from those that have a difference.
   pure function scatter_along(values, ends) result(scatter)
      real(dp), intent(in) :: values(:)
      type(ends_t), intent(in) :: ends
      real(dp) :: scatter(size(values)), v(1 - reach:size(values) + reach), square(size(values))
      real(dp), parameter :: of_differences = 70
      integer :: i, n
      scatter = 0
      n = size(values)
      if (n < 2*reach + 1) return
      v = continued(values, ends)
      do i = 1, n
         associate (j => within(i, reach, n, ends))
            square(i) = (v(j - 2) - 4*v(j - 1) + 6*v(j) - 4*v(j + 1) + v(j + 2))**2
         end associate
      end do
      do i = 1, n
         associate (before => merge(modulo(i - 2, n) + 1, max(i - 1, 1), ends%is_closed), &
                    behind => merge(modulo(i, n) + 1, min(i + 1, n), ends%is_closed))
            scatter(i) = 2*sqrt((square(before) + square(i) + square(behind))/(3*of_differences))
         end associate
      end do
   end function scatter_along

   !> The next place with so many values to each side.
   pure integer function within(i, sides, n, ends) result(j)
      integer, intent(in) :: i, sides, n
      type(ends_t), intent(in) :: ends
      j = i
      if (ends%is_closed) return
      if (.not. ends%is_mirror(1)) j = max(j, 1 + sides)
      if (.not. ends%is_mirror(2)) j = min(j, n - sides)
   end function within

   !> The sequence with what follows beyond its ends; 0 beyond free ones.
   pure function continued(values, ends) result(v)
      real(dp), intent(in) :: values(:)
      type(ends_t), intent(in) :: ends
      real(dp) :: v(1 - reach:size(values) + reach)
      integer :: k, n
      n = size(values)
      v = 0
      v(1:n) = values
      do k = 1, reach
         if (ends%is_closed) then
            v(1 - k) = values(n + 1 - k)
            v(n + k) = values(k)
         else
            if (ends%is_mirror(1)) v(1 - k) = merge(-1, 1, ends%is_odd(1))*values(1 + k)
            if (ends%is_mirror(2)) v(n + k) = merge(-1, 1, ends%is_odd(2))*values(n - k)
         end if
      end do
   end function continued
end module hampm_hat_errors
