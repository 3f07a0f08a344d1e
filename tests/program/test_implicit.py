"""Implicit steps (docs/explanation/implicit.md), against closed forms of Newmark and of Hilber, Hughes and Taylor, and against other steps."""

import functools
import numpy as np
import pytest

from history import History, lowpass, read_curve
from paths import REFERENCE, ROOT
import harness
from harness import differing

E, RHO, LENGTH, FORCE, SECTION = 70e9, 2700.0, 0.01, 1e3, 0.01 * 0.01
STRETCHED = FORCE * LENGTH / (E * SECTION)  # by the force, at rest [m]

# A single cell between a wall and a force, which it has one degree of freedom to follow
CELL = f"""\
&run end_time = 4e-5 plane = 'stress' thickness = 0.01 /
&grid lower = 0, 0 cell = 0.01 cells = 1, 1 /
&material name = 'a' young = {E} poisson = 0.0 density = {RHO} /
&body material = 'a' lower = 0, 0 upper = 0.01, 0.01 /
&constraint lower = 0, 0 upper = 0, 0.01 fix = 'xy' /
&constraint lower = 0, 0 upper = 0.01, 0 fix = 'y' /
&constraint lower = 0, 0.01 upper = 0.01, 0.01 fix = 'y' /
&load kind = 'traction' lower = 0.01, 0 upper = 0.01, 0.01 force = {FORCE}, 0 /
&method time = 'implicit' time_step = 1e-6 /
&output history_interval = 1e-6 /
"""
MASS = RHO * SECTION * LENGTH
FREQUENCY = {"lumped": np.sqrt(E * SECTION / LENGTH / (MASS / 2)),     # half of the mass at the moving end
             "consistent": np.sqrt(E * SECTION / LENGTH / (MASS * 5 / 16))}  # sum of m N**2 over points at the quarters
# A cantilever, bent by a force on its end
BEAM = """\
&run end_time = 1e-3 plane = 'stress' thickness = 0.01 /
&grid lower = 0, 0 cell = 0.01 cells = 20, 2 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, 0 upper = 0.2, 0.02 /
&constraint lower = 0, 0 upper = 0, 0.02 fix = 'xy' name = 'wall' /
&load kind = 'traction' lower = 0.2, 0 upper = 0.2, 0.02 force = 0, 10 /
&method time = 'implicit' /
&output history_interval = 1e-5 snapshot_interval = 5e-4 /
"""
REFINED = ("refine.indicator=tip", "refine.max_level=2", "crack.kind=line", "crack.tip=0.1,0.01")


@pytest.fixture
def columns(hampm):
    """`columns(model, *settings)` runs it: its row."""
    return functools.partial(harness.run, hampm, name="case")


def way(columns):
    """How far the force has moved the end of CELL [m]."""
    return columns["external_work"] / FORCE


def energy_error(columns):
    """What is missing in the energy balance at any time, over the largest energy."""
    energy = columns["kinetic_energy"] + columns["strain_energy"] + columns["damping_loss"] - columns["external_work"]
    return np.max(np.abs(energy - energy[0])) / np.max(columns["kinetic_energy"] + columns["strain_energy"])


def hht(frequency, rate, alpha, dt, steps):
    """Displacement, over that at rest, of one degree of freedom under a sudden force, by the equations as Hilber, Hughes and
    Taylor have them: solved for the acceleration."""
    beta, gamma = (1 - alpha)**2 / 4, 0.5 - alpha
    u, v, a = 0.0, 0.0, frequency**2
    found = [u]
    for _ in range(steps):
        u_predicted, v_predicted = u + dt * v + dt**2 * (0.5 - beta) * a, v + dt * (1 - gamma) * a
        right = frequency**2 + alpha * (rate * v + frequency**2 * u)
        right -= (1 + alpha) * (rate * v_predicted + frequency**2 * u_predicted)
        a = right / (1 + (1 + alpha) * (rate * gamma * dt + frequency**2 * beta * dt**2))
        u, v = u_predicted + dt**2 * beta * a, v_predicted + dt * gamma * a
        found.append(u)
    return np.array(found)


