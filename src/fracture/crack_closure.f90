!> Energy release rate of a crack on a symmetry plane by crack closure. Mode II vanishes there by symmetry.
module hampm_crack_closure
   use hampm_kinds, only: dp, ndim
   use hampm_crack, only: crack_t
   use hampm_extrapolation, only: extrapolate
   use hampm_failure, only: failure_t
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_patch, only: patch_t, patch_around, fitted_displacement, internal_force
   implicit none
   private
   public :: crack_opening, stress_closure, nodal_force_closure

contains

   !> Opening of the crack one cell behind its tip, both faces together [m].
   pure real(dp) function crack_opening(crack, grid, p) result(opening)
      type(crack_t), intent(in) :: crack
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(patch_t) :: patch
      real(dp) :: u(ndim)
      call patch_around(grid, p, crack%node_behind, patch)
      u = fitted_displacement(patch, p)
      opening = 2*crack%side*u(crack%normal)
   end function crack_opening

   !> G_I by stress closure, (14): displacement of node (1) and normal stress at nodes (2) and (3), each extrapolated with
   !> the mass matrix of the run [J/m2]. It tends to a constant times G as cells become small: the constant is about 0.33
   !> with the lumped and 0.52 with the full matrix, because the near-tip fields look alike at every cell size.
   !> `nodal_force_closure` tends to G. Signed like the opening. Fails where the equations cannot be solved.
   subroutine stress_closure(crack, grid, p, materials, matrix, solver, g, failure)
      type(crack_t), intent(in) :: crack
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(mass_matrix_t), intent(in) :: matrix
      type(mass_solver_t), intent(inout) :: solver     !! without held components
      real(dp), intent(out) :: g
      type(failure_t), intent(inout) :: failure
      integer, parameter :: u = 1, s = 2               ! components of the fields: normal displacement and stress
      real(dp), allocatable :: field(:, :), nodal(:, :)
      real(dp) :: stress(ndim, ndim)
      integer :: i
      allocate (field(ndim, p%n), nodal(ndim, grid%n_points), source=0.0_dp)
      do i = 1, p%n
         stress = materials(p%material(i))%kirchhoff_stress(p%gradient(:, :, i))
         field([u, s], i) = [p%displacement(crack%normal, i), stress(crack%normal, crack%normal)]
      end do
      call extrapolate(grid, p, matrix, solver, field, nodal, failure)
      g = crack%side*nodal(u, crack%node_behind)/6*abs(2*nodal(s, crack%node_tip) + nodal(s, crack%node_ahead))
   end subroutine stress_closure

   !> G_I by nodal force closure (Rybicki & Kanninen 1977): the force that the symmetry plane transmits at the tip node
   !> times the opening one cell behind it, over twice the area of that cell's face [J/m2]. In a symmetric half model the
   !> force is the reaction of the constraint, opposite to the internal force. Signed like the opening.
   pure real(dp) function nodal_force_closure(crack, grid, p, materials, thickness) result(g)
      type(crack_t), intent(in) :: crack
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: thickness          !! [m]
      type(patch_t) :: patch
      real(dp) :: force(ndim)
      call patch_around(grid, p, crack%node_tip, patch)
      force = internal_force(patch, p, materials)
      g = abs(force(crack%normal))*crack_opening(crack, grid, p)/(2*crack%step*thickness)
   end function nodal_force_closure
end module hampm_crack_closure
