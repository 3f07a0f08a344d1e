!> Traction and separation of faces that cohesion holds together: irreversible, without rate, in mixed mode.
!>
!> The traction hangs on the opening across the faces and the sliding along them through
!>
!>    lambda**2 = <g_n>**2 + g_s**2,   B = g_s**2/lambda**2,   <g> = max(g, 0).
!>
!> What is opened behind the elastic part, x = o/X of which the traction is S t(x), is a curve of straight parts from x = 0 on: of the laws
!> `linear` and `bilinear` from t = 1 to 0 at x = 2, of `table` that of the user, without the elastic part of its first point. Its area
!> is 1, so that with the strength S(B) and the length X(B) = G(B)/S(B) the toughness G(B) is the area of each mode mix. In front of it, in series,
!> are the elastic opening of the law, at its initial stiffness, and that of the layer of the cells: with e the sum of both compliances
!>
!>    lambda = X x + e S t,
!>
!> a shear of the curve, which does not change its area: the layer, which a coarse mesh makes soft, costs no toughness. It gives the curve an end
!> where it would turn back, e S > X dx/-dt.
!>
!> Toughness and strength of a mode mix:
!>
!>    benzeggagh_kenane   G = G_I + (G_II - G_I) B**m,   S**2 = S_I**2 + (S_II**2 - S_I**2) B**m
!>    power               ((1 - B) G/G_I)**m + (B G/G_II)**m = 1,   (1 - B) S**2/S_I**2 + B S**2/S_II**2 = 1
!>
!> In proportional motion B is G_II/(G_I + G_II), as traction and opening are parallel: T = g/(e + c), with the compliance c = X x/(S t) of what
!> is damaged. c never falls: the largest so far is kept as the damage d = c/(c + c_I), c_I = G_I/S_I**2, which no mesh changes; 1 is parted. Back to
!> the origin the way is straight. Faces that overlap press on each other by the layer alone, whatever the damage.
!>
!> A state (c, B) has dissipated what lies between the curve and the straight way back, G (area up to x - x t/2), in proportional motion; where B changes
!> as damage grows the dissipation of a step is taken at its end.
!>
!> Sources: Camanho & Davila, NASA TM 2002-211737 (mixed mode, power law); Turon, Camanho, Costa & Davila, Mechanics of Materials 38 (2006), 1072
!> (onset that fits the toughness of Benzeggagh & Kenane).
module hampm_cohesive_law
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: cohesive_law_t, cohesive_state_t, new_cohesive_law, most_openings

   integer, parameter :: most_openings = 24      !! of a table

   !> A law.
   type :: cohesive_law_t
      real(dp) :: strength(2) = 1                !! S_I and S_II [Pa]
      real(dp) :: toughness(2) = 1               !! G_I and G_II [J/m2]
      logical :: by_power = .false.              !! how they are mixed
      real(dp) :: exponent = 1                   !! m, 1 at least [-]
      real(dp) :: compliance = 0                 !! elastic, before any damage [m/Pa]
      integer :: n = 2                           !! points of the curve
      real(dp) :: x(most_openings) = 0           !! ascending from 0 [-]
      real(dp) :: t(most_openings) = 0           !! its largest 1, its last 0 [-]
   contains
      procedure :: respond
      procedure :: turns_back
      procedure, private :: mix
      procedure, private :: dissipated
   end type cohesive_law_t

   !> What a law answers, for each area of the faces.
   type :: cohesive_state_t
      real(dp) :: traction(ndim) = 0             !! along the faces and across them, by which they resist [Pa]
      real(dp) :: tangent(ndim, ndim) = 0        !! its change with the opening [Pa/m]
      real(dp) :: secant(ndim, ndim) = 0         !! of the way from the origin, symmetric: of the quadratic energy that is never less than that of the law
                                                 !! and touches it here [Pa/m]
      real(dp) :: damage = 0                     !! d
      real(dp) :: stored = 0                     !! [J/m2]
      real(dp) :: taken = 0                      !! dissipated since the last state that was kept [J/m2]
   end type cohesive_state_t

   !> Strength and length of a mode mix, and their derivatives by B.
   type :: mix_t
      real(dp) :: s, x                           !! [Pa], [m]
      real(dp) :: ds, dx
   end type mix_t

