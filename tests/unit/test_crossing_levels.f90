!> A body that flies through a patch of fine cells is split on entry and recombined behind it, and stays one body that moves on as
!> if there were no patch.
program test_crossing_levels
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: smallest_occupied_cell
   use hampm_constraints, only: constrain_box
   use hampm_energy, only: strain_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_matching, only: match_particles
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_refined, only: refine_box, misplaced
   use hampm_refinement, only: follow_particles
   use hampm_samples, only: rectangle_t, place_bodies, start, total_energy, energy_residual
   use hampm_step, only: advance
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: cell = 0.1_dp, courant = 0.2_dp
   character(5), parameter :: tried(3) = ['usf  ', 'usavg', 'musl ']   ! plain USL breaks up free edges that leave the cell lines

   type :: flight_t                              !! the largest of what was seen
      integer :: misplaced = 0                   !! particles times steps
      integer :: most_particles = 0
      real(dp) :: finest_step = 0                !! the finest cell on the way over the smallest with particles [-]
      real(dp) :: last_step = 0                  !! smallest cell with particles at the end over a root cell [-]
      real(dp) :: off_the_line = 0               !! distance of the centre of mass from where it should be [m]
      real(dp) :: momentum_change = 0            !! relative to the sum of m |v| [-]
      real(dp) :: residual = 0                   !! of the energy audit, relative to the initial energy [-]
      real(dp) :: internal_energy = 0            !! relative to the initial energy [-]
      real(dp) :: stretch = 0                    !! see `largest_stretch` [-]
   end type flight_t

   integer :: k

   do k = 1, size(tried)
      call translation(trim(tried(k)))
      call rotation(trim(tried(k)), 'neo_hookean', 2, 0.2_dp)
      call rotation(trim(tried(k)), 'linear_elastic', 2, 0.01_dp)
      call vibration(trim(tried(k)))
   end do
   call rotation('musl', 'neo_hookean', 3, 0.2_dp)
   call finish()

