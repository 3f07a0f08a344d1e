!> The mean force over a coarse step of local time stepping by leapfrog steps: large cells take long steps beside small ones.
!>
!> A coarse step T of s'' = B f(s), f linear in the displacements s, B = D**-1 M D**-1 (`hampm_local_leapfrog`), takes the second
!> difference of s from a motion that starts from rest at s(t), with constant forces of cells that need no shorter steps (Diaz &
!> Grote 2009; 2015 by levels). The acceleration of level g at a displacement d, with the force c of coarser cells, is
!>
!>    a_g(d, c) = (a_(g-1)(d, c_g) + a_(g-1)(d + h a_(g-1)(d, c_g), c_g))/2,   c_g = c + f_g(d),   h = theta (2**(g-1) dt)**2/2,
!>    a_0(d, c) = B (c + f_0(d)).
!>
!> Forces of cells of group g are evaluated each 2**g finest steps. The acceleration is Q f with a symmetric Q: energy stays bounded
!> while no eigenvalue of T**2 Q df/ds is below -4, which theta, a little above 1, ensures (Grote, Michel & Sauter 2021;
!> docs/explanation/local_time_steps.md). All cells and nodes with a turn (`hampm_fine_region`) are the first ones.
module hampm_mean_force
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: cell_blocks_t, lanes
   use hampm_fine_region, only: fine_region_t
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_material, only: material_t
   use hampm_particle_pass, only: blocks_per_task
   use hampm_element_kernels, only: n_masses, n_moments, apply_mass, isotropic_stress, anisotropic_stress, add_divergence
   use hampm_particle_kernels, only: take_corners, n_across
   use hampm_vectors, only: add_scaled
   implicit none
   private
   public :: mean_force_t, make_room, add_mean_change, theta

   integer, parameter :: stride = lanes*corners  !! of the data of cells, from one component to the next

   real(dp), parameter :: least_theta = 1.05_dp, theta_by_level = 0.05_dp
   integer, parameter :: worth_threads = 2*nodes_per_chunk !! points or blocks that are shared between threads

   !> Displacements and sums within a coarse step, by points of the region and, in its blocks of cells, at corners.
   type :: mean_force_t
      type(fine_region_t) :: region
      real(dp), allocatable, private :: displacement(:, :)  !! [m], (ndim, points)
      real(dp), allocatable, private :: first(:, :)         !! acceleration without displacement [m/s2], (ndim, nodes)
      real(dp), allocatable, private :: change(:, :)        !! sums of the force or momentum of the cells around [N], (ndim, points)
      real(dp), allocatable, private :: kick(:, :)          !! change of D**-1 f [m/s2], (ndim, points)
      real(dp), allocatable, private :: force_sum(:, :)     !! of the changes of the force in all finest steps [N], (ndim, nodes)
      real(dp), allocatable, private :: acceleration_sum(:, :) !! of the changes of the acceleration [m/s2], (ndim, nodes)
      integer, allocatable, private :: start(:)             !! start of the data of a turn in the next two, (0:largest)
      real(dp), allocatable, private :: displacement_then(:, :) !! kept at the last turns, (ndim, ..)
      real(dp), allocatable, private :: sum_then(:, :)
      real(dp), allocatable, private :: force(:, :, :, :)   !! change [N], (lanes, corners, ndim, 0:blocks)
      real(dp), allocatable, private :: momentum(:, :, :, :) !! M times `kick` [N], (lanes, corners, ndim, 0:blocks)
   end type mean_force_t

