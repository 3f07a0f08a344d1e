!> Cracks carried by the material, where particles move through the grid (updated frame): the lines that cut cells follow the faces,
!> and cells are cut anew when these have moved by a small part of a cell.
!>
!> Each point of a line follows the nearest particles on either side in the reference configuration (the mean if equally near): its
!> place on a face is x + F (X - X_p), on the line the mean of both faces. So lines turn and bend with the material without drift,
!> and separated faces separate them. Particles keep their sides (`cut_cells_t%follow`).
module hampm_crack_carrying
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_crack_lines, only: line_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_matching, only: adopt_lines
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, quarter_turn
   use hampm_text, only: to_text
   implicit none
   private
   public :: carried_cracks_t, attach_cracks, place_cracks, follow_cracks, archive_carried

   integer, parameter :: faces = 2               !! the left and the right one
   integer, parameter :: n_carriers = 4          !! most particles that are as near to a point, as those around one are
   real(dp), parameter :: usual_allowance = 0.05_dp, allowance_of_nodes = 0.2_dp !! see `carried_cracks_t`
   real(dp), parameter :: most_overlap = 0.5_dp  !! largest overlap of faces [finest cells]

   !> Carriers of the points of lines. A particle that splits gives its number to its children; a face follows the nearest of these.
   !> An entry is a place of `carrier`, in its order.
   type :: carried_cracks_t
      real(dp), private :: allowance = 0         !! lag of a line behind the material [finest cells]: more if nodes close a crack
      integer, allocatable, private :: carrier(:, :, :) !! numbers of the particles, 0 behind the last; (n_carriers, faces, points)
      integer, allocatable, private :: first(:)  !! the first entry that is the particle of a number, 0 for none
      integer, allocatable, private :: next(:)   !! the next one of the same particle, 0 behind the last; (entries)
   contains
      procedure :: are_there
   end type carried_cracks_t

