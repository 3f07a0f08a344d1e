!> Resources of a model before it is built: particles, cells, steps, samples, memory and size of the results. All numbers are real:
!> an integer might overflow.
!>
!> The memory and the stack available to this process, from the files of Linux.
module hampm_resource_estimate
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: region_in
   use hampm_failure, only: failure_t, exit_input
   use hampm_front, only: front_t, find_fronts, region_t
   use hampm_json, only: member
   use hampm_law, only: value_of
   use hampm_path_placement, only: path_tips
   use hampm_placement, only: particle_number
   use hampm_material, only: material_t
   use hampm_model, only: model_t, mass_used
   use hampm_stiffness, only: most_direct
   use hampm_model_materials, only: materials_of
   use hampm_text, only: to_text
   use hampm_critical_step, only: stable_time_step
   implicit none
   private
   public :: resources_t, estimate_resources, check_room, check_resources, resource_report, resource_json

   real(dp), parameter :: unknown = -1
   real(dp), parameter :: of_algebra = 3.2e8_dp  !! address space that OpenBLAS and its thread take at first use [bytes]
   real(dp), parameter :: least_stack = 1048576  !! five times the largest use of the program and its threads [bytes]

   real(dp), parameter :: most_steps = 1e12_dp      !! of the largest cells: months at a microsecond each

   ! Bytes, measured (tests/program/test_needs.py)
   real(dp), parameter :: of_program = 2.0e7_dp     !! without any model
   logical, parameter :: solid = ndim == 3
   real(dp), parameter :: of_particle = merge(237, 156, solid), of_cell = merge(850, 520, solid), &
                          of_full_cell = merge(400, 465, solid), of_full_cell_in_total = merge(1050, 465, solid)
   real(dp), parameter :: of_quadratic_cell = 1840, of_full_quadratic_cell = 1060, of_domain = 270
   real(dp), parameter :: of_refined_particle = 60, of_refined_cell = 200
   real(dp), parameter :: of_mass = merge(1400, 480, solid), of_cg = merge(950, 200, solid), &
                          of_viewed_particle = merge(400, 192, solid), of_viewed_cell = merge(1100, 290, solid)
   real(dp), parameter :: of_quadratic_mass = 3350, of_quadratic_cg = 1600, of_viewed_quadratic_cell = 2000
   real(dp), parameter :: of_snapshot_particle = 169, of_snapshot_cell = 113

   ! The static solution: for the estimated errors of a crack, and for the distance of a damped motion
   real(dp), parameter :: of_stiffness = 205.0_dp   !! per entry of its factors, as counted by `fill_of` [bytes]
   real(dp), parameter :: of_unknown = 1800, of_entry = 95, of_multigrid = 2400 !! of a solid, see below
   real(dp), parameter :: of_lasting = merge(3.4_dp, 2.35_dp, solid) !! fill of factors of each step, kept as columns too [-]
   real(dp), parameter :: of_mass_entry = 346    !! of the factor of a mass matrix of a solid [bytes]
   real(dp), parameter :: of_quadratic_fill = 1.25_dp  !! entries over those of bilinear cells with as many nodes [-]
   real(dp), parameter :: most_static = 2.5e5_dp    !! cells with particles for which it is found

   !> Resources of a model, in numbers.
   type :: resources_t
      real(dp) :: particles = 0                     !! that the run begins with, refined around a tip
      real(dp) :: cells = 0                         !! leaves that the run begins with
      real(dp) :: most_particles = 0                !! upper bound where cells refine as the solution requires
      real(dp) :: steps = 0                         !! with all cells as large as the root cells
      real(dp) :: rows = 0                          !! of the history
      real(dp) :: snapshots = 0
      character(48) :: of_steps = ''                !! which steps have snapshots, in words; '' as for the rows
      real(dp) :: memory = 0                        !! at the start [bytes]
      real(dp) :: most_memory = 0                   !! with `most_particles` [bytes]
      real(dp) :: results = 0                       !! size of the result file with the mesh of the start [bytes]
      real(dp) :: most_results = 0                  !! with `most_particles` in all snapshots but the first [bytes]
   end type resources_t

