"""What each choice of mass matrix costs, dissipates and allows: three tables, and a CSV file of each.

    cost         processor time of a step relative to the lumped matrix, and memory
    dissipation  energy lost by the method in 100 periods of the free vibration of a bar
    limit        largest stable time step, by bisection, beside theory
    fractions    which lumped fraction gives waves that load a crack best: K_I of Chen's plate (50 by 100 cells, total frame) against independent finite
                 elements, over the peak, until the wave that closes the crack

Run by `make -C bench masses`, or for one part: .venv/bin/python bench/mass_matrices.py limit --output results/masses
"""

import math
import resource
import statistics
import sys

import numpy as np
from mass_theory import Block
from program_runs import Program, Unstable
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))

from history import moving_mean, read_curve  # noqa: E402

SCHEMES = ("usf", "usl", "usavg", "musl")
KINDS = ("lumped", "fmpm 2", "fmpm 4", "weighted 0.5", "partial", "consistent")  # partial: consistent in the left half


def mass_settings(kind, box):
    """Keys of &method of a kind such as 'fmpm 2'; `box` is where a partial one is consistent."""
    mass, _, number = kind.partition(" ")
    settings = {"mass": f"'{mass}'"}
    if mass == "fmpm":
        settings["order"] = number
    if mass == "weighted":
        settings["lumped_fraction"] = number
    if mass == "partial":
        settings |= {"consistent_lower": f"{box[0]}, {box[1]}", "consistent_upper": f"{box[2]}, {box[3]}"}
    return settings


# --- cost -----------------------------------------------------------------------------------------------------------

COST_KINDS = [("fmpm 2", None), ("fmpm 4", None)] + [
    (kind, solver) for kind in ("weighted 0.5", "partial", "consistent") for solver in ("cg", "direct")]


def target(kind, frame):
    """Most that a kind may cost relative to lumped."""
    if kind == "fmpm 2":
        return 1.6
    if frame == "total":
        return 4.0
    return 8.0


def dcb_settings(kind, solver, frame, cell, steps):
    shear_speed = (70e9 / 2.6 / 2700) ** 0.5
    end = steps * 0.1 * cell / shear_speed
    columns = round(0.1 / cell)
    method = mass_settings(kind, (0.0, 0.0, 0.05, 0.01)) | {"frame": f"'{frame}'", "courant": 0.1}
    if solver:
        method["solver"] = f"'{solver}'"
    return [f"grid.cell={cell}", f"grid.cells={columns},{columns // 10 + 1}", "energy_release.estimators='vcct'", "energy_release.energy_balance=.false.",
            "output.snapshot_interval=0", f"output.history_interval={end}", f"run.end_time={end}"] + [f"method.{key}={value}" for key, value in method.items()]


def step_time(program, kind, solver, frame, few=60, many=260):
    """User time of a step [s], without set-up and the first steps."""
    scene, cell = ROOT / "input/dcb.nml", 0.625e-3
    times = [program(scene, dcb_settings(kind, solver, frame, cell, steps)).seconds for steps in (few, many)]
    return (times[1] - times[0]) / (many - few)


def cost(program, repeats):
    rows = [("mass", "solver", "frame", "cost", "target", "met")]
    for frame in ("updated", "total"):
        for kind, solver in COST_KINDS:
            ratios = []
            for _ in range(repeats):
                yardstick = step_time(program, "lumped", None, frame)
                ratios.append(step_time(program, kind, solver, frame) / yardstick)
            ratio, most = statistics.median(ratios), target(kind, frame)
            met = "yes" if ratio <= most else "NO"
            rows.append((kind, solver or "", frame, f"{ratio:.2f}", most or "", met))
    return rows


