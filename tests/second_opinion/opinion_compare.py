"""Columns of the program beside what finite elements say of them.

Two numbers agree where they differ by no more than both errors. That of the program is its own column `_error`; where it has none, SETTLED times what the number changes by with
cells of half the size, and a part of the largest value of its kind. That of the elements is what the last order and the rings make of it, with a floor.
"""

from dataclasses import dataclass

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
import opinion_integrals as integrals
from opinion_mesh import build
from opinion_scene import Outside, distance
from opinion_solve import Problem

SETTLED, COARSE = 3.0, 0.01    # and by this part of the largest value of that kind, as differences of few cells tell little
FLOOR = 1e-5            # of the own error, over the value
NOTHING = 1e-9          # over the largest value of that kind, or what it would be at the stress of all that acts: rounding
BESIDE = 2.0            # distance of a tip within which no stress or strain is judged [cells]
FACE = 2e-3             # beside a crack, from where values are continued to its faces [cells]


@dataclass
class Row:
    """A quantity by both, with its verdict: 'agree', 'disagree', or why there is none."""

    column: str
    kind: str
    program: float
    program_error: float
    own: float
    own_error: float
    has_bar: bool
    verdict: str = ""


class Answer:
    """What finite elements of one order say, by column: (kind, value, scale of its kind)."""

    def __init__(self, scene, mesh, order, rings=integrals.RINGS):
        self.scene, self.mesh, self.values, self.unknown = scene, mesh, {}, {}
        self.solution = solution = Problem(scene, mesh, order).solve()
        self.size = max(np.abs(one.vec.FV().NumPy()[:len(mesh.nodes)]).max() for one in (solution.ux, solution.uy)) or 1.0
        self.spread = {}
        self.stress = max(natural_stresses(scene, mesh.size))
        self.refuse_pressed()
        self.tips(order, rings)
        self.wholes()
        for keys in scene.probes:
            try:
                self.probe(keys)
            except (Outside, RuntimeError, netgen.NgException) as reason:    # the last is of a point in no element
                self.unknown[keys["name"]] = str(reason)

    def add(self, column, kind, value, unit, scale=0.0):
        """Adds a value; what is far below the stress of all that acts at any time is rounding."""
        least = self.stress**2 if kind in ("J", "energy", "work") or kind.startswith("G") else self.stress
        self.values[column] = kind, value * unit, scale * unit, NOTHING * max(abs(scale), least * self.mesh.size) * abs(unit)

    def side(self, place, crack, left):
        """The displacement of a face of a crack at a place on it."""
        a, b = min(zip(crack.points, crack.points[1:]), key=lambda ends: distance(place, ("line", *ends)))
        along = (b - a) / np.linalg.norm(b - a)
        off = min([FACE, *(0.05 * np.linalg.norm(place - end) for end in crack.points)]) * (1 if left else -1) * np.array([-along[1], along[0]])
        near, far = (self.solution.at(ng.CF((self.solution.ux, self.solution.uy)), place + k * off) for k in (1, 2))
        return 2 * near - far

    def refuse_pressed(self):
        """Refuses cracks with contact whose faces would overlap."""
        for crack in self.scene.cracks:
            if not crack.contact:
                continue
            for a, b in zip(crack.points, crack.points[1:]):
                left = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
                for part in (0.003, 0.02, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95, 0.985, 0.997):
                    place = a + part * (b - a)
                    if self.scene.material_at(place) is None:
                        continue
                    if (self.side(place, crack, True) - self.side(place, crack, False)) @ left < -1e-5 * self.size:
                        raise Outside("faces that press on each other")

    def tips(self, order, rings):
        """G, J and K of all tips."""
        scene, number = self.scene, 0
        if self.solution.gives_way:
            self.unknown["G, J, K"] = "supports at points that give way"
            return
        tips = [tip for crack in scene.cracks for tip in crack.tips]
        found = []
        for tip, room, seam in zip(tips, self.mesh.rooms, self.mesh.seams):
            number += 1
            suffix = "" if number == 1 else f"_tip{number}"
            try:
                rows = integrals.tip_values(self.solution, scene, tip, room, seam, order, rings)
            except Outside as reason:
                self.unknown[f"tip {number}"] = str(reason)
                continue
            found.append((suffix, rows, tip))
        energy, factor = scene.young * scene.cell, scene.young * scene.cell**0.5
        largest = max((abs(rows[0, 0]) for _, rows, _ in found), default=0.0)
        for suffix, rows, tip in found:
            j, k1, k2 = rows.mean(0)
            spread = np.ptp(rows, axis=0)
            for name in ("J", "G"):
                self.add(f"{name}{suffix}", name, j, energy, largest)
                self.spread[f"{name}{suffix}"] = spread[0] * energy
            if np.isnan(k1):
                continue
            names = [("K_I", k1, spread[1])] + ([("K_II", k2, spread[2])] if tip.crack.kind != "symmetry" else [])
            for name, value, apart in names:
                self.add(f"{name}{suffix}", name, value, factor, np.nanmax(np.abs(rows[:, 1:])))
                self.spread[f"{name}{suffix}"] = apart * factor
            if scene.body_at(tip).material.isotropic:
                for mode, value in (("I", k1), ("II", k2)):
                    for estimator in ("domain", "vcct", "stress_closure", "material_force"):
                        self.add(f"G_{estimator}_{mode}{suffix}", f"G_{estimator}", abs(j) * value**2 / max(k1**2 + k2**2, 1e-300), energy, j)
                        self.spread[f"G_{estimator}_{mode}{suffix}"] = spread[0] * energy

    def wholes(self):
        """Energies, work and reactions."""
        scene, solution, force = self.scene, self.solution, self.scene.force
        eigen = any(np.any(body.eigenstrain) for body in scene.bodies)
        if solution.singular:
            self.unknown["energies, reactions"] = "a point carries a load"
            return
        self.add("strain_energy", "energy", solution.strain_energy, force * scene.cell, solution.strain_energy)
        if not eigen:
            self.add("external_work", "work", solution.external_work, force * scene.cell, solution.strain_energy)
        acting = [np.abs(load.value).max() * np.abs(load.factors).max() for load in scene.loads if load.kind in ("traction", "point", "body")]
        acting += [abs(value) for one in solution.reactions.values() for value in one.values()]
        scale = max([*acting, solution.strain_energy / self.size])
        for number, reaction in solution.reactions.items():
            name = scene.holds[number].name
            for c, value in reaction.items():
                if name:
                    self.add(f"reaction_{name}_{'xy'[c]}", "reaction", value, force, scale)

    def probe(self, keys):
        """The columns of a probe."""
        scene, solution, name = self.scene, self.solution, keys["name"]
        wanted = keys["quantity"] if isinstance(keys["quantity"], list) else [keys["quantity"]]
        if solution.singular:
            raise Outside("a point carries a load")
        loose = solution.floats
        u = ng.CF((solution.ux, solution.uy))
        if "at" in keys:
            at = (np.reshape(keys["at"], (-1, 2)) - scene.origin) / scene.cell
            if keys.get("face", "none") != "none":
                crack = min((one for one in scene.cracks), key=lambda one: min(np.linalg.norm(at[0] - p) for p in np.linspace(one.points[0], one.points[-1], 400)))
                a, b = crack.points[:2]
                left = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
                at = at + 1e-5 * left * (1 if keys["face"] == "left" else -1)
            components, young = (("xx", 0), ("yy", 1), ("xy", 3)) + ((("zz", 2),) if scene.ring else ()), scene.young
            points = at if len(at) == 1 else at[0] + np.linspace(0.005, 0.995, 100)[:, None] * (at[1] - at[0])
            if any(scene.material_at(p) is None for p in (points if wanted != ["strain"] else at)):
                raise Outside("a probe beside the material")
            near = min((np.linalg.norm(p - tip.place) for p in points for one in scene.cracks for tip in one.tips), default=np.inf)
            for quantity in wanted:
                if quantity in ("stress", "strain") and near < BESIDE and not (quantity == "strain" and len(at) == 2):
                    self.unknown[f"{quantity}_{name}"] = "a probe next to a tip"
                elif quantity == "strain" and len(at) == 2:
                    way = at[1] - at[0]
                    ends = [solution.at(u, p) for p in at]
                    if not solution.floats:
                        self.add(f"strain_{name}", "strain of a line", (ends[1] - ends[0]) @ way / (way @ way), 1.0, self.size / np.linalg.norm(way))
                elif quantity == "displacement" and not loose:
                    mean = np.mean([solution.at(u, p) for p in points], axis=0)
                    for c in range(2):
                        self.add(f"displacement_{name}_{'xy'[c]}", "displacement", mean[c], scene.cell, self.size)
                elif quantity in ("strain", "stress"):
                    mean = np.mean([solution.at(solution.strain() if quantity == "strain" else solution.stress(), p) for p in points], axis=0)
                    for component, c in components:
                        half = 0.5 if quantity == "strain" and c == 3 else 1.0
                        self.add(f"{quantity}_{name}_{component}", quantity, half * mean[c], young if quantity == "stress" else 1.0, np.abs(mean).max())
        if {"opening", "volume"} & set(wanted):
            self.crack_probe(keys, name, wanted)
        if "load_line" in wanted:
            of = keys["of"] if isinstance(keys["of"], list) else [keys["of"]]
            number = next((k for k, load in enumerate(scene.loads) if load.name == of[0]), None)
            if number is not None and len(of) == 1 and not loose:
                for c in range(2):
                    self.add(f"load_displacement_{name}_{'xy'[c]}", "load-line displacement", solution.displaced[number][c], scene.cell, self.size)

    def crack_probe(self, keys, name, wanted):
        """Opening, sliding and volume of a crack."""
        scene = self.scene
        of = keys.get("of", [""])
        crack = next((one for one in scene.cracks if one.name == (of if isinstance(of, str) else of[0])), None)
        if crack is None:
            raise Outside("a probe of a crack without a name")
        symmetric = crack.kind == "symmetry"

        def jump(place, direction):
            if symmetric:
                u = self.solution.at(ng.CF((self.solution.ux, self.solution.uy)), place + np.array([0, FACE]))
                return 2 * u[1], 0.0
            apart = self.side(place, crack, True) - self.side(place, crack, False)
            return apart @ np.array([-direction[1], direction[0]]), apart @ direction

        if "opening" in wanted:
            tip = next((one for one in crack.tips if one.end == keys.get("tip", "last")), None)
            if tip is None or keys["distance"] / scene.cell > tip.straight:
                raise Outside("an opening beyond a kink")
            along = tip.direction if tip.end == "last" else -tip.direction
            opened, slid = jump(tip.place - keys["distance"] / scene.cell * tip.direction, along)
            self.add(f"opening_{name}", "opening", opened, scene.cell, self.size)
            if not symmetric:
                self.add(f"sliding_{name}", "opening", slid, scene.cell, self.size)
        if "volume" in wanted and not scene.ring:
            number = next(k for k, one in enumerate(scene.cracks) if one is crack)
            if symmetric:
                raise Outside("volume on a symmetry plane")
            n, region = ng.specialcf.normal(2), self.mesh.boundaries(lambda key: key[2] == number)
            volume = -ng.Integrate(self.solution.ux * n[0] + self.solution.uy * n[1], region)
            self.add(f"volume_{name}", "volume", volume, scene.cell**2 * scene.thickness, self.size * np.linalg.norm(crack.points[-1] - crack.points[0]))


