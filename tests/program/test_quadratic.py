"""Quadratic cells, `&grid order = 2`, at rest: energy release rates against closed forms and converged finite elements."""

import h5py
import numpy as np
import pytest

from harness import differing, run
from history import lowpass, read_curve
from paths import INPUT, REFERENCE, REGRESSION

CONVERGED = 1.28737  # G/G_ref of the double cantilever beam at rest, tests/reference/dcb_static.csv
QUADRATIC = ("grid.order=2", "method.time=static", "method.frame=total", "body.points_per_cell=3", "output.history_interval=0",
             "energy_release.estimators=vcct,domain_integral")
BEAM = "grid.cell=2.5e-3", "grid.cells=40,5", "output.snapshot_interval=0"
TIP = "refine.indicator=tip", "refine.rings=4"


def test_a_beam_with_a_graded_mesh_has_the_converged_value(hampm):
    """Eight levels around the tip, and three estimators that share nothing but the mesh."""
    h = run(hampm, INPUT / "dcb.nml", *QUADRATIC, *BEAM, *TIP, "refine.max_level=8")
    assert h["G_vcct_I"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=1e-4)
    assert h["J"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=1e-4)
    assert h["K_I"][-1] ** 2 / 70e9 / h["G_ref"] == pytest.approx(CONVERGED, rel=1e-3)
    assert h["reaction_y"][-1] == pytest.approx(-1, rel=1e-9)


def test_levels_around_the_tip_take_its_error_away_by_halves(hampm):
    """The singular tip leaves an error in proportion to the cells there: each two levels leave a quarter."""
    j = [run(hampm, INPUT / "dcb.nml", *QUADRATIC, *BEAM, *TIP, f"refine.max_level={level}")["J"][-1] for level in (1, 3, 5, 7)]
    ratios = np.diff(j)[1:] / np.diff(j)[:-1]
    assert ratios == pytest.approx(1 / 4, abs=0.02)


def test_the_error_estimate_leads_to_the_converged_value(hampm):
    """From two cells over the depth on, without a word of where the tip is; bilinear cells have 0.07 % with 16800 particles."""
    h = run(hampm, INPUT / "dcb.nml", *QUADRATIC, "grid.cell=5e-3", "grid.cells=20,3", "output.snapshot_interval=0",
            "refine.indicator=zz", "refine.tolerance=0.005", "refine.max_level=12")
    assert h["J"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=1e-4)
    assert h["particles"][-1] < 6000


@pytest.mark.parametrize("points", [3, 4])
def test_a_split_beam_has_g_of_both_modes_in_closed_form(hampm, points):
    """A moment M on one of two arms of depth h: J = 21 M**2/(4 E B**2 h**3), of which 4/7 is of mode I (Williams 1988). Pure bending is
    quadratic, so that coarse cells have it; K is of second order in the cells, with 0.2 % that Poisson's ratio changes in mode II."""
    h = run(hampm, REGRESSION / "mixed_mode/case.nml", *QUADRATIC, "refine.indicator=none", f"body.points_per_cell={points}",
            "energy_release.radii=6e-3,7.5e-3,9e-3")
    j = 21 * 5e-3**2 / (4 * 70e9 * 0.01**2 * 0.01**3)
    assert h["J"][-1] == pytest.approx(j, rel=1e-4)
    assert h["G_vcct_I"][-1] == pytest.approx(4 / 7 * j, rel=5e-4)
    assert abs(h["G_vcct_II"][-1]) == pytest.approx(3 / 7 * j, rel=5e-4)
    assert h["K_I"][-1] ** 2 / 70e9 == pytest.approx(4 / 7 * j, rel=0.008)
    assert h["K_II"][-1] ** 2 / 70e9 == pytest.approx(3 / 7 * j, rel=0.008)


def test_explicit_motion_comes_to_the_same_rest(hampm):
    """Damped critically, with the default time step: G is that of equilibrium on the same mesh."""
    mesh = "grid.order=2", "body.points_per_cell=3", "method.frame=total", "grid.cell=5e-3", "grid.cells=20,3", \
        "energy_release.estimators=vcct", "output.snapshot_interval=0", "refine.indicator=tip", "refine.rings=1", "refine.max_level=1"
    motion = run(hampm, INPUT / "dcb.nml", *mesh, "method.courant=0", "damping.rate=3.2e4", "run.end_time=1.2e-3",
                 "output.history_interval=1e-5")
    rest = run(hampm, INPUT / "dcb.nml", *mesh, "method.time=static")
    assert motion["G_vcct_I"][-1] == pytest.approx(rest["G_vcct_I"][-1], rel=1e-4)


