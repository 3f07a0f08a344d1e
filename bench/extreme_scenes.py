"""The scenes of the atlas of extremes, and how each is judged: see `extremes.py`.

Scenes are in cells of size 1, density 1 and dilatational wave speed 1 where nothing else is said: a time step is then a
courant number.
"""

import math
import re
import subprocess
from dataclasses import dataclass

import h5py
import numpy as np
from mass_matrices import KINDS, SCHEMES, bar_is_held, bisect, body, group, held, is_stable, mass_settings, scene
from mass_theory import Block
from program_runs import Program
from tables import ROOT

FRAMES = ("total", "updated")
LIKELY = re.compile(r"Likely cause|&\w+ \w+")  # every message names a cause or a key


@dataclass
class Cell:
    """A run of the atlas and what came of it."""

    name: str
    outcome: str            # stable, warned, refused, stopped or defect
    quantity: str = ""      # what was looked at
    value: float | None = None
    bound: float | None = None
    message: str = ""


@dataclass
class Outcome:
    """How the program has ended."""

    code: int
    message: str
    columns: dict           # of the history
    units: dict             # of the columns
    path: object


class Runner(Program):
    """Runs the program on a namelist given as text, and judges what comes of it."""

    def outcome(self, text, settings=(), name="case"):
        path, result = self.folder / f"{name}.nml", self.folder / f"{name}.h5"
        path.write_text(text)
        result.unlink(missing_ok=True)
        command = [self.path, str(path), "--output", str(self.folder), "--force", "--quiet", "--threads", "1"]  # whatever a killed run has left
        command += [word for setting in settings for word in ("--set", setting)]
        process = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=600, check=False)
        columns, names = {}, {}
        if process.returncode in (0, 3) and result.exists():
            with h5py.File(result) as file:
                columns = {key: item[()] for key, item in file["history"].items()}
                names = {key: item.attrs["units"] for key, item in file["history"].items()}
        # Scenes at rest and in motion share their keys: that one of them has no effect says nothing about the numbers
        lines = [line for line in process.stderr.strip().splitlines() if " has no effect " not in line]
        return Outcome(process.returncode, "\n".join(lines), columns, names, result)

    def judge(self, name, text, quantity, bound, number, expected=None, settings=()):
        """Run a scene; `number(columns)` is to be within the bound in size. `expected`: outcomes that theory allows."""
        end = self.outcome(text, settings)
        cell = Cell(name, "defect", quantity, None, bound, end.message)
        if end.code == 2:
            cell.outcome = "refused" if LIKELY.search(end.message) else "defect"
        elif end.code == 3:
            cell.outcome = "stopped" if LIKELY.search(end.message) else "defect"
        elif end.code == 0:
            with np.errstate(all="ignore"):
                cell.value = abs(float(number(end.columns)))
            if "warning" in end.message:
                cell.outcome = "warned"
            elif cell.value <= bound:
                cell.outcome = "stable"
            if expected and "stable" in expected and not cell.value <= bound:
                cell.outcome = "defect"
        if expected and cell.outcome not in expected:
            cell.message = f"{cell.outcome}, which theory excludes. {cell.message}"
            cell.outcome = "defect"
        return cell


def kind_of(message):
    """A message without its place in the file, step, time and numbers; of several its last, which is why the run has ended."""
    line = message.splitlines()[-1].removeprefix("hampm: ")
    line = re.sub(r"^\S*?case\.nml:\d+: |^\S*case\.nml: ", "", line)
    line = re.sub(r"step \d+, t = \S+ s: ", "", line)
    line = re.sub(r"(?<![\w'])-?\d+\.?\d*(e[-+]?\d+)?(?![\w'])", "#", line)
    return line.replace("|", "/")


# --- numbers from a history -------------------------------------------------------------------------------------------

def stored(c):
    return c["kinetic_energy"] + c["strain_energy"]


def growth(c):
    """Energy gained without work, over the largest energy; negative values, losses, count as none."""
    gain = stored(c) + c["damping_loss"] - c["external_work"] - stored(c)[0]
    return max(0.0, gain.max() / max(stored(c).max(), 1e-300))


def frequency_error(expected, c):
    """Relative error of the first frequency, which is half of that of the kinetic energy [-]."""
    t, k = c["time"], c["kinetic_energy"] / c["kinetic_energy"].max()
    window = np.hanning(t.size)
    k = (k - np.average(k, weights=window)) * window

    def power(w):
        return abs(np.sum(k * np.exp(-1j * w * t)))

    trial = 2 * expected * np.linspace(0.5, 1.5, 201)
    step = trial[1] - trial[0]
    best = trial[np.argmax([power(w) for w in trial])]
    while step > 1e-7 * best:
        best = max((best - step, best - step / 2, best, best + step / 2, best + step), key=power)
        step /= 2
    return best / (2 * expected) - 1


def time_discrete(w, dt):
    """Angular frequency that leapfrog makes of w with steps dt."""
    return 2 / dt * math.asin(min(1.0, w * dt / 2))