def memory(program):
    rows = [("cell [mm]", "nodes", "MiB lumped", "MiB consistent, cg", "KiB a node more than the row above, cg")]
    last = None
    for cell in (1.25e-3, 0.625e-3, 0.3125e-3, 0.15625e-3):
        scene, columns = ROOT / "input/dcb.nml", round(0.1 / cell)
        nodes = (columns + 1) * (columns // 10 + 2)
        peak = {kind: program(scene, dcb_settings(kind, None, "updated", cell, 10)).memory for kind in ("lumped", "consistent")}
        if min(peak.values()) <= resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:
            print("memory: hidden by that of this script; run the part cost by itself")
        growth = "" if last is None else f"{1024 * (peak['consistent'] - last[1]) / (nodes - last[0]):.2f}"
        rows.append((f"{cell * 1e3:g}", nodes, f"{peak['lumped']:.1f}", f"{peak['consistent']:.1f}", growth))
        last = nodes, peak["consistent"]
    return rows


# --- scenes in cells of size 1, density 1 and dilatational wave speed 1 -----------------------------------------------

def group(title, /, **keys):
    return f"&{title}\n" + "".join(f"   {key} = {value}\n" for key, value in keys.items()) + "/\n"


def scene(cells, poisson, end, interval, method, law="linear_elastic", balance=False):
    """The groups that every scene needs, but for its bodies."""
    young = (1 + poisson) * (1 - 2 * poisson) / (1 - poisson)
    text = group("run", plane="'strain'", end_time=end) + group("grid", cell=1.0, cells=f"{cells[0]}, {cells[1]}")
    text += group("material", name="'m'", law=f"'{law}'", young=young, poisson=poisson, density=1.0)
    text += group("method", **method) + group("output", history_interval=interval)
    return text + (group("energy_release", energy_balance=".true.") if balance else "")


def body(lower, upper, velocity=(0.0, 0.0)):
    return group("body", material="'m'", lower=f"{lower[0]}, {lower[1]}", upper=f"{upper[0]}, {upper[1]}",
                 velocity=f"{velocity[0]}, {velocity[1]}")


def held(lower, upper, fix):
    return group("constraint", lower=f"{lower[0]}, {lower[1]}", upper=f"{upper[0]}, {upper[1]}", fix=f"'{fix}'")


def bar_is_held(length):
    """One end held, and no motion across the bar."""
    return held((0, 0), (0, 2), "x") + held((0, 0), (length + 1, 2), "y")


# --- dissipation ----------------------------------------------------------------------------------------------------

BAR = 10  # cells
COURANTS = (0.1, 0.3, 0.6)


def bar_loss(program, kind, scheme, courant, amplitude, frame, periods):
    """Loss in some periods as a share of the energy of the first mode, whose tip moves by `amplitude` cells.

    A body force that rises and falls as 1 - cos over one period excites the first mode alone: its spectrum has zeros at
    the others.
    """
    period, pieces = 4.0 * BAR, 40
    force = amplitude / BAR / (8 / math.pi**2)
    times = [period * k / pieces for k in range(pieces + 1)]
    factors = [0.5 - 0.5 * math.cos(2 * math.pi * k / pieces) for k in range(pieces + 1)]
    factors[0] = factors[-1] = 0.0
    method = mass_settings(kind, (0, 0, BAR / 2, 1)) | {
        "scheme": f"'{scheme}'", "courant": courant, "wave_speed": "'dilatational'", "frame": f"'{frame}'"}
    law = "neo_hookean" if frame == "updated" else "linear_elastic"
    end, interval = (periods + 11) * period, courant * round(9.1 / courant)
    text = scene((BAR + 2, 2), 0.0, end, interval, method, law, True)
    text += body((0, 0), (BAR, 1)) + bar_is_held(BAR)
    text += group("load", kind="'body'", lower="0, 0", upper=f"{BAR}, 1", force=f"{force}, 0", history="'table'",
                  times=", ".join(map(str, times)), factors=", ".join(map(str, factors)))
    try:
        columns = program(text).columns
    except Unstable:
        return None
    time, loss = columns["time"], columns["numerical_loss"]  # means over ten periods: a scheme borrows within a period
    first = (time > period) & (time <= 11 * period)
    last = time > (periods + 1) * period
    energy = (columns["kinetic_energy"] + columns["strain_energy"])[first].mean()
    return (loss[last].mean() - loss[first].mean()) / energy


def dissipation(program, periods):
    rows = [("motion", "mass", "scheme") + tuple(f"courant {c}" for c in COURANTS)]
    for motion, amplitude, frame in (("small", 1e-6, "total"), ("through cells", 0.4, "updated")):
        for kind in KINDS:
            for scheme in SCHEMES:
                losses = [bar_loss(program, kind, scheme, c, amplitude, frame, periods) for c in COURANTS]
                rows.append((motion, kind, scheme) + tuple("unstable" if x is None else f"{x:.1e}" if abs(x) < 1e-4
                                                           else f"{x:.4f}" for x in losses))
    return rows


# --- limit ----------------------------------------------------------------------------------------------------------

SHIFTS = (0.01, 0.2, 0.251, 0.26, 0.3, 0.4)  # of a block against the lattice; at 0.25 particles enter new cells


def is_stable(program, block, kind, scheme, courant, frame="total", steps=2000):
    nx, ny, poisson = block
    method = mass_settings(kind, (0, 0, nx / 2, ny)) | {
        "scheme": f"'{scheme}'", "wave_speed": "'dilatational'", "frame": f"'{frame}'"}
    across = 0.0 if ny == 1 else 0.7e-6
    text = scene((nx + 1, ny + 1), poisson, steps * courant, steps * courant / 10, method)
    text += body((0, 0), (nx, ny), (1e-6, across)) + (bar_is_held(nx) if ny == 1 else held((0, 0), (0, ny), "xy"))
    try:
        program(text, forced=courant * (1 + 1e-9))
    except Unstable:
        return False
    return True


def bisect(is_stable, guess, accuracy=0.005):
    """Largest stable courant number: between a stable and an unstable run, first sought around the guess."""
    low, high = 0.98 * guess, 1.02 * guess
    while not is_stable(low):
        low, high = low / 1.3, low
    while is_stable(high):
        low, high = high, high * 1.3
    while high > (1 + accuracy) * low:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return (low * high) ** 0.5


def drift(program, method, *more):
    """What two blocks that meet and drift through 10 cells gain, over their energy in excess of the common drift: 'fails' where the run does.

    The courant number of the settings of &method is that of shear waves; `more` are further groups.
    """
    text = scene((40, 20), 0.3, 500.0, 10.0, method | {"frame": "'updated'"}, "neo_hookean")
    text += body((2, 2), (5, 6), (0.022, 0.0083)) + body((5, 2), (8, 6), (0.018, 0.0083)) + "".join(more)
    try:
        columns = program(text).columns
    except Unstable:
        return "fails"
    energy = columns["kinetic_energy"] + columns["strain_energy"]
    common = 24 / 2 * (0.02**2 + 0.0083**2)
    return f"{(energy[-1] - energy[0]) / (energy[0] - common):+.3f}"


def limit(program):
    rows = [("body", "mass", "scheme", "elements", "theory", "measured", "measured/theory", "over the default",
             "any position", "over the default", "drift, courant 0.1", "drift, courant 0.05")]
    for name, block in (("bar", (20, 1, 0.0)), ("block", (5, 5, 0.3))):
        poisson = block[2]
        default = 0.1 * ((2 - 2 * poisson) / (1 - 2 * poisson)) ** 0.5  # 0.1 of the shear wave, as courant of the other
        theory = Block(*block, held_y=name == "bar")
        shifts = [Block(4, 4, 0.3, (x, y), held_left=False) for x in SHIFTS for y in SHIFTS] if name == "block" else []
        for kind in KINDS:
            mass, _, number = kind.partition(" ")
            options = {"order": int(number)} if mass == "fmpm" else {}
            a = theory.inverse(mass, **options)
            anywhere = {}
            for scheme in SCHEMES:
                expected = theory.limit(scheme, a)
                measured = bisect(lambda courant: is_stable(program, block, kind, scheme, courant), expected)
                row = [name, kind, scheme, f"{theory.node_limit(a):.3f}", f"{expected:.3f}", f"{measured:.3f}",
                       f"{measured / expected:.3f}", f"{measured / default:.2f}", "", "", "", ""]
                if shifts:
                    by = "usl" if scheme == "usl" else "musl"
                    if by not in anywhere:
                        anywhere[by] = min(b.limit(by, b.inverse(mass, **options)) for b in shifts)
                    moving_default = default / 2 if mass in ("consistent", "partial") else default
                    row[8:] = [f"{anywhere[by]:.3f}", f"{anywhere[by] / moving_default:.2f}",
                               *(drift(program, mass_settings(kind, (0, 0, 15, 20)) | {"scheme": f"'{scheme}'", "courant": c}) for c in (0.1, 0.05))]
                rows.append(tuple(row))
    return rows


# --- fractions ------------------------------------------------------------------------------------------------------

CHEN = ROOT / "tests/regression/chen"
COMPARED, WINDOW = 13.95e-6, 0.2e-6  # K_I is compared until then, and its means over that [s]


def fractions(program, cells=50):
    """The table of docs/explanation/mass.md; tests/unit/test_surface_wave.f90 measures that of a surface wave."""
    rows = [("mass", "lumped fraction", "rms [%]", "rms of the mean over 0.2 us [%]", "time [s]")]
    times, single, mean = (read_curve(CHEN / "reference.csv", column) for column in (1, 1, 2))
    times, single, mean = times[0], single[1], mean[1]
    for mass, part in (("lumped", 1.0), *(("weighted", b) for b in (0.5, 0.4, 5 / 18, 0.25, 0.1)), ("consistent", 0.0)):
        done = program(CHEN / "case.nml", [f"grid.cell={10e-3 / cells}", f"grid.cells={cells + 1},{2 * cells + 1}", "method.frame=total", f"method.mass={mass}",
                                           f"method.courant={0 if mass == 'consistent' else 0.3}", f"method.lumped_fraction={part}", "method.solver=cg",
                                           "energy_release.estimators=domain_integral", "energy_release.energy_balance=.false."])
        t, k = done.columns["time"], done.columns["K_I"]
        errors = [np.sqrt(np.mean((found - np.interp(t, times, exact))[t <= COMPARED]**2)) / mean.max()
                  for found, exact in ((k, single), (moving_mean(t, k, WINDOW), mean))]
        rows.append((mass, f"{part:.3f}", *(f"{100 * error:.2f}" for error in errors), f"{done.seconds:.1f}"))
        print(*rows[-1], flush=True)
    return rows


def main():
    arguments = command_line(__doc__, ["cost", "dissipation", "limit", "fractions"], "results/masses",
                             repeats=(3, "measurements of a cost, of which the median"),
                             periods=(100, "of the dissipation"))
    program = Program(arguments.program, arguments.output)
    if "cost" in arguments.part:  # first: a large script would hide the memory of the program
        write(memory(program), "memory", arguments.output)
        write(cost(program, arguments.repeats), "cost", arguments.output)
    if "dissipation" in arguments.part:
        write(dissipation(program, arguments.periods), "dissipation", arguments.output)
    if "limit" in arguments.part:
        write(limit(program), "limit", arguments.output)
    if "fractions" in arguments.part:
        write(fractions(program), "fractions", arguments.output)


if __name__ == "__main__":
    main()
