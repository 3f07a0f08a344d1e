"""Growth in time at rest: lives and ways against closed integrations of Charles' law and of a toughness that depends on the speed, loads that vary, the same in motion."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from harness import run

YOUNG, WIDTH, START, BREAKS = 70e9, 40e-3, 6e-3, 16e-3


def intensity(a):
    """K over stress of a crack of half length a in the middle of a plate (Tada, Paris & Irwin, to 0.1 %)."""
    part = a / WIDTH
    return np.sqrt(np.pi * a / np.cos(np.pi * part / 2)) * (1 - 0.025 * part**2 + 0.06 * part**4)


def plate(growth, end, steps=10, load="", stress=10e6, more=""):
    """A quarter of the plate, under a stress."""
    return f"""&run plane = 'stress'  thickness = 1e-2  end_time = {end} /
&grid lower = 0, 0  cell = 1e-3  cells = 40, 100 /
&material name = 'g'  young = {YOUNG}  poisson = 0.22  density = 2500 /
&body material = 'g'  lower = 0, 0  upper = {WIDTH}, 0.1 /
&load kind = 'traction'  lower = 0, 0.1  upper = {WIDTH}, 0.1  force = 0, {stress * WIDTH * 1e-2}  {load} /
&constraint lower = 0, 0  upper = 0, 0.1  fix = 'x' /
&constraint lower = {START}, 0  upper = {WIDTH}, 0  fix = 'y' /
&crack kind = 'symmetry'  tip = {START}, 0 /
&growth law = 'subcritical'  direction = 'straight'  increment = 1e-3  {growth} /
&method time = 'static'  load_steps = {steps} /
&refine indicator = 'tip'  max_level = 2  rings = 8 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
{more}"""


def charles(exponent, critical, speed=1e-3):
    return f"rate = 'charles'  speed = {speed}  rate_exponent = {exponent}  toughness = {critical**2 / YOUNG}"


def time_to(a, exponent, critical, speed=1e-3, stress=10e6):
    return quad(lambda s: (critical / stress / intensity(s))**exponent / speed, START, a, epsrel=1e-10)[0]


def check_times(row, asked):
    """The times of all rows, within what they say of their errors."""
    off = row["time"] - asked
    print("times off by", np.max(np.abs(off)) / asked[-1], "estimate", row["time_error"][-1] / asked[-1])
    assert np.all(np.abs(off) <= row["time_error"] + row["crack_length_error"] / np.maximum(row["tip_speed"], 1e-300) + 1e-12 * asked[-1])


@pytest.mark.parametrize("exponent", [5, 20])
def test_life_by_charles(hampm, exponent):
    """The life of a plate under a constant stress, to where K is that of its toughness: the integral of da/v."""
    critical = 10e6 * intensity(BREAKS)
    asked = time_to(BREAKS, exponent, critical)
    row = run(hampm, plate(charles(exponent, critical), 3 * asked))
    print("life off by", row["life"] / asked - 1, "estimate", row["life_error"] / asked)
    assert abs(row["life"] - asked) < row["life_error"] and abs(row["life"] / asked - 1) < 0.004 * exponent / 3
    check_times(row, np.array([time_to(a, exponent, critical) for a in row["crack_length"]]))
    assert "fracture at t = " in row.said and "load_factor" not in row
    assert row["tip_speed"] == pytest.approx(1e-3 * (row["G"] / row["toughness"])**(exponent / 2), rel=1e-9)


def test_strength_at_a_rate_of_stress(hampm):
    """Under a stress that rises with time the crack breaks later the faster it rises: dynamic fatigue, d(strength)/d(rate) = strength/((n + 1) rate)."""
    exponent, critical = 12, 10e6 * intensity(BREAKS)
    strength = []
    for name, end in (("slow", 4e5), ("fast", 4e3)):
        row = run(hampm, plate(charles(exponent, critical), end, steps=40, load=f"history = 'ramp'  rise_time = {end}", stress=30e6), name=name)
        until = solve_ivp(lambda t, a, end=end: [1e-3 * (30e6 * t / end * intensity(a[0]) / critical)**exponent], (0, end), [START], rtol=1e-10, atol=1e-14,
                          events=[breaks := lambda t, a, end=end: 30e6 * t / end * intensity(a[0]) - critical], dense_output=True)
        asked = until.t_events[0][0]
        there = until.sol(np.minimum(row["time"], asked))[0]
        print(name, "breaks at", row["life"] / end, "asked", asked / end, "error", row["life_error"] / end, "ways off by", np.max(np.abs(row["crack_length"] - there)))
        assert row["life"] == pytest.approx(asked, rel=0.004)
        assert np.all(np.abs(row["crack_length"] - there) < row["crack_length_error"] + 2e-5)
        strength.append(30e6 * row["life"] / end)
    assert strength[1] / strength[0] == pytest.approx(100**(1 / (exponent + 1)), rel=0.02)


def beam(time, growth, steps=8, cell=1e-3, end=4e-4):
    """A double cantilever beam that is opened by 1.78 mm at first."""
    n = round(1e-3 / cell)
    return f"""&run plane = 'stress'  thickness = 0.01  end_time = {end} /
