!> A simulation and the cost of its solver: in words for people, and as JSON for programs.
module hampm_summary
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use hampm_kinds, only: dp, name_len
   use hampm_cell_values, only: is_occupied
   use hampm_crack_tip, only: crack_tip_t
   use hampm_cracks, only: first_point
   use hampm_integrator, only: steps_for
   use hampm_json, only: array, item, json_of, member, object
   use hampm_loads, only: all_become_constant, time_to_constant_value
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_placement, only: point_text
   use hampm_static_equilibrium, only: find_lowest_frequency, time_to_equilibrium
   use hampm_simulation, only: simulation_t, is_near_equilibrium
   use hampm_stiffness, only: stiffness_t
   use hampm_text, only: string_t, to_text, length_text, decimal, three_digits, digits_text
   implicit none
   private
   public :: summary, summary_json, solver_report, tip_report, equilibrium_report, equilibrium_proposal

   real(dp), parameter :: two_pi = 2*acos(-1.0_dp)

contains

   !> Cost of the solution of the nodal equations, for people; '' where the mass matrix is diagonal or not inverted.
   function solver_report(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      text = ''
      associate (solver => s%problem%solver)
         if (solver%solutions == 0) return
         text = 'mass matrix: '//to_text(solver%solutions)//' solutions, '//to_text(solver%iterations)//' iterations'
         if (solver%direct%factorisations == 0) return
         text = text//', '//to_text(solver%direct%analyses)//' analyses, '//to_text(solver%direct%factorisations)// &
                ' factorisations'
      end associate
   end function solver_report

   !> The last means along the fronts of cracks of a solid, a row each; '' where none is measured.
   function front_report(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text, ending
      character(*), parameter :: names(*) = ['G_mean   ', 'G_largest', 'K_I      ', 'K_II     ', 'K_III    ']
      character(*), parameter :: headings(*) = [character(16) :: 'front', 'mean G [J/m2]', 'error', 'largest G', 'K_I [Pa m^0.5]', &
                                                'K_II [Pa m^0.5]', 'K_III [Pa m^0.5]']
      type(string_t), allocatable :: table(:, :)
      real(dp) :: value
      integer :: front, fronts, n, column
      fronts = 0
      do while (.not. ieee_is_nan(s%measurements%history%latest('G_mean'//ending_of(fronts + 1))))
         fronts = fronts + 1
      end do
      text = ''
      if (fronts == 0) return
      allocate (table(0:fronts, size(headings)))
      do n = 1, size(headings)
         table(0, n)%text = trim(headings(n))
      end do
      do front = 1, fronts
         ending = ending_of(front)
         associate (history => s%measurements%history)
            table(front, 1)%text = to_text(front)
            do n = 1, size(names)
               column = n + 1                    ! the third has the error
               if (n > 1) column = n + 2
               table(front, column)%text = known(history%latest(trim(names(n))//ending), 5)
            end do
            value = history%latest('G_mean_error'//ending)/history%latest('G_mean'//ending)
            table(front, 3)%text = '-'
            if (value >= 0) table(front, 3)%text = percent(value)
         end associate
      end do
      text = aligned(table)
      text = text(:len(text) - 1)
   contains
      !> Ending of the names of the columns of a front.
      pure function ending_of(front) result(ending)
         integer, intent(in) :: front
         character(:), allocatable :: ending
         ending = ''
         if (front > 1) ending = '_front'//to_text(front)
      end function ending_of
   end function front_report

   !> The last values at all tips as a table, a row each, with their errors and a note on these, or else along fronts.
   function tip_report(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      character(*), parameter :: names(*) = ['G   ', 'J   ', 'K_I ', 'K_II']
      character(*), parameter :: headings(*) = [character(15) :: 'tip', 'length [m]', 'angle [deg]', 'speed [m/s]', &
                                                'G [J/m2]', 'error', 'J [J/m2]', 'error', &
                                                'K_I [Pa m^0.5]', 'error', 'K_II [Pa m^0.5]', 'error']
      character(*), parameter :: of_cells = 'errors are estimated from the cells', &
                                 of_motion = '; waves too short for them, and what is missing to rest, are not included', &
                                 unknown = 'errors are not known: those of cells are not estimated where material depends on '// &
                                           'its history, or a crack was not there at first'
      real(dp), parameter :: degree = acos(-1.0_dp)/180
      type(string_t) :: table(0:size(s%cracks%tips), size(headings))
      character(:), allocatable :: ending
      real(dp) :: value, error
      integer :: k, n
      text = front_report(s)
      if (size(s%cracks%tips) == 0) return
      do n = 1, size(headings)
         table(0, n)%text = trim(headings(n))
      end do
      do k = 1, size(s%cracks%tips)
         ending = ''
         if (k > 1) ending = '_tip'//to_text(k)
         associate (tip => s%cracks%tips(k), history => s%measurements%history)
            table(k, 1)%text = to_text(k)
            table(k, 2)%text = digits_text(s%cracks%crack(tip%crack)%length(), 5)
            table(k, 3)%text = digits_text(atan2(tip%axis(2, 1), tip%axis(1, 1))/degree, 4)
            table(k, 4)%text = known(history%latest('tip_speed'//ending), 4)
            do n = 1, size(names)
               value = history%latest(trim(names(n))//ending)
               error = history%latest(trim(names(n))//'_error'//ending)
               table(k, 3 + 2*n)%text = known(value, 5)
               table(k, 4 + 2*n)%text = '-'
               if (ieee_is_nan(value) .or. ieee_is_nan(error)) cycle
               if (.not. abs(value) > 0) cycle   ! as K_I of closed faces
               table(k, 4 + 2*n)%text = '> 100 %'
               if (error < abs(value)) table(k, 4 + 2*n)%text = percent(error/abs(value))
            end do
         end associate
      end do
      text = aligned(table)
      if (index(text, '%') > 0) then
         text = text//of_cells//trim(merge(repeat(' ', len(of_motion)), of_motion, s%integrator%is_static))
      else if (.not. all(s%measurements%crack%errors%are_known)) then
         text = text//unknown
      else
         text = text(:len(text) - 1)
      end if
   end function tip_report

   !> A number in so many digits, '-' if absent.
   pure function known(value, digits) result(text)
      real(dp), intent(in) :: value
      integer, intent(in) :: digits
      character(:), allocatable :: text
      text = '-'
      if (.not. ieee_is_nan(value)) text = digits_text(value, digits)
   end function known

   !> A table with a row of headings, its columns below each other, in lines; columns without any value are left out.
   pure function aligned(table) result(text)
      type(string_t), intent(in) :: table(0:, :)
      character(:), allocatable :: text
      integer :: width(size(table, 2)), row, column
      do column = 1, size(width)
         width(column) = 0
         if (any([(table(row, column)%text /= '-', row=1, ubound(table, 1))])) &
            width(column) = 2 + maxval([(len(table(row, column)%text), row=0, ubound(table, 1))])
      end do
      text = ''
      do row = 0, ubound(table, 1)
         do column = 1, size(width)
            if (width(column) > 0) text = text//repeat(' ', width(column) - len(table(row, column)%text))//table(row, column)%text
         end do
         text = text//new_line('a')
      end do
   end function aligned

   !> Distance of the last values from equilibrium, for people.
   function equilibrium_report(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      text = three_digits(s%distance_to_equilibrium)//' of the displacements'
      if (.not. is_near_equilibrium(s)) text = text//'; G, J and energies are about twice as far from their static values'
   end function equilibrium_report

   !> Proposal to reach equilibrium: the damping and the end time for the lowest frequency of the model; '' where it is not known,
   !> as where something moves without any force, and where a load is never constant.
   function equilibrium_proposal(s, rest) result(text)
      type(simulation_t), intent(inout) :: s
      type(stiffness_t), intent(inout) :: rest   !! that has estimated errors
      character(:), allocatable :: text
      real(dp) :: frequency
      text = ''
      if (s%integrator%is_static .or. .not. all_become_constant(s%problem%loads)) return
      call find_lowest_frequency(s%problem, rest, frequency)
      if (.not. frequency > 0) return
      text = 'to equilibrium  &damping rate = '//three_digits(2*frequency)//' (lowest frequency '// &
             three_digits(frequency/two_pi)//' Hz), &run end_time = '// &
             three_digits(time_to_constant_value(s%problem%loads) + time_to_equilibrium(frequency))//new_line('a')
   end function equilibrium_proposal

   !> Summary of the run of a model, for people.
   function summary(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      integer :: k
      text = 'particles       '//to_text(s%problem%particles%n)//nl// &
             'cells           '//to_text(s%problem%grid%forest%leaf_count())//', of which occupied '// &
             to_text(occupied_cells(s))//nl// &
             steps_summary(s)
      do k = 1, size(s%measurements%crack)
         text = text//crack_summary(s, s%cracks%tips(k))//growth_summary(s, k)//error_summary(s, k)
      end do
      if (s%measurements%g_ref > 0) text = text//'G_ref           '//to_text(s%measurements%g_ref)//' J/m2'//nl
   end function summary

   !> Number of cells with particles.
   pure integer function occupied_cells(s)
      type(simulation_t), intent(in) :: s
      integer :: leaf
      occupied_cells = count([(is_occupied(s%problem%grid, s%problem%blocks, leaf), leaf=1, s%problem%grid%forest%leaf_count())])
   end function occupied_cells

   !> The same for programs: members of an object. Lengths are in m, times in s; expected errors are parts of the values.
   function summary_json(s) result(members)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: members, tips
      integer :: k
      tips = ''
      do k = 1, size(s%measurements%crack)
         tips = tips//item(tip_json(s, k))
      end do
      members = member('particles', s%problem%particles%n)//member('cells', s%problem%grid%forest%leaf_count())// &
                member('occupied_cells', occupied_cells(s))//member('time_step', s%longest_step)// &
                member('tips', array(tips), raw=.true.)
      if (s%integrator%is_static) then
         members = members//member('steps', s%model%method%load_steps)
      else
         members = members//member('steps', to_text(steps_for(s%model%run%end_time, s%longest_step)), raw=.true.)
      end if
      if (s%measurements%g_ref > 0) members = members//member('G_ref', s%measurements%g_ref)
   end function summary_json

   !> A tip as JSON.
   function tip_json(s, number) result(json)
      type(simulation_t), intent(in) :: s
      integer, intent(in) :: number
      character(:), allocatable :: json, radii, parts
      character(name_len), allocatable :: names(:)
      real(dp), allocatable :: errors(:)
      integer :: k
      call list_expected_errors(s, number, names, errors)
      radii = ''
      parts = ''
      associate (tip => s%cracks%tips(number))
         do k = 1, size(tip%radii)
            radii = radii//item(json_of(tip%radii(k)))
         end do
         do k = 1, size(names)
            parts = parts//member(trim(names(k)), errors(k))
         end do
         json = object(member('crack', tip%crack)//member('kind', trim(s%cracks%crack(tip%crack)%kind))// &
                       member('x', tip%place(1))//member('y', tip%place(2))//member('cell', tip%nodes%spacing)// &
                       member('radii', array(radii), raw=.true.))
         if (parts /= '') json = json(:len(json) - 1)//member('expected_errors', object(parts), raw=.true.)//'}'
      end associate
   end function tip_json

   !> Place of the crack of a tip, and where its energy release rate is measured.
   function crack_summary(s, tip) result(text)
      type(simulation_t), intent(in) :: s
      type(crack_tip_t), intent(in) :: tip
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      integer :: i
      associate (crack => s%cracks%crack(tip%crack), cell => s%model%grid%cell)
         text = 'crack           '//trim(crack%kind)//', tip '//point_text(tip%place)
         if (.not. tip%is_half()) text = text//' m at its '//trim(merge('first', 'last ', tip%end == first_point))// &
                                     ' point, length '//length_text(crack%length())//trim(merge('  ', ' m', all(crack%is_tip)))
         if (.not. all(crack%is_tip)) text = text//', mouth '//point_text(decimal(crack%mouth, cell))
         text = text//' m'//nl
      end associate
      text = text//'cells at tip    '//to_text(tip%nodes%spacing)//' m'//nl
      if (size(tip%radii) == 0) return
      text = text//'domain radii    '
      do i = 1, size(tip%radii)
         text = text//length_text(tip%radii(i))
         if (i < size(tip%radii)) text = text//', '
      end do
      text = text//' m'//nl
   end function crack_summary

   !> How a tip grows; '' where it does not.
   function growth_summary(s, tip) result(text)
      type(simulation_t), intent(in) :: s
      integer, intent(in) :: tip                 !! its number
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      integer :: k
      text = ''
      if (.not. s%growing%are_there()) return
      if (.not. s%growing%points(tip)%grows) return
      do k = 1, size(s%model%growth)
         associate (growth => s%model%growth(k), of => s%cracks%tips(tip))
            if (growth%path /= of%crack .or. .not. growth%of_end(of%end)) cycle
            text = text//'growth          '//trim(growth%direction)
            if (growth%law%is_static) text = text//', by '//length_text(growth%increment)//' m a load step'
            if (growth%law%has_rate()) then
               text = text//trim(merge(', in time by       ', ', in load cycles by', growth%law%is_in_time))//' '//trim(growth%rate)
            else if (growth%law%gives_speed()) then
               text = text//', at '//to_text(growth%speed_at(growth%start))//' m/s, '// &
                      three_digits(growth%speed_at(growth%start)/rayleigh_speed(s%problem%materials(of%material)))// &
                      ' of that of Rayleigh waves'
            else
               text = text//', at '//to_text(growth%toughness_at(s%growing%advance_of(s%model, s%cracks, tip)))//' J/m2'
               associate (advance => s%growing%advance_of(s%model, s%cracks, tip))
                  if (advance%is_of_seam) text = text//', the least of the bodies whose seam it is on'
               end associate
            end if
            if (growth%start > 0) text = text//', from '//to_text(growth%start)//' s'
            if (growth%end < huge(growth%end)) text = text//' to '//to_text(growth%end)//' s'
            text = text//nl
         end associate
      end do
   end function growth_summary

   !> How the time is divided.
   function steps_summary(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a')
      if (s%integrator%is_static) then
         text = 'load steps      '//to_text(s%model%method%load_steps)//' of '//to_text(s%longest_step)// &
                ' s, each to equilibrium by '//trim(s%model%method%solver)//nl
      else
         text = 'time step       '//to_text(s%longest_step)//' s at most'//nl// &
                'steps           '//to_text(steps_for(s%model%run%end_time, s%longest_step))//' at least'//nl
      end if
   end function steps_summary

   !> Expected relative errors of the estimators with the cells of the start; '' where no estimator is chosen.
   function error_summary(s, tip) result(text)
      type(simulation_t), intent(in) :: s
      integer, intent(in) :: tip                 !! its number
      character(:), allocatable :: text
      character(name_len), allocatable :: names(:)
      real(dp), allocatable :: errors(:)
      integer :: k
      text = ''
      call list_expected_errors(s, tip, names, errors)
      if (size(names) == 0) return
      if (.not. s%measurements%crack(tip)%errors%are_known) then
         text = 'expected error  not known: the error of cells of a history-dependent material is not estimated'//new_line('a')
         return
      end if
      do k = 1, size(names)
         text = text//', '//trim(names(k))//' '//percent(errors(k))
      end do
      text = 'expected error  '//text(3:)//', of which '//percent(s%measurements%crack(tip)%errors%of_tip)// &
             ' is due to the cells at the tip'//new_line('a')
   end function error_summary

   !> Columns that the estimators of a tip record, and their expected relative errors.
   subroutine list_expected_errors(s, tip, names, errors)
      type(simulation_t), intent(in) :: s
      integer, intent(in) :: tip                 !! its number
      character(name_len), allocatable, intent(out) :: names(:)
      real(dp), allocatable, intent(out) :: errors(:)
      integer :: k
      associate (values => s%measurements%crack(tip))
         allocate (names(size(values%estimates)), errors(size(values%estimates)))
         do k = 1, size(values%estimates)
            names(k) = 'G_'//trim(values%estimates(k)%by%name)
            errors(k) = maxval(values%estimates(k)%error%relative)
         end do
         if (.not. allocated(values%j)) return
         names = [character(name_len) :: names, 'J', 'K']
         errors = [errors, values%errors%j%relative, maxval(values%errors%intensity%relative)]
      end associate
   end subroutine list_expected_errors

   !> A part as text, in two digits of percent.
   pure function percent(part) result(text)
      real(dp), intent(in) :: part
      character(:), allocatable :: text
      character(16) :: buffer
      if (part > 9.995_dp) then
         text = 'more than 1000 %'
      else
         write (buffer, '(f8.1)') 100*part
         text = trim(adjustl(buffer))//' %'
      end if
   end function percent
end module hampm_summary
