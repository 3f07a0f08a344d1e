"""Bodies that meet in the program for solids: beside the plane program, theory, mirror images and exchanged axes (docs/explanation/solids.md)."""

import math
import subprocess

import h5py
import numpy as np
import pytest
from harness import differing
from paths import PROGRAM, SOLID_PROGRAM
from test_solid import difference

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")


def written(folder, text):
    folder.mkdir(exist_ok=True)
    (folder / "case.nml").write_text(text)
    return folder


def run(folder, text, *options, program=SOLID_PROGRAM):
    """The history, and the fields of the particles in the last snapshot, if there is one."""
    result = subprocess.run([program, "case.nml", "--quiet", "--force", *(word for option in options for word in ("--set", option))],
                            cwd=written(folder, text), capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    with h5py.File(folder / "case.h5") as file:
        history = {name: column[:] for name, column in file["history"].items()}
        particles = file.get("VTKHDF/particles")
        if particles is None:
            return history, {}
        n = particles["NumberOfPoints"][-1]
        return history, {name: values[-n:].squeeze() for name, values in particles["PointData"].items()} | {"place": particles["Points"][-n:]}


def vector(values):
    return ", ".join(repr(float(value)) for value in values)


SLAB = """
&run plane = 'strain'  end_time = 1.0{thickness} /
&grid lower = 0.0, 0.0{z0}  cell = 0.05  cells = 24, 20{n} /
&material name = 'm' law = 'neo_hookean' young = 1000.0 poisson = 0.3 density = 1000.0 /
&material name = 'n' law = 'neo_hookean' young = 3000.0 poisson = 0.2 density = 2000.0 /
&body material = 'm' lower = 0.12, 0.21{z0} upper = 0.44, 0.61{z1} velocity = 0.15, 0.05{z0} spin = {spin} /
&body material = 'n' lower = 0.5, 0.3{z0} upper = 0.8, 0.6{z1} velocity = -0.1, -0.05{z0} /
{rollers}
&contact bodies = 'friction' friction = 0.3 /
&method frame = 'updated'  courant = 0.03 /
&output file = 'case.h5'  history_interval = 0.05 /
"""


def test_blocks_between_rollers_meet_as_those_of_the_plane(tmp_path):
    """A block that turns runs into another one and rubs on it. The plane program finds normals by the golden section."""
    plane, _ = run(tmp_path / "plane", SLAB.format(thickness="  thickness = 0.05", z0="", z1="", n="", spin="0.2", rollers=""), program=PROGRAM)
    solid, _ = run(tmp_path / "solid", SLAB.format(thickness="", z0=", 0.0", z1=", 0.05", n=", 1", spin="0.0, 0.0, 0.2",
                                                   rollers="&constraint lower = 0.0, 0.0, 0.0  upper = 2.0, 2.0, 0.05  fix = 'z' /"))
    for name in ("kinetic_energy", "strain_energy", "contact_loss", "friction_loss"):
        assert plane[name].max() > 0
        assert difference(name, solid[name], plane[name], plane["kinetic_energy"][0]) < 1e-7
    assert difference("force", solid["contact_force_x"], plane["contact_force_x"], np.abs(plane["contact_force_x"]).max()) < 1e-6


def bars(axis, sign, cells, phase=0.0, v=1e-3):
    """Two bars of length and wave speed 1, two cells thick, run into each other along an axis."""
    h = 1 / cells
    x0, n = (5 + phase) * h, 2 * cells + 12
    x2, length = x0 + 1 + 0.3 * h, n * h
    turned = lambda x, y, z: [(x, y, z)[(d - axis) % 3] for d in range(3)]
    ends = [(x0, x0 + 1), (x2, x2 + 1)] if sign > 0 else [(length - x2 - 1, length - x2), (length - x0 - 1, length - x0)]
    bodies = "\n".join(f"&body material = 'm'  lower = {vector(turned(a, 2 * h, 2 * h))}  upper = {vector(turned(b, 4 * h, 4 * h))}  "
                       f"velocity = {vector(turned(speed, 0, 0))} /" for (a, b), speed in zip(ends, (v, -v)))
    meet = 0.3 * h / (2 * v)
    return meet, f"""
&run end_time = {meet + 2.6} /
&grid lower = 0.0, 0.0, 0.0  cell = {h!r}  cells = {', '.join(map(str, turned(n, 6, 6)))} /
&material name = 'm' young = 1.0 density = 1.0 poisson = 0.0 /
{bodies}
&contact bodies = 'frictionless' /
&method frame = 'updated' /
&output file = 'case.h5'  history_interval = {(meet + 2.6) / 400}  snapshot_interval = {meet + 2.6} /
"""


@pytest.mark.parametrize(("axis", "sign", "options"), [(0, 1, ()), pytest.param(2, -1, ("method.mass='weighted'",), marks=pytest.mark.verify),
                                                       pytest.param(1, -1, (), marks=pytest.mark.verify),
                                                       pytest.param(2, 1, ("method.mass='fmpm'",), marks=pytest.mark.verify),
                                                       pytest.param(0, 1, ("method.mass='consistent'",), marks=pytest.mark.verify)])
def test_two_bars_exchange_their_momentum(tmp_path, axis, sign, options):
    """They part when the waves are back, after 2 L/c, each with the velocity of the other, and lose what half a cell of each has. On these cells the plane
    program has 0.950 and 1.018 with lumped masses."""
    v, cells = 1e-3, 16 if options == () else 24
    meet, text = bars(axis, sign, cells, v=v)
    row, fields = run(tmp_path / "bars", text, *options)
    force = row[f"contact_force_{'xyz'[axis]}"]
    pressed = row["time"][np.abs(force) > 0]
    mean = [fields["velocity"][fields["body"] == body, axis].mean() for body in (1, 2)]
    energy = row["kinetic_energy"] + row["strain_energy"]
    print(pressed[0] - meet, (pressed[-1] - pressed[0]) / 2, (mean[1] - mean[0]) / (2 * v), energy[-1] / energy[0])
    assert abs(pressed[0] - meet) < 0.02 / cells / v
    assert (pressed[-1] - pressed[0]) / 2 == pytest.approx(1, abs=0.02)
    assert (mean[1] - mean[0]) / (2 * v) == pytest.approx(1, abs=1.5 / cells)
    assert 1 - 1 / cells < energy[-1] / energy[0] < 1
    for name in "xyz":
        assert np.abs(row[f"momentum_{name}"]).max() < 1e-12 * v * (2 / cells)**2


def test_bars_along_another_axis_from_the_other_side_do_the_same(tmp_path):
    one, other = (run(tmp_path / name, bars(axis, sign, 8)[1])[0] for name, axis, sign in (("one", 0, 1), ("other", 2, -1)))
    for name in ("kinetic_energy", "strain_energy", "contact_loss"):
        assert difference(name, other[name], one[name], one["kinetic_energy"][0]) < 1e-10
    assert difference("force", other["contact_force_z"], one["contact_force_x"], np.abs(one["contact_force_x"]).max()) < 1e-8


MEETING = """
&run end_time = 0.4 /
&grid lower = 0.0, 0.0, 0.0  cell = 0.1  cells = 11, 9, 8 /
&material name = 'm' law = 'neo_hookean' young = 1000.0 poisson = 0.3 density = 1000.0 /
&material name = 'n' law = 'neo_hookean' young = 3000.0 poisson = 0.2 density = 2000.0 /
&body material = 'm' lower = 0.12, 0.21, 0.22 upper = 0.44, 0.61, 0.53 velocity = 0.3, 0.1, 0.05 spin = 0.1, 0.2, 0.3 /
&body material = 'n' shape = 'sphere' center = 0.68, 0.47, 0.43 radius = 0.2 velocity = -0.3, -0.05, -0.1 /
&body material = 'm' lower = 0.4, 0.02, 0.2 upper = 0.8, 0.18, 0.4 velocity = 0.0, 0.3, 0.0 /
&contact bodies = 'friction' friction = 0.3 /
&method frame = 'updated' /
&energy_release energy_balance = .true. /
&output file = 'case.h5'  history_interval = 0.05  snapshot_interval = 0.25 /
"""
BOOKED = ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "contact_loss", "friction_loss")


