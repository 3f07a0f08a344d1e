"""Solids: orthotropic material, pressure and absorbing sides, spin and probes."""

import itertools
import subprocess

import numpy as np
import pytest
from paths import PROGRAM, SOLID_PROGRAM
from test_solid import IN_PLANE, IN_SPACE, difference, run, vector

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

YOUNG, NUS, SHEARS = (140.0e9, 10.0e9, 12.0e9), {(0, 1): 0.3, (0, 2): 0.28, (1, 2): 0.45}, {(0, 1): 5.0e9, (0, 2): 4.0e9, (1, 2): 3.0e9}


def compliance():
    """Of the material, by pairs of directions."""
    s = np.zeros((3, 3, 3, 3))
    for a in range(3):
        s[a, a, a, a] = 1 / YOUNG[a]
    for (a, b), nu in NUS.items():
        s[a, a, b, b] = s[b, b, a, a] = -nu / YOUNG[a]
    for (a, b), g in SHEARS.items():
        for i, j in itertools.product(((a, b), (b, a)), repeat=2):
            s[(*i, *j)] = 1 / (4 * g)
    return s


def exchanged(axes):
    """Keys of the material whose axes 1, 2, 3 are those of this one in another order."""
    keys = [f"young_{k + 1} = {YOUNG[a]}" for k, a in enumerate(axes)]
    for k, m in ((0, 1), (0, 2), (1, 2)):
        a, b = axes[k], axes[m]
        nu = NUS[a, b] if a < b else NUS[b, a] * YOUNG[a] / YOUNG[b]
        keys += [f"poisson_{k + 1}{m + 1} = {nu}", f"shear_{k + 1}{m + 1} = {SHEARS[min(a, b), max(a, b)]}"]
    return "  ".join(keys)


def rotation(angles):
    """Columns are the axes of the material."""
    axes = np.eye(3)
    for a, angle in enumerate(np.radians(angles)):
        turn = np.eye(3)
        i, j = (a + 1) % 3, (a + 2) % 3
        turn[i, i] = turn[j, j] = np.cos(angle)
        turn[j, i], turn[i, j] = np.sin(angle), -np.sin(angle)
        axes = turn @ axes
    return axes


BLOCK = """
&run end_time = {end} /
&grid lower = -0.05, -0.05, -0.05  cell = 0.05  cells = 6, 5, 4 /
&material name = 'a'  law = 'orthotropic'  {material}  density = 1600.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.2, 0.1, 0.1{body} /
{rest}
&method {method} /
&output file = 'case.h5'  snapshot_interval = {end}  history_interval = {end} /
"""
HELD = """
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.0, 0.0  fix = 'xyz' /
&constraint lower = 0.2, 0.0, 0.0  upper = 0.2, 0.0, 0.0  fix = 'yz' /
&constraint lower = 0.0, 0.1, 0.0  upper = 0.0, 0.1, 0.0  fix = 'z' /
&load kind = 'pressure'  lower = 0.0, 0.0, 0.0  upper = 0.0, 0.1, 0.1  pressure = 1.0e6 /
&load kind = 'pressure'  lower = 0.2, 0.0, 0.0  upper = 0.2, 0.1, 0.1  pressure = 1.0e6 /
&load kind = 'pressure'  lower = 0.0, 0.0, 0.0  upper = 0.2, 0.0, 0.1  pressure = 2.0e6 /
&load kind = 'pressure'  lower = 0.0, 0.1, 0.0  upper = 0.2, 0.1, 0.1  pressure = 2.0e6 /
&load kind = 'traction'  lower = 0.0, 0.0, 0.1  upper = 0.2, 0.1, 0.1  force = 1.0e4, 0.0, 6.0e4 /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = 0.2, 0.1, 0.0  force = -1.0e4, 0.0, -6.0e4 /
&load kind = 'traction'  lower = 0.2, 0.0, 0.0  upper = 0.2, 0.1, 0.1  force = 0.0, 0.0, 0.5e4 /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = 0.0, 0.1, 0.1  force = 0.0, 0.0, -0.5e4 /
&probe name = 'p'  quantity = 'strain', 'stress', 'displacement'  at = 0.07, 0.06, 0.02 /
&probe name = 'l'  quantity = 'strain'  at = 0.01, 0.02, 0.03, 0.17, 0.09, 0.08 /
"""
AT_REST = "time = 'static'  frame = 'total'"
STRESS = np.array([[-1.0e6, 0, 0.5e6], [0, -2.0e6, 0], [0.5e6, 0, 3.0e6]])
REFINED = """&refine indicator = 'gradient'  field = 'energy_density'  r_crit = 1e-17  max_level = 1
  region_lower = 0.05, 0.0, 0.0  region_upper = 0.1, 0.05, 0.05 /"""


