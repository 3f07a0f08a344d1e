!> The largest stable courant number of a model, and the default.
module hampm_largest_step
   use hampm_kinds, only: dp, ndim
   use hampm_critical_step, only: row_t, ring_t, row_of_points, row_of_cut_cells, shifted, largest_courant, sample_cells, &
      largest_wave_speed
   use hampm_law, only: law_row_t
   use hampm_laws, only: law_row
   use hampm_material, only: material_t
   use hampm_mass_choice, only: mass_choice_t, new_mass_choice
   use hampm_aggregated_nodes, only: least_fill
   use hampm_placement, only: tolerance, points_of
   use hampm_quadratic_points, only: fewest_points
   use hampm_model, only: model_t, body_t, cuts_cells, cracks_cut_cells
   use hampm_model_materials, only: materials_of, material_of
   use hampm_tensors, only: norm, n_voigt
   implicit none
   private
   public :: courant_limit, default_courant, crosses_cells, chosen_speed, smallest_cell, most_damping_a_step, default_part

   !> `rate*dt` above which `v <- v - rate*dt*v` turns the velocity around in a step; from 2 on it grows.
   real(dp), parameter :: most_damping_a_step = 1.0_dp
   real(dp), parameter :: default_part = 0.9_dp  !! part of the limit, for effects that a sample does not have
   !> Courant numbers of the paper, for material that moves through the cells: its edges gain energy when they cross them, below any
   !> limit for a body at one place (docs/explanation/time_step.md).
   real(dp), parameter :: crossing = 0.1_dp, crossing_full = 0.05_dp
   !> Reduction of the limit by several materials in contact, at least: quarters of a square that meet in a point
   real(dp), parameter :: of_contrast = 0.9_dp
   !> Reduction by waves along no grid line in orthotropic material: 2 % at most in 20 extreme samples
   real(dp), parameter :: of_anisotropy = 0.95_dp
   !> Reduction by cells of several sizes, for `usl` with a mass matrix that is not lumped (docs/explanation/time_step.md)
   real(dp), parameter :: of_hanging_nodes = 0.8_dp
   !> Reduction by finer cells with a lattice of particles that does not fit: with leapfrog schemes and the lumped mass matrix, of
   !> the limit over phases of the lattice, and else (docs/explanation/time_step.md)
   real(dp), parameter :: of_misfit_edges = 0.95_dp, of_misfit_else = 0.8_dp
   !> Reduction by growing cracks: they cut cells anywhere, into pieces with few particles and nodal motions without mass; schemes
   !> that map velocities from particles are not affected (docs/explanation/growth_motion.md)
   real(dp), parameter :: of_growth = 0.5_dp
   !> Depths of lines of particles in empty cells, of those positions with the least limit [cells]
   real(dp), parameter :: entered(*) = [0.01_dp, 0.03_dp, 0.06_dp, 0.1_dp, 0.16_dp]
   !> Reduction by cut quadratic cells with `fewest_points`, at edges, cracks and bonded points of tips: 3 % at most in 800 random
   !> samples (docs/explanation/quadratic_cut.md)
   real(dp), parameter :: of_cut_quadratic = 0.9_dp
   !> Reduction by cut cells: they multiply the largest eigenvalue by 1.27 at most
   real(dp), parameter :: of_cut_cells = 0.88_dp
   !> Reduction by rings whose axis is next to the edges
   real(dp), parameter :: of_rings = 0.9_dp
   !> Reduction by edges in any direction
   real(dp), parameter :: of_outlines = 0.95_dp
   !> Reduction by deformation of domains of particles; without the small losses of usl energy grows slowly in longer steps, as
   !> material crosses cells (docs/explanation/domains.md)
   real(dp), parameter :: of_domains = 0.6_dp, of_domains_in_leapfrog = 0.3_dp
   !> Further reduction by slivers at edges that cut the lattice: their domains have half of the edges
   real(dp), parameter :: of_cut_domains = 0.5_dp
   real(dp), parameter :: grace = 1e-9_dp        !! distance below which positions are the same [cells]
   real(dp), parameter :: small_move = 0.1_dp    !! motion of a body that does not count as flight [cells]
   real(dp), parameter :: thinnest = 1e-6_dp     !! thinnest body considered; the limit grows for thinner ones [cells]
   real(dp), parameter :: most = 1000            !! largest value, as for the key
   integer, parameter :: parts = merge(6, 3, ndim == 2) !! parts of cells for the fills at edges
   integer, parameter :: shifted_cells = 3       !! cells of a sample that is tried at any offset

