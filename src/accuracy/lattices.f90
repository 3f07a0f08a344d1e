!> Lattices that fit a model: their nodes are where edges, supports and tips are, as far as one cell size allows.
!>
!> All coordinates that are to be nodes are multiples of a unit, their greatest common divisor by Euclid's algorithm, from the lower
!> corner of all bodies. The cells of the lattices are this unit over 1, 2, 3, ...
module hampm_lattices
   use hampm_kinds, only: dp, ndim
   use hampm_model, only: model_t
   use hampm_tensors, only: norm
   use hampm_text, only: string_t, to_text, without_rounding
   implicit none
   private
   public :: lattices_t, new_lattices

   real(dp), parameter :: same = 1e-7_dp         !! part of the size of all bodies within which places are the same
   real(dp), parameter :: narrow = 0.01_dp       !! part of that up to which a box of supports is to hold the nodes of one line
   real(dp), parameter :: tolerance = 1e-6_dp    !! of a node, in cells
   real(dp), parameter :: coarsest = 3           !! cells of the coarsest lattice in the smallest length of the model
   real(dp), parameter :: most_coarse = merge(1500, 2500, ndim == 2) !! cells of the coarsest lattice, where no unit makes it finer
   real(dp), parameter :: least_part = 0.2_dp    !! of these cells that those of a unit with all wishes may have
   real(dp), parameter :: most_aligned = 3e4_dp  !! cells that a unit may lead to

   !> The lattices of a model.
   type :: lattices_t
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! corners of the box around all bodies [m]
      real(dp) :: unit = 0                       !! [m]
      integer :: margin = 0                      !! cells around the bodies, into which they move
      logical :: has_axis = .false.              !! whether no cell is at a radius below 0
      logical :: fits = .true.                   !! whether boxes of supports and of loads on material end at its nodes
      integer :: first = 1                       !! number of the coarsest: its cells are the unit over that
   contains
      procedure :: cell_size
      procedure :: overrides
   end type lattices_t