def test_a_mesh_that_refines_while_it_runs_comes_to_rest_at_the_converged_value(hampm):
    """At 0.9 ms the beam is nearly at rest on two cells over the depth, 1.1 % off, and looks at its error for the first time. With `usl`, as
    for bilinear cells: `musl` keeps what a release leaves in the velocities of particles that no node feels."""
    h = run(hampm, REGRESSION / "dcb_settled/case.nml", "grid.order=2", "body.points_per_cell=3", "method.frame=total",
            "grid.cell=5e-3", "grid.cells=20,3", "method.courant=0", "method.scheme=usl", "load.history=ramp", "load.rise_time=0.4e-3",
            "energy_release.estimators=vcct,domain_integral", "energy_release.energy_balance=.true.", "refine.indicator=zz", "refine.start=0.9e-3",
            "refine.interval=400", "refine.tolerance=0.05", "refine.max_level=6", "output.history_interval=1e-5")
    looked = np.flatnonzero(np.diff(h["particles"]))
    assert h["time"][looked[0]] >= 0.9e-3 and len(looked) > 2
    assert h["G_vcct_I"][looked[0]] / h["G_ref"] == pytest.approx(0.989 * CONVERGED, rel=2e-3)
    assert h["G_vcct_I"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=4e-3)
    assert h["J"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=5e-3)
    assert h["particles"][-1] < 1000
    error = h["kinetic_energy"] + h["strain_energy"] + h["damping_loss"] + h["numerical_loss"] - h["external_work"]
    assert np.max(np.abs(error)) < 1e-12 * np.max(h["external_work"])


GRADIENT = "refine.indicator=gradient", "refine.field=stress_norm", "refine.r_crit=0.03", "refine.energy_floor=0.2"
NEAR_THE_TIP = "refine.region_lower=0.04,0", "refine.region_upper=0.06,0.01"


def test_gradients_of_the_stress_lead_to_the_converged_value(hampm):
    """With these settings bilinear cells come to -0.7 % with half as many particles: they have as many cells."""
    h = run(hampm, INPUT / "dcb.nml", *QUADRATIC, "grid.cell=5e-3", "grid.cells=20,3", "output.snapshot_interval=0", *GRADIENT,
            *NEAR_THE_TIP, "refine.max_level=6")
    assert h["J"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=1e-3)
    assert h["particles"][-1] < 2500


@pytest.mark.parametrize(("field", "r_crit", "floor", "share"), [("energy_density", 0.02, 0.05, 0.9), ("stress_norm", 0.003, 0.1, 0.5)])
def test_gradients_mark_cells_that_they_mark_in_bilinear_cells_of_the_same_size(hampm, tmp_path, field, r_crit, floor, share):
    """By stress fewer of them: the stress of bilinear cells, which is recovered by linear functions, has kinks where that of quadratic ones has
    none."""
    def refined(*settings):
        run(hampm, INPUT / "dcb.nml", *QUADRATIC, "grid.cell=1.25e-3", "grid.cells=80,9", "refine.indicator=gradient",
            f"refine.field={field}", f"refine.r_crit={r_crit}", f"refine.energy_floor={floor}", "refine.max_level=1", *settings)
        with h5py.File(tmp_path / "out.h5") as file:
            places = np.split(file["VTKHDF/particles/Points"][:], np.cumsum(file["VTKHDF/particles/NumberOfPoints"][:]))[-2][:, :2]
        cells, count = np.unique(np.floor(places / 1.25e-3).astype(int), axis=0, return_counts=True)
        return set(map(tuple, cells[count > np.min(count)]))

    quadratic = refined("output.snapshot_interval=1.5e-3")
    bilinear = refined("output.snapshot_interval=1.5e-3", "grid.order=1", "body.points_per_cell=2")
    assert len(quadratic & bilinear) > 0.97 * len(quadratic)
    assert share * len(bilinear) < len(quadratic) <= len(bilinear)


