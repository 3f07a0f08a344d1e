"""What a scene becomes in a mirror, turned, in other units, in another order, and what that makes of its results.

Each map is a pair: of a scene (a list of groups, see `drawn_scenes.py`) and of the columns of its history.
"""

import math
import re

import numpy as np
from drawn_scenes import copy_of, groups

# Exponents of mass, length and time of what a key has
LENGTH, TIME, NOTHING = (0, 1, 0), (0, 0, 1), (0, 0, 0)
PRESSURE, SPEED, RATE, TOUGHNESS, FORCE, INTENSITY = (1, -1, -2), (0, 1, -1), (0, 0, -1), (1, 0, -2), (1, 1, -2), (1, -0.5, -2)
DIMENSIONS = {
    "run": {"thickness": LENGTH, "end_time": TIME, "stop_length": LENGTH, "stop_rest": TIME}, "grid": {"lower": LENGTH, "cell": LENGTH},
    "material": {"density": (1, -3, 0), "relaxation_times": TIME}
    | dict.fromkeys(("young", "yield_stress", "hardening", "saturation", "kinematic_hardening", "c01", "moduli", "young_1", "young_2", "young_3", "shear_12", "shear_13", "shear_23"), PRESSURE),
    "body": dict.fromkeys(("lower", "upper", "points", "center", "radius", "profile_at"), LENGTH) | {"velocity": SPEED, "spin": RATE, "toughness": TOUGHNESS},
    "constraint": {"lower": LENGTH, "upper": LENGTH, "displacement": LENGTH, "velocity": SPEED},
    "load": {"lower": LENGTH, "upper": LENGTH, "force": FORCE, "pressure": PRESSURE, "acceleration": (0, 1, -2)},
    "damping": {"rate": RATE}, "contact": {"distance": LENGTH}, "method": {"time_step": TIME, "consistent_lower": LENGTH, "consistent_upper": LENGTH},
    "refine": {"region_lower": LENGTH, "region_upper": LENGTH, "start": TIME}, "crack": dict.fromkeys(("tip", "length", "points", "center", "radii"), LENGTH),
    "cohesive": dict.fromkeys(("from", "opening", "openings"), LENGTH) | dict.fromkeys(("strength", "tractions", "strength_shear"), PRESSURE)
    | dict.fromkeys(("toughness", "toughness_shear"), TOUGHNESS),
    "growth": {"points": LENGTH, "toughness": TOUGHNESS, "limit_speed": SPEED, "speed": SPEED, "start": TIME, "end": TIME, "increment": LENGTH, "max_length": LENGTH,
               "extensions": LENGTH, "speeds": SPEED, "toughness_shear": TOUGHNESS, "threshold": INTENSITY, "wheeler_stress": PRESSURE},
    "nucleation": {"toughness": TOUGHNESS, "strength": PRESSURE, "increment": LENGTH},
    "control": {"displacement": LENGTH, "stiffness": (1, 0, -2)},
    "energy_release": {"radii": LENGTH, "phase_length": LENGTH, "reference_value": TOUGHNESS}, "output": {"history_interval": TIME, "snapshot_interval": TIME},
    "probe": {"at": LENGTH, "distance": LENGTH},
}
for _name in ("constraint", "load", "control"):
    DIMENSIONS[_name] |= {"start": TIME, "rise_time": TIME, "times": TIME, "frequency": RATE}
UNITS = {"s": TIME, "1": NOTHING, "m": LENGTH, "J": (1, 2, -2), "kg m/s": (1, 1, -1), "kg m2/s": (1, 2, -1), "N": FORCE, "J/m2": TOUGHNESS, "Pa m^0.5": INTENSITY,
         "rad": NOTHING, "deg": NOTHING, "m/s": SPEED, "Pa": PRESSURE, "m2": (0, 2, 0), "m3": (0, 3, 0)}
# Columns that are linear in the loads of a linear body beside those of their units
OPENINGS = "crack_opening", "crack_sliding", "mouth_opening", "mouth_sliding"
LINEAR = "displacement_", "velocity_", "strain_p", "opening_", "sliding_", "load_displacement_"
BOXES = {"body", "constraint", "load"}
LOADS = {"load": ("force", "pressure", "acceleration"), "constraint": ("displacement", "velocity"), "body": ("velocity", "spin", "eigenstrain")}


