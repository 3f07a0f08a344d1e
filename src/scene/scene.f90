!> What the user asked for: one type for each group of the namelist, after validation, in SI units. What the keys are, and how they
!> come from the text, is beside these types in the modules of the groups.
module hampm_scene
   use hampm_body_group, only: body_t, hole_t, fill_bodies, fill_holes
   use hampm_load_groups, only: constraint_spec_t, fill_constraints, load_spec_t, fill_loads
   use hampm_cohesive_group, only: cohesive_t, fill_cohesive
   use hampm_crack_groups, only: crack_spec_t, path_spec_t, fill_crack, fill_paths, energy_release_t, fill_energy_release, &
                                 growth_t, fill_growth
   use hampm_plain_groups, only: grid_spec_t, fill_grid, run_t, fill_run, damping_t, fill_damping, output_t, fill_output, &
                                 body_contact_spec_t, fill_contact, method_t, fill_method, refine_t, fill_refine
   use hampm_material_group, only: material_spec_t, fill_materials
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: scene_t, fill_scene, cuts_cells, mass_acts, mass_used, run_t, &
             grid_spec_t, material_spec_t, body_t, constraint_spec_t, load_spec_t, &
             damping_t, body_contact_spec_t, method_t, refine_t, crack_spec_t, path_spec_t, growth_t, energy_release_t, output_t

   !> All groups.
   type :: scene_t
      type(run_t) :: run
      type(grid_spec_t) :: grid
      type(material_spec_t), allocatable :: materials(:) !! of which there are bodies
      type(body_t), allocatable :: bodies(:)
      type(hole_t), allocatable :: holes(:)      !! &body with hole = .true.
      type(constraint_spec_t), allocatable :: constraints(:)
      type(load_spec_t), allocatable :: loads(:)
      type(damping_t) :: damping
      type(body_contact_spec_t) :: contact
      type(method_t) :: method
      type(refine_t) :: refine
      type(crack_spec_t) :: crack                !! that is no path
      type(path_spec_t), allocatable :: paths(:) !! cracks of kind 'path'
      type(cohesive_t), allocatable :: cohesive(:)
      type(growth_t), allocatable :: growth(:)
      type(energy_release_t) :: energy_release
      type(output_t) :: output
      character(:), allocatable :: as_used       !! complete namelist text: every key with the value in force
      character(:), allocatable :: warned        !! what the table of rules warns of, a line each
      character(:), allocatable :: noted         !! what it tells, a line each
   end type scene_t

contains

   !> Whether the mass matrix acts: in motion, and where stress is extrapolated by it.
   pure logical function mass_acts(scene)
      type(scene_t), intent(in) :: scene
      mass_acts = scene%method%time /= 'static' .or. scene%energy_release%stress_closure
   end function mass_acts

   !> The mass matrix that a run has: nodes have no more than masses where it does not act.
   pure function mass_used(scene) result(mass)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: mass
      mass = 'lumped'
      if (mass_acts(scene)) mass = trim(scene%method%mass)
   end function mass_used

   !> Fill a scene from what was written and validated.
   pure subroutine fill_scene(settings, scene)
      type(settings_t), intent(in) :: settings
      type(scene_t), intent(inout) :: scene
      call fill_run(settings, scene%run)
      call fill_grid(settings, scene%grid)
      call fill_materials(settings, scene%materials)
      call fill_bodies(settings, scene%bodies)
      call fill_holes(settings, scene%bodies, scene%holes)
      call fill_constraints(settings, scene%constraints)
      call fill_loads(settings, scene%loads)
      call fill_damping(settings, scene%damping)
      call fill_contact(settings, scene%contact)
      call fill_method(settings, scene%method)
      call fill_refine(settings, scene%refine)
      call fill_crack(settings, scene%crack)
      call fill_paths(settings, scene%paths)
      call fill_cohesive(settings, scene%cohesive)
      call fill_growth(settings, scene%growth)
      call fill_energy_release(settings, scene%energy_release)
      call fill_output(settings, scene%output)
      call find_materials(scene)
      call find_growing_paths(scene)
   end subroutine fill_scene

   !> Find the material of each body by its name; 0 where there is none. Materials of which there is no body are left out, and of several that
   !> differ by their names only all bodies are of the first one.
   pure subroutine find_materials(scene)
      type(scene_t), intent(inout) :: scene
      type(material_spec_t), allocatable :: used(:)
      logical :: is_used(size(scene%materials))
      integer :: i, k
      do i = 1, size(scene%bodies)
         scene%bodies(i)%material_index = material_index(scene, scene%bodies(i)%material)
      end do
      is_used = [(any(scene%bodies%material_index == k), k=1, size(is_used))]
      allocate (used(count(is_used)))
      do k = 1, size(is_used)
         if (is_used(k)) used(count(is_used(:k))) = scene%materials(k)
      end do
      do i = 1, size(scene%bodies)
         scene%bodies(i)%material_index = count(is_used(:scene%bodies(i)%material_index))
      end do
      call move_alloc(used, scene%materials)
      do i = 1, size(scene%bodies)
         associate (index => scene%bodies(i)%material_index)
            do k = index - 1, 1, -1
               if (scene%materials(k)%is_the_same_as(scene%materials(index))) index = k
            end do
         end associate
      end do
   end subroutine find_materials

   !> Find the crack of each cohesion and growth by its name, or the only one; 0 where there is none.
   pure subroutine find_growing_paths(scene)
      type(scene_t), intent(inout) :: scene
      integer :: i
      do i = 1, size(scene%cohesive)
         associate (cohesive => scene%cohesive(i))
            cohesive%path = path_of(scene, cohesive%crack)
            if (cohesive%path > 0) scene%paths(cohesive%path)%held_from = cohesive%from
            if (scene%crack%kind == 'symmetry') cohesive%path = 1
         end associate
      end do
      do i = 1, size(scene%growth)
         associate (growth => scene%growth(i))
            growth%path = path_of(scene, growth%crack)
            if (growth%crack == '' .and. scene%crack%kind == 'symmetry') growth%path = 1
         end associate
      end do
   end subroutine find_growing_paths

   !> Number of the path of a name, or without one of the only path; 0 where there is none.
   pure integer function path_of(scene, name)
      type(scene_t), intent(in) :: scene
      character(*), intent(in) :: name
      do path_of = size(scene%paths), 1, -1
         if (merge(size(scene%paths) == 1, scene%paths(path_of)%name == name, name == '')) return
      end do
   end function path_of

   !> Whether cracks of kind 'path', or edges of bodies that are no rectangles, cut cells.
   pure logical function cuts_cells(scene)
      type(scene_t), intent(in) :: scene
      integer :: k
      cuts_cells = size(scene%paths) > 0 .or. any([(scene%bodies(k)%outline%is_there(), k=1, size(scene%bodies))])
   end function cuts_cells

   !> Position of the material of this name, 0 where there is none.
   pure integer function material_index(scene, name)
      type(scene_t), intent(in) :: scene
      character(*), intent(in) :: name
      do material_index = size(scene%materials), 1, -1
         if (scene%materials(material_index)%name == name) return
      end do
   end function material_index
end module hampm_scene
