!> Orthotropic linear elasticity for small strains: stress = C eps, eps = sym(H), with material axes 1 and 2 in the plane, axis 1
!> turned by an angle from x, and axis 3 across the plane.
!>
!> In the axes of the material (Lekhnitskii 1963; Jones 1999)
!>
!>    eps_1 = s_1/E_1 - nu_12 s_2/E_1 - nu_13 s_3/E_1,   eps_2 = -nu_12 s_1/E_1 + s_2/E_2 - nu_23 s_3/E_2,
!>    eps_3 = -nu_13 s_1/E_1 - nu_23 s_2/E_2 + s_3/E_3,  2 eps_12 = s_12/G_12.
!>
!> In plane stress s_3 = 0; in plane strain eps_3 = 0, with the compliances S_ij - S_i3 S_j3/S_33. Matrices act on the columns
!> (s_11, s_22, s_12) and (eps_11, eps_22, 2 eps_12). Solids add 2 eps_13 = s_13/G_13 and 2 eps_23 = s_23/G_23, and their axes are
!> turned around x, then y, then z. As in `hampm_linear_elastic`, rotations count as strain to second order, and the material axes
!> do not turn with the material.
module hampm_orthotropic
   use hampm_kinds, only: dp, ndim
   use hampm_law, only: constant_t, flaw_t, add_flaw, value_of
   use hampm_tensors, only: norm, voigt, n_voigt, in_plane, quarter_turn, identity, inverse_transpose
   implicit none
   private
   public :: stiffness_of_solid, acoustic_modulus_of_solid
   public :: orthotropic_t, orthotropic_of, check_orthotropic, n_voigt, plane_compliance, inverse_of, turned_stiffness, &
             turned_compliance, turned_strain, voigt_stress, acoustic_modulus, why_not_definite

   real(dp), parameter :: to_radians = acos(-1.0_dp)/180

   !> The engineering constants.
   type :: orthotropic_t
      real(dp) :: young(3) = 0                   !! along the axes of the material [Pa]; the third counts in plane strain only
      real(dp) :: shear_12 = 0                   !! [Pa]
      real(dp) :: poisson_12 = 0                 !! -eps_2/eps_1 under s_1 alone [-]
      real(dp) :: poisson_13 = 0                 !! -eps_3/eps_1 under s_1 alone [-]; in plane strain only, as the next
      real(dp) :: poisson_23 = 0                 !! -eps_3/eps_2 under s_2 alone [-]
      real(dp) :: angle = 0                      !! of axis 1 from x, anticlockwise [degrees]
      real(dp) :: shear(2) = 0                   !! of solids: between axes 1 and 3, and between 2 and 3 [Pa]
      real(dp) :: turns(3) = 0                   !! of solids: those around x, then y, then z [degrees]
   end type orthotropic_t

