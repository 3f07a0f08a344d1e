!> Energy release rate by displacement correlation: K of each mode whose field parts the faces of a crack as far as the particles beside them have,
!>
!>    u = 4 K/E' sqrt(r/(2 pi)) (1 + a/r + b r)   of the upper face, and the opposite of the lower one,
!>
!> by least squares over the particles within a cell of the crack from 2 to 8 cells behind its tip; G = K**2/E'. The term a/r is that of a tip
!> that acts a part of a cell from its place.
!>
!> Source: Chan, Tuba & Wilson, Engineering Fracture Mechanics 2 (1970) 1-17.
module hampm_displacement_correlation
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_failure, only: failure_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_particles, only: particles_t
   use hampm_problem, only: problem_t
   use hampm_tensors, only: determinant_of, inverse_transpose_of
   implicit none
   private
   public :: displacement_correlation

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: nearest = 2, farthest = 8, beside = 1 !! [cells]

contains

   !> G of each mode.
   subroutine displacement_correlation(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(mass_solver_t), intent(inout) :: extrapolation
      real(dp), intent(inout) :: rate(modes), uncertainty(modes)
      type(failure_t), intent(inout) :: failure
      real(dp) :: x(ndim), u(ndim), terms(3), matrix(3, 3), right(3, ndim)
      integer :: i
      matrix = 0
      right = 0
      associate (h => tip%nodes%spacing)
         do i = 1, p%n
            x = matmul(p%reference(i, :) - tip%place, tip%axis)/h
            if (-x(1) < nearest .or. -x(1) > farthest .or. abs(x(2)) > beside) cycle
            u = matmul(p%displacement(i, :), tip%axis)*sign(1.0_dp, x(2))
            terms = sqrt(-x(1))*[1.0_dp, 1/x(1), x(1)]
            matrix = matrix + spread(terms, 2, 3)*spread(terms, 1, 3)
            right = right + spread(terms, 2, ndim)*spread(u, 1, 3)
         end do
         rate = 0
         if (.not. abs(determinant_of(matrix)) > 0) return
         right = matmul(inverse_transpose_of(matrix), right) ! of a symmetric matrix: its inverse
         associate (e => problem%materials(tip%material)%plane_modulus(), k => right(1, [2, 1])*sqrt(2*pi/h)/4) ! K/E'
            rate = e*k*abs(k)
         end associate
      end associate
      if (tip%is_half()) rate(2) = 0
   end subroutine displacement_correlation
end module hampm_displacement_correlation
