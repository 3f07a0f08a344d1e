!> The stiffness at small strain is symmetric, is the change of the internal forces, resists no rigid motion and passes the patch
!> test: with cells of two sizes, two materials and faces in contact.
program test_stiffness
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_gradients, inside_cell
   use hampm_constraints, only: constrain_box, hold
   use hampm_crack_lines, only: line_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_interface_points, only: contact
   use loading, only: load_on_points
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: unbalanced_force
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, start, thickness
   use hampm_sorting, only: sort_into_cells
   use hampm_stiffness, only: stiffness_t, new_stiffness, full_loads
   implicit none

   real(dp), parameter :: cell = 0.5_dp, length = 4.0_dp, depth = 2.0_dp, stress = 1e-3_dp
   real(dp), parameter :: young(2) = [1.0_dp, 2.0_dp], poisson(2) = [0.15_dp, 0.3_dp], density(2) = [2.0_dp, 3.0_dp]
   character(*), parameter :: meshes(2) = [character(8) :: 'uniform', 'refined']
   character(*), parameter :: laws(2) = [character(14) :: 'linear_elastic', 'neo_hookean']
   integer :: mesh, law, plane

   call repeat_random_numbers()
   do mesh = 1, size(meshes)
      call symmetric(mesh)
      call resists_no_rigid_motion(mesh)
      call stretched(mesh)
      call pressed_halves(mesh)
      do law = 1, size(laws)
         do plane = 1, 2
            call change_of_force(mesh, laws(law), plane == 1, total_frame=.true.)
            call change_of_force(mesh, laws(law), plane == 1, total_frame=.false.)
         end do
      end do
   end do
   call forces_without_loads()
   call too_many_unknowns()
   call finish()

