"""What refinement around a crack tip costs, allows and changes: a table for each part, and a CSV file of it.

    cost     user time per particle and step over that of uniform cells, and the share of a run that adapting the mesh takes
    limit    largest stable courant number on a refined mesh and on uniform cells, by bisection, and bodies that drift through one
    masses   static energy release rate by every mass matrix, scheme, solver and frame: the same

All on the double cantilever beam. Run by `make -C bench adaptivity`, or for one part: .venv/bin/python bench/refined_meshes.py cost
"""

import statistics

import numpy as np
from mass_matrices import KINDS, SCHEMES, body, group, mass_settings, scene
from program_runs import Program, Unstable
from tables import ROOT, command_line, write

CASE = ROOT / "tests/regression/dcb_refined/case.nml"
SHEAR_SPEED = (70e9 / 2.6 / 2700) ** 0.5


def mesh(cell, levels=0, rings=4):
    """Settings of a beam of root cells of a size in mm, refined around the tip or uniform."""
    columns = round(100 / cell)
    settings = [f"grid.cell={cell}e-3", f"grid.cells={columns},{columns // 10 + 1}"]
    if levels == 0:
        return settings + ["refine.indicator=none"]
    return settings + [f"refine.max_level={levels}", f"refine.rings={rings}"]


def method(kind, **more):
    """Settings of a mass matrix such as 'fmpm 4', and others of &method."""
    keys = mass_settings(kind, (0, 0, 0.05, 0.01)) | more
    if kind == "partial":
        keys = {key: value for key, value in keys.items() if not key.startswith("consistent_")} | {"consistent_region": "refined"}
    return [f"method.{key}={value}" for key, value in keys.items()]


class Beam:
    """Runs the beam."""

    def __init__(self, program):
        self.program = program

    def __call__(self, settings, forced=None):
        """Run, with the courant number `forced` whatever the limit."""
        return self.program(CASE, settings, forced=forced)

    def steps(self, settings, finest, courant, steps):
        """Run a number of steps without damping, `finest` being the smallest cell in mm; return user time [s]."""
        end = steps * courant * finest * 1e-3 / SHEAR_SPEED
        return self([*settings, "damping.rate=0", "method.courant=0", f"run.end_time={end}",
                     f"output.history_interval={end / 20}"], courant).seconds


# --- cost -----------------------------------------------------------------------------------------------------------

PAIRS = [  # a refined mesh and uniform cells with a like number of particles: settings, smallest cell [mm], particles
    (("5 mm, 6 levels, 4 rings", mesh(5, 6, 4), 5 / 64, 2272), ("1.25 mm", mesh(1.25), 1.25, 2560)),
    (("2.5 mm, 4 levels, 8 rings", mesh(2.5, 4, 8), 2.5 / 16, 6016), ("0.625 mm", mesh(0.625), 0.625, 10240))]


def step_time(beam, settings, finest, particles, few=500):
    """User time of a step per particle [ns], without set-up."""
    many = few + round(1.5e7 / particles)
    times = [beam.steps(settings, finest, 0.5, steps) for steps in (few, many)]
    return (times[1] - times[0]) / (many - few) / particles * 1e9


def cost(beam, repeats):
    rows = [("refined", "uniform", "particles", "particles", "ns per particle and step", "uniform", "ratio", "target", "met")]
    for (name, *refined), (uniform_name, *uniform) in PAIRS:
        times = [(step_time(beam, *refined), step_time(beam, *uniform)) for _ in range(repeats)]
        ratio = statistics.median(a / b for a, b in times)
        rows.append((name, uniform_name, refined[2], uniform[2], f"{statistics.median(a for a, _ in times):.1f}",
                     f"{statistics.median(b for _, b in times):.1f}", f"{ratio:.2f}", 1.5, "yes" if ratio <= 1.5 else "NO"))
    return rows


def share(beam, repeats):
    """What looking and adapting takes of a run, from runs that differ in the interval of the looks: the time per particle and step,
    as a straight line over 1/interval, has the value without looks at 0.
    """
    settings = [*mesh(5, 4), "refine.indicator=gradient", "refine.r_crit=0.1", "refine.r_coarsen=0.02", "refine.energy_floor=0.03",
                "refine.region_lower=0.03,0", "refine.region_upper=0.07,0.01", "load.history=ramp", "load.rise_time=0.4e-3",
                "method.courant=0.5", "run.end_time=1e-3"]
    rows = [("interval", "steps", "largest number of particles", "user time [s]", "ns per particle and step", "share of adapting",
             "target", "met", "G/G_ref")]
    found = {}
    for interval in (10, 20, 50, 100):
        runs = [beam([*settings, f"refine.interval={interval}"]) for _ in range(repeats)]
        times, columns = [run.seconds for run in runs], runs[-1].columns | runs[-1].attributes
        work = sum(columns["particles"][1:] * (columns["step"][1:] - columns["step"][:-1]))
        found[interval] = columns, statistics.median(times), statistics.median(times) / work * 1e9
    least = np.polyfit([1 / interval for interval in found], [each for _, _, each in found.values()], 1)[1]
    for interval, (columns, time, each) in found.items():
        part = 1 - least / each
        rows.append((interval, columns["step"][-1], max(columns["particles"]), f"{time:.2f}", f"{each:.1f}", f"{part:.3f}", 0.05,
                     "yes" if part <= 0.05 else "NO", f"{columns['G_vcct_I'][-1] / columns['G_ref']:.4f}"))
    return rows


# --- limit ----------------------------------------------------------------------------------------------------------

