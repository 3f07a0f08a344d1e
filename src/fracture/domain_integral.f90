!> The energy release rate and the stress intensity factors of a crack in motion, by integrals over a disc around its tip. Their
!> derivation is in docs/explanation/energy_release_rate.md.
module hampm_domain_integral
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_closed_faces, only: closed_faces_t
   use hampm_energy_momentum, only: ways, sample_t, take_sample, energy_momentum, interaction
   use hampm_interface_points, only: interfaces_t, find_points_at_tip, holds, is_half, is_softening
   use hampm_face_slopes, only: find_face_force
   use hampm_grid, only: grid_t
   use hampm_loads, only: load_t
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: nodal_state_t
   use hampm_nearby, only: nearby_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, in_plane, quarter_turn
   use hampm_crack_tip_field, only: modes, tip_field_t
   use hampm_tip_domain, only: fields, tip_domain_t, place_t, places_t, list_places, fill_places, weights_at
   implicit none
   private
   public :: integrals_t, domain_integrals, shares_of_modes

   real(dp), parameter :: rounding = 1e-9_dp     !! of q at a point between nodes outside of the domain, where it is 0 [-]

   !> The integrals of a tip, by radius.
   type :: integrals_t
      real(dp), allocatable :: j(:)              !! [J/m2]
      real(dp), allocatable :: k(:, :)           !! [Pa sqrt(m)], (modes, radii); K_II is 0 in a half model
      real(dp), allocatable :: k_uncertainty(:, :) !! by tractions behind a closed tip, as `k`
      real(dp), allocatable :: of_force(:)       !! interaction with a unit force on the tip along the crack, where asked for [-]
      real(dp) :: on_faces(ndim) = 0             !! stresses s_12 and s_22 of loads on the faces at the tip [Pa]
   end type integrals_t