def scaled(value, factor):
    """A number or a list of numbers times a factor."""
    return [factor * one for one in value] if isinstance(value, (list, tuple)) else factor * value


# Mirrors, quarter turns and exchanges of axes, in the plane or in space: orthogonal matrices of 0, 1 and -1
MIRROR_X, MIRROR_Y, TURN = np.array([[-1, 0], [0, 1]]), np.array([[1, 0], [0, -1]]), np.array([[0, -1], [1, 0]])


def dimensions(scene):
    """Two or three: those of the lattice."""
    return len(groups(scene, "grid")[0]["cells"])


def axis_of(q, axis):
    """What axis a map has in the place of this one."""
    return int(np.argmax(np.abs(q[axis])))


def moved(q, vectors):
    """Vectors one behind the other, each as the map q has it."""
    return [float(x) + 0.0 for vector in np.reshape(vectors, (-1, len(q))) for x in q @ vector]


def rotation(angles):
    """The axes of a material, as columns, that turn around x, then y, then z [degrees]."""
    axes = np.eye(3)
    for a, angle in enumerate(np.radians(angles)):
        turn, i, j = np.eye(3), (a + 1) % 3, (a + 2) % 3
        turn[i, i], turn[j, j], turn[j, i], turn[i, j] = np.cos(angle), np.cos(angle), np.sin(angle), -np.sin(angle)
        axes = turn @ axes
    return axes


def angles_of(axes):
    """The same the other way round; an axis may point either way."""
    axes = axes * [1, 1, round(np.linalg.det(axes))]
    if abs(axes[2, 0]) > 1 - 1e-12:
        found = np.arctan2(-axes[1, 2], axes[1, 1]), -np.arcsin(np.sign(axes[2, 0])), 0.0
    else:
        found = np.arctan2(axes[2, 1], axes[2, 2]), -np.arcsin(axes[2, 0]), np.arctan2(axes[1, 0], axes[0, 0])
    return [round(float(np.degrees(angle)), 12) for angle in found]


