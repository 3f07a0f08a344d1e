!> Whether constraints and loads act on something: on nodes of the lattice, on material.
module hampm_load_consistency
   use hampm_load_groups, only: check_history
   use hampm_joints, only: holds_material
   use hampm_kinds, only: dp, ndim, plane
   use hampm_crack_placement, only: path_at
   use hampm_load_placement, only: is_on_faces, find_edge_normal
   use hampm_placement, only: tolerance, nodes_touched, point_text
   use hampm_model, only: model_t, load_spec_t, constraint_spec_t, path_of, has_shapes
   use hampm_settings, only: settings_t
   use hampm_shape_consistency, only: comes_near_edges
   implicit none
   private
   public :: check_constraints, check_loads, check_name, bodies_good

   character(*), parameter :: an_edge = trim(merge('a side ', 'an edge', ndim > 2)) !! carrier of a traction

contains

   !> The box of a constraint holds at least one node of the lattice, and in the total frame material.
   pure subroutine check_constraints(model, settings, has_grid)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_grid
      logical :: is_total
      integer :: i, entry
      is_total = settings%good(settings%find('method', 1), 'frame') .and. model%method%frame == 'total'
      do i = 1, size(model%constraints)
         entry = settings%find('constraint', i)
         call check_history(model%constraints(i)%motion%history, entry, settings)
         call check_motion(model%constraints(i), entry, settings)
         call check_name(model%constraints(:i)%name, 'constraint', entry, settings)
         if (.not. (settings%good(entry, 'lower') .and. settings%good(entry, 'upper'))) cycle
         associate (constraint => model%constraints(i))
            if (any(constraint%upper < constraint%lower)) then
               call settings%complain(entry, 'upper', 'must not be below lower = '//point_text(constraint%lower))
            else if (has_grid) then
               if (.not. nodes_touched(model%grid, constraint%lower, constraint%upper, max(1, model%grid%order))) then
                  call settings%complain(entry, 'lower', 'the box up to '//point_text(constraint%upper)// &
                                         ' must hold at least one node of the grid (nodes are at lower + i*cell, of quadratic '// &
                                         'cells in the middle of their sides too)')
               else if (is_total .and. bodies_good(settings)) then
                  if (.not. holds_material(model, constraint%lower, constraint%upper)) &
                     call settings%complain(entry, 'lower', 'the box up to '//point_text(constraint%upper)// &
                                            ' must hold a node of a cell with material: in frame = ''total'' none comes there '// &
                                            'later, and the constraint would hold nothing')
               end if
            end if
         end associate
      end do
   end subroutine check_constraints

   !> The last of some names is unique and valid for a column; '' is none.
   pure subroutine check_name(names, group, entry, settings)
      character(*), intent(in) :: names(:)
      character(*), intent(in) :: group            !! name of the groups that have these
      integer, intent(in) :: entry                 !! position of that with the last one
      type(settings_t), intent(inout) :: settings
      character(*), parameter :: allowed = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_'
      associate (name => names(size(names)))
         if (name == '') return
         if (verify(trim(name), allowed) > 0) then
            call settings%complain(entry, 'name', 'must be of letters, digits and _, as names of columns are')
         else if (any(names(:size(names) - 1) == name)) then
            call settings%complain(entry, 'name', 'must differ from the name of every other '//group)
         end if
      end associate
   end subroutine check_name

   !> A prescribed component must be fixed.
   pure subroutine check_motion(constraint, entry, settings)
      type(constraint_spec_t), intent(in) :: constraint
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(inout) :: settings
      if (.not. (settings%good(entry, 'displacement') .and. settings%good(entry, 'velocity') .and. settings%good(entry, 'fix'))) &
         return
      associate (motion => constraint%motion)
         if (any((abs(motion%displacement) > 0 .or. abs(motion%velocity) > 0) .and. .not. constraint%fixed)) &
            call settings%complain(entry, trim(merge('displacement', 'velocity    ', &
                                                               any(abs(motion%displacement) > 0))), &
                                   'must be 0 in the direction that fix does not name')
      end associate
   end subroutine check_motion

   !> Loads act on material and have a complete history.
   pure subroutine check_loads(model, settings, has_geometry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_geometry        !! whether grid and bodies are without errors
      integer :: i, entry
      do i = 1, size(model%loads)
         entry = settings%find('load', i)
         call check_history(model%loads(i)%history, entry, settings)
         call check_name(model%loads(:i)%name, 'load', entry, settings)
         if (.not. settings%good(entry, 'kind')) cycle
         if (is_on_faces(model%loads(i))) call check_pressed(model, model%loads(i), entry, settings)
         if (any([size(settings%numbers(entry, 'lower')), size(settings%numbers(entry, 'upper'))] /= merge(0, ndim, &
             model%loads(i)%side > 0 .and. size(settings%numbers(entry, 'lower')) == 0)) .or. .not. model%loads(i)%has_place) cycle
         if (any(model%loads(i)%upper < model%loads(i)%lower)) then
            call settings%complain(entry, 'upper', 'must not be below lower = '//point_text(model%loads(i)%lower))
         else if (has_geometry) then
            call check_place(model, model%loads(i), entry, settings)
         end if
      end do
   end subroutine check_loads

   !> There is a crack whose faces are pressed, away from edges.
   pure subroutine check_pressed(model, load, entry, settings)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(inout) :: settings
      integer :: path
      path = path_of(model, load%crack)
      if (path == 0 .and. load%crack /= '' .and. settings%good(entry, 'crack')) then
         call settings%complain(entry, 'crack', 'must be the name of a &crack of kind = ''plane'', ''line'' or ''path''')
      else if (path > 0 .and. ndim == plane) then
         if (comes_near_edges(model, model%paths(path)%points)) call settings%complain(entry, 'on', '''crack'': the '// &
            'crack must stay two cells away from the edges of polygons, circles and holes, which cut the particles that are '// &
            'pressed')
      end if
   end subroutine check_pressed

   !> Whether the corners of all bodies are known, and their other keys go with their shapes.
   pure logical function bodies_good(settings)
      type(settings_t), intent(in) :: settings
      character(*), parameter :: keys(*) = [character(6) :: 'shape', 'lower', 'upper', 'points', 'center', 'radius', 'hole']
      bodies_good = settings%count_of('body') > 0 .and. settings%knows('body', keys)
   end function bodies_good

   !> There is material where a load acts.
   pure subroutine check_place(model, load, entry, settings)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(inout) :: settings
      character(:), allocatable :: a_load
      real(dp) :: tol, normal(ndim), axis
      logical :: found, misses
      integer :: i, sides
      tol = tolerance(model%grid)
      a_load = 'a '//trim(load%kind)
      if (load%kind == 'absorbing') a_load = 'an absorbing load'
      axis = merge(tol, -huge(tol), model%run%plane == 'axisymmetric')  ! up to where edges are on it [m]
      call check_face(model, load, entry, settings, misses)
      if (misses) return
      if (load%of_outlines /= 1 .and. settings%good(entry, 'side')) then
         call settings%complain(entry, 'side', 'must be the number of a side of one polygon or rectangle: that from its corner '// &
                                'of this number to the next, as they are written (of a rectangle 1 below, 2 right, 3 above, '// &
                                '4 left); '//trim(merge('there is none in its box                                 ', &
                                                        'there are several: give lower and upper of a box with one', &
                                                        load%of_outlines == 0)))
         return
      end if
      found = load%face /= 'none'
      call find_edge_normal(model, load, normal, sides)
      if (any(load%kind == [character(9) :: 'traction', 'pressure', 'absorbing'])) found = found .or. &
         sides > 0 .and. load%upper(1) > axis
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            select case (load%kind)
             case ('point')
               found = found .or. body%holds(load%lower, tol)
             case ('traction', 'pressure', 'absorbing')
               if (body%outline%is_there()) then
                  associate (parts => body%outline%parts_in_box(load%lower, load%upper, tol, model%grid%lower, &
                                                                model%grid%cell, load%side))
                     found = found .or. any(parts%middle(1) > axis)
                     if (any(parts%middle(1) <= axis)) sides = max(sides, 1)
                  end associate
               end if
             case ('body')
               found = found .or. body%area_in(load%lower, load%upper) > 0
            end select
         end associate
      end do
      if (load%kind == 'point' .and. any(load%upper - load%lower > tol)) then
         call settings%complain(entry, 'upper', 'must equal lower = '//point_text(load%lower)//' for a point load')
      else if (found) then
         if (sides > 1 .and. any(load%kind == [character(9) :: 'pressure', 'absorbing'])) &
            call settings%complain(entry, 'lower', 'the line up to '//point_text(load%upper)// &
                                   ' is the edge of bodies on both sides: '//trim(load%kind)//' loads act on a free edge')
      else if (any(load%kind == [character(9) :: 'traction', 'pressure', 'absorbing']) .and. sides > 0) then
         call settings%complain(entry, 'kind', 'the edge is on the axis, where it has no area: a force there is of kind '// &
                                '= ''point''')
      else if (load%kind == 'point') then
         call settings%complain(entry, 'lower', 'the point of a load must be in or on a body')
      else if (load%kind == 'body') then
         call settings%complain(entry, 'lower', 'the box up to '//point_text(load%upper)// &
                                ' must contain material of a body')
      else if (has_shapes(model)) then
         call settings%complain(entry, 'lower', 'the box up to '//point_text(load%upper)// &
                                ' must contain a segment of the edge of a body: '//a_load//' acts on '//an_edge)
      else if (count(load%upper - load%lower <= tol) /= 1) then
         call settings%complain(entry, 'upper', 'must equal lower = '//point_text(load%lower)// &
                                ' in exactly one direction: '//a_load//' acts on '//an_edge)
      else
         call settings%complain(entry, 'lower', 'the '//trim(merge('rectangle', 'line     ', ndim > 2))//' up to '// &
                                point_text(load%upper)// &
                                ' must lie on one '//trim(merge('side', 'edge', ndim > 2))//' of a body: '//a_load//' acts on '// &
                                an_edge)
      end if
   end subroutine check_place

   !> Whether a load misses the face of a crack: the face must belong to a crack with two, and a load on the line of such a crack
   !> must name its side.
   pure subroutine check_face(model, load, entry, settings, misses)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      integer, intent(in) :: entry
      type(settings_t), intent(inout) :: settings
      logical, intent(out) :: misses
      logical :: on_crack
      misses = .false.
      if (.not. settings%good(entry, 'face') .or. load%kind == 'pressure' .or. load%kind == 'absorbing') return
      on_crack = .false.
      if (load%kind /= 'body' .and. .not. model%is_half()) on_crack = all(path_at(model, load%lower, load%upper) > 0)
      misses = on_crack .neqv. load%face /= 'none'
      if (.not. misses) return
      if (on_crack) then
         call settings%complain(entry, 'face', 'must be ''left'' or ''right'': the load is on the line of the crack, '// &
                                'which has two faces there')
      else
         call settings%complain(entry, 'face', 'must be ''none'' but for a point or traction on the line of a '// &
                                'crack, between its mouth or other tip and its tip')
      end if
   end subroutine check_face
end module hampm_load_consistency
