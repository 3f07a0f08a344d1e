!> Nucleation of cracks in equilibrium (`hampm_onset`): after each load step the load factor of the next crack is found, from
!> equilibria without it and with it at all candidate lengths; before the next step it is inserted, and may grow as any other.
module hampm_nucleation
   use hampm_kinds, only: dp, ndim
   use hampm_crack_lines, only: length_of
   use hampm_crack_placement, only: least_radius
   use hampm_failure, only: failure_t, exit_computation
   use hampm_growing, only: fitting
   use hampm_growth_room, only: see_around_tips, see_surroundings, room_of_material, room_of_tip
   use hampm_joints, only: groups_of_bodies
   use hampm_load_work, only: load_state_t, find_load_state
   use hampm_mesh_changes, only: cut_anew
   use hampm_onset, only: load_for_stress, parabola_through, load_for_energy, find_least, never
   use hampm_path_placement, only: place_along
   use hampm_point_values, only: view_t, surroundings_t, new_view, look_around
   use hampm_probes, only: add_means
   use hampm_problem, only: stored_energy
   use hampm_simulation, only: simulation_t
   use hampm_static_growth, only: has_held_drive, has_scaled_drive, book_work
   use hampm_tensors, only: norm, n_symmetric
   use hampm_text, only: to_text
   implicit none
   private
   public :: find_onset, insert_crack, book_onset

   !> Data of a crack that has not appeared.
   type :: candidate_t
      real(dp), allocatable :: length(:)         !! that are tried, ascending [m]
      real(dp), allocatable :: by_stress(:), by_energy(:) !! load factors for these
      real(dp), allocatable :: released(:, :)    !! energy over its area: coefficients of 1, l and l**2 [J/m2]
      integer :: tried = 0                       !! lengths that were
   end type candidate_t

