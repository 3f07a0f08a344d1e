!> Irwin's crack closure at a tip in any direction: work of the tractions ahead of the tip on the opening behind it,
!>
!>    G_I = lim 1/(2 D) int_0^D t_n(r) [u_n](D - r) dr = K_t K_u/E',
!>
!> and likewise mode II. With t = K_t/sqrt(2 pi r) ahead and [u] = 8 K_u/E' sqrt(r/(2 pi)) behind the integral is exact for any D;
!> the tip's own cells, with other fields, are not used. K_t is fitted to tractions of particles ahead on planes along the crack,
!> K_u to displacements behind on both sides, by least squares with Williams' series: r**(1/2 - 1), r**(3/2 - 1), for K_u uniform
!> stress, rotation and translation too, and r**(-1/2 - 1) for a tip that acts a part of a cell away. Without it K_u is 5 to 50 %
!> off (docs/explanation/cracks.md). On a symmetry plane particles count with their mirror images. All in the reference
!> configuration, for finite rotation turned back by the mean of F. Irwin (1957); Rybicki & Kanninen (1977); Williams (1957).
module hampm_path_closure
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_failure, only: failure_t, exit_computation
   use hampm_lapack, only: dposv
   use hampm_mass_solver, only: mass_solver_t
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, quarter_turn, in_plane, identity
   use hampm_text, only: to_text
   implicit none
   private
   public :: path_closure

   real(dp), parameter :: pi = acos(-1.0_dp)
   ! By a little more than round numbers, on which particles are that stand around the tip as on a lattice
   real(dp), parameter :: nearest = 1.5_dp + 1e-6_dp !! cells from the tip beyond which fields count as of a crack
   real(dp), parameter :: farthest = 8 + 1e-6_dp !! cells from it up to which they are fitted
   real(dp), parameter :: slope = 2 + 1e-6_dp    !! of the lines from the tip between which particles are, ahead and behind
   real(dp), parameter :: on_crack = 1e-6_dp     !! cells from the crack within which it is not certain on which side a particle is
   integer, parameter :: of_traction(3) = [1, 3, -1] !! exponents n of the stress r**(n/2 - 1), the singular one first
   integer, parameter :: of_opening(4) = [1, 3, -1, 2]
   integer, parameter :: most_terms = modes*size(of_opening) + ndim

   !> Least squares for a few unknowns.
   type :: fit_t
      integer :: n = 0                           !! unknowns
      integer :: rows = 0                        !! so far
      real(dp) :: matrix(most_terms, most_terms) = 0
      real(dp) :: b(most_terms) = 0
   end type fit_t

