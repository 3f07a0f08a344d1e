"""Sweeps run by Snakemake: on this machine, with what goes wrong there, and by command lines as on a cluster."""

import csv
import os
import re
import signal
import subprocess
import sys
from collections import Counter

import h5py
import numpy as np
import pytest

pytest.importorskip("snakemake")

from hampm.batch.declaration import read_sweep
from paths import BATCH, PROGRAM
from scene import HEAD, MASS, SLOW, runs_of, wait_for, write_sweep

PRODUCT = """\
columns: [kinetic_energy, time]
mean: 5e-4
memory: 100
checkpoint: 0.1
product:
  body.velocity: [[5, 0], [10, 0], [20, 0], [30, 0], [0, 5], [0, 10], [0, 20], [0, 30]]
  method.scheme: [usf, usavg, musl]
  method.mass: [lumped, consistent]
"""
FAILING = {
    "{body.velocity: [30000, 0]}": ("failed", "Likely cause: the run is unstable, or a body is too fast"),
    "{load.force: [-1e12, 0]}": ("failed", "Likely cause: the run is unstable"),
    "{body.velocity: [100, 0], run.end_time: 0.2}": ("failed", "left the grid"),
    "{material.young: -1}": ("refused", "must be in (0, inf) [Pa]"),
    "{method.scheme: mulse}": ("refused", "did you mean 'musl'?"),
    "{grid.cells: [2, 2]}": ("refused", "must be within the grid"),
}
CASES = "cases:\n" + "".join(f"- {settings}\n" for settings in FAILING)


def snakemake(path, *options, cores):
    """The command that runs a sweep."""
    return [sys.executable, "-m", "snakemake", "-s", BATCH / "Snakefile", "--cores", str(cores), *options,
            "--config", f"sweep={path}", f"program={PROGRAM}"]


def start(path, *options, cores=2, **environment):
    """Snakemake begins a sweep, from its folder and by a relative path."""
    return subprocess.Popen(snakemake(path.name, *options, cores=cores), cwd=path.parent, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env=os.environ | environment)


def finish(process):
    """Exit code, the lines that tell how cases ended, now and before, and the messages."""
    out, messages = process.communicate(timeout=300)
    return process.returncode, [line for line in out.splitlines() if re.match(r"\[\d+/\d+|\w+ before: |These|\d+ cases: [^;]*$", line)], messages


def run_cases(sweep):
    """Run the cases of a sweep without Snakemake."""
    for name, settings in sweep.cases.items():
        words = [f"{key}={value}" for key, value in settings.items()]
        subprocess.run([sys.executable, BATCH / "run_case.py", sweep.folder(name), sweep.namelist, "--program", PROGRAM, "--set",
                        *words], check=True, stdout=subprocess.DEVNULL)


def table(path):
    with open(read_sweep(path).output / "table.csv", newline="") as file:
        return list(csv.DictReader(file))


def times(sweep, names):
    return {name: (sweep.folder(name) / "outcome.json").stat().st_mtime_ns for name in names}


def test_a_sweep_with_failures_and_kills(tmp_path):
    path = write_sweep(tmp_path, HEAD + PRODUCT + CASES)
    before = read_sweep(path)
    assert len(before.cases) == 54

    # Snakemake is killed: what it has started comes to its end without it
    process = start(path)
    wait_for(lambda: len(list(before.output.glob("cases/*/ended-*"))) >= 20)
    process.kill()
    process.communicate(timeout=60)
    wait_for(lambda: not runs_of(before.output, PROGRAM))
    first = times(before, [folder.parent.name for folder in before.output.glob("cases/*/outcome.json")])
    assert 20 <= len(first) < 54

    # A case is added, and killed; the others go on
    path.write_text(path.read_text() + "- {" + ", ".join(f"{k}: '{v}'" for k, v in SLOW.items()) + "}\n")
    sweep = read_sweep(path)
    slow, = set(sweep.cases) - set(before.cases)
    process = start(path)
    wait_for((sweep.folder(slow) / f"{slow}.h5.checkpoint").exists)
    for run in runs_of(sweep.folder(slow), PROGRAM):
        os.kill(run, signal.SIGKILL)
    code, _, messages = finish(process)
    assert code == 1 and f"not finished: {slow}: ended by SIGKILL" in messages
    ends = {row["case"]: row["outcome"] for row in table(path)}
    assert Counter(ends.values()) == {"done": 48, "refused": 3, "failed": 3, "not finished": 1} and ends[slow] == "not finished"
    second = times(sweep, before.cases)
    assert first.items() <= second.items()

    # Only that one is run again; cases that are refused are an error of the sweep at its end
    code, lines, messages = finish(start(path))
    assert code == 1 and "3 of 55 cases are refused: mend or remove them" in messages, messages
    told = [re.match(r"(?:refused|failed) before: (?:(\d+) cases: )?", line) for line in lines]     # those that ended in the same words share a line
    assert sum(int(found[1] or 1) for found in told if found) == 6
    assert lines[-3:] == [f"These are not run again, unless they are forgotten: batch/forget.py {path}",
                          "55 cases: 48 done, 3 refused, 3 failed, 1 to run", f"[55/55] done: {slow}"]
    assert times(sweep, before.cases) == second
    assert_table(path, sweep, slow)
    code, lines, messages = finish(start(path))
    assert code == 1 and "3 of 55 cases are refused: mend or remove them" in messages, messages
    assert lines[-1] == "55 cases: 49 done, 3 refused, 3 failed"
    assert times(sweep, before.cases) == second


