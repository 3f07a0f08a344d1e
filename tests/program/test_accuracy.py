"""Errors that are asked (&accuracy): the program chooses lattice, order, levels and steps, and keeps within the error of solutions that are known otherwise."""

import csv
import re
import subprocess

import h5py
import numpy as np
import pytest

from harness import run
from paths import INPUT, REFERENCE, SOLID_PROGRAM

MATERIAL = "&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700.0 /"
BEAM = f"""&run plane = 'stress'  thickness = 0.01  end_time = {{end}} /
{MATERIAL}
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.05, 0.0  upper = 0.1, 0.0  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.01  force = 0.0, 1.0 /
&crack kind = 'symmetry'  tip = 0.05, 0.0 /
&method {{method}} /
&accuracy quantity = '{{quantity}}'  error = {{error}} {{keys}} /
&output file = 'out.h5' {{output}} /
{{more}}"""


def beam(error, quantity="J", method="time = 'static'", keys="", end=1.0, output="", more=""):
    return BEAM.format(error=error, quantity=quantity, method=method, keys=keys, end=end, output=output, more=more)


# 1.28737 of beam theory 12 F**2 a**2/(E b**2 h**3), converged finite elements
G = 1.28737 * 12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3)


@pytest.mark.parametrize("error", [0.03, 0.01, 0.003, 0.001])
def test_a_beam_at_rest(hampm, error):
    row = run(hampm, beam(error))
    off, told = row["J"][-1] / G - 1, row["J_error"][-1] / row["J"][-1]
    print(f"asked {error:.1%}: off {off:.3%}, told {told:.3%}, particles {row['particles'][-1]:.0f}")
    assert abs(off) <= error and told <= error


@pytest.mark.parametrize("beta", ["0", "30", "45"])
@pytest.mark.parametrize("error", [0.01, 0.001])
def test_slanted_cracks_at_rest(hampm, beta, error):
    """K of both modes against integral equations; plane strain and another material."""
    lines = [line for line in (REFERENCE / "cracks/a2_slanted_centre_plate.csv").read_text().splitlines() if line[:1] != "#"]
    tips = [tip for tip in csv.DictReader(lines) if tip["case"] == f"beta={beta}"]
    ends = ", ".join(f"{float(tip[axis]) * 1e-3!r}" for tip in tips for axis in ("x_tip[mm]", "y_tip[mm]"))
    text = f"""&run plane = 'strain'  end_time = 1.0 /
&material name = 'a'  young = 3e9  poisson = 0.4  density = 1200.0 /
&body material = 'a'  lower = -20e-3, -40e-3  upper = 20e-3, 40e-3 /
&load kind = 'traction'  lower = -20e-3, 40e-3  upper = 20e-3, 40e-3  force = 0.0, 40e3 /
&load kind = 'traction'  lower = -20e-3, -40e-3  upper = 20e-3, -40e-3  force = 0.0, -40e3 /
&constraint lower = -20e-3, 0.0  upper = -20e-3, 0.0  fix = 'xy' /
&constraint lower = 20e-3, 0.0  upper = 20e-3, 0.0  fix = 'y' /
&crack kind = 'path'  points = {ends} /
&method time = 'static' /
&accuracy quantity = 'K_I'  error = {error} /
&accuracy quantity = 'K_II'  error = {error if beta != '0' else 0.999} /
&output file = 'out.h5' /
"""
    if beta == "0":
        text = text.replace(f"&accuracy quantity = 'K_II'  error = {0.999} /\n", "")
    row = run(hampm, text)
    for tip, ending in zip(tips, ("", "_tip2"), strict=True):
        for mode in ("K_I", "K_II")[:1 if beta == "0" else 2]:
            truth = float(tip[mode])
            off, told = row[mode + ending][-1] / truth - 1, row[f"{mode}_error{ending}"][-1] / abs(truth)
            print(f"{mode}{ending}: off {off:.4%}, told {told:.4%}")
            assert abs(off) <= error


def test_what_is_given_stays(hampm):
    """A lattice that is given: only order and levels are chosen; levels that are given: only the lattice."""
    given = run(hampm, beam(0.003, more="&grid cell = 2.5e-3  cells = 40, 4 /"))
    assert abs(given["J"][-1] / G - 1) <= 0.003
    assert given["finest_cell"][-1] <= 2.5e-3
    text = run(hampm, beam(0.01, more="&refine indicator = 'none' /"))
    assert abs(text["J"][-1] / G - 1) <= 0.01


