!> The history of a run as it is recorded: which columns it has, and the latest row of their values.
!>
!> A column is defined once in the code, by a call of `record` with its name, unit, meaning and value. The first pass through the
!> calls finds the columns, for any values; each pass fills a row. So all passes make the same calls in the same order.
module hampm_history
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: name_len, dp, long
   use hampm_text, only: to_text, length_text
   implicit none
   private
   public :: history_t, column_t

   !> A column.
   type :: column_t
      character(:), allocatable :: name
      character(:), allocatable :: unit          !! SI unit, '1' for a pure number
      character(:), allocatable :: meaning       !! label of the axis in a plot
      logical :: integer_valued = .false.
      integer :: first = 0                       !! where its values begin in a row
      integer :: n = 1                           !! how many they are: along a front as many as it has nodes
      logical :: is_along_front = .false.        !! whether it is one of those
   end type column_t

   !> The columns, and the row that is being filled.
   type :: history_t
      type(column_t), allocatable :: columns(:)  !! in the order of the calls; not allocated before the first pass
      real(dp), allocatable :: row(:)            !! latest value of each column
      character(name_len) :: of_tip = ''         !! end of the names of the next columns, as '_tip2'
      logical :: is_of_none = .false.            !! whether the next columns are of a tip that has reached the surface: NaN
      integer, private :: filled = 0             !! how many values the row has so far
      integer, private :: n_columns = 0, n_values = 0 !! found so far; there may be room for more in the first pass
   contains
      procedure :: begin_row
      procedure :: end_row
      procedure :: latest
      procedure :: record
      procedure :: record_modes
      procedure :: record_vector
      procedure :: record_radii
      procedure :: record_along_front
   end type history_t

