!> How far the faces of a crack are apart at a place: the displacement of the upper face less that of the lower one.
!>
!> Where nodes are on the faces, as at a tip on a node and beside a front of a plane, each has the displacement that fits the
!> particles around it best (`hampm_patch`). A crack that cuts cells has no such nodes: particles on both sides tell it
!> (`hampm_face_jumps`), for pressed faces the overlap of interface points. On a symmetry plane the mirror image is the other face.
module hampm_openings
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t, frame_along, upper, lower
   use hampm_crack_tip_field, only: modes
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_estimated_errors, only: arrival_t, pace_t, slot_of
   use hampm_face_jumps, only: faces, faces_at, place_of_faces_t, place_between
   use hampm_front_integral, only: front_domain_t
   use hampm_grid, only: grid_t
   use hampm_nodal_fields, only: v_next
   use hampm_face_slopes, only: extend_opening
   use hampm_particles, only: particles_t
   use hampm_patch, only: patch_t, patch_of_face, fitted_displacement
   use hampm_plane_points, only: elements_beside
   use hampm_problem, only: problem_t
   use hampm_tensors, only: norm, identity, quarter_turn
   implicit none
   private
   public :: opening_at, in_modes, look_for_arrival

   interface opening_at
      module procedure at_nodes, at_place, beside_front
   end interface opening_at

