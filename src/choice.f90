!> The choice of mesh and steps by the errors that &accuracy asks. What the user gives stays, what he leaves out is chosen.
!>
!> At rest in the plane the coarsest mesh runs first, then one with as many levels as the tips need, and then the cheapest one whose
!> error is predicted to be small enough (`hampm_mesh_trials`); each run that falls short corrects the prediction. In motion, in
!> solids, and where only other meshes tell an error, pilots of all families that the rules allow come before
!> (`hampm_choice_runs`).
module hampm_choice
   use hampm_kinds, only: dp, ndim
   use hampm_asked_errors, only: no_value, worst_difference, worst_ratio
   use hampm_choice_runs, only: bytes_of, choice_t, choose_by_pilots, chosen, rows_of, take, take_cheapest, try
   use hampm_critical_step, only: largest_wave_speed
   use hampm_failure, only: failure_t, exit_computation
   use hampm_families, only: families
   use hampm_lattices, only: new_lattices
   use hampm_mesh_trials, only: aim, mesh_t, pilot_t
   use hampm_model, only: model_t
   use hampm_model_materials, only: materials_of
   use hampm_reading, only: understand_model
   use hampm_settings, only: settings_t
   use hampm_simulation, only: simulation_t
   use hampm_text, only: string_t, digits_text
   implicit none
   private
   public :: choose, fell_short

   real(dp), parameter :: ringing = 20           !! crossings of the model by waves from which modes and implicit steps may pay
   real(dp), parameter :: least_factor = 1.05_dp !! by which a run that falls short makes the prediction larger
   real(dp), parameter :: least_predicted = 1e-9_dp !! of predicted errors and differences that are compared [-]
   real(dp), parameter :: least_gained = 0.25_dp  !! of a predicted error: meshes that are nearly alike differ by other errors
   real(dp), parameter :: fine = 1500             !! cells of the coarsest lattice from which bilinear ones may be enough
   real(dp), parameter :: usual_error = 0.015_dp  !! estimated error of K on the coarsest lattice of the plane without levels
   integer, parameter :: most_doublings = 3      !! of the coarsest lattice, where rules ask for finer cells
   real(dp), parameter :: stalled = 0.8_dp       !! part of the last error from which on finer meshes are no use
   integer, parameter :: most_stalls = 2         !! runs in a row that gain next to nothing: one may have cut its cells badly
   integer, parameter :: most_tries = 6          !! of runs that fall short

