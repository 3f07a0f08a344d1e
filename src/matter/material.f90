!> A material: its law with its constants, and the stress and energy that follow from the displacement gradient.
!>
!> Laws with a history need what a particle remembers, `past`, too; without it their numbers are not numbers. It is that of the
!> last state that was kept (`follow`). Explicit steps keep it whenever they strain the particles. At rest trial states must not:
!> while `on_trial`, stress, tangent and energies are those at the end of a step that began with `past` and lasts `elapsed`.
module hampm_material
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_j2_plastic, only: j2_constants_t, j2_columns, j2_equivalent, j2_follow, j2_stress, j2_change, j2_energy_density, &
                               j2_dissipation
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_linear_elastic, only: linear_stress, linear_energy_density, linear_stress_energy_density
   use hampm_neo_hookean, only: neo_hookean_kirchhoff, neo_hookean_first_piola, neo_hookean_energy_density, &
                                  neo_hookean_piola_change
   use hampm_orthotropic, only: orthotropic_t, n_voigt, plane_compliance, inverse_of, turned_stiffness, turned_compliance, &
                                voigt_stress, voigt_energy_density, voigt_stress_energy_density, acoustic_modulus
   use hampm_viscoelastic, only: prony_t, new_prony, prony_columns, prony_follow, prony_stress, prony_change, &
                                 prony_energy_density, prony_dissipation
   implicit none
   private
   public :: material_t, new_material, new_orthotropic, laws

   integer, parameter :: linear_elastic = 1, neo_hookean = 2, j2_plastic = 3, viscoelastic = 4, orthotropic = 5
   character(*), parameter :: laws(*) = [character(14) :: 'linear_elastic', 'neo_hookean', 'j2_plastic', & !! their names in
                                                       'viscoelastic', 'orthotropic'] !! scenes, in this order

   !> A law with its constants.
   type :: material_t
      character(name_len) :: name = ''
      integer, private :: law = linear_elastic   !! its place in `laws`
      logical :: linear = .true.                 !! whether that is a linear one
      logical :: isotropic = .true.              !! else `young` and `poisson` have no meaning
      logical :: plane_stress = .true.           !! else plane strain
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! in the reference configuration [kg/m3]
      real(dp) :: lambda = 0                     !! Lame constant; of linear laws in plane stress lambda' [Pa]
      real(dp) :: mu = 0                         !! shear modulus [Pa]
      logical :: mean_dilatation = .false.       !! whether its dilatation is the mean over a cell (`hampm_mean_dilatation`)
      integer :: columns = 0                     !! how many numbers a particle of it remembers
      logical :: on_trial = .false.              !! whether states are tried that are not kept
      real(dp) :: elapsed = 0                    !! since the last that was kept [s]
      type(j2_constants_t), private :: j2
      type(prony_t), private :: prony
      ! Of an orthotropic material, where lambda and mu are C_12 and C_66 in its axes; of the columns (11, 22, 12):
      real(dp) :: stiffness(n_voigt, n_voigt) = 0  !! in x and y [Pa]
      real(dp) :: compliance(n_voigt, n_voigt) = 0 !! its inverse [1/Pa]
      real(dp) :: in_its_axes(n_voigt, n_voigt) = 0 !! the compliance in the axes of the material [1/Pa]
      real(dp) :: angle = 0                      !! of its axis 1 from x [degrees]
      real(dp), private :: fastest = 0           !! rho c**2 of the fastest waves [Pa]
      ! Strain without stress, of the linear law only: `give_eigenstrain`
      logical :: has_eigenstrain = .false.
      real(dp) :: free(ndim, ndim) = 0  !! strain in the plane at which there is no stress in it [-]
      real(dp), private :: out_of_plane = 0      !! energy density there, of the stress normal to it [J/m3]
   contains
      procedure :: give_eigenstrain
      procedure :: law_name
      procedure :: has_history
      procedure :: is_finite
      procedure :: yields
      procedure :: follow
      procedure :: equivalent_plastic_strain
      procedure :: plastic_dissipation
      procedure :: viscous_dissipation
      procedure :: kirchhoff_stress
      procedure :: conjugate_stress
      procedure :: conjugate_change
      procedure :: mapped_stress
      procedure :: energy_density
      procedure :: stress_energy_density
      procedure :: small_strain_stress
      procedure :: small_strain_moduli
      procedure :: small_strain_lambda
      procedure :: plane_modulus
      procedure :: shear_wave_speed
      procedure :: dilatational_wave_speed
   end type material_t

