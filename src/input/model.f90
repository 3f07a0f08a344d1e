!> A validated model in SI units: one type for each group of the namelist. Keys and their reading are beside these types in the
!> modules of the groups.
module hampm_model
   use hampm_body_group, only: body_t, hole_t, fill_bodies, fill_holes
   use hampm_edge_parts, only: edge_part_t
   use hampm_outline, only: outline_t
   use hampm_load_groups, only: constraint_spec_t, fill_constraints, load_spec_t, fill_loads
   use hampm_indicator, only: indicator_row_t, refine_t
   use hampm_indicators, only: indicators
   use hampm_kinds, only: dp, ndim, plane
   use hampm_cohesive_group, only: cohesive_t, fill_cohesive
   use hampm_cycles_group, only: cycles_t, fill_cycles
   use hampm_control_group, only: control_t, fill_control
   use hampm_crack_groups, only: crack_spec_t, fill_cracks, energy_release_t, fill_energy_release, growth_t, fill_growth
   use hampm_group_values, only: accuracy_keys_t, damping_t, grid_spec_t, groups_t, output_t, take_accuracy, take_contact, &
                                 take_groups, take_method, take_run
   use hampm_plain_groups, only: run_t, body_contact_spec_t, method_t
   use hampm_material_group, only: material_spec_t, fill_materials
   use hampm_nucleation_group, only: nucleation_t, fill_nucleations
   use hampm_probe_group, only: probe_t, fill_probes
   use hampm_settings, only: settings_t
   use hampm_tensors, only: norm, quarter_turn
   use hampm_tolerance, only: position_tolerance
   implicit none
   private
   public :: model_t, fill_model, area_around, path_of, cuts_cells, has_shapes, cracks_cut_cells, mass_acts, &
             mass_used, run_t, grid_spec_t, material_spec_t, body_t, constraint_spec_t, load_spec_t, &
             damping_t, body_contact_spec_t, method_t, refine_t, crack_spec_t, growth_t, energy_release_t, probe_t, output_t

   !> All groups: grid, damping, refine, output and others that are no more than their keys, and these.
   type, extends(groups_t) :: model_t
      type(run_t) :: run
      type(material_spec_t), allocatable :: materials(:) !! of which there are bodies
      type(body_t), allocatable :: bodies(:)
      type(hole_t), allocatable :: holes(:)      !! &body with hole = .true.
      type(constraint_spec_t), allocatable :: constraints(:)
      type(load_spec_t), allocatable :: loads(:)
      type(body_contact_spec_t) :: contact
      type(method_t) :: method
      type(crack_spec_t), allocatable :: paths(:) !! cracks of the plane
      type(crack_spec_t), allocatable :: planes(:) !! those of solids
      type(cohesive_t), allocatable :: cohesive(:)
      type(growth_t), allocatable :: growth(:)
      type(nucleation_t), allocatable :: nucleations(:)
      type(control_t) :: control
      type(cycles_t) :: cycles
      type(energy_release_t) :: energy_release
      type(probe_t), allocatable :: probes(:)
      type(accuracy_keys_t), allocatable :: accuracy(:) !! errors that are asked
      logical :: lacks_lattice = .false.         !! whether its lattice is to be chosen, and it is known but for that
      character(:), allocatable :: as_used       !! complete namelist text: every key with the value in force
      character(:), allocatable :: as_begun      !! the same at the begin of the run, before it was resumed with other values
      character(:), allocatable :: warned        !! warnings of the table of rules, a line each
      character(:), allocatable :: noted         !! its notes, a line each
   contains
      procedure :: is_half
   end type model_t

