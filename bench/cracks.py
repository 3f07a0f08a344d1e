"""Stress intensity factors and energy release rates of cracks that ignore the grid, against independent solutions (docs/evidence/crack_accuracy.md).

    table   slanted, eccentric, edge, kinked and several cracks at rest, two levels of refinement at the tips: the largest error of
            K_I and of K_II over the larger of both, and of G, on three meshes; the order at which K converges
    quadratic  the plates by quadratic cells, graded around the tips: K of all tips over its size, median and largest error, processor time
    places  one crack at random places and angles, in any mode, in an infinite plate: error of G, mean, scatter and the largest,
            without refinement and with one and two levels around the tips
    friction  slanted cracks under pressure, which slide against friction or stick, 32 finest cells to the half-length
    slip    pressed cracks that slide, at random places, angles and friction, 8 to 64 finest cells to the half-length: K_II, J, how often estimates
            cover their errors, and the order
    wave    a step of tension meets a slanted crack: rms difference of K_I(t), K_II(t) of both tips, means over a tenth of the window
    shift   a crack that is moved along itself by parts of a cell: G against the straight line, in cells
    pieces  how often small pieces of cells spoil a run at rest: edge cracks at random under pressure, and rings under inner pressure whose cells
            refine. Bad is an exit code other than 0, an energy of a ring that is off Lame's by more than 2 %, and a crack that opens at its mouth, or
            stores, not 0.5 to 1.5 times as much as in cells of half the size

The solutions are in tests/reference/cracks; each file says where it is from. Run by `make -C bench cracks`, or for one part:
.venv/bin/python bench/cracks.py places --number 50
"""

import math
import random
import sys

