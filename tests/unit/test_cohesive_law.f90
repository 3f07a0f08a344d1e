!> Laws of traction and separation: tangents against differences, work to part faces against the toughness of each mode mix, whatever the way of the
!> mode mix, the way back, faces that press on each other, and what is stored and dissipated against the work.
program test_cohesive_law
   use hampm_kinds, only: dp, ndim
   use hampm_cohesive_law, only: cohesive_law_t, cohesive_state_t, new_cohesive_law
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: layer = 2e14_dp        !! [Pa/m]
   real(dp), parameter :: s_I = 30e6_dp, s_II = 50e6_dp, g_I = 300, g_II = 900 !! [Pa], [J/m2]
   type(cohesive_law_t) :: laws(5), steep
   integer :: k

   call repeat_random_numbers()
   laws(1) = new_cohesive_law([0.0_dp, 2*g_I/s_I], [s_I, 0.0_dp], [s_II, g_II], .false., 2.0_dp)
   laws(2) = new_cohesive_law([1e-6_dp, 2*g_I/s_I], [s_I, 0.0_dp], [s_II, g_II], .true., 1.0_dp)
   laws(3) = new_cohesive_law([0.0_dp, 5e-6_dp, 3.5e-5_dp], [s_I, s_I/4, 0.0_dp], [s_II, g_II], .true., 1.5_dp)
   laws(4) = new_cohesive_law([1e-6_dp, 4e-6_dp, 2e-5_dp], [s_I/2, s_I, 0.0_dp], [0.0_dp, 0.0_dp], .false., 1.0_dp)
   laws(5) = new_cohesive_law([0.0_dp, 2*g_I/s_I], [s_I, 0.0_dp], [0.0_dp, 0.0_dp], .false., 1.0_dp)
   call check_close(laws(3)%toughness(1), s_I*(5e-6_dp*5/8 + 3e-5_dp/8), 1e-9_dp, 'area of a table')
   do k = 1, size(laws)
      call look_at_tangent(laws(k), 'law '//to_text(k))
      call look_at_toughness(laws(k), 'law '//to_text(k))
      call look_at_histories(laws(k), 'law '//to_text(k))
      call look_at_way_back(laws(k), 'law '//to_text(k))
   end do
   steep = new_cohesive_law([1e-6_dp, 2*g_I/s_I], [s_I, 0.0_dp], [s_II, g_II], .true., 300.0_dp)
   call look_at_toughness(steep, 'a law whose powers alone are below all numbers')
   call check(.not. laws(1)%turns_back(layer), 'a stiff layer leaves the curve as it is')
   call check(laws(1)%turns_back(0.9_dp*s_I**2/(2*g_I)), 'with a soft layer it turns back')
   call finish()

contains

   !> The tangent against central differences of the traction, at random openings of all signs after random damage.
   subroutine look_at_tangent(law, name)
      type(cohesive_law_t), intent(in) :: law
      character(*), intent(in) :: name
      type(cohesive_state_t) :: state, above, below
      real(dp) :: x(5), g(ndim), h, scale, way(ndim), worst, taken(2)
      integer :: trial, d
      worst = 0
      do trial = 1, 400
         call random_number(x)
         g = 4e-5_dp*[2*x(1) - 1, x(2) - 0.2_dp]
         taken = x(3)*x(4)*toughness_of(law, x(5))*[1 - x(5), x(5)]
         state = law%respond(g, layer, x(3)*x(4), taken)
         scale = max(maxval(abs(state%tangent)), 1/law%compliance)
         do d = 1, ndim
            h = 1e-11_dp
            way = 0
            way(d) = h
            above = law%respond(g + way, layer, x(3)*x(4), taken)
            below = law%respond(g - way, layer, x(3)*x(4), taken)
            if ((above%damage > x(3)*x(4)) .neqv. (below%damage > x(3)*x(4))) cycle ! a corner
            if (has_corner(law, g, h, x(3)*x(4), taken)) cycle
            worst = max(worst, maxval(abs((above%traction - below%traction)/(2*h) - state%tangent(:, d)))/scale)
         end do
      end do
      call check_close(worst, 0.0_dp, 1e-6_dp, 'tangent of '//name)
   end subroutine look_at_tangent

   !> Whether a corner of the curve, or the end of contact, is within reach of an opening.
   pure logical function has_corner(law, g, h, damage, taken)
      type(cohesive_law_t), intent(in) :: law
      real(dp), intent(in) :: g(ndim), h, damage, taken(2)
      type(cohesive_state_t) :: above, below
      above = law%respond(g + 2*h*g/norm2(g), layer, damage, taken)
      below = law%respond(g - 2*h*g/norm2(g), layer, damage, taken)
      has_corner = abs(g(2)) < 2*h .or. maxval(abs(above%tangent - below%tangent)) > 1e-3_dp*maxval(abs(below%tangent))
   end function has_corner

   !> Toughness of a mode mix [J/m2].
   pure real(dp) function toughness_of(law, b)
      type(cohesive_law_t), intent(in) :: law
      real(dp), intent(in) :: b
      associate (g => law%toughness, m => law%exponent)
         toughness_of = g(1) + (g(2) - g(1))*b**m
         associate (x => [1 - b, b]/g)
            if (law%by_power) toughness_of = sum((x/maxval(x))**m)**(-1/m)/maxval(x)
         end associate
      end associate
   end function toughness_of

   !> Ways of any mode mix, that turns with the opening, back and forth: the works of opening and of sliding that part the faces fit the criterion, and what
   !> faces take is all of it.
   subroutine look_at_histories(law, name)
      type(cohesive_law_t), intent(in) :: law
      character(*), intent(in) :: name
      integer, parameter :: steps = 100000
      type(cohesive_state_t) :: state, last
      real(dp) :: works(2), taken(2), g(ndim), before(ndim), angle(3), worst
      integer :: trial, i
      worst = 0
      do trial = 1, 20
         call random_number(angle)
         angle = angle*acos(-1.0_dp)/2
         last = cohesive_state_t()
         before = 0
         works = 0
         taken = 0
         do i = 1, steps
            associate (way => i/real(steps, dp))
               g = 3e-4_dp*way*(1 + sin(20*way)/5)
               associate (turned => angle(1) + (angle(2) - angle(1))*min(10*way, 1.0_dp) + angle(3)/4*sin(40*way))
                  g = g*[abs(cos(turned)), abs(sin(turned))]
               end associate
            end associate
            state = law%respond(g, layer, last%damage, taken)
            works = works + (state%traction([2, 1]) + last%traction([2, 1]))*(g([2, 1]) - before([2, 1]))/2
            taken = taken + state%taken
            before = g
            last = state
            if (.not. state%damage < 1) exit
         end do
         call check(.not. state%damage < 1, name//' parts on any way')
         associate (b => works(2)/sum(works))
            worst = max(worst, abs(sum(works)/toughness_of(law, b) - 1), maxval(abs(works - taken))/sum(works))
         end associate
      end do
      call check_close(worst, 0.0_dp, 5e-4_dp, 'works to part '//name//' whatever the way')
   end subroutine look_at_histories

   !> In proportional motion the work to part the faces is the toughness of the mode mix, and what is stored and dissipated on the way is the work.
   subroutine look_at_toughness(law, name)
      type(cohesive_law_t), intent(in) :: law
      character(*), intent(in) :: name
      integer, parameter :: steps = 200000
      real(dp), parameter :: most = 1e-4_dp
      type(cohesive_state_t) :: state, last
      real(dp) :: b, way(ndim), work, taken(2), toughness, off
      integer :: mixture, i
      do mixture = 0, 4
         b = mixture/4.0_dp
         way = [sqrt(b*law%of_sliding), sqrt(1 - b)]
         toughness = toughness_of(law, b)
         last = cohesive_state_t()
         work = 0
         taken = 0
         off = 0
         do i = 1, steps
            state = law%respond(i*most/steps*way, layer, last%damage, taken)
            work = work + dot_product(state%traction + last%traction, way)/2*most/steps
            taken = taken + state%taken
            off = max(off, abs(work - sum(taken) - state%stored))
            last = state
         end do
         call check(.not. state%damage < 1, name//' parts')
         call check_close(work/toughness, 1.0_dp, 1e-6_dp, 'work of '//name//' with B = '//to_text(b))
         call check_close(sum(taken)/toughness, 1.0_dp, 1e-12_dp, 'dissipation of '//name//' with B = '//to_text(b))
         call check_close(off/toughness, 0.0_dp, 1e-6_dp, 'stored and dissipated in '//name//' with B = '//to_text(b))
      end do
   end subroutine look_at_toughness

   !> Back to the origin the way is straight and takes nothing; damage never falls, and what overlaps is pressed apart by the layer.
   subroutine look_at_way_back(law, name)
      type(cohesive_law_t), intent(in) :: law
      character(*), intent(in) :: name
      type(cohesive_state_t) :: there, half, shut
      real(dp), parameter :: g(ndim) = [3e-6_dp, 8e-6_dp], none(2) = 0
      there = law%respond(g, layer, 0.0_dp, none)
      half = law%respond(g/2, layer, there%damage, there%taken)
      call check(there%damage > 0 .and. there%damage < 1, name//' is damaged')
      call check_close(norm2(half%traction - there%traction/2)/norm2(there%traction), 0.0_dp, 1e-14_dp, 'way back of '//name)
      call check_close(sum(half%taken), 0.0_dp, 0.0_dp, 'the way back of '//name//' takes nothing')
      call check_close(half%damage, there%damage, 0.0_dp, 'damage of '//name//' stays')
      shut = law%respond([0.0_dp, -1e-8_dp], layer, 1.0_dp, there%taken)
      call check_close(shut%traction(2)/(-1e-8_dp*layer), 1.0_dp, 1e-14_dp, 'faces of '//name//' press on each other')
   end subroutine look_at_way_back
end program test_cohesive_law
