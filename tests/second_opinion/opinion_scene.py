"""Reads a static namelist of the plane program as a problem of linear elasticity, in units of its own.

Lengths are in cells of the lattice, from its lower corner (around an axis x is from the axis), stresses in the largest Young's modulus, forces in that times cell
times thickness, around an axis times cell squared and 2 pi: all are of the order of one. Nothing of the program's sources is used; what keys mean is that of docs/reference/keys.md.
"""

import math
from dataclasses import dataclass, field

import f90nml
import numpy as np

NEAR = 1e-6                    # places as near as this are one [cells]
FAR = 1e4                      # beyond all bodies [cells]
LAWS = "linear_elastic", "orthotropic"


class Outside(Exception):
    """A scene, or a quantity, that this judge does not judge, with the reason."""


@dataclass
class Material:
    """Stiffness of (xx, yy, zz, 2 xy), in plane stress without zz, in the axes x and y, and density [kg/m3]."""

    stiffness: np.ndarray
    compliance: np.ndarray     # of (xx, yy, 2 xy) in the plane: of plane strain where that is asked for
    isotropic: bool
    density: float
    key: tuple


@dataclass
class Body:
    """A region with its outline, `pieces` as [('line', a, b) or ('arc', middle, radius)], and what varies in it."""

    pieces: list
    material: Material
    eigenstrain: np.ndarray    # xx, yy, zz, 2 xy
    lower: np.ndarray
    upper: np.ndarray
    direction: np.ndarray = None
    at: list = None
    stiffness: list = None
    density: list = None
    eigen: list = None

    def inside(self, place, margin=0.0):
        """Whether a place is in the outline, by its distance where it is a circle, else by the winding of its corners."""
        kind = self.pieces[0]
        if kind[0] == "arc":
            return math.dist(place, kind[1]) < kind[2] + margin
        turned = 0.0
        for _, a, b in self.pieces:
            u, v = np.subtract(a, place), np.subtract(b, place)
            turned += math.atan2(u[0] * v[1] - u[1] * v[0], u @ v)
        return abs(turned) > math.pi or margin > 0 and self.distance(place) < margin

    def distance(self, place):
        """From a place to the outline."""
        return min(distance(place, piece) for piece in self.pieces)


@dataclass
class Crack:
    """Points of a crack, and which of its ends are tips, in the order of columns."""

    points: np.ndarray
    name: str
    contact: bool
    kind: str
    tips: list = field(default_factory=list)    # Tip
    pressure: float = 0.0                       # at the end

    @property
    def segments(self):
        """Its straight parts."""
        return list(zip(self.points, self.points[1:]))

    def along(self, place):
        """The direction of the part that is next to a place."""
        a, b = min(self.segments, key=lambda ends: distance(place, ("line", *ends)))
        return unit(b - a)

    def off(self, place):
        """From a place to it."""
        return min(distance(place, ("line", *ends)) for ends in self.segments)


@dataclass
class Tip:
    """Place and direction out of the crack of a tip, and the length of the straight part behind it."""

    place: np.ndarray
    direction: np.ndarray
    straight: float
    crack: Crack
    end: str                                    # 'first' or 'last'


@dataclass
class Hold:
    """A constraint: a box, the components that it holds, by how much they are moved at each load step."""

    lower: np.ndarray
    upper: np.ndarray
    components: list
    moved: np.ndarray
    factors: list
    turns: bool
    name: str
    snapped: bool
    middle: np.ndarray


@dataclass
class Load:
    """A load, with its box, its value and its factors at the load steps."""

    kind: str
    lower: np.ndarray
    upper: np.ndarray
    value: np.ndarray
    factors: list
    crack: str = ""
    name: str = ""
    side: tuple = None                          # of a polygon, a piece of its outline


@dataclass
class Scene:
    """All of a model, and the units that its numbers have."""

    plane: str
    bodies: list
    holes: list
    cracks: list
    holds: list
    loads: list
    probes: list
    cell: float
    origin: np.ndarray
    young: float
    thickness: float
    order: int

    @property
    def ring(self):
        """Whether material is around an axis."""
        return self.plane == "axisymmetric"

    @property
    def force(self):
        """The unit of forces [N]."""
        return self.young * self.cell * (2 * math.pi * self.cell if self.ring else self.thickness)

    def material_at(self, place):
        """The body that a place is in."""
        return next((body for body in self.bodies if body.inside(place)), None) if not any(hole.inside(place) for hole in self.holes) else None

    def body_at(self, tip):
        """The body at a tip, ahead of it and to its left where that is material."""
        found = [self.material_at(tip.place + 1e-4 * tip.direction + 1e-4 * side * left_of(tip.direction)) for side in (1, -1)]
        return found[0] or found[1]

    def pieces(self):
        """All pieces of outlines."""
        return [piece for body in self.bodies + self.holes for piece in body.pieces]