@pytest.mark.parametrize(("angles", "rest"), [((0, 0, 0), ""), ((20, -35, 70), ""), ((110, 15, -50), REFINED)])
def test_an_orthotropic_block_strains_by_its_compliance(tmp_path, angles, rest):
    """Uniform stress by pressure and tractions on all sides, axes in any direction: what probes record of stress and strain, and the energy."""
    material = f"{exchanged((0, 1, 2))}  angle = {vector(angles)}"
    history = run(tmp_path / "case", SOLID_PROGRAM, BLOCK.format(end=1.0, material=material, body="", rest=HELD + rest, method=AT_REST))["history"]
    axes = rotation(angles)
    turned = np.einsum("ia,jb,kc,ld,abcd->ijkl", axes, axes, axes, axes, compliance())
    strain = np.einsum("ijkl,kl", turned, STRESS)
    for a, b in itertools.combinations_with_replacement(range(3), 2):
        name = "xyz"[a] + "xyz"[b]
        assert difference(f"stress {name}", history[f"stress_p_{name}"][-1], STRESS[a, b], 3e6) < 1e-9
        assert difference(f"strain {name}", history[f"strain_p_{name}"][-1], strain[a, b], np.max(np.abs(strain))) < 1e-9
    line = np.array([0.16, 0.07, 0.05])
    assert difference("mean along a line", history["strain_l"][-1], line @ strain @ line / (line @ line)) < 1e-9
    assert difference("energy", history["strain_energy"][-1], 0.5 * np.sum(STRESS * strain) * 0.2 * 0.1 * 0.1) < 1e-9


@pytest.mark.parametrize(("angles", "axes"), [((90, 0, 0), (0, 2, 1)), ((0, 90, 0), (2, 1, 0)), ((0, 0, 90), (1, 0, 2)), ((90, 0, 90), (2, 0, 1))])
def test_a_quarter_turn_exchanges_constants(tmp_path, angles, axes):
    """In motion in the updated frame, too: a bent bar with turned axes, and with their constants exchanged."""
    rest = """&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.1, 0.1  fix = 'xyz' /
&load kind = 'traction'  lower = 0.2, 0.0, 0.0  upper = 0.2, 0.1, 0.1  force = 1.0e5, 2.0e5, 3.0e5 /"""
    files = [run(tmp_path / name, SOLID_PROGRAM, BLOCK.format(end=3e-5, material=material, body="", rest=rest, method="frame = 'updated'  courant = 0.2  wave_speed = 'dilatational'"))
             for name, material in (("turned", f"{exchanged((0, 1, 2))}  angle = {vector(angles)}"), ("exchanged", exchanged(axes)))]
    for name in ("strain_energy", "kinetic_energy", "external_work"):
        turned, asked = (file[f"history/{name}"][-1] for file in files)
        assert asked > 0 and difference(name, turned, asked) < 1e-11


