!> Forces that faces in contact carry at rest without overlap and elastic sliding (`hampm_interface_points`), and what single points
!> of faces with friction are spared. The layer between them has the compliance of a third of a cell, which at rest would make a
!> crack whose faces stick a soft seam.
!>
!> Uzawa's method for the augmented Lagrangian: the layer carries the forces of the last balance, and they are balanced again. Each
!> point carries the mean traction of the cells around it. Slanted cuts have more points than openings of nodes: the tractions of
!> single points would alternate without limit, and friction would slide where they are low; these stay to the layer. Source: Simo
!> & Laursen, Comput. Struct. 42 (1992) 97-116.
!>
!> Friction slides where the mean tractions reach its cone: a point that is beyond it by more has that to spare. Where faces slide
!> nothing is left to spare after a few turns: a point gives back what its mean is beyond the cone, over its own part of the mean.
!> Source: Oden & Pires, J. Appl. Mech. 50 (1983) 67-76 (nonlocal law).
module hampm_carried_forces
   use hampm_kinds, only: dp, ndim
   use hampm_interface_points, only: interfaces_t, face_force, is_pressed, is_sliding, along_faces, length_along, &
                                     find_points
   use hampm_nearby, only: nearby_t
   use hampm_tensors, only: norm
   implicit none
   private
   public :: carry_forces

contains

   !> Let faces that press on each other carry their present tractions at rest; penalty ones, which hardly give way, carry none. In
   !> motion the layer bears them, and only the points that slide, or have something to spare, are renewed, within a step by more
   !> alone. `change` is the change over all forces, in the mean square, of what is carried and of what points that slide have to
   !> spare [-].
   pure subroutine carry_forces(interfaces, near, is_static, only_more, change)
      type(interfaces_t), intent(inout) :: interfaces
      type(nearby_t), intent(inout) :: near      !! table of their places, as in `find_points`
      logical, intent(in) :: is_static, only_more
      real(dp), intent(out) :: change
      real(dp), parameter :: reach = 1.5_dp      ! of a mean to either side [cells]
      real(dp) :: force(ndim, interfaces%n), mean(ndim), weight, area, spare, of_all
      logical :: carries(interfaces%n), slides
      integer, allocatable :: found(:)
      integer :: k, j
      change = 0
      of_all = tiny(of_all)
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            carries(k) = is_pressed(point) .and. .not. point%is_penalty
            if (.not. (carries(k) .or. only_more)) point%carried = 0
            if (.not. (carries(k) .or. only_more)) point%spare = 0
            if (.not. carries(k)) cycle
            force(:, k) = face_force(point)
            of_all = of_all + sum(force(:, k)**2)/point%stiffness
         end associate
      end do
      do k = 1, interfaces%n
         if (.not. carries(k)) cycle
         mean = 0
         area = 0
         associate (point => interfaces%list(k))
            slides = point%friction > 0 .and. is_sliding(point)
            if (.not. (is_static .or. slides .or. point%spare > 0)) cycle
            call find_points(interfaces, near, point%origin, 2*point%cell, found)
            do j = 1, size(found)
               associate (other => interfaces%list(found(j)))
                  if (.not. carries(found(j)) .or. other%line /= point%line) cycle
                  weight = 1 - norm(other%place - point%place)/(reach*max(point%cell, other%cell))
                  if (.not. weight > 0) cycle
                  mean = mean + weight*force(:, found(j))
                  area = area + weight*other%area
               end associate
            end do
            mean = point%area/(area*point%stiffness)*mean
            spare = 0
            if (point%friction > 0) spare = max(0.0_dp, excess(force(:, k)/point%stiffness) &
                                                         - excess(mean)*merge(area/point%area, 1.0_dp, excess(mean) > 0))
            if (only_more) spare = max(spare, point%spare)
            change = change + merge(point%stiffness*sum((mean - point%carried)**2), 0.0_dp, is_static)
            weight = point%stiffness*(spare - point%spare)**2
            point%spare = spare
            if (is_static .or. slides .or. is_sliding(point)) change = change + weight
            if (.not. is_static) cycle
            point%carried = mean
            point%slip = point%slid - along_faces(point, point%start)
         end associate
      end do
      change = sqrt(change/of_all)

   contains

      !> How far a force, over the stiffness, is beyond the cone of friction [m].
      pure real(dp) function excess(force)
         real(dp), intent(in) :: force(ndim)
         associate (point => interfaces%list(k))
            excess = length_along(along_faces(point, force)) + point%friction*dot_product(point%normal, force)
         end associate
      end function excess
   end subroutine carry_forces
end module hampm_carried_forces
