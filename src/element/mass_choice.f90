!> Which mass matrix a run uses: how much of each cell is lumped, and how the equations are solved.
module hampm_mass_choice
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_nodal_rows, only: pattern_of_grid
   use hampm_mass_solver, only: by_lumped, by_fmpm, by_cg, by_direct
   implicit none
   private
   public :: mass_choice_t, new_mass_choice, choose_cells

   !> Choice of a model: kind of the mass matrix, its parameters, and the solver.
   type :: mass_choice_t
      integer :: by = by_lumped                  !! way of solution
      integer :: order = 1                       !! of fmpm
      logical :: refined_only = .false.          !! whether a partial one is full in the refined cells, else in the box
      logical :: around_tips = .false.           !! whether it is in the cells around growing tips
      real(dp) :: lumped_inside = 0              !! lumped part of the cells within the box [-]
      real(dp) :: lumped_outside = 0             !! and of the others [-]
      real(dp) :: lower(ndim) = -huge(1.0_dp)    !! box of a partial mass matrix [m]
      real(dp) :: upper(ndim) = huge(1.0_dp)
   end type mass_choice_t

contains

   !> A mass matrix by name: 'lumped', 'consistent', 'partial' (consistent within the box, lumped elsewhere), 'fmpm' of an order,
   !> 'weighted' with a lumped part, or 'tip_weighted' with it around growing tips and lumped elsewhere.
   pure function new_mass_choice(mass, solver, order, lumped_fraction, lower, upper, refined_only) result(choice)
      character(*), intent(in) :: mass
      character(*), intent(in) :: solver         !! 'cg' or 'direct'
      integer, intent(in) :: order
      real(dp), intent(in) :: lumped_fraction, lower(ndim), upper(ndim)
      logical, intent(in), optional :: refined_only !! instead of the box
      type(mass_choice_t) :: choice
      choice%by = merge(by_cg, by_direct, solver == 'cg')
      select case (mass)
      case ('lumped', 'auto')                    ! 'auto' of models that no text has made
         choice%by = by_lumped
      case ('fmpm')
         choice%by = by_fmpm
         choice%order = order
      case ('weighted')
         choice%lumped_inside = lumped_fraction
         choice%lumped_outside = lumped_fraction
      case ('tip_weighted')
         choice%lumped_inside = lumped_fraction
         choice%lumped_outside = 1
         choice%around_tips = .true.
      case ('partial')
         choice%lumped_outside = 1
         choice%lower = lower
         choice%upper = upper
         if (present(refined_only)) choice%refined_only = refined_only
      end select
   end function new_mass_choice

   !> Room for the cell matrices of a choice, and how much of each cell is lumped. A cell is within the box where its middle
   !> is. Fails where the memory does not suffice.
   !>
   !> The weights of a hanging node of quadratic cells are not all positive. The contribution of two cells beside a coarser one to
   !> its nodes is positive if the same part of both is lumped: the larger one.
   subroutine choose_cells(choice, grid, near_tips, matrix, failure)
      type(mass_choice_t), intent(in) :: choice
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: near_tips(:)        !! whether elements are around growing tips, where the choice asks for that
      type(mass_matrix_t), intent(inout) :: matrix
      type(failure_t), intent(inout) :: failure
      integer :: status
      if (choice%by == by_lumped) return
      if (grid%is_quadratic()) matrix%quarters = corners
      call pattern_of_grid(grid, matrix%pattern, status)
      associate (f => grid%n_functions, width => matrix%pattern%width, m => grid%n_elements/matrix%quarters, n => grid%n_points)
         if (status == 0) allocate (matrix%cell(f, f, m), matrix%lumped_fraction(m), matrix%may_hang(m), matrix%cell_lumped(f, m), &
                                    matrix%row(width, n), stat=status)
         if (status == 0 .and. choice%by == by_cg) &
            allocate (matrix%cell_inverse(f, f, m), matrix%inverse_row(width, n), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of cells')
         return
      end if
      matrix%is_solved = choice%by /= by_fmpm
      call set_fractions(choice, grid, near_tips, matrix)
      if (grid%is_quadratic() .and. choice%lumped_inside < choice%lumped_outside) call agree_beside_coarser(grid, matrix)
   end subroutine choose_cells

   !> Which cells have nodes that may hang, and which part of each is lumped.
   subroutine set_fractions(choice, grid, near_tips, matrix)
      type(mass_choice_t), intent(in) :: choice
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: near_tips(:)
      type(mass_matrix_t), intent(inout) :: matrix
      real(dp) :: middle(ndim)
      integer :: e
      do e = 1, grid%n_elements, matrix%quarters
         associate (cell => matrix%cell_of(e))
            middle = grid%element_lower(:, e) + merge(1.0_dp, 0.5_dp, matrix%quarters > 1)*grid%element_size(e)
            matrix%may_hang(cell) = any(grid%support_of(e) > grid%n_nodes)
            matrix%lumped_fraction(cell) = choice%lumped_outside
            if (choice%around_tips) then
               if (near_tips(e)) matrix%lumped_fraction(cell) = choice%lumped_inside
            else if (choice%refined_only) then
               if (grid%forest%level_of(grid%element_leaf(e)) > 0) matrix%lumped_fraction(cell) = choice%lumped_inside
            else if (all(middle >= choice%lower .and. middle <= choice%upper)) then
               matrix%lumped_fraction(cell) = choice%lumped_inside
            end if
         end associate
      end do
   end subroutine set_fractions

   !> Lump the same part of two quadratic cells beside a coarser one: they share the middle of its side, a master of the hanging
   !> nodes of both.
   subroutine agree_beside_coarser(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      logical :: changed
      integer :: k, j, i
      changed = .true.
      do while (changed)
         changed = .false.
         do k = 1, grid%dofs%n_hanging
            associate (own => grid%dofs%elements_at(grid%n_nodes + k))
               do j = grid%dofs%first_master(k), grid%dofs%first_master(k + 1) - 1
                  associate (beside => grid%dofs%elements_at(grid%dofs%master(j)))
                     do i = 1, size(beside)
                        if (grid%element_size(beside(i)) > 1.5_dp*grid%element_size(own(1))) cycle
                        associate (one => matrix%lumped_fraction(matrix%cell_of(own(1))), &
                                   other => matrix%lumped_fraction(matrix%cell_of(beside(i))))
                           if (.not. abs(one - other) > 0) cycle
                           one = max(one, other)
                           other = one
                           changed = .true.
                        end associate
                     end do
                  end associate
               end do
            end associate
         end do
      end do
   end subroutine agree_beside_coarser
end module hampm_mass_choice
