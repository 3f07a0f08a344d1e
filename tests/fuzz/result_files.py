"""Result files that are changed at random: no script of postprocess/ ends with a traceback, but each with one line and exit code 2 or 4, or as ever.

Datasets of real results get other types, shapes and values, attributes too; datasets go; bytes of the file change.

    .venv/bin/python tests/fuzz/result_files.py --cases 1000 --seed 2 FILE.h5 ...
"""

import argparse
import contextlib
import importlib
import io
import random
import shutil
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "postprocess"))

import h5py  # noqa: E402
import numpy as np  # noqa: E402
from history import ResultError  # noqa: E402

SCRIPTS = {  # with what is asked of them, quick first
    "tabulate": ["--column", "*"], "export": ["--normalised"], "compare": ["--interpolate"], "extrapolate": ["--column", "*"],
    "plot_profile": ["--field", "speed", "--csv"], "plot_g": ["--dpi", "20"], "plot_energy": ["--dpi", "20"], "plot_mesh": ["--dpi", "20"],
    "plot_path": ["--dpi", "20"],
    "plot_field": ["--dpi", "20"], "animate": ["--dpi", "20"], "report": ["--dpi", "20"]}
SLOW = ("animate", "report", "plot_path", "plot_field", "plot_mesh", "plot_energy", "plot_g")
COMPOUND = np.dtype([("a", "f8"), ("b", "i4")])


def datasets(file):
    """Names of all datasets, and of the groups with attributes."""
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def replaced(file, name, data, dtype=None):
    """Another dataset in the place of one, with its attributes."""
    attributes = dict(file[name].attrs)
    del file[name]
    item = file.create_dataset(name, data=data, dtype=dtype)
    item.attrs.update(attributes)


