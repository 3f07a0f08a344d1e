"""Static energy release rate by virtual extension of the crack, to check the estimators of a run against.

The case is run with its crack tip moved backwards and forwards by some root cells, all else equal. Under constant loads F a
linear elastic body at rest has the potential energy U - F.u = -U, U its strain energy, so that with its thickness B

    G = (U(a + h) - U(a - h)) / (2 h B),

and twice that where the model is half of the specimen (kind = 'symmetry'). The error of the difference is of second order
in h, h^2 G''/6; with --one-sided, (U(a + h) - U(a)) / (h B), it is of first order, h G'/2. To it comes the discretisation's
error of U as far as it changes with the crack: cells refined by `gradient` or `zz` differ between the runs, and this shows.
G is the sum of all modes; estimators are compared by their sum, too.

Where all loads are sudden, F.u is the work W that they have done, and W - U is taken for U. The potential energy is least at
rest: what a body that still moves is off rest enters W - U by its square alone, where U itself is off in proportion.
How far each G may be off rest is estimated from the last tenth of the run: for the virtual extension by the energies of the
motion, for an estimator, which needs a body closer to rest, by the range of its column.

Exit code: 0 done; 2 the case is not one for this; 3 the body is not at rest; 4 a file or the program is missing; or that of
the run that failed.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
import tempfile
from argparse import Namespace
from collections import namedtuple
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import UNREADABLE, USAGE, ResultError
from ..history import History
from ..program import program_of_scripts
from ..scripts import Parser
from ..stored_model import StoredModel

PROGRAM = program_of_scripts()
MOVING = 3        # exit code: the body is not at rest
LAST_PART = 0.1   # part of the run in which it must be

Sample = namedtuple("Sample", "tip energy unrest")
Sample.__doc__ = "A run: its crack tip [m], energy stored at the end [J], and what this may still be off rest [J]."
Rate = namedtuple("Rate", "name value unrest")
Rate.__doc__ = "What an energy release rate is called, its value, and what this may be off rest [J/m2]."


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    with open_folder(options.keep) as folder:
        runner = Runner(options, folder)
        scene = runner.scene()
        check_scene(scene, options.case)
        moves = {"middle": 0, "ahead": options.cells} | ({} if options.one_sided else {"behind": -options.cells})
        histories = {name: runner.history(name, moved(scene, cells)) for name, cells in moves.items()}
    first, last = "middle" if options.one_sided else "behind", "ahead"
    samples = [sample_of(histories[name], scene, moves[name]) for name in (first, last)]
    check_rest(samples, options)
    extension = (moves[last] - moves[first]) * scene.cell()
    g = release_rate(samples, extension, scene)
    rates = [Rate("virtual_extension", g, g * off_rest(samples)), *estimates(histories["middle"])]
    write = write_csv if options.csv else write_tables
    write(samples, rates, histories["middle"].attributes.get("G_ref"))


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("case", metavar="CASE.nml", help="a case that is at rest when it ends: damp it, load it constantly")
    parser.add_argument("--cells", type=whole, default=1, metavar="N",
                        help="root cells by which the tip moves to each side (default: %(default)s)")
    parser.add_argument("--one-sided", action="store_true", help="move the tip forwards only")
    parser.add_argument("--rest", type=float, default=0.01, metavar="PART",
                        help="how far energies may be off rest, as part of their difference (default: %(default)g)")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.KEY=VALUE", dest="settings",
                        help="passed on to all runs; may be repeated")
    parser.add_argument("--hampm", type=Path, default=PROGRAM, metavar="FILE", help="the program (default: the release build, or the installed one)")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the result files in this folder")
    parser.add_argument("--csv", action="store_true", help="write comma-separated values with every digit")
    parser.add_argument("-v", "--verbose", action="store_true", help="say what runs")
    return parser.parse_args(arguments)


def whole(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number above 0")
    return value


def open_folder(keep: Path | None) -> AbstractContextManager[Any]:
    """Where the result files go, as a context: a folder that stays, or one that goes with them."""
    return nullcontext(keep) if keep else tempfile.TemporaryDirectory()


class Runner:
    """Runs the case with settings that take the place of those in its file."""

    def __init__(self, options: Namespace, folder: str | Path) -> None:
        self.case, self.settings, self.verbose = options.case, options.settings, options.verbose
        self.program, self.folder = options.hampm.resolve(), Path(folder)

    def scene(self) -> StoredModel:
        """The case as the program understands it: all keys with the values in force."""
        return StoredModel(self._call([], "--check").stdout, self.case)

    def history(self, name: str, settings: Sequence[str]) -> History:
        """Run the case into NAME.h5; its history. What the run warns of is passed on."""
        if self.verbose:
            print(f"{name}: {' '.join(settings) or 'as it is'}", file=sys.stderr)
        process = self._call([*settings, f"output.file={name}.h5"], "--quiet", "--force", "--output", self.folder)
        if process.stderr:
            print(f"{name}: {process.stderr.rstrip()}", file=sys.stderr)
        return History(self.folder / f"{name}.h5")

    def _call(self, settings: Sequence[str], *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        words = [word for setting in [*self.settings, *settings] for word in ("--set", setting)]
        try:
            process = subprocess.run([self.program, self.case, *arguments, *words], capture_output=True, text=True)
        except OSError as error:
            raise ResultError(f"{self.program}: cannot be run ({error.strerror}); `make program` builds it, --hampm names "
                              "another", UNREADABLE) from error
        if process.returncode != 0:
            raise ResultError(f"{' '.join(['hampm', self.case, *words])} has failed:\n{process.stderr.rstrip()}",
                              process.returncode)
        return process


def check_scene(scene: StoredModel, case: str) -> None:
    """The case has a crack, and is one in which G is the change of the strain energy."""
    if not scene.count("crack"):
        raise ResultError(f"{case}: has no group &crack, so there is no tip to move")
    if len(scene.numbers("crack", "tip")) != 2:
        raise ResultError(f"{case}: its crack has no key 'tip' to move; give it as kind = 'symmetry', 'line' or 'plane' with front = 'straight'")
    if not scene.count("load"):
        raise ResultError(f"{case}: has no group &load, so there is no constant load that stores energy")
    for n in range(1, scene.count("material") + 1):
        if (law := scene.text("material", "law", n)) != "linear_elastic":
            raise ResultError(f"{case}: material({n}) has law = '{law}'; only of a linear elastic body is G the change of "
                              "the strain energy")


def moved(scene: StoredModel, cells: int) -> list[str]:
    """Settings that move the crack tip by some root cells in its direction, and nothing else of the crack."""
    if cells == 0:
        return []
    tip, shift, length = np.array(scene.numbers("crack", "tip")), shift_of(scene, cells), scene.numbers("crack", "length")
    settings = [f"crack.tip={listed(tip + shift)}"]
    if scene.text("crack", "kind") == "symmetry":
        settings += moved_constraints(scene, tip, shift)
    elif any(length):  # it is that of the crack behind the tip, whose other end stays
        settings.append(f"crack.length={length[0] + cells * scene.cell()!r}")
    return settings


def shift_of(scene: StoredModel, cells: int) -> Array:
    """So many root cells in the direction of the crack [m]."""
    direction = np.array(scene.numbers("crack", "direction"))
    return cells * scene.cell() * direction / np.hypot(*direction)


def moved_constraints(scene: StoredModel, tip: Array, shift: Array) -> list[str]:
    """Settings that move the edge, at the tip, of each box that holds the nodes from the tip on. The edge is between the
    tip and the node behind it, which is free."""
    direction = np.array(scene.numbers("crack", "direction"))
    along = int(np.argmax(np.abs(direction)))
    edge = "lower" if direction[along] > 0 else "upper"
    settings = []
    for n in range(1, scene.count("constraint") + 1):
        if holds(scene, n, tip, "yx"[along]):
            corner = np.array(scene.numbers("constraint", edge, n))
            settings.append(f"constraint({n}).{edge}={listed(corner + shift)}")
    if not settings:
        raise ResultError(f"{scene.path}: no &constraint holds the nodes from the crack tip on, so there is none to move with it")
    return settings


def holds(scene: StoredModel, n: int, point: Array, component: str) -> bool:
    """Whether a constraint holds a component of a node at a point."""
    close = 1e-6 * scene.cell()
    lower, upper = (np.array(scene.numbers("constraint", key, n)) for key in ("lower", "upper"))
    return component in scene.text("constraint", "fix", n) and bool(np.all((lower - close <= point) & (point <= upper + close)))


def listed(values: Iterable[float]) -> str:
    return ",".join(repr(float(value)) for value in values)


def sample_of(history: History, scene: StoredModel, cells: int) -> Sample:
    tip = np.array(scene.numbers("crack", "tip")) + shift_of(scene, cells)
    strain, kinetic, work = (history.columns[name] for name in ("strain_energy", "kinetic_energy", "external_work"))
    late = last_part(history)
    if np.count_nonzero(late) < 3:
        raise ResultError(f"{history.path.name}: the last {LAST_PART:.0%} of the run have fewer than 3 samples, too few to see "
                          "whether the body is at rest (set `history_interval` in &output)")
    energy = work - strain if all_sudden(scene) else strain
    signs = [np.ptp(energy[late]), np.max(kinetic[late])]
    if all_sudden(scene):
        signs.append(distance_energy(strain[-1], work[-1]))
    return Sample(tip, energy[-1], max(signs))


def last_part(history: History) -> Array:
    """Which samples are of the part of the run in which the body must be at rest."""
    return history.times >= (1 - LAST_PART) * history.times[-1]


def all_sudden(scene: StoredModel) -> bool:
    """Whether all loads have their full size from the beginning, so that their work is that over the displacement."""
    return all(scene.text("load", "history", n) == "step" and scene.numbers("load", "start", n)[0] <= 0
               for n in range(1, scene.count("load") + 1))


def distance_energy(strain: float, work: float) -> float:
    """Least strain energy of the displacement d by which a linear body under loads F is off rest [J].

    By Clapeyron's theorem 2 U = W at rest; off it 2 U - W is F.d and higher powers of d, and by Schwarz's inequality
    (F.d)^2 <= 4 U U(d).
    """
    return (2 * strain - work) ** 2 / (4 * max(strain, np.finfo(float).tiny))


def check_rest(samples: Sequence[Sample], options: Namespace) -> None:
    """The energy grows with the crack, by much more than it is off rest."""
    first, last = samples
    if (off := off_rest(samples)) > options.rest:
        raise ResultError(
            f"{options.case}: is not at rest when it ends: stored energies of {first.energy:.6g} and {last.energy:.6g} J may be "
            f"off by {off:.2g} of their difference (--rest allows {options.rest:g}); set a &damping rate near twice the lowest "
            "angular frequency, or a later end_time", MOVING)
    if last.energy <= first.energy:
        raise ResultError(f"{options.case}: the stored energy does not grow with the crack, so the loads do not open it", USAGE)


def off_rest(samples: Sequence[Sample]) -> float:
    """What two energies may be off rest, as part of their difference: so much may be wrong with G."""
    off, difference = sum(sample.unrest for sample in samples), abs(samples[1].energy - samples[0].energy)
    return 0.0 if off == 0 else off / difference if difference > 0 else np.inf


def release_rate(samples: Sequence[Sample], extension: float, scene: StoredModel) -> float:
    """G of the whole specimen [J/m2] from the energies at two crack lengths."""
    halves = 2 if scene.text("crack", "kind") == "symmetry" else 1
    return halves * (samples[1].energy - samples[0].energy) / (extension * scene.numbers("run", "thickness")[0])


def estimates(history: History) -> Iterator[Rate]:
    """What the estimators of a run have at its end; modes, whose signs only tell which way the faces part, are summed."""
    columns = history.columns
    for name in columns:
        if name.startswith("G_") and name.endswith("_I"):
            second = columns.get(f"{name}I")
            g = columns[name] if second is None else columns[name] + np.abs(second)
            yield Rate(name if second is None else f"{name}+II", g[-1], np.ptp(g[last_part(history)]))


def rows(rates: Sequence[Rate], g_ref: float | None) -> Iterator[tuple[str, float, float | None, float, float]]:
    """Name, G, G/G_ref (None where G_ref is not known), and in percent of the first G: off rest, and difference from it."""
    first = rates[0].value
    for rate in rates:
        yield (rate.name, rate.value, rate.value / g_ref if g_ref else None, 100 * rate.unrest / first,
               100 * (rate.value / first - 1))


def write_tables(samples: Sequence[Sample], rates: Sequence[Rate], g_ref: float | None) -> None:
    print(f"{'crack tip [m]':<24}{'stored energy [J]':>20}")
    for sample in samples:
        print(f"{listed(sample.tip.round(12)):<24}{sample.energy:>20.8g}")
    print(f"\n{'estimator':<24}{'G [J/m2]':>20}{'G/G_ref':>12}{'off rest [%]':>16}{'difference [%]':>16}")
    for name, value, ratio, unrest, difference in rows(rates, g_ref):
        print(f"{name:<24}{value:>20.8g}{'-' if ratio is None else f'{ratio:.5f}':>12}{unrest:>16.3f}{difference:>16.3f}")


def write_csv(samples: Sequence[Sample], rates: Sequence[Rate], g_ref: float | None) -> None:
    """The estimators as rows; the runs behind them as comments above."""
    for sample in samples:
        print(f"# crack tip {listed(sample.tip.round(12))} m: stored energy {sample.energy:.17g} J")
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(["estimator", "G [J/m2]", "G/G_ref", "off rest [%]", "difference [%]"])
    writer.writerows(["" if value is None else value for value in row] for row in rows(rates, g_ref))
