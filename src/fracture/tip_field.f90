!> The singular fields at the tip of a crack in any material, which the stress intensity factors multiply, and how G follows from these:
!>
!>    G = sum_mn K_m Y_mn K_n,   opening and sliding r behind the tip = 8 sqrt(r/(2 pi)) sum_n Y_mn K_n,
!>
!> in an isotropic material with Y = 1/E' times the unit matrix. Axes: the crack lies on the negative first axis and ends at the origin.
module hampm_tip_field
   use hampm_anisotropic_tip_field, only: anisotropic_tip_t, new_anisotropic_tip
   use hampm_crack_tip_field, only: modes, effective_modulus, tip_gradient, tip_stress, tip_opening
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t
   implicit none
   private
   public :: tip_field_t, new_tip_field

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: same_rate = 1e-6_dp !! well above what nearly equal roots of the field leave of rounding, 1e-10

   !> A tip in a material.
   type :: tip_field_t
      type(material_t) :: material
      type(anisotropic_tip_t), private :: anisotropic
   contains
      procedure :: gradient
      procedure :: stress
      procedure :: opening
      procedure :: rate_of
      procedure :: modes_couple
      procedure :: intensities_of
      procedure :: of_rate
      procedure :: shares
      procedure :: typical_intensities
   end type tip_field_t

contains

   !> The field at a tip.
   type(tip_field_t) function new_tip_field(material, direction) result(field)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack
      field%material = material
      if (.not. material%isotropic) field%anisotropic = new_anisotropic_tip(material, direction)
   end function new_tip_field

   !> Displacement gradient for a unit stress intensity factor of a mode [1/(Pa sqrt(m))].
   pure function gradient(self, mode, x)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! place, not the tip itself [m]
      real(dp) :: gradient(ndim, ndim)
      if (self%material%isotropic) then
         gradient = tip_gradient(self%material, mode, x)
      else
         gradient = self%anisotropic%gradient(mode, x)
      end if
   end function gradient

   !> Stress of a displacement gradient at small strain [Pa].
   pure function stress(self, h)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp) :: stress(ndim, ndim)
      if (self%material%isotropic) then
         stress = tip_stress(self%material, h)
      else
         stress = self%anisotropic%stress(h)
      end if
   end function stress

   !> Opening (1) or sliding (2) behind the tip for a unit stress intensity factor of a mode [sqrt(m)/Pa].
   pure real(dp) function opening(self, component, mode, r)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: component, mode
      real(dp), intent(in) :: r                  !! distance from the tip [m]
      if (.not. self%material%isotropic) then
         opening = 8*self%anisotropic%rate(component, mode)*sqrt(r/(2*pi))
      else if (component == mode) then
         opening = tip_opening(self%material, r)
      else
         opening = 0
      end if
   end function opening

   !> G of stress intensity factors [J/m2].
   pure real(dp) function rate_of(self, k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      if (self%material%isotropic) then
         rate_of = sum(k**2)/effective_modulus(self%material)
      else
         rate_of = dot_product(k, matmul(self%anisotropic%rate, k))
      end if
   end function rate_of

   !> Whether G has a part of both modes together, as it does where a crack lies across the axes of a material.
   pure logical function modes_couple(self)
      class(tip_field_t), intent(in) :: self
      modes_couple = .false.
      if (self%material%isotropic) return
      associate (y => self%anisotropic%rate)
         modes_couple = abs(y(1, 2)) > same_rate*(y(1, 1) + y(2, 2))
      end associate
   end function modes_couple

   !> Stress intensity factors from the interactions 2 sum_n Y_mn K_n with the fields of a unit K of each mode, over any number [Pa sqrt(m)].
   pure function intensities_of(self, interaction, over) result(k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: interaction(modes)
      real(dp), intent(in) :: over               !! by which interactions are too large
      real(dp) :: k(modes)
      if (self%material%isotropic) then
         k = interaction*effective_modulus(self%material)/(2*over)
         return
      end if
      associate (y => self%anisotropic%rate)
         k = [y(2, 2)*interaction(1) - y(1, 2)*interaction(2), y(1, 1)*interaction(2) - y(1, 2)*interaction(1)] &
             /(2*over*(y(1, 1)*y(2, 2) - y(1, 2)**2))
      end associate
   end function intensities_of

   !> Stress intensity factors in the ratio of some, of the size that goes with G, of whichever sign: rounding may be all that there is of it [Pa sqrt(m)].
   pure function of_rate(self, k, g)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp), intent(in) :: g                  !! [J/m2]
      real(dp) :: of_rate(modes)
      of_rate = k
      if (self%rate_of(k) > 0) of_rate = k*sqrt(abs(g)/self%rate_of(k))
   end function of_rate

   !> What each mode has of G, their sum being 1: the work of the tractions ahead of the tip across the crack on its opening, and of those
   !> along it on its sliding. In an anisotropic material, where each K opens and slides the faces, one may be below 0.
   pure function shares(self, k) result(part)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! not both 0 [Pa sqrt(m)]
      real(dp) :: part(modes)
      if (self%material%isotropic) then
         part = (k/norm2(k))**2
      else
         part = k*matmul(self%anisotropic%rate, k)/self%rate_of(k)
      end if
   end function shares

   !> Sizes of the stress intensity factors that go with parts of G by mode [Pa sqrt(m)]; where modes couple as if they did not.
   pure function typical_intensities(self, g) result(k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: g(modes)           !! [J/m2]
      real(dp) :: k(modes)
      if (self%material%isotropic) then
         k = sqrt(effective_modulus(self%material)*abs(g))
      else
         k = sqrt(abs(g)/[self%anisotropic%rate(1, 1), self%anisotropic%rate(2, 2)])
      end if
   end function typical_intensities
end module hampm_tip_field
