!> What the model says of the surroundings of a crack that grows: it goes on with the crack, and tells how much room there is for a tip.
module hampm_growth_room
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: held_ahead, least_radius, distance_in_material, body_at
   use hampm_cracks, only: cracks_t
   use hampm_path_placement, only: room_around
   use hampm_model, only: model_t
   implicit none
   private
   public :: update_model_path, room_for, why_no_room

contains

   !> Let a crack of the model be where it is in the run.
   subroutine update_model_path(model, cracks, number)
      type(model_t), intent(inout) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      model%paths(number)%points = cracks%crack(number)%open_part()
   end subroutine update_model_path

   !> The largest radius of a domain integral around a tip that has come to a place [m]; 0 where there is none.
   pure real(dp) function room_for(model, crack, place) result(room)
      type(model_t), intent(in) :: model
      integer, intent(in) :: crack               !! its number
      real(dp), intent(in) :: place(ndim)        !! [m]
      room = room_around(model, place, crack)
      if (model%is_half()) room = min(room, held_ahead(model, place))
   end function room_for

   !> Why there is no room for a tip at a place.
   pure function why_no_room(model, place) result(why)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: place(ndim)        !! [m]
      character(:), allocatable :: why
      why = 'there is no room for a radius of the domain integral of two of the finest cells: a surface, a load, a constraint '// &
            'or another crack is near'
      if (.not. model%is_half() .or. body_at(model, place) == 0) return
      associate (held => held_ahead(model, place), material => distance_in_material(model, place, model%paths(1)%direction))
         if (held < min(least_radius(model), material)*(1 - 1e-9_dp)) &
            why = 'there is no &constraint that holds its symmetry plane ahead of it, over two of the finest cells at least'
      end associate
   end function why_no_room
end module hampm_growth_room
