!> What holds the nodes of small pieces of quadratic cells that cracks or edges cut: a piece that has few particles leaves some motions of its
!> nine nodes free, or nearly so. Each node of such a piece is tied by an interface point to the place to which the functions of the fullest cell next to it, on the
!> same side of the crack, are continued; of several that are as full the one nearest to the particles of the piece, or each by a part of the interface point, so that mirror images are alike. Such
!> interface points do not feel any quadratic displacement. In motion they have a mass too, which no quadratic
!> velocity has any of: so the mass matrix is as well-conditioned as that of whole cells.
!>
!> Source: Burman, Ghost penalty, Comptes Rendus Mathematique 348 (2010) 1217-1220; here it is the difference of the continued polynomials
!> itself that is held, at the nodes (Preuss 2018). In the mass matrix: `hampm_mass_ties`.
module hampm_small_pieces
   use hampm_kinds, only: dp, ndim, corners
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_interface_points, only: interfaces_t, ghost, add_interface_point
   use hampm_ghost_penalty, only: fills_of_pieces
   use hampm_grid, only: grid_t
   use hampm_matter, only: matter_t
   implicit none
   private
   public :: tie_small_pieces, enough_alone

   real(dp), parameter :: enough = 0.5_dp        !! part of a cell from which on a piece needs no stiffness
   real(dp), parameter :: enough_in_motion = 0.9_dp !! and no mass
   real(dp), parameter :: enough_alone = 0.6_dp  !! with which it moves by itself, where no cell beside it is fuller
   real(dp), parameter :: firmness = 1.0_dp      !! stiffness of an interface point, over E' and the thickness
   real(dp), parameter :: heaviness = 0.1_dp     !! mass of an interface point, over that of a full cell