contains

   !> After a load step, with loads scaled so that tips are about to grow, unless no tip does: find whether a crack appears before
   !> that, and its load factor. Cells are then as before, and loads still to be scaled.
   subroutine find_onset(s, any_grows, load, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: any_grows           !! whether a tip is about to grow
      real(dp), intent(out) :: load              !! [-]
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: rounding = 1e-7_dp  ! of load factors: of cracks that are alike the first one appears
      type(candidate_t) :: of
      real(dp), allocatable :: loads(:), before(:)
      real(dp) :: least, length
      integer :: k, tried
      load = s%growing%load_factor
      s%growing%onset_crack = 0
      s%growing%onset_length = 0
      s%growing%onset_released = 0
      if (failure%failed() .or. .not. any(s%cracks%crack%waits) .or. .not. has_scaled_drive(s%problem)) return
      loads = [load]
      if (has_held_drive(s%problem)) loads = load*[1.0_dp, 0.5_dp, 1.5_dp]
      allocate (before(size(loads)), source=0.0_dp)
      if (.not. any_grows) load = never
      do k = 1, size(s%model%nucleations)
         if (.not. s%cracks%crack(s%model%nucleations(k)%path)%waits) cycle
         call measure_without(s, k, loads, before, of, failure)
         call try_lengths(s, k, loads, before, load, of, failure)
         if (failure%failed()) return
         if (of%tried == 0) cycle
         call find_least(of%length(:of%tried), of%by_stress(:of%tried), of%by_energy(:of%tried), least, length, tried)
         if (least >= load*(1 - rounding)) cycle
         load = least
         s%growing%onset_crack = s%model%nucleations(k)%path
         s%growing%onset_length = length
         s%growing%onset_released = max(s%model%nucleations(k)%toughness, dot_product(of%released(:, tried), least**[0, 1, 2]))
      end do
      if (s%growing%onset_crack == 0) load = s%growing%load_factor
      if (load > 0) return
      call failure%report(exit_computation, s%problem%state%when()//'crack '//to_text(s%growing%onset_crack)// &
                          ' of the model appears by held loads or eigenstrains alone: no factor of the other loads is right')
   end subroutine find_onset

   !> Without the k-th crack that may appear: energies, and the load factors that the stress along it asks for.
   subroutine measure_without(s, k, loads, energy, of, failure)
      type(simulation_t), intent(inout) :: s
      integer, intent(in) :: k
      real(dp), intent(in) :: loads(:)           !! factors that are tried [-]
      real(dp), intent(out) :: energy(:)         !! [J]
      type(candidate_t), intent(out) :: of
      type(failure_t), intent(inout) :: failure
      integer, parameter :: looks = 16           ! at the stress along a crack that appears as a whole
      real(dp), allocatable :: stress(:, :), part(:) ! across the crack, at parts of it and at loads [Pa]
      real(dp) :: spacing
      integer :: i, n
      associate (nucleation => s%model%nucleations(k), crack => s%cracks%crack(s%model%nucleations(k)%path))
         n = 1
         if (nucleation%increment > 0) n = max(1, nint((crack%covered(2) - crack%covered(1))/nucleation%increment))
         spacing = (crack%covered(2) - crack%covered(1))/n
         of%length = spacing*[(i, i=1, n)]
         if (nucleation%increment > 0) of%length(:n - 1) = nucleation%increment*[(i, i=1, n - 1)]
         allocate (of%by_stress(n), of%by_energy(n), source=never)
         allocate (of%released(3, n), source=0.0_dp)
         part = (of%length + crack%covered(1))/length_of(crack%given) ! beside a notch nothing is known within an increment
         if (n == 1) part = (crack%covered(1) + spacing/looks*[(i - 0.5_dp, i=1, looks)])/length_of(crack%given)
         allocate (stress(size(part), size(loads)))
         do i = size(loads), 1, -1               ! the first is that at which it was
            if (size(loads) > 1) call s%integrator%rescale(s%problem, loads(i), failure)
            if (failure%failed()) return
            energy(i) = potential(s, failure)
            call find_stress(s, crack%given, part, stress(:, i))
         end do
         if (.not. nucleation%strength > 0) stress = spread(sum(stress, dim=1)/size(part), 1, size(part)) ! it need but open
         stress(:, 1) = load_for_stress(held_part(stress), scaled_part(stress), nucleation%strength)
         of%by_stress = [(maxval(stress(:merge(size(part), i, n == 1), 1)), i=1, n)]
      end associate

   contains

      !> Stresses without scaled loads.
      pure function held_part(stress) result(part)
         real(dp), intent(in) :: stress(:, :)
         real(dp) :: part(size(stress, 1))
         part = stress(:, 1) - loads(1)*scaled_part(stress)
      end function held_part

      !> Change of stresses with the load factor.
      pure function scaled_part(stress) result(part)
         real(dp), intent(in) :: stress(:, :)
         real(dp) :: part(size(stress, 1))
         part = stress(:, 1)/loads(1)
         if (size(loads) > 1) part = (stress(:, 1) - stress(:, 2))/(loads(1) - loads(2))
      end function scaled_part
   end subroutine measure_without

   !> Find the stress across a crack that is not there.
   subroutine find_stress(s, points, part, stress)
      type(simulation_t), intent(in) :: s
      real(dp), intent(in) :: points(:, :)       !! of the crack [m]
      real(dp), intent(in) :: part(:)            !! of its length at which it is sought [-]
      real(dp), intent(out) :: stress(:)         !! there [Pa]
      type(view_t) :: view
      type(surroundings_t) :: around
      real(dp), parameter :: nowhere(ndim) = 0, step = 1e-6_dp
      real(dp) :: along(ndim), u(ndim), v(ndim), strain(n_symmetric), tensor(n_symmetric)
      integer :: i
      call new_view(s%problem%matter_t, s%cracks, groups_of_bodies(s%model), minval(points, dim=2), maxval(points, dim=2), view)
      do i = 1, size(part)
         along = place_along(points, min(1.0_dp, part(i) + step)) - place_along(points, max(0.0_dp, part(i) - step))
         u = 0
         v = 0
         strain = 0
         tensor = 0
         call look_around(s%problem%matter_t, view, place_along(points, part(i)), nowhere, around)
         call add_means(s%problem, around, 1.0_dp, u, v, strain, tensor)
         associate (n => [-along(2), along(1)]/norm(along))
            stress(i) = n(1)**2*tensor(1) + n(2)**2*tensor(2) + 2*n(1)*n(2)*tensor(3)
         end associate
      end do
   end subroutine find_stress

   !> Try the lengths of the k-th crack until strength governs: with more there is a larger load.
   subroutine try_lengths(s, k, loads, before, most, of, failure)
      type(simulation_t), intent(inout) :: s
      integer, intent(in) :: k
      real(dp), intent(in) :: loads(:)           !! factors that are tried [-]
      real(dp), intent(in) :: before(:)          !! energies without it [J]
      real(dp), intent(in) :: most               !! load factor at which something else comes first [-]
      type(candidate_t), intent(inout) :: of
      type(failure_t), intent(inout) :: failure
      real(dp) :: after(size(loads)), area
      integer :: i, j
      associate (nucleation => s%model%nucleations(k))
         do i = 1, size(of%length)
            if (of%by_stress(i) >= most .or. failure%failed()) exit
            call open_crack(s, nucleation%path, of%length(i))
            call cut_anew(s, failure)
            do j = size(loads), 1, -1
               if (size(loads) > 1 .and. .not. failure%failed()) call s%integrator%rescale(s%problem, loads(j), failure)
               if (.not. failure%failed()) after(j) = potential(s, failure)
            end do
            if (failure%failed()) exit
            area = area_of(s, nucleation%path, of%length(i))
            of%released(:, i) = parabola_through(loads, (before - after)/area)
            of%by_energy(i) = load_for_energy(of%released(:, i), nucleation%toughness)
            of%tried = i
            if (of%by_energy(i) <= of%by_stress(i)) exit
         end do
         if (of%tried == 0 .or. failure%failed()) return
         call s%cracks%hide(nucleation%path)
         call see_around_tips(s%model, s%cracks, nucleation%path)
      end associate
      call cut_anew(s, failure)
   end subroutine try_lengths

   !> Stored energy less the work of the loads [J]: its decrease is released by a new crack, under given loads and motions.
   real(dp) function potential(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(load_state_t) :: now
      call find_load_state(s%problem, now, failure)
      potential = stored_energy(s%problem) - sum(now%factor*now%energy)
   end function potential

   !> The area of a length of a crack [m2].
   pure real(dp) function area_of(s, path, length) result(area)
      type(simulation_t), intent(in) :: s
      integer, intent(in) :: path
      real(dp), intent(in) :: length             !! [m]
      integer, parameter :: parts = 64
      integer :: i
      associate (crack => s%cracks%crack(path))
         area = length/parts*sum([(s%model%run%thickness%at(place_along(crack%given, &
            (crack%covered(1) + (i - 0.5_dp)/parts*length)/length_of(crack%given))), i=1, parts)])
      end associate
   end function area_of

   !> Let a length of a crack be there, from its first point on.
   subroutine open_crack(s, path, length)
      type(simulation_t), intent(inout) :: s
      integer, intent(in) :: path
      real(dp), intent(in) :: length             !! [m]
      call s%cracks%show(path, length)
      call see_around_tips(s%model, s%cracks, path)
   end subroutine open_crack

   !> Let the crack be there whose turn it is, before cells are cut.
   subroutine insert_crack(s)
      type(simulation_t), intent(inout) :: s
      integer :: k, path
      path = s%growing%onset_crack
      s%growing%onset_crack = 0
      call open_crack(s, path, s%growing%onset_length)
      do k = 1, size(s%cracks%tips)
         associate (tip => s%cracks%tips(k))
            if (tip%crack /= path) cycle
            s%growing%points(k)%has_ended = .false.
            s%growing%points(k)%has_stopped = .false.
            if (.not. any(s%model%energy_release%chosen%needs_radii)) cycle
            associate (room => room_of_tip(s%model, s%cracks, tip))
               tip%has_no_domain = room < least_radius(s%model)*(1 - 1e-9_dp)
               tip%radii = fitting(tip%radii, least_radius(s%model), min(max(room, least_radius(s%model)), &
                                                                         room_of_material(s%model, tip)))
               call see_surroundings(s%model, tip)
               if (.not. tip%has_no_domain) cycle
               s%growing%points(k)%has_stopped = .true.
               call s%growing%warn_once(k, 'has appeared where no radius of two of the finest cells fits: its G, J and K are '// &
                                       'not numbers, and it does not grow. Take smaller cells', s%warning)
            end associate
         end associate
      end do
   end subroutine insert_crack

   !> Book the energy released by a new crack at the last load: dissipated by its faces, also what would become motion.
   subroutine book_onset(s, stored, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: stored             !! energy without it [J]
      type(failure_t), intent(inout) :: failure
      real(dp) :: taken
      taken = -s%growing%work
      call book_work(s%growing, s%problem, failure)
      taken = taken + s%growing%work - (stored_energy(s%problem) - stored)
      s%problem%energies%fracture_energy = s%problem%energies%fracture_energy + taken
      if (s%problem%audit) s%problem%energies%numerical_loss = s%problem%energies%numerical_loss - taken
   end subroutine book_onset
end module hampm_nucleation
