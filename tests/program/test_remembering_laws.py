"""Laws with a history, `j2_plastic` and `viscoelastic`, in whole runs: closed forms at rest and in motion, what is dissipated, and which
numbers of cracks are left."""

import functools
import math

import h5py
import numpy as np
import pytest

from paths import CHECKED_PROGRAM, PROGRAM
import harness
from harness import differing
from snapshots import field, points, read_steps

E, NU = 200e9, 0.3
MU, KAPPA = E/(2*(1 + NU)), E/(3*(1 - 2*NU))
YIELD, HARDENING = 400e6, 10e9
QUADRATIC = "grid.order=2", "body.points_per_cell=3", "method.frame=total"
both_orders = pytest.mark.parametrize("cells", [(), QUADRATIC], ids=["bilinear", "quadratic"])


@pytest.fixture
def run(hampm):
    """`run(model, *settings)` runs it: its row."""
    return functools.partial(harness.run, hampm, name="case")


# --- plasticity -------------------------------------------------------------------------------------------------------

STEEL = f"&material name = 'a'  young = {E}  poisson = {NU}  density = 7800  law = 'j2_plastic'  yield_stress = {YIELD}"
# tension, unloading, compression, tension again, by the motion of one end
BAR = STEEL + """  hardening = {hardening} /
&run plane = '{plane}'  thickness = 0.01  end_time = 4.0 /
&grid lower = 0.0, 0.0  cell = 5e-3  cells = 10, 4 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.04, 0.01 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.01  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.04, 0.0  fix = 'y' /
{more}
&constraint lower = 0.04, 0.0  upper = 0.04, 0.01  fix = 'x'  displacement = 4e-4, 0.0  name = 'grip'
            history = 'table'  times = 0.0, 1.0, 2.0, 3.0, 4.0  factors = 0.0, 1.0, 0.5, -1.0, 1.0 /
&method time = 'static'  load_steps = {steps} /
&energy_release energy_balance = .true. /
"""
HELD = "&constraint lower = 0.0, 0.01  upper = 0.04, 0.01  fix = 'y' /"


def bilinear(strain, modulus, slope, yields, per_stress):
    """Stress along a way of strains: elastic with `modulus`, with `slope` beyond a yield stress that rises as the plastic flow does."""
    stress, present, limit, stresses = 0.0, 0.0, yields, []
    for goal in strain:
        trial = stress + modulus*(goal - present)
        if abs(trial) > limit:
            side = math.copysign(1.0, trial)
            limit += slope*(abs(trial) - limit)/modulus*per_stress
            trial = side*limit
        stress, present = trial, goal
        stresses.append(stress)
    return np.array(stresses)


@both_orders
@pytest.mark.parametrize("plane, more, modulus, slope", [
    # uniaxial stress: E, and E H/(E + H); the yield stress is the stress itself
    ("stress", "", E, E*HARDENING/(E + HARDENING)),
    # uniaxial strain: kappa + 4/3 mu, and kappa + 4/3 mu h/(3 mu + h)
    ("strain", HELD, KAPPA + 4*MU/3, KAPPA + 4*MU/3*HARDENING/(3*MU + HARDENING)),
])
def test_a_bar_that_is_loaded_unloaded_and_loaded_the_other_way(run, plane, more, modulus, slope, cells):
    """Steps end where the way turns, so that each is the closed form's."""
    got = run(BAR.format(plane=plane, more=more, steps=48, hardening=HARDENING), *cells)
    strain = np.interp(got["time"], [0, 1, 2, 3, 4], [0, 1, 0.5, -1, 1])*0.01
    if plane == "stress":
        expected = bilinear(strain, modulus, slope, YIELD, 1.0)
        plastic = strain - expected/E
    else:
        # the deviator 4/3 mu (eps - eps_p 3/2) follows a bilinear way of its own beside the elastic pressure
        deviator = bilinear(strain, 2*MU, 2*MU*HARDENING/(3*MU + HARDENING), YIELD, 1.0)
        expected = KAPPA*strain + 2*deviator/3
        plastic = strain - deviator/(2*MU)
    stress = got["reaction_grip_x"]/1e-4
    print(f"\n{plane}: largest error over the yield stress {np.max(np.abs(stress - expected))/YIELD:.1e}")
    assert stress == pytest.approx(expected, abs=1e-6*YIELD)
    # the work on the plastic strain is that of the stress that flows, (yield + H alpha) d alpha
    alpha = np.cumsum(np.abs(np.diff(plastic, prepend=0.0)))*(1 if plane == "stress" else 2/3)
    volume = 0.04*0.01*0.01
    assert got["plastic_dissipation"] == pytest.approx(volume*(YIELD*alpha + HARDENING*alpha**2/2), rel=1e-6, abs=1e-9)
    assert np.all(np.diff(got["plastic_dissipation"]) >= 0)


