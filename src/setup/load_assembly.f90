!> Assembly of the loads of a model on its particles and on the faces of its cracks.
module hampm_load_assembly
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_absorbing_edges, only: components
   use hampm_crack_placement, only: face_normal
   use hampm_failure, only: failure_t, exit_input
   use hampm_load_placement, only: is_on_faces, find_edge_normal, into_half
   use hampm_loads, only: load_t, load_on_particles
   use hampm_edge_loads, only: lay_loads
   use hampm_edge_parts, only: edge_part_t
   use hampm_problem, only: problem_t
   use hampm_placement, only: tolerance
   use hampm_pressed_faces, only: press_faces
   use hampm_model, only: model_t, load_spec_t, path_of
   use hampm_text, only: to_text
   implicit none
   private
   public :: place_loads

contains

   !> Find where the loads act, and attach them to the particles. A pressure on a crack is several loads: one for each face along a
   !> grid line, or one for each direction of the edges of particles.
   subroutine place_loads(model, m, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(load_t), allocatable :: loads(:)
      integer :: k, n, i
      logical :: changed
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
      changed = .false.
      call lay_loads(m%loads, m%matter_t, changed)
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
                                                                                   model%grid%cell/body%points_per_cell, spec%side)]
         end associate
      end do
   end function loaded_parts

   !> Area of a part of a surface [m2].
   pure real(dp) function area_of(model, part)
      type(model_t), intent(in) :: model
      type(edge_part_t), intent(in) :: part
      area_of = part%area
      if (ndim == 2) area_of = 2*norm(part%half)*model%run%thickness%at(part%middle)
   end function area_of

   !> Parts of edges on which a load at a place acts, with their areas [m2]: of polygons, circles and bodies with holes, or else the
   !> part in its box, one for each side with a body. A point load has a part without a size.
   function edges_of(model, spec) result(parts)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(edge_part_t), allocatable :: parts(:)
      integer :: k, sides
      allocate (parts(0))
      if (spec%kind /= 'point') parts = loaded_parts(spec, model)
      if (size(parts) == 0) then
         parts = [edge_part_t(middle=(spec%lower + spec%upper)/2, half=(spec%upper - spec%lower)/2, &
                              normal=-face_normal(model, spec), area=product(spec%upper - spec%lower, &
                                                                             spec%upper - spec%lower > tolerance(model%grid)))]
         if (spec%kind /= 'point' .and. spec%face == 'none') then
            call find_edge_normal(model, spec, parts(1)%normal, sides)
            if (sides /= 1) then
               parts = [parts, parts]
               parts(2)%normal = -parts(1)%normal
            end if
         end if
      end if
      do k = 1, size(parts)
         parts(k)%area = merge(1.0_dp, area_of(model, parts(k)), spec%kind == 'point')
      end do
   end function edges_of

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
      real(dp), parameter :: everywhere(ndim) = huge(1.0_dp)
      integer :: k
      parts%per_cell = maxval(model%bodies%points_per_cell)
      associate (load => parts(1))
         load%force = spec%force
         select case (spec%kind)
         case ('body')
            call load_on_particles(m%particles, spec%lower, spec%upper, load)
         case ('gravity')
            call load_on_particles(m%particles, -everywhere, everywhere, load)
            load%force = sum(m%particles%mass(load%particle))*spec%acceleration
         case ('absorbing')
            do k = 1, size(parts)
               parts(k)%absorbs = k
               parts(k)%edges = edges_of(model, spec)
            end do
         case ('pressure')
            if (is_on_faces(spec)) then
               call place_on_faces(model, spec, parts)
            else
               call press(edges_of(model, spec), spec%pressure, parts)
            end if
         case default
            load%edges = edges_of(model, spec)
            load%edges%area = load%edges%area/sum(load%edges%area)
         end select
      end associate
   end subroutine place_load

   !> Let a pressure act on parts of edges: a load for each component, whose parts go with the normals, or one on a straight edge.
   pure subroutine press(edges, pressure, loads)
      type(edge_part_t), intent(in) :: edges(:)  !! with their areas
      real(dp), intent(in) :: pressure           !! [Pa]
      type(load_t), intent(inout) :: loads(:)
      integer :: d
      do d = 1, size(loads)
         loads(d)%edges = edges
         if (size(loads) == 1) then
            loads(d)%force = -pressure*sum(edges%area)*edges(1)%normal
            loads(d)%edges%area = edges%area/sum(edges%area)
         else
            loads(d)%force = 0
            loads(d)%force(d) = -pressure*sum(abs(edges%area*edges%normal(d))) ! its size counts where forces are compared
            loads(d)%edges%area = 0
            if (sum(abs(edges%area*edges%normal(d))) > 0) &
               loads(d)%edges%area = edges%area*edges%normal(d)/sum(abs(edges%area*edges%normal(d)))
         end if
      end do
   end subroutine press

   !> Let a pressure act on all faces of a crack.
   subroutine place_on_faces(model, spec, parts)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: spec
      type(load_t), intent(inout) :: parts(:)
      type(edge_part_t) :: edge
      integer :: k
      if (.not. model%is_half()) then
         do k = 1, size(parts)
            parts(k)%line = path_of(model, spec%crack)
            parts(k)%pressure = spec%pressure
            parts(k)%into(1 + (k - 1)/2) = 3 - 2*(1 + mod(k - 1, 2))
         end do
         return
      end if
      associate (points => model%paths(1)%points)
         edge = edge_part_t(middle=(points(:, 1) + points(:, 2))/2, half=(points(:, 2) - points(:, 1))/2, normal=-into_half(model))
      end associate
      edge%area = area_of(model, edge)
      call press([edge], spec%pressure, parts)
   end subroutine place_on_faces
end module hampm_load_assembly