contains

   !> Whether any cracks are carried.
   pure logical function are_there(self)
      class(carried_cracks_t), intent(in) :: self
      are_there = allocated(self%carrier)
   end function are_there

   !> Find the particles on which lines hang, at the start of a run, where lines are carried at all.
   pure subroutine attach_cracks(carried, m, by_nodes)
      type(carried_cracks_t), intent(inout) :: carried
      type(problem_t), intent(in) :: m
      logical, intent(in) :: by_nodes            !! whether the nodes where cracks end are to close them
      real(dp), allocatable :: origin(:, :), normal(:, :)
      integer :: n
      if (.not. m%grid%cut_cells%are_there()) return
      call list_points(m%grid%cut_cells%lines, origin, normal)
      if (size(origin, 2) == 0) return
      carried%allowance = merge(allowance_of_nodes, usual_allowance, by_nodes)
      allocate (carried%carrier(n_carriers, faces, size(origin, 2)))
      do n = 1, size(origin, 2)
         carried%carrier(:, :, n) = nearest_to(m, origin(:, n), normal(:, n))
      end do
      call list_entries(carried)
   end subroutine attach_cracks

   !> The numbers of the particles on either side of a line that are nearest to a point of it.
   pure function nearest_to(m, origin, normal) result(carrier)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: origin(ndim), normal(ndim) !! see `list_points`
      integer :: carrier(n_carriers, faces)
      real(dp) :: nearest(faces), away(ndim), distance, far
      integer :: i, face
      carrier = 0
      nearest = huge(nearest)
      far = huge(far)
      do i = 1, m%particles%n
         away = m%particles%reference(i, :) - origin
         if (maxval(abs(away)) > far) cycle
         face = face_toward(normal, away)
         distance = norm(away)
         if (distance > nearest(face) + m%grid%cut_cells%slack) cycle
         if (distance < nearest(face) - m%grid%cut_cells%slack) carrier(:, face) = 0
         nearest(face) = min(distance, nearest(face))
         far = maxval(nearest) + 2*m%grid%cut_cells%slack
         if (any(carrier(:, face) == m%particles%id(i)) .or. all(carrier(:, face) > 0)) cycle
         carrier(count(carrier(:, face) > 0) + 1, face) = m%particles%id(i)
      end do
      if (carrier(1, 1) == 0) carrier(:, 1) = carrier(:, 2)
      if (carrier(1, 2) == 0) carrier(:, 2) = carrier(:, 1)
   end function nearest_to

   !> List the entries of each particle.
   pure subroutine list_entries(carried)
      type(carried_cracks_t), intent(inout) :: carried
      integer :: n, face, k, entry
      if (allocated(carried%first)) deallocate (carried%first, carried%next)
      allocate (carried%first(maxval(carried%carrier)), carried%next(size(carried%carrier)), source=0)
      do n = 1, size(carried%carrier, 3)
         do face = 1, faces
            do k = 1, count(carried%carrier(:, face, n) > 0)
               entry = n_carriers*(faces*(n - 1) + face - 1) + k
               associate (id => carried%carrier(k, face, n))
                  carried%next(entry) = carried%first(id)
                  carried%first(id) = entry
               end associate
            end do
         end do
      end do
   end subroutine list_entries

   !> Let lines, of which those that grow may have points that the grid does not know, be where the material has carried them.
   pure subroutine place_cracks(carried, m, lines)
      type(carried_cracks_t), intent(inout) :: carried
      type(problem_t), intent(in) :: m
      type(line_t), intent(inout) :: lines(:)
      real(dp), allocatable :: origin(:, :), normal(:, :), before(:, :), place(:, :)
      integer, allocatable :: carrier(:, :, :)
      real(dp) :: overlap
      integer :: n, old
      if (.not. carried%are_there()) return
      call list_points(m%grid%cut_cells%lines, before, normal)
      call list_points(lines, origin, normal)
      allocate (carrier(n_carriers, faces, size(origin, 2)))
      do n = 1, size(origin, 2)
         old = findloc(sum((before - spread(origin(:, n), 2, size(before, 2)))**2, dim=1) <= m%grid%cut_cells%slack**2, &
                       .true., dim=1)
         if (old > 0) carrier(:, :, n) = carried%carrier(:, :, old)
         if (old == 0) carrier(:, :, n) = nearest_to(m, origin(:, n), normal(:, n))
      end do
      call move_alloc(carrier, carried%carrier)
      call list_entries(carried)
      call find_places(carried, m%particles, m%grid%cut_cells%slack, origin, normal, place, overlap)
      call move_to(place, lines)
   end subroutine place_cracks

   !> Give lines that are carried their places.
   pure subroutine move_to(place, lines)
      real(dp), intent(in) :: place(:, :)        !! [m], (ndim, points of all lines)
      type(line_t), intent(inout) :: lines(:)
      integer :: k, n
      n = 0
      do k = 1, size(lines)
         if (.not. allocated(lines(k)%origin)) cycle
         lines(k)%points = place(:, n + 1:n + size(lines(k)%points, 2))
         n = n + size(lines(k)%points, 2)
      end do
   end subroutine move_to

   !> Let lines follow the material after a step. Where one lags by more than a small part of a cell, cells are cut along the
   !> present lines, and `moved` is true.
   subroutine follow_cracks(carried, m, lines, moved, failure)
      type(carried_cracks_t), intent(in) :: carried
      type(problem_t), intent(inout) :: m
      type(line_t), allocatable, intent(inout) :: lines(:) !! lines of the grid, with the present tips
      logical, intent(out) :: moved
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: origin(:, :), normal(:, :), place(:, :)
      real(dp) :: behind, overlap
      integer :: k, n
      moved = .false.
      if (.not. carried%are_there()) return
      call list_points(m%grid%cut_cells%lines, origin, normal)
      call find_places(carried, m%particles, m%grid%cut_cells%slack, origin, normal, place, overlap)
      if (overlap > most_overlap*m%grid%finest_cell) then
         call failure%report(exit_computation, m%state%when()//'the faces of a crack interpenetrate by '// &
                             to_text(overlap)//' m, more than half of a cell: in the updated frame both would be one body in '// &
                             'the cells beyond. Use &method frame = ''total'', with &crack contact = ''frictionless'' or '// &
                             '''friction'' where faces come into contact')
         return
      end if
      behind = 0
      n = 0
      do k = 1, size(m%grid%cut_cells%lines)
         associate (points => m%grid%cut_cells%lines(k)%points)
            if (.not. allocated(m%grid%cut_cells%lines(k)%origin)) cycle
            behind = max(behind, maxval(sqrt(sum((place(:, n + 1:n + size(points, 2)) - points)**2, dim=1))))
            n = n + size(points, 2)
         end associate
      end do
      moved = behind > carried%allowance*m%grid%finest_cell
      if (.not. moved) return
      call move_to(place, lines)
      call adopt_lines(m, lines, failure)
   end subroutine follow_cracks

   !> The points of all lines that are carried in the reference configuration, and the normals there, to the left.
   pure subroutine list_points(lines, origin, normal)
      type(line_t), intent(in) :: lines(:)
      real(dp), allocatable, intent(out) :: origin(:, :) !! [m], (ndim, points)
      real(dp), allocatable, intent(out) :: normal(:, :) !! (ndim, points)
      real(dp) :: along(ndim)
      integer :: line, k, n
      n = 0
      do line = 1, size(lines)
         if (allocated(lines(line)%origin)) n = n + size(lines(line)%origin, 2)
      end do
      allocate (origin(ndim, n), normal(ndim, n))
      n = 0
      do line = 1, size(lines)
         if (.not. allocated(lines(line)%origin)) cycle
         associate (points => lines(line)%origin, last => size(lines(line)%origin, 2))
            do k = 1, last
               n = n + 1
               origin(:, n) = points(:, k)
               along = 0
               if (k > 1) along = along + (points(:, k) - points(:, k - 1))/norm(points(:, k) - points(:, k - 1))
               if (k < last) along = along + (points(:, k + 1) - points(:, k))/norm(points(:, k + 1) - points(:, k))
               normal(:, n) = quarter_turn(along)
            end do
         end associate
      end do
   end subroutine list_points

   !> Present places of the points, in the middle between the faces, and the largest interpenetration of these.
   pure subroutine find_places(carried, p, slack, origin, normal, place, overlap)
      type(carried_cracks_t), intent(in) :: carried
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: slack              !! tolerance of equal distances [m]
      real(dp), intent(in) :: origin(:, :), normal(:, :) !! see `list_points`
      real(dp), allocatable, intent(out) :: place(:, :)  !! [m], (ndim, points)
      real(dp), intent(out) :: overlap           !! [m]
      real(dp) :: of_face(ndim, faces, size(origin, 2)), nearest(faces, size(origin, 2)), away(ndim), distance
      integer :: i, n, face, entry, as_near(faces, size(origin, 2))
      nearest = huge(nearest)
      as_near = 0
      of_face = 0
      do i = 1, p%n
         if (p%id(i) > size(carried%first)) cycle
         entry = carried%first(p%id(i))
         do while (entry > 0)
            n = 1 + (entry - 1)/(n_carriers*faces)
            face = 1 + mod((entry - 1)/n_carriers, faces)
            away = origin(:, n) - p%reference(i, :)
            distance = norm(away)
            if (face_toward(normal(:, n), -away) /= face) distance = sqrt(huge(distance)) ! only where there is no other
            if (distance < nearest(face, n) - slack) as_near(face, n) = 0
            if (distance <= nearest(face, n) + slack) then
               nearest(face, n) = min(distance, nearest(face, n))
               as_near(face, n) = as_near(face, n) + 1
               of_face(:, face, n) = of_face(:, face, n) + (p%position(i) + away + matmul(p%gradient_of(i), away) &
                                                            - of_face(:, face, n))/as_near(face, n)
            end if
            entry = carried%next(entry)
         end do
      end do
      place = sum(of_face, dim=2)/faces
      overlap = 0
      do n = 2, size(origin, 2) - 1              ! the normal is that between two neighbours
         associate (along => place(:, n + 1) - place(:, n - 1), jump => of_face(:, 1, n) - of_face(:, 2, n))
            if (dot_product(along, along) > 0) overlap = max(overlap, (along(2)*jump(1) - along(1)*jump(2))/norm(along))
         end associate
      end do
   end subroutine find_places

   !> The face on whose side a point is.
   pure integer function face_toward(normal, away) result(face)
      real(dp), intent(in) :: normal(ndim)       !! of the line, to the left
      real(dp), intent(in) :: away(ndim)         !! from it to the point [m]
      face = merge(1, 2, dot_product(normal, away) >= 0)
   end function face_toward

   !> Archive the carriers of lines: lines of grown cracks follow the particles that were there at growth.
   subroutine archive_carried(carried, archive)
      type(carried_cracks_t), intent(inout) :: carried
      class(archive_t), intent(inout) :: archive
      integer :: n
      if (.not. carried%are_there()) return
      n = size(carried%carrier, 3)
      call archive%section('carried_cracks')
      call archive%serialise('points', n)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         deallocate (carried%carrier)
         allocate (carried%carrier(n_carriers, faces, n))
      end if
      call archive%archive_integers('carrier', size(carried%carrier), carried%carrier)
      if (archive%is_read .and. .not. archive%failure%failed()) call list_entries(carried)
   end subroutine archive_carried
end module hampm_crack_carrying
