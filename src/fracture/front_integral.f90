!> Energy release rate and stress intensity factors along the front of a plane crack, by domain integrals, of solids only.
!>
!> For an extension q(X) of the crack, f(r) N_k(s) times the normal e_1(s) of the front in its plane, at its ends along sides,
!>
!>    G_k int N_k ds = sum_p V [ E_mJ q_m,J + (div P)_i u_i,m q_m ],                                   E_mJ = u_i,m P_iJ - W d_mJ,
!>    2 K_k/E' int N_k ds = sum_p V [ I_mJ q_m,J + (div P)_i A_im q_m + (div s)_i u_i,m q_m + P_ij (A_im,j - A_ij,m) q_m ],
!>    I_mJ = P_iJ A_im + s_iJ u_i,m - P_kl A_kl d_mJ;
!>
!> in mode III 2/E' is 1/mu. q has the functions of the grid in the reference configuration, with which particles integrate forces:
!> their nodal sums are independent of q, for all hat functions and domains. E of a uniform stress has no divergence: for a pressure
!> p on faces P has p n n more and W p u_n,n. Pressed faces with a force f add f . [A e_1] q to the interaction. Interface points
!> ahead of a curved front (`hampm_plane_points`) become longer: their energy w by area adds -sum w g q to G (`find_unit_field`).
module hampm_front_integral
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: inside_cell
   use hampm_energy_momentum, only: ways, plateau, frame_t, sample_t, take_sample, energy_momentum, interaction, weight_at
   use hampm_front, only: front_t
   use hampm_interface_points, only: bonded, energy_of, face_force, is_pressed
   use hampm_face_slopes, only: find_face_force
   use hampm_material, only: material_t
   use hampm_nearby, only: nearby_t
   use hampm_nodal_state, only: nodal_state_t
   use hampm_outline, only: wall_t
   use hampm_problem, only: problem_t
   use hampm_tensors, only: norm, identity
   implicit none
   private
   public :: front_domain_t, front_place_t, front_integrals, front_modes, along, cell_at, locate

   integer, parameter :: front_modes = 3         !! opening, sliding across the front and along it
   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: singular = 1e-3_dp     !! part of a cell within which of the front a particle counts as on it

   !> A front, and the domains around it.
   type, extends(frame_t) :: front_domain_t
      type(front_t) :: front
      type(wall_t), allocatable :: walls(:)      !! at which it may end
      real(dp), allocatable :: radius(:)         !! of the domains, in planes normal to the front, ascending [m]
      integer :: material = 0                    !! number of the material at it
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! of all material [m]
      real(dp) :: cell = 0                       !! the finest [m]
      logical :: has_modes = .false.             !! whether K have a meaning there: by isotropic laws of small strain
   contains
      procedure :: only_side
   end type front_domain_t

   !> A place as seen from the nearest place of a front.
   type :: front_place_t
      integer :: node = 0                        !! after which that is, 0: far away
      real(dp) :: part = 0                       !! position on the way to the next node [-]
      real(dp) :: ahead = 0                      !! along e_1 [m]
      real(dp) :: above = 0                      !! along the normal of the plane [m]
      real(dp) :: curvature = 0                  !! of the front, above 0 where the crack is convex [1/m]
      real(dp) :: outward(ndim) = 0              !! e_1
   end type front_place_t

