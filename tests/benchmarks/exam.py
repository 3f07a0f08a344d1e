"""The field's exam: published numbers and those of hampm side by side, each with an error bar.

    python tests/benchmarks/exam.py [SUITE...] [--write] [--best] [--draw PICTURE]

A folder beside this file is a suite. Its models, *.nml, are as a user writes them: the error is asked, the mesh is chosen. `suite.toml` has the numbers:

    title           what the suite is about
    [[part]]        keys that a part leaves out are those of the file's top, before the first part
        model       name of the namelist; one that ends with 3d.nml is for the program for solids
        source      author, title, page or section of the published numbers
        kind        formula (evaluated here), number (copied), exact (closed form of theory) or derived (by other means, which the source tells)
        accuracy    relative, as stated there; 0 where it is exact; text, such as 'not stated', where there is none: the number then counts as exact
        let         optional: names for numbers and expressions, in order
        cases       optional: name = values, all of one length: one case for each
        set         optional: settings of --set, in which {expression} stands for its value
        at          optional: expression of the time at which columns are taken; the last row without it
        since       optional: expression of an earlier time: columns are then changes since it
        along, point  optional, of fronts of solids: expression of x, y, z of their points, and its value where columns of /front are taken
        quantity, unit
        published   an expression, or a number for each case
        measured    an expression of the columns of the history, or of the front
        others      optional: {name of a program = a number for each case}
        error       optional: expression of the error where no column has one, by finer cells, as the file tells
        case        optional: a text with {expressions} that tells the case
        cause, fault  optional: why rows of this part fail, and what is at fault: 'source' (independent numbers show it), 'model' or 'hampm'
    [[impossible]]  quantity, source, missing: what hampm lacks for it

Errors of columns, NAME_error, become the error of `measured` by its change as each column changes by its error. A row holds if the difference is within
this error and the stated accuracy of the published number together. --write writes docs/evidence/benchmarks.csv and the tables of the page beside it.
--best compares the choice with the best by hand: from the mesh that the program chose for the error that is asked, order, levels, rings and lattice are changed
one by one while the error bar, or the true error, stays and the time falls. In motion it begins with the mesh of the model and changes cells, order, mass matrix
and Courant number; bar and error are the root mean square of all times of the part. benchmarks_best.csv keeps what it found.
HAMPM and HAMPM3D name other programs than those of the release.
"""

import argparse
import csv
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from paths import PROGRAM, ROOT, SOLID_PROGRAM  # noqa: E402

TABLE, PAGE, BEST = ROOT / "docs/evidence/benchmarks.csv", ROOT / "docs/evidence/benchmarks.md", ROOT / "docs/evidence/benchmarks_best.csv"
BEST_COLUMNS = ["suite", "case", "asked", "error", "deviation", "seconds", "best_error", "best_deviation", "best_seconds", "best", "runs"]
FAULTS = {"source": "the source, as independent numbers show", "model": "the model, whose boundaries or material are not those of the source", "hampm": "hampm", "not known": "a cause that is not known"}
KINDS = {"formula", "number", "exact", "derived"}
COLUMNS = ["suite", "quantity", "case", "unit", "published", "accuracy", "kind", "hampm", "error", "deviation_percent", "covers", "verdict", "others",
           "cells", "seconds", "fault", "cause", "source"]
MATHEMATICS = {name: getattr(np, name) for name in ("sqrt", "sin", "cos", "tan", "arctan", "arctan2", "exp", "log", "pi", "radians", "degrees", "interp", "array", "arange",
                                                    "where", "minimum", "maximum", "sinh", "cosh", "tanh", "arccos", "arcsin")} | {"abs": abs, "sum": sum, "max": max, "min": min}
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}


def suites():
    """The names of all suites, in the order of the alphabet."""
    return sorted(path.parent.name for path in HERE.glob("*/suite.toml"))


def read(suite):
    """The file of a suite, with all keys of the top in each part."""
    with open(HERE / suite / "suite.toml", "rb") as file:
        top = tomllib.load(file)
    parts, common = top.pop("part", []), {key: value for key, value in top.items() if key not in ("title", "impossible")}
    return top | {"impossible": top.get("impossible", []), "part": [common | part | {"let": common.get("let", {}) | part.get("let", {})} for part in parts]}