def flow(stress, alpha, rate):
    """Rates of J2 plasticity in plane strain where the axes of stress stay: of stress 11, 22, 33 and of alpha, by the consistency of the flow."""
    elastic = (KAPPA - 2*MU/3)*np.sum(rate) + 2*MU*rate
    deviator = stress - np.mean(stress)
    size = math.sqrt(np.dot(deviator, deviator))
    if size < math.sqrt(2/3)*(YIELD + HARDENING*alpha)*(1 - 1e-9) or np.dot(deviator, rate) <= 0:
        return elastic, 0.0
    gamma = 2*MU*np.dot(deviator/size, rate)/(2*MU + 2/3*HARDENING)
    return elastic - 2*MU*gamma*deviator/size, math.sqrt(2/3)*gamma


def flowing(ways, steps=4000):
    """Stress and alpha at the corners of a way of strains 11, 22: the differential equations by Heun's rule, what drifts off the yield surface put back."""
    stress, alpha, found = np.zeros(3), 0.0, []
    for way in np.diff(ways, axis=0):
        rate = np.append(way, 0.0)/steps
        for _ in range(steps):
            first = flow(stress, alpha, rate)
            second = flow(stress + first[0], alpha + first[1], rate)
            stress, alpha = stress + (first[0] + second[0])/2, alpha + (first[1] + second[1])/2
            deviator = stress - np.mean(stress)
            radius = math.sqrt(2/3)*(YIELD + HARDENING*alpha)
            stress = stress - max(0.0, 1 - radius/max(math.sqrt(np.dot(deviator, deviator)), radius))*deviator
        found.append([*stress[:2], alpha])
    return np.array(found)


@both_orders
def test_a_block_whose_ends_and_sides_move_by_turns_has_the_stress_of_the_differential_equations(run, cells):
    """The principal directions of stress stay and its way bends."""
    ways = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-0.5, 0.5], [-0.5, -1.0]])*6e-3
    side = """&constraint lower = 0.0, 0.01  upper = 0.04, 0.01  fix = 'y'  displacement = 0.0, 1e-2  name = 'side'
            history = 'table'  times = 0.0, 1.0, 2.0, 3.0, 4.0  factors = """ + ", ".join(str(way) for way in ways[:, 1]) + " /"
    got = run(BAR.format(plane="strain", more=side, steps=800, hardening=HARDENING), *cells, "constraint(4).displacement=4e-2,0",
              "constraint(4).factors=" + ",".join(str(way) for way in ways[:, 0]))
    expected = flowing(ways)
    at = np.searchsorted(got["time"], [1.0 - 1e-9, 2.0 - 1e-9, 3.0 - 1e-9, 4.0 - 1e-9])
    stress = np.array([got["reaction_grip_x"][at]/1e-4, got["reaction_side_y"][at]/4e-4]).T
    print("\nlargest error over the yield stress:", f"{np.max(np.abs(stress - expected[:, :2]))/YIELD:.1e}")
    assert stress == pytest.approx(expected[:, :2], abs=2e-3*YIELD)
    alpha = expected[:, 2]
    assert got["plastic_dissipation"][at] == pytest.approx(0.04*0.01*0.01*(YIELD*alpha + HARDENING*alpha**2/2), rel=2e-3)


BLOCK = STEEL + """  hardening = 1e9 /
&run plane = 'strain'  thickness = 0.01  end_time = 2e-4 /
&grid lower = 0.0, 0.0  cell = 2e-3  cells = 10, 12 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.016, 0.016 /
&constraint lower = 0.0, 0.0  upper = 0.016, 0.0  fix = 'xy' /
&constraint lower = 0.0, 0.016  upper = 0.016, 0.016  fix = 'xy'  displacement = 0.0, 8e-5  history = 'ramp'  rise_time = 2e-4
            name = 'grip' /
"""


