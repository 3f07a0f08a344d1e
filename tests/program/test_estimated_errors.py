"""The estimated errors of G, J and K cover the true ones, on specimens with known G, and are not much larger."""

import sys

import h5py
import numpy as np
import pytest

from history import History
from paths import BENCH

sys.path.insert(0, str(BENCH))

from error_specimens import columns_of, specimens, with_quadratic_cells  # noqa: E402

pytestmark = pytest.mark.xdist_group("test_estimated_errors")  # which share the runs of a fixture
CHEAP = ["centre 0.4", "centre 0.5", "compact 0.5", "double edge 0.5", "beam, 4 cells", "beam, 4 cells, 3 points", "beam, 4 cells, strain",
         "beam, 8 cells, 1 point", "split beam, one moment", "split beam, opposite", "split beam, equal, 4 cells", "end notched, 4 cells"]
MOST = 3  # times the true error
# With quadratic cells. Closed forms of split beams are good to 2e-4 here: graded meshes come to 1.6e-4 of them, whatever the cells and particles
QUADRATIC = ["edge 0.5", "edge 0.5, tip", "edge 0.3", "edge 0.25, short plate", "centre 0.4", "centre 0.4, whole, tip", "centre 0.5",
             "centre 0.3, strain, nu 0.45", "Griffith 0.1, tip", "compact 0.5", "beam, 4 cells", "beam, 4 cells, tip", "beam, 4 cells, strain",
             "split beam, one moment", "split beam, equal, 4 cells"]


@pytest.fixture(scope="module")
def results(run_hampm, tmp_path_factory):
    folder = tmp_path_factory.mktemp("errors")
    found = {}
    for name in CHEAP:
        specimen = specimens()[name]
        (folder / "case.nml").write_text(specimen.scene)
        done = run_hampm("case.nml", "--force", "--quiet", "--set", "output.file=case.h5", cwd=folder)
        assert done.returncode == 0, done.stderr
        found[name] = History(folder / "case.h5").columns
    return found


@pytest.mark.parametrize("name", CHEAP)
def test_the_estimate_covers_the_error(results, name):
    columns, specimen = results[name], specimens()[name]
    for column, known in columns_of(specimen).items():
        error = abs(abs(columns[column][-1]) - known)
        assert error <= columns[column + "_error"][-1] + specimen.uncertainty_of(column), column


@pytest.mark.parametrize("points", [3, 4])
@pytest.mark.parametrize("name", QUADRATIC)
def test_the_estimate_covers_the_error_of_quadratic_cells(hampm, tmp_path, name, points):
    specimen = with_quadratic_cells(specimens()[name], points)
    (tmp_path / "case.nml").write_text(specimen.scene)
    settings = [word for setting in ("output.file=case.h5", *specimen.overrides) for word in ("--set", setting)]
    done = hampm("case.nml", "--quiet", *settings)
    assert done.returncode == 0, done.stderr
    columns = History(tmp_path / "case.h5").columns
    for column, known in columns_of(specimen).items():
        error = abs(abs(columns[column][-1]) - known)
        uncertain = max(specimen.uncertainty_of(column), 2e-4 * known if "split" in name else 0)
        assert error <= columns[column + "_error"][-1] + uncertain, column
        if "split" not in name:
            assert columns[column + "_error"][-1] <= MOST * (error + uncertain), column


def test_the_estimate_of_j_is_not_much_larger_than_the_error(results):
    for name in CHEAP:
        known = columns_of(specimens()[name])["J"]
        assert results[name]["J_error"][-1] <= MOST * abs(results[name]["J"][-1] - known), name


def test_no_estimate_is_below_its_part_of_the_largest_value(results):
    columns = results["beam, 4 cells"]
    part = columns["J_error"][-1] / columns["J"][-1]
    assert np.all(columns["J_error"] >= 0.099 * part * np.maximum.accumulate(np.abs(columns["J"])))


