!> Records of the probes of a model: of material points and lines, of cracks, of loads.
!>
!> Values belong to the instant, from the particles alone; no state is kept from sample to sample.
module hampm_probes
   use hampm_kinds, only: dp, ndim, plane
   use hampm_crack_lines, only: left_face, right_face, both_faces
   use hampm_crack_lines, only: segment_at
   use hampm_crack_placement, only: body_at
   use hampm_crack_tip, only: frame_along
   use hampm_crack_tip_field, only: modes
   use hampm_cracks, only: cracks_t
   use hampm_history, only: history_t
   use hampm_load_lines, only: find_load_line
   use hampm_model, only: model_t, probe_t, path_of
   use hampm_openings, only: in_modes
   use hampm_point_values, only: view_t, surroundings_t, new_view, look_around, weights_of, weights_of_cells, &
                                   quadratic_fit
   use hampm_problem, only: problem_t
   use hampm_tensors, only: norm, in_plane, quarter_turn, n_symmetric, components_of, space
   implicit none
   private
   public :: record_probes, add_means

   character(2), parameter :: of_both(10) = ['xx', 'yy', 'xy', 'zz', 'xx', 'yy', 'xy', 'xz', 'yz', 'zz'] ! of a plane and of space
   character(2), parameter :: components(n_symmetric) = of_both(4*ndim - 7:6*ndim - 8)

