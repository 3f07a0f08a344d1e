!> The part of a grid that changes within a coarse step of local time stepping (`hampm_local_leapfrog`): its cells and nodes ordered
!> by frequency of change, so that those with a turn are the first ones, with all their data side by side.
!>
!> A finest step at which cells up to group t have their turn (`hampm_step_groups`) displaces the nodes of these, and changes
!>
!>    forces         in cells up to group t, and at their nodes: `forced`;
!>    accelerations  by B = D**-1 M D**-1 in and at the nodes of one layer of cells more, the kicked ones: `moved`.
!>
!> Nodes are ordered by both intervals. A hanging node, after all others, has the least intervals of its masters. Masters that never
!> have a turn are outside: one point that is never displaced.
module hampm_fine_region
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: cell_blocks_t, lanes, n_sums, are_in_row
   use hampm_dofs, only: dofs_t
   use hampm_element_kernels, only: n_masses, n_moments
   use hampm_element_operators, only: sum_masses, sum_moments
   use hampm_node_list, only: node_list_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: fine_region_t, find_region

   !> Points of one kind in the order of their intervals, of which there are as many as have a turn at t or before.
   type :: ordered_points_t
      integer, allocatable :: point(:)           !! numbers in the grid
      integer, allocatable :: forced(:)          !! how many have new forces at a turn, (0:largest - 1)
      integer, allocatable :: moved(:)           !! how many have new accelerations, (0:largest - 1)
   end type ordered_points_t

   !> Data that change within a coarse step. Points are numbered in its own order: nodes, hanging nodes, and the point outside.
   type :: fine_region_t
      integer :: largest = 0                     !! a coarse step is 2**largest finest ones
      type(ordered_points_t) :: nodes, hanging
      integer :: outside = 0                     !! number of the point for all that never changes
      type(node_list_t) :: list                  !! the nodes, and hanging nodes as many as are treated
      type(dofs_t) :: dofs                       !! masters of the hanging nodes; sums at the point outside are unused
      real(dp), allocatable :: inverse_mass(:, :) !! 1/D, 0 for fixed components [1/kg], (ndim, nodes)
      ! Blocks of cells are the first of `cell_blocks_t`
      integer, allocatable :: kicked(:)          !! how many are kicked at a turn, (0:largest - 1)
      integer, allocatable :: corner(:, :, :)    !! points at their corners, (corners, lanes, blocks)
      logical, allocatable :: in_row(:)          !! as `cell_blocks_t`
      real(dp), allocatable :: masses(:, :, :)   !! [kg], (lanes, n_masses, blocks)
      integer, allocatable :: forced(:)          !! how many have a turn, (0:largest - 1)
      integer, allocatable :: first_part(:)      !! their parts with one material each, (blocks + 1)
      integer, allocatable :: material(:)        !! of each part
      real(dp), allocatable :: moments(:, :, :)  !! [m3], (lanes, n_moments, parts)
      ! Contributions of the blocks: vectors at the corners, (lanes, corners, ndim, 0:blocks), of block 0 zero
      integer, allocatable :: place(:, :)        !! place of each cell around a point among them, (corners, points)
      integer, allocatable :: high_valence(:, :) !! points with more cells than that, and where the others stand; (cells, 2)
   end type fine_region_t

