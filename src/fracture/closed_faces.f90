!> Tractions on the crack faces behind a closed tip (docs/explanation/crack_contact.md has theory and measurements).
!>
!> The layer of interface points between faces (`hampm_interface_points`) is compliant, the material ahead of a tip is not:
!> tractions in the last cells oscillate, which shifts K_II at any cell size. A tip is closed if the faces of some cells behind it
!> overlap in the mean; the traction there, a line in the distance from the tip, is extrapolated to it by weighted least squares
!> over half of the pressed faces, with weights that fall to 0 at both ends. Stiff faces between whole cells have no oscillation:
!> there the tractions of the cell at the tip count. Sticking faces are no crack: K_II is at most that of the sliding behind the tip
!> (`largest_intensity`), 0 without any; the sliding of each point is kept through changes of the mesh, apart from the compliance of
!> the layer.
!>
!> Where the layer across the faces gives way this is no opening of the crack: J omits the work of the pressure in it
!> (`work_at_tip`). With it J of a split beam pressed together by 50 kPa is 2.9 times K_II**2/E'.
module hampm_closed_faces
   use hampm_kinds, only: dp, ndim
   use hampm_interface_points, only: interfaces_t, interface_point_t, contact, force_of, is_pressed, slid_in_all
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: closed_faces_t, sample_behind_tip

   real(dp), parameter :: replaced = 5           !! cells behind the tip whose own tractions are not used
   real(dp), parameter :: from = 2, to = 16      !! cells behind the tip of the fit, at the end or half of the closed faces
   real(dp), parameter :: sampled = 8            !! and for the decision whether the tip is closed
   real(dp), parameter :: least = 1 - 1e-6_dp    !! least cells of faces for any result; on grid lines whole numbers
   real(dp), parameter :: for_line = 4 - 1e-6_dp !! and for a line instead of a mean

   !> Tractions behind a tip.
   type :: closed_faces_t
      logical :: are_closed = .false.            !! whether the tip is pressed shut
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector out of the crack
      real(dp) :: cell = 0                       !! size of the cells at the tip [m]
      real(dp) :: normal(ndim) = 0               !! of the line of the faces
      real(dp) :: mean(ndim) = 0                 !! force against separation of the faces, over their length [N/m]
      real(dp) :: slope(ndim) = 0                !! its change with the distance behind the tip [N/m2]
      real(dp) :: middle = 0                     !! distance at which it is the mean [m]
      real(dp) :: compliance = 0                 !! of the layer, overlap of the faces for a force over their length [m2/N]
      real(dp) :: swing(ndim) = 0                !! deviation of tractions from the line, along the direction and across [N]
      real(dp) :: sliding = 0                    !! largest sliding of faces behind the tip over the root of their distance [m**0.5]
      real(dp) :: uncertainty_of_mean(ndim) = 0  !! of the mean by that [N/m]
      real(dp) :: uncertainty_of_slope(ndim) = 0 !! [N/m2]
   contains
      procedure :: has
      procedure :: slope_across
      procedure :: work_at_tip
      procedure :: traction_at
      procedure :: uncertainty_at
      procedure :: largest_intensity
      procedure :: distance_of
   end type closed_faces_t

