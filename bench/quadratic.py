"""What quadratic cells give and cost (docs/explanation/quadratic.md).

    beam       static G of the double cantilever beam, quadratic and bilinear cells: uniform, or graded towards the tip
    levels     the same against the number of levels around the tip, up to 20
    reference  the value that graded meshes of quadratic cells tend to, by J and by the nodal closure, from two sequences of meshes
    tension    a crack in the middle of a plate in tension, where nothing bends: the same comparison
    dispersion waves along a bar of such cells for each mass matrix, and the largest stable time step of a block: from matrices, without a run
    paths      cracks that cut cells, in a plate of 40 by 80 mm: K of slanted, edge, kinked and two cracks against integral equations
    wave       K(t) of a slanted crack that cuts cells and that a step of tension meets, against the closed form
    motion     G(t) of the undamped beam below 50 kHz in 0.6 ms against converged finite elements: implicit steps

Run by `make -C bench quadratic`; a part alone: .venv/bin/python bench/quadratic.py beam
"""

import sys

import numpy as np
from cracks import cases, scene, wave_errors, wave_scene
from mass_theory import Block, functions, weights
from program_runs import Program
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))

from history import lowpass, read_curve  # noqa: E402

BEAM = ROOT / "input/dcb.nml"
PLATE = ROOT / "tests/regression/centre_crack/case.nml"
CONVERGED = 1.28737  # G/G_ref at rest, tests/reference/dcb_static.csv
ORDERS = {"quadratic": ["grid.order=2", "body.points_per_cell=3"], "bilinear": ["body.points_per_cell=2"]}
STATIC = ["method.time=static", "method.frame=total", "damping.rate=0", "output.snapshot_interval=0", "output.history_interval=0",
          "energy_release.estimators=vcct,domain_integral", "energy_release.energy_balance=.false."]
TURNS = 5


class Runs(Program):
    """Runs models: columns of the history, what G is divided by, and the median processor time [s]."""

    def __call__(self, case, settings, turns=1):
        done = super().__call__(case, settings, turns=turns)
        return done.columns, done.attributes.get("G_ref"), done.seconds


def around_tip(levels, rings):
    """Settings of a mesh that is graded towards the tip."""
    return ["refine.indicator=tip", f"refine.rings={rings}", f"refine.max_level={levels}"] if levels else ["refine.indicator=none"]


def beam_cells(n):
    """n cells over the depth of an arm."""
    return [f"grid.cell={0.01 / n}", f"grid.cells={10 * n},{n + 1}"]


def beam(runs):
    rows = [("cells", "n", "levels", "rings", "particles", "CPU [s]", "nodal closure [%]", "J [%]")]
    meshes = {"quadratic": [(2, 0, 0), (4, 0, 0), (8, 0, 0), (16, 0, 0), (2, 6, 1), (2, 6, 2), (3, 6, 2), (4, 6, 2), (4, 8, 4)],
              "bilinear": [(4, 0, 0), (8, 0, 0), (16, 0, 0), (32, 0, 0), (8, 4, 4), (16, 4, 4), (24, 4, 4), (32, 4, 4), (48, 4, 4)]}
    for order, cases in meshes.items():
        for n, levels, rings in cases:
            radii = [] if n > 2 or levels else ["energy_release.estimators=vcct", "energy_release.energy_balance=.false."]
            h, unit, seconds = runs(BEAM, [*STATIC, *radii, *ORDERS[order], *beam_cells(n), *around_tip(levels, rings)], TURNS)
            errors = [f"{100 * (h[name][-1] / unit / CONVERGED - 1):+.3f}" if name in h else "" for name in ("G_vcct_I", "J")]
            rows.append((order, n, levels, rings, int(h["particles"][-1]), f"{seconds:.3f}", *errors))
    write(rows, "beam", runs.folder)


def levels(runs):
    rows = [("n", "levels", "particles", "G/G_ref, nodal closure", "J/G_ref", "change of J by two levels")]
    for n in (2, 4, 8):
        last = None
        for level in range(0, 21, 2):
            if n == 2 and level == 0:
                continue
            h, unit, _ = runs(BEAM, [*STATIC, *ORDERS["quadratic"], *beam_cells(n), *around_tip(level, n)])
            j = h["J"][-1] / unit
            rows.append((n, level, int(h["particles"][-1]), f"{h['G_vcct_I'][-1] / unit:.7f}", f"{j:.7f}",
                         f"{j - last:.1e}" if last else ""))
            last = j
    write(rows, "levels", runs.folder)