def bisect(beam, settings, finest, guess, accuracy=0.005):
    """Largest stable courant number of the shear wave."""
    def is_stable(courant):
        try:
            beam.steps(settings, finest, courant, 2000)
        except Unstable:
            return False
        return True
    low, high = 0.98 * guess, 1.02 * guess
    while not is_stable(low):
        low, high = low / 1.3, low
    while is_stable(high):
        low, high = high, high * 1.3
    while high > (1 + accuracy) * low:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return (low * high) ** 0.5


def limit(beam):
    rows = [("mass", "scheme", "uniform, total", "refined, total", "refined/uniform", "over the default", "refined, updated",
             "over the default")]
    guesses = {"lumped": 1.0, "fmpm 2": 0.65, "fmpm 4": 0.43, "weighted 0.5": 0.7, "partial": 0.26, "consistent": 0.26}
    for kind in KINDS:
        for scheme in SCHEMES:
            settings = method(kind, scheme=scheme)
            total = [*settings, "method.frame=total"]
            guess = guesses[kind]
            uniform = None if kind == "partial" else bisect(beam, [*mesh(2.5), *total], 2.5, guess)
            refined = bisect(beam, [*mesh(5, 3), *total], 0.625, guess)
            updated = bisect(beam, [*mesh(5, 3), *settings], 0.625, refined)
            default = 0.05 if kind in ("consistent", "partial") else 0.1
            rows.append((kind, scheme, "" if uniform is None else f"{uniform:.3f}", f"{refined:.3f}",
                         "" if uniform is None else f"{refined / uniform:.3f}", f"{refined / 0.1:.2f}", f"{updated:.3f}",
                         f"{updated / default:.2f}"))
    return rows


def drift(program, kind, scheme, courant):
    """What two blocks that meet and drift into a patch of finer cells gain, over their energy in excess of the common drift: the
    scene of `mass_matrices.drift`, whose cells refine by two levels where 7 < x < 14. 'fails' where the run does.
    """
    keys = mass_settings(kind, (0, 0, 15, 20)) | {"scheme": f"'{scheme}'", "courant": courant}
    if kind == "partial":
        keys = {"mass": "'partial'", "consistent_region": "'refined'", "scheme": f"'{scheme}'", "courant": courant}
    text = scene((40, 20), 0.3, 500.0, 10.0, keys, "neo_hookean")
    text += body((2, 2), (5, 6), (0.022, 0.0083)) + body((5, 2), (8, 6), (0.018, 0.0083))
    text += group("refine", indicator="'gradient'", r_crit=1e-9, r_coarsen=1e-10, energy_floor=0.0, max_level=2,
                  region_lower="7, 0", region_upper="14, 20")
    try:
        columns = program(text).columns
    except Unstable:
        return "fails"
    energy = columns["kinetic_energy"] + columns["strain_energy"]
    common = 24 / 2 * (0.02**2 + 0.0083**2)
    return f"{(energy[-1] - energy[0]) / (energy[0] - common):+.3f}"


def drifts(program):
    rows = [("mass", "courant", *SCHEMES)]
    for kind in KINDS:
        for courant in (0.1, 0.05):
            rows.append((kind, courant, *(drift(program, kind, scheme, courant) for scheme in SCHEMES)))
    return rows


# --- masses ---------------------------------------------------------------------------------------------------------

def masses(beam):
    """Every mass matrix, scheme, solver and frame at rest, on 5 mm cells of three levels."""
    rows = [("mass", "solver", "frame", "scheme", "courant", "G/G_ref", "change in the last 5 %", "kinetic/strain energy",
             "error of the energy balance", "user time [s]")]
    courants = {"lumped": 0.8, "fmpm 4": 0.35, "weighted 0.5": 0.6, "partial": 0.2, "consistent": 0.2}
    for kind, courant in courants.items():
        for solver in ("cg",) if kind in ("lumped", "fmpm 4") else ("cg", "direct"):
            for frame in ("updated", "total"):
                for scheme in ("musl", "usf", "usavg"):
                    settings = [*mesh(5, 3), *method(kind, solver=solver, frame=frame, scheme=scheme, courant=courant)]
                    done = beam(settings)
                    time, c = done.seconds, done.columns | done.attributes
                    ratio = c["G_vcct_I"] / c["G_ref"]
                    stored = c["kinetic_energy"] + c["strain_energy"]
                    error = abs(stored + c["damping_loss"] + c["numerical_loss"] - c["external_work"] - stored[0])
                    rows.append((kind, solver, frame, scheme, courant, f"{ratio[-1]:.5f}",
                                 f"{ratio[-1] / ratio[int(0.95 * len(ratio))] - 1:.1e}",
                                 f"{c['kinetic_energy'][-1] / c['strain_energy'][-1]:.1e}",
                                 f"{max(error) / max(c['external_work']):.1e}", f"{time:.1f}"))
    return rows


def main():
    arguments = command_line(__doc__, ["cost", "limit", "masses"], "results/adaptivity",
                             repeats=(5, "measurements of a time, of which the median"))
    program = Program(arguments.program, arguments.output)
    beam = Beam(program)
    if "cost" in arguments.part:
        write(cost(beam, arguments.repeats), "cost", arguments.output)
        write(share(beam, min(3, arguments.repeats)), "share", arguments.output)
    if "limit" in arguments.part:
        write(limit(beam), "limit", arguments.output)
        write(drifts(program), "drift", arguments.output)
    if "masses" in arguments.part:
        write(masses(beam), "masses", arguments.output)


if __name__ == "__main__":
    main()
