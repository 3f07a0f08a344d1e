!> The rows of the tables of groups and keys (`hampm_key_table`).
module hampm_key_rows
   use hampm_kinds, only: dp, name_len
   implicit none
   private
   public :: group_t, key_t, list_len, max_values, type_real, type_integer, type_name, type_text, type_logical, is_required, &
             is_assumed, is_optional

   integer, parameter :: type_real = 1, type_integer = 2
   integer, parameter :: type_name = 3             !! text of at most `name_len` characters: a name or a choice
   integer, parameter :: type_text = 4             !! text of at most `path_len` characters
   integer, parameter :: type_logical = 5          !! .true. or .false., kept as the numbers 1 and 0

   integer, parameter :: is_required = 1           !! a model without the group is refused
   integer, parameter :: is_assumed = 2            !! a model without the group gets it with its defaults
   integer, parameter :: is_optional = 3           !! a model without the group does without it

   integer, parameter :: max_values = 10000        !! most values of any key
   integer, parameter :: list_len = 256            !! longest list of values or choices in this table

   !> A row of the table of groups.
   type :: group_t
      character(name_len) :: name
      logical :: repeats                           !! whether it may stand several times
      integer :: presence                          !! meaning of its absence: `is_required`, `is_assumed`, `is_optional`
      character(96) :: meaning
      logical :: is_apart = .false.                !! whether it belongs to other choices than the template's only
   end type group_t

   !> A row of the table of keys.
   type :: key_t
      character(name_len) :: name
      integer :: value_type
      character(120) :: meaning
      character(list_len) :: default = ''          !! value where it is not given, without quotes
      character(list_len) :: example = ''          !! value in the template if it is not the default
      character(16) :: unit = ''
      character(list_len) :: allowed = ''          !! numbers: an interval; text: choices separated by `|`, or a set of
                                                   !! `hampm_choice_sets` in braces; '' for any text
      integer :: fewest = 1, most = 1              !! number of values
      logical :: required = .false.                !! whether it must be given
      character(32) :: also = ''                   !! its common names, separated by `|`, for messages about names
      real(dp) :: lowest = -huge(1.0_dp), highest = huge(1.0_dp) !! ends of the interval
      logical :: above = .false., below = .false.  !! whether these are outside of it
   end type key_t
end module hampm_key_rows
