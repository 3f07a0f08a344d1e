!> Steps of the plain model, by the program or by the least that such a step needs (`minimal_kernel.f90`):
!>
!>     bench_step time REPETITIONS CASE...
!>     bench_step steps STEPS CASE
!>     bench_step turns CASE...
!>
!> `time` measures cases in turn, so that a change of the machine's speed meets all of them; `turns` measures the case whose number, from
!> 1 on, it reads from its standard input, so that others can take turns with it. A line for each case and repetition:
!> case, particles, bytes moved a particle and step; then per particle and step [ns] processor time, wall time, and the time to
!> copy these bytes (processor time with one thread, else wall time). `steps` does steps and prints the number of particles,
!> the peak of the memory [bytes], and the kinetic and the strain energy [J].
!>
!> A case is CODE:FRAME:SCHEME:CELLS:THREADS or CODE:FRAME:SCHEME:CELLS:THREADS:MOTION, such as program:updated:musl:50:1; CODE is
!> program or minimal, CELLS those along an edge of the box, MOTION smooth or, of a softer body in a part of that box, resting or
!> turning. `speed.py` and `peers.py` make tables of it.
program bench_step
   use, intrinsic :: iso_fortran_env, only: output_unit
   use hampm_kinds, only: dp, ndim
   use hampm_command_line, only: command_arguments
   use hampm_energy, only: kinetic_energy, strain_energy
   use hampm_failure, only: failure_t
   use hampm_minimal_kernel, only: blocks_t, set_up, step
   use hampm_problem, only: problem_t, update_particles
   use hampm_plain_scene, only: plain_scene, soft_body, start, turn, time_step
   use hampm_model, only: model_t
   use hampm_step, only: explicit_t
   use hampm_text, only: string_t
   use hampm_threads, only: use_threads
   use hampm_timing, only: processor_seconds, wall_seconds, time_to_move, peak_memory
   implicit none
   type(explicit_t) :: explicit

   type :: case_t
      character(32) :: name = ''
      character(8) :: code = '', frame = '', scheme = '', motion_kind = ''
      integer :: cells = 0, threads = 0
      type(problem_t) :: problem
      type(blocks_t) :: blocks                   !! of the minimal kernel
      real(dp) :: dt = 0                         !! [s]
   end type case_t

   integer, parameter :: updates = 5000000       !! of particles in one measurement, at least
   integer, parameter :: least_steps = 50        !! in one measurement: particles are looked at once in each

   call act(command_arguments())

