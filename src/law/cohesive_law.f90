!> Traction-separation law of crack faces: irreversible, rate-independent, in mixed mode, independent of the path of the mode mix.
!>
!> Mode I is a piecewise linear curve without the elastic part of the openings: x = o/X, t = T/S_I, X = G_I/S_I, of area 1. The
!> damage p = (area up to x) - x t/2 is the dissipated part of the toughness; its largest value is stored, 1 failed. Unloading is
!> straight to the origin.
!>
!>    T_n = g_n/(e + c),   T_s = g_s/(k (e + c)),   c = G_I/S_I**2 x/t,   k = (G_II/S_II**2)/(G_I/S_I**2)
!>
!> e is the compliance of the elastic part and the layer of the cells, in series: it shears the curve and keeps its area, so a
!> coarse mesh changes no toughness (docs/explanation/cohesion.md). Sources: Camanho & Davila, NASA TM 2002-211737 (mixed mode,
!> power law); Turon, Camanho, Costa & Renart, Composite Structures 92 (2010), 1857 (stiffness of sliding from strengths and
!> toughnesses of both modes).
module hampm_cohesive_law
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm, in_plane
   implicit none
   private
   public :: cohesive_law_t, cohesive_state_t, new_cohesive_law, most_openings

   integer, parameter :: most_openings = 24      !! of a table

   !> A law.
   type :: cohesive_law_t
      real(dp) :: toughness(2) = 1               !! G_I and G_II [J/m2]
      logical :: by_power = .false.              !! how they are mixed
      real(dp) :: exponent = 1                   !! m, 1 at least [-]
      real(dp) :: elastic = 0                    !! compliance before any damage [m/Pa]
      real(dp) :: compliance = 1                 !! G_I/S_I**2 [m/Pa]
      real(dp) :: of_sliding = 1                 !! k [-]
      integer :: n = 2                           !! points of the curve
      real(dp) :: x(most_openings) = 0           !! ascending from 0 [-]
      real(dp) :: t(most_openings) = 0           !! its largest 1, its last 0 [-]
      real(dp) :: p(most_openings) = 0           !! ascending from 0 to 1 [-]
   contains
      procedure :: respond
      procedure :: turns_back
      procedure, private :: find_mode_mix
      procedure, private :: find_remaining
   end type cohesive_law_t

   !> Response of a law, per area of the faces.
   type :: cohesive_state_t
      real(dp) :: traction(ndim) = 0             !! resistance along the faces and across them [Pa]
      real(dp) :: tangent(ndim, ndim) = 0        !! its change with the opening [Pa/m]
      real(dp) :: secant(ndim, ndim) = 0         !! from the origin, symmetric; its quadratic energy is never below the law's
                                                 !! and equal to it here [Pa/m]
      real(dp) :: damage = 0                     !! p
      real(dp) :: stored = 0                     !! [J/m2]
      real(dp) :: taken(2) = 0                   !! by opening and by sliding, since the last state that was kept [J/m2]
   end type cohesive_state_t

