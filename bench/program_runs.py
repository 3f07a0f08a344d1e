"""Runs of the program, as measuring scripts need them: each one process, with its end, time, memory and result."""

import os
import statistics
import subprocess
import sys
from functools import cached_property
from pathlib import Path

import h5py


class Unstable(Exception):
    """A run has ended with exit code 3, or a time step that is unstable with every scheme was refused."""


class Run:
    """What has come of a run; several turns of it have the median of their times."""

    def __init__(self, code, message, seconds, memory, path):
        self.code, self.message, self.path = code, message, path
        self.seconds = seconds    # of the processor, user and system
        self.memory = memory      # the most that it held [MiB], if that is more than what this process has held

    @cached_property
    def columns(self):
        """All values of the columns of the history."""
        with h5py.File(self.path) as file:
            return {name: column[()] for name, column in file["history"].items()}

    @cached_property
    def attributes(self):
        """Attributes of the history, as G_ref."""
        with h5py.File(self.path) as file:
            return dict(file["history"].attrs)

    @property
    def last(self):
        """The last value of each column."""
        return {name: column[-1] for name, column in self.columns.items()}


class Program:
    """A program that runs models in a folder."""

    def __init__(self, path, folder):
        self.path, self.folder = Path(path).resolve(), Path(folder).resolve()

    def __call__(self, source, settings=(), words=(), forced=None, threads=1, turns=1, codes=(0,)):
        """Run a model, a text or the path of a namelist, with what --set overrides, as `key=value` or a dictionary, and with the courant number
        `forced` whatever the limit. Ends this process where the exit code is none of `codes`."""
        if isinstance(source, str):
            (self.folder / "run.nml").write_text(source)
            source = self.folder / "run.nml"
        if isinstance(settings, dict):
            settings = [f"{key}={value}" for key, value in settings.items()]
        begin = [self.path] if forced is None else [self.path.with_name("forced_step"), repr(float(forced))]
        command = [*begin, source, "--output", self.folder, "--quiet", "--force", *(["--threads", threads] if threads else []), *words,
                   *(word for setting in (*settings, "output.file=run.h5") for word in ("--set", setting))]
        return self._run(command, turns, codes)

    def resume(self, words=(), codes=(0,)):
        """Go on with the run that was stopped."""
        return self._run([self.path, "--resume", self.folder / "run.h5.checkpoint", "--quiet", *words], 1, codes)

    def _run(self, command, turns, codes):
        ends = [self._end(list(map(str, command))) for _ in range(turns)]
        code, message, _, memory = ends[-1]
        if code not in codes and (code == 3 or "is unstable in plane" in message):
            raise Unstable(message)
        if code not in codes:
            sys.exit(f"{' '.join(map(str, command))}\nhas ended with {code}: {message}")
        return Run(code, message, statistics.median(end[2] for end in ends), memory, self.folder / "run.h5")

    def _end(self, command):
        """Exit code, message, time and memory of a process."""
        log = self.folder / "log"
        actions = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0), (os.POSIX_SPAWN_OPEN, 2, str(log), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)]
        process = os.posix_spawn(command[0], command, os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}, file_actions=actions)
        _, status, usage = os.wait4(process, 0)
        return os.waitstatus_to_exitcode(status), log.read_text(errors="replace"), usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def run_scene(program, folder, text, options=(), name="case"):
    """Run a scene: its history, and the fields of the particles in its last snapshot."""
    (folder / f"{name}.nml").write_text(text)
    words = [word for option in options for word in ("--set", option)]
    result = subprocess.run([program, f"{name}.nml", "--force", "--quiet", *words], cwd=folder, capture_output=True, text=True)
    if result.returncode:
        raise RuntimeError(result.stderr)
    with h5py.File(folder / f"{name}.h5") as file:
        history = {column: values[:] for column, values in file["history"].items()}
        particles = file["VTKHDF/particles"]
        n = particles["NumberOfPoints"][-1]
        fields = {column: values[-n:].squeeze() for column, values in particles["PointData"].items()}
        fields["place"] = particles["Points"][-n:, :2]
    return history, fields
