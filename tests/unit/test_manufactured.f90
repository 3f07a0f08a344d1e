!> Manufactured solutions at large deformation (Kamojjala, Brannon, Sadeghirad & Guilkey 2015): motions that are given, with the body
!> force that makes them solutions. Where particles have domains, displacements in the updated frame have errors that fall with the
!> square of the cell, as those of the total frame do: with material that is stretched and pressed along the axes, where it crosses
!> cells all the time, and with a ring of it that is twisted. Bilinear functions at the places of particles do not reach that.
program test_manufactured
   use hampm_kinds, only: dp, ndim, corners
   use hampm_constraints, only: constrain_box
   use hampm_domains, only: start_domains, reference_corners, follow_corners
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, finish
   use hampm_loads, only: load_on_particles
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps
   use hampm_sorting, only: sort_into_cells
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: young = 1, poisson = 0.3_dp, density = 1
   real(dp), parameter :: mu = young/(2*(1 + poisson)), lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
   real(dp), parameter :: end = 0.5_dp           !! when errors are taken [s]
   real(dp), parameter :: difference = 1e-3_dp   !! of differences, whose error is of order 4 in it
   real(dp) :: courant = 0.1_dp                  !! time step over cell [s/m]
   character(6) :: motion                        !! 'axes' or 'vortex'
   character(4) :: word
   integer :: finer = 1                          !! 2 with the argument 'fine', for cells of half the size
   real(dp) :: amplitude
   real(dp) :: waves = 2                         !! of 'axes': half waves along the body
   real(dp) :: half_width                        !! of the square body [m]

   call get_command_argument(1, word)
   if (word == 'fine') finer = 2
   motion = 'axes'
   half_width = 0.5_dp
   amplitude = 0.1_dp
   call check_order('total', [8, 16], 1.9_dp)
   call check_order('cpdi', [8, 16], 1.8_dp)
   amplitude = 0.3_dp                            ! lines of material of a sixteenth of their length
   waves = 1
   courant = 0.03_dp
   call check_order('cpdi', [8, 16], merge(1.8_dp, 1.5_dp, finer > 1))
   motion = 'vortex'
   half_width = 1.5_dp
   courant = 0.08_dp
   call check_order('cpdi', [12, 24], 1.8_dp)
   amplitude = 0.6_dp
   call check_order('total', [12, 24], 1.6_dp)
   call check_order('cpdi', [12, 24], 1.8_dp)
   call finish()