def test_quadratic_cells_that_yield_need_no_shared_dilatation(run):
    """A block between plates yields nearly as in bilinear cells of a quarter of the size with it, which those of the same size do not come as
    near to, at rest and in slow motion."""
    at_rest = "method.time=static", "method.load_steps=40"
    fine = run(BLOCK, *at_rest, "material.volumetric=b_bar", "method.frame=total", "grid.cell=5e-4", "grid.cells=40,48")
    coarse = run(BLOCK, *at_rest, *QUADRATIC)
    bilinear = run(BLOCK, *at_rest, "material.volumetric=b_bar", "method.frame=total")
    moved = run(BLOCK, *QUADRATIC, "output.history_interval=1e-5")
    print("\nreaction, dissipation over those of the fine mesh:",
          *(f"{got['reaction_grip_y'][-1]/fine['reaction_grip_y'][-1]:.4f} {got['plastic_dissipation'][-1]/fine['plastic_dissipation'][-1]:.4f}"
            for got in (coarse, moved, bilinear)))
    assert coarse["reaction_grip_y"][-1] == pytest.approx(fine["reaction_grip_y"][-1], rel=0.015)
    assert abs(coarse["reaction_grip_y"][-1] - fine["reaction_grip_y"][-1]) < abs(bilinear["reaction_grip_y"][-1] - fine["reaction_grip_y"][-1])
    assert coarse["plastic_dissipation"][-1] == pytest.approx(fine["plastic_dissipation"][-1], rel=0.01)
    assert moved["plastic_dissipation"][-1] == pytest.approx(coarse["plastic_dissipation"][-1], rel=0.02)


def test_work_at_rest_is_stored_or_dissipated_to_the_second_order_of_the_steps(run):
    losses = []
    for steps in (80, 160, 320, 640):
        got = run(BAR.format(plane="strain", more="", steps=steps, hardening=HARDENING), "constraint(3).history=sine",
                  "constraint(3).frequency=0.21", "constraint(3).times=", "constraint(3).factors=")
        missing = got["external_work"] - got["strain_energy"] - got["plastic_dissipation"]
        assert missing == pytest.approx(got["numerical_loss"], abs=1e-9*got["external_work"][-1])
        losses.append(np.max(np.abs(missing))/np.max(got["external_work"]))
    print("\nwork that is neither stored nor dissipated, over all:", *(f"{loss:.1e}" for loss in losses))
    assert losses[-1] < 1e-4
    assert losses[-1] < losses[0]/8**1.5


def bent(cells, level):
    """Half of the depth of a beam in pure bending: its end planes turn, by a constraint for each row of nodes."""
    depth = 0.01
    cell = depth/cells
    length = 2*cell
    rows = []
    for row in range(1, cells + 1):
        y = row*cell
        rows.append(f"&constraint lower = 0.0, {y}  upper = 0.0, {y}  fix = 'x' /")
        rows.append(f"&constraint lower = {length}, {y}  upper = {length}, {y}  fix = 'x'  name = 'r{row}'  history = 'ramp'\n"
                    f"   rise_time = 1.0  displacement = {level*YIELD/E/depth*length*y}, 0.0 /")
    return STEEL + f""" /
&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {cell}  cells = 4, {cells + 3} /
&body material = 'a'  lower = 0.0, 0.0  upper = {length}, {depth} /
&constraint lower = 0.0, 0.0  upper = {length}, 0.0  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'y' /
{chr(10).join(rows)}
&method time = 'static'  load_steps = 25 /
"""


def test_a_bent_beam_has_the_moment_of_the_elastic_and_plastic_zones(run):
    """M/Me = 1.5 - 0.5 (ke/k)**2 beyond the elastic moment, in plane stress without hardening."""
    cells = 16
    got = run(bent(cells, 5.0))
    depth = 0.01
    moment = 2*sum(got[f"reaction_r{row}_x"]*row*depth/cells for row in range(1, cells + 1))
    elastic = 2*YIELD*0.01*depth**2/3
    curvature = 5.0*got["time"]
    expected = np.where(curvature < 1, curvature, 1.5 - 0.5/np.maximum(curvature, 1)**2)
    print("\nM/Me:", *(f"{k:.1f}: {a/elastic:.4f} ({b:.4f})" for k, a, b in zip(curvature[5::5], moment[5::5], expected[5::5])))
    assert moment/elastic == pytest.approx(expected, rel=0.01, abs=1e-9)