import numpy as np
import program_runs
from tables import ROOT, command_line, reference, write

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
{loads}
&energy_release estimators = 'domain_integral' /
&method time = 'static' /
&refine max_particles = 20000000  indicator = '{indicator}'  max_level = {levels}  rings = {rings} /
{cracks}
"""


def traction(lower, upper, stress):
    """A load on part of an edge, by the mean of its traction [Pa]."""
    force = np.multiply(stress, THICKNESS * math.dist(lower, upper))
    return "&load kind = 'traction'  lower = {}, {}  upper = {}, {}  force = {}, {} /".format(
        *(repr(float(x)) for x in (*lower, *upper, *force)))


def tension(half, sigma):
    """Tension in y on the edges of a plate."""
    return [traction((-half[0], y), (half[0], y), (0.0, math.copysign(1.0, y) * sigma)) for y in (half[1], -half[1])]


def scene(cracks, cell, half=PLATE, levels=LEVELS, rings=8, sigma=SIGMA, loads=None):
    """The namelist of a plate with cracks, each a list of points [m]; under tension in y where no loads are given."""
    width, height = half
    cell = float(cell)
    cells = [2 * math.ceil(round(side / cell, 6)) + 2 for side in half]
    lines = "\n".join("&crack kind = 'path'  points = " + ", ".join(f"{float(x)!r}" for point in crack for x in point) + " /"
                      for crack in cracks)
    return SCENE.format(thickness=THICKNESS, young=YOUNG, poisson=POISSON, cell=cell, cells=f"{cells[0]}, {cells[1]}",
                        lower=", ".join(repr(-n * cell / 2) for n in cells), left=-width, right=width, bottom=-height, top=height,
                        loads="\n".join(loads or tension(half, sigma)), indicator="tip" if levels else "none", levels=levels, rings=rings, cracks=lines)


class Program(program_runs.Program):
    """Runs scenes in a folder."""

    def __call__(self, text, *settings):
        """K_I, K_II and G times E' of each tip, in their order; `j` is J times E' of each, `errors` has the estimated errors of K_II and of that."""
        done = super().__call__(text, settings)
        self.seconds, self.columns, last = done.seconds, done.columns, done.last
        ends = [""] + [name[3:] for name in last if name.startswith("K_I_tip")]
        self.j = np.array([last["J" + end] * MODULUS for end in ends])
        self.errors = np.array([[last["K_II_error" + end], last["J_error" + end] * MODULUS] for end in ends])
        return np.array([[last["K_I" + end], last["K_II" + end], last["G" + end] * MODULUS] for end in ends])


def rows(name):
    return reference(REFERENCE / name)


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


def errors_of_k(found, asked):
    """Errors of K_I and K_II of each tip over the larger of both."""
    return (found[:, :2] - asked) / np.max(np.abs(asked), axis=1)[:, None]


def case_scene(case, cells):
    """The namelist of one of `cases`, with so many of the finest cells to the length that is resolved."""
    _, cracks, half, resolved, _ = case
    levels = LEVELS if half == PLATE or resolved >= half[0] / LARGE else LEVELS + 1
    return scene(cracks, resolved / cells * 2**levels, half, levels)


def order(cells, errors):
    """The slope of a straight line through log error over log cells, downwards."""
    return -np.polyfit(np.log(cells), np.log(np.maximum(errors, 1e-300)), 1)[0]


def table(program, arguments):
    """The error whose order is taken is the root of the mean square of those of K_I and K_II over the tips; a change of its sign is
    that of the tip and mode which is most off on the coarsest mesh. One crack has hardly an order of its own, as it matters where its
    tips lie in their cells. The last row has the root of the mean square over the cases."""
    finest = (16, 24, 32)
    head = [f"{what} %, {n} cells" for n in finest for what in ("K_I", "K_II", "G")]
    out = [("case", *head, "order of K", "sign")]
    of_all = []
    for case in list(cases())[arguments.first - 1:]:
        row, of_case, asked = [case[0]], [], case[4]
        for n in finest:
            found = program(case_scene(case, n))
            row += [f"{100 * error:+.2f}" for error in errors(found, asked)]
            of_case.append(errors_of_k(found, asked))
        squares = [np.mean(each**2) for each in of_case]
        worst = np.unravel_index(np.argmax(np.abs(of_case[0])), of_case[0].shape)
        same = len({math.copysign(1, each[worst]) for each in of_case}) == 1
        row += [f"{order(finest, np.sqrt(squares)):.1f}", "same" if same else "changes"]
        of_all.append(squares)
        out.append(tuple(row))
        print("  ".join(row), flush=True)
    means = np.sqrt(np.mean(of_all, axis=0))
    of_means = [cell for mean in means for cell in (f"{100 * mean:.2f}", "", "")]
    out.append(("all: rms of K_I and K_II", *of_means, f"{order(finest, means):.1f}", ""))
    write(out, "table", arguments.output)


def quadratic(program, arguments):
    """Cells are those of the body, which they fill."""
    plates = [case for case in cases() if case[0][:2] in ("a2", "a3", "a6", "a7")]
    out = [("cell", "levels", "rings", "tips", "median %", "largest %", "of", "s")]
    for cell, levels, rings in ((4e-3, 3, 1), (2e-3, 3, 1), (2e-3, 4, 1), (1e-3, 5, 1)):
        found, spent = [], []
        for name, cracks, half, _, asked in plates:
            if all(abs(side / cell - round(side / cell)) < 1e-9 for side in half):
                k = program(scene(cracks, cell, half=half, levels=levels, rings=rings), "grid.order=2", "body.points_per_cell=3")[:, :2]
                found += [(np.linalg.norm(k_tip - np.array(tip)) / np.linalg.norm(tip), name) for k_tip, tip in zip(k, asked) if tip is not None]
                spent.append(program.seconds)
        largest = max(found)
        out.append((f"{1e3 * cell:g} mm", levels, rings, len(found), f"{100 * np.median([each[0] for each in found]):.3f}", f"{100 * largest[0]:.2f}",
                    largest[1], f"{np.median(spent):.2f}"))
        print(*out[-1], sep="  ", flush=True)
    write(out, "quadratic", arguments.output)


def infinite_plate(z, a, stress, shear, taken):
    """Stress xx, yy, xy around a crack from -a to a on the x axis of an infinite plate, at z = x + iy, under tension across the crack
    and shear along it, far away; `taken` is what of them, tension + i shear, the faces do not pass on to each other: all where the crack
    is open. Muskhelishvili: yy - i xy = F(z) + F(conj z) + (z - conj z) conj F'(z), xx + yy = 4 Re F, and what is uniform."""
    def potential(z):
        return np.conj(taken) / 2 * (z / (np.sqrt(z - a) * np.sqrt(z + a)) - 1)

    slope = -np.conj(taken) / 2 * a**2 / (np.sqrt(z - a) * np.sqrt(z + a))**3
    across = potential(z) + potential(np.conj(z)) + (z - np.conj(z)) * np.conj(slope) + stress - 1j * shear
    return np.array([4 * potential(z).real + stress - across.real, across.real, -across.imag])