@pytest.mark.parametrize("mass", FREQUENCY)
@pytest.mark.parametrize("dt", [1e-7, 1e-6, 1e-5])
def test_the_period_is_that_of_average_acceleration(columns, mass, dt):
    """tan(phase of a step / 2) = w dt/2 (Hughes 1987, section 9.3); for small steps w is too low by (w dt)**2/12."""
    found = columns(CELL, f"method.mass={mass}", f"method.time_step={dt}", f"output.history_interval={dt}",
                    f"run.end_time={40 * dt}")
    phase = 2 * np.arctan(FREQUENCY[mass] * dt / 2)
    assert np.allclose(found["dt"][1:], dt, rtol=1e-9)
    assert np.allclose(way(found), STRETCHED * (1 - np.cos(phase * np.arange(41))), rtol=0, atol=1e-9 * STRETCHED)
    x = FREQUENCY[mass] * dt
    if x < 0.2:
        assert abs((1 - phase / x) / (x**2 / 12) - 1) < 0.01


def test_explicit_steps_with_lumped_masses_have_more_inertia(columns):
    """They map velocities anew in each step, v = D^-1 p with p = C v of the particles: their mass is D C^-1 D, C being the consistent
    matrix, of which D is (1/2)**2/(5/16) of the body's here. Implicit steps have D itself."""
    found = columns(CELL, "method.time=explicit", "method.time_step=0", "method.courant=0.02", "output.history_interval=1e-7")
    frequency = np.sqrt(E * SECTION / LENGTH / (0.8 * MASS))
    assert np.allclose(way(found), STRETCHED * (1 - np.cos(frequency * found["time"])), rtol=0, atol=0.02 * STRETCHED)


@pytest.mark.parametrize("alpha", [0.0, -0.05, -1 / 3])
@pytest.mark.parametrize("rate", [0.0, 1e5])
def test_a_step_is_that_of_hilber_hughes_and_taylor(columns, alpha, rate):
    for dt in (1e-6, 3e-5):
        found = columns(CELL, f"method.time_step={dt}", f"output.history_interval={dt}", f"run.end_time={40 * dt}",
                        f"method.hht_alpha={alpha}", f"damping.rate={rate}")
        asked = STRETCHED * hht(FREQUENCY["lumped"], rate, alpha, dt, 40)
        assert np.allclose(way(found), asked, rtol=0, atol=1e-9 * STRETCHED)


def test_alpha_damps_what_steps_do_not_resolve(columns):
    """With -1/3 a mode of high frequency falls to (1 + alpha)/(1 - alpha) = 1/2 in each step; with 0 it stays."""
    swing = {}
    for alpha in (0.0, -1 / 3):
        found = columns(CELL, "method.time_step=1e-3", "output.history_interval=1e-3", "run.end_time=0.03",
                        f"method.hht_alpha={alpha}")
        swing[alpha] = np.max(np.abs(way(found)[-10:] / STRETCHED - 1))
    assert 0.99 < swing[0.0] <= 1.01
    assert swing[-1 / 3] < 1e-3


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
def test_energy_stays_for_a_thousand_periods(columns, mass):
    period = 2 * np.pi / FREQUENCY[mass]
    found = columns(CELL, f"method.mass={mass}", f"method.time_step={period / 20}", f"output.history_interval={period}",
                    f"run.end_time={1000 * period}")
    assert found["step"][-1] == 20000
    assert energy_error(found) < 1e-10


@pytest.mark.parametrize("settings", [
    ("method.mass=lumped",), ("method.mass=consistent",), ("method.mass=consistent", "method.solver=cg"), ("method.mass=weighted",
    "method.solver=direct"), ("damping.rate=3e3", "method.mass=consistent"), REFINED, (*REFINED, "method.mass=consistent"),
    (*REFINED, "method.mass=partial", "method.consistent_region=refined"),
    (*REFINED, "body.velocity=1,2", "method.mass=consistent", "damping.rate=100"), ("load.history=sine", "load.frequency=3e3"),
    ("load.history=table", "load.times=0,1e-4,3e-4", "load.factors=1,-1,0.5"), ("body.points_per_cell=1",),
    ("load.kind=body", "load.lower=0.1,0")], ids=" ".join)
def test_the_energy_balance_is_exact(columns, settings):
    """For steps that are long for the cells (courant 3) and loads that vary within them."""
    assert energy_error(columns(BEAM, "method.time_step=1e-5", *settings)) < 1e-10