NOTCHED = STEEL + """  volumetric = '{volumetric}' /
&run plane = '{plane}'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {across}, {along} /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.016, 0.032 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.032  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.002, 0.0  fix = 'y' /
&constraint lower = 0.0, 0.032  upper = 0.016, 0.032  fix = 'y'  displacement = 0.0, 4e-4  history = 'ramp'  rise_time = 1.0
            name = 'grip' /
&method time = 'static'  load_steps = 20 /
"""


def limit_load(run, cell, volumetric, *settings):
    """The load at the end over Prandtl's."""
    across, along = round(0.016/cell) + 2, round(0.032/cell) + 2
    got = run(NOTCHED.format(plane="strain", cell=cell, across=across, along=along, volumetric=volumetric), *settings)
    load = got["reaction_grip_y"]/((2 + math.pi)*YIELD/math.sqrt(3)*0.002*0.01)
    print(f"\ncell {cell}, {volumetric}: load over Prandtl's {load[10]:.4f} {load[-1]:.4f}")
    return load


@pytest.mark.verify
def test_a_double_edge_notched_bar_has_the_limit_load_of_prandtl(run):
    """A quarter of it. Cells whose points have a dilatation each never reach a limit load."""
    shared = limit_load(run, 0.5e-3, "b_bar")
    assert shared[-1] == pytest.approx(1.0, abs=0.03)
    assert shared[-1] - shared[-3] < 0.01
    locked = limit_load(run, 0.5e-3, "standard")
    assert locked[-1] > 1.1


# --- viscoelasticity --------------------------------------------------------------------------------------------------

YOUNG, POISSON = 3e9, 0.35
G, K = YOUNG/(2*(1 + POISSON)), YOUNG/(3*(1 - 2*POISSON))
CREEP = """
&material name = 'a'  young = 3e9  poisson = 0.35  density = 1200  law = 'viscoelastic'  moduli = {modulus}  relaxation_times = 1.0 /
&run plane = '{plane}'  thickness = 0.01  end_time = 4.0 /
&grid lower = 0.0, 0.0  cell = 5e-3  cells = 10, 4 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.04, 0.01 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.01  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.04, 0.0  fix = 'y' /
{drive}
&method time = 'static'  load_steps = 80 /
&energy_release energy_balance = .true. /
"""
PULL = "&load kind = 'traction'  lower = 0.04, 0.0  upper = 0.04, 0.01  force = 100.0, 0.0  history = 'step' /"
MODELS = {"Maxwell": G, "standard linear solid": 0.5e9}


@both_orders
@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("model", MODELS)
def test_a_bar_creeps_under_constant_stress(run, model, plane, cells):
    """In shear 2 e = s J(t), J = 1/G + t/(G tau) or 1/Ginf - (1/Ginf - 1/G) exp(-t Ginf/(G tau)); in its volume it is elastic. In plane
    strain the stress across changes with time: by the Laplace transform, inverted numerically (Talbot)."""
    part = MODELS[model]
    got = run(CREEP.format(plane=plane, drive=PULL, modulus=part), *cells)
    t = got["time"]
    rest = G - part
    stress = 1e6
    if plane == "stress":
        compliance = 1/G + t/G if rest < 1e-6*G else 1/rest - (1/rest - 1/G)*np.exp(-t*rest/G)
        expected = stress*(1/(9*K) + compliance/3)
    else:
        expected = np.array([talbot(lambda s: of_plane_strain(s, rest, part)*stress, time) for time in t[1:]])
        t, got = t[1:], {name: values[1:] if name != "warnings" else values for name, values in got.items()}
    work = got["external_work"]
    # a load that comes at once has done half of its work; from there on it follows
    at_once = stress/(YOUNG if plane == "stress" else YOUNG/(1 - POISSON**2))
    measured = (work - 0.5*100*at_once*0.04)/(100*0.04) + at_once
    print(f"\n{model}, plane {plane}: largest relative error of the strain {np.max(np.abs(measured/expected - 1)):.1e}")
    assert measured == pytest.approx(expected, rel=1e-4)
    missing = got["external_work"] - got["strain_energy"] - got["viscous_dissipation"]
    assert np.max(np.abs(missing)) < 3e-4*np.max(got["external_work"])


