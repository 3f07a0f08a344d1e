"""What equilibrium costs and how near to it damped motions come.

    price   processor time of G of the double cantilever beam at rest: static runs beside the cheapest damped run on uniform cells within
            0.3 % (docs/evidence/tradeoff.md) and a damped one that refines by itself, in turns, the median counts
    size    time and memory from a thousand to a million particles, by solver: uniform cells, whole runs
    limit   static values beside those of motions that are damped for long: two cells, refined or not, two mass matrices

Run by `make -C bench static`; a part alone: .venv/bin/python bench/static.py price
"""

import statistics

import numpy as np
from program_runs import Program
from tables import ROOT, command_line

CONVERGED = 1.28737  # G/G_ref at rest, tests/reference/dcb_static.csv
SCENE = ROOT / "input/dcb.nml"
TURNS = 5
PLAIN = {"output.snapshot_interval": 0, "method.frame": "total", "method.courant": 0,
         "energy_release.estimators": "vcct,domain_integral", "energy_release.energy_balance": ".false."}
STATIC = PLAIN | {"method.time": "static"}
DAMPED = PLAIN | {"damping.rate": 3.2e4, "run.end_time": 1e-3, "output.history_interval": 1e-5}  # critical, of the first mode


def cells(n):
    """n cells over the depth of an arm."""
    return {"grid.cell": 0.01 / n, "grid.cells": f"{10 * n},{n + 1}"}


def run(settings, program):
    """Run the beam; processor time [s], largest memory [MiB], columns of the history."""
    done = program(SCENE, settings)
    return done.seconds, done.memory, done.columns


def error(columns, name="J"):
    """Error of the last G [%], of the largest size in the last tenth of a damped run."""
    g = columns[name] / (12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3))
    last = g[columns["time"] >= 0.9 * columns["time"][-1]] if len(g) > 2 else g[-1:]
    return max(100 * (last / CONVERGED - 1), key=abs)


def price(program):
    rows = [("damped, uniform, n = 28, usf", DAMPED | cells(28) | {"method.scheme": "usf"}, "G_vcct_I"),
            ("damped, zz 0.03, n = 2", DAMPED | cells(2) | {
                "refine.indicator": "zz", "refine.tolerance": 0.03, "refine.max_level": 6, "refine.start": 8e-4, "refine.interval": 50,
                "method.scheme": "usl", "run.end_time": 2e-3}, "J"),
            *((f"static, zz {tolerance}, n = {n}", STATIC | cells(n) | {
                "refine.indicator": "zz", "refine.tolerance": tolerance, "refine.max_level": 12}, "J")
              for n, tolerance in ((2, 0.06), (4, 0.06), (4, 0.05), (2, 0.04), (4, 0.035), (2, 0.03), (4, 0.03))),
            ("static, uniform, n = 8", STATIC | cells(8), "G_vcct_I"),
            ("static, uniform, n = 16", STATIC | cells(16), "G_vcct_I"),
            ("static, uniform, n = 48", STATIC | cells(48), "J")]
    measured = {name: [] for name, _, _ in rows}
    for turn in range(TURNS):
        for name, settings, _ in rows:
            if turn == 0 or not name.startswith("damped, zz"):   # a minute each
                measured[name].append(run(settings, program))
    yardstick = statistics.median(seconds for seconds, _, _ in measured[rows[0][0]])
    print("| setting | estimator | cells | error | CPU s | of the first |\n|---|---|---|---|---|---|")
    for name, _, column in rows:
        seconds = statistics.median(seconds for seconds, _, _ in measured[name])
        columns = measured[name][0][2]
        print(f"| {name} | {column} | {columns['cells'][-1]:.0f} | {error(columns, column):+.3f} % | {seconds:.3f} | "
              f"1/{yardstick / seconds:.1f} |", flush=True)
    pair = [measured[f"static, uniform, n = {n}"] for n in (8, 16)]
    seconds = sum(statistics.median(seconds for seconds, _, _ in runs) for runs in pair)
    coarse, fine = (error(runs[0][2], "G_vcct_I") for runs in pair)
    print(f"| static, uniform, n = 8 and 16, extrapolated | G_vcct_I | | {2 * fine - coarse:+.3f} % | {seconds:.3f} | "
          f"1/{yardstick / seconds:.1f} |")


def size(program):
    print("| particles | unknowns | direct s | MiB | cg s | MiB |\n|---|---|---|---|---|---|")
    before, times = None, {}
    for n in (5, 16, 50, 158):
        taken = []
        for solver in ("direct", "cg"):
            settings = STATIC | cells(n) | {"method.solver": solver, "energy_release.estimators": "vcct", "energy_release.energy_balance": ".false."}
            seconds, memory, _ = run(settings, program)
            times[n, solver] = seconds
            taken.append(f"{seconds:.2f} | {memory:.0f}")
        particles = 40 * n**2
        print(f"| {particles} | {2 * (10 * n + 1) * (n + 1)} | {' | '.join(taken)} |", flush=True)
        if before:
            orders = {solver: np.log(times[n, solver] / times[before, solver]) / np.log((n / before)**2)
                      for solver in ("direct", "cg")}
            print("|  | order in particles | " + " |  | ".join(f"{order:.2f}" for order in orders.values()) + " |  |", flush=True)
        before = n


def limit(program):
    long = {"damping.rate": 1.2e4, "run.end_time": 1.6e-2, "output.history_interval": 1e-3}
    print("| cell [mm] | mesh | mass | G_vcct | G_stress_closure | J | K_I |\n|---|---|---|---|---|---|---|")
    for n in 2, 8:
        for mesh in ("uniform", "refined"):
            for mass in ("lumped", "consistent"):
                both = cells(n) | {"method.mass": mass, "method.solver": "direct",
                                   "energy_release.estimators": "vcct,stress_closure,domain_integral", "energy_release.energy_balance": ".false."}
                if mesh == "refined":
                    both |= {"refine.indicator": "tip", "refine.max_level": 2}
                rest, motion = (run(given | both, program)[2] for given in (STATIC, PLAIN | long))
                differences = [f"{rest[name][-1] / motion[name][-1] - 1:+.1e}"
                               for name in ("G_vcct_I", "G_stress_closure_I", "J", "K_I")]
                print(f"| {10 / n} | {mesh} | {mass} | {' | '.join(differences)} |", flush=True)


if __name__ == "__main__":
    ARGUMENTS = command_line(__doc__, ["price", "size", "limit"], "results/static")
    for part in ARGUMENTS.part:
        print(f"\n{part}")
        globals()[part](Program(ARGUMENTS.program, ARGUMENTS.output))
