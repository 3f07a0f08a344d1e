!> Dependence of a tip's toughness beside its law: on extension, speed, direction and mode mix.
!>
!> Each is a factor. Those of extension, speed and direction are tables, linear between their points and constant beyond. A
!> direction is a line in the material: its table repeats after 180 degrees. With the share m of mode II in G and
!> tan(psi)**2 = m/(1 - m),
!>
!>    1 + tan((1 - lambda) psi)**2              Hutchinson & Suo, Adv. Appl. Mech. 29 (1992) 63, equation 2.42
!>    1 + (G_II,c/G_I,c - 1) m**eta             Benzeggagh & Kenane, Compos. Sci. Technol. 56 (1996) 439
!>
!> are the factors of the mix of modes.
module hampm_toughness
   use hampm_kinds, only: dp, name_len
   implicit none
   private
   public :: advance_t, factors_t, table_t, direction_of

   real(dp), parameter :: degree = acos(-1.0_dp)/180

   !> State of an advancing tip on which its toughness depends.
   type :: advance_t
      real(dp) :: speed = 0                      !! [m/s]
      real(dp) :: length = 0                     !! of the whole crack [m]
      real(dp) :: extension = 0                  !! growth of the tip so far [m]
      real(dp) :: angle = 0                      !! of its direction, from x to the left [rad]
      real(dp) :: shear = 0                      !! share of mode II in G [-]
      real(dp) :: of_body = 0                    !! toughness of the body there, least of a seam; 0: that of &growth [J/m2]
      logical :: or_of_growth = .false.          !! whether a body with that of &growth is on the seam: the lesser of both counts
      logical :: is_of_seam = .false.            !! whether bodies of several toughnesses are there
   end type advance_t

   !> A table of factors.
   type :: table_t
      real(dp), allocatable :: x(:)              !! ascending
      real(dp), allocatable :: factor(:)         !! [-]
   contains
      procedure :: is_there
      procedure :: at
      procedure :: around
   end type table_t

   !> All factors.
   type :: factors_t
      type(table_t) :: of_extension              !! [m]
      type(table_t) :: of_speed                  !! [m/s]
      type(table_t) :: of_angle                  !! [deg]
      character(name_len) :: mixed_mode = 'none'
      real(dp) :: lambda = 1
      real(dp) :: of_shear = 1                   !! toughness of mode II over that of mode I
      real(dp) :: exponent = 1
   contains
      procedure :: product_at
      procedure :: of_mix
   end type factors_t

contains

   !> Product of all factors [-].
   pure real(dp) function product_at(self, advance) result(factor)
      class(factors_t), intent(in) :: self
      type(advance_t), intent(in) :: advance
      factor = self%of_extension%at(advance%extension)*self%of_speed%at(advance%speed) &
               *self%of_angle%around(advance%angle/degree)*self%of_mix(advance%shear)
   end function product_at

   !> Factor of the mix of modes [-].
   pure real(dp) function of_mix(self, shear) result(factor)
      class(factors_t), intent(in) :: self
      real(dp), intent(in) :: shear              !! share of mode II [-]
      real(dp), parameter :: least = 1e-6_dp     ! so that nothing overflows
      factor = 1
      select case (self%mixed_mode)
       case ('hutchinson_suo')
         factor = 1/max(least, cos((1 - self%lambda)*atan2(sqrt(shear), sqrt(max(0.0_dp, 1 - shear))))**2)
       case ('benzeggagh_kenane')
         factor = 1 + (self%of_shear - 1)*shear**self%exponent
      end select
   end function of_mix

   !> Whether there is a table.
   pure logical function is_there(self)
      class(table_t), intent(in) :: self
      is_there = .false.
      if (allocated(self%x)) is_there = size(self%x) > 0
   end function is_there

   !> Its factor, 1 without any [-].
   pure real(dp) function at(self, x) result(factor)
      class(table_t), intent(in) :: self
      real(dp), intent(in) :: x
      integer :: i
      factor = 1
      if (.not. self%is_there()) return
      i = count(self%x <= x)
      if (i == 0) then
         factor = self%factor(1)
      else if (i == size(self%x)) then
         factor = self%factor(i)
      else
         factor = between(self%x(i), self%factor(i), self%x(i + 1), self%factor(i + 1), x)
      end if
   end function at

   !> The same for a periodic table of directions.
   pure real(dp) function around(self, x) result(factor)
      class(table_t), intent(in) :: self
      real(dp), intent(in) :: x                  !! [deg]
      real(dp), parameter :: turn = 180
      real(dp) :: angle
      factor = 1
      if (.not. self%is_there()) return
      angle = self%x(1) + modulo(x - self%x(1), turn)
      associate (n => size(self%x))
         factor = self%at(angle)
         if (angle > self%x(n)) factor = between(self%x(n), self%factor(n), self%x(1) + turn, self%factor(1), angle)
      end associate
   end function around

   !> On the line through two points.
   pure real(dp) function between(x1, y1, x2, y2, x) result(y)
      real(dp), intent(in) :: x1, y1, x2, y2, x
      y = y1 + (y2 - y1)*(x - x1)/(x2 - x1)
   end function between

   !> Angle of a direction, from x to the left [rad].
   pure real(dp) function direction_of(along) result(angle)
      real(dp), intent(in) :: along(:)
      angle = atan2(along(2), along(1))
   end function direction_of
end module hampm_toughness
