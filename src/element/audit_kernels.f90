!> What the energy balance sums over the particles of a block during a pass (see `hampm_particle_kernels` for the arrays).
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
            energy = energy + 0.5_dp*mass(k)*(a(l, 1, d) + xi(k, 1)*a(l, 2, d) + xi(k, 2)*(a(l, 3, d) + xi(k, 1)*a(l, 4, d)))**2
         end do
      end do
   end function kick_energy

   !> Work of the stress in the strain step that follows, by Gauss's rule of two places, which is exact to the third order as Simpson's of
   !> three is [J]; of a linear law the stress in the middle is enough, and of a law with a history there are those at the ends.
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
      integer :: l, k
      work = 0
      do k = 1, lanes*rows
         l = mod(k - 1, lanes) + 1
         before = h(k, :, :)
         change(:, 1) = a(l, 2, :) + xi(k, 2)*a(l, 4, :)
         change(:, 2) = a(l, 3, :) + xi(k, 1)*a(l, 4, :)
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
         work = history_work(material, before, change, dt, p%history_of(number), hoop)
      else if (material%linear) then
         work = sum(change*material%first_piola_stress(before + change/2, hoop=hoop))
      else
         work = sum(change*(material%first_piola_stress(before + gauss(1)*change, hoop=hoop) &
                            + material%first_piola_stress(before + gauss(2)*change, hoop=hoop)))/2
      end if
   end function work_of_change

   !> Work of the stress of a law with a history per volume in a step of length `dt`, by the rule of trapezoids [J/m3].
   pure real(dp) function history_work(material, before, change, dt, old_state, hoop) result(work)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: before(ndim, ndim), change(ndim, ndim) !! displacement gradient and its change [-]
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), contiguous, intent(in) :: old_state(:)  !! state variables of the particle
      real(dp), intent(in), optional :: hoop            !! H_33 [-]
      real(dp) :: next(size(old_state))
      next = old_state
      call material%update_state(before + change, dt, next, hoop)
      work = sum(change*(material%first_piola_stress(before, old_state, hoop) &
                         + material%first_piola_stress(before + change, next, hoop)))/2
   end function history_work

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