def static_error(exact, c):
    """Relative error of the strain energy at rest; the kinetic energy that is left counts as error."""
    return abs(c["strain_energy"][-1] / exact - 1) + c["kinetic_energy"][-1] / exact


# --- scenes -----------------------------------------------------------------------------------------------------------

def method_of(kind="lumped", scheme="musl", frame="total", courant=0.3, box=(0, 0, 4, 1), **more):
    return mass_settings(kind, box) | {"scheme": f"'{scheme}'", "frame": f"'{frame}'", "courant": courant,
                                       "wave_speed": "'dilatational'"} | more


def interval_near(wanted, courant):
    """Multiple of the time step near a time, so that samples do not shorten the step."""
    return courant * max(1, round(wanted / courant)) * (1 - 1e-12)


def bar(n, method, end, velocity=1e-6, interval=0.8, law="linear_elastic", points=2, balance=False):
    """A bar of n cells, held at its left end, that starts with a uniform velocity."""
    text = scene((n + 1, 2), 0.0, end, interval_near(interval, method["courant"]), method, law, balance)
    piece = body((0, 0), (n, 1), (velocity, 0.0)).replace("&body\n", f"&body\n   points_per_cell = {points}\n")
    return text + piece + bar_is_held(n)


def bar_frequency(n, kind, points=2):
    """First angular frequency of the bar without the error in time, from waves along a row of cells (docs/explanation/mass.md)."""
    lumped = 1 - (points**2 - 1) / (3 * points**2)
    s = math.sin(math.pi / (4 * n)) ** 2
    mu = 1 - lumped * s
    mass, _, number = kind.partition(" ")
    x = {"lumped": 1.0, "consistent": 1 / mu, "weighted": 1 / (float(number or 0) + (1 - float(number or 0)) * mu),
         "fmpm": sum((1 - mu) ** j for j in range(int(number) if mass == "fmpm" else 1))}[mass]
    return math.sqrt(4 * s * mu * x**2)


# --- courant ----------------------------------------------------------------------------------------------------------

COURANTS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 1.9, 2.1, 5.0, 10.0)
BAR = 8


def courant(runner):
    """Every scheme, mass matrix and frame: the limit by bisection beside theory, then runs on both sides of it."""
    cells = []
    long, short = Block(20, 1, 0.0, held_y=True), Block(BAR, 1, 0.0, held_y=True)
    for kind in KINDS:
        mass, _, number = kind.partition(" ")
        options = {"order": int(number)} if mass == "fmpm" else {}
        a, b = long.inverse(mass, **options), short.inverse(mass, **options)
        w = math.sqrt(np.linalg.eigvals(b @ short.mass @ b @ short.stiffness).real.min())
        for scheme in SCHEMES:
            theory = long.limit(scheme, a)
            edge = short.limit(scheme, b)
            for frame in FRAMES:
                measured = bisect(lambda courant: is_stable(runner, (20, 1, 0.0), kind, scheme, courant, frame), theory, 0.01)
                error = abs(measured / theory - 1)
                cells.append(Cell(f"limit, {kind}, {scheme}, {frame}", "stable" if error < 0.01 else "defect",
                                  "limit of the time step against theory", error, 0.01, f"{measured:.3f}, {measured / theory:.3f}"))
                for c in sorted((*COURANTS, round(0.96 * edge, 3), round(1.04 * edge, 3))):
                    method = method_of(kind, scheme, frame, c, box=(0, 0, BAR / 2, 1))
                    name = f"{kind}, {scheme}, {frame}, {c}"
                    # near the limit the scheme borrows more energy than a tenth, which the program tells
                    expected = (("refused",) if c > 1.03 * edge else ("stable",) if c < 0.4 * edge else
                                ("stable", "warned") if c < 0.95 * edge else None)
                    below = time_discrete(w, c)
                    cells.append(runner.judge(name, bar(BAR, method, 20 * 2 * BAR, interval=min(0.8, c)),
                                              "first frequency of a bar against theory", 0.01,
                                              lambda h, f=below: abs(frequency_error(f, h)), expected))
    return cells


# --- poisson ----------------------------------------------------------------------------------------------------------

def settled_block(poisson, plane, kind, method, law="linear_elastic", strain=1e-6):
    """A block of 4 x 2 cells on rollers, pulled until it is at rest; its scene and its exact strain energy."""
    modulus = 1 / (1 - poisson**2) if plane == "strain" else 1.0
    stiffest = (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)) if plane == "strain" else 1 / (1 - poisson**2)
    first = math.pi / 2 / 4 * math.sqrt(min(modulus, 1.0))
    end = 60 / first  # the shortest waves of a lumped matrix lose a quarter as fast
    text = group("run", plane=f"'{plane}'", end_time=end) + group("grid", cell=1.0, cells="6, 4")
    text += group("material", name="'m'", law=f"'{law}'", young=1.0, poisson=poisson, density=1.0)
    text += group("method", **(mass_settings(kind, (0, 0, 2, 2)) | method)) + group("output", history_interval=end / 100)
    text += group("damping", rate=min(2 * first, 0.5 * math.sqrt(stiffest))) + body((0, 0), (4, 2))
    text += held((0, 0), (0, 4), "x") + held((0, 0), (6, 0), "y")
    text += group("load", kind="'traction'", lower="4, 0", upper="4, 2", force=f"{2 * strain * modulus}, 0")
    return text, 8 * modulus * strain**2 / 2