def test_gradients_refine_a_mesh_that_moves(hampm):
    """As the error estimate does above: the beam that nearly is at rest stays there, and the audit closes."""
    h = run(hampm, REGRESSION / "dcb_settled/case.nml", "grid.order=2", "body.points_per_cell=3", "method.frame=total",
            "grid.cell=5e-3", "grid.cells=20,3", "method.courant=0", "method.scheme=usl", "load.history=ramp", "load.rise_time=0.4e-3",
            "energy_release.estimators=vcct,domain_integral", "energy_release.energy_balance=.true.", *GRADIENT, *NEAR_THE_TIP, "refine.max_level=3",
            "refine.start=0.9e-3", "refine.interval=100", "output.history_interval=1e-5")
    assert np.count_nonzero(np.diff(h["particles"])) > 0 and h["finest_cell"][-1] == 6.25e-4
    assert h["J"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=3e-3)
    assert h["G_vcct_I"][-1] / h["G_ref"] == pytest.approx(CONVERGED, rel=3e-3)
    error = h["kinetic_energy"] + h["strain_energy"] + h["damping_loss"] + h["numerical_loss"] - h["external_work"]
    assert np.max(np.abs(error)) < 1e-12 * np.max(h["external_work"])


PULSE = """\
&run thickness = 1.0 end_time = 6.0 /
&grid cell = 0.5 cells = 20, 1 order = 2 /
&material name = 'a' young = 1.0 poisson = 0.0 density = 1.0 /
&body material = 'a' lower = 0.0, 0.0 upper = 10.0, 0.5 points_per_cell = 3 /
&constraint lower = 0.0, 0.0 upper = 10.0, 0.5 fix = 'y' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.5 force = 5e-6, 0.0 history = 'table' times = 0.0, 0.5, 1.5, 2.0 factors = 0.0, 1.0, 1.0, 0.0 /
&method frame = 'total' mass = 'consistent' scheme = 'usavg' /
&refine indicator = 'gradient' field = 'stress_norm' r_crit = 0.05 r_coarsen = 0.02 max_level = 2 interval = 20 energy_floor = 0.05 /
&energy_release energy_balance = .true. /
&output history_interval = 1.0 /
"""


def test_fine_cells_go_with_a_pulse_and_recombine_behind_it(hampm, tmp_path):
    """The energy of a pulse in a bar is the integral of F**2/(A rho c) and half of it kinetic; cells that recombine take little of it, and the audit closes."""
    (tmp_path / "case.nml").write_text(PULSE)
    h = run(hampm, tmp_path / "case.nml")
    energy = 5e-6**2 * (4 / 3) / 0.5
    assert h["external_work"][-1] == pytest.approx(energy, rel=5e-3)
    assert h["finest_cell"][-1] == 0.125 and h["particles"][-1] < 0.9 * h["particles"].max()
    assert h["kinetic_energy"][3:] == pytest.approx(energy / 2, rel=0.02) and h["strain_energy"][3:] == pytest.approx(energy / 2, rel=0.02)
    assert np.ptp(h["numerical_loss"][3:]) < 1e-3 * energy
    error = h["kinetic_energy"] + h["strain_energy"] + h["damping_loss"] + h["numerical_loss"] - h["external_work"]
    assert np.max(np.abs(error)) < 1e-13 * energy


BAR = """\
&run thickness = 0.01 end_time = 1.0 /
&grid cell = 5e-3 cells = 4, 12 order = 2 /
&material name = 'a' young = 70e9 poisson = 0.0 density = 2700 /
&body material = 'a' lower = 0.0, 0.0 upper = 0.02, 0.06 points_per_cell = 3 /
&constraint lower = 0.0, 0.0 upper = 0.02, 0.0 fix = 'y' /
&load kind = 'gravity' acceleration = 0.0, -9.81 /
&method time = 'static' frame = 'total' /
&crack kind = 'line' tip = 0.01, 0.03 direction = 0.0, 1.0 length = 0.01 /
&refine indicator = 'tip' rings = 1 max_level = 2 /
"""