WAVE = """
&run end_time = {end} /
&grid lower = 0.0, 0.0, 0.0  cell = 0.01  cells = {cells} /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = {upper} /
{rollers}
&load kind = 'absorbing'  lower = {far}  upper = {upper} /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = {near}  force = {force}  history = 'table'  {pulse} /
&method frame = 'total'  courant = 0.5 /
&output file = 'case.h5'  history_interval = {interval} /
"""


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("across", [0, 1, 2])
def test_a_side_absorbs_plane_waves(tmp_path, axis, across):
    """Waves along a bar between rollers, dilatational and shear ones in both directions, leave it at its end."""
    def along(value, other):
        values = [other] * 3
        values[axis] = value
        return vector(values)

    length, width = 0.4, 0.01
    moved = (axis + across) % 3
    count = [1, 1, 1]
    count[axis] = 40
    force = [0.0, 0.0, 0.0]
    force[moved] = 1.0e3
    held = "".join(sorted("xyz"[d] for d in range(3) if d != moved))
    end = 3.0e-4
    times = np.linspace(0, 6.0e-5, 13)
    text = WAVE.format(end=end, pulse=f"times = {vector(times)}  factors = {vector(np.sin(np.pi * times / times[-1]) ** 2)}", cells=", ".join(map(str, count)), upper=along(length, width), far=along(length, 0.0), near=along(0.0, width),
                       force=vector(force), interval=end / 40, rollers=f"&constraint lower = 0.0, 0.0, 0.0  upper = {along(length, width)}  fix = '{held}' /")
    history = run(tmp_path / "case", SOLID_PROGRAM, text)["history"]
    energy = history["strain_energy"][:] + history["kinetic_energy"][:]
    print(f"{'P' if across == 0 else 'S'} wave: energy left {energy[-1] / np.max(energy):.1e}")
    assert np.max(energy) > 0 and energy[-1] < 1e-3 * np.max(energy)


def test_an_absorbing_slab_between_rollers_is_plane_strain(tmp_path):
    """Waves in all directions of the plane, which meet the sides at any angle: energies of the plane program."""
    text = """
&run end_time = 8e-5  plane = 'strain'{thickness} /
&grid lower = -0.05, -0.05{z0}  cell = 0.05  cells = 8, 6{n} /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0{z0}  upper = 0.3, 0.2{z1} /
{rollers}
&load kind = 'absorbing'  lower = 0.3, 0.0{z0}  upper = 0.3, 0.2{z1} /
&load kind = 'absorbing'  lower = 0.0, 0.0{z0}  upper = 0.3, 0.0{z1} /
&load kind = 'pressure'  lower = 0.1, 0.2{z0}  upper = 0.2, 0.2{z1}  pressure = 1.0e6 /
&load kind = 'traction'  lower = 0.0, 0.1{z0}  upper = 0.0, 0.2{z1}  force = 1.0e4, 2.0e4{z0} /
&method frame = 'total'  courant = 0.2 /
&output file = 'case.h5'  history_interval = 8e-6 /
"""
    plane = run(tmp_path / "plane", PROGRAM, text.format(**IN_PLANE))["history"]
    rollers = "&constraint lower = 0.0, 0.0, 0.0  upper = 0.3, 0.2, 0.05  fix = 'z' /"
    solid = run(tmp_path / "solid", SOLID_PROGRAM, text.format(**{**IN_SPACE, "rollers": rollers}))["history"]
    scale = np.max(plane["external_work"])
    for column in ("strain_energy", "kinetic_energy", "external_work"):
        assert difference(column, solid[column][:], plane[column][:], scale) < 1e-11


