!> The factor of a sparse symmetric positive definite matrix, A = P^T L D L^T P, stored for many solutions: L by columns in the
!> order of elimination, in panels of four, a vector at each row that one of them has, without entries below rounding. The inverse
!> of a mass matrix decays from node to node, and so does its factor: a quarter to two thirds of its entries are below.
module hampm_sparse_factor
   use hampm_kinds, only: dp
   implicit none
   private
   public :: sparse_factor_t

   integer, parameter :: lanes = 4               !! columns of a panel

   !> Part of the diagonal, in the scale of the row, up to which an entry is left out: rounding errors of the factor are larger
   !> (Higham 2002, theorem 10.3).
   real(dp), parameter :: negligible = epsilon(1.0_dp)/16

   !> L without its diagonal, which is 1, and D. The last panel is filled up with columns of the unit matrix.
   type :: sparse_factor_t
      private
      integer, allocatable :: unknown(:)         !! of each column, (n)
      integer, allocatable :: first(:)           !! first entry of each panel in the next two, (panels + 1)
      integer, allocatable :: row(:)             !! row of each entry, behind the panel
      real(dp), allocatable :: value(:, :)       !! (lanes, entries)
      real(dp), allocatable :: block(:, :, :)    !! L between the columns of a panel, (lanes, lanes, panels)
      real(dp), allocatable :: inverse(:, :)     !! D^-1, (lanes, panels)
      integer, allocatable :: last(:)            !! columns of unknowns that are eliminated behind all others
      real(dp), allocatable :: y(:)              !! workspace
   contains
      procedure :: take
      procedure :: solve
   end type sparse_factor_t