@pytest.mark.parametrize("options", [(), ("method.mass='consistent'",), ("contact.bodies='stick'", "contact.friction=0"),
                                     pytest.param(("method.scheme='usf'",), marks=pytest.mark.verify),
                                     pytest.param(("method.mass='weighted'", "damping.rate=0.3"), marks=pytest.mark.verify),
                                     pytest.param(("method.mass='fmpm'",), marks=pytest.mark.verify),
                                     ("refine.indicator='zz'", "refine.max_level=1", "refine.tolerance=0.3", "refine.max_particles=8000")], ids=str)
def test_momentum_is_kept_and_energy_is_booked(tmp_path, options):
    """Of a block that turns, a ball and a bar, with finer cells too."""
    row, _ = run(tmp_path / "case", MEETING, *options)
    start = row["kinetic_energy"][0]
    if "damping.rate=0.3" not in options:
        for axis in "xyz":
            assert difference("momentum", row[f"momentum_{axis}"], row[f"momentum_{axis}"][0], start / 0.3) < 1e-12
    assert row["contact_loss"][-1] > 0
    assert (row["friction_loss"][-1] > 0) == ("contact.bodies='stick'" not in options)
    assert difference("energy", sum(row[name] for name in BOOKED if name in row), start, start) < 1e-6