def of_plane_strain(s, rest, part):
    """Laplace transform of the strain under a unit stress from time 0, by the correspondence principle."""
    shear = rest + part*s/(s + 1)
    young = 9*K*shear/(3*K + shear)
    nu = (3*K - 2*shear)/(2*(3*K + shear))
    return (1 - nu**2)/young/s


def talbot(transform, t, n=32):
    """Inverse of a Laplace transform at a time (Abate & Valko 2004)."""
    k = np.arange(1, n)
    theta = k*np.pi/n
    delta = np.concatenate(([2*n/5], 2*k*np.pi/5*(1/np.tan(theta) + 1j)))
    gamma = np.concatenate(([0.5*np.exp(2*n/5)], (1 + 1j*theta*(1 + (1/np.tan(theta))**2) - 1j/np.tan(theta))*np.exp(delta[1:])))
    return 2/(5*t)*np.sum((gamma*transform(delta/t)).real)


@both_orders
@pytest.mark.parametrize("model", MODELS)
def test_a_bar_relaxes_at_constant_strain(run, model, cells):
    """Uniaxial strain: K + 4/3 G(t)."""
    part = MODELS[model]
    grip = "&constraint lower = 0.04, 0.0  upper = 0.04, 0.01  fix = 'x'  displacement = 4e-4, 0.0  name = 'grip' /\n" + HELD
    got = run(CREEP.format(plane="strain", drive=grip, modulus=part), *cells)
    expected = 0.01*(K + 4/3*(G - part + part*np.exp(-got["time"])))
    stress = got["reaction_grip_x"]/1e-4
    print(f"\n{model}: largest relative error of the stress {np.max(np.abs(stress/expected - 1)):.1e}")
    assert stress == pytest.approx(expected, rel=1e-6)
    stored = got["strain_energy"] + got["viscous_dissipation"]
    assert stored == pytest.approx(np.full(len(stored), stored[0]), rel=1e-9)


# --- motion -----------------------------------------------------------------------------------------------------------

HIT = """
&run plane = 'strain'  thickness = 0.01  end_time = 1e-5 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 64, 3 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.06, 0.002 /
&constraint lower = 0.0, 0.0  upper = 0.06, 0.0  fix = 'y' /
&constraint lower = 0.0, 0.002  upper = 0.06, 0.002  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.002  force = {force}, 0.0{rise} /
&method courant = 0.4 /
&energy_release energy_balance = .true. /
&output history_interval = 2e-7 snapshot_interval = 8e-6 /
"""


@pytest.mark.parametrize("frame, pressure, cells", [("total", 1000e6, ("grid.cell=5e-4", "grid.cells=124,5")), ("updated", 700e6, ()), ("total", 1000e6, (*QUADRATIC, "method.courant=0.15"))],
                         ids=["total", "updated", "quadratic"])
def test_waves_of_yielding_material_are_slower(run, tmp_path, frame, pressure, cells):
    """A pressure that comes in a short time, in uniaxial strain and with Poisson's ratio 0: an elastic wave that yields, and behind it a plastic one of the speed
    sqrt((kappa + 4/3 mu h/(3 mu + h))/rho). Material moves by what each of them brings, stress over density and speed."""
    hardening, mu, kappa = 20e9, E/2, E/3
    run(STEEL + f" hardening = {hardening} /" + HIT.format(force=pressure*2e-5, rise="  history = 'ramp'  rise_time = 1.5e-6"),
        f"method.frame={frame}", "material.poisson=0", *cells)
    fast = math.sqrt(E/7800)
    slow = math.sqrt((kappa + 4*mu/3*hardening/(3*mu + hardening))/7800)
    yields = YIELD
    step = read_steps(tmp_path / "case.h5")[1][1][0]
    x, stress, velocity = points(step)[:, 0], -field(step.point_data, "stress_xx"), field(step.point_data, "velocity")[:, 0]
    near = (x > 0.004) & (x < 0.6*slow*8e-6)
    between = (x > 1.1*slow*8e-6) & (x < 0.95*fast*6.5e-6)
    speeds = yields/(7800*fast) + (pressure - yields)/(7800*slow), yields/(7800*fast)
    ratios = [np.mean(stress[near])/pressure, np.mean(stress[between])/yields, np.mean(velocity[near])/speeds[0],
              np.mean(velocity[between])/speeds[1]]
    print(f"\n{frame}: stress and velocity over those of the closed forms", *(f"{ratio:.4f}" for ratio in ratios))
    assert ratios == pytest.approx([1, 1, 1, 1], abs=0.03 if frame == "total" else 0.05)  # coarser cells


