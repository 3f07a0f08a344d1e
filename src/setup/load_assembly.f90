!> From the loads of a model to what acts on its particles and on the faces of its cracks.
module hampm_load_assembly
   use hampm_kinds, only: dp, ndim
   use hampm_absorbing_edges, only: components, impedance
   use hampm_bodies, only: points_along
   use hampm_crack_placement, only: face_normal
   use hampm_failure, only: failure_t, exit_input
   use hampm_load_placement, only: is_on_faces, find_edge_normal, into_half
   use hampm_loads, only: load_t, load_on_points, load_on_parts, load_on_particles
   use hampm_edge_parts, only: edge_part_t
   use hampm_problem, only: problem_t
   use hampm_placement, only: tolerance
   use hampm_pressed_faces, only: press_faces
   use hampm_model, only: model_t, load_spec_t, path_of, plane_of
   use hampm_text, only: to_text
   implicit none
   private
   public :: place_loads

contains

   !> Attach the loads to the particles. A pressure on a crack is several: one for each face along a grid line, or for each direction in which
   !> edges of particles look.
   subroutine place_loads(model, m, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(load_t), allocatable :: loads(:)
      integer :: k, n, i
      allocate (loads(sum([(parts_of(model, model%loads(k)), k=1, size(model%loads))])))
      n = 0
      do k = 1, size(model%loads)
         i = parts_of(model, model%loads(k))
         associate (parts => loads(n + 1:n + i))
            do i = 1, size(parts)
               parts(i)%number = k
               parts(i)%history = model%loads(k)%history
               if (model%loads(k)%kind == 'pressure' .and. (any(m%materials%is_finite) .or. model%method%frame == 'updated')) &
                  parts(i)%follows = m%materials%is_finite .or. model%method%frame == 'updated'
            end do
            call place_load(model, model%loads(k), m, parts)
            n = n + size(parts)
            if (.not. allocated(parts(1)%particle)) cycle ! found below
            if (size(parts(1)%particle) == 0) call failure%report(exit_input, '&load('//to_text(k)// &
                                           '): there is no particle within its box; give it a box that holds material')
         end associate
      end do
      call move_alloc(loads, m%loads)
      call press_faces(m)
   end subroutine place_loads

   !> The parts of the edges of polygons and circles, and of bodies with holes, on which a traction acts: those in its box.
   pure function loaded_parts(spec, model) result(parts)
      type(load_spec_t), intent(in) :: spec
      type(model_t), intent(in) :: model
      type(edge_part_t), allocatable :: parts(:)
      integer :: k
      allocate (parts(0))
      do k = 1, size(model%bodies)
         associate (body => model%bodies(k))
            if (body%outline%is_there()) parts = [parts, body%outline%parts_in_box(spec%lower, spec%upper, tolerance(model%grid), &
                                                                                   model%grid%lower, &
                                                                                   model%grid%cell/body%points_per_cell)]
         end associate
      end do
   end function loaded_parts

   !> Area of a part of a surface [m2].
   pure real(dp) function area_of(model, part)
      type(model_t), intent(in) :: model
      type(edge_part_t), intent(in) :: part
      area_of = part%area
      if (ndim == 2) area_of = 2*norm2(part%half)*model%run%thickness%at(part%middle)
   end function area_of

   !> Length of a straight part of an edge [m], or area of a rectangle between two corners along the grid [m2].
   pure real(dp) function size_between(model, from, to) result(size)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      if (ndim == 2) then
         size = norm2(to - from)
      else
         size = product(pack(abs(to - from), abs(to - from) > tolerance(model%grid)))
      end if
   end function size_between

   !> How many loads of the motion a load of the model is.
   pure integer function parts_of(model, spec)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      parts_of = 1
      if (spec%kind == 'absorbing') parts_of = components
      if (spec%kind == 'pressure' .and. .not. is_on_faces(spec)) then
         if (size(loaded_parts(spec, model)) > 0) parts_of = ndim
      end if
      if (.not. is_on_faces(spec)) return
      parts_of = merge(1, 2*ndim, model%is_half())
   end function parts_of

   !> Attach a load to the particles.
   subroutine place_load(model, spec, m, parts)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(problem_t), intent(in) :: m
      type(load_t), intent(inout) :: parts(:)
      type(edge_part_t), allocatable :: edge(:)
      real(dp), parameter :: everywhere(ndim) = huge(1.0_dp)
      real(dp), allocatable :: area(:)           ! in proportion to those of edges
      real(dp) :: normal(ndim)
      integer :: sides, k
      associate (load => parts(1))
         if (spec%kind == 'absorbing') then
            call place_dashpots(model, spec, m, parts)
            return
         end if
         load%force = spec%force
         select case (spec%kind)
         case ('body')
            call load_on_particles(m%particles, spec%lower, spec%upper, load)
         case ('gravity')
            call load_on_particles(m%particles, -everywhere, everywhere, load)
            load%force = sum(m%particles%mass(load%particle))*spec%acceleration
         case ('pressure')
            if (is_on_faces(spec)) then
               call place_on_faces(model, spec, m, parts)
            else if (size(parts) > 1) then
               call press_parts(model, spec, m, parts)
            else
               call find_edge_normal(model, spec, normal, sides)
               call press_segment(model, m, spec%lower, spec%upper, -normal, spec%pressure, load)
            end if
         case default
            edge = loaded_parts(spec, model)
            if (spec%kind == 'traction' .and. size(edge) > 0) then
               area = [(area_of(model, edge(k)), k=1, size(edge))]
               call load_on_parts(m%matter_t, edge, area/sum(area), load)
            else
               call load_on_segment(model, m, spec%lower, spec%upper, face_normal(model, spec), load)
            end if
         end select
      end associate
   end subroutine place_load

   !> Let a pressure act on parts of slanted sides and arcs: a load for each component, whose parts go with the normals.
   subroutine press_parts(model, spec, m, loads)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(problem_t), intent(in) :: m
      type(load_t), intent(inout) :: loads(ndim)
      type(edge_part_t), allocatable :: edge(:)
      integer :: d, k
      allocate (edge, source=loaded_parts(spec, model))
      do d = 1, ndim
         loads(d)%force = 0
         loads(d)%force(d) = -spec%pressure
         call load_on_parts(m%matter_t, edge, [(area_of(model, edge(k))*edge(k)%normal(d), k=1, size(edge))], loads(d), &
                            in_halves=model%method%frame == 'updated')
      end do
   end subroutine press_parts

   !> Let dashpots act on parts of edges: a load for each component of the area times Z.
   subroutine place_dashpots(model, spec, m, loads)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(problem_t), intent(in) :: m
      type(load_t), intent(inout) :: loads(components)
      type(edge_part_t), allocatable :: edge(:)
      type(load_t) :: points                     ! with areas as their parts
      real(dp) :: normal(ndim), z(components)
      integer :: k, c, sides
      allocate (edge, source=loaded_parts(spec, model))
      if (size(edge) > 0) then
         call load_on_parts(m%matter_t, edge, [(area_of(model, edge(k)), k=1, size(edge))], points)
      else
         call find_edge_normal(model, spec, normal, sides)
         call load_on_segment(model, m, spec%lower, spec%upper, 0*normal, points)
         points%fraction = points%fraction*size_between(model, spec%lower, spec%upper) &
                           *model%run%thickness%at((spec%lower + spec%upper)/2)
      end if
      do c = 1, components
         points%absorbs = c
         loads(c) = points
      end do
      do k = 1, size(points%particle)
         if (size(edge) > 0) normal = edge(1 + (k - 1)*size(edge)/size(points%particle))%normal
         z = impedance(m%materials(m%particles%material(points%particle(k))), normal)
         do c = 1, components
            loads(c)%fraction(k) = points%fraction(k)*z(c)
         end do
      end do
   end subroutine place_dashpots

   !> Let a pressure act on all faces of a crack.
   subroutine place_on_faces(model, spec, m, parts)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(problem_t), intent(in) :: m
      type(load_t), intent(inout) :: parts(:)
      integer :: k
      if (.not. model%is_half()) then
         do k = 1, size(parts)
            parts(k)%line = max(path_of(model, spec%crack), plane_of(model, spec%crack))
            parts(k)%pressure = spec%pressure
            parts(k)%into(1 + (k - 1)/2) = 3 - 2*(1 + mod(k - 1, 2))
         end do
         return
      end if
      associate (points => model%paths(1)%points)
         call press_segment(model, m, points(:, 1), points(:, 2), into_half(model), spec%pressure, parts(1))
      end associate
   end subroutine place_on_faces

   !> A pressure on a straight part of a surface: its resultant from its length, the unit vector into the material and the thickness.
   subroutine press_segment(model, m, from, to, into, pressure, load)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: from(ndim), to(ndim) !! its ends [m]
      real(dp), intent(in) :: into(ndim)
      real(dp), intent(in) :: pressure           !! [Pa]
      type(load_t), intent(inout) :: load
      load%force = pressure*size_between(model, from, to)*model%run%thickness%at((from + to)/2)*into
      call load_on_segment(model, m, from, to, into, load)
   end subroutine press_segment

   !> Attach a point load or a traction: at the point, or at the centres of equal parts of the segment, as many as the densest body has
   !> particles along it.
   subroutine load_on_segment(model, m, from, to, toward, load)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: from(ndim), to(ndim) !! its ends [m]
      real(dp), intent(in) :: toward(ndim)       !! unit vector into the material at the face of a crack; 0 elsewhere
      type(load_t), intent(inout) :: load
      real(dp), allocatable :: x(:, :)
      integer :: n(ndim), at(ndim), k, d
      n = points_along(min(from, to), max(from, to), model%grid%cell, maxval(model%bodies%points_per_cell))
      if (ndim == 2) n(:2) = [maxval(n), 1]      ! of a segment that may be slanted
      allocate (x(ndim, product(n)))
      do k = 1, size(x, 2)
         at = [(mod((k - 1)/product(n(:d - 1)), n(d)), d=1, ndim)]
         if (ndim == 2) at(2) = at(1)
         x(:, k) = from + (at + 0.5_dp)/merge(n(1), n, ndim == 2)*(to - from)
      end do
      call load_on_points(m%matter_t, x, (to - from)/(2*merge(n(1), n, ndim == 2)), load, toward)
   end subroutine load_on_segment
end module hampm_load_assembly
