!> Growth direction of a crack in mixed mode: the angle of its kink.
!>
!> Angles are positive to the left, seen along the crack. K_II > 0 turns a crack to the right.
!>
!> Sources: Erdogan & Sih, J. Basic Eng. 85 (1963) 519 (hoop stress); Amestoy & Leblond, Int. J. Solids Struct. 29 (1992) 465
!> (stress intensity factors of a short kink); Goldstein & Salganik, Int. J. Fract. 10 (1974) 507 (local symmetry); Chambolle,
!> Francfort & Marigo, J. Mech. Phys. Solids 57 (2009) 1614 (largest energy over toughness).
module hampm_kinks
   use hampm_kinds, only: dp
   use hampm_tensors, only: norm
   use hampm_crack_values, only: is_pressed
   use hampm_crack_tip_field, only: modes
   use hampm_toughness, only: advance_t, factors_t
   implicit none
   private
   public :: kink_t, kink_angle, best_kink, after_kink, of_t_stress, hoop_intensity, is_opened, slope_of_mixity

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: degree = pi/180
   real(dp), parameter :: largest = 80*degree    !! largest angle considered; the series are good to 1e-5 there

   !> A short kink.
   type :: kink_t
      real(dp) :: angle = 0                      !! to the left [rad]
      real(dp) :: gain = 1                       !! its energy release rate over that of the crack before [-]
      real(dp) :: shear = 0                      !! share of mode II in that [-]
   end type kink_t