contains

   !> Find the region that changes in a coarse step of 2**largest finest ones.
   subroutine find_region(largest, blocks, dofs, list, free, inverse_lumped, p, region)
      integer, intent(in) :: largest             !! above 0
      type(cell_blocks_t), intent(in) :: blocks  !! with groups up to that
      type(dofs_t), intent(in) :: dofs
      class(node_list_t), intent(in) :: list     !! the nodes of cells with particles
      real(dp), intent(in) :: free(:, :)         !! 0 for fixed components of nodes, else 1
      real(dp), intent(in) :: inverse_lumped(:)  !! 1/D [1/kg]
      type(particles_t), intent(in) :: p
      type(fine_region_t), intent(out) :: region
      integer, allocatable :: number_of(:)       ! in the region, by point of the grid
      integer :: k
      region%largest = largest
      associate (groups => blocks%groups)
         region%nodes = order(list%nodes(:list%n_nodes), groups%force_interval, groups%velocity_interval, largest)
         region%hanging = order(list%nodes(list%n_nodes + 1:list%n_points), groups%force_interval, groups%velocity_interval, &
                                largest)
      end associate
      associate (n => size(region%nodes%point), h => size(region%hanging%point))
         region%outside = n + h + 1
         allocate (number_of(size(inverse_lumped)), source=region%outside)
         number_of(region%nodes%point) = [(k, k=1, n)]
         number_of(region%hanging%point) = [(k, k=n + 1, n + h)]
         region%inverse_mass = reshape([(inverse_lumped(region%nodes%point(k))*free(:, region%nodes%point(k)), k=1, n)], [ndim, n])
      end associate
      call find_masters(dofs, number_of, region)
      call find_blocks(blocks, number_of, p, region)
      call find_parts(blocks, p, region)
      call find_places(blocks, number_of, region)
   end subroutine find_region

   !> Order points by how often they have new accelerations and, if these are as often, forces. Those that have none before
   !> the coarse step ends are left out.
   pure type(ordered_points_t) function order(points, force_interval, velocity_interval, largest) result(ordered)
      integer, intent(in) :: points(:)
      integer, intent(in) :: force_interval(:), velocity_interval(:) !! by point of the grid
      integer, intent(in) :: largest
      integer :: force(size(points)), r, k
      allocate (ordered%point(0))
      allocate (ordered%forced(0:largest - 1), ordered%moved(0:largest - 1))
      force = min(force_interval(points), velocity_interval(points) + 1) ! a turn too many does no harm
      do r = 0, largest - 1
         associate (moves => velocity_interval(points) == r)
            ordered%point = [ordered%point, pack(points, moves .and. force == r), pack(points, moves .and. force > r)]
         end associate
         ordered%moved(r) = size(ordered%point)
         ordered%forced(r) = count([(force(k) <= r, k=1, size(points))])
      end do
   end function order

   !> Find the masters of the hanging nodes.
   subroutine find_masters(dofs, number_of, region)
      type(dofs_t), intent(in) :: dofs
      integer, intent(in) :: number_of(:)        !! in the region, by point of the grid
      type(fine_region_t), intent(inout) :: region
      integer :: k, j
      associate (hanging => region%hanging%point - dofs%n_nodes, first => dofs%first_master, own => region%dofs)
         own%n_nodes = size(region%nodes%point)
         own%n_hanging = size(hanging)
         region%list%n_nodes = own%n_nodes
         region%list%nodes = [(k, k=1, own%n_nodes + own%n_hanging)]
         own%first_master = [1, first(hanging + 1) - first(hanging)]
         do k = 1, own%n_hanging
            own%first_master(k + 1) = own%first_master(k) + own%first_master(k + 1)
         end do
         own%master = [((number_of(dofs%master(j)), j=first(hanging(k)), first(hanging(k) + 1) - 1), k=1, own%n_hanging)]
         own%weight = [((dofs%weight(j), j=first(hanging(k)), first(hanging(k) + 1) - 1), k=1, own%n_hanging)]
      end associate
   end subroutine find_masters

   !> Find the blocks of cells that are kicked, and their mass matrices.
   subroutine find_blocks(blocks, number_of, p, region)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: number_of(:)        !! in the region, by point of the grid
      type(particles_t), intent(in) :: p
      type(fine_region_t), intent(inout) :: region
      integer :: b, t, n
      allocate (region%kicked(0:region%largest - 1), source=0)
      do b = 1, blocks%n
         associate (cells => blocks%cells(:count(blocks%cells(:, b) > 0), b))
            do t = minval(blocks%groups%kick_interval(cells)), region%largest - 1
               region%kicked(t) = b
            end do
         end associate
      end do
      n = region%kicked(region%largest - 1)
      allocate (region%corner(corners, lanes, n), region%in_row(n), region%masses(lanes, n_masses, n))
      !$omp parallel do schedule(static)
      do b = 1, n
         region%corner(:, :, b) = reshape(number_of(reshape(blocks%nodes(:, :, b), [corners*lanes])), [corners, lanes])
         region%in_row(b) = are_in_row(region%corner(:, :, b))
         call sum_masses(p, blocks, b, region%masses(:, :, b))
      end do
   end subroutine find_blocks

   !> Find the blocks of cells that have turns, their parts that have a material each, and the moments of the volumes of these.
   subroutine find_parts(blocks, p, region)
      type(cell_blocks_t), intent(in) :: blocks
      type(particles_t), intent(in) :: p
      type(fine_region_t), intent(inout) :: region
      integer :: b, k, n, material, most
      n = count(blocks%groups%of_cell(blocks%cells(1, :blocks%n)) < region%largest)
      allocate (region%forced(0:region%largest - 1), region%first_part(n + 1))
      region%forced = [(count(blocks%groups%of_cell(blocks%cells(1, :blocks%n)) <= k), k=0, region%largest - 1)]
      most = 0
      do b = 1, n
         associate (of => p%material(blocks%first(b):blocks%last(b)))
            most = most + count([(any(of == material), material=minval(of), maxval(of))])
         end associate
      end do
      allocate (region%material(most), region%moments(lanes, n_moments, most))
      k = 0
      do b = 1, n
         region%first_part(b) = k + 1
         do material = minval(p%material(blocks%first(b):blocks%last(b))), maxval(p%material(blocks%first(b):blocks%last(b)))
            if (.not. any(p%material(blocks%first(b):blocks%last(b)) == material)) cycle
            k = k + 1
            region%material(k) = material
            call sum_moments(p, blocks, b, material, region%moments(:, :, k))
         end do
      end do
      region%first_part(n + 1) = k + 1
   end subroutine find_parts

   !> Find the places of the contributions of the cells around each point.
   subroutine find_places(blocks, number_of, region)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: number_of(:)        !! in the region, by point of the grid
      type(fine_region_t), intent(inout) :: region
      integer :: k
      logical, allocatable :: inside(:)
      allocate (region%place(corners, region%outside - 1))
      associate (points => [region%nodes%point, region%hanging%point], n_blocks => size(region%in_row))
         do k = 1, size(points)
            region%place(:, k) = place_of(blocks%slot(:, points(k)), n_blocks)
         end do
         inside = number_of(blocks%high_valence(1, :)) < region%outside
         region%high_valence = reshape([pack(number_of(blocks%high_valence(1, :)), inside), &
                                        pack(place_of(blocks%high_valence(2, :), n_blocks), inside)], [count(inside), 2])
      end associate
   end subroutine find_places

   !> Place of a slot of `cell_blocks_t` among the vectors of the first blocks; for other blocks the first, a zero.
   elemental integer function place_of(slot, n_blocks) result(place)
      integer, intent(in) :: slot, n_blocks
      associate (block => (slot - 1)/(lanes*corners*n_sums), within => mod(slot - 1, lanes*corners*n_sums))
         place = 1
         if (block <= n_blocks) place = 1 + lanes*corners*ndim*block + within
      end associate
   end function place_of
end module hampm_fine_region
