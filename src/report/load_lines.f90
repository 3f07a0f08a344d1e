!> The load line of a test: a load or the reaction of a constraint, and the displacement on which it does its work.
!>
!> The force of a load goes to the nodes by its parts and by shape functions: its work is the work of its resultant on the mean of
!> the displacements of its points, by the same parts and functions. Force and displacement are a work-conjugate pair: in an elastic
!> body the area below their curve is the strain energy.
module hampm_load_lines
   use hampm_kinds, only: dp, ndim, corners
   use hampm_domains, only: edges_of_domain, weights_in_domain
   use hampm_load_sharing, only: share_by_cell
   use hampm_loads, only: load_t
   use hampm_patch, only: patch_t, patch_around, fitted_displacement
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: find_load_line

contains

   !> Force on the body and displacement of the k-th load of the model or, where that is 0, of a constraint; components that the
   !> constraint does not hold have none.
   subroutine find_load_line(problem, k, constraint, reactions, force, displacement)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: k                   !! 0: the constraint is meant
      integer, intent(in) :: constraint
      real(dp), intent(in) :: reactions(:, :)    !! of the constraints [N]
      real(dp), intent(out) :: force(ndim)       !! [N]
      real(dp), intent(out) :: displacement(ndim) !! [m]
      integer :: i
      if (k == 0) then
         force = reactions(:, constraint)
         displacement = problem%constraints%prescribed_of_box(constraint, problem%state%time)
      else
         i = findloc(problem%loads%number, k, dim=1)
         force = problem%loads(i)%history%factor(problem%state%time)*problem%loads(i)%force
         call find_displacement(problem, problem%loads(i), displacement)
      end if
   end subroutine find_load_line

   !> The mean displacement of the points of a load, by their parts of it [m].
   subroutine find_displacement(problem, load, u)
      type(problem_t), intent(in) :: problem
      type(load_t), intent(in) :: load
      real(dp), intent(out) :: u(ndim)
      integer :: node(problem%grid%n_functions)
      real(dp) :: shape(problem%grid%n_functions)
      integer, allocatable :: nodes(:)
      real(dp), allocatable :: parts(:)          ! of the load that nodes take
      type(patch_t) :: patch
      integer :: k, c, at
      allocate (nodes(0), parts(0))
      u = 0
      associate (p => problem%particles, grid => problem%grid)
         do k = 1, size(load%particle)
            associate (i => load%particle(k))
               if (load%by_mass) then
                  u = u + load%fraction(k)*(p%displacement(i, :) + matmul(p%gradient_of(i), load%offset(:, k)))
               else if (allocated(p%corner_displacement)) then
                  u = u + load%fraction(k)*matmul(reshape(p%corner_displacement(i, :, :), [ndim, corners]), &
                                                  weights_in_domain(load%offset(:, k), edges_of_domain(p, i)))
               else
                  call share_by_cell(p, grid, i, load%offset(:, k), load%half(:, k), .false., node, shape)
                  do c = 1, size(node)
                     at = findloc(nodes, node(c), dim=1)
                     if (at == 0) then
                        nodes = [nodes, node(c)]
                        parts = [parts, 0.0_dp]
                        at = size(nodes)
                     end if
                     parts(at) = parts(at) + load%fraction(k)*shape(c)
                  end do
               end if
            end associate
         end do
         do k = 1, size(nodes)
            if (.not. abs(parts(k)) > 0) cycle
            call patch_around(grid, p, problem%blocks, nodes(k), patch)
            u = u + parts(k)*fitted_displacement(patch, p)
         end do
      end associate
   end subroutine find_displacement
end module hampm_load_lines