def test_a_body_spins_around_any_axis(tmp_path):
    """Free rotation of a cube: its kinetic energy is I w**2/2, stays, and its momentum is 0."""
    spin = np.array([300.0, -200.0, 500.0])
    text = BLOCK.format(end=2e-5, material=exchanged((0, 1, 2)).replace("140000000000.0", "14e9"), rest="", method="frame = 'updated'  courant = 0.1",
                        body=f"  spin = {vector(spin)}").replace("upper = 0.2, 0.1, 0.1", "upper = 0.1, 0.1, 0.1").replace("snapshot_interval = 2e-05", "")
    file = run(tmp_path / "case", SOLID_PROGRAM, text)
    mass, edge = 1600.0e-3, 0.1
    asked = 0.5 * mass * edge**2 / 6 * np.sum(spin**2) * (1 - (0.025 / edge) ** 2)  # of points in the middle of particles
    history = {name: values[:] for name, values in file["history"].items()}
    assert difference("kinetic energy", history["kinetic_energy"][0], asked) < 1e-9
    total = history["kinetic_energy"] + history["strain_energy"]
    assert difference("energy at the end", total[-1], asked) < 0.02
    for k, d in enumerate("xyz"):
        assert np.max(np.abs(history[f"momentum_{d}"])) < 1e-9 * mass * edge * np.linalg.norm(spin)
        assert difference(f"angular momentum {d}", history[f"angular_momentum_{d}"], 2 * asked * spin[k] / np.sum(spin**2)) < 1e-3


SLAB = """
&run end_time = {end}  plane = 'strain'{thickness} /
&grid lower = -0.05, -0.05{z0}  cell = 0.05  cells = 10, 4{n} /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0{z0}  upper = 0.4, 0.1{z1} /
{rollers}
{rest}
&method {method} /
&output file = 'case.h5'  history_interval = {end} /
"""
ON_SUPPORTS = """&constraint lower = 0.0, 0.0{z0}  upper = 0.0, 0.0{z1}  fix = 'xy' /
&constraint lower = 0.1, 0.0{z0}  upper = 0.4, 0.0{z1}  fix = 'y'  unilateral = .true. /
&load kind = 'traction'  lower = 0.0, 0.1{z0}  upper = 0.2, 0.1{z1}  force = 0.0, -1.0e5{z0} /
&load kind = 'traction'  lower = 0.3, 0.1{z0}  upper = 0.4, 0.1{z1}  force = 0.0, 2.0e4{z0} /"""
BY_PINS = """&constraint lower = 0.0, 0.0{z0}  upper = 0.0, 0.1{z1}  fix = 'xy'  turns = .true. /
&constraint lower = 0.4, 0.0{z0}  upper = 0.4, 0.1{z1}  fix = 'xy'  turns = .true.  displacement = 1e-6, 0.0{z0} /
&load kind = 'traction'  lower = 0.0, 0.1{z0}  upper = 0.4, 0.1{z1}  force = 0.0, -1.0e5{z0}  history = 'smooth_ramp'  rise_time = 1e-4 /"""


@pytest.mark.parametrize(("rest", "method"), [
    (ON_SUPPORTS, "time = 'static'"), (ON_SUPPORTS, "time = 'implicit'  time_step = 1e-5"), (BY_PINS, "time = 'static'"),
    (BY_PINS.replace("displacement", "history = 'smooth_ramp'  rise_time = 1e-4  displacement"), "time = 'explicit'  frame = 'total'  courant = 0.2")])
def test_supports_and_pins_of_a_slab_are_those_of_the_plane(tmp_path, rest, method):
    """A beam lifts off supports that only push, and turns with pins at its ends: energies of the plane program."""
    end = 1e-4
    plane = run(tmp_path / "plane", PROGRAM, SLAB.format(end=end, method=method, rest=rest.format(**IN_PLANE), **IN_PLANE))["history"]
    rollers = "&constraint lower = 0.0, 0.0, 0.0  upper = 0.4, 0.1, 0.05  fix = 'z' /"
    solid = run(tmp_path / "solid", SOLID_PROGRAM, SLAB.format(end=end, method=method, rest=rest.format(**IN_SPACE),
                                                              **{**IN_SPACE, "rollers": rollers}))["history"]
    for column in ("strain_energy",) if "static" in method else ("strain_energy", "kinetic_energy"):
        assert plane[column][-1] > 0 and difference(column, solid[column][-1], plane[column][-1]) < 1e-9


