!> hampm, from the command line to the exit code.
program main
   use hampm_command_line, only: options_t, command_arguments, parse_arguments
   use hampm_failure, only: failure_t
   use hampm_program, only: act, end_program
   use hampm_resource_estimate, only: check_room
   use hampm_version, only: identify
   implicit none
   include 'version.inc'                         ! `built_version`, which the Makefile writes
   type(options_t) :: options
   type(failure_t) :: failure

   call identify(built_version)
   call parse_arguments(command_arguments(), options, failure)
   if (options%input//options%resume /= '') call check_room(failure) ! before memory is used
   if (.not. failure%failed()) call act(options, failure)
   call end_program(failure)
end program main
