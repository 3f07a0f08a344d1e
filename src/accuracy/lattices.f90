!> Lattices that fit a model: their nodes are where edges, supports and tips are, as far as one cell size allows.
!>
!> All coordinates that are to be nodes are multiples of a unit, their greatest common divisor by Euclid's algorithm, from the first
!> of them in each direction on. Those that have to be are first: edges, supports of no width. Ends of supports, of cracks and of
!> loads follow, each unless the unit would be too small. The cells of the lattices are the unit over 1, 2, 3, ...
module hampm_lattices
   use hampm_kinds, only: dp, ndim
   use hampm_critical_step, only: largest_wave_speed
   use hampm_load_groups, only: constraint_spec_t
   use hampm_model, only: model_t
   use hampm_model_materials, only: materials_of
   use hampm_tensors, only: norm, edge_of
   use hampm_text, only: string_t, to_text, without_rounding
   implicit none
   private
   public :: lattices_t, new_lattices

   real(dp), parameter :: same = 1e-7_dp         !! part of the size of all bodies within which places are the same
   real(dp), parameter :: narrow = 0.01_dp       !! part of that up to which a box of supports is to hold the nodes of one line
   real(dp), parameter :: tolerance = 1e-6_dp    !! of a node, in cells
   real(dp), parameter :: coarsest = 3           !! cells of the coarsest lattice in the smallest length of the model
   real(dp), parameter :: in_supports = 2        !! cells of that in what a support holds of a body
   real(dp), parameter :: of_wave = merge(10, 20, ndim == 3) !! cells of that along the way of a wave, at most through the model
   real(dp), parameter :: most_coarse = merge(1500, 2500, ndim == 2) !! cells of the coarsest lattice, where no unit makes it finer
   real(dp), parameter :: least_part = 0.2_dp    !! of these cells that those of a unit with wishes may have
   real(dp), parameter :: most_aligned = 3e4_dp  !! cells that a unit may lead to

   !> What marks nodes, in this order: up to supports of one node they have to be nodes, then they are better nodes
   integer, parameter :: of_bodies = 1, of_narrow_supports = 2, of_cracks_at_nodes = 3, of_node_supports = 4, of_supports = 5, &
                         of_cracks = 6, of_loads = 7

   !> The lattices of a model.
   type :: lattices_t
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! corners of the box around all bodies [m]
      real(dp) :: origin(ndim) = 0               !! a node [m]
      real(dp) :: unit = 0                       !! [m]
      integer :: margin = 0                      !! cells around the bodies, into which they move
      logical :: has_axis = .false.              !! whether no cell is at a radius below 0
      logical :: has_middles = .false.           !! whether pins are in the middle of sides, where quadratic cells alone have nodes
      logical :: fits = .true.                   !! whether supports end at its nodes
      integer :: first = 1                       !! number of the coarsest: its cells are the unit over that
   contains
      procedure :: cell_size
      procedure :: overrides
   end type lattices_t

