"""Motions that begin from static equilibrium: what stays as it is makes no waves, in every law, scheme and mass matrix, and in both frames."""

import h5py
import harness
import numpy as np
import pytest

from paths import INPUT

# A plate with a slanted crack between its cells' lines, held below, pulled above; between cells of 1 mm
PLATE = """
&run plane = '{plane}'  end_time = {end} /
&grid lower = -22e-3, -22e-3  cell = 2e-3  cells = 22, 22  order = {order} /
&material name = 'a'  {law}  density = 7800 /
&body material = 'a'  lower = -20e-3, -20e-3  upper = 20e-3, 20e-3  points_per_cell = {points} {body} /
&constraint lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  fix = 'xy' /
&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = {force}  {history} /
&crack kind = 'path'  points = {crack} /
&method {method} /
&energy_release estimators = 'domain_integral' /
{more}
"""
ELASTIC = "young = 200e9  poisson = 0.3"
SLANTED, LEVEL = "-6e-3, -3e-3, 6e-3, 4e-3", "-6e-3, 0.0, 6e-3, 0.0"
MOVED = "&constraint lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  fix = 'y'  displacement = 0.0, 1e-6 /"
PULL, PRESS = "0.0, 40e3", "20e3, -100e3"
FRICTION = SLANTED + "  contact = 'friction'  friction = 0.2"
IMPLICIT = "time = 'implicit'  time_step = 2e-7"


def plate(hampm, tmp_path, method, code=0, options=(), **values):
    """Run the plate; columns of its history."""
    values = {"plane": "strain", "end": 6e-6, "order": 1, "points": 2, "law": ELASTIC, "body": "", "force": PULL, "history": "", "crack": SLANTED,
              "more": "", "method": method} | values
    (tmp_path / "plate.nml").write_text(PLATE.format(**values))
    result = hampm("plate.nml", "--force", *options)
    assert result.returncode == code, result.stderr
    if code:
        return result
    with h5py.File(tmp_path / "plate.h5") as file:
        return {name: column[:] for name, column in file["history"].items()}


def in_motion(row):
    """The largest kinetic energy, over the strain energy at the start."""
    return row["kinetic_energy"].max() / row["strain_energy"][0]


STILL = {
    "explicit": {}, "implicit": {"method": IMPLICIT}, "HHT": {"method": IMPLICIT + "  hht_alpha = -0.1"}, "reference": {"method": "path = 'reference'"},
    **{scheme: {"method": f"scheme = '{scheme}'"} for scheme in ("usf", "usl", "usavg")},
    **{mass: {"method": f"mass = '{mass}'"} for mass in ("consistent", "weighted", "fmpm")},
    "neo-Hookean": {"law": "law = 'neo_hookean'  " + ELASTIC}, "J2": {"law": "law = 'j2_plastic'  yield_stress = 2e6  hardening = 1e9  " + ELASTIC},
    "J2 implicit": {"law": "law = 'j2_plastic'  yield_stress = 2e6  hardening = 1e9  " + ELASTIC, "method": IMPLICIT},
    "orthotropic": {"law": "law = 'orthotropic'  young_1 = 200e9  young_2 = 100e9  young_3 = 100e9  shear_12 = 50e9  poisson_12 = 0.3  poisson_13 = 0.3  poisson_23 = 0.3"},
    "tip": {"more": "&refine indicator = 'tip'  max_level = 2  rings = 4 /"}, "zz": {"more": "&refine indicator = 'zz'  max_level = 1  tolerance = 0.05 /"},
    "quadratic": {"method": "mass = 'consistent'", "order": 2, "points": 3},
    "eigenstrain": {"body": "eigenstrain = 1e-4, -2e-5, 1e-5"}, "friction": {"crack": FRICTION, "force": PRESS},
    "friction implicit": {"crack": FRICTION, "force": PRESS, "method": IMPLICIT}, "moved": {"more": MOVED},
    "moved consistent": {"more": MOVED, "method": "mass = 'consistent'"}, "moved implicit": {"more": MOVED, "method": IMPLICIT},
    "cohesion": {"crack": LEVEL, "more": "&cohesive strength = 20e6  toughness = 100.0  from = 10e-3 /"},
    "pressed crack": {"more": "&load kind = 'pressure'  on = 'crack'  pressure = 1e6 /"},
    "one point implicit": {"points": 1, "method": IMPLICIT, "crack": LEVEL},
    "gravity": {"more": "&load kind = 'gravity'  acceleration = 0.0, -9.81 /"},
}