contains

   !> The law of some points of a curve of mode I: openings [m] and tractions [Pa], the last of which is 0.
   pure type(cohesive_law_t) function new_cohesive_law(openings, tractions, of_shear, by_power, exponent) result(law)
      real(dp), intent(in) :: openings(:), tractions(:)
      real(dp), intent(in) :: of_shear(2)        !! strength [Pa] and toughness [J/m2] of mode II; 0: as in mode I
      logical, intent(in) :: by_power
      real(dp), intent(in) :: exponent
      real(dp) :: strength(2), o(size(openings)) ! S_I and S_II [Pa]; openings without their elastic part [m]
      integer :: i
      law%n = size(openings)
      law%elastic = openings(1)/tractions(1)
      strength = maxval(tractions)
      if (of_shear(1) > 0) strength(2) = of_shear(1)
      o = openings - law%elastic*tractions
      associate (n => law%n, x => law%x, t => law%t)
         law%toughness = sum((tractions(2:) + tractions(:n - 1))/2*(o(2:) - o(:n - 1)))
         if (of_shear(2) > 0) law%toughness(2) = of_shear(2)
         x(:n) = o*strength(1)/law%toughness(1)
         t(:n) = tractions/strength(1)
         do i = 2, n
            law%p(i) = law%p(i - 1) + (x(i)*t(i - 1) - x(i - 1)*t(i))/2
         end do
         law%p(:n) = law%p(:n)/law%p(n)
      end associate
      law%compliance = law%toughness(1)/strength(1)**2
      law%of_sliding = law%toughness(2)/strength(2)**2/law%compliance
      law%by_power = by_power
      law%exponent = exponent
   end function new_cohesive_law

   !> Whether the curve would turn back with a layer of the cells, which then lets faces jump open.
   pure logical function turns_back(self, layer)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: layer              !! stiffness [Pa/m]
      associate (e => self%elastic + 1/layer, x => self%x, t => self%t, n => self%n)
         turns_back = any(self%compliance*(x(2:n) - x(:n - 1)) <= e*(t(:n - 1) - t(2:n)))
      end associate
   end function turns_back

   !> Toughness of a mode mix [J/m2]; m is the exponent:
   !>
   !>    benzeggagh_kenane   G_c = G_I + (G_II - G_I) B**m
   !>    power               ((1 - B) G_c/G_I)**m + (B G_c/G_II)**m = 1
   pure subroutine find_mode_mix(self, b, toughness, slope)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: b                  !! B
      real(dp), intent(out) :: toughness
      real(dp), intent(out) :: slope             !! its change with B [J/m2]
      real(dp) :: x(2), largest, sum_of_both
      associate (of => self%toughness, m => self%exponent)
         if (self%by_power) then
            x = [1 - b, b]/of
            largest = maxval(x)                  ! powers of x itself may be below all numbers
            sum_of_both = sum((x/largest)**m)
            toughness = sum_of_both**(-1/m)/largest
            slope = ((x(1)/largest)**(m - 1)/of(1) - (x(2)/largest)**(m - 1)/of(2))*toughness/(largest*sum_of_both)
         else
            toughness = of(1) + (of(2) - of(1))*b**m
            slope = (of(2) - of(1))*m*b**(m - 1)
         end if
      end associate
   end subroutine find_mode_mix

   !> Dissipation from a damage on over the remaining damage, G = w/(1 - p) [J/m2], of faces that have dissipated W = W_I + W_II and
   !> go on with the mode mix B until the sums satisfy the criterion: W + w = G_c((W_II + w B)/(W + w)). G is constant while B is.
   pure subroutine find_remaining(self, b, damage, taken, toughness, slope)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: b                  !! B
      real(dp), intent(in) :: damage             !! below 1
      real(dp), intent(in) :: taken(2)           !! W_I and W_II [J/m2]
      real(dp), intent(out) :: toughness
      real(dp), intent(out) :: slope             !! its change with B [J/m2]
      integer, parameter :: most = 100
      real(dp), parameter :: steep = 0.1_dp      ! least rate at which Newton's method continues, else by halves
      real(dp) :: w, low, high, mixture, of_all, off, rate
      integer :: i
      call self%find_mode_mix(b, w, slope)
      w = (1 - damage)*w
      low = 0
      high = sum(self%toughness)
      do i = 1, most
         mixture = min(max((taken(2) + w*b)/(sum(taken) + w), 0.0_dp), 1.0_dp)
         call self%find_mode_mix(mixture, of_all, slope)
         off = sum(taken) + w - of_all
         rate = 1 - slope*(b - mixture)/(sum(taken) + w)
         if (off > 0) high = w
         if (off < 0) low = w
         if (.not. abs(off) > 1e-14_dp*of_all) exit
         if (rate > steep) w = w - off/rate
         if (.not. (rate > steep .and. w > low .and. w < high)) w = (low + high)/2
      end do
      toughness = w/(1 - damage)
      slope = slope*toughness/((sum(taken) + w)*max(rate, steep))
   end subroutine find_remaining

   !> Response of the faces to an opening after a damage. With lambda**2 = <g_n>**2 + g_s**2/k both modes have one law: as p grows
   !> by dp the faces dissipate G dp, the part B = g_s**2/(k lambda**2) of it by sliding (B at the end of the step), where
   !> lambda = sqrt(G) (e t + G_I/S_I**2 x)/sqrt(G_I/S_I**2). Closed faces press on each other by the layer alone, at any damage.
   pure type(cohesive_state_t) function respond(self, opening, layer, damage, taken) result(state)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: opening(ndim)      !! along the faces and across them [m]
      real(dp), intent(in) :: layer              !! stiffness of the layer of the cells [Pa/m]
      real(dp), intent(in) :: damage             !! so far
      real(dp), intent(in) :: taken(2)           !! so far, by opening and by sliding [J/m2]
      real(dp) :: g(ndim), lambda, b, e, toughness, slope, reached(self%n), x, t, secant, change(ndim), scale(ndim)
      integer :: i
      scale = in_plane(1/sqrt(self%of_sliding), 1.0_dp)
      g = scale*in_plane(opening(1), max(opening(2), 0.0_dp))
      lambda = norm(g)
      b = 0
      if (lambda > 0) b = min((g(1)/lambda)**2, 1.0_dp)
      e = self%elastic + 1/layer
      state%damage = damage
      secant = 0
      associate (c => self%compliance, n => self%n, p => self%p)
         if (damage < 1) then
            call self%find_remaining(b, damage, taken, toughness, slope)
            reached = sqrt(toughness/c)*(e*self%t(:n) + c*self%x(:n))
            i = findloc(lambda < reached, .true., dim=1)
            if (i == 0) state%damage = 1
            if (i > 1) state%damage = max(damage, min(1.0_dp, &
                                          p(i - 1) + (lambda - reached(i - 1))/(reached(i) - reached(i - 1))*(p(i) - p(i - 1))))
            state%taken = toughness*(state%damage - damage)*[1 - b, b]
         end if
         if (state%damage < 1) then
            i = findloc(state%damage < p(:n), .true., dim=1)
            associate (part => (state%damage - p(i - 1))/(p(i) - p(i - 1)), dt => self%t(i) - self%t(i - 1), &
                       dx => self%x(i) - self%x(i - 1))
               t = self%t(i - 1) + part*dt
               x = self%x(i - 1) + part*dx
               secant = t/(e*t + c*x)
               if (state%damage > damage) then
                  change = (g/lambda - lambda*slope/toughness*g(1)*g(2)/lambda**4*in_plane(g(2), -g(1))) &
                           /(reached(i) - reached(i - 1))
                  change = c*(dt*x - t*dx)/(e*t + c*x)**2*change ! of the secant
                  state%tangent(:, 1) = g*change(1)
                  state%tangent(:, 2) = g*change(2)
               end if
            end associate
         end if
      end associate
      do i = 1, ndim
         state%secant(i, i) = secant
         state%tangent(i, i) = state%tangent(i, i) + secant
         state%secant(:, i) = scale*state%secant(:, i)*scale(i)
         state%tangent(:, i) = scale*state%tangent(:, i)*scale(i)
      end do
      state%traction = secant*scale*g
      state%stored = secant*lambda**2/2
      if (opening(2) > 0) return
      state%secant(2, 2) = layer
      state%tangent(2, 2) = layer
      state%traction(2) = layer*opening(2)
      state%stored = state%stored + layer*opening(2)**2/2
   end function respond
end module hampm_cohesive_law
