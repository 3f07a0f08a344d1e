!> Patch test: on any balanced mesh a linear displacement field leaves no force on the nodes inside a body, and mass and momentum at
!> the nodes are those that the body began with.
!>
!> Particles stand two by two in each cell, so one in the middle of each quarter: there the sum over particles of V times the
!> gradient of a shape function, which is linear in each quarter, is its integral, and that is zero for a node inside. Particles
!> displaced by a linear field u stay on average where the middles of their cells go. Bilinear functions have
!> N_,x(x + u) = N_,x + N_,xy u_y, and what this adds, the integral of N_,xy u_y, is zero as well: by parts it is one over edges
!> of N_,x along them, and one of N, which are the same from both sides where N is continuous. So no force is left in the
!> updated frame either, as long as particles stay in their quarters.
program test_patch
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, outside
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: assemble_sums, problem_t, refresh_grid
   use hampm_random_forests, only: random_integer, change_at_random
   use hampm_samples, only: rectangle_t, place_bodies, start, thickness
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: sequences = 100, meshes = 10  !! 1000 meshes in each frame
   integer, parameter :: most_leaves = 220, most_levels = 4
   integer, parameter :: force = 1, mass = 2, momentum = 3, volume = 4, no_mass = 5 !! of the figures of `look`
   real(dp), parameter :: cell = 0.3_dp, rounding = 1.0e-13_dp

   call repeat_random_numbers()
   call random_meshes(.true., 1.0_dp, 'total frame')
   call random_meshes(.false., 1.0e-3_dp, 'updated frame')
   call finish()

