!> What coarse runs of a family of meshes and steps tell of its others: their errors, over those asked, as
!>
!>    e = a (h/h0)**p + b (h/h0) 2**(levels0 - levels),
!>
!> a and b being of the cells away from the tips and of those at them, h0 and levels0 of the first run; and their work, counted, not
!> timed, so that a choice is the same on every machine.
module hampm_mesh_trials
   use hampm_kinds, only: dp, ndim
   use hampm_asked_errors, only: asked_error_t, no_value, worst_difference
   use hampm_families, only: family_t
   implicit none
   private
   public :: mesh_t, pilot_t, trials_t, limits_t, is_better, aim, most_particles

   real(dp), parameter :: aim = 0.8_dp           !! part of the asked error at which a choice aims
   real(dp), parameter :: patience = 20          !! work of a mesh over that of the first where none reaches the error,
   real(dp), parameter :: cheap = 1e7_dp         !! but so much, about a second, anyway
   real(dp), parameter :: of_row = 9.0_dp        !! work of a row of the history for each particle, as in `hampm_families`
   real(dp), parameter :: least_order = 0.5_dp, most_order = 6, usual_order = 2 !! of the error away from the tips in the cell
   real(dp), parameter :: least_part = 1e-3_dp   !! of the cells away from the tips in an error
   integer, parameter :: order_of_differences = 1 !! in the cell, of errors that only other meshes tell, at least
   real(dp), parameter :: most_particles = 4e6_dp !! of a mesh that is chosen
   integer, parameter :: most_lattice = 200      !! number of a lattice over that of the coarsest

   !> A mesh of a family.
   type :: mesh_t
      integer :: lattice = 1                     !! number of its lattice
      integer :: levels = 0
   end type mesh_t

   !> What a run of a mesh tells.
   type :: pilot_t
      real(dp) :: error = no_value               !! over that asked [-]
      real(dp) :: particles = 0
      real(dp) :: rows = 1                       !! of its history
      real(dp) :: seconds = 0                    !! of its processor [s]
      real(dp) :: bytes = 0                      !! of memory for each particle
      type(asked_error_t), allocatable :: values(:) !! that it has found
   end type pilot_t

   !> What has been tried of a family.
   type :: trials_t
      type(family_t) :: family
      logical :: is_allowed = .false.
      logical :: compares = .false.              !! whether meshes are compared: errors of columns are not all there is
      type(mesh_t) :: first                      !! of the first pilot
      real(dp) :: of_cells = 0, of_tips = 0      !! the parts a and b of the error over that asked [-]
      real(dp) :: order = usual_order            !! p [-]
      real(dp) :: particles = 0, of_level = 0    !! of root cells of the first pilot; those that the first level adds
      real(dp) :: in_box = 1                     !! root cells' of the first mesh if bodies fill the box around them
      real(dp) :: steps = 0                      !! of a wave through the root cells of the first pilot until the end
      real(dp) :: rows = 1                       !! of the history
      real(dp) :: seconds = 0                    !! of its processor for one unit of work [s]
      real(dp) :: bytes = 0                      !! of memory for each particle
      type(mesh_t) :: compared                   !! of the last run, with which the next one is compared in motion
      type(asked_error_t), allocatable :: values(:) !! of that
   contains
      procedure :: error_of
      procedure :: work_of
      procedure :: particles_of
      procedure :: fit
      procedure :: levels_for
      procedure :: learn
      procedure :: find_cheapest
   end type trials_t

   !> What a choice may not change, and not exceed.
   type :: limits_t
      logical :: has_lattice = .false., has_levels = .false. !! given ones
      real(dp) :: seconds = huge(1.0_dp)         !! of the processor [s]
      real(dp) :: bytes = huge(1.0_dp)           !! of memory
   end type limits_t

