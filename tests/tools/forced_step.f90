!> The program with a time step that it would refuse: what is beyond the limit is to be seen, not only believed.
!>
!>    forced_step COURANT case.nml [options of hampm for a run]
!>
!> runs the model, which is to be stable as it stands, with this courant number instead.
program forced_step
   use hampm_command_line, only: options_t, command_arguments, parse_arguments
   use hampm_failure, only: failure_t
   use hampm_program, only: run_and_report, end_program
   use hampm_reading, only: read_model
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build
   use hampm_text, only: string_t
   implicit none
   type(string_t), allocatable :: words(:)
   type(options_t) :: options
   type(model_t) :: model
   type(simulation_t) :: simulation
   character(:), allocatable :: text
   type(failure_t) :: failure

   allocate (words, source=command_arguments())
   call parse_arguments(words(2:), options, failure)
   if (.not. failure%failed()) call read_model(options%input, options%overrides, model, failure, text=text)
   read (words(1)%text, *) model%method%courant
   if (.not. failure%failed()) call build(model, options%threads, simulation, failure)
   if (.not. failure%failed()) call run_and_report(options, simulation, failure)
   call end_program(failure)
end program forced_step