def poisson(runner):
    """A block pulled to rest. With the shear wave the time step knows nothing of how stiff the material is against pressure."""
    cells = []
    for plane in ("stress", "strain"):
        for wave in ("shear", "dilatational"):
            for kind in ("lumped", "fmpm 4", "consistent"):
                for nu in (-0.99, -0.5, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999):
                    text, exact = settled_block(nu, plane, kind, {"wave_speed": f"'{wave}'"})
                    cells.append(runner.judge(f"poisson {nu}, plane {plane}, {wave}, {kind}", text,
                                              "strain energy at rest against the exact one", 1e-4,
                                              lambda h, e=exact: static_error(e, h)))
    return cells


# --- contrast ---------------------------------------------------------------------------------------------------------

def composite_frequency(n, stiffness, density):
    """First frequency of a bar of n cells with modulus and density 1, then n with others, held at the first end."""
    speed = math.sqrt(stiffness / density)
    impedance = math.sqrt(stiffness * density)

    def residual(w):  # positive below the first frequency
        return math.cos(w * n) * math.cos(w * n / speed) - impedance * math.sin(w * n) * math.sin(w * n / speed)

    low, high = 0.0, math.pi / 2 / n * min(1.0, speed) * 1e-4
    while residual(high) > 0:
        low, high = high, high * 1.1
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if residual(middle) > 0 else (low, middle)
    return low


def contrast(runner):
    """Two bodies, one behind the other, whose stiffness or density differ."""
    cells, n = [], 5
    for kind, scheme, c in (("lumped", "musl", 0.9), ("lumped", "usavg", 0.9), ("lumped", "usf", 0.9), ("consistent", "musl", 0.35)):
        for what in ("stiffness", "density"):
            for ratio in (1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6):
                stiffness, density = (ratio, 1.0) if what == "stiffness" else (1.0, ratio)
                w = composite_frequency(n, stiffness, density)
                end = 4 * 2 * math.pi / w
                method = method_of(kind, scheme, courant=c, box=(0, 0, n, 1)) | {"solver": "'direct'"}
                text = scene((2 * n + 1, 2), 0.0, end, end / 400, method)
                text += group("material", name="'other'", young=stiffness, poisson=0.0, density=density)
                text += body((0, 0), (n, 1), (1e-6, 0)) + bar_is_held(2 * n)
                text += body((n, 0), (2 * n, 1), (1e-6, 0)).replace("'m'", "'other'")
                cells.append(runner.judge(f"{what} {ratio:g}, {kind}, {scheme}", text,
                                          "first frequency against theory of the continuum", 0.05,
                                          lambda h, f=w: max(abs(frequency_error(f, h)), 0.5 * growth(h))))
    return cells


# --- points and position ----------------------------------------------------------------------------------------------

def points(runner):
    """1 to 25 particles a cell; one particle has no strain at its place that the shortest waves could be seen by."""
    cells = []
    for count in (1, 2, 3, 4, 5):
        for kind in ("lumped", "fmpm 4", "weighted 0.5", "consistent"):
            for scheme in SCHEMES:
                for frame in FRAMES:
                    text = bar(BAR, method_of(kind, scheme, frame, 0.1), 20 * 2 * BAR, points=count)
                    w = time_discrete(bar_frequency(BAR, kind, count), 0.1)
                    cells.append(runner.judge(f"{count**2} a cell, {kind}, {scheme}, {frame}", text,
                                              "first frequency against theory", 0.01,
                                              lambda h, f=w: max(abs(frequency_error(f, h)), 0.1 * growth(h))))
    return cells


SHIFTS = (0.0, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.25 - 1e-12, 0.25, 0.25 + 1e-12, 0.5, 0.75, 0.999, 1 - 1e-12)


def position(runner):
    """A free bar whose halves start apart, anywhere in its cells."""
    cells = []
    for kind in ("lumped", "fmpm 2", "consistent"):
        for scheme in SCHEMES:
            for frame in FRAMES:
                for shift in SHIFTS:
                    w = math.pi / (2 * BAR)
                    text = scene((2 * BAR + 3, 2), 0.0, 20 * 2 * BAR / 2, 0.8,
                                 method_of(kind, scheme, frame, 0.05))
                    text += body((1 + shift, 0), (1 + shift + BAR, 1), (-1e-6, 0)) + held((0, 0), (2 * BAR + 3, 2), "y")
                    text += body((1 + shift + BAR, 0), (1 + shift + 2 * BAR, 1), (1e-6, 0))
                    cells.append(runner.judge(f"offset {shift!r}, {kind}, {scheme}, {frame}", text,
                                              "first frequency against the continuum", 0.06,
                                              lambda h, f=w: max(abs(frequency_error(f, h)), 0.6 * growth(h))))
    return cells