def test_a_run_that_is_stopped_or_has_other_threads_has_the_same_bytes(tmp_path):
    folder = written(tmp_path / "whole", MEETING)
    for words, code in ((["case.nml"], 0), (["case.nml", "--output", "threads", "--threads", "3"], 0), (["case.nml", "--output", "parts", "--steps", "12"], 5),
                        (["--resume", "parts/case.h5.checkpoint"], 0)):
        result = subprocess.run([SOLID_PROGRAM, "--quiet", *words], cwd=folder, capture_output=True, text=True)
        assert result.returncode == code, result.stderr
    assert differing(folder / "case.h5", folder / "threads/case.h5") == []
    assert differing(folder / "case.h5", folder / "parts/case.h5") == []


BLOCK = """
&run end_time = 0.1 /
&grid lower = 0.0, 0.0, -0.05  cell = 0.05  cells = 12, 10, 7 /
&material name = 'm' young = 1e6 poisson = 0.2 density = 1000.0 /
&body material = 'm' lower = 0.0, 0.0, 0.0 upper = 0.6, 0.5, 0.1 /
&body material = 'm' lower = 0.1125, 0.1, 0.1 upper = 0.3125, 0.25, 0.2 /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.6, 0.5, 0.05  fix = 'xyz' /
&load kind = 'gravity'  acceleration = {g}  history = 'smooth_ramp'  rise_time = 0.04 /
&damping rate = 0.0 /
&contact {contact} /
&method frame = 'updated' /
&output file = 'case.h5'  history_interval = 5e-4  snapshot_interval = 0.05 /
"""


@pytest.mark.parametrize(("contact", "friction"), [("bodies = 'friction'  friction = 0.3", 0.3), ("bodies = 'frictionless'", 0.0),
                                                   pytest.param("bodies = 'friction'  friction = 1.0", 1.0, marks=pytest.mark.verify)])
def test_a_block_slides_down_a_slope_across_the_grid(tmp_path, contact, friction):
    """By g (sin a - mu cos a), or not at all: a slope of 30 degrees, down at 35 degrees to the lines of the grid."""
    a, way, g = math.radians(30), math.radians(35), 10.0
    down = np.array([math.cos(way), math.sin(way), 0])
    row, fields = run(tmp_path / "block", BLOCK.format(g=vector(g * math.sin(a) * down + [0, 0, -g * math.cos(a)]), contact=contact))
    late = row["time"] > 0.05
    force = np.array([row[f"contact_force_{axis}"][late].mean() for axis in "xyz"])
    found = -(force @ down) / force[2]
    velocity = fields["velocity"][fields["body"] == 2].mean(axis=0)
    print(force, found, velocity)
    assert found == pytest.approx(min(friction, math.tan(a)), abs=1e-3 if friction < 1 else 0.02)
    assert force[2] == pytest.approx(1000 * 0.2 * 0.15 * 0.1 * g * math.cos(a), rel=0.05)
    if friction < 1:
        assert abs(np.cross(down, velocity)[2]) < 1e-2 * (velocity @ down)
        assert velocity @ down == pytest.approx((0.1 - 0.02) * g * (math.sin(a) - friction * math.cos(a)), rel=0.02)
    else:
        assert np.linalg.norm(velocity) < 0.02 * 0.08 * g * math.sin(a)


HERTZ = """
&run end_time = 0.9 /
&grid lower = -2.0, -2.0, -1.0  cell = 0.16666666666666667  cells = 24, 24, 19 /
&material name = 'm' law = 'neo_hookean' young = 1e6 poisson = 0.3 density = 1000.0 /
&body material = 'm' lower = -1.8333333333333333, -1.8333333333333333, -0.8333333333333333 upper = 1.8333333333333333, 1.8333333333333333, 0.0 /
&body material = 'm' shape = 'sphere' center = 0.0, 0.0, 1.0 radius = 1.0 /
&constraint lower = -9.0, -9.0, -9.0 upper = 9.0, 9.0, -0.8333333333333333 fix = 'xyz' /
&load kind = 'body' force = 0.0, 0.0, -{force} lower = -9.0, -9.0, 1e-6 upper = 9.0, 9.0, 9.0 history = 'smooth_ramp' rise_time = 0.3 /
&damping rate = 16.0 /
&contact bodies = 'frictionless' /
&method frame = 'updated' /
&refine indicator = 'zz' tolerance = 0.99 max_level = 1 region_lower = -0.5, -0.5, -0.5 region_upper = 0.5, 0.5, 0.5 max_particles = 40000 /
&output file = 'case.h5'  history_interval = 0.009 snapshot_interval = 0.9 /
"""


