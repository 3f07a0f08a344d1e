!> Criteria of crack branching: three conditions for possible branches of a running crack. Tips of this program do not branch.
!>
!> - Its speed over that of Rayleigh waves: experiments show branches from 0.4 to 0.7 on (docs/explanation/resistance.md).
!> - The angle of the largest hoop stress: it leaves 0 at about two thirds of that speed (Yoffe, Phil. Mag. 42 (1951) 739).
!> - The static energy release rate under the same loads, G/g(v), over twice the static toughness: from 1 on it is enough
!>   for two slow tips (Eshelby, Inelastic Behaviour of Solids (1970) 77; Freund, Dynamic Fracture Mechanics (1990), section 6.4).
module hampm_branching
   use hampm_kinds, only: dp
   use hampm_crack_groups, only: growth_t
   use hampm_crack_tip, only: crack_tip_t
   use hampm_history, only: history_t
   use hampm_material, only: material_t
   use hampm_moving_tip, only: rayleigh_speed, share_of_rest, hoop_angle
   use hampm_text, only: three_digits
   use hampm_toughness, only: advance_t
   implicit none
   private
   public :: branching_t, criteria_of, record_branching, why_it_may_branch

   real(dp), parameter :: degree = acos(-1.0_dp)/180

   !> The criteria.
   type :: branching_t
      real(dp) :: speed = 0                      !! over the Rayleigh wave speed [-]
      real(dp) :: angle = 0                      !! of the largest hoop stress [rad]
      real(dp) :: energy = 0                     !! G/g(v) over twice the static toughness; 0 for a given speed [-]
   end type branching_t

contains

   !> The criteria of a tip.
   pure function criteria_of(material, tip, growth, advance, rate) result(criteria)
      type(material_t), intent(in) :: material   !! at the tip
      type(crack_tip_t), intent(in) :: tip
      type(growth_t), intent(in) :: growth
      type(advance_t), intent(in) :: advance     !! of the tip
      real(dp), intent(in) :: rate               !! its energy release rate [J/m2]
      type(branching_t) :: criteria
      real(dp), parameter :: least = 0.1_dp      ! of G at rest that cells leave at the speed of Rayleigh waves, where g(v) is 0
      type(advance_t) :: standing
      criteria%speed = tip%speed/rayleigh_speed(material)
      criteria%angle = hoop_angle(material, tip%speed)
      if (growth%law%gives_speed()) return
      standing = advance
      standing%speed = 0
      criteria%energy = rate/(2*growth%toughness_at(standing)*max(share_of_rest(material, tip%speed), least))
   end function criteria_of

   !> Record the criteria of a tip.
   subroutine record_branching(criteria, of_toughness, history)
      type(branching_t), intent(in) :: criteria
      logical, intent(in) :: of_toughness        !! whether a toughness is known
      type(history_t), intent(inout) :: history
      call history%record('speed_ratio', '1', 'speed of the tip over that of Rayleigh waves', criteria%speed)
      call history%record('hoop_angle', 'deg', 'angle of the largest hoop stress at this speed, to either side', &
                          criteria%angle/degree)
      if (of_toughness) call history%record('branching_energy', '1', 'energy release rate of a tip at rest in its place over '// &
                                            'twice the toughness at rest', criteria%energy)
   end subroutine record_branching

   !> Why a tip may branch, by its energy or by the hoop stress around it; '' where it may not.
   pure function why_it_may_branch(criteria, by_energy) result(why)
      type(branching_t), intent(in) :: criteria
      logical, intent(in) :: by_energy
      character(:), allocatable :: why
      why = ''
      if (.not. criteria%speed > 0) return
      if (by_energy .and. criteria%energy >= 1) then
         why = 'has the energy to branch: a tip at rest in its place would have '//three_digits(2*criteria%energy)// &
               ' times the toughness'
      else if (.not. by_energy .and. criteria%angle > 0) then
         why = 'is fast enough to branch: the hoop stress is largest '//three_digits(criteria%angle/degree)// &
               ' degrees to either side'
      end if
      if (why /= '') why = why//', first at '//three_digits(criteria%speed)//' of the speed of Rayleigh waves'
   end function why_it_may_branch
end module hampm_branching
