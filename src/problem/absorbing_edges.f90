!> Absorbing edges: dashpots with the traction t = -Z v, Z = (rho A)**(1/2), A = n.C.n the acoustic tensor of the undeformed
!> material normal to the edge (isotropic: rho c_p v_n across and rho c_s v_t along it). A plane wave at right angles leaves the
!> body without reflection, others with little (docs/explanation/absorbing_edges.md).
!>
!> An edge is three loads without force (`hampm_loads`), a side of a solid six; the parts of their points are the components xx, yy,
!> xy of the area times Z, so that points follow particles, cells and checkpoints like those of other loads. With the lumped matrix
!> D = sum of N_i Z A, two components at each node, explicit steps use the mean velocity of both ends,
!>
!>    (m + dt D/2) v' = m (v + dt f/m) - dt D v/2,
!>
!> which takes dt w.D w with w = (v + v')/2 from the energy, without effect on the limit of the time step. Source: Lysmer &
!> Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.
module hampm_absorbing_edges
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_loads, only: load_t, place_loads
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: in_plane, identity, inverse_transpose, n_voigt, voigt, trace
   implicit none
   private
   public :: absorbing_edges_t, components, impedance, nodes_of_dashpots

   real(dp), parameter :: rounding = 1e-9_dp     !! rounding of a node's part of a point, or below 0 outside its cells [-]

   integer, parameter :: components = n_voigt    !! of a symmetric tensor, in the order of `voigt`

   !> The dashpots at the nodes of a grid.
   type :: absorbing_edges_t
      integer :: n = 0                           !! number of nodes
      integer, allocatable :: node(:)            !! (n)
      real(dp), allocatable :: d(:, :, :)        !! D [kg/s], (ndim, ndim, n)
      integer, private :: layout = -1            !! of the cells for which they were found
   contains
      procedure :: renew
      procedure :: brake
      procedure :: resist
   end type absorbing_edges_t

contains

   !> Z of an edge with a normal [kg/(m2 s)].
   pure function impedance(material, normal) result(z)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: normal(ndim)       !! unit vector
      real(dp) :: z(components)
      real(dp) :: a(ndim, ndim), root, dh(ndim, ndim), state(material%columns), x(ndim, ndim)
      integer, parameter :: passes = 20          ! each of the first halves the error, the last squares it
      integer :: k
      state = 0
      do k = 1, ndim
         dh = spread(identity(:, k), 2, ndim)*spread(normal, 1, ndim)
         a(:, k) = material%density*matmul(material%first_piola_change(0*dh, dh, state, 0.0_dp, 0.0_dp), normal)
      end do
      if (ndim > 2) then
         x = sqrt(trace(a))*identity
         do k = 1, passes                        ! Newton; all of them have the axes of A
            x = (x + matmul(a, inverse_transpose(x)))/2
         end do
         do k = 1, ndim
            z(voigt(:, k)) = (x(:, k) + x(k, :))/2
         end do
         return
      end if
      root = sqrt(a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1))
      a = (a + root*identity)/sqrt(a(1, 1) + a(2, 2) + 2*root) ! the square root of a tensor of two dimensions
      z(:3) = [a(1, 1), a(2, 2), a(1, 2)]
   end function impedance

   !> Nodes with a part of dashpots, hanging ones included.
   function nodes_of_dashpots(loads, grid, p) result(nodes)
      type(load_t), intent(inout) :: loads(:)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, allocatable :: nodes(:)
      integer :: l
      allocate (nodes(0))
      if (.not. any(loads%absorbs > 0)) return
      call place_loads(loads, grid, p)
      do l = 1, size(loads)
         if (loads(l)%absorbs > 0) nodes = [nodes, pack(loads(l)%node, loads(l)%shape > rounding)]
      end do
   end function nodes_of_dashpots

   !> Find the dashpots at the nodes, unless cells are as they were and keep their material.
   subroutine renew(self, loads, grid, p, matrix, layout)
      class(absorbing_edges_t), intent(inout) :: self
      type(load_t), intent(inout) :: loads(:)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: layout              !! of the cells
      real(dp), allocatable :: by_node(:, :)
      integer :: l, k, c, i
      if (.not. any(loads%absorbs > 0) .or. (p%total_frame .and. self%layout == layout)) return
      call place_loads(loads, grid, p)
      allocate (by_node(components, grid%n_points), source=0.0_dp)
      do l = 1, size(loads)
         associate (load => loads(l))
            if (load%absorbs == 0) cycle
            do k = 1, size(load%particle)
               do c = 1, size(load%node, 1)
                  if (.not. load%shape(c, k) > rounding) cycle
                  associate (sum => by_node(load%absorbs, load%node(c, k)))
                     sum = sum + load%fraction(k)*load%shape(c, k)
                  end associate
               end do
            end do
         end associate
      end do
      call grid%dofs%condense(matrix%all, components, by_node)
      self%node = pack([(i, i=1, grid%n_nodes)], any(abs(by_node(:, :grid%n_nodes)) > 0, dim=1))
      self%n = size(self%node)
      if (allocated(self%d)) deallocate (self%d)
      allocate (self%d(ndim, ndim, self%n))
      do k = 1, self%n
         do c = 1, ndim
            self%d(:, c, k) = by_node(voigt(:, c), self%node(k))
         end do
      end do
      self%layout = layout
   end subroutine renew

   !> Apply the dashpots of an explicit step to velocities, accelerations and forces at its end, without hanging nodes.
   subroutine brake(self, free, mass, dt, before, after, acceleration, force, taken)
      class(absorbing_edges_t), intent(in) :: self
      real(dp), intent(in) :: free(:, :)         !! 0 for fixed components, else 1, (ndim, n_points)
      real(dp), intent(in) :: mass(:)            !! lumped [kg], (n_points)
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: before(:, :)       !! velocities at the start of the step [m/s], (ndim, n_points)
      real(dp), intent(inout) :: after(:, :), acceleration(:, :), force(:, :) !! [m/s], [m/s2], [N], (ndim, n_points)
      real(dp), intent(out) :: taken             !! energy [J]
      real(dp) :: m(ndim, ndim), v(ndim), mean(ndim), determinant
      integer :: k, d
      taken = 0
      do k = 1, self%n
         associate (i => self%node(k))
            if (.not. mass(i) > 0) cycle
            m = dt*self%d(:, :, k)/2
            v = mass(i)*after(:, i) - matmul(m, before(:, i))
            do d = 1, ndim
               m(d, d) = m(d, d) + mass(i)
               if (free(d, i) > 0) cycle
               m(d, :) = 0
               m(d, d) = 1
               v(d) = after(d, i)
            end do
            if (ndim > 2) then
               v = matmul(v, inverse_transpose(m))
            else
               determinant = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
               v = in_plane(m(2, 2)*v(1) - m(1, 2)*v(2), m(1, 1)*v(2) - m(2, 1)*v(1))/determinant
            end if
            acceleration(:, i) = acceleration(:, i) + (v - after(:, i))/dt
            after(:, i) = v
            mean = (before(:, i) + v)/2
            force(:, i) = force(:, i) - matmul(self%d(:, :, k), mean)
            taken = taken + dt*dot_product(mean, matmul(self%d(:, :, k), mean))
         end associate
      end do
   end subroutine brake

   !> Take the forces of the dashpots at a velocity from others [N].
   pure subroutine resist(self, velocity, force)
      class(absorbing_edges_t), intent(in) :: self
      real(dp), intent(in) :: velocity(:, :)     !! [m/s], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k
      do k = 1, self%n
         associate (i => self%node(k))
            force(:, i) = force(:, i) - matmul(self%d(:, :, k), velocity(:, i))
         end associate
      end do
   end subroutine resist
end module hampm_absorbing_edges
