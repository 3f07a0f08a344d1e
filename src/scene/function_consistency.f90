!> Whether cracks run along the domains of particles of `functions = 'cpdi'`.
module hampm_function_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_placement, only: points_of
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t, body_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_functions

   character(*), parameter :: intro = 'with &method functions = ''cpdi'''

contains

   !> Check a scene whose particles have domains; others have no use for this.
   pure subroutine check_functions(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method, k
      method = settings%find('method', 1)
      if (.not. settings%good(method, 'functions') .or. .not. scene%method%has_domains()) return
      do k = 1, size(scene%paths)
         call check_path(scene, settings, k, mistakes)
      end do
   end subroutine check_functions

   !> A crack parts domains: it runs along their edges.
   pure subroutine check_path(scene, settings, path, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: path                  !! which of the paths
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry, k, j
      entry = settings%find('crack', path)
      if (.not. settings%good(entry, 'points')) return
      do k = 2, size(scene%paths(path)%points, 2)
         do j = 1, size(scene%bodies)
            if (runs_along_domains(scene, scene%bodies(j), scene%paths(path)%points(:, k - 1:k))) cycle
            call settings%complain(mistakes, entry, 'points', 'must run along edges of the domains of particles '//intro// &
                                   ', which are rectangles with the edges '//to_text(edge_of(scene, scene%bodies(j), 1))//', '// &
                                   to_text(edge_of(scene, scene%bodies(j), 2))//' m from the lower corner of the body on: a '// &
                                   'crack through a domain would not part it')
            return
         end do
      end do
   end subroutine check_path

   !> Whether a segment runs along edges of the domains of a body, or past it.
   pure logical function runs_along_domains(scene, body, ends) result(along)
      type(scene_t), intent(in) :: scene
      type(body_t), intent(in) :: body
      real(dp), intent(in) :: ends(ndim, 2)        !! [m]
      real(dp), parameter :: grace = 1e-6_dp       ! of an edge
      real(dp) :: lines
      integer :: d
      along = any(maxval(ends, dim=2) <= body%lower .or. minval(ends, dim=2) >= body%upper)
      do d = 1, ndim
         if (along) return
         lines = (ends(d, 1) - first_edge(scene, body, d))/edge_of(scene, body, d)
         along = abs(ends(d, 2) - ends(d, 1)) <= grace*edge_of(scene, body, d) .and. abs(lines - anint(lines)) <= grace
      end do
   end function runs_along_domains

   !> Edge of the domains of a body that no edge of it cuts [m].
   pure real(dp) function edge_of(scene, body, direction)
      type(scene_t), intent(in) :: scene
      type(body_t), intent(in) :: body
      integer, intent(in) :: direction
      integer :: points(ndim)
      if (body%outline%is_there()) then
         edge_of = scene%grid%cell/body%points_per_cell
      else
         points = points_of(scene, body)
         edge_of = (body%upper(direction) - body%lower(direction))/points(direction)
      end if
   end function edge_of

   !> Where an edge of them is [m].
   pure real(dp) function first_edge(scene, body, direction)
      type(scene_t), intent(in) :: scene
      type(body_t), intent(in) :: body
      integer, intent(in) :: direction
      first_edge = merge(scene%grid%lower(direction), body%lower(direction), body%outline%is_there())
   end function first_edge
end module hampm_function_consistency
