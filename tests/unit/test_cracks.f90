!> Where cracks are: their tips, numbered through, with frames, faces and surroundings, the nodes around these, and their lines.
program test_cracks
   use hampm_kinds, only: dp, ndim
   use hampm_assembly, only: assemble
   use hampm_crack_tip, only: crack_tip_t, upper, lower
   use hampm_cracks, only: crack_t, cracks_t, first_point
   use hampm_estimators, only: estimators
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish
   use hampm_indicator, only: refinement_t
   use hampm_model, only: model_t
   use hampm_problem, only: problem_t
   use hampm_thickness, only: thickness_t
   use hampm_crack_lines, only: line_t, left_face
   implicit none

   real(dp), parameter :: cell = 0.5_dp, x(ndim) = [1.0_dp, 0.0_dp], y(ndim) = [0.0_dp, 1.0_dp]
   integer, parameter :: cells(ndim) = [12, 8]

   call scene_without_crack()
   call edge_crack()
   call two_tips()
   call symmetry_crack(2.0_dp, 3.5_dp, x, [.true., .false.])
   call symmetry_crack(0.5_dp, 2.0_dp, x, [.false., .true.])
   call symmetry_crack(2.0_dp, 3.5_dp, -x, [.false., .true.])
   call symmetry_crack(0.5_dp, 2.0_dp, -x, [.true., .false.])
   call several_cracks()
   call frames_of_a_polyline()
   call finish()