def below(r, z, a):
    """Stress zz below a Hertzian pressure 1 on a circle (Huber 1904)."""
    q = r**2 + z**2 - a**2
    u = (q + np.sqrt(q**2 + 4 * a**2 * z**2)) / 2
    return -(z / np.sqrt(u))**3 * a**2 * u / (u**2 + a**2 * z**2)


@pytest.mark.verify
def test_a_ball_on_a_block_has_the_contact_of_hertz(tmp_path):
    """As far as three cells to the contact radius resolve it; docs/explanation/solids.md has six."""
    elastic, a = 1e6 / (2 * (1 - 0.3**2)), 0.25
    row, fields = run(tmp_path / "ball", HERTZ.format(force=4 * elastic * a**3 / 3))
    start = fields["place"] - fields["displacement"]
    r, z = np.hypot(start[:, 0], start[:, 1]), -start[:, 2]
    near = (fields["body"] == 1) & (r < 2 * a) & (z < 2 * a)
    fits = []
    for radius in np.linspace(0.7 * a, 1.3 * a, 121):
        unit = below(r[near], z[near], radius)
        pressure = unit @ fields["stress_zz"][near] / (unit @ unit)
        fits.append((np.sum((fields["stress_zz"][near] - pressure * unit)**2), radius / a, pressure / (2 * elastic * a / np.pi)))
    force = row["contact_force_z"][-8:].mean() / (4 * elastic * a**3 / 3)
    print(force, min(fits))
    assert force == pytest.approx(1, abs=0.03)
    assert min(fits)[1] == pytest.approx(1, abs=0.1) and min(fits)[2] == pytest.approx(1, abs=0.15)
    assert min(fits)[1]**2 * min(fits)[2] == pytest.approx(1, abs=0.05)      # which is its force


# Half of a block with a penny crack that is sheared along x and pressed together, half of a side of 2.5 radii
RUBBING = """
&run end_time = {end} /
&grid lower = -2.5, 0.0, {low}  cell = {h!r}  cells = {n2}, {n}, {m} /
&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 /
&body material = 'a'  lower = -2.5, 0.0, -2.5  upper = 2.5, 2.5, 2.5 /
&constraint lower = -2.5, 0.0, -2.5  upper = 2.5, 0.0, 2.5  fix = 'y' /
&load kind = 'traction'  lower = -2.5, 0.0, 2.5  upper = 2.5, 2.5, 2.5  force = 12.5, 0.0, {down} {rise} /
&load kind = 'traction'  lower = -2.5, 0.0, -2.5  upper = 2.5, 2.5, -2.5  force = -12.5, 0.0, {up} {rise} /
&load kind = 'traction'  lower = 2.5, 0.0, -2.5  upper = 2.5, 2.5, 2.5  force = 0.0, 0.0, 12.5 {rise} /
&load kind = 'traction'  lower = -2.5, 0.0, -2.5  upper = -2.5, 2.5, 2.5  force = 0.0, 0.0, -12.5 {rise} /
&crack kind = 'plane'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = 1.0  {contact} /
{more}
&method {method} /
&output file = 'case.h5'{interval} /
"""


def rubbing(folder, pressure, friction, n, more="", method="time = 'static'  frame = 'total'", end=1.0, rise=""):
    contact = f"contact = 'friction'  friction = {friction}" if friction else "contact = 'frictionless'"
    text = RUBBING.format(h=2.5 / n, n=n, n2=2 * n, m=2 * n + 2, low=-2.5 - 2.5 / n, up=12.5 * pressure, down=-12.5 * pressure, contact=contact, more=more,
                          method=method, end=end, rise=rise, interval=f"  history_interval = {end / 10}" if rise else "")
    row, _ = run(folder, text)
    with h5py.File(folder / "case.h5") as file:
        return row, {name: values[-1] for name, values in file["front"].items()} if "front" in file else {}


