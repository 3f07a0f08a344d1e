"""A second opinion on static scenes drawn at random by the project's own generator, tests/fuzz/drawn_scenes.py.

    .venv/bin/python tests/second_opinion/trial.py --seed 3 --cases 100
    .venv/bin/python tests/second_opinion/trial.py --seed 3 --first 17 --cases 1 --show

Scenes are those of `Drawing`, at rest, of linear elastic and orthotropic material, without growth and cohesion, with J and K of each crack; one that is refused is repaired as in `combinations.py`. Each quantity that
disagrees is a line, with what it is off over both errors. Totals and counts by kind of quantity follow, and of those with an estimated error how many it holds, by what the scene
has, with the median of the error that is told over the true one, and of how many models, as the values of one model hang together.
Exit code 1 where a quantity disagrees.
"""

import argparse
import random
import re
import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from judge import judge, text
from opinion_program import PROGRAM, ROOT, run
from opinion_scene import Outside, Reader, crossings

sys.path.insert(0, str(ROOT / "tests/fuzz"))

from drawn_scenes import Drawing, groups, repair, text_of  # noqa: E402

REPAIRS = 15
ORDER = 3


class AtRest(Drawing):
    """A scene at rest of material that follows Hooke's law, without growth, cohesion and cracks to come."""

    def __init__(self, chance):
        super().__init__(chance)
        self.time, self.frame, self.end = "static", "total", 10 * self.tick
        self.grows = self.holds = self.waits = False
        self.margin = min(self.margin, 1)
        self.shaped = self.crack != "symmetry" and chance.random() < 0.35

    def material(self, name, law):
        return super().material(name, law if law in ("linear_elastic", "orthotropic") else self.chance.choice(["linear_elastic", "linear_elastic", "orthotropic"]))


def traits(path):
    """What a scene has, by which its estimated errors are counted; of cracks at an edge whether an edge with a mouth is loaded too."""
    one = Reader(path)
    scene, group = one.scene(), one.one
    pairs = [ends for crack in scene.cracks for ends in crack.segments]
    at_edge = [place for crack in scene.cracks for place in (crack.points[0], crack.points[-1]) if crack.kind != "symmetry" and not any(np.allclose(place, tip.place) for tip in crack.tips)]
    at_edge = [place for a, b in pairs for piece in scene.pieces() for place in [a + t * (b - a) for t in crossings(a, b, piece) if 0 <= t <= 1]] if at_edge else []
    acts = [load for load in scene.loads if load.kind in ("traction", "pressure") and load.lower is not None]
    pressed = any(np.all(place > load.lower - 1e-6) and np.all(place < load.upper + 1e-6) for place in at_edge for load in acts) or any(load.kind == "crack" for load in scene.loads) and at_edge
    found = {"cracks on a symmetry plane": any(crack.kind == "symmetry" for crack in scene.cracks), "mouths that are loaded": pressed, "other mouths": at_edge and not pressed,
             "kinks": any(len(crack.points) > 2 for crack in scene.cracks), "several cracks": len(scene.cracks) > 1, "rings": scene.ring, "quadratic cells": scene.order == 2,
             "graded bodies": any(body.at for body in scene.bodies), "eigenstrains": any(np.any(body.eigenstrain) for body in scene.bodies), "holes and curved edges": len(scene.holes) > 0 or
             any(piece[0] == "arc" for piece in scene.pieces()), "two bodies": len(scene.bodies) > 1, "orthotropic": any(not body.material.isotropic for body in scene.bodies),
             "finer cells at tips": group("refine").get("indicator", "none") != "none", "one point a cell": any(keys.get("points_per_cell") == 1 for keys in one.groups["body"])}
    return ["all", *(name for name, has in found.items() if has)]


def drawn(chance, path, program):
    """The text of a scene that the program accepts, in a file; None where it refuses all repairs."""
    scene = AtRest(chance).scene()
    for _ in range(REPAIRS):
        for keys in groups(scene, "method"):
            keys["time"] = "static"
        for keys in groups(scene, "constraint"):
            keys.pop("unilateral", None)
        for keys in groups(scene, "energy_release") if groups(scene, "crack") else []:     # J and K are what is judged
            keys["estimators"] = ["domain_integral", *(name for name in keys.get("estimators", []) if name != "domain_integral")]
        path.write_text(text_of(scene))
        ended = run(path, program=program)
        if ended.code != 2:
            return True
        messages = [line.removeprefix("hampm: ") for line in ended.said.splitlines() if line.startswith("hampm: ")]
        scene = repair(scene, messages, chance)
    return False


