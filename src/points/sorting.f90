!> Sorting the particles into the cells of a grid, in the order of the blocks (`hampm_cell_blocks`). Between two sorts most
!> particles stay in order, so that they are moved in stretches: particles that follow each other before and after.
module hampm_sorting
   use hampm_kinds, only: dp, ndim, long
   use hampm_cell_blocks, only: cell_blocks_t, resize_to_elements, form_blocks, find_materials
   use hampm_column_visitor, only: column_visitor_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_particles, only: particles_t
   use hampm_text, only: to_text, point_text
   implicit none
   private
   public :: sorting_t, sort_into_cells, take_order

   !> Where the last sort moved the particles, and workspace.
   type, extends(column_visitor_t) :: sorting_t
      integer, allocatable :: new_place(:)              !! of each particle, (n)
      logical, allocatable :: changed(:)                !! elements that particles have left or entered, if only cell-crossing
                                                        !! particles were checked; (n_elements)
      integer, private :: n_stretches = 0
      integer, allocatable, private :: from(:), to(:), length(:) !! of each stretch
      integer, allocatable, private :: next(:)          !! place of the next particle of each element
      real(dp), allocatable, private :: real_copy(:)
      integer, allocatable, private :: integer_copy(:)
      integer(long), allocatable, private :: long_copy(:)
      logical, private :: of_all = .false.              !! whether all particles were checked
   contains
      procedure :: reals => permute_reals
      procedure :: integers => permute_integers
      procedure :: longs => permute_longs
   end type sorting_t

