#!/usr/bin/env python3
"""Make one table of all cases of a sweep, table.csv and table.h5 in its folder, and list those that have no result.

A case is a row: its name, its settings, its outcome (done; refused: a mistake in the scene; failed: in the computation; not
finished), what hampm said, processor time, wall time and peak memory of its runs, and of those that are done the number of particles
and the columns that the sweep asks for: the last value of each, and its mean over the time `mean` at the end as NAME_mean. An
attribute of the history, such as G_ref, is a column too. What a case does not have is blank, in table.h5 not a number.

It can be called at any time, also while cases run.
"""

import argparse
import csv
import os
from collections import Counter
from fnmatch import fnmatchcase
from pathlib import Path

from declaration import run
from history import History, moving_mean
from run_case import NOTHING_SPENT, identity, known
from sweep import PROGRAM, read_sweep

import h5py
import numpy as np

UNITS = {"cpu_seconds": "s", "wall_seconds": "s", "peak_megabytes": "MB"}
LONG_NAMES = {"case": "name of the case", "outcome": "how it ended", "message": "what hampm said",
              "cpu_seconds": "processor time of its runs", "wall_seconds": "wall time of its runs",
              "peak_megabytes": "peak memory of its runs", "starts": "number of times that it was started"}


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    rows = [begun(sweep, name) for name in sweep.cases]
    histories = {row["case"]: History(sweep.folder(row["case"]) / "result.h5") for row in rows if row["outcome"] == "done"}
    names = chosen(sweep, histories.values())
    units, long_names = dict(UNITS), dict(LONG_NAMES)
    for row in rows:
        if row["case"] in histories:
            row |= measured(histories[row["case"]], names, sweep.mean, units, long_names)
    sweep.output.mkdir(parents=True, exist_ok=True)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    write_csv(sweep.output / "table.csv", columns, rows)
    write_hdf5(sweep.output / "table.h5", columns, rows, units, long_names, sweep)
    report(sweep, rows)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    return parser.parse_args(arguments)


def begun(sweep, name):
    """The row of a case without what it has computed."""
    settings = sweep.cases[name]
    what = identity(sweep.namelist, settings)
    record, start = (found if found.get("case") == what else {}
                     for found in (known(sweep.folder(name) / file) for file in ("outcome.json", "case.json")))
    end = {"outcome": record.get("outcome", "not finished"), "message": record.get("message", "")}
    spent = record.get("spent") or start.get("spent") or NOTHING_SPENT
    return {"case": name} | {key: settings.get(key, "") for key in sweep.keys} | end | spent


def chosen(sweep, histories):
    """Names of the columns and attributes that any result has and the sweep asks for."""
    names = {}
    available = dict.fromkeys(name for history in histories for name in (*history.columns, *numbers(history)))
    for pattern in sweep.columns:
        matching = [name for name in available if fnmatchcase(name, pattern)]
        if available and not matching:
            print(f"{sweep.path}: columns: no result has '{pattern}'; they have {', '.join(available)}")
        names.update(dict.fromkeys(matching))
    return ["particles", *(name for name in names if name != "particles")]


def numbers(history):
    """The attributes of a history that are numbers."""
    return {name: value for name, value in history.attributes.items() if isinstance(value, (int, float))}


def measured(history, names, mean, units, long_names):
    """The chosen values of a result; units and descriptions are noted."""
    values = {}
    for name in names:
        if name in history.columns:
            samples = history.columns[name]
            values[name] = samples[-1].item()
            units[name], long_names[name] = history.units[name], history.long_names[name]
            if mean and name != "time":
                values[f"{name}_mean"] = float(moving_mean(history.times, samples, 2 * mean)[-1])
                units[f"{name}_mean"] = history.units[name]
                long_names[f"{name}_mean"] = f"{history.long_names[name]}; mean over the last {mean:g} s"
        elif name in history.attributes:
            values[name] = history.attributes[name]
    return values


def write_csv(path, columns, rows):
    part = path.with_name(path.name + ".part")
    with open(part, "w", newline="") as file:
        table = csv.DictWriter(file, columns, restval="")
        table.writeheader()
        table.writerows(rows)
    os.replace(part, path)


def write_hdf5(path, columns, rows, units, long_names, sweep):
    """/table: one dataset a column, as /history in a result; /input: the sweep and the namelist as they are now."""
    part = path.with_name(path.name + ".part")
    with h5py.File(part, "w") as file:
        for name in columns:
            data = file.create_dataset(f"table/{name}", data=as_array([row.get(name, "") for row in rows]))
            data.attrs["units"] = units.get(name, "1")
            data.attrs["long_name"] = long_names.get(name, name)
        file["input/sweep"] = sweep.path.read_text()
        file["input/namelist"] = sweep.namelist.read_text()
    os.replace(part, path)


def as_array(values):
    """Numbers where all values are numbers or blank, else texts."""
    try:
        return np.array([float(value) if value != "" else np.nan for value in values])
    except ValueError:
        return np.array([str(value) for value in values], dtype=h5py.string_dtype())


def report(sweep, rows):
    """Print how many cases ended how, and which have no result, and why."""
    for row in rows:
        if row["outcome"] != "done":
            print(f"{row['outcome']}: {row['case']}{row['message'] and ': '}{row['message']}")
    count = Counter(row["outcome"] for row in rows)
    ends = ", ".join(f"{count[end]} {end}" for end in ("done", "refused", "failed", "not finished") if count[end])
    print(f"{len(rows)} cases: {ends}; {sweep.output / 'table.csv'}, table.h5")


if __name__ == "__main__":
    run(main)
