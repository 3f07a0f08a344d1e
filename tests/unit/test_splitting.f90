!> What splitting particles and recombining them keeps, in a body that is deformed, rotates and moves.
program test_splitting
   use hampm_kinds, only: dp, ndim, corners
   use hampm_energy, only: kinetic_energy, strain_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, corner_offset
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t, add_history, spacing_of
   use hampm_samples, only: rectangle_t, place_bodies
   use hampm_splitting, only: start_families, split, recombine
   use hampm_children, only: times_split
   use hampm_tensors, only: identity
   implicit none

   real(dp), parameter :: lower(ndim) = [0.13_dp, 0.21_dp], upper(ndim) = [0.73_dp, 0.51_dp]
   integer, parameter :: points(ndim) = [6, 5]       ! 0.1 m by 0.06 m each
   real(dp), parameter :: stretch(ndim, ndim) = reshape([0.4_dp, 0.3_dp, -0.5_dp, -0.2_dp], [ndim, ndim])   ! of the body
   real(dp), parameter :: shift(ndim) = [0.3_dp, -0.1_dp]
   real(dp), parameter :: drift(ndim) = [2.0_dp, -1.0_dp]
   real(dp), parameter :: rate(ndim, ndim) = reshape([0.4_dp, 3.1_dp, -2.9_dp, -0.3_dp], [ndim, ndim])      ! mostly spin
   real(dp), parameter :: rounding = 1.0e-14_dp
   type(forest_t), parameter :: coarse = forest_t([-2.0_dp, -2.0_dp], 1.0_dp, [6, 6])
   type(material_t) :: neo_hookean, linear

   call repeat_random_numbers()
   neo_hookean = new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.3_dp)
   linear = new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.3_dp)
   call split_keeps('all', .false.)
   call split_keeps('some', .false.)
   call split_keeps('some', .true.)
   call children_fill_the_body()
   call angular_momentum_to_second_order()
   call recombined_is_the_parent(.false.)
   call recombined_is_the_parent(.true.)
   call recombined_is_the_mean()
   call incomplete_families_stay()
   call torn_families_stay()
   call many_cycles()
   call halves_become_quarters()
   call finish()