def cut_out(half, pieces, a, middle, beta, stress, shear, taken=None):
    """Loads on the edges of a square around a slanted crack, by which it is part of an infinite plate: means over pieces of an edge."""
    turn = np.exp(1j * math.radians(beta))
    if taken is None:
        taken = stress + 1j * shear
    points, weights = np.polynomial.legendre.leggauss(8)
    loads = []
    for normal in (1, 1j, -1, -1j):
        ends = half * np.linspace(-1, 1, pieces + 1)
        for first, last in zip(ends, ends[1:]):
            z = normal * (half + 1j * ((first + last) / 2 + points * (last - first) / 2))
            xx, yy, xy = infinite_plate((z - complex(*middle)) / turn, a, stress, shear, taken)
            out = normal / turn
            force = turn * np.sum(weights / 2 * (xx * out.real + xy * out.imag + 1j * (xy * out.real + yy * out.imag)))
            ends_of_piece = sorted((w.real, w.imag) for w in (normal * (half + 1j * first), normal * (half + 1j * last)))
            loads.append(traction(*ends_of_piece, (force.real, force.imag)))
    # Means over pieces leave a little of a moment
    return loads + [f"&constraint lower = {x!r}, {-half!r}  upper = {x!r}, {-half!r}  fix = '{fix}' /"
                    for x, fix in ((-half, "xy"), (half, "y"))]


CUT_OUT = 10  # half of the side of the square that is cut out of an infinite plate, over the half-length of the crack


def places(program, arguments):
    """Errors of G. Tension across the crack and shear along it are turned with it, so that G is the same at all angles, and both modes
    come in all mixtures in which the crack is open."""
    dice = np.random.default_rng(19)
    a, cell = 4e-3, 0.5e-3
    half, found, failed = CUT_OUT * a, {0: [], 1: [], 2: []}, dict.fromkeys((0, 1, 2), 0)
    every = [("crack", "levels", "angle", "mixity", "x", "y", "K_I %", "K_II %", "G %", "K_I %, second tip", "K_II %", "G %")]
    asked = SIGMA * math.sqrt(math.pi * a)
    for crack in range(1, arguments.number + 1):
        beta, mixity, middle = dice.uniform(0, 360), dice.uniform(-75, 75), dice.uniform(-0.5, 0.5, 2) * cell
        modes = direction(mixity)
        loads = cut_out(half, 2 * CUT_OUT, a, middle, beta, *(SIGMA * modes))
        for levels, errors in found.items():
            try:
                tips = program(scene([[middle - a * direction(beta), middle + a * direction(beta)]], cell, (half, half), levels,
                                     loads=loads))
            except SystemExit as end:
                print(end, flush=True)
                failed[levels] += 1
                continue
            each = 100 * np.column_stack([tips[:, :2] / asked - modes, tips[:, 2] / asked**2 - 1])
            errors += list(each[:, 2])
            every.append((crack, levels, f"{beta:.3f}", f"{mixity:.3f}", *(f"{x:.4e}" for x in middle),
                          *(f"{x:+.3f}" for x in each.ravel())))
        print("  ".join(map(str, every[-1])), flush=True)
    out = [("levels", "finest cells of the half-length", "cracks", "failed", "mean of G %", "rms scatter %", "largest error %",
            "beyond 4 %")]
    for levels, errors in found.items():
        errors = np.array(errors)
        out.append((levels, round(a / cell * 2**levels), arguments.number, failed[levels], f"{errors.mean():+.2f}", f"{errors.std():.2f}",
                    f"{np.max(np.abs(errors)):.2f}", int(np.sum(np.abs(errors) > 4))))
    write(every, "places_each", arguments.output)
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


