!> Whether the faces of a crack have gone through each other. Without contact nothing keeps them from it, and what is measured at
!> the tip is then that of material that cannot be: K_I below zero.
module hampm_face_overlap
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   use hampm_crack_tip_field, only: modes
   implicit none
   private
   public :: face_overlap_t, keep_overlap

   !> Overlap over the largest displacement of the faces against each other in the run, above which it is told [-]. Dispersion lets
   !> waves ripple before they arrive; what they part or press the faces by stays below a thousandth of what comes with the wave.
   real(dp), parameter :: noticed = 1e-3_dp

   !> The most that was seen, by the opening one cell behind the tip and at the mouth.
   type :: face_overlap_t
      real(dp) :: largest_jump = 0               !! largest opening, overlap or sliding [m]
      real(dp) :: overlap = 0                    !! largest overlap [m]
      real(dp) :: time = 0                       !! when that was [s]
      real(dp) :: last_time = 0                  !! when there was a notable one last [s]
   contains
      procedure :: look
      procedure :: is_notable
   end type face_overlap_t

contains

   !> Look at an opening and sliding of the faces.
   pure subroutine look(self, jump, time)
      class(face_overlap_t), intent(inout) :: self
      real(dp), intent(in) :: jump(modes)        !! opening, sliding [m]
      real(dp), intent(in) :: time               !! [s]
      self%largest_jump = max(self%largest_jump, maxval(abs(jump)))
      if (-jump(1) > noticed*self%largest_jump) self%last_time = time
      if (-jump(1) <= self%overlap) return
      self%overlap = -jump(1)
      self%time = time
   end subroutine look

   !> Whether there was an overlap beyond rounding and ripples.
   pure logical function is_notable(self)
      class(face_overlap_t), intent(in) :: self
      is_notable = self%overlap > noticed*self%largest_jump
   end function is_notable

   !> Keep it in an archive.
   subroutine keep_overlap(overlap, archive)
      type(face_overlap_t), intent(inout) :: overlap
      class(archive_t), intent(inout) :: archive
      call archive%section('face_overlap')
      call archive%keep('largest_jump', overlap%largest_jump)
      call archive%keep('overlap', overlap%overlap)
      call archive%keep('time', overlap%time)
      call archive%keep('last_time', overlap%last_time)
   end subroutine keep_overlap
end module hampm_face_overlap
