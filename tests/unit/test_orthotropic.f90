!> Orthotropic elasticity: the engineering constants come back from the stress, material that is turned answers as a body that is turned,
!> with isotropic constants all is isotropic, waves, and the singular fields at the tip of a crack.
program test_orthotropic
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t, new_material, new_orthotropic
   use hampm_orthotropic, only: orthotropic_t, why_not_definite
   use hampm_crack_tip_field, only: modes, tip_field_t, new_tip_field
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp), density = 1600
   !> A carbon fibre laminate, a soft one whose roots are complex, and one near to an isotropic material [Pa]
   type(orthotropic_t), parameter :: examples(3) = [ &
      orthotropic_t([140.0e9_dp, 10.0e9_dp, 9.0e9_dp], 5.0e9_dp, 0.3_dp, 0.25_dp, 0.4_dp, 0.0_dp), &
      orthotropic_t([20.0e9_dp, 30.0e9_dp, 15.0e9_dp], 25.0e9_dp, 0.1_dp, 0.2_dp, 0.3_dp, 0.0_dp), &
      orthotropic_t([70.0e9_dp, 70.1e9_dp, 70.0e9_dp], 27.0e9_dp, 0.3_dp, 0.3_dp, 0.3_dp, 0.0_dp)]
   integer :: k

   call repeat_random_numbers()
   call off_axis_modulus()
   do k = 1, size(examples)
      call plane_strain(examples(k))
      call turned_material(examples(k))
      call energies(examples(k))
      call fastest_waves(examples(k))
      call tip_fields(examples(k))
   end do
   call isotropic_constants()
   call degenerate_roots()
   call unstable_constants()
   call finish()

