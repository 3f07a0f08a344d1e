!> Passes without particles: element operators give the change of the contributions of a cell with the motion of its corners, where
!> it is linear (total frame, linear law). The gain of a particle in many passes is then linear in sums of nodal values:
!>
!>    v_p <- v_p + sum_i A_i N_i,             A_i = sum of a_i dt;
!>    u_p <- u_p + sum_i U_i N_i,             U_i = sum of (v_i + a_i dt) dt;
!>    H_p <- H_p + sum_i S_i (x) grad N_i,    S_i = sum of the straining velocities, times their part of dt.
!>
!> This is the finite element method with the particles as quadrature points: nodal momentum changes by the mass matrix (6), force
!> by the stiffness matrix. A pass adds to sums at the nodes (`hampm_stencils`); particles stay behind until `give_to_particles`
!> updates and maps them. Points with operators in all cells keep their sums. Blocks with another law, several materials, loaded
!> particles or a corner of next to no mass (a particle would be a small difference of large sums) are passed particle by particle.
module hampm_element_operators
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_cell_blocks, only: cell_blocks_t, lanes, of_mass
   use hampm_element_kernels, only: n_masses, n_moments, add_to_sum, copy_points
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_matter, only: matter_t
   use hampm_nodal_fields, only: nodal_fields_t, assemble_at, v_next
   use hampm_nodal_kernels, only: assemble_sums
   use hampm_particle_pass, only: pass_report_t, pass_over_all, pass_over_blocks, cell_matrices, blocks_per_task
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_stencils, only: stencils_t, run_t, find_stencils, runs_of, apply_stencils
   use hampm_support_operators, only: support_operators_t, find_support_operators, apply_support_operators, least_part
   use hampm_support_pass, only: pass_by_supports
   use hampm_vectors, only: add_scaled
   implicit none
   private
   public :: element_operators_t, find_operators, keeps_sums, add_up, add_up_from, apply_to_runs, &
             pass_by_all_operators, refresh_sums, assemble_all, give_to_particles, archive_gains

   integer, parameter :: runs_per_task = 16      !! size of a thread's task

   !> Which cells have an operator, and the numbers of these.
   type :: element_operators_t
      logical :: is_active = .false.                    !! whether any block has operators
      logical :: is_behind = .false.                    !! whether particles do not have the sums yet
      ! Derived from the particles
      integer, allocatable :: material(:)               !! of those that have, else 0; (blocks)
      integer, allocatable :: with(:), without(:)       !! blocks that have, and the others
      type(stencils_t) :: stencils
      type(run_t), allocatable :: runs(:)               !! of all points with stencils
      integer, allocatable :: storing(:), gather(:)     !! points that keep their sums, and points that gather them from cells
      integer :: of_map = 0                             !! the map of the particles with which the kept sums begin
      real(dp), allocatable :: mobility(:, :)           !! 1/m, 0 of fixed components, in steps in tiles [1/kg], (ndim, n_points)
      type(support_operators_t) :: cells                !! instead of these, where cells are passed by supports
      real(dp), allocatable :: momentum(:, :)           !! that points keep [kg m/s], (ndim, n_points)
      real(dp), allocatable :: force(:, :)              !! [N], (ndim, n_points)
      ! Increments that the particles do not have yet, by point; zero if they are up to date. (ndim, n_points)
      real(dp), allocatable :: kick(:, :)               !! A [m/s]
      real(dp), allocatable :: move(:, :)               !! U [m]
      real(dp), allocatable :: strain(:, :)             !! S [m]
   end type element_operators_t