def natural_stresses(scene, size):
    """Of each eigenstrain, load and motion, without its history, what stress there is about, in the units of the scene."""
    parts = {"traction": 1 / size, "point": 1 / size, "body": 1 / size, "gravity": size * max(body.material.density for body in scene.bodies)}
    yield from (np.abs(body.eigenstrain).max() for body in scene.bodies)
    yield from (np.abs(load.value).max() * parts.get(load.kind, 1.0) for load in scene.loads)
    yield from (np.abs(hold.moved).max() / size for hold in scene.holds)


def answers(scene, order):
    """What elements of an order say, with what the order before it says less: {column: (kind, value, error, scale, rounding)}, and what is left out and why."""
    mesh = build(scene)
    low, high = Answer(scene, mesh, order - 1, integrals.RINGS[1:2]), Answer(scene, mesh, order)
    found = {}
    for column, (kind, value, scale, rounding) in high.values.items():
        if column in low.values:
            error = abs(value - low.values[column][1]) + high.spread.get(column, 0.0) + FLOOR * abs(value) + rounding
            found[column] = kind, value, error, scale, rounding
    return found, high.unknown


def table(found, row, finer_row):
    """All quantities that both have, with their verdicts."""
    rows = []
    for column, (kind, value, error, scale, rounding) in found.items():
        if column not in row or np.isnan(row[column]):
            continue
        name, _, tip = column.partition("_tip")
        bar = row.get(f"{name}_error" + (f"_tip{tip}" if tip else ""))
        its = abs(row[column]) if kind.startswith("G") else row[column]           # parts have the sign of their K, and so has G by closure
        has_bar = bar is not None and not np.isnan(bar)
        if not has_bar and kind in ("J", "G", "K_I", "K_II") or kind.startswith("G_") and not has_bar:
            continue
        if not has_bar:
            if column not in finer_row:
                continue
            bar = SETTLED * abs(finer_row[column] - its) + COARSE * abs(scale)
        off = abs(its - value)
        verdict = "agree" if off <= bar + error + rounding else "disagree"
        rows.append(Row(column, kind, its, bar, value, error, has_bar, verdict))
    return rows