contains

   !> Begin a pass.
   subroutine begin_row(self)
      class(history_t), intent(inout) :: self
      if (.not. allocated(self%columns)) allocate (self%columns(0), self%row(0))
      self%filled = 0
   end subroutine begin_row

   !> End a pass, which leaves as much room as there are columns.
   subroutine end_row(self)
      class(history_t), intent(inout) :: self
      if (size(self%columns) > self%n_columns) call reserve(self, self%n_columns)
      if (size(self%row) > self%n_values) self%row = self%row(:self%n_values)
   end subroutine end_row

   !> Room for so many columns; a copy of all texts for each new one would take the square of their number.
   subroutine reserve(self, room)
      type(history_t), intent(inout) :: self
      integer, intent(in) :: room
      type(column_t), allocatable :: columns(:)
      integer :: k
      allocate (columns(room))
      do k = 1, self%n_columns
         columns(k) = self%columns(k)
      end do
      call move_alloc(columns, self%columns)
   end subroutine reserve

   !> The latest value of a column; NaN if there is no column of this name.
   pure real(dp) function latest(self, name)
      class(history_t), intent(in) :: self
      character(*), intent(in) :: name
      integer :: k
      latest = ieee_value(0.0_dp, ieee_quiet_nan)
      if (.not. allocated(self%columns)) return
      do k = 1, self%n_columns
         if (self%columns(k)%name == name .and. .not. self%columns(k)%is_along_front) latest = self%row(self%columns(k)%first)
      end do
   end function latest

   !> A column of real numbers or of integers, of any kind.
   subroutine record(self, name, unit, meaning, value)
      class(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      class(*), intent(in) :: value
      real(dp) :: number
      logical :: integer_valued
      number = 0
      integer_valued = .true.
      select type (value)
       type is (real(dp))
         number = value
         integer_valued = .false.
       type is (integer)
         number = value
       type is (integer(long))
         number = real(value, dp)
      end select
      if (is_new(self)) call add_column(self, name, unit, meaning, integer_valued)
      call put(self, number)
   end subroutine record

   !> A column for each mode: `name`I, `name`II, each followed by `behind`.
   subroutine record_modes(self, name, unit, meaning, values, behind)
      class(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      real(dp), intent(in) :: values(:)          !! by mode
      character(*), intent(in), optional :: behind
      character(:), allocatable :: suffix
      integer :: mode
      suffix = ''
      if (present(behind)) suffix = behind
      do mode = 1, size(values)
         if (is_new(self)) call add_column(self, name//repeat('I', mode)//suffix, unit, meaning//', mode '//repeat('I', mode), &
                                           integer_valued=.false.)
         call put(self, values(mode))
      end do
   end subroutine record_modes

   !> A column for each direction: `name`_x, `name`_y.
   subroutine record_vector(self, name, unit, meaning, values)
      class(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      real(dp), intent(in) :: values(:)          !! by direction
      integer :: d
      do d = 1, size(values)
         call self%record(name//'_'//'xyz'(d:d), unit, meaning, values(d))
      end do
   end subroutine record_vector

   !> A column for each radius: `name`1, `name`2, ... Where radii may change from row to row the columns do not name them.
   subroutine record_radii(self, name, unit, meaning, radii, values, may_change)
      class(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      real(dp), intent(in) :: radii(:)           !! [m]
      real(dp), intent(in) :: values(:)          !! by radius
      logical, intent(in), optional :: may_change
      character(:), allocatable :: radius
      integer :: i
      radius = ''
      do i = 1, size(values)
         if (is_new(self)) then
            radius = ', radius '//length_text(radii(i))//' m'
            if (present(may_change)) then
               if (may_change) radius = ', radius '//to_text(i)//' of those that there is room for'
            end if
            call add_column(self, name//to_text(i), unit, meaning//radius, integer_valued=.false.)
         end if
         call put(self, values(i))
      end do
   end subroutine record_radii

   !> A column with a value of each node of a front, always as many.
   subroutine record_along_front(self, name, unit, meaning, values)
      class(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      real(dp), intent(in) :: values(:)          !! by node
      integer :: i
      if (is_new(self)) then
         call add_column(self, name, unit, meaning, integer_valued=.false.)
         self%columns(self%n_columns)%n = size(values)
         self%columns(self%n_columns)%is_along_front = .true.
         call add_values(self, size(values) - 1)
      end if
      do i = 1, size(values)
         call put(self, values(i))
      end do
   end subroutine record_along_front

   !> Whether the next value belongs to a new column. Names and meanings are composed only then: this takes longer than many a
   !> value.
   pure logical function is_new(self)
      type(history_t), intent(in) :: self
      is_new = self%filled == self%n_values
   end function is_new

   !> Add a column behind the others.
   subroutine add_column(self, name, unit, meaning, integer_valued)
      type(history_t), intent(inout) :: self
      character(*), intent(in) :: name, unit, meaning
      logical, intent(in) :: integer_valued
      if (self%n_columns == size(self%columns)) call reserve(self, 2*self%n_columns + 16)
      self%n_columns = self%n_columns + 1
      associate (column => self%columns(self%n_columns))
         column%name = trim(name)//trim(self%of_tip)
         column%unit = unit
         column%meaning = meaning
         column%integer_valued = integer_valued
         column%first = self%n_values + 1
      end associate
      call add_values(self, 1)
   end subroutine add_column

   !> Make the row longer.
   subroutine add_values(self, more)
      type(history_t), intent(inout) :: self
      integer, intent(in) :: more
      real(dp), allocatable :: row(:)
      if (self%n_values + more > size(self%row)) then
         allocate (row(2*(self%n_values + more) + 16), source=0.0_dp)
         row(:self%n_values) = self%row(:self%n_values)
         call move_alloc(row, self%row)
      end if
      self%n_values = self%n_values + more
   end subroutine add_values

   !> Put the next value into the row.
   pure subroutine put(self, value)
      type(history_t), intent(inout) :: self
      real(dp), intent(in) :: value
      self%filled = self%filled + 1
      self%row(self%filled) = value
      if (self%is_of_none) self%row(self%filled) = ieee_value(value, ieee_quiet_nan)
   end subroutine put
end module hampm_history