DRIVEN = {"constant": ("constraint.velocity=0,1",), "ramp": ("constraint.velocity=0,1", "constraint.history=ramp",
                                                             "constraint.rise_time=3e-4"),
          "shortened": ("constraint.velocity=0,1", "output.history_interval=4e-6", "output.snapshot_interval=0"),
          "sudden": ("constraint.velocity=0,1", "constraint.start=3.33e-4"),
          "displacement": ("constraint.displacement=1e-4,1e-3", "constraint.history=sine", "constraint.frequency=2e3")}


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("kind", DRIVEN)
def test_nodes_go_where_a_constraint_moves_them_and_the_work_of_that_is_exact(columns, kind, mass):
    found = columns(BEAM, "method.time_step=1e-5", f"method.mass={mass}", "damping.rate=100", *DRIVEN[kind])
    assert np.max(found["external_work"]) > 0
    assert energy_error(found) < 1e-10


def test_driven_nodes_do_not_swing_around_their_way(columns):
    """One end of a bar suddenly gets a velocity, and hht_alpha takes the waves of that away: then all of it has this velocity.
    Newmark's relations between displacement, velocity and acceleration would let the held nodes swing for ever, with a mass
    matrix that couples others to them."""
    found = columns(BEAM, "constraint.velocity=1,0", "constraint.start=2e-3", "load.force=0,0", "method.mass=consistent",
                    "method.time_step=1e-4", "method.hht_alpha=-0.3", "run.end_time=0.1", "output.history_interval=1e-3")
    mass = 2700 * 0.2 * 0.02 * 0.01
    assert abs(found["kinetic_energy"][-1] / (mass / 2) - 1) < 1e-6


def test_small_steps_give_the_motion_of_explicit_steps(columns):
    """With the consistent mass matrix nodes keep their velocity in both; explicit steps with usavg are of second order too."""
    same = ("method.mass=consistent", "method.solver=direct", "output.history_interval=1e-5")
    implicit = columns(BEAM, *same, "method.time_step=2.5e-7")
    explicit = columns(BEAM, *same, "method.time=explicit", "method.scheme=usavg", "method.courant=0.1")
    for name in ("external_work", "strain_energy"):
        assert np.max(np.abs(implicit[name] - explicit[name])) < 1e-3 * np.max(explicit[name]), name


def test_large_steps_under_a_slow_load_give_the_static_answer(columns):
    slow = ("run.end_time=10", "load.history=ramp", "load.rise_time=10", "output.history_interval=1", "output.snapshot_interval=0")
    implicit = columns(BEAM, *slow, "method.time_step=1")
    static = columns(BEAM, *slow, "method.time=static", "method.load_steps=10")
    assert implicit["step"][-1] == 10
    assert np.allclose(implicit["strain_energy"], static["strain_energy"], rtol=1e-6)
    assert np.allclose(implicit["reaction_wall_y"][1:], -np.arange(1, 11), rtol=1e-6)


def test_a_free_body_takes_the_impulse_of_a_force(columns):
    scene = "\n".join(line for line in BEAM.splitlines() if "constraint" not in line) + "\n"
    found = columns(scene, "load.kind=body", "load.lower=0,0", "method.mass=consistent", "body.velocity=0,1")
    mass = 2700 * 0.2 * 0.02 * 0.01
    assert np.allclose(found["kinetic_energy"], mass / 2 * (1 + 10 / mass * found["time"])**2, rtol=1e-10)


def test_steps_have_the_length_that_is_given_whatever_is_recorded(columns):
    """Shortened equally to end with the run; a row is of the first step that ends at its time or after it."""
    found = columns(BEAM, "method.time_step=3e-6", "output.history_interval=1e-5", "output.snapshot_interval=0")
    assert np.allclose(found["dt"][1:], 1e-3 / 334, rtol=1e-12)
    assert np.allclose(found["time"], 1e-3 / 334 * found["step"], rtol=1e-12) and found["time"][-1] == 1e-3
    assert np.all(np.ceil(np.arange(101) * 1e-5 / (1e-3 / 334) - 1e-9) == found["step"])
    assert columns(BEAM)["dt"][-1] == pytest.approx(1e-6)           # 1/1000 of the end time
    shear = np.sqrt(70e9 / 2.6 / 2700)
    for order in (), ("grid.order=2", "body.points_per_cell=3"):
        found = columns(BEAM, "method.courant=4", "output.history_interval=5e-4", *order)
        assert found["dt"][-1] == pytest.approx(4 * 0.01 / shear, rel=0.05)