def assert_table(path, sweep, slow):
    """One row a case: energies of free flight, the failures' messages, and how often the killed case was started."""
    rows = {row["case"]: row for row in table(path)}
    assert list(rows) == list(sweep.cases)
    assert rows[slow]["starts"] == "2" and float(rows[slow]["time"]) == float(SLOW["run.end_time"])
    done = [row for name, row in rows.items() if row["outcome"] == "done" and name != slow]
    assert len(done) == 48
    for row in done:
        energy = MASS * max(map(float, row["body.velocity"].split(","))) ** 2 / 2
        assert float(row["kinetic_energy"]) == pytest.approx(energy) == pytest.approx(float(row["kinetic_energy_mean"]))
    failures = [row for row in rows.values() if row["outcome"] in ("refused", "failed")]
    for row, (end, message) in zip(failures, FAILING.values(), strict=True):
        assert row["outcome"] == end and message in row["message"] and row["kinetic_energy"] == ""
    with h5py.File(sweep.output / "table.h5") as file:
        energies = file["table/kinetic_energy"]
        assert file["table/body.velocity"].attrs["units"] == "m/s" and file["table/run.end_time"].attrs["units"] == "s"
        assert energies.shape == (55,) and energies.attrs["units"] == "J" and np.isnan(energies[:]).sum() == 6
        assert file["table/outcome"].asstr()[:].tolist() == [row["outcome"] for row in rows.values()]


@pytest.mark.verify
@pytest.mark.parametrize("name", ["plain", "with: a blank"])
def test_cases_in_groups_as_on_a_cluster(tmp_path, name):
    """By an executor that takes the place of Slurm's; the rest is what the profile for Slurm says. Where paths are plain, without run_sweep.py too."""
    tmp_path = tmp_path / name
    tmp_path.mkdir()
    path = write_sweep(tmp_path, HEAD + "product: {body.velocity: [[10, 0], [20, 0], [30, 0]], method.mass: [lumped, consisten]}\n"
                       "memory: 100\nruntime: 7\nthreads: 2")
    plugin, options = {"PYTHONPATH": str(BATCH.parent / "tests/batch/plugins")}, ("--executor", "standin", "--seconds-between-status-checks", "1")
    if name == "plain":
        process = start(path, "--profile", BATCH / "profiles/slurm", *options, cores=4, **plugin)
    else:
        process = subprocess.Popen([sys.executable, BATCH / "run_sweep.py", path.name, "--program", PROGRAM, "--profile", "slurm", "--cores", "4", "--", *options],
                                   cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | plugin)
    code, _, messages = finish(process)
    assert code == 1 and "3 of 6 cases are refused" in messages, messages
    assert Counter(row["outcome"] for row in table(path)) == {"done": 3, "refused": 3}
    # The six after one another: cores and memory of one, time of all
    assert (tmp_path / "submitted.txt").read_text().split() == ["6", "2", "100", "42"]


