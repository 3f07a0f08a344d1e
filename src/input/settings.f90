!> The groups and keys of a namelist as written: values as text, each with its location in the input.
!>
!> Errors of the input are collected, so that all of them are reported at once.
module hampm_settings
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: max_values
   use hampm_law, only: constant_t, constant
   use hampm_text, only: printable, to_text
   use hampm_failure, only: failure_t, exit_input
   use hampm_json, only: message_record
   implicit none
   private
   public :: row_of, value_t, setting_t, group_entry_t, settings_t, input_errors_t

   integer, parameter :: most_shown = 50           !! a file that is no namelist would fill the screen

   !> The messages so far.
   type :: input_errors_t
      integer :: count = 0
      character(:), allocatable, private :: text   !! a line for each
      character(:), allocatable, private :: records !! items of an array of JSON
   contains
      procedure :: add
      procedure :: tell
   end type input_errors_t

   !> A value as it was written.
   type :: value_t
      character(:), allocatable :: text            !! without quotes
      logical :: quoted = .false.                  !! whether it stood in quotes
   contains
      procedure :: is_null
   end type value_t

   !> One key of one group.
   type :: setting_t
      logical :: given = .false.                   !! whether the user wrote it
      logical :: good = .true.                     !! whether no error was found in it
      character(:), allocatable :: location        !! 'case.nml:12' or '--set group.key=value'
      integer :: count = 0                         !! number of values, may exceed what `values` keeps
      type(value_t), allocatable :: values(:)
      real(dp), allocatable :: numbers(:)          !! the values of a number, once validated
   contains
      procedure :: append
      procedure :: shown
   end type setting_t

   !> One group as it stands in the file, or as it was added.
   type :: group_entry_t
      integer :: group = 0                         !! its row in the table of groups
      character(name_len) :: name = ''             !! of the group
      character(:), allocatable :: location        !! place of its beginning
      character(name_len), allocatable :: keys(:)  !! names of its keys, in the order of the table of keys
      type(setting_t), allocatable :: settings(:)  !! value of each key
   end type group_entry_t

   !> All groups: those of the file in their order, then added ones.
   type :: settings_t
      character(:), allocatable :: file            !! path of the namelist file
      integer :: count = 0
      type(group_entry_t), allocatable :: entries(:) !! the first `count` are used
      character(name_len), allocatable, private :: names(:) !! of these groups, each once
      integer, allocatable, private :: counts(:)   !! how many have it
      integer, allocatable, private :: positions(:, :) !! of these among the entries, (as many, names)
      type(input_errors_t) :: errors               !! found so far in them
   contains
      procedure :: add_entry
      procedure :: count_of
      procedure :: find
      procedure :: good
      procedure :: all_good
      procedure :: knows
      procedure :: given
      procedure :: number
      procedure :: numbers
      procedure :: constants
      procedure :: flag
      procedure :: vector
      procedure :: text
      procedure :: texts
      procedure :: set_numbers
      procedure :: set_text
      procedure :: title
      procedure :: complain
      procedure :: complain_in_words
      procedure :: location
      procedure :: shown => shown_values
      procedure :: records_of
   end type settings_t