contains

   !> Record all of them.
   subroutine record_probes(model, problem, cracks, joined, reactions, history)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: joined(:)           !! by body, which of them are one
      real(dp), intent(in) :: reactions(:, :)    !! of the constraints [N], (ndim, constraints)
      type(history_t), intent(inout) :: history
      integer :: k
      do k = 1, size(model%probes)
         associate (probe => model%probes(k))
            if (size(probe%at, 2) > 0) call record_place(problem, cracks, joined, probe, history)
            if (probe%gives('opening') .or. probe%gives('volume')) &
               call record_crack(model, problem, cracks, joined, probe, history)
            if (probe%gives('load_line')) call record_load(model, problem, probe, reactions, history)
         end associate
      end do
   end subroutine record_probes

   !> Record the quantities asked for at a point, or their mean along a line.
   subroutine record_place(problem, cracks, joined, probe, history)
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: joined(:)           !! by body, which of them are one
      type(probe_t), intent(in) :: probe
      type(history_t), intent(inout) :: history
      integer, parameter :: points_in_cell = 2, most_points = 200
      type(surroundings_t) :: around
      type(view_t) :: view
      real(dp) :: strain(n_symmetric), stress(n_symmetric), u(ndim), v(ndim), along, toward(ndim)
      integer :: n, k, ends
      character(:), allocatable :: of, name
      name = trim(probe%name)
      of = ' of '//name
      call new_view(problem%matter_t, cracks, joined, minval(probe%at, dim=2), maxval(probe%at, dim=2), view)
      n = 1
      toward = 0
      if (size(probe%at, 2) == 1) then
         toward = toward_face(cracks, probe, problem%grid%forest%tolerance())
      else
         associate (way => norm(probe%at(:, 2) - probe%at(:, 1)))
            n = min(most_points, max(2, ceiling(points_in_cell*way/problem%grid%finest_cell)))
         end associate
      end if
      strain = 0
      stress = 0
      u = 0
      v = 0
      along = 0
      ends = size(probe%at, 2)
      associate (first => probe%at(:, 1), last => probe%at(:, ends))
         if (n > 1 .and. probe%gives('strain')) along = elongation(problem, view, probe%at)
         if (n == 1 .or. any(probe%quantity /= 'strain' .and. probe%quantity /= '')) then
            do k = 1, n
               call look_around(problem%matter_t, view, first + (k - 0.5_dp)/n*(last - first), toward, around)
               call add_means(problem, around, 1.0_dp/n, u, v, strain, stress)
            end do
         end if
      end associate
      if (probe%gives('displacement')) call history%record_vector('displacement_'//name, 'm', 'displacement'//of, u)
      if (probe%gives('velocity')) call history%record_vector('velocity_'//name, 'm/s', 'velocity'//of, v)
      if (probe%gives('strain') .and. n > 1) call history%record('strain_'//name, '1', 'mean strain along the line'//of, along)
      do k = 1, merge(n_symmetric, 3, problem%particles%thickness%is_ring .or. ndim > 2)
         if (probe%gives('strain') .and. n == 1) &
            call history%record('strain_'//name//'_'//components(k), '1', 'strain'//of//', '//components(k), strain(k))
      end do
      do k = 1, merge(3, n_symmetric, problem%materials(1)%plane_stress)
         if (probe%gives('stress')) &
            call history%record('stress_'//name//'_'//components(k), 'Pa', 'stress'//of//', '//components(k), stress(k))
      end do
   end subroutine record_place

   !> Unit vector to the material of the face that a point on a crack is on; 0 for other points.
   pure function toward_face(cracks, probe, tolerance) result(toward)
      type(cracks_t), intent(in) :: cracks
      type(probe_t), intent(in) :: probe
      real(dp), intent(in) :: tolerance          !! distance below which places are the same [m]
      real(dp) :: toward(ndim)
      real(dp), allocatable :: points(:, :)
      integer :: c, k
      toward = 0
      if (probe%face == 'none') return
      do c = 1, size(cracks%crack)
         points = cracks%crack(c)%points
         if (cracks%crack(c)%grows) points = cracks%crack(c)%open_part()
         k = segment_at(points, probe%at(:, 1), probe%at(:, 1), tolerance)
         if (k == 0) cycle                       ! it may not be there yet
         toward = left_of(points(:, k - 1), points(:, k))*merge(-1, 1, probe%face == 'right')
         return
      end do
   end function toward_face

   !> Unit vector to the left of a segment.
   pure function left_of(from, to) result(normal)
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      real(dp) :: normal(ndim)
      normal = quarter_turn(to - from)/norm(to - from)
   end function left_of

   !> Add parts of the means of the particles around a point: displacement, velocity, and the components of strain and stress. The
   !> strain is the symmetric part of the displacement gradient or, of laws for any rotation, Green and Lagrange's; the stress is
   !> Kirchhoff's, as in snapshots.
   pure subroutine add_means(problem, around, part, u, v, strain, stress)
      type(problem_t), intent(in) :: problem
      type(surroundings_t), intent(in) :: around
      real(dp), intent(in) :: part
      real(dp), intent(inout) :: u(ndim), v(ndim) !! [m], [m/s]
      real(dp), intent(inout) :: strain(n_symmetric), stress(n_symmetric) !! [-], [Pa]
      real(dp), allocatable :: weights(:)
      real(dp) :: h(ndim, ndim), t(ndim, ndim), hoop, hoop_stress
      integer :: k
      associate (p => problem%particles)
         allocate (weights, source=weights_of(around, quadratic_fit))
         u = u + part*matmul(weights, p%displacement(around%particle, :))
         v = v + part*matmul(weights, p%velocity(around%particle, :))
         weights = part*weights_of_cells(problem%matter_t, around)
         do k = 1, size(weights)
            associate (i => around%particle(k), material => problem%materials(p%material(around%particle(k))))
               h = p%gradient_of(i)
               hoop = p%hoop_of(i)
               t = material%kirchhoff_stress(h, p%history_of(i), hoop)
               hoop_stress = 0
               if (ndim == plane) hoop_stress = (1 + merge(hoop, 0.0_dp, material%is_finite)) &
                                                *material%hoop_stress(h, p%history_of(i), hoop)
               if (material%is_finite) then
                  h = h + matmul(transpose(h), h)/2
                  hoop = hoop + hoop**2/2
               end if
               strain = strain + weights(k)*components_in_space((h + transpose(h))/2, hoop)
               stress = stress + weights(k)*components_in_space(t, hoop_stress)
            end associate
         end do
      end associate
   end subroutine add_means

   !> Components of a symmetric tensor of the model, in a plane with the one across it.
   pure function components_in_space(t, across) result(c)
      real(dp), intent(in) :: t(ndim, ndim), across
      real(dp) :: c(n_symmetric), in_space(space, space)
      in_space = 0
      in_space(space, space) = across
      in_space(:ndim, :ndim) = t
      c = [components_of(in_space), in_space(space, space)]
   end function components_in_space

   !> Displacement of a point [m].
   pure function displacement_at(problem, view, x, toward) result(u)
      type(problem_t), intent(in) :: problem
      type(view_t), intent(in) :: view
      real(dp), intent(in) :: x(ndim), toward(ndim) !! see `look_around`
      real(dp) :: u(ndim)
      type(surroundings_t) :: around
      call look_around(problem%matter_t, view, x, toward, around)
      u = matmul(weights_of(around, quadratic_fit), problem%particles%displacement(around%particle, :))
   end function displacement_at

   !> Mean strain along a line: the change of the distance of its ends over its length [-]: the mean of the strain along it and of
   !> the openings of cracks between its ends.
   pure real(dp) function elongation(problem, view, ends)
      type(problem_t), intent(in) :: problem
      type(view_t), intent(in) :: view
      real(dp), intent(in) :: ends(ndim, 2)      !! [m]
      real(dp) :: apart(ndim), length, across(ndim)
      across = 0
      apart = displacement_at(problem, view, ends(:, 2), across) - displacement_at(problem, view, ends(:, 1), across)
      associate (line => ends(:, 2) - ends(:, 1))
         length = norm(line)
         elongation = dot_product(line, apart)/length**2
         if (any(problem%materials%is_finite)) elongation = (2*dot_product(line, apart) + sum(apart**2)) &
                                                            /(length*(norm(line + apart) + length)) ! without cancellation
      end associate
   end function elongation

   !> Record the opening behind a tip and the volume between the faces of a crack.
   subroutine record_crack(model, problem, cracks, joined, probe, history)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: joined(:)           !! by body, which of them are one
      type(probe_t), intent(in) :: probe
      type(history_t), intent(inout) :: history
      real(dp), allocatable :: points(:, :)
      type(view_t) :: view
      character(:), allocatable :: name
      real(dp) :: parted(modes), left, length, between
      integer :: number, k
      number = path_of(model, probe%of(1))
      name = trim(probe%name)
      associate (crack => cracks%crack(number))
         allocate (points, source=crack%open_part())
         call new_view(problem%matter_t, cracks, joined, minval(points, dim=2), maxval(points, dim=2), view)
         if (probe%gives('opening')) then
            if (probe%tip == 'last') points = points(:, size(points, 2):1:-1)
            left = probe%distance
            length = 1
            do k = 2, size(points, 2)
               length = norm(points(:, k) - points(:, k - 1))
               if (left <= length .or. k == size(points, 2)) exit
               left = left - length
            end do
            parted = 0
            associate (from => points(:, k - 1), to => points(:, k))
               if (.not. crack%waits) parted = parted_at(problem, view, crack%face, from + left/length*(to - from), &
                                                         merge(-1, 1, probe%tip == 'last')*left_of(from, to))
            end associate
            call history%record('opening_'//name, 'm', 'opening of the crack of '//name, parted(1))
            if (crack%face == both_faces) call history%record('sliding_'//name, 'm', 'sliding of the crack of '//name, parted(2))
         end if
         if (probe%gives('volume')) then
            points = crack%open_part()
            between = 0
            do k = 2, merge(0, size(points, 2), crack%waits)
               between = between + volume(model, problem, view, crack%face, points(:, k - 1), points(:, k))
            end do
            call history%record('volume_'//name, 'm3', 'volume between the faces of the crack of '//name, between)
         end if
      end associate
   end subroutine record_crack

   !> Opening of the faces of a crack at a place, and sliding of the left one in the direction of the crack against the right one
   !> [m]; of laws for any rotation in the frame that turns with the material beside it. On a symmetry plane the mirror image is the
   !> other face.
   pure function parted_at(problem, view, face, x, normal) result(parted)
      type(problem_t), intent(in) :: problem
      type(view_t), intent(in) :: view
      integer, intent(in) :: face                !! which faces there are
      real(dp), intent(in) :: x(ndim)            !! on the crack [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      real(dp) :: parted(modes)
      type(surroundings_t) :: around
      real(dp), allocatable :: weights(:)
      real(dp) :: jump(ndim), c, s
      integer :: side, k
      jump = 0
      c = 0
      s = 0
      do side = 1, -1, -2
         if (face == merge(right_face, left_face, side == 1)) cycle
         call look_around(problem%matter_t, view, x, side*normal, around)
         weights = weights_of(around, quadratic_fit)
         jump = jump + side*matmul(weights, problem%particles%displacement(around%particle, :))
         do k = 1, size(weights)
            associate (h => problem%particles%gradient_of(around%particle(k)))
               c = c + weights(k)*(2 + h(1, 1) + h(2, 2))
               s = s + weights(k)*(h(2, 1) - h(1, 2))
            end associate
         end do
      end do
      if (any(problem%materials%is_finite) .and. hypot(c, s) > 0) &
         jump = in_plane(c*jump(1) + s*jump(2), c*jump(2) - s*jump(1))/hypot(c, s)
      parted = in_modes(jump, frame_along(quarter_turn(-normal)), face /= both_faces)
   end function parted_at

   !> Volume between the faces of a straight part of a crack, with material on both sides [m3]: the integral of the opening by the
   !> midpoints of parts no longer than half of a cell there, from repeated halving.
   pure recursive function volume(model, problem, view, face, from, to) result(integral)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(view_t), intent(in) :: view
      integer, intent(in) :: face                !! which faces there are
      real(dp), intent(in) :: from(ndim), to(ndim) !! its ends [m]
      real(dp) :: integral
      real(dp), parameter :: beside = 1e-3_dp, most = 0.5_dp + 1e-9_dp ! cells
      real(dp) :: x(ndim), aside(ndim), parted(modes), cell
      integer :: side
      x = (from + to)/2
      aside = beside*problem%grid%finest_cell*left_of(from, to)
      cell = huge(cell)
      integral = 0
      do side = 1, -1, -2
         if (face == merge(right_face, left_face, side == 1)) cycle
         if (body_at(model, x + side*aside) == 0) then
            if (norm(to - from) <= most*problem%grid%forest%cell) return
            cycle
         end if
         associate (forest => problem%grid%forest, now => problem%grid%cut_cells%follow(x))
            cell = min(cell, forest%size_of(max(1, forest%leaf_at(now + side*aside))))
         end associate
      end do
      if (norm(to - from) > most*min(cell, problem%grid%forest%cell)) then
         integral = volume(model, problem, view, face, from, x) + volume(model, problem, view, face, x, to)
      else
         parted = parted_at(problem, view, face, x, left_of(from, to))
         integral = parted(1)*norm(to - from)*problem%particles%thickness%at(x)
      end if
   end function volume

   !> Record a load, or the reaction of a constraint, and its displacement, less the displacement of another one.
   subroutine record_load(model, problem, probe, reactions, history)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(probe_t), intent(in) :: probe
      real(dp), intent(in) :: reactions(:, :)
      type(history_t), intent(inout) :: history
      real(dp) :: force(ndim), displacement(ndim), other(ndim), from(ndim)
      from = 0
      associate (of => probe%of)
         call find_load_line(problem, findloc(model%loads%name, of(1), dim=1), findloc(model%constraints%name, of(1), dim=1), &
                             reactions, force, displacement)
         if (of(2) /= '') call find_load_line(problem, findloc(model%loads%name, of(2), dim=1), &
                                              findloc(model%constraints%name, of(2), dim=1), reactions, other, from)
      end associate
      call history%record_vector('load_'//trim(probe%name), 'N', 'load of '//trim(probe%name), force)
      call history%record_vector('load_displacement_'//trim(probe%name), 'm', 'load-line displacement of '//trim(probe%name), &
                                 displacement - from)
   end subroutine record_load
end module hampm_probes