contains

   !> Take a factor of Cholesky, the diagonal first in each column.
   pure subroutine take(self, unknown, first, row, value, is_last)
      class(sparse_factor_t), intent(inout) :: self
      integer, intent(in) :: unknown(:)          !! of each column, (n)
      integer, intent(in) :: first(:)            !! first entry of each column in the next two, (n + 1)
      integer, intent(in) :: row(:)
      real(dp), intent(in) :: value(:)
      logical, intent(in) :: is_last(:)          !! unknowns whose columns change only columns of such unknowns, (n)
      real(dp) :: least(size(unknown))           ! that counts, by row
      integer :: place(size(unknown)), list(size(row)), p, j, k, entries ! entry of each row in a panel, and row of each entry
      logical :: counts(size(row))
      least = 0
      do k = 1, size(row)
         least(row(k)) = least(row(k)) + value(k)**2
      end do
      least = negligible*sqrt(least)
      counts = abs(value) > least(row)
      self%unknown = unknown
      self%last = pack([(j, j=1, size(unknown))], is_last(unknown))
      associate (n => size(unknown), panels => (size(unknown) - 1)/lanes + 1)
         if (allocated(self%first)) deallocate (self%first, self%value, self%block, self%inverse)
         allocate (self%first(panels + 1), self%value(lanes, count(counts)))
         allocate (self%block(lanes, lanes, panels), source=0.0_dp)
         allocate (self%inverse(lanes, panels), source=1.0_dp)
         place = 0
         entries = 0
         do p = 1, panels
            self%first(p) = entries + 1
            associate (before => lanes*(p - 1))
               do j = before + 1, min(before + lanes, n)
                  self%inverse(j - before, p) = 1/value(first(j))**2
                  do k = first(j) + 1, first(j + 1) - 1
                     if (.not. counts(k)) cycle
                     if (row(k) <= before + lanes) then
                        self%block(row(k) - before, j - before, p) = value(k)/value(first(j))
                        cycle
                     end if
                     if (place(row(k)) < self%first(p)) then
                        entries = entries + 1
                        place(row(k)) = entries
                        list(entries) = row(k)
                        self%value(:, entries) = 0
                     end if
                     self%value(j - before, place(row(k))) = value(k)/value(first(j))
                  end do
               end do
            end associate
         end do
         self%first(panels + 1) = entries + 1
      end associate
      self%row = list(:entries)
   end subroutine take

   !> x = A^-1 b for one right-hand side or several, side by side at each unknown; a b `without` the unknowns that are eliminated
   !> last leaves out their equations: x is 0 there.
   pure subroutine solve(self, b, x, without)
      class(sparse_factor_t), intent(inout) :: self
      real(dp), intent(in), contiguous :: b(:)   !! (right-hand sides n)
      real(dp), intent(out), contiguous :: x(:)  !! (right-hand sides n)
      logical, intent(in), optional :: without(:) !! (right-hand sides)
      integer :: width
      associate (n => size(self%unknown), panels => size(self%first) - 1)
         width = size(b)/n
         if (allocated(self%y)) then
            if (size(self%y) /= width*lanes*panels) deallocate (self%y)
         end if
         if (.not. allocated(self%y)) allocate (self%y(width*lanes*panels), source=0.0_dp)
         call gather(width, n, self%unknown, b, self%y)
         select case (width)
         case (1)                                ! a constant, for which the compiler unrolls
            call eliminate(1, panels, self%first, self%row, self%value, self%block, self%y)
         case (2)
            call eliminate(2, panels, self%first, self%row, self%value, self%block, self%y)
         case default
            call eliminate(width, panels, self%first, self%row, self%value, self%block, self%y)
         end select
         if (present(without)) call leave_out(width, self%last, without, self%y)
         select case (width)
         case (1)
            call substitute(1, panels, self%first, self%row, self%value, self%block, self%inverse, self%y)
         case (2)
            call substitute(2, panels, self%first, self%row, self%value, self%block, self%inverse, self%y)
         case default
            call substitute(width, panels, self%first, self%row, self%value, self%block, self%inverse, self%y)
         end select
         call scatter(width, n, self%unknown, self%y, x)
      end associate
   end subroutine solve

   !> y = P b.
   pure subroutine gather(width, n, unknown, b, y)
      integer, intent(in) :: width, n, unknown(n)
      real(dp), intent(in) :: b(width, n)
      real(dp), intent(inout) :: y(width, *)
      integer :: j
      do j = 1, n
         y(:, j) = b(:, unknown(j))
      end do
   end subroutine gather

   !> y <- L^-1 y.
   pure subroutine eliminate(width, panels, first, row, value, block, y)
      integer, intent(in) :: width, panels, first(*), row(*)
      real(dp), intent(in) :: value(lanes, *), block(lanes, lanes, *)
      real(dp), intent(inout) :: y(width, lanes, *)
      real(dp) :: a(width, lanes)
      integer :: p, b, c
      do p = 1, panels
         a = y(:, :, p)
         if (.not. any(abs(a) > 0)) cycle
         do c = 1, lanes - 1
            do b = c + 1, lanes
               a(:, b) = a(:, b) - block(b, c, p)*a(:, c)
            end do
         end do
         y(:, :, p) = a
         call subtract(width, first(p + 1) - first(p), row(first(p)), value(1, first(p)), a, y)
      end do
   end subroutine eliminate

   !> y <- y - V a at the rows of a panel.
   pure subroutine subtract(width, n, row, v, a, y)
      integer, intent(in) :: width, n, row(n)
      real(dp), intent(in) :: v(lanes, n), a(width, lanes)
      real(dp), intent(inout) :: y(width, *)
      integer :: k, d
      do k = 1, n
         do d = 1, width
            y(d, row(k)) = y(d, row(k)) - (v(1, k)*a(d, 1) + v(2, k)*a(d, 2) + v(3, k)*a(d, 3) + v(4, k)*a(d, 4))
         end do
      end do
   end subroutine subtract

   !> y = 0 in some columns of some right-hand sides.
   pure subroutine leave_out(width, columns, without, y)
      integer, intent(in) :: width, columns(:)
      logical, intent(in) :: without(width)
      real(dp), intent(inout) :: y(width, *)
      integer :: k
      do k = 1, size(columns)
         where (without) y(:, columns(k)) = 0
      end do
   end subroutine leave_out

   !> y <- L^-T D^-1 y.
   pure subroutine substitute(width, panels, first, row, value, block, inverse, y)
      integer, intent(in) :: width, panels, first(*), row(*)
      real(dp), intent(in) :: value(lanes, *), block(lanes, lanes, *), inverse(lanes, *)
      real(dp), intent(inout) :: y(width, *)
      real(dp) :: a(lanes, width)
      integer :: p, k, b, c, d
      do p = panels, 1, -1
         do d = 1, width
            a(:, d) = inverse(:, p)*y(d, lanes*(p - 1) + 1:lanes*p)
         end do
         do k = first(p), first(p + 1) - 1
            do d = 1, width
               a(:, d) = a(:, d) - value(:, k)*y(d, row(k))
            end do
         end do
         do c = lanes, 1, -1
            do b = c + 1, lanes
               a(c, :) = a(c, :) - block(b, c, p)*a(b, :)
            end do
            y(:, lanes*(p - 1) + c) = a(c, :)
         end do
      end do
   end subroutine substitute

   !> x = P^T y.
   pure subroutine scatter(width, n, unknown, y, x)
      integer, intent(in) :: width, n, unknown(n)
      real(dp), intent(in) :: y(width, *)
      real(dp), intent(out) :: x(width, n)
      integer :: j
      do j = 1, n
         x(:, unknown(j)) = y(:, j)
      end do
   end subroutine scatter
end module hampm_sparse_factor
