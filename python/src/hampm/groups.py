"""The groups of a model and their keys, for editors and checkers of types: what `hampm --keys --json` says, printed by tools/python_groups.py."""

from collections.abc import Sequence
from typing import Literal

from .namelist import Group, GroupList, RunGroup


class Run(RunGroup):
    """What is computed, and for how long."""

    title: str | None
    """What the run is about; the result keeps it; default ''"""
    plane: Literal['stress', 'strain', 'axisymmetric'] | None
    """Plane stress, plane strain, or material around the axis x = 0, where x is the radius; default 'stress'"""
    thickness: float | None
    """Thickness of the plane; forces and energies are those of all of it [m]; (0, inf); default 1.0"""
    end_time: float | None
    """The run goes from time 0 to this time [s]; (0, inf); required"""
    stop_when: Literal['arrested', 'load_dropped', 'crack_length', 'separated'] | Sequence[Literal['arrested', 'load_dropped', 'crack_length', 'separated']] | None
    """What ends the run before that, at a sample; none by default; no default"""
    stop_length: float | None
    """Of crack_length: length of a whole crack [m]; [0, inf); default 0.0"""
    stop_load: float | None
    """Of load_dropped: part of the largest load so far; (0, 1); default 0.5"""
    stop_rest: float | None
    """Of arrested, in motion: time for which no tip has grown [s]; [0, inf); default 0.0"""


class Grid(Group):
    """The lattice of square root cells that the material moves through."""

    lower: float | Sequence[float] | None
    """Lower corner of the lattice [m]; (-inf, inf); default [0.0, 0.0]"""
    cell: float | None
    """Size of a root cell, the same in both directions [m]; (0, inf); required"""
    cells: int | Sequence[int] | None
    """Number of root cells in each direction; [1, inf); required"""
    order: int | None
    """Of the shape functions: 1 bilinear, 2 biquadratic cells with nine nodes; [1, 2]; default 1"""


class Material(Group):
    """A material; bodies name it."""

    name: str | None
    """Name that bodies refer to; required"""
    law: Literal['linear_elastic', 'neo_hookean', 'mooney_rivlin', 'j2_plastic', 'viscoelastic', 'orthotropic'] | None
    """Neo_hookean and mooney_rivlin are for any strain and rotation, the others for small ones; default 'linear_elastic'"""
    young: float | None
    """Young's modulus, at small strain; required of isotropic laws [Pa]; (0, inf); no default"""
    poisson: float | None
    """Poisson's ratio, at small strain; (-1, 0.5); default 0.0"""
    density: float | None
    """Mass per undeformed volume [kg/m3]; (0, inf); required"""
    volumetric: Literal['standard', 'b_bar'] | None
    """Each point has its own dilatation, or the mean of its cell, which does not lock at constant volume; default 'standard'"""
    yield_stress: float | None
    """Of law = 'j2_plastic': the stress in uniaxial tension at which the material yields at first [Pa]; [0, inf); default 0.0"""
    hardening: float | None
    """Of law = 'j2_plastic': by which the yield stress rises with the equivalent plastic strain [Pa]; [0, inf); default 0.0"""
    saturation: float | None
    """Of law = 'j2_plastic': by which it rises to a limit besides (Voce) [Pa]; [0, inf); default 0.0"""
    saturation_strain: float | None
    """The equivalent plastic strain at which 1 - 1/e of that is reached; required with saturation; (0, inf); no default"""
    kinematic_hardening: float | None
    """Of law = 'j2_plastic': by which the back stress rises with the plastic strain (Prager) [Pa]; [0, inf); default 0.0"""
    c01: float | None
    """Of law = 'mooney_rivlin': modulus of the second invariant; c10 = young/(4 (1 + poisson)) - c01 [Pa]; (0, inf); no default"""
    moduli: float | Sequence[float] | None
    """Of law = 'viscoelastic': the relaxing parts of the instantaneous shear modulus, a Prony series [Pa]; (0, inf); no default"""
    relaxation_times: float | Sequence[float] | None
    """Of law = 'viscoelastic': the time in which each of them falls to 1/e [s]; (0, inf); no default"""
    young_1: float | None
    """Of 'orthotropic': Young's modulus along axis 1 of the material [Pa]; (0, inf); no default"""
    young_2: float | None
    """The same along axis 2 [Pa]; (0, inf); no default"""
    young_3: float | None
    """The same across the plane; required in plane strain [Pa]; (0, inf); no default"""
    shear_12: float | None
    """Shear modulus in the plane, between axes 1 and 2 [Pa]; (0, inf); no default"""
    shear_13: float | None
    """Of solids: the same between axes 1 and 3 [Pa]; (0, inf); no default"""
    shear_23: float | None
    """Of solids: the same between axes 2 and 3 [Pa]; (0, inf); no default"""
    poisson_12: float | None
    """-(strain along 2)/(strain along 1) under stress along 1; poisson_21 follows; (-inf, inf); no default"""
    poisson_13: float | None
    """-(strain across the plane)/(strain along 1) under stress along 1; required in plane strain; (-inf, inf); no default"""
    poisson_23: float | None
    """-(strain across the plane)/(strain along 2) under stress along 2; required in plane strain; (-inf, inf); no default"""
    angle: float | None
    """Of axis 1 of an orthotropic material from x, anticlockwise; of solids around x, then y, then z [degrees]; (-inf, inf); default 0.0"""


