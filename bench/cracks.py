"""Stress intensity factors and energy release rates of cracks that ignore the grid, against independent solutions (docs/cracks.md).

    table   slanted, eccentric, edge, kinked and several cracks at rest, two levels of refinement at the tips: the largest error of
            K_I and of K_II over the larger of both, and of G, on three meshes
    places  one crack at random places and angles in a large plate: mean error of G, its scatter and the largest, with the cells
    friction  slanted cracks under pressure, which slide against friction or stick, 32 finest cells to the half-length
    wave    a step of tension meets a slanted crack: rms difference of K_I(t), K_II(t) of both tips, means over a tenth of the window
    shift   a crack that is moved along itself by parts of a cell: G against the straight line, in cells

The solutions are in tests/reference/cracks; each file says where it is from. Run by `make cracks`, or for one part:
.venv/bin/python bench/cracks.py places --number 50
"""

import csv
import math
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
from tables import ROOT, command_line, write

REFERENCE = ROOT / "tests/reference/cracks"
YOUNG, POISSON, THICKNESS = 200e9, 0.3, 1e-3
MODULUS = YOUNG / (1 - POISSON**2)
SIGMA = 1e6
PLATE = (0.02, 0.04)  # half of the width and of the height of the plate of the references [m]
LEVELS = 2

SCENE = """&run plane = 'strain'  thickness = {thickness}  end_time = 1.0 /
&grid lower = {lower}  cell = {cell!r}  cells = {cells} /
&material name = 'a'  young = {young}  poisson = {poisson}  density = 7800 /
&body material = 'a'  lower = {left!r}, {bottom!r}  upper = {right!r}, {top!r} /
&load kind = 'traction'  lower = {left!r}, {top!r}  upper = {right!r}, {top!r}  force = 0.0, {force!r} /
&load kind = 'traction'  lower = {left!r}, {bottom!r}  upper = {right!r}, {bottom!r}  force = 0.0, {down!r} /
&energy_release estimators = 'domain_integral' /
&method time = 'static' /
&refine max_particles = 20000000  indicator = '{indicator}'  max_level = {levels}  rings = {rings} /
{cracks}
"""


def scene(cracks, cell, half=PLATE, levels=LEVELS, rings=8, sigma=SIGMA):
    """The namelist of a plate under tension in y with cracks, each a list of points [m]."""
    width, height = half
    cell = float(cell)
    cells = [2 * math.ceil(round(side / cell, 6)) + 2 for side in half]
    force = sigma * THICKNESS * 2 * width
    lines = "\n".join("&crack kind = 'path'  points = " + ", ".join(f"{float(x)!r}" for point in crack for x in point) + " /"
                      for crack in cracks)
    return SCENE.format(thickness=THICKNESS, young=YOUNG, poisson=POISSON, cell=cell, cells=f"{cells[0]}, {cells[1]}",
                        lower=", ".join(repr(-n * cell / 2) for n in cells), left=-width, right=width, bottom=-height, top=height,
                        force=force, down=-force, indicator="tip" if levels else "none", levels=levels, rings=rings, cracks=lines)


class Program:
    """Runs scenes in a folder."""

    def __init__(self, arguments):
        self.path, self.folder = arguments.program.resolve(), arguments.output.resolve()

    def __call__(self, text):
        """K_I, K_II and G times E' of each tip, in their order."""
        (self.folder / "cracks.nml").write_text(text)
        result = subprocess.run([self.path, "cracks.nml", "--force", "--quiet"], cwd=self.folder, capture_output=True, text=True)
        if result.returncode:
            sys.exit(f"{self.folder / 'cracks.nml'} has ended with {result.returncode}: {result.stderr}")
        with h5py.File(self.folder / "cracks.h5") as file:
            history = {name: column[-1] for name, column in file["history"].items()}
        ends = [""] + [name[3:] for name in history if name.startswith("K_I_tip")]
        return np.array([[history["K_I" + end], history["K_II" + end], history["G" + end] * MODULUS] for end in ends])