def pressed_cases():
    """Name, namelist, and K_II and K_II without friction, of slanted cracks that are pressed."""
    a = 8e-3
    root = SIGMA * math.sqrt(math.pi * a)
    cases = [("infinite", float(row["beta[deg]"]), float(row["mu"]), root * float(row["K_II/(sigma*sqrt(pi*a))"]))
             for row in rows("a8_friction_infinite.csv")]
    cases += [("plate", 45.0, float(row["mu"]), float(row["K_II[Pa*sqrt(m)]"])) for row in rows("a8_friction_plate.csv")
              if row["case"].startswith("beta=45 2a=16") and row["tip"] == "1"]
    for where, beta, mu, asked in cases:
        half, loads = PLATE, None
        cosine, sine = direction(beta)
        if where == "infinite":
            half = (CUT_OUT * a, CUT_OUT * a)
            loads = cut_out(half[0], 2 * CUT_OUT, a, (0.0, 0.0), beta, -SIGMA * cosine**2, -SIGMA * sine * cosine,
                            1j * SIGMA * asked / root)
        text = scene([[-a * direction(beta), a * direction(beta)]], a / 32 * 2**LEVELS, half, sigma=-SIGMA, loads=loads)
        contact = f"contact = 'friction'  friction = {mu}" if mu else "contact = 'frictionless'"
        yield f"{where} {beta:g}, mu {mu:g}", text.rstrip().removesuffix("/") + contact + " /\n", asked, root * sine * cosine


def friction(program, arguments):
    """K_I, which is 0, the error of K_II, over K_II without friction in an infinite plate, and that of J over J there."""
    out = [("case", "K_II %", "K_I %", "J %")]
    for name, text, asked, free in list(pressed_cases())[arguments.first - 1:]:
        found = program(text)
        worst = max((tip[1] - asked for tip in found), key=abs)
        out.append((name, f"{100 * worst / free:+.2f}", f"{100 * np.max(np.abs(found[:, 0])) / free:.2f}",
                    f"{100 * max(program.j - asked**2, key=abs) / free**2:+.2f}"))
        print("  ".join(out[-1]), flush=True)
    write(out, "friction", arguments.output)


def slip(program, arguments):
    """Errors of K_II over K_II without friction, and of J over J without friction. Plates are infinite, as in `places`."""
    dice = np.random.default_rng(1000)
    a, finest = 8e-3, (8, 16, 32, 64)
    root = SIGMA * math.sqrt(math.pi * a)
    found = {cells: [] for cells in finest}
    for _ in range(arguments.number):
        beta, mu, middle = dice.choice([-1, 1]) * dice.uniform(30, 60), dice.uniform(0, 0.6), dice.uniform(-1e-3, 1e-3, 2)
        cosine, sine = direction(beta)
        mu = min(mu, 0.9 * abs(sine) / cosine)
        free, asked = root * abs(sine) * cosine, -math.copysign(root * cosine * (abs(sine) - mu * cosine), sine)
        loads = cut_out(CUT_OUT * a, 2 * CUT_OUT, a, middle, beta, -SIGMA * cosine**2, -SIGMA * sine * cosine, 1j * SIGMA * asked / root)
        for cells in finest:
            text = scene([[middle - a * direction(beta), middle + a * direction(beta)]], a / cells * 2**LEVELS, (CUT_OUT * a, CUT_OUT * a), loads=loads)
            tips = program(text.rstrip().removesuffix("/") + f"contact = 'friction'  friction = {mu} /\n")
            found[cells] += list(np.column_stack([(tips[:, 1] - asked) / free, program.errors[:, 0] / free, (program.j - asked**2) / free**2,
                                                  program.errors[:, 1] / free**2, tips[:, 0] / free]))
        print(f"{beta:+.1f} {mu:.2f} ", "  ".join(f"{100 * error[0]:+.2f}" for cells in finest for error in found[cells][-2:]), flush=True)
    out = [("cells of the half-length", "K_II %: rms", "largest", "covered %", "J %: rms", "largest", "covered %", "tips with K_I")]
    for cells, errors in found.items():
        errors = np.array(errors).T
        of_both = [(f"{100 * np.sqrt(np.mean(each**2)):.2f}", f"{100 * np.max(np.abs(each)):.2f}", f"{100 * np.mean(np.abs(each) <= estimated):.0f}")
                   for each, estimated in (errors[:2], errors[2:4])]
        out.append((cells, *of_both[0], *of_both[1], int(np.sum(errors[4] != 0))))
    out.append(("order", *(f"{order(finest, [float(row[k]) for row in out[1:]]):.1f}" if k in (1, 4) else "" for k in range(1, 8))))
    write(out, "slip", arguments.output)


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


WAVE_HALF, WAVE_SHIFT = 5e-3 * direction(30), np.array([7e-5, 3e-5])  # of the crack: half of it, and its middle [m]
WAVE_START = float((12e-3 - WAVE_HALF[1] - WAVE_SHIFT[1]) / 7337.8471)  # when the wave is at the upper tip [s]


