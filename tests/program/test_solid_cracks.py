"""Cracks in planes of the program for solids: a disc and an ellipse in blocks beside finite elements of degree 4, whole bodies beside parts of them."""

import re
import subprocess

import h5py
import numpy as np
import pytest
from paths import INPUT, REFERENCE, SOLID_PROGRAM
from test_solid import difference

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

NU = 0.3
TIP = "&refine indicator = 'tip'  max_level = 1  rings = 2 /"
STATIC = "time = 'static'  frame = 'total'"


def vector(values):
    return ", ".join(repr(float(value)) for value in values)


def part(sides, cells, crack, axes=(0, 1, 2), mirrored=(), method=STATIC, refine="", end=1.0, output=""):
    """An eighth of a block of half sides `sides` under tension 1 along its last axis, `cells` to a unit, with a crack in the plane of its middle; its axes
    exchanged, some of them mirrored."""
    at = lambda values: [(-1 if axes[d] in mirrored else 1) * values[axes[d]] for d in range(3)]
    corner, n = at(sides), [round(sides[d] * cells) + (d == 2) for d in axes]
    box = lambda a, b: f"lower = {vector(np.minimum(at(a), at(b)) + 0.0)}  upper = {vector(np.maximum(at(a), at(b)) + 0.0)}"
    flat = lambda d, x: box([x if k == d else 0.0 for k in range(3)], [x if k == d else sides[k] for k in range(3)])
    planes = "\n".join(f"&constraint {flat(d, 0.0)}  fix = '{'xyz'[axes.index(d)]}' /" for d in range(3))
    center = crack.pop("center", (0.0, 0.0, 0.0))
    keys = "  ".join(f"{key} = {value if isinstance(value, str) else vector(value)}" for key, value in crack.items())
    return f"""
&run end_time = {end} /
&grid lower = {vector(min(0.0, c - np.sign(c) * 0.0) - (1 / cells if c < 0 and axes[d] == 2 else 0.0) for d, c in enumerate(corner))}
  cell = {1 / cells!r}  cells = {', '.join(map(str, n))} /
&material name = 'a'  young = 1.0  poisson = {NU}  density = 1.0 /
&body material = 'a'  {box((0, 0, 0), sides)} /
{planes}
&load kind = 'traction'  {flat(2, sides[2])}  force = {vector(at((0.0, 0.0, sides[0] * sides[1])))} /
&crack kind = 'symmetry'  normal = '{'xyz'[axes.index(2)]}'  center = {vector(np.array(at(center)) + 0.0)}  {keys} /
{refine}
&method {method} /
&output file = 'case.h5'  {output} /
"""


def whole(side, cells, crack, method=STATIC, refine="", end=1.0, output=""):
    """The whole of a cube, with its crack in the plane of its middle, pulled at both ends."""
    s, z = side, side + 1 / cells
    held = "\n".join(f"&constraint lower = {vector(x)}  upper = {vector(y)}  fix = '{f}' /" for x, y, f in (
        ((0, -s, -s), (0, s, -s), "x"), ((-s, 0, -s), (s, 0, -s), "y"), ((s, s, 0), (s, s, 0), "z"), ((-s, s, 0), (-s, s, 0), "z"),
        ((s, -s, 0), (s, -s, 0), "z")))
    pull = "\n".join(f"&load kind = 'traction'  lower = {vector((-s, -s, e * s))}  upper = {vector((s, s, e * s))}  "
                     f"force = {vector((0, 0, e * 4 * s * s))} /" for e in (-1, 1))
    keys = "  ".join(f"{key} = {value if isinstance(value, str) else vector(value)}" for key, value in crack.items())
    return f"""
&run end_time = {end} /
&grid lower = {vector((-s, -s, -z))}  cell = {1 / cells!r}  cells = {round(2 * s * cells)}, {round(2 * s * cells)}, {round(2 * z * cells)} /
&material name = 'a'  young = 1.0  poisson = {NU}  density = 1.0 /
&body material = 'a'  lower = {vector((-s, -s, -s))}  upper = {vector((s, s, s))} /
{held}
{pull}
&crack kind = 'plane'  {keys} /
{refine}
&method {method} /
&output file = 'case.h5'  {output} /
"""