contains

   !> Factor of the steps in the first half of an interval of 2**(turn + 1) finest steps.
   pure real(dp) function theta(turn, largest)
      integer, intent(in) :: turn, largest
      theta = least_theta + (largest - 1 - turn)*theta_by_level
   end function theta

   !> Allocate the sums of a region.
   subroutine make_room(region, mean)
      type(fine_region_t), intent(in) :: region
      type(mean_force_t), intent(out) :: mean
      integer :: t
      mean%region = region
      associate (n => size(region%nodes%point), all => region%outside, forced => region%nodes%forced)
         allocate (mean%displacement(ndim, all), mean%change(ndim, all), mean%kick(ndim, all), source=0.0_dp)
         allocate (mean%first(ndim, n), mean%force_sum(ndim, n), mean%acceleration_sum(ndim, n), source=0.0_dp)
         allocate (mean%start(0:region%largest), source=[1, (1 + sum(forced(:t - 1)), t=1, region%largest)])
         allocate (mean%displacement_then(ndim, sum(forced) + forced(region%largest - 1)), &
                   mean%sum_then(ndim, sum(forced) + forced(region%largest - 1)), source=0.0_dp)
      end associate
      associate (n => size(region%in_row))
         allocate (mean%force(lanes, corners, ndim, 0:n), mean%momentum(lanes, corners, ndim, 0:n), source=0.0_dp)
      end associate
   end subroutine make_room

   !> Add to the nodal forces the difference of their mean over a coarse step of 2**largest steps `dt`.
   subroutine add_mean_change(mean, materials, blocks, dt, acceleration, force)
      type(mean_force_t), intent(inout) :: mean
      type(material_t), intent(in) :: materials(:)
      type(cell_blocks_t), intent(in) :: blocks
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: acceleration(:, :) !! D**-1 f, also at hanging nodes [m/s2], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! f [N], (ndim, n_points)
      integer :: s
      call find_first(mean, blocks, acceleration)
      mean%force = 0
      mean%momentum = 0
      mean%kick = 0
      mean%force_sum = 0
      mean%acceleration_sum = 0
      do s = 1, 2**mean%region%largest - 1
         associate (turn => trailz(s))
            call displace(mean, dt, s, turn)
            call find_forces(mean, materials, blocks, turn)
            call find_accelerations(mean, turn)
         end associate
      end do
      associate (nodes => mean%region%nodes%point)
         force(:, nodes) = force(:, nodes) + scale(mean%force_sum, -mean%region%largest)
      end associate
   end subroutine add_mean_change

   !> The accelerations B f where no node is displaced.
   subroutine find_first(mean, blocks, acceleration)
      type(mean_force_t), intent(inout) :: mean
      type(cell_blocks_t), intent(in) :: blocks
      real(dp), intent(in) :: acceleration(ndim, *) !! D**-1 f [m/s2]
      integer :: b
      associate (region => mean%region, last => mean%region%largest - 1)
         !$omp parallel do schedule(static) if (region%kicked(last) > worth_threads)
         do b = 1, region%kicked(last), blocks_per_task
            call kick_cells(b, min(b + blocks_per_task - 1, region%kicked(last)), region%masses, blocks%nodes, blocks%in_row, &
                            acceleration, mean%momentum)
         end do
         call sum_at_points(mean, region%nodes%moved(last), region%hanging%moved(last), mean%momentum)
         mean%first = region%inverse_mass*mean%change(:, :size(region%nodes%point))
      end associate
   end subroutine find_first

   !> Displace the nodes of the cells whose turn it is: by the mean acceleration in the first half of the interval of which the
   !> second half begins, from where its first half began. That was at the last turn of a larger group.
   subroutine displace(mean, dt, s, turn)
      type(mean_force_t), intent(inout) :: mean
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: s                   !! finest steps since the beginning of the coarse one
      integer, intent(in) :: turn                !! the largest group whose turn it is
      integer :: before, i, n
      before = mean%region%largest
      if (ibclr(s, turn) > 0) before = trailz(ibclr(s, turn))
      associate (region => mean%region, forced => mean%region%nodes%forced(turn))
         !$omp parallel do schedule(static) private(n) if (forced > worth_threads)
         do i = 1, forced, nodes_per_chunk
            n = min(nodes_per_chunk, forced - i + 1)
            call place_nodes(ndim*n, 0.5_dp*theta(turn, mean%region%largest)*(2**turn*dt)**2, 0.5_dp**turn, mean%first(1, i), &
                             mean%sum_then(1, mean%start(before) + i - 1), mean%acceleration_sum(1, i), &
                             mean%displacement_then(1, mean%start(before) + i - 1), mean%displacement(1, i), &
                             mean%sum_then(1, mean%start(turn) + i - 1), mean%displacement_then(1, mean%start(turn) + i - 1))
         end do
         region%list%n_points = region%list%n_nodes + region%hanging%forced(turn)
         call region%dofs%distribute(region%list, ndim, mean%displacement)
      end associate
   end subroutine displace

   !> Find the changes of the forces of the cells with a turn, and the kicks D**-1 f of their nodes.
   subroutine find_forces(mean, materials, blocks, turn)
      type(mean_force_t), intent(inout) :: mean
      type(material_t), intent(in) :: materials(:)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: turn
      integer :: b, g, first
      associate (region => mean%region, n_blocks => mean%region%forced(turn), n => mean%region%nodes%forced(turn))
         !$omp parallel do schedule(static) if (n_blocks > worth_threads)
         do b = 1, n_blocks, blocks_per_task
            call force_cells(b, min(b + blocks_per_task - 1, n_blocks), region%first_part, region%material, materials, &
                             region%moments, blocks%inverse_size, region%corner, region%in_row, mean%displacement, mean%force)
         end do
         call sum_at_points(mean, n, region%hanging%forced(turn), mean%force)
         first = 1
         do g = 0, turn
            if (region%nodes%forced(g) < first) cycle
            call add_scaled(ndim*(region%nodes%forced(g) - first + 1), 2.0_dp**g, mean%change(1, first), mean%force_sum(1, first))
            first = region%nodes%forced(g) + 1
         end do
         mean%kick(:, :n) = region%inverse_mass(:, :n)*mean%change(:, :n)
         call region%dofs%distribute(region%list, ndim, mean%kick)
      end associate
   end subroutine find_forces

   !> Find the changes of the accelerations B f.
   subroutine find_accelerations(mean, turn)
      type(mean_force_t), intent(inout) :: mean
      integer, intent(in) :: turn
      integer :: b, g, first
      associate (region => mean%region, n_blocks => mean%region%kicked(turn))
         !$omp parallel do schedule(static) if (n_blocks > worth_threads)
         do b = 1, n_blocks, blocks_per_task
            call kick_cells(b, min(b + blocks_per_task - 1, n_blocks), region%masses, region%corner, region%in_row, mean%kick, &
                            mean%momentum)
         end do
         call sum_at_points(mean, region%nodes%moved(turn), region%hanging%moved(turn), mean%momentum)
         first = 1
         do g = 0, turn
            if (region%nodes%moved(g) < first) cycle
            call add_product(ndim*(region%nodes%moved(g) - first + 1), 2.0_dp**g, region%inverse_mass(1, first), &
                             mean%change(1, first), mean%acceleration_sum(1, first))
            first = region%nodes%moved(g) + 1
         end do
      end associate
   end subroutine find_accelerations

   !> Sum the contributions of the cells at the first nodes and hanging nodes, and condense the sums.
   subroutine sum_at_points(mean, n_nodes, n_hanging, held)
      type(mean_force_t), intent(inout) :: mean
      integer, intent(in) :: n_nodes, n_hanging
      real(dp), intent(in) :: held(*)            !! vectors at the corners of blocks
      integer :: i, k
      associate (region => mean%region, before => size(mean%region%nodes%point))
         !$omp parallel do schedule(static) if (n_nodes > worth_threads)
         do i = 1, n_nodes, nodes_per_chunk
            call gather(i, min(i + nodes_per_chunk - 1, n_nodes), region%place, held, mean%change)
         end do
         call gather(before + 1, before + n_hanging, region%place, held, mean%change)
         do k = 1, size(region%high_valence, 1)
            associate (point => region%high_valence(k, 1))
               if (point <= n_nodes .or. (point > before .and. point <= before + n_hanging)) &
                  mean%change(:, point) = mean%change(:, point) + held(region%high_valence(k, 2) + [0, lanes*corners])
            end associate
         end do
         region%list%n_points = before + n_hanging
         call region%dofs%condense(region%list, ndim, mean%change)
      end associate
   end subroutine sum_at_points

   !> Displacement of nodes: from the start of an interval, by a constant acceleration in its first half: the mean of the
   !> accelerations there, a0 + (sum now - sum then)/steps. Both are kept for the intervals that begin now.
   pure subroutine place_nodes(n, factor, share, a0, sum_then, sum_now, d_then, d, kept_sum, kept_d)
      integer, intent(in) :: n                          !! components of the nodes
      real(dp), intent(in) :: factor                    !! displacement over acceleration [s2]
      real(dp), intent(in) :: share                     !! 1/steps
      real(dp), intent(in) :: a0(n)                     !! where no node is displaced [m/s2]
      real(dp), intent(in) :: sum_then(n), sum_now(n)   !! of its changes, over the finest steps [m/s2]
      real(dp), intent(in) :: d_then(n)                 !! [m]
      real(dp), intent(out) :: d(n)                     !! [m]
      real(dp), intent(out) :: kept_sum(n), kept_d(n)
      integer :: k
      !$omp simd
      do k = 1, n
         d(k) = d_then(k) + factor*(a0(k) + share*(sum_now(k) - sum_then(k)))
         kept_d(k) = d(k)
         kept_sum(k) = sum_now(k)
      end do
   end subroutine place_nodes

   !> The change of the forces of cells whose corners are displaced. A block has parts, of one material each.
   pure subroutine force_cells(first, last, first_part, material, materials, moments, inverse_size, nodes, in_row, d, force)
      integer, intent(in) :: first, last                !! blocks
      integer, intent(in) :: first_part(*)              !! by block
      integer, intent(in) :: material(*)                !! by part
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: moments(lanes, n_moments, *) !! by part [m3]
      real(dp), intent(in) :: inverse_size(lanes, *)    !! by block [1/m]
      integer, intent(in) :: nodes(corners, lanes, *)   !! by block
      logical, intent(in) :: in_row(*)                  !! by block
      real(dp), intent(in) :: d(ndim, *)                !! displacement, by point [m]
      real(dp), intent(inout) :: force(lanes, corners, ndim, 0:*) !! by block [N]
      real(dp) :: a(lanes, corners, ndim), integrals(lanes, ndim*ndim, n_across)
      integer :: b, k
      do b = first, last
         force(:, :, :, b) = 0
         call take_corners(1, inverse_size(1, b), d, nodes(1, 1, b), in_row(b), a)
         do k = first_part(b), first_part(b + 1) - 1
            associate (law => materials(material(k)))
               if (law%isotropic) then
                  call isotropic_stress(law%lambda, law%mu, a, moments(1, 1, k), integrals)
               else
                  call anisotropic_stress(law%stiffness, a, moments(1, 1, k), integrals)
               end if
               call add_divergence(inverse_size(1, b), integrals, force(1, 1, 1, b))
            end associate
         end do
      end do
   end subroutine force_cells

   !> Contributions of kicked cells to the momenta at their corners per time: M a.
   pure subroutine kick_cells(first, last, masses, nodes, in_row, acceleration, momentum)
      integer, intent(in) :: first, last                !! blocks
      real(dp), intent(in) :: masses(lanes, n_masses, *) !! by block [kg]
      integer, intent(in) :: nodes(corners, lanes, *)   !! by block
      logical, intent(in) :: in_row(*)                  !! by block
      real(dp), intent(in) :: acceleration(ndim, *)     !! by point [m/s2]
      real(dp), intent(inout) :: momentum(lanes, corners, ndim, 0:*) !! by block [N]
      real(dp) :: a(lanes, corners, ndim)
      real(dp), parameter :: factor(lanes) = 1
      integer :: b
      do b = first, last
         momentum(:, :, :, b) = 0
         call take_corners(1, factor, acceleration, nodes(1, 1, b), in_row(b), a)
         call apply_mass(a, masses(1, 1, b), momentum(1, 1, 1, b))
      end do
   end subroutine kick_cells

   !> Sum the contributions of the cells at some points, always in the order of the cells.
   pure subroutine gather(first, last, place, held, total)
      integer, intent(in) :: first, last                !! points
      integer, intent(in) :: place(corners, *)          !! where it stands, by point
      real(dp), intent(in) :: held(*)
      real(dp), intent(inout) :: total(ndim, *)         !! by point
      integer :: i
      !GCC$ novector
      do i = first, last
         associate (k1 => place(1, i), k2 => place(2, i), k3 => place(3, i), k4 => place(4, i))
            total(1, i) = ((held(k1) + held(k2)) + held(k3)) + held(k4)
            total(2, i) = ((held(k1 + stride) + held(k2 + stride)) + held(k3 + stride)) + held(k4 + stride)
         end associate
      end do
   end subroutine gather

   !> total <- total + factor a b.
   pure subroutine add_product(n, factor, a, b, total)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, a(n), b(n)
      real(dp), intent(inout) :: total(n)
      integer :: k
      !$omp simd
      do k = 1, n
         total(k) = total(k) + factor*(a(k)*b(k))
      end do
   end subroutine add_product
end module hampm_mean_force
