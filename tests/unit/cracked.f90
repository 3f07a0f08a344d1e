!> Rectangular bodies with a crack, under loads that act along a line, for the unit tests.
module hampm_cracked
   use hampm_kinds, only: dp, ndim
   use hampm_cracks, only: cracks_t, crack_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check
   use loading, only: load_on_points
   use hampm_loads, only: load_t
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_stiffness, only: stiffness_t, new_stiffness, full_loads
   implicit none
   private
   public :: build_cracked, add_pull, rest_of

contains

   !> A body with a crack, ready for a first step, with the nodes around the tips.
   subroutine build_cracked(forest, material, body, crack, m, cracks)
      type(forest_t), intent(in) :: forest
      type(material_t), intent(in) :: material
      type(rectangle_t), intent(in) :: body
      type(crack_t), intent(in) :: crack
      type(problem_t), intent(out) :: m
      type(cracks_t), intent(out) :: cracks
      type(failure_t) :: failure
      integer :: k
      cracks%crack = [crack]
      call cracks%list_tips()
      do k = 1, size(cracks%tips)
         cracks%tips(k)%material = 1
      end do
      call place_bodies(forest, material, [body], m, cracks%lines())
      m%interfaces%are_moving = .false.          ! faces that touch are as one, but for a layer that hardly gives way
      call start(m, 'musl')
      call cracks%find_nodes(m%grid, failure)
      call check(.not. failure%failed(), 'the tips have their nodes')
   end subroutine build_cracked

   !> Add a force that is spread evenly over a line.
   subroutine add_pull(m, from, to, force)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: from(ndim), to(ndim) !! ends of the line [m]
      real(dp), intent(in) :: force(ndim)        !! [N]
      integer, parameter :: parts = 64
      type(load_t), allocatable :: loads(:)
      real(dp) :: points(ndim, parts)
      integer :: i
      do i = 1, parts
         points(:, i) = from + (i - 0.5_dp)/parts*(to - from)
      end do
      allocate (loads(size(m%loads) + 1))
      loads(:size(m%loads)) = m%loads
      loads(size(loads))%force = force
      call load_on_points(m%matter_t, points, (to - from)/(2*parts), loads(size(loads)))
      call move_alloc(loads, m%loads)
   end subroutine add_pull

   !> Displacement at rest under all loads [m], (ndim, n_points), and the energy that is stored then [J]; faces in contact touch
   !> everywhere.
   subroutine rest_of(m, stiffness, u, energy)
      type(problem_t), intent(inout) :: m
      type(stiffness_t), intent(inout) :: stiffness
      real(dp), allocatable, intent(out) :: u(:, :)
      real(dp), intent(out) :: energy
      real(dp), allocatable :: force(:, :)
      logical :: done
      call full_loads(m, force)
      call new_stiffness(m, 1000000, stiffness, done)
      call check(done, 'there is a state of rest')
      call stiffness%solve(m, force, u)
      energy = sum(force*u)/2
   end subroutine rest_of
end module hampm_cracked
