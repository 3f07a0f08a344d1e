!> Whether the faces of a crack have gone through each other. Without contact nothing keeps them from it, and what is measured at
!> the tip is then that of material that cannot be: K_I below zero.
module hampm_face_overlap
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   implicit none
   private
   public :: face_overlap_t, keep_overlap

   !> Overlap over the largest displacement of the faces against each other in the run, above which it is told [-]. While waves come
   !> and go it takes more: before a beam opens, the first bending waves press its arms together by a hundredth of that, or by a
   !> thirtieth of what they have opened by then. What
   !> is left at rest needs to be above what is not yet at rest only.
   real(dp), parameter :: noticed_in_motion = 0.1_dp, noticed_at_rest = 1e-3_dp

   !> The most that was seen, by the opening one cell behind the tip and at the mouth.
   type :: face_overlap_t
      real(dp) :: largest_jump = 0               !! largest opening, overlap or sliding [m]
      real(dp) :: overlap = 0                    !! largest overlap [m]
      real(dp) :: time = 0                       !! when that was [s]
      real(dp) :: last = 0                       !! overlap at the last look; below 0 where the faces have parted [m]
      real(dp) :: last_time = 0                  !! when that was [s]
   contains
      procedure :: look
      procedure :: is_notable
   end type face_overlap_t

contains

   !> Look at the openings and slidings of the faces at some places.
   pure subroutine look(self, jumps, time)
      class(face_overlap_t), intent(inout) :: self
      real(dp), intent(in) :: jumps(:, :)        !! opening, sliding [m], (modes, places)
      real(dp), intent(in) :: time               !! [s]
      self%largest_jump = max(self%largest_jump, maxval(abs(jumps)))
      self%last = maxval(-jumps(1, :))
      self%last_time = time
      if (self%last <= self%overlap) return
      self%overlap = self%last
      self%time = time
   end subroutine look

   !> Whether there was an overlap beyond rounding and passing waves.
   pure logical function is_notable(self, at_rest)
      class(face_overlap_t), intent(in) :: self
      logical, intent(in) :: at_rest             !! whether the motion has come to rest
      is_notable = self%overlap > noticed_in_motion*self%largest_jump
      if (at_rest) is_notable = is_notable .or. self%last > noticed_at_rest*self%largest_jump
   end function is_notable

   !> Keep it in a section of an archive.
   subroutine keep_overlap(overlap, archive)
      type(face_overlap_t), intent(inout) :: overlap
      class(archive_t), intent(inout) :: archive
      call archive%keep('largest_jump', overlap%largest_jump)
      call archive%keep('overlap', overlap%overlap)
      call archive%keep('time', overlap%time)
      call archive%keep('last', overlap%last)
      call archive%keep('last_time', overlap%last_time)
   end subroutine keep_overlap
end module hampm_face_overlap
