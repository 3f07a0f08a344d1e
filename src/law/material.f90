!> A material: its law with constants, in the plane of a model; stress and energy from the displacement gradient.
!>
!> Laws (`hampm_law`) are written in space; the plane is treated here, once for all laws: H_33 = 0 in plane strain, stress_33 = 0 in
!> plane stress, and H_33 is given, `hoop` = u_r/R, in axisymmetric material; eigenstrain is subtracted before. Linear laws have
!> moduli in the plane; H_33 adds the strain nu H_33 in it (`by_across`), and a stress_33 by Young's modulus across it. Without its
!> hoop the stress of axisymmetric material is NaN.
!>
!> Laws with a history need the state variables of a particle, `old_state`, too, else their results are NaN. Explicit steps update
!> them (`update_state`) whenever they strain the particles. Trial states of equilibrium do not: while `is_trial`, stress, tangent
!> and energies are those at the end of a step that began with `old_state` and lasts `time_increment`.
module hampm_material
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, ndim, plane, name_len
   use hampm_law, only: law_t, law_row_t, constant_t, most_columns
   use hampm_laws, only: law_row
   use hampm_linear_elastic, only: linear_stress
   use hampm_orthotropic, only: orthotropic_t, orthotropic_of, stiffness_of_solid, acoustic_modulus_of_solid, &
                                plane_compliance, inverse_of, turned_stiffness, &
                                turned_compliance, turned_strain, voigt_stress, acoustic_modulus
   use hampm_tensors, only: voigt, n_voigt, space, identity, inverse_transpose, unit_tensor, inverse_transpose_of, &
                            volume_change, in_plane
   implicit none
   private
   public :: material_t, slice_t, new_material, new_orthotropic, are_of_one

   !> A slice of a graded body, across a direction, with its own material; along it the moduli change exponentially.
   type :: slice_t
      integer :: number = 0                      !! from the first on, 0 for none
      integer :: most = 0                        !! how many there are
      integer :: first_material = 0              !! number of the material of the first
      real(dp) :: direction(ndim) = 0            !! unit vector
      real(dp) :: start = 0                      !! where the first begins along it [m]
      real(dp) :: width = 1                      !! [m]
      real(dp) :: rate = 0                       !! of change of the logarithm of the moduli [1/m]
      real(dp) :: free_rate(ndim, ndim) = 0      !! of change of the stress-free strain in the plane [1/m]
   end type slice_t

   !> A law with its constants.
   type :: material_t
      character(name_len) :: name = ''
      character(name_len) :: law_name = ''       !! of its law in model files
      logical :: linear = .true.                 !! whether the law is linear
      class(law_t), allocatable, private :: law  !! unless it is linear
      logical :: is_finite = .false.             !! whether the law is for any rotation and strain: bodies may buckle
      logical :: yields = .false.                !! whether it is a law of plasticity
      logical :: has_history = .false.           !! whether stress depends on the history
      logical :: isotropic = .true.              !! else `young` and `poisson` have no effect
      logical :: plane_stress = .true.           !! else plane strain
      logical :: is_ring = .false.               !! else, of a material as in plane strain, axisymmetric
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! in the reference configuration [kg/m3]
      real(dp) :: lambda = 0                     !! Lame constant; of linear laws in plane stress lambda' [Pa]
      real(dp) :: mu = 0                         !! shear modulus [Pa]
      logical :: mean_dilatation = .false.       !! whether its dilatation is the mean over a cell (`hampm_mean_dilatation`)
      integer :: columns = 0                     !! number of state variables
      logical :: is_trial = .false.              !! whether states are tried that are not kept
      real(dp) :: time_increment = 0             !! since the last that was kept [s]
      ! At small strain, of the columns (s_11, s_22, s_12) and (eps_11, eps_22, 2 eps_12); lambda and mu of an orthotropic material
      ! are C_12 and C_66 in its axes
      real(dp) :: stiffness(n_voigt, n_voigt) = 0  !! in x and y [Pa]
      real(dp) :: compliance(n_voigt, n_voigt) = 0 !! its inverse [1/Pa]
      real(dp) :: in_its_axes(n_voigt, n_voigt) = 0 !! the compliance in the axes of the material [1/Pa]
      real(dp) :: angle = 0                      !! of its axis 1 from x [degrees]
      real(dp), private :: fastest = 0           !! rho c**2 of the fastest waves [Pa]
      ! Strain without stress: `give_eigenstrain`
      logical :: has_eigenstrain = .false.
      logical :: is_scaled = .false.             !! whether quasi-static growth scales it
      real(dp) :: scale = 1                      !! factor of that scaling [-]
      real(dp), private :: given(4) = 0          !! value of the model [-]
      real(dp), private :: eigenstrain(space, space) = 0 !! [-]
      real(dp), private :: inverse(space, space) = unit_tensor !! of the stretch I + eigenstrain, of laws for any strain
      real(dp), private :: swelling = 1          !! its determinant, volume without stress over reference volume, of these laws [-]
      real(dp), private :: by_across(ndim, ndim) = 0 !! strain in the plane by one that is kept across it; 0 in plane stress [-]
      real(dp), private :: young_across = 0      !! Young's modulus there [Pa]
      real(dp) :: free(ndim, ndim) = 0           !! stress-free strain in the plane [-]
      real(dp) :: free_hoop = 0                  !! H_33 of stress-free axisymmetric material [-]
      real(dp) :: idle_energy = 0                !! energy density there, of the stress normal to it [J/m3]
      type(slice_t) :: slice                     !! of a graded body that it is of
   contains
      procedure :: is_graded
      procedure :: slices_to
      procedure :: give_eigenstrain
      procedure :: scale_eigenstrain
      procedure :: stress_at_first
      procedure :: update_state
      procedure :: equivalent_plastic_strain
      procedure :: dissipation
      procedure :: kirchhoff_stress
      procedure :: first_piola_stress
      procedure :: first_piola_change
      procedure :: hoop_stress
      procedure :: hoop_change
      procedure :: mapped_stress
      procedure :: energy_density
      procedure :: stress_energy_density
      procedure :: small_strain_stress
      procedure :: small_hoop_stress
      procedure :: stress_across
      procedure :: strain_of_pressure
      procedure :: hoop_moduli
      procedure :: small_strain_lambda
      procedure :: plane_modulus
      procedure :: shear_wave_speed
      procedure :: dilatational_wave_speed
   end type material_t

