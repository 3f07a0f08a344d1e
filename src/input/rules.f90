!> Rows of the table of rules (`hampm_rule_table`): which features of a model do not go together, what needs what, and which keys do nothing
!> where. Validation, the warnings of `--check` and of runs, `--rules` and docs/reference/key_rules.md all come from the table. What stays
!> outside are checks of places and of numbers against each other.
!>
!> A row is a condition, a verdict, another condition (both as in `hampm_conditions`), the kind of reason, the reason, and what may be
!> used instead. The message stands at the first key of the first condition. Conditions on the same group are about the same one of
!> several; a condition on another group that may stand several times `requires` it of all of these, and is met by any of them else.
!> Only materials of which there is a body, and bodies that are no holes count.
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
   integer, parameter :: noted_with = 6          !! or told

   integer, parameter :: mechanics = 1           !! kinds of reasons: no program could,
   integer, parameter :: not_built = 2           !! this one does not yet,
   integer, parameter :: by_meaning = 3          !! or it follows from what the keys mean

   integer, parameter :: is_present = 1, is_set = 2, is_one_of = 3, is_none_of = 4, is_above = 5, is_below = 6, is_named = 7 !! words of conditions

   !> A word of a condition.
   type :: atom_t
      integer :: alternative = 1                 !! number of the part between `or` in which it is; 0 in the first condition of a rule
      integer :: kind = 0                        !! how it is told, one of the above
      integer :: group = 0                       !! row of the group, 0 for a feature
      integer :: key = 0                         !! position among the keys of the group, 0 for a group or a feature
      integer :: first = 1, last = 0             !! which of the names in the table are its values, of a text
      real(dp) :: number = 0                     !! its value, of a number or of what is true (1) or false
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
      integer :: behind                          !! its words stand in the table behind so many: those of the subject,
      integer :: of_subject, of_other, of_use    !! of the other condition, and of what may be used, as many as these
   end type rule_t
end module hampm_rules
