!> Sparse Cholesky factorisation by CHOLMOD (Chen, Davis, Hager & Rajamanickam 2008), through its C interface for 32-bit indices:
!> order by approximate minimum degree, in solids by nested dissection where it has fewer entries; L L^T by dense blocks of columns
!> where these pay, else column by column. For many solutions `hampm_sparse_factor` solves.
module hampm_cholmod
   use, intrinsic :: iso_c_binding, only: c_int, c_double, c_size_t, c_ptr, c_funptr, c_null_ptr, c_associated, c_loc, c_f_pointer
   !$ use omp_lib, only: omp_get_max_active_levels, omp_set_max_active_levels
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t, exit_computation
   use hampm_sparse, only: sparse_t
   use hampm_sparse_factor, only: sparse_factor_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: cholmod_t

   integer(c_int), parameter :: solve_system = 0          ! CHOLMOD_A: A x = b
   integer(c_int), parameter :: no = 0, yes = 1
   integer(c_int), parameter :: upper = 1                 ! the triangle that is read
   integer(c_int), parameter :: integers = 0, reals = 1, doubles = 0 ! CHOLMOD_INT, CHOLMOD_REAL, CHOLMOD_DOUBLE
   integer(c_int), parameter :: given = 1        ! ordering given by the caller
   integer(c_int), parameter :: usual = merge(2, 0, ndim == 2) ! else AMD; in a solid METIS too, which in a plane costs more
                                                          ! than it saves

   !> The first members of CHOLMOD's settings, in its order, and room for the others, which are 2500 bytes.
   type, bind(c) :: settings_t
      real(c_double) :: dbound, grow0, grow1
      integer(c_size_t) :: grow2, maxrank
      real(c_double) :: supernodal_switch
      integer(c_int) :: supernodal, final_asis, final_super, final_ll, final_pack, final_monotonic, final_resymbol
      real(c_double) :: zrelax(3)
      integer(c_size_t) :: nrelax(3)
      integer(c_int) :: prefer_zomplex, prefer_upper, quick_return_if_not_posdef, prefer_binary
      integer(c_int) :: print, precise, try_catch
      type(c_funptr) :: error_handler
      integer(c_int) :: nmethods
      integer(c_size_t) :: others(2000)
   end type settings_t

   !> CHOLMOD's description of a sparse matrix, by columns.
   type, bind(c) :: columns_t
      integer(c_size_t) :: nrow, ncol, nzmax
      type(c_ptr) :: p, i, nz, x, z
      integer(c_int) :: stype, itype, xtype, dtype, sorted, packed
   end type columns_t

   !> Its description of a full matrix.
   type, bind(c) :: full_t
      integer(c_size_t) :: nrow, ncol, nzmax, d
      type(c_ptr) :: x, z
      integer(c_int) :: xtype, dtype
   end type full_t

   !> The first members of its description of a factor.
   type, bind(c) :: factor_t
      integer(c_size_t) :: n
      integer(c_size_t) :: minor                 !! columns before the first one that has failed
      type(c_ptr) :: order                       !! row of each column
   end type factor_t

   !> A factorised matrix. The analysis belongs to the pattern and is kept until that changes.
   type :: cholmod_t
      logical :: solves_often = .false.          !! whether many solutions are to follow
      type(sparse_factor_t), private :: often    !! the factor for these
      type(c_ptr), private :: factor = c_null_ptr
      type(c_ptr), private :: solution = c_null_ptr, work(2) = c_null_ptr
   contains
      procedure :: factorise
      procedure :: solve
      procedure :: release
   end type cholmod_t

   interface
      integer(c_int) function cholmod_start(settings) bind(c)
         import :: c_int, settings_t
         type(settings_t), intent(inout) :: settings
      end function cholmod_start

      type(c_ptr) function cholmod_analyze(a, settings) bind(c)
         import :: c_ptr, columns_t, settings_t
         type(columns_t), intent(in) :: a
         type(settings_t), intent(inout) :: settings
      end function cholmod_analyze

      integer(c_int) function cholmod_camd(a, f_set, f_size, group, order, settings) bind(c)
         import :: c_int, c_ptr, c_size_t, columns_t, settings_t
         type(columns_t), intent(in) :: a
         type(c_ptr), value :: f_set
         integer(c_size_t), value :: f_size
         integer(c_int), intent(in) :: group(*)
         integer(c_int), intent(out) :: order(*)
         type(settings_t), intent(inout) :: settings
      end function cholmod_camd

      type(c_ptr) function cholmod_analyze_p(a, order, f_set, f_size, settings) bind(c)
         import :: c_int, c_ptr, c_size_t, columns_t, settings_t
         type(columns_t), intent(in) :: a
         integer(c_int), intent(in) :: order(*)
         type(c_ptr), value :: f_set
         integer(c_size_t), value :: f_size
         type(settings_t), intent(inout) :: settings
      end function cholmod_analyze_p

      type(c_ptr) function cholmod_copy_factor(factor, settings) bind(c)
         import :: c_ptr, settings_t
         type(c_ptr), value :: factor
         type(settings_t), intent(inout) :: settings
      end function cholmod_copy_factor

      type(c_ptr) function cholmod_factor_to_sparse(factor, settings) bind(c)
         import :: c_ptr, settings_t
         type(c_ptr), value :: factor
         type(settings_t), intent(inout) :: settings
      end function cholmod_factor_to_sparse

      integer(c_int) function cholmod_factorize(a, factor, settings) bind(c)
         import :: c_int, c_ptr, columns_t, settings_t
         type(columns_t), intent(in) :: a
         type(c_ptr), value :: factor
         type(settings_t), intent(inout) :: settings
      end function cholmod_factorize

      integer(c_int) function cholmod_solve2(system, factor, b, b_set, x, x_set, y, e, settings) bind(c)
         import :: c_int, c_ptr, full_t, settings_t
         integer(c_int), value :: system
         type(c_ptr), value :: factor, b_set, x_set
         type(full_t), intent(in) :: b
         type(c_ptr), intent(inout) :: x, y, e
         type(settings_t), intent(inout) :: settings
      end function cholmod_solve2
   end interface

   abstract interface
      !> Release the memory of an object.
      integer(c_int) function free_object(object, settings) bind(c)
         import :: c_int, c_ptr, settings_t
         type(c_ptr), intent(inout) :: object
         type(settings_t), intent(inout) :: settings
      end function free_object
   end interface

   procedure(free_object), bind(c) :: cholmod_free_factor, cholmod_free_dense, cholmod_free_sparse

   type(settings_t), save :: settings
   logical, save :: is_started = .false., is_known = .false.