@pytest.mark.parametrize("case", [pytest.param(case, id=name, marks=[pytest.mark.verify] * (name == "J2 implicit")) for name, case in STILL.items()])
def test_what_stays_as_it_is_makes_no_waves(hampm, tmp_path, case):
    case = dict(case)
    row = plate(hampm, tmp_path, case.pop("method", "") + "  start = 'static'", **case)
    assert row["strain_energy"][0] > 0
    assert in_motion(row) < 1e-20
    assert np.ptp(row["J"]) < 1e-8 * abs(row["J"][0])


# Shape functions at the present positions are others than those at the reference ones by the strain, 1e-4 and less here, and sums over particles no
# integrals; the residual is of the order of the strain
MOVES_WITH_CELLS = {"updated": {}, "consistent": {"method": "mass = 'consistent'"}, "tip": {"more": "&refine indicator = 'tip'  max_level = 2  rings = 4 /"},
                    "cpdi": {"method": "shape_functions = 'cpdi'", "crack": LEVEL}, "pressed crack": {"more": "&load kind = 'pressure'  on = 'crack'  pressure = 1e6 /"}}


@pytest.mark.parametrize("case", MOVES_WITH_CELLS.values(), ids=MOVES_WITH_CELLS)
def test_updated_frame(hampm, tmp_path, case):
    case = dict(case)
    row = plate(hampm, tmp_path, case.pop("method", "") + "  frame = 'updated'  start = 'static'", **case)
    assert in_motion(row) < 1e-7
    assert np.ptp(row["J"]) < 2e-3 * row["J"][0]


@pytest.mark.parametrize("method", ["", IMPLICIT], ids=["explicit", "implicit"])
def test_it_begins_with_the_answer_of_a_static_model(hampm, tmp_path, method):
    """On the same cells; interface points at tips and small parts of cut cells are held otherwise at rest: 0.3 %."""
    still = plate(hampm, tmp_path, "time = 'static'", crack=LEVEL)
    row = plate(hampm, tmp_path, method + "  start = 'static'", crack=LEVEL)
    for name in ("J", "strain_energy", "external_work"):
        assert row[name][0] == pytest.approx(still[name][-1], rel=3e-3), name
    assert row["external_work"][0] == pytest.approx(row["strain_energy"][0], rel=1e-9)


def test_a_viscoelastic_body_begins_at_once_and_creeps(hampm, tmp_path):
    """The equilibrium is that of the instantaneous moduli; after that the material creeps as under a load that has come at once."""
    law = "law = 'viscoelastic'  moduli = 2e10  relaxation_times = 1e-5  " + ELASTIC
    row, elastic = (plate(hampm, tmp_path, "start = 'static'", law=of, crack=LEVEL) for of in (law, ELASTIC))
    assert row["J"][0] == pytest.approx(elastic["J"][0], rel=1e-9)
    assert row["viscous_dissipation"][-1] > 1e-3 * row["strain_energy"][0]
    assert row["kinetic_energy"].max() < 1e-2 * row["strain_energy"][0]


def test_loads_that_begin_later_are_the_only_ones_that_make_waves(hampm, tmp_path):
    """Of a linear body: what a second load does is the same on top of a held one as by itself, whatever the body holds."""
    later = "&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = 0.0, 10e3  history = 'smooth_ramp'  rise_time = 2e-6 /"
    both = plate(hampm, tmp_path, "start = 'static'", more=later)
    alone = plate(hampm, tmp_path, "start = 'static'", force="0.0, 0.0", more=later)
    assert both["kinetic_energy"][-1] > 0
    assert both["kinetic_energy"] == pytest.approx(alone["kinetic_energy"], rel=1e-7, abs=1e-9 * alone["kinetic_energy"].max())
    assert both["external_work"] == pytest.approx(both["strain_energy"] + both["kinetic_energy"], rel=1e-2)


def test_a_body_that_nothing_holds_has_no_static_start(hampm, tmp_path):
    (tmp_path / "free.nml").write_text(PLATE.format(plane="strain", end=1e-6, order=1, points=2, law=ELASTIC, body="", force=PULL, history="", crack=SLANTED,
                                                    more="", method="start = 'static'").replace("&constraint", "! &constraint"))
    result = hampm("free.nml")
    assert result.returncode == 3
    assert "equilibrium" in result.stderr


