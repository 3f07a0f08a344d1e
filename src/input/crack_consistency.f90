!> Whether the crack lies where a crack can be, and whether the energy release rate asked for is defined.
module hampm_crack_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_crack_lines, only: last_point
   use hampm_crack_placement, only: is_fixed, path_at
   use hampm_path_consistency, only: check_path_radii
   use hampm_path_placement, only: path_tip
   use hampm_placement, only: tolerance, upper_corner, nearest_node, on_node, on_face, point_text
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_crack, check_energy_release

   character(*), parameter :: where_and_what(*) = ['lower', 'upper', 'fix  '] !! of a constraint

contains

   !> The tip is a node with a node behind and ahead. The constraints make a crack of it.
   pure subroutine check_crack(model, settings, has_grid)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_grid            !! whether the grid is without errors
      integer :: entry, before
      entry = settings%find('crack', 1)
      if (.not. model%is_half()) return
      if (.not. (settings%good(entry, 'kind') .and. settings%good(entry, 'tip') .and. settings%good(entry, 'direction'))) return
      before = settings%errors%count
      if (count(abs(model%paths(1)%direction) > 0) /= 1) &
         call settings%complain(entry, 'direction', 'must be along a grid line: one component not 0, all others 0')
      if (.not. has_grid) return
      if (.not. on_node(model%grid, node(model, 0))) &
         call settings%complain(entry, 'tip', 'must be a node of the grid: lower + i*cell with lower = '// &
                                point_text(model%grid%lower)//', cell = '//to_text(model%grid%cell)//', up to '// &
                                point_text(upper_corner(model%grid))//'; the nearest is '// &
                                point_text(nearest_node(model%grid, node(model, 0))))
      if (settings%errors%count > before) return
      if (.not. (on_node(model%grid, node(model, -1)) .and. on_node(model%grid, node(model, 1)))) then
         call settings%complain(entry, 'tip', 'the nodes one cell behind and one cell ahead must be in the grid')
      else
         call check_edge(model, settings, entry)
         call check_symmetry(model, settings, entry)
      end if
   end subroutine check_crack

   !> Position of the n-th node ahead of the crack tip [m].
   pure function node(model, n) result(position)
      type(model_t), intent(in) :: model
      integer, intent(in) :: n
      real(dp) :: position(ndim)
      position = path_tip(model%paths(1), last_point) + n*model%grid%cell*model%paths(1)%direction
   end function node

   !> The line of the crack, a cell behind and ahead of the tip, is part of an edge of a body.
   pure subroutine check_edge(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group &crack, here and below
      real(dp) :: lower(ndim), upper(ndim), tol
      integer :: i, body
      tol = tolerance(model%grid)
      lower = min(node(model, -1), node(model, 1))
      upper = max(node(model, -1), node(model, 1))
      do i = 1, size(model%bodies)
         body = settings%find('body', i)
         if (.not. (settings%good(body, 'lower') .and. settings%good(body, 'upper'))) return
         if (on_face(lower, upper, model%bodies(i), tol)) return
      end do
      call settings%complain(entry, 'tip', &
                             'must be on an edge of a body that reaches a cell behind and ahead of it, for kind = ''symmetry''')
   end subroutine check_edge

   !> On the symmetry line, nodes from the tip on are fixed in the normal direction, nodes behind are free.
   pure subroutine check_symmetry(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      character(*), parameter :: axis = 'xyz'
      integer :: normal
      if (.not. settings%knows('constraint', where_and_what)) return
      do normal = 1, ndim
         if (abs(model%paths(1)%direction(normal)) <= 0) exit
      end do
      if (.not. (is_fixed(model, node(model, 0), normal) .and. is_fixed(model, node(model, 1), normal))) &
         call settings%complain(entry, 'tip', 'the nodes at the tip and one cell ahead must be held in '// &
                                axis(normal:normal)//' by a &constraint, for kind = ''symmetry''')
      if (is_fixed(model, node(model, -1), normal)) &
         call settings%complain(entry, 'tip', 'the node one cell behind the tip must not be held in '// &
                                axis(normal:normal)//' by a &constraint, for kind = ''symmetry''')
   end subroutine check_symmetry

   !> Outputs of the energy release rate need a crack, and a reference needs its model.
   pure subroutine check_energy_release(model, settings, has_geometry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_geometry        !! whether grid, bodies and crack are without errors
      integer :: entry, i
      entry = settings%find('energy_release', 1)
      if (settings%good(entry, 'estimators') .and. any(model%energy_release%chosen%needs_radii) .and. has_geometry .and. &
          settings%good(entry, 'radii') .and. settings%knows('load', ['kind ', 'lower', 'upper']) .and. &
          settings%knows('constraint', where_and_what)) call check_path_radii(model, settings, entry)
      if (any(model%energy_release%chosen%name == 'stress_closure') .and. has_geometry .and. &
          any([(any(model%loads(i)%kind == ['traction', 'pressure']) .and. &
                any(path_at(model, model%loads(i)%lower, model%loads(i)%upper) > 0), i=1, size(model%loads))])) &
         call settings%complain(entry, 'estimators', '''stress_closure'' is not defined with tractions on the faces '// &
                                'of the crack; use ''vcct'' or ''domain_integral''')
      if (.not. settings%good(entry, 'reference')) return
      if (model%energy_release%reference == 'dcb') call check_dcb(model, settings, entry)
   end subroutine check_energy_release

   !> The double cantilever beam's reference needs a load that opens the crack.
   pure subroutine check_dcb(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      integer :: i
      if (.not. settings%knows('crack', ['direction']) .or. size(model%paths) /= 1 .or. .not. settings%knows('load', ['force'])) &
         return
      if (.not. any([(any(abs(model%loads(i)%force) > 0 .and. .not. abs(model%paths(1)%direction) > 0), &
                      i=1, size(model%loads))])) call settings%complain(entry, 'reference', &
         '''dcb'' needs a &load with a force normal to the crack')
   end subroutine check_dcb
end module hampm_crack_consistency
