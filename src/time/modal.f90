!> Motion of a linear model by its modes, K x = w**2 M x: each has an exact solution where loads vary linearly in time. Modes that
!> are left out follow the loads statically (mode acceleration).
!>
!>    u = u_0 + sum over modes of x_k q_k + sum over loads of U_l h_l,    q_k'' + alpha q_k' + w_k**2 q_k = x_k . f
!>
!> with the displacement U_l by that part of a load l which no mode has, and the factor h_l of its history; supports may move
!> (`hampm_moved_supports`). A step of time ends at the next row, whatever its length. Theory: docs/explanation/modal.md. Sources:
!> Clough & Penzien, Dynamics of Structures (1993), chapters 12 and 13; Bathe, Finite Element Procedures (1996), section 9.3;
!> Cornwell, Craig & Johnson, Earthq. Eng. Struct. Dyn. 11 (1983) 123-136 (mode acceleration).
module hampm_modal
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_arpack, only: arpack_t, to_multiply, to_solve, to_do_both, is_finished
   use hampm_balance, only: is_linear
   use hampm_failure, only: failure_t, exit_computation
   use hampm_integrator, only: integrator_t, book_step
   use hampm_loads, only: add_load, place_loads
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_moved_supports, only: moved_supports_t, piece_t
   use hampm_newmark, only: move_particles, follow_nodes
   use hampm_nodal_state, only: internal_force
   use hampm_problem, only: problem_t, map_to_grid, refresh_grid, stored_energy, kinetic_energy
   use hampm_results, only: results_t
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness
   use hampm_text, only: to_text, three_digits
   use hampm_time_history, only: time_history_t, most_chords
   implicit none
   private
   public :: modal_t, response_t, respond

   real(dp), parameter :: two_pi = 2*acos(-1.0_dp)
   real(dp), parameter :: shift_of_shear = 0.1_dp !! root of the shift over the rate of a shear wave across the bodies [-]
   real(dp), parameter :: rigid = 1e-7_dp        !! squared frequency over the shift below which a mode is rigid
   real(dp), parameter :: hardly = 1e-13_dp      !! change of a displacement, relative, at which an iteration ends
   integer, parameter :: most_turns = 100        !! of that iteration
   real(dp), parameter :: tolerance = 1e-3_dp    !! part of the strain energy of a load that may follow statically [-]
   integer, parameter :: at_first = 16           !! modes that are tried first
   integer, parameter :: most_by_itself = 256    !! modes that `tolerance` may need

   !> What a mode does in a time in which its load varies linearly.
   type :: response_t
      real(dp) :: q = 0, rate = 0                !! at its end [m kg^0.5], [m kg^0.5/s]
      real(dp) :: sum = 0                        !! integral of q over the time
   end type response_t

   !> The modes, and their motion.
   type, extends(integrator_t) :: modal_t
      integer :: asked = 0                       !! number of modes; 0: as many as `tolerance` needs
      real(dp) :: left_out = 0                   !! the largest such part [-]
      real(dp), allocatable :: square(:)         !! w**2 of each mode, 0 for rigid motion [1/s2]
      real(dp), allocatable :: error(:)          !! of each mode, |x - (w**2 + c) (K + c M)^-1 M x| with |x|**2 = x . M x = 1
      type(stiffness_t), private :: k            !! K + c M
      real(dp), private :: shift = 0             !! c [1/s2]
      real(dp), allocatable, private :: mass(:)  !! part of M beside the matrices of cells [kg], (n_points)
      real(dp), allocatable, private :: shape(:, :) !! x of each mode at the unknowns, (unknowns, modes) [kg^-0.5]
      real(dp), allocatable, private :: q(:), rate(:)
      real(dp), allocatable, private :: first(:, :) !! internal forces at the start [N], (ndim, n_points)
      type(time_history_t), allocatable, private :: history(:) !! h of each load
      real(dp), allocatable, private :: push(:, :) !! x . f of each load at its factor 1; first forces are load 0, moved supports
                                                 !! the last, (modes, 0:loads and motions)
      real(dp), allocatable, private :: static_part(:, :) !! U of these [m], (unknowns, 0:loads and motions)
      real(dp), allocatable, private :: compliance(:, :) !! f . U of each two of them [J]
      real(dp), allocatable, private :: held(:)  !! h of these in the present displacement, (0:loads)
      type(moved_supports_t), private :: supports
   contains
      procedure :: advance
      procedure :: initialise
      procedure :: serialise
      procedure :: describe
      procedure :: report
      procedure, private :: in_modes
   end type modal_t