def test_a_bar_under_its_weight_is_exact_on_cells_of_three_sizes(hampm, tmp_path):
    """Its displacement is quadratic: the energy is that of theory to rounding. The crack along the stress changes nothing."""
    (tmp_path / "bar.nml").write_text(BAR)
    h = run(hampm, "bar.nml")
    assert h["finest_cell"][-1] == 1.25e-3
    assert h["reaction_y"][-1] == pytest.approx(2700 * 9.81 * 0.02 * 0.06 * 0.01, rel=1e-12)
    assert h["strain_energy"][-1] == pytest.approx((2700 * 9.81) ** 2 * 0.06**3 / (6 * 70e9) * 0.02 * 0.01, rel=1e-12)


RUBBER = """\
&run thickness = 0.01 end_time = 0.3 /
&grid cell = 0.02 cells = 15, 3 order = 2 /
&material name = 'rubber' law = 'neo_hookean' young = 1e6 poisson = 0.3 density = 1000 /
&body material = 'rubber' lower = 0.0, 0.0 upper = 0.2, 0.04 points_per_cell = 3 /
&constraint lower = 0.0, 0.0 upper = 0.0, 0.04 fix = 'x{held}' /
{symmetry}
&load kind = 'traction' lower = 0.2, 0.0 upper = 0.2, 0.04 force = {force} history = 'ramp' rise_time = 0.1 /
&method frame = 'total' {time} /
&damping rate = {rate} /
&output file = 'out.h5' snapshot_interval = 0.3 history_interval = 0.01 /
"""
AXIS = "&constraint lower = 0.0, 0.0 upper = 0.2, 0.0 fix = 'y' /"


@pytest.mark.parametrize(("time", "tolerance"), [("time = 'static' load_steps = 10", 1e-12), ("scheme = 'usf'", 1e-6)])
def test_rubber_has_the_large_stretch_of_its_closed_form(hampm, tmp_path, time, tolerance):
    """As tests/regression/neo_hookean_bar: a stretch of 1.40 at a lateral one of 0.9, at rest and after a damped motion."""
    (tmp_path / "rubber.nml").write_text(RUBBER.format(held="", symmetry=AXIS, force="126.6523417818091, 0.0", time=time,
                                                       rate=0 if "static" in time else 500))
    run(hampm, "rubber.nml")
    with h5py.File(tmp_path / "out.h5") as file:
        particles = file["VTKHDF/particles"]
        places, moved = (np.split(particles[name][:], 2) for name in ("Points", "PointData/displacement"))
    q = 0.9
    stretch = np.exp(-(q**2 - 1) * 1.3 * 0.4 / 2.6 / 0.3) / q**2
    start = places[1] - moved[1]
    np.testing.assert_allclose(places[1][:, 0], stretch * start[:, 0], rtol=0, atol=tolerance * 0.2)
    np.testing.assert_allclose(places[1][:, 1], q * start[:, 1], rtol=0, atol=tolerance * 0.2)


def test_bent_rubber_has_the_energy_that_bilinear_cells_tend_to(hampm, tmp_path):
    """A cantilever that is bent by about its depth: two cells over the depth against eight and sixteen, extrapolated."""
    def energy(*settings):
        return run(hampm, "rubber.nml", *settings)["strain_energy"][-1]
    (tmp_path / "rubber.nml").write_text(RUBBER.format(held="y", symmetry="", force="0.0, 4.0", rate=0, time="time = 'static' load_steps = 5"))
    coarse, fine = (energy("grid.order=1", "body.points_per_cell=2", f"grid.cell={cell}", f"grid.cells={round(0.3 / cell)},{round(0.06 / cell)}")
                    for cell in (0.005, 0.0025))
    assert energy() == pytest.approx(fine + (fine - coarse) / 3, rel=1e-3)


MOVING = ("grid.order=2", "method.time=implicit", "method.courant=0", "method.time_step=1e-6", "method.frame=total",
          "body.points_per_cell=3", "energy_release.estimators=vcct", "output.history_interval=2e-6", "damping.rate=0",
          "output.snapshot_interval=0", *TIP, "refine.max_level=2")


@pytest.mark.parametrize("mass", ["lumped", "weighted", "consistent"])
def test_motion_keeps_its_energy(hampm, mass):
    """What the load does is kinetic or strain energy, to rounding: the step of Newmark with alpha = 0 takes none."""
    h = run(hampm, INPUT / "dcb.nml", *MOVING, *BEAM[:2], "run.end_time=2e-4", "method.hht_alpha=0", f"method.mass={mass}")
    error = h["kinetic_energy"] + h["strain_energy"] - h["external_work"]
    assert np.max(np.abs(error)) < 1e-11 * np.max(h["external_work"])