contains

   !> J, and K_I and K_II, of each disc:
   !>
   !>    J = (1/B) [ sum_p V { P_iJ w_i q,J - W q,1 + rho d_i w_i q } - sum_points f_i w_i q ],
   !>    K = E'/(2 B) [ sum_p V { (P_iJ a_i,1 + s_iJ w_i) q,J - P_iJ a_i,J q,1 + rho d_i a_i,1 q } - sum_points f_i a_i,1 q ],
   !>    w = u,1 - c,
   !>
   !> in the reference configuration, with rho d = div P, the displacement a and stress s of a unit K of the mode and f the force of
   !> the tractions on the faces at a point. J holds for any elastic law (Nakamura, Shih & Freund 1985), K for small strain (Yau,
   !> Wang & Corten 1980). The constant c has no part in the integrals, but removes the rotation of the disc from the errors of the
   !> sums. For finite rotation all is turned back by R, the rotation of the mean F over the discs: F becomes R**T F, P becomes R**T
   !> P, and K is of the remaining small strain.
   !>
   !> In axisymmetric material, with the radius R and d = cos(e_1, e_R), V is of rings, B the length of the front, and the sums add
   !>
   !>    J: P_33 (H_33 d - c_R) q/R - W d q/R,
   !>    K: { P_33 a_R,1 + s_iR w_i - P_iJ a_i,J d - s_33 (u_R,1 - H_33 d) } q/R,
   !>
   !> the first as J is the derivative of the energy by the places of rings, H_33 = u_R/r, and c q does no work with balanced
   !> stress; the second with fields of plane strain for a and s, H_33 of a being 0, which balance in the plane, not in a ring.
   !>
   !> A tip with speed v has fields (Freund 1990) in balance with rho v**2 a,11. With m = min(1, r/r_0), r_0 where q is 1,
   !>
   !>    K = E'/(2 A B) sum_p V { (P_iJ a_i,1 + s_iJ w_i) q,J - P_iJ a_i,J q,1
   !>                             + m (rho d_i a_i,1 + rho v**2 a_i,11 w_i) q - rho v v_i a_i,1 m,1 },
   !> v_i without its mean over the discs: within r_0 the terms of q are the remainder of v_i = -v w_i, for which they cancel at
   !> each place. At the tip each of them alone is as r**-2.
   !>
   !> The terms (rho v**2/2) q,1 + rho v_i v_i,1 q of Nakamura, Shih & Freund are the derivative of rho v**2 q/2 along the crack:
   !> for a stationary tip their integral is 0, its numerical value an error, larger than J in a flying body. They are left out.
   subroutine domain_integrals(domain, problem, factors, p, state, closed, places, found)
      type(tip_domain_t), intent(inout) :: domain !! its frame is completed here
      type(problem_t), intent(in) :: problem     !! its loads at their places in the grid; those that reach into a disc are on the
                                                 !! faces
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      type(particles_t), intent(in) :: p         !! with the places of the motion's particles
      type(nodal_state_t), intent(in) :: state   !! of these particles
      type(closed_faces_t), intent(in) :: closed !! tractions behind a closed tip
      type(places_t), intent(inout) :: places    !! of the last time: found anew if tip or mesh have changed
      type(integrals_t), intent(out) :: found
      real(dp) :: by_closed(modes, size(domain%radius)), x(ndim), velocity(ndim)
      real(dp) :: sums(size(domain%radius), 0:fields), flux(ways, ndim), source(ways) ! of J and of each field
      real(dp), allocatable :: q(:, :)           ! weights at the points of the grid [-], (radii, points)
      type(sample_t) :: s
      integer :: radii, n, mode
      radii = size(domain%radius)
      allocate (found%k_uncertainty(modes, radii), source=0.0_dp)
      associate (grid => problem%grid, blocks => problem%blocks)
         call list_places(domain, grid, blocks, p, places)
         call find_frame(domain, problem%materials, p, places)
         x = 0
         velocity = 0
         call places%weigh_points(q)
         call fill_places(domain, grid, blocks, p, q, places)
         sums = 0
         by_closed = 0
         do n = 1, size(places%list)
            associate (place => places%list(n), material => problem%materials(p%material(places%list(n)%particle)))
               call sample_place(domain, problem, p, place, state, s)
               call energy_momentum(s, flux, source)
               call weigh(s%volume, flux, source, radii, places%q(1, n), places%dq(1, 1, n), sums)
               if (domain%field%is_running) then
                  x = domain%from_tip(p%place_in_grid(place%particle), p%total_frame)
                  velocity = domain%in_axes(p%velocity(place%particle, :)) - domain%carried
               end if
               do mode = 1, merge(fields, modes, domain%has_force)
                  call interaction(s, domain%frame_t, material, place%unit(:, :, mode), place%unit_stress(:, :, mode), flux, source)
                  if (domain%field%is_running) &
                     call add_motion(s, domain, material, mode, place%unit(:, :, mode), x, velocity, source)
                  if (mode == fields) source = place%resolved*source
                  call weigh(s%volume, flux, source, radii, places%q(1, n), places%dq(1, 1, n), sums(1, mode))
               end do
            end associate
         end do
         call add_faces_on_interfaces(domain, problem%interfaces, closed, p%total_frame, q, sums, by_closed, &
                                      found%k_uncertainty)
         do n = 1, size(problem%loads)
            if (problem%loads(n)%by_mass .or. problem%loads(n)%line > 0) cycle
            call add_loaded_faces(domain, grid, p, blocks, problem%loads(n), factors(n), q, sums, found%on_faces)
         end do
      end associate
      found%j = (sums(:, 0) + closed%work_at_tip())/domain%thickness
      found%k = transpose(sums(:, 1:modes))
      found%of_force = sums(:, fields)/domain%thickness
      associate (j => found%j, k => found%k, k_uncertainty => found%k_uncertainty)
         do n = 1, radii
            k(:, n) = domain%field%intensities_of(k(:, n), domain%thickness)
            if (closed%are_closed) j(n) = j(n) + by_closed(2, n)*k(2, n)/domain%thickness ! faces there slide as those of K_II
            k_uncertainty(:, n) = abs(domain%field%intensities_of(k_uncertainty(:, n), domain%thickness))
         end do
         if (domain%half) then
            j = 2*j
            k(1, :) = 2*k(1, :)
            k(2, :) = 0
         end if
      end associate
   end subroutine domain_integrals

   !> G_I and G_II [J/m2]: J shared as the fields of K_I and K_II share it, each signed like its K. In an isotropic material in
   !> proportion to their squares, with sizes that sum to J, which converges faster than K.
   pure function shares_of_modes(field, j, k) result(g)
      type(tip_field_t), intent(in) :: field
      real(dp), intent(in) :: j                  !! [J/m2]
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp) :: g(modes)
      g = 0
      if (any(abs(k) > 0)) g = abs(j)*field%shares(k)*sign(1.0_dp, k)
   end function shares_of_modes

   !> Complete the frame of a tip by the rotation of the material in the discs, zero for laws of small rotation, and by the means
   !> of u,1, turned back by it, and, of a running tip, of the velocity. On a symmetry plane the normal stress allows only the
   !> component along it to be subtracted.
   pure subroutine find_frame(domain, materials, p, places)
      type(tip_domain_t), intent(inout) :: domain
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(in) :: p
      type(places_t), intent(in) :: places
      real(dp) :: weight, total, mean(ndim, ndim), velocity(ndim), angle
      logical :: turns
      integer :: n
      domain%mu = domain%material%mu
      mean = 0
      velocity = 0
      total = 0
      turns = .false.
      do n = 1, size(places%list)
         associate (i => places%list(n)%particle)
            weight = p%volume(i)*places%list(n)%weight
            mean = mean + weight*p%gradient_of(i)
            if (domain%field%is_running) velocity = velocity + weight*p%velocity(i, :)
            turns = turns .or. materials(p%material(i))%is_finite
            total = total + weight
         end associate
      end do
      if (.not. total > 0) return
      mean = mean/total
      if (turns .and. .not. domain%half) then
         angle = atan2(mean(2, 1) - mean(1, 2), 2 + mean(1, 1) + mean(2, 2))
         domain%turn(:, 1) = in_plane(-2*sin(angle/2)**2, sin(angle))
         domain%turn(:, 2) = in_plane(-sin(angle), -2*sin(angle/2)**2)
      end if
      domain%constant(:, 1) = matmul(turned_back(domain, matmul(mean, domain%axes(:, 1)), domain%axes(:, 1)), domain%axes)
      domain%carried = domain%in_axes(velocity/total)
      if (domain%half) domain%constant(2, 1) = 0
      if (domain%half) domain%carried(2) = 0
   end subroutine find_frame

   !> The change u,d of the displacement along a direction d without the turn of the material: R**T (d + u,d) - d [-].
   pure function turned_back(domain, slope, along)
      type(tip_domain_t), intent(in) :: domain
      real(dp), intent(in) :: slope(ndim)        !! u,d [-]
      real(dp), intent(in) :: along(ndim)        !! d, a unit vector
      real(dp) :: turned_back(ndim), line(ndim)
      line = slope + along
      turned_back = slope + matmul(line, domain%turn)
   end function turned_back

   !> Fields of a particle in the discs.
   pure subroutine sample_place(domain, problem, p, place, state, s)
      type(tip_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      type(place_t), intent(in) :: place
      type(nodal_state_t), intent(in) :: state
      type(sample_t), intent(out) :: s
      real(dp) :: acceleration(ndim)
      integer :: k
      acceleration = 0
      do k = 1, problem%grid%n_functions
         acceleration = acceleration + place%shape(k)*state%divergence(:, place%point(k))
      end do
      call take_sample(domain%frame_t, problem%materials(p%material(place%particle)), p, place%particle, acceleration, s)
   end subroutine sample_place

   !> Add a particle's contribution to the integral of each disc.
   pure subroutine weigh(volume, flux, source, radii, q, dq, sums)
      real(dp), intent(in) :: volume             !! of the particle [m3]
      real(dp), intent(in) :: flux(ways, ndim), source(ways) !! factors of q,J and of q
      integer, intent(in) :: radii
      real(dp), intent(in) :: q(radii)           !! at the particle, by radius
      real(dp), intent(in) :: dq(ndim, radii)    !! its gradient [1/m]
      real(dp), intent(inout) :: sums(radii)
      integer :: r
      do r = 1, radii
         sums(r) = sums(r) + volume*(flux(1, 1)*dq(1, r) + flux(1, 2)*dq(2, r) + source(1)*q(r))
      end do
   end subroutine weigh

   !> Change the source of the interaction with a field of a running tip, see `domain_integrals`.
   pure subroutine add_motion(s, domain, material, mode, a, x, velocity, source)
      type(sample_t), intent(in) :: s
      type(tip_domain_t), intent(in) :: domain
      type(material_t), intent(in) :: material   !! of the particle
      integer, intent(in) :: mode
      real(dp), intent(in) :: a(ndim, ndim)      !! displacement gradient of the field
      real(dp), intent(in) :: x(ndim), velocity(ndim) !! from the tip [m], and relative to the mean [m/s]
      real(dp), intent(inout) :: source(ways)
      source = min(1.0_dp, norm(x)/domain%inner_radius()) &
               *(source + material%mu/domain%material%mu*dot_product(domain%field%inertia(mode, x), s%slope(:, 1)))
      if (norm(x) < domain%inner_radius()) source = source - material%density*domain%speed*dot_product(velocity, a(:, 1)) &
                                                             *x(1)/(norm(x)*domain%inner_radius())
   end subroutine add_motion

   !> Add faces pressed on each other by interface points to both integrals: the force f of a point against the opening, times the
   !> change of that along the crack, f . [u],1 q for B J and f . [a],1 q for the interaction.
   !>
   !> Forces in a cohesive zone ahead of the tip are not of the body: the integrals are to be those of a circle around the zone, so
   !> that its faces count with q - 1. J is then the energy taken from the body where q is 1, and K that of the body around a short
   !> zone. The same holds for releasing bonded points at a growing tip, also beyond the disc, where q is 0: zones are some cells
   !> long, as discs may be.
   !>
   !> In the last cells the slope of a is largest, and the tractions of the compliant layer oscillate. At a closed tip the
   !> extrapolated traction of the faces behind replaces them, faces slide by K_II, and the layer follows that traction.
   pure subroutine add_faces_on_interfaces(domain, interfaces, closed, total_frame, q, sums, by_closed, k_uncertainty)
      type(tip_domain_t), intent(in) :: domain
      type(interfaces_t), intent(in) :: interfaces
      type(closed_faces_t), intent(in) :: closed
      logical, intent(in) :: total_frame         !! whether interface points are at places of the reference configuration
      real(dp), allocatable, intent(in) :: q(:, :) !! at the points [-], (radii, points)
      real(dp), intent(inout) :: sums(:, 0:)     !! of J and of each mode
      real(dp), intent(inout) :: by_closed(:, :) !! part of K by faces behind a closed tip
      real(dp), intent(inout) :: k_uncertainty(:, :) !! uncertain part of K by replaced tractions
      real(dp) :: force(ndim), slope(ndim), at_point(size(q, 1)), direction(ndim), x(ndim), normal(ndim), of_unit(ndim), &
                  uncertainty(ndim), far
      real(dp), parameter :: around = 8          ! cells, within which the nodes of a point are
      type(nearby_t) :: near
      logical :: is_there, is_closed, softens
      integer, allocatable :: beside(:)
      integer :: n, k, i, mode
      far = maxval(domain%radius)
      direction = domain%axes(:, 1)
      if (.not. total_frame) direction = direction + matmul(domain%turn, direction)
      call find_points_at_tip(interfaces, domain%tip, far, around, beside)
      do k = 1, size(beside)
         n = beside(k)
         softens = interfaces%list(n)%tip == domain%number
         if (softens) softens = is_softening(interfaces%list(n))
         if (.not. softens .and. any(abs(interfaces%list(n)%middle - domain%tip) > far + around*interfaces%list(n)%cell)) cycle
         at_point = 0
         do i = 1, count(interfaces%list(n)%jump%node > 0)    ! the mean of both faces, of which the right one has the other sign
            associate (point => interfaces%list(n))
               at_point = at_point + sign(0.5_dp, point%n_left - i + 0.5_dp)*point%jump%share(i)*weights_at(q, point%jump%node(i))
            end associate
         end do
         if (is_half(interfaces%list(n))) at_point = 2*at_point ! there is one face
         if (softens) then
            at_point = at_point - 1
         else if (.not. any(at_point > rounding)) then
            cycle
         end if
         if (domain%has_zone .and. holds(interfaces%list(n))) at_point = merge(at_point - 1, 0.0_dp, at_point > rounding)
         uncertainty = 0
         call find_face_force(interfaces, near, n, direction, force, slope, is_there)
         is_closed = closed%has(interfaces%list(n))
         if (is_there .and. .not. is_closed) sums(:, 0) = sums(:, 0) + dot_product(force, slope)*at_point
         if (is_closed) then
            force = interfaces%list(n)%length*closed%traction_at(closed%distance_of(interfaces%list(n)))
            sums(:, 0) = sums(:, 0) + dot_product(force, closed%slope_across())*at_point
            uncertainty = interfaces%list(n)%length*closed%uncertainty_at(closed%distance_of(interfaces%list(n)))
         else if (.not. is_there) then
            cycle
         end if
         normal = domain%from_tip(domain%tip + interfaces%list(n)%normal, total_frame)
         force = sign(1.0_dp, normal(2))*domain%in_axes(force)
         x = domain%from_tip(interfaces%list(n)%middle, total_frame)
         do mode = 1, modes
            of_unit = 2*mean_slope_of_face(domain, mode, -x(1), interfaces%list(n)%length/2)
            sums(:, mode) = sums(:, mode) + dot_product(force, of_unit)*at_point
            if (is_closed) by_closed(mode, :) = by_closed(mode, :) + dot_product(force, of_unit)*at_point
            k_uncertainty(mode, :) = k_uncertainty(mode, :) + dot_product(uncertainty, of_unit)*at_point
         end do
      end do
   end subroutine add_faces_on_interfaces

   !> Add the tractions of a load on the faces to all integrals, and find those at the tip.
   pure subroutine add_loaded_faces(domain, grid, p, blocks, load, factor, q, sums, on_faces)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(load_t), intent(in) :: load
      real(dp), intent(in) :: factor             !! of the load [-]
      real(dp), allocatable, intent(in) :: q(:, :) !! at the points of the grid [-], (radii, points)
      real(dp), intent(inout) :: sums(:, 0:)     !! of J and of each field
      real(dp), intent(inout) :: on_faces(ndim)  !! stresses s_12 and s_22 [Pa]
      real(dp), parameter :: at_tip = 1 + 1e-6_dp
      real(dp) :: force(ndim), x(ndim), slope(ndim), a(ndim, ndim), side, part_of_face, half, at_point(size(q, 1))
      integer :: n, k, mode
      do n = 1, size(load%particle)
         associate (particle => load%particle(n))
            if (maxval(load%node(:, n)) < lbound(q, 2) .or. minval(load%node(:, n)) > ubound(q, 2)) cycle
            at_point = 0
            do k = 1, size(load%node, 1)
               at_point = at_point + load%shape(k, n)*weights_at(q, load%node(k, n))
            end do
            if (.not. any(abs(at_point) > 0)) cycle
            force = domain%in_axes(factor*load%force_at(n))
            x = domain%from_tip(p%place_in_grid(particle), p%total_frame)
            side = sign(1.0_dp, x(2))
            part_of_face = merge(domain%below%part_of_opening, domain%field%part_of_opening, &
                                 side < 0 .and. domain%field%is_at_interface)
            slope = turned_back(domain, slope_at_face(domain, grid, p, blocks, particle, load%offset(:, n)), domain%axes(:, 1))
            sums(:, 0) = sums(:, 0) - dot_product(force, matmul(slope, domain%axes) - domain%constant(:, 1))*at_point
            x = domain%from_tip(p%place_in_grid(particle) + load%offset(:, n), p%total_frame)
            half = norm(load%half(:, n))
            do mode = 1, modes
               sums(:, mode) = sums(:, mode) - 2*part_of_face*side*at_point &
                                               *dot_product(force, mean_slope_of_face(domain, mode, -x(1), half))
            end do
            if (.not. domain%has_force .or. .not. norm(x) > 0) cycle
            a = domain%field%gradient_of_force(x)
            sums(:, fields) = sums(:, fields) - dot_product(force, a(:, 1))*at_point
            if (half > 0 .and. norm(x) <= at_tip*half) &
               on_faces = on_faces - side*merge(1.0_dp, 0.5_dp, domain%half)*force/(2*half*domain%thickness)
         end associate
      end do
   end subroutine add_loaded_faces

   !> u,1 on a face, beside a particle [-]. In a cell it is linear in the distance from the line of the crack, in quadratic cells
   !> quadratic in that and linear along the crack, extrapolated from the particles of the cell by least squares: the value of the
   !> nearest particle would have a constant error near the tip. Terms that they do not determine up to the face are left out.
   pure function slope_at_face(domain, grid, p, blocks, particle, offset) result(slope)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim)       !! of the face from the particle [m]
      real(dp) :: slope(ndim)
      real(dp), allocatable :: term(:, :), slopes(:, :), at_face(:) ! of the particles, made orthogonal one after the other
      real(dp) :: far
      integer :: e, i, n, k, of_cell(2)
      of_cell = p%cell(particle)
      if (domain%quadratic) of_cell = [grid%first_of_piece(of_cell(1)), grid%last_of_piece(of_cell(1))]
      n = sum(blocks%count_in(of_cell(1):of_cell(2)))
      allocate (at_face, source=terms_at(offset))
      allocate (term(n, size(at_face)), slopes(n, ndim))
      n = 0
      do e = of_cell(1), of_cell(2)
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            n = n + 1
            term(n, :) = terms_at(p%reference(i, :) - p%reference(particle, :))
            slopes(n, :) = matmul(p%gradient(i, :, :), domain%axes(:, 1))
         end do
      end do
      slope = 0
      do n = 1, size(at_face)
         far = at_face(n)
         do k = 1, n - 1
            if (.not. any(abs(term(:, k)) > 0)) cycle
            associate (part => dot_product(term(:, n), term(:, k))/sum(term(:, k)**2))
               at_face(n) = at_face(n) - part*at_face(k)
               term(:, n) = term(:, n) - part*term(:, k)
            end associate
         end do
         if (n > 1 .and. .not. sum(term(:, n)**2) > far**2) term(:, n) = 0
         if (any(abs(term(:, n)) > 0)) slope = slope + at_face(n)/sum(term(:, n)**2)*matmul(term(:, n), slopes)
      end do

   contains

      !> The terms of u,1 at a distance from the particle [m].
      pure function terms_at(from_particle) result(terms)
         real(dp), intent(in) :: from_particle(ndim) !! [m]
         real(dp), allocatable :: terms(:)
         associate (y => dot_product(from_particle, quarter_turn(domain%axes(:, 1))), &
                    x => dot_product(from_particle, domain%axes(:, 1)))
            terms = [1.0_dp, y]
            if (domain%quadratic) terms = [1.0_dp, y, x, x*y, y**2, x*y**2]
         end associate
      end function terms_at
   end function slope_at_face

   !> Mean of half of the change of sliding and opening over a segment of the faces, a,1 of the upper face in one material, in crack
   !> axes [1/(Pa sqrt(m))]. Segments that end at the tip begin exactly there: the opening is as the root of the distance.
   pure function mean_slope_of_face(domain, mode, r, half) result(mean)
      type(tip_domain_t), intent(in) :: domain
      integer, intent(in) :: mode
      real(dp), intent(in) :: r                  !! distance of its middle behind the tip [m]
      real(dp), intent(in) :: half               !! half of its length [m]
      real(dp) :: mean(ndim)
      real(dp), parameter :: same = 1e-9_dp      ! part of a segment that counts as none
      real(dp) :: near, far
      integer :: d
      near = r - half - domain%tip_offset_of(mode)
      if (near <= same*half) near = 0
      far = max(r + half - domain%tip_offset_of(mode), 0.0_dp)
      mean = 0
      if (.not. half > 0) return
      do d = 1, ndim
         mean(d) = -(domain%field%opening(3 - d, mode, far) - domain%field%opening(3 - d, mode, near))/(4*half)
      end do
   end function mean_slope_of_face
end module hampm_domain_integral
