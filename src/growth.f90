!> Cracks that grow at rest, by increments: in each load step tips advance, and all loads and prescribed motions are scaled so that the
!> largest energy release rate over its toughness is 1. What is left of the loads by themselves is how they are shared.
module hampm_growth
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_crack_measurements, only: crack_values_t, best_rate
   use hampm_crack_placement, only: least_radius
   use hampm_cracks, only: cracks_t
   use hampm_history, only: history_t
   use hampm_kinks, only: kink_angle
   use hampm_motion, only: motion_t, stored_energy
   use hampm_path_placement, only: path_radius
   use hampm_scene, only: scene_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: growing_t, new_growing, advance_tips, turn_tips, book_fracture, factor_to_toughness, correct_work, scale_loads, &
             record_growth, keep_growing

   real(dp), parameter :: straight = 1e-3_dp     !! K_II over K_I below which a tip that has advanced needs no other direction
   real(dp), parameter :: steepness = 0.6_dp     !! change of K_II over K_I with the angle of the last increment [1/rad]

   !> How the tips of a run grow.
   type :: growing_t
      integer, allocatable :: law(:)             !! number of the &growth of each tip, 0 where it stays
      logical, allocatable :: has_stopped(:)     !! whether a tip has, for good
      real(dp), allocatable :: advance(:)        !! by which each has advanced in the last load step [m]
      real(dp), allocatable :: rate(:)           !! energy release rate of each at the end of the step before [J/m2]
      real(dp) :: load_factor = 1                !! by which all loads and prescribed motions are scaled
      real(dp) :: work = 0                       !! of the loads and stored energy at the end of the step before [J]
      real(dp) :: stored = 0
   contains
      procedure :: are_there
      procedure :: is_growing
   end type growing_t

