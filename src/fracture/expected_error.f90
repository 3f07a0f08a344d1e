!> Energy release rate of a static model, and its estimated error on the mesh of the run before the first step; specimens in
!> docs/explanation/estimated_errors.md.
!>
!> The derivative of the displacement by the place of each tip takes one solution each with the factorised stiffness. All material
!> moves with v = q e, e being the direction of the tip, q 1 around it and 0 beyond the largest disc. With M = I + a grad v the
!> stiffness is that of the gradients grad u M**-1 in the volumes det M dV; since K u = f for each a, with loads at fixed places,
!>
!>    K du/da = -K' u,   (K' u) . w = int { C : (-H G) + s div v - s G**T } : grad w dV,   H = grad u, G = grad v, s = C : H.
!>
!> In axisymmetric material H_33 = u_r/r, G_33 = v_r/r and w_r/r are components of these gradients. Around the tip v causes no
!> strain: there du/da is the change at places that move with the tip. Source: Lin & Abel (1988).
module hampm_expected_error
   use hampm_kinds, only: dp, ndim
   use hampm_condensation, only: condensation_t, new_condensation
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes, tip_field_t
   use hampm_estimated_errors, only: hardly, uncertainty
   use hampm_interface_points, only: interfaces_t, contact, overlap_of, along_faces, length_along
   use hampm_jumps, only: jump_of
   use hampm_problem, only: problem_t, is_weighed, refresh_grid
   use hampm_quadratic_tip_offset, only: quadratic_tip_offset
   use hampm_rigid_motions, only: free_motions_t, find_free_motions, take_inertia, take_motion_as_whole
   use hampm_stiffness, only: stiffness_t, is_larger, kind_at_rest, new_stiffness, full_loads
   use hampm_element_stiffness, only: derivatives_at, n_derivatives
   use hampm_tip_domain, only: tip_domain_t, weight_nodes, elements_of, fields_at
   use hampm_failure, only: failure_t
   use hampm_loads, only: add_load, factors_at, largest_factors
   use hampm_mass_solver, only: solve_aside
   use hampm_material, only: material_t
   use hampm_tensors, only: norm, identity, trace
   use hampm_tolerance, only: bounded_ratio
   use hampm_missing_energy, only: gradient_of, gradient_by, stress_of, pair_t, missing_energies
   implicit none
   private
   public :: static_model_t, find_equilibrium, static_crack_t, find_static_crack, static_tips_t, find_static_tips, &
             error_by_lengths, place_of_tip, lost_by_locking, disc_of_shifts, no_work, weight_moved

   !> A static model under its loads, scaled down to small gradients.
   type :: static_model_t
      logical :: known = .false.
      real(dp), allocatable :: factors(:)        !! of these loads [-]
      real(dp) :: scale = 1                      !! scale of these loads [-]
      real(dp) :: energy = 0                     !! half of the work of the forces [J]
      real(dp), allocatable :: u(:, :)           !! displacement of the points [m], (ndim, n_points)
      real(dp), allocatable :: divergence(:, :)  !! (div stress)/rho: the acceleration of what nothing holds, less that by body
                                                 !! loads; 0 for fixed components [m/s2], (ndim, n_points)
      type(free_motions_t), private :: free      !! its rigid-body modes then
   end type static_model_t

   !> The model, and its change with the places of its tips.
   type, extends(static_model_t) :: static_tips_t
      integer, allocatable :: group(:)           !! by tip: tips of one group are so far apart that they move together
      real(dp), allocatable :: moved(:, :, :)    !! its derivative by the way of the tips of each [-], (ndim, n_points, groups)
      real(dp), allocatable :: dual(:, :, :, :)  !! displacement by forces whose product with another is K of a mode
                                                 !! of a tip [Pa sqrt(m) m/J], (ndim, n_points, modes, groups)
   end type static_tips_t

   integer, parameter :: most_turns = 60             !! of solving and looking which faces part: each opens a point at least
   integer, parameter :: most_pairs = 3              !! behind the tip that are closed

   !> Unknowns of the largest problem solved: about a gigabyte.
   integer, parameter :: most_unknowns = 500000

   !> Shortness of the crack of the cells, in cells at the tip, by mode: short + by_stiffness x/(1 + x/stiff), x = lambda/mu of the
   !> plane, as nearly incompressible cells are too stiff, more so in sliding. With 2 by 2 particles a cell, a centre crack of 28
   !> cells (up to 0.45: 12) in plane strain has J as if short by 0.21, 0.29, 0.56, 1.8 and 4.3 cells in mode I with Poisson's ratio
   !> 0.3, 0.45, 0.49, 0.499 and 0.4999, by 0.33, 0.58, 1.3, 4.2 and 8.5 in mode II; the nodal force lacks up to a ninth less; with
   !> 4 by 4 particles both lack a ninth more.
   real(dp), parameter :: short(modes) = [0.205_dp, 0.275_dp], by_stiffness(modes) = [0.0079_dp, 0.028_dp], &
                          stiff(modes) = [400, 200]

   !> Radius around the tip, in cells there, of the error by shortness. Middles of cells are at round distances from many tips, on
   !> either side by rounding.
   real(dp), parameter :: tip_zone = 3 + 1e-6_dp

   real(dp), parameter :: most_level = 0.9_dp    !! part of the largest disc of a tip in which cells move with it undeformed

   !> Place error of a tip inside a bilinear cell, in cells, at most for 95 % of random places and directions, by J in each mode and
   !> by K (docs/explanation/estimated_errors.md); for quadratic cells half of it.
   real(dp), parameter :: astray_of_j(modes) = [0.15_dp, 0.19_dp], astray_of_k = 0.1_dp

   !> The same by mode over that, in cells with one particle, which hardly resists their bending: faces slide as if the crack were
   !> longer by 0.47 +- 0.31 cells, and open as with more particles. A K is off by more for the other one, too.
   real(dp), parameter :: of_lone(modes) = [1, 3]

   !> Error of K by the fields beside the singular one, over the square of cells over the radius of a disc.
   real(dp), parameter :: astray_in_disc = 0.1_dp

   real(dp), parameter :: no_work = 1e-8_dp      !! that closing a cell at a tip takes, over the strain energy: rounding

   !> And a crack in it.
   type, extends(static_model_t) :: static_crack_t
      real(dp) :: g(modes) = 0                   !! energy release rate of the cells [J/m2]
      real(dp) :: by_tip(modes) = 0              !! deficit by the shortness of their crack [J/m2]
      real(dp) :: by_cells(modes) = 0            !! deficit by the cells away from the tip [J/m2]
      real(dp) :: shortness(modes) = 0           !! [cells]
   contains
      procedure :: best
      procedure :: correction
      procedure :: deficit
      procedure :: part_of_tip
   end type static_crack_t