contains

   !> The side of a plane of symmetry with material: 1 above, 2 below.
   pure integer function only_side(self)
      class(front_domain_t), intent(in) :: self
      associate (axis => self%front%axis, plane => self%front%plane)
         only_side = merge(1, 2, self%upper(axis) - plane > plane - self%lower(axis))
      end associate
   end function only_side

   !> Means over hats: G at front nodes [J/m2], (nodes, radii), and K_I, K_II and K_III [Pa sqrt(m)], (modes, nodes, radii).
   subroutine front_integrals(domain, problem, state, g, k)
      type(front_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      type(nodal_state_t), intent(in) :: state   !! of its particles
      real(dp), allocatable, intent(out) :: g(:, :), k(:, :, :)
      real(dp), allocatable :: of_node(:, :, :)  ! nodal material forces, and those of the interaction, (ndim, 0:modes, n_points)
      real(dp) :: force(ndim), slope(ndim)
      real(dp) :: at(0:front_modes), of_unit, a(ndim, ndim), s(ndim, ndim), of_s(ndim), of_a(ndim)
      integer :: i, mode, r
      logical :: is_there
      type(front_place_t) :: place
      type(nearby_t) :: near
      associate (grid => problem%grid, front => domain%front, material => problem%materials(domain%material))
         allocate (of_node(ndim, 0:front_modes, grid%n_points), source=0.0_dp)
         call sum_particles(domain, problem, state, of_node)
         call grid%dofs%condense(grid%dofs%every_node(), ndim*(front_modes + 1), of_node)
         allocate (g(front%n(), size(domain%radius)), k(front_modes, front%n(), size(domain%radius)), source=0.0_dp)
         do i = 1, grid%n_nodes
            if (.not. any(abs(of_node(:, 0, i)) > 0)) cycle
            place = locate(front, grid%node_position(:, i), maxval(domain%radius))
            if (place%node == 0) cycle
            at = matmul(extension(domain, place, grid%node_position(:, i)), of_node(:, :, i))
            call add_to_hats(at)
         end do
         do i = 1, problem%interfaces%n
            associate (point => problem%interfaces%list(i))
               if (point%law /= bonded .and. .not. is_pressed(point)) cycle
               place = locate(front, point%middle, maxval(domain%radius))
               if (place%node == 0) cycle
               at = 0
               if (point%law == bonded) then
                  at(0) = -energy_of(point)*place%curvature/(1 + place%curvature*place%ahead)
               else if (point%friction > 0) then
                  call find_face_force(problem%interfaces, near, i, place%outward, force, slope, is_there)
                  at(0) = dot_product(force, slope)
               end if
               place%above = 0
               if (point%law /= bonded) call take_mean_place(point%length/2, place%ahead)
               do mode = 1, merge(front_modes, 0, domain%has_modes .and. point%law /= bonded .and. place%ahead < 0)
                  call find_unit_field(domain, material, place, mode, a, s, of_s, of_a)
                  at(mode) = 2*sign(1.0_dp, point%normal(front%axis))*dot_product(face_force(point), matmul(a, place%outward))
               end do
               call add_to_hats(at)
            end associate
         end do
         if (front%is_symmetry) then
            g = 2*g
            k(1, :, :) = 2*k(1, :, :)
            k(2:, :, :) = 0
         end if
         do r = 1, size(domain%radius)
            g(:, r) = g(:, r)/front%weight
            do mode = 1, front_modes
               of_unit = material%mu/(1 - material%poisson)
               if (mode == front_modes) of_unit = material%mu
               k(mode, :, r) = of_unit*k(mode, :, r)/front%weight
            end do
         end do
      end associate

   contains

      !> Place where the slope of the unit field is its mean along a part of the faces, with the distance to the power -1/2.
      pure subroutine take_mean_place(half, ahead)
         real(dp), intent(in) :: half            !! of the part [m]
         real(dp), intent(inout) :: ahead        !! of its middle [m]
         if (ahead < half) ahead = -(half/(sqrt(half - ahead) - sqrt(max(-ahead - half, 0.0_dp))))**2
      end subroutine take_mean_place

      !> Add the sums at a place to its hat functions.
      subroutine add_to_hats(of_place)
         real(dp), intent(in) :: of_place(0:front_modes)
         real(dp) :: f(size(domain%radius)), part
         integer :: side, node, r
         f = weight_at(hypot(place%ahead, place%above), domain%radius, plateau*domain%radius)
         do side = 0, 1
            node = modulo(place%node + side - 1, domain%front%n()) + 1
            part = merge(1 - place%part, place%part, side == 0)
            do r = 1, size(f)
               g(node, r) = g(node, r) + part*f(r)*of_place(0)
               k(:, node, r) = k(:, node, r) + part*f(r)*of_place(1:)
            end do
         end do
      end subroutine add_to_hats
   end subroutine front_integrals

   !> Size of the largest cells with material at the nodes of a front [m].
   pure real(dp) function cell_at(front, problem) result(cell)
      type(front_t), intent(in) :: front
      type(problem_t), intent(in) :: problem
      integer :: i, side
      cell = 0
      do i = 1, front%n()
         do side = -1, 1, 2
            associate (e => problem%grid%element_at(front%at(:, i) + side*problem%grid%finest_cell/4*identity(:, front%axis)))
               if (e == 0) cycle
               if (problem%blocks%count_in(e) > 0) cell = max(cell, problem%grid%leaf_size(e))
            end associate
         end do
      end do
   end function cell_at

   !> Sum the contributions of particles at nodes.
   pure subroutine sum_particles(domain, problem, state, of_node)
      type(front_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      type(nodal_state_t), intent(in) :: state
      real(dp), intent(inout) :: of_node(:, 0:, :)
      logical, allocatable :: is_near(:)
      type(front_place_t) :: place
      real(dp) :: reach
      integer :: n, i
      associate (grid => problem%grid, blocks => problem%blocks)
         allocate (is_near(grid%n_points), source=.false.)
         do i = 1, grid%n_points                 ! hanging nodes are among nodes that do not hang, two cells away or less
            place = locate(domain%front, grid%node_position(:, i), maxval(domain%radius) + 2*grid%finest_cell)
            is_near(i) = place%node > 0
         end do
         do n = 1, blocks%n_occupied
            associate (e => blocks%occupied(n))
               if (.not. any(is_near(grid%element_nodes(:, e))) .or. .not. grid%is_in_first_field(e)) cycle
               reach = maxval(domain%radius) + 4*grid%element_size(e)
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  call add_particle(domain, problem, state, i, reach, of_node)
               end do
            end associate
         end do
      end associate
   end subroutine sum_particles

   !> Add a particle's contributions to the nodes of its cell.
   pure subroutine add_particle(domain, problem, state, i, reach, of_node)
      type(front_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      type(nodal_state_t), intent(in) :: state
      integer, intent(in) :: i
      real(dp), intent(in) :: reach              !! from the front, no less than the particle's distance [m]
      real(dp), intent(inout) :: of_node(:, 0:, :)
      real(dp) :: a(ndim, ndim), s(ndim, ndim), of_s(ndim), of_a(ndim)
      real(dp) :: flux(ways, ndim, 0:front_modes), source(ways, 0:front_modes)
      real(dp) :: gradient(problem%grid%n_functions, ndim), shape(problem%grid%n_functions), xi(ndim)
      real(dp) :: at_nodes(ndim, problem%grid%n_functions)
      integer :: nodes(problem%grid%n_functions), last, j, k
      type(front_place_t) :: place
      type(sample_t) :: here
      associate (grid => problem%grid, p => problem%particles, e => problem%particles%cell(i), &
                 material => problem%materials(problem%particles%material(i)))
         xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
         nodes = grid%element_nodes(:, e)
         shape = grid%functions_in(e, xi)
         gradient = grid%gradients_in(e, xi)
         at_nodes = state%divergence(:, nodes)
         call take_sample(domain%frame_t, material, p, i, matmul(at_nodes, shape), here)
         call energy_momentum(here, flux(:, :, 0), source(:, 0))
         last = 0
         if (domain%has_modes) then
            place = locate(domain%front, p%reference(i, :), reach)
            if (place%node > 0 .and. hypot(place%ahead, place%above) > singular*grid%element_size(e)) &
               last = merge(1, front_modes, domain%front%is_symmetry)
         end if
         do k = 1, last
            call find_unit_field(domain, material, place, k, a, s, of_s, of_a)
            call interaction(here, domain%frame_t, material, a, s, flux(:, :, k), source(:, k))
            source(:, k) = source(:, k) + matmul(of_s, here%slope) &
                           + dot_product(matmul(here%stress, along(domain%front, place)), of_a)*place%outward(:ways)
         end do
         do j = 1, size(nodes)
            do k = 0, last
               associate (at => of_node(:ways, k, nodes(j)))
                  at = at + p%volume(i)*(matmul(flux(:, :, k), gradient(j, :)) + source(:, k)*shape(j))
               end associate
            end do
         end do
      end associate
   end subroutine add_particle

   !> Motion of a node for an advance 1 of the front [-]: along its normal, tangential on a side, within a cell of a round one.
   pure function extension(domain, place, x) result(e)
      type(front_domain_t), intent(in) :: domain
      type(front_place_t), intent(in) :: place
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: e(ndim)
      real(dp), parameter :: on_side = 1e-3_dp   ! of the radius
      real(dp), parameter :: least = 0.25_dp     ! of sides that a front leaves along itself
      e = place%outward
      where (min(abs(x - domain%lower), abs(x - domain%upper)) < on_side*domain%radius(1)) e = 0
      call take_off_walls(domain, x, e)
      e = e/max(dot_product(e, place%outward), least)
   end function extension

   !> Remove the part of a motion through the wall of a hole, or a round side, nearer than a cell, within the crack plane.
   pure subroutine take_off_walls(domain, x, e)
      type(front_domain_t), intent(in) :: domain
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(inout) :: e(ndim)
      real(dp) :: normal(ndim)
      integer :: w
      do w = 1, size(domain%walls)
         associate (wall => domain%walls(w), front => domain%front, cell => domain%cell)
            if (.not. (wall%is_hole .or. wall%is_circle)) cycle
            if (wall%distance(x) > cell) cycle
            normal = wall%normal_at(x)
            if (abs(x(front%axis) - front%plane) < singular*cell) normal(front%axis) = 0
            e = e - dot_product(e, normal)*normal/max(sum(normal**2), tiny(cell))
         end associate
      end do
   end subroutine take_off_walls

   !> t = e_1 x n.
   pure function along(front, place) result(t)
      type(front_t), intent(in) :: front
      type(front_place_t), intent(in) :: place
      real(dp) :: t(ndim)
      t = 0
      t(front%along) = [place%outward(front%along(2)), -place%outward(front%along(1))]
   end function along

   !> The slope A of the plane field of a unit K of a mode in the axes e_1, n, t = e_1 x n of the nearest place of the front, its
   !> stress s, the divergence of s, and the curl of A. Both fields have no curvature: s leaves faces free, but at a distance d
   !> ahead of a front of curvature c, with g = c/(1 + c d),
   !>
   !>    div s = g [ (s_11 - s_tt) e_1 + s_n1 n + 2 s_t1 t ],   t-derivative of A = g [ (A_i1 e_i)' + ... ], e_1' = t, t' = -e_1,
   !>
   !> do not vanish (Gosz & Moran 2002).
   pure subroutine find_unit_field(domain, material, place, mode, a, s, of_s, of_a)
      type(front_domain_t), intent(in) :: domain
      type(material_t), intent(in) :: material
      type(front_place_t), intent(in) :: place
      integer, intent(in) :: mode
      real(dp), intent(out) :: a(ndim, ndim)     !! A [1/(Pa sqrt(m))]
      real(dp), intent(out) :: s(ndim, ndim)     !! s [1/sqrt(m)]
      real(dp), intent(out) :: of_s(ndim)        !! div s
      real(dp), intent(out) :: of_a(ndim)        !! D e_1, of the derivative D of A along t
      real(dp) :: axes(ndim, front_modes), local(front_modes, front_modes), stress(front_modes, front_modes), u(front_modes), &
                  turned(front_modes), r, angle, half, kolosov, g
      integer :: i
      r = hypot(place%ahead, place%above)
      angle = atan2(place%above, place%ahead)
      half = angle/2
      kolosov = 3 - 4*material%poisson
      u = 0
      turned = 0                                 ! derivative of u with respect to the angle
      select case (mode)
      case (1)
         u(:2) = [cos(half), sin(half)]*(kolosov - cos(angle))
         turned(:2) = [-sin(half), cos(half)]*(kolosov - cos(angle))/2 + [cos(half), sin(half)]*sin(angle)
      case (2)
         u(:2) = [sin(half)*(kolosov + 2 + cos(angle)), -cos(half)*(kolosov - 2 + cos(angle))]
         turned(:2) = [cos(half)*(kolosov + 2 + cos(angle)), sin(half)*(kolosov - 2 + cos(angle))]/2 &
                      + [-sin(half), cos(half)]*sin(angle)
      case default
         u(3) = 4*sin(half)
         turned(3) = 2*cos(half)
      end select
      local = 0
      local(:, 1) = (u*cos(angle)/2 - turned*sin(angle))/(2*material%mu*sqrt(2*pi*r))
      local(:, 2) = (u*sin(angle)/2 + turned*cos(angle))/(2*material%mu*sqrt(2*pi*r))
      stress = material%mu*(local + transpose(local))
      do i = 1, front_modes
         stress(i, i) = stress(i, i) + material%small_strain_lambda()*(local(1, 1) + local(2, 2))
      end do
      axes = 0
      axes(:, 1) = place%outward
      axes(domain%front%axis, 2) = 1
      axes(:, 3) = along(domain%front, place)
      a = matmul(axes, matmul(local, transpose(axes)))
      s = matmul(axes, matmul(stress, transpose(axes)))
      g = place%curvature/(1 + place%curvature*place%ahead)
      of_s = g*matmul(axes, [stress(1, 1) - stress(3, 3), stress(2, 1), 2*stress(3, 1)])
      of_a = g*matmul(axes, [-local(3, 1), 0.0_dp, local(1, 1)])
   end subroutine find_unit_field

   !> Coordinates of a place at the front: at the front place with the normal plane through it. Normals turn evenly between nodes.
   pure function locate(front, x, reach) result(place)
      type(front_t), intent(in) :: front
      real(dp), intent(in) :: x(ndim)            !! in the reference configuration [m]
      real(dp), intent(in) :: reach              !! beyond which it is far away [m]
      type(front_place_t) :: place
      real(dp), parameter :: beyond = 1e-9_dp    ! of a way between nodes
      real(dp), dimension(2) :: way, turn, from, outward
      real(dp) :: t, ahead, distance, best, above, roots(2), far
      integer :: k, next, i, n
      above = x(front%axis) - front%plane
      best = reach
      if (abs(above) >= reach) return
      n = front%n()
      far = 2*reach + front%length/max(1, n - 1)
      do k = 1, n - merge(0, 1, front%is_closed)
         from = x(front%along) - front%at(front%along, k)
         if (sum(from**2) > far**2) cycle
         next = modulo(k, n) + 1
         way = front%at(front%along, next) - front%at(front%along, k)
         outward = front%outward(front%along, k)
         turn = front%outward(front%along, next) - outward
         roots = roots_of(cross(from, outward), cross(from, turn) - cross(way, outward), -cross(way, turn))
         do i = 1, 2
            t = roots(i)
            if (.not. front%is_closed) then      ! beside its ends
               if (k == 1) t = max(t, 0.0_dp)
               if (next == n) t = min(t, 1.0_dp)
            end if
            if (t < -beyond .or. t > 1 + beyond) cycle
            associate (e => (outward + t*turn)/norm(outward + t*turn))
               ahead = dot_product(from - t*way, e)
               distance = hypot(norm(from - t*way), above)
               if (distance >= best) cycle
               best = distance
               place%node = k
               place%part = min(max(t, 0.0_dp), 1.0_dp)
               place%ahead = ahead
               place%above = above
               place%curvature = dot_product(turn, way)/sum(way**2)
               place%outward(front%along) = e
            end associate
         end do
      end do
   end function locate

   !> Roots of c + b t + a t**2, equal if there is only one, far away if there is none.
   pure function roots_of(c, b, a) result(t)
      real(dp), intent(in) :: c, b, a
      real(dp) :: t(2), q
      t = huge(q)
      if (b**2 < 4*a*c) return
      q = -(b + sign(sqrt(b**2 - 4*a*c), b))/2
      if (.not. abs(q) > 0) return
      t = c/q
      if (abs(a)*1e9_dp > abs(q)) t(2) = q/a
   end function roots_of

   !> Of two vectors of the plane.
   pure real(dp) function cross(a, b)
      real(dp), intent(in) :: a(2), b(2)
      cross = a(1)*b(2) - a(2)*b(1)
   end function cross
end module hampm_front_integral