contains

   !> A material from its engineering constants; of the orthotropic law one that is isotropic.
   pure function new_material(name, law, plane_stress, young, poisson, density, yield_stress, hardening, moduli, &
                              relaxation_times) result(m)
      character(*), intent(in) :: name
      character(*), intent(in) :: law            !! one of `laws`
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(in) :: young              !! [Pa]
      real(dp), intent(in) :: poisson            !! [-], below 0.5
      real(dp), intent(in) :: density            !! [kg/m3]
      real(dp), intent(in), optional :: yield_stress, hardening !! of 'j2_plastic', which else does not yield [Pa]
      real(dp), intent(in), optional :: moduli(:), relaxation_times(:) !! of 'viscoelastic', which else does not relax [Pa, s]
      type(material_t) :: m
      m%name = name
      m%law = findloc(laws, law, dim=1)
      if (m%law == orthotropic) then
         m = new_orthotropic(name, plane_stress, orthotropic_t(spread(young, 1, 3), young/(2*(1 + poisson)), poisson, poisson, &
                                                               poisson), density)
         return
      end if
      m%linear = m%law == linear_elastic
      m%plane_stress = plane_stress
      m%young = young
      m%poisson = poisson
      m%density = density
      m%mu = young/(2*(1 + poisson))
      m%lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
      if (m%linear .and. plane_stress) m%lambda = young*poisson/(1 - poisson**2)
      if (m%law == j2_plastic) then
         m%j2 = j2_constants_t(m%lambda, m%mu, plane_stress, sqrt(huge(1.0_dp)))
         if (present(yield_stress)) m%j2%yield_stress = yield_stress
         if (present(hardening)) m%j2%hardening = hardening
         m%columns = j2_columns
      else if (m%law == viscoelastic) then
         m%prony = prony_t(m%lambda + 2*m%mu/3, m%mu, plane_stress, rest=m%mu)
         if (present(moduli)) m%prony = new_prony(m%prony%kappa, m%mu, plane_stress, moduli, relaxation_times)
         m%columns = prony_columns(m%prony)
      end if
   end function new_material

   !> Give the linear law a strain eps0 at which there is no stress: stress = C : (eps - eps0), energy density (eps - eps0) : C : (eps - eps0)/2.
   !> In plane strain what is kept from the strain normal to the plane, by a stress of -E eps0_zz where there is none in the plane, adds
   !> nu eps0_zz to the strain in the plane.
   pure subroutine give_eigenstrain(self, eigenstrain)
      class(material_t), intent(inout) :: self
      real(dp), intent(in) :: eigenstrain(4)     !! components xx, yy, xy and zz of the tensor [-]
      associate (e => eigenstrain)
         self%has_eigenstrain = any(abs(e) > 0)
         self%free = reshape([e(1), e(3), e(3), e(2)], [ndim, ndim])
         if (self%plane_stress) return
         self%free(1, 1) = self%free(1, 1) + self%poisson*e(4)
         self%free(2, 2) = self%free(2, 2) + self%poisson*e(4)
         self%out_of_plane = self%young*e(4)**2/2
      end associate
   end subroutine give_eigenstrain

   !> An orthotropic material, whose constants make it positive definite.
   pure function new_orthotropic(name, plane_stress, constants, density) result(m)
      character(*), intent(in) :: name
      logical, intent(in) :: plane_stress        !! else plane strain
      type(orthotropic_t), intent(in) :: constants
      real(dp), intent(in) :: density            !! [kg/m3]
      type(material_t) :: m
      real(dp) :: of_axes(n_voigt, n_voigt)      ! stiffness in the axes of the material [Pa]
      m%name = name
      m%in_its_axes = plane_compliance(constants, plane_stress)
      of_axes = inverse_of(m%in_its_axes)
      m%law = orthotropic
      m%isotropic = .false.
      m%plane_stress = plane_stress
      m%density = density
      m%mu = constants%shear_12
      m%lambda = of_axes(1, 2)
      m%angle = constants%angle
      m%compliance = turned_compliance(m%in_its_axes, m%angle)
      m%stiffness = turned_stiffness(of_axes, m%angle)
      m%fastest = acoustic_modulus(of_axes)
   end function new_orthotropic

   !> The name of its law in scenes.
   pure function law_name(self) result(name)
      class(material_t), intent(in) :: self
      character(:), allocatable :: name
      name = trim(laws(self%law))
   end function law_name

   !> Whether stress depends on what has been.
   elemental logical function has_history(self)
      class(material_t), intent(in) :: self
      has_history = self%columns > 0
   end function has_history

   !> Whether the law is meant for any rotation and strain, with which bodies may buckle.
   elemental logical function is_finite(self)
      class(material_t), intent(in) :: self
      is_finite = self%law == neo_hookean
   end function is_finite

   !> Whether the law is one of plasticity.
   elemental logical function yields(self)
      class(material_t), intent(in) :: self
      yields = self%law == j2_plastic
   end function yields

   !> Remember a step of length `dt` at the end of which the displacement gradient is `h`.
   pure subroutine follow(self, h, dt, past)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), contiguous, intent(inout) :: past(:) !! what the particle remembers
      select case (self%law)
       case (j2_plastic)
         call j2_follow(self%j2, h, past)
       case (viscoelastic)
         call prony_follow(self%prony, h, dt, past)
      end select
   end subroutine follow

   !> What a particle would remember of the present state: of a trial state more than it does.
   pure function present_of(self, h, past) result(now)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: past(:)
      real(dp) :: now(size(past))
      now = past
      if (self%on_trial) call self%follow(h, self%elapsed, now)
   end function present_of

   !> Equivalent plastic strain [-].
   pure real(dp) function equivalent_plastic_strain(self, past) result(strain)
      class(material_t), intent(in) :: self
      real(dp), contiguous, intent(in) :: past(:)
      strain = 0
      if (self%law == j2_plastic) strain = past(j2_equivalent)
   end function equivalent_plastic_strain

   !> Work on the plastic strain per reference volume [J/m3].
   pure real(dp) function plastic_dissipation(self, h, past) result(work)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: past(:)
      work = 0
      if (self%law == j2_plastic) work = j2_dissipation(self%j2, present_of(self, h, past))
   end function plastic_dissipation

   !> Energy that viscosity has taken per reference volume [J/m3].
   pure real(dp) function viscous_dissipation(self, h, past) result(energy)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: past(:)
      energy = 0
      if (self%law == viscoelastic) energy = prony_dissipation(present_of(self, h, past))
   end function viscous_dissipation

   !> Stress of the laws with a history [Pa].
   pure function remembered_stress(self, h, past) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in), optional :: past(:)
      real(dp) :: stress(ndim, ndim)
      stress = ieee_value(1.0_dp, ieee_quiet_nan)
      if (.not. present(past)) return
      if (self%law == j2_plastic) then
         stress = j2_stress(self%j2, h, present_of(self, h, past))
      else
         stress = prony_stress(self%prony, h, self%elapsed, past)
      end if
   end function remembered_stress

   !> What a small change of H makes of that stress: while `on_trial` along the step, else as sudden strains do [Pa].
   pure function remembered_change(self, h, dh, past) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim), dh(ndim, ndim)
      real(dp), contiguous, intent(in), optional :: past(:)
      real(dp) :: change(ndim, ndim)
      change = ieee_value(1.0_dp, ieee_quiet_nan)
      if (self%law == viscoelastic) then
         change = prony_change(self%prony, dh, self%elapsed)
      else if (.not. self%on_trial) then
         change = linear_stress(self%small_strain_lambda(), self%mu, dh)
      else if (present(past)) then
         change = j2_change(self%j2, h, dh, past)
      end if
   end function remembered_change

   !> Elastic energy per reference volume of the laws with a history [J/m3].
   pure real(dp) function remembered_energy_density(self, h, past) result(energy)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in), optional :: past(:)
      energy = ieee_value(1.0_dp, ieee_quiet_nan)
      if (.not. present(past)) return
      if (self%law == j2_plastic) then
         energy = j2_energy_density(self%j2, h, present_of(self, h, past))
      else
         energy = prony_energy_density(self%prony, h, present_of(self, h, past))
      end if
   end function remembered_energy_density

   !> Kirchhoff stress [Pa], which times the reference volume and the spatial gradient of a shape function is a force.
   pure function kirchhoff_stress(self, h, past) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), contiguous, intent(in), optional :: past(:)  !! what the particle remembers
      real(dp) :: stress(ndim, ndim)
      stress = 0
      select case (self%law)
       case (linear_elastic)
         stress = linear_stress(self%lambda, self%mu, h - self%free)
       case (orthotropic)
         stress = voigt_stress(self%stiffness, h)
       case (neo_hookean)
         stress = neo_hookean_kirchhoff(self%lambda, self%mu, self%plane_stress, h)
       case (j2_plastic, viscoelastic)
         stress = remembered_stress(self, h, past)
      end select
   end function kirchhoff_stress

   !> The stress whose product with the change of H is the change of the energy density [Pa].
   pure function conjugate_stress(self, h, past) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), contiguous, intent(in), optional :: past(:)  !! what the particle remembers
      real(dp) :: stress(ndim, ndim)
      stress = 0
      select case (self%law)
       case (linear_elastic)
         stress = linear_stress(self%lambda, self%mu, h - self%free)
       case (orthotropic)
         stress = voigt_stress(self%stiffness, h)
       case (neo_hookean)
         stress = neo_hookean_first_piola(self%lambda, self%mu, self%plane_stress, h)
       case (j2_plastic, viscoelastic)
         stress = remembered_stress(self, h, past)
      end select
   end function conjugate_stress

   !> What a small change of H makes of `conjugate_stress` [Pa].
   pure function conjugate_change(self, h, dh, past) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(ndim, ndim)     !! its change [-]
      real(dp), contiguous, intent(in), optional :: past(:)  !! what the particle remembers
      real(dp) :: change(ndim, ndim)
      change = 0
      select case (self%law)
       case (linear_elastic)
         change = linear_stress(self%lambda, self%mu, dh)
       case (orthotropic)
         change = voigt_stress(self%stiffness, dh)
       case (neo_hookean)
         change = neo_hookean_piola_change(self%lambda, self%mu, self%plane_stress, h, dh)
       case (j2_plastic, viscoelastic)
         change = remembered_change(self, h, dh, past)
      end select
   end function conjugate_change

   !> The stress that with the gradients of the shape functions of a frame gives the internal force [Pa].
   pure function mapped_stress(self, h, total_frame, past) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      logical, intent(in) :: total_frame         !! gradients at the reference positions, else at the present ones
      real(dp), contiguous, intent(in), optional :: past(:)  !! what the particle remembers
      real(dp) :: stress(ndim, ndim)
      if (total_frame) then
         stress = self%conjugate_stress(h, past)
      else
         stress = self%kirchhoff_stress(h, past)
      end if
   end function mapped_stress

   !> Elastic energy per reference volume [J/m3].
   pure real(dp) function energy_density(self, h, past)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), contiguous, intent(in), optional :: past(:)  !! what the particle remembers
      energy_density = 0
      select case (self%law)
       case (linear_elastic)
         energy_density = linear_energy_density(self%lambda, self%mu, h - self%free) + self%out_of_plane
       case (orthotropic)
         energy_density = voigt_energy_density(self%stiffness, h)
       case (neo_hookean)
         energy_density = neo_hookean_energy_density(self%lambda, self%mu, self%plane_stress, h)
       case (j2_plastic, viscoelastic)
         energy_density = remembered_energy_density(self, h, past)
      end select
   end function energy_density

   !> Elastic energy per volume of a small stress [J/m3].
   pure real(dp) function stress_energy_density(self, stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: stress(ndim, ndim) !! symmetric [Pa]
      if (self%isotropic) then
         stress_energy_density = linear_stress_energy_density(self%small_strain_lambda(), self%mu, stress)
      else
         stress_energy_density = voigt_stress_energy_density(self%compliance, stress)
      end if
   end function stress_energy_density

   !> Stress of a small displacement gradient, whatever the law [Pa].
   pure function small_strain_stress(self, h) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)
      if (self%isotropic) then
         stress = linear_stress(self%small_strain_lambda(), self%mu, h)
      else
         stress = voigt_stress(self%stiffness, h)
      end if
   end function small_strain_stress

   !> Lame constant with which every isotropic law is the linear one at small strain; in plane stress lambda' [Pa].
   pure real(dp) function small_strain_lambda(self) result(lambda)
      class(material_t), intent(in) :: self
      lambda = self%lambda
      if (self%plane_stress .and. .not. self%linear) lambda = 2*lambda*self%mu/(lambda + 2*self%mu)
   end function small_strain_lambda

   !> Stiffness of the columns (s_11, s_22, s_12) and (eps_11, eps_22, 2 eps_12) at small strain, whatever the law [Pa].
   pure function small_strain_moduli(self) result(moduli)
      class(material_t), intent(in) :: self
      real(dp) :: moduli(n_voigt, n_voigt)
      moduli = self%stiffness
      if (.not. self%isotropic) return
      moduli(:2, :2) = self%small_strain_lambda()
      moduli(1, 1) = moduli(1, 1) + 2*self%mu
      moduli(2, 2) = moduli(1, 1)
      moduli(3, 3) = self%mu
   end function small_strain_moduli

   !> Speed of shear (rotational) waves [m/s], equation (32); in an orthotropic material of those along its axes.
   pure real(dp) function shear_wave_speed(self)
      class(material_t), intent(in) :: self
      shear_wave_speed = sqrt(self%mu/self%density)
   end function shear_wave_speed

   !> Speed of dilatational waves in the plane condition of the material [m/s]; in an orthotropic material of the fastest in any
   !> direction.
   pure real(dp) function dilatational_wave_speed(self)
      class(material_t), intent(in) :: self
      real(dp) :: modulus
      if (.not. self%isotropic) then
         modulus = self%fastest
      else if (self%plane_stress) then
         modulus = self%young/(1 - self%poisson**2)
      else
         modulus = self%lambda + 2*self%mu
      end if
      dilatational_wave_speed = sqrt(modulus/self%density)
   end function dilatational_wave_speed

   !> E' of the plane condition [Pa]: E in plane stress, E/(1 - nu**2) in plane strain; of an orthotropic material the geometric mean of
   !> those along its axes.
   pure real(dp) function plane_modulus(self)
      class(material_t), intent(in) :: self
      if (.not. self%isotropic) then
         plane_modulus = 1/sqrt(self%in_its_axes(1, 1)*self%in_its_axes(2, 2))
         return
      end if
      plane_modulus = self%young
      if (.not. self%plane_stress) plane_modulus = plane_modulus/(1 - self%poisson**2)
   end function plane_modulus
end module hampm_material