@pytest.mark.parametrize("mass", ["lumped", "weighted", "consistent"])
def test_the_beam_vibrates_as_converged_finite_elements_do(hampm, mass):
    """G(t) below 50 kHz, rms over the peak, with four cells over the depth and steps of a 400th of the first period."""
    h = run(hampm, INPUT / "dcb.nml", *MOVING, *BEAM[:2], "run.end_time=0.7e-3", f"method.mass={mass}")
    times, exact = read_curve(REFERENCE / "dcb_dynamic_undamped.csv", 1)
    t, g = h["time"], h["G_vcct_I"] / h["G_ref"]
    converged = np.interp(t, times, exact)
    difference = (lowpass(t, g, 5e4) - lowpass(t, converged, 5e4))[t <= 0.6e-3]
    assert np.sqrt(np.mean(difference**2)) / np.max(np.abs(converged)) < 0.01


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf", "usavg"])
@pytest.mark.parametrize("mass", ["lumped", "weighted", "consistent", "fmpm"])
def test_the_audit_of_the_energy_closes_in_explicit_steps(hampm, mass, scheme):
    """With loss of the scheme, which the audit books particle by particle, on cells of three sizes."""
    h = run(hampm, INPUT / "dcb.nml", *MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "run.end_time=4e-6",
            "energy_release.estimators=vcct", "energy_release.energy_balance=.true.", "damping.rate=1e4", f"method.mass={mass}", f"method.scheme={scheme}")
    error = h["kinetic_energy"] + h["strain_energy"] + h["damping_loss"] + h["numerical_loss"] - h["external_work"]
    assert np.max(np.abs(h["numerical_loss"])) > 1e-5 * np.max(h["external_work"])
    assert np.max(np.abs(error)) < 1e-13 * np.max(h["external_work"])


@pytest.mark.parametrize(("mass", "scheme", "points"), [("lumped", "musl", 3), ("consistent", "usl", 3), ("weighted", "usf", 4), ("fmpm", "usavg", 5)])
def test_element_operators_do_what_the_passes_over_the_particles_do(hampm, mass, scheme, points):
    """The audit of the energy asks for each particle in each pass: without it cells are passed by their operators."""
    settings = (*MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "run.end_time=1e-5", "damping.rate=1e4",
                f"method.mass={mass}", f"method.scheme={scheme}", f"body.points_per_cell={points}")
    both = [run(hampm, INPUT / "dcb.nml", *settings, "energy_release.estimators=vcct", f"energy_release.energy_balance={balance}")
            for balance in (".false.", ".true.")]
    for column in ("G_vcct_I", "kinetic_energy", "strain_energy", "external_work", "mouth_opening"):
        np.testing.assert_allclose(both[0][column], both[1][column], rtol=0, atol=1e-11 * np.max(np.abs(both[1][column])))


FIBRES = "law = 'orthotropic' young_1 = 140e9 young_2 = 9e9 young_3 = 9e9 shear_12 = 5e9 poisson_12 = 0.3 angle = 30"


@pytest.mark.parametrize(("mass", "scheme", "points"), [("lumped", "musl", 3), ("consistent", "usl", 4), ("weighted", "usf", 3), ("fmpm", "usavg", 5)])
def test_element_operators_do_so_with_fibres_in_any_direction(hampm, tmp_path, mass, scheme, points):
    """A split beam under a moment on one arm, whose fibres couple tension and shear, on cells of three sizes."""
    text = (REGRESSION / "mixed_mode/case.nml").read_text().replace("young = 70e9\n   poisson = 0.3", FIBRES)
    assert FIBRES in text
    (tmp_path / "fibres.nml").write_text(text)
    settings = ("grid.order=2", "method.frame=total", "method.courant=0", "output.snapshot_interval=0", "output.history_interval=1e-6",
                "grid.cell=2.5e-3", "grid.cells=21,12", "run.end_time=1.2e-5", "refine.indicator=tip", "refine.rings=1", "refine.max_level=2",
                f"method.mass={mass}", f"method.scheme={scheme}", f"body.points_per_cell={points}")
    both = [run(hampm, "fibres.nml", *settings, "energy_release.estimators=vcct", f"energy_release.energy_balance={balance}")
            for balance in (".false.", ".true.")]
    for column in ("G_vcct_I", "G_vcct_II", "kinetic_energy", "strain_energy", "external_work"):
        np.testing.assert_allclose(both[0][column], both[1][column], rtol=0, atol=1e-12 * np.max(np.abs(both[1][column])))