contains

   !> A model of one body of the second of two materials, on a lattice from the origin to (6, 4).
   pure function scene_of(lower, upper) result(model)
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! of the body [m]
      type(model_t) :: model
      model%run%plane = 'stress'
      model%run%thickness = thickness_t(1.0_dp)
      model%grid%cell = cell
      model%grid%cells = cells
      model%method%scheme = 'musl'
      allocate (model%materials(2), model%bodies(1), model%constraints(0), model%loads(0), model%paths(0), model%planes(0), &
                model%growth(0), model%cohesive(0), model%nucleations(0), &
                model%energy_release%radii(0))
      model%materials%law = 'linear_elastic'
      model%materials%young = 1
      model%materials%density = 1
      model%bodies(1)%material_index = 2
      model%bodies(1)%lower = lower
      model%bodies(1)%upper = upper
      model%bodies(1)%points_per_cell = 2
      associate (rows => estimators())
         model%energy_release%chosen = pack(rows, rows%name == 'domain_integral')
      end associate
   end function scene_of

   !> Let the crack of a model be a line between two points, its tip the second.
   subroutine put_line(model, from, to)
      type(model_t), intent(inout) :: model
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      deallocate (model%paths)
      allocate (model%paths(1))
      model%paths(1)%kind = 'line'
      model%paths(1)%key = 'tip'
      model%paths(1)%direction = to - from
      model%paths(1)%points = reshape([from, to], [ndim, 2])
   end subroutine put_line

   !> The cracks of a model and its grid, with the nodes around the tips.
   subroutine build(model, cracks, grid)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(out) :: cracks
      type(grid_t), intent(out) :: grid
      type(problem_t) :: problem
      type(refinement_t) :: refinement
      type(failure_t) :: failure
      call assemble(model, problem, cracks, refinement, failure)
      grid = problem%grid
      call cracks%find_nodes(grid, failure)
      call check(.not. failure%failed(), 'every tip has its nodes')
   end subroutine build

   !> Number of nodes that there are twice.
   pure integer function doubled(grid)
      type(grid_t), intent(in) :: grid
      doubled = grid%n_nodes - product(cells + 1)
   end function doubled

   !> Whether a node is at a place and has an element in a direction.
   pure logical function is_at(grid, node, place, toward)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node
      real(dp), intent(in) :: place(ndim), toward(ndim)
      is_at = node > 0
      if (is_at) is_at = norm2(grid%node_position(:, node) - place) < 1.0e-12_dp .and. grid%has_element_toward(node, toward)
   end function is_at

   !> Check place and frame of a tip.
   subroutine check_place(tip, crack, place, outward, what)
      type(crack_tip_t), intent(in) :: tip
      integer, intent(in) :: crack
      real(dp), intent(in) :: place(ndim), outward(ndim)
      character(*), intent(in) :: what
      call check(tip%crack == crack .and. norm2(tip%place - place) <= 0, what//' is where it is')
      call check_close(norm2(tip%axis(:, 1) - outward), 0.0_dp, epsilon(1.0_dp), what//' points out of the crack')
      call check_close(norm2(tip%axis(:, 2) - [-outward(2), outward(1)]), 0.0_dp, epsilon(1.0_dp), what//' has its left there')
   end subroutine check_place

   !> A plain model has no cracks, and its grid is whole.
   subroutine scene_without_crack()
      type(cracks_t) :: cracks
      type(grid_t) :: grid
      call build(scene_of([0.5_dp, 0.5_dp], [5.5_dp, 3.5_dp]), cracks, grid)
      call check(size(cracks%crack) == 0 .and. size(cracks%tips) == 0 .and. size(cracks%lines()) == 0, 'no crack, no tip')
      call check(size(cracks%tip_places(), 2) == 0 .and. doubled(grid) == 0, 'and no cut')
   end subroutine scene_without_crack

   !> From the left edge of a body into it: a line out of the lattice, its mouth at the edge.
   subroutine edge_crack()
      type(model_t) :: model
      type(cracks_t) :: cracks
      type(grid_t) :: grid
      type(line_t), allocatable :: lines(:)
      real(dp), parameter :: tip(ndim) = [2.5_dp, 2.0_dp]
      model = scene_of([0.5_dp, 0.5_dp], [5.5_dp, 3.5_dp])
      call put_line(model, [0.5_dp, 2.0_dp], tip)
      call build(model, cracks, grid)
      call check(size(cracks%tips) == 1 .and. .not. cracks%crack(1)%is_tip(first_point), 'an edge crack has one tip')
      call check_place(cracks%tips(1), 1, tip, x, 'the tip of an edge crack')
      lines = cracks%lines()
      call check(lines(1)%points(1, 1) < 0.5_dp - cell, 'its line ends beyond the surface')
      call check(norm2(cracks%crack(1)%mouth - [0.5_dp, 2.0_dp]) <= 0, 'its mouth is where it leaves the body')
      call check(doubled(grid) == 5, 'its nodes are double from the edge of the lattice to the last before the tip')
      associate (tip_1 => cracks%tips(1), nodes => cracks%tips(1)%nodes)
         call check(.not. tip_1%is_half() .and. tip_1%material == 2, 'it has two faces, and the material of its body')
         call check_close(maxval(abs(tip_1%radii - [1.0_dp, 1.1_dp, 1.2_dp])), 0.0_dp, 1.0e-14_dp, &
                          'radii from two cells to four fifths of the distance to the nearest edge')
         call check_close(nodes%spacing, cell, 0.0_dp, 'nodes around the tip are a cell apart')
         call check(is_at(grid, nodes%tip, tip, -x) .and. is_at(grid, nodes%ahead, tip + cell*x, x), 'nodes at the tip and ahead')
         call check(is_at(grid, nodes%behind(upper), tip - cell*x, y) .and. &
                    is_at(grid, nodes%behind(lower), tip - cell*x, -y) .and. &
                    nodes%behind(upper) /= nodes%behind(lower), 'behind the tip each face has its node')
      end associate
   end subroutine edge_crack

   !> Inside the body: its second tip looks the other way, so that its upper face is the lower one of the first.
   subroutine two_tips()
      type(model_t) :: model
      type(cracks_t) :: cracks
      type(grid_t) :: grid
      real(dp), parameter :: tip(ndim) = [4.5_dp, 2.0_dp], other(ndim) = [2.5_dp, 2.0_dp]
      model = scene_of([0.5_dp, 0.5_dp], [5.5_dp, 3.5_dp])
      call put_line(model, other, tip)
      call build(model, cracks, grid)
      call check(size(cracks%tips) == 2 .and. all(cracks%crack(1)%is_tip), 'a crack inside the body has two tips')
      call check_place(cracks%tips(1), 1, tip, x, 'the first tip')
      call check_place(cracks%tips(2), 1, other, -x, 'the second tip')
      call check(maxval(abs(cracks%tip_places() - reshape([tip, other], [ndim, 2]))) <= 0, 'places are in the order of the tips')
      call check(doubled(grid) == 3, 'the nodes between the tips are double')
      call check(norm2(cracks%crack(1)%mouth - (tip - x)) <= 0, 'the mouth of both is in the middle')
      call check(size(cracks%tips(1)%radii) == 1 .and. size(cracks%tips(2)%radii) == 3, &
                 'each tip has the radii that fit there: the first is nearer to an edge')
      associate (one => cracks%tips(1)%nodes, two => cracks%tips(2)%nodes)
         call check(is_at(grid, one%behind(upper), tip - cell*x, y) .and. is_at(grid, two%behind(upper), other + cell*x, -y), &
                    'the upper faces are to the left of the tips')
         call check(is_at(grid, one%ahead, tip + cell*x, x) .and. is_at(grid, two%ahead, other - cell*x, -x), &
                    'ahead is out of the crack')
      end associate
   end subroutine two_tips

   !> On a symmetry plane the crack has the face at which there is a body.
   subroutine symmetry_crack(bottom, top, direction, face)
      real(dp), intent(in) :: bottom, top        !! of the body, on one side of the plane at 2 m [m]
      real(dp), intent(in) :: direction(ndim)
      logical, intent(in) :: face(2)             !! upper and lower, which there is
      type(model_t) :: model
      type(cracks_t) :: cracks
      type(grid_t) :: grid
      real(dp), parameter :: tip(ndim) = [3.0_dp, 2.0_dp]
      real(dp) :: body_side(ndim)
      integer :: k
      model = scene_of([0.5_dp, bottom], [5.5_dp, top])
      call put_line(model, tip - 2.5_dp*direction, tip)
      model%paths(1)%is_symmetry = .true.
      model%paths(1)%direction = direction
      call build(model, cracks, grid)
      call check(size(cracks%tips) == 1, 'a crack on a symmetry plane has one tip')
      call check_place(cracks%tips(1), 1, tip, direction, 'the tip on a symmetry plane')
      call check(norm2(cracks%crack(1)%mouth - (tip - 2.5_dp*direction)) <= 0, 'its mouth is at the edge of the body')
      k = merge(upper, lower, face(upper))
      body_side = y*sign(1.0_dp, bottom + top - 4)
      associate (tip_1 => cracks%tips(1))
         call check(all(tip_1%face .eqv. face) .and. tip_1%is_half(), 'there is the face of the body')
         call check(count(tip_1%nodes%behind > 0) == 1 .and. is_at(grid, tip_1%nodes%behind(k), tip - cell*direction, body_side), &
                    'with its node behind the tip')
      end associate
   end subroutine symmetry_crack

   !> Three cracks in one grid: along x with two tips, along y with one at its last and another with one at its first point.
   subroutine several_cracks()
      type(cracks_t) :: cracks
      type(grid_t) :: grid
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(line_t), allocatable :: lines(:)
      allocate (cracks%crack(3))
      call put(cracks%crack(1), [1.0_dp, 2.0_dp], [2.5_dp, 2.0_dp], [.true., .true.])
      call put(cracks%crack(2), [4.0_dp, -1.0_dp], [4.0_dp, 1.5_dp], [.false., .true.])
      call put(cracks%crack(3), [5.0_dp, 2.5_dp], [5.0_dp, 9.0_dp], [.true., .false.])
      cracks%crack(2)%contact = .true.
      call cracks%list_tips()
      call check(size(cracks%tips) == 4, 'three cracks with four tips')
      call check_place(cracks%tips(1), 1, [2.5_dp, 2.0_dp], x, 'tip 1, the last point of the first crack,')
      call check_place(cracks%tips(2), 1, [1.0_dp, 2.0_dp], -x, 'tip 2, its first point,')
      call check_place(cracks%tips(3), 2, [4.0_dp, 1.5_dp], y, 'tip 3, the last point of the second crack,')
      call check_place(cracks%tips(4), 3, [5.0_dp, 2.5_dp], -y, 'tip 4, the first point of the third crack,')
      forest = forest_t([0.0_dp, 0.0_dp], cell, cells)
      lines = cracks%lines()
      call check(size(lines) == 3 .and. all(lines%contact .eqv. [.false., .true., .false.]), 'each crack is a line')
      call check(all(abs(lines(1)%points - cracks%crack(1)%points) <= 0) .and. all(lines(1)%is_tip), 'from end to end')
      call build_grid(forest, grid, failure, lines)
      call check(doubled(grid) == 2 + 3 + 3, 'all nodes of the cracks but the tips are double')
      call cracks%find_nodes(grid, failure)
      call check(.not. failure%failed(), 'every tip has its nodes')
      call check(is_at(grid, cracks%tips(3)%nodes%behind(upper), [4.0_dp, 1.0_dp], -x) .and. &
                 is_at(grid, cracks%tips(4)%nodes%behind(upper), [5.0_dp, 3.0_dp], x), 'the upper face is to the left of each tip')
   end subroutine several_cracks

   !> Put a crack between two points.
   subroutine put(crack, from, to, is_tip)
      type(crack_t), intent(out) :: crack
      real(dp), intent(in) :: from(ndim), to(ndim)
      logical, intent(in) :: is_tip(2)
      crack%points = reshape([from, to], [ndim, 2])
      crack%is_tip = is_tip
   end subroutine put

   !> The frame of a tip is that of the segment that ends there, in any direction; its faces are those of the crack, from there.
   subroutine frames_of_a_polyline()
      type(cracks_t) :: cracks
      allocate (cracks%crack(1))
      associate (crack => cracks%crack(1))
         crack%points = reshape([0.0_dp, 0.0_dp, 1.0_dp, 0.0_dp, 4.0_dp, 4.0_dp], [ndim, 3])
         crack%is_tip = .true.
         crack%face = left_face
      end associate
      call cracks%list_tips()
      call check_place(cracks%tips(1), 1, [4.0_dp, 4.0_dp], [0.6_dp, 0.8_dp], 'the tip of an oblique segment')
      call check_place(cracks%tips(2), 1, [0.0_dp, 0.0_dp], -x, 'the tip of another segment')
      call check(all(cracks%tips(1)%face([upper, lower]) .eqv. [.true., .false.]), 'the left face is upper at the last point')
      call check(all(cracks%tips(2)%face([upper, lower]) .eqv. [.false., .true.]), 'and lower at the first')
   end subroutine frames_of_a_polyline
end program test_cracks
