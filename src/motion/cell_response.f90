!> Sweeps without particles: how the shares of a cell answer to the motion of its corners, where they do so linearly.
!>
!> In the total frame shape functions stay. What a particle gains in a sweep is then linear in values at the nodes, and what it
!> gains in many is so in their sums:
!>
!>    v_p <- v_p + sum_i A_i N_i,             A_i = sum of a_i dt;
!>    u_p <- u_p + sum_i U_i N_i,             U_i = sum of (v_i + a_i dt) dt;
!>    H_p <- H_p + sum_i S_i (x) grad N_i,    S_i = sum of the velocities that strain, times their part of dt.
!>
!> With a linear law the shares of a cell in momentum and internal force change linearly too, by its mass matrix (6) and by moments of
!> its volume: this is the finite element method with the particles as points of quadrature. A sweep then adds to sums at the nodes
!> and to shares, and particles stay behind until `settle` gives them what they have gained, and maps them.
!>
!> Blocks of cells with another law or with several materials are swept particle by particle as ever, and so are those with
!> particles that carry a load, whose way is asked for after each step, and those with a corner that has hardly any mass: there the
!> sums would be large, and a particle the small difference of such.
!>
!> Once settled nothing is kept here that does not follow from the particles: the sums are zero, the shares those of the particles.
module hampm_cell_response
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions
   use hampm_block_kernels, only: take_corners
   use hampm_large_pages, only: prefer_large_pages
   use hampm_loads, only: load_t
   use hampm_mass_matrix, only: nodes_per_block
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: nodal_fields_t, new, mass_share, momentum_share, force_share, shares
   use hampm_particles, only: particles_t, lanes
   use hampm_response_kernels, only: n_masses, n_moments, answer_kick, answer_strain, add_to_sum
   use hampm_sweep, only: sweep_t, sweep_list, sweep_between, blocks_per_task
   implicit none
   private
   public :: cell_response_t, fit_response, add_up, respond, respond_everywhere, settle_particles

   real(dp), parameter :: least_share = 1.0e-6_dp       !! of a corner in the mass of its cell

   !> Which cells answer by themselves, and with which matrices.
   type :: cell_response_t
      logical :: is_active = .false.                    !! whether any block has a response
      logical :: is_behind = .false.                    !! whether particles have not yet got what the sums hold
      ! What follows from the particles
      logical, allocatable :: has_response(:)           !! (n_blocks)
      integer, allocatable :: blocks(:)                 !! those that have
      real(dp), allocatable :: masses(:, :, :)          !! M of the cells [kg], (lanes, n_masses, n_blocks)
      real(dp), allocatable :: moments(:, :, :)         !! moments of their volume [m3], (lanes, n_moments, n_blocks)
      ! What the particles have not got yet, by point; zero where they are not behind. (ndim, n_points)
      real(dp), allocatable :: kick(:, :)               !! A [m/s]
      real(dp), allocatable :: move(:, :)               !! U [m]
      real(dp), allocatable :: strain(:, :)             !! S [m]
   end type cell_response_t