class Body(Group):
    """A piece of material, or a hole in one; bodies must not overlap."""

    material: str | None
    """Name of its material; none of a hole; default ''"""
    shape: Literal['rectangle', 'polygon', 'circle', 'cylinder', 'sphere'] | None
    """A rectangle along the grid lines, a polygon or a circle; a solid is a box, cylinder or sphere; default 'rectangle'"""
    lower: float | Sequence[float] | None
    """Lower corner of a rectangle or box; lower end of the axis of a cylinder [m]; (-inf, inf); no default"""
    upper: float | Sequence[float] | None
    """Upper corner of a rectangle or box; upper end of the axis of a cylinder [m]; (-inf, inf); no default"""
    points: float | Sequence[float] | None
    """Corners of a polygon: x1, y1, x2, y2, ..., as one walks around it [m]; (-inf, inf); no default"""
    center: float | Sequence[float] | None
    """Center of a circle or sphere [m]; (-inf, inf); no default"""
    radius: float | None
    """Radius of a circle, cylinder or sphere [m]; [0, inf); default 0.0"""
    hole: bool | None
    """Whether it is a hole, in the body that it lies in; holes come after all bodies; default False"""
    points_per_cell: int | None
    """Material points per root cell in each direction; even where cells may refine; [1, 16]; default 2"""
    velocity: float | Sequence[float] | None
    """Initial velocity of its middle [m/s]; (-inf, inf); default [0.0, 0.0]"""
    spin: float | None
    """Initial angular velocity around its middle, anticlockwise; of a solid around x, y and z [rad/s]; (-inf, inf); default 0.0"""
    eigenstrain: float | Sequence[float] | None
    """Strain xx, yy, xy and zz (0) at which there is no stress; heat: alpha dT in xx, yy and zz; [-0.05, 0.05]; default [0.0, 0.0, 0.0]"""
    held: bool | None
    """Whether its eigenstrain stays where growth at rest scales loads, instead of being scaled too; default True"""
    toughness: float | None
    """Energy release rate at which a crack grows in it, in place of that of &growth; 0: that [J/m2]; [0, inf); default 0.0"""
    profile_direction: float | Sequence[float] | None
    """Of a graded body: the direction in which its material changes; (-inf, inf); default [1.0, 0.0]"""
    profile_at: float | Sequence[float] | None
    """Of a graded body: places along that, from the origin of coordinates on, increasing [m]; (-inf, inf); no default"""
    profile_stiffness: float | Sequence[float] | None
    """Factors of all moduli and strengths at these; exponential between; (0, inf); no default"""
    profile_density: float | Sequence[float] | None
    """Factors of the density at these; exponential between; (0, inf); no default"""
    profile_eigenstrain: float | Sequence[float] | None
    """Factors of the eigenstrain at these; linear between; (-inf, inf); no default"""
    contact_group: str | None
    """With &contact: bodies of the same part are one; without a name a body is one by itself; default ''"""


