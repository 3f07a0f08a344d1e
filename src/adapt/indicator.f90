!> Interface of a refinement indicator: its name, its column of the history, and the procedure that marks leaves.
!>
!> A new indicator is a file with such a procedure and a row in the table of `hampm_indicators`: its choice in `&refine`, its
!> column, its value in checkpoints, and its rules follow from the row. Its own keys stand in src/input/schema/refine.toml.
module hampm_indicator
   use hampm_kinds, only: dp, ndim, long, name_len
   use hampm_cell_values, only: is_occupied
   use hampm_law, only: constant_t, value_of
   use hampm_problem, only: problem_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: indicator_t, indicator_row_t, refine_t, refinement_t, may_refine, is_in_box

   integer, parameter :: most_constants = 24     !! keys of indicators

   !> Description of an indicator.
   type :: indicator_t
      character(name_len) :: name = ''           !! in model files; '' for none
      character(name_len) :: column = ''         !! of the history, in which its value is; '' for none
      character(64) :: meaning = ''              !! of the column
      character(32) :: advice = ''               !! remedy for too many particles
      character(name_len) :: reach = ''          !! key of within how many cells of a tip it marks, of one that does
      logical :: is_of_places = .false.          !! whether it depends on places only, and marks before the first step
      logical :: is_of_one_body = .false.        !! whether all nodes of a cell count for one body
   end type indicator_t

   !> A row of the table.
   type, extends(indicator_t) :: indicator_row_t
      procedure(mark_leaves), pointer, nopass :: mark => null()
   end type indicator_row_t

   !> &refine: where cells refine. Components have the names of its keys, except keys of indicators.
   type :: refine_t
      character(name_len) :: indicator = ''      !! name of the indicator
      type(indicator_t) :: by                    !! the same; none where the group is absent
      type(constant_t) :: constants(most_constants) !! the numbers of the keys of indicators
      character(name_len) :: field = ''          !! of gradient: 'energy_density', 'stress_norm' or 'speed'
      integer :: max_level = 0                   !! level of the finest cells, 0: the root cells
      real(dp) :: region_lower(ndim) = -huge(1.0_dp)   !! box in which cells may refine [m]; -huge and huge where it has no
      real(dp) :: region_upper(ndim) = huge(1.0_dp)    !! limit: compare with them, their difference overflows
      real(dp) :: start = 0                      !! time of the first check of the motion [s]
      integer :: interval = 1                    !! steps between checks of the indicator
      integer :: max_particles = huge(1)         !! refinement ends where there would be more particles
   contains
      procedure :: is_active
      procedure :: looks_at_motion
   end type refine_t

   !> The same in a run, with the results of the last check.
   type, extends(refine_t) :: refinement_t
      logical :: is_static = .false.             !! whether each mesh takes a solution
      logical :: tips_move = .false.             !! whether tips move through the grid
      logical :: reached_max_level = .false.     !! whether a leaf would have been refined further
      logical :: reached_max_particles = .false. !! whether refinement has ended
      real(dp) :: value = 0                      !! of the indicator at the last check [-]
   contains
      procedure :: follows_motion
      procedure :: is_due
      procedure :: warning
   end type refinement_t

   abstract interface
      !> Mark leaves, and find the value of the column.
      subroutine mark_leaves(r, m, tips, change)
         import :: refinement_t, problem_t, dp
         type(refinement_t), intent(inout) :: r
         type(problem_t), intent(inout) :: m
         real(dp), intent(in) :: tips(:, :)      !! places of the crack tips [m], (ndim, number)
         integer, intent(inout) :: change(:)     !! by leaf: 1 where it is to be refined, -1 where it may be recombined; else 0
      end subroutine mark_leaves
   end interface

contains

   !> Whether cells refine at all.
   pure logical function is_active(self)
      class(refine_t), intent(in) :: self
      is_active = self%by%name /= '' .and. self%max_level > 0
   end function is_active

   !> Whether it depends on the motion.
   pure logical function looks_at_motion(self)
      class(refine_t), intent(in) :: self
      looks_at_motion = self%by%name /= '' .and. .not. self%by%is_of_places
   end function looks_at_motion

   !> Whether the mesh may change during the run: cells around a tip stay where the tip does.
   pure logical function follows_motion(self)
      class(refinement_t), intent(in) :: self
      follows_motion = self%is_active() .and. (self%looks_at_motion() .or. self%tips_move)
   end function follows_motion

   !> Whether a check is due after a step, or several at once.
   pure logical function is_due(self, time, before, steps)
      class(refinement_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      integer(long), intent(in) :: before        !! steps done before
      integer(long), intent(in) :: steps         !! and now
      is_due = self%follows_motion() .and. time >= self%start .and. steps/self%interval > before/self%interval
   end function is_due

   !> Whether a leaf may be refined; where only its level stands against it, that is noted.
   logical function may_refine(r, m, leaf) result(may)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(in) :: m
      integer, intent(in) :: leaf
      may = is_occupied(m%grid, m%blocks, leaf) .and. is_in_box(r, m, leaf)
      if (.not. may) return
      may = m%grid%forest%level_of(leaf) < r%max_level
      r%reached_max_level = r%reached_max_level .or. .not. may
   end function may_refine

   !> Whether the middle of a leaf is in the box.
   pure logical function is_in_box(r, m, leaf)
      type(refinement_t), intent(in) :: r
      type(problem_t), intent(in) :: m
      integer, intent(in) :: leaf
      associate (x => m%grid%forest%middle_of(leaf))
         is_in_box = all(x >= r%region_lower .and. x <= r%region_upper)
      end associate
   end function is_in_box

   !> Warnings at the end; '' if there are none.
   function warning(self, steps, refined) result(text)
      class(refinement_t), intent(in) :: self
      integer(long), intent(in) :: steps         !! that the run has taken, 0 where the model is only checked
      logical, intent(in) :: refined             !! whether there are cells that are refined
      character(:), allocatable :: text
      text = ''
      if (self%reached_max_particles) then
         text = 'refinement ended at &refine max_particles = '//to_text(self%max_particles)// &
                ': cells that would have been refined further were not. Give '//trim(self%by%advice)// &
                ' or a smaller max_level, or allow more'
      else if (self%reached_max_level) then
         text = 'refinement reached &refine max_level = '//to_text(self%max_level)// &
                ': cells that would have been refined further were not'
      else if (self%is_active() .and. self%looks_at_motion() .and. .not. self%is_static .and. &
               steps > 0 .and. steps < self%interval) then
         text = 'no cell has refined: &refine interval = '//to_text(self%interval)//' is more than the '//to_text(int(steps))// &
                ' steps of the run'
      else if (self%is_active() .and. self%by%reach /= '' .and. .not. refined) then
         text = 'no cell has refined: there is none within &refine '//trim(self%by%reach)//' = '// &
                to_text(nint(value_of(self%constants, self%by%reach, 0.0_dp)))// &
                ' cells of a crack tip in the box from region_lower to region_upper'
      end if
   end function warning
end module hampm_indicator