def wave_scene(cell, mass):
    """The namelist of the plate that a step of tension goes through."""
    points = ", ".join(repr(float(x)) for x in np.concatenate([WAVE_SHIFT - WAVE_HALF, WAVE_SHIFT + WAVE_HALF]))
    return WAVE.format(end=WAVE_START + 2.4e-6, cell=cell, nx=round(32e-3 / cell), ny=round(26e-3 / cell), mass=mass, points=points)


def wave_errors(history):
    """Of the upper and the lower tip: rms of K_I and K_II over the peak, of means over a tenth of the window in which the reference is exact."""
    table = rows("c4_slanted_crack_step_wave_30deg.csv")
    times, errors_of = history["time"] - WAVE_START, {}
    for tip, end in (("upper", ""), ("lower", "_tip2")):
        asked = np.array([[float(row[name]) for name in ("t[s]", "K_I[Pa*sqrt(m)]", "K_II[Pa*sqrt(m)]")] for row in table
                          if row["tip"] == tip])
        begin, last = ([float(row[name]) for row in table if row["tip"] == tip][0] for name in ("t0[s]", "t_end[s]"))
        window = 0.1 * (last - begin)
        asked = asked[(asked[:, 0] > begin + window) & (asked[:, 0] < last - window / 2)]
        peak = np.max(np.abs(asked[:, 1:]))
        errors_of[tip] = []
        for mode in (1, 2):
            means = [np.mean(history["K_" + mode * "I" + end][np.abs(times - t) <= window / 2]) for t in asked[:, 0]]
            errors_of[tip].append(np.sqrt(np.mean((np.array(means) - asked[:, mode])**2)) / peak)
    return errors_of


def wave(program, arguments):
    """The reflections from the edges come after the window, and the sides are held as in a plane wave."""
    out = [("mass", "cell", "tip", "K_I %", "K_II %")]
    for mass, cell in (("lumped", 0.25e-3), ("lumped", 0.125e-3), ("weighted", 0.25e-3), ("weighted", 0.125e-3)):
        program(wave_scene(cell, mass))
        found = wave_errors(program.columns)
        out += [(mass, f"{cell:g}", tip, *(f"{100 * error:.2f}" for error in found[tip])) for tip in found]
    write(out, "wave", arguments.output)


def pieces(program, arguments):
    sys.path.insert(0, str(ROOT / "tests/cases"))
    from test_cut_cells import edge_crack, lame_energy
    ring = (ROOT / "tests/cases/pressed_ring_refined_a.nml").read_text().replace("-5e-3, -5e-3  upper = 5e-3, 5e-3", "-6.2e-3, -6.2e-3  upper = 6.2e-3, 6.2e-3")
    plain, at_random = program_runs.Program(program.path, program.folder), random.Random(1)

    def last(text):
        """The last values of the history; None where the run has failed."""
        done = plain(text, codes=range(256))
        return None if done.code else done.last

    def crack_is_bad(text):
        coarse, fine = last(text), last(text.replace("cell = 1e-3  cells = 12, 12", "cell = 0.5e-3  cells = 24, 24"))
        return coarse is None or fine is None or any(not 0.5 * fine[name] < coarse[name] < 1.5 * fine[name] for name in ("mouth_opening", "strain_energy"))

    def ring_is_bad(tenths, levels):
        row = last(ring.replace("4.6e-3", repr(tenths * 1e-4)).replace("max_level = 1", f"max_level = {levels}"))
        return row is None or abs(row["strain_energy"] / lame_energy(tenths * 1e-4, 9e-3) - 1) > 0.02
    out = [("runs", "of", "bad"), ("edge cracks", arguments.number, sum(crack_is_bad(edge_crack(at_random)) for _ in range(arguments.number)))]
    out += [(f"rings, {levels} levels", 21, sum(ring_is_bad(tenths, levels) for tenths in range(40, 61))) for levels in (1, 2, 3)]
    write(out, "pieces", arguments.output)


PARTS = {"table": table, "quadratic": quadratic, "places": places, "friction": friction, "slip": slip, "wave": wave, "shift": shift, "pieces": pieces}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/cracks", number=(200, "cracks of `places`, `slip` and `pieces`"), first=(1, "case with which `table` and `friction` begin"))
    program = Program(arguments.program, arguments.output)
    for part in arguments.part:
        PARTS[part](program, arguments)


if __name__ == "__main__":
    main()
