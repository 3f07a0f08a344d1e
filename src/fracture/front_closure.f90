!> Energy release rate along the front of a plane crack by virtual closure, by area; of solids only.
!>
!> Let the crack move by a cell, v, along an axis of its plane. Forces F_j that hold the faces, of closed nodes and interface
!> points, are then the same at x_j + v, and the separation is g(x - v). By reciprocity a piece of the front needs the energy
!>
!>    G_k v . e_1 int N_k ds = sum_j N_k F_j . [g(x_j - v) - g(x_j + v)]/2,
!>
!> e_1 being its normal half of v back from x_j, the last term the separation of soft points. Both axes count by their component of
!> e_1, one cell for any direction of the front. At a distance d ahead of a front of curvature c points become longer, which takes
!> c/(1 + c d) F_j . g(x_j)/2 off. For a straight front on nodes it is the force of each node times the opening of the one behind
!> (Shivakumar, Tan & Newman 1988). Modes are the parts across the plane, along e_1 and along the front. Pressure p on the faces is
!> closed as the tension p, with the part of all faces ahead of the front (`hampm_crack_closure`).
module hampm_front_closure
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: inside_cell
   use hampm_front, only: front_t
   use hampm_front_integral, only: front_domain_t, front_place_t, front_modes, along, cell_at, locate
   use hampm_interface_points, only: pulls, force_of
   use hampm_openings, only: opening_at
   use hampm_problem, only: problem_t
   use hampm_tensors, only: identity
   implicit none
   private
   public :: closure_rates

   integer, parameter :: closed_ways = 2         !! by one cell, and by two
   integer, parameter :: upper = 1, lower = 2
   real(dp), parameter :: in_plane = 1e-6_dp     !! cells
   real(dp), parameter :: reach = 3.5_dp         !! cells from the front considered for forces and separations

   !> Nodal forces in the plane around a front, from the material on both sides.
   type :: sides_t
      logical, allocatable :: is_near(:)         !! whether a point is one of them, (points)
      real(dp), allocatable :: force(:, :, :)    !! of the material of each side on it [N], (ndim, 2, points)
      real(dp), allocatable :: mass(:, :)        !! [kg], (2, points)
      real(dp), allocatable :: area(:, :)        !! of the faces of each side [m2], (2, points)
   end type sides_t