contains

   !> Kink angle by a criterion: 'straight', 'hoop_stress', 'local_symmetry' or 'max_energy' [rad]. It is straight without strain.
   pure real(dp) function kink_angle(criterion, k) result(angle)
      character(*), intent(in) :: criterion
      real(dp), intent(in) :: k(modes)           !! stress intensity factors before [Pa sqrt(m)]
      type(kink_t) :: kink
      type(factors_t) :: same                    ! toughness in all directions
      angle = 0
      if (.not. maxval(abs(k)) > 0) return
      select case (criterion)
       case ('hoop_stress')
         if (abs(k(2)) > 0) angle = 2*atan((k(1) - sqrt(k(1)**2 + 8*k(2)**2))/(4*k(2)))
       case ('local_symmetry')
         angle = symmetric_angle(k)
       case ('max_energy')
         kink = best_kink(k, 0.0_dp, advance_t(), same)
         angle = kink%angle
      end select
   end function kink_angle

   !> Stress intensity factor of the largest hoop stress around a tip [Pa sqrt(m)].
   pure real(dp) function hoop_intensity(k)
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp) :: angle
      hoop_intensity = k(1)
      if (.not. abs(k(2)) > 0) return
      angle = kink_angle('hoop_stress', k)
      hoop_intensity = cos(angle/2)**2*(k(1)*cos(angle/2) - 3*k(2)*sin(angle/2))
   end function hoop_intensity

   !> Whether a tip opens in the direction of a criterion: also in pure mode II, as at a closed crack.
   pure logical function is_opened(criterion, k)
      character(*), intent(in) :: criterion
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp), parameter :: nothing = 1e-6_dp   ! remainder of K_II where the series has a direction without it
      ! Hoop stress of a pressed tip is at least 0, that of its faces. It is 4 (K_II/K_I)**3 of K_I for small K_II: a K_II of 6 % of
      ! K_I, maybe its error, would turn such a crack right round
      real(dp), parameter :: little = 1e-3_dp
      real(dp) :: of_kink(modes)
      select case (criterion)
       case ('hoop_stress')
         is_opened = hoop_intensity(k) > little*norm(k)
       case ('local_symmetry', 'max_energy')
         of_kink = after_kink(symmetric_angle(k), k)
         is_opened = of_kink(1) > 0 .and. abs(of_kink(2)) <= nothing*norm(k)
       case default
         is_opened = .not. is_pressed(k, 0.0_dp)  ! K_I of a sheared crack is rounding, of any sign
      end select
   end function is_opened

   !> Angle of a short kink without K_II [rad]: to the right for positive K_II. If none is within the considered range, the end of
   !> the range.
   pure real(dp) function symmetric_angle(k) result(angle)
      real(dp), intent(in) :: k(modes)
      real(dp) :: low, high, of_kink(modes)
      integer :: i
      low = 0
      high = -sign(largest, k(2))
      do i = 1, digits(low)
         angle = (low + high)/2
         of_kink = after_kink(angle, k)
         if (of_kink(2)*k(2) > 0) then
            low = angle
         else
            high = angle
         end if
      end do
   end function symmetric_angle

   !> Derivative of atan(K_II/K_I) of a short kink by its angle, where K_II is 0.
   pure real(dp) function slope_of_mixity(angle, k) result(slope)
      real(dp), intent(in) :: angle              !! [rad]
      real(dp), intent(in) :: k(modes)           !! of the crack before [Pa sqrt(m)]
      real(dp), parameter :: small = 1e-4_dp     ! [rad]
      real(dp) :: before(modes), after(modes)
      before = after_kink(angle - small, k)
      after = after_kink(angle + small, k)
      slope = (after(2) - before(2))/(after(1) + before(1))/small
   end function slope_of_mixity

   !> The short kink that opens and has the largest energy release rate over its toughness: the best of directions a degree apart
   !> and of those in the table of toughnesses, where weak planes are, then refined. Of two equal ones the smaller turn, or the left
   !> one.
   pure function best_kink(k, t, advance, factors) result(kink)
      real(dp), intent(in) :: k(modes)           !! of the crack before [Pa sqrt(m)]
      real(dp), intent(in) :: t                  !! its T-stress times the root of the length of the kink [Pa sqrt(m)]
      type(advance_t), intent(in) :: advance     !! straight on
      type(factors_t), intent(in) :: factors     !! of the toughness
      type(kink_t) :: kink
      integer, parameter :: most = 100           !! angle [deg]; the series are good to 1e-5 there
      real(dp), parameter :: golden = 0.6180339887498949_dp, rounding = 1e-9_dp
      real(dp) :: best, low, high, a, b
      integer :: i
      best = 0
      do i = 0, most
         call try(i*degree, kink%angle, best)
         call try(-i*degree, kink%angle, best)
      end do
      if (factors%of_angle%is_there()) then
         do i = 1, size(factors%of_angle%x)
            a = modulo(factors%of_angle%x(i)*degree - advance%angle, pi)
            if (a <= most*degree) call try(a, kink%angle, best)
            if (pi - a <= most*degree) call try(a - pi, kink%angle, best)
         end do
      end if
      low = max(kink%angle - degree, -most*degree)
      high = min(kink%angle + degree, most*degree)
      do i = 1, digits(low)
         a = high - golden*(high - low)
         b = low + golden*(high - low)
         if (ratio(a) > ratio(b)) then
            high = b
         else
            low = a
         end if
      end do
      call try((low + high)/2, kink%angle, best)
      kink%gain = sum(of(kink%angle)**2)/max(sum(k**2), tiny(best))
      kink%shear = shear_of(of(kink%angle))
   contains
      !> Stress intensity factors of a kink.
      pure function of(angle) result(of_kink)
         real(dp), intent(in) :: angle
         real(dp) :: of_kink(modes)
         of_kink = after_kink(angle, k) + t*of_t_stress(angle)
      end function of

      !> Share of mode II.
      pure real(dp) function shear_of(k)
         real(dp), intent(in) :: k(modes)
         shear_of = k(2)**2/max(sum(k**2), tiny(best))
      end function shear_of

      !> Square of the stress intensity factors of a kink over the factor of its toughness; 0 of one that does not open.
      pure real(dp) function ratio(angle)
         real(dp), intent(in) :: angle
         type(advance_t) :: there
         real(dp) :: of_kink(modes)
         of_kink = of(angle)
         there = advance
         there%angle = advance%angle + angle
         there%shear = shear_of(of_kink)
         ratio = merge(sum(of_kink**2), 0.0_dp, of_kink(1) > 0)/factors%product_at(there)
      end function ratio

      !> Take a kink where it is better.
      pure subroutine try(angle, best_angle, best)
         real(dp), intent(in) :: angle
         real(dp), intent(inout) :: best_angle, best
         real(dp) :: now
         now = ratio(angle)
         if (.not. now > best*(1 + rounding)) return
         best = now
         best_angle = angle
      end subroutine try
   end function best_kink

   !> Stress intensity factors of a short kink, from those of the crack before [Pa sqrt(m)]: the series of Amestoy & Leblond.
   pure function after_kink(angle, k) result(of_kink)
      real(dp), intent(in) :: angle              !! [rad]
      real(dp), intent(in) :: k(modes)
      real(dp) :: of_kink(modes)
      real(dp), parameter :: f11(0:10) = [1.0_dp, -3*pi**2/8, pi**2 - 5*pi**4/128, pi**2/9 - 11*pi**4/72 + 119*pi**6/15360, &
                                          5.07790_dp, -2.88312_dp, -0.0925_dp, 2.996_dp, -4.059_dp, 1.63_dp, 4.1_dp]
      real(dp), parameter :: f12(0:9) = [-3*pi/2, 10*pi/3 + pi**3/16, -2*pi - 133*pi**3/180 + 59*pi**5/1280, 12.313906_dp, &
                                         -7.32433_dp, 1.5793_dp, 4.0216_dp, -6.915_dp, 4.21_dp, 4.56_dp]
      real(dp), parameter :: f21(0:9) = [pi/2, -4*pi/3 - pi**3/48, -2*pi/3 + 13*pi**3/30 - 59*pi**5/3840, -6.176023_dp, &
                                         4.44112_dp, -1.5340_dp, -2.0700_dp, 4.684_dp, -3.95_dp, -1.32_dp]
      real(dp), parameter :: f22(0:10) = [1.0_dp, -4 - 3*pi**2/8, 8.0_dp/3 + 29*pi**2/18 - 5*pi**4/128, &
                                          -32.0_dp/15 - 4*pi**2/9 - 1159*pi**4/7200 + 119*pi**6/15360, &
                                          10.58254_dp, -4.78511_dp, -1.8804_dp, 7.280_dp, -7.591_dp, 0.25_dp, 12.5_dp]
      associate (m => angle/pi)
         of_kink(1) = series(f11, m**2)*k(1) + m*series(f12, m**2)*k(2)
         of_kink(2) = m*series(f21, m**2)*k(1) + series(f22, m**2)*k(2)
      end associate
   end function after_kink

   !> Additional K by a T-stress of 1 at the end of a kink of length 1.
   pure function of_t_stress(angle) result(k)
      real(dp), intent(in) :: angle              !! [rad]
      real(dp) :: k(modes)
      real(dp), parameter :: g1(0:9) = [(2*pi)**1.5_dp, -47.933390_dp, 63.665987_dp, -50.70880_dp, 26.66807_dp, -6.0205_dp, &
                                        -7.314_dp, 10.947_dp, -2.85_dp, -13.7_dp]
      real(dp), parameter :: g2(0:9) = [-2*sqrt(2*pi), 12*sqrt(2*pi), -59.565733_dp, 61.174444_dp, -39.90249_dp, 15.6222_dp, &
                                        3.0343_dp, -12.781_dp, 9.69_dp, 6.62_dp]
      associate (m => angle/pi)
         k = [m**2*series(g1, m**2), m*series(g2, m**2)]
      end associate
   end function of_t_stress

   !> A polynomial, by Horner's rule.
   pure real(dp) function series(coefficient, x)
      real(dp), intent(in) :: coefficient(0:), x
      integer :: i
      series = 0
      do i = ubound(coefficient, 1), 0, -1
         series = series*x + coefficient(i)
      end do
   end function series
end module hampm_kinks
