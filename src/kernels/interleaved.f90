!> Particles of the updated frame as the fastest steps want them: interleaved by blocks of cells, so that a pass reads and writes one
!> stream of memory (docs/performance.md).
!>
!> All cells are of one size and stand in rows of the grid. A block is `lanes` cells side by side, whether or not they have particles. In
!> a row of it stand, column by column, one particle of each: all that a pass needs of `lanes` particles is one piece of memory, and
!> a block is its rows one after the other. What does not change, mass and stiffness, stands apart, once for all rows of a block where
!> that is the same. A cell with fewer particles than its block has rows has places without mass at its
!> end. Blocks have room for more rows, and with a margin there are also blocks of the empty cells around the body, so that a
!> particle that changes its cell goes to a free place and all others stay (`hampm_interleaved_moves`).
!>
!> Nodes have the sums of the cells instead of these: a batch of blocks adds what it gives, in the order of the blocks, while that is in
!> the first cache. Nodal values are kept by component, in rows of the grid that are filled up with places of no node, so that the last
!> block of a row is like the others.
!>
!> While this is active the particles are behind. `particle(lane, row)` tells which one stands in a place, `give_to_particles` brings
!> them up to date, and afterwards nothing is kept here that does not follow from them.
module hampm_interleaved
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_basis, only: edge_margin
   use hampm_cell_blocks, only: cell_blocks_t, lanes
   use hampm_constraints, only: constraints_t
   use hampm_grid, only: grid_t
   use hampm_interleaved_kernels, only: of_offset, of_displacement, of_velocity, of_gradient, n_columns, &
                                        n_constants
   use hampm_large_pages, only: prefer_large_pages
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next, v_mapped
   use hampm_particles, only: particles_t
   use hampm_pass, only: scheme_t
   use hampm_tiling, only: tiling_t, plan_for_sums
   implicit none
   private
   public :: interleaved_t, can_be_interleaved, interleave, give_interleaved, give_place, clear_place, keep_interleaved

   integer, parameter :: margin = 2              !! cells around those with particles that have blocks, too, where there is one

   !> Interleaved particles, and the nodal values of the steps.
   type :: interleaved_t
      logical :: is_active = .false.             !! whether particles are here, and those outside are behind
      integer :: steps_unseen = 0                !! steps since particles were looked at
      logical :: has_margin = .false.            !! whether cells around the body have blocks, and blocks room for more rows
      logical :: have_moved = .false.            !! whether particles are in other cells than when they were interleaved
      ! Where particles are
      type(cell_blocks_t) :: blocks              !! `n`, `layout`, `n_points`, `cells`, `first` (row), `rows` and `nodes` of these
      integer, allocatable :: room(:)            !! rows for which a block has room, (blocks)
      integer, allocatable :: corner(:)          !! the lower left node of a block, (blocks)
      integer, allocatable :: count_of(:, :)     !! particles of each cell, (lanes, blocks)
      integer, allocatable :: block_of(:)        !! in which block an element is, 0 for none, (n_elements)
      integer :: n_rows = 0                      !! rows that belong to blocks
      integer :: most_rows = 0                   !! and may do so; there may be room for more from before
      real(dp), allocatable :: row(:, :, :)      !! (lanes, n_columns, rows)
      integer, allocatable :: particle(:, :)     !! which particle is there, 0 for none, (lanes, rows)
      integer, allocatable :: first_constant(:)  !! the first row of a block in the next, (blocks)
      integer, allocatable :: rows_of_constants(:) !! and how many it has there: 1, or as many as it has room, (blocks)
      real(dp), allocatable :: constant(:, :, :) !! (lanes, n_constants, those rows)
      real(dp) :: inverse_size = 0               !! 1 / edge length of the cells [1/m]
      logical, allocatable :: left(:)            !! whether a particle has left its cell in the last pass, (blocks)
      type(tiling_t) :: plan                     !! of the steps
      ! Nodes, of which there are `points`
      integer :: stride = 0                      !! from a node to the one above it
      integer, allocatable :: node(:)            !! where each node of the grid is among them, (n_points)
      integer, allocatable :: fixed(:)           !! those with a fixed component, ascending
      logical, allocatable :: is_fixed(:, :)     !! which component, (ndim, as `fixed`)
      real(dp), allocatable :: mass(:)           !! sums for the coming nodal equations: of mass [kg], (points),
      real(dp), allocatable :: momentum(:, :)    !! of momentum [kg m/s], (points, ndim),
      real(dp), allocatable :: force(:, :)       !! and of the internal force [N], (points, ndim)
      real(dp), allocatable :: inverse_mass(:)   !! [1/kg], 0 where there is no mass, (points)
      real(dp), allocatable :: velocity(:, :)    !! v^n [m/s], (points, ndim)
      real(dp), allocatable :: acceleration(:, :) !! [m/s2], (points, ndim)
      real(dp), allocatable :: remapped(:, :)    !! v^(n+1) as it is mapped anew [m/s], (points, ndim); without where no scheme does
   end type interleaved_t