def change(chance, file):
    """Change something; in words what."""
    name = chance.choice([n for n in datasets(file) if "compiler" not in n])
    item = file[name]
    kind = chance.choice(["delete", "text", "complex", "bool", "compound", "reference", "scalar", "null", "empty", "short", "long", "nan", "inf", "huge",
                          "negative", "zero", "deep", "float16", "shuffled", "one", "attribute", "group"])
    values = np.asarray(item[()]) if item.dtype.kind in "iuf" and item.shape is not None else np.zeros(3)
    wide = float if kind in ("nan", "inf", "huge") or values.dtype.kind == "f" else np.int64
    some = np.array(values, dtype=wide if kind in ("nan", "inf", "huge", "negative", "one") else None).reshape(np.shape(values))
    size = max(some.size, 1)
    match kind:
        case "delete":
            del file[name]
        case "text":
            replaced(file, name, np.array(["<b>x</b>"] * size, dtype=object).reshape(some.shape or (1,)), h5py.string_dtype())
        case "complex":
            replaced(file, name, some + 1j)
        case "bool":
            replaced(file, name, some.astype(bool))
        case "compound":
            replaced(file, name, np.zeros(some.shape, COMPOUND))
        case "reference":
            replaced(file, name, np.array([file.ref] * size, dtype=object).reshape(some.shape or (1,)), h5py.ref_dtype)
        case "scalar":
            replaced(file, name, 1.0)
        case "null":
            replaced(file, name, h5py.Empty("f8"))
        case "empty":
            replaced(file, name, some[:0] if some.ndim else np.zeros(0))
        case "short":
            replaced(file, name, some[:len(some) // 2] if some.ndim else some)
        case "long":
            replaced(file, name, np.concatenate([some, some]) if some.ndim else some)
        case "nan" | "inf" | "huge" if some.ndim and some.size:
            some.flat[chance.randrange(size)] = {"nan": np.nan, "inf": np.inf, "huge": 1e300}[kind]
            replaced(file, name, some)
        case "negative" if some.ndim and some.size:
            some.flat[chance.randrange(size)] = -chance.choice([1, 7, 10**9])
            replaced(file, name, some)
        case "one" if some.ndim and some.size:
            some.flat[chance.randrange(size)] = chance.choice([1, 2, 1000, 2**31 - 1])
            replaced(file, name, some)
        case "zero":
            replaced(file, name, 0 * some)
        case "deep":
            replaced(file, name, some[..., None] if some.ndim else some)
        case "float16":
            with np.errstate(over="ignore"):
                replaced(file, name, some.astype(np.float16))
        case "shuffled" if some.ndim:
            replaced(file, name, some[::-1])
        case "attribute":
            place = chance.choice([name, "history", "input"])
            if place in file and len(file[place].attrs):
                key = chance.choice(sorted(file[place].attrs))
                file[place].attrs[key] = chance.choice([np.nan, 0.0, -1.0, "<script>", np.arange(3), b"\xff\xfe", 1j, np.inf, True])
                return f"{kind} {key} of {place}"
        case "group":
            del file[name]
            file.create_group(name)
    return f"{kind} {name}"


def corrupt(chance, path):
    """Change bytes, or cut the file short; in words where."""
    data = bytearray(path.read_bytes())
    if chance.random() < 0.3:
        path.write_bytes(data[:chance.randrange(len(data))])
        return "cut short"
    for _ in range(chance.choice([1, 4, 64])):
        data[chance.randrange(len(data))] = chance.randrange(256)
    path.write_bytes(data)
    return "bytes"


READ_ALL = """import contextlib, h5py, sys
def read(group):
    for name in list(group):
        with contextlib.suppress(Exception):
            item = group[name]
            list(item.attrs.items())
            read(item) if isinstance(item, h5py.Group) else item[()]
with h5py.File(sys.argv[1]) as file:
    read(file)
"""


def ends_the_library(path):
    """Whether HDF5 itself ends a process that reads a file, by a signal: no script can tell anything then."""
    return subprocess.run([sys.executable, "-c", READ_ALL, path], capture_output=True).returncode < 0


def call(name, arguments):
    """The exit code of a script and what it says; raises what it should not."""
    module = importlib.import_module(name)
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return module.main(arguments) or 0, said.getvalue()
        except ResultError as error:
            return error.exit_code, str(error)
        except SystemExit as end:
            return end.code or 0, said.getvalue()


def try_files(originals, cases, seed, scripts=None):
    """How many runs of scripts ended with which exit code, and which went wrong."""
    ends, findings = Counter(), []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for case in range(cases):
            chance = random.Random(f"{seed} {case}")
            original, path = Path(chance.choice(originals)), folder / "case.h5"
            shutil.copyfile(original, path)
            if chance.random() < 0.1:
                what = corrupt(chance, path)
                if ends_the_library(path):
                    ends["HDF5"] += 1
                    continue
            else:
                with h5py.File(path, "r+") as file:
                    what = ", ".join(change(chance, file) for _ in range(chance.choice([1, 1, 1, 2])))
            quick = [name for name in SCRIPTS if name not in SLOW]
            for name in scripts or [*quick, chance.choice(SLOW)]:
                files = [str(path)] + [str(original)] * (name in ("compare", "extrapolate"))
                output = [] if name in ("tabulate", "export", "compare", "extrapolate", "plot_profile") else \
                    ["-o", str(folder / {"animate": "a.gif", "report": "a.html"}.get(name, "a.png"))]
                try:
                    code, said = call(name, [*files, *SCRIPTS[name], *output])
                    fault = "" if code in (0, 1, 2, 4) and (code < 2 or len(said.strip().splitlines()) == 1 or "usage:" in said) else \
                        f"exit code {code}: {said}"
                except Exception:  # whatever it is, it is the finding
                    code, fault = None, traceback.format_exc(limit=-3)
                ends[code] += 1
                if fault:
                    findings.append(f"seed {seed} case {case}: {name} after {what}: {fault}")
    return ends, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="results with snapshots")
    parser.add_argument("--cases", type=int, default=1000, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    options = parser.parse_args()
    ends, findings = try_files(options.files, options.cases, options.seed)
    print(", ".join(f"{count} ended with {code}" for code, count in sorted(ends.items(), key=str)))
    sys.exit("\n".join(findings) or 0)


if __name__ == "__main__":
    main()