class Constraint(Group):
    """Displacement components of all grid nodes in a box that are held, or moved as prescribed."""

    lower: float | Sequence[float] | None
    """Lower corner of the box whose nodes are held [m]; (-inf, inf); required"""
    upper: float | Sequence[float] | None
    """Upper corner of the box, may equal the lower one [m]; (-inf, inf); required"""
    fix: Literal['x', 'y', 'xy'] | None
    """Components that are held there, or moved; required"""
    displacement: float | Sequence[float] | None
    """By which they are moved where its factor is 1 [m]; (-inf, inf); default [0.0, 0.0]"""
    velocity: float | Sequence[float] | None
    """With which they are moved where its factor is 1 [m/s]; (-inf, inf); default [0.0, 0.0]"""
    history: Literal['step', 'ramp', 'smooth_ramp', 'sine', 'table'] | None
    """Factor over time: 1, rising to 1 by a line or smoothly, sin(2 pi frequency t), or a table; t counts from start; default 'step'"""
    start: float | None
    """Time at which the history begins; before it the factor is 0 [s]; (-inf, inf); default 0.0"""
    rise_time: float | None
    """Of both ramps: time in which the factor rises from 0 to 1; needed there [s]; [0, inf); default 0.0"""
    frequency: float | None
    """Of a sine: its frequency; needed there [Hz]; [0, inf); default 0.0"""
    times: float | Sequence[float] | None
    """Of a table: increasing, counted from start; linear between, constant outside [s]; (-inf, inf); no default"""
    factors: float | Sequence[float] | None
    """Of a table: factors at its times, as many as these; (-inf, inf); no default"""
    held: bool | None
    """Whether it stays as its history has it where cracks grow at rest, which scales all others; default False"""
    name: str | None
    """Gives the force of this constraint columns of its own: reaction_<name>_x and _y; default ''"""
    unilateral: bool | None
    """Whether it holds what presses on it only: a support from which material may lift off; default False"""
    turns: bool | None
    """Whether its nodes turn freely about the middle of the box, as a rigid body: a pin or roller; default False"""


class Load(Group):
    """A force on the material, with its history in time."""

    kind: Literal['point', 'traction', 'body', 'pressure', 'gravity', 'absorbing'] | None
    """Acts at a point, on an edge, in a box, normal to an edge or crack, on all material; or lets waves out of an edge; required"""
    lower: float | Sequence[float] | None
    """Lower corner of where it acts; none of gravity and of pressure on a crack [m]; (-inf, inf); no default"""
    upper: float | Sequence[float] | None
    """Upper corner of where it acts, for a point equal to the lower one; none where lower is none [m]; (-inf, inf); no default"""
    side: int | None
    """Of a traction, pressure or absorbing edge: the side of a polygon or rectangle, by its number; 0: all in the box; [0, inf); default 0"""
    force: float | Sequence[float] | None
    """Of a point, traction or body: resultant of the whole load where its factor is 1 [N]; (-inf, inf); no default"""
    pressure: float | None
    """Of a pressure: force on each area where its factor is 1, positive into the material [Pa]; (-inf, inf); default 0.0"""
    on: Literal['edge', 'crack'] | None
    """Of a pressure: whether on a part of a body's edge or on all faces of a crack; default 'edge'"""
    crack: str | None
    """Of a pressure on a crack: its name, not needed where there is only one; default ''"""
    acceleration: float | Sequence[float] | None
    """Of gravity: force on each mass where its factor is 1 [m/s2]; (-inf, inf); default [0.0, 0.0]"""
    face: Literal['none', 'left', 'right'] | None
    """Of a point or traction on a line or path: its face, as one walks to its tip or last point; default 'none'"""
    history: Literal['step', 'ramp', 'smooth_ramp', 'sine', 'table'] | None
    """Factor over time: 1, rising to 1 by a line or smoothly, sin(2 pi frequency t), or a table; t counts from start; default 'step'"""
    start: float | None
    """Time at which the history begins; before it the factor is 0 [s]; (-inf, inf); default 0.0"""
    rise_time: float | None
    """Of both ramps: time in which the factor rises from 0 to 1; needed there [s]; [0, inf); default 0.0"""
    frequency: float | None
    """Of a sine: its frequency; needed there [Hz]; [0, inf); default 0.0"""
    times: float | Sequence[float] | None
    """Of a table: increasing, counted from start; linear between, constant outside [s]; (-inf, inf); no default"""
    factors: float | Sequence[float] | None
    """Of a table: factors at its times, as many as these; (-inf, inf); no default"""
    held: bool | None
    """Whether it stays as its history has it where cracks grow at rest, which scales all others; default False"""
    name: str | None
    """By which a &probe means it; default ''"""


class Damping(Group):
    """A force -rate m v on all material."""

    rate: float | None
    """Damping force over mass times velocity [1/s]; [0, inf); default 0.0"""