def run(folder, text, *arguments, code=0):
    """The columns of the history of a run, or what it says where it ends with another code; without a text it is resumed."""
    folder.mkdir(exist_ok=True)
    if text:
        (folder / "case.nml").write_text(text)
        arguments = ("case.nml", "--force", *arguments)
    result = subprocess.run([SOLID_PROGRAM, "--quiet", *arguments], cwd=folder, capture_output=True, text=True)
    assert result.returncode == code, result.stderr
    if code > 0:
        return result.stderr
    with h5py.File(folder / "case.h5") as results:
        return {key: column[()] for key, column in results["history"].items() if key in
                ("time", "strain_energy", "kinetic_energy", "external_work")}


def disc(radius):
    return {"front": "'disc'", "center": (0.0, 0.0, 0.0), "radii": [radius]}


def rate(folder, sides, cells, crack, part_of=0.05):
    """Energy that a crack of size 1 releases as it grows in all directions alike, for its growth, by two sizes around 1."""
    low, high = (run(folder, part(sides, cells, crack(1 + s * part_of)))["strain_energy"][-1] for s in (-1, 1))
    return (high - low) / (2 * part_of)


def reference(name):
    """Angles and K of a reference."""
    rows = [line for line in (REFERENCE / "solid" / name).read_text().splitlines() if line[0] in "0123456789"]
    angle, k, _ = np.array([line.split(",") for line in rows], float).T
    return np.radians(angle), k


def expected(name, area):
    """The same of a reference: G over a quarter of the front, of one half of the body, `area` being the product of the half axes."""
    angle, k = reference(name)
    return area * np.trapezoid((1 - NU**2) * k**2, angle) / 2


def test_whole_and_eighth_have_the_same_energy(tmp_path):
    """With nodes doubled in the plane of a crack, cells finer around its front, and with a node on the front: to rounding."""
    for radius, refine in ((0.62, TIP), (0.75, "")):
        all_of_it = run(tmp_path, whole(1.0, 4, disc(radius), refine=refine))["strain_energy"][-1]
        eighth = run(tmp_path, part((1.0, 1.0, 1.0), 4, disc(radius), refine=refine))["strain_energy"][-1]
        assert difference(f"radius {radius}", all_of_it / 8, eighth) < 1e-12


@pytest.mark.parametrize("method", ["time = 'implicit'  frame = 'total'  time_step = 0.2", "time = 'explicit'  frame = 'total'"])
def test_whole_and_eighth_move_alike(tmp_path, method):
    """In motion, for both: to rounding. Implicit steps keep the energy."""
    options = {"method": method, "end": 2.0, "output": "history_interval = 0.1"}
    all_of_it = run(tmp_path, whole(1.0, 4, disc(0.62), **options))
    eighth = run(tmp_path, part((1.0, 1.0, 1.0), 4, disc(0.62), **options))
    scale = np.max(np.abs(eighth["external_work"]))
    for column in ("strain_energy", "kinetic_energy", "external_work"):
        assert difference(column, all_of_it[column] / 8, eighth[column], scale) < 1e-12
    if "implicit" in method:
        assert difference("energy beside work", eighth["strain_energy"] + eighth["kinetic_energy"], eighth["external_work"], scale) < 1e-11


def test_axes_exchanged_and_mirrored(tmp_path):
    """An ellipse, a polygon and a half plane that is cut off slanted: to rounding."""
    sides = (1.0, 1.25, 0.75)
    polygon = lambda at: {"front": "'polygon'", "points": [x for y in ((-0.2, -0.1, 0), (0.6, 0, 0), (0.4, 0.7, 0), (-0.2, 0.5, 0)) for x in at(y)]}
    for shape in ("ellipse", "polygon", "straight"):
        energies = []
        for axes, mirrored in (((0, 1, 2), ()), ((1, 2, 0), ()), ((2, 0, 1), ()), ((1, 0, 2), ()), ((0, 1, 2), (2,)), ((2, 1, 0), (0, 2))):
            at = lambda x: [(-1 if axes[d] in mirrored else 1) * float(x[axes[d]]) for d in range(3)]
            if shape == "ellipse":
                radii = [r for d, r in zip(axes, [(0.7, 0.4, None)[d] for d in axes], strict=True) if r]
                crack = {"front": "'ellipse'", "center": (0.0, 0.0, 0.0), "radii": radii}
            elif shape == "polygon":
                crack = polygon(at)
            else:
                crack = {"front": "'straight'", "tip": at((0.55, 0.0, 0.0)), "direction": at((0.8, 0.6, 0.0))}
            text = part(sides, 4, dict(crack), axes, mirrored)
            energies.append(run(tmp_path, text if shape == "ellipse" else "\n".join(
                line.replace("center = 0.0, 0.0, 0.0", "") for line in text.splitlines()))["strain_energy"][-1])
        assert difference(shape, energies, energies[0]) < 1e-12


