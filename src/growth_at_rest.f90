!> Cracks that grow at rest, by increments: in each load step tips advance, and all loads and prescribed motions are scaled so that the
!> largest energy release rate over its toughness is 1. What is left of the loads by themselves is how they are shared.
module hampm_growth_at_rest
   use hampm_kinds, only: dp, ndim
   use hampm_crack_measurements, only: crack_values_t, best_rate
   use hampm_crack_placement, only: least_radius
   use hampm_crack_tip, only: crack_tip_t
   use hampm_cracks, only: cracks_t
   use hampm_growing, only: growing_t, fitting, part_of_crack
   use hampm_growth_room, only: follow_in_scene, room_for, why_no_room
   use hampm_kinks, only: kink_angle
   use hampm_motion, only: motion_t, stored_energy
   use hampm_path_placement, only: path_radius
   use hampm_scene, only: scene_t
   implicit none
   private
   public :: advance_tips, turn_tips, book_fracture, factor_to_toughness, note_grown, note_drive, correct_work, scale_loads

   real(dp), parameter :: straight = 1e-3_dp     !! K_II over K_I below which a tip that has advanced needs no other direction
   real(dp), parameter :: steepness = 0.6_dp     !! change of K_II over K_I with the angle of the last increment [1/rad]

contains

   !> Number of the &growth of a tip that grows.
   pure integer function law_of(scene, tip)
      type(scene_t), intent(in) :: scene
      type(crack_tip_t), intent(in) :: tip
      law_of = findloc(scene%growth%path, tip%crack, dim=1)
   end function law_of

   !> Let tips advance by an increment. `have_moved` tells whether any has; `said` why some will no more.
   subroutine advance_tips(growing, scene, cracks, values, have_moved, said)
      type(growing_t), intent(inout) :: growing
      type(scene_t), intent(inout) :: scene      !! its paths follow the cracks
      type(cracks_t), intent(inout) :: cracks
      type(crack_values_t), intent(in) :: values(:) !! of each tip
      logical, intent(out) :: have_moved
      character(:), allocatable, intent(inout) :: said
      real(dp) :: rates(size(values))
      integer :: k
      growing%advance = 0
      rates = [(best_rate(values(k), cracks%tips(k)), k=1, size(values))]
      do k = 1, size(values)
         if (.not. growing%is_growing(k)) cycle
         associate (law => scene%growth(law_of(scene, cracks%tips(k))), tip => cracks%tips(k))
            if (law%only_largest) then
               if (rates(k) < maxval(rates, mask=cracks%tips%crack == tip%crack .and. .not. growing%has_stopped)) cycle
            end if
            if (law%direction == 'straight') then
               if (.not. rates(k) > 0) cycle     ! there is no load yet
            else if (values(k)%intensity(1) <= 0) then
               call growing%note_waiting(k, said)
               cycle
            end if
            call try_to_advance(k)
         end associate
      end do
      have_moved = any(growing%advance > 0)
   contains
      !> Advance a tip, unless it would come too near to something or be too long.
      subroutine try_to_advance(k)
         integer, intent(in) :: k
         real(dp), allocatable :: before(:, :)
         real(dp) :: angle, most
         associate (law => scene%growth(law_of(scene, cracks%tips(k))), tip => cracks%tips(k))
            if (law%max_length > 0 .and. cracks%crack(tip%crack)%length() + law%increment > law%max_length*(1 + 1e-9_dp)) then
               call growing%stop_tip(k, 'the crack has its max_length', said)
               return
            end if
            angle = kink_angle(trim(law%direction), values(k)%intensity)
            before = cracks%crack(tip%crack)%points
            call cracks%extend(k, law%increment, angle)
            call follow_in_scene(scene, cracks, tip%crack)
            if (scene%crack%present) then
               most = room_for(scene, tip%crack, tip%place)
            else
               most = path_radius(scene, tip%crack, tip%end)
            end if
            if (most < least_radius(scene)*(1 - 1e-9_dp)) then
               call growing%stop_tip(k, 'a step further '//why_no_room(scene, tip%place), said)
               call cracks%put_back(k, before)
               call follow_in_scene(scene, cracks, tip%crack)
               return
            end if
            tip%radii = fitting(tip%radii, least_radius(scene), most)
            growing%advance(k) = law%increment
         end associate
      end subroutine try_to_advance
   end subroutine advance_tips

   !> By local symmetry: turn the last increments of tips where K_II is left. `have_turned` tells whether any was.
   subroutine turn_tips(growing, scene, cracks, values, have_turned)
      type(growing_t), intent(in) :: growing
      type(scene_t), intent(inout) :: scene
      type(cracks_t), intent(inout) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      logical, intent(out) :: have_turned
      integer :: k
      have_turned = .false.
      do k = 1, size(values)
         if (.not. growing%grows(k) .or. .not. growing%advance(k) > 0) cycle
         if (scene%growth(law_of(scene, cracks%tips(k)))%direction /= 'local_symmetry') cycle
         associate (of => values(k)%intensity)
            if (.not. of(1) > 0 .or. abs(of(2)) <= straight*of(1)) cycle
            call cracks%turn(k, -of(2)/(steepness*of(1)))
            call follow_in_scene(scene, cracks, cracks%tips(k)%crack)
            have_turned = .true.
         end associate
      end do
   end subroutine turn_tips

   !> By what loads are to be multiplied so that the largest G of a tip that still grows, over its toughness, is 1; 1 where none has any.
   pure real(dp) function factor_to_toughness(growing, scene, cracks, values) result(factor)
      type(growing_t), intent(in) :: growing
      type(scene_t), intent(in) :: scene
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      real(dp) :: largest
      integer :: k
      largest = 0
      do k = 1, size(values)
         if (growing%is_growing(k)) largest = max(largest, best_rate(values(k), cracks%tips(k)) &
                                                        /scene%growth(law_of(scene, cracks%tips(k)))%toughness)
      end do
      factor = 1
      if (largest > 0) factor = 1/sqrt(largest)
   end function factor_to_toughness

   !> Note the energy of tips that have advanced at constant drive.
   subroutine note_grown(growing, m)
      type(growing_t), intent(inout) :: growing
      type(motion_t), intent(in) :: m
      growing%stored_grown = stored_energy(m)
   end subroutine note_grown

   !> Note by what the loads have changed since then by their own history: where all change alike, by the root of what is stored.
   subroutine note_drive(growing, m)
      type(growing_t), intent(inout) :: growing
      type(motion_t), intent(in) :: m
      growing%drive = 0                          ! where there was no load before, tips that advanced have freed nothing
      if (growing%stored_grown > 0) growing%drive = sqrt(stored_energy(m)/growing%stored_grown)
   end subroutine note_drive

   !> Before all that drives the material is multiplied by a factor: correct the work that it does in a load step. Tips have advanced at
   !> constant drive, and the loads follow, by their history and by the factor; what they do on the way is that of the mean of the
   !> forces at both ends of the step, as if all had gone on together. In a linear body the difference is the energy that the advance has
   !> freed, times by what the drive changes less 1.
   subroutine correct_work(growing, factor, m)
      type(growing_t), intent(in) :: growing
      real(dp), intent(in) :: factor
      type(motion_t), intent(inout) :: m
      m%external_work = m%external_work &
                        + (growing%drive*factor - 1)*((m%external_work - growing%work) - (stored_energy(m) - growing%stored))
   end subroutine correct_work

   !> Scale all loads and prescribed motions.
   pure subroutine scale_loads(growing, m)
      type(growing_t), intent(in) :: growing
      type(motion_t), intent(inout) :: m
      integer :: k
      do k = 1, size(m%loads)
         m%loads(k)%history%scale = growing%load_factor
      end do
      call m%constraints%scale_ways(growing%load_factor)
   end subroutine scale_loads

   !> Book what new faces have taken, the integral of G over their area by the mean of G before and after, and keep G for the next step.
   subroutine book_fracture(growing, scene, cracks, values, m)
      type(growing_t), intent(inout) :: growing
      type(scene_t), intent(in) :: scene
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(motion_t), intent(inout) :: m
      real(dp) :: rate, taken
      integer :: k
      do k = 1, size(values)
         rate = best_rate(values(k), cracks%tips(k))
         taken = part_of_crack(cracks%tips(k))*scene%run%thickness*growing%advance(k)*(growing%rate(k) + rate)/2
         m%fracture_energy = m%fracture_energy + taken
         if (m%audit) m%numerical_loss = m%numerical_loss - taken
         growing%rate(k) = rate
      end do
      growing%advance = 0
      growing%work = m%external_work
      growing%stored = stored_energy(m)
   end subroutine book_fracture
end module hampm_growth_at_rest