def vibration(error, keys=""):
    """A beam that vibrates long enough for modes to pay."""
    return beam(error, "G", "time = 'explicit'", f"at = 'all'  {keys}", 5e-4, "history_interval = 4e-6", "&energy_release estimators = 'vcct' /").replace("&method time = 'explicit' /\n", "")


@pytest.mark.parametrize("model, least", [("beam", 8), ("wave", 6), ("vibration", 8)])
def test_explained(hampm, model, least):
    """--explain prints the model with every chosen key and why, of the mesh that a run ends with; it runs to the same bytes, and leaves nothing to choose."""
    text = {"beam": beam, "wave": wave, "vibration": vibration}[model]({"beam": 0.0003, "wave": 0.05, "vibration": 0.1}[model])
    run(hampm, text, "output.file=out.h5")
    with h5py.File(hampm.folder / "out.h5") as file:
        before = {name: column[:].tobytes() for name, column in file["history"].items()}
    (hampm.folder / "asked.nml").write_text(text)
    said = hampm("--explain", "asked.nml")
    assert said.returncode == 0 and said.stdout.count("! chosen: ") >= least
    run(hampm, said.stdout, "output.file=out.h5")
    with h5py.File(hampm.folder / "out.h5") as file:
        after = {name: column[:].tobytes() for name, column in file["history"].items()}
    assert before == after


def test_the_choice_is_the_same_on_any_number_of_threads(hampm):
    (hampm.folder / "asked.nml").write_text(beam(0.0003))
    one, two = (hampm("--explain", "asked.nml", "--threads", n).stdout for n in (1, 2))
    assert one == two != ""


@pytest.mark.parametrize("text", [beam(0.001), beam(0.1, end=1e-5, method="time = 'explicit'", keys="at = 'all'")], ids=["rest", "motion"])
def test_checked(hampm, text):
    """--check tells mesh, error, time, and what other errors cost, a smaller one more; nothing is written."""
    (hampm.folder / "asked.nml").write_text(text)
    said = hampm("--check", "asked.nml")
    assert said.returncode == 0
    for words in ("! accuracy ", "of the error asked"):
        assert words in said.stdout, said.stdout
    costs = [re.search(rf"{words}[^:]*: (?:about (\S+) s|is not reached)", said.stdout)[1] for words in ("a tenth of that error", "ten times that error")]
    assert costs[0] is None or float(costs[0]) >= float(costs[1])
    assert [path.name for path in hampm.folder.iterdir()] == ["asked.nml"]


@pytest.mark.parametrize("model, code, words", [
    (beam(0.01, quantity="K_III"), 2, "no such column with an estimated error; those that it has: "),
    (beam(0.01, quantity="strain_energy"), 2, "no such column with an estimated error"),
    (beam(1.5), 2, "error"),
    (beam(1e-9, keys="must = .true."), 3, "cannot be reached"),
    (beam(0.0001, keys="most_memory = 1e3"), 3, "most_memory"),
    (beam(0.03, keys="most_memory = 1e3"), 3, "most_memory"),    # also where the first mesh, or the next, is good enough
    (beam(0.01, keys="most_time = 1e-9"), 3, "most_time"),
    (beam(0.01).replace("quantity = 'J'", ""), 2, "quantity"),
])
def test_what_cannot_be(hampm, model, code, words):
    said = run(hampm, model, code=code)
    assert words in said
    assert not (hampm.folder / "out.h5").exists()


def test_an_error_that_is_not_reached(hampm):
    """The best mesh of little work has its result, and the run ends with 3."""
    said = run(hampm, beam(1e-9), code=3)
    assert "not reached" in said
    with h5py.File(hampm.folder / "out.h5") as file:
        assert abs(file["history/J"][-1] / G - 1) < 1e-3


def test_growth_at_rest(hampm):
    """The load at which a beam grows: G is that of the converged beam times the square of the load."""
    more = "&growth law = 'quasi_static'  toughness = 100.0  direction = 'straight'  increment = 1e-3 /"
    row = run(hampm, beam(0.005, quantity="load_factor", keys="at = 'all'", more=more, method="time = 'static'  load_steps = 2"))
    there = row["crack_length"] > 0.05 + 1e-9
    beam_theory = G * (1 + (row["crack_length"][there] - 0.05) / (0.05 * np.sqrt(1.28737)))**2     # the arm is longer than the crack, as that of the converged G is
    assert np.max(np.abs(row["load_factor"][there] / np.sqrt(100.0 / beam_theory) - 1)) <= 0.005