class Contact(Group):
    """How bodies that meet act on each other."""

    bodies: Literal['bonded', 'stick', 'frictionless', 'friction'] | None
    """Bonded: one velocity field, in which they stick; else one for each: those that touch stick, or slide; default 'bonded'"""
    friction: float | None
    """Of bodies = 'friction': coefficient; [0, inf); default 0.0"""
    distance: float | None
    """Gap between their surfaces at which bodies touch [m]; [0, inf); default 0.0"""


class Method(Group):
    """How the equations of motion are integrated."""

    time: Literal['explicit', 'implicit', 'static', 'modal'] | None
    """How motion is followed: by short explicit steps, by implicit ones, from equilibrium to equilibrium, or by modes; default 'explicit'"""
    time_step: float | None
    """Of time = 'implicit': longest time step; 0: by courant, and 1/1000 of end_time where that is 0 [s]; [0, inf); default 0.0"""
    hht_alpha: float | None
    """Of time = 'implicit': 0 for average acceleration; below it steps damp what they do not resolve; [-0.33334, 0]; default 0.0"""
    modes: int | None
    """Of time = 'modal': number of modes; 0: so many that the rest takes at most 0.001 of the strain energy of any load; [0, 100000]; default 0"""
    start: Literal['undeformed', 'static'] | None
    """Of motion: from undeformed bodies, or from the static equilibrium of what acts at time 0; default 'undeformed'"""
    load_steps: int | None
    """Of time = 'static': equal steps of the time, by which loads vary, up to end_time; [1, 100000]; default 1"""
    scheme: Literal['usf', 'usl', 'usavg', 'musl'] | None
    """When a step updates the stress: first, last, half and half, or last by velocities mapped anew; default 'musl'"""
    courant: float | None
    """Time step over cell size / wave speed; 0: 0.9 of the limit, in the updated frame 0.1 or less; [0, 1000]; default 0.0"""
    path: Literal['fastest', 'reference'] | None
    """Of explicit steps: the fastest one for the model, or the plain reference step; default 'fastest'"""
    wave_speed: Literal['shear', 'dilatational'] | None
    """Which wave speed courant refers to; default 'shear'"""
    frame: Literal['updated', 'total'] | None
    """Shape functions at the present positions, for bodies that meet, or always at the initial ones; default 'total'"""
    shape_functions: Literal['linear', 'cpdi'] | None
    """Of a particle in frame = 'updated': of its place, or the mean over the corners of its domain; default 'linear'"""
    mass: Literal['auto', 'lumped', 'consistent', 'partial', 'fmpm', 'weighted', 'tip_weighted'] | None
    """By row sums, consistent, so in some cells, a series, a weighted mean, that around tips; auto: lumped or tip_weighted; default 'auto'"""
    order: int | None
    """Of mass = 'fmpm': number of terms of the series; 1 is lumped; [1, 100]; default 2"""
    lumped_fraction: float | None
    """Of mass = 'weighted' and 'tip_weighted': weight of the lumped matrix; 5/18 has the least dispersion in short steps; [0, 1]; default 0.2778"""
    consistent_region: Literal['box', 'refined'] | None
    """Of mass = 'partial': it is consistent in a box, or in the cells that are refined; default 'box'"""
    consistent_lower: float | Sequence[float] | None
    """Of consistent_region = 'box': lower corner of the box in which mass = 'partial' is consistent [m]; (-inf, inf); default [0.0, 0.0]"""
    consistent_upper: float | Sequence[float] | None
    """Of consistent_region = 'box': upper corner of this box; needed there [m]; (-inf, inf); default [0.0, 0.0]"""
    solver: Literal['auto', 'cg', 'direct'] | None
    """Of mass matrices that are not lumped and of equilibrium; auto: direct; cg for masses on 1e6 cells, solids of 3e4 or more; default 'auto'"""