contains

   !> G of each mode, uncertain by the difference of tractions and openings. Fails with too few particles ahead or behind.
   subroutine path_closure(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(mass_solver_t), intent(inout) :: extrapolation
      real(dp), intent(inout) :: rate(modes), uncertainty(modes)
      type(failure_t), intent(inout) :: failure
      type(fit_t) :: ahead, behind
      real(dp) :: turn(ndim, ndim), x(ndim), u(ndim), stress(ndim, ndim), k_t(modes), k_u(modes)
      real(dp) :: inner, outer, kappa            ! Kolosov's constant
      integer :: i, side
      outer = min(farthest*tip%nodes%spacing, (1 + 1e-6_dp)*maxval(tip%radii))
      inner = min(nearest*tip%nodes%spacing, outer/4)
      turn = rotation(tip, p, problem%materials, outer)
      ahead%n = modes*size(of_traction)
      behind%n = modes*size(of_opening) + ndim
      associate (h => tip%nodes%spacing, materials => problem%materials, material => problem%materials(tip%material))
         kappa = 3 - 4*material%poisson
         if (material%plane_stress) kappa = (3 - material%poisson)/(1 + material%poisson)
         do i = 1, p%n
            if (maxval(abs(p%reference(i, :) - tip%place)) > outer) cycle
            x = matmul(p%reference(i, :) - tip%place, tip%axis)
            if (norm(x) > outer .or. norm(x) < inner) cycle
            if (slope*x(1) > abs(x(2))) then
               stress = matmul(transpose(turn), materials(p%material(i))%first_piola_stress(p%gradient_of(i), hoop=p%hoop_of(i)))
               stress = matmul(transpose(tip%axis), matmul(stress, tip%axis))
               do side = 1, merge(-1, 1, tip%is_half()), -2
                  call add_tractions(ahead, in_plane(x(1), side*x(2))/h, in_plane(side*stress(1, 2), stress(2, 2)), p%volume(i))
               end do
            else if (-slope*x(1) > abs(x(2)) .and. abs(x(2)) > on_crack*h) then
               associate (from_tip => p%reference(i, :) - tip%place)  ! without stress-free strain
                  u = matmul(from_tip + p%displacement(i, :) - matmul(materials(p%material(i))%free, from_tip), turn)
               end associate
               u = matmul(u, tip%axis) - x
               do side = 1, merge(-1, 1, tip%is_half()), -2
                  call add_displacement(behind, in_plane(x(1), side*x(2))/h, 2*material%mu/h*in_plane(u(1), side*u(2)), &
                                        kappa, p%volume(i))
               end do
            end if
         end do
         call solve(ahead, k_t, failure)
         call solve(behind, k_u, failure)
         if (failure%failed()) return
         k_t = sqrt(2*pi*h)*k_t
         k_u = sqrt(2*pi*h)*k_u
         rate = abs(k_t)*k_u/material%plane_modulus()
         uncertainty = maxval(abs(k_t**2 - k_u**2))/(2*material%plane_modulus())  ! the errors may be of opposite sign
      end associate
   end subroutine path_closure

   !> Rotation in the mean of F around a tip; none where all laws there are for small ones.
   pure function rotation(tip, p, materials, reach) result(turn)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: reach              !! [m]
      real(dp) :: turn(ndim, ndim)
      real(dp) :: mean(ndim, ndim), c, s
      logical :: turns
      integer :: i
      turn = identity
      mean = 0
      turns = .false.
      do i = 1, p%n
         if (norm(p%reference(i, :) - tip%place) > reach) cycle
         mean = mean + p%volume(i)*(identity + p%gradient_of(i))
         turns = turns .or. materials(p%material(i))%is_finite
      end do
      if (.not. turns) return
      c = mean(1, 1) + mean(2, 2)
      s = mean(2, 1) - mean(1, 2)
      turn(:, 1) = in_plane(c, s)/max(hypot(c, s), tiny(c))
      turn(:, 2) = quarter_turn(turn(:, 1))
   end function rotation

   !> Tractions of a particle on a plane along the crack: two equations, across it and along it. Weights make the singular term
   !> count equally near the tip and far from it.
   pure subroutine add_tractions(fit, x, traction, volume)
      type(fit_t), intent(inout) :: fit
      real(dp), intent(in) :: x(ndim)            !! from the tip, in its frame [cells]
      real(dp), intent(in) :: traction(ndim)     !! [Pa]
      real(dp), intent(in) :: volume             !! [m3]
      real(dp) :: row(most_terms, ndim), r, angle, a, sign_of
      integer :: k
      r = norm(x)
      angle = atan2(x(2), x(1))
      row = 0
      do k = 1, size(of_traction)
         a = of_traction(k)/2.0_dp
         sign_of = merge(1, -1, mod(of_traction(k), 2) == 0)
         associate (first => (a - 1)*angle, second => (a - 3)*angle, size_of => a*r**(a - 1))
            row(2*k - 1, 1) = size_of*((a - 1)*sin(second) - (a + sign_of)*sin(first))
            row(2*k - 1, 2) = size_of*((2 - a - sign_of)*cos(first) + (a - 1)*cos(second))
            row(2*k, 1) = size_of*((a - 1)*cos(second) - (a - sign_of)*cos(first))
            row(2*k, 2) = -size_of*((2 - a + sign_of)*sin(first) + (a - 1)*sin(second))
         end associate
      end do
      do k = 1, ndim
         call add_equation(fit, row(:, k), traction(k), r*volume)
      end do
   end subroutine add_tractions

   !> Displacement of a particle, times 2 mu: two equations.
   pure subroutine add_displacement(fit, x, u, kappa, volume)
      type(fit_t), intent(inout) :: fit
      real(dp), intent(in) :: x(ndim)            !! from the tip, in its frame [cells]
      real(dp), intent(in) :: u(ndim)            !! times 2 mu, over the cell [Pa]
      real(dp), intent(in) :: kappa              !! Kolosov's constant
      real(dp), intent(in) :: volume             !! [m3]
      real(dp) :: row(most_terms, ndim), r, angle, a, sign_of
      integer :: k
      r = norm(x)
      angle = atan2(x(2), x(1))
      row = 0
      do k = 1, size(of_opening)
         a = of_opening(k)/2.0_dp
         sign_of = merge(1, -1, mod(of_opening(k), 2) == 0)
         associate (first => a*angle, second => (a - 2)*angle, size_of => r**a)
            row(2*k - 1, 1) = size_of*((kappa + a + sign_of)*cos(first) - a*cos(second))
            row(2*k - 1, 2) = size_of*((kappa - a - sign_of)*sin(first) + a*sin(second))
            row(2*k, 1) = size_of*((kappa + a - sign_of)*sin(first) - a*sin(second))
            row(2*k, 2) = -size_of*((kappa - a + sign_of)*cos(first) + a*cos(second))
         end associate
      end do
      do k = 1, ndim
         row(modes*size(of_opening) + k, k) = 1
         call add_equation(fit, row(:, k), u(k), volume)
      end do
   end subroutine add_displacement

   !> Add an equation with a weight.
   pure subroutine add_equation(fit, row, value, weight)
      type(fit_t), intent(inout) :: fit
      real(dp), intent(in) :: row(most_terms), value, weight
      integer :: j
      do j = 1, fit%n
         fit%matrix(:, j) = fit%matrix(:, j) + weight*row(j)*row
      end do
      fit%b = fit%b + weight*value*row
      fit%rows = fit%rows + 1
   end subroutine add_equation

   !> The coefficients of the singular terms. Fails where there are too few equations.
   subroutine solve(fit, singular, failure)
      type(fit_t), intent(in) :: fit
      real(dp), intent(out) :: singular(modes)
      type(failure_t), intent(inout) :: failure
      real(dp) :: matrix(most_terms, most_terms), b(most_terms, 1), scale(most_terms)
      integer :: info, j
      singular = 0
      if (failure%failed()) return
      info = 1
      if (fit%rows > 2*fit%n) then
         scale = 1
         do j = 1, fit%n
            scale(j) = sqrt(fit%matrix(j, j))
         end do
         do j = 1, fit%n
            matrix(:, j) = fit%matrix(:, j)/(scale*scale(j))
         end do
         b(:, 1) = fit%b/scale
         call dposv('L', fit%n, 1, matrix, most_terms, b, most_terms, info)
      end if
      if (info == 0) singular = b(:modes, 1)/scale(:modes)
      if (info /= 0) call failure%report(exit_computation, 'series_fit: only '//to_text(fit%rows/ndim)//' particles are '// &
         'ahead of or behind a tip within the largest of &energy_release radii, too few to fit the fields there. Use larger '// &
         'radii, or smaller cells')
   end subroutine solve
end module hampm_path_closure