def isometric(scene, q):
    """The scene of which each place and vector is mapped by q."""
    scene, flips, turns, n = copy_of(scene), round(np.linalg.det(q)) < 0, q[0, 0] == 0, len(q)
    for name, keys in scene:
        if name == "crack" and n == 2 and keys.pop("front", "") == "disc":  # the last of its tips is the upper one
            center, (radius,), normal = keys.pop("center"), keys.pop("radii"), keys.pop("normal")
            keys |= {"kind": "path", "points": [x + end * radius * (axis != normal) for end in (-1, 1) for x, axis in zip(center, "xy")]}
        if name == "grid":
            upper = [keys.get("lower", n * [0.0])[d] + keys["cell"] * keys["cells"][d] for d in range(n)]
            keys["lower"] = list(np.minimum(moved(q, keys.get("lower", n * [0.0])), moved(q, upper)))
            keys["lower"] = [float(x) for x in keys["lower"]]
            keys["cells"] = [keys["cells"][axis_of(q, d)] for d in range(n)]
        for low, high in (("lower", "upper"), ("consistent_lower", "consistent_upper"), ("region_lower", "region_upper")):
            if name != "grid" and low in keys and high in keys:
                a, b = moved(q, keys[low]), moved(q, keys[high])
                keys[low], keys[high] = [min(pair) for pair in zip(a, b)], [max(pair) for pair in zip(a, b)]
        for key in ("points", "center", "velocity", "force", "acceleration", "displacement", "tip", "direction", "profile_direction", "at"):
            if key in keys and isinstance(keys[key], (list, tuple)):
                keys[key] = moved(q, keys[key])
        if name == "crack" and keys.get("kind", "symmetry") != "path" and keys.get("front", "straight") == "straight" and "direction" not in keys:
            keys["direction"] = moved(q, [1.0, *(n - 1) * [0.0]])
        if name == "crack" and (n == 3 or "normal" in keys):
            across = "xyz".index(keys.get("normal", "z"))
            if len(keys.get("radii", ())) == 2:
                radii = dict(zip([d for d in range(3) if d != across], keys["radii"]))
                keys["radii"] = [radii[axis_of(q, d)] for d in range(3) if axis_of(q, d) != across]
            keys["normal"] = next("xyz"[d] for d in range(n) if axis_of(q, d) == across)
        if name == "material" and keys.get("law") == "orthotropic" and n == 3:
            keys["angle"] = angles_of(q @ rotation(keys.get("angle", [0.0])))
        elif name == "material" and "angle" in keys:
            keys["angle"] = math.degrees(math.atan2(*(q @ [math.cos(math.radians(keys["angle"])), math.sin(math.radians(keys["angle"]))])[::-1]))
            keys["angle"] = round(keys["angle"], 9)
        if name == "material" and keys.get("law") == "orthotropic" and "angle" not in keys:
            keys["angle"] = 90.0 if turns else 0.0
        if name == "growth" and "angles" in keys:       # of lines: they repeat after 180 degrees
            ahead = [q @ [math.cos(math.radians(angle)), math.sin(math.radians(angle))] for angle in keys["angles"]]
            angles = [round(math.degrees(math.atan2(y, x)) % 180, 9) % 180 for x, y in ahead]
            keys["angles"], keys["angle_factors"] = [list(column) for column in zip(*sorted(zip(angles, keys["angle_factors"])))]
        if "spin" in keys:                                                   # an axial vector
            keys["spin"] = moved((-1 if flips else 1) * q, keys["spin"]) if n == 3 else -keys["spin"] if flips else keys["spin"]
        if "eigenstrain" in keys:
            xx, yy, xy, *zz = keys["eigenstrain"]
            strain = np.zeros((n, n))
            strain[:2, :2] = [[xx, xy], [xy, yy]]
            if n == 3:
                strain[2, 2] = sum(zz)
            strain = q @ strain @ q.T
            keys["eigenstrain"] = [float(strain[0, 0]), float(strain[1, 1]), float(strain[0, 1]), *(zz if n == 2 else [float(strain[2, 2])])]
        if "fix" in keys:
            keys["fix"] = "".join(axis for d, axis in enumerate("xyz"[:n]) if "xyz"[axis_of(q, d)] in keys["fix"])
        if flips and keys.get("face") in ("left", "right"):
            keys["face"] = {"left": "right", "right": "left"}[keys["face"]]
    return scene


def family(column):
    """The name of a column without the number of its tip."""
    base, _, number = column.rpartition("_tip")
    return base if number.isdigit() and base else column


def ends_with_its_tip(column, values, warnings):
    """Whether the numbers of a column end where its tip, as a run has warned, has come to where its crack ends or near to it."""
    base = family(column)
    tip = "1" if base == column else column.rpartition("_tip")[2]
    told = re.search(rf"tip {tip} (has run through|has ended|is nearer than one of the finest cells|has appeared where no radius)", warnings)
    return bool(told) and not np.any(np.isinf(values)) and not np.any(np.diff(np.isnan(values).astype(int)) < 0)


def without_waiting(column, row):
    """The numbers of a column without those that are missing where its crack is not there yet."""
    values, length = row[column], row.get(f"crack_length{column[len(family(column)):]}")
    return values if length is None else values[~(np.isnan(values) & (length == 0))]