class Refine(Group):
    """Where cells refine; without this group they never do."""

    indicator: Literal['none', 'gradient', 'zz', 'tip'] | None
    """What tells which cells refine: gradients, the estimated error, the distance to the tip; default 'none'"""
    field: Literal['energy_density', 'stress_norm', 'speed'] | None
    """Of indicator = 'gradient': the field whose gradients count; default 'energy_density'"""
    r_crit: float | None
    """Of 'gradient': cells whose mean R is above it refine; (0, inf); default 0.03"""
    r_coarsen: float | None
    """Of 'gradient': cells whose mean R is below it recombine; 0: never; below r_crit; [0, inf); default 0.0"""
    energy_floor: float | None
    """Of 'gradient': cells whose field is below this part of its largest value do not refine; [0, 1); default 0.001"""
    tolerance: float | None
    """Of 'zz': relative error in the energy norm that is aimed at; (0, 1); default 0.02"""
    rings: int | None
    """Of 'tip': cells within so many cells of a crack tip refine, level by level; [1, 1000]; default 4"""
    max_level: int | None
    """How often a root cell may be divided; its size is halved each time; [0, 20]; default 4"""
    region_lower: float | Sequence[float] | None
    """Lower corner of the box in which cells may refine; without limit by default [m]; (-inf, inf); no default"""
    region_upper: float | Sequence[float] | None
    """Upper corner of the box in which cells may refine; without limit by default [m]; (-inf, inf); no default"""
    start: float | None
    """Time of the first look at gradient or zz: loads that begin make steep fronts [s]; [0, inf); default 0.0"""
    interval: int | None
    """Steps between looks at the indicator; [1, inf); default 100"""
    max_particles: int | None
    """Most material points; where there would be more, refinement ends with a warning; [1, 2e9]; default 1000000"""


class Crack(Group):
    """A crack; without this group the model has none. All but the kind symmetry may be several."""

    kind: Literal['symmetry', 'line', 'path', 'plane'] | None
    """In a plane, inside or the constrained one of a symmetric half; in two dimensions also a line or a path in any direction; default 'symmetry'"""
    tip: float | Sequence[float] | None
    """Crack tip, at a symmetry plane a node of the lattice; of two tips the one that direction points out of [m]; (-inf, inf); no default"""
    direction: float | Sequence[float] | None
    """From the crack out of its tip; at a symmetry plane along it; (-inf, inf); default [1.0, 0.0]"""
    normal: Literal['x', 'y'] | None
    """Of kind = 'plane': axis across it; default 'y'"""
    front: Literal['straight', 'disc', 'ellipse', 'polygon'] | None
    """Of a half plane, through tip; of a disc, in two dimensions between two tips, an ellipse or a polygon, which is cracked; default 'straight'"""
    center: float | Sequence[float] | None
    """Of a disc or an ellipse [m]; (-inf, inf); no default"""
    radii: float | None
    """One of a disc; two of an ellipse, along the axes of its plane in the order x, y, z [m]; (0, inf); no default"""
    length: float | None
    """Of a straight crack with two tips or fronts: from one to the other; 0: it reaches the edge of the material [m]; [0, inf); default 0.0"""
    contact: Literal['none', 'frictionless', 'friction'] | None
    """Of a line, a path or a plane: whether faces press on each other or go through; default 'none'"""
    friction: float | None
    """With contact = 'friction': coefficient; [0, inf); default 0.0"""
    points: float | Sequence[float] | None
    """Of a path: x1, y1, x2, y2, ..., as one walks along it; ends inside are tips. Of a polygon: corners [m]; (-inf, inf); no default"""
    name: str | None
    """By which other groups mean it; default ''"""


class Cohesive(Group):
    """How the faces of a crack hold each other by cohesion; without this group they do not."""

    crack: str | None
    """Name of the crack; may be left out where there is one crack; default ''"""
    # from, a word of Python: group["from"]: float | None; Way along its points from which on faces hold each other; there its tip is at first [m]; [0, inf); default 0.0
    law: Literal['linear', 'bilinear', 'table'] | None
    """Traction over opening: falling by a line, rising and falling by lines, or along points; default 'linear'"""
    strength: float | None
    """Largest traction across the faces, of the laws linear and bilinear [Pa]; [0, inf); default 0.0"""
    toughness: float | None
    """Energy to part faces by opening, of these laws [J/m2]; [0, inf); default 0.0"""
    opening: float | None
    """Of law = bilinear: opening at the strength [m]; [0, inf); default 0.0"""
    openings: float | Sequence[float] | None
    """Of law = table: ascending; before one above 0 the traction rises from 0 by a line, without damage [m]; [0, inf); no default"""
    tractions: float | Sequence[float] | None
    """Across the faces at these openings, the last 0 [Pa]; [0, inf); no default"""
    strength_shear: float | None
    """Largest traction along the faces; 0: that across them [Pa]; [0, inf); default 0.0"""
    toughness_shear: float | None
    """Energy to part faces by sliding; 0: that by opening [J/m2]; [0, inf); default 0.0"""
    mixed_mode: Literal['benzeggagh_kenane', 'power'] | None
    """How the toughness of both together is found; default 'benzeggagh_kenane'"""
    exponent: float | None
    """Of that; [1, 1000]; default 1.0"""


