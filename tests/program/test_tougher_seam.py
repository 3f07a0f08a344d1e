"""Where a crack comes to a tougher body of the same material it rests at the seam, at rest, in cycles, in time and in motion, tips of the plane and fronts of solids, until the load is that at which
G is the toughness of the other: in a long strip between grips G = E_1 u**2/h, with the modulus of strain across alone and u the displacement of each grip (Nilsson 1974)."""

import numpy as np
import pytest

from harness import run

H, HALF, SEAM, FIRST = 1e-3, 8e-3, 1.3e-3, -6e-3            # cells, half height, the seam off the lattice, the tip at the start
RATE = 200e9 * 0.7 / (1.3 * 0.4) * 1e-12 / HALF             # J/m2, of a load factor of 1
WEAK, TOUGH = 10.0, 30.0
DRIVES = {"load": ("law = 'quasi_static'  increment = 2e-3", ""),
          "frame": ("law = 'quasi_static'  increment = 2e-3", "&control quantity = 'displacement'  displacement = 2e-6  history = 'table'  times = 0.0, 1.0  factors = 0.5, 1.0 /"),
          "cycles": ("law = 'fatigue'  rate_constant = 1e-27  rate_exponent = 3.0  increment = 2e-3", "&cycles ratio = 0.1 /"),
          "time": ("law = 'subcritical'  rate = 'charles'  speed = {speed}  rate_exponent = 8.0  increment = 2e-3", ""),
          "motion": ("law = 'toughness'", "")}


def strip(solid, drive, toughness=(WEAK, TOUGH), steps=10, pull=1e-6, end=1.0, speed=1.0, tip=FIRST):
    across = lambda x0, y0, x1, y1: f"lower = {x0}, {y0}" + ", 0.0" * solid + f"  upper = {x1}, {y1}" + f", {H}" * solid
    growth, more = DRIVES[drive]
    sides = "\n".join(f"&constraint lower = -20e-3, -8e-3, {z}  upper = 20e-3, 8e-3, {z}  fix = 'z' /" for z in (0.0, H)) if solid else ""
    method = "start = 'static'  mass = 'weighted'  courant = 0.35" if drive == "motion" else f"time = 'static'  load_steps = {steps}"
    grips = "\n".join(f"&constraint {across(-20e-3, y, 20e-3, y)}  fix = 'xy'  displacement = 0.0, {np.sign(y) * pull}{', 0.0' * solid} /" for y in (HALF, -HALF))
    return f"""&run end_time = {end} {'' if solid else f" plane = 'strain'  thickness = {H}"} /
&grid lower = -20e-3, -9e-3{", 0.0" * solid}  cell = {H}  cells = 40, 18{", 1" * solid} /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 5000 /
&body material = 'a'  {across(-20e-3, -HALF, SEAM, HALF)}  toughness = {toughness[0]} /
&body material = 'a'  {across(SEAM, -HALF, 20e-3, HALF)}  toughness = {toughness[1]} /
{grips}
{sides}
&crack kind = 'plane'  normal = 'y'  tip = {tip}, 0.0{f", {H / 2}" * solid}  direction = 1.0, 0.0{", 0.0" * solid} /
&growth {growth.format(speed=speed)}  toughness = {WEAK}  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
{more}
&method {method} /
&output {f'history_interval = {end / 40}' if drive == "motion" else ''} /
"""


@pytest.fixture
def grow(either):
    """Runs a strip: its row, with the place of the crack's end as `place` [m] and G as `rate` [J/m2]."""
    program, solid = either

    def of(*arguments, **options):
        row = run(program, strip(solid, *arguments, **options))
        row["place"] = row["crack_area"] / H - 20e-3 if solid else row["tip_x"]
        row["rate"] = row["G_mean" if solid else "G"]
        return row
    return of


