"""Columns of the program beside what finite elements say of them.

Two numbers agree where they differ by no more than both errors. That of the program is its own column `_error`; where it has none, MARGIN times what a value of first order in
the cell lacks if it changes so with finer cells, of half and of a quarter of the size, the larger of both, and a part of the largest value of its kind. That of the elements is what the last order and the rings make of it, with a floor.
"""

from dataclasses import dataclass

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
import opinion_integrals as integrals
from opinion_mesh import build
from opinion_scene import Outside, left_of, listed, unit
from opinion_solve import Problem

MARGIN, COARSE = 1.5, 0.01     # and by this part of the largest value of that kind, as differences of few cells tell little
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

    def displacement(self, place):
        """The displacement at a place."""
        return self.solution.at(ng.CF((self.solution.ux, self.solution.uy)), place)

    def apart(self, crack, place, direction):
        """How far the faces of a crack are apart at a place: opening and sliding in the axes of a direction along it, continued to the faces."""
        if crack.kind == "symmetry":
            return np.array([2 * self.displacement(place + np.array([0, FACE]))[1], 0.0])
        off = min([FACE, *(0.05 * np.linalg.norm(place - end) for end in crack.points)]) * left_of(crack.along(place))
        jump = sum(times * (self.displacement(place + k * off) - self.displacement(place - k * off)) for times, k in ((2, 1), (-1, 2)))
        return np.array([jump @ left_of(direction), jump @ direction])

    def refuse_pressed(self):
        """Refuses cracks with contact whose faces would overlap."""
        for crack in (one for one in self.scene.cracks if one.contact):
            for a, b in crack.segments:
                places = [a + part * (b - a) for part in (0.003, 0.02, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95, 0.985, 0.997)]
                if any(self.apart(crack, place, unit(b - a))[0] < -1e-5 * self.size for place in places if self.scene.material_at(place)):
                    raise Outside("faces that press on each other")

    def tips(self, order, rings):
        """G, J and K of all tips."""
        scene, found = self.scene, []
        if self.solution.gives_way:
            self.unknown["G, J, K"] = "supports at points that give way"
            return
        for number, (tip, room, seam) in enumerate(zip((tip for crack in scene.cracks for tip in crack.tips), self.mesh.rooms, self.mesh.seams), 1):
            try:
                found.append(("" if number == 1 else f"_tip{number}", integrals.tip_values(self.solution, scene, tip, room, seam, order, rings), tip))
            except Outside as reason:
                self.unknown[f"tip {number}"] = str(reason)
        energy, factor = scene.young * scene.cell, scene.young * scene.cell**0.5
        largest = max((abs(rows[0, 0]) for _, rows, _ in found), default=0.0)
        for suffix, rows, tip in found:
            j, k1, k2 = rows.mean(0)
            spread, of_k = np.ptp(rows, axis=0), np.abs(rows[:, 1:]).max()
            values = [(name, name, j, spread[0], energy, largest) for name in ("J", "G")]
            if not np.isnan(k1):
                values += [(name, name, value, apart, factor, of_k) for name, value, apart in (("K_I", k1, spread[1]), ("K_II", k2, spread[2])) if (name, tip.crack.kind) != ("K_II", "symmetry")]
                if scene.body_at(tip).material.isotropic:
                    values += [(f"G_{estimator}_{mode}", f"G_{estimator}", abs(j) * value**2 / max(k1**2 + k2**2, 1e-300), spread[0], energy, j)
                               for mode, value in (("I", k1), ("II", k2)) for estimator in ("domain", "vcct", "stress_closure", "material_force")]
            for name, kind, value, apart, factor_of, scale in values:
                self.add(name + suffix, kind, value, factor_of, scale)
                self.spread[name + suffix] = apart * factor_of

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
        loads = [np.abs(load.value).max() * np.abs(load.factors).max() for load in scene.loads if load.kind in ("traction", "point", "body")]
        felt = [abs(value) for one in solution.reactions.values() for value in one.values()]
        scale = max(*loads, *felt, solution.strain_energy / self.size, 0.0)
        for hold, reaction in ((scene.holds[number], one) for number, one in solution.reactions.items()):
            for c, value in reaction.items() if hold.name else ():
                self.add(f"reaction_{hold.name}_{'xy'[c]}", "reaction", value, force, scale)

    def probe(self, keys):
        """The columns of a probe."""
        name, wanted, of = keys["name"], listed(keys["quantity"]), listed(keys.get("of", ""))
        if self.solution.singular:
            raise Outside("a point carries a load")
        if "at" in keys:
            self.place_probe(keys, name, wanted)
        if {"opening", "volume"} & set(wanted):
            self.crack_probe(keys, name, wanted, of[0])
        number = next((k for k, load in enumerate(self.scene.loads) if load.name == of[0]), None)
        if "load_line" in wanted and number is not None and len(of) == 1 and not self.solution.floats:
            self.add_vector(f"load_displacement_{name}", "load-line displacement", self.solution.displaced[number])

    def add_vector(self, name, kind, values):
        """Adds a displacement."""
        for c in range(2):
            self.add(f"{name}_{'xy'[c]}", kind, values[c], self.scene.cell, self.size)

    def place_probe(self, keys, name, wanted):
        """Displacement, stress and strain at a point, or of a line."""
        scene, solution = self.scene, self.solution
        at = (np.reshape(keys["at"], (-1, 2)) - scene.origin) / scene.cell
        if keys.get("face", "none") != "none":
            crack = min(scene.cracks, key=lambda one: min(np.linalg.norm(at[0] - p) for p in np.linspace(one.points[0], one.points[-1], 400)))
            at = at + 1e-5 * left_of(unit(crack.points[1] - crack.points[0])) * (1 if keys["face"] == "left" else -1)
        is_line, way = len(at) == 2, at[-1] - at[0]
        points = at[0] + np.linspace(0.005, 0.995, 100)[:, None] * way if is_line else at
        if any(scene.material_at(p) is None for p in (points if wanted != ["strain"] else at)):
            raise Outside("a probe beside the material")
        near = min((np.linalg.norm(p - tip.place) for p in points for one in scene.cracks for tip in one.tips), default=np.inf)
        for quantity in wanted:
            if quantity == "strain" and is_line:
                if not solution.floats:
                    self.add(f"strain_{name}", "strain of a line", (self.displacement(at[1]) - self.displacement(at[0])) @ way / (way @ way), 1.0, self.size / np.linalg.norm(way))
            elif quantity == "displacement" and not solution.floats:
                self.add_vector(f"displacement_{name}", quantity, np.mean([self.displacement(p) for p in points], axis=0))
            elif quantity in ("strain", "stress") and near < BESIDE:
                self.unknown[f"{quantity}_{name}"] = "a probe next to a tip"
            elif quantity in ("strain", "stress"):
                mean = np.mean([solution.at(getattr(solution, quantity)(), p) for p in points], axis=0)
                for component, c in (("xx", 0), ("yy", 1), ("xy", 3), *([("zz", 2)] * scene.ring)):
                    half = 0.5 if quantity == "strain" and c == 3 else 1.0
                    self.add(f"{quantity}_{name}_{component}", quantity, half * mean[c], scene.young if quantity == "stress" else 1.0, np.abs(mean).max())

    def crack_probe(self, keys, name, wanted, of):
        """Opening, sliding and volume of a crack."""
        scene = self.scene
        number, crack = next(((k, one) for k, one in enumerate(scene.cracks) if one.name == of), (None, None))
        if crack is None:
            raise Outside("a probe of a crack without a name")
        if "opening" in wanted:
            tip = next((one for one in crack.tips if one.end == keys.get("tip", "last")), None)
            if tip is None or keys["distance"] / scene.cell > tip.straight:
                raise Outside("an opening beyond a kink")
            values = self.apart(crack, tip.place - keys["distance"] / scene.cell * tip.direction, tip.direction if tip.end == "last" else -tip.direction)
            for column, value in zip(["opening"] if crack.kind == "symmetry" else ["opening", "sliding"], values):
                self.add(f"{column}_{name}", "opening", value, scene.cell, self.size)
        if "volume" in wanted and not scene.ring:
            if crack.kind == "symmetry":
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


def change_of(column, value, finer_rows):
    """What a value of first order in the cell lacks, by its change with cells of 1/times of the size; None without."""
    return max((abs(row[column] - value) / (1 - 1 / times) for times, row in finer_rows.items() if column in row), default=None)


def table(found, row, finer_rows):
    """All quantities that both have, with their verdicts; rows of finer cells by how many there are of one."""
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
            lacks = change_of(column, its, finer_rows)
            if lacks is None:
                continue
            bar = MARGIN * lacks + COARSE * abs(scale)
        off = abs(its - value)
        verdict = "agree" if off <= bar + error + rounding else "disagree"
        rows.append(Row(column, kind, its, bar, value, error, has_bar, verdict))
    return rows