def rows(name):
    """The rows of a reference."""
    with open(REFERENCE / name, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def direction(degrees):
    return np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


LARGE = 30  # half of the side of a plate that stands for an infinite one, over the half-length of the crack


def cases():
    """Name, cracks, half of the plate, length that is resolved [m], and what K_I, K_II of each tip in hampm's order are."""
    a = 8e-3
    infinite = (LARGE * a, LARGE * a)
    root = SIGMA * math.sqrt(math.pi * a)
    for row in rows("a1_slanted_infinite.csv"):
        beta = float(row["beta[deg]"])
        if beta in (0, 15, 30, 45, 60):
            k = [root * float(row["K_I/(sigma*sqrt(pi*a))"]), root * float(row["K_II/(sigma*sqrt(pi*a))"])]
            yield f"a1 slanted {beta:g}", [[-a * direction(beta), a * direction(beta)]], infinite, a, [k, k]
    for name, of_kind in (("a2_slanted_centre_plate.csv", "a2 slanted"), ("a2_eccentric_plate.csv", "a2 eccentric"),
                          ("a3_edge_plate.csv", "a3 edge")):
        yield from plates(name, of_kind)
    for row in rows("a4_kinked_infinite.csv"):
        theta, b = float(row["theta[deg]"]), float(row["b/a"]) * a
        if b < 0.5 * a:
            continue
        kink = np.array([a, 0.0])
        k = root * np.array([[float(row["K_I_branch"]), float(row["K_II_branch"])], [float(row["K_I_other"]), float(row["K_II_other"])]])
        yield f"a4 kinked {theta:g}, b/a {row['b/a']}", [[(-a, 0.0), kink, kink + b * direction(theta)]], infinite, b, k
    for row in rows("a5_two_collinear_infinite.csv"):
        ratio = float(row["a/b"])
        if ratio not in (0.2, 0.3, 0.5):
            continue
        inner = 2 * a * ratio / (1 - ratio)
        k_in, k_out = (SIGMA * math.sqrt(math.pi * a) * float(row[f"K_{end}/(sigma*sqrt(pi*c))"]) for end in ("in", "out"))
        yield (f"a5 collinear {ratio:g}", [[(-inner - 2 * a, 0), (-inner, 0)], [(inner, 0), (inner + 2 * a, 0)]], infinite,
               min(a, 2 * inner), [[k_in, 0], [k_out, 0], [k_out, 0], [k_in, 0]])
    for row in rows("a5_two_offset_infinite.csv"):
        dx, dy = float(row["dx/a"]), float(row["dy/a"])
        if dy < 0.5:
            continue
        right = [root * float(row["K_I_right"]), root * float(row["K_II_right"])]
        left = [root * float(row["K_I_left"]), root * float(row["K_II_left"])]
        yield (f"a5 offset {dx:g}, {dy:g}", [[(-a * (1 + dx / 2), -a * dy / 2), (a * (1 - dx / 2), -a * dy / 2)],
                                             [(a * (dx / 2 - 1), a * dy / 2), (a * (dx / 2 + 1), a * dy / 2)]], infinite, a * min(1, dy),
               [right, left, left, right])
    yield from plates("a6_kinked_plate.csv", "a6 kinked")
    yield from plates("a7_two_cracks_plate.csv", "a7 two")


def plates(name, of_kind):
    """The cases of a file of cracks in the plate; tips are in the order of the file, first point first."""
    cases = {}
    for row in rows(name):
        cases.setdefault(row["case"], []).append(row)
    for case, tips in cases.items():
        places = [np.array([float(tip["x_tip[mm]"]), float(tip["y_tip[mm]"])]) * 1e-3 for tip in tips]
        k = [[float(tip["K_I"]), float(tip["K_II"])] for tip in tips]
        if of_kind == "a3 edge":
            start = places[1] if len(places) > 1 else np.array([-PLATE[0], 0.0])
            cracks, resolved = [[start, places[0]]], np.linalg.norm(places[0] - start)
        elif of_kind == "a6 kinked":
            points = [np.array([float(x) for x in point.strip("()").split(";")]) * 1e-3 for point in case.split()]
            cracks = [points]
            resolved = min(np.linalg.norm(points[i] - points[i - 1]) for i in range(1, len(points)))
            k = k[::-1]
        else:
            cracks = [[places[i], places[i + 1]] for i in range(0, len(places), 2)]
            resolved = min(np.linalg.norm(crack[1] - crack[0]) / 2 for crack in cracks)
            k = [k[i + 1 - j] for i in range(0, len(k), 2) for j in (0, 1)]
        yield f"{of_kind} {case}", cracks, PLATE, resolved, k


def errors(found, asked):
    """Largest error of K_I and of K_II over the larger of both, and of G, over the tips."""
    asked = np.array(asked)
    larger = np.max(np.abs(asked), axis=1)
    g = np.sum(asked**2, axis=1)
    return [max(errors, key=abs) for errors in ((found[:, 0] - asked[:, 0]) / larger, (found[:, 1] - asked[:, 1]) / larger,
                                                found[:, 2] / g - 1)]


def table(program, arguments):
    finest = (16, 24, 32)
    out = [("case", *(f"{what} %, {n} cells" for n in finest for what in ("K_I", "K_II", "G")))]
    for name, cracks, half, resolved, asked in list(cases())[arguments.first - 1:]:
        row = [name]
        for n in finest:
            levels = LEVELS if half == PLATE or resolved >= half[0] / LARGE else LEVELS + 1
            found = program(scene(cracks, resolved / n * 2**levels, half, levels))
            row += [f"{100 * error:+.2f}" for error in errors(found, asked)]
        out.append(tuple(row))
        print("  ".join(row), flush=True)
    write(out, "table", arguments.output)


def places(program, arguments):
    """Errors of G of cracks that are at least a little open: G of the crack is that of one in an infinite plate."""
    out = [("finest cells of the half-length", "cracks", "mean of G %", "rms scatter %", "largest deviation %")]
    for levels in (1, 2, 3):
        random = np.random.default_rng(19)
        a, cell, found = 4e-3, 1e-3, []
        for _ in range(arguments.number):
            beta, middle = random.uniform(0, 360), random.uniform(-0.5, 0.5, 2) * cell
            tips = program(scene([[middle - a * direction(beta), middle + a * direction(beta)]], cell, (LARGE * a, LARGE * a), levels))
            exact = SIGMA**2 * math.pi * a * math.cos(math.radians(beta))**2
            if abs(math.cos(math.radians(beta))) > 0.3:
                found += list(100 * (tips[:, 2] / exact - 1))
        found = np.array(found)
        out.append((a / cell * 2**levels, len(found) // 2, f"{found.mean():+.2f}", f"{found.std():.2f}",
                    f"{np.max(np.abs(found - found.mean())):.2f}"))
    write(out, "places", arguments.output)


def shift(program, arguments):
    """One tip is moved along its crack by parts of a cell; G of an infinite plate goes as the length."""
    out = [("levels", "angle", "largest deviation from the line, cells", "monotonous")]
    a, cell, parts = 8e-3, 1e-3, 20
    for levels in (0, 1):
        for beta in (0, 20, 45):
            h = cell / 2**levels
            lengths = np.array([2 * a + h * k / parts for k in range(2 * parts)])
            tip = direction(beta)
            g = np.array([program(scene([[(-a + 0.31e-3) * tip + [0, 0.27e-3], (-a + 0.31e-3 + length) * tip + [0, 0.27e-3]]], cell,
                                        (0.1, 0.1), levels))[0, 2] for length in lengths])
            line = np.polynomial.Polynomial.fit(lengths, g, 1)
            slope = line.deriv()(lengths[0])
            out.append((levels, beta, f"{np.max(np.abs(g - line(lengths))) / slope / h:.3f}", bool(np.all(np.diff(g) > 0))))
    write(out, "shift", arguments.output)


def friction(program, arguments):
    """K_II over that of the solution, and the greatest K_I over K_II; where the crack sticks, K_II over that without friction."""
    out = [("case", "K_II %", "K_I %")]
    a = 8e-3
    cases = [(float(row["beta[deg]"]), float(row["mu"]), SIGMA * math.sqrt(math.pi * a) * float(row["K_II/(sigma*sqrt(pi*a))"]),
              (LARGE * a, LARGE * a)) for row in rows("a8_friction_infinite.csv")]
    cases += [(45.0, float(row["mu"]), float(row["K_II[Pa*sqrt(m)]"]), PLATE) for row in rows("a8_friction_plate.csv")
              if row["case"].startswith("beta=45 2a=16") and row["tip"] == "1"]
    for beta, mu, asked, half in cases[arguments.first - 1:]:
        text = scene([[-a * direction(beta), a * direction(beta)]], a / 32 * 2**LEVELS, half, sigma=-SIGMA)
        contact = f"contact = 'friction'  friction = {mu}" if mu else "contact = 'frictionless'"
        found = program(text.rstrip().removesuffix("/") + contact + " /\n")
        free = SIGMA * math.sqrt(math.pi * a) * math.sin(math.radians(beta)) * math.cos(math.radians(beta))
        scale = abs(asked) if abs(asked) > 0.01 * free else free
        worst = max((tip[1] - asked for tip in found), key=abs)
        out.append((f"{'infinite' if half != PLATE else 'plate'} {beta:g}, mu {mu:g}", f"{100 * worst / scale:+.2f}",
                    f"{100 * np.max(np.abs(found[:, 0])) / scale:.2f}"))
        print("  ".join(out[-1]), flush=True)
    write(out, "friction", arguments.output)


WAVE = """&run plane = 'strain'  thickness = 1e-3  end_time = {end!r} /
&grid lower = -16e-3, -14e-3  cell = {cell!r}  cells = {nx}, {ny} /
&material name = 'a'  young = 1.99992e11  poisson = 0.3  density = 5000.0 /
&body material = 'a'  lower = -16e-3, -14e-3  upper = 16e-3, 12e-3 /
&constraint lower = -16e-3, -14e-3  upper = -16e-3, 12e-3  fix = 'x' /
&constraint lower = 16e-3, -14e-3  upper = 16e-3, 12e-3  fix = 'x' /
&load kind = 'traction'  lower = -16e-3, 12e-3  upper = 16e-3, 12e-3  force = 0.0, 32.0 /
&energy_release estimators = 'domain_integral' /
&method scheme = 'usavg'  mass = '{mass}' /
&output history_interval = 2e-8 /
&crack kind = 'path'  points = {points} /
"""


def wave(program, arguments):
    """The reflections from the edges come after the window, and the sides are held as in a plane wave."""
    table = [row for row in csv.DictReader(line for line in open(REFERENCE / "c4_slanted_crack_step_wave_30deg.csv") if line[0] != "#")]
    half, shift, speed = 5e-3 * direction(30), np.array([7e-5, 3e-5]), 7337.8471
    out = [("mass", "cell", "tip", "K_I %", "K_II %")]
    for mass, cell in (("lumped", 0.25e-3), ("lumped", 0.125e-3), ("blend", 0.25e-3), ("blend", 0.125e-3)):
        start = (12e-3 - half[1] - shift[1]) / speed
        points = ", ".join(repr(float(x)) for x in np.concatenate([shift - half, shift + half]))
        program(WAVE.format(end=start + 2.4e-6, cell=cell, nx=round(32e-3 / cell), ny=round(26e-3 / cell), mass=mass, points=points))
        with h5py.File(program.folder / "cracks.h5") as file:
            history = {name: column[:] for name, column in file["history"].items()}
        times = history["time"] - start
        for tip, end in (("upper", ""), ("lower", "_tip2")):
            asked = np.array([[float(row[name]) for name in ("t[s]", "K_I[Pa*sqrt(m)]", "K_II[Pa*sqrt(m)]")] for row in table
                              if row["tip"] == tip])
            begin, last = ([float(row[name]) for row in table if row["tip"] == tip][0] for name in ("t0[s]", "t_end[s]"))
            window = 0.1 * (last - begin)
            asked = asked[(asked[:, 0] > begin + window) & (asked[:, 0] < last - window / 2)]
            peak = np.max(np.abs(asked[:, 1:]))
            of_mode = []
            for mode in (1, 2):
                means = [np.mean(history["K_" + mode * "I" + end][np.abs(times - t) <= window / 2]) for t in asked[:, 0]]
                of_mode.append(f"{100 * np.sqrt(np.mean((np.array(means) - asked[:, mode])**2)) / peak:.2f}")
            out.append((mass, f"{cell:g}", tip, *of_mode))
    write(out, "wave", arguments.output)


PARTS = {"table": table, "places": places, "friction": friction, "wave": wave, "shift": shift}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/cracks", number=(200, "cracks of `places`"), first=(1, "case with which `table` and `friction` begin"))
    program = Program(arguments)
    for part in arguments.part:
        PARTS[part](program, arguments)


if __name__ == "__main__":
    main()
