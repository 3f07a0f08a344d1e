"""What time steps that fit the size of the cells cost and change on the refined double cantilever beam.

    cost       user time and instructions against those of common steps, measured in turn
    motion     first frequency and G(t) without damping, against common steps of half the length
    energy     total energy over 1000 periods of the undamped beam of three and seven sizes of cells, about eight minutes

Run by `make -C bench local_steps`, about ten minutes, or for one part: .venv/bin/python bench/local_time_steps.py cost. Instructions
need `make program` and valgrind, which takes fifty times as long as the program: they are counted on a short
piece of the runs on 5 mm cells.
"""

import statistics
import sys

from instructions import can_count, run_counted
from mass_matrices import Program
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))
CASE = ROOT / "tests/regression/dcb_refined/case.nml"
RELEASE = ROOT / "build/release/hampm"
FINE = ["grid.cell=2.5e-3", "grid.cells=40,5", "refine.max_level=4", "refine.rings=8"]
REST = "run.end_time=2.4e-3"
BEAMS = {  # name: settings, courant, end times of what is counted [s]
    "5 mm, 6 levels, 4 rings": ([], 0.5, (2e-5, 4e-5)),
    "5 mm, 6 levels, 4 rings, courant 0.8": ([], 0.8, (2e-5, 4e-5)),
    "2.5 mm, 4 levels, 8 rings": (FINE, 0.8, None)}
STEPS = ("global", "local")
ASKED = 0.5  # of the work of common steps, at most
HEAD = ("common: CPU [s]", "local", "ratio", "common: instructions", "local", "ratio")


def settings(steps, courant=0.5, interval=1e-5):
    return ["method.frame=total", f"method.time_steps={steps}", f"method.courant={courant}", f"output.history_interval={interval}",
            "energy_release.estimators='vcct'", "energy_release.energy_balance=.false.", "output.file=local.h5"]


def history(program, scene, words):
    """Run; return the columns of the history."""
    from history import History
    program(scene, words)
    return History(program.folder / "local.h5").columns


def difference(columns, reference):
    """Root mean square difference of G(t) over that of the reference."""
    import numpy as np
    reference = reference["G_vcct_I"]
    return np.sqrt(np.mean((columns["G_vcct_I"] - reference)**2) / np.mean(reference**2))


def count(folder, scene, words, ends):
    """Instructions between two times of a run: without the start."""
    counts = []
    for end in ends:
        text = [word for item in [*words, f"run.end_time={end}"] for word in ("--set", item)]
        counts.append(run_counted(RELEASE, scene, "--quiet", "--force", "--output", folder, *text)[1])
    return counts[1] - counts[0]


def costs(program, scene, words, repeats, ends):
    """What the columns HEAD hold, `words` being the settings for each kind of steps, and the ratio of times."""
    times = [[program(scene, words[steps])[0] for steps in STEPS] for _ in range(repeats)]
    ratio = statistics.median(local / common for common, local in times)
    counted = ("", "", "")
    if ends and can_count() and RELEASE.is_file():
        counts = [count(program.folder, scene, words[steps], ends) for steps in STEPS]
        counted = (f"{counts[0]:.3e}", f"{counts[1]:.3e}", f"{counts[1] / counts[0]:.3f}")
    return (*(f"{statistics.median(column):.2f}" for column in zip(*times)), f"{ratio:.2f}", *counted), ratio


def cost(program, repeats):
    """What local steps cost, and G at the end of the run over that of common steps."""
    rows = [("beam", "courant", *HEAD, "target", "met", "G at the end over that of common steps, less 1")]
    for name, (beam, courant, ends) in BEAMS.items():
        words = {steps: [REST, *beam, *settings(steps, courant)] for steps in STEPS}
        columns, ratio = costs(program, CASE, words, repeats, ends)
        last = {steps: history(program, CASE, words[steps])["G_vcct_I"][-1] for steps in STEPS}
        rows.append((name, courant, *columns, ASKED, "yes" if ratio <= ASKED else "NO", f"{last['local'] / last['global'] - 1:+.1e}"))
    return rows


def motion(program):
    from history import first_frequency
    rows = [("steps", "courant", "f1 [Hz]", "rms difference of G(t)")]
    beam = [*FINE, "damping.rate=0", "run.end_time=1.2e-3"]
    reference = history(program, CASE, [*beam, *settings("global", 0.25, 2e-6)])
    for steps, courant in (("global", 0.8), ("local", 0.8), ("local", 0.4)):
        columns = history(program, CASE, [*beam, *settings(steps, courant, 2e-6)])
        rows.append((steps, courant, f"{first_frequency(columns['time'], columns['crack_opening']):.2f}", f"{difference(columns, reference):.4f}"))
    return rows


def energy(program, periods):
    """Total energy K + U - W of the beam that a sudden load makes vibrate for ever, in units of the energy of the vibration, which
    is half of the mean work: its change from the first tenth of the run to the last, and the largest value, which by the exact
    motion is 0. The first frequency of the first and of the last tenth."""
    import numpy as np
    period = 1 / 2530
    rows = [("sizes of cells", "steps", "periods", "change", "largest", "rms, first tenth", "last tenth", "f1 [Hz]", "in the end")]
    for levels, rings, kinds in ((2, 2, STEPS), (6, 4, ("local",))):
        beam = ["damping.rate=0", f"refine.max_level={levels}", f"refine.rings={rings}", f"run.end_time={periods * period}"]
        for steps in kinds:
            columns = history(program, CASE, [*beam, *settings(steps, 0.8)])
            unit = np.mean(columns["external_work"]) / 2
            total = (columns["kinetic_energy"] + columns["strain_energy"] - columns["external_work"]) / unit
            n = len(total) // 10
            first, last = total[:n], total[-n:]
            rows.append((levels + 1, steps, periods, f"{last.mean() - first.mean():+.1e}", f"{np.max(np.abs(total)):.1e}",
                         f"{np.std(first):.1e}", f"{np.std(last):.1e}",
                         *(f"{peak(columns['time'][part], columns['mouth_opening'][part]):.2f}"
                           for part in (slice(n), slice(-n, None)))))
    return rows


def peak(times, values):
    """Frequency of the largest peak of the spectrum, which a parabola through its logarithm finds between samples [Hz]."""
    import numpy as np
    amplitude = np.abs(np.fft.rfft((values - np.mean(values)) * np.hanning(len(values))))
    k = 1 + np.argmax(amplitude[1:-1])
    below, at, above = np.log(amplitude[k - 1:k + 2])
    return (k + 0.5 * (below - above) / (below - 2 * at + above)) / (len(values) * (times[1] - times[0]))


def main():
    arguments = command_line(__doc__, ["cost", "motion", "energy"], "results/local_time_steps",
                             repeats=(3, "measurements of a time, of which the median; long runs are measured once"),
                             periods=(1000, "length of the runs of `energy`, in periods of the beam"))
    program = Program(arguments.program, arguments.output.resolve())
    if "cost" in arguments.part:
        write(cost(program, arguments.repeats), "cost", arguments.output)
    if "motion" in arguments.part:
        write(motion(program), "motion", arguments.output)
    if "energy" in arguments.part:
        write(energy(program, arguments.periods), "energy", arguments.output)


if __name__ == "__main__":
    main()