def value(expression, names):
    """The value of an expression; of a number itself. Only files of this folder are read."""
    return eval(expression, {"__builtins__": {}}, names) if isinstance(expression, str) else expression


def filled(text, names):
    return re.sub(r"\{([^{}]+)\}", lambda found: format_number(value(found[1], names)), text)


def format_number(number):
    return number if isinstance(number, str) else f"{number:.10g}"


def cases(part):
    """The names that expressions of each case of a part know, and its place among the cases."""
    given = part.get("cases", {})
    for k in range(len(next(iter(given.values()), [0]))):
        names = MATHEMATICS | {name: values[k] for name, values in given.items()}
        for name, expression in part["let"].items():
            names[name] = value(expression, names)
        yield k, names


def published(part, k, names):
    asked = part["published"]
    return asked[k] if isinstance(asked, list) else value(asked, names)


class Runs:
    """Makes each run once: a run is a model and its settings."""

    def __init__(self, folder):
        self.folder, self.made = folder, {}

    def result(self, suite, part, names, more=()):
        """The path of the result, the processor time of the run [s], and what it said; no path where it failed. `more` settings than those of the part."""
        settings = [filled(setting, names) for setting in part.get("set", [])] + list(more)
        key = suite, part["model"], *settings
        if key not in self.made:
            path = Path(self.folder) / f"{suite}_{len(self.made)}.h5"
            program = SOLID_PROGRAM if part["model"].endswith("3d.nml") else PROGRAM
            words = [word for setting in [*settings, f"output.file={path.name}"] for word in ("--set", setting)]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            done = subprocess.run([program, HERE / suite / part["model"], "--force", "--quiet", "--output", self.folder, *words], text=True,
                                  capture_output=True, env=os.environ | ENVIRONMENT)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            self.made[key] = path if done.returncode in (0, 3) and path.exists() else None, seconds, done.stderr.strip()
        return self.made[key]


def columns(path, part, names):
    """The numbers of a result by the names of their columns: of the time that is asked for, or the last ones; of a front, at the point that is asked for."""
    with h5py.File(path) as file:
        history = {name: column[:] for name, column in file["history"].items()}
        front = {name: column[-1] for name, column in file["front"].items()} if "along" in part else {}
    at = value(part["at"], names) if "at" in part else history["time"][-1]
    found = {name: np.interp(at, history["time"], column) for name, column in history.items()}
    if "since" in part:
        found = {name: found[name] - np.interp(value(part["since"], names), history["time"], column) for name, column in history.items()}
    if front:
        where = value(part["along"], names | front)
        order = np.argsort(where)
        found |= {name: np.interp(value(part["point"], names), where[order], column[order]) for name, column in front.items()}
    return found


def error_name(name):
    """The name of the column with the error of another: K_I_error_tip2 of K_I_tip2."""
    return re.sub(r"(_tip\d+|_front\d+)?$", lambda tip: f"_error{tip[0]}", name, count=1)


def measure(expression, known, names):
    """The value of an expression of columns, and its error by those of the columns; no error where no column has one."""
    middle = value(expression, names | known)
    used = [name for name in known if re.search(rf"\b{name}\b", expression) and error_name(name) in known]
    changes = [value(expression, names | known | {name: known[name] + known[error_name(name)]}) - middle for name in used]
    return float(middle), float(np.sqrt(np.sum(np.square(changes)))) if used else float("nan")


def rows_of(suite, runs):
    """The rows of a suite, one for each number."""
    for part in read(suite)["part"]:
        for k, names in cases(part):
            asked, stated = float(published(part, k, names)), part["accuracy"] if isinstance(part["accuracy"], float) else 0.0
            path, seconds, said = runs.result(suite, part, names)
            measured, error, known = float("nan"), float("nan"), {"cells": 0}
            if path:
                known = columns(path, part, names)
                measured, error = measure(part["measured"], known, names)
                error = value(part["error"], names) if "error" in part and np.isnan(error) else error
            difference, bar = measured - asked, (0.0 if np.isnan(error) else error) + stated*abs(asked)
            case = filled(part.get("case", ""), names)
            holds = bool(abs(difference) <= bar)
            fault, cause = part.get("fault", "not known"), part.get("cause", "not known")
            if not path:
                fault, cause = "hampm", said.splitlines()[0] if said else "the run failed"
            yield {"suite": suite, "quantity": part["quantity"], "case": case, "unit": part["unit"], "published": f"{asked:.6g}", "accuracy": part["accuracy"],
                   "kind": part["kind"], "hampm": f"{measured:.6g}", "error": f"{error:.2g}",
                   "deviation_percent": f"{100*difference/abs(asked):.3g}" if asked else f"{difference:.3g} {part['unit']}", "covers": "yes" if abs(difference) <= error else "no",
                   "verdict": "holds" if holds else "fails", "others": "; ".join(f"{name} {100*(values[k]/asked - 1):+.2f} %" for name, values in
                                                                                 part.get("others", {}).items() if asked and values[k] == values[k]),
                   "cells": int(known["cells"]), "seconds": f"{seconds:.2f}", "fault": "" if holds else fault, "cause": "" if holds else cause, "source": part["source"]}