def wave(error, keys=""):
    """A wave that meets a crack, without what is chosen."""
    text = (INPUT / "freund_static.nml").read_text()
    for name in ("grid", "method", "energy_release"):
        before, _, rest = text.partition(f"&{name}\n")
        text = before + rest.partition("\n/\n")[2]
    before, _, rest = text.partition("&load                     ! held")
    text = before + rest.partition("\n/\n")[2]
    return text + f"&accuracy quantity = 'K_I'  error = {error}  at = 'all'  {keys} /\n"


def test_a_choice_with_limits_is_the_same(hampm):
    """In motion the choice is made before the run where there are limits, and by the first run else: the same mesh, and the same error at its end."""
    said = []
    for keys in ("", "must = .true.  most_time = 1e6"):
        (hampm.folder / "wave.nml").write_text(wave(0.05, keys))
        result = hampm("wave.nml", "--force", "--set", "output.file=wave.h5")
        assert result.returncode == 0, result.stderr
        with h5py.File(hampm.folder / "wave.h5") as file:
            said.append((file["history/K_I"][:].tobytes(), re.search(r"accuracy of K_I: .*", result.stdout)[0]))
    assert said[0] == said[1]


def test_freund(hampm):
    """K(t) of Freund's solution of a step, summed over the rise of the wave, within the error in all rows."""
    row = run(hampm, wave(0.05), "output.file=out.h5")
    young, nu, rho, height, rise = 199.992e9, 0.3, 5000.0, 10e-3, 0.7e-6
    speed = np.sqrt(young * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * rho))
    x = np.linspace(0, 1, 2001)
    parts, middle = np.diff(x**3 * (10 - 15 * x + 6 * x**2)), (x[1:] + x[:-1]) / 2
    step = 2e6 / (1 - nu) * np.sqrt(speed * (1 - 2 * nu) / np.pi)
    truth = step * np.sqrt(np.clip(row["time"][:, None] - height / speed - middle * rise, 0, None)) @ parts
    off = np.max(np.abs(row["K_I"] - truth)) / truth.max()
    print(f"off by {off:.2%} of the largest K, cells of {row['finest_cell'][-1]:.3g} m")
    assert off <= 0.05