# --- levels -----------------------------------------------------------------------------------------------------------

def levels(runner):
    """The double cantilever beam with cells around the tip that are smaller and smaller, for a few hundred steps."""
    cells, beam = [], (ROOT / "input/dcb.nml").read_text()
    for level in (0, 2, 4, 6, 8, 10, 12, 16, 20):
        end = 300 * 0.1 * 5e-3 / 2**level / 3000
        settings = ["grid.cell=5e-3", "grid.cells=20,3", f"run.end_time={end!r}", f"output.history_interval={end / 10!r}",
                    "output.snapshot_interval=0", "output.file=case.h5", "method.frame=total", "refine.indicator=tip", f"refine.max_level={level}", "damping.rate=0"]

        def audit(h):
            return np.abs(stored(h) + h["numerical_loss"] - h["external_work"]).max() / h["external_work"][-1]

        cells.append(runner.judge(f"level {level}", beam, "closure of the energy balance", 1e-12, audit, settings=[
            *settings, "energy_release.estimators=vcct", "energy_release.energy_balance=.true."]))
    return cells


# --- damping ----------------------------------------------------------------------------------------------------------

def damping(runner):
    """A bar pulled by a step load: none, little, critical, over-critical, and so much that a step overshoots."""
    cells, n, step, force = [], 4, 0.25, 1e-6
    first = math.pi / 2 / n
    exact = force**2 * n / 2
    for kind in ("lumped", "consistent"):
        for scheme in SCHEMES:
            for rate in (0.0, 1e-12, 1e-3, 0.1, first, 2 * first, 10 * first, 0.9 / step, 1 / step, 1.01 / step, 1.9 / step,
                         2.1 / step, 1e3 / step, 1e90):
                slow = 1 / max(rate / 2 if rate < 2 * first else first**2 / rate, 1e-300)
                settles = 1e-3 <= rate <= 2 / step
                end = 40 * slow if settles else 100 / first  # the shortest waves of a lumped matrix lose a quarter as fast
                text = scene((n + 1, 2), 0.0, end, interval_near(end / 1000 if settles else 0.5, step),
                             method_of(kind, scheme, courant=step)) + group("damping", rate=rate)
                text += body((0, 0), (n, 1)) + bar_is_held(n)
                text += group("load", kind="'traction'", lower=f"{n}, 0", upper=f"{n}, 1", force=f"{force}, 0")
                if settles or rate > 1:
                    what, bound, number = "strain energy at rest against the exact one", 1e-3, lambda h: static_error(exact, h)
                else:  # vibrates about rest: the work of the load is twice the strain energy at rest in the mean
                    what, bound = "mean displacement of a vibration against the one at rest", 0.02

                    def number(h):
                        return np.average(h["external_work"], weights=np.hanning(h["time"].size)) / (2 * exact) - 1
                cells.append(runner.judge(f"rate {rate:.4g}, {kind}, {scheme}", text, what, bound, number,
                                          ("refused",) if rate * step > 1 else None))
    return cells


# --- strain and turn --------------------------------------------------------------------------------------------------

def stretched(stretch):
    """First Piola stress and energy of the neo-Hookean law in uniaxial strain, poisson 0, modulus 1: mu = 1/2, lambda = 0."""
    return 0.5 * (stretch - 1 / stretch), 0.25 * (stretch**2 - 1 - 2 * math.log(stretch))


PULLED = 4  # cells


def pulled_bar(law, method, force, points):
    """A bar that is pulled or pressed by a force that rises slowly, until it is at rest."""
    n = PULLED
    text = scene((2 * n, 2), 0.0, 80.0, 0.8, method, law)
    text += body((0, 0), (n, 1)).replace("&body\n", f"&body\n   points_per_cell = {points}\n")
    text += bar_is_held(2 * n - 1) + group("damping", rate=math.pi / n)
    return text + group("load", kind="'traction'", lower=f"{n}, 0", upper=f"{n}, 1", force=f"{force!r}, 0",
                        history="'ramp'", rise_time=40.0)