contains

   !> The largest stable courant number, of the wave speed that the model names, in three digits; the keys it depends on are good.
   real(dp) function courant_limit(model) result(limit)
      type(model_t), intent(in) :: model
      type(mass_choice_t) :: mass
      real(dp) :: step
      integer :: k, j
      associate (method => model%method)
         mass = new_mass_choice(method%mass, method%solver, method%order, method%lumped_fraction, method%consistent_lower, &
                                method%consistent_upper)
         step = huge(step)
         do k = 1, size(model%bodies)
            if (any([(is_alike(model, model%bodies(k), model%bodies(j)), j=1, k - 1)])) cycle
            step = min(step, body_limit(model, model%bodies(k), mass))
         end do
         limit = step*chosen_speed(model)
         if (any(model%materials%law == 'orthotropic')) limit = limit*of_anisotropy
         if (any(model%bodies%material_index /= model%bodies(1)%material_index)) limit = limit*of_contrast
         if (method%scheme == 'usl' .and. method%mass /= 'lumped' .and. model%refine%is_active()) limit = limit*of_hanging_nodes
         if (method%scheme == 'usl' .and. method%mass /= 'lumped' .and. size(model%growth) > 0) limit = limit*of_growth
         if (model%grid%order > 1) then
            if (cuts_cells(model)) limit = limit*of_cut_quadratic
         else if (cracks_cut_cells(model) .or. size(model%growth) + size(model%cohesive) > 0) then
            limit = limit*of_cut_cells
         end if
      end associate
      limit = rounded_down(limit)
   end function courant_limit

   !> Default courant number: a safe part of the limit that was found; less for material that moves through the cells, and for
   !> damping, which a long step would not resolve.
   real(dp) function default_courant(model) result(courant)
      type(model_t), intent(in) :: model
      courant = default_part*model%method%courant_limit
      associate (method => model%method)
         if (method%frame == 'updated' .and. .not. method%has_domains()) &
            courant = min(courant, merge(crossing_full, crossing, method%mass == 'consistent' .or. method%mass == 'partial'))
      end associate
      if (model%damping%rate > 0) & ! a step at the limit takes all of a velocity
         courant = min(courant, default_part*(most_damping_a_step/model%damping%rate/smallest_cell(model)*chosen_speed(model)))
      courant = rounded_down(min(courant, most))
   end function default_courant

   !> The wave speed that courant refers to, the largest of any material [m/s].
   real(dp) function chosen_speed(model) result(speed)
      type(model_t), intent(in) :: model
      speed = largest_wave_speed(materials_of(model), model%method%wave_speed)
   end function chosen_speed

   !> Size of the cells for the first step: cells around a tip are there from the start [m].
   pure real(dp) function smallest_cell(model) result(cell)
      type(model_t), intent(in) :: model
      cell = model%grid%cell
      if (model%refine%by%is_of_places) cell = scale(cell, -model%refine%max_level)
   end function smallest_cell

   !> Largest stable time step over cell size for a single body [s/m].
   real(dp) function body_limit(model, body, mass) result(limit)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      type(mass_choice_t), intent(in) :: mass
      type(row_t) :: rows(ndim), moved(ndim)
      real(dp) :: start(ndim), length(ndim), speed, moduli(n_voigt, n_voigt), damping
      integer, parameter :: positions = size(entered) + 1
      integer :: n(ndim), d, i, at(ndim)
      logical :: strains_last
      type(material_t) :: material
      type(ring_t), allocatable :: ring
      material = material_of(model, body%material_index) ! gfortran 12 frees the law of an associate name twice
      associate (cell => model%grid%cell)
         n = points_of(model, body)
         length = max((body%upper - body%lower)/cell, thinnest)
         start = place_in_cell(model, body)
         speed = material%dilatational_wave_speed()*quickening(body)
         moduli = material%stiffness/(material%density*material%dilatational_wave_speed()**2)
         damping = min(model%damping%rate*smallest_cell(model), 1e100_dp*speed)/speed
         strains_last = model%method%scheme == 'usl'
         if (material%is_ring) ring = ring_t(start(1) - body%lower(1)/cell, material%hoop_moduli() &
                                             /(material%density*material%dilatational_wave_speed()**2))
         if (body%outline%is_there() .and. .not. crosses_cells(model, body) .and. model%grid%order == 1) then
            ! Edges cut cells anywhere; cells filled less than `least_fill` move with others
            limit = of_outlines*limit_of_fills([(least_fill + i*(1 - least_fill)/parts, i=0, parts)], least_fill, &
                                               body%points_per_cell, moduli, material%isotropic, mass, strains_last, damping)/speed
            if (material%is_ring) limit = limit*of_rings
            return
         end if
         if (model%grid%order > 1 .and. cuts_cells(model)) then ! whole cells are tried
            start = 0
            length = max(1, nint(length))
            n = nint(length)*fewest_points
         end if
         if (.not. crosses_cells(model, body)) then
            do d = 1, ndim                       ! an array of function results would leak in gfortran 12
               rows(d) = row_of_points(start(d), start(d) + length(d), n(d), sample_cells/model%grid%order)
            end do
            limit = largest_courant(rows, moduli, mass, strains_last, damping, have_domains=.false., &
                                    are_quadratic=model%grid%order > 1, ring=ring)/speed
            if (cracks_cut_cells(model) .and. model%grid%order == 1) & ! between columns of particles; nodes beyond have no mass
               limit = min(limit, limit_of_fills([(i, i=1, body%points_per_cell)]/real(body%points_per_cell, dp), 0.0_dp, &
                                                 body%points_per_cell, moduli, material%isotropic, mass, strains_last, &
                                                 damping)/speed/of_cut_cells)
            if (.not. model%refine%is_active() .or. model%grid%order > 1) return
            if (fits_cells([(rows(d)%spacing, d=1, ndim)], start, body%points_per_cell)) return
            limit = min(limit, limit_at_edges(start, length, n, model%refine%max_level, moduli, mass, strains_last, damping)/speed)
            limit = limit*of_misfit(model, body%points_per_cell)
            return
         end if
         n = max(1, nint(n*min(1.0_dp, shifted_cells/length)))
         length = n*length/points_of(model, body)
         start = ceiling(length - grace) - length          ! the upper end on a node
         do d = 1, ndim
            rows(d) = row_of_points(start(d), start(d) + length(d), n(d), sample_cells)
         end do
         limit = huge(limit)
         do i = 0, positions**ndim - 1
            at = [(mod(i/positions**d, positions), d=0, ndim - 1)]
            ! Others differ by the names of the directions only
            if (material%isotropic .and. any([(any(n(:d - 1) == n(d) .and. at(:d - 1) > at(d)), d=2, ndim)])) cycle
            if (ndim > 2 .and. any(at > 0 .and. at /= maxval(at))) cycle ! between these, and many
            moved = rows
            do d = 1, ndim
               if (at(d) > 0) moved(d) = shifted(rows(d), rows(d)%spacing/2 + entered(at(d)))
            end do
            limit = min(limit, largest_courant(moved, moduli, mass, strains_last, damping, model%method%has_domains(), &
                                               ring=ring)/speed)
         end do
         if (model%method%has_domains()) then
            limit = limit*merge(of_domains, of_domains_in_leapfrog, strains_last)
            if (body%outline%is_there()) limit = limit*of_cut_domains
         end if
      end associate
   end function body_limit

   !> How much faster waves are where they are fastest in a graded body than in its material [-].
   pure real(dp) function quickening(body)
      type(body_t), intent(in) :: body
      quickening = 1
      if (.not. allocated(body%profile%at)) return
      if (size(body%profile%at) > 1) quickening = sqrt(maxval(body%profile%stiffness/body%profile%density))
   end function quickening

   !> Whether particles are at the same places in all cells, where finer cells allow no less.
   pure logical function fits_cells(spacing, start, points_per_cell) result(fits)
      real(dp), intent(in) :: spacing(ndim)      !! of the particles [cells]
      real(dp), intent(in) :: start(ndim)        !! place of the body's start in its cell [cells]
      integer, intent(in) :: points_per_cell
      associate (halves => 2*points_per_cell*start)
         fits = all(abs(points_per_cell*spacing - 1) <= grace .and. abs(halves - anint(halves)) <= grace)
      end associate
   end function fits_cells

   !> The limit of the edges of a body in finer cells: the first levels have all kinds of ends of edges in cells. Times the wave
   !> speed over the size of a cell [-].
   pure real(dp) function limit_at_edges(start, length, n, max_level, moduli, mass, strains_last, damping) result(limit)
      real(dp), intent(in) :: start(ndim)        !! place of the body's start in its cell [cells]
      real(dp), intent(in) :: length(ndim)       !! [cells]
      integer, intent(in) :: n(ndim)             !! particles
      integer, intent(in) :: max_level
      real(dp), intent(in) :: moduli(n_voigt, n_voigt) !! over density times wave speed squared [-]
      type(mass_choice_t), intent(in) :: mass
      logical, intent(in) :: strains_last        !! usl
      real(dp), intent(in) :: damping            !! rate times cell size over dilatational wave speed [-]
      integer, parameter :: levels = 4
      type(row_t) :: rows(ndim)
      integer :: level, d
      limit = huge(limit)
      do level = 1, min(max_level, levels)
         associate (begin => modulo(2**level*start, 1.0_dp))
            do d = 1, ndim
               rows(d) = row_of_points(begin(d), begin(d) + 2**level*length(d), 2**level*n(d), sample_cells)
            end do
         end associate
         limit = min(limit, largest_courant(rows, moduli, mass, strains_last, damping, have_domains=.false.))
      end do
   end function limit_at_edges

   !> Reduction of the limit by finer cells. Of n particles in a cell and direction the shortest vibration takes the part (1 -
   !> 1/n^2)/3 of M over D if they are as far from both nodes, and (1 + 2/n^2)/3 if one is at a node; leapfrog schemes have its root
   !> in their frequencies. The limit holds for root cells, which may be the former, and some finer cells are the latter.
   pure real(dp) function of_misfit(model, points_per_cell) result(part)
      type(model_t), intent(in) :: model
      integer, intent(in) :: points_per_cell
      associate (squared => real(max(points_per_cell, 2), dp)**2)  ! others are errors
         part = of_misfit_edges*sqrt((squared - 1)/(squared + 2))
      end associate
      if (model%method%mass /= 'lumped' .or. model%method%scheme == 'usl') part = of_misfit_else
   end function of_misfit

   !> The same for cells at the edge of a material filled by any of some parts, and corners by their products. Times the wave speed
   !> over the size of a cell [-].
   pure real(dp) function limit_of_fills(fills, least, points_per_cell, moduli, isotropic, mass, strains_last, damping) &
      result(limit)
      real(dp), intent(in) :: fills(:)           !! the least first [-]
      real(dp), intent(in) :: least              !! least fill of corners considered [-]
      integer, intent(in) :: points_per_cell
      real(dp), intent(in) :: moduli(n_voigt, n_voigt) !! over density times wave speed squared [-]
      logical, intent(in) :: isotropic           !! whether the moduli are the same in every direction
      type(mass_choice_t), intent(in) :: mass
      logical, intent(in) :: strains_last        !! usl
      real(dp), intent(in) :: damping            !! rate times cell size over dilatational wave speed [-]
      type(row_t) :: rows(ndim)
      integer :: k, d, of(ndim)                  ! of(d): which fill it has in a direction
      limit = huge(limit)
      do k = 0, size(fills)**ndim - 1
         of = [(1 + mod(k/size(fills)**(d - 1), size(fills)), d=1, ndim)]
         if (isotropic .and. any(of(2:) < of(:ndim - 1))) cycle ! the same up to the names of directions
         if (product(fills(of)) < least) cycle
         do d = 1, ndim
            rows(d) = row_of_cut_cells(fills(of(d)), points_per_cell)
         end do
         limit = min(limit, largest_courant(rows, moduli, mass, strains_last, damping, have_domains=.false.))
      end do
   end function limit_of_fills

   !> Whether the particles of a body may be anywhere in the cells: in flight, or with a law for finite strain. With usl no time
   !> step would do for all positions.
   impure elemental logical function crosses_cells(model, body) result(crosses)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      type(law_row_t) :: row
      crosses = model%method%has_domains()
      if (crosses .or. model%method%frame == 'total' .or. model%method%scheme == 'usl') return
      row = law_row(trim(model%materials(body%material_index)%law))
      crosses = row%is_finite .or. maxval(abs(body%velocity)) + sum(abs(body%spin))*norm(body%upper - body%lower)/2 &
                > small_move*model%grid%cell/model%run%end_time
   end function crosses_cells

   !> Position of the lower corner of a body in its cell [cells].
   pure function place_in_cell(model, body) result(place)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp) :: place(ndim)
      place = (body%lower - model%grid%lower)/model%grid%cell
      place = place - aint(place)
      where (abs(place - anint(place)) <= grace) place = 0
   end function place_in_cell

   !> Whether two bodies have the same limit.
   pure logical function is_alike(model, a, b)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: a, b
      is_alike = (a%outline%is_there() .eqv. b%outline%is_there()) &
                 .and. a%material_index == b%material_index .and. .not. abs(quickening(a) - quickening(b)) > 0 &
                 .and. a%points_per_cell == b%points_per_cell &
                 .and. all(abs((a%upper - a%lower) - (b%upper - b%lower)) <= tolerance(model%grid)) &
                 .and. all(abs(place_in_cell(model, a) - place_in_cell(model, b)) <= grace)
   end function is_alike

   !> A positive number, rounded down to three digits.
   pure real(dp) function rounded_down(x)
      real(dp), intent(in) :: x
      real(dp) :: unit
      unit = 10.0_dp**(2 - floor(log10(x)))
      rounded_down = aint(x*unit*(1 + epsilon(x)))/unit
   end function rounded_down
end module hampm_largest_step