contains

   !> Orthotropic constants from their keys; absent ones are isotropic.
   pure type(orthotropic_t) function orthotropic_of(constants, young, poisson) result(of)
      type(constant_t), intent(in) :: constants(:)
      real(dp), intent(in) :: young, poisson     !! of that [Pa], [-]
      integer :: k
      of%young = [value_of(constants, 'young_1', young), value_of(constants, 'young_2', young), &
                  value_of(constants, 'young_3', young)]
      of%shear_12 = value_of(constants, 'shear_12', young/(2*(1 + poisson)))
      of%poisson_12 = value_of(constants, 'poisson_12', poisson)
      of%poisson_13 = value_of(constants, 'poisson_13', poisson)
      of%poisson_23 = value_of(constants, 'poisson_23', poisson)
      of%angle = value_of(constants, 'angle', 0.0_dp)
      of%shear = [value_of(constants, 'shear_13', of%shear_12), value_of(constants, 'shear_23', of%shear_12)]
      if (ndim == 2) return
      k = findloc(constants%name, 'angle', dim=1)
      if (k > 0) of%turns = constants(k)%value(:3)
   end function orthotropic_of

   !> No strain releases energy.
   pure subroutine check_orthotropic(young, poisson, plane_stress, constants, flaws)
      real(dp), intent(in) :: young, poisson
      logical, intent(in) :: plane_stress
      type(constant_t), intent(in) :: constants(:)
      type(flaw_t), allocatable, intent(out) :: flaws(:)
      real(dp), parameter :: most_apart = 1e10_dp ! the largest of moduli, over the least
      real(dp), allocatable :: moduli(:)
      type(orthotropic_t) :: of
      character(:), allocatable :: why
      of = orthotropic_of(constants, young, poisson)
      allocate (moduli, source=[of%young(:merge(2, 3, plane_stress)), of%shear_12, of%shear])
      allocate (flaws(0))
      if (minval(moduli) <= 0) return
      if (maxval(moduli) > most_apart*minval(moduli)) then
         call add_flaw(flaws, 'young_1', 'and the other moduli must be within a factor of 1e10 of each other: else rounding '// &
                       'hides the least of them')
         return
      end if
      why = why_not_definite(of, plane_stress)
      if (why /= '') call add_flaw(flaws, 'poisson_12', why//': else a strain would release energy')
   end subroutine check_orthotropic

   !> Compliance of the plane, or of a solid, in the axes of the material [1/Pa].
   pure function plane_compliance(m, plane_stress) result(s)
      type(orthotropic_t), intent(in) :: m
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp) :: s(n_voigt, n_voigt)
      real(dp) :: across(2)                      ! S_13 and S_23
      integer :: i
      s = 0
      s(1, 1) = 1/m%young(1)
      s(2, 2) = 1/m%young(2)
      s(1, 2) = -m%poisson_12/m%young(1)
      s(2, 1) = s(1, 2)
      s(ndim + 1, ndim + 1) = 1/m%shear_12
      if (ndim > 2) then
         s(ndim, ndim) = 1/m%young(3)
         s(:2, ndim) = -[m%poisson_13/m%young(1), m%poisson_23/m%young(2)]
         s(ndim, :2) = s(:2, ndim)
         s(n_voigt - 1, n_voigt - 1) = 1/m%shear(1)
         s(n_voigt, n_voigt) = 1/m%shear(2)
      end if
      if (plane_stress .or. ndim > 2) return
      across = -[m%poisson_13/m%young(1), m%poisson_23/m%young(2)]
      do i = 1, 2
         s(:2, i) = s(:2, i) - across*across(i)*m%young(3)
      end do
   end function plane_compliance

   !> Reason why the strain energy is not positive definite; '' if it is. Moduli are above 0.
   pure function why_not_definite(m, plane_stress) result(why)
      type(orthotropic_t), intent(in) :: m
      logical, intent(in) :: plane_stress        !! else plane strain
      character(:), allocatable :: why
      real(dp) :: n12, n13, n23                  ! nu_ij sqrt(E_j/E_i), which are symmetric
      why = ''
      n12 = m%poisson_12*sqrt(m%young(2)/m%young(1))
      if (.not. abs(n12) < 1) why = 'poisson_12**2 must be below young_1/young_2'
      if (plane_stress .or. why /= '') return
      n13 = m%poisson_13*sqrt(m%young(3)/m%young(1))
      n23 = m%poisson_23*sqrt(m%young(3)/m%young(2))
      if (.not. abs(n13) < 1) then
         why = 'poisson_13**2 must be below young_1/young_3'
      else if (.not. abs(n23) < 1) then
         why = 'poisson_23**2 must be below young_2/young_3'
      else if (.not. 1 - n12**2 - n13**2 - n23**2 - 2*n12*n13*n23 > 0) then
         why = '1 - a**2 - b**2 - c**2 - 2 a b c must be above 0 with a = poisson_12 sqrt(young_2/young_1), '// &
               'b = poisson_13 sqrt(young_3/young_1) and c = poisson_23 sqrt(young_3/young_2)'
      end if
   end function why_not_definite

   !> Inverse of a matrix in the axes of the material, in which normal and shear components do not couple.
   pure function inverse_of(a) result(inverse)
      real(dp), intent(in) :: a(n_voigt, n_voigt)
      real(dp) :: inverse(n_voigt, n_voigt)
      integer :: k
      inverse = 0
      if (ndim > 2) then
         inverse(:ndim, :ndim) = inverse_transpose(a(:ndim, :ndim))
         do k = ndim + 1, n_voigt
            inverse(k, k) = 1/a(k, k)
         end do
         return
      end if
      inverse(1, 1) = a(2, 2)
      inverse(2, 2) = a(1, 1)
      inverse(1, 2) = -a(1, 2)
      inverse(2, 1) = -a(1, 2)
      inverse = inverse/(a(1, 1)*a(2, 2) - a(1, 2)**2)
      inverse(3, 3) = 1/a(3, 3)
   end function inverse_of

   !> Cosine and sine of an angle, exact at the multiples of 90 degrees.
   pure function direction_of(angle) result(direction)
      real(dp), intent(in) :: angle              !! [degrees]
      real(dp) :: direction(ndim)
      real(dp) :: rest
      integer :: quarter, k
      quarter = nint(modulo(angle, 360.0_dp)/90)
      rest = (modulo(angle, 360.0_dp) - 90*quarter)*to_radians
      direction = in_plane(cos(rest), sin(rest))
      do k = 1, quarter
         direction = quarter_turn(direction)
      end do
   end function direction_of

   !> Strain of principal values along the axes of the material, in x and y.
   pure function turned_strain(along, angle) result(strain)
      real(dp), intent(in) :: along(ndim)        !! [-]
      real(dp), intent(in) :: angle              !! of axis 1 from x [degrees]
      real(dp) :: strain(ndim, ndim), d(ndim)
      d = direction_of(angle)
      strain(:, 1) = in_plane(along(1)*d(1)**2 + along(2)*d(2)**2, (along(1) - along(2))*d(1)*d(2))
      strain(:, 2) = in_plane((along(1) - along(2))*d(1)*d(2), along(1)*d(2)**2 + along(2)*d(1)**2)
   end function turned_strain

   !> Matrix that gives the strain in axes that are turned by an angle, from that in the first ones.
   pure function strain_in_turned(angle) result(r)
      real(dp), intent(in) :: angle              !! [degrees]
      real(dp) :: r(n_voigt, n_voigt)
      real(dp) :: d(ndim)
      d = direction_of(angle)
      if (ndim > 2) r = 0
      r(:3, :3) = reshape([d(1)**2, d(2)**2, -2*d(1)*d(2), d(2)**2, d(1)**2, 2*d(1)*d(2), d(1)*d(2), -d(1)*d(2), &
                           d(1)**2 - d(2)**2], [3, 3])
   end function strain_in_turned

   !> A stiffness in axes from which those in which it is given are turned by an angle [Pa].
   pure function turned_stiffness(c, angle) result(turned)
      real(dp), intent(in) :: c(n_voigt, n_voigt)
      real(dp), intent(in) :: angle              !! [degrees]
      real(dp) :: turned(n_voigt, n_voigt)
      real(dp) :: r(n_voigt, n_voigt)
      r = strain_in_turned(angle)
      turned = symmetric(matmul(transpose(r), matmul(c, r)))
   end function turned_stiffness

   !> The same of a compliance [1/Pa].
   pure function turned_compliance(s, angle) result(turned)
      real(dp), intent(in) :: s(n_voigt, n_voigt)
      real(dp), intent(in) :: angle              !! [degrees]
      real(dp) :: turned(n_voigt, n_voigt)
      real(dp) :: r(n_voigt, n_voigt)
      r = strain_in_turned(-angle)
      turned = symmetric(matmul(r, matmul(s, transpose(r))))
   end function turned_compliance

   !> Stiffness, or with `is_compliance` compliance, of a solid in x, y and z from that in its turned material axes [Pa], [1/Pa].
   pure function stiffness_of_solid(c, turns, is_compliance) result(turned)
      real(dp), intent(in) :: c(n_voigt, n_voigt)
      real(dp), intent(in) :: turns(3)           !! around x, then y, then z [degrees]
      logical, intent(in) :: is_compliance
      real(dp) :: turned(n_voigt, n_voigt)
      real(dp) :: r(n_voigt, n_voigt), axes(ndim, ndim), of_turn(ndim, ndim), strain(ndim, ndim), d(ndim)
      integer :: a, b, i, j
      axes = identity
      do a = 1, ndim                             ! columns are the axes of the material
         d = direction_of(turns(a))
         i = 1 + mod(a, ndim)
         j = 1 + mod(a + 1, ndim)
         of_turn = identity
         of_turn(i, [i, j]) = [d(1), -d(2)]
         of_turn(j, [i, j]) = [d(2), d(1)]
         axes = matmul(of_turn, axes)
      end do
      do b = 1, ndim                             ! of stress for stiffness, of strain for compliance, from material axes to x, y, z
         do a = 1, b
            do j = 1, ndim
               strain(:, j) = (axes(:, a)*axes(j, b) + axes(:, b)*axes(j, a))/2
            end do
            do j = 1, ndim
               do i = 1, j
                  r(voigt(i, j), voigt(a, b)) = strain(i, j)*merge(1, 2, a == b .or. is_compliance) &
                                                *merge(2, 1, i /= j .and. is_compliance)
               end do
            end do
         end do
      end do
      turned = symmetric(matmul(r, matmul(c, transpose(r))))
   end function stiffness_of_solid

   !> rho c**2 of the fastest plane wave in a solid [Pa]: the largest m.C(n, n).m over unit vectors n and m. For a given n it is an
   !> eigenvalue, and n and m may swap: from many start directions each is found by the other in turn, which never lowers the value.
   pure real(dp) function acoustic_modulus_of_solid(c) result(largest)
      real(dp), intent(in) :: c(n_voigt, n_voigt) !! [Pa]
      integer, parameter :: passes = 60
      real(dp) :: n(ndim), m(ndim)
      integer :: start, pass, i
      largest = 0
      do start = 0, (3**ndim - 3)/2                  ! along axes, diagonals of sides, diagonals
         n = [(real(mod(start/3**(i - 1), 3) - 1, dp), i=1, ndim)]
         n = n/norm(n)
         m = n
         do pass = 1, passes
            n = next(m, n)
            m = next(n, m)
         end do
         largest = max(largest, norm(matmul(acoustic(n), m)))
      end do

   contains

      !> The tensor C(n, n) [Pa].
      pure function acoustic(n) result(a)
         real(dp), intent(in) :: n(ndim)
         real(dp) :: a(ndim, ndim)
         integer :: k
         do k = 1, ndim
            a(:, k) = matmul(voigt_stress(c, spread(identity(:, k), 2, ndim)*spread(n, 1, ndim)), n)
         end do
      end function acoustic

      !> A better m for an n.
      pure function next(n, m) result(better)
         real(dp), intent(in) :: n(ndim), m(ndim)
         real(dp) :: better(ndim), a(ndim, ndim)
         a = acoustic(n)
         better = matmul(a, m)
         better = better/norm(better)
      end function next
   end function acoustic_modulus_of_solid

   !> Symmetric part of a matrix: rounding leaves a small antisymmetric part.
   pure function symmetric(a)
      real(dp), intent(in) :: a(n_voigt, n_voigt)
      real(dp) :: symmetric(n_voigt, n_voigt)
      symmetric = (a + transpose(a))/2
   end function symmetric

   !> Stress of a displacement gradient by a stiffness [Pa].
   pure function voigt_stress(c, h) result(stress)
      real(dp), intent(in) :: c(n_voigt, n_voigt) !! [Pa]
      real(dp), intent(in) :: h(ndim, ndim)      !! [-]
      real(dp) :: stress(ndim, ndim)
      real(dp) :: shear, strain(n_voigt)
      integer :: i, j
      if (ndim > 2) then
         strain = 0
         do j = 1, ndim
            do i = 1, ndim
               strain(voigt(i, j)) = strain(voigt(i, j)) + h(i, j)
            end do
         end do
         strain = matmul(c, strain)
         do j = 1, ndim
            stress(:, j) = strain(voigt(:, j))
         end do
         return
      end if
      shear = h(1, 2) + h(2, 1)
      stress(1, 1) = c(1, 1)*h(1, 1) + c(1, 2)*h(2, 2) + c(1, 3)*shear
      stress(2, 2) = c(1, 2)*h(1, 1) + c(2, 2)*h(2, 2) + c(2, 3)*shear
      stress(2, 1) = c(1, 3)*h(1, 1) + c(2, 3)*h(2, 2) + c(3, 3)*shear
      stress(1, 2) = stress(2, 1)
   end function voigt_stress

   !> rho c**2 of the fastest plane wave [Pa]: the largest eigenvalue of the acoustic tensor over all directions n = (cos, sin).
   !>
   !> In the axes of the material the tensor has the components C_11 t + C_66 (1 - t), C_66 t + C_22 (1 - t) and
   !> (C_12 + C_66) cos sin, t = cos**2, so its larger eigenvalue is p + q t + sqrt(a t**2 + b t + c). It is largest at t of 0 or 1,
   !> or at a zero of the derivative, a root of a quadratic equation.
   pure real(dp) function acoustic_modulus(stiffness) result(largest)
      real(dp), intent(in) :: stiffness(n_voigt, n_voigt) !! in the axes of the material [Pa]
      real(dp) :: p, q, a, b, c, root
      associate (c11 => stiffness(1, 1), c22 => stiffness(2, 2), c66 => stiffness(3, 3), c12 => stiffness(1, 2))
         p = (c66 + c22)/2
         q = (c11 - c22)/2
         ! half of the difference of the diagonal is u + v t
         a = ((c11 + c22 - 2*c66)/2)**2 - (c12 + c66)**2
         b = (c66 - c22)*(c11 + c22 - 2*c66)/2 + (c12 + c66)**2
         c = ((c66 - c22)/2)**2
         largest = max(c11, c22, c66)
         ! the derivative is 0 where a (a - q**2) t**2 + b (a - q**2) t + b**2/4 - q**2 c is
         if (abs(a) <= epsilon(a)*(c11 + c22)**2) then
            if (abs(q*b) > 0) largest = max(largest, larger_at((b/q)**2/(4*b) - c/b))
         else if (abs(a - q**2) > 0) then
            root = (b/(2*a))**2 - (b**2/4 - q**2*c)/(a*(a - q**2))
            if (root >= 0) largest = max(largest, larger_at(-b/(2*a) - sqrt(root)))
            if (root >= 0) largest = max(largest, larger_at(-b/(2*a) + sqrt(root)))
         end if
      end associate

   contains

      !> The larger eigenvalue at a value of cos**2; 0 outside (0, 1) [Pa].
      pure real(dp) function larger_at(t)
         real(dp), intent(in) :: t
         larger_at = 0
         if (t > 0 .and. t < 1) larger_at = p + q*t + sqrt(max(a*t**2 + b*t + c, 0.0_dp))
      end function larger_at
   end function acoustic_modulus
end module hampm_orthotropic
