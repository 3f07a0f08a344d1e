!> Whether the crack lies where a crack can be, and whether the energy release rate asked for is defined.
module hampm_crack_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: has_two_tips, body_at, largest_radius, least_radius, domain_radii, is_covered, is_on_crack, &
                                    is_other_within, is_layer
   use hampm_path_consistency, only: check_path_radii
   use hampm_placement, only: tolerance, upper_corner, nearest_node, within, on_node, on_face, point_text, length_text
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_crack, check_energy_release

contains

   !> The tip is a node with a node behind and ahead. On a symmetry plane the constraints make a crack of it; a line is inside the
   !> material.
   pure subroutine check_crack(scene, settings, has_grid)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_grid            !! whether the grid is without mistakes
      integer :: entry, before
      entry = settings%find('crack', 1)
      if (.not. scene%crack%present) return
      if (.not. (settings%good(entry, 'kind') .and. settings%good(entry, 'tip') .and. settings%good(entry, 'direction'))) return
      before = settings%mistakes%count
      if (count(abs(scene%crack%direction) > 0) /= 1) &
         call settings%complain(entry, 'direction', 'must be along a grid line: one component not 0, all others 0')
      if (.not. has_grid) return
      if (.not. on_node(scene%grid, scene%crack%tip)) &
         call settings%complain(entry, 'tip', 'must be a node of the grid: lower + i*cell with lower = '// &
                                point_text(scene%grid%lower)//', cell = '//to_text(scene%grid%cell)//', up to '// &
                                point_text(upper_corner(scene%grid))//'; the nearest is '// &
                                point_text(nearest_node(scene%grid, scene%crack%tip)))
      if (settings%mistakes%count > before) return
      if (.not. (on_node(scene%grid, node(scene, -1)) .and. on_node(scene%grid, node(scene, 1)))) then
         call settings%complain(entry, 'tip', 'the nodes one cell behind and one cell ahead must be in the grid')
      else if (scene%crack%kind == 'line') then
         call check_inside(scene, settings, entry)
      else
         call check_edge(scene, settings, entry)
         call check_symmetry(scene, settings, entry)
      end if
   end subroutine check_crack

   !> A line has material around its tip, and its other tip is at a node.
   pure subroutine check_inside(scene, settings, entry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group &crack, here and below
      real(dp) :: cells
      integer :: i
      if (.not. all([(settings%good(settings%find('body', i), 'lower') .and. settings%good(settings%find('body', i), 'upper'), &
                      i=1, size(scene%bodies))])) return
      if (.not. is_covered(scene, scene%crack%tip, scene%grid%cell)) then
         call settings%complain(entry, 'tip', 'must be inside the material, at least a cell from its edges, '// &
                                'for kind = ''line''')
         return
      end if
      cells = scene%crack%length/scene%grid%cell
      if (.not. settings%good(entry, 'length') .or. .not. has_two_tips(scene)) return
      if (abs(cells - anint(cells))*scene%grid%cell > tolerance(scene%grid) .or. cells < 1.5_dp) &
         call settings%complain(entry, 'length', 'the other tip must be at a node too: a multiple of cell = '// &
                                to_text(scene%grid%cell)//', two cells at least')
   end subroutine check_inside

   !> Position of the n-th node ahead of the crack tip [m].
   pure function node(scene, n) result(position)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: n
      real(dp) :: position(ndim)
      position = scene%crack%tip + n*scene%grid%cell*scene%crack%direction
   end function node

   !> The line of the crack, a cell behind and ahead of the tip, is part of an edge of a body.
   pure subroutine check_edge(scene, settings, entry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      real(dp) :: lower(ndim), upper(ndim), tol
      integer :: i, body
      tol = tolerance(scene%grid)
      lower = min(node(scene, -1), node(scene, 1))
      upper = max(node(scene, -1), node(scene, 1))
      do i = 1, size(scene%bodies)
         body = settings%find('body', i)
         if (.not. (settings%good(body, 'lower') .and. settings%good(body, 'upper'))) return
         if (on_face(lower, upper, scene%bodies(i), tol)) return
      end do
      call settings%complain(entry, 'tip', &
                             'must be on an edge of a body that reaches a cell behind and ahead of it, for kind = ''symmetry''')
   end subroutine check_edge

   !> On the symmetry line, nodes from the tip on are held in the normal direction and those behind are free.
   pure subroutine check_symmetry(scene, settings, entry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      character(*), parameter :: axis = 'xyz'
      integer :: normal, i, c
      do i = 1, size(scene%constraints)
         c = settings%find('constraint', i)
         if (.not. (settings%good(c, 'lower') .and. settings%good(c, 'upper') .and. settings%good(c, 'fix'))) return
      end do
      do normal = 1, ndim
         if (abs(scene%crack%direction(normal)) <= 0) exit
      end do
      if (.not. (is_held(scene, node(scene, 0), normal) .and. is_held(scene, node(scene, 1), normal))) &
         call settings%complain(entry, 'tip', 'the nodes at the tip and one cell ahead must be held in '// &
                                axis(normal:normal)//' by a &constraint, for kind = ''symmetry''')
      if (is_held(scene, node(scene, -1), normal)) &
         call settings%complain(entry, 'tip', 'the node one cell behind the tip must not be held in '// &
                                axis(normal:normal)//' by a &constraint, for kind = ''symmetry''')
   end subroutine check_symmetry

   !> Whether a constraint holds one component of the node at a position.
   pure logical function is_held(scene, position, component)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: position(ndim)
      integer, intent(in) :: component
      integer :: i
      is_held = .false.
      do i = 1, size(scene%constraints)
         associate (constraint => scene%constraints(i))
            if (.not. constraint%fixed(component)) cycle
            is_held = is_held .or. within(position, position, constraint%lower, constraint%upper, tolerance(scene%grid))
         end associate
      end do
   end function is_held

   !> What is asked about the energy release rate needs a crack, and a reference needs its scene.
   pure subroutine check_energy_release(scene, settings, has_geometry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_geometry        !! whether grid, bodies and crack are without mistakes
      integer :: entry
      entry = settings%find('energy_release', 1)
      if (settings%good(entry, 'estimators')) then
         if (size(scene%paths) > 0) then
            if (scene%energy_release%needs_radii() .and. has_geometry .and. settings%good(entry, 'radii')) &
               call check_path_radii(scene, settings, entry)
         else if (scene%crack%present .and. scene%energy_release%needs_radii() .and. has_geometry .and. &
                  settings%good(entry, 'radii')) then
            call check_radii(scene, settings, entry)
         end if
      end if
      if (scene%energy_release%stress_closure .and. has_geometry .and. any_on_faces(scene)) &
         call settings%complain(entry, 'estimators', '''stress_closure'' is not defined with tractions on the faces '// &
                                'of the crack; use ''nodal_force'' or ''domain_integral''')
      if (.not. settings%good(entry, 'reference')) return
      if (scene%energy_release%reference == 'dcb') call check_dcb(scene, settings, entry)
   end subroutine check_energy_release

   !> Whether a traction acts on a face of the crack.
   pure logical function any_on_faces(scene) result(any_on)
      type(scene_t), intent(in) :: scene
      integer :: i
      any_on = .false.
      do i = 1, size(scene%loads)
         if (scene%loads(i)%kind == 'traction' .or. scene%loads(i)%kind == 'pressure') &
            any_on = any_on .or. is_on_crack(scene, scene%loads(i)%lower, scene%loads(i)%upper)
      end do
   end function any_on_faces

   !> The domains of the integral are full of one material, with nothing but the crack in them, and have cells enough.
   pure subroutine check_radii(scene, settings, entry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group &energy_release, here and below
      real(dp), allocatable :: radii(:)
      real(dp) :: most, least
      integer :: crack, i
      crack = settings%find('crack', 1)
      if (.not. all([settings%good(crack, 'kind'), settings%good(crack, 'tip'), settings%good(crack, 'direction'), &
                     settings%good(crack, 'length')])) return
      if (.not. surroundings_good(scene, settings)) return
      if (body_at(scene, scene%crack%tip) == 0) return
      most = largest_radius(scene, scene%crack%tip)
      allocate (radii, source=domain_radii(scene, most))
      least = least_radius(scene)
      if (most < least - tolerance(scene%grid)) then
         call settings%complain(entry, 'radii', 'there is no place for a radius: around the tip there are only '// &
                                'material and this crack up to '//length_text(most)//' m, and two of the finest cells, '// &
                                to_text(least)//' m, are the least; use smaller cells or move the tip, or loads and '// &
                                'constraints near it')
         return
      end if
      if (any(radii(2:) <= radii(:size(radii) - 1))) &
         call settings%complain(entry, 'radii', 'must increase from one to the next')
      if (scene%energy_release%crack_closure .and. .not. maxval(radii) >= 2*least - tolerance(scene%grid)) &
         call settings%complain(entry, 'radii', 'the largest must be at least '//to_text(2*least)// &
                                ' m, four of the finest cells, with ''crack_closure'', and is '//length_text(maxval(radii))// &
                                ' m; there is room for '//length_text(most)//' m')
      if (any(radii < least - tolerance(scene%grid) .or. radii > most + tolerance(scene%grid))) &
         call settings%complain(entry, 'radii', 'must be in ['//to_text(least)//', '//length_text(most)//'] [m]: two '// &
                                'of the finest cells at least, and around the tip nothing within them but material and this '// &
                                'crack, neither point load nor traction but on its faces, and no constraint but that of '// &
                                'the symmetry plane')
      do i = 1, size(scene%bodies)
         if (.not. is_other_within(scene, i, scene%crack%tip, maxval(radii))) cycle
         if (is_layer(scene, i, scene%crack%tip, maxval(radii))) cycle
         call settings%complain(entry, 'radii', 'there must be one material within them, or layers along the '// &
                                'crack; body '//to_text(i)//' is of another one than the tip''s, or has another eigenstrain, '// &
                                'and ends within them')
         return
      end do
   end subroutine check_radii

   !> Whether it is known where all loads and constraints are, and what these hold.
   pure logical function surroundings_good(scene, settings) result(good)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer :: i, entry
      good = .true.
      do i = 1, size(scene%loads)
         entry = settings%find('load', i)
         good = good .and. settings%good(entry, 'kind') .and. settings%good(entry, 'lower') .and. settings%good(entry, 'upper')
      end do
      do i = 1, size(scene%constraints)
         entry = settings%find('constraint', i)
         good = good .and. settings%good(entry, 'fix') .and. settings%good(entry, 'lower') .and. settings%good(entry, 'upper')
      end do
   end function surroundings_good

   !> The double cantilever beam's reference needs a load that opens the crack.
   pure subroutine check_dcb(scene, settings, entry)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      logical :: opens, known
      integer :: i
      opens = .false.
      known = scene%crack%present .and. settings%good(settings%find('crack', 1), 'direction')
      do i = 1, size(scene%loads)
         known = known .and. settings%good(settings%find('load', i), 'force')
         opens = opens .or. any(abs(scene%loads(i)%force) > 0 .and. .not. abs(scene%crack%direction) > 0)
      end do
      if (known .and. .not. opens) call settings%complain(entry, 'reference', &
         '''dcb'' needs a &load with a force normal to the crack')
   end subroutine check_dcb
end module hampm_crack_consistency