contains

   !> A body with the fields u = shift + stretch X and v = drift + rate x, and random disturbances of H and v of a given size.
   subroutine place(points, disturbance, p)
      integer, intent(in) :: points(ndim)
      real(dp), intent(in) :: disturbance
      type(particles_t), intent(out) :: p
      type(problem_t) :: m
      real(dp) :: h(ndim, ndim), v(ndim)
      integer :: i
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [2, 2]), neo_hookean, [rectangle_t(lower, upper, points)], m)
      p = m%particles
      do i = 1, p%n
         call random_number(h)
         call random_number(v)
         p%displacement(i, :) = shift + matmul(stretch, p%reference(i, :))
         p%gradient(i, :, :) = stretch + disturbance*(h - 0.5_dp)
         p%velocity(i, :) = drift + matmul(rate, p%position(i)) + disturbance*(v - 0.5_dp)
      end do
      call start_families(p)
   end subroutine place

   !> Split the marked particles with the velocity gradient `rate`.
   subroutine split_marked(p, marked, first_child)
      type(particles_t), intent(inout) :: p
      logical, intent(in) :: marked(:)
      integer, allocatable, intent(out), optional :: first_child(:)
      integer, allocatable :: first(:)
      type(failure_t) :: failure
      call split(p, marked, spread(rate, 3, count(marked)), spread(spread([0.0_dp, 0.0_dp], 2, 1), 3, count(marked)), &
                 spread([0.0_dp, 0.0_dp], 2, count(marked)), first, failure)
      if (present(first_child)) call move_alloc(first, first_child)
   end subroutine split_marked

   !> Beside a crack along the diagonals of particles it does not matter whether these are halved first or split into quarters: mass, places and
   !> fields are the same. Beside one in any direction through the middle the halves become the quarters on their side, and linear momentum stays.
   subroutine halves_become_quarters()
      type(particles_t) :: p, q
      real(dp), parameter :: spacing(ndim) = [0.1_dp, 0.06_dp]
      real(dp), parameter :: diagonal(ndim) = [-spacing(2), spacing(1)], slanted(ndim) = [-0.3_dp, 0.8_dp]
      real(dp) :: nearest
      integer :: i, j
      call place(points, 0.0_dp, p)
      q = p
      call split_beside(p, spread(.true., 1, p%n), diagonal)
      call check(all([(times_split(p, i) == 0, i=1, p%n)]), 'halves are as coarse as whole particles')
      call split_beside(p, spread(.true., 1, p%n), diagonal)
      call split_beside(q, spread(.true., 1, q%n), [0.0_dp, 0.0_dp])
      call split_beside(q, q%path == 0 .or. q%path == 3, diagonal)
      call check(p%n == 6*product(points) .and. q%n == p%n, 'diagonal: two whole quarters and two halves of two')
      nearest = 0
      do i = 1, p%n
         j = minloc(sum((q%reference - spread(p%reference(i, :), 1, q%n))**2, dim=2), dim=1)
         nearest = max(nearest, maxval(abs(q%reference(j, :) - p%reference(i, :))), abs(q%mass(j) - p%mass(i)), &
                       maxval(abs(q%displacement(j, :) - p%displacement(i, :))), maxval(abs(q%velocity(j, :) - p%velocity(i, :))), &
                       real(abs(q%level(j) - p%level(i)), dp), real(abs(q%path(j)/corners - p%path(i)/corners), dp))
      end do
      call check_close(nearest, 0.0_dp, rounding, 'halves that are split, and quarters that are halved')
      call place(points, 0.2_dp, p)
      q = p
      call split_beside(q, spread(.true., 1, q%n), slanted)
      call split_beside(q, spread(.true., 1, q%n), slanted)
      call check(q%n == 4*p%n .and. all(q%level == 1), 'slanted: the quarters on each side')
      call check_close(norm2(linear_momentum(q) - linear_momentum(p)), 0.0_dp, rounding*norm2(linear_momentum(p)), &
                       'slanted: linear momentum')
      call check(maxval(abs(q%mass - p%mass(1)/4)) <= rounding*p%mass(1), 'slanted: a quarter of the mass each')
   end subroutine halves_become_quarters

   !> Split the marked particles with the velocity gradient `rate`, beside cracks of a normal through their middles; 0 for none.
   subroutine split_beside(p, marked, normal)
      type(particles_t), intent(inout) :: p
      logical, intent(in) :: marked(:)
      real(dp), intent(in) :: normal(ndim)
      integer, allocatable :: first(:)
      type(failure_t) :: failure
      integer :: n
      n = count(marked)
      call split(p, marked, spread(rate, 3, n), spread(spread([0.0_dp, 0.0_dp], 2, 1), 3, n), spread(normal, 2, n), first, failure)
   end subroutine split_beside

   !> Split all particles some times.
   subroutine split_all(p, times)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: times
      integer :: k
      do k = 1, times
         call split_marked(p, spread(.true., 1, p%n))
      end do
   end subroutine split_all

   !> Recombine all that can be, and return how many families were.
   integer function recombine_all(p) result(families)
      type(particles_t), intent(inout) :: p
      integer, allocatable :: new_number(:)
      integer :: found
      type(failure_t) :: failure
      families = 0
      do
         call recombine(p, spread(.true., 1, p%n), coarse, found, new_number, failure)
         if (found == 0) return
         families = families + found
      end do
   end function recombine_all

   !> First moment of the mass: sum of m x, of present or reference positions.
   pure function first_moment(p, in_reference) result(moment)
      type(particles_t), intent(in) :: p
      logical, intent(in) :: in_reference
      real(dp) :: moment(ndim)
      integer :: i
      moment = 0
      do i = 1, p%n
         if (in_reference) then
            moment = moment + p%mass(i)*p%reference(i, :)
         else
            moment = moment + p%mass(i)*p%position(i)
         end if
      end do
   end function first_moment

   !> Angular momentum about the origin [kg m2/s].
   pure real(dp) function angular_momentum(p) result(l)
      type(particles_t), intent(in) :: p
      integer :: i
      real(dp) :: x(ndim)
      l = 0
      do i = 1, p%n
         x = p%position(i)
         l = l + p%mass(i)*(x(1)*p%velocity(i, 2) - x(2)*p%velocity(i, 1))
      end do
   end function angular_momentum

   !> Relative difference of the sums over two sets of particles.
   subroutine check_sums(p, q, tolerance, what)
      type(particles_t), intent(in) :: p, q
      real(dp), intent(in) :: tolerance
      character(*), intent(in) :: what
      call check_close(sum(q%mass), sum(p%mass), tolerance*sum(p%mass), what//': mass')
      call check_close(sum(q%volume), sum(p%volume), tolerance*sum(p%volume), what//': volume')
      call check_close(norm2(linear_momentum(q) - linear_momentum(p)), 0.0_dp, tolerance*norm2(linear_momentum(p)), &
                       what//': linear momentum')
      call check_close(norm2(first_moment(q, .false.) - first_moment(p, .false.)), 0.0_dp, tolerance*sum(p%mass), &
                       what//': centre of mass')
      call check_close(norm2(first_moment(q, .true.) - first_moment(p, .true.)), 0.0_dp, tolerance*sum(p%mass), &
                       what//': centre of mass in the reference configuration')
      call check_close(strain_energy(q, [neo_hookean]), strain_energy(p, [neo_hookean]), &
                       tolerance*strain_energy(p, [neo_hookean]), what//': strain energy')
   end subroutine check_sums

   !> Splitting keeps the sums, and particle by particle places the children in the parent's rectangle and its linear fields. What
   !> is not split stays as it is.
   subroutine split_keeps(which, total_frame)
      character(*), intent(in) :: which          !! 'all' or 'some' particles
      logical, intent(in) :: total_frame
      type(particles_t) :: p, q
      real(dp) :: chance(product(points)), dx(ndim), moved(ndim), error(4)
      logical :: marked(product(points)), exact
      integer, allocatable :: first_child(:)
      integer :: i, c, j
      call place(points, 0.2_dp, p)
      p%total_frame = total_frame
      call random_number(chance)
      marked = which == 'all' .or. chance < 0.4_dp
      q = p
      call split_marked(q, marked, first_child)
      call check(q%n == p%n + 3*count(marked) .and. size(q%mass) == q%n, which//' split: number of particles')
      call check_sums(p, q, rounding, which//' split')
      exact = .true.
      error = 0
      do i = 1, p%n
         if (.not. marked(i)) then
            j = first_child(i)
            exact = exact .and. all(abs(q%reference(j, :) - p%reference(i, :)) <= 0) .and. &
                    all(abs(q%displacement(j, :) - p%displacement(i, :)) <= 0) .and. &
                    all(abs(q%velocity(j, :) - p%velocity(i, :)) <= 0) .and. &
                    abs(q%mass(j) - p%mass(i)) <= 0 .and. q%level(j) == 0 .and. q%id(j) == p%id(i)
            cycle
         end if
         exact = exact .and. abs(sum(q%mass(first_child(i):first_child(i) + 3)) - p%mass(i)) <= 0 .and. &
                 abs(sum(q%volume(first_child(i):first_child(i) + 3)) - p%volume(i)) <= 0
         do c = 1, corners
            j = first_child(i) + c - 1
            dx = (corner_offset(c) - 0.5_dp)*[0.05_dp, 0.03_dp]
            moved = dx
            if (.not. total_frame) moved = dx + matmul(p%gradient(i, :, :), dx)
            error(1) = max(error(1), maxval(abs(q%reference(j, :) - (p%reference(i, :) + dx))))
            error(2) = max(error(2), maxval(abs(q%displacement(j, :) - (p%displacement(i, :) &
                                                                         + matmul(p%gradient(i, :, :), dx)))))
            error(3) = max(error(3), maxval(abs(q%velocity(j, :) - (p%velocity(i, :) + matmul(rate, moved)))))
            error(4) = max(error(4), maxval(abs(q%gradient(j, :, :) - p%gradient(i, :, :))))
            exact = exact .and. q%id(j) == p%id(i) .and. q%level(j) == 1 .and. q%body(j) == p%body(i)
         end do
      end do
      call check(exact, which//' split: mass and volume of each particle exactly, and all of those that stay')
      call check_close(error(1), 0.0_dp, rounding, which//' split: children stand at X +- s/4')
      call check_close(error(2), 0.0_dp, rounding, which//' split: in the displacement field u + H dX')
      call check_close(error(3), 0.0_dp, rounding, which//' split: and move by v + L dx')
      call check_close(error(4), 0.0_dp, 0.0_dp, which//' split: with the parent''s H')
   end subroutine split_keeps

   !> Split three times, a body is that which is filled eight times as finely, in both directions: each of its particles is there
   !> once, in the same linear displacement and velocity fields.
   subroutine children_fill_the_body()
      type(particles_t) :: p, fine
      integer, parameter :: times = 3, many = product(points)*corners**times
      real(dp) :: spacing(ndim), error(4)
      integer :: i, k, place_of(ndim), visits(many)
      call place(points, 0.0_dp, p)
      call place(points*2**times, 0.0_dp, fine)
      call split_all(p, times)
      call check(p%n == many .and. fine%n == many .and. all(p%level == times), 'three times split: number of particles')
      spacing = (upper - lower)/(points*2**times)
      visits = 0
      error = 0
      do i = 1, p%n
         place_of = int((p%reference(i, :) - lower)/spacing)
         k = 1 + place_of(1) + place_of(2)*points(1)*2**times
         visits(k) = visits(k) + 1
         error(1) = max(error(1), maxval(abs(p%reference(i, :) - (lower + (place_of + 0.5_dp)*spacing))))
         error(2) = max(error(2), maxval(abs(p%displacement(i, :) - (shift + matmul(stretch, p%reference(i, :))))))
         error(3) = max(error(3), maxval(abs(p%velocity(i, :) - (drift + matmul(rate, p%position(i))))))
         error(4) = max(error(4), maxval(abs(spacing_of(p, i) - spacing)))
      end do
      call check(all(visits == 1), 'three times split: one particle in each part of the body')
      call check_close(maxval(error), 0.0_dp, rounding, 'three times split: places, displacement and velocity field, spacing')
      call check_sums(fine, p, 1.0e-13_dp, 'three times split, against a finer filling')
      call check_close(angular_momentum(p), angular_momentum(fine), 1.0e-13_dp*abs(angular_momentum(fine)), &
                       'three times split, against a finer filling: angular momentum')
   end subroutine children_fill_the_body

   !> The angular momentum that a split adds, that of the children about their parent, falls with the square of the spacing. It is
   !> the sum of m d x L d over d = F (+- s/4).
   subroutine angular_momentum_to_second_order()
      type(particles_t) :: p, q
      integer, parameter :: refinements = 4
      real(dp) :: change(refinements), theory(refinements), spacing(ndim), second(ndim, ndim), f(ndim, ndim), turned(ndim, ndim)
      integer :: k, d
      f = identity + stretch
      do k = 1, refinements
         call place(points*2**(k - 1), 0.0_dp, p)
         q = p
         call split_all(q, 1)
         change(k) = (angular_momentum(q) - angular_momentum(p))/angular_momentum(p)
         spacing = (upper - lower)/(points*2**(k - 1))
         second = 0
         do d = 1, ndim
            second(d, d) = (spacing(d)/4)**2
         end do
         turned = matmul(rate, matmul(f, matmul(second, transpose(f))))          ! mean of L d (d transposed)
         theory(k) = sum(p%mass)*(turned(2, 1) - turned(1, 2))/angular_momentum(p)
      end do
      write (*, '(a,*(es10.2))') 'angular momentum that a split adds, relative, spacing halved each time:', change
      write (*, '(a,*(f8.4))') 'observed order:', log(change(:refinements - 1)/change(2:))/log(2.0_dp)
      call check_close(maxval(abs(change - theory)), 0.0_dp, 1.0e-13_dp, 'a split adds the angular momentum about the parents')
      call check_close(log(change(refinements - 1)/change(refinements))/log(2.0_dp), 2.0_dp, 0.02_dp, &
                       'angular momentum is kept to second order')
   end subroutine angular_momentum_to_second_order

   !> What nothing has happened to since it was split becomes its parent again, at every level and also where only some were split.
   subroutine recombined_is_the_parent(deeper)
      logical, intent(in) :: deeper              !! whether some children are split again
      type(particles_t) :: p, q
      integer :: families
      call place(points, 0.2_dp, p)
      q = p
      call split_all(q, 1)
      families = p%n
      if (deeper) then
         call split_marked(q, [(mod(families, 3) < 2, families=1, q%n)])
         families = p%n + count([(mod(families, 3) < 2, families=1, 4*p%n)])
         call split_marked(q, q%level == 2 .and. q%path == 7)
         families = families + count(q%level == 3)/corners
         call check(count(q%level == 3) > 0, 'there are particles of three levels')
      end if
      call check(recombine_all(q) == families, 'all families recombine')
      call check(q%n == p%n .and. all(q%id == p%id) .and. all(q%level == 0) .and. all(q%path == 0), &
                 'as many particles as before, in the same order')
      call check(all(abs(q%mass - p%mass) <= 0) .and. all(abs(q%volume - p%volume) <= 0), &
                 'each has the mass and the volume of the parent exactly')
      call check_close(maxval(abs(q%reference - p%reference)), 0.0_dp, 1.0e-15_dp, 'recombined: X of the parent')
      call check_close(maxval(abs(q%displacement - p%displacement)), 0.0_dp, 1.0e-15_dp, 'recombined: u of the parent')
      call check_close(maxval(abs(q%velocity - p%velocity)), 0.0_dp, 1.0e-14_dp, 'recombined: v of the parent')
      call check_close(maxval(abs(q%gradient - p%gradient)), 0.0_dp, 1.0e-15_dp, 'recombined: H of the parent')
   end subroutine recombined_is_the_parent

   !> Whatever the siblings did, recombining keeps mass, momentum and the volume-weighted H, and takes the kinetic energy of their
   !> motion and (linear law, of which the energy is a square) the strain energy of their H relative to the mean.
   subroutine recombined_is_the_mean()
      type(particles_t) :: p, q
      real(dp) :: mean(ndim), mean_h(ndim, ndim), kinetic_loss, strain_loss, noise(ndim), noise_h(ndim, ndim)
      real(dp) :: h(ndim, ndim), h_before(ndim, ndim)
      integer :: i, c
      call place(points, 0.2_dp, p)
      call split_all(p, 1)
      call add_history(p, 2)
      call random_number(p%history)
      kinetic_loss = 0
      strain_loss = 0
      do i = 1, p%n
         call random_number(noise)
         p%displacement(i, :) = p%displacement(i, :) + 0.02_dp*(noise - 0.5_dp)
         call random_number(noise)
         p%velocity(i, :) = p%velocity(i, :) + (noise - 0.5_dp)
         call random_number(noise_h)
         p%gradient(i, :, :) = p%gradient(i, :, :) + 0.3_dp*(noise_h - 0.5_dp)
      end do
      do i = 1, p%n, corners
         mean = sum(p%velocity(i:i + 3, :), dim=1)/corners
         mean_h = sum(p%gradient(i:i + 3, :, :), dim=1)/corners
         do c = i, i + 3
            kinetic_loss = kinetic_loss + 0.5_dp*p%mass(c)*sum((p%velocity(c, :) - mean)**2)
            strain_loss = strain_loss + p%volume(c)*linear%energy_density(p%gradient(c, :, :) - mean_h)
         end do
      end do
      q = p
      call check(recombine_all(q) == p%n/corners, 'disturbed families recombine')
      h = 0
      h_before = 0
      do i = 1, q%n
         h = h + q%volume(i)*q%gradient(i, :, :)
      end do
      do i = 1, p%n
         h_before = h_before + p%volume(i)*p%gradient(i, :, :)
      end do
      call check_close(maxval(abs(h - h_before)), 0.0_dp, rounding*sum(p%volume), 'recombining keeps the volume-weighted H')
      call check_close(maxval(abs(matmul(q%volume, q%history) - matmul(p%volume, p%history))), 0.0_dp, rounding*sum(p%volume), &
                       'recombining keeps the means over the volume of what laws remember')
      call check_close(sum(q%mass), sum(p%mass), rounding*sum(p%mass), 'recombining keeps the mass')
      call check_close(sum(q%volume), sum(p%volume), rounding*sum(p%volume), 'recombining keeps the volume')
      call check_close(norm2(linear_momentum(q) - linear_momentum(p)), 0.0_dp, rounding*norm2(linear_momentum(p)), &
                       'recombining keeps the momentum')
      call check_close(norm2(first_moment(q, .false.) - first_moment(p, .false.)), 0.0_dp, rounding*sum(p%mass), &
                       'recombining keeps the centre of mass')
      call check_close(kinetic_energy(p) - kinetic_energy(q), kinetic_loss, 1.0e-13_dp*kinetic_energy(p), &
                       'recombining takes the kinetic energy of the motion relative to the mean')
      call check_close(strain_energy(p, [linear]) - strain_energy(q, [linear]), strain_loss, &
                       1.0e-13_dp*strain_energy(p, [linear]), 'and the strain energy of H relative to its mean')
      call check(kinetic_loss > 0 .and. strain_loss > 0, 'which there is')
   end subroutine recombined_is_the_mean

   !> Families of which a member is not marked, or is split itself, stay; the others recombine.
   subroutine incomplete_families_stay()
      type(particles_t) :: p, q
      logical :: marked(4*product(points))
      integer :: families
      integer, allocatable :: new_number(:)
      type(failure_t) :: failure
      call place(points, 0.2_dp, p)
      call split_all(p, 1)
      marked = .true.
      marked(1::4) = .false.                     ! the first child of each
      q = p
      call recombine(q, marked, coarse, families, new_number, failure)
      call check(families == 0 .and. same(p, q), 'families without one member stay as they are')
      marked(1) = .true.
      call recombine(q, marked, coarse, families, new_number, failure)
      call check(families == 1 .and. q%n == p%n - 3 .and. q%level(1) == 0 .and. all(q%level(2:) == 1), &
                 'and only the complete one recombines')
      call check(all(new_number(:4) == 1) .and. all([(new_number(families) == families - 3, families=5, p%n)]), &
                 'and where each particle is now is known')
      q = p
      call split_marked(q, [.true., spread(.false., 1, q%n - 1)])
      call recombine(q, q%level == 1, coarse, families, new_number, failure)
      call check(families == product(points) - 1, 'the family of a member that was split stays until that is whole')
      call check(recombine_all(q) == 2 .and. q%n == product(points), 'and then recombines too')
   end subroutine incomplete_families_stay

   !> A family of which a member has gone away stays, the others recombine; when it is back, it recombines as well.
   subroutine torn_families_stay()
      type(particles_t) :: p
      integer, parameter :: torn = 22
      real(dp), parameter :: away(ndim) = [0.0_dp, 0.5_dp]
      call place(points, 0.0_dp, p)
      call split_all(p, 1)
      p%displacement(torn, :) = p%displacement(torn, :) + away
      call check(recombine_all(p) == product(points) - 1, 'all but the torn family recombine')
      call check(p%n == product(points) + 3 .and. count(p%level == 1) == 4 .and. all(p%id == 6 .eqv. p%level == 1), &
                 'and the torn one stays')
      where (p%level == 1 .and. p%path == mod(torn - 1, 4)) p%displacement(:, 2) = p%displacement(:, 2) - away(2)
      call check(recombine_all(p) == 1 .and. p%n == product(points), 'until it is together again')
   end subroutine torn_families_stay

   !> Whether two sets of particles are the same.
   pure logical function same(p, q)
      type(particles_t), intent(in) :: p, q
      same = p%n == q%n
      if (same) same = all(abs(p%mass - q%mass) <= 0) .and. all(abs(p%reference - q%reference) <= 0) .and. &
                       all(abs(p%displacement - q%displacement) <= 0) .and. all(abs(p%velocity - q%velocity) <= 0) .and. &
                       all(abs(p%gradient - q%gradient) <= 0) .and. all(p%path == q%path) .and. all(p%level == q%level)
   end function same

   !> Rounding does not add up over ten thousand cycles, of one level and now and then of two.
   subroutine many_cycles()
      type(particles_t) :: p, q
      integer, parameter :: cycles = 10000
      integer :: k
      real(dp) :: drift_of(4)
      call place([2, 2], 0.2_dp, p)
      q = p
      do k = 1, cycles
         call split_all(q, merge(2, 1, mod(k, 10) == 0))
         if (recombine_all(q) == 0) exit
      end do
      call check(q%n == p%n, 'many cycles: as many particles as before')
      call check(all(abs(q%mass - p%mass) <= 0) .and. all(abs(q%volume - p%volume) <= 0), &
                 'many cycles: mass and volume of each particle exactly')
      drift_of(1) = maxval(abs(q%reference - p%reference))/maxval(abs(p%reference))
      drift_of(2) = maxval(abs(q%displacement - p%displacement))/maxval(abs(p%displacement))
      drift_of(3) = maxval(abs(q%velocity - p%velocity))/maxval(abs(p%velocity))
      drift_of(4) = maxval(abs(q%gradient - p%gradient))/maxval(abs(p%gradient))
      write (*, '(a,i0,a,4es9.1)') 'after ', cycles, ' cycles: relative drift of X, u, v, H', drift_of
      call check_close(maxval(drift_of), 0.0_dp, 1.0e-12_dp, 'many cycles: X, u, v and H')
      call check_sums(p, q, 1.0e-12_dp, 'many cycles')
   end subroutine many_cycles
end program test_splitting
