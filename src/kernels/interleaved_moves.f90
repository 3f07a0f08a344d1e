!> Interleaved particles that change their cell (`hampm_interleaved`). A pass that moves leaves out of its sums those that it has
!> moved out of their cell. Here they go to a free place of the cell in which they are now, and add to the sums there; all others
!> stay. Where a block has no room for another row, it moves to free rows; where there are none left, or a particle has come to a cell
!> without a block, all have to be sorted and interleaved anew.
module hampm_interleaved_moves
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: edge_margin, shape_functions, shape_gradients
   use hampm_cell_blocks, only: lanes
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_interleaved, only: interleaved_t, clear_place, give_place
   use hampm_interleaved_kernels, only: of_offset, of_displacement, of_velocity, of_gradient, of_weight, of_lambda, of_mu, &
                                        n_columns, n_constants, largest_rounding
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: move_leavers, moves_t

   !> What has become of particles that left their cells.
   type :: moves_t
      logical :: jumped = .false.                !! some particle moved past the next cell or is no longer a number
      logical :: fit = .true.                    !! all others are in their places
   end type moves_t

   !> A particle between two places.
   type :: leaver_t
      integer :: particle = 0
      integer :: cell = 0                        !! in which it is now
      real(dp) :: columns(n_columns) = 0         !! of its place, with the offset in that cell
      real(dp) :: constants(n_constants) = 0
   end type leaver_t

