"""Particles with domains: what is measured at nodes follows from the corners of these, as the motion does."""

import h5py
import numpy as np
import pytest

from paths import CHECKED_PROGRAM


def datasets(path):
    """The bytes of all that a run has recorded, by name."""
    found = {}
    with h5py.File(path) as file:
        for group in {"history", "VTKHDF"} & set(file):
            file[group].visititems(lambda name, item: found.update({name: np.asarray(item[()]).tobytes()} if isinstance(item, h5py.Dataset) else {}))
    return found


METHODS = [(), ("method.scheme='usf'", "method.mass='full'"), ("method.scheme='musl'", "method.mass='lumped'", "output.snapshot_interval=1e-6"),
           ("refine.indicator='gradient'", "refine.max_level=1", "refine.interval=3"), ("energy_release.estimators='domain_integral','energy_balance'",)]


@pytest.mark.parametrize("settings", METHODS)
def test_resumed_run(case, hampm, text_of, settings):
    """A run that is stopped at a sample, before one and behind one, and resumed, has the bytes of the run that never stopped."""
    words = [word for item in settings for word in ("--set", item)]
    whole = case("cpdi_resume", *words)
    assert whole.code == 0, whole.stderr
    expected = datasets(whole.path)
    at_sample = int(whole.row["step"][1])
    part = case("cpdi_resume", *words, "--steps", str(at_sample))
    for more in (1, at_sample - 2):
        assert part.code == 5, part.stderr
        assert hampm("--resume", f"{part.path}.checkpoint", "--steps", str(more), program=CHECKED_PROGRAM).returncode == 5
    assert hampm("--resume", f"{part.path}.checkpoint", program=CHECKED_PROGRAM).returncode == 0
    found = datasets(part.path)
    assert [name for name in expected if found[name] != expected[name]] == []


def coarse_beam(text_of, method):
    """The cantilever with cells of twice the size, until its end has been pulled for a while."""
    return (text_of("cpdi_J_and_reaction").replace("cell = 2.5e-3  cells = 44, 10", "cell = 5e-3  cells = 22, 5").replace("end_time = 2e-3", "end_time = 5e-4")
            .replace("frame = 'updated'  functions = 'cpdi'  scheme = 'usf'", method).replace("radii = 6e-3, 8e-3", "radii = 1e-2"))


@pytest.mark.parametrize("scheme", ["usf", "usavg", "usl", "musl"])
def test_J_and_reaction_of_a_beam(case, text_of, scheme):
    """J, G by nodal forces and the reaction in motion are those of linear functions in the total frame, whichever scheme maps stresses when: they came from
    forces that linear functions of the particles would map (J 9.34 J/m2 in place of 12.88 and +11.7 in place of -48.7 N with usf and usavg)."""
    plain = case("cpdi_J_and_reaction", text=coarse_beam(text_of, "frame = 'total'"))
    run = case("cpdi_J_and_reaction", text=coarse_beam(text_of, f"frame = 'updated'  functions = 'cpdi'  scheme = '{scheme}'"))
    assert plain.code == run.code == 0, run.stderr
    for column in ("J", "G_nodal_force_I", "reaction_g_y"):
        assert np.allclose(run.row[column], plain.row[column], rtol=0, atol=0.01*np.max(np.abs(plain.row[column]))), column


@pytest.mark.parametrize("scheme", ["usf", "usavg", "usl", "musl"])
def test_reaction_of_a_heavy_block(case, text_of, scheme):
    """A block of 12 kg on a floor under 30 m/s2 has a reaction of 360 N when it is at rest, across cells that it has left and entered."""
    text = (text_of("cpdi_reaction_block").replace("cell = 1e-2  cells = 12, 20", "cell = 2e-2  cells = 6, 10").replace("rate = 50.0", "rate = 150.0")
            .replace("end_time = 1.0", "end_time = 0.25"))
    run = case("cpdi_reaction_block", "--set", f"method.scheme={scheme}", text=text)
    assert run.code == 0, run.stderr
    assert run.row["reaction_f_y"][-1] == pytest.approx(360, rel=2e-3)