def strain(runner):
    """A bar pulled or pressed to rest, from strains far below rounding to those that no small-strain law is for."""
    cells = []
    sizes = [10.0**-k for k in (90, 70, 30, 20, 17, 16, 15, 14, 13, 12, 10, 8, 6, 4, 3, 2)] + [0.04, 0.06, 0.1, 0.3, 0.5]
    for law, kind, frame, count in (("linear_elastic", "lumped", "total", 2), ("linear_elastic", "lumped", "updated", 4),
                                    ("neo_hookean", "lumped", "total", 2), ("neo_hookean", "consistent", "total", 2),
                                    ("neo_hookean", "lumped", "updated", 2), ("neo_hookean", "lumped", "updated", 4)):
        for size in [sign * size for size in sizes for sign in (1, -1)]:
            force, energy = size, size**2 / 2
            if law == "neo_hookean" and abs(size) > 1e-4:
                force, energy = stretched(1 + size)
            text = pulled_bar(law, method_of(kind, "musl", frame, 0.2), force, count)
            expected = ("stable",) if abs(size) < 0.03 else ("warned", "stopped") if law == "linear_elastic" and size > 0.05 else None
            # The linear law knows strains to its first order. In the updated frame the cell at the end is partly filled.
            bound = 1e-3
            if law == "linear_elastic" and frame == "updated":
                bound = max(bound, 3 * abs(size))
            elif frame == "updated":
                bound = max(bound, 2 * abs(size) * 2 / count)
            cells.append(runner.judge(f"strain {size:g}, {law}, {kind}, {frame}, {count**2} a cell", text,
                                      "strain energy at rest against the law" + (", updated frame" if frame == "updated" else ""),
                                      bound, lambda h, e=energy * PULLED: static_error(e, h), expected))
    return cells


def pinwheel(law, method, turns, speed):
    """Four squares that move around their common middle, so that the body that they are turns; its time."""
    end = turns * 2 * math.pi / (0.75 * speed)
    text = scene((8, 8), 0.0, end, end / 200, method, law, True)
    for x, y in ((-1, -1), (0, -1), (-1, 0), (0, 0)):
        text += body((4 + 2 * x, 4 + 2 * y), (6 + 2 * x, 6 + 2 * y), (-speed * (2 * y + 1), speed * (2 * x + 1)))
    return text.replace("&output\n", f"&output\n   snapshot_interval = {end / 4 / max(turns, 1)}\n"), end


def turned(path):
    """Angle by which the body has turned, from its snapshots, followed through full turns."""
    with h5py.File(path) as file:
        block = file["VTKHDF"]
        return angle_of(block)


def angle_of(block):
    part = next(item for item in block.values() if "Points" in item)
    count, points = part["NumberOfPoints"][()], part["Points"][()]
    move = part["PointData/displacement"][()]
    angle, first = 0.0, 0
    for n in count:
        x, u = points[first:first + n, :2], move[first:first + n, :2]
        first += n
        a, b = x - u - (x - u).mean(axis=0), x - x.mean(axis=0)
        now = math.atan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
        angle += (now - angle + math.pi) % (2 * math.pi) - math.pi
    return angle


def turn(runner):
    """A body that turns freely. Its angular momentum says how fast, to the order of the square of the strain."""
    cells, speed = [], 0.01
    for law in ("linear_elastic", "neo_hookean"):
        for kind, scheme, frame, c in (("lumped", "musl", "total", 0.3), ("lumped", "usavg", "total", 0.3),
                                       ("consistent", "musl", "total", 0.2), ("lumped", "musl", "updated", 0.1),
                                       ("lumped", "usavg", "updated", 0.1), ("consistent", "usavg", "updated", 0.05)):
            for turns in (0.002, 0.25, 1, 3):
                text, end = pinwheel(law, method_of(kind, scheme, frame, c, box=(0, 0, 8, 8)), turns, speed)

                def number(h, turns=turns):
                    return max(abs(turned(runner.folder / "case.h5") / (2 * math.pi * turns) - 1), growth(h))
                expected = ("warned", "stopped") if law == "linear_elastic" and turns >= 0.25 else None
                cells.append(runner.judge(f"{turns} turns, {law}, {kind}, {scheme}, {frame}", text,
                                          "angle against the one of a rigid body, growth of the energy", 0.15, number, expected))
    return cells


# --- units ------------------------------------------------------------------------------------------------------------

DIMENSIONS = {  # powers of length, time and mass
    "thickness": (1, 0, 0), "end_time": (0, 1, 0), "lower": (1, 0, 0), "upper": (1, 0, 0), "cell": (1, 0, 0),
    "young": (-1, -2, 1), "density": (-3, 0, 1), "velocity": (1, -1, 0), "force": (1, -2, 1), "start": (0, 1, 0),
    "rise_time": (0, 1, 0), "rate": (0, -1, 0), "region_lower": (1, 0, 0), "region_upper": (1, 0, 0), "tip": (1, 0, 0),
    "radii": (1, 0, 0), "history_interval": (0, 1, 0), "snapshot_interval": (0, 1, 0), "length": (1, 0, 0),
    "consistent_lower": (1, 0, 0), "consistent_upper": (1, 0, 0), "times": (0, 1, 0), "points": (1, 0, 0)}
COLUMNS = {"1": (0, 0, 0), "rad": (0, 0, 0), "s": (0, 1, 0), "m": (1, 0, 0), "N": (1, -2, 1), "J": (2, -2, 1),
           "J/m2": (0, -2, 1), "Pa m^0.5": (-0.5, -2, 1), "kg m/s": (1, -1, 1),
           "kg m2/s": (2, -1, 1)}  # by the unit that the result file names