class Growth(Group):
    """How a crack grows; without this group cracks stay as they are."""

    crack: str | None
    """Name of the crack; may be left out where there is one crack; default ''"""
    law: Literal['quasi_static', 'prescribed', 'toughness', 'fatigue', 'subcritical'] | None
    """At rest by increments, under loads that are scaled, in load cycles or in time; in motion, at a speed or by the toughness; default 'quasi_static'"""
    direction: Literal['straight', 'hoop_stress', 'local_symmetry', 'max_energy', 'path'] | None
    """Where tips go to; path: along points; default 'hoop_stress'"""
    points: float | Sequence[float] | None
    """Of direction = path: x, y of each point, in the order in which the tip comes to them [m]; (-inf, inf); no default"""
    toughness: float | None
    """Energy release rate at which the crack grows by quasi_static and toughness; by fatigue and charles it breaks then [J/m2]; [0, inf); default 0.0"""
    limit_speed: float | None
    """Of law or rate = toughness, which at speed v is toughness/(1 - (v/limit_speed)**exponent); 0: it is constant [m/s]; [0, inf); default 0.0"""
    exponent: float | None
    """Of that; (0, inf); default 1.0"""
    speed: float | None
    """Of law = prescribed; of rate = charles at K_c: speed (K/K_c)**rate_exponent [m/s]; [0, inf); default 0.0"""
    rate_constant: float | None
    """Of law = fatigue: C of its rate, m/cycle where the range of K is 1 Pa sqrt(m); of forman times 1 Pa sqrt(m) [m/(Pa m^0.5)^m]; [0, inf); default 0.0"""
    rate_exponent: float | None
    """Of law = fatigue: m of its rate; of charles n; [0, inf); default 0.0"""
    walker_exponent: float | None
    """Of rate = walker: the range of K counts as divided by (1 - R)**(1 - walker_exponent); [0, inf); default 1.0"""
    threshold: float | None
    """Of law = fatigue: range of K up to which a tip does not grow; of charles K [Pa m^0.5]; [0, inf); default 0.0"""
    wheeler_exponent: float | None
    """Of law = fatigue: by which growth is slow within the plastic zone of an overload; 0: it is not; [0, inf); default 0.0"""
    wheeler_stress: float | None
    """Yield stress, which tells how large these zones are [Pa]; [0, inf); default 0.0"""
    extensions: float | Sequence[float] | None
    """R-curve: ways that a tip has grown, ascending [m]; [0, inf); no default"""
    extension_factors: float | Sequence[float] | None
    """By which the toughness is multiplied there; (0, inf); no default"""
    speeds: float | Sequence[float] | None
    """Of the tip, in motion and by rate = toughness, ascending [m/s]; [0, inf); no default"""
    speed_factors: float | Sequence[float] | None
    """By which the toughness is multiplied there; (0, inf); no default"""
    angles: float | Sequence[float] | None
    """From x to the left to the direction in which a tip goes, ascending; they repeat after 180 [deg]; [-180, 180]; no default"""
    angle_factors: float | Sequence[float] | None
    """By which the toughness is multiplied there; (0, inf); no default"""
    mixed_mode: Literal['none', 'hutchinson_suo', 'benzeggagh_kenane'] | None
    """How the toughness rises with mode II; default 'none'"""
    # lambda, a word of Python: group["lambda"]: float | None; Of hutchinson_suo: 1 + tan((1 - lambda) psi)**2; 1: no rise, 0: G_I has the toughness; [0, 1]; default 0.3
    toughness_shear: float | None
    """Of benzeggagh_kenane: toughness in mode II [J/m2]; [0, inf); default 0.0"""
    mixed_mode_exponent: float | None
    """Of benzeggagh_kenane: eta; [0.1, 100]; default 1.0"""
    rate: Literal['paris', 'walker', 'forman', 'charles', 'toughness'] | None
    """Of law = fatigue: whose law the way in a cycle follows; of subcritical: charles, or where the toughness at a speed is G; default 'paris'"""
    start: float | None
    """From when on this &growth applies, in motion [s]; [0, inf); default 0.0"""
    end: float | None
    """Until when; 0: to the end of the run [s]; [0, inf); default 0.0"""
    increment: float | None
    """By which a tip advances in a load step at rest; of fatigue that which is the first to [m]; [0, inf); default 0.0"""
    max_length: float | None
    """Length of the whole crack at which it stops; 0: none [m]; [0, inf); default 0.0"""
    tips: Literal['all', 'largest', 'last', 'first'] | None
    """Which tips go on: all; at rest, of all with this, that with the largest G over toughness; in motion that at an end; default 'all'"""


