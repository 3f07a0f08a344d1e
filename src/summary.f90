!> What a simulation is and what its solver took, in words for people.
module hampm_summary
   use hampm_kinds, only: long
   use hampm_cell_values, only: is_occupied
   use hampm_crack_placement, only: has_two_tips, domain_radii
   use hampm_placement, only: point_text, length_text, decimal
   use hampm_simulation, only: simulation_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: summary, solver_report

contains

   !> What the solution of the nodal equations took, for people; '' where the mass matrix is diagonal or not inverted.
   function solver_report(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      text = ''
      associate (solver => s%motion%solver)
         if (solver%solutions == 0) return
         text = 'mass matrix: '//to_text(solver%solutions)//' solutions, '//to_text(solver%iterations)//' iterations'
         if (solver%direct%factorisations == 0) return
         text = text//', '//to_text(solver%direct%analyses)//' analyses, '//to_text(solver%direct%factorisations)// &
                ' factorisations'
         if (solver%direct%bandwidth() > 0) text = text//', bandwidth '//to_text(solver%direct%bandwidth())
      end associate
   end function solver_report

   !> What a run of the scene would do, for people.
   function summary(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      integer :: leaf
      text = 'particles       '//to_text(s%motion%particles%n)//nl// &
             'cells           '//to_text(s%motion%grid%forest%leaf_count())//', of which occupied '// &
             to_text(count([(is_occupied(s%motion%grid, s%motion%blocks, leaf), &
                             leaf=1, s%motion%grid%forest%leaf_count())]))//nl// &
             'time step       '//to_text(s%longest_step)//' s at most'//nl// &
             'steps           '//to_text(ceiling(s%scene%run%end_time/s%longest_step, long))//' at least'//nl
      if (s%scene%crack%present) text = text//crack_summary(s)
      if (s%measurements%g_ref > 0) text = text//'G_ref           '//to_text(s%measurements%g_ref)//' J/m2'//nl
   end function summary

   !> Where the crack of a scene is, and where its energy release rate is looked for.
   function crack_summary(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      integer :: i
      associate (spec => s%scene%crack, cell => s%scene%grid%cell, radii => domain_radii(s%scene))
         text = 'crack           '//trim(spec%kind)//', tip '//point_text(spec%tip)
         if (has_two_tips(s%scene)) then
            text = text//', other tip '//point_text(decimal(spec%tip - spec%length*spec%direction, cell))//' m'//nl
         else
            text = text//', mouth '//point_text(decimal(s%crack%line%mouth, cell))//' m'//nl
         end if
         text = text//'cells at tip    '//to_text(s%crack%step)//' m'//nl
         if (.not. s%scene%energy_release%domain_integral) return
         text = text//'domain radii    '
         do i = 1, size(radii)
            text = text//length_text(radii(i))
            if (i < size(radii)) text = text//', '
         end do
         text = text//' m'//nl
      end associate
   end function crack_summary
end module hampm_summary
