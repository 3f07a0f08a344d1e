"""Checkpoints that are changed at random: bits, bytes, pieces that are cut out, put in, zeroed or exchanged.

A checkpoint that is not what it was is refused with exit code 4 and one line, and the result beside it stays as it is. Where only bytes have changed that HDF5 leaves
unused, the run goes on to the result that it would have.

    .venv/bin/python tests/fuzz/checkpoint_files.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import argparse
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

from runs import PROGRAM, ROOT

GROWTH = """\
&run plane = 'strain'  end_time = 1.0 /
&grid lower = -20e-3, -21e-3  cell = 1e-3  cells = 40, 42 /
&material name = 'a'  young = 3e9  poisson = 0.3  density = 1200 /
&body material = 'a'  lower = -20e-3, -20e-3  upper = 20e-3, 20e-3 /
&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = 0, 40 /
&load kind = 'traction'  lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  force = 0, -40 /
&crack kind = 'path'  points = -5e-3, 0.3e-3, 5e-3, 0.3e-3 /
&growth direction = 'straight'  toughness = 100  increment = 2e-3 /
&energy_release estimators = 'domain_integral' /
&method time = 'static'  load_steps = 6 /
"""
SCENES = {"a crack that grows": (GROWTH, ["--steps", "2"]),
          "a beam": ((ROOT / "input/dcb.nml").read_text(), ["--steps", "20", "--set", "run.end_time=1e-5", "--set", "output.snapshot_interval=0"])}


def change(data, chance):
    """Another file made of one."""
    data, at = bytearray(data), chance.randrange(len(data))
    kind = chance.choice(["bit", "bytes", "cut", "zero", "insert", "exchange", "empty", "more"])
    if kind == "bit":
        data[at] ^= 1 << chance.randrange(8)
    elif kind == "bytes":
        for _ in range(chance.randint(1, 50)):
            data[chance.randrange(len(data))] = chance.randrange(256)
    elif kind == "cut":
        del data[at:]
    elif kind == "zero":
        data[at:at + 1000] = bytes(len(data[at:at + 1000]))
    elif kind == "insert":
        data[at:at] = chance.randbytes(chance.randint(1, 20))
    elif kind == "exchange":
        other = chance.randrange(len(data))
        data[at], data[other] = data[other], data[at]
    elif kind == "empty":
        data.clear()
    else:
        data += chance.randbytes(chance.randint(1, 100))
    return bytes(data)


def computed(path):
    """The bytes of all that a result holds but for when and where it was made, attributes of the file itself."""
    found = {}

    def note(name, item):
        found[name] = [item[()].tobytes() if isinstance(item[()], np.generic | np.ndarray) else item[()]] if isinstance(item, h5py.Dataset) else []
        found[name] += sorted((key, str(value)) for key, value in item.attrs.items() if key not in ("REFERENCE_LIST", "DIMENSION_LIST"))
    with h5py.File(path) as file:
        file.visititems(note)
    return found


def try_checkpoints(program, cases, seed):
    """How many checkpoints were refused, how many were as good as before, and what is wrong with the rest."""
    refused, unused, findings = 0, 0, []
    for name, (text, more) in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "case.nml").write_text(text)
            words = ["--quiet", "--set", "output.file=case.h5", *more]
            subprocess.run([program, "case.nml", *words], cwd=folder, capture_output=True)
            checkpoint, result = folder / "case.h5.checkpoint", folder / "case.h5"
            good, before = checkpoint.read_bytes(), result.read_bytes()
            subprocess.run([program, "--resume", checkpoint.name, "--quiet"], cwd=folder, check=True)
            after = computed(result)
            result.write_bytes(before)
            for case in range(cases // len(SCENES)):
                changed = change(good, random.Random(f"{seed} {name} {case}"))
                if changed == good:
                    continue
                checkpoint.write_bytes(changed)
                run = subprocess.run([program, "--resume", checkpoint.name, "--quiet"], cwd=folder, capture_output=True, text=True)
                if run.returncode == 0 and computed(result) == after:
                    unused += 1
                    result.write_bytes(before)
                elif run.returncode != 4 or len(run.stderr.splitlines()) != 1 or not run.stderr.startswith("hampm: ") or result.read_bytes() != before:
                    findings.append(f"seed {seed}, {name}, case {case}: ended with {run.returncode}: {run.stderr[-500:]}")
                    checkpoint.unlink(missing_ok=True)
                    result.write_bytes(before)
                else:
                    refused += 1
    return refused, unused, findings


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=1000, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    refused, unused, found = try_checkpoints(options.program.resolve(), options.cases, options.seed)
    print(f"{refused} refused, {unused} changed in what HDF5 does not use")
    sys.exit("\n".join(found) or 0)
