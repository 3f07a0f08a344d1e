!> Initial forces of bonded points where cells are cut through stressed material, so that the cut changes nothing at that moment:
!> the accelerations of the nodes of both faces do not separate them,
!>
!>    C M**-1 C' x = C M**-1 S f,
!>
!> with C the weights of the nodes in the openings, M their lumped masses, f the forces on them, S the held part of these, and x the
!> forces of the points beyond the mean traction of the material. S is the length of a node's function along the points, over its
!> length along a side of a cell. Least squares of x over the lengths of the points, damped for points much shorter than a cell.
module hampm_bonded_forces
   use hampm_kinds, only: dp, ndim
   use hampm_crack_lines, only: both_faces
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_jumps, only: faces, faces_at, nearest_carrier
   use hampm_interface_points, only: interfaces_t, add_interface_forces, is_half
   use hampm_jumps, only: give_nodes, jump_of
   use hampm_lapack, only: dposv
   use hampm_matter, only: matter_t
   use hampm_patch, only: patch_t, patch_around, internal_force, patch_mass
   implicit none
   private
   public :: traction_at, balance_bonded_points

contains

   !> Traction in the material on both sides of a line, on its right side [Pa], by the mean stress of the particles of the leaf.
   !> On a symmetry plane the mean with the mirror image has no part along it.
   pure function traction_at(m, x, normal, face) result(traction)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: x(ndim)            !! on the line [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      integer, intent(in) :: face                !! which faces have material
      real(dp) :: traction(ndim)
      integer :: e(faces), side, i
      real(dp) :: volume
      traction = 0
      volume = 0
      e = faces_at(m, x, normal, face)
      do side = 1, faces
         if (e(side) == 0) cycle
         associate (carrier => nearest_carrier(m, e(side), x))
            do i = m%blocks%first_in(carrier), m%blocks%last_in(carrier), m%blocks%stride_in(carrier)
               volume = volume + m%particles%volume(i)
               traction = traction + m%particles%volume(i) &
                     *matmul(m%materials(m%particles%material(i))%first_piola_stress(m%particles%gradient_of(i), &
                                                                                     m%particles%history_of(i), &
                                                                                     m%particles%hoop_of(i)), normal)
            end do
         end associate
      end do
      if (volume > 0) traction = traction/volume
      if (face /= both_faces) traction = dot_product(traction, normal)*normal
   end function traction_at

   !> Let new bonded points hold their faces together as the uncut cells did.
   pure subroutine balance_bonded_points(interfaces, begins, m)
      type(interfaces_t), intent(inout) :: interfaces
      logical, intent(in) :: begins(:)
      type(matter_t), intent(in) :: m
      real(dp), parameter :: firm = 0.005_dp     ! relative damping of least squares: small except for short layers
      real(dp), allocatable :: mass(:), held(:)
      real(dp) :: damping
      real(dp), allocatable :: force(:, :), inverse(:, :), moved(:, :) ! moved: by a unit force of a bonded point [1/kg]
      real(dp) :: matrix(count(begins), count(begins)), x(count(begins), ndim), change(ndim)
      integer, allocatable :: new(:)
      integer :: i, j, info
      allocate (force(ndim, m%grid%n_nodes), inverse(ndim, m%grid%n_nodes), moved(ndim, m%grid%n_nodes))
      allocate (mass(m%grid%n_nodes), held(m%grid%n_nodes))
      call load_nodes(interfaces, m, mass, force)
      new = pack([(i, i=1, interfaces%n)], begins)
      held = 0
      do i = 1, size(new)
         associate (point => interfaces%list(new(i)))
            do j = 1, count(point%jump%node > 0)      ! its function along them, over that on a side of a cell
               held(point%jump%node(j)) = held(point%jump%node(j)) + abs(point%jump%share(j))*point%length/(point%cell/2)
            end do
         end associate
      end do
      inverse = spread(merge(1/max(mass, tiny(mass)), 0.0_dp, mass > 0), 1, ndim)
      do i = 1, size(new)                        ! nodes of a symmetry plane that is not cut there do not move
         associate (point => interfaces%list(new(i)))
            if (.not. is_half(point)) cycle
            do j = 1, count(point%jump%node > 0)
               if (.not. any(m%grid%cut_cells%freed_at(m%grid%node_position(:, point%jump%node(j))))) &
                  inverse(:, point%jump%node(j)) = 0
            end do
         end associate
      end do
      force = inverse*spread(min(1.0_dp, held), 1, ndim)*force
      damping = 0
      do i = 1, size(new)
         associate (point => interfaces%list(new(i)), n => count(interfaces%list(new(i))%jump%node > 0))
            damping = max(damping, firm*point%cell*sum(point%jump%share(:n)**2*inverse(1, point%jump%node(:n))))
            x(i, :) = sqrt(point%length)*jump_of(point%jump, force)
            moved = 0
            call give_nodes(point%jump, spread(1.0_dp, 1, ndim), moved, inverse)
            do j = 1, size(new)
               change = jump_of(interfaces%list(new(j))%jump, moved)
               matrix(i, j) = sqrt(point%length*interfaces%list(new(j))%length)*change(1)
            end do
         end associate
      end do
      do i = 1, size(new)
         matrix(i, i) = matrix(i, i) + damping
      end do
      call dposv('L', size(new), ndim, matrix, size(new), x, size(new), info)
      if (info /= 0) return                      ! NaN: reported elsewhere
      do i = 1, size(new)
         associate (point => interfaces%list(new(i)))
            if (is_half(point)) x(i, :) = dot_product(x(i, :), point%normal)*point%normal
            point%initial_force = point%initial_force + sqrt(point%length)*x(i, :)
         end associate
      end do
   end subroutine balance_bonded_points

   !> Lumped masses of the nodes of interface points, and the forces on them of the particles (hanging nodes included) and of the
   !> points; masses of other nodes are 0.
   pure subroutine load_nodes(interfaces, m, mass, force)
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), intent(out) :: mass(:)           !! [kg]
      real(dp), intent(out) :: force(:, :)       !! [N], (ndim, nodes)
      logical :: is_wanted(size(mass))
      type(patch_t) :: patch
      real(dp) :: weight(1, most_nodes_of_leaf)
      integer :: node, n, j, k, master(most_nodes_of_leaf)
      is_wanted = .false.
      do k = 1, interfaces%n
         is_wanted(pack(interfaces%list(k)%jump%node, interfaces%list(k)%jump%node > 0)) = .true.
      end do
      mass = 0
      force = 0
      do node = 1, m%grid%n_points
         call m%grid%dofs%masters_of([node], n, master, weight)
         if (.not. any(is_wanted(master(:n)))) cycle
         call patch_around(m%grid, m%particles, m%blocks, node, patch)
         do j = 1, n
            mass(master(j)) = mass(master(j)) + weight(1, j)*patch_mass(patch, m%particles)
            force(:, master(j)) = force(:, master(j)) + weight(1, j)*internal_force(patch, m%particles, m%materials)
         end do
      end do
      ! Particles on an edge of a cell do not load the nodes at the opposite one: avoid division by next to nothing
      where (is_wanted) mass = max(mass, epsilon(mass)*maxval(mass), tiny(mass))
      call add_interface_forces(interfaces, 1, force)
   end subroutine load_nodes
end module hampm_bonded_forces
