!> Change of momentum and internal force at points with the motion of the points around them: by the rows of a point in the
!> assembled mass and stiffness matrices of the cells with element operators (`hampm_element_operators`),
!>
!>    p_i <- p_i + sum_j M_ij a_j dt,     f_i <- f_i - sum_j K_ij v_j dt.
!>
!> Cells of the same size and material whose particles stand alike are of one class, with one element matrix. Points with cells of
!> the same classes and the same relative point numbers around them have the same rows: a stencil. Consecutive points with the same
!> stencil are a run, done with unit stride and without any look-up: inside bodies and at straight edges; elsewhere a run is one
!> point. Points that also have cells without operators keep the sums of the others in the contribution of one of these.
!>
!> The points of a stencil are taken in lines of three consecutive numbers, as in a row of the grid.
module hampm_stencils
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes, n_sums, of_mass, of_momentum, of_force
   use hampm_dofs, only: element_of_slot, corner_of_slot
   use hampm_element_kernels, only: n_masses, n_moments, add_mass_line, add_stiffness_line, mass_by_lines, &
                                    stiffness_by_lines
   use hampm_element_stiffness, only: element_stiffness
   use hampm_matter, only: matter_t
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: stencils_t, run_t, find_stencils, runs_of, find_next, apply_stencils

   integer, parameter :: stride = lanes*corners  !! among contributions from one sum to the next
   integer, parameter :: recent = merge(8, 128, ndim == 2) !! classes, or stencils, found last, that are searched
   integer, parameter :: longest = 128           !! points of a run
   real(dp), parameter :: rounding = 1.0e-12_dp  !! of integrals over the largest

   !> Points numbered on with one stencil.
   type :: run_t
      integer :: first = 0, n = 0
      integer :: stencil = 0
      integer :: home = 0                        !! of a single point: its contribution with the sums; 0: at the points
   end type run_t

   !> The stencils, line by line, and the stencil of each point.
   type :: stencils_t
      integer, allocatable :: first_line(:)      !! of each stencil, (stencils + 1)
      integer, allocatable :: middle(:)          !! of a line: its point minus the stencil's, ascending in a stencil; (lines)
      real(dp), allocatable :: mass(:, :)        !! M_ij of its points [kg], (-1:1, lines)
      real(dp), allocatable :: stiffness(:, :, :, :) !! minus K_ij [N/m], (ndim, ndim, -1:1, lines)
      integer, allocatable :: of_point(:)        !! 0 where no cell around has an operator, (n_points)
      integer, allocatable :: home(:)            !! see `run_t`, (n_points)
   end type stencils_t

   !> Common data of the cells of a class.
   type :: class_t
      integer :: material = 0
      real(dp) :: inverse_size = 0               !! [1/m]
      real(dp) :: integrals(n_masses + n_moments) = 0   !! M [kg], moments of the volume [m3]
      real(dp) :: margin(n_masses + n_moments) = 0      !! tolerance of these [kg], [m3]
      real(dp) :: mass(corners, corners) = 0     !! [kg]
      real(dp) :: stiffness(ndim*corners, ndim*corners) = 0  !! [N/m]
   end type class_t

   !> The cells around a point, by column: class, corner at which the point is, and their points minus it.
   type :: surroundings_t
      integer :: n = 0                           !! number of cells
      integer, allocatable :: cells(:, :)        !! (2 + corners, n and more)
   end type surroundings_t

