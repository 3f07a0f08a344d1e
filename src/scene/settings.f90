!> The groups and keys of a namelist as they were written: values as text, each with the place it comes from.
module hampm_settings
   use hampm_kinds, only: dp
   use hampm_keys, only: groups, find_group, find_key, key_count, max_values
   use hampm_mistakes, only: mistakes_t
   use hampm_text, only: printable
   implicit none
   private
   public :: value_t, setting_t, block_t, settings_t, new_block

   !> A value as it was written.
   type :: value_t
      character(:), allocatable :: text            !! without quotes
      logical :: quoted = .false.                  !! whether it stood in quotes
   end type value_t

   !> One key of one group.
   type :: setting_t
      logical :: given = .false.                   !! whether the user wrote it
      logical :: good = .true.                     !! whether no mistake was found in it
      character(:), allocatable :: place           !! 'case.nml:12' or '--set group.key=value'
      integer :: count = 0                         !! number of values, may exceed what `values` keeps
      type(value_t), allocatable :: values(:)
      real(dp), allocatable :: numbers(:)          !! the values of a number, once validated
   contains
      procedure :: append
      procedure :: shown
   end type setting_t

   !> One group of the file.
   type :: block_t
      integer :: group = 0                         !! its row in the table of groups
      character(:), allocatable :: place           !! where it begins
      type(setting_t), allocatable :: settings(:)  !! in the order of the table of keys
   end type block_t

   !> All groups of a file, in their order.
   type :: settings_t
      character(:), allocatable :: file            !! path of the namelist file
      integer :: count = 0
      type(block_t), allocatable :: blocks(:)      !! the first `count` are used
   contains
      procedure :: add_block
      procedure :: count_of
      procedure :: find
      procedure :: good
      procedure :: given
      procedure :: number
      procedure :: numbers
      procedure :: text
      procedure :: texts
      procedure :: set_numbers
      procedure :: set_text
      procedure :: complain
   end type settings_t

contains

   !> A group of which no key is set yet.
   pure function new_block(group, place) result(block)
      integer, intent(in) :: group
      character(*), intent(in) :: place
      type(block_t) :: block
      block%group = group
      block%place = place
      allocate (block%settings(key_count(group)))
   end function new_block

   !> Add a group behind the others. It is moved, not copied: its settings are gone from the argument.
   pure subroutine add_block(self, block)
      class(settings_t), intent(inout) :: self
      type(block_t), intent(inout) :: block
      type(block_t), allocatable :: more(:)
      integer :: i
      if (.not. allocated(self%blocks)) allocate (self%blocks(16))
      if (self%count == size(self%blocks)) then
         allocate (more(2*self%count))
         do i = 1, self%count
            call move_block(self%blocks(i), more(i))
         end do
         call move_alloc(more, self%blocks)
      end if
      self%count = self%count + 1
      call move_block(block, self%blocks(self%count))
   end subroutine add_block

   !> Move a group, which leaves nothing behind.
   pure subroutine move_block(from, to)
      type(block_t), intent(inout) :: from, to
      to%group = from%group
      call move_alloc(from%place, to%place)
      call move_alloc(from%settings, to%settings)
   end subroutine move_block

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
      integer :: row, i
      row = find_group(group)
      count_of = count([(self%blocks(i)%group == row, i=1, self%count)])
   end function count_of

   !> Position of the n-th group of this name, 0 where there are fewer.
   pure integer function find(self, group, instance)
      class(settings_t), intent(in) :: self
      character(*), intent(in) :: group
      integer, intent(in) :: instance
      integer :: row, seen
      row = find_group(group)
      seen = 0
      do find = 1, self%count
         if (self%blocks(find)%group == row) seen = seen + 1
         if (seen == instance) return
      end do
      find = 0
   end function find

   !> Whether a key has a value in which no mistake was found.
   pure logical function good(self, block, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block                 !! position of the group, 0 where it is absent
      character(*), intent(in) :: key
      good = .false.
      if (block > 0) good = self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%good
   end function good

   !> Whether the user wrote this key.
   pure logical function given(self, block, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key
      given = .false.
      if (block > 0) given = self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%given
   end function given

   !> The number that a validated key holds; 0 where it holds none.
   pure real(dp) function number(self, block, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key
      number = 0
      if (self%good(block, key)) number = self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%numbers(1)
   end function number

   !> The numbers that a validated key holds.
   pure function numbers(self, block, key) result(list)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key
      real(dp), allocatable :: list(:)
      if (self%good(block, key)) then
         list = self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%numbers
      else
         allocate (list(0))
      end if
   end function numbers

   !> The text that a validated key holds; '' where it holds none.
   pure function text(self, block, key)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key
      character(:), allocatable :: text
      text = ''
      if (self%good(block, key)) text = self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%values(1)%text
   end function text

   !> Whether a validated list of texts holds this one.
   pure logical function texts(self, block, key, wanted)
      class(settings_t), intent(in) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key, wanted
      integer :: i
      texts = .false.
      if (.not. self%good(block, key)) return
      associate (setting => self%blocks(block)%settings(find_key(self%blocks(block)%group, key)))
         do i = 1, setting%count
            texts = texts .or. setting%values(i)%text == wanted
         end do
      end associate
   end function texts

   !> Replace the numbers that a validated key holds.
   pure subroutine set_numbers(self, block, key, list)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key
      real(dp), intent(in) :: list(:)
      self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%numbers = list
   end subroutine set_numbers

   !> Replace the text that a validated key holds.
   pure subroutine set_text(self, block, key, text)
      class(settings_t), intent(inout) :: self
      integer, intent(in) :: block
      character(*), intent(in) :: key, text
      self%blocks(block)%settings(find_key(self%blocks(block)%group, key))%values(1)%text = text
   end subroutine set_text

   !> Note a mistake in a key: `place: &group key = value: message`.
   pure subroutine complain(self, mistakes, block, key, message)
      class(settings_t), intent(in) :: self
      type(mistakes_t), intent(inout) :: mistakes
      integer, intent(in) :: block
      character(*), intent(in) :: key
      character(*), intent(in) :: message
      character(:), allocatable :: place, note
      associate (group => self%blocks(block)%group)
         associate (setting => self%blocks(block)%settings(find_key(group, key)))
            place = self%blocks(block)%place
            if (allocated(setting%place)) place = setting%place
            note = ': '
            if (.not. setting%given) note = ' (default): '
            call mistakes%add(place//': &'//trim(groups(group)%name)//' '//key//' = '//setting%shown()//note//message)
         end associate
      end associate
   end subroutine complain
end module hampm_settings
