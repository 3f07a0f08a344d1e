"""The program's numbers against theory and reference solutions, one folder a case.

`case.nml` is the scene. `expected.toml` holds

    [runs]      optional: name = [what --set overrides]; one run of the scene as it is where it is missing
    [let]       optional: names for numbers and expressions, in order
    verify      optional: patterns of the names of runs that take long, which `make verify` makes
    warning     optional: a regular expression that the standard error must match; nothing may be there without it
    [[expect]]  what      the quantity, in words
                measured  an expression
                asked     a number or an expression
                rtol      of `asked`, and/or; a number or an expression
                atol      absolute; a number or an expression
                source    where `asked` and the tolerance come from
                runs      optional: only the runs whose names match this pattern (* and ? as in a shell)

Expressions know the columns of the history and the attributes of /history by their names, numpy as `np`, the name of
the run as `run`, and the functions that `Run` lists. Every run is made once. `pytest -s tests/regression` prints all numbers.
"""

import functools
import re
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest

from history import History, first_frequency, lowpass, moving_mean, read_curve
from paths import REFERENCE
from snapshots import field, points, read_steps

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

CASES = sorted(path.parent for path in Path(__file__).parent.glob("*/case.nml"))


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


class Run:
    """One run of a case and what its expressions may use."""

    def __init__(self, run_hampm, folder, case, name, expected):
        self.folder = case
        overrides = [word for item in expected.get("runs", {}).get(name, []) for word in ("--set", item)]
        self.process = run_hampm(case / "case.nml", "--quiet", "--threads", 1, "--set", "output.file=result.h5",
                                 *overrides, cwd=folder)
        self.path = folder / "result.h5"
        self.history = History(self.path)
        self.names = {"np": np, "rms": rms, "lowpass": lowpass, "moving_mean": moving_mean,
                      "first_frequency": first_frequency, "reference": self.reference, "energy_error": self.energy_error,
                      "snapshot": self.snapshot, "run": name,
                      **self.history.attributes, **self.history.columns}
        for key, value in expected.get("let", {}).items():
            self.names[key] = self.value(value)

    def value(self, expression):
        """The value of an expression, or a number as it is."""
        return eval(expression, dict(self.names)) if isinstance(expression, str) else expression

    def reference(self, file, column):
        """A column of a file of reference values over time, of the case or of all, at the times of the history."""
        path = self.folder / file if (self.folder / file).exists() else REFERENCE / file
        return np.interp(self.history.times, *read_curve(path, column))

    def energy_error(self):
        """Largest error of the energy balance of all samples over the largest energy that was brought in."""
        c = self.history.columns
        stored = c["kinetic_energy"] + c["strain_energy"]
        brought_in = c["external_work"] + stored[0]
        return np.max(np.abs(stored + c["damping_loss"] + c["numerical_loss"] - brought_in)) / np.max(np.abs(brought_in))

    @functools.cached_property
    def snapshots(self):
        return [step[0] for step in read_steps(self.path)[1]]

    def snapshot(self, name, step=-1, body=None):
        """A field of the particles of all bodies or of one, in the order of their numbers; `position` is one."""
        data = self.snapshots[step]
        values = points(data) if name == "position" else field(data.point_data, name)
        order = np.argsort(field(data.point_data, "id"))
        if body is not None:
            order = order[field(data.point_data, "body")[order] == body]
        return values[order]


@functools.cache
def expected_of(case):
    return tomllib.loads((case / "expected.toml").read_text())


def runs_of(case):
    return list(expected_of(case).get("runs", {"": []}))


@pytest.fixture(scope="session")
def run_of(run_hampm, tmp_path_factory):
    """`run_of(case, name)`: that run, made once."""
    return functools.cache(lambda case, name: Run(run_hampm, tmp_path_factory.mktemp("run"), case, name, expected_of(case)))


def marks_of(case, name):
    """Tests of one run stay together; those of a long one are left to `make verify`."""
    together = pytest.mark.xdist_group(f"{case.name} {name}")
    takes_long = any(fnmatchcase(name, pattern) for pattern in expected_of(case).get("verify", []))
    return [together, pytest.mark.verify] if takes_long else [together]


def parameters(items):
    """Test parameters from tuples that begin with case and run; the ids are made of their words."""
    return [pytest.param(*item, id="-".join([item[0].name, *filter(None, [item[1]]), *words]), marks=marks_of(*item[:2]))
            for *item, words in items]


@pytest.mark.parametrize(("case", "name"), parameters((case, name, []) for case in CASES for name in runs_of(case)))
def test_run_ends_well(run_of, case, name):
    process, warning = run_of(case, name).process, expected_of(case).get("warning", "^$")
    assert process.returncode == 0
    assert process.stdout == ""
    assert re.search(warning, process.stderr), process.stderr


@pytest.mark.parametrize(("case", "name", "expectation"), parameters(
    (case, name, expectation, [expectation["what"]]) for case in CASES for name in runs_of(case)
    for expectation in expected_of(case)["expect"] if fnmatchcase(name, expectation.get("runs", "*"))))
def test_value(run_of, case, name, expectation, record_property):
    run = run_of(case, name)
    measured, asked = run.value(expectation["measured"]), run.value(expectation["asked"])
    tolerance = run.value(expectation.get("atol", 0.0)) + run.value(expectation.get("rtol", 0.0)) * abs(asked)
    report = (f"{case.name} {name}: {expectation['what']}: asked {asked:.6g} +- {tolerance:.2g}, "
              f"measured {measured:.6g} ({expectation['source']})")
    print(f"\n{report}", end=" ")
    for key, value in {"run": f"{case.name} {name}", "what": expectation["what"], "asked": f"{asked:.6g}",
                       "tolerance": f"{tolerance:.2g}", "measured": f"{measured:.6g}", "source": expectation["source"]}.items():
        record_property(key, value)
    assert abs(measured - asked) <= tolerance, report
