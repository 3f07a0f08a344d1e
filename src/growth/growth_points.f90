!> Points that grow at rest, of tips and along fronts alike: G there over the toughness, and the energy that new faces take. Tips
!> come first, each a front of one point; then the points of each front (`hampm_front_values`).
module hampm_growth_points
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: finest_cell, take_toughness
   use hampm_crack_values, only: crack_values_t, best_rate
   use hampm_cracks, only: cracks_t
   use hampm_front_values, only: front_values_t, mean_rate, parts_of
   use hampm_growing, only: growing_t, next_t, part_of_crack
   use hampm_model, only: model_t
   use hampm_problem, only: problem_t
   use hampm_toughness, only: advance_t
   implicit none
   private
   public :: next_of_points, ratios_of, book_fracture

contains

   !> Next advance of each point for a multiple of the present load; empty without a law, and at its end.
   pure function next_of_points(growing, model, cracks, values, fronts, factor) result(next)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:) !! of each tip
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in), optional :: factor   !! default: 1 [-]
      type(next_t) :: next(size(growing%tips))
      type(advance_t) :: advance
      real(dp) :: times
      integer :: f, j, k
      times = 1
      if (present(factor)) times = factor
      next%is_there = growing%tips%law > 0 .and. .not. growing%tips%has_ended ! also of a point that has stopped
      do k = 1, size(values)
         if (.not. next(k)%is_there) cycle
         next(k) = growing%next_of(model, cracks, k, model%growth(growing%tips(k)%law), values(k)%times(times))
      end do
      k = size(values)
      do f = 1, size(fronts)
         associate (front => fronts(f), along => fronts(f)%domain%front%along)
            do j = 1, size(front%arc)
               k = k + 1
               if (.not. next(k)%is_there) cycle
               advance = advance_t(extension=growing%tips(k)%extension + growing%tips(k)%advance, &
                                   shear=front%of_g(2, j)**2/max(sum(front%of_g(:, j)**2), tiny(1.0_dp)), &
                                   angle=atan2(front%outward(along(2), j), front%outward(along(1), j)))
               call take_toughness(model, front%at(:, j) + finest_cell(model)*front%outward(:, j), front%at(:, j), advance)
               next(k) = next_t(is_there=.true., rate=max(0.0_dp, times**2*front%g(j)), intensity=times*front%of_g(:2, j), &
                                toughness=model%growth(growing%tips(k)%law)%toughness_at(advance))
               if (.not. mean_rate(front) > front%mean_error) next(k)%hindrance = 2
               if (-times*front%of_g(1, j) > abs(times)*front%k_error(1, j)) next(k)%hindrance = 1
               if (next(k)%hindrance == 2) next(k)%intensity = 0
            end do
         end associate
      end do
   end function next_of_points

   !> G over the toughness of each growing point; 0 if hindered, or at any hindrance with `whatever`.
   pure function ratios_of(growing, model, cracks, values, fronts, whatever) result(ratios)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(front_values_t), intent(in) :: fronts(:)
      logical, intent(in) :: whatever
      real(dp), allocatable :: ratios(:)
      type(next_t) :: next(size(growing%tips))
      integer :: k
      next = next_of_points(growing, model, cracks, values, fronts)
      ratios = pack(merge(next%rate/max(next%toughness, tiny(1.0_dp)), 0.0_dp, whatever .or. next%hindrance == 0), &
                    [(growing%is_growing(k), k=1, size(next))])
   end function ratios_of

   !> Add the dissipation of new faces, the integral of G over their area: the mean of G times the length of front, before and after
   !> the advance. Both are kept for the next step.
   subroutine book_fracture(growing, model, cracks, values, fronts, m)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(front_values_t), intent(in) :: fronts(:)
      type(problem_t), intent(inout) :: m
      real(dp), dimension(size(growing%tips)) :: rate, width
      real(dp) :: middle(ndim), taken
      integer :: f, k, n
      rate = growing%tips%rate                   ! of points that have reached their end
      width = 0
      do k = 1, size(values)
         if (.not. growing%tips(k)%grows) cycle
         if (.not. cracks%tips(k)%has_ended) rate(k) = best_rate(values(k), cracks%tips(k))
         middle = cracks%tips(k)%now - growing%tips(k)%advance/2*cracks%tips(k)%direction
         width(k) = part_of_crack(cracks%tips(k))*model%run%thickness%at(middle)
         growing%tips(k)%width = width(k)
      end do
      k = size(values)
      do f = 1, size(fronts)
         n = size(fronts(f)%arc)
         associate (front => fronts(f)%domain%front)
            width(k + 1:k + n) = front%length*parts_of(fronts(f))*merge(0.5_dp, 1.0_dp, front%is_symmetry)
         end associate
         where (.not. growing%tips(k + 1:k + n)%has_ended) rate(k + 1:k + n) = fronts(f)%g
         k = k + n
      end do
      associate (points => growing%tips)
         taken = sum(points%advance*(points%width*points%rate + width*rate)/2, mask=points%grows)
         m%energies%fracture_energy = m%energies%fracture_energy + taken
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - taken
         where (points%grows)
            points%rate = rate
            points%width = width
            points%extension = points%extension + points%advance
            points%advance = 0
         end where
      end associate
   end subroutine book_fracture
end module hampm_growth_points