def test_it_rests_in_a_load_frame_until_the_load_of_theory(grow):
    """Tips rested a cell before the seam. G of a frame is that of the strip; what faces take is their toughness times their area; it goes on at sqrt(30/33.65) = 0.944."""
    row = grow("frame", steps=20)
    factor, place = row["load_factor"], row["place"]
    print(factor, place, row["rate"] / (RATE * factor**2), row["fracture_energy"][-1])
    rests = (factor > 0.61) & (factor < 0.99 * np.sqrt(TOUGH / RATE))
    assert np.count_nonzero(rests) > 8 and place[rests] == pytest.approx(SEAM, abs=1e-6 * H)
    assert row["rate"][rests] == pytest.approx(RATE * factor[rests] ** 2, rel=0.05)  # cells of an eighth of the half height
    assert row["fracture_energy"][rests] == pytest.approx(WEAK * (SEAM - FIRST) * H, rel=0.03)
    assert np.all(place[factor > 1.03 * np.sqrt(TOUGH / RATE)] > SEAM + H)


def test_the_load_rises_at_the_seam(grow):
    """By the root of the ratio of both toughnesses, and what faces take before is the lesser one."""
    row = grow("load", steps=8)
    at = np.flatnonzero(np.abs(row["place"] - SEAM) < 1e-6 * H)
    print(row["place"], row["load_factor"])
    assert at.size == 1
    load = row["load_factor"][at[0] - 1:at[0] + 2]
    assert load == pytest.approx(np.sqrt(np.array([WEAK, TOUGH, TOUGH]) / RATE), rel=0.03) and load[1] / load[0] == pytest.approx(np.sqrt(TOUGH / WEAK), rel=0.025)  # a tip at a node, and one in its cell
    assert row["fracture_energy"][at[0]:at[0] + 2] / H == pytest.approx(WEAK * (SEAM - FIRST) + np.array([0, TOUGH * 2e-3]), rel=0.01)


def test_a_weaker_body_breaks_at_the_seam_in_cycles(grow):
    """The toughness of the other is below the largest G of the cycles: the life ends there, not a cell before."""
    row = grow("cycles", toughness=(200.0, 20.0), steps=20)
    print(row["place"], row.said)
    assert "fracture after" in row.said and row["place"][-1] == pytest.approx(SEAM, abs=1e-6 * H)
    assert row["rate"][-1] == pytest.approx(RATE, rel=0.05)


def test_the_speed_in_time_changes_at_the_seam(grow):
    """v (K/K_c)**8 with K_c of the body that it is in: in a body of twice the toughness a way takes 16 times the time. Where both lines of the place over time meet is the seam."""
    row = grow("time", toughness=(100.0, 200.0), steps=60, end=30.0, speed=1e-3 * (100.0 / RATE) ** 4)
    time, place = row["time"], row["place"]
    before, after = ((place > -3e-3) & (place < 0.9e-3)), (place > 1.35e-3) & (place < 2e-3)
    (fast, at_once), (slow, later) = (np.polyfit(time[some], place[some], 1) for some in (before, after))
    meet = (later - at_once) / (fast - slow)
    print(fast, slow, fast * meet + at_once)
    assert fast == pytest.approx(1e-3, rel=0.2) and slow / fast == pytest.approx(1 / 16, rel=0.08)  # of G**4
    assert fast * meet + at_once == pytest.approx(SEAM, abs=0.03 * H)


def test_it_rests_in_motion(grow):
    """G of the strip at rest is 20; the tip runs at half of the speed of Rayleigh waves, as G = (1 - v/c_R) 20 is 10, and is at the seam before waves come back from the grips."""
    row = grow("motion", toughness=(WEAK, 60.0), pull=np.sqrt(20.0 / RATE) * 1e-6, end=16e-6, tip=-2e-3)
    print(row["place"])
    assert row["place"][row["time"] > 12e-6] == pytest.approx(SEAM, abs=0.3 * H)
    assert np.ptp(row["place"][row["time"] > 12e-6]) == 0