def read_table(path=TABLE):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(row, name):
    """A number of a row; nan where there is none."""
    try:
        return float(row[name])
    except ValueError:
        return float("nan")


def impossible():
    return [{"suite": suite} | row for suite in suites() for row in read(suite)["impossible"]]


# --- the best choice by hand --------------------------------------------------------------------------------------------------

MASSES = "lumped", "weighted", "tip_weighted", "consistent"
OF_MOTION = {("grid", "lower"), ("grid", "cell"), ("grid", "cells"), ("grid", "order"), ("body(1)", "points_per_cell"), ("refine", "max_level"), ("method", "mass"),
             ("method", "courant")}


def model_text(suite, part):
    return (HERE / suite / part["model"]).read_text(encoding="utf-8")


def asks(suite, part):
    """Whether the model of a part asks for an error."""
    return "&accuracy" in model_text(suite, part)


def chosen(suite, part, names):
    """What the program chose for a part, in motion what its model says: values by `group.key`."""
    program = SOLID_PROGRAM if part["model"].endswith("3d.nml") else PROGRAM
    settings = [word for setting in part.get("set", []) for word in ("--set", filled(setting, names))]
    text = subprocess.run([program, "--explain", HERE / suite / part["model"], *settings], text=True, capture_output=True, env=os.environ | ENVIRONMENT).stdout
    found, group, bodies = {}, "", 0
    for line in text.splitlines():
        if line.startswith("&"):
            group = line[1:].split()[0]
            bodies += group == "body"
        elif match := re.match(r" *(\w+) = (.*?)( +! chosen.*|$)", line):
            key = f"{group}({bodies})" if group == "body" else group, match[1]
            if match[3] if asks(suite, part) else key in OF_MOTION:
                found[key] = match[2].replace(" ", "")
    return found


def coarser(choice, factor):
    """A choice with cells that are larger by a factor; nodes of both lattices meet at the origin."""
    lower, cell, cells = (np.array(choice["grid", key].split(","), float) for key in ("lower", "cell", "cells"))
    new = cell*factor
    start = np.floor(lower/new + 1e-6)*new
    ends = {"lower": start, "cell": new, "cells": np.ceil((lower + cell*cells - start)/new - 1e-6).astype(int)}
    return choice | {("grid", key): ",".join(f"{number:.12g}" for number in numbers) for key, numbers in ends.items()}


def neighbours_in_motion(choice):
    """Choices that differ from one in cells, order, both, levels, mass matrix or Courant number."""
    order, mass, courant = ("grid", "order"), ("method", "mass"), ("method", "courant")
    other = 3 - int(choice[order])
    turned = choice | {order: str(other), ("body(1)", "points_per_cell"): str(other + 1)}
    yield from (coarser(choice, 2), coarser(choice, 1.5), coarser(turned, 2), coarser(turned, 3))
    if int(choice.get(("refine", "max_level"), 0)) > 0:
        yield choice | {("refine", "max_level"): str(int(choice["refine", "max_level"]) - 1)}
    yield from ({key: value for key, value in choice.items() if key != courant} | {mass: f"'{name}'"} for name in MASSES if f"'{name}'" != choice.get(mass))
    if courant in choice:
        yield choice | {courant: f"{float(choice[courant])/2:.4g}"}