def test_threads_and_restarts_change_no_byte(tmp_path):
    """In motion, with finer cells: of all columns."""
    for method in ("time = 'explicit'  frame = 'total'", "time = 'implicit'  frame = 'total'  time_step = 0.1"):
        text = part((1.0, 1.0, 1.0), 4, disc(0.62), method=method, refine=TIP, end=1.0, output="history_interval = 0.1")
        one = run(tmp_path / "one", text, "--threads", "1")
        run(tmp_path / "two", text, "--threads", "2", "--steps", "4", code=5)
        two = run(tmp_path / "two", None, "--resume", "case.h5.checkpoint")
        for column in one:
            assert np.array_equal(one[column], two[column]), (method, column)


def test_energy_released_by_a_disc(tmp_path):
    """G over the front of a penny crack in a cube of 2.5 radii, with 4 and 6 cells to the radius."""
    for cells in (4, 6):
        g = rate(tmp_path, (2.5, 2.5, 2.5), cells, disc)
        assert difference(f"K of {cells} cells", np.sqrt(g / expected("penny_cube2.5.csv", 1.0)), 1.0) < 0.01


def test_k_of_a_front_that_passes_faces_of_cells(tmp_path):
    """Nodes just ahead of a tip held faces of the plane together, 4 % of K; those of a front that is along the cells or slanted do not."""
    found = []
    for cells in (3.999, 4.001):
        run(tmp_path, (INPUT / "solid/penny.nml").read_text(), "--set", f"crack.radii={cells * 2.5e-3!r}", "--set", "refine.max_level=0", "--set", "output.file=case.h5")
        with h5py.File(tmp_path / "case.h5") as results:
            found.append(results["front/K_I"][-1])
    assert len(found[0]) == 5 and found[1] == pytest.approx(found[0], rel=1e-3)


@pytest.mark.verify
@pytest.mark.parametrize(("name", "sides", "radii", "within"), [
    ("penny_cube4.csv", (4.0, 4.0, 4.0), (1.0, 1.0), 0.01), ("ellipse_block.csv", (6.0, 4.0, 5.0), (2.0, 1.0), 0.02)])
def test_energy_released_in_other_blocks(tmp_path, name, sides, radii, within):
    """G over the front of a penny in a larger cube, and of an ellipse in a block, with 4 cells to the smaller radius."""
    g = rate(tmp_path, sides, 4, lambda size: {"front": "'ellipse'", "center": (0.0, 0.0, 0.0), "radii": [size * r for r in radii]})
    assert difference(name, np.sqrt(g / expected(name, radii[0] * radii[1])), 1.0) < within


CYLINDER = """
&run end_time = 1.0 /
&grid lower = -2.75, -2.75, 0.0  cell = 0.25  cells = 22, 22, 11 /
&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 /
&body material = 'a'  shape = 'cylinder'  lower = 0.0, 0.0, 0.0  upper = 0.0, 0.0, 2.5  radius = 2.5 /
&constraint lower = -2.5, -2.5, 0.0  upper = 2.5, 2.5, 0.0  fix = 'z' /
&constraint lower = 0.0, 0.0, 2.5  upper = 0.0, 0.0, 2.5  fix = 'xy' /
&constraint lower = 0.0, 1.0, 2.5  upper = 0.0, 1.0, 2.5  fix = 'x' /
&crack kind = 'symmetry'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = {radius} /
&load kind = 'pressure'  on = 'crack'  pressure = 1.0 /
&method time = 'static'  frame = 'total' /
&output file = 'case.h5' /
"""


