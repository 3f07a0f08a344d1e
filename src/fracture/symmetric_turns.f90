!> Directions of the last increments of some tips without K_II, all together: Broyden's method, the secant rule for one tip.
!>
!> The mixity m = atan2(K_II, K_I) of each tip is brought to 0 by the angle a of each increment. With B, the map of a change of
!> mixities to one of angles,
!>
!>    a <- a - B m,    B <- B + (da - B dm) da^T B/(da^T B dm),
!>
!> and B begins with the slope of the series of a short kink (`hampm_kinks`). Trials start from the best. Broyden, Math. Comp. 19
!> (1965) 577.
module hampm_symmetric_turns
   use hampm_kinds, only: dp
   implicit none
   private
   public :: symmetric_turns_t, begin_turns, is_symmetric

   real(dp), parameter :: enough = 0.9e-3_dp     !! mixity that counts as none [rad]: K_II is below 0.1 % of K_I, also remeasured
   integer, parameter :: most_trials = 16
   real(dp), parameter :: most_turn = 0.35_dp    !! from the best trial to the next [rad]
   real(dp), parameter :: least_turn = 2e-4_dp   !! a smaller one changes a mixity by less than `enough`, except jumps [rad]

   !> The trials so far. Arrays have an entry for each tip that turns.
   type :: symmetric_turns_t
      integer, allocatable :: tip(:)             !! its number
      real(dp), allocatable :: angle(:)          !! of the present trial, to the left of where the increment was first [rad]
      real(dp), allocatable :: best(:)           !! of the best trial [rad]
      real(dp) :: least = huge(1.0_dp)           !! the largest mixity of that [rad]
      real(dp), allocatable :: mixity(:)         !! of the best trial [rad]
      real(dp), allocatable, private :: inverse(:, :) !! B
      integer, private :: trials = 0
   contains
      procedure :: note
      procedure :: have_found
      procedure :: has_found
      procedure :: choose
   end type symmetric_turns_t

contains

   !> Begin with tips as they have advanced.
   pure subroutine begin_turns(turns, tip, slope)
      type(symmetric_turns_t), intent(out) :: turns
      integer, intent(in) :: tip(:)              !! numbers of the tips
      real(dp), intent(in) :: slope(:)           !! change of the mixity of each with its angle, by a guess
      integer :: k
      turns%tip = tip
      allocate (turns%angle(size(tip)), turns%best(size(tip)), source=0.0_dp)
      allocate (turns%inverse(size(tip), size(tip)), source=0.0_dp)
      do k = 1, size(tip)
         turns%inverse(k, k) = 1/slope(k)
      end do
   end subroutine begin_turns

   !> Note the mixities of the present trial.
   pure subroutine note(self, mixity)
      class(symmetric_turns_t), intent(inout) :: self
      real(dp), intent(in) :: mixity(:)          !! [rad]
      real(dp) :: turn(size(mixity)), missed(size(mixity)), share
      if (self%trials > 0) then
         turn = self%angle - self%best
         missed = matmul(self%inverse, mixity - self%mixity)
         share = dot_product(turn, missed)
         if (abs(share) > epsilon(share)*dot_product(turn, turn)) self%inverse = self%inverse &
            + spread((turn - missed)/share, 2, size(turn))*spread(matmul(turn, self%inverse), 1, size(turn))
      end if
      self%trials = self%trials + 1
      if (maxval(abs(mixity)) >= self%least) return
      self%least = maxval(abs(mixity))
      self%best = self%angle
      self%mixity = mixity
   end subroutine note

   !> Whether the best trial has no K_II at any tip.
   pure logical function have_found(self)
      class(symmetric_turns_t), intent(in) :: self
      have_found = self%least <= enough .or. size(self%tip) == 0
   end function have_found

   !> Whether tips with such mixities have no K_II.
   pure logical function is_symmetric(mixity)
      real(dp), intent(in) :: mixity(:)          !! [rad]
      is_symmetric = all(abs(mixity) <= enough)
   end function is_symmetric

   !> Whether it has none at the k-th.
   pure logical function has_found(self, k)
      class(symmetric_turns_t), intent(in) :: self
      integer, intent(in) :: k
      has_found = abs(self%mixity(k)) <= enough
   end function has_found

   !> Choose the next trial, or return to the best one if no more are allowed (`are_over`). `turn`: angle by which each increment is
   !> to be turned to the left [rad].
   pure subroutine choose(self, turn, are_over)
      class(symmetric_turns_t), intent(inout) :: self
      real(dp), intent(out) :: turn(:)
      logical, intent(out) :: are_over
      real(dp) :: present(size(self%angle))
      present = self%angle
      turn = -matmul(self%inverse, self%mixity)
      turn = turn*min(1.0_dp, most_turn/maxval(abs(turn)))
      are_over = self%trials == most_trials .or. maxval(abs(turn)) < least_turn
      if (are_over) turn = 0
      self%angle = self%best + turn
      turn = self%angle - present
   end subroutine choose
end module hampm_symmetric_turns
