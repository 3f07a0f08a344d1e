!> Offset of the effective tip behind its node in quadratic cells: the field around a node is of a slightly shorter crack, less so
!> the more exact the integration by particles. Measurements: docs/explanation/quadratic.md.
module hampm_quadratic_tip_offset
   use hampm_kinds, only: dp
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_problem, only: problem_t
   use hampm_quadratic_points, only: fewest_points
   implicit none
   private
   public :: quadratic_tip_offset

   ! In cells at the tip: base + by_stiffness x/(1 + x/stiff), x = lambda/mu of the plane, with three points a direction; its factor
   ! with three, four, five, six, and more
   real(dp), parameter :: base(modes) = [0.0535_dp, 0.0745_dp], by_stiffness(modes) = [0.0018_dp, 0.0092_dp], stiff = 42
   real(dp), parameter :: of_points(3:7) = [1.0_dp, 1.215_dp, 1.285_dp, 1.316_dp, 1.345_dp]

contains

   !> The tip offset in each mode [cells]; 0 where cells are bilinear.
   pure function quadratic_tip_offset(m, tip) result(tip_offset)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      real(dp) :: tip_offset(modes)
      real(dp) :: x
      integer :: n
      tip_offset = 0
      if (.not. m%grid%is_quadratic()) return
      associate (material => m%materials(tip%material))
         x = 1
         if (material%isotropic) x = material%small_strain_lambda()/material%mu
      end associate
      n = min(max(points_at(m, tip%nodes%tip), fewest_points), ubound(of_points, 1))
      tip_offset = of_points(n)*(base + by_stiffness*x/(1 + x/stiff))
   end function quadratic_tip_offset

   !> How many particles the cells at a node have in each direction.
   pure integer function points_at(m, node) result(n)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: node
      integer, allocatable :: around(:)
      integer :: k
      n = 0
      if (node == 0) return
      around = m%grid%dofs%elements_at(node)
      do k = 1, size(around)
         associate (first => m%grid%first_of_piece(around(k)), last => m%grid%last_of_piece(around(k)))
            n = max(n, nint(sqrt(real(sum(m%blocks%count_in(first:last)), dp))))
         end associate
      end do
   end function points_at
end module hampm_quadratic_tip_offset