contains

   !> The lattices of a model, from its geometry.
   type(lattices_t) function new_lattices(model) result(self)
      type(model_t), intent(in) :: model
      real(dp) :: wanted
      integer :: d, k
      do d = 1, ndim
         self%lower(d) = minval([(model%bodies(k)%lower(d), k=1, size(model%bodies))])
         self%upper(d) = maxval([(model%bodies(k)%upper(d), k=1, size(model%bodies))])
      end do
      self%margin = merge(2, 1, model%method%frame == 'updated')
      self%has_axis = model%run%plane == 'axisymmetric'
      wanted = smallest_length(model, self)/coarsest
      if (model%method%time /= 'static') wanted = min(wanted, min(maxval(self%upper - self%lower), model%run%end_time* &
                                                                  largest_wave_speed(materials_of(model), 'dilatational'))/of_wave)
      wanted = max(wanted, edge_of(product(self%upper - self%lower)/most_coarse))
      call find_unit(model, wanted, self)
      self%fits = supports_fit(model, self)
      self%first = max(1, ceiling(self%unit/wanted*(1 - same)))
   end function new_lattices

   !> Whether all supports end at nodes of the coarsest lattice, or beyond all bodies. How far others hold a cell is known to the
   !> second order in the cell (`hampm_part_supports`), or not at all, and no estimated error knows of it.
   pure logical function supports_fit(model, self) result(fit)
      type(model_t), intent(in) :: model
      type(lattices_t), intent(in) :: self
      real(dp) :: ends(ndim, 2), x(ndim, 2)      ! of a support [m], [cells]
      integer :: k
      fit = .true.
      do k = 1, size(model%constraints)
         if (size(model%constraints(k)%lower) < ndim .or. size(model%constraints(k)%upper) < ndim) cycle
         ends(:, 1) = model%constraints(k)%lower
         ends(:, 2) = model%constraints(k)%upper
         x = (ends - spread(self%origin, 2, 2))/self%unit
         fit = fit .and. all(abs(x - anint(x)) <= tolerance .or. ends <= spread(self%lower + same*self%unit, 2, 2) .or. &
                             ends >= spread(self%upper - same*self%unit, 2, 2) .or. &
                             spread(ends(:, 2) - ends(:, 1) < narrow*maxval(self%upper - self%lower), 2, 2))
      end do
   end function supports_fit

   !> Cell size of one of them, for cells of this order [m].
   pure real(dp) function cell_size(self, number, order)
      class(lattices_t), intent(in) :: self
      integer, intent(in) :: number, order
      cell_size = self%unit/(number*merge(2, 1, self%has_middles .and. order == 1))
   end function cell_size

   !> The keys of &grid of one of them, `group.key=value`.
   pure function overrides(self, number, order)
      class(lattices_t), intent(in) :: self
      integer, intent(in) :: number, order
      type(string_t), allocatable :: overrides(:)
      character(:), allocatable :: lower, cells
      integer :: d, below
      lower = 'grid.lower='
      cells = 'grid.cells='
      associate (h => self%cell_size(number, order))
         do d = 1, ndim
            if (d > 1) lower = lower//','
            if (d > 1) cells = cells//','
            below = ceiling((self%origin(d) - self%lower(d))/h - same) + self%margin
            if (self%has_axis .and. d == 1) below = min(below, int(self%origin(d)/h + same))
            lower = lower//to_text(without_rounding(self%origin(d) - below*h, maxval(abs([self%lower, self%upper]))))
            cells = cells//to_text(ceiling((self%upper(d) - self%origin(d))/h*(1 - same)) + below + self%margin)
         end do
         allocate (overrides(3))
         overrides(1)%text = 'grid.cell='//to_text(h)
         overrides(2)%text = lower
         overrides(3)%text = cells
      end associate
   end function overrides

   !> The smallest length that cells have to resolve [m]: of bodies, of cracks, and of what supports hold of bodies.
   pure real(dp) function smallest_length(model, box) result(length)
      type(model_t), intent(in) :: model
      type(lattices_t), intent(in) :: box
      real(dp) :: of_crack
      integer :: k, i
      length = huge(length)
      do k = 1, size(model%bodies)
         length = min(length, minval(model%bodies(k)%upper - model%bodies(k)%lower))
      end do
      do k = 1, size(model%paths)
         associate (points => model%paths(k)%points)
            of_crack = sum([(norm(points(:, i + 1) - points(:, i)), i=1, size(points, 2) - 1)])
            if (of_crack > 0) length = min(length, of_crack)
         end associate
      end do
      do k = 1, size(model%planes)
         if (size(model%planes(k)%radii) > 0) length = min(length, minval(model%planes(k)%radii))
      end do
      do k = 1, size(model%constraints)
         associate (lower => model%constraints(k)%lower, upper => model%constraints(k)%upper)
            if (size(lower) < ndim .or. size(upper) < ndim) cycle
            associate (held => min(upper, box%upper) - max(lower, box%lower))
               if (.not. any(held >= narrow*maxval(box%upper - box%lower))) cycle
               length = min(length, coarsest/in_supports*minval(held, mask=held >= narrow*maxval(box%upper - box%lower)))
            end associate
         end associate
      end do
   end function smallest_length

   !> The largest length of which marks are multiples, from the first of each direction on: of those that have to be nodes, where
   !> that leads to few enough cells, and of so many of those that are better nodes as leave it large enough.
   subroutine find_unit(model, wanted, box)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: wanted             !! size of the cells of the coarsest lattice [m]
      type(lattices_t), intent(inout) :: box
      real(dp) :: extent, farthest               ! of the places taken from the first [m]
      logical :: is_marked(ndim), is_needed      ! whether an origin is known, and marks have to be nodes
      integer :: d, k, kind
      extent = maxval(box%upper - box%lower)
      is_marked = .false.
      box%origin = box%lower
      if (box%has_axis) is_marked(1) = .true.
      box%unit = 0
      farthest = 0
      do kind = of_bodies, of_loads
         is_needed = kind <= of_node_supports
         do d = 1, ndim
            select case (kind)
             case (of_bodies)
               do k = 1, size(model%bodies)
                  if (model%bodies(k)%shape == 'rectangle') call mark_ends(model%bodies(k)%lower, model%bodies(k)%upper, d)
               end do
             case (of_narrow_supports, of_supports)
               do k = 1, size(model%constraints)
                  associate (lower => model%constraints(k)%lower, upper => model%constraints(k)%upper)
                     if (size(lower) < ndim .or. size(upper) < ndim .or. is_point(model%constraints(k))) cycle
                     if (is_needed .and. upper(d) - lower(d) < narrow*extent) call mark(middle_of(model%constraints(k), d), d)
                     if (.not. (is_needed .or. upper(d) - lower(d) < narrow*extent)) call mark_ends(lower, upper, d)
                  end associate
               end do
             case (of_cracks_at_nodes, of_cracks)
               do k = 1, size(model%planes)
                  if (model%planes(k)%axis == d .or. .not. is_needed) call mark(model%planes(k)%center(d), d)
               end do
               do k = 1, size(model%paths)
                  associate (points => model%paths(k)%points, last => size(model%paths(k)%points, 2))
                     if (last == 0) cycle
                     if (model%paths(k)%is_symmetry .or. any(model%energy_release%chosen%needs_nodes) .or. .not. is_needed) &
                        call mark_ends(points(:, 1), points(:, last), d)
                  end associate
               end do
             case (of_node_supports)             ! nodes may be in the middle of the sides of quadratic cells
               do k = 1, size(model%constraints)
                  if (is_point(model%constraints(k))) call mark(middle_of(model%constraints(k), d), d, merge(2, 1, ndim == 2))
               end do
             case default
               do k = 1, size(model%loads)
                  if (model%loads(k)%has_place) call mark_ends(model%loads(k)%lower, model%loads(k)%upper, d)
               end do
            end select
         end do
         if (kind /= of_node_supports .or. .not. box%unit > 0) cycle
         if (product((box%upper - box%lower)/box%unit) > most_aligned) then
            box%unit = 0
            farthest = 0
         end if
      end do
      if (box%unit <= 0) box%unit = wanted
      if (farthest > 0) box%unit = without_rounding(farthest, extent)/(anint(2*farthest/box%unit)/2) ! without rounding
      do k = 1, size(model%constraints)
         if (.not. is_point(model%constraints(k))) cycle
         box%has_middles = box%has_middles .or. any([(is_off(middle_of(model%constraints(k), d), d), d=1, ndim)])
      end do

   contains

      !> Whether a support is to hold one node.
      pure logical function is_point(c)
         type(constraint_spec_t), intent(in) :: c
         is_point = size(c%lower) == ndim .and. size(c%upper) == ndim
         if (is_point) is_point = all(c%upper - c%lower < narrow*extent)
      end function is_point

      !> A coordinate of the middle of a support [m].
      pure real(dp) function middle_of(c, d)
         type(constraint_spec_t), intent(in) :: c
         integer, intent(in) :: d
         middle_of = (c%lower(d) + c%upper(d))/2
      end function middle_of

      !> Whether a coordinate is of no nodes at corners of cells.
      pure logical function is_off(x, d)
         real(dp), intent(in) :: x               !! [m]
         integer, intent(in) :: d
         is_off = abs((x - box%origin(d))/box%unit - anint((x - box%origin(d))/box%unit)) > tolerance
      end function is_off

      !> Take a coordinate of both ends of a box or a path.
      subroutine mark_ends(first, last, d)
         real(dp), intent(in) :: first(:), last(:) !! [m]
         integer, intent(in) :: d
         call mark(first(d), d)
         call mark(last(d), d)
      end subroutine mark_ends

      !> Take a coordinate within the box, where it is needed or leaves the unit large enough: of nodes at corners of cells or, at
      !> their parts, between.
      subroutine mark(x, d, parts)
         real(dp), intent(in) :: x               !! [m]
         integer, intent(in) :: d
         integer, intent(in), optional :: parts  !! of a cell; 1 by default
         real(dp) :: a, b, rest
         if (x < box%lower(d) - same*extent .or. x > box%upper(d) + same*extent) return
         if (.not. is_marked(d)) box%origin(d) = x
         is_marked(d) = .true.
         a = abs(x - box%origin(d))
         if (present(parts)) a = parts*a
         b = box%unit
         if (a <= same*extent) return
         do while (b > same*extent)
            rest = modulo(a, b)
            if (b - rest <= same*extent) rest = 0
            a = b
            b = rest
         end do
         if (.not. (is_needed .or. a >= least_part*wanted)) return
         box%unit = a
         farthest = max(farthest, abs(x - box%origin(d)))
      end subroutine mark
   end subroutine find_unit
end module hampm_lattices
