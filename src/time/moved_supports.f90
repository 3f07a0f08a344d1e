!> Supports of prescribed motion, in a motion by modes: each moves by g h(t), and the material follows statically by Psi h,
!>
!>    K Psi = 0 at free nodes,   Psi = g at held ones,   u = Psi h + sum over modes of x_k q_k,
!>
!> while its inertia acts on the modes: q_k'' + alpha q_k' + w_k**2 q_k = -P_k (h'' + alpha h'),  P_k = x_k . M Psi. Between
!> corners h' is linear in time; at corners a jump of h' is an impulse. Theory and energies: docs/explanation/modal.md. Source:
!> Clough & Penzien, Dynamics of Structures (1993), chapter 26.
module hampm_moved_supports
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_instant, only: instant_t, save_instant, go_back_to
   use hampm_mass_product, only: multiply_by_mass
   use hampm_newmark, only: move_particles
   use hampm_nodal_state, only: internal_force
   use hampm_problem, only: problem_t, map_to_grid
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: moved_supports_t, piece_t

   !> Motion of the supports in a piece of time, h' = rate + slope t.
   type :: piece_t
      real(dp), allocatable :: rate(:), slope(:) !! (motions)
   end type piece_t

   !> The motions of the supports: a box with a displacement and a velocity has two.
   type :: moved_supports_t
      integer :: n = 0                           !! number of motions
      type(time_history_t), allocatable :: history(:)
      logical, allocatable :: by_velocity(:)     !! whether h is the integral of the factor [s], else the factor [-]
      real(dp), allocatable :: shape(:, :, :)    !! Psi, (ndim, n_points, motions) [m, m/s]
      real(dp), allocatable :: pull(:, :)        !! P, (modes, motions)
      real(dp), allocatable :: against(:, :, :)  !! -K g, as it is at the start, (ndim, n_points, motions)
      real(dp), allocatable, private :: stiffness(:, :), mass(:, :) !! Psi . K Psi, Psi . M Psi, (motions, motions)
      real(dp), allocatable, private :: preload(:) !! - Psi . r of the internal forces at the start
      real(dp), allocatable :: way(:), rate(:)   !! h and h' just before the present time
   contains
      procedure :: find_motions
      procedure :: find_forces_against
      procedure :: find_energies
      procedure :: enter
      procedure :: leave
      procedure :: serialise
      procedure, private :: way_at
      procedure, private :: energy
   end type moved_supports_t