def reference(runs):
    """Meshes n = 4, 8, 16 with 20 levels of n rings: what is left is the error of the smooth part, of fourth order."""
    rows = [("points", "n", "particles", "G/G_ref, nodal closure", "J/G_ref", "J extrapolated in fourth order")]
    for points in (3, 4):
        last = None
        for n in (4, 8, 16):
            h, unit, _ = runs(BEAM, [*STATIC, "grid.order=2", f"body.points_per_cell={points}", *beam_cells(n), *around_tip(20, n)])
            j = h["J"][-1] / unit
            rows.append((points, n, int(h["particles"][-1]), f"{h['G_vcct_I'][-1] / unit:.7f}", f"{j:.7f}",
                         f"{j + (j - last) / 15:.7f}" if last else ""))
            last = j
    write(rows, "reference", runs.folder)


def tension(runs):
    """Against the finest mesh: Tada's K is known to 0.1 % only."""
    def settings(order, cell, level, rings):
        cells = [f"grid.cell={cell}e-3", f"grid.cells={round(44 / cell)},{round(84 / cell)}"]
        return [*STATIC, *ORDERS[order], *cells, *around_tip(level, rings), "energy_release.radii=4e-3,5e-3,6e-3"]

    finest = runs(PLATE, settings("quadratic", 0.5, 12, 16))[0]["J"][-1]
    rows = [("cells", "cell [mm]", "levels", "rings", "particles", "CPU [s]", "nodal closure [%]", "J [%]")]
    meshes = {"quadratic": [(2, 0, 0), (1, 0, 0), (0.5, 0, 0), (2, 4, 1), (2, 6, 1), (2, 6, 2), (2, 8, 2), (1, 8, 4)],
              "bilinear": [(2, 0, 0), (1, 0, 0), (0.5, 0, 0), (0.25, 0, 0), (2, 4, 2), (2, 6, 2), (2, 6, 4), (1, 6, 4), (1, 6, 8),
                           (0.5, 6, 8)]}
    for order, cases in meshes.items():
        for cell, level, rings in cases:
            h, _, seconds = runs(PLATE, settings(order, cell, level, rings), TURNS)
            rows.append((order, cell, level, rings, int(h["particles"][-1]), f"{seconds:.3f}",
                         *[f"{100 * (h[name][-1] / finest - 1):+.3f}" for name in ("G_vcct_I", "J")]))
    write(rows, "tension", runs.folder)


def frequency(q, lumped_fraction, points, maps=True):
    """omega h/c of the slowest wave that grows by exp(i q) from cell to cell: of material points, which map to the nodes and back, or of
    elements."""
    mass, stiffness = np.zeros((3, 3)), np.zeros((3, 3))
    for weight, a in zip(weights(2, points), (np.arange(points) + 0.5) / points, strict=True):
        shape, slope = functions(2, a)
        mass += weight * np.outer(shape, shape)
        stiffness += weight * np.outer(slope, slope)
    last = np.array([[1, 0], [0, 1], [np.exp(1j * q), 0]])  # the last node of a cell is the first of the next
    m, k, b = (last.conj().T @ x @ last for x in (mass, stiffness, (1 - lumped_fraction) * mass + lumped_fraction * np.diag(mass.sum(axis=1))))
    inverse = np.linalg.inv(b)
    return np.sqrt(np.linalg.eigvals(inverse @ m @ inverse @ k if maps else inverse @ k).real.min())


def dispersion(runs):
    rows = [("points", "mass", "4 cells a wave", "8", "16", "order", "error/q^4", "elements: error/q^4", "limit of musl", "of usl")]
    for points in (3, 4):
        block = Block(5, 4, 0.3, held_left=False, order=2, points=points)
        for name, lumped_fraction in (("lumped", 1.0), ("weighted 0.5", 0.5), ("weighted 5/18", 5 / 18), ("weighted 0.25", 0.25), ("consistent", 0.0)):
            waves = 2 * np.pi / np.array([4, 8, 16])
            error = [frequency(q, lumped_fraction, points) / q - 1 for q in waves]
            elements = frequency(waves[-1], lumped_fraction, points, maps=False) / waves[-1] - 1
            kind = name.split()[0]
            limits = [block.limit(scheme, block.inverse(kind, lumped_fraction=lumped_fraction)) for scheme in ("musl", "usl")]
            rows.append((points, name, *[f"{e:.1e}" for e in error], f"{np.log2(abs(error[1] / error[2])):.1f}",
                         *[f"{e / waves[-1] ** 4:.1e}" for e in (error[-1], elements)], *[f"{limit:.3f}" for limit in limits]))
    write(rows, "dispersion", runs.folder)


