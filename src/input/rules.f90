!> Rows of the table of rules (`hampm_rule_table`): excluded, required and ineffective combinations of features and keys. Source of
!> validation, the warnings of `--check` and of runs, `--rules` and docs/reference/key_rules.md. Checks of places and of numbers
!> against each other stand elsewhere.
!>
!> A row is a condition, a verdict, another condition (both as in `hampm_conditions`), the kind of reason, the reason, and a
!> replacement. The message stands at the first key of the first condition. Conditions on the same group are about the same
!> instance; a condition on another group that may be repeated `requires` it of all instances, and otherwise any one meets it. Only
!> materials with a body, and bodies that are no holes, count.
module hampm_rules
   use hampm_kinds, only: dp
   implicit none
   private
   public :: atom_t, rule_t, not_with, requires, no_effect_with, no_effect_without, warned_with, noted_with, mechanics, not_built, &
             by_meaning, is_present, is_set, is_one_of, is_none_of, is_above, is_below, is_named

   integer, parameter :: not_with = 1            !! verdicts: the model is refused where both conditions hold,
   integer, parameter :: requires = 2            !! or where the first holds and the second does not;
   integer, parameter :: no_effect_with = 3      !! the user is warned where both hold, as the first does nothing there,
   integer, parameter :: no_effect_without = 4   !! or where the first holds and the second does not, for the same reason;
   integer, parameter :: warned_with = 5         !! the user is warned where both hold,
   integer, parameter :: noted_with = 6          !! or given a note

   integer, parameter :: mechanics = 1           !! kinds of reasons: no program could,
   integer, parameter :: not_built = 2           !! this one does not yet,
   integer, parameter :: by_meaning = 3          !! or it follows from the meaning of the keys

   integer, parameter :: is_present = 1, is_set = 2, is_one_of = 3, is_none_of = 4, is_above = 5, is_below = 6, is_named = 7

   !> A word of a condition.
   type :: atom_t
      integer :: alternative = 1                 !! number of its part between `or`; 0 in the first condition of a rule
      integer :: kind = 0                        !! kind of its test, one of the above
      integer :: group = 0                       !! row of the group, 0 for a feature
      integer :: key = 0                         !! position among the keys of the group, 0 for a group or a feature
      integer :: first = 1, last = 0             !! its values among the names in the table, of a text
      real(dp) :: number = 0                     !! its value, of a number, or of true (1) or false
      integer :: feature = 0
   end type atom_t

   !> A row of the table.
   type :: rule_t
      character(104) :: subject                  !! condition
      integer :: verdict
      character(112) :: other                    !! condition; '' for one that always holds
      integer :: basis                           !! kind of reason
      character(176) :: reason                   !! '' where the conditions say it
      character(80) :: use                       !! a condition, or words; '' for nothing
      integer :: behind                          !! number of words in the table before its own: those of the subject,
      integer :: of_subject, of_other, of_use    !! of the other condition, and of the replacement, as many as these
   end type rule_t
end module hampm_rules