contains

   !> The example with its axes turned.
   type(material_t) function turned(constants, angle, plane_stress)
      type(orthotropic_t), intent(in) :: constants
      real(dp), intent(in) :: angle              !! [degrees]
      logical, intent(in) :: plane_stress
      type(orthotropic_t) :: these
      these = constants
      these%angle = angle
      turned = new_orthotropic('', plane_stress, these, density)
   end function turned

   pure function rotation(angle) result(q)
      real(dp), intent(in) :: angle              !! [degrees]
      real(dp) :: q(ndim, ndim)
      q = reshape([cos(angle*pi/180), sin(angle*pi/180), -sin(angle*pi/180), cos(angle*pi/180)], [ndim, ndim])
   end function rotation

   !> Under uniaxial stress s along x a lamina at an angle strains by (Jones 1999, section 2.8)
   !>
   !>    eps_x = s [c**4/E1 + (1/G12 - 2 nu12/E1) c**2 s**2 + s**4/E2],
   !>    eps_y = s [-nu12/E1 (c**4 + s**4) + (1/E1 + 1/E2 - 1/G12) c**2 s**2],
   !>    2 eps_xy = s [(2/E1 + 2 nu12/E1 - 1/G12) s c**3 - (2/E2 + 2 nu12/E1 - 1/G12) s**3 c].
   subroutine off_axis_modulus()
      real(dp), parameter :: angles(*) = [0.0_dp, 30.0_dp, 45.0_dp, 90.0_dp, -60.0_dp, 200.0_dp]
      type(material_t) :: m
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      integer :: i
      do i = 1, size(angles)
         m = turned(examples(1), angles(i), .true.)
         associate (c => cos(angles(i)*pi/180), s => sin(angles(i)*pi/180), e1 => examples(1)%young(1), &
                    e2 => examples(1)%young(2), g => examples(1)%shear_12, nu => examples(1)%poisson_12)
            h(1, 1) = c**4/e1 + (1/g - 2*nu/e1)*c**2*s**2 + s**4/e2
            h(2, 2) = -nu/e1*(c**4 + s**4) + (1/e1 + 1/e2 - 1/g)*c**2*s**2
            h(1, 2) = ((2/e1 + 2*nu/e1 - 1/g)*s*c**3 - (2/e2 + 2*nu/e1 - 1/g)*s**3*c)/2
            h(2, 1) = h(1, 2)
         end associate
         stress = m%kirchhoff_stress(h)
         stress(1, 1) = stress(1, 1) - 1
         call check_close(maxval(abs(stress)), 0.0_dp, 1.0e-13_dp, 'a lamina at an angle has the strains of the textbook')
      end do
   end subroutine off_axis_modulus

   !> In plane strain the stress across the plane that keeps eps_3 = 0 gives the strains of the three-dimensional law.
   subroutine plane_strain(of)
      type(orthotropic_t), intent(in) :: of
      type(material_t) :: m
      real(dp) :: h(ndim, ndim), stress(ndim, ndim), across, strain(ndim)
      call random_number(h)
      m = turned(of, 0.0_dp, .false.)
      stress = m%kirchhoff_stress(h)
      across = of%young(3)*(of%poisson_13/of%young(1)*stress(1, 1) + of%poisson_23/of%young(2)*stress(2, 2))
      strain(1) = stress(1, 1)/of%young(1) - of%poisson_12/of%young(1)*stress(2, 2) - of%poisson_13/of%young(1)*across
      strain(2) = stress(2, 2)/of%young(2) - of%poisson_12/of%young(1)*stress(1, 1) - of%poisson_23/of%young(2)*across
      call check_close(maxval(abs(strain - [h(1, 1), h(2, 2)])), 0.0_dp, 1.0e-13_dp, 'plane strain has no strain across the plane')
      call check_close(stress(1, 2), of%shear_12*(h(1, 2) + h(2, 1)), 1.0e-13_dp*of%shear_12, 'shear is by G12')
   end subroutine plane_strain

   !> Q S(h) Q^T of a material at an angle is S(Q h Q^T) of the one that is turned by Q.
   subroutine turned_material(of)
      type(orthotropic_t), intent(in) :: of
      real(dp), parameter :: angles(*) = [17.0_dp, 90.0_dp, 135.0_dp, -61.0_dp]
      type(material_t) :: straight, rotated
      real(dp) :: h(ndim, ndim), q(ndim, ndim), difference(ndim, ndim)
      integer :: i, plane
      do plane = 1, 2
         do i = 1, size(angles)
            call random_number(h)
            q = rotation(angles(i))
            straight = turned(of, 23.0_dp, plane == 1)
            rotated = turned(of, 23.0_dp + angles(i), plane == 1)
            difference = rotated%kirchhoff_stress(matmul(q, matmul(h, transpose(q)))) &
                         - matmul(q, matmul(straight%kirchhoff_stress(h), transpose(q)))
            call check_close(maxval(abs(difference)), 0.0_dp, 1.0e-14_dp*maxval(of%young), 'turned material is a turned body')
         end do
      end do
   end subroutine turned_material

   !> The energy of a strain is that of its stress, and its change the work of the stress; the tangent is the stress of the change.
   subroutine energies(of)
      type(orthotropic_t), intent(in) :: of
      type(material_t) :: m
      real(dp) :: h(ndim, ndim), dh(ndim, ndim), change
      m = turned(of, 33.0_dp, .false.)
      call random_number(h)
      call random_number(dh)
      call check_close(m%stress_energy_density(m%kirchhoff_stress(h)), m%energy_density(h), 1.0e-13_dp*m%energy_density(h), &
                       'the energy of a strain is that of its stress')
      change = (m%energy_density(h + dh) - m%energy_density(h - dh))/2
      call check_close(change, sum(m%first_piola_stress(h)*dh), 1.0e-13_dp*abs(change), &
                       'the stress is the derivative of the energy')
      call check_close(maxval(abs(m%first_piola_change(h, dh) - m%first_piola_stress(dh))), 0.0_dp, 0.0_dp, 'the law is linear')
   end subroutine energies

   !> The fastest wave is the largest eigenvalue of the acoustic tensor over a thousand directions.
   subroutine fastest_waves(of)
      type(orthotropic_t), intent(in) :: of
      type(material_t) :: m
      real(dp) :: acoustic(ndim, ndim), n(ndim), largest, h(ndim, ndim)
      integer :: i, j, plane
      do plane = 1, 2
         m = turned(of, 11.0_dp, plane == 1)
         largest = 0
         do i = 1, 1000
            n = [cos(pi*i/1000), sin(pi*i/1000)]
            do j = 1, ndim
               h = 0
               h(j, :) = n
               acoustic(:, j) = matmul(m%first_piola_stress(h), n)
            end do
            largest = max(largest, (acoustic(1, 1) + acoustic(2, 2))/2 + hypot((acoustic(1, 1) - acoustic(2, 2))/2, acoustic(1, 2)))
         end do
         call check_close(m%dilatational_wave_speed(), sqrt(largest/density), 1.0e-5_dp*sqrt(largest/density), &
                          'the fastest wave is that of the acoustic tensor')
      end do
      call check_close(m%shear_wave_speed(), sqrt(of%shear_12/density), 1.0e-9_dp, 'shear waves along the axes go by G12')
   end subroutine fastest_waves

   !> Ahead of a tip the tractions are 1/sqrt(2 pi r) of the mode; its faces carry none; it is in equilibrium; what the faces have parted is
   subroutine tip_fields(of)
      type(orthotropic_t), intent(in) :: of
      real(dp), parameter :: angles(*) = [0.0_dp, 30.0_dp, 90.0_dp, -75.0_dp], r = 0.37_dp
      type(tip_field_t) :: field
      real(dp) :: scale, stress(ndim, ndim), slope(ndim, 2), g, k(modes), compliant
      integer :: i, mode, c, plane
      scale = 1/sqrt(2*pi*r)
      compliant = 1/minval(of%young)
      do plane = 1, 2
         do i = 1, size(angles)
            field = new_tip_field(turned(of, angles(i), plane == 1), [1.0_dp, 0.0_dp])
            g = 0
            k = [2.0_dp, -0.7_dp]
            do mode = 1, modes
               stress = field%stress(field%gradient(mode, [r, 0.0_dp]))
               call check_close(stress(2, 2), merge(scale, 0.0_dp, mode == 1), 1.0e-12_dp, 'K_I is the stress ahead of the tip')
               call check_close(stress(1, 2), merge(0.0_dp, scale, mode == 1), 1.0e-12_dp, 'K_II is the shear stress there')
               do c = 1, 2
                  stress = field%stress(field%gradient(mode, [-r, sign(0.0_dp, 1.5_dp - c)]))
                  call check_close(maxval(abs(stress(:, 2))), 0.0_dp, 1.0e-11_dp, 'faces carry no traction')
               end do
               stress = field%gradient(mode, [-r, 0.0_dp]) - field%gradient(mode, [-r, -0.0_dp])
               slope(:, mode) = stress(:, 1)
               do c = 1, 2
                  call check_close(-slope(3 - c, mode), field%opening(c, mode, r)/(2*r), 1.0e-11_dp*compliant, &
                                   'faces part by 8 Y sqrt(r/(2 pi)) K')
                  g = g + k(mode)*k(c)*field%opening(c, mode, 1.0_dp)*sqrt(2*pi)/8
               end do
               call equilibrium(field, mode)
            end do
            call check_close(field%rate_of(k), g, 1.0e-12_dp*g, 'G is what closes the faces')
            call check_close(sum(field%shares(k)), 1.0_dp, 1.0e-14_dp, 'modes share all of G')
            call check(all(abs(field%intensities_of(2*[(coupling(field, mode, k), mode=1, modes)], 1.0_dp) - k) < 1.0e-12_dp), &
                       'K follows from the interactions')
         end do
      end do
   end subroutine tip_fields

   !> (Y K) of a mode, by differences of G.
   real(dp) function coupling(field, mode, k)
      type(tip_field_t), intent(in) :: field
      integer, intent(in) :: mode
      real(dp), intent(in) :: k(modes)
      real(dp) :: unit(modes)
      unit = 0
      unit(mode) = 1
      coupling = (field%rate_of(k + unit) - field%rate_of(k - unit))/4
   end function coupling

   !> The divergence of the stress is 0, and the gradient is one: its curl is 0.
   subroutine equilibrium(field, mode)
      type(tip_field_t), intent(in) :: field
      integer, intent(in) :: mode
      real(dp), parameter :: x(ndim) = [-0.21_dp, 0.4_dp], step = 1.0e-4_dp
      real(dp) :: s(ndim, ndim, ndim), h(ndim, ndim, ndim), at(ndim), force(ndim), typical
      integer :: d
      do d = 1, ndim
         at = 0
         at(d) = step
         h(:, :, d) = (field%gradient(mode, x + at) - field%gradient(mode, x - at))/(2*step)
         s(:, :, d) = (field%stress(field%gradient(mode, x + at)) - field%stress(field%gradient(mode, x - at)))/(2*step)
      end do
      typical = maxval(abs(s))
      force = s(:, 1, 1) + s(:, 2, 2)
      call check_close(maxval(abs(force)), 0.0_dp, 1.0e-6_dp*typical, 'the field is in equilibrium')
      call check_close(maxval(abs(h(:, 1, 2) - h(:, 2, 1))), 0.0_dp, 1.0e-6_dp*maxval(abs(h)), 'it has a displacement')
   end subroutine equilibrium

   !> With isotropic constants stress, energies, waves, fields, K and G are those of the isotropic law, at any angle.
   subroutine isotropic_constants()
      real(dp), parameter :: young = 70.0e9_dp, poisson = 0.3_dp, angles(*) = [0.0_dp, 37.0_dp, 90.0_dp]
      type(material_t) :: a, b
      type(tip_field_t) :: of_a, of_b
      real(dp), parameter :: direction(ndim) = [0.6_dp, 0.8_dp]
      real(dp) :: h(ndim, ndim), x(ndim)
      integer :: i, plane, mode
      do plane = 1, 2
         a = new_material('', 'linear_elastic', plane == 1, young, poisson, density)
         do i = 1, size(angles)
            b = turned(orthotropic_t([young, young, young], young/2.6_dp, poisson, poisson, poisson, 0.0_dp), angles(i), plane == 1)
            call random_number(h)
            call check_close(maxval(abs(a%kirchhoff_stress(h) - b%kirchhoff_stress(h))), 0.0_dp, 1.0e-14_dp*young, &
                             'isotropic constants give the isotropic stress')
            call check_close(maxval(abs(a%stiffness - b%stiffness)), 0.0_dp, 1.0e-14_dp*young, &
                             'and its moduli')
            call check_close(b%energy_density(h), a%energy_density(h), 1.0e-13_dp*a%energy_density(h), 'and its energy')
            call check_close(b%dilatational_wave_speed(), a%dilatational_wave_speed(), 1.0e-10_dp, 'and its waves')
            call check_close(b%plane_modulus(), a%plane_modulus(), 1.0e-13_dp*young, 'and its E''')
            of_a = new_tip_field(a, direction)
            of_b = new_tip_field(b, direction)
            do mode = 1, modes
               call random_number(x)
               x = x - 0.5_dp
               call check_close(maxval(abs(of_a%gradient(mode, x) - of_b%gradient(mode, x))), 0.0_dp, &
                                1.0e-10_dp*maxval(abs(of_a%gradient(mode, x))), 'and its field at a tip')
            end do
            call check_close(of_b%rate_of([3.0_dp, 2.0_dp]), of_a%rate_of([3.0_dp, 2.0_dp]), 1.0e-13_dp*13/young, 'and its G of K')
         end do
      end do
   end subroutine isotropic_constants

   !> Where the roots of the field come together, from purely imaginary to complex ones, it changes as little as the constants do.
   subroutine degenerate_roots()
      real(dp), parameter :: x(ndim) = [-0.3_dp, 0.2_dp]
      real(dp) :: change, before(ndim, ndim), now(ndim, ndim)
      type(orthotropic_t) :: of
      type(tip_field_t) :: field
      integer :: n, mode, side
      do mode = 1, modes
         do side = -1, 1, 2
            of = orthotropic_t([70.0e9_dp, 70.0e9_dp, 70.0e9_dp], 70.0e9_dp/2.6_dp, 0.3_dp, 0.3_dp, 0.3_dp, 0.0_dp)
            field = new_tip_field(turned(of, 25.0_dp, .true.), [1.0_dp, 0.0_dp])
            before = field%gradient(mode, x)
            do n = 4, 56
               change = side*10.0_dp**(-n/4.0_dp)
               of%shear_12 = 70.0e9_dp/2.6_dp*(1 + change)
               field = new_tip_field(turned(of, 25.0_dp, .true.), [1.0_dp, 0.0_dp])
               now = field%gradient(mode, x)
               call check(maxval(abs(now - before)) <= (2*abs(change) + 1.0e-10_dp)*maxval(abs(before)), &
                          'the field changes as little as its constants where roots come together')
            end do
         end do
      end do
   end subroutine degenerate_roots

   !> What would release energy is told.
   subroutine unstable_constants()
      type(orthotropic_t) :: of
      of = examples(1)
      call check(why_not_definite(of, .true.) == '', 'these constants are those of a solid')
      call check(why_not_definite(of, .false.) == '', 'in plane strain too')
      of%poisson_12 = 3.8_dp                     ! sqrt(14) is 3.74
      call check(index(why_not_definite(of, .true.), 'poisson_12') > 0, 'poisson_12**2 is below young_1/young_2')
      of = orthotropic_t([1.0_dp, 1.0_dp, 1.0_dp], 0.3_dp, 0.6_dp, 0.6_dp, 0.6_dp, 0.0_dp)
      call check(why_not_definite(of, .true.) == '', 'in the plane alone 0.6 is possible')
      call check(why_not_definite(of, .false.) /= '', 'Poisson''s ratios of 0.6 in all directions are not')
   end subroutine unstable_constants
end program test_orthotropic
