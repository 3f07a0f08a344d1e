"""Scenes drawn at random over all features and keys together, as lists of groups [name, {key: value}].

Lengths are drawn in cells, times in those that a wave takes through a cell, loads as strains. Where the program refuses a scene, the keys that its messages name are
drawn anew (`repair`). All numbers are drawn from a `random.Random`, so that a seed and a number tell a scene.
"""

import math
import random
import re

LAWS = ["linear_elastic", "linear_elastic", "linear_elastic", "neo_hookean", "mooney_rivlin", "j2_plastic", "j2_plastic", "viscoelastic", "orthotropic"]
HISTORY_KEYS = ["history", "start", "rise_time", "frequency", "times", "factors"]
# Values of keys that are drawn by themselves, when a message names them or as one change too many
CHOICES = {
    "run": {"plane": ["stress", "strain", "axisymmetric"]},
    "grid": {"order": [1, 1, 2]},
    "material": {"volumetric": ["standard", "b_bar"]},
    "body": {"points_per_cell": [1, 2, 2, 3, 4]},
    "constraint": {"unilateral": [False, True], "turns": [False, True], "fix": ["x", "y", "xy"]},
    "load": {"face": ["none", "left", "right"]},
    "contact": {"bodies": ["bonded", "stick", "frictionless", "friction"]},
    "method": {"time": ["explicit", "implicit", "static", "modal"], "start": ["undeformed", "static"], "scheme": ["musl", "usf", "usl", "usavg"], "wave_speed": ["shear", "dilatational"],
               "path": ["fastest", "reference"], "frame": ["total", "updated"], "shape_functions": ["linear", "linear", "cpdi"],
               "mass": ["lumped", "auto", "consistent", "partial", "fmpm", "weighted", "tip_weighted"], "solver": ["auto", "cg", "direct"],
               "consistent_region": ["box", "refined"], "order": [1, 2, 3], "lumped_fraction": [0.2778, 0.5], "hht_alpha": [0.0, -0.1], "courant": [0.0, 0.05, 0.1]},
    "refine": {"indicator": ["none", "tip", "zz", "gradient"], "field": ["energy_density", "stress_norm", "speed"], "max_level": [1, 2], "rings": [2, 3, 4],
               "tolerance": [0.05, 0.1, 0.2], "r_crit": [0.03, 0.1], "r_coarsen": [0.0, 0.01], "energy_floor": [1e-3, 0.1], "interval": [5, 20]},
    "crack": {"contact": ["none", "frictionless", "friction"], "kind": ["path", "line", "plane", "symmetry"]},
    "cohesive": {"law": ["linear", "bilinear", "table"], "mixed_mode": ["benzeggagh_kenane", "power"]},
    "growth": {"law": ["quasi_static", "prescribed", "toughness", "fatigue", "subcritical"], "rate": ["paris", "walker", "forman", "charles", "toughness"], "direction": ["straight", "hoop_stress", "local_symmetry", "max_energy"],
               "tips": ["all", "largest", "last", "first"]},
    "cycles": {"repeat": [False, True]},
    "energy_release": {"estimators": [["domain_integral"], ["vcct"], ["stress_closure"], ["material_force"], [],
                                      ["domain_integral", "vcct"]], "energy_balance": [False, True], "t_stress": [False, True]},
}
REMEMBER = ["j2_plastic", "viscoelastic"]
REQUIRED = {"run", "grid", "material", "body"}


def value_text(value):
    """A value as a namelist has it."""
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, (list, tuple)):
        return ", ".join(value_text(one) for one in value)
    return f"'{value}'" if isinstance(value, str) else repr(value)


def text_of(scene):
    """A scene as a namelist, a group a line."""
    return "".join(f"&{name} " + "  ".join(f"{key} = {value_text(value)}" for key, value in keys.items()) + " /\n" for name, keys in scene)


def groups(scene, name):
    """The keys of all groups of a name."""
    return [keys for group, keys in scene if group == name]


def group(scene, name):
    """The keys of the first group of a name, {} where there is none."""
    return next(iter(groups(scene, name)), {})


def copy_of(scene):
    """A scene that may be changed without changing this one."""
    return [[name, {key: list(value) if isinstance(value, list) else value for key, value in keys.items()}] for name, keys in scene]


def mouths(scene):
    """Of cracks with names that end at edges of rectangles: the name, the axis across the edge, its place along that, the ends of the edge and the place of the mouth between them."""
    found = []
    for crack in groups(scene, "crack"):
        if "name" not in crack or "length" in crack or not ("points" in crack or {"tip", "direction"} <= set(crack)):
            continue
        points = crack.get("points") or [x - 1e4 * d for x, d in zip(crack["tip"], crack["direction"])] + crack["tip"]
        for body in groups(scene, "body"):
            if len(points) < 4 or body.get("shape", "rectangle") != "rectangle":
                continue
            for axis, side, at in [(axis, side, 0) for axis in (0, 1) for side in ("lower", "upper")] + [(axis, side, -4) for axis in (0, 1) for side in ("lower", "upper")]:
                line, place = points[at:][:4], body[side][axis]
                across, along = line[axis::2], line[1 - axis::2]
                if (across[0] - place) * (across[1] - place) < 0:
                    mouth = along[0] + (place - across[0]) / (across[1] - across[0]) * (along[1] - along[0])
                    low, high = body["lower"][1 - axis], body["upper"][1 - axis]
                    if low < mouth < high:
                        found.append((crack["name"], axis, place, low, high, mouth))
    return found