MEASURED = "&energy_release estimators = 'domain_integral'  energy_balance = .true. /\n"


@pytest.mark.verify
def test_faces_of_a_sheared_penny_rub_on_each_other(tmp_path):
    """All of the faces slide, against the friction 0.3 p: what they do is what 0.7 of the shear does to faces that do not press on each other. Friction takes
    its part of what they slide by, the integral of G over all radii. Where friction holds them there is no crack."""
    more = MEASURED + "&refine indicator = 'tip'  max_level = 1  rings = 2 /"
    alone, of_alone = rubbing(tmp_path / "alone", 0, 0, 8, more)
    row, found = rubbing(tmp_path / "pressed", 1, 0.3, 8, more)
    largest = 0.7 * np.max(of_alone["K_II"])
    for mode in ("K_II", "K_III"):
        assert difference(mode, found[mode], 0.7 * of_alone[mode], largest) < 0.02
    assert difference("G", row["G_mean"][-1], 0.49 * alone["G_mean"][-1]) < 0.03
    assert difference("friction", row["friction_loss"][-1], 0.7 * 0.3 * np.pi / 3 * alone["G_mean"][-1]) < 0.03
    stuck, of_stuck = rubbing(tmp_path / "stuck", 1, 1.2, 8, more)
    print("stuck", stuck["G_mean"][-1] / alone["G_mean"][-1], np.max(np.abs(of_stuck["K_II"])) / np.max(of_alone["K_II"]))
    assert stuck["G_mean"][-1] < 2e-3 * alone["G_mean"][-1] and stuck["friction_loss"][-1] == 0
    assert np.max(np.abs(of_stuck["K_II"])) < 0.03 * np.max(of_alone["K_II"])


@pytest.mark.parametrize("more", ["", "&refine indicator = 'tip'  max_level = 1  rings = 1 /"],
                         ids=["", "finer"])
def test_friction_takes_its_part_of_the_work(tmp_path, more):
    """With the energy C of a crack under the shear 1 it takes 0.3 times 0.7 C, as all that slides is 0.7 of that. C is by two other runs: without friction,
    and with so much that nothing slides, under the pressure 1 whose energy is known."""
    work = {name: rubbing(tmp_path / name, *keys, 4, more)[0] for name, keys in (("alone", (0, 0)), ("pressed", (1, 0.3)), ("stuck", (1, 1.2)))}
    of_crack = work["alone"]["external_work"][-1] - (work["stuck"]["external_work"][-1] - 2.5 * 5 * 5 / 2)
    assert difference("friction", work["pressed"]["friction_loss"][-1], 0.21 * of_crack) < 0.005
    assert work["stuck"]["friction_loss"][-1] == 0


@pytest.mark.parametrize("method", ["time = 'explicit'  frame = 'total'", pytest.param("time = 'implicit'  time_step = 0.5", marks=pytest.mark.verify),
                                    pytest.param("scheme = 'usl'  frame = 'total'", marks=pytest.mark.verify),
                                    pytest.param("mass = 'consistent'  frame = 'total'", marks=pytest.mark.verify)])
def test_energy_of_faces_that_rub_is_booked(tmp_path, method):
    row, _ = rubbing(tmp_path / "case", 1, 0.3, 4, "&energy_release energy_balance = .true. /", method, 10.0, "history = 'smooth_ramp'  rise_time = 5.0")
    inside = sum(row[name] for name in ("kinetic_energy", "strain_energy", "numerical_loss", "friction_loss"))
    assert row["friction_loss"][-1] > 0.1
    assert difference("energy", inside, row["external_work"], row["external_work"].max()) < 1e-12


def test_a_run_with_faces_that_rub_goes_on_from_a_checkpoint(tmp_path):
    rubbing(tmp_path / "whole", 1, 0.3, 4, MEASURED.replace("'domain_integral'", ""), "time = 'explicit'  frame = 'total'", 6.0, "history = 'smooth_ramp'  rise_time = 5.0")
    for words, code in ((["case.nml", "--output", "threads", "--threads", "3"], 0), (["case.nml", "--output", "parts", "--steps", "7"], 5),
                        (["--resume", "parts/case.h5.checkpoint"], 0)):
        result = subprocess.run([SOLID_PROGRAM, "--quiet", *words], cwd=tmp_path / "whole", capture_output=True, text=True)
        assert result.returncode == code, result.stderr
    assert differing(tmp_path / "whole/case.h5", tmp_path / "whole/threads/case.h5") == []
    assert differing(tmp_path / "whole/case.h5", tmp_path / "whole/parts/case.h5") == []
