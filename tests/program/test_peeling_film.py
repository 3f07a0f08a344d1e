"""A film that peels off a substrate as both are heated: growth at rest that scales eigenstrains.

A strip of film has the energy of a misfit, and gives it away as it comes off. Where both layers stay plane and are free along x, with E' = E/(1 - nu**2) and the misfit
m = (1 + nu_1) e_1 - (1 + nu_2) e_2 of free strains in plane strain,

    G = k m**2/2,   k = E'_1 h E'_2 H/(E'_1 h + E'_2 H),

whatever the length; on a thick substrate that does not strain E'_1 h m**2/2, which is (1 - nu**2) sigma**2 h/(2 E) with the stress sigma = E e/(1 - nu) of the film (Hutchinson & Suo 1991).
"""

import numpy as np
import pytest

from harness import datasets, run
from paths import INPUT

H, DEPTH, TOUGHNESS = 1e-6, 10e-6, 2.0
MODULI = 200e9 / (1 - 0.25**2), 100e9 / (1 - 0.3**2)
MISFIT = 1.25 * 0.5e-3 - 1.3 * 1.5e-3


def plane():
    """G at the load factor 1 of layers that stay plane."""
    film, base = MODULI[0] * H, MODULI[1] * DEPTH
    return film * base / (film + base) * MISFIT**2 / 2


def bent():
    """The same of layers that are free to bend: the energy of int E' (e + k y - misfit)**2/2 dy at its least."""
    (e1, e2), moments = MODULI, np.zeros((2, 2))
    force = np.zeros(2)
    for modulus, low, high, free in ((e2, 0.0, DEPTH, 0.0), (e1, DEPTH, DEPTH + H, MISFIT)):
        n = [(high**k - low**k) / k for k in (1, 2, 3)]
        moments += modulus * np.array([[n[0], n[1]], [n[1], n[2]]])
        force += modulus * free * np.array([n[0], n[1]])
    return (e1 * H * MISFIT**2 - force @ np.linalg.solve(moments, force)) / 2


def film(**changes):
    """The scene in input/, with its steps in larger cells where nothing else is said."""
    text = (INPUT / "peeling_film.nml").read_text()
    for old, new in changes.get("replace", ()):
        assert old in text, old
        text = text.replace(old, new)
    return text


def check_energy(row, part):
    """What heating gives is stored or taken by the new faces, per increment once the end of the film is far."""
    missing = np.diff(row["external_work"] - row["strain_energy"] - row["fracture_energy"]) / np.diff(row["fracture_energy"])
    print("missing of the toughness in each increment", missing)
    assert np.all(np.abs(missing[3:]) < part)
    taken = sum(row[name] for name in ("strain_energy", "fracture_energy", "numerical_loss", "friction_loss") if name in row)
    closed = row["external_work"] - taken
    assert np.max(np.abs(closed - closed[0])) < 1e-9 * row["strain_energy"][0]


def test_temperature_at_which_a_film_peels(hampm):
    """The load factor comes to sqrt(toughness/G(1)); a film without misfit in its first increments needs more."""
    row = run(hampm, film())
    asked = np.sqrt(TOUGHNESS / plane())
    print("load factor over that of the steady state", row["load_factor"] / asked)
    assert row["G"] == pytest.approx(TOUGHNESS, rel=1e-6)
    assert np.all(np.diff(row["load_factor"]) < 0)
    assert row["load_factor"][-1] == pytest.approx(asked, rel=2e-3)
    assert row["J_domain_dependence"][-1] < 2e-3
    check_energy(row, 5e-3)


COARSE = [("cell = 0.25e-6", "cell = 0.5e-6"), ("cells = 168, 52", "cells = 84, 26"), ("increment = 1.0e-6", "increment = 2.0e-6"), ("load_steps = 12", "load_steps = 8"),
          ("end_time = 12.0", "end_time = 8.0")]
