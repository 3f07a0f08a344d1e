"""Scenes of large deformation for particles with domains: docs/explanation/domains.md, and what they should give.

    square       turns freely: its angular momentum and energy stay
    cantilever   is bent by 0.6 of its length; its equilibrium is that of the total frame on fine cells
    bar          hangs under its own weight, held at its sides: the exact stretch is that of a Piola stress
"""

import math

import numpy as np
from program_runs import run_scene

MATERIAL = "&material name = 'a'  law = 'neo_hookean'  young = 1e6  poisson = 0.3  density = 1000 /\n"

SQUARE = """\
&run end_time = {end!r}  plane = 'strain' /
&grid lower = 0, 0  cell = {cell!r}  cells = {cells} /
&body material = 'a'  lower = {lower}  upper = {upper}  points_per_cell = 2  spin = {spin!r}  velocity = {velocity} /
&method frame = 'updated'  shape_functions = '{functions}'  scheme = '{scheme}'  mass = '{mass}' {method} /
&energy_release energy_balance = .true. /
&output history_interval = {interval!r}  snapshot_interval = {end!r} /
"""


def square(turns, scheme="usl", mass="consistent", functions="cpdi", method="", cell=0.2, lower="0.63, 0.61", upper="1.63, 1.61",
           cells="12, 12", spin=2 * math.pi, velocity="0, 0"):
    """A square of 1 m somewhere in its cells. Where it turns once in a second its corners have a tenth of the speed of its waves, and the
    vibration with which it begins has a hundredth of its energy."""
    end = turns * 2 * math.pi / spin
    return MATERIAL + SQUARE.format(end=end, interval=end / 20, scheme=scheme, mass=mass, functions=functions, method=method,
                                    cell=cell, lower=lower, upper=upper, cells=cells, spin=spin, velocity=velocity)


CANTILEVER = """\
&run end_time = {end!r}  plane = 'strain' /
&grid lower = 0, 0  cell = {cell!r}  cells = {cells} /
&body material = 'a'  lower = 0, 6  upper = 8, 7  points_per_cell = 2 /
&constraint lower = 0, 0  upper = 0, 8  fix = 'xy' /
&load kind = 'traction'  lower = 8, 6  upper = 8, 7  force = 0, -3800  history = 'ramp'  rise_time = {rise!r} /
&method {method} /
&output snapshot_interval = {end!r} /
"""


def deflection(program, folder, cell, method, end=1.0, rise=1.0, more=""):
    """Of the end of a cantilever."""
    cells = f"{round(9 / cell)}, {round(8 / cell)}"
    _, fields = run_scene(program, folder, MATERIAL + more + CANTILEVER.format(cell=cell, cells=cells, end=end, rise=rise, method=method))
    u = fields["displacement"][:, 1]
    began = fields["place"][:, 0] - fields["displacement"][:, 0]
    columns = np.unique(np.round(began, 6))
    last, before = (np.mean(u[np.abs(began - x) < 1e-4]) for x in columns[:-3:-1])
    return last + (last - before) / 2


def stretch_of(stress):
    """Stretch of a bar of the material that is held at its sides, under a first Piola stress: mu (F - 1/F) + lambda ln F / F."""
    mu, lam = 1e6 / 2.6, 1e6 * 0.3 / (1.3 * 0.4)
    low, high = np.full_like(stress, 1e-3), np.full_like(stress, 50.0)
    for _ in range(80):
        middle = (low + high) / 2
        above = mu * (middle - 1 / middle) + lam * np.log(middle) / middle > stress
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return middle


BAR = """\
&run end_time = {end!r}  plane = 'strain' /
&grid lower = 0, 0  cell = {cell!r}  cells = {across}, {along} /
&body material = 'a'  lower = 0, {bottom}  upper = 1, {top}  points_per_cell = 2 /
&constraint lower = 0, 0  upper = 0, {top}  fix = 'x' /
&constraint lower = 1, 0  upper = 1, {top}  fix = 'x' /
&constraint lower = 0, {top}  upper = 1, {top}  fix = 'y' /
&load kind = 'gravity'  acceleration = 0, {gravity!r}  history = 'ramp'  rise_time = {rise!r} /
&damping rate = {rate!r} /
&method frame = 'updated'  shape_functions = 'cpdi'  scheme = 'usl'  mass = 'consistent' /
&output snapshot_interval = {end!r} /
"""


def elongation_error(program, folder, cell, gravity, height=10):
    """Of a bar of 4 m that hangs under its own weight, against the exact one, by the displacements of all particles, and their number."""
    wave = math.sqrt(1.35e6 / 1000)
    period = 4 * 4 / wave
    text = MATERIAL + BAR.format(end=12 * period, cell=cell, across=round(1 / cell), along=round(height / cell), top=height,
                                 bottom=height - 4, gravity=-gravity, rise=4 * period, rate=2 * math.pi / period)
    _, fields = run_scene(program, folder, text)
    u = fields["displacement"][:, 1]
    began = fields["place"][:, 1] - u
    ends = np.linspace(0, 4, 20001)                       # from the lower end
    stretch = stretch_of(1000 * gravity * ends)
    above = np.concatenate([[0], np.cumsum((stretch[1:] + stretch[:-1] - 2) / 2 * np.diff(ends))])
    exact = -(above[-1] - np.interp(began - height + 4, ends, above))
    return np.sqrt(np.mean((u - exact)**2)) / np.max(np.abs(exact)), len(u)


def energy(row):
    return row["kinetic_energy"] + row["strain_energy"]


def change(values):
    """Largest change of values from the first, over that."""
    return np.max(np.abs(values / values[0] - 1))
