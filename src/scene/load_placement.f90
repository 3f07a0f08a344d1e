!> Where pressures act: the normal of an edge of a body, and the faces of cracks. For the checks of the input and for the assembly.
module hampm_load_placement
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: distance_to_mouth, has_two_tips, body_at
   use hampm_placement, only: tolerance, on_face
   use hampm_scene, only: scene_t, load_spec_t
   implicit none
   private
   public :: is_on_faces, find_edge_normal, pressed_path, face_start, into_faces

contains

   !> Whether a load is a pressure on the faces of a crack.
   elemental logical function is_on_faces(load)
      type(load_spec_t), intent(in) :: load
      is_on_faces = load%kind == 'pressure' .and. .not. load%has_place
   end function is_on_faces

   !> Unit vector out of the body whose edge a load is on. `sides` counts on which sides of the line there is such a body: 0 where it is on
   !> no edge, 2 where bodies touch there.
   pure subroutine find_edge_normal(scene, load, normal, sides)
      type(scene_t), intent(in) :: scene
      type(load_spec_t), intent(in) :: load
      real(dp), intent(out) :: normal(ndim)
      integer, intent(out) :: sides
      logical :: is_there(2)
      integer :: i, d
      real(dp) :: tol
      tol = tolerance(scene%grid)
      normal = 0
      is_there = .false.
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            if (body%outline%is_there() .or. .not. on_face(load%lower, load%upper, body, tol)) cycle
            d = minloc(load%upper - load%lower, dim=1)
            normal = 0
            normal(d) = merge(1.0_dp, -1.0_dp, abs(load%upper(d) - body%upper(d)) <= tol)
            is_there(merge(1, 2, normal(d) > 0)) = .true.
         end associate
      end do
      sides = count(is_there)
   end subroutine find_edge_normal

   !> Number of the path that a pressure is on: that of its name, or the only one; 0 for none.
   pure integer function pressed_path(scene, load) result(path)
      type(scene_t), intent(in) :: scene
      type(load_spec_t), intent(in) :: load
      integer :: k
      path = merge(1, 0, load%crack == '' .and. size(scene%paths) == 1)
      do k = 1, size(scene%paths)
         if (load%crack /= '' .and. scene%paths(k)%name == load%crack) path = k
      end do
   end function pressed_path

   !> Where the faces of a crack along a grid line begin: at its mouth or its other tip [m].
   pure function face_start(scene) result(x)
      type(scene_t), intent(in) :: scene
      real(dp) :: x(ndim)
      associate (spec => scene%crack)
         x = spec%tip - merge(spec%length, distance_to_mouth(scene), has_two_tips(scene))*spec%direction
      end associate
   end function face_start

   !> Unit vectors from the line of such a crack into the material at each of its faces, (ndim, faces): on a symmetry plane one is modelled.
   pure function into_faces(scene) result(normals)
      type(scene_t), intent(in) :: scene
      real(dp), allocatable :: normals(:, :)
      real(dp) :: left(ndim), inward(ndim)
      associate (spec => scene%crack)
         left = [-spec%direction(2), spec%direction(1)]
         if (spec%kind == 'line') then
            normals = reshape([left, -left], [ndim, 2])
         else
            associate (body => scene%bodies(body_at(scene, spec%tip)))
               inward = (body%lower + body%upper)/2 - spec%tip
            end associate
            normals = reshape(sign(1.0_dp, dot_product(inward, left))*left, [ndim, 1])
         end if
      end associate
   end function into_faces
end module hampm_load_placement
