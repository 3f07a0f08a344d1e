!> Whether the crack lies where a crack can be, and whether the energy release rate asked for is defined.
module hampm_crack_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_mistakes, only: mistakes_t
   use hampm_placement, only: tolerance, within, on_node, on_face, point_text
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_crack, check_energy_release

contains

   !> The tip is a node with a node behind and ahead, and the constraints make a crack of it.
   pure subroutine check_crack(scene, settings, has_grid, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: has_grid
      type(mistakes_t), intent(inout) :: mistakes
      integer :: b, before
      b = settings%find('crack', 1)
      if (.not. (settings%good(b, 'tip') .and. settings%good(b, 'direction'))) return
      before = mistakes%count
      if (count(abs(scene%crack%direction) > 0) /= 1) &
         call settings%complain(mistakes, b, 'direction', 'must be along a grid line: one component not 0, all others 0')
      if (.not. has_grid) return
      if (.not. on_node(scene%grid, scene%crack%tip)) &
         call settings%complain(mistakes, b, 'tip', 'must be a node of the grid: lower + i*cell with lower = '// &
                                point_text(scene%grid%lower)//', cell = '//to_text(scene%grid%cell))
      if (mistakes%count > before) return
      if (.not. (on_node(scene%grid, node(scene, -1)) .and. on_node(scene%grid, node(scene, 1)))) then
         call settings%complain(mistakes, b, 'tip', 'the nodes one cell behind and one cell ahead must be in the grid')
      else
         call check_edge(scene, settings, b, mistakes)
         call check_symmetry(scene, settings, b, mistakes)
      end if
   end subroutine check_crack

   !> Position of the n-th node ahead of the crack tip [m].
   pure function node(scene, n) result(position)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: n
      real(dp) :: position(ndim)
      position = scene%crack%tip + n*scene%grid%cell*scene%crack%direction
   end function node

   !> The line of the crack, a cell behind and ahead of the tip, is part of an edge of a body.
   pure subroutine check_edge(scene, settings, b, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: b
      type(mistakes_t), intent(inout) :: mistakes
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
      call settings%complain(mistakes, b, 'tip', &
                             'must be on an edge of a body that reaches a cell behind and ahead of it, for kind = ''symmetry''')
   end subroutine check_edge

   !> On the symmetry line, nodes from the tip on are held in the normal direction and those behind are free.
   pure subroutine check_symmetry(scene, settings, b, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: b
      type(mistakes_t), intent(inout) :: mistakes
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
         call settings%complain(mistakes, b, 'tip', 'the nodes at the tip and one cell ahead must be held in '// &
                                axis(normal:normal)//' by a &constraint, for kind = ''symmetry''')
      if (is_held(scene, node(scene, -1), normal)) &
         call settings%complain(mistakes, b, 'tip', 'the node one cell behind the tip must not be held in '// &
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
   pure subroutine check_energy_release(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: e
      e = settings%find('energy_release', 1)
      if (settings%good(e, 'estimators') .and. .not. scene%crack%present .and. &
          (scene%energy_release%nodal_force .or. scene%energy_release%stress_closure)) &
         call settings%complain(mistakes, e, 'estimators', '''nodal_force'' and ''stress_closure'' need a group &crack')
      if (.not. settings%good(e, 'reference')) return
      if (scene%energy_release%reference == 'dcb') call check_dcb(scene, settings, e, mistakes)
      if (scene%energy_release%reference == 'value' .and. settings%good(e, 'reference_value') &
          .and. scene%energy_release%reference_value <= 0) call settings%complain(mistakes, e, 'reference_value', &
         'must be in (0, inf) [J/m2] for reference = ''value''')
   end subroutine check_energy_release

   !> The double cantilever beam's reference needs a crack, one body, and a load that opens the crack.
   pure subroutine check_dcb(scene, settings, e, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: e
      type(mistakes_t), intent(inout) :: mistakes
      logical :: opens, known
      integer :: i
      if (.not. scene%crack%present) call settings%complain(mistakes, e, 'reference', '''dcb'' needs a group &crack')
      if (size(scene%bodies) > 1) call settings%complain(mistakes, e, 'reference', '''dcb'' needs exactly one &body, not '// &
                                                         to_text(size(scene%bodies)))
      opens = .false.
      known = scene%crack%present .and. settings%good(settings%find('crack', 1), 'direction')
      do i = 1, size(scene%loads)
         known = known .and. settings%good(settings%find('load', i), 'force')
         opens = opens .or. any(abs(scene%loads(i)%force) > 0 .and. .not. abs(scene%crack%direction) > 0)
      end do
      if (known .and. .not. opens) call settings%complain(mistakes, e, 'reference', &
         '''dcb'' needs a &load with a force normal to the crack')
   end subroutine check_dcb
end module hampm_crack_consistency