@pytest.mark.parametrize("settings", [(), *((*QUADRATIC, f"method.mass={mass}") for mass in ("lumped", "consistent", "weighted", "fmpm"))],
                         ids=lambda settings: " ".join(settings[-1:]) or "bilinear")
def test_what_steps_miss_of_the_energy_falls_faster_than_they(run, settings):
    """The audit books the work of the stress by the rule of trapezoids, and what flows by (yield + H alpha) d alpha."""
    missing = []
    for courant in (0.06, 0.015) if settings else (0.4, 0.1):
        got = run(STEEL + " hardening = 20e9 /" + HIT.format(force=3e4, rise="  history = 'ramp'  rise_time = 8e-6"),
                  f"method.courant={courant}", *settings)
        left = (got["external_work"] - got["kinetic_energy"] - got["strain_energy"] - got["plastic_dissipation"]
                - got["numerical_loss"])
        missing.append(np.max(np.abs(left))/got["external_work"][-1])
    print("\nenergy that is missing, over all:", *(f"{part:.1e}" for part in missing))
    assert missing[0] < 1e-4
    assert missing[1] < missing[0]/8


@pytest.mark.parametrize("settings", [(), ("method.time=static", "method.load_steps=24"), QUADRATIC], ids=["motion", "rest", "quadratic"])
@pytest.mark.parametrize("law", ["j2_plastic", "viscoelastic"])
def test_results_have_the_same_bytes_on_any_number_of_threads(run, tmp_path, law, settings):
    scene = TENSION[law]
    run(scene, *settings, name="one", words=("--threads", 1))
    run(scene, *settings, name="two", words=("--threads", 2))
    assert differing(tmp_path / "one.h5", tmp_path / "two.h5") == []


LAWS = {"j2_plastic": STEEL + "  hardening = 1e9 /",
        "viscoelastic": "&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800  law = 'viscoelastic'\n"
                        "   moduli = 20e9, 30e9  relaxation_times = 1e-6, 1e-5 /"}
TENSION = {law: material + """
&run plane = 'strain'  thickness = 0.01  end_time = 2e-5 /
&grid lower = 0.0, -0.02  cell = 2e-3  cells = 18, 22 /
&body material = 'a'  lower = 0.0, -0.016  upper = 0.032, 0.016 /
&constraint lower = 0.0, -0.016  upper = 0.032, -0.016  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.016  upper = 0.032, 0.016  force = 0.0, 6.4e4  history = 'ramp'  rise_time = 1.6e-5 /
&constraint lower = 0.0, -0.016  upper = 0.0, -0.016  fix = 'x' /
&crack kind = 'line'  tip = 0.012, 0.0 /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = 4e-3, 6e-3, 9e-3 /
&output history_interval = 2e-6  snapshot_interval = 1e-5 /
""" for law, material in LAWS.items()}


@pytest.mark.parametrize("law", LAWS)
def test_at_a_crack_in_yielding_material_there_is_j_of_each_domain_and_no_k(run, law):
    got = run(TENSION[law], "method.time=static", "method.load_steps=10")
    assert "J depends on its domain" in got["warnings"]
    assert {"J", "J_domain_dependence", "J_near_tip", "J_far_field", "J_1", "J_2", "J_3"} <= got.keys()
    assert not [name for name in got if name.startswith(("K_", "G", "mode")) or name.endswith("_error")]
    assert got["J_near_tip"] == pytest.approx(got["J_1"]) and got["J_far_field"] == pytest.approx(got["J_3"])


