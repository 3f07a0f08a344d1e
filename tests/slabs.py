"""Slab twins: a scene of a straight crack of the plane, in plane strain, and the same as a slab of solids one cell thick, held across on both sides.

    twins(folder, text)    rows of the history of both, `Row`, and the radii of the domain integral in both: `Twins`
    Told                   why a scene has no slab
"""

import subprocess

import f90nml
import numpy as np

from harness import Row
from paths import PROGRAM, SOLID_PROGRAM

COURANT = 0.2                    # of both: by default the steps are those of waves in the plane, and in space
LONGEST = 60                     # of a run [s]
STOPPED = 5                      # exit code of a run that has made as many steps as are asked for
# Keys of places and vectors, and their component across the slab: its lower or upper side, or nothing
PLACES = {"lower": 0, "upper": 1, "region_lower": 0, "region_upper": 1, "consistent_lower": 0, "consistent_upper": 1, "tip": 0, "center": 0}
VECTORS = "velocity", "displacement", "force", "acceleration", "direction", "profile_direction"
IN_PLANE_ONLY = {("energy_release", "t_stress"), ("energy_release", "extrapolation")}
ESTIMATORS = "vcct", "domain_integral"
SAME = "time", "step", "particles", "cells", "dt", "finest_cell"
# Columns of the plane, and those of the slab that are the same
COLUMNS = {"J": "G_mean", "K_I": "K_I", "K_II": "K_II", "G_vcct_I": "G_vcct_I", "G_vcct_II": "G_vcct_II"}


class Told(Exception):
    """Why a scene has no slab."""


def groups_of(text):
    """Groups of a namelist, [name, {key: value}], in their order."""
    return [[name, dict(keys)] for name, keys in f90nml.Parser().reads(text).items()]


def shown(value):
    if isinstance(value, list):
        return ", ".join(map(shown, value))
    return f".{str(value).lower()}." if isinstance(value, bool) else repr(value)


def text_of(groups):
    return "".join(f"&{name} " + "  ".join(f"{key} = {shown(value)}" for key, value in keys.items()) + " /\n" for name, keys in groups)


def strained(groups):
    """The scene of the plane as its slab has it: in plane strain, one cell thick, with the estimators of both."""
    groups = [[name, dict(keys)] for name, keys in groups if name != "probe"]
    named = {name: keys for name, keys in groups}
    if named["run"].get("plane") == "axisymmetric":
        raise Told("a ring is no slab")
    thickness = named["run"].get("thickness", 1.0)
    part = named["grid"]["cell"] / thickness
    named["run"] |= {"plane": "strain", "thickness": named["grid"]["cell"]}
    for name in ("method", "output"):
        if name not in named:
            groups.append([name, named.setdefault(name, {})])
    method = named["method"]
    named["output"]["file"] = "out.h5"
    if method.get("time", "explicit") == "explicit":
        method["courant"] = method.get("courant", COURANT)
    method["frame"] = "total"
    for name, keys in groups:
        if name == "load" and "force" in keys:
            keys["force"] = [part * x for x in keys["force"]]
        if name == "energy_release":
            wanted = keys.get("estimators", [])
            keys["estimators"] = [one for one in (wanted if isinstance(wanted, list) else [wanted]) if one in ESTIMATORS]
            if not keys["estimators"]:
                del keys["estimators"]
            for key in ("t_stress", "reference", "reference_value", "phase_length"):
                keys.pop(key, None)
    return groups


def longer(groups):
    """The scene of the plane with all tips of its cracks a cell farther, and with them the ends of what holds a plane of symmetry."""
    groups, h = [[name, dict(keys)] for name, keys in groups], next(keys["cell"] for name, keys in groups if name == "grid")
    for keys in [keys for name, keys in groups if name == "crack"]:
        plane = plane_of(keys)
        along = int(np.argmax(np.abs(plane["direction"])))
        step = h * float(np.sign(plane["direction"][along]))
        if keys.get("kind") == "path":
            x = np.array(keys["points"], float).reshape(2, 2)
            x[:, along] += [-step, step]
            keys["points"] = x.ravel().tolist()
        elif keys.get("front") == "disc":
            keys["radii"] += h
        else:
            keys["tip"] = [x + step * (d == along) for d, x in enumerate(keys["tip"])]
            if "length" in keys:
                keys["length"] += 2 * h
        if keys.get("kind", "symmetry") == "symmetry":
            for held in [held for name, held in groups if name == "constraint"]:
                end = "lower" if step > 0 else "upper"
                if abs(held[end][along] - plane["tip"][along]) < 1e-6 * h and abs(held[end][1 - along] - plane["tip"][1 - along]) < 1e-6 * h:
                    held[end] = [x + step * (d == along) for d, x in enumerate(held[end])]
    return groups