contains

   !> Add the interface points of all small pieces, and note whether one is alone.
   pure subroutine tie_small_pieces(interfaces, m)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp) :: fill(m%grid%n_elements), middle(ndim, m%grid%n_elements), least, most
      logical :: moves(m%grid%n_points)
      integer :: e, i, k
      integer, allocatable :: hosts(:)
      fill = fills_of_pieces(m)
      middle = 0
      moves = .false.
      interfaces%alone = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            middle(:, first) = middle(:, first) + m%particles%area_of(i)*m%particles%place_in_grid(i)/m%grid%leaf_size(first)**ndim
         end associate
      end do
      do e = 1, m%grid%n_elements, corners
         if (fill(e) > 0) middle(:, e) = middle(:, e)/fill(e)
         if (.not. fill(e) > 0) middle(:, e) = m%grid%element_lower(:, e) + m%grid%leaf_size(e)/2
      end do
      most = merge(enough_in_motion, enough, interfaces%are_moving)
      least = merge(-1.0_dp, 0.0_dp, interfaces%are_moving) ! of a piece without particles too nodes may be masters of hanging ones
      do e = 1, m%grid%n_elements, corners
         if (fill(e) > 0) moves(m%grid%support_of(e)) = .true.
      end do
      call m%grid%dofs%mark_masters(moves)
      do e = 1, m%grid%n_elements, corners
         if (.not. (fill(e) > least .and. fill(e) < most) .or. .not. m%grid%is_cut(m%grid%element_leaf(e))) cycle
         hosts = fullest_beside(m%grid, fill, middle, e)
         if (size(hosts) == 0 .and. interfaces%are_moving .and. fill(e) > 0 .and. fill(e) < enough_alone) interfaces%alone = e
         do k = 1, size(hosts)
            call tie(interfaces, m, e, hosts(k), moves, fill(e) > 0 .and. fill(e) < enough, 1/real(size(hosts), dp))
         end do
      end do
   end subroutine tie_small_pieces

   !> The fullest cell, or piece of one, that has a side in common with a piece, if it is fuller than that. Of several as full it is the one whose middle
   !> is nearest to the particles of the piece; all that are as near, where there are several.
   pure function fullest_beside(grid, fill, middle, e) result(hosts)
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: fill(:)
      real(dp), intent(in) :: middle(:, :)       !! centroid of the particles of each piece [m], (ndim, elements)
      integer, intent(in) :: e                   !! the first element of the piece
      integer, allocatable :: hosts(:)           !! their first elements
      real(dp), parameter :: rounding = 1e-9_dp  ! of what a cell holds, and of distances
      real(dp) :: held, nearest
      integer :: k, j, other
      allocate (hosts(0))
      held = 0
      nearest = 0
      associate (own => grid%support_of(e))
         do k = 1, size(own)
            associate (around => grid%dofs%elements_at(own(k)))
               do j = 1, size(around)
                  other = grid%first_of_piece(around(j))
                  if (grid%element_leaf(other) == grid%element_leaf(e) .or. fill(other) <= fill(e) .or. any(hosts == other)) cycle
                  associate (holds => fill(other)*grid%leaf_size(other), &
                             distance => norm2(grid%element_lower(:, other) + grid%leaf_size(other)/2 - middle(:, e)))
                     if (holds < held*(1 - rounding)) cycle
                     if (count_common(own, grid%support_of(other)) < 2) cycle
                     if (holds <= held*(1 + rounding) .and. distance > nearest*(1 + rounding)) cycle
                     if (holds > held*(1 + rounding) .or. distance < nearest*(1 - rounding)) hosts = [integer ::]
                     held = holds
                     nearest = distance
                  end associate
                  hosts = [hosts, other]
               end do
            end associate
         end do
      end associate
   end function fullest_beside

   !> How many nodes two cells have in common.
   pure integer function count_common(a, b)
      integer, intent(in) :: a(:), b(:)
      integer :: k
      count_common = count([(any(b == a(k)), k=1, size(a))])
   end function count_common

   !> Tie the nodes of a piece that are not those of its host.
   pure subroutine tie(interfaces, m, e, host, moves, is_stiff, part)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e, host             !! the first elements of both
      logical, intent(in) :: moves(:)            !! which nodes have material, (n_points)
      logical, intent(in) :: is_stiff            !! else they have only a mass
      real(dp), intent(in) :: part               !! of the stiffness and mass of an interface point that this host has
      real(dp) :: of_node(1, most_nodes_of_leaf), of_host(m%grid%n_functions, most_nodes_of_leaf), modulus, density, &
            moduli(size(m%materials)), densities(size(m%materials))
      integer :: master(most_nodes_of_leaf), own(m%grid%n_functions), k, j, n, s
      own = m%grid%support_of(e)
      moduli = [(m%materials(k)%plane_modulus(), k=1, size(m%materials))]
      densities = [(m%materials(k)%density, k=1, size(m%materials))]
      modulus = 0
      density = 0
      do j = 0, corners - 1
         modulus = max(modulus, largest_in(moduli, e + j))
         density = max(density, largest_in(densities, e + j), largest_in(densities, host + j))
      end do
      do k = 1, size(own)
         if (own(k) > m%grid%n_nodes .or. .not. moves(own(k)) .or. any(m%grid%support_of(host) == own(k))) cycle
         call add_interface_point(interfaces, ghost)
         s = interfaces%n
         call m%grid%dofs%masters_of(own(k:k), n, master, of_node)
         interfaces%list(s)%node(:n) = master(:n)
         interfaces%list(s)%share(:n) = of_node(1, :n)
         interfaces%list(s)%n_left = n
         associate (x => m%grid%node_position(:, own(k)))
            call m%grid%dofs%masters_of(m%grid%support_of(host), j, master, of_host)
            interfaces%list(s)%node(n + 1:n + j) = master(:j)
            interfaces%list(s)%share(n + 1:n + j) = -matmul(m%grid%functions_in(host, m%grid%local_coordinate(host, x)), &
                                                         of_host(:, :j))
            interfaces%list(s)%place = x
         end associate
         associate (thickness => interfaces%thickness%at(interfaces%list(s)%place))
            interfaces%list(s)%stiffness = part*merge(firmness*modulus*thickness, 0.0_dp, is_stiff)
            interfaces%list(s)%mass = part*merge(heaviness*density*thickness*m%grid%leaf_size(e)**ndim, 0.0_dp, &
                                                 interfaces%are_moving)
         end associate
         interfaces%list(s)%length = m%grid%leaf_size(e)
         interfaces%list(s)%cell = m%grid%leaf_size(e)
      end do
   contains
      !> The largest value that the materials of the particles in an element have; 0 where there are none.
      pure real(dp) function largest_in(values, element) result(largest)
         real(dp), intent(in) :: values(:)       !! by material
         integer, intent(in) :: element
         integer :: i
         largest = 0
         do i = m%blocks%first_in(element), m%blocks%last_in(element), m%blocks%stride_in(element)
            largest = max(largest, values(m%particles%material(i)))
         end do
      end function largest_in
   end subroutine tie
end module hampm_small_pieces
