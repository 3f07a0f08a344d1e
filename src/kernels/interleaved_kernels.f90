!> What a pass does with interleaved particles (`hampm_interleaved`): all of it in one loop over the rows of a block, so that a
!> particle is loaded and stored once. In a row the lanes stand side by side, one column after the other: a block is one piece of
!> memory. What is summed over the particles of a cell stays in registers.
!>
!> The loop stands here once, with switches for what a pass may do. A pass that a scheme has calls it with constants, of which the
!> compiler makes a loop without switches; any other pass calls it as it is, and takes longer.
module hampm_interleaved_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: edge_margin
   use hampm_cell_blocks, only: lanes, of_mass, of_momentum, of_force, n_sums
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: pass_over_rows, most_blocks, largest_rounding, of_offset, of_displacement, of_velocity, of_gradient, of_weight, &
             of_lambda, of_mu, n_columns, n_constants

   integer, parameter :: most_blocks = 16        !! of a batch

   !> A place is outside its cell where its local coordinate is outside [0, 1] by more than this, which is rounding.
   real(dp), parameter :: largest_rounding = 4*edge_margin

   !> Makes 1 of min(1, large x) for all masses and differences of local coordinates x above 0: a comparison would part the lanes, and
   !> not every processor has vectors for that
   real(dp), parameter :: large = 1.0e60_dp

   ! Columns of a row
   integer, parameter :: of_offset = 1           !! X - lower corner of the cell [m], the first component
   integer, parameter :: of_displacement = 3     !! u [m], the first component
   integer, parameter :: of_velocity = 5         !! v [m/s], the first component
   integer, parameter :: of_gradient = 7         !! H as 11, 21, 12, 22 [-], the first of them
   integer, parameter :: n_columns = 10
   ! What does not change
   integer, parameter :: of_weight = 1           !! mass [kg], 0 in a place without a particle
   integer, parameter :: of_lambda = 2           !! volume times lambda of the law [J]
   integer, parameter :: of_mu = 3               !! volume times mu [J]
   integer, parameter :: n_constants = 3

   ! What a pass may do
   integer, parameter :: kicks = 1, strains = 2, moves = 4, maps_mass = 8, maps_momentum = 16, maps_force = 32

