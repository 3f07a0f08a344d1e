!> A material: its law with its constants, and the stress and energy that follow from the displacement gradient.
module hampm_material
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_linear_elastic, only: linear_stress, linear_energy_density, linear_stress_energy_density
   use hampm_neo_hookean, only: neo_hookean_kirchhoff, neo_hookean_first_piola, neo_hookean_energy_density, &
                                  neo_hookean_piola_change
   use hampm_orthotropic, only: orthotropic_t, n_voigt, plane_compliance, inverse_of, turned_stiffness, turned_compliance, &
                                voigt_stress, voigt_energy_density, voigt_stress_energy_density, acoustic_modulus
   implicit none
   private
   public :: material_t, new_material, new_orthotropic, laws

   integer, parameter :: linear_elastic = 1, neo_hookean = 2, orthotropic = 3
   character(*), parameter :: laws(*) = [character(14) :: 'linear_elastic', 'neo_hookean', 'orthotropic'] !! their names in scenes, in this order

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
      ! Of an orthotropic material, where lambda and mu are C_12 and C_66 in its axes; of the columns (11, 22, 12):
      real(dp) :: stiffness(n_voigt, n_voigt) = 0  !! in x and y [Pa]
      real(dp) :: compliance(n_voigt, n_voigt) = 0 !! its inverse [1/Pa]
      real(dp) :: in_its_axes(n_voigt, n_voigt) = 0 !! the compliance in the axes of the material [1/Pa]
      real(dp) :: angle = 0                      !! of its axis 1 from x [degrees]
      real(dp), private :: fastest = 0           !! rho c**2 of the fastest waves [Pa]
   contains
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
   pure function new_material(name, law, plane_stress, young, poisson, density) result(m)
      character(*), intent(in) :: name
      character(*), intent(in) :: law            !! one of `laws`
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(in) :: young              !! [Pa]
      real(dp), intent(in) :: poisson            !! [-], below 0.5
      real(dp), intent(in) :: density            !! [kg/m3]
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
   end function new_material

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

   !> Kirchhoff stress [Pa], which times the reference volume and the spatial gradient of a shape function is a force.
   pure function kirchhoff_stress(self, h) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)
      stress = 0
      select case (self%law)
       case (linear_elastic)
         stress = linear_stress(self%lambda, self%mu, h)
       case (orthotropic)
         stress = voigt_stress(self%stiffness, h)
       case (neo_hookean)
         stress = neo_hookean_kirchhoff(self%lambda, self%mu, self%plane_stress, h)
      end select
   end function kirchhoff_stress

   !> The stress whose product with the change of H is the change of the energy density [Pa].
   pure function conjugate_stress(self, h) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)
      stress = 0
      select case (self%law)
       case (linear_elastic)
         stress = linear_stress(self%lambda, self%mu, h)
       case (orthotropic)
         stress = voigt_stress(self%stiffness, h)
       case (neo_hookean)
         stress = neo_hookean_first_piola(self%lambda, self%mu, self%plane_stress, h)
      end select
   end function conjugate_stress

   !> What a small change of H makes of `conjugate_stress` [Pa].
   pure function conjugate_change(self, h, dh) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(ndim, ndim)     !! its change [-]
      real(dp) :: change(ndim, ndim)
      change = 0
      select case (self%law)
       case (linear_elastic)
         change = linear_stress(self%lambda, self%mu, dh)
       case (orthotropic)
         change = voigt_stress(self%stiffness, dh)
       case (neo_hookean)
         change = neo_hookean_piola_change(self%lambda, self%mu, self%plane_stress, h, dh)
      end select
   end function conjugate_change

   !> The stress that with the gradients of the shape functions of a frame gives the internal force [Pa].
   pure function mapped_stress(self, h, total_frame) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      logical, intent(in) :: total_frame         !! gradients at the reference positions, else at the present ones
      real(dp) :: stress(ndim, ndim)
      if (total_frame) then
         stress = self%conjugate_stress(h)
      else
         stress = self%kirchhoff_stress(h)
      end if
   end function mapped_stress

   !> Elastic energy per reference volume [J/m3].
   pure real(dp) function energy_density(self, h)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      energy_density = 0
      select case (self%law)
       case (linear_elastic)
         energy_density = linear_energy_density(self%lambda, self%mu, h)
       case (orthotropic)
         energy_density = voigt_energy_density(self%stiffness, h)
       case (neo_hookean)
         energy_density = neo_hookean_energy_density(self%lambda, self%mu, self%plane_stress, h)
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