@pytest.mark.verify
def test_a_disc_in_a_cylinder(tmp_path):
    """K by the energy, of a crack under pressure in a cylinder as high and wide as 2.5 radii, by axisymmetric finite elements 1.06129 times that of the infinite body."""
    low, high = (run(tmp_path, CYLINDER.format(radius=radius))["strain_energy"][-1] for radius in (0.95, 1.05))
    assert difference("K", np.sqrt((high - low) / (0.1 * np.pi * (1 - NU**2))) / (2 / np.sqrt(np.pi)), 1.06129) < 0.01


def test_pressure_on_the_faces_is_tension_less_that_of_the_block(tmp_path):
    """The energy of the crack in both, in the whole cube and its eighth, with finer cells and without: to rounding."""
    pressed = "&load kind = 'pressure'  on = 'crack'  pressure = 1.0 /\n&crack"
    for radius, refine in ((0.62, TIP), (0.75, "")):
        text = whole(1.0, 4, disc(radius), refine=refine)
        tension = run(tmp_path, text)["strain_energy"][-1]
        for scale, of in ((1, text), (8, part((1.0, 1.0, 1.0), 4, disc(radius), refine=refine))):
            pressure = run(tmp_path, re.sub("&load.*\n", "", of).replace("&crack", pressed))["strain_energy"][-1]
            assert difference(f"an {'eighth' if scale > 1 else 'whole'}", scale * pressure, tension - 4.0) < 1e-12


@pytest.mark.parametrize("more", ["", "&refine indicator = 'tip'  max_level = 1  rings = 1 /"], ids=["", "finer"])
def test_pressure_presses_on_both_faces_where_rows_of_particles_do_not_fit_the_cells(tmp_path, more):
    """A block of 7.5 cells: no particle is as far from the plane of the crack as on the other side, and the block is held by no force."""
    (tmp_path / "case.nml").write_text(f"""
&run end_time = 1.0 /
&grid lower = 0.0, 0.0, 0.0  cell = 0.25  cells = 8, 8, 8 /
&material name = 'a'  young = 1.0  poisson = {NU}  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 1.875, 2.0, 2.0 /
&constraint name = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.0, 2.0, 2.0  fix = 'xyz' /
&crack kind = 'plane'  normal = 'x'  front = 'disc'  center = 1.0, 1.0, 1.0  radii = 0.6 /
&load kind = 'pressure'  on = 'crack'  pressure = 1.0 /
{more}
&method time = 'static' /
&output file = 'case.h5' /
""")
    subprocess.run([SOLID_PROGRAM, "case.nml", "--quiet"], cwd=tmp_path, check=True)
    with h5py.File(tmp_path / "case.h5") as results:
        assert results["history/strain_energy"][-1] > 0
        assert difference("force that holds the block", results["history/reaction_a_x"][-1], 0.0, np.pi * 0.6**2) < 1e-9


def test_faces_in_contact_are_none(tmp_path):
    """A cracked cube under compression is one without a crack, but for the stiffness of what presses; under tension contact does nothing."""
    text = whole(1.0, 4, disc(0.62))
    touching = text.replace("&crack", "&crack contact = 'frictionless'")
    assert difference("apart", run(tmp_path, touching)["strain_energy"][-1], run(tmp_path, text)["strain_energy"][-1]) < 1e-12
    turned = re.sub(r"0.0, (-?)4.0 /", lambda sign: "0.0, -4.0 /" if not sign[1] else "0.0, 4.0 /", touching)
    assert difference("pressed", run(tmp_path, turned)["strain_energy"][-1], 4.0) < 1e-5