contains

   !> The law of some points of a curve of mode I: openings [m] and tractions [Pa], the last of which is 0.
   pure type(cohesive_law_t) function new_cohesive_law(openings, tractions, of_shear, by_power, exponent) result(law)
      real(dp), intent(in) :: openings(:), tractions(:)
      real(dp), intent(in) :: of_shear(2)        !! strength [Pa] and toughness [J/m2] of mode II; 0: those of mode I
      logical, intent(in) :: by_power
      real(dp), intent(in) :: exponent
      integer :: i
      law%n = size(openings)
      law%compliance = openings(1)/tractions(1)
      associate (o => openings - law%compliance*tractions)
         law%strength(1) = maxval(tractions)
         law%toughness(1) = sum([((tractions(i) + tractions(i - 1))/2*(o(i) - o(i - 1)), i=2, law%n)])
         law%x(:law%n) = o*law%strength(1)/law%toughness(1)
      end associate
      law%t(:law%n) = tractions/law%strength(1)
      law%strength(2) = merge(of_shear(1), law%strength(1), of_shear(1) > 0)
      law%toughness(2) = merge(of_shear(2), law%toughness(1), of_shear(2) > 0)
      law%by_power = by_power
      law%exponent = exponent
   end function new_cohesive_law

   !> Strength and length of a mode mix.
   pure type(mix_t) function mix(self, b)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: b                  !! B
      real(dp) :: g, dg, rise, slope
      associate (s => self%strength, of => self%toughness, m => self%exponent)
         if (self%by_power) then
            rise = (1 - b)/s(1)**2 + b/s(2)**2
            mix%s = 1/sqrt(rise)
            mix%ds = -(1/s(2)**2 - 1/s(1)**2)*mix%s**3/2
            rise = ((1 - b)/of(1))**m + (b/of(2))**m
            slope = -((1 - b)/of(1))**(m - 1)/of(1) + (b/of(2))**(m - 1)/of(2)
            g = rise**(-1/m)
            dg = -slope*g/rise
         else
            mix%s = sqrt(s(1)**2 + (s(2)**2 - s(1)**2)*b**m)
            mix%ds = (s(2)**2 - s(1)**2)*m*b**(m - 1)/(2*mix%s)
            g = of(1) + (of(2) - of(1))*b**m
            dg = (of(2) - of(1))*m*b**(m - 1)
         end if
      end associate
      mix%x = g/mix%s
      mix%dx = (dg - mix%x*mix%ds)/mix%s
   end function mix

   !> Whether the curve of a mode would turn back with a layer of the cells, which then lets faces jump open.
   pure logical function turns_back(self, layer)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: layer              !! stiffness [Pa/m]
      integer :: i
      associate (e => self%compliance + 1/layer, x => self%x, t => self%t, n => self%n)
         turns_back = any([(minval(self%toughness/self%strength**2)*(x(i) - x(i - 1)) <= e*(t(i - 1) - t(i)), i=2, n)])
      end associate
   end function turns_back

   !> What the faces answer to an opening after a damage.
   pure type(cohesive_state_t) function respond(self, opening, layer, damage) result(state)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: opening(ndim)      !! along the faces and across them [m]
      real(dp), intent(in) :: layer              !! stiffness of the layer of the cells [Pa/m]
      real(dp), intent(in) :: damage             !! so far
      type(mix_t) :: of
      real(dp) :: lambda, b, e, c_I, g(ndim), db(ndim), here, before, x, t, secant, slope, a, traction, change(ndim), dx
      integer :: i
      g = [opening(1), max(opening(2), 0.0_dp)]
      lambda = norm2(g)
      b = 0
      if (lambda > 0) b = min((g(1)/lambda)**2, 1.0_dp)
      e = self%compliance + 1/layer
      c_I = self%toughness(1)/self%strength(1)**2
      of = self%mix(b)
      state%damage = damage
      i = 0
      here = e*of%s*self%t(1)
      if (lambda > here) then
         state%damage = 1
         do i = 2, self%n
            before = here
            here = of%x*self%x(i) + e*of%s*self%t(i)
            if (lambda < here) exit
         end do
         if (i <= self%n) then
            x = self%x(i - 1) + (lambda - before)/(here - before)*(self%x(i) - self%x(i - 1))
            t = self%t(i - 1) + (lambda - before)/(here - before)*(self%t(i) - self%t(i - 1))
            state%damage = max(damage, of%x*x/(of%x*x + c_I*of%s*t))
         end if
      end if
      secant = (1 - state%damage)/(e*(1 - state%damage) + c_I*state%damage)
      state%traction = secant*g
      state%tangent(1, 1) = secant
      state%tangent(2, 2) = merge(secant, layer, opening(2) > 0)
      state%secant = state%tangent
      state%stored = secant*lambda**2/2
      if (opening(2) < 0) then
         state%traction(2) = layer*opening(2)
         state%stored = state%stored + layer*opening(2)**2/2
      end if
      if (.not. state%damage > damage) return
      state%taken = self%dissipated(state%damage, of) - self%dissipated(damage, of)
      if (.not. state%damage < 1) return
      slope = (self%t(i) - self%t(i - 1))/(self%x(i) - self%x(i - 1))
      a = self%t(i) - slope*self%x(i)
      dx = -(of%ds*e*a + x*(of%dx + of%ds*e*slope))/(of%x + of%s*e*slope) ! of x by B
      traction = of%s*t
      db = 2*g(1)*g(2)/lambda**4*[g(2), -g(1)]
      change = of%s*slope/(of%x + of%s*e*slope)*g/lambda + (of%ds*t + of%s*slope*dx)*db
      change = change/lambda - traction/lambda**3*g   ! of the secant
      state%tangent(:, 1) = state%tangent(:, 1) + g*change(1)
      state%tangent(:, 2) = state%tangent(:, 2) + g*change(2)
   end function respond

   !> What has been dissipated at a damage in proportional motion of a mode mix [J/m2].
   pure real(dp) function dissipated(self, damage, of)
      class(cohesive_law_t), intent(in) :: self
      real(dp), intent(in) :: damage
      type(mix_t), intent(in) :: of
      real(dp) :: area, ratio, slope, a, x
      integer :: i
      dissipated = of%s*of%x
      if (.not. damage < 1) return
      ratio = self%toughness(1)/self%strength(1)**2*damage/(1 - damage)*of%s/of%x ! x/t
      area = 0
      do i = 2, self%n
         slope = (self%t(i) - self%t(i - 1))/(self%x(i) - self%x(i - 1))
         a = self%t(i) - slope*self%x(i)
         x = self%x(i)
         if (x > ratio*self%t(i)) x = ratio*a/(1 - ratio*slope)
         area = area + (x - self%x(i - 1))*(self%t(i - 1) + a + slope*x)/2
         if (x < self%x(i)) exit
      end do
      dissipated = of%s*of%x*(area - x*(a + slope*x)/2)
   end function dissipated
end module hampm_cohesive_law