contains

   !> Whether any tip is to grow.
   pure logical function are_there(self)
      class(growing_t), intent(in) :: self
      are_there = .false.
      if (allocated(self%law)) are_there = any(self%law > 0)
   end function are_there

   !> Whether a tip still grows.
   pure logical function is_growing(self, tip)
      class(growing_t), intent(in) :: self
      integer, intent(in) :: tip
      is_growing = self%law(tip) > 0 .and. .not. self%has_stopped(tip)
   end function is_growing

   !> What is to grow in a scene.
   pure subroutine new_growing(scene, cracks, growing)
      type(scene_t), intent(in) :: scene
      type(cracks_t), intent(in) :: cracks
      type(growing_t), intent(out) :: growing
      integer :: k
      if (size(scene%growth) == 0) return
      associate (n => size(cracks%tips))
         allocate (growing%law(n), source=0)
         allocate (growing%has_stopped(n), source=.false.)
         allocate (growing%advance(n), growing%rate(n), source=0.0_dp)
         do k = 1, n
            growing%law(k) = findloc(scene%growth%path, cracks%tips(k)%crack, dim=1)
         end do
      end associate
   end subroutine new_growing

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
         associate (law => scene%growth(growing%law(k)), tip => cracks%tips(k))
            if (law%only_largest) then
               if (rates(k) < maxval(rates, mask=cracks%tips%crack == tip%crack .and. .not. growing%has_stopped)) cycle
            end if
            if (values(k)%intensity(1) <= 0 .and. law%direction /= 'straight') cycle ! nothing opens it
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
         associate (law => scene%growth(growing%law(k)), tip => cracks%tips(k))
            if (law%max_length > 0 .and. cracks%crack(tip%crack)%length() + law%increment > law%max_length*(1 + 1e-9_dp)) then
               call stop_tip(k, 'the crack has its max_length')
               return
            end if
            angle = kink_angle(trim(law%direction), values(k)%intensity)
            before = cracks%crack(tip%crack)%points
            call cracks%extend(k, law%increment, angle)
            scene%paths(tip%crack)%points = cracks%crack(tip%crack)%points
            most = path_radius(scene, tip%crack, tip%end)
            if (most < least_radius(scene)*(1 - 1e-9_dp)) then
               call cracks%put_back(k, before)
               scene%paths(tip%crack)%points = before
               call stop_tip(k, 'a step further there is no room for a radius of the domain integral of two of the finest '// &
                                'cells: a surface, a load, a constraint or another crack is near')
               return
            end if
            tip%radii = fitting(tip%radii, least_radius(scene), most)
            growing%advance(k) = law%increment
         end associate
      end subroutine try_to_advance

      !> Note that a tip stops.
      subroutine stop_tip(k, why)
         integer, intent(in) :: k
         character(*), intent(in) :: why
         growing%has_stopped(k) = .true.
         if (.not. allocated(said)) said = ''
         if (said /= '') said = said//new_line('a')
         said = said//'tip '//to_text(k)//' no longer grows: '//why
      end subroutine stop_tip
   end subroutine advance_tips

   !> As many radii as before, between the least and the largest that there may be [m].
   pure function fitting(radii, least, most)
      real(dp), intent(in) :: radii(:), least, most
      real(dp) :: fitting(size(radii))
      real(dp) :: first, last
      integer :: k
      fitting = radii
      if (all(radii <= most)) return
      last = max(0.8_dp*most, least)
      first = min(max(0.4_dp*most, least), last)
      fitting = [(first + (k - 1)*(last - first)/max(1, size(radii) - 1), k=1, size(radii))]
   end function fitting

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
         if (growing%law(k) == 0 .or. .not. growing%advance(k) > 0) cycle
         if (scene%growth(growing%law(k))%direction /= 'local_symmetry') cycle
         associate (of => values(k)%intensity)
            if (.not. of(1) > 0 .or. abs(of(2)) <= straight*of(1)) cycle
            call cracks%turn(k, -of(2)/(steepness*of(1)))
            scene%paths(cracks%tips(k)%crack)%points = cracks%crack(cracks%tips(k)%crack)%points
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
                                                        /scene%growth(growing%law(k))%toughness)
      end do
      factor = 1
      if (largest > 0) factor = 1/sqrt(largest)
   end function factor_to_toughness

   !> Before all that drives the material is multiplied by a factor: correct the work that it does in a load step. Tips have advanced at
   !> constant drive, and the loads follow; what they do on the way is that of the mean of the forces at both ends of the step, as if
   !> both had gone on together. In a linear body the difference is the energy that the advance has freed, times the factor less 1.
   subroutine correct_work(growing, factor, m)
      type(growing_t), intent(in) :: growing
      real(dp), intent(in) :: factor
      type(motion_t), intent(inout) :: m
      m%external_work = m%external_work &
                        + (factor - 1)*((m%external_work - growing%work) - (stored_energy(m) - growing%stored))
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
         taken = scene%run%thickness*growing%advance(k)*(growing%rate(k) + rate)/2
         m%fracture_energy = m%fracture_energy + taken
         if (m%audit) m%numerical_loss = m%numerical_loss - taken
         growing%rate(k) = rate
      end do
      growing%advance = 0
      growing%work = m%external_work
      growing%stored = stored_energy(m)
   end subroutine book_fracture

   !> Record how a tip stands.
   subroutine record_growth(growing, scene, cracks, tip, history)
      type(growing_t), intent(in) :: growing
      type(scene_t), intent(in) :: scene
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: tip
      type(history_t), intent(inout) :: history
      real(dp), parameter :: degree = acos(-1.0_dp)/180
      associate (of => cracks%tips(tip))
         call history%record('crack_length', 'm', 'length of the whole crack', cracks%crack(of%crack)%length())
         call history%record('tip_x', 'm', 'place of the tip', of%place(1))
         call history%record('tip_y', 'm', 'place of the tip', of%place(2))
         call history%record('tip_angle', 'deg', 'direction out of the crack, from x to the left', &
                             atan2(of%axis(2, 1), of%axis(1, 1))/degree)
         if (growing%law(tip) > 0) &
            call history%record('toughness', 'J/m2', 'energy release rate at which the crack grows', &
                                scene%growth(growing%law(tip))%toughness)
      end associate
   end subroutine record_growth

   !> Keep how tips have grown.
   subroutine keep_growing(growing, archive)
      type(growing_t), intent(inout) :: growing
      class(archive_t), intent(inout) :: archive
      if (.not. growing%are_there()) return
      call archive%section('growth')
      call archive%keep('load_factor', growing%load_factor)
      call archive%keep('work', growing%work)
      call archive%keep('stored', growing%stored)
      call archive%keep_logicals('has_stopped', size(growing%has_stopped), growing%has_stopped)
      call archive%keep_reals('rate', size(growing%rate), growing%rate)
   end subroutine keep_growing
end module hampm_growth
