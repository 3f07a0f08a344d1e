!> Reads many models and command lines in one process, for tests/fuzz:
!>
!>     fuzz_driver CASES ANSWERS
!>
!> CASES holds one case after the other, each an integer for its kind, an integer n and n texts. A text is an integer, its length,
!> and its bytes. For kind 1 the texts are those of a namelist file and of its overrides, for kind 2 the arguments of a command
!> line. ANSWERS gets the exit code, the processor time in milliseconds and a text for each case, at once, so that where a case ends
!> the process it is known which: all that `--check` says, the options as a list, or the message. Models of very many particles are
!> understood and weighed, but not built.
program fuzz_driver
   use, intrinsic :: iso_fortran_env, only: error_unit
   use hampm_command_line, only: options_t, parse_arguments
   use hampm_failure, only: failure_t
   use hampm_kinds, only: dp
   use hampm_resource_estimate, only: resources_t, estimate_resources, check_resources
   use hampm_program, only: check_report
   use hampm_reading, only: understand_model
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build, warnings
   use hampm_stiffness, only: stiffness_t
   use hampm_text, only: string_t, to_text
   implicit none
   integer, parameter :: is_scene = 1
   integer, parameter :: most_built = 20000        !! particles and cells
   character, parameter :: separator = achar(0)
   character(4096) :: path
   integer :: cases, answers, kind, n, i, status
   real(dp) :: began                               !! processor time at the beginning of a case [s]
   type(string_t), allocatable :: texts(:)

   call get_command_argument(1, path)
   open (newunit=cases, file=path, access='stream', form='unformatted', status='old', action='read')
   call get_command_argument(2, path)
   open (newunit=answers, file=path, access='stream', form='unformatted', status='replace', action='write')
   do
      read (cases, iostat=status) kind, n
      if (status /= 0) exit
      call cpu_time(began)
      if (allocated(texts)) deallocate (texts)
      allocate (texts(n))
      do i = 1, n
         call read_text(texts(i)%text)
      end do
      if (kind == is_scene) then
         call try_scene(texts(1)%text, texts(2:))
      else
         call try_arguments(texts)
      end if
   end do

contains

   subroutine read_text(text)
      character(:), allocatable, intent(out) :: text
      integer :: length
      read (cases) length
      allocate (character(length) :: text)
      if (length > 0) read (cases) text
   end subroutine read_text

   !> Understand a model; what is understood must read back as the same.
   subroutine try_scene(text, overrides)
      character(*), intent(in) :: text
      type(string_t), intent(in) :: overrides(:)
      character(*), parameter :: file = 'case.nml'
      type(model_t) :: model, again
      type(failure_t) :: failure, second
      type(string_t) :: none(0)
      character(:), allocatable :: report
      report = ''
      call understand_model(file, text, overrides, model, failure)
      if (.not. (failure%failed() .or. model%lacks_lattice)) then ! which &accuracy chooses: nothing is written before
         call understand_model(file, model%as_used, none, again, second)
         if (second%failed()) call stop_with('what was understood is refused: '//second%message, text)
         if (again%as_used /= model%as_used) call stop_with('what was understood reads as something else', text)
         report = model%as_used
         call try_to_build(model, report, failure)
      end if
      if (failure%failed()) then
         call answer(failure%code, failure%message)
      else
         call answer(0, report)
      end if
   end subroutine try_scene

   !> Do with a model what --check does.
   subroutine try_to_build(model, report, failure)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: report
      type(failure_t), intent(inout) :: failure
      type(simulation_t) :: simulation
      type(stiffness_t) :: rest
      type(resources_t) :: needs
      needs = estimate_resources(model)
      call check_resources(needs, failure)
      if (failure%failed() .or. needs%particles + needs%cells > most_built) return
      call build(model, 1, simulation, failure, rest)
      if (.not. failure%failed()) report = check_report(model, simulation, needs, rest)//warnings(simulation)
      call rest%release()
      call simulation%problem%solver%direct%release()
      call simulation%measurements%extrapolation%direct%release()
   end subroutine try_to_build

   subroutine stop_with(message, text)
      character(*), intent(in) :: message, text
      write (error_unit, '(a)') message, text
      error stop
   end subroutine stop_with

   subroutine try_arguments(arguments)
      type(string_t), intent(in) :: arguments(:)
      type(options_t) :: options
      type(failure_t) :: failure
      character(:), allocatable :: text
      character(16) :: bits
      integer :: k
      call parse_arguments(arguments, options, failure)
      if (failure%failed()) then
         call answer(failure%code, failure%message)
         return
      end if
      write (bits, '(z16.16)') transfer(options%time_limit, options%steps)
      text = options%input//separator//options%output//separator//to_text(options%threads)//separator// &
             options%resume//separator//to_text(options%steps)//separator//bits//separator//flag(options%force)// &
             flag(options%check)//flag(options%template)//flag(options%keys)//flag(options%quiet)//flag(options%version)// &
             flag(options%help)
      do k = 1, size(options%overrides)
         text = text//separator//options%overrides(k)%text
      end do
      call answer(0, text)
   end subroutine try_arguments

   pure character function flag(is_set)
      logical, intent(in) :: is_set
      flag = merge('1', '0', is_set)
   end function flag

   subroutine answer(code, text)
      integer, intent(in) :: code
      character(*), intent(in) :: text
      real(dp) :: now
      call cpu_time(now)
      write (answers) code, nint(1000*(now - began)), len(text), text
      flush (answers)
   end subroutine answer
end program fuzz_driver
