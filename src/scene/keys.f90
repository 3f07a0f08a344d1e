!> Every group and key of the namelist file, in two tables. Validation, `--template`, the canonical text of a scene and
!> the reference documentation all come from them: a new key is one row here and one assignment in `hampm_reading`.
module hampm_keys
   use hampm_kinds, only: ndim, name_len
   use hampm_text, only: did_you_mean, printable
   implicit none
   private
   public :: group_t, key_t, groups, keys, find_group, find_key, first_key, key_count, choices, joined_choices, default_count, &
             default_value, unknown_group, unknown_key, is_text, max_values, most_radii, &
             type_real, type_integer, type_name, type_text, is_required, is_assumed, is_optional

   integer, parameter :: type_real = 1, type_integer = 2
   integer, parameter :: type_name = 3             !! text of at most `name_len` characters: a name or a choice
   integer, parameter :: type_text = 4             !! text of at most `path_len` characters

   integer, parameter :: is_required = 1           !! a scene without the group is refused
   integer, parameter :: is_assumed = 2            !! a scene without the group gets it with its defaults
   integer, parameter :: is_optional = 3           !! a scene without the group does without it

   integer, parameter :: max_values = 1000         !! most values of any key
   integer, parameter :: list_len = 256            !! longest list of values or choices in this table
   integer, parameter :: most_radii = 10           !! most radii of the domain integral
   logical, parameter :: must = .true., may = .false., repeats = .true., once = .false.

   !> A row of the table of groups.
   type :: group_t
      character(name_len) :: name
      logical :: repeats                           !! whether it may stand several times
      integer :: presence                          !! what its absence means: `is_required`, `is_assumed`, `is_optional`
      character(96) :: meaning
   end type group_t

   !> A row of the table of keys.
   type :: key_t
      character(name_len) :: group
      character(name_len) :: name
      integer :: value_type
      integer :: fewest, most                      !! number of values
      logical :: required                          !! whether it must be given
      character(list_len) :: default               !! value where it is not given, without quotes
      character(list_len) :: example               !! value in the template where that is not the default
      character(16) :: unit
      character(list_len) :: allowed               !! numbers: an interval; text: choices separated by `|`, '' for any text
      character(112) :: meaning
   end type key_t

   type(group_t), parameter :: groups(*) = [ &
      group_t('run', once, is_required, 'what is computed, and for how long'), &
      group_t('grid', once, is_required, 'the lattice of square root cells that the material moves through'), &
      group_t('material', repeats, is_required, 'a material; bodies name it'), &
      group_t('body', repeats, is_required, 'a piece of material; bodies must not overlap'), &
      group_t('constraint', repeats, is_optional, 'fixed displacement components of all grid nodes in a box'), &
      group_t('load', repeats, is_optional, 'a force on the material, with its history in time'), &
      group_t('damping', once, is_assumed, 'a force -rate m v on all material'), &
      group_t('method', once, is_assumed, 'how the equations of motion are integrated'), &
      group_t('refine', once, is_optional, 'where cells refine; without this group they never do'), &
      group_t('crack', once, is_optional, 'the crack; without this group the scene has none'), &
      group_t('energy_release', once, is_assumed, 'which energy quantities are recorded'), &
      group_t('output', once, is_assumed, 'what is written, and how often')]

   character(*), parameter :: any_number = '(-inf, inf)', positive = '(0, inf)', not_negative = '[0, inf)'

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: keys(*) = [ &
      key_t('run', 'title', type_text, 1, 1, may, '', 'DCB, suddenly loaded', '', &
            '', 'what the run is about; the result keeps it'), &
      key_t('run', 'plane', type_name, 1, 1, may, 'stress', '', '', &
            'stress|strain', 'plane stress or plane strain'), &
      key_t('run', 'thickness', type_real, 1, 1, may, '1.0', '0.01', 'm', &
            positive, 'thickness of the plane; forces and energies are those of all of it'), &
      key_t('run', 'end_time', type_real, 1, 1, must, '', '1.5e-3', 's', &
            positive, 'the run goes from time 0 to this time'), &
      key_t('grid', 'lower', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'lower corner of the lattice'), &
      key_t('grid', 'cell', type_real, 1, 1, must, '', '1.25e-3', 'm', &
            positive, 'size of a root cell, the same in both directions'), &
      key_t('grid', 'cells', type_integer, ndim, ndim, must, '', '80, 9', '', &
            '[1, inf)', 'number of root cells in each direction'), &
      key_t('material', 'name', type_name, 1, 1, must, '', 'aluminium', '', &
            '', 'name that bodies refer to'), &
      key_t('material', 'law', type_name, 1, 1, may, 'linear_elastic', '', '', &
            'linear_elastic|neo_hookean', 'for small strains and rotations, or for any'), &
      key_t('material', 'young', type_real, 1, 1, must, '', '70e9', 'Pa', &
            positive, 'Young''s modulus, at small strain'), &
      key_t('material', 'poisson', type_real, 1, 1, may, '0.0', '0.3', '', &
            '(-1, 0.5)', 'Poisson''s ratio, at small strain'), &
      key_t('material', 'density', type_real, 1, 1, must, '', '2700.0', 'kg/m3', &
            positive, 'mass per undeformed volume'), &
      key_t('body', 'material', type_name, 1, 1, must, '', 'aluminium', '', &
            '', 'name of its material'), &
      key_t('body', 'shape', type_name, 1, 1, may, 'rectangle', '', '', &
            'rectangle', 'a rectangle along the grid lines'), &
      key_t('body', 'lower', type_real, ndim, ndim, must, '', '0.0, 0.0', 'm', &
            any_number, 'its lower corner'), &
      key_t('body', 'upper', type_real, ndim, ndim, must, '', '0.1, 0.01', 'm', &
            any_number, 'its upper corner'), &
      key_t('body', 'points_per_cell', type_integer, 1, 1, may, '2', '', '', &
            '[1, 16]', 'material points per root cell in each direction; even where cells may refine'), &
      key_t('body', 'velocity', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm/s', &
            any_number, 'initial velocity of all of it'), &
      key_t('constraint', 'lower', type_real, ndim, ndim, must, '', '0.05, 0.0', 'm', &
            any_number, 'lower corner of the box whose nodes are held'), &
      key_t('constraint', 'upper', type_real, ndim, ndim, must, '', '0.1, 0.0', 'm', &
            any_number, 'upper corner of the box, may equal the lower one'), &
      key_t('constraint', 'fix', type_name, 1, 1, must, '', 'y', '', &
            'x|y|xy', 'components of the velocity that are zero there'), &
      key_t('load', 'kind', type_name, 1, 1, must, '', 'traction', '', &
            'point|traction|body', 'acts at a point, on part of a body''s edge, or on the material in a box'), &
      key_t('load', 'lower', type_real, ndim, ndim, must, '', '0.0, 0.0', 'm', &
            any_number, 'lower corner of where it acts'), &
      key_t('load', 'upper', type_real, ndim, ndim, must, '', '0.0, 0.01', 'm', &
            any_number, 'upper corner of where it acts, for a point equal to the lower one'), &
      key_t('load', 'force', type_real, ndim, ndim, must, '', '0.0, 1.0', 'N', &
            any_number, 'resultant of the whole load where its factor is 1'), &
      key_t('load', 'history', type_name, 1, 1, may, 'step', '', '', &
            'step|ramp|sine|table', &
            'factor over time: 1, rising to 1, sin(2 pi frequency t), or a table; t counts from start'), &
      key_t('load', 'start', type_real, 1, 1, may, '0.0', '', 's', &
            any_number, 'time at which the history begins; before it the factor is 0'), &
      key_t('load', 'rise_time', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'of a ramp: time in which the factor rises from 0 to 1; needed there'), &
      key_t('load', 'frequency', type_real, 1, 1, may, '0.0', '', 'Hz', &
            not_negative, 'of a sine: its frequency; needed there'), &
      key_t('load', 'times', type_real, 0, max_values, may, '', '', 's', &
            any_number, 'of a table: increasing, counted from start; linear between, constant outside'), &
      key_t('load', 'factors', type_real, 0, max_values, may, '', '', '', &
            any_number, 'of a table: factors at its times, as many as these'), &
      key_t('damping', 'rate', type_real, 1, 1, may, '0.0', '1.0e4', '1/s', &
            not_negative, 'damping force over mass times velocity'), &
      key_t('method', 'scheme', type_name, 1, 1, may, 'musl', '', '', &
            'usf|usl|usavg|musl', &
            'when a step updates the stress: first, last, half and half, or last by velocities mapped anew'), &
      key_t('method', 'courant', type_real, 1, 1, may, '0.0', '', '', &
            '[0, 10]', 'time step over cell size / wave speed; 0: 0.1, but 0.05 for full, partial in the updated frame'), &
      key_t('method', 'wave_speed', type_name, 1, 1, may, 'shear', '', '', &
            'shear|dilatational', 'which wave speed courant refers to'), &
      key_t('method', 'time_steps', type_name, 1, 1, may, 'global', '', '', &
            'global|local', 'one for all cells, that of the smallest, or longer ones for larger cells'), &
      key_t('method', 'frame', type_name, 1, 1, may, 'updated', '', '', &
            'updated|total', 'shape functions at the present or always at the initial positions'), &
      key_t('method', 'mass', type_name, 1, 1, may, 'lumped', '', '', &
            'lumped|full|partial|fmpm|blend', &
            'mass matrix: by row sums, consistent, so in some cells, a series for its inverse, or a mean of both'), &
      key_t('method', 'order', type_integer, 1, 1, may, '2', '', '', &
            '[1, 100]', 'of mass = ''fmpm'': number of terms of the series; 1 is lumped'), &
      key_t('method', 'blend', type_real, 1, 1, may, '0.5', '', '', &
            '[0, 1]', 'of mass = ''blend'': part that is lumped'), &
      key_t('method', 'full_region', type_name, 1, 1, may, 'box', '', '', &
            'box|refined', 'of mass = ''partial'': it is full in a box, or in the cells that are refined'), &
      key_t('method', 'full_lower', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'of full_region = ''box'': lower corner of the box in which mass = ''partial'' is full'), &
      key_t('method', 'full_upper', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'of full_region = ''box'': upper corner of this box; needed there'), &
      key_t('method', 'solver', type_name, 1, 1, may, 'cg', '', '', &
            'cg|umfpack|banded', &
            'of the equations with a full, partial or blended mass matrix: iterative, or a factorisation'), &
      key_t('refine', 'indicator', type_name, 1, 1, may, 'none', 'tip', '', &
            'none|gradient|zz|tip', 'what tells which cells refine: gradients, the estimated error, the distance to the tip'), &
      key_t('refine', 'field', type_name, 1, 1, may, 'energy_density', '', '', &
            'energy_density|stress_norm|speed', 'of indicator = ''gradient'': the field whose gradients count'), &
      key_t('refine', 'r_crit', type_real, 1, 1, may, '0.03', '', '', &
            positive, 'of ''gradient'': cells whose mean R is above it refine'), &
      key_t('refine', 'r_coarsen', type_real, 1, 1, may, '0.0', '', '', &
            not_negative, 'of ''gradient'': cells whose mean R is below it recombine; 0: never; below r_crit'), &
      key_t('refine', 'tolerance', type_real, 1, 1, may, '0.02', '', '', &
            '(0, 1)', 'of ''zz'': relative error in the energy norm that is aimed at'), &
      key_t('refine', 'rings', type_integer, 1, 1, may, '4', '', '', &
            '[1, 1000]', 'of ''tip'': cells within so many cells of a crack tip refine, level by level'), &
      key_t('refine', 'max_level', type_integer, 1, 1, may, '4', '2', '', &
            '[0, 20]', 'how often a root cell may be divided; its size is halved each time'), &
      key_t('refine', 'energy_floor', type_real, 1, 1, may, '1e-3', '', '', &
            '[0, 1)', 'of ''gradient'': cells whose field is below this part of its largest value do not refine'), &
      key_t('refine', 'region_lower', type_real, 0, ndim, may, '', '0.04, 0.0', 'm', &
            any_number, 'lower corner of the box in which cells may refine; without limit by default'), &
      key_t('refine', 'region_upper', type_real, 0, ndim, may, '', '0.06, 0.01', 'm', &
            any_number, 'upper corner of the box in which cells may refine; without limit by default'), &
      key_t('refine', 'start', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time of the first look at gradient or zz: loads that begin make steep fronts'), &
      key_t('refine', 'interval', type_integer, 1, 1, may, '100', '', '', &
            '[1, inf)', 'steps between looks at the indicator'), &
      key_t('refine', 'max_particles', type_integer, 1, 1, may, '1000000', '', '', &
            '[1, 2e9]', 'most material points; where there would be more, refinement ends with a warning'), &
      key_t('crack', 'kind', type_name, 1, 1, may, 'symmetry', '', '', &
            'symmetry|line', 'along the constrained edge of a symmetric half, or along a grid line inside the material'), &
      key_t('crack', 'tip', type_real, ndim, ndim, must, '', '0.05, 0.0', 'm', &
            any_number, 'crack tip, on a node of the lattice; of two tips the one that direction points out of'), &
      key_t('crack', 'direction', type_real, ndim, ndim, may, '1.0, 0.0', '', '', &
            any_number, 'direction of growth, along a grid line'), &
      key_t('crack', 'length', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'of a line with two tips: from one to the other; 0: it reaches the edge of the material'), &
      key_t('crack', 'contact', type_name, 1, 1, may, 'none', '', '', &
            'none|frictionless', 'of a line: whether its faces press on each other or go through'), &
      key_t('energy_release', 'estimators', type_name, 0, 4, may, '', &
            'nodal_force, stress_closure, domain_integral, energy_balance', '', &
            'nodal_force|stress_closure|domain_integral|energy_balance', 'what the history records of energy; none by default'), &
      key_t('energy_release', 'radii', type_real, 0, most_radii, may, '', '4.0e-3, 6.0e-3, 8.0e-3', 'm', &
            positive, 'of domain_integral: increasing; by default 0.4, 0.6 and 0.8 of what fits, of two cells or more'), &
      key_t('energy_release', 'reference', type_name, 1, 1, may, 'none', 'dcb', '', &
            'none|dcb|value', 'where the reference value G_ref comes from: nowhere, double cantilever beam theory, or a key'), &
      key_t('energy_release', 'reference_value', type_real, 1, 1, may, '0.0', '', 'J/m2', &
            not_negative, 'G_ref where reference = ''value''; needed there'), &
      key_t('output', 'file', type_text, 1, 1, may, '', 'dcb.h5', '', &
            '', 'result file in the output folder; by default named after the namelist file'), &
      key_t('output', 'history_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time between samples of the history; 0: a thousandth of end_time'), &
      key_t('output', 'snapshot_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time between snapshots of particles and mesh; 0: none'), &
      key_t('output', 'checkpoint_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'wall time between checkpoints, from which --resume goes on; 0: none'), &
      key_t('output', 'checkpoint_steps', type_integer, 1, 1, may, '0', '', '', &
            '[0, inf)', 'steps between checkpoints; 0: none')]

contains

   !> Row of a group in the table, 0 for an unknown name.
   pure integer function find_group(name)
      character(*), intent(in) :: name             !! in lower case
      do find_group = size(groups), 1, -1
         if (groups(find_group)%name == name) return
      end do
   end function find_group

   !> Position of a key among the keys of its group, 0 for an unknown name.
   pure integer function find_key(group, name)
      integer, intent(in) :: group                 !! row of the group
      character(*), intent(in) :: name             !! in lower case
      do find_key = key_count(group), 1, -1
         if (keys(first_key(group) + find_key - 1)%name == name) return
      end do
   end function find_key

   !> Row of the first key of a group; the keys of a group stand together.
   pure integer function first_key(group)
      integer, intent(in) :: group
      do first_key = 1, size(keys)
         if (keys(first_key)%group == groups(group)%name) return
      end do
   end function first_key

   !> Number of keys of a group.
   pure integer function key_count(group)
      integer, intent(in) :: group
      key_count = count(keys%group == groups(group)%name)
   end function key_count

   !> Whether the values of a key are text.
   pure logical function is_text(key)
      type(key_t), intent(in) :: key
      is_text = key%value_type == type_name .or. key%value_type == type_text
   end function is_text

   !> The texts that a key allows; none where it allows any text.
   pure subroutine choices(key, list)
      type(key_t), intent(in) :: key
      character(name_len), allocatable, intent(out) :: list(:)
      integer :: i
      allocate (list(part_count(key%allowed, '|')))
      do i = 1, size(list)
         list(i) = part(key%allowed, '|', i)
      end do
   end subroutine choices

   !> The texts that a key allows in one, each between quotes; '' where it allows any text.
   pure function joined_choices(key, quote, separator) result(text)
      type(key_t), intent(in) :: key
      character(*), intent(in) :: quote, separator
      character(:), allocatable :: text
      character(name_len), allocatable :: list(:)
      integer :: i
      call choices(key, list)
      text = ''
      do i = 1, size(list)
         if (i > 1) text = text//separator
         text = text//quote//trim(list(i))//quote
      end do
   end function joined_choices

   !> Number of values of a key that is not given, or of its values in the template.
   pure integer function default_count(key, as_example)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example            !! whether the template is meant
      default_count = 1
      if (key%most > 1) default_count = part_count(default_list(key, as_example), ',')
   end function default_count

   !> One of these values.
   pure function default_value(key, as_example, i) result(text)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      integer, intent(in) :: i
      character(:), allocatable :: text
      text = trim(default_list(key, as_example))
      if (key%most > 1) text = part(text, ',', i)
   end function default_value

   !> These values in one text.
   pure character(list_len) function default_list(key, as_example)
      type(key_t), intent(in) :: key
      logical, intent(in) :: as_example
      default_list = key%default
      if (as_example .and. key%example /= '') default_list = key%example
   end function default_list

   !> How many parts a text has between separators; an empty text has none.
   pure integer function part_count(text, separator)
      character(*), intent(in) :: text
      character, intent(in) :: separator
      integer :: i
      part_count = 0
      if (text /= '') part_count = count([(text(i:i) == separator, i=1, len(text))]) + 1
   end function part_count

   !> The n-th part of a text between separators, without the blanks around it.
   pure function part(text, separator, n)
      character(*), intent(in) :: text
      character, intent(in) :: separator
      integer, intent(in) :: n
      character(:), allocatable :: part
      integer :: i
      part = text//separator
      do i = 2, n
         part = part(index(part, separator) + 1:)
      end do
      part = trim(adjustl(part(:index(part, separator) - 1)))
   end function part

   !> Complaint about a group that does not exist.
   pure function unknown_group(name) result(message)
      character(*), intent(in) :: name
      character(:), allocatable :: message
      character(name_len) :: names(size(groups))
      names = groups%name
      message = 'there is no group &'//printable(name, 40)//did_you_mean(name, names)
      if (name == '') message = 'the name of a group is missing behind ''&'''
   end function unknown_group

   !> Complaint about a key that does not exist in a group; names the group that has one of this name.
   pure function unknown_key(group, name) result(message)
      integer, intent(in) :: group
      character(*), intent(in) :: name
      character(:), allocatable :: message, question
      character(name_len) :: names(key_count(group))
      integer :: first, i
      first = first_key(group)
      names = keys(first:first + size(names) - 1)%name
      question = did_you_mean(name, names)
      do i = size(keys), 1, -1
         if (keys(i)%name == name) question = '; '''//name//''' is a key of &'//trim(keys(i)%group)
      end do
      message = '&'//trim(groups(group)%name)//' has no key '''//printable(name, 40)//''''//question
   end function unknown_key
end module hampm_keys