def test_a_mistake_ends_before_any_case_is_run(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {grid.cel: [1]}")
    code, _, messages = finish(start(path))
    assert code == 1 and f"{path}:3: 'grid.cel': &grid has no key 'cel'; did you mean 'cell'?" in messages
    assert "Traceback" not in messages and not (tmp_path / "out").exists()


def test_all_cases_are_checked_before_the_first_is_run(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {body.velocity: [[10, 0]], method.mass: [consisten, lumped]}")
    out, messages = (process := start(path, cores=1)).communicate(timeout=300)
    first, bad = out.splitlines()[0], next(iter(read_sweep(path).cases))
    assert first.startswith(f"will be refused: {bad}: ") and "did you mean 'consistent'?" in first
    assert "1 of 2 cases will be refused; the others are run, and the exit code is 1" in out
    assert process.returncode == 1 and Counter(row["outcome"] for row in table(path)) == {"done": 1, "refused": 1}


def run_sweep(folder, *words):
    """batch/run_sweep.py as a user calls it."""
    return subprocess.run([sys.executable, BATCH / "run_sweep.py", *words, "--program", PROGRAM, "--cores", "2"], cwd=folder, capture_output=True, text=True, timeout=120)


def test_paths_with_blanks(tmp_path):
    """And with what YAML takes for something else, of the sweep, the model and the results; results are named by their cases."""
    folder = tmp_path / "my sweeps: a, 'b' #2"
    folder.mkdir()
    path = write_sweep(folder, "namelist: flight.nml\noutput: out of it\nproduct: {body.velocity: [[10, 0], [20, 0]]}\ncolumns: [kinetic_energy]")
    result = run_sweep(tmp_path, path.relative_to(tmp_path))
    assert result.returncode == 0, result.stderr
    rows = table(path)
    assert [float(row["kinetic_energy"]) for row in rows] == pytest.approx([MASS * v**2 / 2 for v in (10, 20)])
    assert all((folder / "out of it/cases" / row["case"] / f"{row['case']}.h5").exists() for row in rows)


def test_where_cases_are_refused_or_fail_is_an_error_when_asked_for(tmp_path):
    """Failures are rows of a table; with --strict they are an error of the sweep, and nothing is run where a case would be refused."""
    path = write_sweep(tmp_path, HEAD + "cases:\n- {body.velocity: [10, 0]}\n- {body.velocity: [30000, 0]}\n- {body.velocity: [30001, 0]}\n")
    assert run_sweep(tmp_path, path, "--check").returncode == 2    # no such option
    loose = run_sweep(tmp_path, path)
    assert loose.returncode == 0
    sweep = read_sweep(path)
    fast, faster = list(sweep.cases)[1:]
    assert "failed: 2 cases: " in loose.stdout and loose.stdout.rstrip().splitlines()[-3:-1] == [f"  {fast}", f"  {faster}"]
    assert "(exit code 3)\n" in loose.stdout
    strict = run_sweep(tmp_path, path, "--strict")
    assert strict.returncode == 1 and "2 of 3 cases have failed" in strict.stderr
    collected = subprocess.run([sys.executable, BATCH / "collect.py", path, "--strict"], capture_output=True, text=True)
    assert collected.returncode == 1
    path.write_text(path.read_text().replace("output: out", "output: other") + "- {method.mass: consisten}\n- {method.mass: consistan}\n")
    strict = run_sweep(tmp_path, path, "--strict")
    assert strict.returncode == 1 and "2 of 5 cases will be refused; none is run, and the exit code is 1" in strict.stdout
    assert strict.stdout.count("(exit code 2)") == 2 and not (tmp_path / "other/cases").exists()
    assert run_sweep(tmp_path, path).returncode == 1


def test_derived_columns_are_in_the_table(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {$v: [10, 20]}\nset: {body.velocity: ['${v}', 0]}\ncolumns: [kinetic_energy]\nderived:\n"
                       f"  speed: ${{sqrt(2 * kinetic_energy / {MASS})}}\n  part: ${{speed / v}}\n  half: first time time > ${{run.end_time / 2}}\n  whole: max time\n")
    sweep = read_sweep(path)
    run_cases(sweep)
    result = subprocess.run([sys.executable, BATCH / "collect.py", path], capture_output=True, text=True)
    rows = table(path)
    assert [float(row["part"]) for row in rows] == pytest.approx([1, 1]) and [float(row["whole"]) for row in rows] == [1e-3, 1e-3]
    assert [row["$v"] for row in rows] == ["10", "20"] and [row["half"] for row in rows] == ["", ""]
    assert result.stdout.count("derived: half: ") == 2 and "there is no run.end_time" in result.stdout   # the sweep does not set it
    with h5py.File(sweep.output / "table.h5") as file:
        assert file["table/whole"].attrs["units"] == "s" and file["table/speed"].attrs["long_name"].startswith("${sqrt")
        assert list(file["table/$v"][:]) == [10, 20]


def test_failures_are_forgotten_when_asked_for(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {body.velocity: [[10, 0]], method.mass: [lumped, consisten]}")
    sweep = read_sweep(path)
    run_cases(sweep)
    good, bad = sweep.cases
    result = subprocess.run([sys.executable, BATCH / "forget.py", path], capture_output=True, text=True)
    assert result.stdout.split() == [bad] and sweep.folder(good).exists() and not sweep.folder(bad).exists()
    result = subprocess.run([sys.executable, BATCH / "collect.py", path], capture_output=True, text=True)
    assert result.stdout.startswith(f"not finished: {bad}\n2 cases: 1 done, 1 not finished; ")


def test_a_column_that_no_result_has_is_named(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {body.velocity: [[10, 0]]}\ncolumns: [K_I, kinetic_energy]")
    sweep = read_sweep(path)
    run_cases(sweep)
    result = subprocess.run([sys.executable, BATCH / "collect.py", path], capture_output=True, text=True)
    assert f"{path}: columns: no result has 'K_I'; they have " in result.stdout
    assert float(table(path)[0]["kinetic_energy"]) == pytest.approx(MASS * 10**2 / 2)
    (sweep.folder(*sweep.cases) / f"{next(iter(sweep.cases))}.h5").unlink()
    result = subprocess.run([sys.executable, BATCH / "collect.py", path], capture_output=True, text=True)
    assert f"{next(iter(sweep.cases))}.h5: no such file\n1 cases: 1 done; " in result.stdout