contains

   !> Find the responses of blocks whose particles have just been located, if they are wanted. None are active where the memory
   !> does not suffice.
   subroutine fit_response(wanted, materials, loads, p, f, r)
      logical, intent(in) :: wanted
      type(material_t), intent(in) :: materials(:)
      type(load_t), intent(in) :: loads(:)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      type(cell_response_t), intent(out) :: r
      integer :: b, k, status
      if (.not. wanted) return
      call choose_blocks(materials, loads, p, f, r%has_response)
      r%blocks = pack([(b, b=1, p%n_blocks)], r%has_response)
      if (size(r%blocks) == 0) return
      associate (points => size(f%acceleration, 2))
         allocate (r%masses(lanes, n_masses, p%n_blocks), r%moments(lanes, n_moments, p%n_blocks), r%kick(ndim, points), &
                   r%move(ndim, points), r%strain(ndim, points), stat=status)
      end associate
      if (status /= 0) return
      call prefer_large_pages(size(r%masses), r%masses)
      call prefer_large_pages(size(r%moments), r%moments)
      r%is_active = .true.
      !$omp parallel do schedule(static)
      do k = 1, size(r%blocks)
         call sum_block(p, r%blocks(k), r%masses(:, :, r%blocks(k)), r%moments(:, :, r%blocks(k)))
      end do
      call clear_sums(r)
   end subroutine fit_response

   !> Which blocks have a linear law, one material, no particle that carries a load, and mass at all corners.
   pure subroutine choose_blocks(materials, loads, p, f, chosen)
      type(material_t), intent(in) :: materials(:)
      type(load_t), intent(in) :: loads(:)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      logical, allocatable, intent(out) :: chosen(:)
      logical, allocatable :: is_loaded(:)
      integer :: b, l, k
      allocate (is_loaded(size(p%count_in)), source=.false.)
      do k = 1, size(loads)
         is_loaded(p%cell(loads(k)%host)) = .true.
      end do
      allocate (chosen(p%n_blocks), source=.false.)
      do b = 1, p%n_blocks
         if (p%block_material(b) == 0) cycle
         chosen(b) = materials(p%block_material(b))%linear
         do l = 1, count(p%block_cells(:, b) > 0)
            associate (mass => f%share(l, :, mass_share, b))
               if (is_loaded(p%block_cells(l, b)) .or. minval(mass) < least_share*sum(mass)) chosen(b) = .false.
            end associate
         end do
      end do
   end subroutine choose_blocks

   !> Sum mass matrices and moments of the cells of a block.
   pure subroutine sum_block(p, b, masses, moments)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: b
      real(dp), intent(out) :: masses(lanes, n_masses), moments(lanes, n_moments)
      real(dp) :: n(corners), xi(ndim)
      integer :: l, i
      masses = 0
      moments = 0
      do l = 1, count(p%block_cells(:, b) > 0)
         associate (e => p%block_cells(l, b))
            do i = p%first_in(e), p%last_in(e), p%stride_in(e)
               xi = p%local(i, :)
               n = shape_functions(xi)
               masses(l, :) = masses(l, :) + p%mass(i)*[n(1)*n, n(2)*n(2:), n(3)*n(3:), n(4)*n(4:)]
               moments(l, :) = moments(l, :) + p%volume(i)*[1.0_dp, xi(1), xi(2), xi(1)**2, xi(1)*xi(2), xi(2)**2]
            end do
         end associate
      end do
   end subroutine sum_block

   !> Add what a sweep does at some points to the sums.
   pure subroutine add_up(sweep, dt, points, f, r)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: points(:)
      type(nodal_fields_t), intent(in) :: f
      type(cell_response_t), intent(inout) :: r
      if (sweep%kick) call add_to_sum(dt, size(points), points, f%acceleration, r%kick)
      if (sweep%move) call add_to_sum(dt, size(points), points, f%velocity(1, 1, new), r%move)
      if (sweep%strain_fraction > 0) call add_to_sum(sweep%strain_fraction*dt, size(points), points, &
                                                     f%velocity(1, 1, sweep%strain_by), r%strain)
   end subroutine add_up

   !> Do a sweep over some blocks: by their response, or particle by particle where they have none.
   subroutine respond(r, sweep, dt, materials, p, f, blocks)
      type(cell_response_t), intent(in) :: r
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: blocks(:)
      if (.not. r%is_active) then
         call sweep_list(sweep, dt, materials, p, f, .false., blocks)
      else
         call respond_some(sweep, dt, materials, size(blocks), blocks, r%has_response, p%block_material, f%block_nodes, &
                           f%in_row, f%block_inverse_size, r%masses, r%moments, f%acceleration, f%velocity(1, 1, sweep%strain_by), &
                           f%share(1, 1, 1, 1))
         if (.not. all(r%has_response(blocks))) call sweep_list(sweep, dt, materials, p, f, .false., &
                                                                pack(blocks, .not. r%has_response(blocks)))
      end if
   end subroutine respond

   !> What a sweep adds to the shares of those of some blocks that have a response.
   pure subroutine respond_some(sweep, dt, materials, n_listed, listed, has_response, block_material, nodes, in_row, inverse_size, &
                                masses, moments, acceleration, strain_velocity, share)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: n_listed, listed(n_listed) !! blocks, and by block:
      logical, intent(in) :: has_response(*), in_row(*)
      integer, intent(in) :: block_material(*), nodes(corners, lanes, *)
      real(dp), intent(in) :: inverse_size(lanes, *), masses(lanes, n_masses, *), moments(lanes, n_moments, *)
      real(dp), intent(in) :: acceleration(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(inout) :: share(lanes, corners, shares, *)
      real(dp) :: factor(lanes), a(lanes, corners, ndim)
      integer :: j, b
      do j = 1, n_listed
         b = listed(j)
         if (.not. has_response(b)) cycle
         if (sweep%kick) then
            factor = dt
            call take_corners(1, factor, acceleration, nodes(1, 1, b), in_row(b), a)
            call answer_kick(a, masses(1, 1, b), share(1, 1, momentum_share, b))
         end if
         if (sweep%strain_fraction > 0) then
            factor = (sweep%strain_fraction*dt)*inverse_size(:, b)
            call take_corners(1, factor, strain_velocity, nodes(1, 1, b), in_row(b), a)
            call answer_strain(materials(block_material(b))%lambda, materials(block_material(b))%mu, inverse_size(1, b), a, &
                               moments(1, 1, b), share(1, 1, force_share, b))
         end if
      end do
   end subroutine respond_some

   !> Do a sweep over all blocks, and sum up at all points.
   subroutine respond_everywhere(r, sweep, dt, materials, p, f)
      type(cell_response_t), intent(inout) :: r
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      integer :: k, b
      associate (all => f%mass_matrix%all)
         !$omp parallel do schedule(static)
         do k = 1, all%n_points, nodes_per_block
            call add_up(sweep, dt, all%nodes(k:min(k + nodes_per_block - 1, all%n_points)), f, r)
         end do
      end associate
      !$omp parallel do schedule(static) private(b)
      do k = 1, p%n_blocks, blocks_per_task
         call respond(r, sweep, dt, materials, p, f, [(b, b=k, min(k + blocks_per_task - 1, p%n_blocks))])
      end do
   end subroutine respond_everywhere

   !> Give the particles what they have gained since they were up to date, and map them.
   subroutine settle_particles(r, materials, p, f)
      type(cell_response_t), intent(inout) :: r
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      type(sweep_t) :: gain
      integer :: k
      if (.not. r%is_behind) return
      gain = sweep_t(kick=.true., strain_fraction=1.0_dp, move=.true., map_momentum=.true., map_force=.true.)
      !$omp parallel do schedule(static)
      do k = 1, size(r%blocks), blocks_per_task
         call sweep_between(gain, 1.0_dp, materials, p, f, .false., r%blocks(k:min(k + blocks_per_task - 1, size(r%blocks))), &
                            f%block_nodes, f%in_row, r%kick, r%move, r%strain)
      end do
      call clear_sums(r)
   end subroutine settle_particles

   !> Begin new sums.
   subroutine clear_sums(r)
      type(cell_response_t), intent(inout) :: r
      r%kick = 0
      r%move = 0
      r%strain = 0
      r%is_behind = .false.
   end subroutine clear_sums
end module hampm_cell_response