contains

   !> Place at a time of what began at a place in the reference configuration [m]. Along the axes both directions move for
   !> themselves; a vortex turns a ring around the middle by an angle that depends on the radius.
   pure function place(x, t) result(y)
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: t                  !! [s]
      real(dp) :: y(ndim), radius, s, angle
      if (motion == 'axes') then
         y = x + amplitude*sin(waves*pi*(x + half_width))*[sin(pi*t), sin(pi*t + 2*pi/3)]
      else
         radius = norm2(x)
         s = radius - 1
         angle = 0
         if (abs(s) < 0.5_dp) angle = amplitude*(1 - cos(2*pi*t))/2*(1 - 4*s**2)**4
         y = [cos(angle)*x(1) - sin(angle)*x(2), sin(angle)*x(1) + cos(angle)*x(2)]
      end if
   end function place

   !> Deformation gradient [-].
   pure function deformation(x, t) result(f)
      real(dp), intent(in) :: x(ndim), t
      real(dp) :: f(ndim, ndim), d(ndim)
      integer :: j
      do j = 1, ndim
         d = 0
         d(j) = difference
         f(:, j) = (8*(place(x + d, t) - place(x - d, t)) - (place(x + 2*d, t) - place(x - 2*d, t)))/(12*difference)
      end do
   end function deformation

   !> First Piola stress of the neo-Hookean law in plane strain, mu (F - F^-T) + lambda ln J F^-T [Pa].
   pure function piola(x, t) result(p)
      real(dp), intent(in) :: x(ndim), t
      real(dp) :: p(ndim, ndim), f(ndim, ndim), inverse(ndim, ndim), j
      f = deformation(x, t)
      j = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
      inverse = reshape([f(2, 2), -f(1, 2), -f(2, 1), f(1, 1)], [ndim, ndim])/j    ! F^-T
      p = mu*(f - inverse) + lambda*log(j)*inverse
   end function piola

   !> The body force per mass that the motion needs, its acceleration less div P over the density [m/s2].
   pure function body_force(x, t) result(b)
      real(dp), intent(in) :: x(ndim), t
      real(dp) :: b(ndim), d(ndim), change(ndim, ndim)
      integer :: j
      b = 0
      if (motion == 'vortex' .and. abs(norm2(x) - 1) > 0.5_dp) return
      b = (16*(place(x, t + difference) + place(x, t - difference)) - (place(x, t + 2*difference) + place(x, t - 2*difference)) &
           - 30*place(x, t))/(12*difference**2)
      do j = 1, ndim
         d = 0
         d(j) = difference
         change = (8*(piola(x + d, t) - piola(x - d, t)) - (piola(x + 2*d, t) - piola(x - 2*d, t)))/(12*difference)
         b = b - change(:, j)/density
      end do
   end function body_force

   !> Velocity [m/s].
   pure function velocity(x, t) result(v)
      real(dp), intent(in) :: x(ndim), t
      real(dp) :: v(ndim)
      v = (8*(place(x, t + difference) - place(x, t - difference)) - (place(x, t + 2*difference) - place(x, t - 2*difference))) &
          /(12*difference)
   end function velocity

   !> Check that the error falls with the cell by an order.
   subroutine check_order(way, cells, least)
      character(*), intent(in) :: way            !! 'total', 'cpdi' or 'linear'
      integer, intent(in) :: cells(2)            !! along the body
      real(dp), intent(in) :: least              !! of the order
      real(dp) :: error(2), order
      error = [error_of(way, finer*cells(1)), error_of(way, finer*cells(2))]
      order = log(error(1)/error(2))/log(real(cells(2), dp)/cells(1))
      write (*, '(a, 2es10.2, a, f5.2)') trim(motion)//' '//to_text(amplitude)//' '//way//': errors', error, ', order', order
      call check(order > least, trim(motion)//' '//to_text(amplitude)//' '//way//': order '//to_text(order))
   end subroutine check_order

   !> Root of the mean square of the error of the displacements at the end, over the largest displacement.
   real(dp) function error_of(way, cells) result(error)
      character(*), intent(in) :: way
      integer, intent(in) :: cells
      type(problem_t) :: m
      real(dp) :: cell, square, largest, u(ndim), x(ndim), dt
      integer :: i, k, steps
      cell = 2*half_width/cells
      steps = ceiling(end/(courant*cell))
      dt = end/steps
      call place_body(way, cell, dt, m)
      call start(m, merge('usl ', 'musl', way == 'cpdi'), choice_of('consistent', 'cg'))
      do k = 1, steps
         call push(m)
         call run_steps(m, dt, 1)
      end do
      square = 0
      largest = 0
      do i = 1, m%particles%n
         x = m%particles%reference(i, :)
         u = place(x, m%state%time) - x
         square = square + sum((m%particles%displacement(i, :) - u)**2)/m%particles%n
         largest = max(largest, norm2(u))
      end do
      error = sqrt(square)/largest
   end function error_of

   !> A square of the material in its motion, with edges on which nothing moves across them. Steps kick before they move, so that velocities
   !> are those of half a step before.
   subroutine place_body(way, cell, dt, m)
      character(*), intent(in) :: way
      real(dp), intent(in) :: cell, dt           !! [m], [s]
      type(problem_t), intent(out) :: m
      type(failure_t) :: failure
      real(dp) :: x(ndim), origin(ndim, corners), lower(ndim), upper(ndim)
      integer :: i, c, n
      lower = -half_width
      upper = half_width
      n = nint(2*half_width/cell)
      call place_bodies(forest_t(lower, cell, [n, n]), new_material('', 'neo_hookean', .false., young, poisson, density), &
                        [rectangle_t(lower, upper, [2*n, 2*n])], m)
      m%particles%total_frame = way == 'total'
      call constrain_box(m%constraints, m%grid, lower, [lower(1), upper(2)], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [upper(1), lower(2)], upper, [.true., .false.])
      call constrain_box(m%constraints, m%grid, lower, [upper(1), lower(2)], [.false., .true.])
      call constrain_box(m%constraints, m%grid, [lower(1), upper(2)], upper, [.false., .true.])
      do i = 1, m%particles%n
         x = m%particles%reference(i, :)
         m%particles%displacement(i, :) = place(x, 0.0_dp) - x
         m%particles%gradient(i, :, :) = deformation(x, 0.0_dp) - reshape([1, 0, 0, 1], [ndim, ndim])
         m%particles%velocity(i, :) = velocity(x, -dt/2)
      end do
      if (way == 'cpdi') then
         call start_domains(m%particles)
         do i = 1, m%particles%n
            origin = reference_corners(m%particles, i)
            do c = 1, corners
               x = origin(:, c)
               m%particles%corner_displacement(i, :, c) = place(x, 0.0_dp) - x
               m%particles%corner_velocity(i, :, c) = velocity(x, -dt/2)
            end do
            call follow_corners(m%particles, i)
         end do
      end if
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call check(.not. failure%failed(), 'the body is in the grid')
      allocate (m%loads(ndim))
      do i = 1, ndim
         call load_on_particles(m%particles, lower, upper, m%loads(i))
         m%loads(i)%force(i) = 1
      end do
   end subroutine place_body

   !> Let the loads be the body force at the present time.
   subroutine push(m)
      type(problem_t), intent(inout) :: m
      real(dp) :: b(ndim)
      integer :: i, k
      do k = 1, size(m%loads(1)%particle)
         i = m%loads(1)%particle(k)
         b = body_force(m%particles%reference(i, :), m%state%time)
         m%loads(1)%fraction(k) = m%particles%mass(i)*b(1)
         i = m%loads(2)%particle(k)
         if (i /= m%loads(1)%particle(k)) b = body_force(m%particles%reference(i, :), m%state%time)
         m%loads(2)%fraction(k) = m%particles%mass(i)*b(2)
      end do
   end subroutine push
end program test_manufactured
