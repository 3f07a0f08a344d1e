!> Interface of a material law: stress, energy, dissipation and tangent of material that is strained in space.
!>
!> A law sees the whole displacement gradient H, 3 x 3. `hampm_material` treats, once for all laws, the plane (H_33 = 0 in plane
!> strain, stress_33 = 0 in plane stress), eigenstrain and the mean dilatation of cells. The history of a particle, its state
!> variables, are `columns` numbers: `update` advances them over a step; stress, energy and dissipation belong to an updated state.
!>
!> Laws for small strain take eps = sym(H), and their stress holds on any configuration; laws for any strain (`is_finite`) give the
!> Kirchhoff stress tau = P F^T, which keeps the digits of small strains.
!>
!> A new law is a file that extends this type, with its keys, and a row in the table of `hampm_laws`.
module hampm_law
   use hampm_kinds, only: dp, name_len
   use hampm_tensors, only: space, unit_tensor, inverse_transpose_of
   implicit none
   private
   public :: law_t, law_row_t, constant_t, flaw_t, add_flaw, constant, value_of, values_of, most_columns, most_values

   integer, parameter :: most_columns = 48       !! state variables that a law may have

   integer, parameter :: most_values = 8         !! of a constant

   !> A constant of a law, by the name of its key.
   type :: constant_t
      character(name_len) :: name = ''
      integer :: count = 0                       !! of its values
      real(dp) :: value(most_values) = 0         !! in the unit of the key
   end type constant_t

   !> An invalid constant.
   type :: flaw_t
      character(name_len) :: key = ''
      character(:), allocatable :: what          !! message that follows the key
   end type flaw_t

   !> A row of the table of laws.
   type :: law_row_t
      character(name_len) :: name = ''           !! in model files
      logical :: is_finite = .false.             !! whether it is for any rotation and strain
      logical :: has_history = .false.           !! whether it has state variables
      procedure(make_law), pointer, nopass :: make => null() !! of the linear laws none
      procedure(check_law), pointer, nopass :: check => null() !! of laws whose constants have to fit each other
   end type law_row_t

   !> A law with its constants.
   type, abstract :: law_t
      integer :: columns = 0                     !! state variables
      logical :: is_finite = .false.             !! whether it is for any rotation and strain: bodies may buckle
      logical :: yields = .false.                !! whether its dissipation is plastic work, else viscous
   contains
      procedure(stress_of), deferred :: stress
      procedure(tangent_of), deferred :: tangent
      procedure(energy_of), deferred :: energy
      procedure :: update
      procedure :: dissipation
      procedure :: plastic_strain
      procedure :: across
   end type law_t

   abstract interface
      !> The law of Lame constants at small strain [Pa] and constants of its own.
      subroutine make_law(lambda, mu, constants, law)
         import :: dp, constant_t, law_t
         real(dp), intent(in) :: lambda, mu
         type(constant_t), intent(in) :: constants(:)
         class(law_t), allocatable, intent(out) :: law
      end subroutine make_law

      !> Find in which constants, each of which is by itself as its key asks, do not fit the others.
      pure subroutine check_law(young, poisson, plane_stress, constants, flaws)
         import :: dp, constant_t, flaw_t
         real(dp), intent(in) :: young, poisson
         logical, intent(in) :: plane_stress     !! else plane strain
         type(constant_t), intent(in) :: constants(:)
         type(flaw_t), allocatable, intent(out) :: flaws(:)
      end subroutine check_law

      !> Stress of a state [Pa]: of a finite law the Kirchhoff stress, 0 where the material is inverted, which the caller detects.
      pure function stress_of(self, h, state) result(stress)
         import :: law_t, dp, space
         class(law_t), intent(in) :: self
         real(dp), intent(in) :: h(space, space) !! displacement gradient [-]
         real(dp), intent(in) :: state(:)        !! state variables, up to date
         real(dp) :: stress(space, space)
      end function stress_of

      !> Change of the first Piola stress at the end of a step by a small change of H [Pa]: the tangent consistent with `update`;
      !> without a step the instantaneous elastic tangent.
      pure function tangent_of(self, h, dh, state, dt) result(change)
         import :: law_t, dp, space
         class(law_t), intent(in) :: self
         real(dp), intent(in) :: h(space, space), dh(space, space) !! at the end, and its change [-]
         real(dp), intent(in) :: state(:)        !! before the step
         real(dp), intent(in), optional :: dt    !! length of the step [s]
         real(dp) :: change(space, space)
      end function tangent_of

      !> Elastic energy of a state per reference volume [J/m3].
      pure real(dp) function energy_of(self, h, state) result(energy)
         import :: law_t, dp, space
         class(law_t), intent(in) :: self
         real(dp), intent(in) :: h(space, space), state(:)
      end function energy_of
   end interface