def paths(runs):
    names = "a2 slanted beta=15", "a2 slanted beta=30", "a2 slanted beta=45", "a3 edge beta=30", "a6", "a7"
    rows = [("cells", "cell [mm]", "levels", "particles", "CPU [s]", "K [%], rms", "G [%], rms", "G [%], largest")]
    for order, meshes in {"quadratic": [(4, 1), (4, 2), (4, 3), (4, 4), (4, 5), (2, 1), (2, 2), (2, 3), (2, 4)],
                          "bilinear": [(2, 2), (2, 3), (2, 4), (1, 1), (1, 2), (1, 3), (1, 4), (0.5, 1), (0.5, 2), (0.5, 3)]}.items():
        for cell, levels in meshes:
            of_k, of_g, particles, cost = [], [], [], []
            for name, cracks, half, _, asked in cases():
                if not name.startswith(names):
                    continue
                h, _, seconds = runs(scene(cracks, cell * 1e-3, half, levels), [*ORDERS[order], "method.frame=total"])
                ends = [""] + [column[3:] for column in h if column.startswith("K_I_tip")]
                k = np.array([[h["K_I" + end][-1], h["K_II" + end][-1]] for end in ends])
                asked = np.array(asked)
                of_k += list(((k - asked) / np.max(np.abs(asked))).ravel())
                of_g += list(np.sum(k**2, axis=1) / np.sum(asked**2, axis=1) - 1)
                particles.append(h["particles"][-1])
                cost.append(seconds)
            rows.append((order, cell, levels, int(np.mean(particles)), f"{np.mean(cost):.2f}", f"{100 * np.sqrt(np.mean(np.square(of_k))):.3f}",
                         f"{100 * np.sqrt(np.mean(np.square(of_g))):.3f}", f"{100 * np.max(np.abs(of_g)):.2f}"))
            print("  ".join(map(str, rows[-1])), flush=True)
    write(rows, "paths", runs.folder)


def motion(runs):
    cut, within = 5e4, 0.6e-3
    times, exact = read_curve(ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1)
    undamped = ["damping.rate=0", "method.frame=total", "method.courant=0", "run.end_time=0.7e-3",
                "energy_release.estimators=vcct", "energy_release.energy_balance=.false.", "output.history_interval=2e-6", "output.snapshot_interval=0",
                "method.time=implicit"]
    rows = [("cells", "mass", "n", "levels", "rings", "dt [us]", "particles", "CPU [s]", "rms from converged finite elements [%]")]
    meshes = {"quadratic": [(2, 0, 0), (4, 0, 0), (2, 4, 1), (2, 4, 2), (4, 4, 2)], "bilinear": [(8, 0, 0), (16, 0, 0), (8, 1, 8), (8, 3, 4)]}
    kinds = [("quadratic", "lumped"), ("quadratic", "weighted"), ("quadratic", "consistent"), ("bilinear", "lumped")]
    for order, mass in kinds:
        for n, level, rings in meshes[order]:
            for dt in (2e-6, 1e-6, 0.5e-6):
                h, unit, seconds = runs(BEAM, [*undamped, *ORDERS[order], *beam_cells(n), *around_tip(level, rings),
                                               f"method.time_step={dt}", f"method.mass={mass}"])
                t, g = h["time"], h["G_vcct_I"] / unit
                converged = np.interp(t, times, exact)
                error = (lowpass(t, g, cut) - lowpass(t, converged, cut))[t <= within]
                rows.append((order, mass, n, level, rings, 1e6 * dt, int(h["particles"][-1]), f"{seconds:.2f}",
                             f"{100 * np.sqrt(np.mean(error**2)) / np.max(np.abs(converged)):.2f}"))
    write(rows, "motion", runs.folder)


def wave(runs):
    """Cells that are cut, in motion."""
    rows = [("cells", "cell [mm]", "levels", "steps", "particles", "CPU [s]", *(f"{tip} tip: K_{mode} [%]" for tip in ("upper", "lower") for mode in ("I", "II")))]
    explicit, implicit = ["method.mass=consistent"], ["method.mass=consistent", "method.time=implicit", "method.time_step=1e-8"]
    for order, cell, levels, settings in (("quadratic", 1, 0, explicit), ("quadratic", 1, 2, implicit), ("quadratic", 0.5, 0, explicit),
                                          ("quadratic", 0.5, 0, implicit), ("bilinear", 0.25, 0, [])):
        h, _, seconds = runs(wave_scene(cell * 1e-3, "lumped"), [*ORDERS[order], "method.frame=total", *around_tip(levels, 3), *settings])
        found = wave_errors(h)
        rows.append((order, cell, levels, "implicit" if settings == implicit else "usavg", int(h["particles"][-1]), f"{seconds:.1f}",
                     *(f"{100 * error:.2f}" for tip in ("upper", "lower") for error in found[tip])))
        print("  ".join(map(str, rows[-1])), flush=True)
    write(rows, "wave", runs.folder)


PARTS = {"beam": beam, "levels": levels, "reference": reference, "tension": tension, "dispersion": dispersion, "paths": paths, "motion": motion,
         "wave": wave}

if __name__ == "__main__":
    ARGUMENTS = command_line(__doc__, list(PARTS), "results/quadratic")
    RUNS = Runs(ARGUMENTS.program, ARGUMENTS.output)
    for part in ARGUMENTS.part:
        PARTS[part](RUNS)
