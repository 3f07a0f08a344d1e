!> Closing pairs of nodes behind a tip gives the state of a body whose crack is shorter by so many cells: its displacement, and its
!> energy. The latter is solved for on its own, in a grid with a shorter cut.
program test_condensation
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_condensation, only: condensation_t, new_condensation
   use hampm_constraints, only: constrain_box
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_cracked, only: build_cracked, add_pull, rest_of
   use hampm_cracks, only: crack_t, cracks_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t
   use hampm_stiffness, only: stiffness_t
   use hampm_crack_lines, only: left_face
   implicit none

   real(dp), parameter :: cell = 0.5_dp, length = 8.0_dp, depth = 1.5_dp, tip = 4.0_dp, little = 1e-7_dp
   !> The same between faces in contact: the rounding of a layer that is a million times as stiff as the cells
   real(dp), parameter :: by_layer = 1e-5_dp
   !> Force on the end of the upper and of the lower arm [N]
   real(dp), parameter :: opening(ndim, 2) = reshape([0, 1, 0, -1], [ndim, 2])*1e-6_dp
   real(dp), parameter :: sliding(ndim, 2) = reshape([0, 1, 0, 1], [ndim, 2])*1e-6_dp
   real(dp), parameter :: mixed(ndim, 2) = reshape([1, 2, 0, 0], [ndim, 2])*1e-6_dp
   real(dp), parameter :: pressing(ndim, 2) = reshape([1, -1, 0, 1], [ndim, 2])*1e-6_dp
   integer :: n

   do n = 1, 3
      call edge_crack('opening', opening, n, 0, .false., [.true., .false.])
      call edge_crack('sliding', sliding, n, 0, .false., [.false., .true.])
      call edge_crack('mixed', mixed, n, 0, .false., [.true., .true.])
      call edge_crack('mixed, smaller cells', mixed, n, 1, .false., [.true., .true.])
      call edge_crack('faces pressed together', pressing, n, 0, .true., [.false., .true.])
      call half_body(n)
   end do
   call two_tips()
   call pairs_that_are_there()
   call finish()

