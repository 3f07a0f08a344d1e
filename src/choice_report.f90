!> What &accuracy has chosen, and why, for people.
module hampm_choice_report
   use hampm_kinds, only: dp
   use hampm_choice_runs, only: choice_t
   use hampm_mesh_trials, only: is_better, mesh_t, trials_t, most_particles
   use hampm_model, only: model_t
   use hampm_reading, only: split_instance
   use hampm_text, only: to_text, three_digits, digits_text
   implicit none
   private
   public :: choice_report, explained_model

contains

   !> What has been chosen and, of --check, what other errors would cost, in lines.
   function choice_report(choice, model, checks) result(text)
      type(choice_t), intent(in) :: choice
      type(model_t), intent(in) :: model
      logical, intent(in) :: checks
      character(:), allocatable :: text
      character(*), parameter :: nl = new_line('a'), indent = repeat(' ', 16)
      integer :: k
      text = ''
      if (.not. choice%is_open .or. choice%family == 0) return
      associate (trials => choice%trials(choice%family))
         text = 'accuracy        '//trim(trials%family%name)//' of '//three_digits(model%grid%cell)//' m, '// &
                to_text(choice%mesh%levels)//' levels around tips, '//trim(trials%family%time)//nl//indent// &
                'predicted '//digits_text(choice%predicted, 2)//' of the error asked, about '// &
                digits_text(trials%seconds*trials%work_of(choice%mesh), 2)//' s'
         if (choice%pilots > 0) text = text//'; pilots took '//digits_text(choice%pilots, 2)//' s'
         text = text//nl
         if (.not. checks .or. choice%tries == 0) return
         do k = 1, 2
            text = text//indent//trim(merge('a tenth of that error  ', 'ten times that error   ', k == 1))//': '// &
                   cost_of_other(choice, merge(0.1_dp, 10.0_dp, k == 1))//nl
         end do
      end associate
   end function choice_report

   !> What a multiple of the error asked would cost, by the cheapest mesh of all families that have been tried.
   function cost_of_other(choice, multiple) result(text)
      type(choice_t), intent(in) :: choice
      real(dp), intent(in) :: multiple           !! [-]
      character(:), allocatable :: text
      type(trials_t) :: other
      type(mesh_t) :: mesh
      real(dp) :: work, error, least_work, least_error, seconds
      integer :: k
      least_work = huge(least_work)
      least_error = huge(least_error)
      seconds = 0
      do k = 1, size(choice%trials)
         other = choice%trials(k)
         if (.not. (other%is_allowed .and. other%seconds > 0)) cycle
         other%of_cells = other%of_cells/multiple
         other%of_tips = other%of_tips/multiple
         call other%find_cheapest(choice%limits, mesh, work, error)
         if (.not. is_better(error, work, least_error, least_work)) cycle
         least_error = error
         least_work = work
         seconds = other%seconds*work
      end do
      text = 'about '//digits_text(seconds, 2)//' s'
      if (least_error > 1) text = 'is not reached within '//to_text(nint(most_particles))//' particles'
   end function cost_of_other

   !> The whole namelist of a model, with a comment to each chosen key.
   function explained_model(choice, model) result(text)
      type(choice_t), intent(in) :: choice
      type(model_t), intent(in) :: model
      character(:), allocatable :: text, group, key
      character, parameter :: nl = new_line('a')
      integer :: k, first, last, number
      text = model%as_used
      do k = 1, size(choice%chosen)
         associate (set => choice%chosen(k)%text)
            call split_instance(set(:index(set, '.') - 1), group, number)
            key = set(index(set, '.') + 1:index(set, '=') - 1)
         end associate
         first = 1
         do number = max(number, 1), 1, -1
            first = first + index(nl//text(first:), nl//'&'//group//nl)
         end do
         first = first + index(text(first:), nl//'   '//key//' =')
         last = first + index(text(first:), nl) - 2
         text = text(:last)//' ! chosen: '//reason(group, key)//text(last + 1:)
      end do
   end function explained_model

   !> Why a key has been chosen as it is.
   pure function reason(group, key) result(text)
      character(*), intent(in) :: group, key
      character(:), allocatable :: text
      select case (group//'.'//key)
       case ('grid.lower', 'grid.cell', 'grid.cells')
         text = 'the coarsest of the lattices with nodes at edges, supports and tips that is predicted to reach the error'
       case ('grid.order', 'body.points_per_cell', 'method.time', 'method.mass', 'method.time_step', 'refine.rings', &
             'refine.max_particles')
         text = 'of the cheapest family of meshes and steps that the rules allow'
       case ('refine.indicator', 'refine.max_level')
         text = 'so many levels around the tips as make their part of the error small enough'
       case default
         text = 'as the quantity that is asked requires'
      end select
   end function reason
end module hampm_choice_report