contains

   !> A material from its engineering constants; of the orthotropic law one that is isotropic as far as its own are not given.
   function new_material(name, law, plane_stress, young, poisson, density, constants) result(m)
      character(*), intent(in) :: name
      character(*), intent(in) :: law            !! a name of `hampm_laws`
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(in) :: young              !! [Pa]
      real(dp), intent(in) :: poisson            !! [-], below 0.5
      real(dp), intent(in) :: density            !! [kg/m3]
      type(constant_t), intent(in), optional :: constants(:) !! of its law alone
      type(material_t) :: m
      type(constant_t), allocatable :: own(:)
      type(law_row_t) :: row
      logical :: kept
      integer :: k
      allocate (own(0))
      if (present(constants)) own = constants
      if (law == 'orthotropic') then
         m = new_orthotropic(name, plane_stress, orthotropic_of(own, young, poisson), density)
         return
      end if
      m%name = name
      m%law_name = law
      m%linear = law == 'linear_elastic'
      m%plane_stress = plane_stress
      m%young = young
      m%poisson = poisson
      m%density = density
      m%mu = young/(2*(1 + poisson))
      m%lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
      kept = ndim < space .and. .not. plane_stress ! the strain across the plane
      if (kept) m%by_across = poisson*identity
      if (kept) m%young_across = young
      if (m%linear .and. plane_stress) m%lambda = young*poisson/(1 - poisson**2)
      m%fastest = young/(1 - poisson**2)
      if (.not. plane_stress) m%fastest = m%lambda + 2*m%mu
      m%stiffness(:ndim, :ndim) = m%small_strain_lambda() + 2*m%mu*identity
      associate (nu => merge(poisson/(1 - poisson), poisson, kept), e => merge(young/(1 - poisson**2), young, kept))
         m%compliance(:ndim, :ndim) = -nu/e
         do k = 1, ndim
            m%compliance(k, k) = 1/e
         end do
      end associate
      do k = ndim + 1, n_voigt
         m%stiffness(k, k) = m%mu
         m%compliance(k, k) = 1/m%mu
      end do
      m%in_its_axes = m%compliance
      row = law_row(law)
      if (.not. associated(row%make)) return
      call row%make(m%lambda, m%mu, own, m%law)
      m%is_finite = m%law%is_finite
      m%yields = m%law%yields
      m%columns = m%law%columns
      m%has_history = m%columns > 0
   end function new_material

   !> Give material an eigenstrain eps0, the stress-free strain: stress and energy are those of H - eps0 or, of laws for any strain,
   !> of (I + H)(I + eps0)**-1 - I, the energy per stress-free volume. The linear laws know the plane only: a normal strain that is
   !> held by a stress of -E eps0_zz, without stress in the plane, adds nu eps0_zz to the strain in the plane.
   pure subroutine give_eigenstrain(self, eigenstrain, is_scaled)
      class(material_t), intent(inout) :: self
      real(dp), intent(in) :: eigenstrain(4)     !! components xx, yy, xy and zz of the tensor [-]
      logical, intent(in), optional :: is_scaled !! whether quasi-static growth scales it
      self%has_eigenstrain = any(abs(eigenstrain) > 0)
      self%given = eigenstrain
      if (present(is_scaled)) self%is_scaled = is_scaled
      call take_eigenstrain(self, eigenstrain)
   end subroutine give_eigenstrain

   !> Multiply a given eigenstrain that is scaled.
   elemental subroutine scale_eigenstrain(self, scale)
      class(material_t), intent(inout) :: self
      real(dp), intent(in) :: scale              !! relative to the given value, not to the present one [-]
      if (.not. self%is_scaled) return
      self%scale = scale
      call take_eigenstrain(self, scale*self%given)
   end subroutine scale_eigenstrain

   !> Have an eigenstrain from now on.
   pure subroutine take_eigenstrain(self, eigenstrain)
      class(material_t), intent(inout) :: self
      real(dp), intent(in) :: eigenstrain(4)
      associate (e => eigenstrain)
         self%eigenstrain = 0
         self%eigenstrain(1, 1) = e(1)
         self%eigenstrain(2, 2) = e(2)
         self%eigenstrain(3, 3) = e(4)
         self%eigenstrain(1, 2) = e(3)
         self%eigenstrain(2, 1) = e(3)
         self%free = self%eigenstrain(:ndim, :ndim)
         if (self%is_ring) self%free_hoop = e(4)
         if (.not. self%is_ring) self%free = self%free + e(4)*self%by_across
         self%idle_energy = self%young_across*e(4)**2/2
         if (self%plane_stress) self%eigenstrain(3, 3) = 0
      end associate
      if (.not. self%is_finite) return
      self%inverse = inverse_transpose_of(unit_tensor + self%eigenstrain)
      self%swelling = 1 + volume_change(self%eigenstrain)
   end subroutine take_eigenstrain

   !> Whether it belongs to a graded body.
   pure elemental logical function is_graded(self)
      class(material_t), intent(in) :: self
      is_graded = self%slice%number > 0
   end function is_graded

   !> Number of slices from its own to the one at a place; 0 if the body is not graded.
   pure integer function slices_to(self, place)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: place(ndim)        !! in the reference configuration [m]
      slices_to = 0
      if (.not. self%is_graded()) return
      associate (slice => self%slice)
         associate (at => (dot_product(place, slice%direction) - slice%start)/slice%width)
            slices_to = ceiling(min(max(at, 1.0_dp), real(slice%most, dp))) - slice%number
         end associate
      end associate
   end function slices_to

   !> Whether two materials are the same, or of one graded body.
   pure logical function are_of_one(materials, a, b)
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: a, b
      are_of_one = a == b
      if (.not. are_of_one .and. materials(a)%is_graded()) &
         are_of_one = materials(a)%slice%first_material == materials(b)%slice%first_material
   end function are_of_one

   !> H_33 [-]: in a plane 0, of axisymmetric material the one that is given, and no number where none is.
   pure real(dp) function given_hoop(self, hoop) result(given_one)
      class(material_t), intent(in) :: self
      real(dp), intent(in), optional :: hoop
      given_one = 0
      if (.not. self%is_ring) return
      if (present(hoop)) then
         given_one = hoop
      else
         given_one = ieee_value(1.0_dp, ieee_quiet_nan)
      end if
   end function given_hoop

   !> Stress at zero displacement, due to an eigenstrain [Pa].
   pure function stress_at_first(self) result(stress)
      class(material_t), intent(in) :: self
      real(dp) :: stress(ndim, ndim), nothing(self%columns)
      real(dp), parameter :: no_gradient(ndim, ndim) = 0
      nothing = 0
      stress = self%first_piola_stress(no_gradient, nothing, 0.0_dp)
   end function stress_at_first

   !> An orthotropic material, whose constants make it positive definite.
   function new_orthotropic(name, plane_stress, constants, density) result(m)
      character(*), intent(in) :: name
      logical, intent(in) :: plane_stress        !! else plane strain
      type(orthotropic_t), intent(in) :: constants
      real(dp), intent(in) :: density            !! [kg/m3]
      type(material_t) :: m
      real(dp) :: of_axes(n_voigt, n_voigt)      ! stiffness in the axes of the material [Pa]
      m%name = name
      m%in_its_axes = plane_compliance(constants, plane_stress)
      of_axes = inverse_of(m%in_its_axes)
      m%law_name = 'orthotropic'
      m%linear = .true.
      m%isotropic = .false.
      m%plane_stress = plane_stress
      m%density = density
      m%mu = constants%shear_12
      m%lambda = of_axes(1, 2)
      m%angle = constants%angle
      if (ndim > 2) then
         m%compliance = stiffness_of_solid(m%in_its_axes, constants%turns, is_compliance=.true.)
         m%stiffness = stiffness_of_solid(of_axes, constants%turns, is_compliance=.false.)
         m%fastest = acoustic_modulus_of_solid(of_axes)
         return
      end if
      m%compliance = turned_compliance(m%in_its_axes, m%angle)
      m%stiffness = turned_stiffness(of_axes, m%angle)
      m%fastest = acoustic_modulus(of_axes)
      if (plane_stress) return
      m%by_across = turned_strain(in_plane(constants%young(3)*constants%poisson_13/constants%young(1), &
                                          constants%young(3)*constants%poisson_23/constants%young(2)), m%angle)
      m%young_across = constants%young(3)
   end function new_orthotropic

   !> Update the state by a step of length `dt` at the end of which the displacement gradient is `h`.
   pure subroutine update_state(self, h, dt, old_state, hoop)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), contiguous, intent(inout) :: old_state(:) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: strain(space, space)
      if (self%columns == 0) return
      strain = strain_of(self, h, old_state(:self%columns), dt, hoop)
      call self%law%update(strain, dt, old_state(:self%columns))
   end subroutine update_state

   !> Displacement gradient in space less the eigenstrain, of a nonlinear law: at the end of a step, or of the present state.
   pure function strain_of(self, h, old_state, dt, hoop) result(strain)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: old_state(:)
      real(dp), intent(in), optional :: dt       !! [s]
      real(dp), intent(in), optional :: hoop
      real(dp) :: strain(space, space)
      strain = 0
      strain(:ndim, :ndim) = h
      if (ndim < space) strain(space, space) = given_hoop(self, hoop)
      if (self%has_eigenstrain) strain = matmul(strain - self%eigenstrain, self%inverse)
      if (self%plane_stress) strain(3, 3) = self%law%across(strain, old_state, dt)
   end function strain_of

   !> Present strain and state of a law that is not linear; while `is_trial`, those at the end of the step. NaN where a history is
   !> needed and not given.
   pure subroutine find_state(self, h, old_state, hoop, strain, state)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), intent(in), optional :: old_state(self%columns)
      real(dp), intent(in), optional :: hoop
      real(dp), intent(out) :: strain(space, space), state(most_columns)
      associate (n => self%columns)
         if (n == 0) then
            strain = strain_of(self, h, state(:0), hoop=hoop)
         else if (.not. present(old_state)) then
            strain = ieee_value(1.0_dp, ieee_quiet_nan)
            state(:n) = strain(1, 1)
         else
            state(:n) = old_state
            if (self%is_trial) then
               strain = strain_of(self, h, old_state, self%time_increment, hoop)
               call self%law%update(strain, self%time_increment, state(:n))
            else
               strain = strain_of(self, h, old_state, hoop=hoop)
            end if
         end if
      end associate
   end subroutine find_state

   !> Equivalent plastic strain [-].
   pure real(dp) function equivalent_plastic_strain(self, old_state) result(strain)
      class(material_t), intent(in) :: self
      real(dp), contiguous, intent(in) :: old_state(:)
      strain = 0
      if (self%columns > 0) strain = self%law%plastic_strain(old_state(:self%columns))
   end function equivalent_plastic_strain

   !> Dissipation per reference volume [J/m3]: plastic work where the law `yields`, else viscous dissipation.
   pure real(dp) function dissipation(self, h, old_state, hoop)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: old_state(:)
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: strain(space, space), state(most_columns)
      dissipation = 0
      if (self%columns == 0) return
      call find_state(self, h, old_state, hoop, strain, state)
      dissipation = self%law%dissipation(state(:self%columns))
   end function dissipation

   !> Kirchhoff stress [Pa], which times the reference volume and the spatial gradient of a shape function is a force.
   pure function kirchhoff_stress(self, h, old_state, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: stress(ndim, ndim), in_space(space, space)
      if (self%linear) then
         stress = stress_of_plane(self, strain_of_plane(self, h, hoop))
      else
         in_space = stress_in_space(self, h, old_state, hoop)
         stress = in_space(:ndim, :ndim)
      end if
   end function kirchhoff_stress

   !> The same in space, of material whose law is not linear.
   pure function stress_in_space(self, h, old_state, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), intent(in), optional :: old_state(self%columns)
      real(dp), intent(in), optional :: hoop
      real(dp) :: stress(space, space), strain(space, space), state(most_columns)
      call find_state(self, h, old_state, hoop, strain, state)
      stress = self%swelling*self%law%stress(strain, state(:self%columns))
   end function stress_in_space

   !> Component 33 of the first Piola stress of axisymmetric material, the resistance of its rings to widening [Pa].
   pure real(dp) function hoop_stress(self, h, old_state, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: in_space(space, space)
      if (self%linear) then
         stress = sum(self%by_across*stress_of_plane(self, strain_of_plane(self, h, hoop))) &
                  + self%young_across*(given_hoop(self, hoop) - self%eigenstrain(space, space))
      else
         in_space = stress_in_space(self, h, old_state, hoop)
         stress = in_space(space, space)
         if (self%is_finite) stress = stress/(1 + given_hoop(self, hoop))
      end if
   end function hoop_stress

   !> The first Piola stress, whose product with the change of H is the change of the energy density [Pa].
   pure function first_piola_stress(self, h, old_state, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: stress(ndim, ndim)
      if (self%linear) then
         stress = stress_of_plane(self, strain_of_plane(self, h, hoop))
      else
         stress = self%kirchhoff_stress(h, old_state, hoop)
         if (self%is_finite .and. any(abs(stress) > 0)) stress = matmul(stress, inverse_transpose(identity + h))
      end if
   end function first_piola_stress

   !> Change of `first_piola_stress` by a small change of H [Pa]; in plane stress H_33 changes too, so that stress_33 stays 0.
   pure function first_piola_change(self, h, dh, old_state, hoop, change_of_hoop) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(ndim, ndim)     !! its change [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp), intent(in), optional :: change_of_hoop !! change of H_33 [-]
      real(dp) :: change(ndim, ndim), in_space(space, space)
      if (self%linear) then
         change = stress_of_plane(self, dh + given_hoop(self, change_of_hoop)*self%by_across)
      else
         in_space = change_in_space(self, h, dh, old_state, hoop, change_of_hoop)
         change = in_space(:ndim, :ndim)
      end if
   end function first_piola_change

   !> And of `hoop_stress` [Pa].
   pure real(dp) function hoop_change(self, h, dh, old_state, hoop, change_of_hoop) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(ndim, ndim)     !! its change [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp), intent(in), optional :: change_of_hoop !! change of H_33 [-]
      real(dp) :: in_space(space, space)
      if (self%linear) then
         change = sum(self%by_across*stress_of_plane(self, dh + given_hoop(self, change_of_hoop)*self%by_across)) &
                  + self%young_across*given_hoop(self, change_of_hoop)
      else
         in_space = change_in_space(self, h, dh, old_state, hoop, change_of_hoop)
         change = in_space(space, space)
      end if
   end function hoop_change

   !> Change of the first Piola stress in space, of material whose law is not linear [Pa].
   pure function change_in_space(self, h, dh, old_state, hoop, change_of_hoop) result(change)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim), dh(ndim, ndim)
      real(dp), intent(in), optional :: old_state(self%columns)
      real(dp), intent(in), optional :: hoop, change_of_hoop
      real(dp), dimension(space, space) :: change, strain, by_thickness, in_space
      real(dp) :: before(most_columns)
      real(dp), parameter :: thickness(space, space) = reshape([0, 0, 0, 0, 0, 0, 0, 0, 1], [space, space])
      call find_state(self, h, old_state, hoop, strain, before)
      if (present(old_state)) before(:self%columns) = old_state
      in_space = 0
      in_space(:ndim, :ndim) = dh
      if (ndim < space) in_space(space, space) = given_hoop(self, change_of_hoop)
      change = tangent(in_space)
      if (self%plane_stress) then
         by_thickness = tangent(thickness)
         if (abs(by_thickness(3, 3)) > 0) change = change - change(3, 3)/by_thickness(3, 3)*by_thickness
      end if
   contains
      !> Of the step of a trial, else of instantaneous strain.
      pure function tangent(direction)
         real(dp), intent(in) :: direction(space, space)
         real(dp) :: tangent(space, space)
         if (self%is_trial) then
            tangent = self%law%tangent(strain, matmul(direction, self%inverse), before(:self%columns), self%time_increment)
         else
            tangent = self%law%tangent(strain, matmul(direction, self%inverse), before(:self%columns))
         end if
         tangent = self%swelling*matmul(tangent, self%inverse)
      end function tangent
   end function change_in_space

   !> Strain in the plane from which stress in it follows, of the linear laws [-].
   pure function strain_of_plane(self, h, hoop) result(strain)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), intent(in), optional :: hoop
      real(dp) :: strain(ndim, ndim)
      strain = h - self%free
      if (self%is_ring) strain = strain + (given_hoop(self, hoop) - self%free_hoop)*self%by_across
   end function strain_of_plane

   !> Stress of the linear laws by that [Pa].
   pure function stress_of_plane(self, strain) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: strain(ndim, ndim)
      real(dp) :: stress(ndim, ndim)
      if (self%isotropic) then
         stress = linear_stress(self%lambda, self%mu, strain)
      else
         stress = voigt_stress(self%stiffness, strain)
      end if
   end function stress_of_plane

   !> The stress that with the gradients of the shape functions of a frame gives the internal force [Pa].
   pure function mapped_stress(self, h, total_frame, old_state, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      logical, intent(in) :: total_frame         !! gradients at the reference positions, else at the present ones
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: stress(ndim, ndim)
      if (total_frame) then
         stress = self%first_piola_stress(h, old_state, hoop)
      else
         stress = self%kirchhoff_stress(h, old_state, hoop)
      end if
   end function mapped_stress

   !> Elastic energy per reference volume [J/m3].
   pure real(dp) function energy_density(self, h, old_state, hoop)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in), optional :: old_state(self%columns) !! state variables of the particle
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: strain(space, space), state(most_columns), in_plane(ndim, ndim)
      if (.not. self%linear) then
         call find_state(self, h, old_state, hoop, strain, state)
         energy_density = self%swelling*self%law%energy(strain, state(:self%columns))
         return
      end if
      in_plane = strain_of_plane(self, h, hoop)
      energy_density = 0.5_dp*sum(stress_of_plane(self, in_plane)*in_plane) &
                       + self%young_across*(given_hoop(self, hoop) - self%eigenstrain(space, space))**2/2
   end function energy_density

   !> Elastic energy per volume of a small stress [J/m3]: in the plane; of axisymmetric material with the given stress_33.
   pure real(dp) function stress_energy_density(self, stress, hoop_stress, other, other_hoop) result(energy)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: stress(ndim, ndim) !! symmetric [Pa]
      real(dp), intent(in), optional :: hoop_stress !! of axisymmetric material [Pa]
      real(dp), intent(in), optional :: other(ndim, ndim), other_hoop !! another stress, for the product of both in this energy [Pa]
      real(dp) :: column(n_voigt), other_column(n_voigt), across
      integer :: d
      do d = 1, ndim
         column(voigt(:, d)) = stress(:, d)
         if (present(other)) other_column(voigt(:, d)) = other(:, d)
      end do
      if (.not. present(other)) other_column = column
      energy = 0.5_dp*dot_product(column, matmul(self%compliance, other_column))
      if (.not. self%is_ring) return
      across = given_hoop(self, hoop_stress) - sum(self%by_across*stress)
      if (present(other)) energy = energy + across*(given_hoop(self, other_hoop) - sum(self%by_across*other))/(2*self%young_across)
      if (.not. present(other)) energy = energy + across**2/(2*self%young_across)
   end function stress_energy_density

   !> Stress of a small displacement gradient, for any law [Pa].
   pure function small_strain_stress(self, h, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in), optional :: hoop     !! H_33 of axisymmetric material [-]
      real(dp) :: stress(ndim, ndim), strain(ndim, ndim)
      strain = h
      if (self%is_ring) strain = strain + given_hoop(self, hoop)*self%by_across
      stress = voigt_stress(self%stiffness, strain)
   end function small_strain_stress

   !> And its stress_33 where material is axisymmetric [Pa].
   pure real(dp) function small_hoop_stress(self, h, hoop) result(stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: hoop               !! H_33 [-]
      stress = self%stress_across(self%small_strain_stress(h, hoop)) + self%young_across*hoop
   end function small_hoop_stress

   !> Stress across the plane by that in it, where there is no strain across it [Pa].
   pure real(dp) function stress_across(self, stress)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: stress(ndim, ndim) !! [Pa]
      stress_across = sum(self%by_across*stress)
   end function stress_across

   !> Strain of a small tension, equal in all directions of the plane or, of axisymmetric isotropic material, of space [-].
   pure function strain_of_pressure(self, tension) result(strain)
      class(material_t), intent(in) :: self
      real(dp), intent(in) :: tension            !! [Pa]
      real(dp) :: strain(ndim, ndim)
      real(dp) :: of_unit(n_voigt)
      integer :: d
      of_unit = sum(self%compliance(:, :ndim), dim=2)
      if (self%is_ring .and. self%isotropic) of_unit = of_unit/(1 + self%poisson) ! no strain is held across the plane
      of_unit(ndim + 1:) = of_unit(ndim + 1:)/2
      do d = 1, ndim
         strain(:, d) = tension*of_unit(voigt(:, d))
      end do
   end function strain_of_pressure

   !> Lame constant with which every isotropic law is the linear one at small strain; in plane stress lambda' [Pa].
   pure real(dp) function small_strain_lambda(self) result(lambda)
      class(material_t), intent(in) :: self
      lambda = self%lambda
      if (self%plane_stress .and. .not. self%linear) lambda = 2*lambda*self%mu/(lambda + 2*self%mu)
   end function small_strain_lambda

   !> Stress 11, 22, 12 and 33 by H_33 at small strain, of axisymmetric material of any law [Pa].
   pure function hoop_moduli(self) result(moduli)
      class(material_t), intent(in) :: self
      real(dp) :: moduli(n_voigt + 1), stress(ndim, ndim)
      integer :: d
      real(dp), parameter :: no_gradient(ndim, ndim) = 0
      stress = self%small_strain_stress(no_gradient, 1.0_dp)
      do d = 1, ndim
         moduli(voigt(:, d)) = stress(:, d)
      end do
      moduli(n_voigt + 1) = self%small_hoop_stress(no_gradient, 1.0_dp)
   end function hoop_moduli

   !> Speed of shear (rotational) waves [m/s], equation (32); in an orthotropic material of those along its axes.
   pure real(dp) function shear_wave_speed(self)
      class(material_t), intent(in) :: self
      shear_wave_speed = sqrt(self%mu/self%density)
   end function shear_wave_speed

   !> Speed of dilatational waves in the plane condition of the material [m/s]; in an orthotropic material of the fastest in any
   !> direction.
   pure real(dp) function dilatational_wave_speed(self)
      class(material_t), intent(in) :: self
      dilatational_wave_speed = sqrt(self%fastest/self%density)
   end function dilatational_wave_speed

   !> E' of the plane condition [Pa]: E in plane stress, E/(1 - nu**2) in plane strain; of an orthotropic material the geometric
   !> mean of E' along its axes.
   pure real(dp) function plane_modulus(self)
      class(material_t), intent(in) :: self
      real(dp) :: along(ndim)                    ! each axis, of solids in planes with the next one across [Pa]
      integer :: k
      associate (s => self%in_its_axes)
         plane_modulus = 1/sqrt(s(1, 1)*s(2, 2))
         if (ndim == plane) return
         along = [(1/(s(k, k) - s(k, modulo(k, ndim) + 1)**2/s(modulo(k, ndim) + 1, modulo(k, ndim) + 1)), k=1, ndim)]
         plane_modulus = along(1)*product(along/along(1))**(1.0_dp/ndim) ! E' itself where all are alike
      end associate
   end function plane_modulus
end module hampm_material