contains

   !> Whether the library has its settings where they are expected: their defaults are found there. Sets them at the first call.
   logical function is_ready()
      if (.not. is_started) then
         is_started = .true.
         is_known = cholmod_start(settings) == yes
         associate (s => settings)
            if (is_known) is_known = &
               s%supernodal == 1 .and. s%final_asis == yes .and. s%final_super == yes .and. s%final_ll == no .and. &
               s%final_pack == yes .and. all(s%nrelax == [4, 16, 48]) .and. s%prefer_upper == yes .and. s%print == 3 .and. &
               s%try_catch == no .and. .not. c_associated(s%error_handler) .and. s%nmethods == 0
            s%final_ll = yes
            s%quick_return_if_not_posdef = yes
            s%print = 0
            s%try_catch = yes                    ! says nothing of failures
            s%nmethods = usual
         end associate
      end if
      is_ready = is_known
   end function is_ready

   !> Factorise a matrix; its pattern is analysed at first, and after `release`. It is not `definite` where it has no factor. Fails
   !> where the memory does not suffice.
   subroutine factorise(self, matrix, definite, failure, last)
      class(cholmod_t), intent(inout) :: self
      type(sparse_t), intent(in), target :: matrix
      logical, intent(out) :: definite
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: last(:)   !! rows that are to be eliminated behind all others
      integer(c_int), allocatable, target :: column_start(:), row(:)
      logical, allocatable :: is_last(:)
      type(columns_t) :: a
      type(factor_t), pointer :: factor
      integer(c_int) :: status
      !$ integer :: levels
      definite = matrix%n == 0
      if (definite) return
      if (.not. is_ready()) then
         call failure%report(exit_computation, 'this version of CHOLMOD has its settings elsewhere than expected')
         return
      end if
      allocate (is_last(matrix%n), source=.false.)
      if (present(last)) is_last = last
      allocate (column_start, source=matrix%row_start - 1)   ! symmetric: its rows are its columns
      allocate (row, source=matrix%column - 1)
      a = columns_t(matrix%n, matrix%n, size(row), c_loc(column_start), c_loc(row), c_null_ptr, c_loc(matrix%value), c_null_ptr, &
                    upper, integers, reals, doubles, yes, yes)
      !$ levels = omp_get_max_active_levels()
      !$ call omp_set_max_active_levels(0)          ! else it starts threads of its own
      if (.not. c_associated(self%factor)) self%factor = analysis(a, is_last)
      status = no
      if (c_associated(self%factor)) status = cholmod_factorize(a, self%factor, settings)
      !$ call omp_set_max_active_levels(levels)
      if (status == yes) then
         call c_f_pointer(self%factor, factor)
         definite = factor%minor == factor%n
         if (definite .and. self%solves_often) call take_factor(self, is_last, status)
      end if
      if (status == no) call failure%report(exit_computation, 'CHOLMOD cannot factorise it: memory does not suffice for '// &
                                            to_text(matrix%n)//' rows')
   end subroutine factorise

   !> The order of elimination of a matrix, and the pattern of its factor; null where the memory does not suffice.
   function analysis(a, is_last) result(factor)
      type(columns_t), intent(in) :: a
      logical, intent(in) :: is_last(:)          !! rows that are to be eliminated behind all others
      type(c_ptr) :: factor
      integer(c_int) :: order(size(is_last))
      factor = c_null_ptr
      if (.not. any(is_last)) then
         factor = cholmod_analyze(a, settings)
      else if (cholmod_camd(a, c_null_ptr, 0_c_size_t, merge(1, 0, is_last), order, settings) == yes) then
         settings%nmethods = given
         factor = cholmod_analyze_p(a, order, c_null_ptr, 0_c_size_t, settings)
         settings%nmethods = usual
      end if
   end function analysis

   !> Take the factor over, for many solutions.
   subroutine take_factor(self, is_last, status)
      class(cholmod_t), intent(inout) :: self
      logical, intent(in) :: is_last(:)
      integer(c_int), intent(out) :: status
      type(c_ptr) :: copy, columns               ! of the factor, which gives its numbers away to its columns
      type(factor_t), pointer :: factor
      type(columns_t), pointer :: l
      integer(c_int), pointer :: order(:), first(:), row(:)
      real(c_double), pointer :: value(:)
      status = no
      copy = cholmod_copy_factor(self%factor, settings)
      if (.not. c_associated(copy)) return
      columns = cholmod_factor_to_sparse(copy, settings)
      status = cholmod_free_factor(copy, settings)
      if (.not. c_associated(columns)) status = no
      if (status == no) return
      call c_f_pointer(self%factor, factor)
      call c_f_pointer(columns, l)
      call c_f_pointer(factor%order, order, [l%ncol])
      call c_f_pointer(l%p, first, [l%ncol + 1])
      call c_f_pointer(l%i, row, [first(size(first))])
      call c_f_pointer(l%x, value, [first(size(first))])
      call self%often%take(order + 1, first + 1, row + 1, value, is_last)
      status = cholmod_free_sparse(columns, settings)
   end subroutine take_factor

   !> Solve with the factorised matrix, for one right-hand side or several, side by side at each row. Right-hand sides `without` the
   !> rows that are eliminated last (for many solutions only) leave these equations out: x is 0 there.
   subroutine solve(self, rhs, x, without)
      class(cholmod_t), intent(inout) :: self
      real(dp), intent(in), contiguous :: rhs(:)
      real(dp), intent(out), contiguous :: x(:)
      logical, intent(in), optional :: without(:) !! (right-hand sides)
      type(factor_t), pointer :: factor
      type(full_t), pointer :: solution
      real(c_double), pointer :: values(:, :)
      real(c_double), allocatable, target :: b(:, :)
      integer :: k
      if (self%solves_often) then
         if (present(without)) call self%often%solve(rhs, x, without)
         if (.not. present(without)) call self%often%solve(rhs, x)
         return
      end if
      x = 0                                      ! the caller checks the residual
      call c_f_pointer(self%factor, factor)
      associate (n => factor%n, width => size(rhs, kind=c_size_t)/factor%n)
         allocate (b(n, width))
         do k = 1, int(width)
            b(:, k) = rhs(k::width)
         end do
         if (cholmod_solve2(solve_system, self%factor, full_t(n, width, n*width, n, c_loc(b), c_null_ptr, reals, doubles), &
                            c_null_ptr, self%solution, c_null_ptr, self%work(1), self%work(2), settings) == no) return
         call c_f_pointer(self%solution, solution)
         call c_f_pointer(solution%x, values, [n, width])
         do k = 1, int(width)
            x(k::width) = values(:, k)
         end do
      end associate
   end subroutine solve

   !> Release the memory.
   subroutine release(self)
      class(cholmod_t), intent(inout) :: self
      integer :: k
      integer(c_int) :: status
      if (c_associated(self%factor)) status = cholmod_free_factor(self%factor, settings)
      if (c_associated(self%solution)) status = cholmod_free_dense(self%solution, settings)
      do k = 1, size(self%work)
         if (c_associated(self%work(k))) status = cholmod_free_dense(self%work(k), settings)
      end do
   end subroutine release
end module hampm_cholmod