def isometric_columns(row, q, normal=None):
    """The columns of the history of the mapped scene; of a solid with a crack across an axis. There K_II is along the outward normal e_1 of the front, of the side
    to which that axis points, and K_III along e_1 x n."""
    flips, found = round(np.linalg.det(q)) < 0, {}
    signs = {"K_II": q[:, "xyz".index(normal)].sum(), "K_III": -1 if flips else 1} if normal else {}
    for column, values in row.items():
        name = family(column)
        odd = (name in ("K_II", "K_II_by_fields", "kink_angle", "oscillation_index", "crack_sliding", "mouth_sliding", "angular_momentum") or name.startswith("sliding_") or len(q) == 2 and name.startswith("G_") and name.endswith("_II"))
        if name == "mode_mixity":
            continue
        if name == "tip_angle":
            angle = np.radians(values)
            ahead = q @ np.array([np.cos(angle), np.sin(angle)])
            found[column] = np.degrees(np.arctan2(ahead[1], ahead[0]))
        elif name.endswith(("_x_error", "_y_error", "_z_error")):
            found[column] = row[column.replace(name, name[:-7] + "xyz"[axis_of(q, "xyz".index(name[-7]))] + "_error")]
        elif name.endswith(("_x", "_y", "_z")):
            axis = "xyz".index(name[-1])
            other = axis_of(q, axis)
            turn = -1 if name.startswith("angular_momentum") and flips else 1       # of an axial vector
            found[column] = turn * q[axis, other] * row[column.replace(name, name[:-1] + "xyz"[other])]
        elif name.startswith(("strain_", "stress_")) and re.search("_[xyz][xyz]$", name) and "xyz".index(max(name[-2:])) < len(q):
            axes = ["xyz".index(axis) for axis in name[-2:]]
            others = [axis_of(q, axis) for axis in axes]
            found[column] = math.prod(q[axis, other] for axis, other in zip(axes, others)) * row[name[:-2] + "".join("xyz"[k] for k in sorted(others))]
        else:
            found[column] = values * signs.get(name.partition("_front")[0], -1 if odd and flips else 1)
    return found


def in_units(scene, mass, length, time):
    """The scene in other units, of which one old one is `mass`, `length` and `time`."""
    scene = copy_of(scene)
    for name, keys in scene:
        for key, exponents in DIMENSIONS.get(name, {}).items():
            if key in keys:
                keys[key] = scaled(keys[key], mass**exponents[0] * length**exponents[1] * time**exponents[2])
        if "rate_constant" in keys:                                          # the rate where the range of K is one unit of the old ones
            unit = mass * length**-0.5 * time**-2
            keys["rate_constant"] *= length * unit ** (float(keys.get("rate") == "forman") - keys["rate_exponent"])
        if name == "run" and keys.get("plane") == "axisymmetric":           # where the default may be given
            keys.pop("thickness", None)
        elif name == "run" and "thickness" not in keys and dimensions(scene) == 2:
            keys["thickness"] = length
    return scene


def in_units_columns(row, units, mass, length, time):
    """The columns of the history in the other units."""
    found = {}
    for column, values in row.items():
        m, x, t = UNITS[units[column]]
        found[column] = values * (mass**m * length**x * time**t)
    return found


def thicker(scene, factor):
    """The scene of another thickness, with forces to match."""
    scene = copy_of(scene)
    scene[0][1]["thickness"] = scene[0][1].get("thickness", 1.0) * factor
    for keys in groups(scene, "load"):
        if "force" in keys:
            keys["force"] = scaled(keys["force"], factor)
    for keys in groups(scene, "control"):
        keys["stiffness"] = keys.get("stiffness", 0.0) * factor
    return scene


def thicker_columns(row, units, factor):
    """Energies, forces and momenta go with the thickness; what is of the plane stays."""
    return {column: values * factor if units[column] in ("J", "N", "kg m/s", "kg m2/s", "m3") else values for column, values in row.items()}


def times_loads(scene, factor, keep=lambda name, number: True):
    """The scene with each load, motion and eigenstrain times a factor where `keep(group, number of it)`."""
    scene, count = copy_of(scene), {}
    for name, keys in scene:
        number = count[name] = count.get(name, -1) + 1
        for key in LOADS.get(name, ()):
            if key in keys and keep(name, number):
                keys[key] = scaled(keys[key], factor)
    return scene


def times_loads_columns(row, units, factor):
    """Of a linear scene: what is quadratic, what is linear, and what stays. Where a crack grows at rest, its drive is the toughness: the load factor changes."""
    if "load_factor" in row:
        return {column: values / factor if column in ("load_factor", "load_factor_error") else values for column, values in row.items()}
    power = {"J": 2, "J/m2": 2, "kg m/s": 1, "kg m2/s": 1, "N": 1, "Pa m^0.5": 1, "Pa": 1, "m3": 1}
    found = {}
    for column, values in row.items():
        n = power.get(units[column], 0)
        if family(column) in OPENINGS or column.startswith(LINEAR):
            n = 1
        found[column] = values * (abs(factor) if "_error" in family(column) else factor) ** n
    return found


