!> The families of meshes and steps among which a run that is to reach an error chooses: those on the fronts of
!> docs/evidence/tradeoff.md, of accuracy over cost. Their work is measured by bench/accuracy.py --fit, which `make tradeoff` runs.
module hampm_families
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: family_t, families

   !> A family: what it sets beside lattice and levels, and what its runs cost.
   type :: family_t
      character(32) :: name
      character(8) :: time                       !! of &method
      character(10) :: mass                      !! of that
      integer :: order                           !! of &grid
      integer :: points_per_cell                 !! of &body
      integer :: rings                           !! of &refine indicator = 'tip'
      integer :: first_level, level_step, most_level !! of this
      logical :: is_second                       !! whether models take it that take none of its steps, and as high an order, before
      real(dp) :: work                           !! at rest and for modes of each particle, times the logarithm of their number;
                                                 !! in steps of each of them, a step being that of a wave through a root cell;
                                                 !! that of bilinear cells with lumped masses in explicit steps is 1.5
   end type family_t

   logical, parameter :: plane = ndim == 2

   type(family_t), parameter :: families(*) = [ &
      family_t('quadratic cells', 'static', 'auto', 2, 3, 3, merge(0, 1, plane), 1, merge(14, 3, plane), .false., 130.0_dp), &
      family_t('bilinear cells', 'static', 'auto', 1, 2, 4, merge(0, 1, plane), 1, merge(14, 3, plane), .true., 63.0_dp), &
      family_t('bilinear cells', 'explicit', 'auto', 1, 2, 4, 0, 1, merge(4, 2, plane), .false., 1.5_dp), &
      family_t('bilinear cells, weighted masses', 'explicit', 'weighted', 1, 2, 4, 0, 1, merge(4, 2, plane), .false., &
               merge(4.0_dp, 11.0_dp, plane)), &
      family_t('quadratic cells', 'explicit', 'lumped', 2, 3, 3, 0, 1, merge(4, 2, plane), .false., 20.0_dp), &
      family_t('quadratic cells', 'explicit', 'consistent', 2, 3, 3, 0, 1, merge(4, 2, plane), .true., 12.0_dp), &
      family_t('quadratic cells', 'modal', 'auto', 2, 3, 3, merge(2, 0, plane), 1, merge(8, 2, plane), .false., 420.0_dp), &
      family_t('bilinear cells', 'modal', 'auto', 1, 2, 4, 0, 1, merge(8, 2, plane), .true., 190.0_dp), &
      family_t('quadratic cells', 'implicit', 'auto', 2, 3, 3, merge(2, 0, plane), 1, merge(8, 2, plane), .false., 38.0_dp), &
      family_t('bilinear cells', 'implicit', 'auto', 1, 2, 4, 0, 1, merge(8, 2, plane), .true., 13.0_dp)]
end module hampm_families