RESUMED = {
    "static": (*QUADRATIC, *BEAM, "method.load_steps=4", "load.history=ramp", "load.rise_time=1.5e-3", "output.snapshot_interval=5e-4"),
    "implicit": (*MOVING, *BEAM[:2], "run.end_time=1e-5", "output.snapshot_interval=5e-6"),
    "explicit": (*MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "run.end_time=1e-6", "output.snapshot_interval=5e-7",
                 "output.history_interval=1e-7"),
    "refining": (*MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "run.end_time=1e-5", "output.snapshot_interval=1e-6",
                 "refine.indicator=zz", "refine.interval=2", "refine.tolerance=0.05", "output.history_interval=1e-7"),
    "gradients": (*MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "run.end_time=1e-5", "output.snapshot_interval=1e-6",
                  *GRADIENT, "refine.interval=2", "output.history_interval=1e-7"),
    "gradients at rest": (*QUADRATIC, *BEAM[:2], "method.load_steps=4", "load.history=ramp", "load.rise_time=1.5e-3",
                          "output.snapshot_interval=5e-4", *GRADIENT),
    "consistent": (*MOVING, *BEAM[:2], "method.time=explicit", "method.time_step=0", "method.mass=consistent", "run.end_time=1e-6",
             "output.snapshot_interval=5e-7", "output.history_interval=1e-7"),
}


@pytest.mark.parametrize("time", RESUMED)
def test_a_resumed_run_has_the_same_bytes(hampm, tmp_path, time):
    settings = (*TIP, "refine.max_level=3", *RESUMED[time])
    run(hampm, INPUT / "dcb.nml", *settings, name="whole")
    words = [word for setting in settings for word in ("--set", setting)]
    stopped = hampm(INPUT / "dcb.nml", "--force", "--quiet", "--set", "output.file=parts.h5", *words, "--steps", "2")
    assert stopped.returncode == 5, stopped.stderr
    resumed = hampm("--resume", "parts.h5.checkpoint", "--quiet")
    assert resumed.returncode == 0, resumed.stderr
    assert not differing(tmp_path / "whole.h5", tmp_path / "parts.h5")


def test_snapshots_have_biquadratic_cells(hampm, tmp_path):
    """VTK's own cell of nine nodes, 28: as its shape functions have it, the cells fill the grid, and the middle is the last node."""
    run(hampm, INPUT / "dcb.nml", *QUADRATIC, *BEAM[:2], *TIP, "refine.max_level=2")
    with h5py.File(tmp_path / "out.h5") as file:
        mesh = file["VTKHDF/mesh"]
        types, points, cells = mesh["Types"][:], mesh["Points"][:, :2], mesh["NumberOfCells"][-1]
        nodes = points[mesh["Connectivity"][: 9 * cells].reshape(cells, 9)]
    assert set(types) == {28}
    corners, sides, middle = nodes[:, :4], nodes[:, 4:8], nodes[:, 8]
    np.testing.assert_allclose(sides, (corners + np.roll(corners, -1, axis=1)) / 2, atol=1e-15)
    np.testing.assert_allclose(middle, corners.mean(axis=1), atol=1e-15)
    x, y = corners[..., 0], corners[..., 1]
    areas = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) / 2
    assert np.all(areas > 0)
    assert np.sum(areas) == pytest.approx(0.1 * 0.0125, rel=1e-9)


@pytest.mark.parametrize("settings", [QUADRATIC, (*RESUMED["consistent"], "run.end_time=2e-7", "output.snapshot_interval=0")], ids=["rest", "motion"])
def test_threads_do_not_change_a_byte(hampm, tmp_path, settings):
    words = [word for setting in (*settings, *BEAM[:2], *TIP, "refine.max_level=4") for word in ("--set", setting)]
    for threads in (1, 3):
        result = hampm(INPUT / "dcb.nml", "--quiet", "--threads", threads, "--set", f"output.file={threads}.h5", *words)
        assert result.returncode == 0, result.stderr
    assert not differing(tmp_path / "1.h5", tmp_path / "3.h5")
