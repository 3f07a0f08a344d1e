!> hampm, from the command line to the exit code.
program main
   use, intrinsic :: iso_c_binding, only: c_int
   use hampm_command_line, only: options_t, command_arguments, parse_arguments
   use hampm_failure, only: failure_t
   use hampm_program, only: act, print_message
   implicit none
   interface
      subroutine c_exit(code) bind(c, name='exit')
         import :: c_int
         integer(c_int), value :: code
      end subroutine c_exit
   end interface
   type(options_t) :: options
   type(failure_t) :: failure

   call parse_arguments(command_arguments(), options, failure)
   if (.not. failure%failed()) call act(options, failure)
   if (failure%failed()) call print_message(failure%message)
   call c_exit(int(failure%code, c_int))
end program main