def test_check_prints_the_step(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(BEAM)
    text = hampm("case.nml", "--check", "--set", "method.time_step=2e-6").stdout
    assert "! time step       2.0e-6 s at most\n! steps           500 at least\n" in text


def test_results_have_the_same_bytes_on_any_number_of_threads(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(BEAM)
    words = [word for item in (*REFINED, "method.mass=consistent") for word in ("--set", item)]
    for threads in (1, 3):
        assert hampm("case.nml", "--quiet", "--threads", threads, "--output", f"{threads}", *words).returncode == 0
    assert differing(tmp_path / "1/case.h5", tmp_path / "3/case.h5") == []


def test_a_crack_is_measured_as_ever(columns, tmp_path):
    """At rest by damping, and by hht_alpha for what long steps do not resolve: the energy release rate of the static solution."""
    crack = (*REFINED, "energy_release.estimators='vcct','domain_integral'", "output.snapshot_interval=0")
    static = columns(BEAM, *crack, "method.time=static")
    implicit = columns(BEAM, *crack, "damping.rate=5e3", "run.end_time=2e-2", "output.history_interval=1e-3",
                       "method.time_step=2e-5", "method.hht_alpha=-0.1")
    for name in ("G_vcct_II", "G_domain_II", "strain_energy"):
        assert implicit[name][-1] == pytest.approx(static[name][-1], rel=1e-4), name
    assert History(tmp_path / "case.h5").attributes["distance_to_equilibrium"] < 1e-3


def test_g_of_a_beam_that_vibrates_is_that_of_converged_finite_elements(columns, tmp_path):
    """Below 50 kHz, with steps that are 23 times as long as explicit ones may be. The bilinear cells, four over the depth of an
    arm, are too stiff in bending, and the lumped matrix is too light: what is left of both was measured as 0.7 % of the peak."""
    scene = (ROOT / "tests/regression/dcb_refined/case.nml").read_text()
    found = columns(scene, "damping.rate=0", "method.frame=total", "method.courant=0", "method.time=implicit",
                    "method.time_step=5e-7", "grid.cell=2.5e-3", "grid.cells=40,5", "refine.max_level=5",
                    "energy_release.estimators='vcct'", "run.end_time=0.7e-3", "output.history_interval=2e-6")
    times, exact = read_curve(REFERENCE / "dcb_dynamic_undamped.csv", 1)
    early = found["time"] <= 0.6e-3
    g = found["G_vcct_I"] / History(tmp_path / "case.h5").attributes["G_ref"]
    error = lowpass(found["time"], g, 5e4) - lowpass(found["time"], np.interp(found["time"], times, exact), 5e4)
    assert np.sqrt(np.mean(error[early]**2)) < 0.01 * np.max(exact)
    assert energy_error(found) < 1e-10


# --- laws that are not linear -------------------------------------------------------------------------------------------

# A cantilever of a large strain law that a force bends through more than a right angle, and lets swing
BENT = """\
&run end_time = 2.5 plane = 'strain' thickness = 1 /
&grid lower = 0, -2.5 cell = 0.1 cells = 24, 50 /
&material name = 'a' law = 'neo_hookean' young = 1e6 poisson = 0.3 density = 1000 /
&body material = 'a' lower = 0, 0 upper = 2, 0.2 /
&constraint lower = 0, 0 upper = 0, 0.2 fix = 'xy' name = 'wall' /
&load kind = 'traction' lower = 2, 0 upper = 2, 0.2 force = 0, 3e3 /
&method time = 'implicit' time_step = 2.5e-3 /
&output history_interval = 1e-2 snapshot_interval = 0 /
"""


def swing(columns):
    """Largest energy that is missing in the balance at any time, over the largest energy."""
    energy = columns["kinetic_energy"] + columns["strain_energy"] - columns["external_work"]
    return np.max(np.abs(energy)) / np.max(columns["kinetic_energy"] + columns["strain_energy"])


def test_the_energy_of_a_beam_that_turns_far_stays_for_a_thousand_steps(columns):
    """Newmark's average acceleration does not conserve the energy of a nonlinear law exactly: the internal forces work by the rule of
    trapezoids, which errs by dt**3 a step, back and forth. Measured 1.4e-4 of the energy with 1000 steps, 3.5e-5 with 2000."""
    found = columns(BENT)
    assert found["step"][-1] == 1000
    assert np.max(found["external_work"]) > 1.8 * 3e3                  # the end has moved by nearly the length of the beam
    drift = swing(found)
    print(f"energy missing after 1000 steps at most {drift:.2e} of the largest")
    assert drift < 3e-4
    assert swing(columns(BENT, "method.time_step=5e-3")) == pytest.approx(4 * drift, rel=0.4)


def test_a_large_strain_law_moves_as_by_explicit_steps(columns):
    same = ("method.mass=consistent", "run.end_time=1", "output.history_interval=2e-2", "load.history=sine", "load.frequency=0.4")
    explicit = columns(BENT, *same, "method.time=explicit", "method.time_step=0", "method.courant=0.1", "method.scheme=usavg",
                       "method.frame=total")  # so short that they stay as they are
    error = [np.max(np.abs(columns(BENT, *same, f"method.time_step={dt}")["external_work"] - explicit["external_work"]))
             / np.max(explicit["external_work"]) for dt in (1e-2, 5e-3, 2.5e-3)]
    print("external work from explicit steps:", error)
    assert error[2] < 2e-3
    assert error[1] < 0.4 * error[0] and error[2] < 0.4 * error[1]     # of second order


# A bar that is pulled, sheared and let go, in all of which its law dissipates
DISSIPATES = {"j2_plastic": "yield_stress = 1e8 hardening = 1e9",
              "viscoelastic": "moduli = 10e9, 8e9 relaxation_times = 2e-4, 2e-3"}
PULLED = """\
&run end_time = 1e-3 plane = 'strain' thickness = 1 /
&grid lower = 0, 0 cell = 0.05 cells = 22, 4 /
&material name = 'a' law = '{law}' young = 70e9 poisson = 0.3 density = 2700 {constants} volumetric = '{volumetric}' /
&body material = 'a' lower = 0, 0 upper = 1, 0.1 /
&constraint lower = 0, 0 upper = 0, 0.1 fix = 'xy' name = 'wall' /
&load kind = 'traction' lower = 1, 0 upper = 1, 0.1 force = 1.8e7, 2e5 history = 'sine' frequency = 1e3 /
&method time = 'implicit' mass = 'consistent' /
&output history_interval = 2e-5 snapshot_interval = 0 /
"""


@pytest.mark.parametrize("volumetric", ["standard", "b_bar"])
@pytest.mark.parametrize("law", DISSIPATES)
def test_laws_that_remember_move_and_dissipate_as_by_explicit_steps(columns, law, volumetric):
    scene = PULLED.format(law=law, constants=DISSIPATES[law], volumetric=volumetric)
    name = {"j2_plastic": "plastic_dissipation", "viscoelastic": "viscous_dissipation"}[law]
    explicit = columns(scene, "method.time=explicit", "method.time_step=0", "method.courant=0.05", "method.frame=total")
    error, missing = [], []
    for dt in (4e-6, 2e-6, 1e-6):
        found = columns(scene, f"method.time_step={dt}")
        error.append(np.max(np.abs(found[name] - explicit[name])) / np.max(explicit[name]))
        energy = found["kinetic_energy"] + found["strain_energy"] + found[name] - found["external_work"]
        missing.append(np.max(np.abs(energy)) / np.max(found["external_work"]))
    print(f"{law}, {volumetric}: dissipation from explicit steps {error}, missing energy {missing}")
    assert np.max(explicit[name]) > 0.02 * np.max(explicit["external_work"])
    for other in ("kinetic_energy", "strain_energy", "external_work"):
        assert np.max(np.abs(found[other] - explicit[other])) < 0.01 * np.max(explicit[other]), other
    assert error[-1] < 2e-3 and error[1] < 0.7 * error[0]
    assert missing[-1] < 1e-4 and missing[2] < 0.4 * missing[1]


def test_a_step_that_is_too_long_is_divided(columns):
    """The first step would bend the beam so far that Newton's iteration does not find the end of it at once."""
    found = columns(BENT, "run.end_time=0.4", "method.time_step=0.4", "output.history_interval=0.4", "load.force=0,2e4")
    whole = columns(BENT, "run.end_time=0.4", "method.time_step=1e-3", "output.history_interval=0.4", "load.force=0,2e4")
    assert found["step"][-1] == 1
    assert found["external_work"][-1] == pytest.approx(whole["external_work"][-1], rel=0.5)


def test_a_step_that_is_not_found_fails_and_says_where(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(BENT)
    result = hampm("case.nml", "--quiet", "--set", "load.force=0,-1e8", "--set", "method.time_step=0.5")
    assert result.returncode == 3
    assert "no equilibrium was found" in result.stderr and "method time_step" in result.stderr


# --- cells that refine ---------------------------------------------------------------------------------------------------

SHAKEN = f"""\
&run end_time = 6e-5 plane = 'strain' thickness = 1.0 /
&grid lower = 0, 0 cell = 0.01 cells = 10, 10 /
&material name = 'a' young = {E} poisson = 0.3 density = {RHO} /
&body material = 'a' lower = 0, 0 upper = 0.1, 0.1 /
&crack kind = 'symmetry' tip = 0.04, 0 /
&constraint lower = 0.04, 0 upper = 0.1, 0 fix = 'y' /
&constraint lower = 0.1, 0 upper = 0.1, 0 fix = 'x' /
&load kind = 'traction' lower = 0, 0.1 upper = 0.1, 0.1 force = 0, 1e5 history = 'ramp' rise_time = 2e-5 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. radii = 0.02, 0.03 /
&method time = 'implicit' time_step = 5e-7 /
&output history_interval = 2e-6 /
"""
FOLLOWS = ("refine.indicator=zz", "refine.max_level=2", "refine.tolerance=0.01", "refine.interval=5")


def balance_error(columns):
    """What the audit does not explain, over the largest energy."""
    had = sum(columns.get(name, 0) for name in ("kinetic_energy", "strain_energy", "numerical_loss", "plastic_dissipation", "damping_loss"))
    had = had - columns["external_work"]
    return np.max(np.abs(had - had[0])) / np.max(columns["kinetic_energy"] + columns["strain_energy"])


def test_cells_that_refine_in_motion_give_k_of_fine_ones(columns):
    """K(t) on cells that follow the motion is that on cells as fine everywhere, which the coarse ones have not; what another mesh does to the
    energy is booked and little."""
    follows, fine, coarse = (columns(SHAKEN, *settings) for settings in (FOLLOWS, ("grid.cell=0.0025", "grid.cells=40,40"), ()))
    assert follows["particles"][-1] < fine["particles"][-1]
    largest = np.max(fine["K_I"])
    off, coarse_off = (np.sqrt(np.mean((one["K_I"] - fine["K_I"])**2)) / largest for one in (follows, coarse))
    assert off < 0.002 and off < 0.3 * coarse_off
    assert balance_error(follows) < 1e-13
    assert abs(follows["numerical_loss"][-1]) < 1e-3 * np.max(follows["strain_energy"])


@pytest.mark.parametrize("settings", [("method.mass=consistent", "material.law=neo_hookean"), ("method.hht_alpha=-0.1", "damping.rate=1e3"),
                                      ("material.law=j2_plastic", "material.yield_stress=3e5", "material.hardening=1e10"),
                                      ("refine.indicator=gradient", "refine.field=energy_density", "refine.r_crit=0.1", "refine.r_coarsen=0.02"),
                                      ("crack.kind=line", "crack.tip=0.045,0.055", "crack.direction=2,1", "crack.contact=frictionless", "load.force=0,-1e5")])
def test_the_audit_closes_while_cells_refine(columns, settings):
    kept = [one for one in FOLLOWS if "gradient" not in settings[0] or "tolerance" not in one]
    found = columns(SHAKEN, "run.end_time=2e-5", *kept, *settings)
    assert found["particles"][-1] > found["particles"][0]
    assert balance_error(found) < 1e-13


# --- the audit ----------------------------------------------------------------------------------------------------------

AUDIT = "energy_release.estimators='domain_integral'", "energy_release.energy_balance=.true."


def unexplained(columns):
    """What is missing in the energy balance with all losses, over the largest energy."""
    taken = sum(columns[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "plastic_dissipation",
                                           "viscous_dissipation") if name in columns)
    energy = taken - columns["external_work"]
    return np.max(np.abs(energy - energy[0])) / np.max(columns["kinetic_energy"] + columns["strain_energy"])


@pytest.mark.parametrize("settings", [(), ("method.mass=consistent", "damping.rate=3e3"), DRIVEN["ramp"]],
                         ids=" ".join)
def test_the_audit_has_no_loss_without_alpha_and_all_of_it_with(columns, settings):
    """With average acceleration and a linear law nothing is lost; with alpha below 0 the loss closes the balance, and falls with
    the square of the steps or faster."""
    lost = {}
    for alpha in (0.0, -0.1):
        for dt in (1e-5, 5e-6):
            found = columns(BEAM, *REFINED, *AUDIT, *settings, f"method.time_step={dt}", f"method.hht_alpha={alpha}",
                            "load.history=sine", "load.frequency=5e2")
            assert unexplained(found) < 1e-10
            lost[alpha, dt] = np.max(np.abs(found["numerical_loss"])) / np.max(found["kinetic_energy"] + found["strain_energy"])
    print(settings, lost)
    assert max(lost[0.0, 1e-5], lost[0.0, 5e-6]) < 1e-10
    assert 1e-9 < lost[-0.1, 5e-6] < 0.5 * lost[-0.1, 1e-5]


def test_the_loss_of_a_single_mode_is_that_of_its_amplitude(columns):
    """One degree of freedom under a sudden force: the energy of its swing around rest, by the equations of Hilber, Hughes and Taylor."""
    alpha, dt, steps = -0.2, 1e-6, 40
    found = columns(CELL, f"method.hht_alpha={alpha}", "energy_release.energy_balance=.true.")
    u = STRETCHED * hht(FREQUENCY["lumped"], 0.0, alpha, dt, steps)
    assert unexplained(found) < 1e-12
    assert np.allclose(found["external_work"], FORCE * u, rtol=0, atol=1e-9 * FORCE * STRETCHED)
    lost = FORCE * u - E * SECTION / LENGTH * u**2 / 2 - found["kinetic_energy"]
    assert np.allclose(found["numerical_loss"], lost, rtol=0, atol=1e-9 * FORCE * STRETCHED)
    assert found["numerical_loss"][-1] > 0.01 * FORCE * STRETCHED


@pytest.mark.parametrize("law", DISSIPATES)
def test_the_audit_closes_the_balance_of_laws_that_remember(columns, law):
    scene = PULLED.format(law=law, constants=DISSIPATES[law], volumetric="b_bar")
    found = columns(scene, "method.time_step=1e-5", "method.hht_alpha=-0.05", "energy_release.energy_balance=.true.")
    assert unexplained(found) < 1e-8
    assert np.max(np.abs(found["numerical_loss"])) > 1e-6 * np.max(found["external_work"])


def test_a_body_flies_on_with_the_support_that_moves_with_it(hampm):
    """From the first step on: nothing strains it, and its kinetic energy is m v**2/2."""
    row = harness.run(hampm, """&run plane = 'strain' end_time = 1e-3 /
&grid lower = 0.0, 0.0 cell = 0.1 cells = 12, 4 /
&material name = 'a' young = 1e7 poisson = 0.3 density = 1000 /
&body material = 'a' lower = 0.1, 0.0 upper = 0.9, 0.3 velocity = 2.0, 0.0 /
&constraint lower = 0.1, 0.0 upper = 0.1, 0.3 fix = 'x' velocity = 2.0, 0.0 /
&method time = 'implicit' time_step = 1e-4 mass = 'consistent' /
""")
    assert row["kinetic_energy"] == pytest.approx(1000 * 0.8 * 0.3 * 2.0**2 / 2, rel=1e-9)
    assert np.max(row["strain_energy"]) < 1e-12 * row["kinetic_energy"][0]