&grid lower = -0.002, -0.012  cell = {cell}  cells = {124 * n}, {24 * n} /
&material name = 'm'  young = 3.2e9  poisson = 0.35  density = 1180.0 /
&body material = 'm'  lower = 0, -0.01  upper = 0.12, 0.01 /
&constraint lower = 0, 0.005  upper = 0, 0.01  fix = 'y'  displacement = 0, 0.89e-3 /
&constraint lower = 0, -0.01  upper = 0, -0.005  fix = 'y'  displacement = 0, -0.89e-3 /
&constraint lower = 0.12, 0  upper = 0.12, 0  fix = 'xy' /
&method {time} /
&crack kind = 'path'  points = -0.001, 0, 0.04, 0 /
&growth toughness = 200.0  direction = 'straight'  {growth} /
&energy_release estimators = 'domain_integral' /
&output history_interval = {end / steps}  file = 'out.h5' /
"""


def test_creeps_as_in_motion(hampm):
    """A crack that creeps at 10 m/s under a given opening, far below the speed of waves: explicit steps go the same way, at a hundred times the cost, and G is the
    toughness of the speed."""
    law = "limit_speed = 20.0"
    still = run(hampm, beam("time = 'static'  load_steps = 8", f"law = 'subcritical'  rate = 'toughness'  increment = 2e-3  {law}"), name="still")
    moves = run(hampm, beam("time = 'explicit'  start = 'static'  mass = 'weighted'", f"law = 'toughness'  {law}"), name="moves")
    way = np.interp(still["time"], moves["time"], moves["crack_length"])
    print("at rest", still["crack_length"], "in motion", way, "estimate", still["crack_length_error"])
    assert still["crack_length"][-1] > 42.5e-3 and np.all(np.abs(still["crack_length"] - way) < still["crack_length_error"] + 5e-5)
    assert still["G"] == pytest.approx(200 / (1 - still["tip_speed"] / 20), rel=1e-6)


def test_tables_of_the_toughness(hampm):
    """A table of speeds is the law that it is taken from; the crack stops creeping at the toughness at rest, and breaks beyond the end of the table."""
    speeds = np.linspace(0, 15, 61)
    table = f"speeds = {', '.join(f'{v}' for v in speeds)}  speed_factors = {', '.join(f'{1 / (1 - v / 20)}' for v in speeds)}"
    static = "time = 'static'  load_steps = 8"
    law = run(hampm, beam(static, "law = 'subcritical'  rate = 'toughness'  increment = 2e-3  limit_speed = 20.0"), name="law")
    same = run(hampm, beam(static, f"law = 'subcritical'  rate = 'toughness'  increment = 2e-3  {table}"), name="table")
    assert same["crack_length"] == pytest.approx(law["crack_length"], abs=2e-6)
    late = run(hampm, beam("time = 'static'  load_steps = 40", "law = 'subcritical'  rate = 'toughness'  increment = 2e-3  limit_speed = 20.0", end=8e-3), name="late")
    assert late["G"][-1] == pytest.approx(200, rel=0.01) and late["tip_speed"][-1] < 0.2
    breaks = run(hampm, beam(static, "law = 'subcritical'  rate = 'toughness'  increment = 2e-3  speeds = 0, 2  speed_factors = 1.0, 1.5"), name="breaks")
    assert breaks["life"] == 0 and "fracture at t = 0" in breaks.said


def test_tips_have_speeds_of_their_own(hampm):
    """A crack nearer to one side: both tips are where the integration of their speeds has them, with K of the run; increments of half the size change nothing."""
    def scene(increment):
        return f"""&run plane = 'stress'  thickness = 1e-2  end_time = 2000 /
&grid lower = -0.03, -0.06  cell = 1e-3  cells = 80, 120 /
&material name = 'g'  young = {YOUNG}  poisson = 0.22  density = 2500 /
&body material = 'g'  lower = -0.03, -0.06  upper = 0.05, 0.06 /
&load kind = 'traction'  lower = -0.03, 0.06  upper = 0.05, 0.06  force = 0, 8e3 /
&load kind = 'traction'  lower = -0.03, -0.06  upper = 0.05, -0.06  force = 0, -8e3 /
&constraint lower = 0.05, 0  upper = 0.05, 0  fix = 'xy' /
&constraint lower = 0.05, 0.06  upper = 0.05, 0.06  fix = 'x' /
&crack kind = 'path'  points = -0.008, 0, 0.008, 0 /
&growth law = 'subcritical'  direction = 'straight'  increment = {increment}  {charles(8, 3e6, 1e-4)} /
&method time = 'static'  load_steps = 5 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
    coarse, fine = (run(hampm, scene(h), name=f"h{h}") for h in (2e-3, 4e-3))
    for tip in ("", "_tip2"):
        assert np.interp(coarse["time"][-1], fine["time"], fine["tip_x" + tip]) == pytest.approx(coarse["tip_x" + tip][-1], abs=2e-4)
        gone = np.abs(coarse["tip_x" + tip] - coarse["tip_x" + tip][0])
        speed = coarse["tip_speed" + tip]
        way = np.sum((speed[1:] - speed[:-1]) / np.log(speed[1:] / speed[:-1]) * np.diff(coarse["time"]))
        assert gone[-1] == pytest.approx(way, rel=0.02)
    assert coarse["tip_speed_tip2"][-1] > 1.1 * coarse["tip_speed"][-1]  # at the left


@pytest.mark.parametrize(("growth", "message"), [
    ("rate = 'toughness'  toughness = 1.0", "limit_speed"), ("toughness = 1.0", "charles"), ("rate = 'charles'  toughness = 1.0", "speed"),
    ("rate = 'toughness'  toughness = 1.0  speeds = 0, 1, 2  speed_factors = 1, 2, 1.5", "must ascend at rest"),
    ("rate = 'toughness'  toughness = 1.0  limit_speed = 1.0  threshold = 1e6", "threshold")])
def test_what_is_no_law_of_time(hampm, growth, message):
    assert message in run(hampm, plate(growth, 1.0), code=2)