contains

   !> A constant of these values.
   pure type(constant_t) function constant(name, values)
      character(*), intent(in) :: name
      real(dp), intent(in) :: values(:)          !! the first `most_values` count
      constant%name = name
      constant%count = min(size(values), most_values)
      constant%value(:constant%count) = values(:constant%count)
   end function constant

   !> Append a flaw. A constructor with a text is not deallocated within an array: a trap of gfortran.
   pure subroutine add_flaw(flaws, key, what)
      type(flaw_t), allocatable, intent(inout) :: flaws(:)
      character(*), intent(in) :: key, what
      type(flaw_t) :: flaw
      flaw%key = key
      flaw%what = what
      flaws = [flaws, flaw]
   end subroutine add_flaw

   !> The values of a constant; none where it is not given.
   pure function values_of(constants, name) result(values)
      type(constant_t), intent(in) :: constants(:)
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      integer :: k
      k = findloc(constants%name, name, dim=1)
      values = [real(dp) ::]
      if (k > 0) values = constants(k)%value(:constants(k)%count)
   end function values_of

   !> The value of a constant, or another one where it is not given.
   pure real(dp) function value_of(constants, name, else) result(value)
      type(constant_t), intent(in) :: constants(:)
      character(*), intent(in) :: name
      real(dp), intent(in) :: else
      integer :: k
      k = findloc(constants%name, name, dim=1)
      value = else
      if (k > 0) value = merge(constants(k)%value(1), else, constants(k)%count > 0)
   end function value_of

   !> Bring state variables to the end of a step. Here nothing is kept.
   pure subroutine update(self, h, dt, state)
      class(law_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space)    !! displacement gradient at the end of the step [-]
      real(dp), intent(in) :: dt                 !! its length [s]
      real(dp), intent(inout) :: state(:)
   end subroutine update

   !> Dissipation per reference volume [J/m3]; here 0.
   pure real(dp) function dissipation(self, state)
      class(law_t), intent(in) :: self
      real(dp), intent(in) :: state(:)
      dissipation = 0
   end function dissipation

   !> Equivalent plastic strain [-]. Here nothing yields.
   pure real(dp) function plastic_strain(self, state)
      class(law_t), intent(in) :: self
      real(dp), intent(in) :: state(:)
      plastic_strain = 0
   end function plastic_strain

   !> H_33 at zero stress_33 [-], by Newton's iteration: at the end of a step, or without a step of an updated state. The stress
   !> rises with H_33. The next value is by bisection where Newton's leaves the bracket or inverts the material, or where a step is
   !> not half of the last one, as where the tangents of a law that yields lead round in circles.
   pure real(dp) function across(self, h, state, dt) result(h_33)
      class(law_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space)    !! H_33 is not used [-]
      real(dp), intent(in) :: state(:)           !! before the step
      real(dp), intent(in), optional :: dt       !! length of the step [s]
      real(dp), parameter :: thickness(space, space) = reshape([0, 0, 0, 0, 0, 0, 0, 0, 1], [space, space])
      integer, parameter :: most_iterations = 60
      real(dp) :: trial(space, space), slope(space, space), stress(space, space), low, high, step, last, least
      real(dp) :: now(size(state))
      integer :: k
      trial = h
      trial(3, 3) = 0
      low = -1
      if (.not. self%is_finite) low = -huge(low)
      high = huge(high)
      last = huge(last)
      do k = 1, most_iterations
         now = state
         if (present(dt)) call self%update(trial, dt, now)
         stress = self%stress(trial, now)
         if (self%is_finite) stress = matmul(stress, inverse_transpose_of(unit_tensor + trial))
         slope = self%tangent(trial, thickness, state, dt)
         if (.not. abs(slope(3, 3)) > 0) exit
         if (stress(3, 3) > 0) high = trial(3, 3)
         if (stress(3, 3) < 0) low = trial(3, 3)
         step = -stress(3, 3)/slope(3, 3)
         least = 2*epsilon(step)*max(abs(trial(3, 3)), maxval(abs(h(:2, :2))))
         if (abs(step) > least .and. max(-low, high) < huge(high) .and. &
             (abs(step) > last/2 .or. trial(3, 3) + step <= low .or. trial(3, 3) + step >= high)) &
            step = (low + high)/2 - trial(3, 3)
         if (abs(step) <= least) exit
         last = abs(step)
         trial(3, 3) = trial(3, 3) + step
      end do
      h_33 = trial(3, 3)
   end function across
end module hampm_law