contains

   !> Choose mesh and steps of a model that is known but for them. Where nothing is left to choose only its errors are compared with
   !> those asked, at its end.
   subroutine choose(path, text, overrides, threads, checks, explains, model, written, choice, failure)
      character(*), intent(in) :: path, text     !! of the namelist file
      type(string_t), intent(in) :: overrides(:) !! of the command line
      integer, intent(in) :: threads
      logical, intent(in) :: checks, explains    !! whether the choice is wanted without a run: as it is predicted, and with what
                                                 !! other errors cost; or as a run would end
      type(model_t), intent(inout) :: model      !! as it is given; then with what is chosen
      type(settings_t), intent(in) :: written
      type(choice_t), intent(out) :: choice
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: refused
      type(pilot_t) :: pilot
      type(mesh_t) :: deeper
      real(dp) :: verdict                        ! error of the mesh over that asked, predicted where it has not been run [-]
      logical :: goes, judges                    ! whether runs are tried until one reaches the error, or comes nearest
      choice%path = path
      choice%text = text
      choice%given = overrides
      choice%chosen = [string_t ::]
      choice%asked = model
      choice%written = written
      if (size(model%accuracy) == 0) return
      choice%limits%has_lattice = .not. model%lacks_lattice
      choice%limits%has_levels = written%given(written%find('refine', 1), 'indicator') .or. &
                                 size(model%paths) + size(model%planes) == 0
      choice%is_open = .not. (choice%limits%has_lattice .and. choice%limits%has_levels .and. &
                              written%given(written%find('grid', 1), 'order'))
      if (.not. choice%is_open) return
      choice%limits%seconds = minval(model%accuracy%most_time, mask=model%accuracy%most_time > 0) ! huge where there is none
      choice%limits%bytes = minval(model%accuracy%most_memory, mask=model%accuracy%most_memory > 0)
      choice%lattices = new_lattices(model)
      call find_families(choice, failure)
      if (failure%failed()) return
      call take(choice, choice%family, choice%trials(choice%family)%first, model, failure)
      if (failure%failed()) return
      associate (asked => choice%asked%accuracy)
         judges = checks .or. any(asked%must .or. asked%most_time > 0 .or. asked%most_memory > 0)
      end associate
      judges = explains .or. judges .and. model%method%time == 'static' ! in motion that is too long
      if (.not. (judges .or. choice%trials(choice%family)%compares)) return
      do
         call try(choice, choice%trials(choice%family)%family, choice%mesh, threads, judges .and. choice%tries > 0, pilot, refused)
         if (refused%failed()) then
            call failure%report(refused%code, refused%message, refused%records)
            return
         end if
         goes = goes_on(choice, pilot, threads, model, failure)
         verdict = merge(choice%predicted, choice%reached, goes)
         if (failure%failed()) return
         if (.not. judges .or. .not. goes .and. (choice%tries > 1 .or. .not. choice%trials(choice%family)%compares)) exit
      end do
      choice%is_judged = judges .and. model%method%time == 'static'
      if (choice%is_judged) choice%predicted = choice%reached
      associate (trials => choice%trials(choice%family))
         if (checks .and. choice%is_judged .and. choice%tries == 1 .and. .not. choice%limits%has_levels) then ! for other errors
            deeper = mesh_t(trials%first%lattice, trials%levels_for(trials%error_of(trials%first), &
                                                                    trials%first%levels + trials%family%level_step))
            call try(choice, trials%family, deeper, threads, .false., pilot, refused)
            if (.not. refused%failed()) call trials%fit(choice%first, choice%first, pilot, trials%first, deeper)
         end if
      end associate
      if (verdict > 1 .and. any(choice%asked%accuracy%must)) call failure%report(exit_computation, '&accuracy error: it cannot '// &
         'be reached within the limits: the best mesh has '//digits_text(verdict, 2)// &
         ' times the error asked. Ask for less, allow more time or memory, or use must = .false. for that mesh')
   end subroutine choose

   !> Find the families that the rules allow, and the first of them. Bilinear cells are for models that have no others.
   subroutine find_families(choice, failure)
      type(choice_t), intent(inout) :: choice
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: refused
      type(model_t) :: trial
      real(dp) :: size_of, crossings             ! of the model [m], by waves until the end
      real(dp) :: least_work
      type(mesh_t) :: finer
      integer :: k, i, level, lowest, double
      logical :: scouts                          ! whether a family of fewer unknowns runs first
      size_of = maxval(choice%lattices%upper - choice%lattices%lower)
      crossings = choice%asked%run%end_time*largest_wave_speed(materials_of(choice%asked), 'dilatational')/size_of
      associate (lattices => choice%lattices)
         scouts = ndim == 2 .and. choice%asked%method%time == 'static' .and. lattices%fits .and. &
                  .not. (lattices%has_middles .or. choice%limits%has_lattice) .and. &
                  product((lattices%upper - lattices%lower)/lattices%cell_size(lattices%first, 2)) > fine
      end associate
      allocate (choice%trials(size(families)))
      do k = 1, size(families)
         choice%trials(k)%family = families(k)
         associate (trials => choice%trials(k), family => families(k), model => choice%asked, written => choice%written)
            if (family%time /= model%method%time .and. &
                (model%method%time == 'static' .or. family%time == 'static' .or. &
                 written%given(written%find('method', 1), 'time'))) cycle
            if (written%given(written%find('grid', 1), 'order') .and. family%order /= model%grid%order) cycle
            if (any(family%time == ['modal   ', 'implicit']) .and. crossings < ringing .and. &
                any(choice%trials(:k)%is_allowed)) cycle
            trials%compares = family%time /= 'static' .or. .not. choice%lattices%fits .or. &
                              any([(any(model%planes(i)%front == ['straight', 'polygon ']), i=1, size(model%planes))])
            trials%first = mesh_t(choice%lattices%first, merge(0, family%first_level, choice%limits%has_levels))
            if (ndim == 2 .and. .not. (trials%compares .or. choice%limits%has_levels)) &
               trials%first%levels = trials%levels_for(usual_error/minval(model%accuracy%error), trials%first%levels)
            trials%rows = rows_of(model)
            associate (before => choice%trials(:k)%is_allowed .and. choice%trials(:k)%family%time == family%time)
               if (family%is_second .and. any(before .and. choice%trials(:k)%family%order >= family%order)) then
                  if (.not. scouts) cycle
                  choice%scout = k
               end if
               if (any(before .and. choice%trials(:k)%family%order == family%order) .and. &
                   written%given(written%find('method', 1), 'mass')) cycle
            end associate
            lowest = trials%first%levels
            do double = 0, merge(0, most_doublings, choice%limits%has_lattice)
               do i = lowest, merge(lowest, lowest + family%most_level, choice%limits%has_levels)
                  level = modulo(i, family%most_level + 1) ! then fewer, where rules refuse levels
                  trials%first = mesh_t(choice%lattices%first*2**double, level) ! fine enough for growth, and around fronts
                  refused = failure_t()
                  call understand_model(choice%path, choice%text, choice%given, trial, refused, &
                                        chosen=chosen(choice, family, trials%first))
                  trials%is_allowed = .not. refused%failed()
                  if (trials%is_allowed) exit
               end do
               if (trials%is_allowed) exit
            end do
            trials%steps = crossings*size_of/choice%lattices%cell_size(trials%first%lattice, family%order)
         end associate
      end do
      choice%family = findloc(choice%trials%is_allowed, .true., dim=1)
      least_work = huge(least_work)
      do k = 1, size(families)                   ! first that which a finer mesh costs least in
         if (.not. choice%trials(k)%is_allowed) cycle
         associate (trials => choice%trials(k), family => families(k))
            trials%in_box = product((choice%lattices%upper - choice%lattices%lower)*family%points_per_cell/ &
                                    choice%lattices%cell_size(trials%first%lattice, family%order))
            trials%particles = trials%in_box
            finer = mesh_t(2*trials%first%lattice, trials%first%levels + 3*family%level_step)
            if (.not. trials%work_of(finer) < least_work) cycle
            least_work = trials%work_of(finer)
            choice%family = k
         end associate
      end do
      if (choice%family == 0) call failure%report(refused%code, refused%message, refused%records)
   end subroutine find_families

   !> After a run: whether it fell short of the error asked and another mesh, which is then chosen, is better.
   logical function fell_short(choice, s, seconds, threads, model, failure)
      type(choice_t), intent(inout) :: choice
      type(simulation_t), intent(in) :: s
      real(dp), intent(in) :: seconds            !! of the processor that it took [s]
      integer, intent(in) :: threads
      type(model_t), intent(inout) :: model
      type(failure_t), intent(inout) :: failure
      fell_short = .false.
      if (.not. choice%is_open .or. failure%failed() .or. .not. allocated(s%asked)) return
      fell_short = goes_on(choice, pilot_t(worst_ratio(s%asked), real(s%problem%particles%n, dp), rows_of(model), seconds, &
                                           bytes_of(model), s%asked), threads, model, failure)
   end function fell_short

   !> After a run, for real or not: whether another mesh, which is then chosen, is better.
   logical function goes_on(choice, pilot, threads, model, failure) result(goes)
      type(choice_t), intent(inout) :: choice
      type(pilot_t), intent(in) :: pilot         !! that run
      integer, intent(in) :: threads
      type(model_t), intent(inout) :: model
      type(failure_t), intent(inout) :: failure
      real(dp) :: factor                         ! of the error over the predicted one [-]
      real(dp) :: differs, gained, last
      type(mesh_t) :: before
      integer :: family, k
      logical :: traps                           ! whether values differ more than they were to where levels are
      logical :: deepens                         ! whether the second mesh is the first one with more levels
      logical :: keeps                           ! whether the run kept within the limits
      goes = .false.
      before = choice%mesh
      family = choice%family
      choice%tries = choice%tries + 1
      last = choice%reached
      if (choice%is_judged) then                 ! by runs of the same meshes
         choice%reached = max(choice%reached, pilot%error)
         return
      end if
      choice%reached = pilot%error
      associate (trials => choice%trials(family), compares => choice%trials(family)%compares)
         if (family == choice%scout .and. pilot%error > 1 .and. pilot%error < no_value) then
            trials%is_allowed = .false.
            choice%tries = 0
            choice%scout = 0
            family = findloc(choice%trials%is_allowed, .true., dim=1)
            call take(choice, family, choice%trials(family)%first, model, failure)
            goes = .not. failure%failed()
            return
         end if
         if (choice%tries == 1) choice%first = pilot
         if (choice%tries == 1) call trials%fit(pilot, pilot, pilot, trials%first, trials%first)
         deepens = .not. (compares .or. ndim == 3 .or. choice%limits%has_levels)
         if (choice%tries == 2 .and. deepens) call trials%fit(choice%first, choice%first, pilot, trials%first, before)
         keeps = pilot%seconds <= choice%limits%seconds .and. pilot%particles*pilot%bytes <= choice%limits%bytes
         if (pilot%error <= 1 .and. keeps .and. .not. compares .or. pilot%error >= no_value .or. choice%tries > most_tries) return
         choice%stalls = merge(choice%stalls + 1, 0, choice%tries > 2 .and. pilot%error > stalled*last)
         if (choice%stalls == most_stalls .and. keeps .and. .not. compares) return
         if (choice%tries == 1 .and. (compares .or. ndim == 3) .or. compares .and. .not. allocated(trials%values)) then
            call choose_by_pilots(choice, pilot, threads, model, failure)
         else if (choice%tries == 1 .and. deepens .and. keeps) then
            choice%predicted = aim
            call take(choice, family, mesh_t(trials%first%lattice, trials%levels_for(pilot%error, &
                      trials%first%levels + trials%family%level_step)), model, failure)
         else if (choice%tries == 1 .or. choice%tries == 2 .and. deepens) then
            call take_cheapest(choice, model, failure)
         else
            if (compares) then                   ! what it differs by from the last run, beside what it was to differ by
               gained = max(abs(trials%error_of(trials%compared) - trials%error_of(choice%mesh)), least_gained*choice%predicted)
               differs = worst_difference(trials%values, pilot%values)
               choice%reached = max(pilot%error, differs/max(gained, least_predicted)*choice%predicted)
               if (trials%family%time == 'explicit' .and. (choice%mesh%levels /= trials%compared%levels .or. &
                                                           choice%mesh%lattice <= trials%compared%lattice)) &
                  choice%reached = max(choice%reached, differs) ! either may have waves of its cells
               if (choice%reached <= 1) return
            end if
            factor = max(choice%reached/max(choice%predicted, least_predicted), least_factor)
            traps = trials%of_tips > 0 .and. pilot%error <= 1 .and. trials%family%time == 'explicit' .and. choice%mesh%levels > 0
            if (compares .and. .not. traps) then
               trials%compared = choice%mesh
               trials%values = pilot%values
            end if
            if (traps) then                      ! waves of the cells, by levels: smaller cells instead, beside those of the pilot
               trials%of_cells = trials%of_cells + trials%of_tips
               trials%of_tips = 0
               factor = 1
            else
               call trials%learn(choice%reached, choice%mesh, factor)
            end if
            do k = 1, size(choice%trials)        ! pilots of others had the same rows, and hoped for as much
               if (k == family .or. .not. (compares .and. choice%trials(k)%compares)) cycle
               choice%trials(k)%of_cells = factor*choice%trials(k)%of_cells
               choice%trials(k)%of_tips = factor*choice%trials(k)%of_tips
            end do
            call take_cheapest(choice, model, failure)
            if (choice%predicted > 1 .and. choice%predicted >= choice%reached .and. .not. failure%failed()) then
               choice%predicted = choice%reached ! no mesh reaches it, and that of the run comes nearest
               call take(choice, family, before, model, failure)
            end if
         end if
      end associate
      goes = .not. failure%failed() .and. (choice%mesh%lattice /= before%lattice .or. &
                                           choice%mesh%levels /= before%levels .or. choice%family /= family)
      if (.not. goes) choice%reached = max(choice%reached, choice%predicted)
   end function goes_on
end module hampm_choice
