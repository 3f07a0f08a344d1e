"""Models of cracks that appear, in laminates and at notches, for tests and pictures."""

import math

T90, T0, TOUGHNESS = 1e-3, 0.5e-3, 250.0  # half of the 90-degree plies, and those above [m]; J/m2
YOUNG, POISSON, K_IC, STRENGTH = 2.3e9, 0.36, 1.02e6, 124e6  # acrylic glass


def laminate(of, length, *, heat=1.0, cells=24, places=(0.0,), extra=""):
    """Plies between two cracks, and further ones that wait."""
    cell, half = T90 / cells, length / 2
    strains = [[a * of["dT"] * heat for a in pair] for pair in ((of["aT"], of["aT"]), (of["aA"], of["aT"]))]
    cracks = "".join(f"&crack name = 'c{k}'  kind = 'path'  points = {x}, {-1.5 * cell}, {x}, {T90} /\n&nucleation crack = 'c{k}'  toughness = {TOUGHNESS} /\n"
                     for k, x in enumerate(places))
    return f"""&run plane = 'stress'  thickness = 1.0  end_time = 1.0 /
&grid lower = {-half}, {-2 * cell}  cell = {cell}  cells = {round(length / cell)}, {round(1.5 * cells) + 4} /
&material name = 'n'  law = 'orthotropic'  young_1 = {of['ET']}  young_2 = {of['ET']}  shear_12 = {of['GT']}  poisson_12 = {of['nuT']}  density = 1600 /
&material name = 'z'  law = 'orthotropic'  young_1 = {of['EA']}  young_2 = {of['ET']}  shear_12 = {of['GA']}  poisson_12 = {of['nuA']}  density = 1600 /
&body material = 'n'  lower = {-half}, 0.0  upper = {half}, {T90}  eigenstrain = {strains[0][0]}, {strains[0][1]}, 0.0 /
&body material = 'z'  lower = {-half}, {T90}  upper = {half}, {T90 + T0}  eigenstrain = {strains[1][0]}, {strains[1][1]}, 0.0 /
&constraint lower = {-half}, 0.0  upper = {half}, 0.0  fix = 'y' /
&constraint lower = {-half}, {T90}  upper = {-half}, {T90 + T0}  fix = 'x' /
&constraint lower = {half}, {T90}  upper = {half}, {T90 + T0}  fix = 'x'  displacement = {length * 5e-3}, 0.0  name = 'grip' /
{cracks}&method time = 'static'  load_steps = {len(places)} /
&energy_release energy_balance = .true. /
&output file = 'out.h5' /
{extra}"""


def beam(angle, level=9, *, cells=2, extra="", loads=(-1000.0, 500.0, 500.0), first="0.0, 4.0e-3"):
    """A notched beam of acrylic glass, bent at three points."""
    tip, increment = 5e-3, cells * 1e-3 / 2**level
    width = tip * math.tan(math.radians(angle) / 2)
    most = increment * math.ceil(40e-6 / increment)
    points = "".join(f"&load kind = 'point'  lower = {x}, {y}  upper = {x}, {y}  force = 0.0, {f} /\n"
                     for f, x, y in zip(loads, (0.0, -38e-3, 38e-3), (18e-3, 0.0, 0.0)))
    return f"""&run plane = 'strain'  thickness = 12.7e-3  end_time = 1.0 /
&grid lower = -42e-3, -2e-3  cell = 1e-3  cells = 84, 22 /
&material name = 'pmma'  young = {YOUNG}  poisson = {POISSON}  density = 1180.0 /
&body material = 'pmma'  shape = 'polygon'  points = -40e-3, 0.0, {-width}, 0.0, 0.0, {tip}, {width}, 0.0, 40e-3, 0.0, 40e-3, 18e-3, -40e-3, 18e-3 /
{points}&crack kind = 'path'  points = {first}, 0.0, {tip + most} /
&nucleation toughness = {K_IC**2 * (1 - POISSON**2) / YOUNG}  strength = {STRENGTH}  increment = {increment} /
&method time = 'static'  load_steps = 1 /
&refine indicator = 'tip'  max_level = {level}  rings = 6 /
&output file = 'out.h5' /
{extra}"""
