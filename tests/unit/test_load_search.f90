!> The load factor at which cracks at rest are about to grow, from ratios of G to the toughness that are polynomials of the second degree.
program test_load_search
   use hampm_kinds, only: dp
   use hampm_load_search, only: load_search_t
   use hampm_harness, only: check, check_close, finish
   implicit none

   call try([0.0_dp], [3.0_dp], [0.0_dp], .true., 1/3.0_dp, 2, 'one tip, all loads scaled')
   call try([-2.0_dp], [3.0_dp], [0.0_dp], .false., 1.0_dp, 4, &
            'held loads press a crack together, whose faces interpenetrate where the search begins')
   call try([-20.0_dp], [3.0_dp], [0.0_dp], .false., 7.0_dp, 5, 'the same, far beyond where it begins')
   call try([0.4_dp], [3.0_dp], [0.0_dp], .false., 0.2_dp, 5, 'held loads open it')
   call try([-2.0_dp], [3.0_dp], [0.6_dp], .false., (2 + 0.8_dp)/3, 5, 'with shear that is held')
   call try([-2.0_dp, -8.0_dp, 0.0_dp], [3.0_dp, 2.0_dp, 1.0_dp], [0.6_dp, 0.0_dp, 0.0_dp], .false., (2 + 0.8_dp)/3, 5, &
            'the first of three tips, of which another has more G with faces that interpenetrate')
   call try([-1e6_dp], [3.0_dp], [0.0_dp], .false., (1e6_dp + 1)/3, 15, 'a load that hardly counts where the search begins')
   call finish()

contains

   !> Search with K_I = held + load*scaled and K_II = shear of each tip, and r = K_I**2 + K_II**2.
   subroutine try(held, scaled, shear, is_proportional, expected, most, what)
      real(dp), intent(in) :: held(:), scaled(:), shear(:)
      logical, intent(in) :: is_proportional
      real(dp), intent(in) :: expected           !! load factor
      integer, intent(in) :: most                !! solutions
      character(*), intent(in) :: what
      type(load_search_t) :: search
      real(dp) :: load, next
      logical :: is_found
      integer :: k
      search%is_proportional = is_proportional
      load = 1
      do k = 1, most
         call search%note(load, (held + load*scaled)**2 + shear**2)
         call search%choose(next, is_found)
         if (is_found) exit
         load = next
      end do
      call check(is_found, what//': found')
      call check_close(load, expected, 1e-6_dp*expected, what)
   end subroutine try
end program test_load_search
