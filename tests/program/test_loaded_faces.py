"""Tractions on the faces of a crack: by superposition G, J and K are those of the crack that the same tractions load from afar."""

import math
import re

import pytest

from history import History

LENGTH, WIDTH, HALF_HEIGHT, THICKNESS, PRESSURE = 0.04, 0.1, 0.06, 0.01, 1e5
SCENE = """\
&run thickness = 0.01 plane = 'stress' end_time = 1.5e-3 /
&grid lower = -0.008, -0.068 cell = 4e-3 cells = 29, 34 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, -0.06 upper = 0.1, 0.06 /
&crack kind = 'line' tip = 0.04, 0 direction = 1, 0 /
&damping rate = 2e4 /
&energy_release estimators = 'nodal_force', 'domain_integral' radii = 0.016, 0.024 /
&method frame = 'total' courant = 0.4 /
&output file = 'plate.h5' history_interval = 5e-4 /
"""


def traction(lower, upper, stress, area, face="none"):
    return (f"&load kind = 'traction' lower = {lower} upper = {upper} face = '{face}' force = {stress[0] * area}, "
            f"{stress[1] * area} history = 'ramp' rise_time = 4e-4 /\n")


def on_faces(x, y):
    area = LENGTH * THICKNESS
    return traction("0, 0", "0.04, 0", (x, y), area, "left") + traction("0, 0", "0.04, 0", (-x, -y), area, "right")


def from_afar(x, y):
    across, along = WIDTH * THICKNESS, 2 * HALF_HEIGHT * THICKNESS
    loads = traction("0, 0.06", "0.1, 0.06", (x, y), across) + traction("0, -0.06", "0.1, -0.06", (-x, -y), across)
    if x:
        loads += traction("0.1, -0.06", "0.1, 0.06", (0, x), along) + traction("0, -0.06", "0, 0.06", (0, -x), along)
    return loads


@pytest.mark.parametrize(("mode", "stress"), [("I", (0, PRESSURE)), ("II", (PRESSURE, 0))])
def test_superposition(hampm, tmp_path, mode, stress):
    last = {}
    for place in (on_faces, from_afar):
        (tmp_path / "plate.nml").write_text(SCENE + place(*stress))
        result = hampm("plate.nml", "--quiet", "--force")
        assert (result.returncode, result.stderr) == (0, "")
        last[place] = {name: values[-1] for name, values in History(tmp_path / "plate.h5").columns.items()}
    faces, afar = last[on_faces], last[from_afar]
    for name, tolerance in ((f"G_nodal_force_{mode}", 1e-4), ("J", 1e-4), (f"K_{mode}", 1e-3)):
        assert faces[name] == pytest.approx(afar[name], rel=tolerance), name
        assert faces[name + "_error"] == pytest.approx(afar[name + "_error"], rel=0.02), name
    if mode == "I":  # Tada's polynomial for a long strip, to 0.5 %; this one is short, and its cells are coarse
        ratio = LENGTH / WIDTH
        factor = 1.12 - 0.231 * ratio + 10.55 * ratio**2 - 21.72 * ratio**3 + 30.39 * ratio**4
        assert faces["K_I"] == pytest.approx(factor * PRESSURE * math.sqrt(math.pi * LENGTH), rel=0.05)


@pytest.mark.parametrize("history", [
    "history = 'sine' frequency = 1e3", "history = 'table' times = 0, 2e-4, 1e-3 factors = 0, 3, 0", "history = 'step'"])
def test_the_expected_error_is_that_of_the_loads_at_their_largest(hampm, tmp_path, history):
    """A part of the value: the same however large the tractions are, and whatever becomes of them."""
    ramp = SCENE + on_faces(0, PRESSURE)
    lines = []
    for scene in (ramp, ramp.replace("history = 'ramp' rise_time = 4e-4", history), SCENE + on_faces(0, 1e-3 * PRESSURE)):
        (tmp_path / "plate.nml").write_text(scene)
        lines.append([line for line in hampm("--check", "plate.nml").stdout.splitlines() if line.startswith("! expected error")])
    assert lines[0] == lines[1] == lines[2] and len(lines[0]) == 1


@pytest.mark.parametrize(("scene", "phrase"), [
    (SCENE + traction("0, 0", "0.04, 0", (0, 1), 1), "&load face = 'none'.*must be 'left' or 'right'"),
    (SCENE + traction("0, 0.06", "0.1, 0.06", (0, 1), 1, "left"), "&load face = 'left': must be 'none' but"),
    (SCENE + traction("0, 0", "0.06, 0", (0, 1), 1, "left"), "&load face = 'left': must be 'none' but"),
    (SCENE.replace("'nodal_force'", "'stress_closure'") + on_faces(0, 1), "'stress_closure' is not defined")])
def test_what_has_no_meaning_is_refused(hampm, tmp_path, scene, phrase):
    (tmp_path / "plate.nml").write_text(scene)
    result = hampm("--check", "plate.nml")
    assert result.returncode == 2
    assert re.search(phrase, result.stderr), result.stderr
