!> What &accuracy chooses for a model, and the runs that tell which mesh: those of one mesh for its errors alone, and the pilots.
!>
!> In motion, in solids, and where only other meshes tell an error, each family of meshes and steps that the rules allow has three
!> coarse runs, its pilots: on the coarsest lattice, with more levels around the tips, and on a finer lattice. Pilots measure few
!> rows.
module hampm_choice_runs
   use hampm_kinds, only: dp, ndim
   use hampm_asked_errors, only: worst_ratio
   use hampm_critical_step, only: largest_wave_speed
   use hampm_failure, only: failure_t, exit_computation
   use hampm_families, only: family_t
   use hampm_lattices, only: lattices_t
   use hampm_mesh_trials, only: aim, is_better, limits_t, mesh_t, most_particles, pilot_t, trials_t
   use hampm_model, only: model_t
   use hampm_model_materials, only: materials_of
   use hampm_reading, only: understand_model
   use hampm_resource_estimate, only: estimate_resources, resources_t
   use hampm_run, only: run
   use hampm_settings, only: settings_t
   use hampm_simulation, only: simulation_t, build, release
   use hampm_text, only: string_t, to_text
   implicit none
   private
   public :: choice_t, take, take_cheapest, choose_by_pilots, try, chosen, rows_of, bytes_of

   integer, parameter :: n_pilots = 3
   integer, parameter :: most_rows = 200         !! of a pilot in motion
   real(dp), parameter :: worth = 0.15_dp        !! work of pilots of another family over that of the best so far, at most
   real(dp), parameter :: step_of_lattice = 1.5_dp !! number of the lattice of the second pilot over that of the first

   !> The choice for a model.
   type :: choice_t
      logical :: is_open = .false.               !! whether anything is left to choose
      character(:), allocatable :: path, text    !! of the namelist file
      type(model_t) :: asked                     !! the model as it is given
      type(settings_t) :: written                !! its settings
      type(string_t), allocatable :: given(:)    !! overrides of the command line
      type(string_t), allocatable :: chosen(:)   !! chosen ones
      type(trials_t), allocatable :: trials(:)   !! by family
      type(lattices_t) :: lattices
      type(limits_t) :: limits
      integer :: family = 0                      !! chosen one
      integer :: scout = 0                       !! one that runs before a dearer one where even the coarsest lattice is fine
      type(mesh_t) :: mesh                       !! chosen one
      real(dp) :: predicted = 0                  !! its error over that asked [-]
      real(dp) :: reached = 0                    !! that of its run [-]
      real(dp) :: pilots = 0                     !! processor time of all pilots [s]
      integer :: tries = 0                       !! runs so far
      integer :: stalls = 0                      !! the last of them that gained next to nothing
      logical :: is_judged = .false.             !! whether the mesh is known to reach the error, or to be the best
      type(pilot_t) :: first                     !! the first of these runs
   end type choice_t