contains

   !> Opening and sliding of a separation of the faces in a frame.
   pure function in_modes(apart, axis, is_half) result(opening)
      real(dp), intent(in) :: apart(ndim)        !! upper less lower face, of a missing one 0 [m]
      real(dp), intent(in) :: axis(ndim, ndim)   !! out of the crack, and from the lower to the upper face
      logical, intent(in) :: is_half             !! whether the other face is a mirror image
      real(dp) :: opening(modes)
      opening = matmul(apart, axis(:, [2, 1]))
      if (is_half) opening = [2*opening(1), 0.0_dp]
   end function in_modes

   !> At nodes of the faces behind a tip, as opening and sliding [m].
   pure function at_nodes(tip, face, problem, p) result(opening)
      type(crack_tip_t), intent(in) :: tip
      integer, intent(in) :: face(2)             !! upper and lower one, 0 for none
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      real(dp) :: opening(modes), apart(ndim)
      apart = 0
      if (face(upper) > 0) apart = displacement_of(problem, p, face(upper))
      if (face(lower) > 0) apart = apart - displacement_of(problem, p, face(lower))
      opening = in_modes(apart, tip%axis, tip%is_half())
   end function at_nodes

   !> Displacement of a node of the faces [m].
   pure function displacement_of(problem, p, node) result(u)
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      integer, intent(in) :: node
      real(dp) :: u(ndim)
      type(patch_t) :: patch
      call patch_of_face(problem%grid, p, problem%blocks, node, patch)
      u = fitted_displacement(patch, p)
   end function displacement_of

   !> At the point of a crack of the plane next to a place, as opening and sliding; 0 without material on both sides [m]. Where
   !> cells meet, those on one side of it are used, or the mean of both, so that mirror images open alike. Where none is cut, the
   !> next cut one within half a cell.
   pure function at_place(tip, x, toward, problem, p, axes) result(opening)
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(in) :: x(ndim)            !! on the line of a crack, or near it, in the grid [m]
      real(dp), intent(in) :: toward(ndim)       !! unit vector along the crack to the side whose cells are sampled, 0: both
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      real(dp), intent(in), optional :: axes(ndim, ndim) !! frame of the opening, else that of the tip in the grid
      real(dp) :: opening(modes)
      real(dp), parameter :: beside = 1e-2_dp    ! cells; well above the sampling distance beside the line (`faces_at`),
                                                 ! as a crack at 45 degrees through an edge of cells needs
      real(dp) :: point(ndim), normal(ndim), along(ndim), axis(ndim, ndim), apart(ndim), at_points(ndim), across
      logical :: may_touch
      real(dp), parameter :: rounding = 1e-9_dp  ! part of an opening: faces with the same motion have none
      integer, parameter :: steps = 8            ! sixteenths of a cell: a sliver without a sample (`hampm_cut_cells`) is uncut
      type(place_of_faces_t) :: place
      integer :: elements(faces), side, n, k
      opening = 0
      call problem%grid%cut_cells%find_nearest(x, point, normal, tip%crack) ! at its end another one may be as near
      call halve_kink(problem%grid, tip%crack, point, tip%nodes%spacing, normal)
      along = quarter_turn(-normal)
      if (dot_product(along, toward) < 0) along = -along
      axis = frame_along(tip%direction)
      if (present(axes)) axis = axes
      n = 0
      do side = 1, -1, -2
         do k = 0, steps
            elements = faces_at(problem%matter_t, point + side*(beside + k/(2.0_dp*steps))*tip%nodes%spacing*along, normal, &
                                tip%only_face())
            if (any(elements > 0)) exit
         end do
         if (all(elements == 0)) cycle
         place = place_between(problem%matter_t, elements, point, normal)
         apart = place%jump(p)
         call extend_opening(problem%interfaces, tip%crack, point, side*along, at_points, may_touch)
         if (may_touch) then
            across = dot_product(at_points, normal)
            if (across < rounding*norm(apart)) apart = apart + (across - dot_product(apart, normal))*normal
         end if
         opening = opening + in_modes(apart, axis, tip%is_half())
         n = n + 1
         if (norm(toward) > 0) exit
      end do
      if (n > 1) opening = opening/n
      if (tip%end == 1) opening = -opening       ! its upper face is the right one, as one walks along the crack
   end function at_place

   !> At a place in the plane of a front, as a vector, sampled beyond a side of the material at it [m].
   function beside_front(domain, x, problem, u) result(opening)
      type(front_domain_t), intent(in) :: domain
      real(dp), intent(in) :: x(ndim)            !! [m]
      type(problem_t), intent(in) :: problem
      real(dp), allocatable, intent(inout) :: u(:, :) !! displacements of nodes, kept from place to place [m], (ndim, n_points)
      real(dp) :: opening(ndim), inside(ndim), weight(problem%grid%n_functions, most_nodes_of_leaf), share(most_nodes_of_leaf)
      real(dp), parameter :: within = 1e-6_dp    ! cells
      real(dp), parameter :: none = 1e-14_dp     ! share of a node
      integer :: e(faces), master(most_nodes_of_leaf), n, k, i
      opening = 0
      inside = min(max(x, domain%lower + within*domain%cell), domain%upper - within*domain%cell)
      inside(domain%front%axis) = domain%front%plane
      associate (grid => problem%grid, cut => problem%grid%planes(domain%front%crack), across => identity(:, domain%front%axis))
         if (.not. allocated(u)) allocate (u(ndim, grid%n_points), source=huge(x))
         e = elements_beside(problem%matter_t, cut, domain%only_side(), inside)
         do k = 1, faces
            if (e(k) == 0) cycle
            call grid%dofs%masters_of(grid%support_of(e(k)), n, master, weight)
            share(:n) = (3 - 2*k)*matmul(grid%functions_in(e(k), grid%local_coordinate(e(k), inside)), weight(:, :n))
            do i = 1, n
               if (abs(share(i)) < none) cycle
               associate (node => master(i))
                  if (.not. u(1, node) < huge(x)) u(:, node) = displacement_of(problem, problem%particles, node)
                  opening = opening + share(i)*u(:, node)
               end associate
            end do
         end do
         if (cut%is_symmetry) opening = 2*dot_product(opening, across)*across
      end associate
   end function beside_front

   !> After a step, look whether a wave has arrived: it strains a cell at a tip, or along a front, several times as fast as
   !> all before it. What moves there far less than the whole body about its mean is rounding, or runs ahead of waves in cells.
   pure subroutine look_for_arrival(problem, places, pace, arrival)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: places(:, :)       !! in the cells [m], (ndim, places)
      type(pace_t), intent(in) :: pace
      type(arrival_t), intent(inout) :: arrival
      real(dp), parameter :: several = 4, far_less = 1e-6_dp
      real(dp) :: rate                           ! [m/s]
      integer :: k
      arrival%last_look = slot_of(problem%state%time, pace)
      rate = 0
      do k = 1, size(places, 2)
         rate = max(rate, velocity_range_at(problem, places(:, k)))
      end do
      if (.not. rate > several*arrival%rate) return
      if (.not. rate > far_less*spread_of_velocities(problem)) return
      arrival%rate = rate
      arrival%slot = arrival%last_look
   end subroutine look_for_arrival

   !> Root of the mean square of velocities of nodes about that of all material [m/s].
   pure real(dp) function spread_of_velocities(problem) result(spread)
      type(problem_t), intent(in) :: problem
      real(dp) :: total                          ! mass [kg]
      integer :: d
      associate (m => abs(problem%fields%mass_matrix%lumped), v => problem%fields%velocity(:, :, v_next))
         total = sum(m)
         spread = 0
         do d = 1, ndim
            spread = spread + sum(m*(v(d, :) - sum(m*v(d, :))/total)**2)/total
         end do
      end associate
      spread = sqrt(spread)
   end function spread_of_velocities

   !> Largest range of a component of the velocity over the nodes of the element at a place, 0 outside [m/s].
   pure real(dp) function velocity_range_at(problem, x) result(range)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: x(ndim)            !! [m]
      range = 0
      associate (e => problem%grid%element_at(x))
         if (e == 0) return
         associate (v => problem%fields%velocity(:, problem%grid%support_of(e), v_next))
            range = maxval(maxval(v, dim=2) - minval(v, dim=2))
         end associate
      end associate
   end function velocity_range_at

   !> At a kink of a line, average the normals of both parts: the order of the parts must not matter.
   pure subroutine halve_kink(grid, line, point, cell, normal)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: line
      real(dp), intent(in) :: point(ndim)        !! on the line [m]
      real(dp), intent(in) :: cell               !! [m]
      real(dp), intent(inout) :: normal(ndim)    !! unit vector
      real(dp), parameter :: beside = 1e-3_dp    ! cells
      real(dp) :: nearest(ndim), of_part(ndim), mean(ndim)
      integer :: side
      mean = 0
      do side = -1, 1, 2
         call grid%cut_cells%find_nearest(point + side*beside*cell*quarter_turn(-normal), nearest, of_part, &
                                          line)
         mean = mean + sign(1.0_dp, dot_product(of_part, normal))*of_part
      end do
      if (norm(mean) > 0) normal = mean/norm(mean)
   end subroutine halve_kink
end module hampm_openings