def test_j_of_yielding_material_is_the_elastic_one_while_it_is_elastic_and_then_more(run):
    """Far from a small yielded zone J is that of the elastic material of the same displacement, as in small-scale yielding."""
    elastic = run(TENSION["j2_plastic"], "method.time=static", "method.load_steps=10", "material.yield_stress=1e15")
    yielding = run(TENSION["j2_plastic"], "method.time=static", "method.load_steps=10")
    print("\nfar-field J over the elastic one:", *(f"{a/b:.3f}" for a, b in zip(yielding["J_far_field"][1:], elastic["J"][1:])))
    print("near-tip J over the far-field one:",
          *(f"{a/b:.3f}" for a, b in zip(yielding["J_near_tip"][1:], yielding["J_far_field"][1:])))
    assert yielding["J_far_field"][1] == pytest.approx(elastic["J_far_field"][1], rel=0.02)
    assert np.max(elastic["J_domain_dependence"]/np.maximum(elastic["J"], 1e-9)) < 0.05


@both_orders
def test_cells_that_refine_and_coarsen_keep_what_they_remember(run, cells):
    """What recombining changes is booked as a loss of the method; quadratic cells only refine."""
    scene = LAWS["j2_plastic"] + """
&run plane = 'strain'  thickness = 0.01  end_time = 2e-5 /
&grid lower = 0.0, 0.0  cell = 2e-3  cells = 10, 10 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.016, 0.016 /
&constraint lower = 0.0, 0.0  upper = 0.016, 0.0  fix = 'y' /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.016  fix = 'x' /
&load kind = 'traction'  lower = 0.0, 0.016  upper = 0.008, 0.016  force = 0.0, 8e4  history = 'ramp'  rise_time = 1.6e-5 /
&energy_release energy_balance = .true. /
&output history_interval = 1e-6 /
&refine indicator = 'zz'  tolerance = 0.02  max_level = 2  interval = 20 /
"""
    got = run(scene, *cells)
    assert got["finest_cell"].min() < 2e-3
    left = (got["external_work"] - got["kinetic_energy"] - got["strain_energy"] - got["plastic_dissipation"] - got["numerical_loss"])
    print(f"\ncells {got['cells'].min()} to {got['cells'].max()}; energy that is missing: {np.max(np.abs(left))/got['external_work'][-1]:.1e}")
    assert np.max(np.abs(left)) < (1e-4 if cells else 2e-3)*np.max(got["external_work"])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("settings", [(), ("method.frame=updated", "method.mass=consistent"), ("refine.indicator=tip", "refine.max_level=1"),
                                      ("method.time=static", "method.load_steps=30"),
                                      ("material.volumetric=b_bar", "energy_release.estimators=domain_integral"),
                                      (*QUADRATIC, "method.mass=consistent"), (*QUADRATIC, "method.time=static", "method.load_steps=30")],
                         ids=["motion", "updated", "refined", "rest", "shared dilatation", "quadratic", "quadratic at rest"])
def test_a_resumed_run_has_the_bytes_of_an_unbroken_one(hampm, tmp_path, law, settings):
    (tmp_path / "case.nml").write_text(TENSION[law])
    words = [word for setting in settings for word in ("--set", setting)]
    assert hampm("case.nml", "--quiet", "--output", "unbroken", *words).returncode == 0
    result = hampm("case.nml", "--quiet", "--threads", 2, *words, "--steps", 7)
    assert result.returncode == 5, result.stderr
    result = hampm("--resume", "case.h5.checkpoint", "--quiet", "--steps", 5, "--threads", 1)
    assert result.returncode == 5, result.stderr
    assert hampm("--resume", "case.h5.checkpoint", "--quiet").returncode == 0
    assert differing(tmp_path / "unbroken/case.h5", tmp_path / "case.h5") == []


def test_the_snapshot_has_the_equivalent_plastic_strain(run, tmp_path):
    run(TENSION["j2_plastic"], "method.time=static", "method.load_steps=10")
    strain = field(read_steps(tmp_path / "case.h5")[1][-1][0].point_data, "plastic_strain")
    assert strain.max() > 1e-3 and strain.min() >= 0


