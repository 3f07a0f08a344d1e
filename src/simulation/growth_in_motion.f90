!> Growth in motion: tips along paths whose cells are cut in advance (`hampm_dynamic_growth`), fronts of solids by regions of planes
!> (`hampm_moving_front`), at given speeds or at those of their toughness; tips in implicit steps at the advance that keeps G at the
!> toughness (`hampm_advance_search`).
module hampm_growth_in_motion
   use hampm_cracks, only: cracks_t
   use hampm_dynamic_front_growth, only: lay_points, move_fronts
   use hampm_dynamic_growth, only: find_speeds, move_tips, must_check, note_check, plan_ways
   use hampm_failure, only: failure_t
   use hampm_growing, only: growing_t, note_taken, part_of_crack
   use hampm_growth_at_rest, only: note_separation
   use hampm_advance_search, only: begin_search, follow_search, advance_search_t
   use hampm_growth_room, only: find_loose_tips
   use hampm_interface_points, only: interface_energy, is_half
   use hampm_kinds, only: dp, ndim
   use hampm_measurements, only: has_measured_tips, measure_tips, measurements_t
   use hampm_mesh_changes, only: change_cut
   use hampm_nodal_state, only: external_force, internal_force
   use hampm_problem, only: problem_t, refresh_grid, update_particles
   use hampm_simulation, only: simulation_t
   implicit none
   private
   public :: prepare_motion, advance_by_trials, follow_motion