@pytest.mark.parametrize("at", ["end", "mean"])
def test_a_step_load(hampm, at):
    """A half-plane crack whose faces are pressed apart from time 0 on. Freund (1990), section 2.5: K = 2 p sqrt(c_d t (1 - 2 nu)/pi)/(1 - nu). The last row,
    or the root mean square of all, keeps within the error; a matrix with less dispersion than the lumped one takes part in the choice."""
    row = run(hampm, f"""&run plane = 'strain'  end_time = 6.2e-3 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7500 /
&body material = 'steel'  lower = -40.0, -20.0  upper = 20.0, 20.0 /
&load kind = 'pressure'  on = 'crack'  pressure = 100e6  history = 'ramp'  rise_time = 1e-6 /
&crack kind = 'path'  points = -40.0, 0.0, 0.0, 0.0 /
&accuracy quantity = 'K_I'  error = 0.05  at = '{at}' /
&output file = 'out.h5'  history_interval = 3.1e-5 /
""")
    speed = np.sqrt(200e9 * 0.7 / (7500 * 1.3 * 0.4))
    truth = 2 * 100e6 * np.sqrt(speed * row["time"] * 0.4 / np.pi) / 0.7
    off = (row["K_I"] - truth) / truth[-1]
    reached = abs(off[-1]) if at == "end" else np.sqrt(np.mean(off**2))
    print(f"off {reached:.2%} of 5 %, cells of {row['finest_cell'][-1]:.3g} m, particles {row['particles'][-1]:.0f}")
    assert reached <= 0.05
    assert row["particles"][-1] < 1e5


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_a_step_load_in_a_solid(tmp_path):
    """The same between two planes that hold the front in plane strain: pilots choose among families of explicit steps, and K in the last row keeps within the error."""
    (tmp_path / "case.nml").write_text("""&run end_time = 6.2e-3 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7500 /
&body material = 'steel'  lower = -40.0, 0.0, 0.0  upper = 20.0, 20.0, 10.0 /
&constraint lower = 0.0, 0.0, 0.0  upper = 20.0, 0.0, 10.0  fix = 'y' /
&constraint lower = -40.0, 0.0, 0.0  upper = 20.0, 20.0, 0.0  fix = 'z' /
&constraint lower = -40.0, 0.0, 10.0  upper = 20.0, 20.0, 10.0  fix = 'z' /
&load kind = 'pressure'  on = 'crack'  pressure = 100e6  history = 'ramp'  rise_time = 1e-6 /
&crack kind = 'symmetry'  normal = 'y'  front = 'straight'  tip = 0.0, 0.0, 0.0  direction = 1.0, 0.0, 0.0 /
&accuracy quantity = 'K_I'  error = 0.2  at = 'end' /
&output file = 'case.h5'  history_interval = 1.24e-4 /
""")
    said = subprocess.run([SOLID_PROGRAM, "case.nml"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0 and "pilots took" in said.stdout, said.stderr
    with h5py.File(tmp_path / "case.h5") as file:
        k, end, particles = (file[f"history/{name}"][-1] for name in ("K_I", "time", "particles"))
    truth = 2 * 100e6 * np.sqrt(np.sqrt(200e9 * 0.7 / (7500 * 1.3 * 0.4)) * end * 0.4 / np.pi) / 0.7
    print(f"off {k / truth - 1:.2%}, particles {particles:.0f}")
    assert abs(k / truth - 1) <= 0.2
    assert particles < 2e5


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize("error", [0.03, 0.01])
def test_a_penny_in_a_cube(tmp_path, error):
    """G along the front of a solid: finite elements of degree 4 give K of 1.0590 times that of an endless body."""
    (tmp_path / "case.nml").write_text(f"""&run end_time = 1.0 /
&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 2.5, 2.5, 2.5 /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 2.5, 2.5  fix = 'x' /
&constraint lower = 0.0, 0.0, 0.0  upper = 2.5, 0.0, 2.5  fix = 'y' /
&constraint lower = 0.0, 0.0, 0.0  upper = 2.5, 2.5, 0.0  fix = 'z' /
&load kind = 'traction'  lower = 0.0, 0.0, 2.5  upper = 2.5, 2.5, 2.5  force = 0.0, 0.0, 0.00625 /
&crack kind = 'symmetry'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = 1.0 /
&method time = 'static' /
&accuracy quantity = 'G_mean'  error = {error} /
&output file = 'case.h5' /
""")
    said = subprocess.run([SOLID_PROGRAM, "--quiet", "case.nml"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    with h5py.File(tmp_path / "case.h5") as file:
        g, told = file["history/G_mean"][-1], file["history/G_mean_error"][-1]
    truth = (1.0590 * 2 * 1e-3 / np.sqrt(np.pi))**2 * (1 - 0.3**2)
    print(f"off {g / truth - 1:.3%}, told {told / g:.3%}")
    assert abs(g / truth - 1) <= error


@pytest.mark.verify
@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_an_ellipse_that_the_coarsest_lattices_are_too_coarse_for(tmp_path):
    """Lattices are made finer until the rules take them. Irwin (1962): K at the ends of the short axis b is sigma sqrt(pi b)/E(k); a body five times as wide has some percent more."""
    (tmp_path / "case.nml").write_text("""&run end_time = 1.0 /
&material name = 'a'  young = 210e9  poisson = 0.3  density = 7850 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 125e-3, 125e-3, 125e-3 /
&constraint lower = 0.0, 0.0, 0.0  upper = 125e-3, 125e-3, 0.0  fix = 'z' /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 125e-3, 125e-3  fix = 'x' /
&constraint lower = 0.0, 0.0, 0.0  upper = 125e-3, 0.0, 125e-3  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0, 125e-3  upper = 125e-3, 125e-3, 125e-3  force = 0.0, 0.0, 15625.0 /
&crack kind = 'symmetry'  normal = 'z'  front = 'ellipse'  center = 0.0, 0.0, 0.0  radii = 25e-3, 9e-3 /
&method time = 'static' /
&accuracy quantity = 'G_mean'  error = 0.2 /
""")
    said = subprocess.run([SOLID_PROGRAM, "--quiet", "case.nml"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    angle = (np.arange(2000) + 0.5) * np.pi / 4000
    width, height = 25e-3, 9e-3
    ellipse = np.mean(np.sqrt(1 - (1 - (height / width)**2) * np.sin(angle)**2)) * np.pi / 2
    along = np.hypot(width * np.cos(angle), height * np.sin(angle))        # at the end of the short axis: the width
    g = (1e6 / ellipse)**2 * np.pi * height / width * along * (1 - 0.3**2) / 210e9
    with h5py.File(tmp_path / "case.h5") as file:
        assert file["history/G_mean"][-1] == pytest.approx(np.sum(g * along) / np.sum(along), rel=0.05)


def test_supports_that_end_between_nodes(hampm):
    """What they hold depends on the cells: meshes are compared, and a warning says so."""
    text = beam(0.05).replace("fix = 'y' /", "fix = 'y' /\n&constraint lower = 0.09, 0.0037  upper = 0.1, 0.01  fix = 'x' /", 1)
    row = run(hampm, text)
    assert "ends between nodes" in row.said
    assert abs(row["J"][-1] / G - 1) <= 0.05
    assert "between nodes" not in run(hampm, beam(0.05)).said


def test_lattices_between_edges_of_other_shapes(hampm):
    """Bodies of other shapes than rectangles need no nodes: lattices begin at the end of a support. What a support holds of a body is two cells at least. Finite elements of order 4: 3.0673e-4 J."""
    text = """&run plane = 'strain' end_time = 1 /
&material name = 'm' young = 1e9 poisson = 0.3 density = 1000 /
&body material = 'm' shape = 'polygon' points = 0.3e-3, 0.2e-3, 10.3e-3, 1.1e-3, 10.3e-3, 4.3e-3, 0.3e-3, 4.3e-3 /
&constraint lower = -1e-3, -1e-3 upper = 12e-3, 0.5e-3 fix = 'xy' /
&load kind = 'traction' lower = 10.3e-3, 0 upper = 10.3e-3, 6e-3 force = 0, -100 /
&crack kind = 'path' points = 9e-3, 3e-3, 9.5e-3, 3e-3 /
&method time = 'static' /
&accuracy quantity = 'J' error = 0.9 /
&output file = 'out.h5' /
"""
    row = run(hampm, text)
    assert "between nodes" not in row.said
    assert row["strain_energy"][-1] == pytest.approx(3.0673e-4, rel=0.1)


def test_pins_between_nodes_leave_cells_large(hampm):
    """Pins that are no multiples of the unit of edges are in the middle of sides of quadratic cells, of which there would be four times as many else. Tada, Paris & Irwin (2000), p. 2.2."""
    text = re.sub(r"&(grid|refine)\n.*?\n/\n", "", (INPUT / "centre_crack.nml").read_text(), flags=re.DOTALL)
    row = run(hampm, text + "&accuracy quantity = 'K_I'  error = 0.01 /\n", "output.file=out.h5")
    truth = 1.1090 * 1e6 * np.sqrt(np.pi * 20e-3)
    print(row["K_I"][-1] / truth - 1, row["particles"][-1])
    assert abs(row["K_I"][-1] / truth - 1) <= 0.01
    assert row["particles"][-1] < 1e5 and "between nodes" not in row.said


@pytest.mark.parametrize("error, order", [(0.02, 1), (0.0005, 2)])
def test_lattices_that_coordinates_make_fine(hampm, error, order):
    """A tip at 81 of 160 parts of the beam makes all cells small: bilinear ones are tried first, and quadratic ones where they fall short."""
    text = beam(error).replace("lower = 0.05, 0.0", "lower = 0.050625, 0.0").replace("tip = 0.05,", "tip = 0.050625,")
    row = run(hampm, text)
    truth = G * (1 + 0.000625 / (0.05 * np.sqrt(1.28737)))**2     # the arm is longer than the crack, as that of the converged G is
    print(f"off {row['J'][-1] / truth - 1:.3%}, particles {row['particles'][-1]:.0f}")
    assert abs(row["J"][-1] / truth - 1) <= error
    (hampm.folder / "asked.nml").write_text(text)
    assert f"order = {order} ! chosen" in hampm("--explain", "asked.nml").stdout


def test_the_place_of_a_chosen_key(hampm):
    """Messages about a key that was chosen say so, and do not name an option that nobody gave."""
    text = f"""&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
{MATERIAL}
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.01  fix = 'xy' /
&load kind = 'traction'  lower = 0.1, 0.0  upper = 0.1, 0.01  force = 0.0, 1.0 /
&crack kind = 'path'  points = 0.05, 0.01, 0.05, 0.003 /
&method time = 'static' /
&grid cell = 0.0025  cells = 40, 4 /
&refine indicator = 'none' /
&accuracy quantity = 'J'  error = 0.01 /
"""
    said = run(hampm, text, code=2)
    assert "chosen for &accuracy, energy_release.estimators" in said and "--set energy" not in said