UNITS = [(length, time, mass) for length in (1e-9, 1.0, 1e3) for time in (1e-6, 1.0, 3.15576e7)
         for mass in ((1e-20,) if time < 1 else (1.0,) if time == 1 else (1e20,))]

TIP = {"run": {"thickness": 1.0, "end_time": 300.0, "plane": "'strain'"}, "grid": {"cell": 2.0, "cells": "12, 4"},
       "material": {"name": "'m'", "young": 1.0, "poisson": 0.3, "density": 1.0},
       "body": {"material": "'m'", "lower": (0.0, 0.0), "upper": (20.0, 4.0)},
       "constraint": {"lower": (10.0, 0.0), "upper": (20.0, 0.0), "fix": "'y'"},
       "load": {"kind": "'traction'", "lower": (0.0, 0.0), "upper": (0.0, 4.0), "force": (0.0, 1e-3), "history": "'ramp'",
                "rise_time": 50.0},
       "damping": {"rate": 0.05}, "crack": {"tip": (10.0, 0.0)},
       "refine": {"indicator": "'zz'", "max_level": 6, "interval": 50, "tolerance": 0.2, "start": 60.0},
       "method": {"courant": 0.3}, "energy_release": {
           "estimators": "'vcct', 'domain_integral', 'stress_closure'", "energy_balance": ".true."},
       "output": {"history_interval": 3.0}}
LINE = TIP | {"run": {"thickness": 1.0, "end_time": 50.0, "plane": "'strain'"}, "output": {"history_interval": 1.0},
              "grid": {"lower": (0.0, -4.0), "cell": 1.0, "cells": "22, 9"},
              "body": {"material": "'m'", "lower": (0.0, -4.0), "upper": (20.0, 4.0)},
              "constraint": {"lower": (20.0, -4.0), "upper": (20.0, 4.0), "fix": "'xy'"},
              "crack": {"kind": "'line'", "tip": (10.0, 0.0), "contact": "'frictionless'"},
              "refine": {"indicator": "'tip'", "max_level": 1},
              "method": {"courant": 0.1, "mass": "'consistent'", "scheme": "'usavg'"}}
PATH = LINE | {"crack": {"kind": "'path'", "points": (0.0, 0.3, 7.4, -0.6, 10.2, 1.3), "contact": "'frictionless'"},
               "energy_release": {"estimators": "'domain_integral'", "energy_balance": ".true."}}
BLOW = {"run": {"end_time": 60.0, "thickness": 1.0, "plane": "'stress'"}, "grid": {"cell": 1.0, "cells": "24, 8"},
        "material": {"name": "'m'", "law": "'neo_hookean'", "young": 1.0, "poisson": 0.3, "density": 1.0},
        "body": {"material": "'m'", "lower": (1.0, 2.0), "upper": (5.0, 6.0), "velocity": (0.03, 0.02), "points_per_cell": 4},
        "body ": {"material": "'m'", "lower": (6.3, 2.0), "upper": (10.3, 6.0), "velocity": (-0.01, 0.0), "points_per_cell": 4},
        "method": {"courant": 0.1, "frame": "'updated'"}, "output": {"history_interval": 1.0},
        "energy_release": {"energy_balance": ".true."}}


def in_units(groups, units):
    """A scene, given by its groups, as a namelist in other units."""
    def scaled(key, value):
        values = value if isinstance(value, tuple) else (value,)
        if key in DIMENSIONS:
            factor = math.prod(unit**power for unit, power in zip(units, DIMENSIONS[key]))
            values = [repr(v * factor) for v in values]
        return ", ".join(map(str, values))
    return "".join(group(name.strip(), **{key: scaled(key, value) for key, value in keys.items()})
                   for name, keys in groups.items())


def columns_differ(reference, columns, dimension, units):
    """Largest difference of a column in its scaled unit from the reference, over the largest value of that."""
    worst = 0.0
    for name, values in columns.items():
        factor = math.prod(unit**power for unit, power in zip(units, COLUMNS[dimension[name]]))
        size = np.abs(reference[name]).max()
        if values.size != reference[name].size:
            return math.inf
        if size > 0:
            worst = max(worst, np.abs(values / factor - reference[name]).max() / size)
    return worst


def units(runner):
    """The same scene in other units: the same numbers without dimension."""
    cells = []
    # Faces that touch and part again and again make more of a rounding, as a step decides for all of a spring
    for name, groups, bound in (("refined beam", TIP, 1e-10), ("crack with contact, consistent mass", LINE, 1e-10),
                                ("crack across cells, contact", PATH, 1e-8), ("collision through cells", BLOW, 1e-10)):
        reference = runner.outcome(in_units(groups, (1.0, 1.0, 1.0)))
        if reference.code:
            cells.append(Cell(name, "defect", message=reference.message))
            continue
        for unit in UNITS:
            cells.append(runner.judge(f"{name}, length {unit[0]:g}, time {unit[1]:g}, mass {unit[2]:g}", in_units(groups, unit),
                                      f"largest difference of any column, to {bound:g}", bound,
                                      lambda h, u=unit, r=reference: columns_differ(r.columns, h, r.units, u),
                                      ("stable",)))
    return cells