contains

   !> Before a step: find speeds, and cut cells ahead of tips. Fronts advance before an implicit step, which ends in balance with
   !> them.
   subroutine prepare_motion(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (must_check(s%growing, s%model, s%problem, s%dt)) call check_points(s, failure)
      if (s%growing%is_implicit .or. failure%failed()) return
      call plan_ways(s%growing, s%model, s%problem, s%cracks, s%dt, s%warning)
      if (.not. s%problem%interfaces%are_bounded) call move_points(s, s%problem%state%time)
      call cut_where_due(s, failure)
   end subroutine prepare_motion

   !> In motion: measure G and K, unless a row has done so, and find the speeds of points that grow by their toughness.
   subroutine check_points(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed()) return
      if (s%growing%is_implicit .or. .not. has_measured_tips(s%problem, s%measurements)) then ! trials repeat a step
         call update_particles(s%problem)
         call measure_tips(s%model, s%problem, s%cracks, s%measurements, failure)
      end if
      if (failure%failed()) return
      call lay_points(s%growing, s%measurements%fronts)
      call note_check(s%growing, s%cracks, s%measurements%crack)
      call find_speeds(s%growing, s%model, s%problem, s%cracks, s%measurements%crack, s%measurements%fronts, s%dt, s%warning)
   end subroutine check_points

   !> Cut cells anew where points ask for it: paths are planned, tips have ended, or fronts have opened more nodes.
   subroutine cut_where_due(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. s%growing%must_cut) return
      s%growing%must_cut = .false.
      call update_particles(s%problem)
      call change_cut(s, failure)
      if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%dt, failure)
      if (.not. failure%failed()) call hold_new_nodes(s%problem)
   end subroutine cut_where_due

   !> Advance tips and fronts in a step and release what they have passed: after an explicit step, before an implicit one, which
   !> ends in balance with them.
   subroutine move_points(s, time)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! at its start [s]
      real(dp) :: before                         ! [J]
      associate (m => s%problem)
         associate (n => m%interfaces%n)
            if (n > 0) m%interfaces%list(:n)%fraction_before = m%interfaces%list(:n)%fraction_left
         end associate
         before = interface_energy(m%interfaces) + m%energies%fracture_energy
         call move_tips(s%growing, s%model, m, s%cracks, time, s%dt, s%warning)
         call book_due(s)
         call move_fronts(s%growing, s%model, m, s%cracks, time, s%dt, s%warning)
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - &
            (interface_energy(m%interfaces) + m%energies%fracture_energy - before)
      end associate
   end subroutine move_points

   !> Book what the new faces of a step are to take, if all of them do so by their toughness.
   subroutine book_due(s)
      type(simulation_t), intent(inout) :: s
      integer :: k
      if (any(s%model%growth%law%gives_speed()) .or. size(s%model%cohesive) > 0) return
      associate (points => s%growing%points, taken => s%growing%taken)
         do k = 1, size(s%cracks%tips)
            associate (tip => s%cracks%tips(k))
               taken%due = taken%due + part_of_crack(tip)*s%model%run%thickness%at(tip%now)*tip%toughness*tip%speed*s%dt
            end associate
         end do
         taken%due = taken%due + sum(points%width*points%toughness*points%speed, mask=points%front > 0)*s%dt
         taken%way = taken%way + maxval(points%speed)*s%dt/s%problem%grid%finest_cell
      end associate
   end subroutine book_due

   !> Where the point that is the fastest is [m].
   pure function place_of_fastest(s) result(place)
      type(simulation_t), intent(in) :: s
      real(dp) :: place(ndim)
      integer :: k
      k = maxloc(s%growing%points%speed, dim=1)
      place = s%growing%points(k)%place
      if (k <= size(s%cracks%tips)) place = s%cracks%tips(k)%place
   end function place_of_fastest

   !> Advance by an implicit step with tips that grow: tried with other advances until G is the toughness (`hampm_advance_search`).
   subroutine advance_by_trials(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(growing_t) :: growing
      type(cracks_t) :: cracks
      type(measurements_t) :: measurements
      type(advance_search_t) :: search
      character(:), allocatable :: warning
      logical :: is_over
      call begin_search(s%growing, s%dt, search)
      call update_particles(s%problem)
      do
         call plan_ways(s%growing, s%model, s%problem, s%cracks, s%dt, s%warning)
         call cut_where_due(s, failure)
         if (failure%failed()) return
         call s%integrator%note_start(s%problem)
         warning = s%warning
         measurements = s%measurements
         cracks = s%cracks
         growing = s%growing
         call move_points(s, s%problem%state%time)
         call s%integrator%advance(s%problem, s%dt, failure)
         call check_points(s, failure)
         if (failure%failed()) return
         call follow_search(search, s%growing, s%cracks, s%dt, is_over)
         if (is_over) exit
         growing%points%point_search_t = s%growing%points%point_search_t
         s%growing = growing
         s%cracks = cracks
         s%measurements = measurements
         s%warning = warning
         call s%integrator%go_to_start(s%problem)
      end do
   end subroutine advance_by_trials

   !> Hold nodes that have become open by points with the force that keeps the material on both sides together.
   subroutine hold_new_nodes(m)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable :: force(:, :), loads(:, :), mass(:, :)
      real(dp) :: weight, light
      integer :: k, side
      if (.not. any(m%interfaces%list(:m%interfaces%n)%is_new)) return
      call refresh_grid(m)
      call internal_force(m, force)
      call external_force(m, m%state%time, loads)
      force = force + loads
      allocate (mass(1, m%grid%n_points), source=0.0_dp)
      do k = 1, m%particles%n
         mass(1, m%nodes_of(k)) = mass(1, m%nodes_of(k)) + m%particles%mass(k)*m%functions_of(k)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, 1, mass)
      do k = 1, m%interfaces%n
         associate (point => m%interfaces%list(k))
            if (.not. point%is_new) cycle
            point%is_new = .false.
            weight = 0
            do side = 1, count(point%jump%node > 0)
               light = 1/mass(1, point%jump%node(side))
               weight = weight + light
               point%initial_force = point%initial_force + point%jump%share(side)*light*force(:, point%jump%node(side))
            end do
            point%initial_force = point%initial_force/(weight*point%fraction_left)
            if (is_half(point)) point%initial_force = dot_product(point%initial_force, point%normal)*point%normal
         end associate
      end do
   end subroutine hold_new_nodes

   !> After a step: advance what has not advanced before it, cut cells anew where due, and check whether bodies separate where all
   !> points have failed.
   subroutine follow_motion(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: is_new
      if (s%problem%interfaces%are_bounded) call move_points(s, s%problem%state%time - s%dt)
      call note_taken(s%growing%taken, s%problem%energies%fracture_energy, s%problem%state%time, place_of_fastest(s))
      call cut_where_due(s, failure)
      call find_loose_tips(s%growing, s%problem%interfaces, is_new)
      if (is_new .and. .not. failure%failed()) call note_separation(s, s%problem%state%time)
   end subroutine follow_motion
end module hampm_growth_in_motion