def slab_of(groups):
    """The slab of a scene that is `strained`."""
    found, h = [], next(keys["cell"] for name, keys in groups if name == "grid")
    bodies = [keys for name, keys in groups if name == "body" and not keys.get("hole")]
    for name, keys in groups:
        keys = dict(keys)
        if name == "run":
            del keys["plane"], keys["thickness"]
        if name == "grid":
            keys["cells"] = [*keys["cells"], 1]
            keys.setdefault("lower", [0.0, 0.0])
        if name == "body" and keys.get("shape") == "circle":
            x, y = keys.pop("center")
            keys |= {"shape": "cylinder", "lower": [x, y], "upper": [x, y]}
        elif name == "body" and keys.get("shape", "rectangle") != "rectangle":
            raise Told("polygons are not extruded")
        if keys.get("law") == "orthotropic":
            keys |= {key: keys["shear_12"] for key in ("shear_13", "shear_23")} | {"angle": [0.0, 0.0, keys.get("angle", 0.0)]}
        if name == "load" and keys["kind"] == "point":
            keys["force"] = [x / 2 for x in keys["force"]]
            for z in (0.0, h):
                found.append([name, keys | {"lower": [*keys["lower"], z], "upper": [*keys["upper"], z], "force": [*keys["force"], 0.0]}])
            continue
        if name == "load" and keys.get("face", "none") != "none":
            raise Told("loads of solids name no face of a crack")
        if name == "crack":
            keys = plane_of(keys)
        for key, value in keys.items():
            if key in PLACES and isinstance(value, list):
                keys[key] = [*value, h * PLACES[key]]
            elif key in VECTORS and isinstance(value, list):
                keys[key] = [*value, 0.0]
        if name in ("cohesive", "nucleation", "contact"):
            raise Told(f"solids have no &{name}" if name != "contact" else "two bodies")
        found.append([name, keys])
    lower, upper = ([f(keys[key][d] for keys in bodies if key in keys) for d in range(2)] for key, f in (("lower", min), ("upper", max)))
    return [*found, ["constraint", {"lower": [*lower, 0.0], "upper": [*upper, h], "fix": "z"}]]


def plane_of(keys):
    """A straight crack of the plane along a grid line as one in a plane of the grid."""
    keys = dict(keys)
    kind = keys.get("kind", "symmetry")
    if kind == "path":
        points = np.reshape(keys.pop("points"), (-1, 2))
        if len(points) > 2:
            raise Told("a path with kinks")
        keys |= {"tip": points[1].tolist(), "direction": (points[1] - points[0]).tolist(), "length": float(np.hypot(*(points[1] - points[0])))}
    if keys.get("front") == "disc":
        middle, radius = np.array(keys.pop("center")), keys.pop("radii")
        way = np.array([0.0, 1.0] if keys.get("normal") == "x" else [1.0, 0.0])
        keys |= {"tip": (middle + radius * way).tolist(), "direction": way.tolist(), "length": 2 * radius}
        del keys["front"]
    way = np.abs(keys.setdefault("direction", [1.0, 0.0]))
    if min(way) > 1e-12 * max(way):
        raise Told("a crack aslant to the grid")
    return keys | {"kind": kind if kind == "symmetry" else "plane", "normal": "yx"[int(np.argmax(way))]}


def run(program, folder, groups, *words):
    """The row of a run; `Told` where it is refused."""
    folder.mkdir()
    (folder / "case.nml").write_text(text_of(groups))
    result = subprocess.run([program, "case.nml", "--quiet", "--force", *words], cwd=folder, capture_output=True, text=True, timeout=LONGEST)
    if result.returncode == 2:
        raise Told(result.stderr)
    assert result.returncode in (0, STOPPED), result.stderr
    return Row(folder / "out.h5", result.stderr)


def twins(folder, text, *words):
    """The rows of a scene in plane strain, of the same with longer cracks, and of its slab, with the signs of the plane: there the normal of a crack is to the left of its
    outward direction, and the closure of mode II has the sign of K_II. In a slab it is an axis, and the closure has no sign."""
    groups = strained(groups_of(text))
    slab = run(SOLID_PROGRAM, folder / "slab", slab_of(groups), *words)
    if "crack_area" in slab:
        slab["crack_length"] = slab["crack_area"] / next(keys["cell"] for name, keys in groups if name == "grid")
    crack = next(plane_of(keys) for name, keys in groups if name == "crack")
    x, y = crack["direction"]
    sign = 1 if (-y if crack["normal"] == "x" else x) > 0 else -1
    for name in [name for name in slab if name.startswith("K_II") and not name.endswith("_error")]:
        slab[name] *= -sign if "_front" in name else sign
        if (closure := name.replace("K_", "G_vcct_")) in slab:
            slab[closure] *= np.sign(slab[name])
    return run(PROGRAM, folder / "plane", groups, *words), run(PROGRAM, folder / "longer", longer(groups), *words), slab


def kind_of(name, row):
    """Columns of a kind, over whose largest value differences are told."""
    stem = name.split("_tip")[0]
    if "energy" in name or "work" in name or "loss" in name:
        return [one for one in row if "energy" in one or "work" in one or "loss" in one]
    beginning = next((part for part in ("K_", "G_vcct_", "reaction", "J") if stem.startswith(part)), name)
    return [one for one in row if one.startswith(beginning) and not one.endswith("_error") and "dependence" not in one]


def pairs(plane, slab):
    """(name, column of the plane, column of the slab) of all quantities that both have."""
    for name in plane:
        stem, _, tip = name.partition("_tip")
        of_slab = COLUMNS.get(stem, stem) + ("_front" + tip if tip.isdigit() else "")
        if of_slab in slab and stem not in SAME and not stem.endswith("_error"):
            yield name, of_slab


def differences(plane, longer, slab):
    """(offset, {column: difference}): by how many cells the crack of the slab is longer, to least squares by the work of the loads, and what differs beside this,
    over the largest value of columns of the kind."""
    change = longer["external_work"] - plane["external_work"]
    offset = float(change @ (slab["external_work"] - plane["external_work"]) / max(change @ change, np.finfo(float).tiny))
    found = {}
    for name, of_slab in pairs(plane, slab):
        scale = max(np.max(np.abs(plane[one])) for one in kind_of(name, plane))
        if scale > 0:
            found[name] = float(np.max(np.abs(slab[of_slab] - plane[name] - offset * (longer[name] - plane[name]))) / scale)
    return offset, found