# --- small ------------------------------------------------------------------------------------------------------------

def flight(cells, size, points, method, at=(0.3, 0.4)):
    """A body of some size that is alone, flies freely, and is pushed by a body force."""
    text = scene(cells, 0.3, 10.0, 0.1, method, "neo_hookean")
    text += body(at, (at[0] + size, at[1] + size), (0.01, 0.0)).replace("&body\n", f"&body\n   points_per_cell = {points}\n")
    return text + group("load", kind="'body'", lower="0, 0", upper=f"{cells[0]}, {cells[1]}", force=f"0.0, {1e-3 * size**2}")


def small(runner):
    """Scenes of next to nothing."""
    result = []
    for kind in KINDS:
        for scheme in SCHEMES:
            for frame in FRAMES:
                method = method_of(kind, scheme, frame, 0.1)
                for name, lattice, size, count, at in (
                        ("one particle in one cell", (1, 1), 0.5, 1, (0.25, 0.25)),
                        ("one particle in a corner", (1, 1), 1e-3, 1, (0.0, 0.0)),
                        ("one particle on a node", (2, 2), 1e-6, 1, (1 - 5e-7, 1 - 5e-7)),
                        ("one particle close to an edge", (3, 3), 1e-9, 1, (1.0, 1.5)),
                        ("one element of four particles", (2, 2), 1.0, 2, (0.0, 0.0)),
                        ("one particle in 300 x 300 cells", (300, 300), 0.5, 1, (150.0, 150.2)),
                        ("one body that fills the lattice", (3, 3), 3.0, 2, (0.0, 0.0))):
                    text = flight(lattice, size, count, method, at)
                    mass = size**2

                    def number(h, mass=mass):  # after 10 with acceleration 1e-3: 1e-4/2 of each direction
                        return h["kinetic_energy"][-1] / (0.5 * mass * (1e-4 + 1e-4)) - 1
                    # A body that leaves the lattice is stopped with that cause
                    result.append(runner.judge(f"{name}, {kind}, {scheme}, {frame}", text, "kinetic energy of a fall", 1e-3, number))
                w = time_discrete(bar_frequency(1, kind), 0.1) if kind != "partial" else None
                if w:
                    result.append(runner.judge(f"one element that vibrates, {kind}, {scheme}, {frame}",
                                               bar(1, method, 80.0, interval=0.1), "frequency against theory", 0.01,
                                               lambda h, f=w: max(abs(frequency_error(f, h)), 0.1 * growth(h))))
    return result


# --- long and release -------------------------------------------------------------------------------------------------

def long(runner):
    """Ten million steps of one element, and of a particle in flight."""
    cells, steps, c = [], 10_000_000, 0.1

    def drift(h):  # of the largest energy: what is written swings within a period
        energy, tenth = stored(h), h["time"].size // 10
        return energy[-tenth:].max() / energy[:tenth].max() - 1

    # Samples at 31 halves of a period and a golden part of one come to every phase of the swing
    interval = math.pi / time_discrete(bar_frequency(1, "lumped"), c) * (31 + (math.sqrt(5) - 1) / 2)
    for scheme, frame in (("musl", "total"), ("usavg", "updated"), ("usf", "updated")):
        text = bar(1, method_of("lumped", scheme, frame, c), steps * c)
        text = re.sub("history_interval = .*", f"history_interval = {interval!r}", text)
        cells.append(runner.judge(f"vibration, {scheme}, {frame}", text, "drift of the energy in 1e7 steps", 1e-4, drift,
                                  ("stable",)))
    text = scene((1002, 1), 0.3, steps * c, steps * c / 1000, method_of(frame="updated", courant=c), "neo_hookean")
    text += body((0.3, 0.2), (1.0, 0.8), (1000 / (steps * c), 0.0))
    cells.append(runner.judge("flight through 1000 cells", text, "change of the energy in 1e7 steps", 1e-9, drift, ("stable",)))
    return cells


def release(runner):
    """A bar that is pulled slowly, held and let go: what was stored is what then vibrates."""
    cells, n, force = [], 4, 1e-6
    period = 4.0 * n
    for kind in KINDS:
        for scheme in SCHEMES:
            for frame in FRAMES:
                method = method_of(kind, scheme, frame, 0.1, box=(0, 0, n / 2, 1))
                text = scene((n + 2, 2), 0.0, 40 * period, 0.4, method, balance=True)
                text += body((0, 0), (n, 1)) + bar_is_held(n)
                text += group("load", kind="'traction'", lower=f"{n}, 0", upper=f"{n}, 1", force=f"{force}, 0",
                              history="'table'", times=f"0, {10 * period}, {12 * period}, {12 * period + 1e-6}",
                              factors="0, 1, 1, 0")

                def number(h):
                    after = h["time"] > 12 * period + 1
                    exact = force**2 * n / 2
                    first = stored(h)[after][:40].mean() / exact - 1
                    return max(abs(first), growth({k: v[after] for k, v in h.items()}))
                cells.append(runner.judge(f"{kind}, {scheme}, {frame}", text, "energy after release against the stored one",
                                          0.1 if scheme == "usl" else 0.05, number))  # usl takes from short waves
    return cells