contains

   !> Whether its bodies are one half of a symmetric model, with a crack on the symmetry plane.
   pure logical function is_half(self)
      class(model_t), intent(in) :: self
      is_half = any(self%paths%is_symmetry)
   end function is_half

   !> Whether the mass matrix acts: in motion, and where stress is extrapolated by it.
   pure logical function mass_acts(model)
      type(model_t), intent(in) :: model
      mass_acts = model%method%time /= 'static' .or. any(model%energy_release%chosen%needs_mass)
   end function mass_acts

   !> The mass matrix that a run has: nodes have no more than masses where it does not act.
   pure function mass_used(model) result(mass)
      type(model_t), intent(in) :: model
      character(:), allocatable :: mass
      mass = 'lumped'
      if (mass_acts(model)) mass = trim(model%method%mass)
   end function mass_used

   !> Fill a model from validated settings.
   pure subroutine fill_model(settings, model)
      type(settings_t), intent(in) :: settings
      type(model_t), intent(inout) :: model
      type(crack_spec_t), allocatable :: cracks(:)
      integer :: k
      call take_groups(settings, model)
      call take_run(settings, settings%find('run', 1), model%run)
      model%run%thickness%of_plate = merge(settings%number(settings%find('run', 1), 'thickness'), 1.0_dp, ndim == plane)
      model%run%thickness%is_ring = model%run%plane == 'axisymmetric'
      call take_contact(settings, settings%find('contact', 1), model%contact)
      call take_method(settings, settings%find('method', 1), model%method)
      call choose_indicator(model%refine)
      call fill_materials(settings, model%materials)
      call fill_bodies(settings, model%bodies)
      call fill_holes(settings, model%bodies, model%holes)
      call fill_constraints(settings, model%constraints)
      call fill_loads(settings, model%loads)
      call fill_cracks(settings, cracks)
      model%paths = cracks(:merge(size(cracks), 0, ndim == plane))
      model%planes = cracks(size(model%paths) + 1:)
      call fill_cohesive(settings, model%cohesive)
      call fill_growth(settings, model%growth)
      call fill_nucleations(settings, model%nucleations)
      call fill_control(settings, model%control)
      call fill_cycles(settings, model%cycles)
      call fill_energy_release(settings, model%energy_release)
      call fill_probes(settings, model%probes)
      allocate (model%accuracy(settings%count_of('accuracy')))
      do k = 1, size(model%accuracy)
         call take_accuracy(settings, settings%find('accuracy', k), model%accuracy(k))
      end do
      call find_materials(model)
      call take_sides(settings, model)
      call place_lines(model)
      call find_growing_paths(model)
   end subroutine fill_model

   !> Choose the indicator of cell refinement.
   pure subroutine choose_indicator(refine)
      type(refine_t), intent(inout) :: refine
      type(indicator_row_t), allocatable :: rows(:)
      integer :: k
      allocate (rows, source=indicators())
      k = findloc(rows%name == refine%indicator, .true., dim=1)
      if (k > 0) refine%by = rows(k)%indicator_t
   end subroutine choose_indicator

   !> Find the material of each body by its name; 0 if unknown. Materials without a body are left out; materials that differ by name
   !> only become the first of them.
   pure subroutine find_materials(model)
      type(model_t), intent(inout) :: model
      type(material_spec_t), allocatable :: used(:)
      logical :: is_used(size(model%materials))
      integer :: i, k
      do i = 1, size(model%bodies)
         model%bodies(i)%material_index = findloc(model%materials%name == model%bodies(i)%material, .true., dim=1, back=.true.)
      end do
      is_used = [(any(model%bodies%material_index == k), k=1, size(is_used))]
      allocate (used(count(is_used)))
      do k = 1, size(is_used)
         if (is_used(k)) used(count(is_used(:k))) = model%materials(k)
      end do
      do i = 1, size(model%bodies)
         model%bodies(i)%material_index = count(is_used(:model%bodies(i)%material_index))
      end do
      call move_alloc(used, model%materials)
      do i = 1, size(model%bodies)
         associate (index => model%bodies(i)%material_index)
            do k = index - 1, 1, -1
               if (model%materials(k)%is_the_same_as(model%materials(index))) index = k
            end do
         end associate
      end do
   end subroutine find_materials

   !> End the boxes of loads on a side at its ends.
   pure subroutine take_sides(settings, model)
      type(settings_t), intent(in) :: settings
      type(model_t), intent(inout) :: model
      type(outline_t) :: outline
      type(edge_part_t), allocatable :: parts(:)
      real(dp) :: lower(ndim), upper(ndim)        ! of the box without the side [m]
      integer :: k, b, i
      do k = 1, size(model%loads)
         associate (load => model%loads(k), grid => model%grid)
            if (load%side == 0 .or. ndim > 2) cycle
            load%of_outlines = 0
            if (.not. grid%cell > 0) cycle
            lower = load%lower
            upper = load%upper
            if (size(settings%numbers(settings%find('load', k), 'lower')) == 0) then
               lower = grid%lower
               upper = grid%lower + grid%cells*grid%cell
            end if
            do b = 1, size(model%bodies)
               outline = model%bodies(b)%whole_outline()
               parts = outline%parts_in_box(lower, upper, position_tolerance(grid%cell, grid%lower, grid%lower + &
                                            grid%cells*grid%cell), lower, sqrt(huge(1.0_dp)), load%side)
               if (size(parts) == 0) cycle
               load%of_outlines = load%of_outlines + count([(any(parts%ring == i), i=1, size(outline%rings))])
               load%lower = [(minval(parts%middle(i) - abs(parts%half(i))), i=1, ndim)]
               load%upper = [(maxval(parts%middle(i) + abs(parts%half(i))), i=1, ndim)]
            end do
         end associate
      end do
   end subroutine take_sides

   !> Find the other ends of straight cracks given by a tip: at their length or, without one or with a longer one, at the end of one
   !> of the faces.
   pure subroutine place_lines(model)
      type(model_t), intent(inout) :: model
      real(dp) :: reach
      integer :: k
      do k = 1, size(model%paths)
         associate (path => model%paths(k))
            if (path%key /= 'tip' .or. size(path%points, 2) /= 1) cycle
            if (.not. (norm(path%direction) > 0 .and. model%grid%cell > 0)) cycle
            path%direction = path%direction/norm(path%direction)
            reach = max(way_out(model, path%points(:, 1), -path%direction), model%grid%cell)
            if (path%length > 0) reach = min(reach, path%length)
            path%points = reshape([path%points(:, 1) - reach*path%direction, path%points(:, 1)], [ndim, 2])
         end associate
      end do
   end subroutine place_lines

   !> Distance from a point in a direction to the end of material on one side, on a symmetry plane on both [m].
   pure real(dp) function way_out(model, from, direction) result(way)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      integer, parameter :: looks = 8, halvings = 50 ! samples in a cell
      real(dp) :: step, nodes(ndim)
      integer :: k
      step = model%grid%cell/looks
      way = 0
      do k = 1, looks*sum(model%grid%cells)
         if (.not. has_sides(way + step)) exit
         way = way + step
      end do
      do k = 1, halvings
         step = step/2
         if (has_sides(way + step)) way = way + step
      end do
      associate (grid => model%grid, x => from + way*direction) ! without the rounding of this
         nodes = grid%lower + grid%cell*anint((x - grid%lower)/grid%cell)
         if (all(abs(nodes - x) <= position_tolerance(grid%cell, grid%lower, grid%lower + grid%cells*grid%cell))) &
            way = dot_product(nodes - from, direction)
      end associate

   contains

      !> Whether there is material at both sides so far on the way.
      pure logical function has_sides(way)
         real(dp), intent(in) :: way             !! [m]
         real(dp), parameter :: beside = 1e-3_dp, looked_at = 1e-7_dp ! [cells]
         real(dp) :: areas(2)
         integer :: side
         areas = [(area_around(model, from + way*direction + side*beside*model%grid%cell*quarter_turn(direction), &
                                       looked_at*model%grid%cell), side=-1, 1, 2)]
         has_sides = merge(sum(areas), minval(areas), model%is_half()) >= 2*(looked_at*model%grid%cell)**2 ! half of it
      end function has_sides
   end function way_out

   !> Area of material that cracks may be in, in the box around a point [m2].
   pure real(dp) function area_around(model, x, reach) result(area)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: reach              !! half of the width of the box [m]
      integer :: i
      area = 0
      do i = 1, size(model%bodies)
         if (may_have_cracks(i)) area = area + model%bodies(i)%area_in(x - reach, x + reach)
      end do
   contains
      !> Whether a body is the first or of its contact group: others are separate from the cracked material, also in touch with it.
      pure logical function may_have_cracks(body)
         integer, intent(in) :: body
         associate (part => model%bodies%contact_group)
            may_have_cracks = body == 1 .or. .not. model%contact%is_wanted() .or. part(1) /= '' .and. part(body) == part(1)
         end associate
      end function may_have_cracks
   end function area_around

   !> Find the crack of each cohesion and growth by its name, or the only one; 0 if there is none.
   pure subroutine find_growing_paths(model)
      type(model_t), intent(inout) :: model
      integer :: i
      do i = 1, size(model%cohesive)
         associate (cohesive => model%cohesive(i))
            cohesive%path = min(path_of(model, cohesive%crack), size(model%paths)) ! no planes
            if (cohesive%path > 0) model%paths(cohesive%path)%held_from = cohesive%from
         end associate
      end do
      do i = 1, size(model%growth)
         model%growth(i)%path = path_of(model, model%growth(i)%crack)
      end do
      do i = 1, size(model%nucleations)
         model%nucleations(i)%path = min(path_of(model, model%nucleations(i)%crack), size(model%paths))
      end do
      do i = 1, size(model%paths)
         model%paths(i)%at_nodes = model%paths(i)%is_symmetry .or. runs_along_cells(model, i) .and. &
                                   .not. (any(model%growth%path == i) .or. any(model%nucleations%path == i) .or. &
                                          model%paths(i)%held_from > 0)
      end do
   end subroutine find_growing_paths

   !> Number of the crack with a name, or of the only crack without one; 0 if there is none.
   pure integer function path_of(model, name)
      type(model_t), intent(in) :: model
      character(*), intent(in) :: name
      associate (names => [model%paths%name, model%planes%name]) ! of which one is empty
         do path_of = size(names), 1, -1
            if (merge(size(names) == 1, names(path_of) == name, name == '')) return
         end do
      end associate
   end function path_of

   !> Whether cracks, or edges of bodies that are no rectangles, cut cells.
   pure logical function cuts_cells(model)
      type(model_t), intent(in) :: model
      cuts_cells = cracks_cut_cells(model) .or. has_shapes(model)
   end function cuts_cells

   !> Whether any body is no mere rectangle.
   pure logical function has_shapes(model)
      type(model_t), intent(in) :: model
      integer :: k
      has_shapes = any([(model%bodies(k)%outline%is_there(), k=1, size(model%bodies))])
   end function has_shapes

   !> Whether cracks cut cells: all except fixed ones along grid lines, with tips at nodes.
   pure logical function cracks_cut_cells(model) result(cut)
      type(model_t), intent(in) :: model
      cut = .not. all(model%paths%at_nodes) .or. .not. all(model%paths%is_symmetry) .and. model%method%frame == 'updated'
   end function cracks_cut_cells

   !> Whether the k-th path is along grid lines with its points at nodes of the lattice; ends at surfaces and beyond are exempt.
   !> True if unknown, as one of them is wrong.
   pure logical function runs_along_cells(model, k) result(along)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp) :: tol
      logical :: on_line(ndim)
      integer :: i, n
      associate (grid => model%grid, points => model%paths(k)%points, within => 1e-3_dp*model%grid%cell)
         n = size(points, 2)
         along = .true.
         if (.not. grid%cell > 0 .or. n < 2) return
         tol = position_tolerance(grid%cell, grid%lower, grid%lower + grid%cells*grid%cell)
         along = all([(count(abs(points(:, i) - points(:, i - 1)) > tol) == 1, i=2, n)])
         do i = 1, n
            on_line = abs(points(:, i) - grid%lower - grid%cell*anint((points(:, i) - grid%lower)/grid%cell)) <= tol
            if (any(i == [1, n]) .and. area_around(model, points(:, i), within) < (2*within)**2 - 4*within*tol) &
               on_line = on_line .or. abs(points(:, i) - points(:, merge(2, n - 1, i == 1))) > tol
            along = along .and. all(on_line)
         end do
      end associate
   end function runs_along_cells
end module hampm_model