def shuffled(scene, chance):
    """The scene with its groups in another order, and a material that no body has. Constraints keep their order (where boxes overlap the last one holds), holes follow
    bodies, and the first body stays so where bodies meet (`contact_force` is that of the first)."""
    scene = copy_of(scene)
    meets = bool(groups(scene, "contact"))
    scene.append(["material", {"name": "unused", "young": 3.0, "poisson": 0.1, "density": 1e4}])
    for name in ("material", "load", "body", "crack", "cohesive", "growth", "nucleation"):
        where = [k for k, (group, keys) in enumerate(scene) if group == name and not keys.get("hole")]
        order = where[:]
        chance.shuffle(order)
        if name == "body" and meets:
            order = [where[0]] + [k for k in order if k != where[0]]
        old = [scene[k] for k in order]
        for k, one in zip(where, old):
            scene[k] = one
    return scene


def reversed_cracks(scene):
    """The scene with the points of each path in the opposite order; None where there is none, or where tips, or what cohesion holds, are named by the order."""
    scene = copy_of(scene)
    paths = [keys for keys in groups(scene, "crack") if keys.get("kind") == "path"]
    swap = {"last": "first", "first": "last"}
    for keys in paths:
        keys["points"] = [x for point in np.reshape(keys["points"], (-1, 2))[::-1].tolist() for x in point]
    lines = [keys.get("name") for keys in groups(scene, "crack") if keys not in paths]
    for keys in groups(scene, "probe"):
        if "opening" in keys["quantity"] and keys.get("of", ["c0"])[0] not in lines:
            keys["tip"] = swap[keys.get("tip", "last")]
        if keys.get("face", "none") != "none" and keys["name"] not in [f"p{name}" for name in lines]:
            keys["face"] = {"left": "right", "right": "left"}[keys["face"]]
    faces = [keys for keys in groups(scene, "load") if keys.get("face", "none") != "none"]
    for keys in faces:                                      # of a path, where there are no other cracks
        keys["face"] = {"left": "right", "right": "left"}[keys["face"]]
    for keys in groups(scene, "growth"):
        if keys.get("crack") not in lines:
            keys["tips"] = swap.get(keys.get("tips", "all"), keys.get("tips", "all"))
    ordered = [keys.get("from") for keys in groups(scene, "cohesive")] + [keys.get("increment") for keys in groups(scene, "nucleation")]
    return scene if paths and not any(ordered) and not (faces and lines) else None


def split_bodies(scene):
    """The scene with its first rectangle in two along a grid line, the halves bonded; None where there is no such line or where the halves are not of one motion."""
    scene = copy_of(scene)
    grid = groups(scene, "grid")[0]
    at = next(k for k, (name, _) in enumerate(scene) if name == "body")
    body = scene[at][1]
    if body.get("shape", "rectangle") != "rectangle" or body.get("spin", 0.0) != 0.0 or any(keys.get("hole") for keys in groups(scene, "body")):
        return None
    lower, cell = grid.get("lower", [0.0])[0], grid["cell"]
    if any(abs((x[0] - lower) / cell - round((x[0] - lower) / cell)) > 1e-9 for x in (body["lower"], body["upper"])):
        return None                                     # particles fill a body evenly: those of a body between grid lines are not those of its parts
    middle = lower + cell * round((0.5 * (body["lower"][0] + body["upper"][0]) - lower) / cell)
    if not body["lower"][0] + 0.5 * cell < middle < body["upper"][0] - 0.5 * cell:
        return None
    if groups(scene, "contact") and groups(scene, "contact")[0].get("bodies", "bonded") != "bonded":
        body["contact_group"] = body.get("contact_group", "halves")
    other = {key: list(value) if isinstance(value, list) else value for key, value in body.items()}
    body["upper"] = [middle, *body["upper"][1:]]
    other["lower"] = [middle, *other["lower"][1:]]
    scene.insert(at + 1, ["body", other])
    return scene


def carried(scene, velocity):
    """The scene with a velocity of all bodies more."""
    scene = copy_of(scene)
    for keys in groups(scene, "body"):
        if not keys.get("hole"):
            keys["velocity"] = [a + b for a, b in zip(keys.get("velocity", len(velocity) * [0.0]), velocity)]
    return scene
