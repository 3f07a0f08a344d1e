!> Whether the keys of a scene agree with quadratic cells, `&grid order = 2`: what these do not go with is refused.
module hampm_quadratic_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_history_consistency, only: has_history
   use hampm_mistakes, only: mistakes_t
   use hampm_placement, only: on_node
   use hampm_quadratic_points, only: fewest_points
   use hampm_scene, only: scene_t, cuts_cells
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_quadratic_cells

   character(*), parameter :: intro = 'with &grid order = 2'
   character(*), parameter :: where_cut = ' in motion where cracks or edges cut cells'

contains

   !> Check a scene whose cells are quadratic; others have no use for this.
   pure subroutine check_quadratic_cells(scene, settings, has_bodies, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: has_bodies            !! whether grid and bodies are good
      type(mistakes_t), intent(inout) :: mistakes
      if (.not. settings%good(settings%find('grid', 1), 'order') .or. scene%grid%order < 2) return
      call check_method(scene, settings, mistakes)
      call check_materials(scene, settings, mistakes)
      if (has_bodies) call check_bodies(scene, settings, mistakes)
      call check_loads(scene, settings, mistakes)
      call check_cracks(scene, settings, mistakes)
   end subroutine check_quadratic_cells

   !> Check how the motion is found, and where cells refine.
   pure subroutine check_method(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method, refine
      method = settings%find('method', 1)
      call settings%demand(mistakes, method, 'frame', 'total', intro//': particles stay where their weights are right')
      if (settings%good(method, 'time') .and. scene%method%time /= 'static') then
         call settings%demand(mistakes, method, 'time_steps', 'global', intro)
      end if
      if (scene%method%time == 'implicit' .and. settings%good(method, 'courant') .and. scene%method%courant > 0) &
         call settings%complain(mistakes, method, 'courant', 'must be 0 '//intro//' in implicit steps. Give a time_step')
      refine = settings%find('refine', 1)
      if (settings%good(refine, 'r_coarsen') .and. scene%refine%indicator == 'gradient' .and. scene%refine%r_coarsen > 0) &
         call settings%complain(mistakes, refine, 'r_coarsen', 'must be 0 '//intro//': their particles do not recombine')
      if (scene%method%time /= 'static' .and. cuts_cells(scene)) call check_motion_of_cut_cells(scene, settings, mistakes)
   end subroutine check_method

   !> Where cells are cut their functions have integrals below 0 for some nodes: only the full mass matrix moves them.
   pure subroutine check_motion_of_cut_cells(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method, refine, k
      method = settings%find('method', 1)
      refine = settings%find('refine', 1)
      if (settings%good(method, 'mass') .and. scene%method%mass /= 'full') call settings%complain(mistakes, method, 'mass', &
         'must be ''full'' '//intro//where_cut//': some nodes would have a lumped mass below 0. Use mass = ''full'', or '// &
         'time = ''static''')
      if (settings%good(method, 'solver') .and. scene%method%solver == 'cg') call settings%complain(mistakes, method, 'solver', &
         'must be ''umfpack'' or ''banded'' '//intro//where_cut//': what ''cg'' takes to begin with are inverses of the mass '// &
         'matrices of cells, and pieces of these may have none')
      if (settings%good(refine, 'indicator') .and. any(scene%refine%indicator == [character(8) :: 'zz', 'gradient'])) &
         call settings%complain(mistakes, refine, 'indicator', 'must be ''tip'' or ''none'' '//intro//where_cut// &
                                ': their particles would have to be given to finer cells')
      do k = 1, size(scene%materials)
         if (scene%materials(k)%law == 'neo_hookean') call settings%complain(mistakes, settings%find('material', k), 'law', &
            'must be ''linear_elastic'' or ''orthotropic'' '//intro//where_cut//'. At rest it may be ''neo_hookean''')
      end do
      if (scene%crack%contact) call settings%complain(mistakes, settings%find('crack', 1), 'contact', 'must be ''none'' '// &
         intro//where_cut//': pairs of nodes have lumped masses')
      do k = 1, size(scene%paths)
         if (scene%paths(k)%contact) call settings%complain(mistakes, settings%find('crack', scene%paths(k)%number), 'contact', &
            'must be ''none'' for a &crack of kind = ''path'' '//intro//' in motion. Use time = ''static'', or order = 1')
      end do
      if (size(scene%growth) > 0) call settings%complain(mistakes, settings%find('grid', 1), 'order', 'must be 1 where cracks '// &
                                                         'grow in motion; with order = 2 paths grow at rest')
   end subroutine check_motion_of_cut_cells

   !> Laws have no history and no share of the dilatation: what particles remember would have to follow each pass.
   pure subroutine check_materials(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%materials)
         if (has_history(scene%materials(k)%law)) call settings%complain(mistakes, settings%find('material', k), 'law', &
            'must be ''linear_elastic'', ''orthotropic'' or ''neo_hookean'' '//intro//': particles of these cells remember nothing')
         call settings%demand(mistakes, settings%find('material', k), 'dilatation', 'point', intro//': they do not lock')
      end do
   end subroutine check_materials

   !> Rectangles fill cells; with enough particles in each cell.
   pure subroutine check_bodies(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry, k
      do k = 1, size(scene%bodies)
         entry = settings%find('body', k)
         associate (body => scene%bodies(k))
            if (settings%good(entry, 'points_per_cell') .and. body%points_per_cell < fewest_points) &
               call settings%complain(mistakes, entry, 'points_per_cell', 'must be at least '//to_text(fewest_points)//' '// &
                                      intro//': with fewer some motions of its nodes strain no particle')
            if (abs(body%spin) > 0) call settings%complain(mistakes, entry, 'spin', 'must be 0 '//intro)
            if (any(abs(body%eigenstrain) > 0)) call settings%complain(mistakes, entry, 'eigenstrain', 'must be 0 '//intro)
            if (body%outline%is_there()) cycle
            if (.not. (on_node(scene%grid, body%lower) .and. on_node(scene%grid, body%upper))) &
               call settings%complain(mistakes, entry, 'lower', 'and upper must be nodes of the lattice '//intro// &
                                      ': bodies are to fill their cells')
         end associate
      end do
   end subroutine check_bodies

   !> Supports that only push, and loads on the faces of cracks, are not there.
   pure subroutine check_loads(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%constraints)
         if (scene%constraints(k)%motion%push_only) call settings%complain(mistakes, settings%find('constraint', k), 'push_only', &
                                                                           'must be .false. '//intro)
      end do
      do k = 1, size(scene%loads)
         call settings%demand(mistakes, settings%find('load', k), 'on', 'edge', intro)
         call settings%demand(mistakes, settings%find('load', k), 'face', 'none', intro)
      end do
   end subroutine check_loads

   !> Cracks stay.
   pure subroutine check_cracks(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      if (size(scene%growth) > 0 .and. size(scene%paths) == 0) call settings%complain(mistakes, settings%find('grid', 1), &
         'order', 'must be 1 where a crack of kind ''symmetry'' grows; a path may, at rest')
      if (scene%crack%contact .and. any(scene%refine%indicator == [character(8) :: 'zz', 'gradient'])) &
         call settings%complain(mistakes, settings%find('crack', 1), 'contact', 'must be ''none'' '//intro//' and &refine '// &
         'indicator = '''//trim(scene%refine%indicator)//''': nodes of both faces are to be at the same places. Use a &crack '// &
         'of kind = ''path'', or indicator = ''tip''')
      if (scene%energy_release%stress_closure) call settings%complain(mistakes, settings%find('energy_release', 1), 'estimators', &
         'must be others than ''stress_closure'' '//intro//': the paper has it for bilinear cells')
      if (scene%contact%is_wanted()) call settings%complain(mistakes, settings%find('contact', 1), 'bodies', &
                                                            'must be ''joined'' '//intro)
   end subroutine check_cracks
end module hampm_quadratic_consistency
