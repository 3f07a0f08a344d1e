"""How often small pieces of cells spoil a run at rest: edge cracks at random under pressure, and rings under inner pressure whose cells refine.

A run counts as bad where it ends with another code than 0, where the energy of a ring is off Lame's by more than 2 %, or where a crack opens at its
mouth, or stores, not 0.5 to 1.5 times as much as in cells of half the size.

    .venv/bin/python bench/small_pieces.py [--program build/release/hampm] [--cracks 100] [--seed 1]
"""

import argparse
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
from tables import ROOT

sys.path.insert(0, str(ROOT / "tests/cases"))
from test_cut_cells import edge_crack, lame_energy  # noqa: E402

RING = (ROOT / "tests/cases/pressed_ring_refined_a.nml").read_text().replace("-5e-3, -5e-3  upper = 5e-3, 5e-3", "-6.2e-3, -6.2e-3  upper = 6.2e-3, 6.2e-3")


def run(program, text, folder):
    """The last values of the history; None where the run has failed."""
    (folder / "scene.nml").write_text(text)
    result = subprocess.run([program, "scene.nml", "--force", "--output", "out", "--set", "output.file=scene.h5"], cwd=folder, capture_output=True)
    if result.returncode != 0:
        return None
    with h5py.File(folder / "out/scene.h5") as file:
        return {name: float(values[-1]) for name, values in file["history"].items()}


def crack_is_bad(program, text, folder):
    coarse = run(program, text, folder)
    fine = run(program, text.replace("cell = 1e-3  cells = 12, 12", "cell = 0.5e-3  cells = 24, 24"), folder)
    if coarse is None or fine is None:
        return True
    return any(not 0.5 * fine[name] < coarse[name] < 1.5 * fine[name] for name in ("mouth_opening", "strain_energy"))


def ring_is_bad(program, tenths, levels, folder):
    inner = tenths * 1e-4
    row = run(program, RING.replace("4.6e-3", repr(inner)).replace("max_level = 1", f"max_level = {levels}"), folder)
    return row is None or abs(row["strain_energy"] / lame_energy(inner, 9e-3) - 1) > 0.02


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", type=Path, default=ROOT / "build/release/hampm")
    options.add_argument("--cracks", type=int, default=100)
    options.add_argument("--seed", type=int, default=1)
    options = options.parse_args()
    program = options.program.resolve()
    at_random = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        bad = sum(crack_is_bad(program, edge_crack(at_random), folder) for _ in range(options.cracks))
        print(f"edge cracks: {bad} of {options.cracks} bad")
        for levels in (1, 2, 3):
            print(f"rings, {levels} levels: {sum(ring_is_bad(program, tenths, levels, folder) for tenths in range(40, 61))} of 21 bad")


if __name__ == "__main__":
    main()