contains

   !> Find the modes, and their motion at the start: from undeformed bodies, which may move, or from a static equilibrium. Motion
   !> that no mode has is left out. Fails where modes are not found.
   subroutine initialise(self, m, dt, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! not used [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:, :), momentum(:)
      logical :: is_ringing                      ! from rest
      real(dp) :: before
      call refresh_grid(m)
      call find_stiffness(self, m, failure)
      if (failure%failed()) return
      is_ringing = allocated(m%state%displacement)
      call internal_force(m, r)
      self%first = r
      momentum = self%k%unknowns%gather(m%fields%momentum)
      call find_modes(self, m, failure)
      if (failure%failed()) return
      allocate (self%held(0:size(self%history)), source=0.0_dp)
      if (is_ringing) self%held = factors_at(self, m%state%time)
      if (.not. is_ringing) allocate (m%state%displacement, source=0*r)
      allocate (self%q(size(self%square)), source=0.0_dp)
      self%rate = matmul(momentum, self%shape)
      before = kinetic_energy(m)
      m%state%velocity = field_of(m, self, matmul(self%shape, self%rate))
      call follow_nodes(m, m%state%velocity)
      if (m%audit) m%energies%numerical_loss = before - kinetic_energy(m)
   end subroutine initialise

   !> Advance by a step of any length: the motion of each mode, then that of the nodes. Fails where the modes of a run that is
   !> resumed are not found.
   subroutine advance(self, m, dt, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: q(:), held(:), way(:), du(:, :), v(:, :)
      real(dp) :: energy, booked
      integer :: k, n
      if (.not. m%cache%mapped) call map_to_grid(m)
      if (.not. allocated(self%shape)) then
         call refresh_grid(m)
         call find_stiffness(self, m, failure)
         if (.not. failure%failed()) call find_modes(self, m, failure)
         if (failure%failed()) return
      end if
      n = size(self%history)
      energy = 0
      if (m%audit) energy = stored_energy(m) + kinetic_energy(m)
      booked = m%energies%external_work - m%energies%damping_loss
      q = self%q
      way = self%supports%way
      call follow_modes(self, m, dt)
      allocate (held(0:size(self%history)))
      held = factors_at(self, m%state%time + dt)
      du = field_of(m, self, matmul(self%shape, self%q - q) + matmul(self%static_part(:, :n), held - self%held))
      v = field_of(m, self, matmul(self%shape, self%rate))
      do k = 1, self%supports%n
         du = du + (self%supports%way(k) - way(k))*self%supports%shape(:, :, k)
         v = v + self%supports%rate(k)*self%supports%shape(:, :, k)
      end do
      associate (work => m%energies%external_work, s => self%compliance(1:n, 1:n), h => held(1:), before => self%held(1:))
         work = work + (dot_product(h, matmul(s, h)) - dot_product(before, matmul(s, before)))/2
      end associate
      call move_particles(m, dt, du, v, .false.)
      self%held = held
      m%state%velocity = v
      m%state%displacement = m%state%displacement + du
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + (m%energies%external_work - m%energies%damping_loss &
                                               - booked) - (stored_energy(m) + kinetic_energy(m) - energy)
      m%state%time = m%state%time + dt
      call book_step(m, dt)
   end subroutine advance

   !> Follow the modes through a step, from corner to corner of the loads, where these may jump, and book the work of the loads on
   !> them and the loss by damping.
   subroutine follow_modes(self, m, dt)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), dimension(0:size(self%history)) :: h, slope
      real(dp), dimension(size(self%square)) :: p, p_slope, of_loads, of_loads_slope, q, rate, sums
      type(response_t) :: after
      type(piece_t) :: piece
      real(dp) :: time, corner, t, work, gain
      integer :: k
      time = m%state%time
      do while (time < m%state%time + dt)
         corner = min(m%state%time + dt, max(minval([huge(time), self%history%end_of_line(time), &
                                                     self%supports%history%end_of_line(time)]), time + dt/most_chords))
         t = corner - time
         call self%supports%enter(time, corner, self%square, self%q, self%rate, piece, m%energies%external_work)
         q = self%q
         rate = self%rate
         h = factors_at(self, time)
         slope = (factors_at(self, nearest(corner, -1.0_dp)) - h)/t
         of_loads = matmul(self%push(:, 1:size(self%history)), h(1:))
         of_loads_slope = matmul(self%push(:, 1:size(self%history)), slope(1:))
         p = of_loads + self%push(:, 0)*h(0)
         p_slope = of_loads_slope + self%push(:, 0)*slope(0)
         if (self%supports%n > 0) then
            p = p - matmul(self%supports%pull, piece%slope + m%damping_rate*piece%rate)
            p_slope = p_slope - matmul(self%supports%pull, m%damping_rate*piece%slope)
         end if
         do k = 1, size(self%square)
            after = respond(self%square(k), m%damping_rate, p(k), p_slope(k), t, self%q(k), self%rate(k))
            work = (of_loads(k) + t*of_loads_slope(k))*after%q - of_loads(k)*self%q(k) - of_loads_slope(k)*after%sum
            m%energies%external_work = m%energies%external_work + work
            if (m%damping_rate > 0) then
               gain = (after%rate**2 - self%rate(k)**2 + self%square(k)*(after%q**2 - self%q(k)**2))/2
               m%energies%damping_loss = m%energies%damping_loss - gain + (p(k) + t*p_slope(k))*after%q - p(k)*self%q(k) &
                                         - p_slope(k)*after%sum
            end if
            self%q(k) = after%q
            self%rate(k) = after%rate
            sums(k) = after%sum
         end do
         call self%supports%leave(corner, t, m%damping_rate, piece, q, sums, rate, self%rate, self%q, m%energies%external_work, &
                                  m%energies%damping_loss)
         time = corner
      end do
   end subroutine follow_modes

   !> The exact solution of q'' + alpha q' + w**2 q = p + t slope after a time: in closed form, in less than a sixth of a period by
   !> its series, which does not lose what is small beside p/w**2.
   pure type(response_t) function respond(square, alpha, p, slope, t, q, rate) result(after)
      real(dp), intent(in) :: square             !! w**2 [1/s2]
      real(dp), intent(in) :: alpha              !! [1/s]
      real(dp), intent(in) :: p, slope           !! load at the start, and its rate
      real(dp), intent(in) :: t                  !! [s]
      real(dp), intent(in) :: q, rate            !! at the start
      real(dp) :: b, x, c, s                     ! C = exp(-b t) cos(w_d t), S = exp(-b t) sin(w_d t)/w_d, b = alpha/2
      if (square*t**2 < 1) then
         after = by_series(square, alpha, p, slope, t, q, rate)
         return
      end if
      b = alpha/2
      x = square - b**2
      if (abs(x)*t**2 < 1e-8_dp) then
         c = exp(-b*t)*(1 - x*t**2/2)
         s = exp(-b*t)*t*(1 - x*t**2/6)
      else if (x > 0) then
         x = sqrt(x)
         c = exp(-b*t)*cos(x*t)
         s = exp(-b*t)*sin(x*t)/x
      else
         x = sqrt(-x)
         c = (exp(-square/(b + x)*t) + exp(-(b + x)*t))/2
         s = (exp(-square/(b + x)*t) - exp(-(b + x)*t))/(2*x)
      end if
      associate (steady => (p - alpha*slope/square)/square, drift => slope/square)
         after%q = steady + drift*t + (q - steady)*(c + b*s) + (rate - drift)*s
         after%rate = drift - square*s*(q - steady) + (c - b*s)*(rate - drift)
      end associate
      after%sum = (p*t + slope*t**2/2 - (after%rate - rate) - alpha*(after%q - q))/square
   end function respond

   !> The same by the exponential of the matrix of q, its rate, its integral, p and slope, in units of a piece of the time: by
   !> Taylor's series in the piece, and by squaring.
   pure type(response_t) function by_series(square, alpha, p, slope, t, q, rate) result(after)
      real(dp), intent(in) :: square, alpha, p, slope, t, q, rate !! as those of `respond`
      integer, parameter :: most_pieces = 16
      real(dp) :: matrix(5, 5), y(5), piece
      integer :: halvings, k
      halvings = max(0, exponent(alpha*t))
      piece = scale(t, -halvings)
      y = [q, rate*piece, 0.0_dp, p*piece**2, slope*piece**3]
      if (2.0_dp**halvings <= most_pieces) then
         do k = 1, 2**halvings
            y = after_piece(y)
         end do
      else
         matrix = 0
         do k = 1, 5
            matrix(k, k) = 1
            matrix(:, k) = after_piece(matrix(:, k))
         end do
         do k = 1, halvings
            matrix = matmul(matrix, matrix)
         end do
         y = matmul(matrix, y)
      end if
      after = response_t(y(1), y(2)/piece, y(3)*piece)

   contains

      !> The five values after a piece.
      pure function after_piece(first) result(y)
         real(dp), intent(in) :: first(5)
         real(dp) :: y(5), term(5)
         integer :: n
         y = first
         term = first
         do n = 1, 20
            term = [term(2), term(4) - square*piece**2*term(1) - alpha*piece*term(2), term(1), term(5), 0.0_dp]/n
            y = y + term
         end do
      end function after_piece
   end function by_series

   !> Factors of all loads at a time, of the first forces as load 0.
   pure function factors_at(self, time) result(h)
      class(modal_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: h(0:size(self%history))
      integer :: k
      h(0) = 1
      do k = 1, size(self%history)
         h(k) = self%history(k)%factor(time)
      end do
   end function factors_at

   !> Factorise K + c M. The shift c makes it definite where bodies are free.
   subroutine find_stiffness(self, m, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      type(stiffness_kind_t) :: kind
      integer :: i
      if (.not. is_linear(m)) then
         call failure%report(exit_computation, 'a model that is not linear has no modes')
         return
      end if
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, self%mass)
      associate (x => m%particles%reference(:m%particles%n, :))
         self%shift = (shift_of_shear*maxval([(m%materials(i)%shear_wave_speed(), i=1, size(m%materials))])/ &
                       maxval(maxval(x, dim=1) - minval(x, dim=1) + m%grid%finest_cell))**2
      end associate
      kind%is_tangent = .true.
      kind%on_interfaces = .false.
      kind%solver = 'direct'
      kind%mass_factor = self%shift
      allocate (kind%rigid_constraints(0))
      call factorise_stiffness(m, kind, self%k, unsolved)
      if (unsolved%failed()) call failure%report(unsolved%code, 'the stiffness cannot be factorised: '//unsolved%message// &
                                                 ', as where cells hold too few particles')
   end subroutine find_stiffness

   !> Find the modes, and the parts of the loads in them and beside them: twice as many until the latter are small, or as many as
   !> are asked for.
   subroutine find_modes(self, m, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: force(:, :)
      integer :: most, wanted
      most = self%k%unknowns%n - 1
      wanted = self%asked
      if (wanted == 0) wanted = at_first
      call self%supports%find_motions(m)
      call self%supports%find_forces_against(m)
      call find_forces(self, m, force)
      do
         call search(self, m, min(wanted, most), failure)
         if (failure%failed()) return
         if (.not. any(self%square > 0)) then
            call failure%report(exit_computation, to_text(size(self%square))//' modes leave out motion as a whole, or are '// &
                                'all of it: use more &method modes')
            return
         end if
         call find_static_part(self, m, force, failure)
         if (failure%failed()) return
         if (wanted >= min(most, most_by_itself) .or. self%asked > 0 .or. self%left_out <= tolerance) exit
         wanted = 2*wanted
      end do
      call take_supports(self, m)
      call find_errors(self, m, failure)
   end subroutine find_modes

   !> Search for some modes. Fails where they are not found.
   subroutine search(self, m, wanted, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      integer, intent(in) :: wanted
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: golden = (sqrt(5.0_dp) - 1)/2
      type(arpack_t) :: arpack
      type(failure_t) :: unsolved
      integer :: task, i
      if (wanted < 1) then
         call unsolved%report(exit_computation, 'the model has too few nodes that move')
      else
         call arpack%start([(modulo(i*golden, 1.0_dp) - 0.5_dp, i=1, self%k%unknowns%n)], wanted)
      end if
      do while (.not. unsolved%failed())
         call arpack%next(task)
         if (task == is_finished) exit
         if (task == to_multiply .or. task == to_do_both) call by_mass(self, m, arpack%x, arpack%y)
         if (task == to_do_both) arpack%x = arpack%y
         if (task == to_solve .or. task == to_do_both) call solve(self, arpack%x, arpack%y, unsolved)
      end do
      if (.not. unsolved%failed()) call arpack%finish(self%square, self%shape, unsolved)
      if (unsolved%failed()) then
         call failure%report(unsolved%code, to_text(wanted)//' modes are not found: '//unsolved%message)
         return
      end if
      self%square = self%shift*merge(self%square, 0.0_dp, self%square > rigid)
   end subroutine search

   !> Forces of the start, and of each load at its factor 1, at the unknowns; loads of one number are one. Their histories. The
   !> forces against moved supports come last.
   subroutine find_forces(self, m, force)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :) !! [N], (unknowns, 0:loads and motions)
      real(dp), allocatable :: of_load(:, :)
      integer :: numbers(size(m%loads)), k, l, n
      numbers = m%loads%number
      n = 0
      allocate (of_load(ndim, m%grid%n_points))
      allocate (force(self%k%unknowns%n, 0:size(numbers) + self%supports%n))
      force(:, 0) = self%k%unknowns%gather(self%first)
      if (allocated(self%history)) deallocate (self%history)
      allocate (self%history(size(numbers)))
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(numbers)
         if (any(numbers(:k - 1) == numbers(k))) cycle
         of_load = 0
         do l = k, size(numbers)
            if (numbers(l) == numbers(k)) call add_load(m%loads(l), 1.0_dp, of_load)
         end do
         call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, of_load)
         n = n + 1
         self%history(n) = m%loads(k)%history
         force(:, n) = self%k%unknowns%gather(of_load)
      end do
      self%history = self%history(:n)
      do k = 1, self%supports%n
         force(:, n + k) = self%k%unknowns%gather(self%supports%against(:, :, k))
      end do
      force = force(:, :n + self%supports%n)
   end subroutine find_forces

   !> Give the supports the displacement of the free nodes that follows them statically, which is in the modes and beside them, and
   !> what its inertia is to the modes.
   subroutine take_supports(self, m)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), allocatable :: free(:, :, :), momentum(:, :, :)
      integer :: k, n
      n = size(self%history)
      allocate (free(ndim, m%grid%n_points, self%supports%n))
      do k = 1, self%supports%n
         free(:, :, k) = field_of(m, self, self%static_part(:, n + k) + matmul(self%shape, self%in_modes(n + k)))
      end do
      call self%supports%find_energies(m, free, self%first, self%mass, momentum)
      if (allocated(self%supports%pull)) deallocate (self%supports%pull)
      allocate (self%supports%pull(size(self%square), self%supports%n))
      do k = 1, self%supports%n
         self%supports%pull(:, k) = matmul(self%k%unknowns%gather(momentum(:, :, k)), self%shape)
      end do
   end subroutine take_supports

   !> The static displacement of the strained modes by a load.
   pure function in_modes(self, load) result(q)
      class(modal_t), intent(in) :: self
      integer, intent(in) :: load
      real(dp) :: q(size(self%square))
      q = merge(self%push(:, load)/max(self%square, tiny(1.0_dp)), 0.0_dp, self%square > 0)
   end function in_modes

   !> The part of each load in each mode, and the displacement U by the rest of it, K U = f - sum over modes of M x (x . f), by
   !> iteration with K + c M: its error falls by c/(w**2 + c) of the lowest mode that is left out. Fails where that is nearly 1.
   !> The measure of what is left out is strain energy for a load, and mass for the displacement that follows a support.
   subroutine find_static_part(self, m, force, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, 0:)       !! (unknowns, 0:loads and motions of supports)
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(size(force, 1)) :: rest, product, change
      real(dp) :: of_modes, beside
      integer :: l, turn
      if (allocated(self%static_part)) deallocate (self%push, self%static_part, self%compliance)
      associate (n => ubound(force, 2), x => self%shape)
         allocate (self%push(size(x, 2), 0:n), self%static_part(size(x, 1), 0:n), self%compliance(0:n, 0:n))
         self%left_out = 0
         do l = 0, n
            self%push(:, l) = matmul(force(:, l), x)
            call by_mass(self, m, matmul(x, self%push(:, l)), product)
            rest = force(:, l) - product
            self%static_part(:, l) = 0
            do turn = 1, most_turns
               call solve(self, rest, change, failure)
               call by_mass(self, m, change, product)
               change = change - matmul(x, matmul(product, x))
               call by_mass(self, m, change, product)
               self%static_part(:, l) = self%static_part(:, l) + change
               if (maxval(abs(change)) <= hardly*maxval(abs(self%static_part(:, l)))) exit
               rest = product
            end do
            if (turn > most_turns) then
               call failure%report(exit_computation, 'what '//to_text(size(x, 2))//' modes leave out is not found: use more '// &
                                   '&method modes')
               return
            end if
         end do
         self%static_part = self%static_part/self%shift
         self%compliance = matmul(transpose(force), self%static_part)
         self%compliance = (self%compliance + transpose(self%compliance))/2
         do l = 0, n
            of_modes = sum(self%push(:, l)**2/self%square, mask=self%square > 0)
            beside = self%compliance(l, l)
            if (l > size(self%history)) then
               of_modes = sum(self%in_modes(l)**2)
               call by_mass(self, m, self%static_part(:, l), product)
               beside = dot_product(product, self%static_part(:, l))
            end if
            if (beside > 0) self%left_out = max(self%left_out, beside/(beside + of_modes))
         end do
      end associate
   end subroutine find_static_part

   !> How far each mode is from what K and M make of it.
   subroutine find_errors(self, m, failure)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(self%k%unknowns%n) :: product, d
      integer :: k
      if (allocated(self%error)) deallocate (self%error)
      allocate (self%error(size(self%square)))
      do k = 1, size(self%square)
         call by_mass(self, m, self%shape(:, k), product)
         call solve(self, product, d, failure)
         d = self%shape(:, k) - (self%square(k)/self%shift + 1)*d
         call by_mass(self, m, d, product)
         self%error(k) = sqrt(max(dot_product(d, product), 0.0_dp))
      end do
   end subroutine find_errors

   !> y = c (K + c M)^-1 x at the unknowns: K/c + M has a shift of 1, and eigenvalues without units.
   subroutine solve(self, x, y, failure)
      class(modal_t), intent(inout) :: self
      real(dp), intent(in), contiguous :: x(:)
      real(dp), intent(out), contiguous :: y(:)
      type(failure_t), intent(inout) :: failure
      call self%k%solve_for_unknowns(x, y, failure)
      y = self%shift*y
   end subroutine solve

   !> y = M x at the unknowns.
   subroutine by_mass(self, m, x, y)
      class(modal_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: x(:)
      real(dp), intent(out) :: y(:)
      real(dp), allocatable :: product(:, :)
      allocate (product(ndim, m%grid%n_points))
      call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, field_of(m, self, x), product)
      y = self%k%unknowns%gather(product)
   end subroutine by_mass

   !> A field of the points by its values at the unknowns, 0 where components are held.
   function field_of(m, self, x) result(field)
      type(problem_t), intent(in) :: m
      class(modal_t), intent(in) :: self
      real(dp), intent(in) :: x(:)
      real(dp), allocatable :: field(:, :)       !! (ndim, n_points)
      allocate (field(ndim, m%grid%n_points), source=0.0_dp)
      call self%k%unknowns%scatter(x, field)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, field)
   end function field_of

   !> Archive the motion of the modes; they are found again.
   subroutine serialise(self, m, archive)
      class(modal_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      integer :: n(2)
      n = 0
      if (allocated(self%q)) n = [size(self%q), size(self%history)]
      call archive%archive_integers('sizes_of_modes', 2, n)
      if (n(1) == 0) return
      if (archive%is_read) allocate (self%q(n(1)), self%rate(n(1)), self%first(ndim, m%grid%n_points), self%held(0:n(2)), &
                                     m%state%displacement(ndim, m%grid%n_points), m%state%velocity(ndim, m%grid%n_points))
      call archive%archive_reals('modal_displacement', n(1), self%q)
      call archive%archive_reals('modal_velocity', n(1), self%rate)
      call archive%archive_reals('first_forces', size(self%first), self%first)
      call archive%archive_reals('held_factors', n(2) + 1, self%held)
      call self%supports%serialise(m%grid%n_points, archive)
      call archive%archive_reals('nodal_displacement', size(m%state%displacement), m%state%displacement)
      call archive%archive_reals('nodal_velocity', size(m%state%velocity), m%state%velocity)
   end subroutine serialise

   !> Write the modes into the result: /modes with the frequency, the error and the part of the mass of each mode in each direction,
   !> and its displacement of each particle, the largest component being 1.
   subroutine describe(self, m, results, failure)
      class(modal_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable, dimension(:, :) :: shape, part, field, along, product
      integer :: k, i, d
      associate (n => m%particles%n, modes => size(self%square))
         allocate (shape(ndim, n*modes), part(ndim, modes), along(ndim, m%grid%n_points), product(ndim, m%grid%n_points))
         do k = 1, modes
            field = field_of(m, self, self%shape(:, k))
            do i = 1, n
               shape(:, (k - 1)*n + i) = matmul(field(:, m%nodes_of(i)), m%functions_of(i))
            end do
            associate (of_mode => shape(:, (k - 1)*n + 1:k*n))
               of_mode = of_mode/maxval(abs(of_mode))
            end associate
            call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, field, product)
            do d = 1, ndim
               along = 0
               along(d, :) = 1
               part(d, k) = sum(product(:, :m%grid%n_nodes)*along(:, :m%grid%n_nodes))**2/sum(m%particles%mass(:n))
            end do
         end do
         call results%add_table('/modes', 'frequency', 'Hz', 'frequency', reshape(sqrt(self%square)/two_pi, [1, modes]), failure)
         call results%add_table('/modes', 'error', '1', 'error of the mode', reshape(self%error, [1, modes]), failure)
         call results%add_table('/modes', 'participation', '1', 'part of the mass', part, failure)
         call results%add_table('/modes', 'id', '1', 'number of the particle', reshape(real(m%particles%id(:n), dp), [1, n]), &
                                failure)
         call results%add_table('/modes', 'position', 'm', 'initial position', transpose(m%particles%reference(:n, :)), failure)
         call results%add_table('/modes', 'shape', '1', 'displacement of the particles', shape, failure)
         call results%add_attribute('/modes', 'left_out', self%left_out, failure)
      end associate
   end subroutine describe

   !> In words: how many modes there are, and what they leave out.
   function report(self) result(text)
      class(modal_t), intent(in) :: self
      character(:), allocatable :: text
      real(dp), parameter :: rounding = 1e-9_dp  ! [%]
      text = ''
      if (.not. allocated(self%square)) return
      text = to_text(size(self%square))//' modes, up to '//three_digits(sqrt(maxval(self%square))/two_pi)//' Hz; '// &
             three_digits(max(100*self%left_out, rounding))//' % of the strain energy of a load'
      if (self%supports%n > 0) text = text//', or of the mass that follows a support,'
      text = text//' is left to modes above, which follow it statically'
   end function report
end module hampm_modal