class Trial:
    """Counts of a series of cases."""

    def __init__(self, program, order, tell, keep=None):
        self.program, self.order, self.tell, self.keep = program, order, tell, keep
        self.ends, self.outside, self.unknown, self.kinds, self.faults, self.barred = Counter(), Counter(), Counter(), Counter(), [], defaultdict(list)

    def case(self, seed, number, show=False):
        """Draws, runs and judges one."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "case.nml"
            if not drawn(random.Random(f"{seed} {number}"), path, self.program):
                self.ends["refused"] += 1
                return
            if show:
                self.tell(path.read_text())
            try:
                rows, unknown, first, _ = judge(path, self.order, self.program)
            except Outside as reason:
                self.ends["not judged"] += 1
                self.outside[re.sub(r"[-+]?\d[-+.\de]*", "#", str(reason))[:90]] += 1
                return
            except Exception as error:  # noqa: BLE001: the mesher and the solver have errors of their own, which are counted as such
                if show:
                    raise
                self.ends["failed"] += 1
                self.tell(f"seed {seed} case {number}: {type(error).__name__}: {str(error)[:200]}")
                return
            self.ends["judged"] += 1
            self.unknown.update(unknown.values())
            if show:
                self.tell(text(rows))
            off = [row for row in rows if row.verdict == "disagree"]
            self.ends["judged, all agree"] += not off
            for row in rows:
                self.kinds[row.kind, row.verdict] += 1
                if row.has_bar and row.program_error > 0 and row.own_error < 0.1 * row.program_error:
                    for trait in [*traits(path), *(["supports of few nodes, which a warning names"] if "no estimated error knows of it" in first.said else [])]:
                        self.barred[trait, row.kind].append((abs(row.program - row.own) / row.program_error, (seed, number)))
            for row in off:
                ratio = abs(row.program - row.own) / (row.program_error + row.own_error or 1e-300)
                self.faults.append((seed, number, row, ratio))
                self.tell(f"seed {seed} case {number} {row.column}: {row.program:.6g} ± {row.program_error:.2g}{'' if row.has_bar else ' (finer cells)'}, finite elements {row.own:.6g} ± {row.own_error:.2g}, "
                          f"off {ratio:.2f} of both")
            if off and self.keep:
                (self.keep / f"{seed}_{number}.nml").write_text(path.read_text())

    def totals(self):
        """The counts as text."""
        lines = ["", "| quantity | judged | agree | disagree |", "|---|---|---|---|"]
        for kind in sorted({kind for kind, _ in self.kinds}):
            agree, off = self.kinds[kind, "agree"], self.kinds[kind, "disagree"]
            lines.append(f"| {kind} | {agree + off} | {agree} | {off} |")
        lines += ["", "| estimated errors | values | models | held | models with all held | median of told over true |", "|---|---|---|---|---|---|"]
        for trait in dict.fromkeys(trait for trait, _ in self.barred):
            for kinds in [("J", "G"), ("K_I", "K_II")] + [(kind,) for kind in sorted({kind for _, kind in self.barred if kind.startswith("G_")}) if trait == "all"]:
                off = [part for kind in kinds for part in self.barred[trait, kind]]
                if off:
                    ratios, models, failed = [ratio for ratio, _ in off], {model for _, model in off}, {model for ratio, model in off if ratio > 1}
                    lines.append(f"| {trait}: {', '.join(kinds)} | {len(off)} | {len(models)} | {np.mean(np.array(ratios) <= 1):.0%} | {1 - len(failed) / len(models):.0%} | "
                                 f"{1 / max(np.median(ratios), 1e-9):.2g} |")
        lines += ["", *(f"{name}: {count}" for name, count in self.ends.most_common())]
        lines += ["not judged: " + f"{count} {reason}" for reason, count in self.outside.most_common()]
        lines += ["quantities not judged: " + f"{count} {reason}" for reason, count in self.unknown.most_common()]
        return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--cases", type=int, default=100, metavar="N", help="scenes that are drawn")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first case of the seed")
    parser.add_argument("--order", type=int, default=ORDER, metavar="N", help="of the elements; one less tells their error")
    parser.add_argument("--longest", type=float, default=1e9, metavar="S", help="begin no case after so many seconds")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where to write the models that disagree")
    parser.add_argument("--show", action="store_true", help="print each scene and its table")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    trial, begun = Trial(options.program.resolve(), options.order, lambda text: print(text, flush=True), options.keep), time.monotonic()
    for number in range(options.first, options.first + options.cases):
        if time.monotonic() - begun > options.longest:
            break
        trial.case(options.seed, number, options.show)
    print(trial.totals())
    sys.exit(1 if trial.faults else 0)


if __name__ == "__main__":
    main()