contains

   !> Whether particles can be interleaved: they are of the updated frame, have linear isotropic laws and nothing besides that other
   !> steps have to follow, and all cells are of one size.
   pure logical function can_be_interleaved(p, materials, grid)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(grid_t), intent(in) :: grid
      can_be_interleaved = .not. (p%total_frame .or. allocated(p%history) .or. allocated(p%corner_velocity) &
                                  .or. allocated(p%level) .or. allocated(grid%bodies) .or. grid%cut_cells%are_there()) &
                           .and. all(materials%linear .and. materials%isotropic .and. .not. materials%has_eigenstrain &
                                     .and. .not. materials%mean_dilatation) &
                           .and. grid%n_sheets == 1 .and. size(grid%cuts) == 0 .and. grid%forest%is_uniform() &
                           .and. .not. grid%is_quadratic()
   end function can_be_interleaved

   !> Interleave particles that stand in the order of their cells. It is not active where the memory does not suffice.
   subroutine interleave(p, materials, grid, occupied, constraints, scheme, self)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: occupied       !! the cells with particles
      type(constraints_t), intent(in) :: constraints
      type(scheme_t), intent(in) :: scheme
      type(interleaved_t), intent(inout) :: self
      integer :: b, l, k, e, status
      self%is_active = .false.
      self%have_moved = .false.
      call number_nodes(grid, constraints, self)
      call form_blocks(grid, blocks_to_hold(grid%forest%cells, occupied%occupied(:occupied%n_occupied), self%has_margin), self)
      call find_rows(occupied%count_in, self)
      self%most_rows = self%n_rows + merge(self%n_rows/2 + 64, 0, self%has_margin)
      call make_room(self, scheme, status)
      if (status /= 0) return
      !$omp parallel do schedule(static) private(l, k, e)
      do b = 1, self%blocks%n
         call clear_block(b, self)
         do l = 1, lanes
            e = self%blocks%cells(l, b)
            if (e == 0) cycle
            do k = 1, occupied%count_in(e)
               call fill_place(p, grid%element_lower(:, e), occupied%first_in(e) + (k - 1)*occupied%stride_in(e), l, &
                               self%blocks%first(b) + k - 1, self)
            end do
            self%count_of(l, b) = occupied%count_in(e)
         end do
      end do
      call find_constants(p, materials, self)
      call plan_for_sums(self%blocks, size(scheme%passes), self%plan)
      self%is_active = .true.
   end subroutine interleave

   !> Number the nodes, and find which are fixed.
   subroutine number_nodes(grid, constraints, self)
      type(grid_t), intent(in) :: grid
      type(constraints_t), intent(in) :: constraints
      type(interleaved_t), intent(inout) :: self
      logical, allocatable :: is_fixed(:, :)
      integer :: i, e
      self%inverse_size = 1/grid%element_size(1)
      self%stride = lanes*((grid%forest%cells(1) - 1)/lanes + 1) + lanes
      self%blocks%n_points = self%stride*(grid%forest%cells(2) + 1)
      if (allocated(self%node)) deallocate (self%node)
      allocate (self%node(grid%n_points))
      do e = 1, grid%n_elements
         i = (e - 1)/grid%forest%cells(1)*self%stride + mod(e - 1, grid%forest%cells(1)) + 1
         self%node(grid%element_nodes(:, e)) = i + [0, 1, self%stride, self%stride + 1]
      end do
      allocate (is_fixed(ndim, self%blocks%n_points), source=.false.)
      do i = 1, grid%n_nodes
         is_fixed(:, self%node(i)) = constraints%fixed(:, i)
      end do
      self%fixed = pack([(i, i=1, self%blocks%n_points)], any(is_fixed, dim=1))
      self%is_fixed = is_fixed(:, self%fixed)
   end subroutine number_nodes

   !> Which blocks there are, of all of a grid: those with particles and, with a margin, those around them. (blocks of a row, rows)
   pure function blocks_to_hold(cells, occupied, has_margin) result(held)
      integer, intent(in) :: cells(ndim)         !! of the grid
      integer, intent(in) :: occupied(:)         !! elements with particles
      logical, intent(in) :: has_margin
      logical, allocatable :: held(:, :)
      integer :: k, around(2, ndim), column, row
      allocate (held((cells(1) - 1)/lanes + 1, cells(2)), source=.false.)
      do k = 1, size(occupied)
         column = mod(occupied(k) - 1, cells(1))
         row = (occupied(k) - 1)/cells(1)
         around(:, 1) = column
         around(:, 2) = row
         if (has_margin) then
            around(1, :) = max(around(1, :) - margin, 0)
            around(2, :) = min(around(2, :) + margin, cells - 1)
         end if
         held(around(1, 1)/lanes + 1:around(2, 1)/lanes + 1, around(1, 2) + 1:around(2, 2) + 1) = .true.
      end do
   end function blocks_to_hold

   !> Form blocks, in the order of the grid.
   subroutine form_blocks(grid, held, self)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: held(:, :)          !! as `blocks_to_hold`
      type(interleaved_t), intent(inout) :: self
      integer :: column, row, n
      if (allocated(self%corner)) deallocate (self%corner, self%block_of, self%blocks%cells, self%blocks%nodes)
      n = count(held)
      allocate (self%corner(n), self%block_of(grid%n_elements), self%blocks%cells(lanes, n), self%blocks%nodes(corners, lanes, n))
      self%block_of = 0
      self%blocks%layout = self%blocks%layout + 1
      self%blocks%n = 0
      do row = 1, size(held, 2)
         do column = 1, size(held, 1)
            if (.not. held(column, row)) cycle
            self%blocks%n = self%blocks%n + 1
            call place_block(grid, (row - 1)*grid%forest%cells(1) + lanes*(column - 1) + 1, self%blocks%n, self)
         end do
      end do
   end subroutine form_blocks

   !> Place a block in the grid.
   pure subroutine place_block(grid, first, b, self)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first               !! its first element
      integer, intent(in) :: b
      type(interleaved_t), intent(inout) :: self
      integer :: l, n
      n = min(lanes, grid%forest%cells(1) - mod(first - 1, grid%forest%cells(1)))
      self%blocks%cells(:, b) = 0
      do l = 1, lanes
         if (l <= n) self%blocks%cells(l, b) = first + l - 1
         self%blocks%nodes(:, l, b) = self%node(grid%element_nodes(:, first + min(l, n) - 1))
      end do
      self%corner(b) = self%blocks%nodes(1, 1, b)
      self%block_of(first:first + n - 1) = b
   end subroutine place_block

   !> How many rows blocks have, and where these are.
   subroutine find_rows(count_in, self)
      integer, intent(in) :: count_in(:)         !! particles of each element
      type(interleaved_t), intent(inout) :: self
      integer :: b, l, next
      associate (blocks => self%blocks)
         if (allocated(blocks%first)) deallocate (blocks%first, blocks%rows, self%room)
         allocate (blocks%first(blocks%n), blocks%rows(blocks%n), self%room(blocks%n))
         next = 1
         do b = 1, blocks%n
            blocks%first(b) = next
            blocks%rows(b) = maxval([(count_in(blocks%cells(l, b)), l=1, count(blocks%cells(:, b) > 0))])
            self%room(b) = blocks%rows(b) + merge(1, 0, self%has_margin)
            next = next + self%room(b)
         end do
      end associate
      self%n_rows = next - 1
   end subroutine find_rows

   !> Room for the blocks, for their rows, and for the nodes, whose sums are zero.
   subroutine make_room(self, scheme, status)
      type(interleaved_t), intent(inout) :: self
      type(scheme_t), intent(in) :: scheme
      integer, intent(out) :: status
      status = 0
      if (allocated(self%left)) deallocate (self%left, self%count_of, self%first_constant, self%rows_of_constants)
      associate (n => self%blocks%n)
         allocate (self%left(n), self%count_of(lanes, n), self%first_constant(n), self%rows_of_constants(n), stat=status)
      end associate
      if (status /= 0) return
      self%left = .false.
      self%count_of = 0
      if (allocated(self%row)) then
         if (size(self%row, 3) < self%most_rows) deallocate (self%row, self%particle, self%constant)
      end if
      if (.not. allocated(self%row)) then
         associate (rows => self%most_rows)
            allocate (self%row(lanes, n_columns, rows), self%particle(lanes, rows), self%constant(lanes, n_constants, rows), &
                      stat=status)
         end associate
         if (status /= 0) return
         call prefer_large_pages(size(self%row), self%row)
      end if
      associate (n => self%blocks%n_points)
         if (.not. allocated(self%mass)) &
            allocate (self%mass(n), self%momentum(n, ndim), self%force(n, ndim), self%inverse_mass(n), self%velocity(n, ndim), &
                      self%acceleration(n, ndim), self%remapped(merge(n, 0, scheme%remaps), ndim), stat=status)
      end associate
      if (status /= 0) return
      self%mass = 0
      self%momentum = 0
      self%force = 0
      self%inverse_mass = 0
      self%velocity = 0
      self%acceleration = 0
      self%remapped = 0
   end subroutine make_room

   !> Empty all places of a block.
   pure subroutine clear_block(b, self)
      integer, intent(in) :: b
      type(interleaved_t), intent(inout) :: self
      integer :: l, row
      do row = self%blocks%first(b), self%blocks%first(b) + self%room(b) - 1
         do l = 1, lanes
            call clear_place(l, row, self)
         end do
      end do
   end subroutine clear_block

   !> Empty a place: it stands still in the middle of a cell, without mass.
   pure subroutine clear_place(lane, row, self)
      integer, intent(in) :: lane, row
      type(interleaved_t), intent(inout) :: self
      self%row(lane, :, row) = 0
      self%row(lane, of_offset:of_offset + ndim - 1, row) = 0.5_dp/self%inverse_size
      self%particle(lane, row) = 0
   end subroutine clear_place

   !> Put a particle as it is into a place of a cell.
   pure subroutine fill_place(p, lower, i, lane, row, self)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: lower(ndim)        !! lower corner of the cell [m]
      integer, intent(in) :: i                   !! the particle
      integer, intent(in) :: lane, row
      type(interleaved_t), intent(inout) :: self
      self%row(lane, :, row) = [p%reference(i, :) - lower, p%displacement(i, :), p%velocity(i, :), p%gradient(i, :, 1), &
                                p%gradient(i, :, 2)]
      self%particle(lane, row) = i
   end subroutine fill_place

   !> Find what does not change of the particles in their places: once for a block where no particle comes or goes and those of each
   !> cell are alike.
   subroutine find_constants(p, materials, self)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(interleaved_t), intent(inout) :: self
      real(dp), allocatable :: constant(:, :, :)
      integer :: b, s, n
      n = 0
      do b = 1, self%blocks%n
         constant = constants_of_block(b)
         if (self%has_margin) n = self%blocks%first(b) - 1      ! each row has its own, where the row is
         self%first_constant(b) = n + 1
         self%rows_of_constants(b) = self%room(b)
         if (.not. self%has_margin .and. self%room(b) > 0) then
            if (all([(all(abs(constant(:, :, s) - constant(:, :, 1)) <= 0), s=2, self%room(b))])) self%rows_of_constants(b) = 1
         end if
         self%constant(:, :, n + 1:n + self%rows_of_constants(b)) = constant(:, :, :self%rows_of_constants(b))
         n = n + self%rows_of_constants(b)
      end do
   contains
      !> Those of all rows of a block.
      pure function constants_of_block(b) result(constant)
         integer, intent(in) :: b
         real(dp) :: constant(lanes, n_constants, self%room(b))
         integer :: l, s
         constant = 0
         do s = 1, self%room(b)
            do l = 1, lanes
               associate (i => self%particle(l, self%blocks%first(b) + s - 1))
                  if (i == 0) cycle
                  constant(l, :, s) = [p%mass(i), p%volume(i)*[materials(p%material(i))%lambda, materials(p%material(i))%mu]]
               end associate
            end do
         end do
      end function constants_of_block
   end subroutine find_constants

   !> Bring the particles up to date, and the nodal values of the last step with them. `also_cells`: also the cells in which they are.
   subroutine give_interleaved(self, also_cells, dt, p, f)
      type(interleaved_t), intent(in) :: self
      logical, intent(in) :: also_cells
      real(dp), intent(in) :: dt                 !! of the last step [s]
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: columns(n_columns)
      integer :: b, row, l, k
      !$omp parallel do schedule(static) private(row, l, columns)
      do b = 1, self%blocks%n
         do row = self%blocks%first(b), self%blocks%first(b) + self%blocks%rows(b) - 1
            do l = 1, lanes
               if (self%particle(l, row) == 0) cycle
               columns = self%row(l, :, row)
               call give_place(columns, self%inverse_size, self%particle(l, row), p)
               if (also_cells) p%cell(self%particle(l, row)) = self%blocks%cells(l, b)
            end do
         end do
      end do
      do k = 1, size(f%acceleration, 2)
         associate (i => self%node(k))
            f%velocity(:, k, v_n) = self%velocity(i, :)
            f%velocity(:, k, v_next) = self%velocity(i, :) + dt*self%acceleration(i, :)
            if (size(self%remapped) > 0) f%velocity(:, k, v_mapped) = self%remapped(i, :)
            f%acceleration(:, k) = self%acceleration(i, :)
            f%mass_matrix%lumped(k) = 0
            if (self%inverse_mass(i) > 0) f%mass_matrix%lumped(k) = 1/self%inverse_mass(i)
            f%mass_matrix%inverse_lumped(k) = self%inverse_mass(i)
         end associate
      end do
   end subroutine give_interleaved

   !> Bring a particle up to date.
   pure subroutine give_place(columns, inverse_size, i, p)
      real(dp), intent(in) :: columns(n_columns)        !! of its place
      real(dp), intent(in) :: inverse_size
      integer, intent(in) :: i                          !! the particle
      type(particles_t), intent(inout) :: p
      p%displacement(i, :) = columns(of_displacement:of_displacement + ndim - 1)
      p%velocity(i, :) = columns(of_velocity:of_velocity + ndim - 1)
      p%gradient(i, :, 1) = columns(of_gradient:of_gradient + ndim - 1)
      p%gradient(i, :, 2) = columns(of_gradient + ndim:of_gradient + 2*ndim - 1)
      p%local(i, :) = min(max((columns(of_offset:of_offset + ndim - 1) + p%displacement(i, :))*inverse_size, edge_margin), &
                          1 - edge_margin)
   end subroutine give_place

   !> Keep where particles are, and the sums of the nodes, which depend on the order in which they came there. What is here of the
   !> particles they have been given before; when it is read, they are taken as they are.
   subroutine keep_interleaved(self, p, materials, grid, constraints, scheme, archive)
      type(interleaved_t), intent(inout) :: self
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(grid_t), intent(in) :: grid
      type(constraints_t), intent(in) :: constraints
      type(scheme_t), intent(in) :: scheme
      class(archive_t), intent(inout) :: archive
      integer, allocatable :: first_cells(:)
      logical :: was_active
      integer :: status
      call archive%section('interleaved')
      was_active = self%is_active
      call archive%keep('is_active', was_active)
      call archive%keep('steps_unseen', self%steps_unseen)
      call archive%keep('has_margin', self%has_margin)
      if (archive%failure%failed() .or. .not. was_active) return
      call archive%keep('have_moved', self%have_moved)
      call archive%keep('blocks', self%blocks%n)
      call archive%keep('rows', self%n_rows)
      call archive%keep('most_rows', self%most_rows)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         call number_nodes(grid, constraints, self)
         call make_places(archive, grid, scheme, self, status)
         if (status /= 0) return
      end if
      allocate (first_cells, source=self%blocks%cells(1, :self%blocks%n))
      call archive%keep_integers('first_cells', self%blocks%n, first_cells)
      call archive%keep_integers('first_rows', self%blocks%n, self%blocks%first)
      call archive%keep_integers('rows_of_blocks', self%blocks%n, self%blocks%rows)
      call archive%keep_integers('room', self%blocks%n, self%room)
      call archive%keep_integers('particles_in_rows', lanes*self%n_rows, self%particle)
      call archive%keep_reals('mass', size(self%mass), self%mass)
      call archive%keep_reals('momentum', size(self%momentum), self%momentum)
      call archive%keep_reals('force', size(self%force), self%force)
      if (archive%is_read .and. .not. archive%failure%failed()) &
         call take_places(archive, p, materials, grid, first_cells, scheme, self)
   end subroutine keep_interleaved

   !> Room for what is read of blocks and rows.
   subroutine make_places(archive, grid, scheme, self, status)
      class(archive_t), intent(inout) :: archive
      type(grid_t), intent(in) :: grid
      type(scheme_t), intent(in) :: scheme
      type(interleaved_t), intent(inout) :: self
      integer, intent(out) :: status
      status = 1
      associate (blocks => self%blocks, n => self%blocks%n)
         if (n < 1 .or. n > grid%n_elements .or. self%n_rows < n .or. self%most_rows < self%n_rows) then
            call archive%refuse('its interleaved particles are not in the cells of the grid')
            return
         end if
         allocate (blocks%cells(lanes, n), blocks%nodes(corners, lanes, n), blocks%first(n), blocks%rows(n), self%room(n), &
                   self%corner(n), self%block_of(grid%n_elements), stat=status)
         blocks%cells = 0
         self%block_of = 0
      end associate
      if (status == 0) call make_room(self, scheme, status)
      if (status /= 0) call archive%refuse('its interleaved particles need more memory than there is')
   end subroutine make_places

   !> Take particles to the places that have been read.
   subroutine take_places(archive, p, materials, grid, first_cells, scheme, self)
      class(archive_t), intent(inout) :: archive
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first_cells(:)      !! of the blocks
      type(scheme_t), intent(in) :: scheme
      type(interleaved_t), intent(inout) :: self
      integer :: b, l, row, i
      associate (blocks => self%blocks)
         if (.not. (all(first_cells >= 1 .and. first_cells <= grid%n_elements &
                        .and. mod(mod(first_cells - 1, grid%forest%cells(1)), lanes) == 0) &
                    .and. all(blocks%first >= 1 .and. blocks%rows >= 0 .and. blocks%rows <= self%room &
                              .and. blocks%first + self%room - 1 <= self%n_rows) &
                    .and. all(self%particle(:, :self%n_rows) >= 0 .and. self%particle(:, :self%n_rows) <= p%n))) then
            call archive%refuse('its interleaved particles do not fit each other')
            return
         end if
         blocks%layout = blocks%layout + 1
         do b = 1, blocks%n
            call place_block(grid, first_cells(b), b, self)
            do row = blocks%first(b), blocks%first(b) + self%room(b) - 1
               do l = 1, lanes
                  i = self%particle(l, row)
                  call clear_place(l, row, self)
                  if (i == 0 .or. blocks%cells(l, b) == 0) cycle
                  call fill_place(p, grid%element_lower(:, blocks%cells(l, b)), i, l, row, self)
                  self%count_of(l, b) = self%count_of(l, b) + 1
               end do
            end do
         end do
      end associate
      call find_constants(p, materials, self)
      call plan_for_sums(self%blocks, size(scheme%passes), self%plan)
      self%is_active = .true.
   end subroutine take_places
end module hampm_interleaved