class Drawing:
    """One scene as it is drawn: what its groups have to agree on."""

    def __init__(self, chance, cracked=False):
        self.chance, self.cracked = chance, cracked
        self.cell = chance.choice([1e-3, 2.0**-10, 0.25, 1.0, 0.03])
        self.origin = [chance.choice([0.0, 0.0, 3.0, -7.5, chance.uniform(-9, 9)]) for _ in "xy"]
        self.young, self.density = chance.choice([(70e9, 2700.0), (1e4, 1000.0), (3e9, 1200.0)])
        self.poisson = chance.choice([0.0, 0.25, 0.3, 0.3, 0.4, 0.49])
        self.strain = 10 ** chance.uniform(-5, -3)
        self.tick = self.cell / math.sqrt(self.young / self.density)
        self.time = chance.choices(["static", "explicit", "implicit"], [4, 5, 2])[0]
        self.frame = "updated" if self.time == "explicit" and chance.random() < 0.4 else "total"
        self.order = 2 if self.frame == "total" and chance.random() < 0.2 else 1
        self.crack = chance.choices(["none", "symmetry", "line", "path"], [0 if cracked else 2, 2, 2, 5])[0]
        self.grows = self.crack != "none" and (self.frame == "total" or self.crack != "symmetry") and self.order == 1 and chance.random() < (0.7 if self.time == "implicit" else 0.25)
        self.holds = self.crack != "none" and self.frame == "total" and (self.order == 1 or self.crack != "symmetry") and not (self.grows and (self.time == "static" or self.crack == "symmetry")) and chance.random() < 0.3
        self.shaped = self.crack != "symmetry" and not self.grows and chance.random() < 0.35
        self.waits = self.time == "static" and self.crack in ("line", "path") and not self.holds and chance.random() < 0.2   # for a crack that appears
        small = self.crack == "none"
        self.size = [chance.randint(4, 9) if small else chance.randint(9, 12) + 2 * self.grows for _ in "xy"]
        self.margin = 3 if self.frame == "updated" else chance.choice([0, 1])
        self.end = self.tick * {"static": 10, "explicit": chance.uniform(6, 25), "implicit": chance.uniform(20, 200)}[self.time]
        self.law = chance.choice(["quasi_static", "quasi_static", "fatigue", "subcritical"])  # at rest
        if self.waits:
            self.grows = False
        self.laws = [law for law in LAWS if not (self.grows or self.waits) or law not in (REMEMBER if self.time != "explicit" else ["orthotropic"])]
        if self.grows and self.time == "implicit" or self.waits:
            self.laws = [law for law in self.laws if law == "linear_elastic" or law == "orthotropic" and self.waits or self.grows and law not in ("orthotropic",)]
        self.thickness = chance.choice([1.0, 1.0, 0.01, 3.0])
        self.plane = chance.choice(["stress", "strain", "stress", "strain", "axisymmetric"])
        if self.plane == "axisymmetric":                                   # x is the radius, and the lattice ends at the axis
            self.origin[0] = chance.choice([0.0, 0.0, 2.0, 20.0])

    def place(self, x, y):
        """A place given in cells from the lower corner of the body."""
        return [(self.origin[0] + x) * self.cell, (self.origin[1] + y) * self.cell]

    def box(self, x0, y0, x1, y1):
        """The two keys of a box."""
        return {"lower": self.place(x0, y0), "upper": self.place(x1, y1)}

    def material(self, name, law):
        """The keys of a material."""
        chance = self.chance
        stiff = chance.choice([1.0, 1.0, 0.3, 3.0]) if name != "m0" else 1.0
        if law == "mooney_rivlin" and self.poisson == 0:
            law = "neo_hookean"                                            # c01 may be at most proportional to it
        young, keys = self.young * stiff, {"name": name, "law": law}
        if law == "orthotropic":
            keys |= {"young_1": young, "young_2": 0.4 * young, "young_3": 0.3 * young, "shear_12": 0.2 * young, "poisson_12": 0.3, "poisson_13": 0.2,
                     "poisson_23": 0.25, "angle": chance.choice([0.0, 90.0, 30.0, -50.0])}
        else:
            keys |= {"young": young, "poisson": self.poisson}
        keys["density"] = self.density * chance.choice([1.0, 1.0, 2.0])
        if law == "j2_plastic":
            keys |= {"yield_stress": young * self.strain * chance.choice([0.2, 1.0, 5.0]), "hardening": young * chance.choice([0.0, 0.1])}
            if chance.random() < 0.5:
                keys |= {"saturation": young * self.strain * chance.choice([0.1, 1.0]), "saturation_strain": self.strain * chance.choice([0.1, 1.0]),
                         "kinematic_hardening": young * chance.choice([0.0, 0.05])}
        if law == "mooney_rivlin":
            keys["c01"] = young / (4 * (1 + self.poisson)) * min(1.0, self.poisson / (1 - 2 * self.poisson)) * chance.choice([0.1, 0.5, 1.0])
        if law == "viscoelastic":
            keys |= {"moduli": [0.1 * young, 0.05 * young], "relaxation_times": [self.end / 20, self.end]}
        if chance.random() < (0.3 if law in REMEMBER else 0.1) and not (self.time != "explicit" and law in ("neo_hookean", "mooney_rivlin")):
            keys["volumetric"] = "b_bar"
        return keys

    def motion(self, keys):
        """Adds what a body does at the start."""
        chance = self.chance
        speed = self.strain * self.cell / self.tick
        if self.time != "static" and chance.random() < 0.4:
            keys["velocity"] = [chance.uniform(-1, 1) * speed, chance.uniform(-1, 1) * speed]
        if self.time != "static" and self.plane != "axisymmetric" and chance.random() < 0.2:
            keys["spin"] = chance.uniform(-1, 1) * speed / (5 * self.cell)
        if chance.random() < 0.15:
            keys["eigenstrain"] = [chance.uniform(-1, 1) * self.strain, chance.uniform(-1, 1) * self.strain,
                                   0.0 if self.crack == "symmetry" else chance.choice([0.0, self.strain])]
            if self.grows and self.time == "static" and chance.random() < 0.6:
                keys["held"] = False
        return keys

    def bodies(self):
        """The groups of bodies and materials."""
        chance, (w, h) = self.chance, self.size
        law = chance.choice(self.laws)
        points = {"points_per_cell": chance.choice([3, 4]) if self.order == 2 else chance.choice([1, 2, 2, 2, 2, 3, 4])}
        materials, first = [self.material("m0", law)], {"material": "m0"} | points
        found = []
        self.sides, self.hole, self.round, self.wide = 0, None, False, [0, 0, w, h]
        if self.shaped:
            kind = chance.choice(["circle", "polygon", "hole", "hole"])
            r = min(w, h) / 2
            if kind == "circle":
                first |= {"shape": "circle", "center": self.place(w / 2 + chance.uniform(-0.2, 0.2), h / 2 + chance.uniform(-0.2, 0.2)), "radius": chance.uniform(0.8, 1) * (r - 0.2) * self.cell}
            elif kind == "polygon":
                corners = chance.randint(4, 7)
                angles = [2 * math.pi * (k + chance.uniform(0, 0.7)) / corners for k in range(corners)]
                points_of = [self.place(w / 2 + chance.uniform(0.6, 1) * r * math.cos(a), h / 2 + chance.uniform(0.6, 1) * r * math.sin(a)) for a in angles]
                first |= {"shape": "polygon", "points": [x for point in points_of for x in point]}
                self.sides = len(points_of)
            else:
                first |= self.box(0, 0, w, h)
        elif chance.random() < 0.2 and self.crack != "symmetry" and self.order == 1:
            self.wide = [chance.choice([0, 0.5]), 0, w - chance.choice([0.25, 0.5]), h - chance.choice([0, 0.3])]
            first |= self.box(*self.wide)
        else:
            first |= self.box(0, 0, w, h)
        found.append(["body", self.motion(first)])
        self.width, self.beside = w, False
        self.round = self.shaped and kind != "hole"
        if chance.random() < 0.3 and not self.shaped and (self.frame == "updated" or self.wide[2] == w):  # a second body, bonded or met
            wide = chance.randint(2, 4)
            other = {"material": chance.choice(["m0", "m1"])} | points
            gap = chance.choice([0, 0, 1, 1.3]) if self.frame == "updated" else 0
            other |= self.box(w + gap, 0, w + gap + wide, h)
            self.beside = True
            self.motion(other)
            if gap or self.frame == "updated":
                other["velocity"] = [-self.strain * self.cell / self.tick * chance.choice([10, 100]), 0.0]
            if other["material"] == "m1":
                materials.append(self.material("m1", chance.choice([law, law, *self.laws])))
            found.append(["body", other])
            self.width = w + gap + wide
            if self.frame == "updated" and chance.random() < 0.8:
                kind = chance.choice(["stick", "frictionless", "friction"])
                found.append(["contact", {"bodies": kind} | ({"friction": chance.choice([0.1, 0.6])} if kind == "friction" else {})
                              | ({"distance": 0.1 * self.cell} if chance.random() < 0.2 else {})])
        if self.shaped and (kind == "hole" or chance.random() < 0.3):
            r = chance.uniform(0.15, 0.3) * min(w, h) * (0.6 if self.round else 1)
            self.hole = [w / 2 + chance.uniform(-1, 1), h / 2 + chance.uniform(-1, 1), r]
            found.append(["body", {"hole": True, "shape": "circle", "center": self.place(*self.hole[:2]), "radius": r * self.cell}])
        if chance.random() < 0.1:
            materials.append(self.material("spare", chance.choice(LAWS)))
        chance.shuffle(materials)
        return [["material", keys] for keys in materials] + found

    def history(self, motion=False):
        """Keys of a history."""
        chance = self.chance
        kind = chance.choice(["ramp", "smooth_ramp", "sine", "table"] if motion and self.time != "static" else ["step", "step", "ramp", "smooth_ramp", "sine", "table"])
        keys = {"history": kind} if kind != "step" else {}
        if kind in ("ramp", "smooth_ramp"):
            keys["rise_time"] = chance.choice([0.3, 1.0, 2.0]) * self.end
        if kind == "sine":
            keys["frequency"] = chance.choice([0.3, 0.6]) / self.end
        if kind == "table":
            keys |= {"times": [0.0, 0.4 * self.end, self.end], "factors": [0.0, 1.0, chance.choice([0.5, 1.0, -0.5])]}
        if chance.random() < 0.15:
            keys["start"] = chance.choice([0.1, 0.3, -0.1]) * self.end
        if (self.grows or self.waits) and self.time == "static" and chance.random() < 0.3:
            keys["held"] = True
        return keys

    def cracks(self):
        """The groups of cracks, their cohesion and their growth."""
        chance, (w, h) = self.chance, self.size
        if self.crack == "none":
            return []
        if self.crack == "symmetry":
            self.tip = chance.randint(3, w - 4)
            found = [["crack", {"kind": "symmetry", "tip": self.place(self.tip, 0)}],
                     ["constraint", self.box(self.tip, 0, self.width, 0) | {"fix": "y", "name": "plane"}]]
        else:
            found, number = [], chance.choices([1, 2, 3], [6, 2, 1])[0] if not self.grows else chance.choice([1, 1, 2])
            places = {1: [(0.5, 0.5)], 2: [(0.3, 0.35), (0.7, 0.65)], 3: [(0.25, 0.3), (0.75, 0.3), (0.5, 0.75)]}[number]
            for k, (x, y) in enumerate(places):
                if len(found) < k:
                    break
                drawn = self.line if self.crack == "line" and (k == 0 or chance.random() < 0.5) else self.path
                for turn in range(20):
                    found[k:] = [["crack", drawn(k, x * w + chance.uniform(-0.5, 0.5), y * h + chance.uniform(-0.5, 0.5), 1 / number)]]
                    if all(self.is_solid(*tip, 1.3 * self.cell) and all(self.distance(tip, other) > 1.2 * self.cell for _, other in found[:k])
                           for tip in self.tips(found[k][1])) and all(self.distance(tip, found[k][1]) > 1.2 * self.cell for _, other in found[:k] for tip in self.tips(other)):
                        break
                    if turn == 19 and k:
                        del found[k:]
                    x, y = chance.uniform(0.2, 0.8), chance.uniform(0.2, 0.8)
        held = []
        if self.holds:                                                     # of cracks that grow the first one does
            held = [keys for name, keys in found if name == "crack" and (keys.get("name", "c0") == f"c{int(self.grows)}" or not self.grows and chance.random() < 0.5)]
            found += [["cohesive", self.cohesive(keys)] for keys in held]
        if self.grows:
            law = self.law if self.time == "static" else chance.choice(["prescribed", "toughness"])
            for keys in [keys for name, keys in found if name == "crack"]:
                if keys not in held and ("name" not in keys or keys["name"] == "c0" or chance.random() < 0.5):
                    found.append(["growth", self.growth(law, keys)])
        if self.waits:
            cracks = [keys for name, keys in found if name == "crack"]
            for keys in cracks:
                keys |= {"contact": "none"}
                keys.pop("friction", None)
            for keys in cracks[:1] + [keys for keys in cracks[1:] if chance.random() < 0.5]:
                found.append(["nucleation", self.nucleation(keys)])
        return found

    def nucleation(self, crack):
        """The keys of a crack that appears."""
        chance = self.chance
        return {"crack": crack["name"], "toughness": self.young * self.strain**2 * self.cell * 10 ** chance.uniform(-1, 1.5),
                "strength": chance.choice([0.0, self.young * self.strain * 10 ** chance.uniform(-2, 0.5)]), "increment": chance.choice([0.0, 1.0, 1.3]) * self.cell}

    def path(self, number, x, y, room):
        """The keys of a crack of kind path around a place [cells]."""
        chance, (w, h) = self.chance, self.size
        least = 2.3 if self.grows else 1.2 * self.order
        half, angle = chance.uniform(least, max(least, 0.28 * min(w, h) * max(room, 0.6))), chance.choice([0, 45, 90, 30, chance.uniform(0, 180)])
        if chance.random() < 0.3:
            x, y = round(2 * x) / 2, round(2 * y) / 2
        dx, dy = half * math.cos(math.radians(angle)), half * math.sin(math.radians(angle))
        points = [[x - dx, y - dy], [x + dx, y + dy]]
        if chance.random() < 0.3 and room == 1:                            # from the surface
            points[0] = [-0.5, y - dy]
        if chance.random() < 0.2 and half > 1.5 * least:
            s = chance.uniform(-0.4, 0.4)
            points.insert(1, [(points[0][0] + points[1][0]) / 2 - s * dy, (points[0][1] + points[1][1]) / 2 + s * dx])
        if self.cracked and chance.random() < 0.4:                         # on particles, nodes, and the edges of cells
            part = chance.choice([1, 2, 4, 6, 8])
            points = [[round(part * x) / part for x in point] for point in points]
        return {"kind": "path", "name": f"c{number}", "points": [x for point in points for x in self.place(*point)]} | self.faces()

    def line(self, number, x, y, room):
        """The keys of a crack of kind line whose tip is near a place [cells]: half of them along grid lines from node to node, the others anywhere."""
        chance, angle = self.chance, self.chance.choice([None, None, 45, 30, self.chance.uniform(0, 360)])
        if angle is None:
            x, y, direction = round(x), round(y), chance.choice([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        else:
            direction = [math.cos(math.radians(angle)), math.sin(math.radians(angle))]
        keys = {"kind": "line", "name": f"c{number}", "tip": self.place(x, y), "direction": direction}
        if chance.random() < 0.5 or room < 1:
            keys["length"] = (chance.randint(2, 4) if angle is None else chance.uniform(2.3 if self.grows else 1.5 * self.order, 4)) * self.cell
        if angle is None and chance.random() < 0.7:                        # in a plane of the grid
            keys |= {"kind": "plane", "normal": "y" if direction[0] else "x"}
            if "length" in keys and chance.random() < 0.5:                 # between its tips
                half = keys.pop("length") / 2
                tip, direction = keys.pop("tip"), keys.pop("direction")
                keys |= {"front": "disc", "center": [a - half * b for a, b in zip(tip, direction)], "radii": [half]}
        return keys | self.faces()

    def is_solid(self, x, y, away=0.0):
        """Whether a place is in the first body, so far from its surface, where that is known."""
        x, y, away = x / self.cell - self.origin[0], y / self.cell - self.origin[1], away / self.cell
        x0, y0, x1, y1 = self.wide
        near = math.hypot(x - self.size[0] / 2, y - self.size[1] / 2) < 0.55 * min(self.size) / 2 - away if self.round else x0 + away < x < x1 - away and y0 + away < y < y1 - away
        return near and not (self.hole and math.hypot(x - self.hole[0], y - self.hole[1]) < self.hole[2] + away)

    def tips(self, crack):
        """Ends of a crack that are tips: all but those outside of the body."""
        return [end for end in self.ends(crack) if not end[0] < self.place(0, 0)[0]]

    def ends(self, crack):
        """Ends of a crack: two, or one of a line that has no length."""
        if "points" in crack:
            return [crack["points"][:2], crack["points"][-2:]]
        if "center" in crack:
            along = 1 if crack["normal"] == "x" else 0
            return [[x + s * crack["radii"][0] * (d == along) for d, x in enumerate(crack["center"])] for s in (-1, 1)]
        return [crack["tip"]] + ([[x - crack["length"] * d for x, d in zip(crack["tip"], crack["direction"])]] if "length" in crack else [])

    def distance(self, place, crack):
        """Of a place from a crack."""
        points = [crack["points"][k:k + 2] for k in range(0, len(crack["points"]), 2)] if "points" in crack else self.ends(crack)
        if len(points) == 1:
            points = [points[0], [x - 20 * self.cell * d for x, d in zip(crack["tip"], crack["direction"])]]
        return min(math.dist(place, [a + k / 20 * (b - a) for a, b in zip(p, q)]) for p, q in zip(points, points[1:]) for k in range(21))

    def has_two_tips(self, crack):
        """Whether both ends of a crack are tips."""
        return crack["kind"] != "symmetry" and len(self.tips(crack)) == 2

    def faces(self):
        """The keys of the contact of faces."""
        kind = self.chance.choice(["none", "none", "none", "frictionless", "friction"])
        return {"contact": kind} | ({"friction": self.chance.choice([0.2, 0.7])} if kind == "friction" else {})

    def cohesive(self, crack):
        """The keys of a cohesion of a path, whose zone is some cells long."""
        chance = self.chance
        strength = self.young * self.strain * 10 ** chance.uniform(-1, 0.5)
        toughness = strength**2 * self.cell / self.young * 10 ** chance.uniform(0, 1.5)
        keys = {"law": chance.choice(["linear", "bilinear", "table"])}
        if keys["law"] == "table":
            keys |= {"openings": [0.0, 0.2 * toughness / strength, 2.5 * toughness / strength], "tractions": [strength, 0.7 * strength, 0.0]}
        else:
            keys |= {"strength": strength, "toughness": toughness}
        if keys["law"] == "bilinear":
            keys["opening"] = chance.choice([0.1, 0.5]) * toughness / strength
        if crack["kind"] == "symmetry":
            return keys
        keys["crack"] = crack["name"]
        if chance.random() < 0.5:
            keys |= {"strength_shear": chance.choice([0.7, 1.5]) * strength, "toughness_shear": chance.choice([1.0, 3.0]) * toughness,
                     "mixed_mode": chance.choice(["benzeggagh_kenane", "power"]), "exponent": chance.choice([1.0, 1.5])}
        if chance.random() < 0.5:
            keys["from"] = chance.choice([0.3, 0.5]) * (math.dist(crack["points"][:2], crack["points"][2:4]) if "points" in crack else 2 * self.cell)
        return keys

    def growth(self, law, crack):
        """The keys of a growth."""
        chance = self.chance
        modulus = self.young * self.strain**2 * self.cell
        keys = {"law": law, "direction": chance.choice(["straight", "hoop_stress", "local_symmetry", "max_energy"]), "tips": chance.choice(["all", "all", "largest" if law == "quasi_static" else "last"])}
        if crack["kind"] == "symmetry":
            keys |= {"direction": "straight", "tips": "all"}
        else:
            keys["crack"] = crack["name"]
        if law == "fatigue":
            return keys | {"increment": chance.choice([2.0, 3.0, 4.0]) * self.cell} | self.fatigue(modulus)
        if law == "subcritical":
            return keys | {"increment": chance.choice([2.0, 3.0, 4.0]) * self.cell} | self.subcritical(modulus)
        if law == "prescribed":
            keys["speed"] = chance.choice([0.05, 0.1, 0.2]) * self.cell / self.tick
        else:
            keys["toughness"] = modulus * 10 ** chance.uniform(-1, 1.5)
        if law == "quasi_static":
            keys["increment"] = chance.choice([2.0, 3.0]) * self.cell
        elif chance.random() < 0.3:
            keys |= {"start": 0.2 * self.end, "end": 0.8 * self.end}
        if chance.random() < 0.2:
            keys["max_length"] = 8 * self.cell
        if law != "prescribed" and chance.random() < 0.5:
            keys |= self.resistance(law, keys["toughness"])
        return keys

    def resistance(self, law, toughness):
        """Of a growth: keys on which its toughness depends."""
        chance, keys = self.chance, {}
        if chance.random() < 0.4:
            keys |= {"extensions": [0.0, chance.choice([0.5, 2.0, 5.0]) * self.cell], "extension_factors": [1.0, chance.choice([0.6, 1.5, 3.0])]}
        if chance.random() < 0.4:
            keys |= {"angles": [chance.choice([-50.0, -20.0, 0.0]), chance.choice([10.0, 35.0, 60.0]), 90.0], "angle_factors": [chance.uniform(0.7, 2.0) for _ in range(3)]}
        if law == "toughness" and chance.random() < 0.4:
            keys |= {"speeds": [0.0, chance.choice([0.1, 0.4]) * self.cell / self.tick], "speed_factors": [1.0, chance.choice([0.7, 2.0])]}
        if chance.random() < 0.4:
            keys |= chance.choice([{"mixed_mode": "hutchinson_suo", "lambda": chance.choice([0.0, 0.3, 1.0])},
                                   {"mixed_mode": "benzeggagh_kenane", "toughness_shear": chance.choice([0.5, 3.0]) * toughness, "mixed_mode_exponent": chance.choice([1.0, 1.6])}])
        return keys

    def fatigue(self, modulus):
        """The keys of the rate of growth in load cycles."""
        chance, rate, m = self.chance, self.chance.choice(["paris", "paris", "walker", "forman"]), self.chance.choice([2.0, 3.0, 4.0])
        keys = {"tips": "all", "rate": rate, "rate_exponent": m, "rate_constant": self.cell * 1e-4 / (modulus * self.young) ** ((m - (rate == "forman")) / 2)}
        if rate == "walker":
            keys["walker_exponent"] = chance.choice([0.5, 0.7])
        if rate == "forman" or chance.random() < 0.2:
            keys["toughness"] = modulus * chance.choice([10.0, 100.0])
        if chance.random() < 0.2:
            keys["threshold"] = 0.3 * math.sqrt(modulus * self.young)
        if chance.random() < 0.2:
            keys |= {"wheeler_exponent": chance.choice([1.0, 1.5]), "wheeler_stress": self.young * self.strain * chance.choice([3.0, 10.0])}
        if "toughness" in keys and chance.random() < 0.7:
            keys |= self.resistance("fatigue", keys["toughness"])
        return keys

    def subcritical(self, modulus):
        """The keys of growth in time."""
        chance, rate, speed = self.chance, self.chance.choice(["charles", "toughness"]), self.cell * 10 ** self.chance.uniform(-0.5, 1) / self.end
        if rate == "charles":
            keys = {"toughness": modulus * chance.choice([3.0, 10.0, 100.0]), "speed": 10 * speed, "rate_exponent": chance.choice([2.0, 5.0, 16.0])}
            if chance.random() < 0.2:
                keys["threshold"] = 0.3 * math.sqrt(modulus * self.young)
        else:
            keys = {"toughness": modulus * 10 ** chance.uniform(-1.5, 0.5)}
            if chance.random() < 0.6:
                keys |= {"limit_speed": speed, "exponent": chance.choice([0.5, 1.0, 2.0])}
            else:
                keys |= {"speeds": [0.0, 0.1 * speed, speed], "speed_factors": [1.0, 1.3, chance.choice([2.0, 30.0])]}
        if chance.random() < 0.4:
            keys |= self.resistance("subcritical", keys["toughness"])
        return keys | {"tips": "all", "rate": rate}

    def cycles(self):
        """The keys of the load cycles."""
        chance, keys = self.chance, {"ratio": self.chance.choice([0.0, 0.1, 0.5, -1.0])}
        if chance.random() < 0.5:
            n = chance.randint(1, 4)
            keys |= {"blocks": [chance.choice([1.0, 100.0, 3e4]) for _ in range(n)], "factors": [chance.choice([1.0, 1.0, 0.7, 1.5]) for _ in range(n)], "repeat": chance.random() < 0.5}
            if chance.random() < 0.5:
                keys["ratios"] = [chance.choice([0.0, 0.3, -0.5]) for _ in range(n)]
                del keys["ratio"]
        return keys

    def constraints(self):
        """The groups of constraints."""
        chance, (w, h) = self.chance, self.size
        found, name = [], iter("abc")
        move = self.strain * self.cell * h
        kind = chance.choice(["none", "low", "corner", "sides", "moved", "moved", "push", "pins"]) if self.time != "static" else chance.choice(
            ["low", "low", "sides", "moved", "moved", "corner", "push", "pins"])
        symmetric = self.crack == "symmetry"
        if kind in ("low", "moved", "push") and not symmetric:
            found.append(self.box(-1 if self.shaped else 0, -0.5 if self.shaped else 0, self.width + self.shaped, 0.3 * h if self.round else 1.2 if self.shaped else 0)
                         | {"fix": chance.choice(["y", "xy", "xy"])})
            if kind == "push" and self.time != "explicit" and not (self.shaped or self.waits):
                found[-1] |= {"fix": "y", "unilateral": True}
        if kind in ("corner", "sides", "moved") and self.round:
            kind = "low"
            found.append(self.box(-1, -0.5, self.width + 1, 0.3 * h) | {"fix": "xy"})
        if kind == "corner" and not symmetric:
            found.append(self.box(0, 0, 1, 0) | {"fix": "xy"})
            found.append(self.box(w - 1, 0, w, 0) | {"fix": "y"})
        if kind == "sides":
            found.append(self.box(0, 1, self.wide[0], h) | {"fix": chance.choice(["x", "xy"])})
        if kind == "moved":
            fix = chance.choice(["y", "xy"])
            amount = [chance.uniform(-1, 1) * move if fix == "xy" else 0.0, chance.uniform(-1, 1) * move]
            if chance.random() < 0.3 and self.time != "static":
                found.append(self.box(0, math.floor(self.wide[3]), self.width, h) | {"fix": fix, "velocity": [a / self.end for a in amount]})
            else:
                found.append(self.box(0, math.floor(self.wide[3]), self.width, h) | {"fix": fix, "displacement": amount} | self.history(motion=True))
        if kind == "pins" and not symmetric:                               # a pin in the material, and another one or a roller
            found.append(self.box(0.7, 0.2, 3.3, 2.8) | {"fix": "xy", "turns": True})
            found.append(self.box(w - 3.3, 0.2, w - 0.7, 2.8) | {"fix": chance.choice(["y", "xy"]), "turns": True})
            if chance.random() < 0.5:
                found[-1] |= {"displacement": [0.0, chance.uniform(-1, 1) * move]} | self.history(motion=True)
        for keys in found:
            if "unilateral" not in keys and chance.random() < 0.1:
                keys["turns"] = True
            if chance.random() < 0.8:
                keys["name"] = next(name)
        return [["constraint", keys] for keys in found]

    def loads(self):
        """The groups of loads."""
        chance, (w, h) = self.chance, self.size
        found = []
        force = self.strain * self.young * w * self.cell * self.thickness
        for _ in range(chance.choices([0, 1, 2, 3], [1, 4, 3, 1])[0]):
            kind = chance.choice(["traction", "traction", "point", "body", "pressure", "pressure", "gravity", "crack"] + (["absorbing"] if self.time != "static" and self.order == 1 else []))
            direction = [chance.choice([0.0, chance.uniform(-1, 1)]) * force, chance.uniform(-1, 1) * force]
            x0, y0, x1, y1 = self.wide
            edges = [(x0, y1, x1, y1), (x0, y1, x1, y1)] + [(x0, y0, x0, y1)] * (self.plane != "axisymmetric" or x0 + self.origin[0] > 0) + [(x1, y0, x1, y1)] * (not self.beside)
            if self.shaped:
                edges = [(-1, h / 2, w + 1, h + 1), (-1, -1, w / 2, h + 1)] + edges[:1] * (not self.round)
            edge = chance.choice(edges)
            where = self.box(*edge)
            if self.sides and chance.random() < 0.5:
                where = {"side": chance.randint(1, self.sides)} | (where if chance.random() < 0.2 else {})
            if kind == "traction":
                keys = {"kind": kind, "force": direction} | where
            elif kind == "point":
                places = [(x0 + (x1 - x0) / 2, y1), (x1, y1), (x0, y1 / 2), (w / 3, h / 4)] if not self.round else [(w / 2, h / 2 + 1), (0.6 * w, h / 2)]
                place = chance.choice([place for place in places if not self.hole or math.dist(place, self.hole[:2]) > self.hole[2]] or [(x1, y1)])
                keys = {"kind": kind, "force": [0.2 * f for f in direction]} | self.box(*place, *place)
            elif kind == "body":
                keys = {"kind": kind, "force": direction} | self.box(0, h / 2 + 0.07, w, h)    # no particle on its edge, for rounding to decide
            elif kind == "pressure":
                keys = {"kind": kind, "pressure": chance.choice([-1, 1]) * self.strain * self.young} | where
            elif kind == "absorbing":
                found.append(["load", {"kind": kind} | where])
                continue
            elif kind == "gravity":
                keys = {"kind": kind, "acceleration": [f / (self.density * w * h * self.cell**2 * self.thickness) for f in direction]}
            elif self.crack in ("path", "line") and not (self.shaped or self.waits or self.grows and self.time != "static"):
                keys = {"kind": "pressure", "on": "crack", "pressure": chance.choice([-0.5, 1, 1]) * self.strain * self.young, "crack": "c0"}
            else:
                continue
            found.append(["load", keys | self.history()])
        return found

    @staticmethod
    def without_history(scene):
        """What is not held has no history of its own."""
        for keys in groups(scene, "load") + groups(scene, "constraint"):
            if not keys.get("held"):
                for key in HISTORY_KEYS:
                    keys.pop(key, None)

    def control(self, scene):
        """The keys of a load frame; of the scene what it drives has no history of its own."""
        chance, move = self.chance, self.strain * self.cell * self.size[1]
        forces = any(not keys.get("held") for keys in groups(scene, "load"))
        for keys in groups(scene, "constraint"):
            if forces and "displacement" in keys:
                keys["held"] = True
        self.without_history(scene)
        keys = {"quantity": chance.choice(["growth", "load", "displacement", "displacement"]), "stiffness": chance.choice([0.0, 0.1, 1.0]) * self.young * self.thickness}
        if keys["quantity"] == "displacement":
            keys["displacement"] = chance.choice([0.3, 1.0, 3.0]) * move
        if keys["quantity"] != "growth":
            keys |= chance.choice([{}, {"history": "ramp", "rise_time": 0.8 * self.end},
                                   {"history": "table", "times": [0.0, 0.4 * self.end, 0.7 * self.end, self.end], "factors": [0.0, 1.0, 0.4, 1.2]}])
        return keys

    def method(self):
        """The keys of the method."""
        chance = self.chance
        keys = {"time": self.time}
        if self.frame != "total":
            keys["frame"] = self.frame
        if self.time == "static":
            keys["load_steps"] = chance.choice([1, 1, 2, 4])
        if self.time == "implicit":
            keys["time_step"] = self.end / chance.choice([20, 40])
            if chance.random() < 0.3:
                keys["hht_alpha"] = -0.1
        if self.time != "static" and chance.random() < 0.25:
            keys["start"] = "static"
        if self.time == "explicit" and chance.random() < 0.6:
            keys["scheme"] = chance.choice(["musl", "usf", "usl", "usavg"])
        if self.frame == "updated" and self.crack == "none" and chance.random() < 0.3:
            keys["shape_functions"] = "cpdi"
        if self.order == 2 and self.time != "static" and (self.shaped or self.crack in ("path", "line") or self.plane == "axisymmetric"):
            keys |= {"mass": "consistent", "solver": "direct"}
        elif chance.random() < 0.5:
            keys["mass"] = chance.choice(["lumped", "consistent", "partial", "weighted", *["fmpm"] * (self.time != "implicit")] if self.order == 1 or self.plane != "axisymmetric" else ["consistent"])
            if keys["mass"] == "fmpm":
                keys["order"] = chance.choice([1, 2, 3])
            if keys["mass"] == "partial":
                box = self.box(1, 1, 5, 5)
                keys |= {"consistent_lower": box["lower"], "consistent_upper": box["upper"]}
            if keys["mass"] in ("consistent", "partial", "weighted") or self.time != "explicit":
                keys["solver"] = chance.choice(["auto", "cg", "direct"])
        return keys

    def refine(self):
        """The group of refinement, or none."""
        chance, (w, h) = self.chance, self.size
        if chance.random() < 0.55:
            return []
        keys = {"indicator": chance.choice(["tip", "tip", "zz", "gradient"] if self.crack != "none" else ["zz", "gradient"]), "max_level": chance.choice([1, 1, 2]),
                "max_particles": 4000}
        if keys["indicator"] == "tip":
            keys["rings"] = chance.choice([2, 3, 4])
        elif self.time != "static":
            keys["interval"] = chance.choice([5, 20])
        if keys["indicator"] == "zz":
            keys["tolerance"] = chance.choice([0.05, 0.1, 0.2])
        if keys["indicator"] == "gradient":
            keys["field"] = chance.choice(["energy_density", "stress_norm", "speed"])
            if chance.random() < 0.5:
                keys |= {"r_crit": 0.1, "r_coarsen": chance.choice([0.0, 0.02])}
        if chance.random() < 0.15:
            box = self.box(1, 1, w - 1, h - 1)
            keys |= {"region_lower": box["lower"], "region_upper": box["upper"]}
        return [["refine", keys]]

    def energy_release(self):
        """The keys of what is recorded of energy."""
        chance = self.chance
        names = []
        if self.crack != "none" and (self.grows or chance.random() < 0.8):
            names.append("domain_integral")
        if self.crack in ("line", "symmetry") and not (self.grows or self.holds):
            names += [name for name in ("vcct", "stress_closure") if chance.random() < 0.4]
        if self.crack != "none" and not (self.grows or self.holds) and chance.random() < 0.25:
            names.append("material_force")
        keys = {"estimators": names} | ({"energy_balance": True} if chance.random() < 0.5 else {})
        if "domain_integral" in names and chance.random() < 0.2:
            keys["radii"] = [2.0 * self.cell, 2.5 * self.cell]
        if "domain_integral" in names and chance.random() < 0.4:
            keys["t_stress"] = True
        return keys

    def scene(self):
        """The whole scene."""
        chance, margin = self.chance, self.margin
        inner = min(margin, self.origin[0]) if self.plane == "axisymmetric" else margin
        bodies = self.bodies()
        wide = math.ceil(self.width)
        grid = {"lower": self.place(-inner, -margin), "cell": self.cell, "cells": [wide + margin + round(inner), self.size[1] + 2 * margin]}
        if self.order == 2:
            grid["order"] = 2
        output = {"file": "case.h5"}
        if self.time != "static":
            output["history_interval"] = self.end / chance.choice([4, 7, 10])
        if chance.random() < 0.5:
            output["snapshot_interval"] = self.end / 2
        run = {"plane": self.plane, "end_time": self.end} | ({} if self.plane == "axisymmetric" else {"thickness": self.thickness})
        if self.grows and chance.random() < 0.3:
            run |= chance.choice([{"stop_when": ["arrested"]}, {"stop_when": ["separated"]}, {"stop_when": ["crack_length"], "stop_length": 5 * self.cell}])
        scene = [["run", run], ["grid", grid], *bodies,
                 *self.cracks(), *self.constraints(), *self.loads(), ["method", self.method()], *self.refine(), ["energy_release", self.energy_release()],
                 ["output", output]]
        if self.time != "static" and chance.random() < 0.25:
            scene.append(["damping", {"rate": chance.choice([0.01, 0.1]) / self.tick}])
        if self.grows and self.time == "static" and self.law == "fatigue":
            self.without_history(scene)
            if chance.random() < 0.8:
                scene.append(["cycles", self.cycles()])
        elif self.grows and self.time == "static" and self.law != "subcritical" and chance.random() < 0.4:
            scene.append(["control", self.control(scene)])
        self.part_at_crack(scene)
        self.grade(scene)
        self.end_anywhere(scene)
        scene += self.probes(scene)
        self.agree(scene)
        if self.time == "implicit" and chance.random() < 0.6:
            self.move_by_modes(scene)
        if chance.random() < 0.1:                                          # a change too many
            name = chance.choice([name for name, _ in scene if name in CHOICES])
            key = chance.choice(list(CHOICES[name]))
            chance.choice(groups(scene, name))[key] = chance.choice(CHOICES[name][key])
        self.ask(scene)
        toughen(scene)
        return scene

    @staticmethod
    def ask(scene):
        """Asks some scenes at rest for an error that the first mesh reaches, so that order and levels are chosen. By itself: other draws stay what they are."""
        asks = random.Random(repr(scene))
        at_rest, release = group(scene, "method").get("time") == "static", group(scene, "energy_release")
        if at_rest and asks.random() < 0.25 and "domain_integral" in release.get("estimators", ()):
            scene.append(["accuracy", {"quantity": "J", "error": 0.9, "at": asks.choice(["end", "largest", "mean", "all"])}])

    def move_by_modes(self, scene):
        """Lets a scene of linear laws without growth and cohesion move by its modes, without what has none."""
        method, used = group(scene, "method"), {keys.get("material") for keys in groups(scene, "body")}
        if {keys["law"] for keys in groups(scene, "material") if keys["name"] in used} - {"linear_elastic", "orthotropic"} or any(
                groups(scene, name) for name in ("growth", "cohesive", "contact", "control")):
            return
        for name, of_name in (("crack", ["contact", "friction"]), ("constraint", ["unilateral"]),
                              ("method", ["time_step", "hht_alpha", "solver"])):
            for keys in groups(scene, name):
                for key in of_name:
                    keys.pop(key, None)
        scene[:] = [[name, keys] for name, keys in scene if not (name == "load" and keys["kind"] == "absorbing" or name == "refine" and keys.get("indicator") != "tip")]
        method["time"] = "modal"
        if self.chance.random() < 0.5:
            method["modes"] = self.chance.choice([10, 40, 150])

    def agree(self, scene):
        """Takes from a scene what its other groups do not go with, so that few scenes are refused as drawn."""
        method, release, cracks, loads = group(scene, "method"), group(scene, "energy_release"), groups(scene, "crack"), groups(scene, "load")
        used = {keys.get("material") for keys in groups(scene, "body")}
        laws = {keys["law"] for keys in groups(scene, "material") if keys["name"] in used}
        remembers, meets = laws & set(REMEMBER), bool(groups(scene, "contact"))
        if meets or self.plane == "axisymmetric" or any(keys["kind"] == "absorbing" for keys in loads):
            for keys in groups(scene, "constraint"):
                keys.pop("turns", None)
        if meets:
            method.pop("start", None)
        refine = group(scene, "refine")
        if meets and refine.get("indicator") == "gradient" or self.order == 2 and self.time != "static" and refine.get("indicator") in ("zz", "gradient") and (
                self.shaped or not self.ends_at_nodes(cracks)):
            scene.remove(["refine", refine])
        if groups(scene, "control"):
            for keys in groups(scene, "body"):
                keys.pop("held", None)
        scaled = [keys for name, keys in scene if name == "load" or name == "constraint" and {"displacement", "velocity"} & set(keys)]
        if not scaled and (groups(scene, "nucleation") or groups(scene, "growth") and self.time == "static"):
            scaled = [{"kind": "point", "force": [0.0, self.strain * self.young * self.cell * self.thickness]} | self.box(self.wide[2], self.wide[3], self.wide[2], self.wide[3])]
            scene.append(["load", scaled[0]])
        if scaled and all(keys.get("held") for keys in scaled) and not any("held" in keys for keys in groups(scene, "body")):
            del scaled[0]["held"]
            if groups(scene, "cycles") or groups(scene, "control"):
                self.without_history(scene)
        for keys in groups(scene, "body"):
            if method.get("start") == "static" or self.plane == "axisymmetric":
                keys.pop("spin", None)
            if laws & {"neo_hookean", "mooney_rivlin"} or self.plane == "axisymmetric":
                if keys.pop("profile_eigenstrain", None) and not {"profile_stiffness", "profile_density"} & set(keys):
                    del keys["profile_at"], keys["profile_direction"]
        for keys in groups(scene, "growth"):
            if remembers or "orthotropic" in laws:
                keys["direction"] = "straight"
                for key in ("mixed_mode", "lambda", "toughness_shear", "mixed_mode_exponent"):
                    keys.pop(key, None)
        for keys in groups(scene, "material"):
            if self.crack == "symmetry" and keys["law"] == "orthotropic":
                keys["angle"] = 90.0 * round(keys["angle"] / 90)
        touched = any(keys.get("contact", "none") != "none" for keys in cracks) or any("crack" in keys for keys in loads) or groups(scene, "cohesive")
        left_out = {"vcct", "stress_closure"} if not self.ends_at_nodes(cracks) else {"vcct", "stress_closure"} if remembers or groups(scene, "cohesive") else set()
        left_out |= {"material_force"} if touched or self.waits else set()
        release["estimators"] = [name for name in release.get("estimators", []) if name not in left_out]
        if remembers or groups(scene, "growth") and self.time != "static" or "domain_integral" not in release["estimators"]:
            release.pop("t_stress", None)
        self.leave_room(scene, release)

    def leave_room(self, scene, release):
        """Leaves J out, and radii that are named, where a tip has not room for it."""
        if "domain_integral" not in release.get("estimators", []):
            return
        cracks, room = groups(scene, "crack"), math.inf
        boxes = [keys for name, keys in scene if name in ("constraint", "load") and "lower" in keys]
        finest = self.cell / 2 ** (group(scene, "refine").get("max_level", 0) if group(scene, "refine").get("indicator") == "tip" else 0)
        for crack in cracks:
            points = crack.get("points", [])
            room = min(room, crack.get("length", math.inf), 2 * crack["radii"][0] if "radii" in crack else math.inf,
                       *(math.dist(points[k:k + 2], points[k + 2:k + 4]) for k in range(0, len(points) - 2, 2)), math.inf)
            for tip in self.tips(crack):
                if crack["kind"] != "symmetry":
                    room = min(room, *(math.dist(tip, [min(max(x, a), b) for x, a, b in zip(tip, keys["lower"], keys["upper"])]) for keys in boxes), math.inf)
                    away = next((k for k in range(1, 30) if not self.is_solid(*tip, 0.1 * k * self.cell)), 30)
                    room = min(room, (away - 1) * 0.1 * self.cell)
                for other in cracks:
                    if other is not crack:
                        room = min(room, *(math.dist(tip, end) for end in self.tips(other)), math.inf)
        if room < 2.6 * self.cell:
            release.pop("radii", None)
        if room < 2.1 * finest and not groups(scene, "growth"):
            release["estimators"] = [name for name in release["estimators"] if name != "domain_integral"]
            release.pop("t_stress", None)
            release.pop("phase_length", None)

    def ends_at_nodes(self, cracks):
        """Whether all cracks are along grid lines, from node to node."""
        for keys in cracks:
            if keys["kind"] == "path" or keys["kind"] != "symmetry" and 0.0 not in keys.get("direction", [0.0]):
                return False
            ends = [keys["tip"]] if "tip" in keys else [[x + s * keys["radii"][0] for x in keys["center"]] for s in (-1, 1)]
            if "length" in keys:
                ends.append([x - keys["length"] * d for x, d in zip(keys["tip"], keys["direction"])])
            for end in ends:
                along = [x / self.cell - o for x, o in zip(end, self.origin)]
                if "center" in keys:
                    along = along["xy".index({"x": "y", "y": "x"}[keys["normal"]]):][:1]
                if any(abs(x - round(x)) > 1e-6 for x in along):
                    return False
        return True

    def end_anywhere(self, scene):
        """Lets boxes of supports on edges, of loads on edges and of body loads end between nodes, and presses edges up to mouths of cracks, and the faces there."""
        chance = self.chance
        for name, keys in scene:
            flat = {"lower", "upper"} <= set(keys) and sum(a == b for a, b in zip(keys["lower"], keys["upper"])) == 1
            if name == "constraint" and flat and keys.get("name") != "plane" and chance.random() < 0.25 or name == "load" and keys["kind"] in ("traction", "pressure") and flat and chance.random() < 0.3:
                self.shorten(keys, chance.choice([d for d, (a, b) in enumerate(zip(keys["lower"], keys["upper"])) if a != b]))
            elif name == "load" and keys["kind"] == "body" and "upper" in keys and chance.random() < 0.7:
                for axis in range(len(keys["lower"])):
                    self.shorten(keys, axis)
        found = mouths(scene)
        if found and chance.random() < 0.5 and not self.shaped:
            crack, axis, place, low, high, mouth = chance.choice(found)
            pressure = {"kind": "pressure", "pressure": chance.choice([-1, 1, 1]) * self.strain * self.young}
            ends = chance.choice([(low, mouth), (mouth, high), (chance.uniform(low, mouth), chance.uniform(mouth, high))])
            edge = {key: [place, end] if axis == 0 else [end, place] for key, end in zip(("lower", "upper"), ends)}
            at = max(k for k, (name, _) in enumerate(scene) if name == "crack") + 1
            scene[at:at] = [["load", pressure | where] for where in chance.choice([[edge], [{"on": "crack", "crack": crack}], [edge, {"on": "crack", "crack": crack}]][:1 if self.waits or self.grows and self.time != "static" else 3])]

    def shorten(self, keys, axis):
        """Lets a box begin or end anywhere along an axis."""
        chance, low, high = self.chance, keys["lower"][axis], keys["upper"][axis]
        if high - low < 1.5 * self.cell:
            return
        parts = chance.choice([(0.0, chance.uniform(0.3, 0.9)), (chance.uniform(0.1, 0.7), 1.0), (chance.uniform(0.05, 0.4), chance.uniform(0.6, 0.95))])
        for end, part in zip(("lower", "upper"), parts):
            keys[end] = [low + part * (high - low) if d == axis else x for d, x in enumerate(keys[end])]

    def part_at_crack(self, scene):
        """Makes two bodies of two materials of one, with a crack along grid lines between them."""
        chance, bodies, lines = self.chance, groups(scene, "body"), [keys for keys in groups(scene, "crack") if keys.get("kind") in ("line", "plane") and 0.0 in keys.get("direction", ())]
        if len(bodies) > 1 or "shape" in bodies[0] or not lines or groups(scene, "contact") or chance.random() < 0.4:
            return
        across = lines[0]["direction"].index(0.0)
        other = dict(bodies[0], material="m2", lower=list(bodies[0]["lower"]))
        bodies[0]["upper"] = list(bodies[0]["upper"])
        bodies[0]["upper"][across] = other["lower"][across] = lines[0]["tip"][across]
        bodies[0].pop("spin", None)
        other.pop("spin", None)
        if "eigenstrain" in other and chance.random() < 0.5:
            del other["eigenstrain"]
        at = max(k for k, (name, _) in enumerate(scene) if name == "body")
        scene[at + 1:at + 1] = [["body", other], ["material", self.material("m2", chance.choice(["linear_elastic", "linear_elastic", "neo_hookean"]))]]
        release = group(scene, "energy_release")
        release["estimators"] = [name for name in release.get("estimators", []) if name == "domain_integral"]  # the parts of others are no odd functions there
        if "domain_integral" in release.get("estimators", []) and chance.random() < 0.8:
            release["phase_length"] = chance.choice([0.3, 3.0]) * self.cell
            lines[0].pop("friction", None)
            lines[0]["contact"] = "none"

    def grade(self, scene):
        """Lets the material of a body change from place to place."""
        chance, body = self.chance, groups(scene, "body")[0]
        if chance.random() < 0.8:
            return
        number = chance.choice([2, 2, 3])
        angle = chance.choice([0, 90, 30])
        body["profile_direction"] = [math.cos(math.radians(angle)), math.sin(math.radians(angle))] if angle % 90 else [float(angle == 0), float(angle == 90)]
        middle = sum(x * d for x, d in zip(self.place(self.size[0] / 2, self.size[1] / 2), body["profile_direction"]))
        body["profile_at"] = [middle + (k - (number - 1) / 2) * 6 * self.cell for k in range(number)]
        body["profile_stiffness"] = [chance.choice([0.5, 1.0, 2.0]) for _ in range(number)]
        if chance.random() < 0.5:
            body["profile_density"] = [chance.choice([0.7, 1.0, 1.5]) for _ in range(number)]
        if "eigenstrain" in body:
            body["profile_eigenstrain"] = [chance.uniform(-1, 1) for _ in range(number)]
        for keys in groups(scene, "energy_release"):
            keys.pop("phase_length", None)

    def probes(self, scene):
        """The groups of probes, drawn last; their names begin with p."""
        chance, (w, h), found = self.chance, self.size, []
        if chance.random() < 0.5:
            return found

        def inside():
            for _ in range(20):
                place = self.place(chance.uniform(0.1, 0.9) * w, chance.uniform(0.1, 0.9) * h)
                if self.is_solid(*place):
                    return place
            return self.place(0.5 * w, 0.5 * h)

        of_point = ["displacement", "strain", "stress"] + ["velocity"] * (self.time != "static")
        found.append({"name": "point", "quantity": chance.sample(of_point, chance.choice([1, 2, len(of_point)])), "at": inside()})
        if chance.random() < 0.5:
            found.append({"name": "line", "quantity": chance.choice([["strain"], ["strain"], ["stress", "displacement"]]), "at": inside() + inside()})
        for keys in groups(scene, "crack"):
            if chance.random() < 0.3:
                continue
            of, name = ({"of": [keys["name"]]} if "name" in keys else {}), keys.get("name", "s")
            found.append({"name": f"c{name}", "quantity": chance.choice([["opening"], ["volume"], ["volume", "opening"]])} | of)
            if "opening" in found[-1]["quantity"]:
                found[-1] |= {"distance": chance.choice([1.0, 1.7]) * self.cell, "tip": chance.choice(["last", "last", "first"]) if self.has_two_tips(keys) else "last"}
            if keys.get("kind") == "path" and "points" in keys:          # a change too many may have made it of a line
                a, b, part = keys["points"][:2], keys["points"][2:4], chance.choice([0.4, 0.6])
                if self.is_solid(*[x + part * (y - x) for x, y in zip(a, b)]):
                    found.append({"name": name, "quantity": ["displacement", "stress"], "face": chance.choice(["left", "right"]),
                                  "at": [x + part * (y - x) for x, y in zip(a, b)]})
        acting = [keys for name, keys in scene if name in ("load", "constraint") and keys.get("kind", "point") in ("point", "traction", "body")]
        if acting and chance.random() < 0.5:
            for keys in acting:
                if "kind" in keys:
                    keys["name"] = f"load{acting.index(keys)}"
            named = [keys["name"] for keys in acting if "name" in keys]
            if named:
                found.append({"name": "works", "quantity": ["load_line"], "of": chance.sample(named, min(len(named), chance.choice([1, 2])))})
        for keys in found:
            keys["name"] = "p" + keys["name"]
        return [["probe", keys] for keys in found]


def toughen(scene):
    """Gives one of several bodies of some scenes that grow a toughness of its own. By itself: other draws stay what they are."""
    gives, bodies, growth = random.Random(repr(scene)), [keys for keys in groups(scene, "body") if "hole" not in keys], group(scene, "growth")
    if len(bodies) > 1 and "toughness" in growth and gives.random() < 0.4:
        gives.choice(bodies)["toughness"] = gives.choice([0.3, 2.0, 10.0]) * growth["toughness"]


def draw(chance, cracked=False):
    """A scene, accepted or not, with cracks where these are asked for."""
    return Drawing(chance, cracked).scene()


NAMED = re.compile(r"&([a-z_]+)(?: ([a-z_0-9]+))?(?: = ('[^']*'|[^ :,]+))?")
ADVICE = re.compile(r"must be '([a-z_0-9]+)'")


def repair(scene, messages, chance):
    """The scene with keys drawn anew that the messages of a refusal name: each is set to what the message asks for, dropped or drawn, or its group goes."""
    scene, named = copy_of(scene), set()
    for message in messages:
        start = re.match(r"[^:]*:(\d+): (.*)", message)
        line, text = (int(start[1]) - 1, start[2]) if start else (None, message)
        found = NAMED.findall(text)
        if not found:
            continue
        at = chance.randrange(len(found))
        name, key = found[at][:2]
        if (name, key) in named:
            continue
        named.add((name, key))
        where = [k for k, (group_name, _) in enumerate(scene) if group_name == name]
        if at == 0 and line is not None and line < len(scene) and scene[line][0] == name:
            where = [line]
        if not where and name in CHOICES and key in CHOICES[name] and name not in ("crack", "load", "constraint", "cohesive", "growth", "nucleation"):
            scene.append([name, {}])
            where = [len(scene) - 1]
        if not where:
            continue
        keys = scene[chance.choice(where)][1]
        advice = ADVICE.search(text)
        what = chance.random()
        if at == 0 and advice and what < 0.5 and key:
            keys[key] = advice[1]
        elif name not in REQUIRED and (what < 0.25 or not key) and name not in ("method", "output", "energy_release"):
            scene[scene.index([name, keys])][1]["drop"] = True
        elif key in CHOICES.get(name, {}) and what < 0.8:
            keys[key] = chance.choice(CHOICES[name][key])
        elif key in keys and key not in ("lower", "upper", "cell", "cells", "material", "young", "density", "end_time", "name", "tip", "fix", "kind"):
            del keys[key]
    return [one for one in scene if "drop" not in one[1]]