contains

   !> The lattices of a model, from its geometry.
   type(lattices_t) function new_lattices(model) result(self)
      type(model_t), intent(in) :: model
      real(dp) :: wanted, all_marks, needed
      integer :: d, k
      do d = 1, ndim
         self%lower(d) = minval([(model%bodies(k)%lower(d), k=1, size(model%bodies))])
         self%upper(d) = maxval([(model%bodies(k)%upper(d), k=1, size(model%bodies))])
      end do
      self%margin = merge(2, 1, model%method%frame == 'updated')
      self%has_axis = model%run%plane == 'axisymmetric'
      wanted = max(smallest_length(model)/coarsest, (product(self%upper - self%lower)/most_coarse)**(1/real(ndim, dp)))
      all_marks = unit_of(model, self, only_needed=.false.)
      needed = unit_of(model, self, only_needed=.true.)
      self%unit = wanted
      if (product((self%upper - self%lower)/max(needed, tiny(needed)**0.25_dp)) <= most_aligned) self%unit = needed
      if (all_marks >= least_part*wanted) self%unit = all_marks
      self%unit = without_rounding(self%unit, maxval(self%upper - self%lower))
      self%fits = boxes_fit(model, self)
      self%first = max(1, ceiling(self%unit/wanted*(1 - same)))
   end function new_lattices

   !> Whether all boxes of supports and of loads on material end at nodes of the coarsest lattice, or beyond all bodies. What others
   !> hold or load depends on the cells, and no estimated error knows of it.
   pure logical function boxes_fit(model, self) result(fit)
      type(model_t), intent(in) :: model
      type(lattices_t), intent(in) :: self
      integer :: k
      fit = .true.
      do k = 1, size(model%constraints)
         associate (lower => model%constraints(k)%lower, upper => model%constraints(k)%upper)
            if (size(lower) == ndim .and. size(upper) == ndim) fit = fit .and. are_nodes(lower) .and. are_nodes(upper)
         end associate
      end do
      do k = 1, size(model%loads)
         if (model%loads(k)%kind /= 'body' .or. .not. model%loads(k)%has_place) cycle
         fit = fit .and. are_nodes(model%loads(k)%lower) .and. are_nodes(model%loads(k)%upper)
      end do

   contains

      !> Whether each coordinate of a corner is of nodes, or outside.
      pure logical function are_nodes(corner)
         real(dp), intent(in) :: corner(ndim)    !! [m]
         real(dp) :: x(ndim)
         x = (corner - self%lower)/self%unit
         are_nodes = all(abs(x - anint(x)) <= tolerance .or. corner <= self%lower + same*self%unit .or. &
                         corner >= self%upper - same*self%unit)
      end function are_nodes
   end function boxes_fit

   !> Cell size of one of them [m].
   pure real(dp) function cell_size(self, number)
      class(lattices_t), intent(in) :: self
      integer, intent(in) :: number
      cell_size = self%unit/number
   end function cell_size

   !> The keys of &grid of one of them, `group.key=value`.
   pure function overrides(self, number)
      class(lattices_t), intent(in) :: self
      integer, intent(in) :: number
      type(string_t), allocatable :: overrides(:)
      character(:), allocatable :: lower, cells
      integer :: d, below
      lower = 'grid.lower='
      cells = 'grid.cells='
      associate (h => self%cell_size(number))
         do d = 1, ndim
            if (d > 1) lower = lower//','
            if (d > 1) cells = cells//','
            below = self%margin
            if (self%has_axis .and. d == 1) below = min(below, int(self%lower(d)/h + same))
            lower = lower//to_text(without_rounding(self%lower(d) - below*h, maxval(abs([self%lower, self%upper]))))
            cells = cells//to_text(ceiling((self%upper(d) - self%lower(d))/h*(1 - same)) + below + self%margin)
         end do
         allocate (overrides(3))
         overrides(1)%text = 'grid.cell='//to_text(h)
         overrides(2)%text = lower
         overrides(3)%text = cells
      end associate
   end function overrides

   !> The smallest length that cells have to resolve [m]: of bodies, of cracks, and from their ends to the ends of the bodies.
   pure real(dp) function smallest_length(model) result(length)
      type(model_t), intent(in) :: model
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
   end function smallest_length

   !> The largest length of which all marks are multiples, from the lower corner on [m]; 0 where they have none.
   pure real(dp) function unit_of(model, box, only_needed) result(unit)
      type(model_t), intent(in) :: model
      type(lattices_t), intent(in) :: box
      logical, intent(in) :: only_needed         !! marks that have to be nodes, else also those that are better so
      real(dp) :: extent
      integer :: d, k
      extent = maxval(box%upper - box%lower)
      unit = 0
      do d = 1, ndim
         do k = 1, size(model%bodies)
            if (model%bodies(k)%shape /= 'rectangle') cycle
            call mark(model%bodies(k)%lower(d), d)
            call mark(model%bodies(k)%upper(d), d)
         end do
         do k = 1, size(model%constraints)
            associate (lower => model%constraints(k)%lower, upper => model%constraints(k)%upper)
               if (size(lower) < ndim .or. size(upper) < ndim) cycle
               if (upper(d) - lower(d) < narrow*extent) then
                  call mark((lower(d) + upper(d))/2, d)
               else if (.not. only_needed) then
                  call mark(lower(d), d)
                  call mark(upper(d), d)
               end if
            end associate
         end do
         do k = 1, size(model%planes)
            if (model%planes(k)%axis == d .or. .not. only_needed) call mark(model%planes(k)%center(d), d)
         end do
         do k = 1, size(model%paths)
            if (size(model%paths(k)%points, 2) == 0) cycle
            if (only_needed .and. .not. (model%paths(k)%is_symmetry .or. any(model%energy_release%chosen%needs_nodes))) cycle
            call mark(model%paths(k)%points(d, 1), d)
            call mark(model%paths(k)%points(d, size(model%paths(k)%points, 2)), d)
         end do
         if (only_needed) cycle
         do k = 1, size(model%loads)
            if (.not. model%loads(k)%has_place) cycle
            call mark(model%loads(k)%lower(d), d)
            call mark(model%loads(k)%upper(d), d)
         end do
      end do

   contains

      !> Take a coordinate within the box.
      pure subroutine mark(x, d)
         real(dp), intent(in) :: x               !! [m]
         integer, intent(in) :: d
         real(dp) :: a, b, rest
         if (x < box%lower(d) - same*extent .or. x > box%upper(d) + same*extent) return
         a = x - box%lower(d)
         b = unit
         if (a <= same*extent) return
         do while (b > same*extent)
            rest = modulo(a, b)
            if (b - rest <= same*extent) rest = 0
            a = b
            b = rest
         end do
         unit = a
      end subroutine mark
   end function unit_of
end module hampm_lattices
