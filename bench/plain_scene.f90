!> The plain model that the benchmarks measure: a box filled with four particles a cell, plane stress, linear elastic, no loads.
module hampm_plain_scene
   use hampm_kinds, only: dp, ndim
   use hampm_assembly, only: assemble
   use hampm_body_group, only: body_t
   use hampm_cell_blocks, only: smallest_occupied_cell
   use hampm_cracks, only: cracks_t
   use hampm_failure, only: failure_t
   use hampm_problem, only: problem_t
   use hampm_indicator, only: refinement_t
   use hampm_model, only: model_t
   use hampm_critical_step, only: stable_time_step
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: plain_scene, soft_body, start, turn, time_step

contains

   !> A grid of `cells` x `cells` cells, filled by one body.
   pure function plain_scene(cells) result(model)
      integer, intent(in) :: cells
      type(model_t) :: model
      type(body_t) :: body
      real(dp), parameter :: cell = 1.0e-3_dp
      model%run%plane = 'stress'
      model%run%thickness = thickness_t(1.0_dp)
      model%grid%cell = cell
      model%grid%cells = cells
      model%method%scheme = 'musl'
      model%method%frame = 'updated'
      allocate (model%materials(1), model%constraints(0), model%loads(0), model%paths(0), model%planes(0), model%growth(0), &
                model%cohesive(0), model%nucleations(0), &
                model%energy_release%chosen(0))
      model%materials(1)%law = 'linear_elastic'
      model%materials(1)%young = 70e9_dp
      model%materials(1)%poisson = 0.3_dp
      model%materials(1)%density = 2700
      body%material_index = 1
      body%upper = cells*cell
      body%points_per_cell = 2
      allocate (model%bodies(1), source=body)
   end function plain_scene

   !> A softer body, of 5/8 of the length of a grid of `cells` x `cells` cells, which has room to turn and fly.
   pure function soft_body(cells) result(model)
      integer, intent(in) :: cells
      type(model_t) :: model
      model = plain_scene(cells)
      model%materials(1)%young = 70e6_dp
      model%bodies(1)%lower = cells/8*model%grid%cell
      model%bodies(1)%upper = 3*cells/4*model%grid%cell
   end function soft_body

   !> Let a soft body turn and fly: 2.4 % of its particles change their cell in each step.
   subroutine turn(problem)
      type(problem_t), intent(inout) :: problem
      integer :: i
      associate (p => problem%particles, centre => 0.4375_dp*problem%grid%forest%cells(1)*problem%grid%forest%cell)
         do i = 1, p%n
            p%velocity(i, :) = p%velocity(i, :) + [3.0_dp, 2.0_dp] &
                               + 300*[centre - p%reference(i, 2), p%reference(i, 1) - centre]
         end do
      end associate
   end subroutine turn

   !> Build a model and set it into a smooth small motion.
   subroutine start(model, problem)
      type(model_t), intent(in) :: model
      type(problem_t), intent(out) :: problem
      type(cracks_t) :: cracks
      type(refinement_t) :: refinement
      type(failure_t) :: failure
      call assemble(model, problem, cracks, refinement, failure)
      if (failure%failed()) error stop 'the benchmark scene cannot be built'
      problem%particles%velocity = 1.0e-3_dp*sin(200*problem%particles%reference)
   end subroutine start

   !> A tenth of what a shear wave takes to cross a cell [s].
   pure real(dp) function time_step(problem)
      type(problem_t), intent(in) :: problem
      time_step = stable_time_step(smallest_occupied_cell(problem%grid, problem%blocks), problem%materials, 0.1_dp, 'shear')
   end function time_step
end module hampm_plain_scene