contains

   !> Estimate of G, by mode [J/m2]. If the corrections would leave next to nothing of it, they are errors of its size.
   pure function best(self)
      class(static_crack_t), intent(in) :: self
      real(dp) :: best(modes)
      real(dp), parameter :: least = 0.1_dp      ! part of the found value
      best = max(self%g + self%by_tip + self%by_cells, least*self%g, tiny(1.0_dp))
   end function best

   !> Relative correction of the estimate, by mode; of a nearly absent mode that of both together [-].
   pure function correction(self)
      class(static_crack_t), intent(in) :: self
      real(dp) :: correction(modes)
      associate (corrected => abs(self%by_tip) + abs(self%by_cells), g => self%best())
         correction = sum(corrected)/sum(g)
         where (g > hardly**2*sum(g)) correction = corrected/g
      end associate
   end function correction

   !> Part that the G of the cells lacks, by mode; of a nearly absent mode that of both together [-]: the corrections, which may
   !> cancel, and what is uncertain of each. They are of first order in the cell over the length in which G changes; the shortness
   !> tells this ratio, and so their next term, which is of its square.
   pure function deficit(self)
      class(static_crack_t), intent(in) :: self
      real(dp) :: deficit(modes)
      real(dp), parameter :: next_term = 0.6_dp  ! cells: 95 % of coarse cracks need 0.4
      real(dp) :: both(modes)                    ! sizes of the corrections
      associate (lacks => self%by_tip + self%by_cells, sizes => abs(self%by_tip) + abs(self%by_cells), g => self%g)
         deficit = abs(sum(lacks))/max(sum(g), tiny(1.0_dp))
         both = sum(sizes)/max(sum(g), tiny(1.0_dp))
         where (g > hardly**2*sum(g))
            deficit = abs(lacks)/g
            both = sizes/g
         end where
      end associate
      deficit = deficit + both*(uncertainty + next_term/self%shortness*both/(1 + both))
   end function deficit

   !> Part of the corrections due to the tip [-].
   pure real(dp) function part_of_tip(self) result(part)
      class(static_crack_t), intent(in) :: self
      part = sum(abs(self%by_tip))/max(sum(abs(self%by_tip) + abs(self%by_cells)), tiny(1.0_dp))
   end function part_of_tip

   !> Relative error of G from lengths alone [-]: for tips too far back by the shortness, with G as (a**2) of a beam of length a and
   !> as (b**-3) of a bent ligament b, for any loads.
   pure real(dp) function error_by_lengths(m, tip, mouth) result(relative)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(in) :: mouth(ndim)        !! of the crack [m]
      real(dp) :: a, b
      integer :: i
      b = 0
      do i = 1, m%particles%n
         b = max(b, dot_product(m%particles%reference(i, :) - tip%place, tip%axis(:, 1)))
      end do
      associate (cell => tip%nodes%spacing)
         a = max(norm(tip%place - mouth), cell)
         b = max(b, cell)
         associate (shortness => shortness_of(m, tip))
            relative = shortness(1)*cell*(2/a + 3/b)
         end associate
      end associate
   end function error_by_lengths

   !> Find the values of one of all tips at nodes of a static model. `known` is false if the model is not known, if its crack has
   !> less than two nodes behind the tip, and if nothing opens it.
   subroutine find_static_crack(m, rest, model, all_tips, number, thickness, crack)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: rest   !! factorised for it
      type(static_model_t), intent(in) :: model
      type(crack_tip_t), intent(in) :: all_tips(:)
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: thickness          !! [m]
      type(static_crack_t), intent(out) :: crack
      type(condensation_t) :: condensation
      type(crack_tip_t), allocatable :: chosen(:), tips(:) ! the tip, and the others
      integer :: of_tip(most_pairs + size(all_tips) - 1), cells(size(of_tip)), k, pairs, found
      real(dp) :: to_g
      crack%static_model_t = model
      if (.not. crack%known) return
      allocate (tips(size(all_tips)))
      do k = 1, size(tips)
         tips(k) = all_tips(merge(number, k - merge(1, 0, k <= number), k == 1))
      end do
      do k = 1, size(of_tip)
         of_tip(k) = max(1, k - most_pairs + 1)
         cells(k) = merge(k, 1, k <= most_pairs)
      end do
      do pairs = most_pairs, 2, -1
         if (allocated(chosen)) deallocate (chosen)
         allocate (chosen(pairs + size(tips) - 1))  ! tips(vector) as an argument would leak in gfortran 12
         do k = 1, size(chosen)
            chosen(k) = tips(of_tip(merge(k, k - pairs + most_pairs, k <= pairs)))
         end do
         call new_condensation(m, rest, chosen, [cells(:pairs), cells(most_pairs + 1:)], crack%u, condensation, found)
         if (found == pairs + size(tips) - 1) exit
      end do
      crack%known = pairs >= 2
      if (.not. crack%known) return
      to_g = merge(2.0_dp, 1.0_dp, tips(1)%is_half())/(thickness*tips(1)%nodes%spacing)
      crack%shortness = shortness_of(m, tips(1))
      call condense_onto_faces(condensation, pairs, size(tips) - 1, to_g, tips(1)%has_layers, crack)
      where (abs(crack%g) < hardly**2*sum(abs(crack%g))) crack%g = max(crack%g, 0.0_dp) ! rounding, of any sign
      ! Else its modes share rounding, or G changes too much from cell to cell for a parabola
      crack%known = all(crack%g >= 0) .and. sum(crack%g) > to_g*no_work*crack%energy
      if (crack%known) call find_far_error(m, tips, condensation, to_g, crack)
   end subroutine find_static_crack

   !> Static solution under all loads and moved supports at a time, or by their largest factors, scaled to small gradients, with
   !> free rigid-body modes; not known if nothing strains it, and for too many unknowns. Contacting faces are free where they
   !> separate, and hold with friction where they do not and do not slide.
   subroutine find_equilibrium(m, rest, model, time)
      type(problem_t), intent(inout) :: m
      type(stiffness_t), intent(inout) :: rest   !! that is factorised
      type(static_model_t), intent(out) :: model
      real(dp), intent(in), optional :: time     !! [s]
      real(dp), allocatable :: force(:, :), shift(:, :), held_back(:, :) ! of moved supports, and its forces
      real(dp), allocatable :: by_body_loads(:, :) ! acceleration [m/s2]
      real(dp), parameter :: nothing = 1.0e-10_dp !! rounding of forces, as part of them
      type(interfaces_t) :: before
      real(dp) :: largest                        ! [N]
      logical :: is_new
      integer :: turn
      model%known = .not. is_larger(m, most_unknowns)
      if (.not. model%known) return
      before = m%interfaces
      model%factors = largest_factors(m%loads)
      if (present(time)) model%factors = factors_at(m%loads, time)
      call full_loads(m, force, model%factors)
      call accelerate_by_body_loads(m, force, model%factors, by_body_loads)
      call add_eigenstrains(m, force)
      call hold_back(m, shift, held_back, time)
      force = force + held_back
      largest = maxval(abs(force))
      call find_free_motions(m, model%free)
      call take_inertia(model%free, force, model%divergence)
      model%divergence = model%divergence - by_body_loads
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force) ! hanging nodes are held with their masters
      model%known = maxval(m%constraints%free*abs(force)) > nothing*max(largest, maxval(abs(force)))
      do turn = 1, most_turns
         if (model%known) call new_stiffness(m, most_unknowns, rest, model%known, kind_at_rest(m, model%free%rigid_constraints))
         if (.not. model%known) exit
         call rest%solve(m, force, model%u)
         model%energy = sum(force*model%u)/2 - sum((model%u + shift/2)*held_back)
         model%u = model%u + shift
         call take_motion_as_whole(model%free, model%u)
         call part_faces(m%interfaces, model%u, is_new)
         if (.not. is_new) exit
      end do
      m%interfaces = before
      if (.not. model%known) return
      if (.not. any(m%materials%has_eigenstrain)) call make_small(m, model%u, model%scale)
      model%divergence = model%scale*model%divergence
      model%energy = model%scale**2*model%energy
   end subroutine find_equilibrium

   !> The acceleration by loads on all material alone, by the mass matrix, as a run finds it (`find_nodal_state`); without any load
   !> that of the forces that stop bodies [m/s2].
   subroutine accelerate_by_body_loads(m, all_loads, factors, acceleration)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: all_loads(:, :)    !! [N], (ndim, n_points)
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      real(dp), allocatable, intent(out) :: acceleration(:, :) !! (ndim, n_points)
      type(failure_t) :: unsolved                !! then it is left out
      real(dp), allocatable :: force(:, :)
      integer :: k
      allocate (acceleration, source=0*all_loads)
      if (.not. (any(m%loads%by_mass) .or. size(m%loads) == 0)) return
      force = acceleration
      do k = 1, size(m%loads)
         if (m%loads(k)%by_mass) call add_load(m%loads(k), factors(k), force)
      end do
      if (size(m%loads) == 0) force = all_loads
      if (.not. is_weighed(m)) call refresh_grid(m)
      associate (all => m%fields%mass_matrix%all)
         call m%grid%dofs%condense(all, ndim, force)
         call solve_aside(m%solver, m%grid, m%fields%mass_matrix, force, acceleration, unsolved)
         if (unsolved%failed()) acceleration = 0
         call m%grid%dofs%distribute(all, ndim, acceleration)
      end associate
   end subroutine accelerate_by_body_loads

   !> The displacement of moved supports at a time, or by their largest factors, of all other points 0, and the forces with which
   !> the material next to them acts against it.
   subroutine hold_back(m, shift, force, time)
      type(problem_t), intent(in) :: m
      real(dp), allocatable, intent(out) :: shift(:, :), force(:, :) !! [m], [N], (ndim, n_points)
      real(dp), intent(in), optional :: time     !! [s]
      real(dp) :: gradient(m%grid%n_functions, n_derivatives(m)), stress(ndim*ndim + 1)
      integer :: i
      allocate (shift(ndim, m%grid%n_points), force(ndim, m%grid%n_points), source=0.0_dp)
      if (present(time)) then
         if (m%constraints%number() > 0) shift(:, :m%grid%n_nodes) = m%constraints%prescribed_at(time)
      else
         shift(:, :m%grid%n_nodes) = m%constraints%largest_prescribed()
      end if
      if (.not. any(abs(shift) > 0)) return
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, shift)
      associate (p => m%particles)
         do i = 1, p%n
            associate (at => m%grid%support_of(p%cell(i)), material => m%materials(p%material(i)))
               if (.not. any(abs(shift(:, at)) > 0)) cycle
               gradient = derivatives_at(m, i)
               stress(:ndim*ndim + n_derivatives(m) - ndim) = stress_of(material, gradient_by(shift, at, gradient))
               force(:, at) = force(:, at) - p%volume(i)*matmul(reshape(stress, [ndim, ndim]), transpose(gradient(:, :ndim)))
               if (material%is_ring) force(1, at) = force(1, at) - p%volume(i)*stress(ndim*ndim + 1)*gradient(:, ndim + 1)
            end associate
         end do
      end associate
   end subroutine hold_back

   !> Open faces in contact that a displacement separates, and let those slide freely whose friction it overcomes, for good: K_II of
   !> faces that slide has the error of one without their friction, whose field is smooth. `is_new`: any that did not before.
   pure subroutine part_faces(interfaces, u, is_new)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: u(:, :)            !! of the points [m], (ndim, n_points)
      logical, intent(out) :: is_new
      real(dp), parameter :: rounding = 1e-6_dp  ! of the largest opening or overlap
      real(dp) :: largest
      logical :: is_open, slides, slid
      integer :: k
      is_new = .false.
      largest = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%law == contact) largest = max(largest, abs(dot_product(point%normal, jump_of(point%jump, u))))
         end associate
      end do
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%law /= contact) cycle
            if (overlap_of(point) < 0) cycle
            associate (opening => dot_product(point%normal, jump_of(point%jump, u)))
               is_open = opening > rounding*largest
               slides = point%friction > 0 .and. &
                        length_along(along_faces(point, jump_of(point%jump, u))) > -point%friction*opening + rounding*largest
            end associate
            slid = any(abs(point%slip) > 0)
            is_new = is_new .or. is_open .or. slides .and. .not. slid
            point%contact_offset = 0
            point%slip = merge(point%cell, 0.0_dp, slides .or. slid)
            point%carried = 0
            point%opening = merge(point%cell, 0.0_dp, is_open)*point%normal
         end associate
      end do
   end subroutine part_faces

   !> Add the forces of the strains without stress, as the material has them where it is not displaced.
   pure subroutine add_eigenstrains(m, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(inout) :: force(:, :)     !! [N], (ndim, n_points)
      real(dp), parameter :: no_gradient(ndim, ndim) = 0
      integer :: i
      associate (p => m%particles)
         do i = 1, p%n
            associate (material => m%materials(p%material(i)), at => m%grid%support_of(p%cell(i)))
               if (.not. material%has_eigenstrain) cycle
               force(:, at) = force(:, at) - p%volume(i)*matmul(material%stress_at_first(), transpose(m%gradients_of(i)))
               if (material%is_ring) force(1, at) = force(1, at) - p%volume(i)*material%hoop_stress(no_gradient, hoop=0.0_dp) &
                                                                   *m%functions_of(i)/p%reference(i, 1)
            end associate
         end do
      end associate
   end subroutine add_eigenstrains

   !> Scale a displacement to small gradients: only ratios matter, with laws and positions of small strain.
   subroutine make_small(m, u, scale)
      type(problem_t), intent(in) :: m
      real(dp), intent(inout) :: u(:, :)         !! [m], (ndim, n_points)
      real(dp), intent(out) :: scale             !! factor of the displacement [-]
      real(dp), parameter :: small = 1.0e-7_dp
      real(dp) :: largest
      integer :: i
      largest = 0
      do i = 1, m%particles%n
         largest = max(largest, maxval(abs(gradient_of(m, u, i))))
      end do
      scale = 1
      if (largest > 0) scale = small/largest
      u = u*scale
   end subroutine make_small

   !> Shortness of the crack of the cells, in cells by mode [-]. For quadratic cells the tip offset of K.
   pure function shortness_of(m, tip) result(shortness)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      real(dp) :: shortness(modes)
      real(dp), parameter :: by_width = 0.79_dp  ! centre cracks in four orthotropic materials within 5 %, bilinear cells within 9 %
      type(tip_field_t) :: field(2)
      shortness = quadratic_tip_offset(m, tip)
      associate (material => m%materials(tip%material_in(m%materials)))
         if (.not. m%grid%is_quadratic()) then
            associate (x => material%small_strain_lambda()/material%mu)
               shortness = short + by_stiffness*x/(1 + x/stiff)
            end associate
         end if
         if (material%isotropic) return
      end associate
      field = fields_at(m%materials, tip)
      if (.not. field(1)%is_at_interface) shortness(2) = shortness(2)*max(1.0_dp, 1 + by_width*(field(1)%widening() - 1))
   end function shortness_of

   !> Place error of a tip, by mode [cells]: at a node behind it, the uncertain part of the shortness; inside a cell anywhere within
   !> this distance, more in few cells. And the part of the size of both K by which each is off, as cells know the fields beside the
   !> singular one to the second order.
   pure subroutine place_of_tip(m, tip, of_j, of_k, in_disc)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(out) :: of_j(modes), of_k(modes) !! as J and as K tell
      real(dp), intent(out) :: in_disc           !! [-]
      real(dp), parameter :: narrow = 6          ! cells, discs in which those that change their shape are too few to tell
      type(tip_field_t) :: field(2)
      real(dp) :: cells, turned                  ! the latter is the part by which one K is off for the other
      of_j = (1 + uncertainty)*shortness_of(m, tip)
      of_k = of_j
      cells = merge(0.5_dp, 1.0_dp, m%grid%is_quadratic())
      turned = astray_in_disc
      field = fields_at(m%materials, tip)
      if (.not. field(1)%is_at_interface) cells = cells*max(1.0_dp, field(1)%narrowing()) ! to which cells are as much wider
      if (tip%nodes%in_cell) then
         of_j = cells*astray_of_j
         of_k = cells*astray_of_k
         if (is_lone(m, tip)) then
            of_j = of_lone*of_j
            of_k = of_lone*of_k
            turned = maxval(of_lone)*turned
         end if
      end if
      associate (few => sqrt(max(1.0_dp, narrow*tip%nodes%spacing/maxval(tip%radii))))
         of_j = of_j*few
         of_k = of_k*few
      end associate
      in_disc = turned*(cells*tip%nodes%spacing/disc_of_shifts(tip))**2
   end subroutine place_of_tip

   !> Whether the bilinear cell in which a tip ends has one particle, or the halves of one.
   pure logical function is_lone(m, tip)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      integer, parameter :: halves = 2
      integer :: k
      is_lone = .false.
      if (m%grid%is_quadratic()) return
      do k = 1, size(m%grid%cut_cells%ends)
         associate (end => m%grid%cut_cells%ends(k))
            if (.not. (end%line == tip%crack .and. end%end == tip%end .and. end%leaf > 0)) cycle
            is_lone = sum(m%blocks%count_in(elements_of([end%leaf], m%grid, m%blocks))) <= halves
         end associate
      end do
   end function is_lone

   !> Relative deficit of G by locking: nearly incompressible bilinear cells resist volume changes that their functions cannot
   !> avoid. Without the part p of the energy that these take the compliance grows by 1/(1 - p) at least, and more with more
   !> locking; its square is taken. Cells at a ratio so near 0.5 that their volumes hardly change do not show it: only the ratio of
   !> bulk and shear modulus bounds it then [-]. 0 below the ratio from which a run warns.
   pure real(dp) function lost_by_locking(m, u, energy) result(lost)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! static [m], (ndim, n_points)
      real(dp), intent(in) :: energy             !! [J]
      real(dp), parameter :: locking = 0.4899_dp, locked = 0.4995_dp, most = 0.99_dp
      real(dp) :: change(2), taken               ! of volume
      integer :: n, i
      lost = 0
      if (m%grid%is_quadratic() .or. all(m%materials%poisson <= locking .or. m%materials%mean_dilatation .or. &
                                         m%materials%plane_stress)) return
      taken = 0
      associate (p => m%particles, b => m%blocks)
         do n = 1, b%n_occupied
            associate (e => b%occupied(n))
               change = 0
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  change = change + p%volume(i)*[1.0_dp, trace(gradient_of(m, u, i))]
               end do
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  associate (material => m%materials(p%material(i)))
                     if (material%poisson <= locking .or. material%mean_dilatation) cycle
                     taken = taken + p%volume(i)*material%lambda/2*(trace(gradient_of(m, u, i)) - change(2)/change(1))**2
                  end associate
               end do
            end associate
         end do
      end associate
      associate (part => bounded_ratio(taken, energy, most))
         lost = 1/(1 - part)**2 - 1
      end associate
      if (any(m%materials%poisson > locked)) lost = maxval(m%materials%lambda/m%materials%mu)
   end function lost_by_locking

   !> G, and its increase with all tips further out by the shortness s, from the work that closes one pair of nodes after the other.
   !> A parabola through d_1, d_2, d_3, the means over the cells behind the tip, has at the tip
   !>
   !>    G = (11 d_1 - 7 d_2 + 2 d_3)/6,  change over s cells = s (2 d_1 - 3 d_2 + d_3) + s**2/2 (d_1 - 2 d_2 + d_3),
   !>
   !> and one through their logarithms l, with
   !>
   !>    ln G = (15 l_1 - 10 l_2 + 3 l_3)/8,  change over s cells = s (2 l_1 - 3 l_2 + l_3) + s**2/2 (l_1 - 2 l_2 + l_3),
   !>
   !> as a mean over a cell is the value in the middle and h**2/24 G''. The first is right where a crack is a few cells long, the
   !> second where a ligament is a few cells wide; each falls short in the other case, so that the larger change is taken. Of two
   !> pairs they are lines. To this comes by how much closing a cell at another tip lowers d_1.
   !>
   !> Between two materials the share of either mode depends on the cell size and may be negative: both are taken as one.
   subroutine condense_onto_faces(condensation, pairs, others, to_g, as_one, crack)
      type(condensation_t), intent(in) :: condensation
      integer, intent(in) :: pairs, others       !! numbers of pairs behind the tip, and of other tips
      real(dp), intent(in) :: to_g               !! from work by cell to G [1/m2]
      logical, intent(in) :: as_one              !! whether modes are
      type(static_crack_t), intent(inout) :: crack
      real(dp) :: force(size(condensation%parting)), work(modes, 0:pairs), d(most_pairs), l(most_pairs), apart(modes), both(modes)
      real(dp) :: g(2), change(2)                ! by the two parabolas
      integer :: k, pair, mode
      work(:, 0) = 0
      do k = 1, pairs
         call condensation%close_pairs([(pair, pair=1, k)], force, work(:, k))
      end do
      do mode = 1, modes
         d(:pairs) = to_g*(work(mode, 1:) - work(mode, :pairs - 1))
         if (as_one) d(:pairs) = merge(to_g*sum(work(:, 1:) - work(:, :pairs - 1), dim=1), spread(0.0_dp, 1, pairs), mode == 1)
         if (any(d(:pairs) <= 0)) cycle
         if (pairs == 2) d(3) = d(2)**2/d(1)
         l = log(d/d(1))
         associate (s => crack%shortness(mode), bend => d(1) - 2*d(2) + d(3))
            g = [(11*d(1) - 7*d(2) + 2*d(3))/6, d(1)*exp((3*l(3) - 10*l(2))/8)*(1 - bend/(24*d(2)))]
            change = [s*(2*d(1) - 3*d(2) + d(3)) + s**2/2*bend, &
                      g(2)*(exp(s*(l(3) - 3*l(2)) + s**2/2*(l(3) - 2*l(2))) - 1)]
            crack%by_tip(mode) = change(maxloc(abs(change), dim=1))
            crack%g(mode) = g(maxloc(abs(change), dim=1))
         end associate
      end do
      do k = pairs + 1, pairs + others
         call condensation%close_pairs([k], force, apart)
         call condensation%close_pairs([1, k], force, both)
         associate (more => work(:, 1) + apart - both)
            crack%by_tip = crack%by_tip + crack%shortness*to_g*merge([sum(more), 0.0_dp], more, as_one)
         end associate
      end do
   end subroutine condense_onto_faces

   !> Deficit of G by the cells away from the tip. If these store M less than the body would, G = (U(a) - U(a - h))/(B h) lacks the
   !> change of M as the first pair is closed. The surroundings of the tip, alike before and after, move with it; in quadratic cells
   !> those of other tips, too, in the shortness. The modes share it as they share G.
   subroutine find_far_error(m, tips, condensation, to_g, crack)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tips(:)
      type(condensation_t), intent(in) :: condensation
      real(dp), intent(in) :: to_g
      type(static_crack_t), intent(inout) :: crack
      real(dp), allocatable :: u(:, :, :)        ! present, and with the first pair closed [m]
      real(dp) :: force(size(condensation%parting)), work(modes), places(ndim, size(tips), 2), missing(2)
      integer :: k
      call condensation%close_pairs([1], force, work)
      allocate (u(ndim, m%grid%n_points, 2))
      u(:, :, 1) = crack%u
      u(:, :, 2) = crack%u
      do k = 1, size(force)
         if (abs(force(k)) > 0) u(:, :, 2) = u(:, :, 2) - force(k)*condensation%moved(:, :, k)
      end do
      do k = 1, size(tips)
         places(:, k, 1) = tips(k)%place
      end do
      places(:, :, 2) = places(:, :, 1)
      k = merge(size(tips), 1, m%grid%is_quadratic())
      associate (h => tips(1)%nodes%spacing)
         places(:, 1, 2) = places(:, 1, 2) - h*tips(1)%axis(:, 1)
         missing = sum(missing_energies(m, places(:, :k, :), spread(tip_zone*h, 1, k), spread(1, 1, k), u, &
                                        [pair_t(1, 1), pair_t(2, 2)]), dim=2)
      end associate
      crack%by_cells = to_g*(missing(1) - missing(2))*work/sum(work)
   end subroutine find_far_error

   !> Radius of the disc in which J and K are measured of a tip that is moved: among cells that go with it [m].
   pure real(dp) function disc_of_shifts(tip) result(radius)
      type(crack_tip_t), intent(in) :: tip
      radius = max(min(minval(tip%radii), maxval(tip%radii)/2), min(2*tip%nodes%spacing, maxval(tip%radii)))
   end function disc_of_shifts

   !> Find what changes as the tips of a model at rest move, where it is known, and the dual displacements z of K. The product in
   !> J = -(K' u) . u/(2 B) of u and the field a of a unit K of a mode, with the energy release rate Y of that, is
   !>
   !>    K_m = -(K' a) . u/(2 B Y),   so that   K z = -K' a/(2 B Y)   and an error e of u changes K_m by a(e, z).
   subroutine find_static_tips(m, rest, model, tips, is_static)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: rest   !! factorised for it
      type(static_model_t), intent(in) :: model
      type(crack_tip_t), intent(in) :: tips(:)   !! all with radii
      type(static_tips_t), intent(out) :: is_static
      real(dp), allocatable :: forces(:, :, :), moved(:, :, :), unused(:, :)
      real(dp) :: pressure
      integer :: k
      is_static%static_model_t = model
      if (.not. model%known) return
      is_static%group = groups_of(tips)
      allocate (forces(ndim, m%grid%n_points, (1 + modes)*maxval(is_static%group)), source=0.0_dp)
      do k = 1, size(tips)
         pressure = model%scale*sum(model%factors*m%loads%pressure, mask=m%loads%line == tips(k)%crack)/(2*ndim)
         associate (last => (1 + modes)*is_static%group(k))
            call add_forces(m, model, tips(k), pressure, forces(:, :, last - modes:last))
         end associate
      end do
      do k = 1, size(forces, 3)
         call take_inertia(model%free, forces(:, :, k), unused)
      end do
      call rest%solve_for_all(m, forces, moved)
      do k = 1, size(forces, 3)
         call take_motion_as_whole(model%free, moved(:, :, k))
      end do
      is_static%moved = moved(:, :, ::1 + modes)
      allocate (is_static%dual(ndim, m%grid%n_points, modes, size(is_static%moved, 3)))
      do k = 1, modes
         is_static%dual(:, :, k, :) = moved(:, :, 1 + k::1 + modes)
      end do
   end subroutine find_static_tips

   !> Groups of tips that are so far apart that each hardly feels that the others move: what a tip changes falls with the square of
   !> the distance over its disc. A few tips have a group each; hundreds share some twenty, so that the cost is not the square of
   !> their number.
   pure function groups_of(tips) result(group)
      type(crack_tip_t), intent(in) :: tips(:)
      integer :: group(size(tips))
      integer, parameter :: few = 16
      real(dp), parameter :: apart = 3           ! discs
      integer :: k, j
      logical :: is_taken(size(tips))
      do k = 1, size(tips)
         group(k) = k
         if (size(tips) <= few) cycle
         is_taken = .false.
         do j = 1, k - 1
            if (norm(tips(k)%place - tips(j)%place) < apart*(maxval(tips(k)%radii) + maxval(tips(j)%radii))) &
               is_taken(group(j)) = .true.
         end do
         group(k) = findloc(is_taken, .false., dim=1)
      end do
   end function groups_of

   !> Way of the nodes over that of a tip as it moves, q, and the leaves with any [-].
   subroutine weight_moved(m, tip, q, leaves)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      real(dp), allocatable, intent(out) :: q(:, :) !! (1, points)
      integer, allocatable, intent(out) :: leaves(:)
      type(tip_domain_t) :: domain
      domain%tip = tip%now
      domain%radius = [maxval(tip%radii)]
      call weight_nodes(domain, m%grid, q, leaves, max(domain%radius(1)/2, min(disc_of_shifts(tip) + tip%nodes%spacing, &
                                                                               most_level*domain%radius(1))))
   end subroutine weight_moved

   !> Add the forces -K' u of a tip [N/m], without stress-free strain, and -K' a/(2 B Y) of a unit K of each mode
   !> [Pa sqrt(m)/m]. A uniform stress p I makes faces under pressure p free.
   subroutine add_forces(m, model, tip, pressure, forces)
      type(problem_t), intent(in) :: m
      class(static_model_t), intent(in) :: model
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(in) :: pressure           !! on its faces [Pa]
      real(dp), intent(inout) :: forces(:, :, 0:) !! (ndim, n_points, 0:modes)
      type(tip_field_t) :: field(2)
      real(dp), allocatable :: q(:, :)
      integer, allocatable :: leaves(:), elements(:)
      real(dp) :: gradient(m%grid%n_functions, n_derivatives(m)), with_hoop(ndim, n_derivatives(m)), x(ndim), over(modes)
      real(dp) :: g(ndim, ndim), g_33, h(ndim, ndim) ! g_33 is 0 in a plane
      real(dp) :: shape(m%grid%n_functions), along ! way of the material along the gradient of its moduli, over that of the tip
      integer :: at(m%grid%n_functions), n, i, mode
      logical :: is_graded
      call weight_moved(m, tip, q, leaves)
      elements = elements_of(leaves, m%grid, m%blocks)
      field = fields_at(m%materials, tip)
      do mode = 1, modes
         over(mode) = merge(2, 1, tip%is_half())/(2*m%particles%thickness%at(tip%now)*field(1)%rate_of(identity(:modes, mode)))
      end do
      associate (p => m%particles, b => m%blocks)
         do n = 1, size(elements)
            at = m%grid%support_of(elements(n))
            is_graded = m%materials(m%particles%material(b%first_in(elements(n))))%is_graded() .and. maxval(q(1, at)) > 0
            if (.not. (maxval(q(1, at)) > minval(q(1, at)) .or. is_graded)) cycle
            do i = b%first_in(elements(n)), b%last_in(elements(n)), b%stride_in(elements(n))
               gradient = derivatives_at(m, i)
               with_hoop = spread(tip%direction, 2, n_derivatives(m))*spread(matmul(q(1, at), gradient), 1, ndim)
               g = with_hoop(:, :ndim)
               g_33 = sum(with_hoop(1, ndim + 1:))
               with_hoop = matmul(model%u(:, at), gradient)
               shape = m%functions_of(i)
               associate (material => m%materials(p%material(i)))
                  along = 0
                  if (is_graded) along = dot_product(material%slice%direction, tip%direction)*dot_product(shape, q(1, at))
                  forces(:, at, 0) = forces(:, at, 0) - p%volume(i)*material%density*(trace(g) + g_33) &
                                     *spread(matmul(model%divergence(:, at), shape), 2, size(at))*spread(shape, 1, ndim)
                  call add(material, with_hoop(:, :ndim) - material%free, sum(with_hoop(1, ndim + 1:)) - material%free_hoop, &
                           pressure, 0)
                  if (.not. (maxval(abs(g)) > 0 .or. is_graded)) cycle ! at the tip itself
                  x = matmul(p%place_in_grid(i) - tip%now, tip%axis)
                  do mode = 1, modes
                     h = over(mode)*field(merge(2, 1, x(2) < 0))%gradient(mode, x)
                     call add(material, matmul(tip%axis, matmul(h, transpose(tip%axis))), 0.0_dp, 0.0_dp, mode)
                  end do
               end associate
            end do
         end do
      end associate

   contains

      !> Add the forces of the particle in a field.
      subroutine add(material, h, h_33, pressure, number)
         type(material_t), intent(in) :: material
         real(dp), intent(in) :: h(ndim, ndim), h_33 !! displacement gradient, h_33 of a ring [-]
         real(dp), intent(in) :: pressure        !! that is added [Pa]
         integer, intent(in) :: number           !! of the forces
         real(dp) :: stress(ndim, ndim), stress_33, strained(ndim, ndim), strained_33
         strained = h + material%strain_of_pressure(pressure)
         strained_33 = h_33
         if (material%is_ring) strained_33 = h_33 + strained(1, 1) - h(1, 1)
         stress_33 = material%small_hoop_stress(h, h_33)
         stress_33 = (stress_33 + pressure)*trace(g) + along*material%slice%rate*stress_33 &
                     - material%small_hoop_stress(matmul(strained, g), strained_33*g_33)
         stress = material%small_strain_stress(h, h_33)
         stress = along*material%slice%rate*stress + (stress + pressure*identity)*(trace(g) + g_33) &
                  - matmul(stress + pressure*identity, transpose(g)) &
                  - material%small_strain_stress(matmul(strained, g), strained_33*g_33)
         if (number == 0 .and. is_graded) stress = stress - along*material%small_strain_stress(material%slice%free_rate, 0.0_dp)
         associate (volume => m%particles%volume(i), force => forces(:, :, number))
            force(:, at) = force(:, at) - volume*matmul(stress, transpose(gradient(:, :ndim)))
            if (material%is_ring) force(1, at) = force(1, at) - volume*stress_33*gradient(:, ndim + 1)
         end associate
      end subroutine add
   end subroutine add_forces
end module hampm_expected_error
