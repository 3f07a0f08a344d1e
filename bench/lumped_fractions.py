"""Which lumped fraction of the mass matrix gives waves that load a crack best: K_I of Chen's plate against independent finite elements.

    .venv/bin/python bench/lumped_fractions.py [--cells 50] [--courant 0.3]

The scene is input/chen.nml in the total frame; errors are over the peak of K_I, until the wave that closes the crack.
The table is in docs/explanation/mass.md, with that of a surface wave, which tests/unit/test_surface_wave.f90 measures.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tables import ROOT

sys.path.insert(0, str(ROOT / "postprocess"))
from history import History  # noqa: E402

CASE = ROOT / "tests/regression/chen"
COMPARED = 13.95e-6  # [s]
WINDOW = 0.2e-6      # of the moving mean [s]
PARTS = [("lumped", 1.0), *(("weighted", b) for b in (0.5, 0.4, 5 / 18, 0.25, 0.1)), ("consistent", 0.0)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=50, metavar="N", help="across the plate (default: 50)")
    parser.add_argument("--courant", type=float, default=0.3,
                        help="of shear waves; 0, and for consistent: 0.9 of the limit (default: 0.3)")
    options = parser.parse_args()
    reference = np.loadtxt(CASE / "reference.csv", delimiter=",", skiprows=header_lines())
    print("matrix            rms [%]  rms of the mean over 0.2 us [%]  time [s]")
    for mass, part in PARTS:
        with tempfile.TemporaryDirectory() as folder:
            seconds = run(mass, part, options.cells, options.courant if mass != "consistent" else 0, folder)
            columns = History(Path(folder) / "chen.h5").columns
        raw, mean = errors(columns["time"], columns["K_I"], reference)
        print(f"{mass:10} {part:6.3f} {100 * raw:8.2f} {100 * mean:33.2f} {seconds:14.1f}", flush=True)


def header_lines():
    """Lines of the reference before its numbers."""
    with open(CASE / "reference.csv") as file:
        return next(k for k, line in enumerate(file) if line[0].isdigit())


def run(mass, part, cells, courant, folder):
    """Run the plate; how long it took [s]."""
    settings = [f"grid.cell={10e-3 / cells}", f"grid.cells={cells + 1},{2 * cells + 1}", "method.frame=total",
                f"method.courant={courant}", f"method.mass={mass}", f"method.lumped_fraction={part}", "method.solver=cg",
                "energy_release.estimators=domain_integral", "energy_release.energy_balance=.false."]
    words = [word for setting in settings for word in ("--set", setting)]
    start = time.perf_counter()
    subprocess.run([ROOT / "build/release/hampm", CASE / "case.nml", "--quiet", "--output", folder, *words], check=True,
                   stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def errors(times, k, reference):
    """Root of the mean square of the error of K_I and of its moving mean, over the peak of that."""
    compared = times <= COMPARED
    peak = reference[:, 2].max()
    n = round(WINDOW / (times[1] - times[0])) | 1
    mean = np.convolve(k, np.full(n, 1 / n), "same")
    return [np.sqrt(np.mean((values - np.interp(times, reference[:, 0], reference[:, column]))[compared]**2)) / peak
            for values, column in ((k, 1), (mean, 2))]


if __name__ == "__main__":
    main()