contains

   !> Add a group behind the others. It is moved, not copied: its settings are gone from the argument.
   pure subroutine add_entry(self, entry)
      class(settings_t), intent(inout) :: self
      type(group_entry_t), intent(inout) :: entry
      type(group_entry_t), allocatable :: more(:)
      integer, allocatable :: positions(:, :)
      integer :: i, k
      if (.not. allocated(self%entries)) allocate (self%entries(16), self%names(0), self%counts(0), self%positions(0, 0))
      if (self%count == size(self%entries)) then
         allocate (more(2*self%count))
         do i = 1, self%count
            call move_entry(self%entries(i), more(i))
         end do
         call move_alloc(more, self%entries)
      end if
      self%count = self%count + 1
      if (.not. any(self%names == entry%name)) then
         self%names = [self%names, entry%name]
         self%counts = [self%counts, 0]
      end if
      if (any(shape(self%positions) /= [size(self%entries), size(self%names)])) then
         allocate (positions(size(self%entries), size(self%names)), source=0)
         positions(:size(self%positions, 1), :size(self%positions, 2)) = self%positions
         call move_alloc(positions, self%positions)
      end if
      k = findloc(self%names, entry%name, dim=1)
      self%counts(k) = self%counts(k) + 1
      self%positions(self%counts(k), k) = self%count
      call move_entry(entry, self%entries(self%count))
   end subroutine add_entry

   !> Move a group, which leaves nothing behind.
   pure subroutine move_entry(from, to)
      type(group_entry_t), intent(inout) :: from, to
      to%group = from%group
      to%name = from%name
      call move_alloc(from%location, to%location)
      call move_alloc(from%keys, to%keys)
      call move_alloc(from%settings, to%settings)
   end subroutine move_entry

   !> Add a value to a setting. No key takes more than `max_values`: further ones are only counted.
   pure subroutine append(self, text, quoted)
      class(setting_t), intent(inout) :: self
      character(*), intent(in) :: text
      logical, intent(in) :: quoted
      type(value_t), allocatable :: more(:)
      integer :: i
      if (.not. allocated(self%values)) allocate (self%values(2))
      if (self%count >= max_values) then
         self%count = max_values + 1
         return
      end if
      if (self%count == size(self%values)) then
         allocate (more(2*self%count))
         do i = 1, self%count
            call move_alloc(self%values(i)%text, more(i)%text)
            more(i)%quoted = self%values(i)%quoted
         end do
         call move_alloc(more, self%values)
      end if
      self%count = self%count + 1
      self%values(self%count)%text = text
      self%values(self%count)%quoted = quoted
   end subroutine append

   !> Whether nothing stood where a value could, as between two commas: it is unset.
   pure logical function is_null(self)
      class(value_t), intent(in) :: self
      is_null = .not. self%quoted .and. len(self%text) == 0
   end function is_null

   !> The values of a setting as a user would write them, cut where they are many.
   pure function shown(self) result(list)
      class(setting_t), intent(in) :: self
      character(:), allocatable :: list
      integer :: i
      list = ''
      if (.not. allocated(self%values)) return
      do i = 1, min(self%count, 8, size(self%values))
         if (i > 1) list = list//', '
         if (self%values(i)%quoted) then
            list = list//''''//printable(self%values(i)%text, 60)//''''
         else
            list = list//printable(self%values(i)%text, 60)
         end if
      end do
      if (self%count > 8) list = list//', ...'
   end function shown

   !> How many groups of this name there are.
   pure integer function count_of(self, group)
      class(settings_t), intent(in) :: self
      character(*), intent(in) :: group
      integer :: k
      count_of = 0
      if (.not. allocated(self%names)) return
      k = findloc(self%names, group, dim=1)
      if (k > 0) count_of = self%counts(k)
   end function count_of

   !> Position of the n-th group of this name, 0 where there are fewer.
   pure integer function find(self, group, instance)
      class(settings_t), intent(in) :: self
      character(*), intent(in) :: group
      integer, intent(in) :: instance
      integer :: k
      find = 0
      if (instance < 1 .or. instance > self%count_of(group)) return
      k = findloc(self%names, group, dim=1)
      find = self%positions(instance, k)
   end function find

   !> Position of a key among the keys of its group, 0 for an unknown name.
   pure integer function row_of(entry, key) result(row)
      type(group_entry_t), intent(in) :: entry
      character(*), intent(in) :: key
      row = findloc(entry%keys == key, .true., dim=1)
   end function row_of

   !> Whether a key has a value in which no error was found.
   pure logical function good(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry                 !! position of the group, 0 where it is absent, here and below
      character(*), intent(in) :: key
      good = .false.
      if (entry > 0) good = self%entries(entry)%settings(row_of(self%entries(entry), key))%good
   end function good

   !> Whether no error was found in any key of any group.
   pure logical function all_good(self)
      class(settings_t), intent(in) :: self
      integer :: i
      all_good = all([(all(self%entries(i)%settings%good), i=1, self%count)])
   end function all_good

   !> Whether no error was found in some keys of any group of a name.
   pure logical function knows(self, group, keys)
      class(settings_t), intent(in) :: self
      character(*), intent(in) :: group, keys(:)
      integer :: i, k
      knows = all([((self%good(self%find(group, i), trim(keys(k))), k=1, size(keys)), i=1, self%count_of(group))])
   end function knows

   !> Whether the user wrote this key.
   pure logical function given(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      given = .false.
      if (entry > 0) given = self%entries(entry)%settings(row_of(self%entries(entry), key))%given
   end function given

   !> The number that a validated key holds; 0 where it holds none.
   pure real(dp) function number(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      number = 0
      associate (list => self%numbers(entry, key))
         if (size(list) > 0) number = list(1)
      end associate
   end function number

   !> The numbers that a validated key holds.
   pure function numbers(self, entry, key) result(list)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      real(dp), allocatable :: list(:)
      if (self%good(entry, key)) then
         list = self%entries(entry)%settings(row_of(self%entries(entry), key))%numbers
      else
         allocate (list(0))
      end if
   end function numbers

   !> The numbers of keys, each by the name of its key.
   pure function constants(self, entry, keys)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: keys(:)
      type(constant_t) :: constants(size(keys))
      integer :: k
      constants = [(constant(keys(k), self%numbers(entry, keys(k))), k=1, size(keys))]
   end function constants

   !> Whether a validated key says .true.
   pure logical function flag(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      flag = self%number(entry, key) > 0
   end function flag

   !> The components of a vector that a validated key holds; 0 where it holds none.
   pure function vector(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      real(dp) :: vector(ndim)
      vector = 0
      if (self%good(entry, key)) vector = self%entries(entry)%settings(row_of(self%entries(entry), key))%numbers
   end function vector

   !> The text that a validated key holds, the first or the n-th; '' where it holds none.
   pure function text(self, entry, key, n)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      integer, intent(in), optional :: n
      character(:), allocatable :: text
      integer :: i
      i = 1
      if (present(n)) i = n
      text = ''
      if (.not. self%good(entry, key)) return
      associate (setting => self%entries(entry)%settings(row_of(self%entries(entry), key)))
         if (i <= setting%count) text = setting%values(i)%text
      end associate
   end function text

   !> Whether a validated list of texts holds this one.
   pure logical function texts(self, entry, key, wanted)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key, wanted
      integer :: i
      texts = .false.
      if (.not. self%good(entry, key)) return
      associate (setting => self%entries(entry)%settings(row_of(self%entries(entry), key)))
         do i = 1, setting%count
            texts = texts .or. setting%values(i)%text == wanted
         end do
      end associate
   end function texts

   !> Replace the numbers that a validated key holds.
   pure subroutine set_numbers(self, entry, key, list)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      real(dp), intent(in) :: list(:)
      self%entries(entry)%settings(row_of(self%entries(entry), key))%numbers = list
   end subroutine set_numbers

   !> Replace the text that a validated key holds.
   pure subroutine set_text(self, entry, key, text)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key, text
      self%entries(entry)%settings(row_of(self%entries(entry), key))%values(1)%text = text
   end subroutine set_text

   !> Title of a group in messages: its name, with its own name or number if there may be several: `crack 'b'`, `load(2)`.
   pure function title(self, entry) result(text)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry                 !! position of the group
      character(:), allocatable :: text, name
      integer :: i
      associate (group => self%entries(entry))
         text = trim(group%name)
         name = ''
         if (row_of(group, 'name') > 0) name = self%text(entry, 'name')
         if (name /= '') then
            text = text//' '''//printable(name, 60)//''''
         else if (self%count_of(text) > 1) then
            text = text//'('//to_text(count([(self%entries(i)%name == group%name, i=1, entry)]))//')'
         end if
      end associate
   end function title

   !> The values of a key as a user would write them; '' for no key.
   pure function shown_values(self, entry, key) result(list)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      character(:), allocatable :: list
      list = ''
      if (key /= '') list = self%entries(entry)%settings(row_of(self%entries(entry), key))%shown()
   end function shown_values

   !> Note an error in a key: `location: &group key = value: message`.
   pure subroutine complain(self, entry, key, message)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      character(*), intent(in) :: message
      character(:), allocatable :: note
      associate (group => self%entries(entry), setting => self%entries(entry)%settings(row_of(self%entries(entry), key)))
         note = ': '
         if (.not. setting%given) note = ' (default): '
         call self%errors%add(message, self%location(entry, key), trim(group%name), key, setting%shown(), &
                              '&'//trim(group%name)//' '//key//' = '//setting%shown()//note)
      end associate
   end subroutine complain

   !> Messages that begin with the title of a group, and perhaps one of its keys, as items of a JSON array with their locations.
   pure function records_of(self, lines) result(records)
      class(settings_t), intent(in) :: self
      character(*), intent(in) :: lines          !! one message a line, none at the end
      character(:), allocatable :: records, message, rest
      integer :: first, last, entry
      records = ''
      first = 1
      do while (first <= len(lines))
         last = first + index(lines(first:)//new_line('a'), new_line('a')) - 2
         message = lines(first:last)
         first = last + 2
         do entry = self%count, 1, -1
            if (index(message//' ', '&'//self%title(entry)//' ') == 1 .or. index(message, '&'//self%title(entry)//':') == 1) exit
         end do
         if (entry == 0) then
            records = records//message_record(message, '', '', '', '')
            cycle
         end if
         rest = message(len('& ') + len(self%title(entry)) + 1:)
         rest = rest(:scan(rest//' ', ' :') - 1)
         if (row_of(self%entries(entry), rest) == 0) rest = ''
         records = records//message_record(message, self%location(entry, rest), trim(self%entries(entry)%name), rest, &
                                           self%shown(entry, rest))
      end do
   end function records_of

   !> Note an error whose message is a whole sentence about a group and perhaps a key.
   pure subroutine complain_in_words(self, entry, key, message)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key, message
      call self%errors%add(message, self%location(entry, key), trim(self%entries(entry)%name), key, self%shown(entry, key), '')
   end subroutine complain_in_words

   !> Location of a key of a group or, if it is not set or has no name, of the group.
   pure function location(self, entry, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      character(:), allocatable :: location
      location = self%entries(entry)%location
      if (key == '') return
      associate (setting => self%entries(entry)%settings(row_of(self%entries(entry), key)))
         if (allocated(setting%location)) location = setting%location
      end associate
   end function location

   !> Record one error in one line: location, object, and correct values.
   pure subroutine add(self, reason, location, group, key, value, subject)
      class(input_errors_t), intent(inout) :: self
      character(*), intent(in) :: reason
      character(*), intent(in), optional :: location          !! 'case.nml:12', 'case.nml' or '--set group.key=value'
      character(*), intent(in), optional :: group, key, value !! that it is about
      character(*), intent(in), optional :: subject           !! words before the reason; '&group key: ' if absent
      character(:), allocatable :: message, record
      message = ''
      if (present(location)) message = location//': '
      if (present(subject)) then
         message = message//subject
      else if (present(key)) then
         message = message//'&'//group//' '//key//': '
      else if (present(group)) then
         message = message//'&'//group//': '
      end if
      message = message//reason
      record = message_record(reason, or_nothing(location), or_nothing(group), or_nothing(key), or_nothing(value))
      self%count = self%count + 1
      if (self%count == 1) then
         self%text = message
         self%records = record
      else
         if (self%count <= most_shown) self%text = self%text//new_line('a')//message
         self%records = self%records//record
      end if
   end subroutine add

   !> A text, '' where it is absent.
   pure function or_nothing(text)
      character(*), intent(in), optional :: text
      character(:), allocatable :: or_nothing
      or_nothing = ''
      if (present(text)) or_nothing = text
   end function or_nothing

   !> Report all errors, if there are any, as one failure.
   pure subroutine tell(self, failure)
      class(input_errors_t), intent(in) :: self
      type(failure_t), intent(inout) :: failure
      if (self%count == 0) return
      call failure%report(exit_input, self%text, self%records)
      if (self%count > most_shown) call failure%report(exit_input, &
         '... and '//to_text(self%count - most_shown)//' more', '')
   end subroutine tell
end module hampm_settings
