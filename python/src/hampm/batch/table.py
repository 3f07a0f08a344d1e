"""One table of all cases of a sweep, table.csv and table.h5 in its folder, and what is said of those that have no result.

A case is a row: its name, its own names and settings, its outcome (done; refused: a mistake in the scene; failed: in the computation; not
finished), what hampm said, processor time, wall time and peak memory of its runs, and of those that are done the number of
particles and the columns that the sweep asks for: the last value of each, and its mean over the time `mean` at the end as
NAME_mean, and the columns that are derived. An attribute of the history, such as G_ref, is a column too. What a case does not have is blank, in table.h5 not a
number.
"""

import csv
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import ResultError
from ..history import History
from ..signals import moving_mean
from .case import NOTHING_SPENT, OUTCOMES, result_of
from .declaration import Declaration
from .derived import derive

Row = dict[str, Any]
About = dict[str, tuple[str, str]]   # column -> unit, description

COUNTS = "time", "step", "particles"  # of which there are no means
OWN = {"case": ("1", "name of the case"), "outcome": ("1", "how it ended"), "message": ("1", "what hampm said"),
       "starts": ("1", "number of times that it was started"), "cpu_seconds": ("s", "processor time of its runs"),
       "wall_seconds": ("s", "wall time of its runs"), "peak_megabytes": ("MB", "peak memory of its runs")}
ATTRIBUTES = {"G_ref": ("J/m2", "reference value of G"), "G_beam_on_foundation": ("J/m2", "G of the beam on an elastic foundation"),
              "distance_to_equilibrium": ("1", "how far the last values are from those at rest, relative to these")}


def collect(sweep: Declaration) -> tuple[list[Row], About]:
    """Write the table of a sweep as it is now. Returns its rows, and unit and description of each column of the results."""
    sweep.adopt()
    about: About = {}
    rows = [row | measured(sweep, row, about) if row["outcome"] == "done" else row for row in (begun(sweep, name) for name in sweep.cases)]
    settings = {key: (sweep.units.get(key, "1"), key) for key in sweep.keys}
    sweep.output.mkdir(parents=True, exist_ok=True)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    write_csv(sweep.output / "table.csv", columns, rows)
    write_hdf5(sweep.output / "table.h5", columns, rows, OWN | settings | about, sweep)
    return rows, about


def begun(sweep: Declaration, name: str) -> Row:
    """The row of a case without what it has computed."""
    values, record = sweep.values(name), sweep.record(name)
    end = {"outcome": record.get("outcome", "not finished"), "message": record["message"] if "outcome" in record else ""}
    return {"case": name} | {key: values.get(key, "") for key in sweep.keys} | end | (record.get("spent") or NOTHING_SPENT)


def measured(sweep: Declaration, row: Row, about: About) -> Row:
    """What the table has of the result of a row; units and descriptions of all that it has go into `about`."""
    try:
        history = History(result_of(sweep.folder(row["case"])))
    except ResultError as error:
        print(error)
        return {}
    last = {column: samples[-1].item() for column, samples in history.columns.items()}
    last |= {key: value for key, value in history.attributes.items() if isinstance(value, (int, float))}
    about |= {column: (history.units[column], history.long_names[column]) if column in history.columns
              else ATTRIBUTES.get(column, ("1", column)) for column in last}
    values: Row = {"particles": last["particles"]}
    for column in (column for pattern in sweep.columns for column in last if fnmatchcase(column, pattern)):
        values[column] = last[column]
        if sweep.mean and column in history.columns and column not in COUNTS:
            mean = f"{column}_mean"
            values[mean] = float(moving_mean(history.times, history.columns[column], 2 * sweep.mean)[-1])
            about[mean] = history.units[column], f"{history.long_names[column]}; mean over the last {sweep.mean:g} s"
    known = row | last
    for column, text in sweep.derived.items():
        try:
            values[column], unit = derive(text, history, known)
        except ResultError as error:
            values[column], unit = "", "1"
            print(f"{sweep.path}: derived: {column}: {row['case']}: {error}")
        known[column] = values[column]
        about[column] = unit, text
    return values


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Row]) -> None:
    """The table as text with commas."""
    part = path.with_name(path.name + ".part")
    with open(part, "w", newline="") as file:
        table = csv.DictWriter(file, columns, restval="")
        table.writeheader()
        table.writerows(rows)
    os.replace(part, path)


def write_hdf5(path: Path, columns: Sequence[str], rows: Sequence[Row], about: About, sweep: Declaration) -> None:
    """/table: one dataset a column, as /history in a result; /input: the sweep and the namelist as they are now."""
    part = path.with_name(path.name + ".part")
    with h5py.File(part, "w") as file:
        for name in columns:
            data = file.create_dataset(f"table/{name}", data=as_array([row.get(name, "") for row in rows]))
            data.attrs["units"], data.attrs["long_name"] = about.get(name, ("1", name))
        file["input/sweep"] = sweep.path.read_text()
        file["input/namelist"] = sweep.namelist.read_text()
    os.replace(part, path)


def as_array(values: Sequence[Any]) -> np.ndarray[Any, Any]:
    """Numbers where all values are numbers or blank, else texts."""
    try:
        return np.array([float(value) if value != "" else np.nan for value in values])
    except ValueError:
        return np.array([str(value) for value in values], dtype=h5py.string_dtype())


def by_reason(what: str, reasons: Mapping[str, str]) -> Iterator[str]:
    """Lines that list cases, given as name -> reason, by the reason that hampm gave, whatever the numbers in it; the first stands for all."""
    alike: dict[str, list[str]] = {}
    for name, reason in reasons.items():
        alike.setdefault(re.sub(r"[-+]?\d[\d.]*([eE][-+]?\d+)?", "#", reason), []).append(name)
    codes = {outcome: f" (exit code {code})" for code, outcome in OUTCOMES.items()}
    for names in alike.values():
        reason = reasons[names[0]]
        which = names[0] if len(names) == 1 else f"{len(names)} cases"
        yield f"{what}: {which}{reason and ': '}{reason}{codes.get(what.replace('will be ', '').replace(' before', ''), '')}"
        yield from (f"  {name}" for name in names if len(names) > 1)


def count_of(ends: Mapping[str, int]) -> str:
    """How many cases ended how."""
    return ", ".join(f"{ends[end]} {end}" for end in ("done", "refused", "failed", "not finished") if ends[end])


def report(sweep: Declaration, rows: Sequence[Row], about: About, brief: bool = False) -> None:
    """Print how many cases ended how, which columns no result has, and unless it is to be brief which have no result, and why."""
    for pattern in sweep.columns:
        if about and not any(fnmatchcase(name, pattern) for name in about):
            print(f"{sweep.path}: columns: no result has '{pattern}'; they have {', '.join(about)}")
    if not brief:
        for outcome in ("refused", "failed", "not finished"):
            for line in by_reason(outcome, {row["case"]: row["message"] for row in rows if row["outcome"] == outcome}):
                print(line)
    print(f"{len(rows)} cases: {count_of(Counter(row['outcome'] for row in rows))}; {sweep.output / 'table.csv'}, table.h5")