contains

   !> A split beam that is clamped at its right end, with forces on the ends of its arms.
   subroutine split_beam(forces, to, levels, contact, m, cracks)
      real(dp), intent(in) :: forces(ndim, 2), to !! where the tip is [m]
      integer, intent(in) :: levels              !! of smaller cells around the tip
      logical, intent(in) :: contact
      type(problem_t), intent(out) :: m
      type(cracks_t), intent(out) :: cracks
      type(forest_t) :: forest
      type(crack_t) :: crack
      forest = forest_t([-cell, -2.0_dp], cell, [18, 8])
      call refine_box(forest, [tip - 1.4_dp, -0.9_dp], [tip + 1.4_dp, 0.9_dp], levels)
      crack%kind = 'line'
      crack%contact = contact
      crack%is_tip = [.false., .true.]
      crack%points = reshape([-9.0_dp, 0.0_dp, to, 0.0_dp], [ndim, 2])
      call build_cracked(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                         rectangle_t([0.0_dp, -depth], [length, depth], [64, 24]), crack, m, cracks)
      call constrain_box(m%constraints, m%grid, [length, -depth], [length, depth], [.true., .true.])
      call add_pull(m, [0.0_dp, 0.0_dp], [0.0_dp, depth], forces(:, 1))
      call add_pull(m, [0.0_dp, -depth], [0.0_dp, 0.0_dp], forces(:, 2))
   end subroutine split_beam

   !> Close `n` pairs of an edge crack.
   subroutine edge_crack(what, forces, n, levels, contact, there)
      character(*), intent(in) :: what
      real(dp), intent(in) :: forces(ndim, 2)
      integer, intent(in) :: n, levels
      logical, intent(in) :: contact
      logical, intent(in) :: there(modes)        !! which modes there are
      type(problem_t) :: m, shorter
      type(cracks_t) :: cracks, shorter_cracks
      integer :: k
      call split_beam(forces, tip, levels, contact, m, cracks)
      call split_beam(forces, tip - n*scale(cell, -levels), levels, contact, shorter, shorter_cracks)
      call compare(what, m, shorter, [(cracks%tips(1), k=1, n)], [(k, k=1, n)], there)
   end subroutine edge_crack

   !> Half of a split beam, its lower face on the symmetry plane.
   subroutine half_body(n)
      integer, intent(in) :: n
      type(problem_t) :: m(2)
      type(cracks_t) :: cracks(2)
      type(crack_t) :: crack
      integer :: k
      crack%kind = 'symmetry'
      crack%is_tip = [.false., .true.]
      crack%face = left_face
      do k = 1, 2
         associate (to => tip - (k - 1)*n*cell)
            crack%points = reshape([-9.0_dp, 0.0_dp, to, 0.0_dp], [ndim, 2])
            call build_cracked(forest_t([-cell, -cell], cell, [18, 6]), &
                               new_material('', 'linear_elastic', .false., 1.0_dp, 0.3_dp, 1.0_dp), &
                               rectangle_t([0.0_dp, 0.0_dp], [length, depth], [64, 12]), crack, m(k), cracks(k))
            call constrain_box(m(k)%constraints, m(k)%grid, [to, 0.0_dp], [length, 0.0_dp], [.false., .true.])
            call constrain_box(m(k)%constraints, m(k)%grid, [length, 0.0_dp], [length, depth], [.true., .false.])
            call add_pull(m(k), [0.0_dp, 0.0_dp], [0.0_dp, depth], [0.0_dp, 1e-6_dp])
         end associate
      end do
      call compare('half', m(1), m(2), [(cracks(1)%tips(1), k=1, n)], [(k, k=1, n)], [.true., .false.])
   end subroutine half_body

   !> A crack inside a plate that is pulled and sheared: a pair at each tip, one and two from one of them and one from the other.
   subroutine two_tips()
      type(problem_t) :: m(2)
      type(cracks_t) :: cracks(2)
      type(crack_t) :: crack
      type(crack_tip_t) :: tips(3)
      integer :: k
      crack%kind = 'line'
      crack%is_tip = .true.
      do k = 1, 2
         crack%points = reshape([2.0_dp + (k - 1)*cell, 0.0_dp, 6.0_dp - 2*(k - 1)*cell, 0.0_dp], [ndim, 2])
         call build_cracked(forest_t([-cell, -2.0_dp], cell, [18, 8]), &
                            new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                            rectangle_t([0.0_dp, -depth], [length, depth], [32, 12]), crack, m(k), cracks(k))
         call constrain_box(m(k)%constraints, m(k)%grid, [0.0_dp, -depth], [length, -depth], [.true., .true.])
         call add_pull(m(k), [0.0_dp, depth], [length, depth], [2e-6_dp, 5e-6_dp])
      end do
      do k = 1, 3
         tips(k) = cracks(1)%tips(max(1, k - 1))  ! tips([1, 1, 2]) as an argument would leak in gfortran 12
      end do
      call compare('two tips', m(1), m(2), tips, [1, 2, 1], [.true., .true.])
   end subroutine two_tips

   !> Close all of some pairs, and hold what comes out to a body with a crack that is shorter by these.
   subroutine compare(what, m, shorter, tips, cells, there)
      character(*), intent(in) :: what
      type(problem_t), intent(inout) :: m, shorter
      type(crack_tip_t), intent(in) :: tips(:)
      integer, intent(in) :: cells(:)            !! behind each of these
      logical, intent(in) :: there(modes)        !! which modes there are
      type(condensation_t) :: closing
      type(stiffness_t) :: stiffness
      real(dp), allocatable :: u(:, :), u_shorter(:, :), force(:)
      real(dp) :: energy, energy_shorter, work(modes), off, largest, small
      integer :: found, i, k
      small = merge(by_layer, little, m%interfaces%n_contact > 0)
      call rest_of(shorter, stiffness, u_shorter, energy_shorter)
      call rest_of(m, stiffness, u, energy)
      call new_condensation(m, stiffness, tips, cells, u, closing, found)
      call check(found == size(cells), what//': the pairs are there')
      allocate (force(size(closing%parting)))
      call closing%close_pairs([(k, k=1, size(cells))], force, work)
      call check_close(sum(work)/(energy - energy_shorter), 1.0_dp, small, what//': work of closing')
      call check(all((abs(work) > 1e-3_dp*sum(abs(work))) .eqv. there), what//': the modes that there are')
      call check(all(abs(pack(work, .not. there)) <= small*sum(abs(work))), what//': no work of other modes')
      do k = 1, size(force)
         u = u - force(k)*closing%moved(:, :, k)
      end do
      off = 0
      largest = 0
      do i = 1, m%particles%n
         off = max(off, maxval(abs(displacement(m, u, i) - displacement(shorter, u_shorter, i))))
         largest = max(largest, maxval(abs(displacement(m, u, i))))
      end do
      call check(maxval(abs(m%particles%reference - shorter%particles%reference)) <= 0, what//': the same particles')
      call check_close(off/largest, 0.0_dp, small, what//': displacement of the particles')
      call stiffness%release()
   end subroutine compare

   !> Displacement of a particle by one of the points [m].
   pure function displacement(m, u, i)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)
      integer, intent(in) :: i
      real(dp) :: displacement(ndim)
      real(dp) :: n(4)
      associate (e => m%particles%cell(i))
         n = shape_functions(inside_cell(m%grid%local_coordinate(e, m%particles%place_in_grid(i))))
         displacement = matmul(u(:, m%grid%element_nodes(:, e)), n)
      end associate
   end function displacement

   !> Pairs are looked for one after the other, up to the first that is not there; those that are not closed bear no force.
   subroutine pairs_that_are_there()
      type(problem_t) :: m
      type(cracks_t) :: cracks
      type(condensation_t) :: closing
      type(stiffness_t) :: stiffness
      real(dp), allocatable :: u(:, :), force(:)
      real(dp) :: energy, work(modes), both(modes)
      integer :: found, k
      call split_beam(mixed, tip, 0, .false., m, cracks)
      call rest_of(m, stiffness, u, energy)
      call new_condensation(m, stiffness, [(cracks%tips(1), k=1, 4)], [1, 2, 100, 3], u, closing, found)
      call check(found == 2 .and. size(closing%parting) == 2*modes, 'two pairs before the one that is outside')
      allocate (force(size(closing%parting)))
      call closing%close_pairs([1], force, work)
      call check(all((abs(force) > 0) .eqv. closing%parting%place == 1), 'forces on the first pair')
      call closing%close_pairs([1, 2], force, both)
      call check(all(both > work) .and. all(abs(force) > 0), 'it takes more to close two')
      call closing%close_pairs([integer ::], force, work)
      call check(all(abs(force) <= 0) .and. all(abs(work) <= 0), 'it takes nothing to close none')
      call stiffness%release()
   end subroutine pairs_that_are_there
end program test_condensation
