!> Moving average of the energy release rate over the last cells of advance of a tip or a front, with its error. The values of a
!> tip that runs swing once a cell, and with waves that cells cannot carry, which a mean over whole cells removes.
module hampm_moving_average
   use hampm_archive, only: archive_t
   use hampm_history, only: history_t
   use hampm_kinds, only: dp
   use hampm_tolerance, only: bounded_ratio
   use hampm_vectors, only: fit_line
   implicit none
   private
   public :: moving_average_t, archive_average

   integer, parameter :: cells = 4               !! of advance over which the mean is taken
   integer, parameter :: parts = 4               !! samples in a cell: its swing, and the next two harmonics of it, cancel
   integer, parameter :: most = cells*parts + 2  !! samples that are kept
   integer, parameter :: values = 3              !! of a sample
   integer, parameter :: least = 6               !! samples that tell what single values swing by
   real(dp), parameter :: rounding = 1e-6_dp     !! of an advance, in parts of a cell

   !> Samples, of which each is the first one in a part of a cell; times, and rows of the history, do not matter.
   type :: moving_average_t
      integer :: n = 0
      real(dp) :: way(most) = 0                  !! advance since the start [m]
      real(dp) :: sample(values, most) = 0       !! G there, its error without waves that cells cannot carry, and by these [J/m2]
      real(dp) :: reached = 0                    !! advance of the last value [m]
      real(dp) :: mean = 0                       !! of G over the last cells before it, or as many as there are [J/m2]
      real(dp) :: error = 0                      !! estimated error of this [J/m2]
   contains
      procedure :: is_next
      procedure :: follow
      procedure :: swing
      procedure :: record
   end type moving_average_t

contains

   !> Whether a value at this advance is the next sample, the first of all included, and counts in a row before which the tip goes a
   !> way that is left.
   pure logical function is_next(self, way, cell, left)
      class(moving_average_t), intent(in) :: self
      real(dp), intent(in) :: way, cell, left    !! [m]
      is_next = self%n > 0 .and. way > self%reached .and. left <= cells*cell
      if (is_next .and. self%reached > self%way(1)) &
         is_next = aint(parts*way/cell + rounding) > aint(parts*self%way(self%n)/cell + rounding)
   end function is_next

   !> Take a value, and find the mean. Before any advance it is the value, and where a tip rests again it stays: what G is then
   !> belongs to no advance. Errors that last over a cell have one sign in all of it; waves of different cells are independent.
   pure subroutine follow(self, way, cell, value)
      class(moving_average_t), intent(inout) :: self
      real(dp), intent(in) :: way                !! since the start, which never decreases [m]
      real(dp), intent(in) :: cell               !! [m]
      real(dp), intent(in) :: value(values)      !! as a sample [J/m2]
      real(dp) :: mean(values)
      logical :: is_sample
      if (self%n == 0 .or. .not. way > 0) then
         self%n = 1
         self%way(1) = way
         self%sample(:, 1) = value
         self%mean = value(1)
         self%error = hypot(value(2), value(3))
         self%reached = way
      end if
      if (.not. way > self%reached) return
      is_sample = self%is_next(way, cell, 0.0_dp)
      if (.not. self%reached > self%way(1)) self%sample(:, 1) = value ! a start at a given speed lowers G at once
      self%reached = way
      associate (from => max(way - cells*cell, self%way(1)))
         mean = mean_from(self, from, way, value)
         self%mean = mean(1)
         self%error = hypot(mean(2), mean(3)/sqrt(max(1.0_dp, (way - from)/cell)))
      end associate
      if (.not. is_sample) return
      if (self%n == most) then
         self%way = eoshift(self%way, 1)
         self%sample = eoshift(self%sample, 1, dim=2)
         self%n = most - 1
      end if
      self%n = self%n + 1
      self%way(self%n) = way
      self%sample(:, self%n) = value
   end subroutine follow

   !> Mean of the samples and a last value, by lines between them [J/m2].
   pure function mean_from(self, from, way, value) result(mean)
      class(moving_average_t), intent(in) :: self
      real(dp), intent(in) :: from, way          !! advance at the start of the mean, and of the last value [m]
      real(dp), intent(in) :: value(values)
      real(dp) :: mean(values), x, y(values)     ! at the start of a line
      real(dp) :: ahead, there(values)           ! and at its end
      integer :: k
      mean = 0
      ahead = way
      there = value
      do k = self%n, 1, -1
         if (.not. ahead > from) exit
         x = max(self%way(k), from)
         y = there
         if (ahead > self%way(k)) y = there + (self%sample(:, k) - there)*(ahead - x)/(ahead - self%way(k))
         mean = mean + (ahead - x)/(way - from)*(y + there)/2
         ahead = x
         there = y
      end do
   end function mean_from

   !> What single values swing by about a line over the last cells of advance: twice their standard deviation, 0 of too few, over
   !> the mean [-].
   pure real(dp) function swing(self, cell)
      class(moving_average_t), intent(in) :: self
      real(dp), intent(in) :: cell               !! [m]
      real(dp) :: unused
      integer :: n
      swing = 0
      n = count(self%way(:self%n) > self%reached - cells*cell)
      if (n < least) return
      call fit_line(self%way(self%n - n + 1:self%n), self%sample(1, self%n - n + 1:self%n), unused, swing)
      swing = bounded_ratio(swing, self%mean, 1.0_dp)
   end function swing

   !> Record the mean and its error.
   subroutine record(self, history)
      class(moving_average_t), intent(in) :: self
      type(history_t), intent(inout) :: history
      call history%record('G_moving_average', 'J/m2', 'energy release rate, mean over the last four cells of advance', self%mean)
      call history%record('G_moving_average_error', 'J/m2', 'estimated error of that', self%error)
   end subroutine record

   !> Keep the samples.
   subroutine archive_average(average, name, archive)
      type(moving_average_t), intent(inout) :: average
      character(*), intent(in) :: name
      class(archive_t), intent(inout) :: archive
      call archive%serialise(name//'_samples', average%n)
      call archive%archive_reals(name//'_way', most, average%way)
      call archive%archive_reals(name//'_sample', values*most, average%sample)
      call archive%serialise(name//'_reached', average%reached)
      call archive%serialise(name//'_mean', average%mean)
      call archive%serialise(name//'_error', average%error)
   end subroutine archive_average
end module hampm_moving_average
