!> Points that grow at rest, of tips and along fronts alike: G there over the toughness, and the energy that new faces take. Tips
!> come first, each a front of one point; then the points of each front (`hampm_front_values`).
module hampm_growth_points
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: finest_cell, take_toughness
   use hampm_crack_values, only: crack_values_t, best_rate, is_pressed
   use hampm_cracks, only: cracks_t
   use hampm_front_values, only: front_values_t, mean_rate
   use hampm_growing, only: growing_t, growing_point_t, next_t, part_of_crack, widths_of
   use hampm_model, only: model_t
   use hampm_problem, only: problem_t
   use hampm_tensors, only: norm
   use hampm_toughness, only: advance_t, direction_of
   implicit none
   private
   public :: next_of_points, book_fracture, book_rate, must_book

contains

   !> Next advance of each point, for a multiple of the present load and by other laws than the last ones if these are given; empty
   !> without a law, and at its end.
   pure function next_of_points(growing, model, cracks, values, fronts, factor, law) result(next)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:) !! of each tip
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in), optional :: factor   !! default: 1 [-]
      integer, intent(in), optional :: law(:)    !! numbers of &growth
      type(next_t) :: next(size(growing%points))
      type(advance_t) :: advance
      real(dp) :: times
      integer :: f, j, k, laws(size(next))
      times = 1
      if (present(factor)) times = factor
      laws = growing%points%law
      if (present(law)) laws = law
      next%is_there = laws > 0 .and. .not. growing%points%has_ended ! also of a point that has stopped
      do k = 1, size(values)
         if (.not. next(k)%is_there) cycle
         if (abs(times - 1) > 0) then
            next(k) = growing%next_of(model, cracks, k, model%growth(laws(k)), values(k)%times(times))
         else                                    ! without a copy of all that values keep
            next(k) = growing%next_of(model, cracks, k, model%growth(laws(k)), values(k))
         end if
      end do
      k = size(values)
      do f = 1, size(fronts)
         associate (front => fronts(f), along => fronts(f)%domain%front%along)
            do j = 1, size(front%arc)
               k = k + 1
               if (.not. next(k)%is_there) cycle
               advance = advance_t(speed=growing%points(k)%speed, &
                                   extension=growing%points(k)%extension + growing%points(k)%advance, &
                                   shear=front%of_g(2, j)**2/max(sum(front%of_g(:, j)**2), tiny(1.0_dp)), &
                                   angle=atan2(front%outward(along(2), j), front%outward(along(1), j)))
               call take_toughness(model, front%at(:, j) + growing%cells_ahead(k)*finest_cell(model)*front%outward(:, j), &
                                   front%at(:, j), advance)
               next(k) = next_t(is_there=.true., advance=advance, rate=max(0.0_dp, times**2*front%g(j)), &
                                intensity=times*front%of_g(:2, j), toughness=model%growth(laws(k))%toughness_at(advance))
               if (.not. growing%is_static) cycle
               if (.not. mean_rate(front) > front%mean_error) next(k)%hindrance = 2
               if (is_pressed(next(k)%intensity, abs(times)*front%k_error(1, j))) next(k)%hindrance = 1
               if (next(k)%hindrance == 2) next(k)%intensity = 0
            end do
         end associate
      end do
   end function next_of_points

   !> At rest: add the dissipation of new faces, the integral of G over their area.
   subroutine book_fracture(growing, model, cracks, values, fronts, m)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(front_values_t), intent(in) :: fronts(:)
      type(problem_t), intent(inout) :: m
      real(dp), parameter :: pi = acos(-1.0_dp)
      real(dp) :: taken, turn
      integer :: k
      do k = 1, size(values)                     ! a kink is 2 K_II/K_I, if that is small; between increments a path has half of it
         associate (point => growing%points(k), of => values(k))
            if (.not. (point%advance > 0 .and. cracks%tips(k)%is_measured() .and. of%errors%are_known)) cycle
            turn = 2*of%errors%intensity(2)%now/max(norm(of%intensity), tiny(turn))
            point%off_path = point%off_path + (point%advance*min(turn, 1.0_dp))**2
            turn = modulo(direction_of(cracks%tips(k)%axis(:, 1)) - point%heading + pi, 2*pi) - pi
            if (point%extension > 0) point%beside = point%beside + point%advance*turn/2
            point%heading = point%heading + turn
         end associate
      end do
      call integrate_rate(growing, model, cracks, values, fronts, growing%points%advance, taken)
      m%energies%fracture_energy = m%energies%fracture_energy + taken
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - taken
      where (growing%points%grows)
         growing%points%extension = growing%points%extension + growing%points%advance
         growing%points%advance = 0
      end where
   end subroutine book_fracture

   !> Whether the integral of G over the new area of tips is to go on from a step in motion: as a tip begins to move, with each cell
   !> it passes, and when it rests. So it does not depend on rows, between which explicit steps measure nothing else.
   pure logical function must_book(growing, cracks, start)
      type(growing_t), intent(in) :: growing
      type(cracks_t), intent(in) :: cracks
      real(dp), intent(in) :: start              !! of the step [s]
      associate (points => growing%points(:size(cracks%tips)), tips => cracks%tips)
         must_book = any(tips%grown > points%booked .and. &
                         (ceiling(tips%grown/tips%nodes%spacing) > ceiling(points%booked/tips%nodes%spacing) .or. &
                          points%last_motion <= start))
      end associate
   end function must_book

   !> In motion: add the integral of G over the new area of tips, for a row alone unless it is to go on from there.
   subroutine book_rate(growing, model, cracks, values, goes_on)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      logical, intent(in) :: goes_on
      type(front_values_t) :: fronts(0)
      type(growing_point_t), allocatable :: points(:)
      if (size(values) == 0) return
      points = growing%points
      call integrate_rate(growing, model, cracks, values, fronts, cracks%tips%grown - points%booked, growing%since_booked)
      if (goes_on) then
         growing%integral = growing%integral + growing%since_booked
         growing%since_booked = 0
         growing%points%booked = cracks%tips%grown
      else
         growing%points = points
      end if
   end subroutine book_rate

   !> The integral of G over the area of new faces: the mean of G times the length of front, before and after the advance. Both are
   !> kept for the next one.
   subroutine integrate_rate(growing, model, cracks, values, fronts, advance, taken)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: advance(:)         !! of each point [m]
      real(dp), intent(out) :: taken             !! [J]
      real(dp), dimension(size(advance)) :: rate, width
      real(dp) :: middle(ndim)
      integer :: f, k, n
      rate = growing%points%rate                 ! of points that are no longer measured
      width = 0
      do k = 1, size(values)
         if (.not. growing%points(k)%grows) cycle
         if (cracks%tips(k)%is_measured()) rate(k) = best_rate(values(k), cracks%tips(k))
         middle = cracks%tips(k)%now - advance(k)/2*cracks%tips(k)%direction
         width(k) = part_of_crack(cracks%tips(k))*model%run%thickness%at(middle)
         growing%points(k)%width = width(k)
      end do
      k = size(values)
      do f = 1, size(fronts)
         n = size(fronts(f)%arc)
         width(k + 1:k + n) = widths_of(fronts(f))
         where (.not. growing%points(k + 1:k + n)%has_ended) rate(k + 1:k + n) = fronts(f)%g
         k = k + n
      end do
      associate (points => growing%points)
         taken = sum(advance*(points%width*points%rate + width*rate)/2, mask=points%grows)
         where (points%grows)
            points%rate = rate
            points%width = width
         end where
      end associate
   end subroutine integrate_rate
end module hampm_growth_points