BENT = [("lower = 0.0, 0.0\n   upper = 40.0e-6, 0.0\n   fix = 'y'", "lower = 40.0e-6, 0.0\n   upper = 40.0e-6, 0.0\n   fix = 'y'")]
COLD = [("0.5e-3, 0.5e-3, 0.0, 0.5e-3", "-0.5e-3, -0.5e-3, 0.0, -0.5e-3"), ("1.5e-3, 1.5e-3, 0.0, 1.5e-3", "-1.5e-3, -1.5e-3, 0.0, -1.5e-3"),
        ("points = -1.0e-6, 10.0e-6, 1.0e-6, 10.0e-6", "points = -1.0e-6, 10.0e-6, 1.0e-6, 10.0e-6  contact = 'frictionless'")]


def test_a_substrate_that_bends(hampm):
    row = run(hampm, film(replace=COARSE + BENT))
    asked = np.sqrt(TOUGHNESS / bent())
    print("load factor", row["load_factor"][-1], asked, "plane", np.sqrt(TOUGHNESS / plane()))
    assert row["load_factor"][-1] == pytest.approx(asked, rel=0.02)


@pytest.mark.verify
def test_a_film_under_compression_shears_off(hampm):
    """Its faces are closed: the crack is one of mode II, and G of the steady state the same. With friction it needs more."""
    free = run(hampm, film(replace=COARSE + COLD))
    rubs = run(hampm, film(replace=COARSE + COLD + [("'frictionless'", "'friction'  friction = 0.3")]))
    asked = np.sqrt(TOUGHNESS / plane())
    print("load factor", free["load_factor"][-1] / asked, rubs["load_factor"][-1] / asked)
    assert free["load_factor"][-1] == pytest.approx(asked, rel=0.02)
    assert np.all(rubs["load_factor"] > 1.01 * free["load_factor"])
    assert rubs["friction_loss"][-1] > 0
    check_energy(free, 0.02)


def test_large_strain(hampm):
    row = run(hampm, film(replace=COARSE + [("name = 'film'\n", "name = 'film'\n   law = 'neo_hookean'\n")]))
    assert row["load_factor"][-1] == pytest.approx(np.sqrt(TOUGHNESS / plane()), rel=0.02)
    check_energy(row, 0.02)


def test_a_live_load_beside_the_heat(hampm):
    """Held, a pull on the end of the film helps: with it the load factor is lower, and the first one is that of both in a scene without growth."""
    pull = "&load kind = 'traction'  lower = 0.0, 10.0e-6  upper = 0.0, 11.0e-6  force = 0.0, 10.0  held = .true. /\n"
    alone, helped = run(hampm, film(replace=COARSE)), run(hampm, film(replace=COARSE) + pull)
    assert np.all(helped["load_factor"] < alone["load_factor"])
    factor = float(helped["load_factor"][0])
    heat = [(f"{e}e-3, {e}e-3, 0.0, {e}e-3\n   held = .false.", f"{e * factor}e-3, {e * factor}e-3, 0.0, {e * factor}e-3") for e in (0.5, 1.5)]
    text = film(replace=COARSE + heat) + pull
    start, end = text.index("&growth"), text.index("&energy_release")
    row = run(hampm, text[:start] + text[end:])
    for name in ("G", "strain_energy"):
        assert row[name][0] == pytest.approx(helped[name][0], rel=1e-6), name


def test_resumed_to_the_byte(hampm):
    (hampm.folder / "film.nml").write_text(film(replace=COARSE))
    whole = datasets(run(hampm, film(replace=COARSE)).path)
    assert hampm("film.nml", "--force", "--quiet", "--set", "output.file=out.h5", "--steps", "3").returncode == 5
    assert hampm("--resume", "out.h5.checkpoint", "--quiet").returncode == 0
    parts = datasets(hampm.folder / "out.h5")
    assert whole.keys() == parts.keys()
    assert all(np.asarray(whole[name]).tobytes() == np.asarray(parts[name]).tobytes() for name in whole)


def test_refused(hampm):
    assert "eigenstrain" in run(hampm, film(replace=[("eigenstrain = 0.5e-3, 0.5e-3, 0.0, 0.5e-3\n", "")]), code=2)
    assert "load frame" in run(hampm, film() + "&control /\n", code=2)
    text = film()
    start, end = text.index("&growth"), text.index("&energy_release")
    assert "held" in run(hampm, text[:start] + text[end:]).said