@pytest.mark.parametrize("method", ["", IMPLICIT, "frame = 'updated'"], ids=["total", "implicit", "updated"])
def test_resumed(hampm, tmp_path, method):
    """A motion that has begun from equilibrium goes on from a checkpoint as if it had not been stopped."""
    ramp = "&load kind = 'point'  lower = 20e-3, 20e-3  upper = 20e-3, 20e-3  force = 5e3, 0.0  history = 'ramp'  rise_time = 2e-6 /"
    whole = plate(hampm, tmp_path, method + "  start = 'static'", more=ramp)
    plate(hampm, tmp_path, method + "  start = 'static'", more=ramp, code=5, options=("--steps", 3))
    assert hampm("--resume", "plate.h5.checkpoint", "--steps", 4).returncode == 5
    assert hampm("--resume", "plate.h5.checkpoint").returncode == 0
    with h5py.File(tmp_path / "plate.h5") as file:
        for name, column in whole.items():
            assert file["history"][name][:].tobytes() == column.tobytes(), name


def test_freund_with_an_initial_static_state(hampm, tmp_path):
    """K is the static one, and besides that of Freund's solution of a step, summed over the smooth rise of the wave. Asked of G are 0.5 %; held are
    0.1 % all along, and 1 % of what the wave adds to K once a tenth of that is there."""
    young, nu, rho, height, rise = 199.992e9, 0.3, 5000.0, 10e-3, 0.7e-6
    result = hampm(INPUT / "freund_static.nml", "--force")
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "freund_static.h5") as file:
        time, k, g = (file["history"][name][:] for name in ("time", "K_I", "J"))
    speed = np.sqrt(young * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * rho))
    x = np.linspace(0, 1, 2001)
    parts, middle = np.diff(x**3 * (10 - 15 * x + 6 * x**2)), (x[1:] + x[:-1]) / 2
    step = 2e6 / (1 - nu) * np.sqrt(speed * (1 - 2 * nu) / np.pi)
    added = step * np.sqrt(np.clip(time[:, None] - height / speed - middle * rise, 0, None)) @ parts
    before = time < height / speed
    off, late = np.abs(g / g[0] / (1 + added / k[0])**2 - 1), added > 0.1 * added[-1]
    of_added = np.abs((k - k[0])[late] / added[late] - 1)
    print(f"G before the wave varies by {np.ptp(g[before]) / g[0]:.1e}; off Freund's by at most {off.max():.1e}, of what is added {of_added.max():.1e}")
    assert np.ptp(g[before]) < 2e-4 * g[0]
    assert off.max() < 1e-3
    assert of_added.max() < 0.01


FREE = """\
&run plane = 'stress'  thickness = 0.01  end_time = 1e-3 /
&grid lower = -0.01, -0.01  cell = 0.01  cells = 12, 9  order = {order} /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700.0 /
&body material = 'a'  points_per_cell = 3  lower = 0.0, 0.0  upper = 0.1, 0.06  eigenstrain = 1e-4, 3e-4, 0.0 /
&method {method} /
&probe name = 'middle'  quantity = 'displacement'  at = 0.05, 0.03 /
&probe name = 'corner'  quantity = 'displacement'  at = 0.0, 0.0 /
&output file = 'out.h5' /
"""


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("method", ["time = 'static'", "start = 'static'", "start = 'static'  time = 'implicit'", "start = 'static'  time = 'modal'"])
def test_a_body_that_nothing_holds_stays_where_it_is(hampm, method, order):
    """It swells about its centre of mass, and turns nowhere: fixed nodes chose its place, another one in a mirror."""
    history = harness.run(hampm, FREE.format(method=method, order=order))
    assert np.abs(history["displacement_middle_x"]).max() < 1e-12
    assert np.abs(history["displacement_middle_y"]).max() < 1e-12
    for row in (0, -1):
        assert history["displacement_corner_x"][row] == pytest.approx(-0.05 * 1e-4, rel=1e-9)
        assert history["displacement_corner_y"][row] == pytest.approx(-0.03 * 3e-4, rel=1e-9)