def neighbours(choice):
    """Choices that differ from one in the order, the levels, the rings, the lattice, or in lattice and levels together."""
    order, levels, rings = (("grid", "order"), ("refine", "max_level"), ("refine", "rings"))
    if order in choice:
        other = 3 - int(choice[order])
        yield choice | {order: str(other)} | {key: str(other + 1) for key in choice if key[1] == "points_per_cell"}
    for key, least in ((levels, 1), (rings, 2)):
        yield from (choice | {key: str(int(choice[key]) + step)} for step in (-1, 1) if key in choice and int(choice[key]) + step >= least)
    if ("grid", "cells") in choice:
        cell, cells = float(choice["grid", "cell"]), [int(n) for n in choice["grid", "cells"].split(",")]
        for factor, deeper in ((2, 0), (2, 1), (0.5, 0), (0.5, -1)):
            lattice = {("grid", "cell"): repr(cell*factor), ("grid", "cells"): ",".join(str(int(np.ceil(n/factor))) for n in cells)}
            if deeper and levels in choice and int(choice[levels]) + deeper > 0:
                yield choice | lattice | {levels: str(int(choice[levels]) + deeper)}
            elif not deeper:
                yield choice | lattice


def best_of(suite, runs, most=30):
    """The row of a suite, as the program chooses and by hand: of its first case with a right number, in motion of all cases of the run of that; nothing of models at
    rest with a mesh of their own."""
    parts = [part for part in read(suite)["part"] if "since" not in part and (asks(suite, part) or "time = 'static'" not in model_text(suite, part))]
    for part in sorted(parts, key=lambda part: (part["kind"] == "formula", asks(suite, part) or -len(list(cases(part)))))[:1]:
        asking = asks(suite, part)
        all_names = [names for _, names in cases(part)]
        settings_of = [[filled(setting, names) for setting in part.get("set", [])] for names in all_names]
        own = [k for k, settings in enumerate(settings_of) if settings == settings_of[0]][:1 if asking else None]
        names, near = all_names[0], neighbours if asking else neighbours_in_motion
        text = model_text(suite, part)

        def tried(more=()):
            path, seconds, _ = runs.result(suite, part, names, more)
            if not path:
                return None
            numbers = np.array([[*measure(part["measured"], columns(path, part, all_names[k]), all_names[k]), published(part, k, all_names[k])] for k in own], float)
            deviations, errors = numbers[:, 0]/numbers[:, 2] - 1, numbers[:, 1]/np.abs(numbers[:, 2])
            if len(own) > 1:
                deviations, errors = (np.sqrt(np.mean(values**2, keepdims=True)) for values in (deviations, errors))
            return {"error": errors[0], "deviation": deviations[0], "seconds": seconds}

        first, choice, count = tried(), chosen(suite, part, names), 0
        found, by_hand, seen, goes_on = None, choice, set(), bool(first and choice)
        waiting = [choice]
        while waiting and count < most and goes_on:
            trial = waiting.pop(0)
            settings = tuple(f"{group}.{key}={value}" for (group, key), value in sorted(trial.items()))
            if settings in seen:
                continue
            seen.add(settings)
            count += 1
            result = tried(settings)
            if result is None or not (result["error"] <= first["error"] or abs(result["deviation"]) <= abs(first["deviation"]) and result["error"] <= 2*first["error"]):
                continue
            if found is None or result["seconds"] < found["seconds"]:
                found, by_hand, waiting = result, trial, list(near(trial))
        if found:
            told = ("order", "cell", "max_level", "rings") if asking else ("order", "cell", "max_level", "mass", "courant")
            words = ", ".join(f"{key} {by_hand[group, key]}" for group, key in by_hand if key in told and (group, key) != ("method", "order"))
            yield {"suite": suite, "case": filled(part.get("case", ""), names) if len(own) == 1 else f"{part['quantity']}, {len(own)} times",
                   "asked": re.search(r"error = ([\d.e-]+)", text[text.index("&accuracy"):])[1] if asking else "",
                   **{name: f"{first[name]:.2g}" for name in first}, **{f"best_{name}": f"{found[name]:.2g}" for name in found}, "best": words, "runs": count}


# --- the page -----------------------------------------------------------------------------------------------------------------

