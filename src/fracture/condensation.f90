!> Closing of a static crack: compliance of the faces at pairs of nodes, and the work that closes their separation by the loads.
!> That work over the area is the energy release rate as the crack grew there, which gives its change with the length of the crack
!> from one mesh.
module hampm_condensation
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t, face_nodes, upper, lower
   use hampm_crack_tip_field, only: modes
   use hampm_lapack, only: dposv
   use hampm_problem, only: problem_t
   use hampm_stiffness, only: stiffness_t
   implicit none
   private
   public :: condensation_t, new_condensation

   !> A relative motion of the faces at a pair of nodes: the upper one moves along an axis and the lower one against it. On a
   !> symmetry plane there is one node.
   type :: parting_t
      integer :: node(2) = 0                     !! on the upper and the lower face, 0 where there is no face
      integer :: mode = 1                        !! opening or sliding
      real(dp) :: axis(ndim) = 0                 !! unit vector
      integer :: place = 0                       !! number of the pair
   end type parting_t

   !> Separations at some pairs, and the response to unit forces on each.
   type :: condensation_t
      type(parting_t), allocatable :: parting(:)
      real(dp), allocatable :: moved(:, :, :)    !! displacement by a unit force on each [m/N], (ndim, n_points, partings)
      real(dp), allocatable, private :: compliance(:, :) !! parting of each by a unit force on each other [m/N]
      real(dp), allocatable, private :: parted(:)        !! by the loads [m]
   contains
      procedure :: close_pairs
   end type condensation_t

contains

   !> Find the closing of the pairs at some numbers of cells behind tips, in their order; `found`: number of pairs present, one
   !> after the other.
   subroutine new_condensation(m, rest, tips, cells, u, condensation, found)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: rest
      type(crack_tip_t), intent(in) :: tips(:)
      integer, intent(in) :: cells(:)            !! by tip
      real(dp), intent(in) :: u(:, :)            !! displacement by the loads [m], (ndim, n_points)
      type(condensation_t), intent(out) :: condensation
      integer, intent(out) :: found
      real(dp), allocatable :: force(:, :, :)
      integer :: k, i
      allocate (condensation%parting(0))
      do found = 0, size(cells) - 1
         k = size(condensation%parting)
         call add_pair(m, tips(found + 1), cells(found + 1), found + 1, u, condensation%parting)
         if (size(condensation%parting) == k) exit
      end do
      associate (n => size(condensation%parting))
         allocate (force(ndim, m%grid%n_points, n), source=0.0_dp)
         allocate (condensation%compliance(n, n), condensation%parted(n))
         do k = 1, n
            associate (at => condensation%parting(k))
               if (at%node(upper) > 0) force(:, at%node(upper), k) = at%axis
               if (at%node(lower) > 0) force(:, at%node(lower), k) = -at%axis
            end associate
            condensation%parted(k) = parting_by(condensation%parting(k), u)
         end do
         call rest%solve_for_all(m, force, condensation%moved)
         do k = 1, n
            condensation%compliance(:, k) = [(parting_by(condensation%parting(i), condensation%moved(:, :, k)), i=1, n)]
         end do
      end associate
   end subroutine new_condensation

   !> Add the separations of the pair at a number of cells behind a tip, if present. Of quadratic cells the pair half a cell nearer
   !> to the tip is added: both together close a cell. Pressed faces are closed: their overlap is the compliance of the layer.
   subroutine add_pair(m, tip, cells, place, u, list)
      type(problem_t), intent(in) :: m
      type(crack_tip_t), intent(in) :: tip
      integer, intent(in) :: cells, place
      real(dp), intent(in) :: u(:, :)            !! displacement by the loads [m], (ndim, n_points)
      type(parting_t), allocatable, intent(inout) :: list(:)
      integer :: node(2), middle(2), mode
      node = face_nodes(tip, m%grid, tip%place - cells*tip%nodes%spacing*tip%axis(:, 1))
      if (any(node == 0 .and. tip%face)) return
      if (m%grid%is_quadratic()) then
         middle = face_nodes(tip, m%grid, tip%place - (cells - 0.5_dp)*tip%nodes%spacing*tip%axis(:, 1))
         if (any(middle == 0 .and. tip%face)) return
      end if
      do mode = 1, merge(1, modes, tip%is_half())
         if (m%grid%is_quadratic()) call add(middle)
         call add(node)
      end do

   contains

      !> Add one of them.
      subroutine add(at)
         integer, intent(in) :: at(2)            !! nodes
         type(parting_t) :: parting
         parting = parting_t(at, mode, tip%axis(:, modes + 1 - mode), place)
         if (mode == 1 .and. tip%may_close .and. parting_by(parting, u) < 0) return
         list = [list, parting]
      end subroutine add
   end subroutine add_pair

   !> Separation of a pair by a displacement of the points [m].
   pure real(dp) function parting_by(at, u) result(parting)
      type(parting_t), intent(in) :: at
      real(dp), intent(in) :: u(:, :)            !! (ndim, n_points)
      parting = 0
      if (at%node(upper) > 0) parting = dot_product(u(:, at%node(upper)), at%axis)
      if (at%node(lower) > 0) parting = parting - dot_product(u(:, at%node(lower)), at%axis)
   end function parting_by

   !> Close some pairs: the forces on all their separations [N], 0 on other pairs and on those held together by supports, and their
   !> work by mode [J].
   subroutine close_pairs(self, places, force, work)
      class(condensation_t), intent(in) :: self
      integer, intent(in) :: places(:)           !! the pairs, by their numbers
      real(dp), intent(out) :: force(:), work(modes)
      integer, allocatable :: chosen(:)
      real(dp), allocatable :: matrix(:, :), b(:, :)
      integer :: i, info
      force = 0
      work = 0
      chosen = pack([(i, i=1, size(force))], [(any(places == self%parting(i)%place) .and. self%compliance(i, i) > 0, &
                                               i=1, size(force))])
      if (size(chosen) == 0) return
      allocate (matrix, source=self%compliance(chosen, chosen))
      b = reshape(self%parted(chosen), [size(chosen), 1])
      call dposv('L', size(chosen), 1, matrix, size(chosen), b, size(chosen), info)
      if (info /= 0) return
      force(chosen) = b(:, 1)
      do i = 1, size(force)
         associate (mode => self%parting(i)%mode)
            work(mode) = work(mode) + force(i)*self%parted(i)/2
         end associate
      end do
   end subroutine close_pairs
end module hampm_condensation
