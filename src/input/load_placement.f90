!> Where pressures act: the normal of an edge of a body, and the faces of cracks. For the checks of the input and for the assembly.
module hampm_load_placement
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: body_at
   use hampm_path_placement, only: path_tip, last_end
   use hampm_placement, only: tolerance, on_face
   use hampm_model, only: model_t, load_spec_t
   use hampm_tensors, only: quarter_turn
   implicit none
   private
   public :: is_on_faces, find_edge_normal, into_half

contains

   !> Whether a load is a pressure on the faces of a crack.
   elemental logical function is_on_faces(load)
      type(load_spec_t), intent(in) :: load
      is_on_faces = load%kind == 'pressure' .and. .not. load%has_place
   end function is_on_faces

   !> Unit vector out of the body whose edge a load is on. `sides` counts on which sides of the line there is such a body: 0 where it is on
   !> no edge, 2 where bodies touch there.
   pure subroutine find_edge_normal(model, load, normal, sides)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      real(dp), intent(out) :: normal(ndim)
      integer, intent(out) :: sides
      logical :: is_there(2)
      integer :: i, d
      real(dp) :: tol
      tol = tolerance(model%grid)
      normal = 0
      is_there = .false.
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            if (body%outline%is_there() .or. .not. on_face(load%lower, load%upper, body, tol)) cycle
            d = minloc(load%upper - load%lower, dim=1)
            normal = 0
            normal(d) = merge(1.0_dp, -1.0_dp, abs(load%upper(d) - body%upper(d)) <= tol)
            is_there(merge(1, 2, normal(d) > 0)) = .true.
         end associate
      end do
      sides = count(is_there)
   end subroutine find_edge_normal

   !> Unit vector from the line of a crack on a symmetry plane into the material.
   pure function into_half(model) result(normal)
      type(model_t), intent(in) :: model
      real(dp) :: normal(ndim), inward(ndim), tip(ndim)
      tip = path_tip(model%paths(1), last_end)
      normal = quarter_turn(model%paths(1)%direction)
      associate (body => model%bodies(body_at(model, tip)))
         inward = (body%lower + body%upper)/2 - tip
      end associate
      normal = sign(1.0_dp, dot_product(inward, normal))*normal
   end function into_half
end module hampm_load_placement
