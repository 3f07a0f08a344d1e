!> Places of a model: boxes against bodies and against the nodes of the root lattice, whose positions are lower + i*cell.
module hampm_placement
   use hampm_bodies, only: points_along, points_off_lines
   use hampm_kinds, only: dp, ndim
   use hampm_model, only: model_t, grid_spec_t, body_t
   use hampm_text, only: point_text
   use hampm_tolerance, only: position_tolerance
   implicit none
   private
   public :: tolerance, upper_corner, within, overlap, nodes_touched, on_node, on_face, points_of, spacing_of, particle_number, &
             most_particles, point_text, nearest_node, reach_of

   real(dp), parameter :: most_particles = 2e9_dp   !! their indices must fit an integer

contains

   !> Distance below which two positions are the same [m].
   pure real(dp) function tolerance(grid)
      type(grid_spec_t), intent(in) :: grid
      tolerance = position_tolerance(grid%cell, grid%lower, upper_corner(grid))
   end function tolerance

   !> Upper corner of the lattice [m].
   pure function upper_corner(grid) result(upper)
      type(grid_spec_t), intent(in) :: grid
      real(dp) :: upper(ndim)
      upper = grid%lower + grid%cells*grid%cell
   end function upper_corner

   !> Whether a box lies within another one.
   pure logical function within(lower, upper, outer_lower, outer_upper, tol)
      real(dp), intent(in) :: lower(ndim), upper(ndim), outer_lower(ndim), outer_upper(ndim), tol
      within = all(lower >= outer_lower - tol) .and. all(upper <= outer_upper + tol)
   end function within

   !> Whether the inner parts of two boxes have a common point.
   pure logical function overlap(lower_1, upper_1, lower_2, upper_2, tol)
      real(dp), intent(in) :: lower_1(ndim), upper_1(ndim), lower_2(ndim), upper_2(ndim), tol
      overlap = all(min(upper_1, upper_2) - max(lower_1, lower_2) > tol)
   end function overlap

   !> Whether a box holds at least one corner of a cell of the lattice, or one of so many equal parts of a cell.
   pure logical function nodes_touched(grid, lower, upper, parts)
      type(grid_spec_t), intent(in) :: grid
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      integer, intent(in), optional :: parts     !! along a side
      real(dp) :: first(ndim), last(ndim), tol, spacing
      tol = tolerance(grid)
      spacing = grid%cell
      if (present(parts)) spacing = spacing/parts
      first = max((lower - tol - grid%lower)/spacing, 0.0_dp)
      last = min((upper + tol - grid%lower)/spacing, grid%cells*(grid%cell/spacing))
      nodes_touched = all(first <= last)
      ! After this check, both are within the lattice, which an integer can count.
      if (nodes_touched) nodes_touched = all(ceiling(first) <= floor(last))
   end function nodes_touched

   !> Whether a point is a node of the lattice.
   pure logical function on_node(grid, point)
      type(grid_spec_t), intent(in) :: grid
      real(dp), intent(in) :: point(ndim)
      on_node = nodes_touched(grid, point, point)
   end function on_node

   !> Whether a box is part of a face of a body: without extent in one direction, where it coincides with a face, and
   !> with extent in all others.
   pure logical function on_face(lower, upper, body, tol)
      real(dp), intent(in) :: lower(ndim), upper(ndim), tol
      type(body_t), intent(in) :: body
      logical :: flat(ndim), at_end(ndim)
      flat = upper - lower <= tol
      at_end = abs(lower - body%lower) <= tol .or. abs(lower - body%upper) <= tol
      on_face = count(flat) == 1 .and. all(at_end .or. .not. flat) .and. within(lower, upper, body%lower, body%upper, tol)
   end function on_face

   !> The box in which a constraint fixes nodes [m], (ndim, its two corners): its own, extended to the next line between cells where
   !> no material is between, as at the end of a body. The nodes beyond the end fix the material of the last cell, too.
   pure function reach_of(model, lower, upper) result(reach)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      real(dp) :: reach(ndim, 2), beyond(ndim, 2), at, tol
      integer :: d, k, i
      tol = tolerance(model%grid)
      reach(:, 1) = lower
      reach(:, 2) = upper
      do d = 1, ndim
         if (upper(d) - lower(d) <= tol) cycle
         do k = 1, 2
            at = (reach(d, k) - model%grid%lower(d))/model%grid%cell
            if (at < 0 .or. at > model%grid%cells(d) .or. abs(at - anint(at))*model%grid%cell <= tol) cycle
            beyond(:, 1) = lower
            beyond(:, 2) = upper
            beyond(d, 3 - k) = reach(d, k)
            beyond(d, k) = model%grid%lower(d) + model%grid%cell*merge(floor(at), ceiling(at), k == 1)
            if (any([(has_part_of(model%bodies(i), beyond, d, tol), i=1, size(model%bodies))])) cycle
            reach(d, k) = beyond(d, k)
         end do
      end do
   end function reach_of

   !> Whether a body has material within a box, beyond its end along one direction, or along it where the box has no size in others;
   !> bodies that are no boxes are sampled.
   pure logical function has_part_of(body, box, direction, tol) result(has)
      type(body_t), intent(in) :: body
      real(dp), intent(in) :: box(ndim, 2), tol  !! [m]
      integer, intent(in) :: direction
      integer, parameter :: samples = 8          ! along the direction; twice as many along others
      real(dp) :: margin(ndim), x(ndim), part
      integer :: i, j, d
      margin = -tol
      margin(direction) = tol
      has = all(min(box(:, 2), body%upper) - max(box(:, 1), body%lower) > margin)
      if (.not. (has .and. body%outline%is_there())) return
      has = .false.
      do i = 0, samples*(2*samples)**(ndim - 1) - 1
         j = i
         do d = 1, ndim
            part = merge((mod(j, samples) + 0.5_dp)/samples, real(mod(j, 2*samples), dp)/(2*samples - 1), d == direction)
            j = j/merge(samples, 2*samples, d == direction)
            x(d) = box(d, 1) + part*(box(d, 2) - box(d, 1))
         end do
         has = body%outline%covers_within(x, tol)
         if (has) return
      end do
   end function has_part_of

   !> The nearest node of the lattice to a point [m].
   pure function nearest_node(grid, point) result(node)
      type(grid_spec_t), intent(in) :: grid
      real(dp), intent(in) :: point(ndim)
      real(dp) :: node(ndim)
      node = grid%lower + grid%cell*max(0.0_dp, min(real(grid%cells, dp), anint((point - grid%lower)/grid%cell)))
   end function nearest_node

   !> Number of material points in each direction of a rectangle. None stands on a grid line, but with domains, whose edges do.
   pure function points_of(model, body) result(n)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      integer :: n(ndim)
      if (model%method%has_domains()) then
         n = points_along(body%lower, body%upper, model%grid%cell, body%points_per_cell)
      else
         n = points_off_lines(body%lower, body%upper, model%grid%cell, body%points_per_cell, model%grid%lower)
      end if
   end function points_of

   !> Distance of the material points of a body in each direction, outside cells that its edges cut [m].
   pure function spacing_of(model, body) result(spacing)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp) :: spacing(ndim)
      spacing = model%grid%cell/body%points_per_cell
      if (.not. body%outline%is_there()) spacing = (body%upper - body%lower)/points_of(model, body)
   end function spacing_of

   !> Number of material points that a body is filled with; a real number, because an integer might not hold it.
   pure real(dp) function particle_number(model, body)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp) :: spacing
      integer :: d, i
      spacing = model%grid%cell/body%points_per_cell
      if (body%outline%is_there()) then            ! approximate; those of cut cells are counted twice
         associate (n => (body%upper - body%lower)/spacing)
            particle_number = aint(body%outline%area()/spacing**ndim &
                                   + 4*sum([(product(pack(n, [(i, i=1, ndim)] /= d)), d=1, ndim)])) + 1
         end associate
         return
      end if
      particle_number = product(max(anint((body%upper - body%lower)/spacing), 1.0_dp))
      if (particle_number <= most_particles) particle_number = product(real(points_of(model, body), dp))
   end function particle_number
end module hampm_placement