contains

   !> Find the operators of blocks whose particles have just been located. None are active where the memory does not suffice.
   subroutine find_operators(m, is_loaded, f, operators)
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_loaded(:)               !! whether a particle of the element carries a load
      type(nodal_fields_t), intent(inout) :: f
      type(element_operators_t), intent(out) :: operators
      real(dp), allocatable :: integrals(:, :, :)       ! M of the cells [kg], moments of their volume [m3]
      integer :: b, k, status
      if (allocated(m%blocks%supports)) then
         call find_support_operators(m, is_loaded, operators%cells)
         if (size(operators%cells%with) == 0) return
      else
         call choose_blocks(m, is_loaded, f, operators%material)
         operators%with = pack([(b, b=1, m%blocks%n)], operators%material > 0)
         operators%without = pack([(b, b=1, m%blocks%n)], operators%material == 0)
         if (size(operators%with) == 0) return
      end if
      associate (points => size(f%acceleration, 2), n => merge(0, m%blocks%n, allocated(m%blocks%supports)))
         allocate (integrals(lanes, n_masses + n_moments, n), operators%kick(ndim, points), operators%move(ndim, points), &
                   operators%strain(ndim, points), operators%momentum(ndim, points), operators%force(ndim, points), stat=status)
      end associate
      if (status /= 0) return
      operators%is_active = .true.
      call clear_sums(operators)
      operators%momentum = 0
      operators%force = 0
      operators%of_map = f%maps
      allocate (operators%storing(0), operators%runs(0))
      operators%gather = f%mass_matrix%all%nodes(:f%mass_matrix%all%n_points)
      if (allocated(m%blocks%supports)) return
      !$omp parallel do schedule(static)
      do k = 1, size(operators%with)
         associate (listed => operators%with(k))
            call sum_masses(m%particles, m%blocks, listed, integrals(:, :n_masses, listed))
            call sum_moments(m%particles, m%blocks, listed, operators%material(listed), integrals(:, n_masses + 1:, listed))
         end associate
      end do
      associate (all => f%mass_matrix%all, s => operators%stencils)
         call find_stencils(m, all%nodes(:all%n_points), operators%material, integrals, s)
         operators%runs = runs_of(s, all%nodes(:all%n_points))
         operators%storing = pack(all%nodes(:all%n_points), keeps_sums(operators, all%nodes(:all%n_points)))
         operators%gather = pack(all%nodes(:all%n_points), .not. keeps_sums(operators, all%nodes(:all%n_points)))
      end associate
      operators%of_map = f%maps - 1
      call refresh_sums(operators, m%blocks, f)
   end subroutine find_operators

   !> Whether a point keeps its sums: all cells with particles around it have operators.
   elemental logical function keeps_sums(operators, point)
      type(element_operators_t), intent(in) :: operators
      integer, intent(in) :: point
      keeps_sums = operators%stencils%of_point(point) > 0 .and. operators%stencils%home(point) == 0
   end function keeps_sums

   !> Which blocks have a linear law, one material, no particle that carries a load, and mass at all corners.
   pure subroutine choose_blocks(m, is_loaded, f, material)
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_loaded(:)
      type(nodal_fields_t), intent(in) :: f
      integer, allocatable, intent(out) :: material(:)  !! 0 of others
      integer :: b, l
      allocate (material(m%blocks%n), source=0)
      do b = 1, m%blocks%n
         if (m%blocks%material(b) == 0) cycle
         if (m%materials(m%blocks%material(b))%linear) material(b) = m%blocks%material(b)
         do l = 1, count(m%blocks%cells(:, b) > 0)
            associate (mass => f%contribution(l, :, of_mass, b), e => m%blocks%cells(l, b))
               if (is_loaded(e) .or. minval(mass) < least_part*sum(mass)) material(b) = 0
               if (ndim > 2 .and. m%grid%is_cut(m%grid%element_leaf(e))) material(b) = 0 ! matrices for each would be large
            end associate
         end do
      end do
   end subroutine choose_blocks

   !> Sum the mass matrices of the cells of a block.
   pure subroutine sum_masses(p, blocks, b, masses)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: b
      real(dp), intent(out) :: masses(lanes, n_masses)  !! [kg]
      real(dp) :: matrix(lanes, corners, corners)
      integer :: l, i, j
      call cell_matrices(p, blocks, b, matrix)
      do l = 1, lanes
         associate (m => matrix(l, :, :))
            masses(l, :) = [((m(i, j), i=j, corners), j=1, corners)]
         end associate
      end do
   end subroutine sum_masses

   !> Sum the moments of the volume of a material in the cells of a block.
   pure subroutine sum_moments(p, blocks, b, material, moments)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: b
      integer, intent(in) :: material
      real(dp), intent(out) :: moments(lanes, n_moments) !! [m3]
      real(dp) :: xi(ndim)
      integer :: l, i, j, k
      moments = 0
      do l = 1, count(blocks%cells(:, b) > 0)
         associate (e => blocks%cells(l, b))
            do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
               if (p%material(i) /= material) cycle
               xi = p%local(i, :)
               moments(l, :) = moments(l, :) + p%volume(i)*[1.0_dp, xi, ((xi(j)*xi(k), k=j, ndim), j=1, ndim)]
            end do
         end associate
      end do
   end subroutine sum_moments

   !> Add the increments of a pass at some points to the sums.
   pure subroutine add_up(pass, dt, points, f, operators)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: points(:)
      type(nodal_fields_t), intent(in) :: f
      type(element_operators_t), intent(inout) :: operators
      if (pass%kick) call add_to_sum(dt, size(points), points, f%acceleration, operators%kick)
      if (pass%move) call add_to_sum(dt, size(points), points, f%velocity(1, 1, v_next), operators%move)
      if (pass%strain_fraction > 0) call add_to_sum(pass%strain_fraction*dt, size(points), points, &
                                                    f%velocity(1, 1, pass%strain_by), operators%strain)
   end subroutine add_up

   !> Add the increments of a pass at consecutive points to the sums.
   pure subroutine add_up_from(pass, dt, first, n, f, operators)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: first, n                   !! point, and number of points
      type(nodal_fields_t), intent(in) :: f
      type(element_operators_t), intent(inout) :: operators
      if (pass%kick) call add_scaled(ndim*n, dt, f%acceleration(1, first), operators%kick(1, first))
      if (pass%move) call add_scaled(ndim*n, dt, f%velocity(1, first, v_next), operators%move(1, first))
      if (pass%strain_fraction > 0) call add_scaled(ndim*n, pass%strain_fraction*dt, f%velocity(1, first, pass%strain_by), &
                                                    operators%strain(1, first))
   end subroutine add_up_from

   !> Add the effect of a pass to the momenta and forces at the points of some runs.
   pure subroutine apply_to_runs(operators, runs, pass, dt, f)
      type(element_operators_t), intent(inout) :: operators
      type(run_t), intent(in) :: runs(:)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      type(nodal_fields_t), intent(inout) :: f
      call apply_stencils(operators%stencils, runs, pass, dt, size(f%acceleration, 2), f%acceleration, &
                          f%velocity(1, 1, pass%strain_by), operators%momentum, operators%force, f%contribution(1, 1, 1, 0))
   end subroutine apply_to_runs

   !> Do a pass over all blocks, by operators where there are any, and sum up at all points.
   subroutine pass_by_all_operators(operators, pass, dt, m, f)
      type(element_operators_t), intent(inout) :: operators
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      type(pass_report_t) :: unused
      type(pass_t) :: by_operators
      integer :: k
      by_operators = pass
      by_operators%kick = pass%kick .and. .not. pass%momentum_later
      if (.not. operators%is_active) then
         call pass_over_all(pass, dt, m, f, unused)
         return
      end if
      associate (all => f%mass_matrix%all)
         !$omp parallel do schedule(static)
         do k = 1, all%n_points, nodes_per_chunk
            call add_up(pass, dt, all%nodes(k:min(k + nodes_per_chunk - 1, all%n_points)), f, operators)
         end do
      end associate
      if (allocated(m%blocks%supports)) then
         call apply_support_operators(operators%cells, by_operators, dt, m%blocks, f)
         call pass_by_supports(pass, dt, m, f, operators%cells%without, f%acceleration, f%velocity(1, 1, v_next), &
                               f%velocity(1, 1, pass%strain_by))
         return
      end if
      !$omp parallel do schedule(static)
      do k = 1, size(operators%runs), runs_per_task
         call apply_to_runs(operators, operators%runs(k:min(k + runs_per_task - 1, size(operators%runs))), by_operators, dt, f)
      end do
      !$omp parallel do schedule(static)
      do k = 1, size(operators%without), blocks_per_task
         call pass_over_blocks(pass, dt, m, f, operators%without(k:min(k + blocks_per_task - 1, size(operators%without))), &
                               f%acceleration, f%velocity(1, 1, v_next), f%velocity(1, 1, pass%strain_by))
      end do
   end subroutine pass_by_all_operators

   !> Restart the sums of points with the sums over the particles, where these have been mapped anew.
   subroutine refresh_sums(operators, blocks, f)
      type(element_operators_t), intent(inout) :: operators
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      if (.not. operators%is_active .or. operators%of_map == f%maps) return
      call assemble_sums(size(operators%storing), operators%storing, blocks%slot, f%contribution, .false., .true., .true., &
                         f%mass_matrix%lumped, operators%momentum, operators%force)
      operators%of_map = f%maps
   end subroutine refresh_sums

   !> Sum the contributions of the cells at all points that do not keep sums. Forces at hanging nodes are not yet condensed.
   subroutine assemble_all(operators, blocks, f, mass, momentum, force)
      type(element_operators_t), intent(inout) :: operators
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: mass, momentum, force
      integer :: k, n
      call refresh_sums(operators, blocks, f)
      associate (all => f%mass_matrix%all%nodes(:f%mass_matrix%all%n_points))
         if (.not. operators%is_active) then
            call assemble_at(all, blocks, f, mass, momentum, force)
            return
         end if
         if (mass) call assemble_at(all, blocks, f, .true., .false., .false.)
      end associate
      call assemble_at(operators%gather, blocks, f, .false., momentum, force)
      !$omp parallel do schedule(static) private(n)
      do k = 1, size(operators%storing), nodes_per_chunk
         n = min(nodes_per_chunk, size(operators%storing) - k + 1)
         if (momentum) call copy_points(n, operators%storing(k), operators%momentum, f%momentum)
         if (force) call copy_points(n, operators%storing(k), operators%force, f%force)
      end do
   end subroutine assemble_all

   !> Update the particles by their increments, and map them.
   subroutine give_to_particles(operators, m, f)
      type(element_operators_t), intent(inout) :: operators
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      type(pass_t) :: update
      integer :: k
      if (.not. operators%is_behind) return
      update = pass_t(kick=.true., strain_fraction=1.0_dp, move=.true., map_momentum=.true., map_force=.true.)
      if (allocated(m%blocks%supports)) then
         call pass_by_supports(update, 1.0_dp, m, f, operators%cells%with, operators%kick, operators%move, operators%strain)
      else
         !$omp parallel do schedule(static)
         do k = 1, size(operators%with), blocks_per_task
            call pass_over_blocks(update, 1.0_dp, m, f, operators%with(k:min(k + blocks_per_task - 1, size(operators%with))), &
                                  operators%kick, operators%move, operators%strain)
         end do
         f%maps = f%maps + 1
      end if
      call clear_sums(operators)
   end subroutine give_to_particles

   !> Begin new sums.
   subroutine clear_sums(operators)
      type(element_operators_t), intent(inout) :: operators
      operators%kick = 0
      operators%move = 0
      operators%strain = 0
      operators%is_behind = .false.
   end subroutine clear_sums

   !> Archive the increments of particles that are behind. When they are read, the operators have been found.
   subroutine archive_gains(operators, archive)
      type(element_operators_t), intent(inout) :: operators
      class(archive_t), intent(inout) :: archive
      call archive%section('operators')
      call archive%serialise('is_behind', operators%is_behind)
      if (.not. operators%is_behind) return
      call archive%archive_reals('kick', size(operators%kick), operators%kick)
      call archive%archive_reals('move', size(operators%move), operators%move)
      call archive%archive_reals('strain', size(operators%strain), operators%strain)
      call archive%archive_reals('momentum', size(operators%momentum), operators%momentum)
      call archive%archive_reals('force', size(operators%force), operators%force)
   end subroutine archive_gains
end module hampm_element_operators