contains

   !> Take all particles that have left their cells to those in which they are, and let them map.
   subroutine move_leavers(map, p, grid, self, moves)
      type(pass_t), intent(in) :: map            !! what they have to map
      type(particles_t), intent(inout) :: p             !! brought up to date are those for which there is no place
      type(grid_t), intent(in) :: grid
      type(interleaved_t), intent(inout) :: self
      type(moves_t), intent(out) :: moves
      integer, allocatable :: place(:, :)
      type(leaver_t), allocatable :: leavers(:)
      integer :: k
      if (.not. any(self%left)) return
      moves%fit = self%has_margin
      call find_places_left(self, place)
      allocate (leavers(size(place, 2)))
      do k = 1, size(leavers)
         call look_at_leaver(p, grid, self, place(:, k), leavers(k), moves)
         if (moves%jumped) return
      end do
      if (.not. moves%fit) return
      self%have_moved = .true.
      do k = 1, size(leavers)
         call take_out(place(:, k), self)
      end do
      do k = 1, size(leavers)
         if (moves%fit) call put_in(leavers(k), self, moves%fit)
         if (moves%fit) then
            call map_place(map, leavers(k), self%node(grid%element_nodes(:, leavers(k)%cell)), self)
         else
            call give_place(leavers(k)%columns, self%inverse_size, leavers(k)%particle, p)
         end if
      end do
   end subroutine move_leavers

   !> The places of particles outside their cells: lane, block, and which particle of its cell, the last of a cell first. In the order of
   !> the blocks.
   subroutine find_places_left(self, place)
      type(interleaved_t), intent(in) :: self
      integer, allocatable, intent(out) :: place(:, :)  !! (3, number)
      integer, allocatable :: found(:, :)
      real(dp) :: over(lanes)
      integer :: b, l, s, n
      n = 0
      do b = 1, self%blocks%n
         if (self%left(b)) n = n + lanes*self%blocks%rows(b)
      end do
      allocate (found(3, n))
      n = 0
      do b = 1, self%blocks%n
         if (.not. self%left(b)) cycle
         do s = self%blocks%rows(b), 1, -1
            call find_excess(self%inverse_size, self%row(1, 1, self%blocks%first(b) + s - 1), over)
            if (all(over <= largest_rounding)) cycle
            do l = 1, lanes
               if (over(l) <= largest_rounding .or. s > self%count_of(l, b)) cycle
               n = n + 1
               found(:, n) = [l, b, s]
            end do
         end do
      end do
      place = found(:, :n)
   end subroutine find_places_left

   !> By how much the places of a row are outside their cells [cells], as the pass sees it.
   pure subroutine find_excess(inverse_size, row, over)
      real(dp), intent(in) :: inverse_size, row(lanes, n_columns)
      real(dp), intent(out) :: over(lanes)
      real(dp) :: x, y
      integer :: l
      !$omp simd private(x, y)
      do l = 1, lanes
         x = (row(l, of_offset) + row(l, of_displacement))*inverse_size
         y = (row(l, of_offset + 1) + row(l, of_displacement + 1))*inverse_size
         over(l) = abs(x - min(max(x, edge_margin), 1 - edge_margin)) + abs(y - min(max(y, edge_margin), 1 - edge_margin))
      end do
   end subroutine find_excess

   !> What is in a place, and the cell where it is now. It does not fit where that has no block or is out of the grid.
   pure subroutine look_at_leaver(p, grid, self, place, leaver, moves)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      type(interleaved_t), intent(in) :: self
      integer, intent(in) :: place(3)            !! as in `find_places_left`
      type(leaver_t), intent(inout) :: leaver
      type(moves_t), intent(inout) :: moves
      real(dp) :: xi(ndim)
      integer :: row
      row = self%blocks%first(place(2)) + place(3) - 1
      leaver%particle = self%particle(place(1), row)
      leaver%columns = self%row(place(1), :, row)
      leaver%constants = self%constant(place(1), :, row)
      xi = coordinate(leaver%columns, self%inverse_size)
      moves%jumped = .not. all(xi >= -1 .and. xi < 2)
      if (moves%jumped) return
      call find_cell(p, grid, leaver)
      if (leaver%cell == outside) then
         moves%fit = .false.
      else
         moves%fit = moves%fit .and. self%block_of(leaver%cell) > 0
      end if
   end subroutine look_at_leaver

   !> Find in which cell of the grid a particle is, and where in that.
   pure subroutine find_cell(p, grid, leaver)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      type(leaver_t), intent(inout) :: leaver
      real(dp) :: start(ndim)
      start = p%reference(leaver%particle, :)
      leaver%cell = grid%element_at(start + leaver%columns(of_displacement:of_displacement + ndim - 1))
      if (leaver%cell /= outside) leaver%columns(of_offset:of_offset + ndim - 1) = start - grid%element_lower(:, leaver%cell)
   end subroutine find_cell

   !> The local coordinate of a place in its cell.
   pure function coordinate(place, inverse_size) result(xi)
      real(dp), intent(in) :: place(n_columns), inverse_size
      real(dp) :: xi(ndim)
      xi = (place(of_offset:of_offset + ndim - 1) + place(of_displacement:of_displacement + ndim - 1))*inverse_size
   end function coordinate

   !> Empty a place. The last particle of the cell fills it.
   pure subroutine take_out(place, self)
      integer, intent(in) :: place(3)            !! as in `find_places_left`
      type(interleaved_t), intent(inout) :: self
      integer :: row, last
      associate (l => place(1), b => place(2))
         row = self%blocks%first(b) + place(3) - 1
         last = self%blocks%first(b) + self%count_of(l, b) - 1
         if (last > row) then
            self%row(l, :, row) = self%row(l, :, last)
            self%constant(l, :, row) = self%constant(l, :, last)
            self%particle(l, row) = self%particle(l, last)
         end if
         call clear_place(l, last, self)
         self%constant(l, :, last) = 0
         self%count_of(l, b) = self%count_of(l, b) - 1
         self%blocks%rows(b) = maxval(self%count_of(:, b))
      end associate
   end subroutine take_out

   !> Put a particle into the next place of its cell, which has a block. `fits` is false where there is no room.
   pure subroutine put_in(leaver, self, fits)
      type(leaver_t), intent(in) :: leaver
      type(interleaved_t), intent(inout) :: self
      logical, intent(out) :: fits
      integer :: l, row
      fits = .true.
      associate (b => self%block_of(leaver%cell), blocks => self%blocks)
         l = findloc(blocks%cells(:, b), leaver%cell, dim=1)
         if (self%count_of(l, b) == self%room(b)) call move_block(b, self, fits)
         if (.not. fits) return
         self%count_of(l, b) = self%count_of(l, b) + 1
         blocks%rows(b) = max(blocks%rows(b), self%count_of(l, b))
         row = blocks%first(b) + self%count_of(l, b) - 1
         self%row(l, :, row) = leaver%columns
         self%particle(l, row) = leaver%particle
         self%constant(l, :, row) = leaver%constants
      end associate
   end subroutine put_in

   !> Move a block to free rows, of which it takes half as many more. `fits` is false where there are not enough.
   pure subroutine move_block(b, self, fits)
      integer, intent(in) :: b
      type(interleaved_t), intent(inout) :: self
      logical, intent(out) :: fits
      integer :: room, row, l
      room = self%room(b) + self%room(b)/2 + 1
      fits = self%n_rows + room <= self%most_rows
      if (.not. fits) return
      associate (from => self%blocks%first(b), to => self%n_rows + 1, old => self%room(b))
         self%row(:, :, to:to + old - 1) = self%row(:, :, from:from + old - 1)
         self%particle(:, to:to + old - 1) = self%particle(:, from:from + old - 1)
         self%constant(:, :, to:to + old - 1) = self%constant(:, :, from:from + old - 1)
         self%constant(:, :, to + old:to + room - 1) = 0
         do row = to + old, to + room - 1
            do l = 1, lanes
               call clear_place(l, row, self)
            end do
         end do
         do row = from, from + old - 1
            self%particle(:, row) = 0
         end do
         self%blocks%first(b) = to
         self%first_constant(b) = to
      end associate
      self%room(b) = room
      self%rows_of_constants(b) = room
      self%n_rows = self%n_rows + room
   end subroutine move_block

   !> Add to the sums at the nodes what one particle maps.
   pure subroutine map_place(map, leaver, nodes, self)
      type(pass_t), intent(in) :: map
      type(leaver_t), intent(in) :: leaver
      integer, intent(in) :: nodes(corners)
      type(interleaved_t), intent(inout) :: self
      real(dp) :: xi(ndim), weight(corners), gradient(corners, ndim), stress(ndim, ndim), h(ndim, ndim)
      integer :: d
      associate (place => leaver%columns, constant => leaver%constants)
         xi = min(max(coordinate(place, self%inverse_size), edge_margin), 1 - edge_margin)
         weight = constant(of_weight)*shape_functions(xi)
         if (map%map_mass) self%mass(nodes) = self%mass(nodes) + weight
         do d = 1, ndim
            if (map%map_momentum) self%momentum(nodes, d) = self%momentum(nodes, d) + weight*place(of_velocity + d - 1)
         end do
         if (.not. map%map_force) return
         gradient = shape_gradients(xi, self%inverse_size)
         h = reshape(place(of_gradient:of_gradient + ndim*ndim - 1), [ndim, ndim])
         stress = constant(of_mu)*(h + transpose(h))
         do d = 1, ndim
            stress(d, d) = stress(d, d) + constant(of_lambda)*(h(1, 1) + h(2, 2))
         end do
         self%force(nodes, :) = self%force(nodes, :) - matmul(gradient, stress)
      end associate
   end subroutine map_place
end module hampm_interleaved_moves