contains

   !> Estimate the resources of a model.
   type(resources_t) function estimate_resources(model) result(resources)
      type(model_t), intent(in) :: model
      real(dp) :: occupied, most_cells
      integer :: k, columns                         ! of the history
      resources%particles = sum([(particle_number(model, model%bodies(k)), k=1, size(model%bodies))])
      resources%cells = product(real(model%grid%cells, dp))
      occupied = sum([(model%bodies(k)%area_in(model%bodies(k)%lower, model%bodies(k)%upper), k=1, size(model%bodies))]) &
                 /model%grid%cell**ndim
      occupied = max(min(occupied, resources%cells), 1.0_dp)
      if (model%refine%by%reach /= '') call refine_around_tips(model, resources, occupied)
      resources%memory = memory_for(model, resources%particles, resources%cells, occupied)
      resources%most_particles = resources%particles
      if (model%refine%is_active() .and. model%refine%by%reach == '') &
         resources%most_particles = min(real(model%refine%max_particles, dp), &
                                        resources%particles*2.0_dp**(ndim*model%refine%max_level))
      associate (growth => resources%most_particles/resources%particles)
         most_cells = resources%cells + (growth - 1)*occupied
         resources%most_memory = memory_for(model, resources%most_particles, most_cells, growth*occupied)
      end associate
      if (model%method%time == 'static') then
         resources%steps = model%method%load_steps
      else if (model%method%time == 'modal') then
         resources%steps = model%run%end_time/model%output%history_interval
      else if (model%method%time_step > 0) then
         resources%steps = model%run%end_time/model%method%time_step
      else
         resources%steps = model%run%end_time/stable_time_step(model%grid%cell, materials_of(model), model%method%courant, &
                                                               model%method%wave_speed)
      end if
      ! The end of the run has a row, too
      resources%rows = 1 + anint(model%run%end_time/model%output%history_interval*(1 - 4*epsilon(resources%rows)) + 0.5_dp)
      if (model%method%time == 'implicit') resources%rows = min(resources%rows, 1 + anint(resources%steps + 0.49_dp))
      call look_at_snapshots(model, resources)
      columns = 10 + merge(1, 2*size(model%paths), model%is_half())*(24 + size(model%energy_release%radii)) ! about
      resources%results = 5e4_dp + 8*columns*max(resources%rows, 512.0_dp) + &
                          resources%snapshots*(of_snapshot_particle*resources%particles + of_snapshot_cell*resources%cells) + &
                          8*ndim*resources%particles*modes_of(model)
      resources%most_results = resources%results + max(resources%snapshots - 1, 0.0_dp)* &
                               (of_snapshot_particle*(resources%most_particles - resources%particles) + &
                            of_snapshot_cell*(most_cells - resources%cells))
   end function estimate_resources

   !> Count snapshots, and name their steps if their times are not times of rows.
   pure subroutine look_at_snapshots(model, resources)
      type(model_t), intent(in) :: model
      type(resources_t), intent(inout) :: resources
      real(dp), parameter :: same = 1e-6_dp      ! part of an interval
      real(dp) :: intervals                      ! between rows, in one between snapshots [-]
      if (.not. model%output%snapshot_interval > 0) return
      resources%snapshots = aint((1 + model%run%end_time/model%output%snapshot_interval)*(1 + 4*epsilon(intervals)))
      intervals = model%output%snapshot_interval/model%output%history_interval
      if (intervals >= 1 - same .and. abs(intervals - anint(intervals)) <= same*intervals) return
      resources%of_steps = ', of the steps in which their times come'
      if (model%method%time /= 'static' .and. model%method%time /= 'modal') return
      resources%of_steps = ', of the load steps at or after their times'
      resources%snapshots = min(resources%snapshots, resources%rows)
   end subroutine look_at_snapshots

   !> Add the refinement around tips and fronts before the run: at each level the cells within the reach of one, within the
   !> material, are divided.
   pure subroutine refine_around_tips(model, resources, occupied)
      type(model_t), intent(in) :: model
      type(resources_t), intent(inout) :: resources
      real(dp), intent(inout) :: occupied           !! cells with particles
      real(dp) :: density, divided, fit, tips, front, more
      integer :: level, k
      density = resources%particles/occupied
      tips = count([(path_tips(model, k), k=1, size(model%paths))])
      if (model%is_half()) tips = tips/2
      front = front_length(model)
      fit = occupied
      do level = 0, model%refine%max_level - 1
         divided = min(fit, (tips + front/scale(model%grid%cell, -level))* &
                       (2*nint(value_of(model%refine%constants, model%refine%by%reach, 0.0_dp)) + 1.0_dp)**2)
         more = (2**ndim - 1)*divided
         if (resources%particles + more*density > model%refine%max_particles) exit
         resources%particles = resources%particles + more*density
         resources%cells = resources%cells + more
         occupied = occupied + more
         fit = 2**ndim*divided
      end do
   end subroutine refine_around_tips

   !> How long the fronts of cracks in solids are; half of it on planes of symmetry, where there is material to one side only [m].
   pure real(dp) function front_length(model)
      type(model_t), intent(in) :: model
      type(front_t), allocatable :: fronts(:)
      type(region_t) :: region
      integer :: k
      front_length = 0
      do k = 1, size(model%planes)
         region = region_in(model, model%planes(k))
         call find_fronts(region, fronts)
         front_length = front_length + sum(fronts%length)*merge(0.5_dp, 1.0_dp, region%is_symmetry)
      end do
   end function front_length

   !> Memory of a run with so many particles, cells and cells with particles [bytes].
   real(dp) function memory_for(model, particles, cells, occupied) result(bytes)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: particles, cells, occupied
      type(material_t), allocatable :: materials(:)
      real(dp) :: fill, copies                   ! entries of the factors of the stiffness, times as which they are kept
      bytes = of_program + of_particle*particles
      if (model%grid%order == 2) then
         bytes = bytes + of_quadratic_cell*cells + of_full_quadratic_cell*occupied
         fill = of_quadratic_fill*fill_of(4*occupied)
      else
         bytes = bytes + of_cell*cells + merge(of_full_cell_in_total, of_full_cell, model%method%frame == 'total')*occupied
         fill = fill_of(occupied)
      end if
      if (model%method%shape_functions == 'cpdi') bytes = bytes + of_domain*particles
      if (model%refine%is_active()) &
         bytes = bytes + of_refined_particle*particles + of_refined_cell*cells
      if (model%output%snapshot_interval > 0) bytes = bytes + of_viewed_particle*particles &
         + merge(of_viewed_quadratic_cell, of_viewed_cell, model%grid%order == 2)*cells
      if ((size(model%energy_release%chosen) > 0 .or. model%damping%rate > 0) .and. occupied <= most_static &
          .or. model%method%time /= 'explicit') then
         materials = materials_of(model)
         copies = merge(of_lasting, 1.0_dp, any(model%method%time == ['implicit', 'modal   ']) .and. all(materials%linear))
         if (solid) then
            bytes = bytes + stiffness_of_solid(model, occupied, copies)
         else
            bytes = bytes + copies*of_stiffness*fill
         end if
      end if
      if (model%method%time == 'modal') &        ! the modes, the Lanczos vectors and some to work with
         bytes = bytes + 8*ndim*occupied*model%grid%order**ndim*(3*modes_of(model) + 8)
      if (mass_used(model) == 'lumped') return
      bytes = bytes + merge(of_quadratic_mass, of_mass, model%grid%order == 2)*cells
      if (model%method%mass == 'fmpm' .or. model%method%mass == 'tip_weighted') return ! few cells are solved
      select case (model%method%solver)
       case ('cg')
         bytes = bytes + merge(of_quadratic_cg, of_cg, model%grid%order == 2)*cells
       case default                              ! the factors of the mass matrix of two directions
         if (solid) then
            bytes = bytes + of_mass_entry*occupied*width_of(model, occupied)
         else
            bytes = bytes + 28*2*fill_of(model%grid%order**ndim*occupied)*merge(of_quadratic_fill, 1.0_dp, model%grid%order == 2)
         end if
      end select
   end function memory_for

   !> How many modes a run finds, about; 0 where it has none.
   pure integer function modes_of(model) result(modes)
      type(model_t), intent(in) :: model
      integer, parameter :: usual = 32
      modes = 0
      if (model%method%time == 'modal') modes = merge(model%method%modes, usual, model%method%modes > 0)
   end function modes_of

   !> Memory of the stiffness of a solid [bytes]: the matrix, and its factor by nested dissection, whose entries a row are some
   !> times the width of the body, or the levels of the multigrid.
   pure real(dp) function stiffness_of_solid(model, occupied, copies) result(bytes)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: occupied
      real(dp), intent(in) :: copies             !! of the factor
      real(dp) :: unknowns
      unknowns = ndim*occupied
      if (model%method%solver == 'cg' .or. model%method%solver == 'auto' .and. unknowns > most_direct) then
         bytes = of_multigrid*unknowns
      else
         bytes = of_unknown*unknowns + copies*of_entry*ndim**2*occupied*width_of(model, occupied)
      end if
   end function stiffness_of_solid

   !> Width of the separator of nested dissection [nodes], of the box around all bodies with so many cells in it: the least of its
   !> three sides, and as much again for each halving of the middle one to that size.
   pure real(dp) function width_of(model, occupied) result(width)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: occupied
      real(dp) :: side(ndim), middle
      integer :: d, k
      do d = 1, ndim
         side(d) = maxval([(model%bodies(k)%upper(d), k=1, size(model%bodies))]) - &
                   minval([(model%bodies(k)%lower(d), k=1, size(model%bodies))])
      end do
      side = max(side*(occupied/product(side))**(1/3.0_dp), 1.0_dp)
      middle = sum(side) - minval(side) - maxval(side)
      width = minval(side)*(1 + log(max(middle/minval(side), 1.0_dp))/log(2.0_dp))
   end function width_of

   !> Entries of the factors of a matrix of the nodes by nested dissection, up to a constant.
   pure real(dp) function fill_of(occupied)
      real(dp), intent(in) :: occupied
      fill_of = occupied*max(log(occupied)/log(2.0_dp), 1.0_dp)
   end function fill_of

   !> Fail where the libraries have no room, before anything calls them.
   subroutine check_room(failure)
      type(failure_t), intent(inout) :: failure
      if (stack_there_is() < least_stack) call failure%report(exit_input, 'the limit of the stack (ulimit -s) is '// &
                              bytes_text(stack_there_is())//': allow '//bytes_text(least_stack)//' or more; 8 MB are usual')
      ! Where the library of linear algebra cannot take the room that it asks for at its first use, it waits for ever
      if (memory_available() <= 1) call failure%report(exit_input, 'the limit of the address space (ulimit -v) leaves no room '// &
                              'for the library of linear algebra: allow about 600 MB and the memory of the model, or set no limit')
   end subroutine check_room

   !> Fail where a model needs more than there can be.
   subroutine check_resources(resources, failure)
      type(resources_t), intent(in) :: resources
      type(failure_t), intent(inout) :: failure
      real(dp) :: memory
      if (resources%steps > most_steps) call failure%report(exit_input, 'the run would take '//rough(resources%steps)// &
                                  ' time steps, more than '//rough(most_steps)//': use a shorter &run end_time or a larger '// &
                                  '&grid cell or &method courant; or &material young or density is wrong')
      memory = memory_available()
      if (resources%memory > memory) call failure%report(exit_input, 'the model needs about '//bytes_text(resources%memory)// &
                                  ' of memory for '//rough(resources%particles)//' particles and '//rough(resources%cells)// &
                                  ' cells, and there are '//bytes_text(memory)// &
                                     ': use fewer &grid cells, a larger &grid cell or '// &
                                  'fewer &body points_per_cell')
   end subroutine check_resources

   !> Report of the resources, for people.
   pure function resource_report(resources) result(text)
      type(resources_t), intent(in) :: resources
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      text = 'samples         '//rough(resources%rows)//' of the history'
      if (resources%snapshots > 0) text = text//', '//rough(resources%snapshots)//' snapshots'//trim(resources%of_steps)
      text = text//nl//'results         about '//bytes_text(resources%results)
      if (resources%most_particles > resources%particles) text = text//', at most '//bytes_text(resources%most_results)
      text = text//nl//'memory          about '//bytes_text(resources%memory)
      if (resources%most_particles > resources%particles) text = text//', '//bytes_text(resources%most_memory)// &
         ' where cells refine to '// &
                                                                 rough(resources%most_particles)//' particles'
      text = text//nl
   end function resource_report

   !> The same for programs: members of an object. Memory and the size of the result file are in bytes.
   pure function resource_json(resources) result(members)
      type(resources_t), intent(in) :: resources
      character(:), allocatable :: members
      members = member('samples', nint(min(resources%rows, real(huge(1), dp))))// &
                member('snapshots', nint(min(resources%snapshots, real(huge(1), dp))))// &
                member('results', resources%results)//member('most_results', resources%most_results)// &
                member('memory', resources%memory)//member('most_memory', resources%most_memory)// &
                member('most_particles', resources%most_particles)
   end function resource_json

   !> A number of bytes as text, in two or three digits.
   pure function bytes_text(bytes) result(text)
      real(dp), intent(in) :: bytes
      character(:), allocatable :: text
      character(2), parameter :: unit(*) = ['kB', 'MB', 'GB', 'TB']
      real(dp) :: size_in_unit
      integer :: k
      size_in_unit = bytes/1000
      do k = 1, size(unit) - 1
         if (size_in_unit < 999.5_dp) exit
         size_in_unit = size_in_unit/1000
      end do
      if (size_in_unit < 9.95_dp) then
         text = to_text(anint(10*size_in_unit)/10)//' '//unit(k)
      else if (size_in_unit < 1e6_dp) then
         text = to_text(nint(size_in_unit))//' '//unit(k)
      else
         text = to_text(size_in_unit)//' '//unit(k)
      end if
   end function bytes_text

   !> A whole number as text; in powers of ten where an integer does not hold it.
   pure function rough(number) result(text)
      real(dp), intent(in) :: number
      character(:), allocatable :: text
      character(9) :: buffer
      integer :: decade
      if (number < 1e9_dp) then
         text = to_text(nint(number))
      else
         write (buffer, '(es9.1e3)') number
         read (buffer(6:9), '(i4)') decade
         text = buffer(2:4)//'e'//to_text(decade)
      end if
   end function rough

   !> The least of the memory of the machine and the limits of this process or its group [bytes]; huge if nothing tells. A limit on
   !> the address space includes the memory mapped by the program and its libraries.
   real(dp) function memory_available() result(bytes)
      real(dp), parameter :: kilobyte = 1024
      real(dp) :: limit
      bytes = huge(bytes)
      call take(kilobyte*number_behind('/proc/meminfo', 'MemTotal:'))
      call take(number_behind('/sys/fs/cgroup/memory.max', ''))
      call take(number_behind('/sys/fs/cgroup/memory/memory.limit_in_bytes', ''))
      limit = number_behind('/proc/self/limits', 'Max address space')
      if (limit > 0) call take(max(1.0_dp, limit - kilobyte*number_behind('/proc/self/status', 'VmSize:') - of_algebra))

   contains

      !> Lower the limit; 0 and below mean no limit.
      subroutine take(limit)
         real(dp), intent(in) :: limit
         if (limit > 0) bytes = min(bytes, limit)
      end subroutine take
   end function memory_available

   !> The limit of the stack [bytes]; huge where there is no limit or the system does not tell.
   real(dp) function stack_there_is() result(bytes)
      bytes = number_behind('/proc/self/limits', 'Max stack size')
      if (bytes < 0) bytes = huge(bytes)
   end function stack_there_is

   !> The number behind a label that begins a line of a file; negative where there is no file, line or number.
   real(dp) function number_behind(path, label) result(number)
      character(*), intent(in) :: path, label
      character(*), parameter :: blank = ' '//achar(9)
      character(200) :: line
      integer :: unit, status
      number = unknown
      open (newunit=unit, file=path, status='old', action='read', iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         if (index(line, label) /= 1) cycle
         if (verify(line(len(label) + 1:), blank) == 0) exit
         line = line(len(label) + 1:)
         line = line(verify(line, blank):)
         line = line(:scan(line, blank) - 1)
         if (line /= '' .and. verify(trim(line), '0123456789') == 0) read (line, *, iostat=status) number
         exit
      end do
      close (unit)
   end function number_behind
end module hampm_resource_estimate