contains

   !> Find the motions, and the displacements g of the held nodes as the first part of Psi.
   subroutine find_motions(self, m)
      class(moved_supports_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), allocatable :: ways(:, :, :)
      integer :: k
      allocate (ways(ndim, m%constraints%number(), 2*m%constraints%number()), source=0.0_dp)
      if (allocated(self%history)) deallocate (self%history, self%by_velocity, self%shape)
      allocate (self%history(2*m%constraints%number()), self%by_velocity(2*m%constraints%number()))
      self%n = 0
      do k = 1, m%constraints%number()
         associate (motion => m%constraints%boxes(k)%motion)
            call add(motion%displacement, .false., motion%history)
            call add(motion%velocity, .true., motion%history)
         end associate
      end do
      self%history = self%history(:self%n)
      self%by_velocity = self%by_velocity(:self%n)
      allocate (self%shape(ndim, m%grid%n_points, self%n), source=0.0_dp)
      do k = 1, self%n
         self%shape(:, m%constraints%node, k) = m%constraints%by_ways(ways(:, :, k))
         call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, self%shape(:, :, k))
      end do
      if (.not. allocated(self%way)) self%way = self%way_at(0.0_dp)
      if (.not. allocated(self%rate)) allocate (self%rate(self%n), source=0.0_dp)

   contains

      !> Add a motion of box `k`, if it is one.
      subroutine add(unit, by_velocity, history)
         real(dp), intent(in) :: unit(:)         !! at h = 1
         logical, intent(in) :: by_velocity
         type(time_history_t), intent(in) :: history
         if (.not. any(abs(unit) > 0)) return
         self%n = self%n + 1
         ways(:, k, self%n) = unit
         self%history(self%n) = history
         self%by_velocity(self%n) = by_velocity
      end subroutine add
   end subroutine find_motions

   !> Forces -K g at all nodes against the motions at h = 1, of cells and of interface points: by moving the particles and back. A
   !> run that is resumed has them.
   subroutine find_forces_against(self, m)
      class(moved_supports_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(instant_t) :: instant
      real(dp), allocatable :: before(:, :), after(:, :)
      integer :: k
      if (allocated(self%against)) return
      allocate (self%against(ndim, m%grid%n_points, self%n))
      if (self%n == 0) return
      call internal_force(m, before)
      call save_instant(m, instant)
      do k = 1, self%n
         if (.not. allocated(m%state%velocity)) allocate (m%state%velocity, source=0*before)
         call move_particles(m, 1.0_dp, self%shape(:, :, k), m%state%velocity, .false.)
         call internal_force(m, after)
         self%against(:, :, k) = after - before
         call go_back_to(instant, m)
         call map_to_grid(m)
      end do
   end subroutine find_forces_against

   !> Complete Psi by its part at free nodes, and find its stiffness, mass and momentum M Psi.
   subroutine find_energies(self, m, free, first, mass, momentum)
      class(moved_supports_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: free(:, :, :)      !! the part at free nodes, (ndim, n_points, motions)
      real(dp), intent(in) :: first(:, :)        !! internal forces at the start [N], (ndim, n_points)
      real(dp), intent(in) :: mass(:)            !! of `multiply_by_mass` [kg]
      real(dp), allocatable, intent(out) :: momentum(:, :, :) !! (ndim, n_points, motions)
      integer :: k, l
      allocate (momentum, mold=free)
      if (allocated(self%stiffness)) deallocate (self%stiffness, self%mass, self%preload)
      allocate (self%stiffness(self%n, self%n), self%mass(self%n, self%n), self%preload(self%n))
      self%shape = self%shape + free
      do k = 1, self%n
         call multiply_by_mass(m%grid, m%fields%mass_matrix, mass, self%shape(:, :, k), momentum(:, :, k))
      end do
      associate (n => m%grid%n_nodes)
         do k = 1, self%n
            self%preload(k) = -sum(self%shape(:, :n, k)*first(:, :n))
            do l = 1, self%n
               self%stiffness(l, k) = -sum(self%shape(:, :n, l)*self%against(:, :n, k))
               self%mass(l, k) = sum(self%shape(:, :n, l)*momentum(:, :n, k))
            end do
         end do
      end associate
      self%stiffness = (self%stiffness + transpose(self%stiffness))/2
   end subroutine find_energies

   !> h at a time.
   pure function way_at(self, time) result(way)
      class(moved_supports_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: way(self%n)
      integer :: k
      do k = 1, self%n
         way(k) = merge(self%history(k)%integral(time), self%history(k)%factor(time), self%by_velocity(k))
      end do
   end function way_at

   !> Energy by the motion of the supports, with what it has together with that of the modes, from the start on [J].
   pure real(dp) function energy(self, rate)
      class(moved_supports_t), intent(in) :: self
      real(dp), intent(in) :: rate(:)            !! q'
      real(dp) :: h(self%n)
      h = self%way - self%way_at(0.0_dp)
      energy = dot_product(h, matmul(self%stiffness, h))/2 + dot_product(self%preload, h) &
               + dot_product(self%rate, matmul(self%mass, self%rate))/2 + dot_product(self%rate, matmul(rate, self%pull))
   end function energy

   !> Enter a piece of time: the impulses of supports whose velocity jumps, and the motion in the piece.
   subroutine enter(self, time, corner, square, q, rate, piece, work)
      class(moved_supports_t), intent(inout) :: self
      real(dp), intent(in) :: time, corner       !! of the piece [s]
      real(dp), intent(in) :: square(:)          !! w**2 [1/s2]
      real(dp), intent(inout) :: q(:), rate(:)   !! of the modes
      type(piece_t), intent(out) :: piece
      real(dp), intent(inout) :: work            !! of the supports [J]
      real(dp), dimension(self%n) :: way, change
      real(dp) :: before
      integer :: k
      allocate (piece%rate(self%n), piece%slope(self%n))
      if (self%n == 0) return
      before = self%energy(rate) + sum(square*q**2)/2
      way = self%way_at(time)
      q = q - matmul(self%pull, way - self%way)  ! of a support that jumps
      self%way = way
      do k = 1, self%n
         associate (first => self%history(k)%factor(time), last => self%history(k)%factor(nearest(corner, -1.0_dp)))
            piece%rate(k) = merge(first, (last - first)/(corner - time), self%by_velocity(k))
            piece%slope(k) = merge((last - first)/(corner - time), 0.0_dp, self%by_velocity(k))
         end associate
      end do
      change = piece%rate - self%rate
      work = work - dot_product(change, matmul(rate - matmul(self%pull, change)/2, self%pull))
      rate = rate - matmul(self%pull, change)
      self%rate = piece%rate
      work = work + self%energy(rate) + sum(square*q**2)/2 - before
   end subroutine enter

   !> Leave it: the work of the supports, and the loss by the damping of their motion.
   subroutine leave(self, corner, t, alpha, piece, q, sums, rate, rate_after, q_after, work, loss)
      class(moved_supports_t), intent(inout) :: self
      real(dp), intent(in) :: corner, t          !! end and length of the piece [s]
      real(dp), intent(in) :: alpha              !! [1/s]
      type(piece_t), intent(in) :: piece
      real(dp), intent(in) :: q(:), sums(:), rate(:) !! of the modes at its start; integrals of q over it
      real(dp), intent(in) :: rate_after(:), q_after(:) !! at its end
      real(dp), intent(inout) :: work, loss      !! [J]
      real(dp), dimension(self%n) :: together    ! integral of h' P . q'
      real(dp) :: before, own                    ! integral of h' . m h'
      integer :: k
      if (self%n == 0) return
      before = self%energy(rate)
      associate (a => piece%rate, b => piece%slope)
         self%rate = a + b*t
         do k = 1, self%n
            self%way(k) = merge(self%history(k)%integral(corner), self%history(k)%factor(nearest(corner, -1.0_dp)), &
                                self%by_velocity(k))
         end do
         together = self%rate*matmul(q_after, self%pull) - a*matmul(q, self%pull) - b*matmul(sums, self%pull)
         own = t*(dot_product(a, matmul(self%mass, a)) + t*dot_product(a, matmul(self%mass, b)) &
                  + t**2/3*dot_product(b, matmul(self%mass, b)))
         work = work + self%energy(rate_after) - before + alpha*(own + sum(together)) &
                - dot_product(b, matmul(q_after - q, self%pull))
         loss = loss + alpha*(own + 2*sum(together))
      end associate
   end subroutine leave

   !> Archive where the supports are, and the forces against their motions.
   subroutine serialise(self, n_points, archive)
      class(moved_supports_t), intent(inout) :: self
      integer, intent(in) :: n_points            !! of the grid
      class(archive_t), intent(inout) :: archive
      integer :: n(1)
      n = self%n
      call archive%archive_integers('moved_supports', 1, n)
      if (archive%is_read) allocate (self%way(n(1)), self%rate(n(1)), self%against(ndim, n_points, n(1)))
      call archive%archive_reals('support_displacement', n(1), self%way)
      call archive%archive_reals('support_velocity', n(1), self%rate)
      call archive%archive_reals('forces_against_supports', size(self%against), self%against)
   end subroutine serialise
end module hampm_moved_supports