contains

   !> Take a mesh of a family.
   subroutine take(choice, family, mesh, model, failure)
      type(choice_t), intent(inout) :: choice
      integer, intent(in) :: family
      type(mesh_t), intent(in) :: mesh
      type(model_t), intent(out) :: model
      type(failure_t), intent(inout) :: failure
      choice%family = family
      choice%mesh = mesh
      choice%chosen = chosen(choice, choice%trials(family)%family, mesh)
      call understand_model(choice%path, choice%text, choice%given, model, failure, chosen=choice%chosen)
   end subroutine take

   !> Take the cheapest mesh of all families.
   subroutine take_cheapest(choice, model, failure)
      type(choice_t), intent(inout) :: choice
      type(model_t), intent(inout) :: model
      type(failure_t), intent(inout) :: failure
      type(mesh_t) :: mesh, best
      real(dp) :: work, error, least_work, least_error
      integer :: k, family
      least_work = huge(least_work)
      least_error = huge(least_error)
      family = 0
      do k = 1, size(choice%trials)
         if (.not. choice%trials(k)%is_allowed) cycle
         call choice%trials(k)%find_cheapest(choice%limits, mesh, work, error)
         if (.not. is_better(error, work, least_error, least_work)) cycle
         least_error = error
         least_work = work
         best = mesh
         family = k
      end do
      if (family == 0) then
         call failure%report(exit_computation, '&accuracy most_time or most_memory: even the '// &
                             'coarsest mesh is predicted to take more')
         return
      end if
      choice%predicted = choice%trials(family)%error_of(best)
      call take(choice, family, best, model, failure)
   end subroutine take_cheapest

   !> After a run of the first mesh of a solid or of a motion: run the pilots of all families, and choose by them.
   subroutine choose_by_pilots(choice, first, threads, model, failure)
      type(choice_t), intent(inout) :: choice
      type(pilot_t), intent(in) :: first         !! that run
      integer, intent(in) :: threads
      type(model_t), intent(inout) :: model
      type(failure_t), intent(inout) :: failure
      type(mesh_t) :: mesh
      real(dp) :: work, least_work, error
      real(dp) :: few_rows                       ! of pilots
      type(mesh_t) :: meshes(n_pilots)
      integer :: i, j, k
      few_rows = min(rows_of(choice%asked), real(most_rows + 1, dp))
      least_work = huge(least_work)
      do i = 0, size(choice%trials)              ! the family of that run first
         k = merge(choice%family, i, i == 0)
         if (i == choice%family .or. .not. choice%trials(k)%is_allowed) cycle
         if (i > 0) then                         ! as many cells as in the first pilot
            choice%trials(k)%particles = first%particles*(real(choice%trials(k)%family%points_per_cell, dp)/ &
                                                          choice%trials(choice%family)%family%points_per_cell)**ndim
            meshes = meshes_of_pilots(choice, choice%trials(k))
            choice%trials(k)%is_allowed = sum([(choice%trials(k)%work_of(meshes(j), rows=few_rows), j=1, n_pilots)]) < &
                                          worth*least_work
            if (.not. choice%trials(k)%is_allowed) cycle
         end if
         call try_family(choice, choice%trials(k), i == 0, first, threads)
         if (.not. choice%trials(k)%is_allowed) cycle
         call choice%trials(k)%find_cheapest(choice%limits, mesh, work, error)
         if (error <= 1) least_work = min(least_work, work)
      end do
      call take_cheapest(choice, model, failure)
   end subroutine choose_by_pilots

   !> Run the pilots of a family. It is not allowed where the first one fails.
   subroutine try_family(choice, trials, is_known, known, threads)
      type(choice_t), intent(inout) :: choice
      type(trials_t), intent(inout) :: trials
      logical, intent(in) :: is_known            !! whether the first pilot is
      type(pilot_t), intent(in) :: known         !! that
      integer, intent(in) :: threads
      type(mesh_t) :: meshes(n_pilots)
      type(pilot_t) :: first, finer, deeper
      type(failure_t) :: refused
      logical :: scouts                          ! whether the finer lattice comes first
      first = known
      if (.not. is_known) call try(choice, trials%family, trials%first, threads, .false., first, refused)
      trials%is_allowed = .not. refused%failed()
      if (.not. trials%is_allowed) return
      meshes = meshes_of_pilots(choice, trials)
      deeper = first
      finer = first
      scouts = trials%compares .and. trials%family%time == 'static' .and. .not. choice%limits%has_lattice
      if (scouts) then                           ! where a finer lattice is enough levels do not matter
         call try_other(3, finer)
         call trials%fit(first, finer, first, meshes(3), trials%first)
         if (meshes(3)%lattice > trials%first%lattice .and. trials%error_of(meshes(3)) <= aim) return
      end if
      if (.not. choice%limits%has_levels) call try_other(2, deeper)
      if (.not. (scouts .or. choice%limits%has_lattice) .and. (trials%compares .or. deeper%error > aim)) call try_other(3, finer)
      call trials%fit(first, finer, deeper, meshes(3), meshes(2))

   contains

      !> Run another one of the pilots; the first one stands for it where it fails.
      subroutine try_other(k, pilot)
         integer, intent(in) :: k
         type(pilot_t), intent(inout) :: pilot
         type(pilot_t) :: other
         call try(choice, trials%family, meshes(k), threads, .false., other, refused)
         if (refused%failed()) meshes(k) = trials%first
         if (.not. refused%failed()) pilot = other
      end subroutine try_other
   end subroutine try_family

   !> The meshes of the pilots of a family: the first one, one with more levels, and one on a finer lattice.
   pure function meshes_of_pilots(choice, trials) result(meshes)
      type(choice_t), intent(in) :: choice
      type(trials_t), intent(in) :: trials
      type(mesh_t) :: meshes(n_pilots)
      meshes = trials%first
      if (.not. choice%limits%has_levels) meshes(2)%levels = trials%first%levels + trials%family%level_step
      if (.not. choice%limits%has_lattice) meshes(3)%lattice = ceiling(step_of_lattice*trials%first%lattice)
   end function meshes_of_pilots

   !> Run a mesh of a family for its errors alone.
   subroutine try(choice, family, mesh, threads, is_whole, pilot, refused)
      type(choice_t), intent(inout) :: choice
      type(family_t), intent(in) :: family
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: threads
      logical, intent(in) :: is_whole            !! whether all rows are measured, as in a run
      type(pilot_t), intent(out) :: pilot
      type(failure_t), intent(out) :: refused
      type(model_t) :: trial
      type(simulation_t) :: s
      type(string_t) :: few                      ! rows
      real(dp) :: start, end
      call cpu_time(start)
      few%text = 'output.history_interval='//to_text(max(choice%asked%output%history_interval, choice%asked%run%end_time/most_rows))
      if (is_whole .or. family%time == 'static') then
         call understand_model(choice%path, choice%text, choice%given, trial, refused, chosen=chosen(choice, family, mesh))
      else
         call understand_model(choice%path, choice%text, choice%given, trial, refused, chosen=[chosen(choice, family, mesh), few])
      end if
      if (.not. refused%failed()) call build(trial, threads, s, refused)
      if (.not. refused%failed()) then
         pilot%particles = s%problem%particles%n
         s%is_pilot = .true.
         call run(s, '', .true., refused)
         if (.not. refused%failed()) pilot%error = worst_ratio(s%asked)
         if (.not. refused%failed()) pilot%values = s%asked
         call release(s)
      end if
      call cpu_time(end)
      pilot%seconds = end - start
      if (.not. refused%failed()) pilot%bytes = bytes_of(trial)
      if (.not. refused%failed()) pilot%rows = rows_of(trial)
      choice%pilots = choice%pilots + pilot%seconds
   end subroutine try

   !> The overrides that make a mesh of a family of a model.
   function chosen(choice, family, mesh) result(overrides)
      type(choice_t), intent(in) :: choice
      type(family_t), intent(in) :: family
      type(mesh_t), intent(in) :: mesh
      type(string_t), allocatable :: overrides(:)
      integer :: k, body
      allocate (overrides(0))
      if (.not. choice%limits%has_lattice) overrides = choice%lattices%overrides(mesh%lattice, family%order)
      call set('grid', 'order', to_text(family%order))
      do k = 1, choice%written%count_of('body')
         body = choice%written%find('body', k)
         if (choice%written%flag(body, 'hole') .or. choice%written%given(body, 'points_per_cell')) cycle
         call add('body('//to_text(k)//').points_per_cell='//to_text(family%points_per_cell))
      end do
      if (.not. choice%limits%has_levels .and. (mesh%levels > 0 .or. choice%written%find('refine', 1) == 0)) then
         call add('refine.indicator='//trim(merge('tip ', 'none', mesh%levels > 0)))
         if (mesh%levels > 0) then
            call set('refine', 'max_level', to_text(mesh%levels))
            call set('refine', 'rings', to_text(family%rings))
            call set('refine', 'max_particles', to_text(nint(2*most_particles)))
         end if
      end if
      if (family%time /= choice%asked%method%time) call add('method.time='//trim(family%time))
      if (family%mass /= 'auto') call set('method', 'mass', trim(family%mass))
      if (family%time == 'implicit' .and. .not. (written_key('method', 'time_step') .or. written_key('method', 'courant'))) &
         call add('method.time_step='//to_text(choice%lattices%cell_size(mesh%lattice, family%order)/ &
                                               largest_wave_speed(materials_of(choice%asked), 'dilatational')))
      if (size(choice%asked%energy_release%chosen) == 0 .and. size(choice%asked%paths) + size(choice%asked%planes) > 0) &
         call add('energy_release.estimators=''domain_integral''')

   contains

      !> Add an override.
      subroutine add(text)
         character(*), intent(in) :: text
         type(string_t) :: override
         override%text = text
         overrides = [overrides, override]
      end subroutine add

      !> Set a key that is not given.
      subroutine set(group, key, value)
         character(*), intent(in) :: group, key, value
         if (.not. written_key(group, key)) call add(group//'.'//key//'='//value)
      end subroutine set

      !> Whether a key is given.
      logical function written_key(group, key) result(is_given)
         character(*), intent(in) :: group, key
         is_given = choice%written%given(choice%written%find(group, 1), key)
      end function written_key
   end function chosen

   !> Rows of the history of a model.
   pure real(dp) function rows_of(model) result(rows)
      type(model_t), intent(in) :: model
      rows = 1 + model%run%end_time/model%output%history_interval
   end function rows_of

   !> Memory of a model for each of its particles [bytes].
   real(dp) function bytes_of(model) result(bytes)
      type(model_t), intent(in) :: model
      type(resources_t) :: resources
      resources = estimate_resources(model)
      bytes = resources%memory/max(resources%particles, 1.0_dp)
   end function bytes_of
end module hampm_choice_runs