@pytest.mark.skipif(not CHECKED_PROGRAM.exists() or PROGRAM == CHECKED_PROGRAM, reason="there is no checked build")
@pytest.mark.parametrize("law", LAWS)
def test_checked_and_release_agree(hampm, run, tmp_path, law):
    (tmp_path / "checked.nml").write_text(TENSION[law])
    words = "--set", "run.end_time=4e-6", "--set", "output.snapshot_interval=0", "--set", "material.volumetric=b_bar", "--set", "energy_release.estimators=domain_integral"
    assert hampm("checked.nml", "--quiet", *words, program=CHECKED_PROGRAM).returncode == 0
    got = run(TENSION[law], "run.end_time=4e-6", "output.snapshot_interval=0", "material.volumetric=b_bar", "energy_release.estimators=domain_integral")
    with h5py.File(tmp_path / "checked.h5") as file:
        for name in ("strain_energy", "J", "external_work"):
            assert got[name] == pytest.approx(file[f"history/{name}"][:], rel=1e-9, abs=1e-12)


YIELDING = """
&run end_time = 1.0 plane = 'strain' thickness = 1.0 /
&grid lower = 0, 0 cell = 0.01 cells = 10, 10 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 {law} /
&body material = 'a' lower = 0, 0 upper = 0.1, 0.1 /
&crack kind = 'symmetry' tip = 0.04, 0 /
&constraint lower = 0.04, 0 upper = 0.1, 0 fix = 'y' /
&constraint lower = 0.1, 0 upper = 0.1, 0 fix = 'x' /
&load kind = 'traction' lower = 0, 0.1 upper = 0.1, 0.1 force = 0, 4e6 history = 'ramp' rise_time = 1.0 /
&refine indicator = 'zz' max_level = 2 tolerance = 0.03 /
&energy_release estimators = 'domain_integral' radii = 0.02, 0.03 /
&method time = 'static' load_steps = 5 /
"""


@pytest.mark.parametrize("law, column", [
    ("law = 'j2_plastic' yield_stress = 2e8 hardening = 1e9 volumetric = 'b_bar'", "plastic_dissipation"),
    ("law = 'viscoelastic' moduli = 5e9, 1e10 relaxation_times = 0.1, 1.0", "viscous_dissipation")])
def test_cells_refine_at_rest_and_carry_what_particles_remember(hampm, tmp_path, law, column):
    """Solve, estimate, refine, and go on from there: what is dissipated and J come to those on cells as fine everywhere."""
    found = []
    (tmp_path / "case.nml").write_text(YIELDING.format(law=law))
    for settings in ((), ("refine.indicator=none", "grid.cell=0.0025", "grid.cells=40,40"), ("refine.indicator=none",)):
        result = hampm("case.nml", "--quiet", "--force", *(word for one in settings for word in ("--set", one)))
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / "case.h5") as file:
            found.append({name: values[-1] for name, values in file["history"].items()})
    refined, fine, coarse = found
    assert refined["particles"] < 0.3 * fine["particles"]
    for name, most in (column, 0.01), ("J", 0.01), ("strain_energy", 0.01):
        assert refined[name] == pytest.approx(fine[name], rel=most)
        assert abs(refined[name] - fine[name]) < 0.5 * abs(coarse[name] - fine[name])


def test_cells_that_refine_as_a_bar_is_let_go_forget_no_plastic_strain(run):
    """A bar that has yielded shrinks by twice what half of the load, under which it was elastic, had stretched it."""
    row = run("""
&run plane = 'strain' end_time = 4.0 /
&grid lower = 0.0, 0.0 cell = 0.1 cells = 20, 5 /
&material name = 'a' law = 'j2_plastic' volumetric = 'b_bar' young = 200e9 poisson = 0.3 density = 7800 yield_stress = 200e6 hardening = 2e9 /
&body material = 'a' lower = 0.0, 0.0 upper = 1.8, 0.5 /
&constraint lower = 0.0, 0.0 upper = 0.0, 0.5 fix = 'xy' /
&constraint lower = 1.8, 0.0 upper = 1.8, 0.5 fix = 'y' /
&load kind = 'traction' lower = 1.8, 0.0 upper = 1.8, 0.5 force = 130e6, 0.0 history = 'table' times = 0.0, 2.0, 4.0 factors = 0.0, 1.0, 0.0 /
&method time = 'static' load_steps = 4 /
&refine indicator = 'gradient' field = 'energy_density' r_crit = 0.05 max_level = 1 /
&probe name = 'end' quantity = 'displacement' at = 1.8, 0.25 /
""")
    u, cells = row["displacement_end_x"], row["cells"]
    assert cells[3] > cells[2] and u[2] > 10 * u[1]
    assert u[2] - u[4] == pytest.approx(2 * u[1], rel=0.01)