def unit(vector):
    """A vector of length 1."""
    return vector / np.linalg.norm(vector)


def left_of(direction):
    """The direction to the left of one."""
    return np.array([-direction[1], direction[0]])


def distance(place, piece):
    """From a place to a line or a circle."""
    if piece[0] == "arc":
        return abs(math.dist(place, piece[1]) - piece[2])
    a, b = np.asarray(piece[1]), np.asarray(piece[2])
    part = np.clip(np.dot(np.subtract(place, a), b - a) / max(np.dot(b - a, b - a), 1e-300), 0, 1)
    return float(np.linalg.norm(a + part * (b - a) - place))


def crossings(a, b, piece):
    """Parts of the way from a to b at which a line crosses a piece of an outline."""
    a, d = np.asarray(a, float), np.subtract(b, a)
    if piece[0] == "arc":
        e = a - piece[1]
        p, q, c = d @ d, e @ d, e @ e - piece[2]**2
        root = q * q - p * c
        return [(-q + sign * math.sqrt(root)) / p for sign in (-1, 1)] if root > 0 else []
    c, e = np.asarray(piece[1]), np.subtract(piece[2], piece[1])
    cross = d[0] * e[1] - d[1] * e[0]
    if abs(cross) < 1e-12 * np.linalg.norm(d) * np.linalg.norm(e):
        return []
    s = np.subtract(c, a)
    t, part = (s[0] * e[1] - s[1] * e[0]) / cross, (s[0] * d[1] - s[1] * d[0]) / cross
    return [t] if -1e-9 <= part <= 1 + 1e-9 else []


def listed(value):
    """A value of a namelist as a list."""
    return [] if value is None else list(value) if isinstance(value, (list, tuple)) else [value]


def factor(keys, time):
    """The factor of a history at a time."""
    kind, t = keys.get("history", "step"), time - keys.get("start", 0.0)
    if t < 0 or kind == "step":
        return float(t >= 0)
    if kind in ("ramp", "smooth_ramp"):
        part = min(t / keys["rise_time"], 1.0)
        return part**3 * (10 - 15 * part + 6 * part * part) if kind == "smooth_ramp" else part
    if kind == "sine":
        return round(math.sin(2 * math.pi * keys["frequency"] * t), 13)          # 0 where it is but for rounding
    return float(np.interp(t, listed(keys["times"]), listed(keys["factors"])))