contains

   !> Predicted error of a mesh over that asked [-].
   pure real(dp) function error_of(self, mesh) result(error)
      class(trials_t), intent(in) :: self
      type(mesh_t), intent(in) :: mesh
      associate (h => real(self%first%lattice, dp)/mesh%lattice)
         error = self%of_cells*exp(self%order*log(h)) + self%of_tips*h*2.0_dp**(self%first%levels - mesh%levels)
      end associate
   end function error_of

   !> Material points of a mesh.
   pure real(dp) function particles_of(self, mesh) result(n)
      class(trials_t), intent(in) :: self
      type(mesh_t), intent(in) :: mesh
      associate (h => real(self%first%lattice, dp)/mesh%lattice)
         n = self%particles*(1/h)**ndim + self%of_level*merge(real(mesh%levels, dp), (2.0_dp**mesh%levels - 1)/h, ndim == 2)
      end associate
   end function particles_of

   !> Work of a mesh, in particles of an explicit step [-].
   pure real(dp) function work_of(self, mesh, rows) result(work)
      class(trials_t), intent(in) :: self
      type(mesh_t), intent(in) :: mesh
      real(dp), intent(in), optional :: rows     !! of the history, if not those of the run
      real(dp) :: n, h, measured
      h = real(self%first%lattice, dp)/mesh%lattice
      n = max(self%particles_of(mesh), 2.0_dp)
      select case (self%family%time)
       case ('static', 'modal')
         work = self%family%work*n*log(n)*merge(1.0_dp, n**(1/3.0_dp), ndim == 2)
       case ('explicit')
         work = self%family%work*n*self%steps/h*2.0_dp**mesh%levels
       case default
         work = self%family%work*n*self%steps/h
      end select
      measured = self%rows
      if (present(rows)) measured = rows
      work = work + of_row*n*measured
   end function work_of

   !> Levels with which the error of the first mesh is small enough where it is all of the cells at the tips.
   pure integer function levels_for(self, error, least) result(levels)
      class(trials_t), intent(in) :: self
      real(dp), intent(in) :: error              !! of that over the one asked [-]
      integer, intent(in) :: least               !! levels
      levels = least
      do while (error*2.0_dp**(self%first%levels - levels) > aim .and. levels < self%family%most_level)
         levels = levels + self%family%level_step
      end do
   end function levels_for

   !> Learn from a run that fell short: at rest on a finer lattice the order of the error away from the tips, else that all of it is
   !> larger.
   subroutine learn(self, error, mesh, factor)
      class(trials_t), intent(inout) :: self
      real(dp), intent(in) :: error              !! over that asked [-]
      type(mesh_t), intent(in) :: mesh           !! of the run
      real(dp), intent(in) :: factor             !! of the error over the predicted one [-]
      real(dp) :: order
      associate (h => real(self%first%lattice, dp)/mesh%lattice, &
                 of_tips => self%of_tips*2.0_dp**(self%first%levels - mesh%levels))
         if (h < 1 .and. error > of_tips*h) then
            order = log((error - of_tips*h)/self%of_cells)/log(h)
            if (order >= least_order .and. order < self%order) then
               self%order = order
               return
            end if
         end if
      end associate
      self%of_cells = factor*self%of_cells
      self%of_tips = factor*self%of_tips
   end subroutine learn

   !> Find the parts and the order of the error, and what a mesh costs, from the pilots.
   subroutine fit(trials, first, finer, deeper, finer_mesh, deeper_mesh)
      class(trials_t), intent(inout) :: trials
      type(pilot_t), intent(in) :: first, finer, deeper
      type(mesh_t), intent(in) :: finer_mesh, deeper_mesh !! of the others; that of the first one where there is no other
      real(dp) :: h, left, gained, whole, part
      real(dp) :: of_finer, of_deeper            ! what values differ by, over errors asked [-]
      real(dp) :: least, most                    ! order of the error away from the tips [-]
      integer :: levels
      trials%bytes = first%bytes
      h = real(trials%first%lattice, dp)/finer_mesh%lattice
      levels = deeper_mesh%levels - trials%first%levels
      trials%compared = finer_mesh
      trials%values = finer%values
      gained = first%error - deeper%error
      whole = first%error
      if (trials%compares) then                  ! errors of columns are not all there is
         of_deeper = worst_difference(first%values, deeper%values)
         of_finer = worst_difference(first%values, finer%values)
         whole = 0
         if (h < 1 .and. of_finer > 0) then
            whole = of_finer/(1 - h**order_of_differences)
            of_deeper = min(of_deeper, whole*(1 - worst_difference(deeper%values, finer%values)/of_finer)) ! towards the finer one
         end if
         if (trials%family%time == 'static') then ! columns do not tell what differs
            gained = max(gained, 0.0_dp) + max(of_deeper, 0.0_dp)
            whole = first%error + whole
         else
            gained = max(gained, of_deeper)
            if (trials%family%time == 'explicit' .and. .not. of_deeper > 0) gained = 0 ! levels hold waves of the cells
            whole = max(first%error, whole)
         end if
      end if
      trials%of_tips = 0
      if (levels > 0) trials%of_tips = min(max(0.0_dp, gained)/(1 - 2.0_dp**(-levels)), whole)
      part = 2.0_dp**(trials%first%levels - finer_mesh%levels)
      trials%of_cells = max(whole - trials%of_tips, least_part*whole)
      trials%order = merge(real(order_of_differences, dp), usual_order, trials%compares)
      if (h < 1 .and. .not. (trials%compares .and. whole > first%error)) then
         left = finer%error - trials%of_tips*h*part
         least = merge(real(order_of_differences, dp), least_order, trials%compares)
         most = merge(usual_order, most_order, trials%compares)
         trials%order = most
         if (left > 0) trials%order = min(max(log(left/trials%of_cells)/log(h), least), most)
      end if
      trials%of_level = max(deeper%particles - first%particles, 1.0_dp)/max(levels, 1)
      if (ndim == 2) trials%particles = max(1.0_dp, first%particles - trials%of_level*trials%first%levels)
      if (ndim == 3) then                        ! the first levels of coarse cells may fill all of a body: the most that any tells
         trials%particles = min(trials%in_box, first%particles)
         trials%of_level = max(1.0_dp, in_level(first, trials%first), in_level(deeper, deeper_mesh), in_level(finer, finer_mesh))
      end if
      trials%seconds = (first%seconds + finer%seconds + deeper%seconds)/ &
                       (trials%work_of(trials%first, first%rows) + trials%work_of(finer_mesh, finer%rows) + &
                        trials%work_of(deeper_mesh, deeper%rows))

   contains

      !> Particles that the first level of the first mesh of a solid adds, as those of a pilot tell.
      pure real(dp) function in_level(pilot, mesh) result(n)
         type(pilot_t), intent(in) :: pilot
         type(mesh_t), intent(in) :: mesh
         associate (h => real(trials%first%lattice, dp)/mesh%lattice)
            n = h*(pilot%particles - trials%particles*(1/h)**ndim)/max(2.0_dp**mesh%levels - 1, 1.0_dp)
         end associate
      end function in_level
   end subroutine fit

   !> The cheapest mesh of a family whose predicted error is small enough, or the one with the least error within the limits.
   subroutine find_cheapest(trials, limits, best, least_work, least_error)
      class(trials_t), intent(in) :: trials
      type(limits_t), intent(in) :: limits
      type(mesh_t), intent(out) :: best
      real(dp), intent(out) :: least_work, least_error !! of that; the error at least `aim`; huge where there is none
      type(mesh_t) :: mesh
      real(dp) :: work, error, most_work
      integer :: lattice, level
      most_work = huge(most_work)
      if (limits%seconds < huge(1.0_dp) .and. trials%seconds > 0) most_work = limits%seconds/trials%seconds
      call look(most_work)
      if (least_error > 1) call look(min(most_work, max(patience*trials%work_of(trials%first), cheap)))

   contains

      !> Look through all meshes within the limits.
      subroutine look(most_work)
         real(dp), intent(in) :: most_work
         least_work = huge(least_work)
         least_error = huge(least_error)
         do lattice = trials%first%lattice, trials%first%lattice*merge(1, most_lattice, limits%has_lattice)
            do level = trials%first%levels, merge(trials%first%levels, trials%family%most_level, limits%has_levels), &
                       trials%family%level_step
               mesh = mesh_t(lattice, level)
               work = trials%work_of(mesh)
               if (work > most_work .or. trials%particles_of(mesh) > most_particles) cycle
               if (trials%particles_of(mesh)*trials%bytes > limits%bytes) cycle
               error = max(trials%error_of(mesh), aim)
               if (.not. is_better(error, work, least_error, least_work)) cycle
               least_error = error
               least_work = work
               best = mesh
            end do
         end do
      end subroutine look
   end subroutine find_cheapest

   !> Whether a mesh is better than the best so far: by its error, or of the same error by its work.
   pure logical function is_better(error, work, least_error, least_work)
      real(dp), intent(in) :: error, work, least_error, least_work
      is_better = error < least_error .or. .not. error > least_error .and. work < least_work
   end function is_better
end module hampm_mesh_trials
