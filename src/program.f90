!> What the program does with its options.
module hampm_program
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use hampm_command_line, only: options_t, usage_text
   use hampm_failure, only: failure_t
   use hampm_namelist_text, only: template_text
   use hampm_reading, only: read_scene
   use hampm_scene, only: scene_t
   use hampm_simulation, only: simulation_t, build, run, summary, solver_report
   use hampm_text, only: to_text
   use hampm_version, only: version
   implicit none
   private
   public :: act, print_message

contains

   !> Do what the options ask for.
   subroutine act(options, failure)
      type(options_t), intent(in) :: options
      type(failure_t), intent(inout) :: failure
      if (options%help) then
         write (output_unit, '(a)', advance='no') usage_text()
      else if (options%version) then
         write (output_unit, '(a)') 'hampm '//version
      else if (options%template) then
         write (output_unit, '(a)', advance='no') template_text()
      else
         call simulate(options, failure)
      end if
   end subroutine act

   !> Read the scene, then check or run it.
   subroutine simulate(options, failure)
      type(options_t), intent(in) :: options
      type(failure_t), intent(inout) :: failure
      type(scene_t) :: scene
      type(simulation_t) :: simulation
      character(:), allocatable :: report
      call read_scene(options%input, options%overrides, scene, failure)
      if (failure%failed()) return
      call build(scene, options%threads, simulation, failure)
      if (failure%failed()) return
      if (options%check) then
         write (output_unit, '(a)', advance='no') scene%as_used//summary_as_comments(scene, simulation)
      else
         call run(simulation, options%output, options%quiet, failure)
         report = solver_report(simulation)
         if (.not. options%quiet .and. len(report) > 0) write (output_unit, '(a)') report
         if (allocated(simulation%warning)) call print_message('warning: '//simulation%warning)
         report = simulation%refinement%warning()
         if (len(report) > 0) call print_message('warning: '//report)
      end if
   end subroutine simulate

   !> The summary of a simulation as comments of a namelist file, so that what --check prints can be run.
   function summary_as_comments(scene, simulation) result(text)
      type(scene_t), intent(in) :: scene
      type(simulation_t), intent(in) :: simulation
      character(:), allocatable :: text
      text = with_prefix('! ', summary(simulation)//refinement_summary(scene))
   end function summary_as_comments

   !> How cells refine, and how deep; no line where they do not.
   pure function refinement_summary(scene) result(text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: text
      text = ''
      associate (refine => scene%refine)
         if (refine%indicator == 'none') return
         text = 'refinement      '//trim(refine%indicator)//', at most '//to_text(refine%max_level)//' levels, to cells of '// &
                to_text(scale(scene%grid%cell, -refine%max_level))//' m'//new_line('a')
      end associate
   end function refinement_summary

   !> Print every line of a message to the standard error, behind the name of the program.
   subroutine print_message(message)
      character(*), intent(in) :: message
      flush (output_unit)
      write (error_unit, '(a)', advance='no') with_prefix('hampm: ', message//new_line('a'))
      flush (error_unit)
   end subroutine print_message

   !> Put a prefix before every line of a text whose lines all end with a line feed.
   pure function with_prefix(prefix, text) result(prefixed)
      character(*), intent(in) :: prefix, text
      character(:), allocatable :: prefixed
      integer :: first, last
      prefixed = ''
      first = 1
      do while (first <= len(text))
         last = first + index(text(first:), new_line('a')) - 1
         prefixed = prefixed//prefix//text(first:last)
         first = last + 1
      end do
   end function with_prefix
end module hampm_program
