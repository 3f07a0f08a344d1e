!> The full mass matrix of quadratic cells that edges and cracks cut, with cells of several sizes: a velocity that is quadratic in the
!> coordinates comes back from the momentum of its particles at all nodes, however little of a cell is left, and with it linear momentum and
!> energy. So its condition is that of whole cells, and the masses of interface points have no part of such a motion. Bodies weigh what their areas do, though pieces may hold no particle.
program test_cut_mass
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: kinetic_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_reading, only: understand_model
   use hampm_model, only: model_t
   use hampm_samples, only: nodal_velocity
   use hampm_simulation, only: simulation_t, build
   use hampm_text, only: string_t, to_text
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp) :: worst(4)
   integer :: k

   call repeat_random_numbers()
   call use_threads(1, 0)
   worst = 0
   do k = 1, 60
      call look_at_body(k)
   end do
   call check(worst(1) < 1e-9_dp, 'nodes have a quadratic velocity, but for '//to_text(worst(1)))
   call check(worst(2) < 1e-12_dp, 'momentum of the nodes is that of the particles, but for '//to_text(worst(2)))
   call check(worst(3) < 1e-12_dp, 'and energy is, but for '//to_text(worst(3)))
   call check(worst(4) < 1e-9_dp, 'bodies weigh what their areas do, but for '//to_text(worst(4)))
   call finish()

contains

   !> A turned rectangle, a disc or a square with a crack somewhere in its cells, in quadratic motion.
   subroutine look_at_body(number)
      integer, intent(in) :: number
      type(string_t) :: overrides(0)
      type(model_t) :: model
      type(simulation_t) :: s
      type(failure_t) :: failure
      real(dp), allocatable :: mass(:), velocity(:, :), momentum(:, :)
      real(dp) :: factor(ndim, 6), x(ndim), largest
      character(:), allocatable :: text
      real(dp) :: area
      integer :: i
      call describe_scene(number, text, area)
      call understand_model('test_cut_mass', text, overrides, model, failure)
      if (.not. failure%failed()) call build(model, 1, s, failure)
      call check(.not. failure%failed(), 'scene '//to_text(number)//' is built')
      if (failure%failed()) return
      call random_number(factor)
      factor = factor - 0.5_dp
      associate (m => s%problem)
         worst(4) = max(worst(4), abs(sum(m%particles%mass(:m%particles%n))/area - 1))
         do i = 1, m%particles%n
            x = m%particles%reference(i, :)
            m%particles%velocity(i, :) = field(factor, x)
         end do
         m%cache%mapped = .false.
         velocity = nodal_velocity(m)
         largest = maxval(abs(velocity))
         associate (all => m%fields%mass_matrix%all)
            do i = 1, all%n_nodes
               x = m%grid%node_position(:, all%nodes(i))
               worst(1) = max(worst(1), maxval(abs(velocity(:, all%nodes(i)) - field(factor, x)))/largest)
            end do
         end associate
         allocate (momentum, mold=velocity)
         call find_concentrated_mass(m%grid, m%fields%mass_matrix, mass)
         call multiply_by_mass(m%grid, m%fields%mass_matrix, mass, velocity, momentum)
         worst(2) = max(worst(2), norm2(sum(momentum, dim=2) - linear_momentum(m%particles)) &
                        /sum(m%particles%mass(:m%particles%n)*norm2(m%particles%velocity(:m%particles%n, :), dim=2)))
         worst(3) = max(worst(3), abs(sum(momentum*velocity)/2/kinetic_energy(m%particles) - 1))
      end associate
   end subroutine look_at_body

   !> A velocity that is quadratic in the coordinates.
   pure function field(factor, x) result(v)
      real(dp), intent(in) :: factor(ndim, 6), x(ndim)
      real(dp) :: v(ndim)
      v = matmul(factor, [1.0_dp, x(1), x(2), x(1)**2, x(1)*x(2), x(2)**2])
   end function field

   !> A model in cells of 1 m.
   subroutine describe_scene(number, text, area)
      integer, intent(in) :: number
      character(:), allocatable, intent(out) :: text
      real(dp), intent(out) :: area              !! of its body [m2]
      character(300) :: body
      real(dp) :: r(4), e(ndim), corner(ndim, 4)
      call random_number(r)
      e = [cos(pi*r(1)), sin(pi*r(1))]
      select case (mod(number, 4))
      case (0)
         corner = 3*reshape([-e(1) + e(2), -e(2) - e(1), e(1) + e(2), e(2) - e(1), e(1) - e(2), e(2) + e(1), &
                             -e(1) - e(2), -e(2) + e(1)], [ndim, 4]) + spread(r(3:4), 2, 4)
         write (body, '(a, 7(es23.15, '',''), es23.15)') 'shape = ''polygon'' points_per_cell = 3 points = ', corner
         area = 36
      case (1)
         write (body, '(a, 2(es23.15, '',''), a, es23.15)') 'shape = ''circle'' points_per_cell = 4 center = ', r(2:3), &
            ' radius = ', 3 + r(4)
         area = pi*(3 + r(4))**2
      case default
         corner(:, 1) = r(3:4) - 2*e
         corner(:, 2) = r(3:4) + 2*e
         write (body, '(a, 3(es23.15, '',''), es23.15)') 'lower = -6, -6 upper = 6, 6 points_per_cell = 3 /'//new_line('a')// &
            '&refine indicator = ''tip'' rings = 2 max_level = '//to_text(mod(number, 4) - 1)//' /'//new_line('a')// &
            '&crack kind = ''path'' points = ', corner(:, :2)
         area = 144
      end select
      text = '&run plane = ''strain'' end_time = 1.0 /'//new_line('a')// &
             '&grid order = 2 lower = -8, -8 cell = 1.0 cells = 16, 16 /'//new_line('a')// &
             '&material name = ''m'' young = 1.0 poisson = 0.3 density = 1.0 /'//new_line('a')// &
             '&method frame = ''total'' mass = ''consistent'' time = ''implicit'' time_step = 0.1 /'//new_line('a')// &
             '&body material = ''m'' '//trim(body)//' /'//new_line('a')
   end subroutine describe_scene
end program test_cut_mass