contains

   !> Without spin nothing at all happens to the body.
   subroutine translation(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      type(flight_t) :: seen
      real(dp), parameter :: velocity(ndim) = [1.0_dp, 0.05_dp]
      integer :: i
      call fly(scheme, 'neo_hookean', 2, 0.0_dp, m, seen)
      call check_flight(m, seen, scheme//', translation')
      call check_close(seen%internal_energy, 0.0_dp, 1.0e-24_dp, scheme//', translation: there is no internal energy')
      call check_close(maxval(abs(m%particles%gradient)), 0.0_dp, 1.0e-13_dp, scheme//', translation: there is no strain')
      call check_close(maxval([(norm2(m%particles%velocity(i, :) - velocity), i=1, m%particles%n)]), 0.0_dp, 1.0e-13_dp, &
                       scheme//', translation: every particle keeps its velocity')
   end subroutine translation

   !> The internal energy of a body that also rotates is about that which it has without fine cells. (With a lumped mass matrix
   !> a body of so few cells turns part of its spin into that.)
   subroutine rotation(scheme, law, levels, spin)
      character(*), intent(in) :: scheme, law
      integer, intent(in) :: levels
      real(dp), intent(in) :: spin               !! [1/s]
      type(problem_t) :: m
      type(flight_t) :: seen, without
      character(:), allocatable :: what
      what = scheme//', '//law//', '//to_text(levels)//' levels'
      call fly(scheme, law, 0, spin, m, without)
      call fly(scheme, law, levels, spin, m, seen)
      call check_flight(m, seen, what)
      write (*, '(2a,2es9.1,a,2f8.4,a,es9.1)') what, ': over the kinetic energy: internal energy without and with fine cells', &
         without%internal_energy, seen%internal_energy, '; stretch', without%stretch, seen%stretch
      call check(seen%internal_energy < 1.5_dp*without%internal_energy, what//': little internal energy arises')
      call check(seen%stretch < 2*without%stretch .and. seen%stretch < 0.06_dp, what//': the body stays in one piece')
   end subroutine rotation

   !> What must hold of every flight.
   subroutine check_flight(m, seen, what)
      type(problem_t), intent(in) :: m
      type(flight_t), intent(in) :: seen
      character(*), intent(in) :: what
      call check(seen%misplaced == 0, what//': each particle is in one leaf that is not finer than it')
      call check(seen%most_particles > 8*m%particles%n, what//': the body is split')
      call check_close(seen%finest_step, 1.0_dp, 1.0e-12_dp, what//': the time step follows the finest cells')
      call check_close(seen%last_step, 1.0_dp, 1.0e-12_dp, what//': and the root cells behind them')
      call check(m%particles%n == 16 .and. all(m%particles%level == 0), what//': and recombined behind the fine cells')
      call check_close(seen%off_the_line, 0.0_dp, 1.0e-12_dp, what//': the centre of mass flies straight on')
      call check_close(seen%momentum_change, 0.0_dp, 1.0e-13_dp, what//': the momentum is kept')
      call check_close(seen%residual, 0.0_dp, 1.0e-12_dp, what//': the energy audit closes')
   end subroutine check_flight

   !> Let a body fly and rotate through a patch with some levels of refinement and out again.
   subroutine fly(scheme, law, levels, spin, m, seen)
      character(*), intent(in) :: scheme, law
      integer, intent(in) :: levels
      real(dp), intent(in) :: spin               !! [1/s]
      type(problem_t), intent(out) :: m
      type(flight_t), intent(out) :: seen
      real(dp), parameter :: lower(ndim) = [0.113_dp, 0.217_dp], upper(ndim) = lower + 0.2_dp
      real(dp), parameter :: velocity(ndim) = [1.0_dp, 0.05_dp], way = 1.07_dp
      type(forest_t) :: forest
      type(failure_t) :: failure
      real(dp) :: dt, initial, momentum(ndim), centre(ndim), x(ndim), mass
      integer :: steps, step, i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [15, 7])
      call refine_box(forest, [0.6_dp, 0.3_dp], [0.9_dp, 0.6_dp], levels)
      call place_bodies(forest, new_material('', law, .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t(lower, upper, [4, 4])], m)
      do i = 1, m%particles%n
         x = m%particles%reference(i, :) - (lower + upper)/2
         m%particles%velocity(i, :) = velocity + spin*[-x(2), x(1)]
      end do
      m%audit = .true.
      call start(m, scheme)
      initial = total_energy(m)
      call match_particles(m, failure)
      dt = courant*cell/4
      if (levels > 2) dt = courant*m%grid%finest_cell
      steps = nint(way/(velocity(1)*dt))
      momentum = linear_momentum(m%particles)
      centre = centre_of_mass(m)
      mass = sum(m%particles%mass)
      do step = 1, steps
         call advance(m, dt, failure)
         if (m%cache%sorted) call follow_particles(m, failure)
         if (failure%failed()) exit
         seen%misplaced = seen%misplaced + misplaced(m)
         seen%most_particles = max(seen%most_particles, m%particles%n)
         seen%last_step = smallest_occupied_cell(m%grid, m%blocks)/cell
         seen%finest_step = max(seen%finest_step, m%grid%finest_cell/(cell*seen%last_step))
         seen%off_the_line = max(seen%off_the_line, norm2(centre_of_mass(m) - centre - step*dt*velocity))
         seen%momentum_change = max(seen%momentum_change, &
                                    norm2(linear_momentum(m%particles) - momentum)/(mass*norm2(velocity)))
         seen%residual = max(seen%residual, abs(energy_residual(m, initial))/initial)
         seen%internal_energy = max(seen%internal_energy, internal_energy(m)/initial)
         if (mod(step, steps/8) == 0) seen%stretch = max(seen%stretch, largest_stretch(m))
      end do
      if (failure%failed()) call check(.false., scheme//', '//law//': '//failure%message)
   end subroutine fly

   !> A bar that is held at one end and swings along its axis, so that its free end sweeps into fine cells and back in each period:
   !> it swings as it does in cells of one size. The siblings of a family at the free end come to differ in velocity and strain
   !> by some noise; recombining takes the energy of that, of which there is more in finer cells.
   subroutine vibration(scheme)
      character(*), intent(in) :: scheme
      real(dp) :: uniform(2), swept(2)
      integer :: levels
      call swing(scheme, 0, uniform(1), uniform(2))
      do levels = 1, 2
         call swing(scheme, levels, swept(1), swept(2))
         write (*, '(2a,i0,a,2f9.5,a,2es9.1)') scheme, ', bar, ', levels, ' levels: period without and with fine cells', &
            uniform(1), swept(1), '; part of the energy lost in two periods', uniform(2), swept(2)
         call check_close(swept(1), uniform(1), 0.02_dp*uniform(1), scheme//', bar: the period is that in cells of one size')
         call check_close(swept(2), uniform(2), 0.06_dp*levels, scheme//', bar: little more energy is lost')
      end do
   end subroutine vibration

   !> Let the bar swing for two periods and a bit.
   subroutine swing(scheme, levels, period, loss)
      character(*), intent(in) :: scheme
      integer, intent(in) :: levels
      real(dp), intent(out) :: period            !! [s]
      real(dp), intent(out) :: loss              !! of energy, relative [-]
      type(problem_t) :: m
      type(forest_t) :: forest
      type(failure_t) :: failure
      real(dp), parameter :: lower(ndim) = [0.2_dp, 0.217_dp], upper(ndim) = [0.8_dp, 0.367_dp], length = upper(1) - lower(1)
      real(dp), parameter :: amplitude = 0.045_dp, pi = acos(-1.0_dp), frequency = pi/(2*length)
      real(dp) :: dt, initial, residual, most_energy, tip, last_tip, first_zero, zero
      integer :: i, step, wrong, zeros, least, most
      forest = forest_t([0.0_dp, 0.0_dp], cell, [12, 6])
      call refine_box(forest, [0.8_dp, 0.0_dp], [1.2_dp, 0.6_dp], levels)
      call place_bodies(forest, new_material('', 'neo_hookean', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t(lower, upper, [12, 3])], m)
      call constrain_box(m%constraints, m%grid, [0.2_dp, 0.0_dp], [0.2_dp, 0.6_dp], [.true., .false.])
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = amplitude*frequency*sin(frequency*(m%particles%reference(i, 1) - lower(1)))
      end do
      m%audit = .true.
      call start(m, scheme)
      initial = total_energy(m)
      call match_particles(m, failure)
      dt = courant*cell/4
      residual = 0
      most_energy = 0
      wrong = 0
      zeros = 0
      last_tip = 0
      first_zero = 0
      zero = 0
      least = m%particles%n
      most = m%particles%n
      do step = 1, nint(2.3_dp*2*pi/frequency/dt)
         call advance(m, dt, failure)
         if (m%cache%sorted) call follow_particles(m, failure)
         if (failure%failed()) exit
         wrong = wrong + misplaced(m)
         least = min(least, m%particles%n)
         most = max(most, m%particles%n)
         most_energy = max(most_energy, total_energy(m))
         residual = max(residual, abs(energy_residual(m, initial)))
         tip = sum(m%particles%mass*m%particles%displacement(:, 1))
         if (last_tip > 0 .and. tip <= 0) then   ! after half a period, and then once more in each
            zeros = zeros + 1
            zero = m%state%time - dt*tip/(tip - last_tip)
            if (zeros == 1) first_zero = zero
            loss = m%energies%numerical_loss/initial
         end if
         last_tip = tip
      end do
      if (failure%failed()) call check(.false., scheme//', bar: '//failure%message)
      call check(zeros == 2, scheme//', bar: it swings')
      period = (zero - first_zero)/max(1, zeros - 1)
      call check(wrong == 0, scheme//', bar: each particle is in one leaf that is not finer than it')
      call check(m%particles%n >= 36 .and. (most > least .eqv. levels > 0), scheme//', bar: the end is split and recombined')
      ! The audit takes the stress work by Gauss's rule: at strains of a tenth its error is above rounding
      call check_close(residual, 0.0_dp, 1.0e-10_dp*initial, scheme//', bar: the energy audit closes')
      call check(most_energy <= initial*1.02_dp, scheme//', bar: no energy arises')
   end subroutine swing

   !> Centre of mass [m].
   pure function centre_of_mass(m) result(x)
      type(problem_t), intent(in) :: m
      real(dp) :: x(ndim)
      integer :: i
      x = 0
      do i = 1, m%particles%n
         x = x + m%particles%mass(i)*m%particles%position(i)
      end do
      x = x/sum(m%particles%mass)
   end function centre_of_mass

   !> Strain energy, and kinetic energy of the motion relative to the rigid one with the same momenta [J].
   real(dp) function internal_energy(m) result(energy)
      type(problem_t), intent(in) :: m
      real(dp) :: centre(ndim), mean(ndim), x(ndim), inertia, spin
      integer :: i
      centre = centre_of_mass(m)
      mean = linear_momentum(m%particles)/sum(m%particles%mass)
      inertia = 0
      spin = 0
      associate (p => m%particles)
         do i = 1, p%n
            x = p%position(i) - centre
            inertia = inertia + p%mass(i)*sum(x**2)
            spin = spin + p%mass(i)*(x(1)*p%velocity(i, 2) - x(2)*p%velocity(i, 1))
         end do
         spin = spin/inertia
         energy = strain_energy(p, m%materials)
         do i = 1, p%n
            x = p%position(i) - centre
            energy = energy + 0.5_dp*p%mass(i)*sum((p%velocity(i, :) - mean - spin*[-x(2), x(1)])**2)
         end do
      end associate
   end function internal_energy

   !> The largest change of the distance of two particles that were about as far apart as the particles were at first, relative to
   !> that distance.
   real(dp) function largest_stretch(m) result(largest)
      type(problem_t), intent(in) :: m
      real(dp) :: distance
      integer :: i, j
      largest = 0
      associate (p => m%particles)
         do i = 1, p%n
            do j = 1, i - 1
               distance = sum((p%reference(i, :) - p%reference(j, :))**2)
               if (distance < 0.04_dp**2 .or. distance > 0.075_dp**2) cycle
               largest = max(largest, abs(sqrt(sum((p%position(i) - p%position(j))**2)/distance) - 1))
            end do
         end do
      end associate
   end function largest_stretch
end program test_crossing_levels