def test_a_pin_of_a_solid_has_an_axis(tmp_path):
    (tmp_path / "case.nml").write_text(BLOCK.format(end=1.0, material=exchanged((0, 1, 2)), body="", method=AT_REST, rest=HELD.replace(
        "fix = 'xyz' /", "fix = 'xyz'  turns = .true. /")))
    result = subprocess.run([SOLID_PROGRAM, "case.nml", "--quiet"], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 2 and "turns around the third direction" in result.stderr, result.stderr


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -0.2, 1.0)])
def test_a_block_that_nothing_holds(tmp_path, direction):
    """Pressure on all sides needs no constraint, nor does it with one held node; a force on one side alone has no equilibrium."""
    sides = "\n".join(f"&load kind = 'pressure'  lower = {vector(upper[d] * side if d == k else 0 for d in range(3))}  upper = "
                      f"{vector(upper[d] * side if d == k else upper[d] for d in range(3))}  pressure = 3.0e6 /"
                      for upper in [(0.2, 0.1, 0.1)] for k in range(3) for side in (0, 1))
    free = BLOCK.replace("law = 'orthotropic'  {material}", "young = 200.0e9  poisson = 0.3")
    for name, held in (("free", ""), ("held", "\n&constraint lower = 0.2, 0.1, 0.0  upper = 0.2, 0.1, 0.0  fix = 'xz' /")):
        history = run(tmp_path / name, SOLID_PROGRAM, free.format(end=1.0, body="", rest=sides + held, method=AT_REST))["history"]
        assert difference(f"{name}: energy", history["strain_energy"][-1], 0.5 * 9.0e12 * 3 * (1 - 0.6) / 200.0e9 * 0.002) < 1e-9
    (tmp_path / "pushed.nml").write_text(free.format(end=1.0, body="", method=AT_REST, rest="&load kind = 'traction'  lower = 0.2, 0.0, 0.0  "
                                                     f"upper = 0.2, 0.1, 0.1  force = {vector(1e3 * x for x in direction)} /"))
    result = subprocess.run([SOLID_PROGRAM, "pushed.nml", "--quiet"], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 3 and "has no equilibrium" in result.stderr, result.stderr


def test_traction_that_a_crack_parts(tmp_path):
    """A traction across the mouth of an edge crack is that of its two parts, wherever its ends lie between particles: K_I came 17 % low."""
    sides = {"one": [(-0.9e-3, 2.2e-3)], "two": [(-0.9e-3, 0.0), (0.0, 2.2e-3)]}
    found = {}
    for name, parts in sides.items():
        loads = "\n".join(f"&load kind = 'traction' lower = 0, {a}, 0 upper = 0, {b}, 4e-3 force = {-1e4 * (b - a)}, {2e4 * (b - a)}, 0 /" for a, b in parts)
        history = run(tmp_path / name, SOLID_PROGRAM, f"""
&run end_time = 1 /
&grid lower = -1e-3, -8e-3, -1e-3 cell = 1e-3 cells = 20, 16, 6 /
&material name = 's' young = 200e9 poisson = 0.3 density = 7800 /
&body material = 's' lower = 0, -6e-3, 0 upper = 18e-3, 6e-3, 4e-3 /
&constraint lower = 18e-3, -6e-3, 0 upper = 18e-3, 6e-3, 4e-3 fix = 'xyz' /
{loads}
&crack kind = 'plane' normal = 'y' front = 'straight' tip = 8e-3, 0, 2e-3 direction = 1, 0, 0 /
&method time = 'static' /
&energy_release estimators = 'domain_integral' /
&output file = 'case.h5' /
""")["history"]
        found[name] = [history[column][-1] for column in ("K_I", "K_II", "strain_energy")]
    assert difference("K_I, K_II, energy", found["one"], found["two"]) < 1e-9
