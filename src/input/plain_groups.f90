!> Values of the groups &run, &contact and &method in a model: those of their keys (`hampm_group_values`), and derived ones.
module hampm_plain_groups
   use hampm_kinds, only: dp
   use hampm_group_values, only: contact_keys_t, method_keys_t, run_keys_t
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: body_contact_spec_t, method_t, run_t

   !> &contact.
   type, extends(contact_keys_t) :: body_contact_spec_t
   contains
      procedure :: is_wanted
   end type body_contact_spec_t

   !> &run: kind and duration of the computation.
   type, extends(run_keys_t) :: run_t
      type(thickness_t) :: thickness
   end type run_t

   !> &method: how the equations of motion are integrated.
   type, extends(method_keys_t) :: method_t
      real(dp) :: courant_limit = 0              !! the largest stable one, if the namelist gives none [-]
   contains
      procedure :: has_domains
   end type method_t

contains

   !> Whether bodies have velocity fields of their own.
   pure logical function is_wanted(self)
      class(body_contact_spec_t), intent(in) :: self
      is_wanted = self%bodies == 'stick' .or. self%bodies == 'frictionless' .or. self%bodies == 'friction'
   end function is_wanted

   !> Whether particles have domains (`hampm_domains`).
   elemental logical function has_domains(self)
      class(method_t), intent(in) :: self
      has_domains = self%shape_functions == 'cpdi'
   end function has_domains
end module hampm_plain_groups