contains

   !> A bar of two materials, one after the other, with smaller cells around the place where they meet or not.
   subroutine build(mesh, law, plane_stress, m, total_frame, line)
      integer, intent(in) :: mesh
      character(*), intent(in) :: law
      logical, intent(in) :: plane_stress
      type(problem_t), intent(out) :: m
      logical, intent(in), optional :: total_frame
      type(line_t), intent(in), optional :: line
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(line_t), allocatable :: lines(:)
      real(dp) :: half
      integer :: k
      half = length/2
      allocate (lines(0))
      if (present(line)) lines = [line]
      forest = forest_t([-cell, -cell], cell, [10, 6])
      call place_bodies(forest, new_material('', law, plane_stress, young(1), poisson(1), density(1)), &
                        [rectangle_t([0.0_dp, 0.0_dp], [half, depth], [16, 16]), &
                         rectangle_t([half, 0.0_dp], [length, depth], [16, 16])], m, lines)
      deallocate (m%materials)
      allocate (m%materials(2))
      do k = 1, 2
         m%materials(k) = new_material('', law, plane_stress, young(k), poisson(k), density(k))
      end do
      associate (p => m%particles)
         if (present(total_frame)) p%total_frame = total_frame
         where (p%body(:p%n) == 2)
            p%material(:p%n) = 2
            p%mass(:p%n) = p%mass(:p%n)*density(2)/density(1)
         end where
      end associate
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      m%interfaces%are_moving = .false.          ! faces that touch are as one, but for a layer that hardly gives way
      call start(m, 'musl')
      if (meshes(mesh) == 'uniform') return
      call refine_box(forest, [1.1_dp, 0.6_dp], [2.4_dp, 1.4_dp], 2)
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed(), 'there is a refined mesh')
   end subroutine build

   subroutine hold_box(m, lower, upper, components)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      logical, intent(in) :: components(ndim)
      call constrain_box(m%constraints, m%grid, lower, upper, components)
   end subroutine hold_box

   subroutine factorise(m, k)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: k
      logical :: done
      call new_stiffness(m, 100000, k, done)
      call check(done, 'the stiffness is factorised')
   end subroutine factorise

   !> A field of the points that is linear in place: u = a + b x, and 0 where there is no material.
   function linear_field(m, a, b) result(u)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: a(ndim), b(ndim, ndim)
      real(dp) :: u(ndim, m%grid%n_points)
      integer :: i
      u = 0
      do i = 1, m%fields%mass_matrix%all%n_nodes
         associate (node => m%fields%mass_matrix%all%nodes(i))
            u(:, node) = a + matmul(b, m%grid%node_position(:, node))
         end associate
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, u)
   end function linear_field

   !> Forces do to each other's points the same work (Betti).
   subroutine symmetric(mesh)
      integer, intent(in) :: mesh
      type(problem_t) :: m
      type(stiffness_t) :: k
      real(dp), allocatable :: f(:, :), g(:, :), u(:, :), v(:, :)
      call build(mesh, 'linear_elastic', .true., m)
      call hold_box(m, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .true.])
      call factorise(m, k)
      allocate (f(ndim, m%grid%n_points), g(ndim, m%grid%n_points))
      call random_number(f)
      call random_number(g)
      call k%solve(m, f, u)
      call k%solve(m, g, v)
      call check_close(sum(f*v)/sum(g*u), 1.0_dp, 1e-12_dp, trim(meshes(mesh))//': reciprocity')
      call check(sum(f*u) > 0 .and. sum(g*v) > 0, trim(meshes(mesh))//': forces do work')
      call k%release()
   end subroutine symmetric

   !> A displacement is found again from the difference of the internal forces for a small part of it forth and back: at hanging
   !> nodes, in both frames, for each law.
   subroutine change_of_force(mesh, law, plane_stress, total_frame)
      integer, intent(in) :: mesh
      character(*), intent(in) :: law
      logical, intent(in) :: plane_stress, total_frame
      real(dp), parameter :: part = 1e-5_dp
      type(problem_t) :: m
      type(stiffness_t) :: k
      real(dp), allocatable :: u(:, :), small(:, :), forth(:, :), back(:, :), found(:, :)
      call build(mesh, law, plane_stress, m, total_frame)
      call hold_box(m, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .true.])
      allocate (u(ndim, m%grid%n_points), source=0.0_dp)
      call random_where_material(m, u)
      small = part*u
      call force_of(m, small, forth)
      small = -small
      call force_of(m, small, back)
      call factorise(m, k)
      call k%solve(m, (back - forth)/(2*part), found)
      call check_close(maxval(abs(found - u)), 0.0_dp, 1e-6_dp, trim(meshes(mesh))//', '//trim(law)// &
                       merge(', plane stress', ', plane strain', plane_stress)//merge(', total:  ', ', updated:', total_frame)// &
                       ' displacement from forces')
      call k%release()
   end subroutine change_of_force

   !> Random displacements of up to 1 of all nodes that are not held.
   subroutine random_where_material(m, u)
      type(problem_t), intent(in) :: m
      real(dp), intent(inout) :: u(:, :)
      real(dp) :: of_node(ndim)
      integer :: i
      associate (all => m%fields%mass_matrix%all)
         do i = 1, all%n_nodes
            call random_number(of_node)
            u(:, all%nodes(i)) = of_node
         end do
         call hold(m%constraints, u)
         call m%grid%dofs%distribute(all, ndim, u)
      end associate
   end subroutine random_where_material

   !> Internal forces for a small displacement of the points.
   subroutine force_of(m, u, internal)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: u(:, :)
      real(dp), allocatable, intent(out) :: internal(:, :)
      real(dp), allocatable :: force(:, :)
      real(dp) :: gradient(corners, ndim), x(ndim)
      integer :: i
      associate (p => m%particles, grid => m%grid)
         do i = 1, p%n
            x = p%place_in_grid(i)
            gradient = shape_gradients(inside_cell(grid%local_coordinate(p%cell(i), x)), 1/grid%element_size(p%cell(i)))
            p%gradient(i, :, :) = matmul(u(:, grid%element_nodes(:, p%cell(i))), gradient)
         end do
      end associate
      m%cache%mapped = .false.
      call unbalanced_force(m, force, internal)
   end subroutine force_of

   !> Of a body that nothing holds the stiffness is only that of the interface points: a force on each particle in proportion to its mass and
   !> to a rigid motion moves the body by that motion, 1/interface point as far. Any part of K that resists it would be seen as if it were
   !> a hundred million times as large.
   subroutine resists_no_rigid_motion(mesh)
      integer, intent(in) :: mesh
      type(problem_t) :: m
      type(stiffness_t) :: k
      real(dp), parameter :: turn(ndim, ndim) = reshape([0, 1, -1, 0], [ndim, ndim]), none(ndim, ndim) = 0
      real(dp), allocatable :: motion(:, :), u(:, :)
      character(*), parameter :: names(3) = [character(12) :: 'moving in x', 'moving in y', 'turning']
      integer :: i
      call build(mesh, 'linear_elastic', .true., m)
      call factorise(m, k)
      do i = 1, size(names)
         motion = linear_field(m, real(merge([1, 0], [0, 1], i == 1), dp)*merge(1, 0, i < 3), merge(turn, none, i == 3))
         call k%solve(m, k%point*quarters_of_mass(m)*motion, u)
         call check_close(maxval(abs(u - motion)), 0.0_dp, 1e-4_dp, trim(meshes(mesh))//': nothing resists '//trim(names(i)))
      end do
      call k%release()
   end subroutine resists_no_rigid_motion

   !> What is at each point of the mass, a quarter of each particle at each corner of its cell [kg].
   pure function quarters_of_mass(m) result(mass)
      type(problem_t), intent(in) :: m
      real(dp) :: mass(ndim, m%grid%n_points)
      integer :: i
      mass = 0
      do i = 1, m%particles%n
         associate (at => m%grid%element_nodes(:, m%particles%cell(i)))
            mass(:, at) = mass(:, at) + m%particles%mass(i)/corners
         end associate
      end do
   end function quarters_of_mass

   !> Put a stress on the right end of the bar.
   subroutine load_end(m, along)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: along              !! [Pa]
      integer, parameter :: parts = 32           ! eight a cell
      real(dp) :: points(ndim, parts)
      integer :: i
      do i = 1, parts
         points(:, i) = [length, (i - 0.5_dp)/parts*depth]
      end do
      deallocate (m%loads)
      allocate (m%loads(1))
      m%loads(1)%force = [along*thickness*depth, 0.0_dp]
      call load_on_points(m%matter_t, points, [0.0_dp, depth/(2*parts)], m%loads(1))
   end subroutine load_end

   !> Displacement of the bar by a stress along it: each half stretches by stress/E, and all contracts by nu stress/E.
   function stretched_bar(m, along) result(u)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: along              !! stress [Pa]
      real(dp) :: u(ndim, m%grid%n_points)
      integer :: i
      u = 0
      do i = 1, m%fields%mass_matrix%all%n_nodes
         associate (node => m%fields%mass_matrix%all%nodes(i))
            associate (x => m%grid%node_position(:, node))
               u(:, node) = along*[min(x(1), length/2)/young(1) + max(x(1) - length/2, 0.0_dp)/young(2), &
                                   -poisson(1)/young(1)*x(2)]
            end associate
         end associate
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, u)
   end function stretched_bar

   !> Patch test: a bar in tension, of two materials that contract alike, has one stress.
   subroutine stretched(mesh)
      integer, intent(in) :: mesh
      type(problem_t) :: m
      type(stiffness_t) :: k
      real(dp), allocatable :: force(:, :), u(:, :)
      call build(mesh, 'linear_elastic', .true., m)
      call hold_box(m, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .false.])
      call hold_box(m, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp], [.false., .true.])
      call load_end(m, stress)
      call full_loads(m, force)
      call factorise(m, k)
      call k%solve(m, force, u)
      call check_close(maxval(abs(u - stretched_bar(m, stress)))/(stress*length), 0.0_dp, 1e-7_dp, &
                       trim(meshes(mesh))//': a bar of two materials in tension')
      call k%release()
   end subroutine stretched

   !> The bar in two halves, one beside the other: where they touch they shrink under a pressure as one piece does, but for the layer between
   !> them; apart, nothing but the soft interface points stops the one that is pushed.
   subroutine pressed_halves(mesh)
      integer, intent(in) :: mesh
      type(problem_t) :: m
      type(stiffness_t) :: k
      type(line_t) :: line
      real(dp), allocatable :: force(:, :), u(:, :)
      real(dp) :: gives                          !! way by which the layer between the halves gives in [m]
      integer :: i
      line%points = reshape([length/2, -9.0_dp, length/2, 9.0_dp], [ndim, 2])
      line%contact = .true.
      call build(mesh, 'linear_elastic', .true., m, line=line)
      call hold_box(m, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .false.])
      call hold_box(m, [0.0_dp, 0.0_dp], [length, 0.0_dp], [.false., .true.])
      call load_end(m, -stress)
      call full_loads(m, force)
      associate (faces => m%interfaces)
         call check_close(sum(faces%list(:faces%n)%length, &
                              mask=[(faces%list(i)%law == contact .and. abs(faces%list(i)%place(2) - depth/2) < depth/2, &
                                     i=1, faces%n)]), depth, 1e-12_dp, &
                          trim(meshes(mesh))//': all along the halves are interface points')
         call factorise(m, k)
         call k%solve(m, force, u)
         gives = stress*depth*thickness/sum(faces%list(:faces%n)%stiffness)
         call check(gives < 1e-5_dp*stress*length, trim(meshes(mesh))//': the layer between them hardly gives in')
         call check_close((maxval(abs(u - stretched_bar(m, -stress))) - gives)/(stress*length), 0.0_dp, 1e-6_dp, &
                          trim(meshes(mesh))//': but for that, halves that touch are one piece')
         do i = 1, faces%n
            faces%list(i)%opening = faces%list(i)%cell*faces%list(i)%normal
         end do
      end associate
      call factorise(m, k)
      call k%solve(m, force, u)
      call check(minval(u(1, :)) < -1e6_dp*stress*length, trim(meshes(mesh))//': halves that are apart go on')
      call k%release()
   end subroutine pressed_halves

   !> Without a load the forces are those that take all momentum while a wave runs through the body.
   subroutine forces_without_loads()
      type(problem_t) :: m
      real(dp), allocatable :: force(:, :)
      real(dp) :: momentum(ndim)
      call build(2, 'linear_elastic', .true., m)
      associate (p => m%particles)
         call random_number(p%velocity)
         momentum = matmul(p%mass(:p%n), p%velocity(:p%n, :))
      end associate
      call full_loads(m, force)
      associate (whole => sum(force, dim=2), speed => m%materials(1)%dilatational_wave_speed(), p => m%particles)
         call check_close(norm2(whole/norm2(whole) + momentum/norm2(momentum)), 0.0_dp, 1e-14_dp, 'forces that stop the bodies')
         call check_close(norm2(whole)/norm2(momentum)*maxval(maxval(p%reference(:p%n, :), dim=1) &
                                                               - minval(p%reference(:p%n, :), dim=1))/speed, &
                          1.0_dp, 0.3_dp, 'in the time of a wave')
      end associate
   end subroutine forces_without_loads

   !> What would take too much is not done.
   subroutine too_many_unknowns()
      type(problem_t) :: m
      type(stiffness_t) :: k
      logical :: done
      call build(1, 'linear_elastic', .true., m)
      associate (unknowns => ndim*m%fields%mass_matrix%all%n_nodes)
         call new_stiffness(m, unknowns - 1, k, done)
         call check(.not. done, 'one unknown too many')
         call new_stiffness(m, unknowns, k, done)
         call check(done, 'as many unknowns as may be')
      end associate
      call k%release()
   end subroutine too_many_unknowns
end program test_stiffness