contains

   !> Do a pass over the rows of a batch of blocks, which have equal numbers of them. What does not change of the particles of all rows
   !> may be one row. The nodal fields come as polynomials a1 + a2 xi + a3 eta + a4 xi eta: that of the kick [m/s], of the strain [-], and
   !> of the move [m]. What cells add to the nodes is kept by block.
   pure subroutine pass_over_rows(pass, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, rows_of_c, c, p, &
                                  contribution, beyond)
      type(pass_t), intent(in) :: pass
      integer, intent(in) :: n                   !! blocks
      integer, intent(in) :: rows                !! of each
      integer, intent(in) :: room                !! rows for which each has room
      real(dp), intent(in) :: inverse_size       !! 1 / edge length of the cells [1/m]
      real(dp), intent(in) :: zeros(lanes)
      real(dp), dimension(lanes, corners, ndim, n), intent(in) :: kick_by, strain_by, move_by
      integer, intent(in) :: rows_of_c           !! `room` or 1
      real(dp), intent(in) :: c(lanes, n_constants, rows_of_c, n)
      real(dp), intent(inout) :: p(lanes, n_columns, room, n)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      real(dp), intent(inout) :: beyond(lanes, n) !! sums of how far places are outside their cells [cells]
      select case (tasks_of(pass))
      case (strains + maps_force)
         call loop(strains + maps_force, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, rows_of_c, c, p, &
                   contribution, beyond)
      case (kicks + moves + maps_mass + maps_momentum)
         call loop(kicks + moves + maps_mass + maps_momentum, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, &
                   rows_of_c, c, p, contribution, beyond)
      case (kicks + maps_momentum)
         call loop(kicks + maps_momentum, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, rows_of_c, c, p, &
                   contribution, beyond)
      case (strains + moves + maps_mass + maps_momentum)
         call loop(strains + moves + maps_mass + maps_momentum, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, &
                   rows_of_c, c, p, contribution, beyond)
      case (strains + moves + maps_mass + maps_momentum + maps_force)
         call loop(strains + moves + maps_mass + maps_momentum + maps_force, n, rows, room, inverse_size, zeros, kick_by, &
                   strain_by, move_by, rows_of_c, c, p, contribution, beyond)
      case (kicks + strains + moves + maps_mass + maps_momentum + maps_force)
         call loop(kicks + strains + moves + maps_mass + maps_momentum + maps_force, n, rows, room, inverse_size, zeros, kick_by, &
                   strain_by, move_by, rows_of_c, c, p, contribution, beyond)
      case default
         call loop(tasks_of(pass), n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, rows_of_c, c, p, &
                   contribution, beyond)
      end select
   end subroutine pass_over_rows

   !> What a pass does, as a sum.
   pure integer function tasks_of(pass)
      type(pass_t), intent(in) :: pass
      tasks_of = sum([kicks, strains, moves, maps_mass, maps_momentum, maps_force], &
                     mask=[pass%kick, pass%strain_fraction > 0, pass%move, pass%map_mass, pass%map_momentum, pass%map_force])
   end function tasks_of

   !> The loop of `pass_over_rows`.
   pure subroutine loop(tasks, n, rows, room, inverse_size, zeros, kick_by, strain_by, move_by, rows_of_c, c, p, contribution, &
                        beyond)
      integer, intent(in) :: tasks
      integer, intent(in) :: n, rows, room, rows_of_c
      real(dp), intent(in) :: inverse_size, zeros(lanes)
      real(dp), dimension(lanes, corners, ndim, n), intent(in) :: kick_by, strain_by, move_by
      real(dp), intent(in) :: c(lanes, n_constants, rows_of_c, n)
      real(dp), intent(inout) :: p(lanes, n_columns, room, n)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      real(dp), intent(inout) :: beyond(lanes, n)
      real(dp), dimension(lanes) :: m1, m2, m3, m4, p1, p2, p3, p4, q1, q2, q3, q4, t11, t12, t22, y11, y12, x12, x22, outside
      real(dp) :: xi, eta, x, y, v1, v2, l11, l12, l21, l22, h11, h21, h12, h22, mass, left, right, w1, w2, w3, w4, &
                  s11, s12, s22, pressure, lambda, mu, over, here
      logical :: kick, strain, move, map_mass, map_momentum, map_force
      integer :: b, s, l
      kick = iand(tasks, kicks) > 0
      strain = iand(tasks, strains) > 0
      move = iand(tasks, moves) > 0
      map_mass = iand(tasks, maps_mass) > 0
      map_momentum = iand(tasks, maps_momentum) > 0
      map_force = iand(tasks, maps_force) > 0
      do b = 1, n
         m1 = zeros
         m2 = zeros
         m3 = zeros
         m4 = zeros
         p1 = zeros
         p2 = zeros
         p3 = zeros
         p4 = zeros
         q1 = zeros
         q2 = zeros
         q3 = zeros
         q4 = zeros
         t11 = zeros
         t12 = zeros
         t22 = zeros
         y11 = zeros
         y12 = zeros
         x12 = zeros
         x22 = zeros
         outside = zeros
         do s = 1, rows
            !$omp simd private(xi, eta, x, y, v1, v2, l11, l12, l21, l22, h11, h21, h12, h22, mass, left, right, w1, w2, w3, w4, &
            !$omp s11, s12, s22, pressure, lambda, mu, over, here)
            do l = 1, lanes
               xi = min(max((p(l, of_offset, s, b) + p(l, of_displacement, s, b))*inverse_size, edge_margin), 1 - edge_margin)
               eta = min(max((p(l, of_offset + 1, s, b) + p(l, of_displacement + 1, s, b))*inverse_size, edge_margin), &
                         1 - edge_margin)
               v1 = p(l, of_velocity, s, b)
               v2 = p(l, of_velocity + 1, s, b)
               if (kick) then
                  v1 = v1 + ((kick_by(l, 1, 1, b) + xi*kick_by(l, 2, 1, b)) + eta*(kick_by(l, 3, 1, b) + xi*kick_by(l, 4, 1, b)))
                  v2 = v2 + ((kick_by(l, 1, 2, b) + xi*kick_by(l, 2, 2, b)) + eta*(kick_by(l, 3, 2, b) + xi*kick_by(l, 4, 2, b)))
                  p(l, of_velocity, s, b) = v1
                  p(l, of_velocity + 1, s, b) = v2
               end if
               h11 = p(l, of_gradient, s, b)
               h21 = p(l, of_gradient + 1, s, b)
               h12 = p(l, of_gradient + 2, s, b)
               h22 = p(l, of_gradient + 3, s, b)
               if (strain) then
                  l11 = strain_by(l, 2, 1, b) + eta*strain_by(l, 4, 1, b)
                  l12 = strain_by(l, 3, 1, b) + xi*strain_by(l, 4, 1, b)
                  l21 = strain_by(l, 2, 2, b) + eta*strain_by(l, 4, 2, b)
                  l22 = strain_by(l, 3, 2, b) + xi*strain_by(l, 4, 2, b)
                  s11 = h11
                  s12 = h12
                  h11 = s11 + (l11 + (l11*s11 + l12*h21))
                  h12 = s12 + (l12 + (l11*s12 + l12*h22))
                  h21 = h21 + (l21 + (l21*s11 + l22*h21))
                  h22 = h22 + (l22 + (l21*s12 + l22*h22))
                  p(l, of_gradient, s, b) = h11
                  p(l, of_gradient + 1, s, b) = h21
                  p(l, of_gradient + 2, s, b) = h12
                  p(l, of_gradient + 3, s, b) = h22
               end if
               mass = c(l, of_weight, min(s, rows_of_c), b)
               if (move) then
                  x = p(l, of_displacement, s, b) + ((move_by(l, 1, 1, b) + xi*move_by(l, 2, 1, b)) &
                                                     + eta*(move_by(l, 3, 1, b) + xi*move_by(l, 4, 1, b)))
                  y = p(l, of_displacement + 1, s, b) + ((move_by(l, 1, 2, b) + xi*move_by(l, 2, 2, b)) &
                                                         + eta*(move_by(l, 3, 2, b) + xi*move_by(l, 4, 2, b)))
                  p(l, of_displacement, s, b) = x
                  p(l, of_displacement + 1, s, b) = y
                  x = (p(l, of_offset, s, b) + x)*inverse_size
                  y = (p(l, of_offset + 1, s, b) + y)*inverse_size
                  xi = min(max(x, edge_margin), 1 - edge_margin)
                  eta = min(max(y, edge_margin), 1 - edge_margin)
                  over = min(1.0_dp, large*mass)*(abs(x - xi) + abs(y - eta))
                  outside(l) = outside(l) + over
                  here = max(0.0_dp, min(1.0_dp, 1 + large*(largest_rounding - over)))  ! who leaves is mapped where it comes to
                  mass = here*mass
               end if
               if (map_mass .or. map_momentum) then
                  left = (1 - xi)*mass
                  right = xi*mass
                  w1 = left*(1 - eta)
                  w2 = right*(1 - eta)
                  w3 = left*eta
                  w4 = right*eta
               end if
               if (map_mass) then
                  m1(l) = m1(l) + w1
                  m2(l) = m2(l) + w2
                  m3(l) = m3(l) + w3
                  m4(l) = m4(l) + w4
               end if
               if (map_momentum) then
                  p1(l) = p1(l) + w1*v1
                  p2(l) = p2(l) + w2*v1
                  p3(l) = p3(l) + w3*v1
                  p4(l) = p4(l) + w4*v1
                  q1(l) = q1(l) + w1*v2
                  q2(l) = q2(l) + w2*v2
                  q3(l) = q3(l) + w3*v2
                  q4(l) = q4(l) + w4*v2
               end if
               if (map_force) then
                  lambda = c(l, of_lambda, min(s, rows_of_c), b)
                  mu = c(l, of_mu, min(s, rows_of_c), b)
                  if (move) then
                     lambda = here*lambda
                     mu = here*mu
                  end if
                  pressure = lambda*(h11 + h22)
                  s11 = pressure + 2*mu*h11
                  s22 = pressure + 2*mu*h22
                  s12 = mu*(h12 + h21)
                  t11(l) = t11(l) + s11
                  t12(l) = t12(l) + s12
                  t22(l) = t22(l) + s22
                  y11(l) = y11(l) + eta*s11
                  y12(l) = y12(l) + eta*s12
                  x12(l) = x12(l) + xi*s12
                  x22(l) = x22(l) + xi*s22
               end if
            end do
         end do
         if (move) beyond(:, b) = outside
         if (map_mass) then
            contribution(:, 1, of_mass, b) = m1
            contribution(:, 2, of_mass, b) = m2
            contribution(:, 3, of_mass, b) = m3
            contribution(:, 4, of_mass, b) = m4
         end if
         if (map_momentum) then
            contribution(:, 1, of_momentum, b) = p1
            contribution(:, 2, of_momentum, b) = p2
            contribution(:, 3, of_momentum, b) = p3
            contribution(:, 4, of_momentum, b) = p4
            contribution(:, 1, of_momentum + 1, b) = q1
            contribution(:, 2, of_momentum + 1, b) = q2
            contribution(:, 3, of_momentum + 1, b) = q3
            contribution(:, 4, of_momentum + 1, b) = q4
         end if
         if (map_force) then
            call divergence(inverse_size, t11, t12, y11, x12, contribution(1, 1, of_force, b))
            call divergence(inverse_size, t12, t22, y12, x22, contribution(1, 1, of_force + 1, b))
         end if
      end do
   end subroutine loop

   !> The contributions to one component of the internal forces (7) at the corners, from the sums of volume times stress and of their
   !> moments across.
   pure subroutine divergence(inverse_size, along_x, along_y, moment_x, moment_y, force)
      real(dp), intent(in) :: inverse_size, along_x(lanes), along_y(lanes), moment_x(lanes), moment_y(lanes)
      real(dp), intent(inout) :: force(lanes, corners)
      real(dp) :: x_lower, x_upper, y_lower, y_upper
      integer :: l
      !$omp simd private(x_lower, x_upper, y_lower, y_upper)
      do l = 1, lanes
         x_upper = inverse_size*moment_x(l)
         x_lower = inverse_size*along_x(l) - x_upper
         y_upper = inverse_size*moment_y(l)
         y_lower = inverse_size*along_y(l) - y_upper
         force(l, 1) = x_lower + y_lower
         force(l, 2) = y_upper - x_lower
         force(l, 3) = x_upper - y_lower
         force(l, 4) = -x_upper - y_upper
      end do
   end subroutine divergence
end module hampm_interleaved_kernels