contains

   subroutine random_meshes(total_frame, strain, what)
      logical, intent(in) :: total_frame
      real(dp), intent(in) :: strain             !! largest component of H [-]
      character(*), intent(in) :: what
      real(dp) :: worst(5)
      integer :: k, finest, most_particles, inside
      worst = 0
      finest = 0
      most_particles = 0
      inside = 0
      do k = 1, sequences
         call sequence_of_meshes(total_frame, strain, worst, finest, most_particles, inside)
      end do
      call check_close(worst(force), 0.0_dp, rounding, what//': a linear field leaves no force inside a body')
      call check_close(worst(mass), 0.0_dp, rounding, what//': the nodes have the mass of the body')
      call check_close(worst(momentum), 0.0_dp, rounding, what//': and their momentum')
      call check_close(worst(volume), 0.0_dp, rounding, what//': an element has as much volume as its particles')
      call check(worst(no_mass) <= 0, what//': every node of an element with particles has mass')
      call check(finest == most_levels .and. inside > 0, what//': there are meshes of all levels, and nodes inside')
      write (*, '(2a,i0,a,i0,a,i0,a)') what, ': ', sequences*meshes, ' meshes, ', inside, ' nodes inside, up to ', &
         most_particles, ' particles'
      write (*, '(a,4es9.1)') '   largest force, and errors of mass, momentum and volume:', worst(:volume)
   end subroutine random_meshes

   !> A body at random in a lattice, with a random linear field, and a mesh that changes at random, each time from the one
   !> before.
   subroutine sequence_of_meshes(total_frame, strain, worst, finest, most_particles, inside)
      logical, intent(in) :: total_frame
      real(dp), intent(in) :: strain
      real(dp), intent(inout) :: worst(5)
      integer, intent(inout) :: finest, most_particles, inside
      type(problem_t) :: m
      type(failure_t) :: failure
      type(forest_t) :: forest
      real(dp) :: found(5), mass_before, momentum_before(ndim)
      integer :: mesh
      call new_body(total_frame, strain, m)
      mass_before = sum(m%particles%mass)
      momentum_before = linear_momentum(m%particles)
      forest = m%grid%forest
      do mesh = 1, meshes
         if (forest%leaf_count() > most_leaves) then
            call change_at_random(forest, 0.0_dp, 0.6_dp, most_levels)
         else
            call change_at_random(forest, 0.2_dp, 0.1_dp, most_levels)
         end if
         call adopt_forest(m, forest, failure)
         if (failure%failed()) call check(.false., failure%message)
         call look(m, mass_before, momentum_before, found, inside)
         worst = max(worst, found)
         finest = max(finest, forest%finest_level())
         most_particles = max(most_particles, m%particles%n)
      end do
   end subroutine sequence_of_meshes

   !> A rectangle of whole cells, with u = H X and random velocities.
   subroutine new_body(total_frame, strain, m)
      logical, intent(in) :: total_frame
      real(dp), intent(in) :: strain
      type(problem_t), intent(out) :: m
      type(material_t) :: material
      real(dp) :: h(ndim, ndim)
      integer :: cells(ndim), first(ndim), last(ndim), d, i
      do d = 1, ndim
         cells(d) = random_integer(1, 4)
         first(d) = random_integer(0, min(1, cells(d) - 1))
         last(d) = random_integer(max(first(d) + 1, cells(d) - 1), cells(d))
      end do
      material = new_material('', 'linear_elastic', .true., 2.0_dp, 0.3_dp, 1.5_dp)
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, cells), material, &
                        [rectangle_t(first*cell, last*cell, 2*(last - first))], m)
      call random_number(h)
      h = strain*(2*h - 1)
      m%particles%total_frame = total_frame
      do i = 1, m%particles%n
         m%particles%gradient(i, :, :) = h
         m%particles%displacement(i, :) = matmul(h, m%particles%reference(i, :) - 0.5_dp*(first + last)*cell)
      end do
      call random_number(m%particles%velocity)
      call start(m, 'usl')
   end subroutine new_body

   !> Largest force at a node inside the body, in units of stress, edge of the finest leaf and thickness; errors of mass and
   !> momentum at the nodes; difference between the volume of an element and that of its particles, in parts of it; and nodes
   !> with forces that are without mass.
   subroutine look(m, mass_before, momentum_before, figures, inside)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: mass_before, momentum_before(ndim)  !! of the particles, before the first refinement
      real(dp), intent(out) :: figures(5)
      integer, intent(inout) :: inside           !! nodes inside bodies so far
      real(dp) :: stress
      integer :: e, node
      call refresh_grid(m)
      call assemble_sums(m, mass=.false., momentum=.false., force=.true.)
      associate (all => m%fields%mass_matrix%all, p => m%particles, blocks => m%blocks, f => m%fields)
         call m%grid%dofs%condense(all, ndim, f%force)
         stress = norm2(m%materials(1)%kirchhoff_stress(p%gradient_of(1)))
         figures = 0
         do node = 1, m%grid%n_nodes
            if (.not. is_inside(m, node)) cycle
            inside = inside + 1
            figures(force) = max(figures(force), maxval(abs(f%force(:, node)))/(stress*thickness*m%grid%finest_cell))
         end do
         figures(mass) = abs(sum(f%mass_matrix%lumped(:m%grid%n_nodes))/mass_before - 1)
         figures(momentum) = maxval(abs(sum(f%momentum(:, :m%grid%n_nodes), dim=2)/momentum_before - 1))
         figures(no_mass) = count(f%mass_matrix%lumped(all%nodes(:all%n_nodes)) <= 0)
         do e = 1, m%grid%n_elements
            if (m%blocks%count_in(e) == 0) cycle
            figures(volume) = max(figures(volume), abs(sum(p%volume(blocks%first_in(e):blocks%last_in(e):blocks%stride_in(e))) &
                                                       /(thickness*m%grid%element_size(e)**2) - 1))
         end do
      end associate
   end subroutine look

   !> Whether a node is strictly inside the body: all around it there is material. Elements with particles are full of them.
   logical function is_inside(m, node)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: node
      real(dp) :: x(ndim)
      integer :: k, e
      is_inside = .true.
      do k = 0, 3
         x = m%grid%node_position(:, node) + 0.25_dp*m%grid%finest_cell*[2*mod(k, 2) - 1, 2*(k/2) - 1]
         e = m%grid%element_at(x)
         if (e == outside) then
            is_inside = .false.
         else if (m%blocks%count_in(e) == 0) then
            is_inside = .false.
         end if
      end do
   end function is_inside
end program test_patch