# --- rest -------------------------------------------------------------------------------------------------------------

REST = {"time": "'static'"}


def rest(runner):
    """Equilibrium: a block for any Poisson's ratio and solver, a bar at any strain, anywhere in its cells, of two materials, and what
    has none: what nothing holds, and a column beyond Euler's load."""
    cells, quantity = [], "strain energy at rest against the exact one, by equilibrium"
    for law in ("linear_elastic", "neo_hookean"):
        for plane in ("stress", "strain"):
            for solver in ("direct", "cg"):
                for nu in (-0.99, 0.0, 0.3, 0.49, 0.4999):
                    text, exact = settled_block(nu, plane, "lumped", REST | {"solver": f"'{solver}'"}, law, strain=1e-9)
                    cells.append(runner.judge(f"poisson {nu}, plane {plane}, {law}, {solver}", text, quantity, 1e-5,
                                              lambda h, e=exact: static_error(e, h), ("stable",)))
    for law in ("linear_elastic", "neo_hookean"):
        for size in [sign * size for size in (1e-90, 1e-20, 1e-12, 1e-6, 1e-3, 0.04, 0.3, 0.5, 2.0) for sign in (1, -1)]:
            if size < -0.9:
                continue
            force, energy = (size, size**2 / 2) if law == "linear_elastic" or abs(size) <= 1e-4 else stretched(1 + size)
            text = pulled_bar(law, method_of() | REST, force, 2)
            expected = ("stable",) if abs(size) < 0.03 or law == "neo_hookean" else ("warned", "stable", "stopped")
            cells.append(runner.judge(f"strain {size:g}, {law}", text, quantity + ", bar", 1e-4,
                                      lambda h, e=energy * PULLED: static_error(e, h), expected))
    for shift in SHIFTS:
        for ratio in (1e-6, 1.0, 1e6):
            text = scene((2 * BAR + 3, 2), 0.0, 1.0, 1.0, method_of() | REST)
            text += group("material", name="'other'", young=ratio, poisson=0.0, density=1.0)
            text += body((1 + shift, 0), (1 + shift + BAR, 1)) + held((0, 0), (2 * BAR + 3, 2), "y")
            text += body((1 + shift + BAR, 0), (1 + shift + 2 * BAR, 1)).replace("'m'", "'other'")
            for place, force in ((1 + shift, -1e-6), (1 + shift + 2 * BAR, 1e-6)):
                text += group("load", kind="'traction'", lower=f"{place!r}, 0", upper=f"{place!r}, 1", force=f"{force}, 0")
            exact = 1e-12 / 2 * BAR * (1 + 1 / ratio)
            # Particles on the wrong side of a cell's edge weigh there with all of their volume; and where the materials meet within a
            # cell, one strain is that of both, and the softer half is stiffer by up to that cell
            bound = 1e-6 if shift < 1e-8 or shift > 1 - 1e-8 else 0.03 if ratio == 1.0 else 0.2
            cells.append(runner.judge(f"offset {shift!r}, stiffness {ratio:g}", text, quantity + ", free bar", bound,
                                      lambda h, e=exact: static_error(e, h)))
    for name, fixed, force in (("x", "y", "1e-6, 0"), ("y", "x", "0, 1e-6"), ("turning", "xy", "0, 1e-6")):
        text = scene((6, 3), 0.0, 1.0, 1.0, method_of() | REST) + body((0, 0), (4, 2))
        text += held((0, 0), (0, 0 if name == "turning" else 2), fixed)
        text += group("load", kind="'traction'", lower="4, 0", upper="4, 2", force=force)
        cells.append(runner.judge(f"nothing holds it against {name}", text, quantity, 1e-9, growth, ("stopped",)))
    for over in (0.5, 2.0, 50.0):
        euler = math.pi**2 * 1.0 * 2**3 / 12 / (4 * 40**2)
        text = scene((42, 5), 0.0, 1.0, 1.0, method_of() | REST, "neo_hookean") + body((0, 1), (40, 3)) + held((0, 1), (0, 3), "xy")
        text += group("load", kind="'traction'", lower="40, 1", upper="40, 3", force=f"{-over * euler}, 0")
        cells.append(runner.judge(f"column under {over} of Euler's load", text, quantity + ", column", 0.02,
                                  lambda h, e=(over * euler)**2 / 2 * 40 / 2: static_error(e, h),
                                  ("stable",) if over < 1 else ("stopped",)))
    return cells


PARTS = {part.__name__: part for part in (courant, poisson, contrast, points, position, levels, damping, strain, turn, units,
                                          small, long, release, rest)}
