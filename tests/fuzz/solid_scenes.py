"""Scenes of solids drawn at random, for the program for solids (`make program dim=3`), held to what needs no reference, as `combinations.py` does with those of the plane.

    .venv/bin/python tests/fuzz/solid_scenes.py --cases 250 --seed 3 --program build/checked3d/hampm3d

Beside its oracles there are mirrors in three axes, axes exchanged in a cycle and by pairs, and slabs one cell thick between rollers, which are plane strain.
"""

from pathlib import Path

import combinations
import numpy as np
import scene_maps as maps
from combinations import MANY, SECOND, Case, Fault, Unasked, isometry
from drawn_scenes import REMEMBER, CHOICES, Drawing, copy_of, group, groups, toughen

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/checked3d/hampm3d"
RELEASE = ROOT / "build/release3d/hampm3d"
PLANE = ROOT / "build/release/hampm"
LAWS = ["linear_elastic", "linear_elastic", "linear_elastic", "neo_hookean", "mooney_rivlin", "j2_plastic", "viscoelastic", "orthotropic"]
ROLLERS = "slab"       # name of the constraint that makes a slab plane strain
FEW = 600              # particles of a scene that may settle in motion
PLANE_COURANT = 0.05   # of slabs: by default the step is that of the body in all its directions


class Solid(Drawing):
    """One scene of solids as it is drawn."""

    def __init__(self, chance):
        super().__init__(chance)
        self.crack, self.grows, self.holds, self.shaped, self.waits, self.order = "none", False, False, False, False, 1
        if self.time == "explicit":
            self.frame = chance.choice(["total", "updated"])
        self.slab = chance.random() < 0.2
        self.size = [chance.randint(2, 5), chance.randint(2, 4), 1 if self.slab else chance.randint(2, 4)]
        if not self.slab:
            chance.shuffle(self.size)
        self.shape = "none" if self.slab or chance.random() < 0.7 else chance.choice(["cylinder", "sphere", "hole", "hole"])
        self.measured = self.shape == "none" and not self.slab and self.frame == "total" and chance.random() < 0.12    # G along the front of a crack, which needs room
        if self.shape != "none":
            self.size = [n + 1 for n in self.size]
        if self.measured:
            self.size = [8, 8, chance.choice([4, 5, 8])]
        self.origin = [chance.choice([0.0, 0.0, 3.0, -7.5, chance.uniform(-9, 9)]) for _ in "xyz"]
        self.margin = [2 if self.frame == "updated" else chance.choice([0, 1]) for _ in "xyz"]
        if self.slab:
            self.margin[2] = 0
        self.thickness, self.plane = self.size[2] * self.cell, "strain"
        self.end = self.tick * {"static": 10, "explicit": chance.uniform(3, 12), "implicit": chance.uniform(20, 200)}[self.time]
        if self.measured and self.time == "implicit":                      # each of its steps is a solution
            self.time = "static"

    def place(self, *x):
        """A place given in cells from the lower corner of the body."""
        return [(o + a) * self.cell for o, a in zip(self.origin, x)]

    def box(self, *ends):
        """The two keys of a box; one of the plane goes from side to side."""
        lower, upper = ends[:len(ends) // 2], ends[len(ends) // 2:]
        return {"lower": self.place(*lower, *[0][:3 - len(lower)]), "upper": self.place(*upper, *[self.size[2]][:3 - len(upper)])}

    def vector(self, size):
        """Three components, none across a slab."""
        chance = self.chance
        found = [chance.choice([0.0, chance.uniform(-1, 1), chance.uniform(-1, 1)]) * size for _ in "xyz"]
        return [*found[:2], 0.0] if self.slab else found

    def material(self, name, law):
        """The keys of a material; of an orthotropic one all nine constants and three turns."""
        keys, chance = super().material(name, law), self.chance
        if law == "orthotropic":
            keys |= {"shear_13": 0.15 * keys["young_1"], "shear_23": 0.25 * keys["young_1"]}
            keys["angle"] = [0.0, 0.0, keys["angle"]] if self.slab else [chance.choice([0.0, 90.0, 30.0, chance.uniform(-180, 180)]) for _ in "xyz"]
        return keys

    def side(self, part=False):
        """A side of the body or a part of one, in cells: its axis, lower and upper corner."""
        chance, size = self.chance, self.whole
        axis = chance.randrange(2 if self.slab else 3)
        lower, upper = list(self.near), [float(n) for n in self.far or size]
        lower[axis] = upper[axis] = chance.choice([lower[axis], upper[axis]])
        if not part and self.far:                                          # at nodes
            lower[axis] = upper[axis] = float(round(lower[axis] + 0.25 * (1 if lower[axis] < 1 else -1)))
        if part:
            for d in range(2 if self.slab else 3):
                if d != axis and size[d] > 1 and chance.random() < 0.3:
                    upper[d] = chance.choice([1.0, size[d] - 1.0, 0.5 * size[d]])
        if self.shape in ("cylinder", "sphere"):                           # which has its side where no node is: a part of it
            lower[axis], upper[axis] = [-0.5, 1.2] if upper[axis] == 0 else [size[axis] - 1.2, size[axis] + 0.5]
        return axis, lower, upper

    def motion(self, keys):
        """Adds what a body does at the start."""
        chance, speed = self.chance, self.strain * self.cell / self.tick
        if self.time != "static" and chance.random() < 0.4:
            keys["velocity"] = self.vector(speed)
        if self.time != "static" and chance.random() < 0.2:
            keys["spin"] = [0.0 if self.slab and axis != "z" else chance.choice([0.0, chance.uniform(-1, 1)]) * speed / (5 * self.cell) for axis in "xyz"]
        if chance.random() < 0.15:
            strain = [chance.uniform(-1, 1) * self.strain for _ in "xyz"]
            keys["eigenstrain"] = [*strain[:2], 0.0, strain[2]]
        return keys

    def bodies(self):
        """The groups of bodies and materials."""
        chance = self.chance
        law = chance.choice((["linear_elastic"] if self.time == "explicit" else ["linear_elastic", "orthotropic"]) if self.measured else LAWS)
        points = {"points_per_cell": 2 if self.measured else chance.choice([1, 2, 2, 2, 2, 2, 3])}
        self.near, self.far = [0.0, 0.0, 0.0], None
        materials, first, self.whole = [self.material("m0", law)], {"material": "m0"} | points, list(self.size)
        if self.shape in ("cylinder", "sphere"):
            self.round(first, self.shape, [n / 2 for n in self.size], chance.choice([1.0, chance.uniform(0.85, 1)]))
        elif chance.random() < 0.2 and self.shape == "none" and not self.measured:
            self.near = [chance.choice([0, 0.5]), 0.0, 0.0]
            self.far = [self.size[0] - chance.choice([0.25, 0.5]), self.size[1] - chance.choice([0, 0.3]), float(self.size[2])]
            first |= self.box(*self.near, *self.far)
        else:
            first |= self.box(0, 0, 0, *self.size)
        found = [["body", self.motion(first)]]
        if self.shape == "none" and not self.measured and self.far is None and chance.random() < 0.3:  # a second body, bonded or met
            axis, gap = chance.randrange(2 if self.slab else 3), chance.choice([0, 0, 1]) if self.frame == "updated" else 0
            other = {"material": chance.choice(["m0", "m1"])} | points
            lower, upper = [0.0, 0.0, 0.0], [float(n) for n in self.size]
            lower[axis] = self.size[axis] + gap
            upper[axis] = lower[axis] + chance.randint(1, 2)
            self.motion(other | self.box(*lower, *upper))
            other |= self.box(*lower, *upper)
            self.whole[axis] = round(upper[axis])
            if gap:
                speed = self.strain * self.cell / self.tick * chance.choice([10, 100])
                other["velocity"] = [-speed if d == axis else 0.0 if d == 2 and self.slab else speed * chance.choice([0.0, chance.uniform(-1, 1)]) for d in range(3)]
                if not self.slab and chance.random() < 0.4:
                    self.round(other, chance.choice(["cylinder", "sphere"]), [(a + b) / 2 for a, b in zip(lower, upper)], chance.uniform(0.85, 1),
                               [b - a for a, b in zip(lower, upper)])
            if other["material"] == "m1":
                materials.append(self.material("m1", chance.choice([law, law, *LAWS])))
            found.append(["body", other])
            if self.frame == "updated" and chance.random() < 0.6:
                kind = chance.choice(["stick", "frictionless", "friction"])
                found.append(["contact", {"bodies": kind} | ({"friction": chance.choice([0.1, 0.6])} if kind == "friction" else {})])
        if self.shape == "hole" or self.shape != "none" and chance.random() < 0.3:
            hole = {"hole": True}
            self.round(hole, chance.choice(["cylinder", "sphere"]), [n / 2 + chance.choice([0.0, chance.uniform(-0.5, 0.5)]) for n in self.size], chance.uniform(0.3, 0.5))
            found.append(["body", hole])
        chance.shuffle(materials)
        return [["material", keys] for keys in materials] + found

    def round(self, keys, kind, middle, part, size=None):
        """Makes it a cylinder from side to side or a sphere, whose radius is a part of the largest."""
        axis, size = self.chance.randrange(3), size or self.size
        keys |= {"shape": kind}
        if kind == "sphere":
            keys.pop("lower", None), keys.pop("upper", None)
            keys |= {"center": self.place(*middle), "radius": part * min(size) / 2 * self.cell}
            return
        lower, upper = ([middle[axis] + n * size[axis] / 2 if d == axis else a for d, a in enumerate(middle)] for n in (-1, 1))
        keys |= {"lower": self.place(*lower), "upper": self.place(*upper), "radius": part * min(n for d, n in enumerate(size) if d != axis) / 2 * self.cell}

    def constraints(self):
        """The groups of constraints."""
        chance, found, name, move = self.chance, [], iter("abcdef"), self.strain * self.cell * 4
        kinds = ["side", "planes", "corner", "moved", "moved", "line", *([] if self.slab else ["push", "pins"])]
        kind = chance.choice(kinds if self.time == "static" else [*kinds, "none", "none"])
        if self.measured:
            kind = chance.choice(["planes", "planes", "moved"])
        fixes = ["x", "y", "z", "xy", "yz", "xz", "xyz", "xyz", "xyz"]
        if kind in ("side", "moved"):
            _, lower, upper = self.side()
            found.append(self.box(*lower, *upper) | {"fix": "xyz" if self.time == "static" else chance.choice(fixes)})
        if kind == "planes":
            for axis in range(3):
                upper = [0.0 if d == axis else float(n) for d, n in enumerate(self.whole)]
                found.append(self.box(0, 0, 0, *upper) | {"fix": "xyz"[axis]})
        if kind == "corner":
            x, y, z = self.whole
            found += [self.box(0, 0, 0, 0, 0, 0) | {"fix": "xyz"}, self.box(x, 0, 0, x, 0, 0) | {"fix": "yz"}, self.box(0, y, 0, 0, y, 0) | {"fix": "z"}]
        if kind == "line":
            found += [self.box(0, 0, 0, self.whole[0], 0, 0) | {"fix": "xyz"}, self.box(0, self.whole[1], 0, self.whole[0], self.whole[1], 0) | {"fix": "z"}]
        if kind == "push":                                                 # a support that only pushes, and one that holds the rest
            axis, lower, upper = self.side()
            found.append(self.box(*lower, *upper) | {"fix": "xyz"[axis]} | ({"unilateral": True} if self.time != "explicit" else {}))
            if chance.random() < 0.7:
                found.append(self.box(*lower, *upper) | {"fix": "xyz".replace("xyz"[axis], "")})
                found[-1]["lower"][axis], found[-1]["upper"][axis] = self.place(0, 0, 0)[axis], self.place(*self.whole)[axis]
                for d in range(3):                                          # along an edge of it
                    if d == (axis + 1) % 3:
                        found[-1]["upper"][d] = found[-1]["lower"][d]
        if kind == "pins":                                                 # around an axis, at both ends of another one
            axis = chance.randrange(3)
            along = chance.choice([d for d in range(3) if d != axis])
            for at in (0.2, self.whole[along] - 1.2):
                lower = [at if d == along else 0.2 for d in range(3)]
                upper = [at + 1.0 if d == along else float(self.whole[d]) if d == axis else 2.2 for d in range(3)]
                lower[axis] = 0.0
                found.append(self.box(*lower, *upper) | {"fix": "xyz".replace("xyz"[axis], ""), "turns": True})
            if chance.random() < 0.5:
                found[-1] |= {"displacement": [move * chance.uniform(-1, 1) if d == along else 0.0 for d in range(3)]} | self.history(motion=True)
            if chance.random() < 0.7:
                found.append(self.box(0, 0, 0, *self.whole) | {"fix": "xyz"[axis]})
                found[-1]["upper"][axis] = found[-1]["lower"][axis]
        if kind == "moved":
            fix, (axis, lower, upper) = chance.choice(fixes), self.side()
            amount = [a if "xyz"[d] in fix else 0.0 for d, a in enumerate(self.vector(move))]
            if chance.random() < 0.3 and self.time != "static":
                found.append(self.box(*lower, *upper) | {"fix": fix, "velocity": [a / self.end for a in amount]})
            else:
                found.append(self.box(*lower, *upper) | {"fix": fix, "displacement": amount} | self.history(motion=True))
        for keys in found:
            if chance.random() < 0.8:
                keys["name"] = next(name)
        if self.slab:
            for keys in found:
                keys["fix"] = "".join(sorted({*keys["fix"], "z"}))          # where boxes overlap the last one holds
                keys["lower"][2], keys["upper"][2] = self.place(0, 0, 0)[2], self.place(*self.whole)[2]
            found.insert(0, self.box(0, 0, 0, *self.whole) | {"fix": "z", "name": ROLLERS})
        return [["constraint", keys] for keys in found]

    def loads(self):
        """The groups of loads."""
        chance, found = self.chance, []
        force = self.strain * self.young * (3 * self.cell)**2
        for _ in range(chance.choices([0, 1, 2, 3], [1, 4, 3, 1])[0]):
            kind = chance.choice(["traction", "traction", "point", "body", "gravity", "pressure", "pressure"] + ["absorbing"] * (self.time != "static")) if not self.measured else "gravity"
            if kind in ("pressure", "absorbing"):
                axis, lower, upper = self.side(part=True)
                keys = {"kind": kind} | self.box(*lower, *upper)
                if kind == "absorbing":
                    found.append(["load", keys])
                    continue
                keys["pressure"] = chance.choice([-1, 1]) * self.strain * self.young
                if self.shape == "hole" and chance.random() < 0.5:          # inside of the hole
                    keys |= self.box(*(0.1 for _ in "xyz"), *(n - 0.1 for n in self.whole))
            elif kind == "gravity":
                keys = {"kind": kind, "acceleration": self.vector(force / (self.density * (3 * self.cell)**3))}
            else:
                keys = {"kind": kind, "force": self.vector(0.2 * force if kind == "point" else force)}
                axis, lower, upper = self.side(part=True)
                if kind == "point":
                    lower = upper = [chance.choice([a, b, (a + b) / 2]) for a, b in zip(lower, upper)]
                if kind == "body":
                    lower, upper = [0.0, 0.0, 0.0], [float(n) for n in self.whole]
                    lower[axis] = upper[axis] / 2 + 0.07                    # no particle on its edge, for rounding to decide
                if kind == "point" and self.slab:
                    continue                                                # a point on one of the two sides of it
                keys |= self.box(*lower, *upper)
            found.append(["load", keys | self.history()])
        return found

    def cracks(self, constraints):
        """The groups of a crack in a plane of the grid and a pressure on its faces, or none."""
        chance, across = self.chance, self.chance.randrange(3)
        if self.slab or self.frame != "total" or chance.random() < 0.6 and not self.measured:
            return []
        if self.measured:
            return self.measured_crack(constraints)
        symmetry = len(constraints) > 2 and constraints[0][1]["fix"] == "x" and chance.random() < 0.7     # on one of three planes
        if not symmetry and self.size[across] < 2:
            return []
        plane = 0 if symmetry else chance.randint(1, self.size[across] - 1)
        at = lambda reach=0.0: [float(plane) if d == across else chance.choice([0.0, chance.uniform(-reach, n + reach), chance.uniform(0, n)]) for d, n in enumerate(self.size)]
        keys = {"kind": "symmetry" if symmetry else "plane", "normal": "xyz"[across], "front": chance.choice(["straight", "disc", "ellipse", "polygon"])}
        if keys["front"] == "straight":
            angle = chance.choice([0.0, 0.5, 1.0, 1.5, chance.uniform(0, 2)]) * np.pi
            ahead = [d for d in range(3) if d != across]
            keys |= {"tip": self.place(*at()), "direction": [0.0 if d == across else float([np.cos(angle), np.sin(angle)][ahead.index(d)]) for d in range(3)]}
            if not symmetry and chance.random() < 0.3:                     # with two fronts
                keys["length"] = chance.uniform(3, 5) * self.cell
        elif keys["front"] == "polygon":
            keys["points"] = [x for _ in range(chance.choice([3, 3, 4])) for x in self.place(*at(1.0))]
        else:
            keys |= {"center": self.place(*at()), "radii": [chance.uniform(1.5, 3) * self.cell for _ in range(1 if keys["front"] == "disc" else 2)]}
        if not symmetry and chance.random() < 0.3:
            keys |= chance.choice([{"contact": "frictionless"}, {"contact": "friction", "friction": chance.choice([0.1, 0.6])}])
        self.crack = keys["kind"]
        found = [["crack", keys]]
        if chance.random() < 0.3:
            found.append(["load", {"kind": "pressure", "on": "crack", "pressure": chance.uniform(-1, 1) * self.strain * self.young} | self.history()])
        return found

    def measured_crack(self, constraints):
        """The groups of a crack with room around its front: a straight one from side to side, on a plane of symmetry or inside, or a quarter of a penny in a corner."""
        chance, (x, y, _) = self.chance, self.size
        symmetry = len(constraints) > 2
        self.crack = "symmetry" if symmetry else "plane"
        keys = {"kind": self.crack, "normal": "y" if symmetry else chance.choice("xy")}
        if symmetry and chance.random() < 0.5:
            keys |= {"normal": "z", "front": "disc", "center": self.place(0, 0, 0), "radii": [chance.uniform(3.6, 4.2) * self.cell]}
        elif keys["normal"] == "y":
            keys |= {"tip": self.place(chance.choice([4.0, chance.uniform(3.6, x - 3.6)]), 0 if symmetry else 4, 1), "direction": [chance.choice([-1.0, 1.0]) if not symmetry else 1.0, 0.0, 0.0]}
        else:
            keys |= {"tip": self.place(4, chance.choice([4.0, chance.uniform(3.6, y - 3.6)]), 1), "direction": [0.0, chance.choice([-1.0, 1.0]), 0.0]}
        found = [["crack", keys]]
        if not symmetry and chance.random() < 0.3:
            keys |= chance.choice([{"contact": "frictionless"}, {"contact": "friction", "friction": chance.choice([0.1, 0.6])}])
        if chance.random() < 0.5:
            found.append(["load", {"kind": "pressure", "on": "crack", "pressure": chance.uniform(-1, 1) * self.strain * self.young} | self.history()])
        if self.time == "explicit" and "contact" not in keys and chance.random() < 0.6:
            keys = {"law": "prescribed", "speed": chance.uniform(0.02, 0.4) * self.cell / self.tick} if chance.random() < 0.5 else \
                {"law": "toughness", "toughness": chance.uniform(0.01, 1) * self.strain**2 * self.young * self.cell}
            if keys["law"] == "toughness" and chance.random() < 0.3:
                keys |= {"extensions": [0.0, self.cell], "extension_factors": [1.0, chance.choice([0.6, 1.5, 3.0])]}
            found.append(["growth", keys | {"direction": "straight"}])
        return found

    def energy_release(self):
        """The keys of what is recorded of energy."""
        measures = self.measured or self.crack != "none" and self.chance.random() < 0.1
        keys = {"estimators": self.chance.choice([["domain_integral"], ["vcct"], ["domain_integral", "vcct"]]) if measures else []}
        if "domain_integral" in keys["estimators"] and self.chance.random() < 0.3:
            keys["radii"] = [factor * self.cell for factor in self.chance.choice([[2.5], [2.2, 3.0], [2.0, 2.5, 3.2]])]
        return keys | ({"energy_balance": True} if self.chance.random() < 0.5 else {})

    def probes(self, scene):
        """The groups of probes; their names begin with p."""
        chance, found = self.chance, []
        if chance.random() < 0.5:
            return found

        def inside():
            part = {"none": (0.3 if self.near[0] else 0.1, 0.6 if self.far else 0.9), "hole": (0.02, 0.12)}.get(self.shape, (0.4, 0.6))
            return self.place(*(chance.uniform(*part) * n for n in self.size))

        of_point = ["displacement", "strain", "stress"] + ["velocity"] * (self.time != "static")
        found.append({"name": "ppoint", "quantity": chance.sample(of_point, chance.choice([1, 2, len(of_point)])), "at": inside()})
        if chance.random() < 0.5:
            found.append({"name": "pline", "quantity": chance.choice([["strain"], ["stress", "displacement"]]), "at": inside() + inside()})
        acting = [keys for name, keys in scene if name in ("load", "constraint") and keys.get("kind", "point") in ("point", "traction", "body")]
        if acting and chance.random() < 0.5:
            for k, keys in enumerate(acting):
                if "kind" in keys:
                    keys["name"] = f"load{k}"
            named = [keys["name"] for keys in acting if "name" in keys]
            if named:
                found.append({"name": "pworks", "quantity": ["load_line"], "of": chance.sample(named, min(len(named), chance.choice([1, 2])))})
        return [["probe", keys] for keys in found]

    def refine(self):
        """The group of refinement, or none."""
        chance = self.chance
        if chance.random() < 0.55 or self.measured and self.time != "static":
            return []
        keys = {"indicator": chance.choice(["zz", "gradient", "gradient", *(["tip", "tip"] if self.crack != "none" else [])]), "max_level": chance.choice([1, 1, 2]), "max_particles": 4000}
        if self.time != "static":
            keys["interval"] = chance.choice([5, 20])
        if keys["indicator"] == "tip":
            keys["rings"] = chance.choice([1, 2])
        elif keys["indicator"] == "zz":
            keys["tolerance"] = chance.choice([0.05, 0.1, 0.2])
        else:
            keys |= {"field": chance.choice(["energy_density", "stress_norm", "speed"]), "r_crit": chance.choice([1e-12, 0.03, 0.1]), "r_coarsen": chance.choice([0.0, 0.0, 0.02])}
        if keys.get("r_crit") == 1e-12:
            keys["r_coarsen"] = 0.0
        if chance.random() < 0.4 or keys.get("r_crit") == 1e-12:            # finer cells in a part, whatever the indicator says there
            lower = [chance.choice([0.0, 1.0, 0.3]) for _ in "xyz"]
            keys |= {f"region_{end}": place for end, place in self.box(*lower, *(a + chance.choice([0.4, 1.0, 1.5]) for a in lower)).items()}
        return [["refine", keys]]

    def scene(self):
        """The whole scene."""
        chance, bodies = self.chance, self.bodies()
        constraints = self.constraints()
        cracks = self.cracks(constraints)
        grid = {"lower": self.place(*(-m for m in self.margin)), "cell": self.cell, "cells": [n + 2 * m for n, m in zip(self.whole, self.margin)]}
        output = {"file": "case.h5"}
        if self.time != "static":
            output["history_interval"] = self.end / chance.choice([4, 7, 10])
        if chance.random() < 0.5:
            output["snapshot_interval"] = self.end / 2
        scene = [["run", {"end_time": self.end}], ["grid", grid], *bodies, *constraints, *cracks, *self.loads(), ["method", self.method()], *self.refine(),
                 ["energy_release", self.energy_release()], ["output", output]]
        if self.time != "static" and chance.random() < 0.25:
            scene.append(["damping", {"rate": chance.choice([0.01, 0.1]) / self.tick}])
        self.grade(scene)
        if not self.measured and self.crack != "symmetry":
            self.end_anywhere(scene)
        scene = self.grow_at_rest(scene + self.probes(scene))
        toughen(scene)
        self.agree(scene)
        if self.time == "implicit" and chance.random() < 0.6:
            self.move_by_modes(scene)
        if chance.random() < 0.1:                                          # a change too many
            name = chance.choice([name for name, _ in scene if name in CHOICES])
            key = chance.choice(list(CHOICES[name]))
            chance.choice(groups(scene, name))[key] = chance.choice(CHOICES[name][key])
        return scene

    def agree(self, scene):
        """Takes from a scene what its other groups do not go with, so that few scenes are refused as drawn."""
        method, release, refine = group(scene, "method"), group(scene, "energy_release"), group(scene, "refine")
        laws, few = {keys["law"] for keys in groups(scene, "material")}, any(keys.get("points_per_cell") == 1 for keys in groups(scene, "body"))
        method.pop("shape_functions", None)
        if groups(scene, "contact") or few and self.time == "explicit":
            method.pop("start", None)
        if method.get("start") == "static":
            for keys in groups(scene, "body"):
                keys.pop("spin", None)
        if laws & set(REMEMBER):
            release["estimators"] = [name for name in release["estimators"] if name != "vcct"]
        if groups(scene, "contact") and refine.get("indicator") == "gradient":
            scene.remove(["refine", refine])
        if groups(scene, "contact") or any(keys["kind"] == "absorbing" for keys in groups(scene, "load")):
            for keys in groups(scene, "constraint"):
                keys.pop("turns", None)
        if groups(scene, "cycles"):
            self.without_history(scene)
        if laws & {"neo_hookean", "mooney_rivlin"}:
            for keys in groups(scene, "body"):
                keys.pop("profile_eigenstrain", None)

    def grow_at_rest(self, scene):
        """Lets the front of a crack at rest grow, by toughness or in load cycles."""
        chance = self.chance
        if not self.measured or self.time != "static" or chance.random() < 0.4:
            return scene
        keys = {"direction": "straight", "increment": chance.uniform(0.2, 0.6) * self.cell}
        stress, crack = self.strain * self.young, group(scene, "crack")
        if "tip" in crack:                                                 # on no side of cells, which an end that stays would leave by rounding
            crack["tip"] = [x + 0.07 * self.cell * (abs(d) > 0) for x, d in zip(crack["tip"], crack["direction"])]
        group(scene, "method")["load_steps"] = chance.choice([2, 3])
        if chance.random() < 0.5:
            return scene + [["growth", keys | {"law": "fatigue", "rate_constant": 1e-3 * self.cell / (stress * self.cell**0.5)**2, "rate_exponent": 2.0}],
                            ["cycles", {"ratio": chance.choice([0.0, 0.3, -1.0])}]]
        if chance.random() < 0.3:
            toughness, speed = chance.uniform(0.03, 3) * stress**2 / self.young * self.cell, chance.uniform(0.2, 3) * self.cell / group(scene, "run")["end_time"]
            return scene + [["growth", keys | {"law": "subcritical", "toughness": toughness} | chance.choice([
                {"rate": "charles", "speed": speed, "rate_exponent": chance.choice([3.0, 12.0])}, {"rate": "toughness", "limit_speed": speed, "exponent": chance.choice([1.0, 2.0])}])]]
        keys |= {"law": "quasi_static", "toughness": chance.uniform(0.1, 10) * stress**2 / self.young * self.cell}
        if chance.random() < 0.3:
            keys |= {"extensions": [0.0, self.cell], "extension_factors": [1.0, 1.5]}
        return scene + [["growth", keys]]

    def grade(self, scene):
        """Lets the material of a body change from place to place."""
        chance, body = self.chance, groups(scene, "body")[0]
        if chance.random() < 0.85:
            return
        axis, number = chance.randrange(2 if self.slab else 3), chance.choice([2, 3])
        body["profile_direction"] = [float(d == axis) for d in range(3)]
        middle = self.place(*(n / 2 for n in self.size))[axis]
        body["profile_at"] = [middle + (k - (number - 1) / 2) * 3 * self.cell for k in range(number)]
        body["profile_stiffness"] = [chance.choice([0.5, 1.0, 2.0]) for _ in range(number)]
        if chance.random() < 0.5:
            body["profile_density"] = [chance.choice([0.7, 1.0, 1.5]) for _ in range(number)]
        if "eigenstrain" in body:
            body["profile_eigenstrain"] = [chance.uniform(-1, 1) for _ in range(number)]


def draw(chance, exact=False):
    """A scene of solids, accepted or not."""
    return Solid(chance).scene()


def in_plane(scene):
    """The scene of the plane that a slab is, in plane strain."""
    scene, found = copy_of(scene), []
    cell = group(scene, "grid")["cell"]
    for name, keys in scene:
        if "angle" in keys:
            keys["angle"] = keys["angle"][2]
        if "spin" in keys:
            keys["spin"] = keys["spin"][2]
        if name == "probe" and len(keys.get("at", ())) == 6:
            keys["at"] = keys["at"][:2] + keys["at"][3:5]
        keys.pop("shear_13", None), keys.pop("shear_23", None)
        for key, value in keys.items():
            if isinstance(value, list) and (name, key) not in (("body", "eigenstrain"), ("energy_release", "estimators")) and len(value) == 3 and not isinstance(value[0], str) \
                    and not key.startswith(("profile_at", "profile_s", "profile_de", "profile_e")) and key not in ("times", "factors"):
                keys[key] = value[:2]
        if name == "run":
            keys |= {"plane": "strain", "thickness": cell}
        if name == "constraint":
            keys["fix"] = keys["fix"].replace("z", "")
            if not keys["fix"]:
                continue
        found.append([name, keys])
    return found


def slab(case):
    """One cell thick between rollers: the program for the plane, in plane strain."""
    scene = copy_of(case.scene)
    case.need(any(keys.get("name") == ROLLERS for keys in groups(scene, "constraint")) and group(scene, "grid")["cells"][2] == 1)
    case.need(case.indicator == "none" and not any(keys.get("volumetric") == "b_bar" for keys in groups(scene, "material")))
    case.need(case.time != "modal")                                        # of as many modes of a slab some vary across it
    case.need(all(len(keys.get(key, "")) == 0 or keys[key][2] == 0.0 for _, keys in scene for key in ("force", "acceleration", "velocity", "displacement")))
    base, grid = case.base, group(scene, "grid")
    if case.time == "explicit":
        case.need(base.row["step"][-1] * np.max(base.row["particles"]) < MANY)
        group(scene, "method")["courant"] = PLANE_COURANT
    for keys in groups(scene, "probe"):        # there means over cells have the same weights; displacements of particles beside it have not
        keys |= {"at": [grid["lower"][2] + grid["cell"] / 2 if d % 3 == 2 else x for d, x in enumerate(keys["at"])]} if "at" in keys else {}
    if case.time == "explicit" or groups(scene, "probe"):
        base = case.bench.run(scene)
    run = case.bench.run(in_plane(scene), program=PLANE)
    case.need(run.code != 2)
    if run.code != base.code:
        raise Fault(f"in the plane it ends with {run.code}: {' '.join(run.said.split())[:300]}")
    base_case = Case(case.bench, scene, base, case.chance)
    base_case.same({name: values for name, values in run.row.items() if name in base.row and name not in ("particles", "cells", "angular_momentum")
                    and not name.startswith(("displacement_p", "velocity_p", "strain_pline"))}, base)


def of_few(oracle):
    """An oracle for scenes of few particles."""
    def asked(case):
        if np.max(case.base.row["particles"]) > FEW:
            raise Unasked
        oracle(case)
    return asked


def in_other_axes(q):
    """Axes exchanged, where no cell is cut: of two cells that are as near to a node of one that is nearly empty it hangs on that along the first axis."""
    def asked(case):
        case.need(not case.is_cut or case.frame == "updated")
        isometry(q)(case)
    return asked


IDENTITY = np.eye(3, dtype=int)
OWN_IMAGES = {f"mirror in {axis}": isometry(IDENTITY - 2 * np.diag(IDENTITY[d])) for d, axis in enumerate("xyz")} | {
    "cycle": in_other_axes(IDENTITY[[1, 2, 0]]), "cycle back": in_other_axes(IDENTITY[[2, 0, 1]]), "exchange": in_other_axes(IDENTITY[[0, 2, 1]])}
ORACLES = OWN_IMAGES | {"slab": slab} | {name: of_few(oracle) if name in ("slow", "damped") else oracle for name, oracle in SECOND.items()
                                         if name not in ("mirror in x", "mirror in y", "quarter turn", "thickness", "reverse", "finer")}


class SolidBench(combinations.Bench):
    """Runs scenes of solids."""

    def __init__(self, program=PROGRAM, release=RELEASE, exact=False):
        super().__init__(program, release, exact, draw, ORACLES)


if __name__ == "__main__":
    combinations.main(SolidBench, PROGRAM, RELEASE)