contains

   !> Do what the command line says.
   subroutine act(words)
      type(string_t), intent(in) :: words(:)
      if (size(words) < 2) error stop 'usage: bench_step time REPETITIONS CASE... | steps STEPS CASE | turns CASE...'
      select case (words(1)%text)
      case ('time')
         call time_cases(number(words(2)%text), words(3:))
      case ('steps')
         call do_steps(number(words(2)%text), words(3)%text)
      case ('turns')
         call take_turns(words(2:))
      case default
         error stop 'bench_step: time, steps or turns?'
      end select
   end subroutine act

   !> Measure some cases in turn.
   subroutine time_cases(repetitions, names)
      integer, intent(in) :: repetitions
      type(string_t), intent(in) :: names(:)
      type(case_t), allocatable :: cases(:)
      integer :: r, k
      call build_all(names, cases)
      do r = 1, repetitions
         do k = 1, size(cases)
            call measure(cases(k))
         end do
      end do
   end subroutine time_cases

   !> Build cases, and let each take a step.
   subroutine build_all(names, cases)
      type(string_t), intent(in) :: names(:)
      type(case_t), allocatable, intent(out) :: cases(:)
      integer :: k
      allocate (cases(size(names)))
      do k = 1, size(names)
         call build(names(k)%text, cases(k))
         call take_steps(1, cases(k))
      end do
   end subroutine build_all

   !> Measure the cases whose numbers are read.
   subroutine take_turns(names)
      type(string_t), intent(in) :: names(:)
      type(case_t), allocatable :: cases(:)
      integer :: k, status
      call build_all(names, cases)
      do
         read (*, *, iostat=status) k
         if (status /= 0 .or. k < 1 .or. k > size(cases)) exit
         call measure(cases(k))
      end do
   end subroutine take_turns

   !> Measure one case once and print its line.
   subroutine measure(c)
      type(case_t), intent(inout) :: c
      real(dp) :: processor, wall, copy
      integer :: steps, bytes
      call use_threads(c%threads, c%problem%particles%n)
      steps = max(updates/c%problem%particles%n + 1, least_steps)
      bytes = bytes_per_step(c%scheme, c%frame == 'total')
      processor = processor_seconds()
      wall = wall_seconds()
      call take_steps(steps, c)
      processor = (processor_seconds() - processor)/steps
      wall = (wall_seconds() - wall)/steps
      if (c%threads == 1) then
         copy = time_to_move(c%problem%particles%n, bytes, steps, processor_seconds)
      else
         copy = time_to_move(c%problem%particles%n, bytes, steps, wall_seconds)
      end if
      print '(a, 2(1x, i0), 3(1x, f0.3))', trim(c%name), c%problem%particles%n, bytes, &
         1e9_dp*[processor, wall, copy]/c%problem%particles%n
      flush (output_unit)
   end subroutine measure

   !> Do some steps of a case and print how large it is.
   subroutine do_steps(steps, name)
      integer, intent(in) :: steps
      character(*), intent(in) :: name
      type(case_t) :: c
      call build(name, c)
      call take_steps(steps, c)
      print '(i0, 1x, i0, 2(1x, es24.16))', c%problem%particles%n, peak_memory(), kinetic_energy(c%problem%particles), &
         strain_energy(c%problem%particles, c%problem%materials)
   end subroutine do_steps

   !> Build the model of a case and let its threads be used.
   subroutine build(name, c)
      character(*), intent(in) :: name
      type(case_t), intent(out) :: c
      type(model_t) :: model
      c%name = name
      call read_case(name, c)
      model = plain_scene(c%cells)
      if (c%motion_kind /= 'smooth') model = soft_body(c%cells)
      model%method%scheme = c%scheme
      model%method%frame = c%frame
      call start(model, c%problem)
      if (c%motion_kind == 'turning') call turn(c%problem)
      c%dt = time_step(c%problem)
      if (c%code == 'minimal') call set_up(c%dt, c%problem, c%blocks)
      call use_threads(c%threads, c%problem%particles%n)
   end subroutine build

   !> Take a case's name apart.
   subroutine read_case(name, c)
      character(*), intent(in) :: name
      type(case_t), intent(inout) :: c
      character(len(name)) :: text
      integer :: k, status
      text = name
      do k = 1, len(text)
         if (text(k:k) == ':') text(k:k) = ' '
      end do
      c%motion_kind = 'smooth'
      read (text, *, iostat=status) c%code, c%frame, c%scheme, c%cells, c%threads
      if (count([(name(k:k) == ':', k=1, len(name))]) == 5) &
         read (text, *, iostat=status) c%code, c%frame, c%scheme, c%cells, c%threads, c%motion_kind
      if (status /= 0 .or. all(c%code /= ['program', 'minimal'])) &
         error stop 'bench_step: a case is CODE:FRAME:SCHEME:CELLS:THREADS[:MOTION], CODE being program or minimal'
      if (c%code == 'minimal' .and. (c%frame /= 'updated' .or. c%scheme /= 'musl' .or. c%threads /= 1)) &
         error stop 'bench_step: the minimal kernel knows minimal:updated:musl:CELLS:1 only'
   end subroutine read_case

   !> Advance a case, as a run does between two looks at its particles.
   subroutine take_steps(steps, c)
      integer, intent(in) :: steps
      type(case_t), intent(inout) :: c
      type(failure_t) :: failure
      integer :: k
      do k = 1, steps
         if (c%code == 'minimal') then
            call step(c%dt, c%problem%grid, c%blocks)
         else
            call explicit%advance(c%problem, c%dt, failure)
            if (failure%failed()) error stop 'bench_step: the scene has failed'
         end if
      end do
      call update_particles(c%problem)
   end subroutine take_steps

   !> Bytes of particle data that the sweeps of a step read and write, 8 a real: what has to be moved where nothing of a tile
   !> stays in the caches.
   pure integer function bytes_per_step(scheme, total_frame) result(bytes)
      character(*), intent(in) :: scheme
      logical, intent(in) :: total_frame
      integer, parameter :: x = ndim, xi = ndim, u = ndim, v = ndim, h = ndim*ndim, m = 1, volume = 1
      integer :: move, remap, reals
      move = merge(2*u, x + xi + 2*u, total_frame)      ! also finds where the particle stands then
      remap = merge(0, v + m, total_frame)              ! of velocities that are not new
      select case (scheme)
      case ('usl')
         reals = xi + 2*v + 2*h + move + m + volume
      case ('usf')
         reals = (xi + 2*h + volume) + (xi + 2*v + move + m)
      case ('musl')
         reals = (xi + 2*v + m) + (xi + 2*h + move + remap + volume)
      case default
         reals = (xi + 2*h + volume) + (xi + 2*v + m) + (xi + 2*h + move + remap)
      end select
      bytes = 8*reals
   end function bytes_per_step

   !> A number of the command line.
   integer function number(text)
      character(*), intent(in) :: text
      integer :: status
      read (text, *, iostat=status) number
      if (status /= 0) error stop 'bench_step: a number is expected'
   end function number
end program bench_step