def test_stress_along_a_crack_is_uniform(tmp_path):
    """With finer cells on one side of its plane only, and three sizes of cells: to rounding."""
    box = "&constraint lower = -1.0, -1.0, -1.0  upper = {}  fix = '{}' /\n"
    held = (box.format("-1.0, 1.0, 1.0", "x") + box.format("-1.0, -1.0, -1.0", "yz")
            + "&constraint lower = -1.0, 1.0, -1.0  upper = -1.0, 1.0, -1.0  fix = 'z' /\n"
              "&load kind = 'traction'  lower = 1.0, -1.0, -1.0  upper = 1.0, 1.0, 1.0  force = 4.0, 0.0, 0.0 /\n&crack")
    fine = "&refine indicator = 'gradient'  field = 'energy_density'  r_crit = 1e-17  max_level = 2  region_lower = 0.2, 0.0, 0.0  region_upper = 0.6, 0.3, 0.1 /"
    for normal in "yz":
        text = whole(1.0, 4, {"normal": f"'{normal}'", "front": "'ellipse'", "center": (0.0, 0.0, 0.0), "radii": [0.62, 0.5]}, refine=fine)
        text = re.sub("&(load|constraint).*\n", "", text).replace("&crack", held).replace("cells = 8,", "cells = 9,")
        assert difference(f"across {normal}", run(tmp_path, text)["strain_energy"][-1], 4.0) < 1e-12


@pytest.mark.parametrize(("crack", "message"), [
    ({"front": "'disc'", "center": (0.0, 0.0, 0.1), "radii": [0.5]}, "plane of the lattice"),
    ({"front": "'disc'", "center": (5.0, 5.0, 0.0), "radii": [0.5]}, "inside of the material"),
    ({"front": "'disc'", "center": (0.0, 0.0, 0.0), "radii": [-0.5]}, "radii"),
    ({"front": "'disc'", "center": (0.0, 0.0, 0.0), "radii": [0.5, 0.4]}, "1 value"),
    ({"front": "'ellipse'", "center": (0.0, 0.0, 0.0), "radii": [0.5, 0.1]}, "of the finest cells"),
    ({"front": "'polygon'", "points": [0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0]}, "go around the crack"),
    ({"front": "'polygon'", "points": [0, 0, 0, 1, 0, 0, 1, 0.1, 0]}, "wider crack"),
    ({"front": "'straight'", "tip": (0.5, 0, 0), "direction": (0, 0, 1)}, "in the plane across z"),
    ({"kind": "'plane'", "front": "'disc'", "center": (0.0, 0.0, 0.0), "radii": [0.5]}, "both sides"),
    ({"front": "'disc'", "radii": [0.5]}, "center")])
def test_wrong_cracks_are_refused_in_words(tmp_path, crack, message):
    text = part((1.0, 1.0, 1.0), 4, {"front": "'disc'", "radii": [0.5]})
    keys = "  ".join(f"{key} = {value if isinstance(value, str) else vector(value)}" for key, value in crack.items())
    lines = [f"&crack {keys} /" if line.startswith("&crack") else line for line in text.splitlines()]
    assert message in run(tmp_path, "\n".join(lines), code=2)


def test_what_is_said_of_a_plane_crack(tmp_path):
    """Its name is in the results; its length is none, and no end of a run."""
    text = """
&run end_time = 1e-3{run} /
&grid lower = 0.0, 0.0, 0.0  cell = 1.0  cells = 3, 3, 4 /
&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0{law} /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 3.0, 3.0, 4.0 /
&crack kind = 'plane'  name = 'flaw'  normal = 'z'  front = 'disc'  center = 1.0, 1.0, 2.0  radii = 1.6 /
&output file = 'case.h5' /
"""

    def call(*words, run="", law=""):
        (tmp_path / "case.nml").write_text(text.format(run=run, law=law))
        return subprocess.run([SOLID_PROGRAM, "case.nml", "--force", *words], cwd=tmp_path, capture_output=True, text=True)

    assert call("--quiet").returncode == 0
    with h5py.File(tmp_path / "case.h5") as file:
        assert file["history"].attrs["cracks"] in ("flaw", b"flaw")
    refused = call("--check", run="  stop_when = 'crack_length'  stop_length = 3.0")
    assert refused.returncode == 2 and "is not allowed with a solid" in refused.stderr
    plastic = "  law = 'j2_plastic'  yield_stress = 1e-3"
    assert "yielding cells lock" in call("--check", law=plastic).stderr
    assert "lock" not in call("--check", law=plastic + "  volumetric = 'b_bar'").stderr
