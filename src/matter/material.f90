!> A material: its law with its constants, and the stress and energy that follow from the displacement gradient.
module hampm_material
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_linear_elastic, only: linear_stress, linear_energy_density, linear_stress_energy_density
   use hampm_neo_hookean, only: neo_hookean_kirchhoff, neo_hookean_first_piola, neo_hookean_energy_density, &
                                  neo_hookean_piola_change
   implicit none
   private
   public :: material_t, new_material, laws

   integer, parameter :: linear_elastic = 1, neo_hookean = 2
   character(*), parameter :: laws(*) = [character(14) :: 'linear_elastic', 'neo_hookean'] !! their names in scenes, in this order

   !> A law with its constants.
   type :: material_t
      character(name_len) :: name = ''
      integer, private :: law = linear_elastic   !! its place in `laws`
      logical :: linear = .true.                 !! whether that is the linear one
      logical :: plane_stress = .true.           !! else plane strain
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! in the reference configuration [kg/m3]
      real(dp) :: lambda = 0                     !! Lame constant; of the linear law in plane stress lambda' [Pa]
      real(dp) :: mu = 0                         !! shear modulus [Pa]
      ! Strain without stress, of the linear law only: `give_eigenstrain`
      logical :: has_eigenstrain = .false.
      real(dp), private :: free(ndim, ndim) = 0  !! strain in the plane at which there is no stress in it [-]
      real(dp), private :: out_of_plane = 0      !! energy density there, of the stress normal to it [J/m3]
   contains
      procedure :: give_eigenstrain
      procedure :: kirchhoff_stress
      procedure :: conjugate_stress
      procedure :: conjugate_change
      procedure :: mapped_stress
      procedure :: energy_density
      procedure :: stress_energy_density
      procedure :: small_strain_lambda
      procedure :: plane_modulus
      procedure :: shear_wave_speed
      procedure :: dilatational_wave_speed
   end type material_t

contains

   !> A material from its engineering constants.
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
      m%linear = m%law == linear_elastic
      m%plane_stress = plane_stress
      m%young = young
      m%poisson = poisson
      m%density = density
      m%mu = young/(2*(1 + poisson))
      m%lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
      if (m%linear .and. plane_stress) m%lambda = young*poisson/(1 - poisson**2)
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

   !> Kirchhoff stress [Pa], which times the reference volume and the spatial gradient of a shape function is a force.
   pure function kirchhoff_stress(self, h) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)
      stress = 0
      select case (self%law)
       case (linear_elastic)
         stress = linear_stress(self%lambda, self%mu, h - self%free)
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
         stress = linear_stress(self%lambda, self%mu, h - self%free)
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
         energy_density = linear_energy_density(self%lambda, self%mu, h - self%free) + self%out_of_plane
       case (neo_hookean)
         energy_density = neo_hookean_energy_density(self%lambda, self%mu, self%plane_stress, h)
      end select
   end function energy_density

   !> Elastic energy per volume of a small stress [J/m3].
   pure real(dp) function stress_energy_density(self, stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: stress(ndim, ndim) !! symmetric [Pa]
      stress_energy_density = linear_stress_energy_density(self%small_strain_lambda(), self%mu, stress)
   end function stress_energy_density

   !> Lame constant with which every law is the linear one at small strain; in plane stress lambda' [Pa].
   pure real(dp) function small_strain_lambda(self) result(lambda)
      class(material_t), intent(in) :: self
      lambda = self%lambda
      if (self%plane_stress .and. .not. self%linear) lambda = 2*lambda*self%mu/(lambda + 2*self%mu)
   end function small_strain_lambda

   !> Speed of shear (rotational) waves [m/s], equation (32).
   pure real(dp) function shear_wave_speed(self)
      class(material_t), intent(in) :: self
      shear_wave_speed = sqrt(self%mu/self%density)
   end function shear_wave_speed

   !> Speed of dilatational waves in the plane condition of the material [m/s].
   pure real(dp) function dilatational_wave_speed(self)
      class(material_t), intent(in) :: self
      real(dp) :: modulus
      if (self%plane_stress) then
         modulus = self%young/(1 - self%poisson**2)
      else
         modulus = self%lambda + 2*self%mu
      end if
      dilatational_wave_speed = sqrt(modulus/self%density)
   end function dilatational_wave_speed

   !> E' of the plane condition [Pa]: E in plane stress, E/(1 - nu**2) in plane strain.
   pure real(dp) function plane_modulus(self)
      class(material_t), intent(in) :: self
      plane_modulus = self%young
      if (.not. self%plane_stress) plane_modulus = plane_modulus/(1 - self%poisson**2)
   end function plane_modulus
end module hampm_material