def table(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|"*len(head), *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def percent(number):
    return "" if np.isnan(number) else f"{number:.2g}"


def relative_error(row):
    """The error bar of hampm in percent of the published number."""
    asked = number(row, "published")
    return 100*number(row, "error")/abs(asked) if asked else float("nan")


def suite_rows(rows):
    for suite in dict.fromkeys(row["suite"] for row in rows):
        own = [row for row in rows if row["suite"] == suite]
        deviations, widths = [abs(number(row, "deviation_percent")) for row in own], [relative_error(row) for row in own]
        yield [f"[{suite}](../../tests/benchmarks/{suite}/suite.toml)", read(suite)["title"], len(own), sum(row["verdict"] == "holds" for row in own),
               percent(np.nanmedian(deviations)), percent(np.nanmax(deviations)), percent(np.nanmedian(widths)) if not np.all(np.isnan(widths)) else "",
               f"{sum(seconds_of(own)):.1f}"]


def seconds_of(rows):
    """The processor times of the runs of these rows: of a run that gave several numbers it counts once."""
    return {(row["suite"], row["seconds"], row["cells"]): number(row, "seconds") for row in rows}.values()


def page_tables(rows):
    """The tables of the page, by the words between which they stand: none has more rows than people read on a page."""
    failing, groups = [row for row in rows if row["verdict"] == "fails"], {}
    for row in failing:
        groups.setdefault((row["suite"], row["quantity"], row["cause"], row["fault"]), []).append(number(row, "deviation_percent"))
    widths, deviations = [relative_error(row) for row in rows], [abs(number(row, "deviation_percent")) for row in rows]
    counts = [("numbers", len(rows)), ("suites", len({row["suite"] for row in rows})),
              ("within the error bar and the stated accuracy of the source together", sum(row["verdict"] == "holds" for row in rows)),
              ("the same of exact and derived numbers alone", "{} of {}".format(*(sum(row["kind"] in ("exact", "derived") and row["verdict"] in verdicts for row in rows)
                                                                                  for verdicts in (("holds",), ("holds", "fails"))))),
              *[(f"failures by {words}", sum(row["fault"] == fault for row in rows)) for fault, words in FAULTS.items()],
              ("within the error bar of hampm alone", sum(row["covers"] == "yes" for row in rows)),
              ("median deviation", f"{percent(np.nanmedian(deviations))} %"), ("median error bar", f"{percent(np.nanmedian(widths))} %"),
              ("processor time of all runs", f"{sum(seconds_of(rows)):.0f} s")]
    failures = [[suite, quantity, len(found), f"{min(found):.2g} to {max(found):.2g}" if len(found) > 1 else f"{found[0]:.2g}", fault, cause]
                for (suite, quantity, cause, fault), found in groups.items()]
    others = [[row["suite"], row["quantity"], row["case"], row["published"], row["deviation_percent"], percent(relative_error(row)), row["others"]] for row in rows if row["others"]]
    return {"sum": table(["", ""], counts),
            **parted("suites", ["suite", "what", "numbers", "hold", "median deviation [%]", "largest [%]", "median error bar [%]", "time [s]"], list(suite_rows(rows))),
            **parted("failures", ["suite", "quantity", "numbers", "deviation [%]", "at fault", "cause"], failures),
            **parted("others", ["suite", "quantity", "case", "published", "hampm [%]", "error bar [%]", "other program"], others),
            **parted("best", ["suite", "case", "error bar, deviation [%]", "time [s]", "by hand [%]", "time [s]", "over"], best_rows()),
            **parted("impossible", ["suite", "quantity", "not possible:"], [[row["suite"], row["quantity"], row["missing"]] for row in impossible()])}


def best_rows():
    percents = lambda row, *names: ", ".join(f"{100*float(row[name]):.2g}" for name in names)  # noqa: E731
    return [[row["suite"], row["case"], percents(row, "error", "deviation"), row["seconds"], percents(row, "best_error", "best_deviation"),
             row["best_seconds"], f"{float(row['seconds'])/float(row['best_seconds']):.1f}"] for row in (read_table(BEST) if BEST.exists() else [])]


def parted(name, head, rows):
    """A table in up to two parts of twenty rows, by `name 1` and `name 2`."""
    return {f"{name} {k + 1}": table(head, rows[20*k:20*(k + 1)]) if rows[20*k:20*(k + 1)] else "" for k in range(2)}


def write_table(path, names, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def write(rows):
    write_table(TABLE, COLUMNS, rows)
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8"), read_table()), encoding="utf-8")


def renewed(page, rows):
    """The page with the tables of these rows."""
    for name, text in page_tables(rows).items():
        page = re.sub(rf"(<!-- {name} -->\n).*?(\n?<!-- end of {name} -->)", lambda found: f"{found[1]}{text}\n<!-- end of {name} -->" if text
                      else f"{found[1]}<!-- end of {name} -->", page, flags=re.DOTALL)
    return page


# --- the picture --------------------------------------------------------------------------------------------------------------

def draw(rows, picture):
    """All deviations in percent over the suites: points and bars of hampm, grey bars of the stated accuracy, crosses of other programs."""
    sys.path.insert(0, str(ROOT / "postprocess"))
    from pictures import COLOURS, STYLE, plt, save
    names = list(dict.fromkeys(row["suite"] for row in rows))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(9.0, 0.34*len(names) + 1.1), layout="constrained")
        for k, suite in enumerate(names):
            own = [row for row in rows if row["suite"] == suite and number(row, "published")]
            for place, row in zip(k + np.linspace(-0.36, 0.36, len(own)) if len(own) > 1 else [k], own):
                bar, deviation, fails = number(row, "accuracy"), number(row, "deviation_percent"), row["verdict"] == "fails"
                if bar == bar and bar > 0:
                    axes.plot([-100*bar, 100*bar], [place, place], color="0.8", linewidth=3.0, zorder=1, solid_capstyle="butt")
                axes.errorbar(deviation, place, xerr=relative_error(row), color=COLOURS[1 if fails else 0], marker="s" if fails else "o", markersize=2.6,
                              elinewidth=0.8, zorder=3)
                for other in re.findall(r"([+-][\d.]+) %", row["others"]):
                    axes.plot(float(other), place, marker="x", markersize=4, color="0.1", zorder=2)
            axes.axhline(k + 0.5, color="0.92", linewidth=0.6)
        axes.set_xscale("symlog", linthresh=0.1, linscale=0.6)
        axes.set(yticks=range(len(names)), yticklabels=[name.replace("_", " ") for name in names], ylim=(len(names) - 0.5, -0.5), xlim=(-60, 120),
                 xlabel="deviation from the published number [%]",
                 xticks=[-30, -10, -3, -1, -0.3, -0.1, 0, 0.1, 0.3, 1, 3, 10, 30])
        axes.xaxis.set_major_formatter("{x:g}")
        axes.axvline(0, color="0.3", linewidth=0.8)
        save(figure, picture, 110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suites", nargs="*", metavar="SUITE", help="suites to run, all by default")
    parser.add_argument("--write", action="store_true", help="write the CSV file and the tables of the page")
    parser.add_argument("--page", action="store_true", help="run nothing: write the tables of the page from the CSV file")
    parser.add_argument("--best", action="store_true", help="compare the choice of the program with the best by hand, and write both")
    parser.add_argument("--draw", metavar="PICTURE", help="run nothing: draw the CSV file")
    arguments = parser.parse_args()
    if arguments.draw:
        return draw(read_table(), arguments.draw)
    if arguments.page:
        return PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8"), read_table()), encoding="utf-8")
    if arguments.best:
        found = {row["suite"]: row for row in (read_table(BEST) if BEST.exists() else [])}
        for suite in arguments.suites or suites():
            with tempfile.TemporaryDirectory() as folder:
                for row in best_of(suite, Runs(folder)):
                    found[suite] = row
                    print(*row.values(), sep="  ", flush=True)
            write_table(BEST, BEST_COLUMNS, [found[name] for name in sorted(found)])
        return PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8"), read_table()), encoding="utf-8")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for suite in arguments.suites or suites():
            for row in rows_of(suite, Runs(folder)):
                rows.append(row)
                print(*(row[name] for name in ("suite", "quantity", "case", "published", "hampm", "error", "deviation_percent", "verdict", "seconds", "cause")), sep="  ",
                      flush=True)
    if arguments.write:
        if arguments.suites:
            old = [row for row in read_table() if row["suite"] not in arguments.suites] if TABLE.exists() else []
            rows = sorted(old + rows, key=lambda row: row["suite"])
        write(rows)
    print(f"{len(rows)} numbers, {sum(row['verdict'] == 'holds' for row in rows)} hold, {sum(seconds_of(rows)):.0f} s")


if __name__ == "__main__":
    main()
