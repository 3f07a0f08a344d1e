!> Lowest eigenvalues of K x = lambda M x, both symmetric and M positive semi-definite, by ARPACK: the Lanczos method with implicit
!> restarts, shifted by 1 and inverted, so that the lowest converge first. Its caller is asked for products, one at a time, which
!> keeps matrices and factors out of here. K is scaled such that lambda of interest are neither far above 1e9 nor the shift is lost.
!>
!> Source: Lehoucq, Sorensen & Yang, ARPACK Users' Guide (1998), sections 3.3 (shift and invert) and 2.5 (reverse communication).
module hampm_arpack
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t, exit_computation
   use hampm_text, only: to_text
   implicit none
   private
   public :: arpack_t, to_multiply, to_solve, to_do_both, is_finished

   !> What a search asks of its caller: y = M x, y = (K + M)^-1 x, y = (K + M)^-1 M x; or nothing more.
   integer, parameter :: to_multiply = 1, to_solve = 2, to_do_both = 3, is_finished = 4
   real(dp), parameter :: accuracy = 1e-12_dp    !! of an eigenvalue of the inverse, relative
   integer, parameter :: most_restarts = 1000
   character, parameter :: generalised = 'G'
   character(*), parameter :: largest = 'LM'     !! of the inverse

   !> A search for eigenvalues.
   type :: arpack_t
      real(dp), allocatable :: x(:), y(:)        !! operand, and the result that the caller gives, (n)
      integer, private :: n = 0, wanted = 0, width = 0
      integer, private :: ido = 0, info = 1
      integer, private :: parameters(11) = 0, at(11) = 1
      real(dp), allocatable, private :: residual(:), basis(:, :), work(:), room(:)
   contains
      procedure :: start
      procedure :: next
      procedure :: finish
   end type arpack_t

   interface
      !> A step of the Lanczos method, by reverse communication.
      subroutine dsaupd(ido, bmat, n, which, nev, tol, resid, ncv, v, ldv, iparam, ipntr, workd, workl, lworkl, info)
         import :: dp
         integer, intent(inout) :: ido, info, iparam(11), ipntr(11)
         character, intent(in) :: bmat
         character(2), intent(in) :: which
         integer, intent(in) :: n, nev, ncv, ldv, lworkl
         real(dp), intent(in) :: tol
         real(dp), intent(inout) :: resid(*), v(ldv, *), workd(*), workl(*)
      end subroutine dsaupd

      !> Eigenvalues, ascending, and eigenvectors when it has converged.
      subroutine dseupd(rvec, howmny, chosen, d, z, ldz, sigma, bmat, n, which, nev, tol, resid, ncv, v, ldv, iparam, ipntr, &
                        workd, workl, lworkl, info)
         import :: dp
         logical, intent(in) :: rvec
         character, intent(in) :: howmny, bmat
         logical, intent(inout) :: chosen(*)
         integer, intent(in) :: ldz, n, nev, ncv, ldv, lworkl
         real(dp), intent(inout) :: d(*), z(ldz, *), resid(*), v(ldv, *), workd(*), workl(*)
         real(dp), intent(in) :: sigma, tol
         character(2), intent(in) :: which
         integer, intent(inout) :: iparam(11), ipntr(11), info
      end subroutine dseupd
   end interface

contains

   !> Begin to search for some of the eigenvalues, fewer than there are.
   subroutine start(self, first, wanted)
      class(arpack_t), intent(out) :: self
      real(dp), intent(in) :: first(:)           !! vector to start from, with a part in all that are wanted, (n)
      integer, intent(in) :: wanted
      self%n = size(first)
      self%wanted = wanted
      self%width = min(self%n, 2*wanted + 8)
      self%residual = first
      self%parameters(1) = 1                     ! its own shifts of restarts
      self%parameters(3) = most_restarts
      self%parameters(4) = 1
      self%parameters(7) = 3                     ! shift and invert
      allocate (self%basis(self%n, self%width), self%work(3*self%n), self%room(self%width*(self%width + 8)))
      allocate (self%x(self%n), self%y(self%n), source=0.0_dp)
   end subroutine start

   !> Go on to the next product that the caller is to find: y of x.
   subroutine next(self, task)
      class(arpack_t), intent(inout) :: self
      integer, intent(out) :: task
      associate (n => self%n)
         if (self%ido /= 0) self%work(self%at(2):self%at(2) + n - 1) = self%y
         call dsaupd(self%ido, generalised, n, largest, self%wanted, accuracy, self%residual, self%width, self%basis, n, &
                     self%parameters, self%at, self%work, self%room, size(self%room), self%info)
         select case (self%ido)
         case (-1)
            task = to_do_both
         case (1)
            task = to_solve
         case (2)
            task = to_multiply
         case default
            task = is_finished
            return
         end select
         associate (from => merge(self%at(3), self%at(1), task == to_solve))
            self%x = self%work(from:from + n - 1)
         end associate
      end associate
   end subroutine next

   !> The eigenvalues, ascending, and their vectors with x.M x = 1. Fails where the method has not converged.
   subroutine finish(self, values, vectors, failure)
      class(arpack_t), intent(inout) :: self
      real(dp), allocatable, intent(out) :: values(:), vectors(:, :) !! (wanted), (n, wanted)
      type(failure_t), intent(inout) :: failure
      logical :: chosen(self%width)
      real(dp) :: all_values(self%width)
      associate (n => self%n)
         if (self%info == 0) call dseupd(.true., 'A', chosen, all_values, self%basis, n, -1.0_dp, generalised, n, largest, &
                                         self%wanted, accuracy, self%residual, self%width, self%basis, n, self%parameters, &
                                         self%at, self%work, self%room, size(self%room), self%info)
      end associate
      if (self%info /= 0) then
         call failure%report(exit_computation, 'ARPACK does not find them (info = '//to_text(self%info)//')')
         return
      end if
      values = all_values(:self%wanted)
      vectors = self%basis(:, :self%wanted)
   end subroutine finish
end module hampm_arpack
