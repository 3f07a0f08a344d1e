!> Nodal forces besides the internal ones: loads and, in motion, inertia.
module hampm_outer_forces
   use hampm_kinds, only: dp
   use hampm_loads, only: load_t, add_load, factors_at, turn_loads
   use hampm_mass_product, only: multiply_by_mass
   use hampm_problem, only: problem_t, stored_energy
   use hampm_nodal_state, only: external_force
   use hampm_vectors, only: add_scaled, correct
   implicit none
   private
   public :: outer_forces_t, loading_t, find_loading, scale_loads, find_heat, have_followers, add_followers

   !> Loading of the material at a time.
   type :: loading_t
      real(dp), allocatable :: force(:, :)       !! of all loads that keep their direction, condensed [N], (ndim, n_points)
      real(dp), allocatable :: factor(:)         !! of each load [-]; not allocated where none follows faces
      real(dp), allocatable :: shift(:, :)       !! displacement of fixed components of nodes [m], (ndim, n_nodes)
   end type loading_t

   !> Forces for a displacement u of the nodes in a step: applied, of inertia, -M (c (u - given) + rest), and of dashpots on edges,
   !> -D (b (u - given) + slide).
   type :: outer_forces_t
      real(dp), allocatable :: applied(:, :)     !! condensed [N], (ndim, n_points)
      real(dp), allocatable :: factor(:)         !! of each load, for those that follow faces [-]; not allocated if none does
      real(dp) :: mass_factor = 0                !! c [1/s2]; 0 in static steps
      real(dp) :: inertia = 0                    !! the largest force of it at first [N]
      real(dp), allocatable :: given(:, :)       !! of fixed components [m], (ndim, n_points)
      real(dp), allocatable :: rest(:, :)        !! [m/s2], (ndim, n_points)
      real(dp) :: dashpot_factor = 0             !! b [1/s]
      real(dp), allocatable :: slide(:, :)       !! [m/s], (ndim, n_points); not allocated without dashpots
      real(dp), allocatable :: mass(:)           !! diagonal part of M beside the matrices of cells [kg], (n_points)
   contains
      procedure :: add_to
   end type outer_forces_t

contains

   !> Loading of the material at a time.
   subroutine find_loading(m, time, loading)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(loading_t), intent(out) :: loading
      call external_force(m, time, loading%force)
      if (have_followers(m)) loading%factor = factors_at(m%loads, time)
      loading%shift = m%constraints%prescribed_at(time)
   end subroutine find_loading

   !> Whether any load follows faces.
   pure logical function have_followers(m)
      type(problem_t), intent(in) :: m
      integer :: k
      have_followers = any([(allocated(m%loads(k)%follows), k=1, size(m%loads))])
   end function have_followers

   !> Add the loads that follow faces, as the particles are strained now, to condensed forces [N].
   pure subroutine add_followers(m, factor, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: factor(:)          !! of each load [-]
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      real(dp) :: following(size(force, 1), size(force, 2))
      type(load_t) :: load(1)
      integer :: k
      following = 0
      do k = 1, size(m%loads)
         if (.not. allocated(m%loads(k)%follows)) cycle
         load(1) = m%loads(k)
         call turn_loads(load, m%particles)
         call add_load(load(1), factor(k), following)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, size(force, 1), following)
      force = force + following
   end subroutine add_followers

   !> Scale all loads, prescribed motions and eigenstrains that are not held.
   pure subroutine scale_loads(m, load_factor)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: load_factor        !! scale of the model's loads [-]
      if (size(m%loads) > 0) call m%loads%history%scale_to(load_factor)
      call m%constraints%scale_ways(load_factor)
      call m%materials%scale_eigenstrain(load_factor)
   end subroutine scale_loads

   !> The factor of scaled eigenstrains, and the derivative of the stored energy by it at fixed nodes [J], the force conjugate to
   !> it; both 0 if none is scaled.
   subroutine find_heat(m, factor, force)
      type(problem_t), intent(inout) :: m        !! as it was in the end
      real(dp), intent(out) :: factor, force
      real(dp), parameter :: part = 1e-3_dp      ! change of the factor
      real(dp) :: change
      factor = 0
      force = 0
      if (.not. any(m%materials%is_scaled)) return
      factor = maxval(m%materials%scale, mask=m%materials%is_scaled)
      change = part*max(abs(factor), tiny(factor)**0.5_dp)
      call m%materials%scale_eigenstrain(factor + change)
      force = stored_energy(m)
      call m%materials%scale_eigenstrain(factor - change)
      force = (force - stored_energy(m))/(2*change)
      call m%materials%scale_eigenstrain(factor)
   end subroutine find_heat

   !> Add the forces with a displacement of the nodes to condensed ones [N].
   subroutine add_to(self, m, u, force)
      class(outer_forces_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in), contiguous :: u(:, :) !! [m], (ndim, n_points)
      real(dp), intent(inout), contiguous :: force(:, :) !! (ndim, n_points)
      real(dp), allocatable :: a(:, :), inertia(:, :)
      call add_scaled(size(force), 1.0_dp, self%applied, force)
      if (allocated(self%factor)) call add_followers(m, self%factor, force)
      if (.not. self%mass_factor > 0) return
      allocate (a, inertia, mold=self%applied)
      call correct(size(u), self%mass_factor, u, self%given, self%rest, a)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, a, inertia)
      call add_scaled(size(force), -1.0_dp, inertia, force)
      if (m%absorbing%n == 0) return
      call correct(size(u), self%dashpot_factor, u, self%given, self%slide, a)
      call m%absorbing%resist(a, force)
   end subroutine add_to
end module hampm_outer_forces
