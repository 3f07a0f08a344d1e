!> The rows of the tables of groups and keys, and the words that stand in them.
module hampm_key_rows
   use hampm_kinds, only: ndim, name_len
   implicit none
   private
   public :: zeros, along_x, near_side, far_side, components, group_t, key_t, list_len, max_values, once, repeats, any_number, &
             positive, not_negative, type_real, type_integer, type_name, type_text, type_logical, is_required, is_assumed, &
             is_optional

   integer, parameter :: type_real = 1, type_integer = 2
   integer, parameter :: type_name = 3             !! text of at most `name_len` characters: a name or a choice
   integer, parameter :: type_text = 4             !! text of at most `path_len` characters
   integer, parameter :: type_logical = 5          !! .true. or .false., kept as the numbers 1 and 0

   integer, parameter :: is_required = 1           !! a model without the group is refused
   integer, parameter :: is_assumed = 2            !! a model without the group gets it with its defaults
   integer, parameter :: is_optional = 3           !! a model without the group does without it

   integer, parameter :: max_values = 1000         !! most values of any key
   integer, parameter :: list_len = 256            !! longest list of values or choices in this table
   logical, parameter :: repeats = .true., once = .false.

   character(*), parameter :: zeros = repeat('0.0, ', ndim - 1)//'0.0'     !! of a vector
   character(*), parameter :: along_x = '1.0'//repeat(', 0.0', ndim - 1)
   character(*), parameter :: near_side = repeat(', 0.0', ndim - 2), far_side = repeat(', 0.01', ndim - 2) !! z in the template
   character(*), parameter :: components = 'x|y|xy|z|xz|yz|xyz'            !! of a vector: the first three are those in the plane

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
      character(list_len) :: example = ''          !! value in the template where that is not the default
      character(16) :: unit = ''
      character(list_len) :: allowed = ''          !! numbers: an interval; text: choices separated by `|`, or a set of
                                                   !! `hampm_choice_sets` in braces; '' for any text
      integer :: fewest = 1, most = 1              !! number of values
      logical :: required = .false.                !! whether it must be given
      character(32) :: only_with = ''              !! condition on another key of its group that it requires; '' for none
   end type key_t

   character(*), parameter :: any_number = '(-inf, inf)', positive = '(0, inf)', not_negative = '[0, inf)'
end module hampm_key_rows
