!> The command line: `hampm [options] case.nml`.
module hampm_command_line
   use hampm_failure, only: failure_t
   use hampm_kinds, only: dp, long, name_len
   use hampm_settings, only: input_errors_t
   use hampm_text, only: line, string_t, did_you_mean, lower_case, printable
   use hampm_values, only: parse_real, is_number
   use hampm_version, only: program_name
   implicit none
   private
   public :: options_t, changes_model, command_arguments, parse_arguments, usage_text

   !> Options of the command line.
   type :: options_t
      character(:), allocatable :: input           !! path of the namelist file; '' where none is needed
      character(:), allocatable :: output          !! folder for results; '' where it is not given
      character(:), allocatable :: resume          !! path of the checkpoint to resume from; '' for a new run
      type(string_t), allocatable :: overrides(:)  !! `group.key=value`, in the order given
      integer :: threads = 0                       !! 0: chosen by the program
      integer(long) :: steps = 0                   !! after which the run stops with a checkpoint; 0: none
      real(dp) :: time_limit = 0                   !! wall time after which it does [s]; 0: none
      logical :: force = .false.                   !! replace an old result
      logical :: check = .false.                   !! validate and print the model, do not run it
      logical :: explain = .false.                 !! print the model with what is chosen, do not run it
      logical :: template = .false.                !! print a complete namelist
      logical :: keys = .false.                    !! print the reference of all keys
      logical :: rules = .false.                   !! print the rules between keys
      logical :: json = .false.                    !! print these for programs
      logical :: quiet = .false.                   !! no progress on the terminal, no wall times of steps
      logical :: version = .false.
      logical :: help = .false.
   end type options_t

   !> An option as `--help` shows it.
   type :: option_t
      character(name_len) :: name
      logical :: takes_value
      character(32) :: synopsis
      character(96) :: meaning
   end type option_t

   type(option_t), parameter :: known(*) = [ &
      option_t('--check', .false., '--check', 'validate the model and print it as understood, without a run'), &
      option_t('--explain', .false., '--explain', 'print the model with the keys that &accuracy chooses, without a run'), &
      option_t('--template', .false., '--template', 'print a complete namelist: every key, its default, unit and meaning'), &
      option_t('--keys', .false., '--keys', 'print the reference of all groups and keys as Markdown'), &
      option_t('--rules', .false., '--rules', 'print the rules between keys as Markdown'), &
      option_t('--json', .false., '--json', 'with --check, --keys or --rules: print JSON, for programs'), &
      option_t('--set', .true., '--set GROUP.KEY=VALUE', 'use this value instead of the file''s; may be given many times'), &
      option_t('--output', .true., '--output DIR', 'folder for the results; default: the current one'), &
      option_t('--force', .false., '--force', 'replace a result that is there'), &
      option_t('--resume', .true., '--resume CHECKPOINT', 'go on from a checkpoint; no namelist file is needed'), &
      option_t('--time-limit', .true., '--time-limit SECONDS', 'stop with a checkpoint after so much time'), &
      option_t('--steps', .true., '--steps N', 'stop with a checkpoint after N steps'), &
      option_t('--threads', .true., '--threads N', 'number of threads, 1 to 1024; 0 (default): chosen by the program'), &
      option_t('--quiet', .false., '--quiet', 'show no progress; with --check: try no steps, by which it tells the wall time'), &
      option_t('--version', .false., '--version', 'print the version'), &
      option_t('--help', .false., '--help', 'print this')]

   integer, parameter :: most_threads = 1024

   ! Keys of a resumed run that may be changed: those of checkpoints and of its end
   character(*), parameter :: of_checkpoints(*) = [character(26) :: 'output.checkpoint_interval', 'output.checkpoint_steps']
   character(*), parameter :: of_end(*) = [character(26) :: 'run.end_time', 'method.load_steps', 'run.stop_']