contains

   !> G of each mode at each node of the front [J/m2], (modes, nodes, ways): means over hats.
   subroutine closure_rates(domain, problem, rate)
      type(front_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      real(dp), allocatable, intent(out) :: rate(:, :, :)
      type(sides_t) :: sides
      real(dp), allocatable :: u(:, :)           ! displacements of nodes, where known
      real(dp) :: cell, across(ndim), pressure
      integer :: i, k, side                      ! side with material, of a plane of symmetry
      associate (grid => problem%grid, front => domain%front, cut => problem%grid%planes(domain%front%crack))
         allocate (rate(front_modes, front%n(), closed_ways), source=0.0_dp)
         across = identity(:, front%axis)
         cell = cell_at(front, problem)
         side = domain%only_side()
         call sum_sides(front, problem, reach*cell, sides)
         pressure = 0
         do k = 1, size(problem%loads)
            associate (load => problem%loads(k))
               if (load%line == front%crack .and. load%into(front%axis)*(3 - 2*side) > 0) &
                  pressure = pressure + load%pressure*load%history%factor(problem%state%time)
            end associate
         end do
         do i = 1, grid%n_nodes
            if (.not. sides%is_near(i) .or. .not. any(sides%mass(:, i) > 0)) cycle
            if (cut%opens_at(grid%forest, grid%node_position(:, i))) cycle
            if (front%is_symmetry) then
               call close_at(grid%node_position(:, i), (3 - 2*side)*sides%force(:, side, i) + pressure*sides%area(side, i)*across)
            else
               associate (f => sides%force(:, :, i), mass => sides%mass(:, i))
                  call close_at(grid%node_position(:, i), (mass(lower)*f(:, upper) - mass(upper)*f(:, lower))/sum(mass) &
                                                          + pressure*sum(sides%area(:, i))/2*across)
               end associate
            end if
         end do
         do i = 1, problem%interfaces%n
            associate (point => problem%interfaces%list(i))
               if (pulls(point) .and. is_in_plane(front, problem, point%middle)) call close_at(point%middle, force_of(point))
            end associate
         end do
         do i = 1, front%n()
            rate(:, i, :) = rate(:, i, :)/front%weight(i)
         end do
      end associate

   contains

      !> Add the force of a held place.
      subroutine close_at(x, force)
         real(dp), intent(in) :: x(ndim)         !! [m]
         real(dp), intent(in) :: force(ndim)     !! of the upper on the lower side [N]
         type(front_place_t) :: here, between
         real(dp) :: way(ndim), opening(ndim)
         integer :: k, d
         associate (front => domain%front)
            here = locate(front, x, reach*cell)
            if (here%node == 0) return
            do k = 1, closed_ways
               do d = 1, size(front%along)
                  way = sign(k*cell, here%outward(front%along(d)))*identity(:, front%along(d))
                  between = locate(front, x - way/2, (reach + k)*cell)
                  if (between%node == 0) cycle
                  opening = parted_at(x - way)
                  opening = opening - parted_at(x + way)
                  call give(between, k, force, opening*dot_product(way, between%outward)/(2*sum(way**2)))
               end do
               call give(here, k, force, -parted_at(x)*here%curvature/(2*(1 + here%curvature*here%ahead)))
            end do
         end associate
      end subroutine close_at

      !> Give the work of a force by modes to the hats at a place.
      subroutine give(place, k, force, opening)
         type(front_place_t), intent(in) :: place
         integer, intent(in) :: k                !! of the ways
         real(dp), intent(in) :: force(ndim), opening(ndim)
         real(dp) :: axes(ndim, front_modes), work(front_modes)
         integer :: next
         axes(:, 1) = across
         axes(:, 2) = place%outward
         axes(:, 3) = along(domain%front, place)
         work = matmul(force, axes)*matmul(opening, axes)
         next = modulo(place%node, domain%front%n()) + 1
         rate(:, place%node, k) = rate(:, place%node, k) + (1 - place%part)*work
         rate(:, next, k) = rate(:, next, k) + place%part*work
      end subroutine give

      !> Separation of the faces at a place; those that may touch do not overlap [m].
      function parted_at(x) result(opening)
         real(dp), intent(in) :: x(ndim)         !! [m]
         real(dp) :: opening(ndim)
         opening = opening_at(domain, x, problem, u)
         if (problem%grid%planes(domain%front%crack)%contact) opening = opening - min(dot_product(opening, across), 0.0_dp)*across
      end function parted_at
   end subroutine closure_rates

   !> Sum nodal values of the material on both sides in the plane around a front.
   pure subroutine sum_sides(front, problem, far, sides)
      type(front_t), intent(in) :: front
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: far                !! from the front [m]
      type(sides_t), intent(out) :: sides
      type(front_place_t) :: place
      real(dp), dimension(problem%grid%n_functions, ndim) :: gradient
      real(dp) :: xi(ndim), shape(problem%grid%n_functions), stress(ndim, ndim)
      integer :: nodes(problem%grid%n_functions), n, i, j, side
      associate (grid => problem%grid, p => problem%particles, blocks => problem%blocks)
         allocate (sides%is_near(grid%n_points), source=.false.)
         allocate (sides%force(ndim, 2, grid%n_points), sides%mass(2, grid%n_points), sides%area(2, grid%n_points), source=0.0_dp)
         do i = 1, grid%n_points
            if (.not. is_in_plane(front, problem, grid%node_position(:, i))) cycle
            place = locate(front, grid%node_position(:, i), far)
            sides%is_near(i) = place%node > 0
         end do
         do n = 1, blocks%n_occupied
            associate (e => blocks%occupied(n))
               nodes = grid%element_nodes(:, e)
               if (.not. any(sides%is_near(nodes)) .or. .not. grid%is_in_first_field(e)) cycle
               side = merge(upper, lower, grid%element_lower(front%axis, e) + grid%element_size(e)/2 > front%plane)
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
                  shape = grid%functions_in(e, xi)
                  gradient = grid%gradients_in(e, xi)
                  stress = problem%materials(p%material(i))%mapped_stress(p%gradient_of(i), p%total_frame, p%history_of(i), &
                                                                          p%hoop_of(i))
                  do j = 1, size(nodes)
                     if (.not. sides%is_near(nodes(j))) cycle
                     sides%force(:, side, nodes(j)) = sides%force(:, side, nodes(j)) - p%volume(i)*matmul(stress, gradient(j, :))
                     sides%mass(side, nodes(j)) = sides%mass(side, nodes(j)) + p%mass(i)*shape(j)
                  end do
               end do
               do j = 1, size(nodes)
                  if (sides%is_near(nodes(j))) sides%area(side, nodes(j)) = sides%area(side, nodes(j)) + grid%element_size(e)**2/4
               end do
            end associate
         end do
         call grid%dofs%condense(grid%dofs%every_node(), 2*ndim, sides%force)
         call grid%dofs%condense(grid%dofs%every_node(), 2, sides%mass)
         call grid%dofs%condense(grid%dofs%every_node(), 2, sides%area)
         do i = 1, problem%interfaces%n          ! part of these forces held by points
            associate (point => problem%interfaces%list(i), jump => problem%interfaces%list(i)%jump)
               if (.not. (pulls(point) .and. is_in_plane(front, problem, point%middle))) cycle
               do j = 1, size(jump%node)
                  if (jump%node(j) == 0) exit
                  side = merge(upper, lower, j <= point%n_left)
                  sides%force(:, side, jump%node(j)) = sides%force(:, side, jump%node(j)) - jump%share(j)*force_of(point)
               end do
            end associate
         end do
      end associate
   end subroutine sum_sides

   !> Whether a place is in the plane of a front.
   pure logical function is_in_plane(front, problem, x) result(is)
      type(front_t), intent(in) :: front
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: x(ndim)            !! [m]
      is = abs(x(front%axis) - front%plane) < in_plane*problem%grid%finest_cell
   end function is_in_plane
end module hampm_front_closure
