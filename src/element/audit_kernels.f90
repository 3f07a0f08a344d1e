!> Sums of the energy balance over the particles of a block during a pass (arrays: `hampm_particle_kernels`).
module hampm_audit_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes
   use hampm_law, only: most_columns
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: product_of
   implicit none
   private
   public :: kick_energy, strain_work, work_of_change, work_of_hoop

   real(dp), parameter :: gauss(2) = 0.5_dp + [-0.5_dp, 0.5_dp]/sqrt(3.0_dp) !! places of Gauss's rule, 0 to 1

contains

   !> Sum of m |dv|**2 / 2, dv being interpolated from the nodes [J].
   pure real(dp) function kick_energy(rows, ld, xi, a, mass) result(energy)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld)
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! dv of the nodes [m/s]
      integer :: l, k, d
      energy = 0
      do k = 1, lanes*rows
         l = mod(k - 1, lanes) + 1
         do d = 1, ndim
            energy = energy + 0.5_dp*mass(k)*value_at(xi(k, :), a(l, :, d))**2
         end do
      end do
   end function kick_energy

   !> A field of the polynomials of `hampm_particle_kernels` at a place of a cell.
   pure real(dp) function value_at(xi, a) result(value)
      real(dp), intent(in) :: xi(ndim), a(corners)
      value = a(1) + xi(1)*a(2) + xi(2)*(a(3) + xi(1)*a(4))
      if (ndim > 2) value = value + xi(ndim)*(a(corners - 3) + xi(1)*a(corners - 2) + xi(2)*(a(corners - 1) + xi(1)*a(corners)))
   end function value_at

   !> Its gradient.
   pure function gradient_at(xi, a) result(gradient)
      real(dp), intent(in) :: xi(ndim), a(corners)
      real(dp) :: gradient(ndim)
      gradient(1) = a(2) + xi(2)*a(4)
      gradient(2) = a(3) + xi(1)*a(4)
      if (ndim == 2) return
      gradient(1) = gradient(1) + xi(ndim)*(a(corners - 2) + xi(2)*a(corners))
      gradient(2) = gradient(2) + xi(ndim)*(a(corners - 1) + xi(1)*a(corners))
      gradient(ndim) = a(corners - 3) + xi(1)*a(corners - 2) + xi(2)*(a(corners - 1) + xi(1)*a(corners))
   end function gradient_at

   !> Work of the stress in the next strain step [J], by Gauss's rule of two points, exact to the third order as Simpson's of three;
   !> of a linear law the stress in the middle suffices, of a law with a history the stresses at the ends.
   pure real(dp) function strain_work(rows, ld, xi, a, materials, material, volume, h, total_frame, dt, p, number) &
      result(work)
      integer, intent(in) :: rows, ld, material(ld)
      real(dp), intent(in) :: xi(ld, ndim), volume(ld), h(ld, ndim, ndim)
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! displacement of the nodes over the size of the cells [-]
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: total_frame
      real(dp), intent(in) :: dt                        !! [s]
      type(particles_t), intent(in) :: p
      integer, intent(in) :: number(lanes*rows)         !! of the particles, 0 for none; not set where no law has a history
      real(dp) :: before(ndim, ndim), change(ndim, ndim)
      integer :: l, k, d
      work = 0
      do k = 1, lanes*rows
         l = mod(k - 1, lanes) + 1
         before = h(k, :, :)
         do d = 1, ndim
            change(d, :) = gradient_at(xi(k, :), a(l, :, d))
         end do
         if (.not. total_frame) change = change + product_of(change, before)
         work = work + volume(k)*work_of_change(materials(material(k)), before, change, dt, p, number(k))
      end do
   end function strain_work

   !> Work of the stress per volume [J/m3], see `strain_work`; of axisymmetric material at the hoop stretch that it has.
   pure real(dp) function work_of_change(material, before, change, dt, p, number, hoop) result(work)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: before(ndim, ndim), change(ndim, ndim) !! displacement gradient and its change [-]
      real(dp), intent(in) :: dt                        !! over which it changes [s]
      type(particles_t), intent(in) :: p
      integer, intent(in) :: number                     !! of the particle; may be not set where the law has no history
      real(dp), intent(in), optional :: hoop            !! H_33 [-]
      if (material%has_history) then
         work = work_of_step(material, before, change, dt, p%history_of(number), hoop)
      else if (material%linear) then
         work = sum(change*material%first_piola_stress(before + change/2, hoop=hoop))
      else
         work = work_of_step(material, before, change, dt, [real(dp) ::], hoop)
      end if
   end function work_of_change

   !> Work of the stress per volume in a step of length `dt` [J/m3]. Nonlinear elasticity: Gauss's rule. A law with a history: the
   !> trapezoidal rule or, if it does not yield, the change of stored and dissipated energy, exact at a constant strain rate.
   pure real(dp) function work_of_step(material, before, change, dt, old_state, hoop) result(work)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: before(ndim, ndim), change(ndim, ndim) !! displacement gradient and its change [-]
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), contiguous, intent(in) :: old_state(:)  !! state variables of the particle, none without a history
      real(dp), intent(in), optional :: hoop            !! H_33 [-]
      real(dp) :: next(size(old_state))
      if (.not. material%has_history) then
         work = sum(change*(material%first_piola_stress(before + gauss(1)*change, hoop=hoop) &
                            + material%first_piola_stress(before + gauss(2)*change, hoop=hoop)))/2
         return
      end if
      next = old_state
      call material%update_state(before + change, dt, next, hoop)
      if (.not. material%yields) then
         work = material%energy_density(before + change, next, hoop) + material%dissipation(before + change, next, hoop) &
                - material%energy_density(before, old_state, hoop) - material%dissipation(before, old_state, hoop)
         return
      end if
      work = sum(change*(material%first_piola_stress(before, old_state, hoop) &
                         + material%first_piola_stress(before + change, next, hoop)))/2
   end function work_of_step

   !> Work of the hoop stress per volume as a particle of axisymmetric material is widened, by Gauss's rule [J/m3].
   pure real(dp) function work_of_hoop(material, before, p, i) result(work)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: before                    !! H_33 that it had [-]
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i                          !! its number
      real(dp) :: h(ndim, ndim), old_state(most_columns)
      h = p%gradient_of(i)
      old_state = p%history_of(i)
      associate (after => p%hoop_of(i))
         work = (after - before)*(material%hoop_stress(h, old_state, before + gauss(1)*(after - before)) &
                                  + material%hoop_stress(h, old_state, before + gauss(2)*(after - before)))/2
      end associate
   end function work_of_hoop
end module hampm_audit_kernels