class Nucleation(Group):
    """When a &crack appears at rest that is not there before: by strength and toughness together."""

    crack: str | None
    """Name of the crack; may be left out where there is one crack; default ''"""
    toughness: float | None
    """Energy that it must release for its area, from the equilibrium before it to the one with it [J/m2]; [0, inf); default 0.0"""
    strength: float | None
    """Stress across it that all of it must have before; 0: the energy tells, if stress opens it in the mean [Pa]; [0, inf); default 0.0"""
    increment: float | None
    """By which the lengths differ that are tried, from its first point on; 0: it appears as a whole [m]; [0, inf); default 0.0"""


class Control(Group):
    """What a load frame controls as cracks grow at rest; load and displacement become columns."""

    quantity: Literal['growth', 'load', 'displacement'] | None
    """What is given: growth, an increment a load step; the load; or the displacement of the load frame; default 'growth'"""
    displacement: float | None
    """Of the load frame where its factor is 1 [m]; (-inf, inf); default 0.0"""
    stiffness: float | None
    """Of the load frame, a spring in series with the specimen; 0: it is rigid [N/m]; [0, inf); default 0.0"""
    history: Literal['step', 'ramp', 'smooth_ramp', 'sine', 'table'] | None
    """Factor over time: 1, rising to 1 by a line or smoothly, sin(2 pi frequency t), or a table; t counts from start; default 'step'"""
    start: float | None
    """Time at which the history begins; before it the factor is 0 [s]; (-inf, inf); default 0.0"""
    rise_time: float | None
    """Of both ramps: time in which the factor rises from 0 to 1; needed there [s]; [0, inf); default 0.0"""
    frequency: float | None
    """Of a sine: its frequency; needed there [Hz]; [0, inf); default 0.0"""
    times: float | Sequence[float] | None
    """Of a table: increasing, counted from start; linear between, constant outside [s]; (-inf, inf); no default"""
    factors: float | Sequence[float] | None
    """Of a table: factors at its times, as many as these; (-inf, inf); no default"""


class Cycles(Group):
    """The load cycles of law = fatigue; without it loads fall to 0 in each cycle."""

    ratio: float | None
    """Least over largest load of a cycle; (-inf, 1); default 0.0"""
    blocks: float | Sequence[float] | None
    """Cycles of one kind that follow one another: how many of each kind; (0, inf); no default"""
    factors: float | Sequence[float] | None
    """Of each block: by which the largest load is multiplied; (0, inf); no default"""
    ratios: float | Sequence[float] | None
    """Of each block: least over largest load, in place of ratio; (-inf, 1); no default"""
    repeat: bool | None
    """Whether the blocks begin again after the last one; else that goes on; default False"""


class EnergyRelease(Group):
    """Which energy quantities are recorded."""

    estimators: Literal['domain_integral', 'vcct', 'material_force', 'stress_closure'] | Sequence[Literal['domain_integral', 'vcct', 'material_force', 'stress_closure']] | None
    """Of the energy release rate and of K, which the history records; none by default; no default"""
    energy_balance: bool | None
    """Whether the history records the energy that the method itself loses, numerical_loss; default False"""
    radii: float | Sequence[float] | None
    """Of domain_integral: increasing; by default 0.4, 0.6, 0.8 of what fits, of two cells or more; of solids 4, 5 and 6 cells [m]; (0, inf); no default"""
    t_stress: bool | None
    """Whether the history records the T-stress, by domain_integral; default False"""
    phase_length: float | None
    """Of tips between two materials: distance ahead at which K_I and K_II are those of the stress; 0: no K there [m]; [0, inf); default 0.0"""
    reference: Literal['none', 'dcb', 'value'] | None
    """Where the reference value G_ref comes from: nowhere, double cantilever beam theory, or a key; default 'none'"""
    reference_value: float | None
    """G_ref where reference = 'value'; needed there [J/m2]; [0, inf); default 0.0"""