contains

   !> Sample the faces behind a tip.
   pure function sample_behind_tip(interfaces, tip, direction, cell) result(faces)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: tip(ndim)          !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack
      real(dp), intent(in) :: cell               !! size of the cells at the tip [m]
      type(closed_faces_t) :: faces
      real(dp) :: r, length, there, parted, last, weight, square, stiffness, carried, moved
      real(dp), parameter :: rounding = 1e-9_dp  ! part of what faces move: overlap that presses nothing
      integer :: n
      faces = closed_faces_t(tip=tip, direction=direction, cell=cell)
      length = 0
      there = 0
      parted = 0
      stiffness = 0
      carried = 0
      moved = 0
      do n = 1, interfaces%n
         r = faces%distance_of(interfaces%list(n))
         if (r > 0 .and. r <= sampled*cell) faces%sliding = max(faces%sliding, norm(slid_in_all(interfaces%list(n)))/sqrt(r))
         if (r > 0 .and. is_pressed(interfaces%list(n))) length = length + interfaces%list(n)%length
         if (r < merge(0.0_dp, from*cell, interfaces%list(n)%is_penalty)) cycle
         if (r > merge(1.0_dp, sampled, interfaces%list(n)%is_penalty)*cell) cycle
         there = there + interfaces%list(n)%length
         faces%normal = interfaces%list(n)%normal
         stiffness = stiffness + interfaces%list(n)%stiffness
         parted = parted + interfaces%list(n)%length*dot_product(interfaces%list(n)%normal, interfaces%list(n)%opening)
         carried = carried + interfaces%list(n)%length*dot_product(interfaces%list(n)%normal, interfaces%list(n)%carried)
         moved = moved + interfaces%list(n)%length*norm(interfaces%list(n)%opening + interfaces%list(n)%carried)
      end do
      if (there < least*cell .or. .not. parted + carried < -rounding*moved) return
      faces%are_closed = .true.
      faces%compliance = there/stiffness*min(1.0_dp, max(0.0_dp, parted/(parted + carried)))
      last = max(sampled*cell, min(to*cell, length), length/2)
      length = 0
      square = 0
      do n = 1, interfaces%n
         r = faces%distance_of(interfaces%list(n))
         if (r < from*cell .or. r > last) cycle
         weight = r*(last - r)
         length = length + weight*interfaces%list(n)%length
         faces%middle = faces%middle + weight*r*interfaces%list(n)%length
         square = square + weight*r**2*interfaces%list(n)%length
         faces%mean = faces%mean + weight*force_of(interfaces%list(n))
         faces%slope = faces%slope + weight*r*force_of(interfaces%list(n))
      end do
      if (.not. length > 0) then                 ! the faces end before: no result
         faces%are_closed = .false.
         return
      end if
      faces%mean = faces%mean/length
      faces%middle = faces%middle/length
      faces%slope = merge(faces%slope - length*faces%middle*faces%mean, 0.0_dp, there >= for_line*cell) &
                    /max(square - length*faces%middle**2, tiny(square))
      call find_uncertainties(faces, interfaces, last, length, max(square - length*faces%middle**2, length*cell**2))
   end function sample_behind_tip

   !> 95 % uncertainty of the line. R = int (t - line) dr of the tractions t oscillates about a mean with a deviation s. By parts, a
   !> mean with weights w has the error int w' R dr/int w dr; as R is independent in each cell of size h this is s sqrt(h int w'**2
   !> dr)/int w dr. The slope is a mean with w times the distance from the middle, over its mean square. The line cuts R anywhere at
   !> its beginning. Deviations of few cells, less two for the line, are those of Student's distribution.
   pure subroutine find_uncertainties(faces, interfaces, last, length, square)
      type(closed_faces_t), intent(inout) :: faces
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: last               !! distance up to which the line is fitted [m]
      real(dp), intent(in) :: length, square     !! sums of the weights and of them by the square of the distance from the middle
      real(dp), dimension(ndim) :: off, bears, mean, squares, wave
      real(dp) :: r, way
      integer :: n
      way = 0
      bears = 0
      mean = 0
      squares = 0
      wave = 0
      do n = 1, interfaces%n
         r = faces%distance_of(interfaces%list(n))
         if (r < from*faces%cell .or. r > last) cycle
         associate (l => interfaces%list(n)%length, d => faces%direction)
            off = force_of(interfaces%list(n)) - l*faces%traction_at(r)
            off = in_plane(dot_product(off, d), d(1)*off(2) - d(2)*off(1))/2
            bears = bears + off                  ! up to the middle of the point: alike from either end
            way = way + l
            mean = mean + l*bears
            squares = squares + l*bears**2
            bears = bears + off
            wave = wave + l*in_plane(last - 2*r, r*(last - r) + (last - 2*r)*(r - faces%middle))**2
         end associate
      end do
      associate (cells => max(way/faces%cell, 3.0_dp))
         faces%swing = (2 + 3/(cells - 2))*sqrt(cells/(cells - 2)*max(squares/way - (mean/way)**2, 0.0_dp))
      end associate
      faces%uncertainty_of_mean = faces%swing*sqrt(faces%cell*wave(1))/length
      faces%uncertainty_of_slope = faces%swing*sqrt(faces%cell*wave(2))/square
   end subroutine find_uncertainties

   !> Distance of an interface point on the faces behind the tip; below 0 for all others [m].
   pure real(dp) function distance_of(self, point) result(r)
      class(closed_faces_t), intent(in) :: self
      type(interface_point_t), intent(in) :: point
      real(dp), parameter :: beside = 1e-3_dp    ! of a cell, and of a right angle
      r = -1
      if (point%law /= contact) return
      associate (way => self%tip - point%place, d => self%direction)
         if (abs(dot_product(point%normal, d)) > beside .or. abs(way(1)*d(2) - way(2)*d(1)) > beside*self%cell) return
         r = dot_product(way, d)
      end associate
   end function distance_of

   !> Whether the extrapolated traction replaces that of an interface point.
   pure logical function has(self, point)
      class(closed_faces_t), intent(in) :: self
      type(interface_point_t), intent(in) :: point
      has = .false.
      if (.not. self%are_closed) return
      associate (r => self%distance_of(point))
         has = r > 0 .and. r < replaced*self%cell
      end associate
   end function has

   !> Change of the opening of the layer along the crack for that traction [-].
   pure function slope_across(self) result(slope)
      class(closed_faces_t), intent(in) :: self
      real(dp) :: slope(ndim)
      associate (normal => quarter_turn(self%direction))
         slope = -self%compliance*dot_product(self%slope, normal)*normal
      end associate
   end function slope_across

   !> Work of that traction on the closing of the layer at the tip [N].
   pure real(dp) function work_at_tip(self) result(work)
      class(closed_faces_t), intent(in) :: self
      work = 0
      if (.not. self%are_closed) return
      associate (normal => quarter_turn(self%direction))
         work = -self%compliance*dot_product(self%mean - self%slope*self%middle, normal)**2
      end associate
   end function work_at_tip

   !> That traction, the force over the length [N/m].
   pure function traction_at(self, distance) result(traction)
      class(closed_faces_t), intent(in) :: self
      real(dp), intent(in) :: distance           !! behind the tip [m]
      real(dp) :: traction(ndim)
      traction = self%mean + self%slope*(distance - self%middle)
   end function traction_at

   !> The largest K_II for the sliding of the faces, 8 K_II/E' sqrt(r/(2 pi)) at the distance r [Pa sqrt(m)]. The compliance of the
   !> layer, where friction holds faces, does not count, whatever their tractions.
   pure real(dp) function largest_intensity(self, modulus)
      class(closed_faces_t), intent(in) :: self
      real(dp), intent(in) :: modulus            !! E' [Pa]
      real(dp), parameter :: pi = acos(-1.0_dp)
      real(dp), parameter :: beyond = 2          ! factor of too little sliding of cells at a tip
      largest_intensity = beyond*modulus/8*sqrt(2*pi)*self%sliding
   end function largest_intensity

   !> 95 % uncertainty of the line at a place, along the direction and across it [N/m].
   pure function uncertainty_at(self, distance) result(uncertainty)
      class(closed_faces_t), intent(in) :: self
      real(dp), intent(in) :: distance           !! behind the tip [m]
      real(dp) :: uncertainty(ndim)
      uncertainty = sqrt(self%uncertainty_of_mean**2 + (self%uncertainty_of_slope*(distance - self%middle))**2 &
                         + (self%swing/(2*replaced*self%cell))**2)
   end function uncertainty_at
end module hampm_closed_faces