def rotated(stiffness, angle):
    """A stiffness of (xx, yy, zz, 2 xy) whose axes are turned by an angle [degrees]."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turn = np.array([[c * c, s * s, 0, c * s], [s * s, c * c, 0, -c * s], [0, 0, 1, 0], [-2 * c * s, 2 * c * s, 0, c * c - s * s]])  # strain into the axes
    return turn.T @ stiffness @ turn


def material(keys, plane, young):
    """A material, with the compliances of its law."""
    law = keys.get("law", "linear_elastic")
    if law not in LAWS:
        raise Outside(f"law {law}")
    e, nu = keys.get("young", 0.0), keys.get("poisson", 0.0)
    young_of, poisson, shear = (e, e, e), (nu, nu, nu), e / (2 * (1 + nu))
    if law == "orthotropic":
        young_of = keys["young_1"], keys["young_2"], keys.get("young_3", keys["young_2"])
        poisson, shear = (keys["poisson_12"], keys.get("poisson_13", 0.0), keys.get("poisson_23", 0.0)), keys["shear_12"]
    s = np.diag([*(1 / e for e in young_of), 1 / shear])
    for nu, (i, j) in zip(poisson, ((0, 1), (0, 2), (1, 2))):
        s[i, j] = s[j, i] = -nu / young_of[i]
    flat = [0, 1, 3]
    if plane == "stress":
        c = np.zeros((4, 4))
        c[np.ix_(flat, flat)] = np.linalg.inv(s[np.ix_(flat, flat)])
    else:
        c = np.linalg.inv(s)
    c = rotated(c, keys.get("angle", 0.0) if law == "orthotropic" else 0.0) / young
    return Material(c, np.linalg.inv(c[np.ix_(flat, flat)]), law != "orthotropic", keys["density"], tuple(np.round(c, 12).ravel()) + (keys["density"],))


class Reader:
    """A namelist on its way to a `Scene`."""

    def __init__(self, path):
        found = f90nml.read(path)
        named = {name: found[name] for name in {"".join(key) for key in found.keys()}}    # keys themselves name one group of several
        self.groups = {name: [dict(one) for one in (value if isinstance(value, list) else [value])] for name, value in named.items()}
        self.one = lambda name: self.groups.get(name, [{}])[0]
        self.run, self.grid, self.method = self.one("run"), self.one("grid"), self.one("method")
        self.plane = self.run.get("plane", "stress")
        self.cell = self.grid["cell"]
        self.origin = np.array(listed(self.grid.get("lower", [0.0, 0.0])), float)
        if self.plane == "axisymmetric":
            self.origin[0] = 0.0
        used = {keys.get("material") for keys in self.groups["body"]}
        self.materials = {keys["name"]: keys for keys in self.groups["material"] if keys["name"] in used}
        self.young = max(keys.get("young_1", keys.get("young", 0.0)) for keys in self.materials.values())
        self.step = 1 if self.grid.get("order", 1) == 1 else 0.5     # between nodes [cells]

    def refuse(self):
        """Raises `Outside` for what is not linear elasticity at rest."""
        if self.method.get("time", "explicit") != "static":
            raise Outside("not static")
        for name in ("growth", "nucleation", "cohesive", "control", "cycles"):
            if name in self.groups:
                raise Outside(f"&{name}")
        if self.one("contact").get("bodies", "bonded") != "bonded":
            raise Outside("bodies that meet")
        if any(keys.get("unilateral") for keys in self.groups.get("constraint", [])):
            raise Outside("a support that only pushes")

    def place(self, values):
        """Places in cells."""
        return (np.reshape(listed(values), (-1, 2)) - self.origin) / self.cell

    def times(self):
        """Times of the rows, from 0 on."""
        return np.linspace(0, self.run["end_time"], self.method.get("load_steps", 1) + 1)

    def outline(self, keys):
        """Pieces of an outline, anticlockwise, and its box."""
        shape = keys.get("shape", "rectangle")
        if shape == "circle":
            middle, radius = self.place(keys["center"])[0], keys["radius"] / self.cell
            return [("arc", middle, radius)], middle - radius, middle + radius
        if shape == "rectangle":
            (x0, y0), (x1, y1) = self.place(keys["lower"])[0], self.place(keys["upper"])[0]
            points = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        else:
            points = self.place(keys["points"])
            x, y = points.T
            if np.dot(x, np.roll(y, -1)) < np.dot(np.roll(x, -1), y):
                points = points[::-1]
        return [("line", a, b) for a, b in zip(points, np.roll(points, -1, axis=0))], points.min(0), points.max(0)

    def body(self, keys):
        """A body."""
        pieces, lower, upper = self.outline(keys)
        if keys.get("hole"):
            return Body(pieces, None, None, lower, upper)
        e = [*listed(keys.get("eigenstrain", [0.0] * 3)), 0.0][:4]
        found = Body(pieces, material(self.materials[keys["material"]], self.plane, self.young), np.array([e[0], e[1], e[3], 2 * e[2]]), lower, upper)
        if "profile_at" in keys:
            found.direction = unit(np.array(keys.get("profile_direction", [1.0, 0.0])))
            found.at = [(x - self.origin @ found.direction) / self.cell for x in listed(keys["profile_at"])]
            found.stiffness, found.density, found.eigen = (listed(keys.get(f"profile_{name}")) or None for name in ("stiffness", "density", "eigenstrain"))
        return found

    def cracks(self, scene):
        """Cracks, cut where material ends, and their tips."""
        found = []
        for keys in self.groups.get("crack", []):
            kind, name = keys.get("kind", "symmetry"), keys.get("name", "")
            if kind == "path":
                points, ends = self.place(keys["points"]), ["last", "first"]
            elif kind == "plane" and "center" in keys:
                way = listed(keys["radii"])[0] / self.cell * np.array([1.0, 0.0] if keys["normal"] == "y" else [0.0, 1.0])
                points, ends = self.place(keys["center"])[0] + np.array([-way, way]), ["last", "first"]
            else:
                tip, direction = self.place(keys["tip"])[0], unit(np.array(listed(keys.get("direction", [1.0, 0.0]))))
                length, ends = keys.get("length", 0.0) / self.cell, ["last", "first"]
                if not length:
                    ways = sorted(t * FAR for piece in scene.pieces() for t in crossings(tip, tip - FAR * direction, piece) if t * FAR > NEAR)
                    length, ends = next((t for t in ways if scene.material_at(tip - (t + 10 * NEAR) * direction) is None), None), ["last"]
                    if length is None:
                        raise Outside("a crack that reaches no edge")
                points = np.array([tip - length * direction, tip])
            crack = Crack(points, name, keys.get("contact", "none") != "none", kind)
            for end in ends:
                way = points if end == "last" else points[::-1]
                off = min(distance(way[-1], piece) for piece in scene.pieces() if not self.seam(piece, scene))
                if kind == "symmetry" or off > 10 * NEAR and scene.material_at(way[-1]) is not None:
                    if kind != "symmetry" and off < 1e-3:
                        raise Outside("a tip next to an edge")
                    along = way[-1] - way[-2]
                    crack.tips.append(Tip(way[-1], unit(along), float(np.linalg.norm(along)), crack, end))
            found.append(crack)
        return found

    @staticmethod
    def seam(piece, scene):
        """Whether a piece of an outline is between two bodies, all along."""
        if piece[0] == "arc":
            return False
        along = np.subtract(piece[2], piece[1])
        across = 1e-4 * left_of(unit(along))
        return all(scene.material_at(piece[1] + part * along + side * across) is not None for part in (0.01, 0.3, 0.7, 0.99) for side in (-1, 1))

    def holds(self, scene):
        """Constraints. One that turns holds what is between the nodes in its box."""
        found, times = [], self.times()
        corner = (np.array(listed(self.grid.get("lower", [0.0, 0.0]))) - self.origin) / self.cell
        for keys in self.groups.get("constraint", []):
            lower, upper = self.place(keys["lower"])[0], self.place(keys["upper"])[0]
            ends, snapped = np.array([lower, upper]), False
            if keys.get("turns"):
                ends = np.array([rounding((place - corner + shift) / self.step) for rounding, place, shift in ((np.ceil, lower, -1e-6), (np.floor, upper, 1e-6))]) * self.step
                ends = np.clip(ends, [np.zeros(2), -np.inf * np.ones(2)], [np.inf * np.ones(2), self.grid["cells"]]) + corner
                corners = np.array([b for body in scene.bodies for b in (body.lower, body.upper)])
                snapped = np.any((abs(ends[0] - lower) > NEAR) & (corners.min(0) < lower - NEAR) | (abs(ends[1] - upper) > NEAR) & (corners.max(0) > upper + NEAR))
                if np.any(ends[1] < ends[0] - NEAR):
                    raise Outside("a support without nodes")
                if snapped and self.one("refine").get("indicator", "none") != "none":
                    raise Outside("a support off the lattice, with refinement")
            if np.any(listed(keys.get("velocity", 0.0))):
                raise Outside("a support with a velocity")
            if self.plane == "axisymmetric" and "y" in keys["fix"] and np.all(ends[:, 0] < NEAR) and ends[1, 1] > ends[0, 1] + NEAR:    # it gives way as the logarithm of the cells
                raise Outside("a support of a part of the axis, which has no area")
            moved = np.array(listed(keys.get("displacement", [0.0, 0.0])), float) / self.cell
            found.append(Hold(*ends, ["xy".index(c) for c in keys["fix"]], moved, [factor(keys, t) for t in times], keys.get("turns", False), keys.get("name", ""), snapped, (lower + upper) / 2))
        return found

    def loads(self, scene):
        """Loads, those on cracks as well."""
        found, times = [], self.times()
        for keys in self.groups.get("load", []):
            kind, factors = keys["kind"], [factor(keys, t) for t in times]
            box = [self.place(keys[name])[0] if name in keys else None for name in ("lower", "upper")]
            if keys.get("face", "none") != "none":
                raise Outside("a load on a face of a crack")
            if kind in ("point", "traction", "body"):
                value = np.array(keys["force"], float) / scene.force
            elif kind == "gravity":
                value = np.array(keys["acceleration"], float) * self.cell / self.young    # times the density
            elif kind == "pressure":
                value = keys["pressure"] / self.young
            else:
                raise Outside(f"a load {kind}")
            crack = ""
            if keys.get("on") == "crack":
                kind, crack = "crack", keys.get("crack", scene.cracks[0].name)
                if scene.cracks[0].kind == "symmetry":
                    raise Outside("pressure in a crack on a symmetry plane")
                next(one for one in scene.cracks if one.name == crack).pressure += value * factors[-1]
            found.append(Load(kind, *box, value, factors, crack, keys.get("name", ""), self.side(keys)))
        return found

    def side(self, keys):
        """The side of the first polygon that a load is on, or none."""
        if "side" not in keys:
            return None
        found = [body["points"] for body in self.groups["body"] if body.get("shape") == "polygon" and not body.get("hole")]
        if not found:
            raise Outside("a load on a side of a rectangle")
        points = self.place(found[0])
        return "line", points[keys["side"] - 1], points[keys["side"] % len(points)]

    def scene(self):
        """All of it."""
        self.refuse()
        bodies = [self.body(keys) for keys in self.groups["body"]]
        scene = Scene(self.plane, [b for b in bodies if b.material], [b for b in bodies if not b.material], [], [], [], self.groups.get("probe", []), self.cell, self.origin, self.young,
                      self.run.get("thickness", 1.0), self.grid.get("order", 1))
        scene.cracks = self.cracks(scene)
        scene.holds = self.holds(scene)
        scene.loads = self.loads(scene)
        return scene


def read(path):
    """The scene of a namelist; raises `Outside` where it is none that can be judged."""
    return Reader(path).scene()