contains

   !> Find the cell of every particle, form the blocks, and sort all columns, keeping the order within a cell. `new_place` then
   !> tells where each particle went. If the blocks that some particle has left are known, only these are checked, and `changed`
   !> tells which cells differ. Fails where the memory does not suffice, a particle has left the grid or its position is NaN.
   subroutine sort_into_cells(s, p, grid, blocks, failure, left)
      type(sorting_t), intent(inout) :: s
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(inout) :: blocks
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)          !! by block
      call resize(s, p%n, grid%n_elements, failure)
      if (.not. failure%failed()) call resize_to_elements(blocks, grid%n_elements, failure)
      if (.not. failure%failed()) call locate(s, p, grid, blocks, failure, left)
      if (failure%failed()) return
      call form_blocks(blocks, grid, p%cell(:p%n))
      call find_places(s, p, blocks)
      s%of_all = .not. present(left)
      call p%visit_columns(s)
      call find_materials(blocks, p%material)
   end subroutine sort_into_cells

   !> Form the blocks of particles that stand in the order of a sort, each in its `cell`. `fits` is false where they do not.
   subroutine take_order(s, p, grid, blocks, fits, failure)
      type(sorting_t), intent(inout) :: s
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(inout) :: blocks
      logical, intent(out) :: fits
      type(failure_t), intent(inout) :: failure
      fits = p%n > 0 .and. all(p%cell >= 1 .and. p%cell <= grid%n_elements)
      if (.not. fits) return
      call resize(s, p%n, grid%n_elements, failure)
      if (.not. failure%failed()) call resize_to_elements(blocks, grid%n_elements, failure)
      if (failure%failed()) return
      call form_blocks(blocks, grid, p%cell)
      call find_places(s, p, blocks)
      fits = s%n_stretches == 0
      if (fits) call find_materials(blocks, p%material)
   end subroutine take_order

   !> Room for the particles and elements that there are.
   subroutine resize(s, n, n_elements, failure)
      type(sorting_t), intent(inout) :: s
      integer, intent(in) :: n, n_elements
      type(failure_t), intent(inout) :: failure
      integer :: status
      status = 0
      if (allocated(s%new_place)) then
         if (size(s%new_place) /= n) deallocate (s%new_place, s%from, s%to, s%length, s%real_copy, s%integer_copy)
      end if
      if (.not. allocated(s%new_place)) allocate (s%new_place(n), s%from(n), s%to(n), s%length(n), s%real_copy(n), &
                                                  s%integer_copy(n), stat=status)
      if (allocated(s%next)) then
         if (size(s%next) /= n_elements) deallocate (s%next, s%changed)
      end if
      if (status == 0 .and. .not. allocated(s%next)) allocate (s%next(n_elements), s%changed(n_elements), stat=status)
      if (status /= 0) call failure%report(exit_computation, 'particles: not enough memory to sort '//to_text(n)//' particles')
   end subroutine resize

   !> Set `cell` from the positions.
   subroutine locate(s, p, grid, blocks, failure, left)
      type(sorting_t), intent(inout) :: s
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)
      integer :: b, i, lost
      lost = 0
      if (present(left)) then
         s%changed = .false.
         do b = 1, blocks%n
            if (.not. left(b)) cycle
            do i = blocks%first(b), blocks%last(b)
               call locate_particle(i)
            end do
         end do
      else
         do i = 1, p%n
            call locate_particle(i)
         end do
      end if
      if (lost > 0) call failure%report(exit_computation, lost_particle(p, lost))
   contains
      !> Set the cell of a particle.
      subroutine locate_particle(i)
         integer, intent(in) :: i
         real(dp) :: origin(ndim)
         integer :: e
         if (grid%cut_cells%are_there()) then
            origin = p%reference(i, :)
            e = grid%element_at(p%place_in_grid(i), origin, body=p%body(i))
         else
            e = grid%element_at(p%place_in_grid(i), body=p%body(i))
         end if
         if (e == outside) then
            if (lost == 0) lost = i
         else if (present(left) .and. e /= p%cell(i)) then
            s%changed(e) = .true.
            s%changed(p%cell(i)) = .true.
         end if
         p%cell(i) = e
      end subroutine locate_particle
   end subroutine locate

   !> Message about a particle that is no longer in the grid.
   function lost_particle(p, i) result(message)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      character(:), allocatable :: message
      real(dp) :: x(ndim)
      x = p%position(i)
      if (any(.not. abs(x) <= huge(x))) then
         message = 'the position of particle '//to_text(p%id(i))//' is no longer a number; it started at '// &
                   point_text(p%reference(i, :))//' m. Likely cause: the run is unstable; reduce &method courant'
      else
         message = 'particle '//to_text(p%id(i))//' left the grid at '//point_text(x)//' m; it started at '// &
                   point_text(p%reference(i, :))// &
                   ' m. Likely cause: the body moves beyond the grid: give &grid more cells or add a &constraint; '// &
                   'or the run is unstable: reduce &method courant'
      end if
   end function lost_particle

   !> Decide the new place of each particle, and which of them move together.
   subroutine find_places(s, p, blocks)
      type(sorting_t), intent(inout) :: s
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer :: i, e
      s%next = blocks%first_in
      do i = 1, p%n
         e = p%cell(i)
         s%new_place(i) = s%next(e)
         s%next(e) = s%next(e) + blocks%stride_in(e)
      end do
      s%n_stretches = 0
      do i = 1, p%n
         if (s%new_place(i) == i) cycle
         if (s%n_stretches > 0) then
            associate (k => s%n_stretches)
               if (s%from(k) + s%length(k) == i .and. s%to(k) + s%length(k) == s%new_place(i)) then
                  s%length(k) = s%length(k) + 1
                  cycle
               end if
            end associate
         end if
         s%n_stretches = s%n_stretches + 1
         s%from(s%n_stretches) = i
         s%to(s%n_stretches) = s%new_place(i)
         s%length(s%n_stretches) = 1
      end do
   end subroutine find_places

   !> Move a field of real numbers to the new places.
   subroutine permute_reals(self, n, width, values)
      class(sorting_t), intent(inout) :: self
      integer, intent(in) :: n, width
      real(dp), intent(inout) :: values(n, width)
      integer :: d, k
      do d = 1, width
         if (self%of_all) then                   ! before anything has moved most columns are zero
            if (all(abs(values(:, d)) <= 0)) cycle
         end if
         do k = 1, self%n_stretches
            associate (from => self%from(k), to => self%to(k), length => self%length(k))
               self%real_copy(to:to + length - 1) = values(from:from + length - 1, d)
            end associate
         end do
         do k = 1, self%n_stretches
            associate (to => self%to(k), length => self%length(k))
               values(to:to + length - 1, d) = self%real_copy(to:to + length - 1)
            end associate
         end do
      end do
   end subroutine permute_reals

   !> Move a field of integers to the new places.
   subroutine permute_integers(self, n, values)
      class(sorting_t), intent(inout) :: self
      integer, intent(in) :: n
      integer, intent(inout) :: values(n)
      self%integer_copy(self%new_place) = values
      values = self%integer_copy
   end subroutine permute_integers

   !> Move a field of long integers to the new places.
   subroutine permute_longs(self, n, values)
      class(sorting_t), intent(inout) :: self
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      if (allocated(self%long_copy)) then
         if (size(self%long_copy) /= n) deallocate (self%long_copy)
      end if
      if (.not. allocated(self%long_copy)) allocate (self%long_copy(n))
      self%long_copy(self%new_place) = values
      values = self%long_copy
   end subroutine permute_longs
end module hampm_sorting