class Probe(Group):
    """What the history records at a point, along a line, of a crack, or of a load."""

    name: str | None
    """What the names of its columns end with, before x, y, xx, yy, xy or zz; required"""
    quantity: Literal['displacement', 'velocity', 'stress', 'strain', 'opening', 'volume', 'load_line'] | Sequence[Literal['displacement', 'velocity', 'stress', 'strain', 'opening', 'volume', 'load_line']] | None
    """What is recorded, one or several; required"""
    at: float | Sequence[float] | None
    """A material point, x, y; or a straight line from x1, y1 to x2, y2, of which the mean is recorded [m]; (-inf, inf); no default"""
    face: Literal['none', 'left', 'right'] | None
    """Of a point on a crack: its face, as one walks to the tip or last point of the crack; default 'none'"""
    of: str | Sequence[str] | None
    """Of opening or volume: name of the crack; of load_line: of the load or constraint, and of another it moves from; no default"""
    tip: Literal['last', 'first'] | None
    """Of opening: at which end of its crack the tip is; default 'last'"""
    distance: float | None
    """Of opening: how far behind that tip, along the crack [m]; [0, inf); default 0.0"""


class Accuracy(Group):
    """An error asked of a result: the program chooses cells, levels and steps that are not given."""

    quantity: str | None
    """Column of the history with an estimated error, of every tip; or of one, as K_I_tip2; required"""
    error: float | None
    """Estimated error that it may have at most, as part of its value; (0, 1); required"""
    at: Literal['end', 'largest', 'mean', 'all'] | None
    """Of the last row, of that with the largest value, the root mean square of all, or all, as parts of the largest value; default 'end'"""
    most_time: float | None
    """Predicted duration that the run may have at most; 0: any [s]; [0, inf); default 0.0"""
    most_memory: float | None
    """Predicted memory that the run may take at most; 0: what there is [bytes]; [0, inf); default 0.0"""
    must: bool | None
    """Whether a run that would not reach it does not start, instead of coming as near as it can; default False"""


class Output(Group):
    """What is written, and how often."""

    file: str | None
    """Result file in the output folder; by default named after the namelist file; default ''"""
    history_interval: float | None
    """Time between samples of the history, where explicit steps end; 0: a thousandth of end_time [s]; [0, inf); default 0.0"""
    snapshot_interval: float | None
    """Time between snapshots of particles and mesh, taken at the end of the step or load step in which it comes; 0: none [s]; [0, inf); default 0.0"""
    checkpoint_interval: float | None
    """Wall time between checkpoints, from which --resume goes on; 0: none [s]; [0, inf); default 0.0"""
    checkpoint_steps: int | None
    """Steps between checkpoints; 0: none; [0, inf); default 0"""


class Groups:
    """The groups of a model."""

    run: Run
    """What is computed, and for how long."""
    grid: Grid
    """The lattice of square root cells that the material moves through."""
    material: GroupList[Material]
    """A material; bodies name it."""
    body: GroupList[Body]
    """A piece of material, or a hole in one; bodies must not overlap."""
    constraint: GroupList[Constraint]
    """Displacement components of all grid nodes in a box that are held, or moved as prescribed."""
    load: GroupList[Load]
    """A force on the material, with its history in time."""
    damping: Damping
    """A force -rate m v on all material."""
    contact: Contact
    """How bodies that meet act on each other."""
    method: Method
    """How the equations of motion are integrated."""
    refine: Refine
    """Where cells refine; without this group they never do."""
    crack: GroupList[Crack]
    """A crack; without this group the model has none. All but the kind symmetry may be several."""
    cohesive: GroupList[Cohesive]
    """How the faces of a crack hold each other by cohesion; without this group they do not."""
    growth: GroupList[Growth]
    """How a crack grows; without this group cracks stay as they are."""
    nucleation: GroupList[Nucleation]
    """When a &crack appears at rest that is not there before: by strength and toughness together."""
    control: Control
    """What a load frame controls as cracks grow at rest; load and displacement become columns."""
    cycles: Cycles
    """The load cycles of law = fatigue; without it loads fall to 0 in each cycle."""
    energy_release: EnergyRelease
    """Which energy quantities are recorded."""
    probe: GroupList[Probe]
    """What the history records at a point, along a line, of a crack, or of a load."""
    accuracy: GroupList[Accuracy]
    """An error asked of a result: the program chooses cells, levels and steps that are not given."""
    output: Output
    """What is written, and how often."""
