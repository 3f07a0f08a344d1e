!> Placement of pressures: the normal of an edge of a body, and the faces of cracks. For checks of the input and the assembly.
module hampm_load_placement
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: body_at
   use hampm_crack_lines, only: last_point
   use hampm_path_placement, only: path_tip
   use hampm_placement, only: tolerance
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

   !> Unit vector out of the bodies whose edge carries a load, one or several in a row. `sides`: number of sides of the line with
   !> such bodies; 0 on no edge, 2 between touching bodies.
   pure subroutine find_edge_normal(model, load, normal, sides)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      real(dp), intent(out) :: normal(ndim)
      integer, intent(out) :: sides
      real(dp) :: covered(2), extent(ndim), common(ndim), tol ! area by bodies above and below
      integer :: i, d
      tol = tolerance(model%grid)
      normal = 0
      sides = 0
      extent = load%upper - load%lower
      if (count(extent <= tol) /= 1) return
      d = minloc(extent, dim=1)
      extent(d) = 1
      covered = 0
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            if (body%outline%is_there()) cycle
            common = max(min(load%upper, body%upper) - max(load%lower, body%lower), 0.0_dp)
            common(d) = 1
            where (abs([body%lower(d), body%upper(d)] - load%upper(d)) <= tol) covered = covered + product(common)
         end associate
      end do
      associate (is_there => covered >= product(extent)*(1 - 2*size(model%bodies)*tol/minval(extent)))
         sides = count(is_there)
         if (sides > 0) normal(d) = merge(1.0_dp, -1.0_dp, is_there(2))
      end associate
   end subroutine find_edge_normal

   !> Unit vector from the line of a crack on a symmetry plane into the material.
   pure function into_half(model) result(normal)
      type(model_t), intent(in) :: model
      real(dp) :: normal(ndim), inward(ndim), tip(ndim)
      tip = path_tip(model%paths(1), last_point)
      normal = quarter_turn(model%paths(1)%direction)
      associate (body => model%bodies(body_at(model, tip)))
         inward = (body%lower + body%upper)/2 - tip
      end associate
      normal = sign(1.0_dp, dot_product(inward, normal))*normal
   end function into_half
end module hampm_load_placement