def test_estimates_have_the_units_of_their_columns(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(specimens()["beam, 4 cells"].scene)
    assert hampm("case.nml", "--set", "output.history_interval=1e-4", "--steps", 5).returncode == 5
    with h5py.File(tmp_path / "case.h5") as file:
        names = [name for name in file["history"] if name.endswith("_error")]
        assert len(names) == 6
        assert all(file["history"][n].attrs["units"] == file["history"][n.removesuffix("_error")].attrs["units"] for n in names)


def test_the_check_says_what_error_is_to_be_expected(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(specimens()["centre 0.5"].scene)
    lines = [line for line in hampm("--check", "case.nml").stdout.splitlines() if line.startswith("! expected error")]
    assert len(lines) == 1 and "J " in lines[0] and "%" in lines[0]


FREE = """\
&run plane = 'strain'  end_time = 1e-5 /
&grid lower = -12e-3, -12e-3  cell = 1e-3  cells = 24, 24 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3  eigenstrain = {strain}, {strain}, 0.0 /
&crack kind = 'path'  points = -4.3e-3, -1.2e-3, 3.7e-3, 1.3e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 100.0, 20e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -10e3 /
&energy_release estimators = 'domain_integral' /
"""


@pytest.mark.parametrize("strain", [0.0, 1e-5])
def test_what_loads_accelerate_has_the_errors_of_what_they_strain(hampm, tmp_path, strain):
    """Nothing holds a body that loads move and turn: errors are told by its strain beside that (they were thousands of times the
    values). With cells of a quarter J of the second body is off by 0.36 of its peak at one time: errors are at most half of it."""
    (tmp_path / "case.nml").write_text(FREE.format(strain=strain))
    assert hampm("case.nml").returncode == 0
    columns = History(tmp_path / "case.h5").columns
    for name in "J", "K_I":
        part = columns[f"{name}_error"] / np.max(np.abs(columns[name]))
        print(name, part[-1])
        assert 0.0 < part[-1] and np.max(part) < 0.5


CLAMPED = """\
&run plane = '{plane}'  end_time = 1.0 /
&grid lower = 0.0, -{cell}  cell = {cell}  cells = {cells}, {cells}  order = 2 /
&material name = 'a'  young = 70e9  poisson = 0.49  density = 2700.0 /
&body material = 'a'  lower = 0.0, 0.0  upper = 12.0, 12.0  points_per_cell = 3 /
&crack kind = 'symmetry'  tip = 3.0, 0.0 /
&constraint lower = 3.0, 0.0  upper = 12.0, 0.0  fix = 'y' /
&constraint lower = 0.0, 12.0  upper = 12.0, 12.0  fix = 'xy' /
&load kind = 'traction'  lower = 12.0, 0.0  upper = 12.0, 12.0  force = 1e6, 1e6 /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 6  rings = 3 /
&energy_release estimators = 'domain_integral' /
&output file = 'case.h5' /
"""


@pytest.mark.parametrize("plane", ["axisymmetric", "strain"])
def test_the_estimate_is_the_error_of_cells_at_a_clamped_corner(hampm, tmp_path, plane):
    """Where a clamped edge meets a free one the stress has no bound. With six levels at the tip all of the error is of the cells there; four
    times finer ones show most of it. Estimates were 0.4 to 0.6 of that."""
    found = []
    for cell, cells in (1.0, 14), (0.25, 50):
        (tmp_path / "case.nml").write_text(CLAMPED.format(plane=plane, cell=cell, cells=cells))
        assert hampm("case.nml", "--force").returncode == 0
        columns = History(tmp_path / "case.h5").columns
        found.append((columns["K_I"][-1], columns["K_I_error"][-1]))
    off = abs(found[0][0] - found[1][0])
    print(plane, off, found[0][1])
    assert 0.9 * off <= found[0][1] <= MOST * off


FACES = """\
&run plane = 'strain'  end_time = 1.0 /
&grid lower = -1.0, -1.0  cell = 1.0  cells = 14, 15  order = 2 /
&material name = 'a'  young = 10e3  poisson = 0.4  density = 2000.0 /
&body material = 'a'  lower = 0.0, 0.0  upper = 12.0, 13.0  points_per_cell = 3 /
&crack kind = 'path'  points = -0.5, 4.6, 6.1, 8.5  contact = '{contact}' /
&constraint lower = 0.0, 0.0  upper = 12.0, 0.0  fix = 'xy' /
&load kind = 'pressure'  lower = 0.0, 0.0  upper = 0.0, 5.7  pressure = -0.16 /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 4  rings = 3 /
&energy_release estimators = 'domain_integral' /
&output file = 'case.h5' /
"""


def test_faces_that_are_open_have_the_errors_of_faces_without_contact(hampm, tmp_path):
    """All points of these faces part, one after the other, in six solutions. One that still held them made the error 40 times as large."""
    errors = []
    for contact in "none", "frictionless":
        (tmp_path / "case.nml").write_text(FACES.format(contact=contact))
        assert hampm("case.nml", "--force").returncode == 0
        errors.append(History(tmp_path / "case.h5").columns["K_I_error"][-1])
    assert errors[1] == pytest.approx(errors[0], rel=1e-6)