contains

   !> Find the stencils of some points.
   pure subroutine find_stencils(m, points, material, integrals, s)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: points(:)
      integer, intent(in) :: material(:)         !! of blocks with operators, else 0
      real(dp), intent(in) :: integrals(:, :, :) !! of their cells, (lanes, n_masses + n_moments, blocks)
      type(stencils_t), intent(out) :: s
      type(class_t), allocatable :: classes(:)
      type(surroundings_t) :: around, known(0:recent - 1)
      integer, allocatable :: class_of(:), place(:) !! by element; 0 without operator
      integer :: k, n, j
      logical :: are_all
      call find_classes(m, material, integrals, class_of, place, classes)
      allocate (s%of_point(m%grid%n_points), s%home(m%grid%n_points), source=0)
      allocate (s%first_line(0:0), source=1)
      allocate (s%middle(0), s%mass(-1:1, 0), s%stiffness(ndim, ndim, -1:1, 0))
      allocate (around%cells(2 + corners, maxval(m%grid%dofs%first_slot(2:) - m%grid%dofs%first_slot(:m%grid%n_points))))
      n = 0
      j = 0
      do k = 1, size(points)
         call look_around(m, points(k), class_of, around, are_all)
         if (around%n == 0) cycle
         if (j == 0 .or. j <= n - recent .or. .not. are_same(known(mod(j, recent)), around)) then
            do j = n, max(0, n - recent) + 1, -1
               if (are_same(known(mod(j, recent)), around)) exit
            end do
         end if
         if (j == max(0, n - recent)) then
            n = n + 1
            j = n
            known(mod(n, recent)) = around
            call add_stencil(around%cells(:, :around%n), classes, n, s)
         end if
         s%of_point(points(k)) = j
         if (.not. are_all) s%home(points(k)) = place_of_first(m, points(k), place)
      end do
   end subroutine find_stencils

   !> Find the classes of the cells in blocks with operators, and where their contributions begin.
   pure subroutine find_classes(m, material, integrals, class_of, place, classes)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: material(:)
      real(dp), intent(in) :: integrals(:, :, :)
      integer, allocatable, intent(out) :: class_of(:), place(:)
      type(class_t), allocatable, intent(out) :: classes(:)
      type(class_t), allocatable :: more(:)
      integer :: b, l, j, n
      allocate (class_of(m%grid%n_elements), place(m%grid%n_elements), source=0)
      allocate (classes(recent))
      n = 0
      do b = 1, m%blocks%n
         if (material(b) == 0) cycle
         do l = 1, count(m%blocks%cells(:, b) > 0)
            associate (e => m%blocks%cells(l, b))
               place(e) = lanes*corners*n_sums*b + l
               do j = n, max(1, n - recent + 1), -1
                  if (is_of_class(classes(j), material(b), m%blocks%inverse_size(l, b), l, integrals(:, :, b))) exit
               end do
               if (j < max(1, n - recent + 1)) then
                  if (n == size(classes)) then
                     allocate (more(2*n))
                     more(:n) = classes
                     call move_alloc(more, classes)
                  end if
                  n = n + 1
                  j = n
                  classes(n)%material = material(b)
                  classes(n)%inverse_size = m%blocks%inverse_size(l, b)
                  classes(n)%integrals = integrals(l, :, b)
                  classes(n)%margin(:n_masses) = rounding*maxval(abs(integrals(l, :n_masses, b)))
                  classes(n)%margin(n_masses + 1:) = rounding*maxval(abs(integrals(l, n_masses + 1:, b)))
                  classes(n)%mass = symmetric(integrals(l, :n_masses, b))
                  call element_stiffness(m, [e], .true., 0.0_dp, classes(n)%stiffness)
               end if
               class_of(e) = j
            end associate
         end do
      end do
   end subroutine find_classes

   !> Whether a cell is of a class.
   pure logical function is_of_class(class, material, inverse_size, l, integrals) result(is)
      type(class_t), intent(in) :: class
      integer, intent(in) :: material
      real(dp), intent(in) :: inverse_size
      integer, intent(in) :: l                   !! lane of the cell
      real(dp), intent(in) :: integrals(lanes, n_masses + n_moments)
      integer :: k
      is = class%material == material .and. abs(class%inverse_size - inverse_size) <= rounding*inverse_size
      do k = 1, n_masses + n_moments
         if (.not. is) return
         is = abs(class%integrals(k) - integrals(l, k)) <= class%margin(k)
      end do
   end function is_of_class

   !> A symmetric matrix of the columns of its lower half.
   pure function symmetric(lower) result(matrix)
      real(dp), intent(in) :: lower(n_masses)
      real(dp) :: matrix(corners, corners)
      integer :: i, j, k
      k = 0
      do j = 1, corners
         do i = j, corners
            k = k + 1
            matrix(i, j) = lower(k)
            matrix(j, i) = lower(k)
         end do
      end do
   end function symmetric

   !> Find the cells with operators around a point, and whether all with particles have some.
   pure subroutine look_around(m, point, class_of, around, are_all)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: point
      integer, intent(in) :: class_of(:)
      type(surroundings_t), intent(inout) :: around
      logical, intent(out) :: are_all
      integer :: k, c, e
      around%n = 0
      are_all = m%grid%dofs%first_slot(point + 1) - m%grid%dofs%first_slot(point) <= corners
      do k = m%grid%dofs%first_slot(point), m%grid%dofs%first_slot(point + 1) - 1
         e = element_of_slot(m%grid%dofs%slot(k))
         if (class_of(e) > 0) then
            around%n = around%n + 1
            around%cells(1, around%n) = class_of(e)
            around%cells(2, around%n) = corner_of_slot(m%grid%dofs%slot(k))
            do c = 1, corners
               around%cells(2 + c, around%n) = m%grid%element_nodes(c, e) - point
            end do
         else if (m%blocks%count_in(e) > 0) then
            are_all = .false.
         end if
      end do
   end subroutine look_around

   !> Whether two points have the same around them.
   pure logical function are_same(a, b)
      type(surroundings_t), intent(in) :: a, b
      integer :: k, c
      are_same = a%n == b%n
      do k = 1, a%n
         do c = 1, 2 + corners
            if (.not. are_same) return
            are_same = a%cells(c, k) == b%cells(c, k)
         end do
      end do
   end function are_same

   !> Where the contribution of the first cell with an operator around a point to its mass stands.
   pure integer function place_of_first(m, point, place) result(first)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: point
      integer, intent(in) :: place(:)
      integer :: k
      associate (slots => m%grid%dofs%slot(m%grid%dofs%first_slot(point):m%grid%dofs%first_slot(point + 1) - 1))
         do k = 1, size(slots)
            first = place(element_of_slot(slots(k)))
            if (first == 0) cycle
            first = first + lanes*(corner_of_slot(slots(k)) - 1)
            return
         end do
      end associate
   end function place_of_first

   !> Add the n-th stencil: the rows of a point in the matrices of the cells around it. Its last line ends at the last of the points
   !> around: all points of the lines exist.
   pure subroutine add_stencil(cells, classes, n, s)
      integer, intent(in) :: cells(:, :)
      type(class_t), intent(in) :: classes(:)
      integer, intent(in) :: n
      type(stencils_t), intent(inout) :: s
      integer :: line, next, k, c
      line = s%first_line(n - 1) - 1
      next = minval(cells(3:, :))
      do while (next < huge(next))
         line = line + 1
         if (line > size(s%middle)) call make_room(n, 2*line + 8, s)
         s%middle(line) = min(next, maxval(cells(3:, :)) - 2) + 1
         s%mass(:, line) = 0
         s%stiffness(:, :, :, line) = 0
         next = minval(cells(3:, :), mask=cells(3:, :) > next + 2)
      end do
      if (n > ubound(s%first_line, 1)) call make_room(2*n + 8, size(s%middle), s)
      s%first_line(n) = line + 1
      do k = 1, size(cells, 2)
         associate (class => classes(cells(1, k)), corner => cells(2, k))
            do c = 1, corners
               line = s%first_line(n - 1)
               do while (cells(2 + c, k) > s%middle(line) + 1)
                  line = line + 1
               end do
               associate (at => cells(2 + c, k) - s%middle(line))
                  s%mass(at, line) = s%mass(at, line) + class%mass(corner, c)
                  s%stiffness(:, :, at, line) = s%stiffness(:, :, at, line) &
                                                - class%stiffness(ndim*corner - ndim + 1:ndim*corner, ndim*c - ndim + 1:ndim*c)
               end associate
            end do
         end associate
      end do
   end subroutine add_stencil

   !> Room for a number of stencils and of lines.
   pure subroutine make_room(n, lines, s)
      integer, intent(in) :: n, lines
      type(stencils_t), intent(inout) :: s
      type(stencils_t) :: old
      call move_alloc(s%first_line, old%first_line)
      call move_alloc(s%middle, old%middle)
      call move_alloc(s%mass, old%mass)
      call move_alloc(s%stiffness, old%stiffness)
      allocate (s%first_line(0:max(n, ubound(old%first_line, 1))), source=0)
      allocate (s%middle(lines), s%mass(-1:1, lines), s%stiffness(ndim, ndim, -1:1, lines))
      s%first_line(:ubound(old%first_line, 1)) = old%first_line
      s%middle(:size(old%middle)) = old%middle
      s%mass(:, :size(old%middle)) = old%mass
      s%stiffness(:, :, :, :size(old%middle)) = old%stiffness
   end subroutine make_room

   !> The runs of ascending points. A run is always done as a whole, so that no number depends on the order in which runs are done.
   pure function runs_of(s, points) result(runs)
      type(stencils_t), intent(in) :: s
      integer, intent(in) :: points(:)
      type(run_t), allocatable :: runs(:)
      integer :: k, n
      allocate (runs(size(points)))
      n = 0
      do k = 1, size(points)
         associate (i => points(k), before => runs(max(n, 1)))
            if (s%of_point(i) == 0) cycle
            if (before%first + before%n == i .and. before%stencil == s%of_point(i) .and. before%home + s%home(i) == 0 &
                .and. before%n < longest) then
               before%n = before%n + 1
            else
               n = n + 1
               runs(n) = run_t(i, 1, s%of_point(i), s%home(i))
            end if
         end associate
      end do
      runs = runs(:n)
   end function runs_of

   !> The next points that keep their sums and are numbered on, in the r-th and later ones of some runs.
   pure subroutine find_next(runs, r, first, n)
      type(run_t), intent(in) :: runs(:)
      integer, intent(inout) :: r                !! at the end, the run behind them
      integer, intent(out) :: first, n
      n = 0
      first = 0
      do r = r, size(runs)
         if (n > 0 .and. (runs(r)%home > 0 .or. runs(r)%first /= first + n)) return
         if (runs(r)%home > 0) cycle
         if (n == 0) first = runs(r)%first
         n = n + runs(r)%n
      end do
   end subroutine find_next

   !> Add the effect of a pass to the sums of the points of some runs.
   pure subroutine apply_stencils(s, runs, pass, dt, n_points, acceleration, velocity, momentum, force, contribution)
      type(stencils_t), intent(in) :: s
      type(run_t), intent(in) :: runs(:)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: n_points
      real(dp), intent(in) :: acceleration(ndim, n_points), velocity(ndim, n_points) !! at the points: that kicks, and that strains
      real(dp), intent(inout) :: momentum(ndim, n_points), force(ndim, n_points)     !! sums that points keep
      real(dp), intent(inout) :: contribution(*) !! of the cells, see `nodal_fields_t`
      integer :: d
      integer, parameter :: at_momentum(ndim) = stride*(of_momentum - of_mass + [(d, d=0, ndim - 1)]), &
                            at_force(ndim) = stride*(of_force - of_mass + [(d, d=0, ndim - 1)])
      integer :: r, k, i, from, n, lines
      real(dp) :: change(ndim), strain_dt
      strain_dt = pass%strain_fraction*dt
      do r = 1, size(runs)
         associate (run => runs(r), first => s%first_line(runs(r)%stencil - 1))
            lines = s%first_line(run%stencil) - first
            from = run%first
            n = 0
            if (run%n > 1) then                  ! from there on, lines have their neighbours contiguous in memory
               from = max(from, 3 - s%middle(first))
               n = max(0, min(run%first + run%n, n_points - s%middle(first + lines - 1) - 1) - from)
               do k = first, first + lines - 1
                  i = from + s%middle(k)
                  if (n == 0) exit
                  if (pass%kick) call add_mass_line(ndim*n, dt, s%mass(-1, k), acceleration(1, i - 1), momentum(1, from))
                  if (strain_dt > 0) call add_stiffness_line(n, strain_dt, s%stiffness(1, 1, -1, k), &
                                                             velocity(2, i - 2), force(1, from))
               end do
            end if
            if (n == run%n) cycle
            do i = run%first, run%first + run%n - 1
               if (i >= from .and. i < from + n) cycle
               if (pass%kick) then
                  change = dt*mass_by_lines(lines, s%middle(first), s%mass(-1, first), i, acceleration)
                  if (run%home == 0) momentum(:, i) = momentum(:, i) + change
                  if (run%home > 0) contribution(run%home + at_momentum) = contribution(run%home + at_momentum) + change
               end if
               if (strain_dt > 0) then
                  change = strain_dt*stiffness_by_lines(lines, s%middle(first), s%stiffness(1, 1, -1, first), i, velocity)
                  if (run%home == 0) force(:, i) = force(:, i) + change
                  if (run%home > 0) contribution(run%home + at_force) = contribution(run%home + at_force) + change
               end if
            end do
         end associate
      end do
   end subroutine apply_stencils
end module hampm_stencils