contains

   !> The arguments of the program.
   function command_arguments() result(arguments)
      type(string_t), allocatable :: arguments(:)
      integer :: i, length
      allocate (arguments(command_argument_count()))
      do i = 1, size(arguments)
         call get_command_argument(i, length=length)
         allocate (character(length) :: arguments(i)%text)
         if (length > 0) call get_command_argument(i, arguments(i)%text)
      end do
   end function command_arguments

   !> Understand the arguments. Every error in them is reported. `--name value` and `--name=value` are the same;
   !> behind `--` no argument is an option.
   pure subroutine parse_arguments(arguments, options, failure)
      type(string_t), intent(in) :: arguments(:)
      type(options_t), intent(out) :: options
      type(failure_t), intent(inout) :: failure
      type(input_errors_t) :: errors
      logical :: options_over
      integer :: i
      options%output = ''
      options%resume = ''
      options%input = ''
      allocate (options%overrides(0))
      options_over = .false.
      i = 1
      do while (i <= size(arguments))
         if (options_over .or. index(arguments(i)%text, '-') /= 1) then
            call take_file(arguments(i)%text, options, errors)
         else if (arguments(i)%text == '--') then
            options_over = .true.
         else
            call take_option(arguments, i, options, errors)
         end if
         i = i + 1
      end do
      if (options%resume /= '') call check_resume(options, errors)
      if (options%json .and. .not. (options%check .or. options%keys .or. options%rules)) call errors%add( &
         '--json requires --check, --keys or --rules')
      if (options%input == '' .and. options%resume == '' .and. errors%count == 0 .and. &
          .not. (options%help .or. options%version .or. options%template .or. options%keys .or. options%rules)) &
         call errors%add('which namelist file? Usage: '//program_name//' [options] case.nml; '//program_name//' --help explains')
      call errors%tell(failure)
   end subroutine parse_arguments

   !> A resumed run has its model; only its checkpoint times can be changed.
   pure subroutine check_resume(options, errors)
      type(options_t), intent(in) :: options
      type(input_errors_t), intent(inout) :: errors
      integer :: i
      if (options%input /= '') call errors%add('--resume and the namelist file '''//printable(options%input, 200)// &
                                               ''': the checkpoint has its model; give one of the two')
      if (options%check) call errors%add('--resume and --check: give one of the two')
      do i = 1, size(options%overrides)
         associate (text => options%overrides(i)%text)
            if (.not. (is_one_of(text, of_checkpoints) .or. is_one_of(text, of_end))) call errors%add('--set '// &
               printable(text, 200)//': with --resume only run.end_time, method.load_steps, run.stop_..., '// &
               'output.checkpoint_interval and output.checkpoint_steps can be changed')
         end associate
      end do
   end subroutine check_resume

   !> Whether an override is of one of these keys.
   pure logical function is_one_of(text, keys)
      character(*), intent(in) :: text           !! `group.key=value`
      character(*), intent(in) :: keys(:)        !! how they begin
      integer :: k
      is_one_of = any([(index(lower_case(adjustl(text)), trim(keys(k))) == 1, k=1, size(keys))])
   end function is_one_of

   !> Whether overrides of a resumed run concern its end, which is a part of its model.
   pure logical function changes_model(options)
      type(options_t), intent(in) :: options
      integer :: i
      changes_model = any([(is_one_of(options%overrides(i)%text, of_end), i=1, size(options%overrides))])
   end function changes_model

   !> Note the name of the namelist file; complain about a second one.
   pure subroutine take_file(name, options, errors)
      character(*), intent(in) :: name
      type(options_t), intent(inout) :: options
      type(input_errors_t), intent(inout) :: errors
      if (name == '') then
         call errors%add('an argument is empty: the name of the namelist file is expected')
      else if (options%input /= '') then
         call errors%add('one namelist file at a time: '''//printable(options%input, 200)//''' and then '''// &
                         printable(name, 200)//'''')
      else
         options%input = name
      end if
   end subroutine take_file

   !> The option at position `i`, which moves on where the value is the next argument.
   pure subroutine take_option(arguments, i, options, errors)
      type(string_t), intent(in) :: arguments(:)
      integer, intent(inout) :: i
      type(options_t), intent(inout) :: options
      type(input_errors_t), intent(inout) :: errors
      character(:), allocatable :: name, value
      character(name_len) :: names(size(known))
      integer :: equals, k
      logical :: has_value
      names = known%name
      equals = index(arguments(i)%text//'=', '=')
      has_value = equals <= len(arguments(i)%text)
      name = arguments(i)%text(:equals - 1)
      value = arguments(i)%text(equals + 1:)
      do k = size(known), 1, -1
         if (names(k) == name) exit
      end do
      if (k == 0) then
         call errors%add('there is no option '//printable(name, 60)//did_you_mean(name, names)// &
                         ' ('//program_name//' --help lists them)')
         return
      end if
      if (has_value .and. .not. known(k)%takes_value) call errors%add(name//' takes no value')
      if (known(k)%takes_value .and. .not. has_value) then
         if (i < size(arguments)) has_value = index(arguments(i + 1)%text, '--') /= 1
         if (has_value) then
            i = i + 1
            value = arguments(i)%text
         end if
      end if
      if (known(k)%takes_value .and. (.not. has_value .or. value == '')) then
         call errors%add(name//': its value is missing: '//trim(known(k)%synopsis))
         return
      end if
      call apply_option(name, value, options, errors)
   end subroutine take_option

   !> Apply an option that exists; add an error if its value is wrong.
   pure subroutine apply_option(name, value, options, errors)
      character(*), intent(in) :: name, value
      type(options_t), intent(inout) :: options
      type(input_errors_t), intent(inout) :: errors
      type(string_t) :: override
      integer :: ios
      select case (name)
       case ('--check')
         options%check = .true.
       case ('--explain')
         options%explain = .true.
       case ('--template')
         options%template = .true.
       case ('--keys')
         options%keys = .true.
       case ('--rules')
         options%rules = .true.
       case ('--json')
         options%json = .true.
       case ('--quiet')
         options%quiet = .true.
       case ('--version')
         options%version = .true.
       case ('--help')
         options%help = .true.
       case ('--output')
         options%output = value
       case ('--resume')
         options%resume = value
       case ('--force')
         options%force = .true.
       case ('--steps')
         ios = 1
         if (len(value) <= 18 .and. verify(value, '0123456789') == 0) read (value, '(i18)', iostat=ios) options%steps
         if (ios /= 0 .or. options%steps < 1) call errors%add('--steps '//printable(value, 40)// &
                                                              ': must be an integer in [1, 1e18)')
       case ('--time-limit')
         call parse_real(value, options%time_limit, ios)
         if (ios /= is_number .or. .not. options%time_limit > 0) &
            call errors%add('--time-limit '//printable(value, 40)//': must be a number in (0, inf) [s]')
       case ('--set')
         override%text = value
         options%overrides = [options%overrides, override]
       case ('--threads')
         options%threads = most_threads + 1
         ios = 0
         if (len(value) <= 6 .and. verify(value, '0123456789') == 0) read (value, '(i6)', iostat=ios) options%threads
         if (ios /= 0 .or. options%threads > most_threads) call errors%add( &
            '--threads '//printable(value, 40)//': must be an integer in [0, 1024], 0 for automatic')
      end select
   end subroutine apply_option

   !> The explanation that `--help` prints.
   pure function usage_text() result(text)
      character(:), allocatable :: text
      integer :: k
      text = line('Usage: '//program_name//' [options] case.nml')//line('       '//program_name//' [options] --resume CHECKPOINT') &
             //line('') &
             //line('Computes the motion of the model that the namelist file describes and the energy release rate of') &
             //line('its crack, by the material point method. '// &
                  program_name//' --template > case.nml gives a model to start from.') &
             //line('')
      do k = 1, size(known)
         text = text//line('  '//known(k)%synopsis(:24)//trim(known(k)%meaning))
      end do
      text = text//line('')//line('Exit codes: 0 done; 2 an error on the command line or in the file; 3 the computation') &
             //line('failed; 4 a file could not be read or written, or an old result is there; 5 stopped before the end,') &
             //line('with a checkpoint to go on from; 6 the processor lacks instructions for which '//program_name//' was built.')
   end function usage_text
end module hampm_command_line
