"""Runs of the program."""

import os
import pty
import re
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .errors import HampmWarning, Message, ModelError, error_of
from .history import History
from .program import find_program, messages_of
from .scene import Scene

PART = re.compile(r" *([\d.]+)% ")


def run(scene: Scene | str | Path, *, output: str | Path | None = None, threads: int = 0, resume: bool = False,
        progress: bool | Callable[[float], None] = True, force: bool = False, settings: dict[str, Any] | None = None, time_limit: float | None = None,
        accuracy: Mapping[str, float] | None = None, program: str | Path | None = None) -> History:
    """Run a model to its end, and read its history.

    scene       a `Scene`, or the path of a namelist
    output      folder of the result; default: the current one
    threads     0: as many as are of use
    resume      go on from the checkpoint of a run that was stopped or killed, where there is one, else begin
    progress    show how far it is; or a function that is called with the part of the time that is done, from 0 to 1
    force       replace an old result; without it that is a `FileError`, as of the command
    settings    {"grid.cell": 1e-3, "load(2).force": (0, 1)}: keys with values in place of those of the model
    time_limit  wall time [s] after which it stops with a checkpoint
    accuracy    {"K_I": 0.01}: errors that columns may have at most, as parts of their values: what the model leaves out of cells, levels and steps is
                chosen so (&accuracy), and its group &grid may be missing

    program     default: that of the model, or the one that is found by the dimensions of its grid

    Raises `ModelError`, `ComputationError`, `FileError` or `Stopped`, whose `messages` are those of the program; what it warns of
    are warnings of the kind `HampmWarning`. An interrupt from the keyboard stops the program with a checkpoint.
    """
    folder = Path(output) if output is not None else Path.cwd()
    scene = scene if isinstance(scene, Scene) else Scene(scene, program=program)
    scene = scene.with_settings(settings) if settings else scene
    scene = scene.with_accuracy(accuracy) if accuracy else scene
    if not resume and (broken := scene.mistakes()):
        scene.check(warn=False)                      # which tells all mistakes, and where each stands
        raise ModelError(broken)
    name = scene.result_name()
    checkpoint = folder / (name + ".checkpoint")
    folder.mkdir(parents=True, exist_ok=True)
    words = ["--threads", threads] + (["--time-limit", time_limit] if time_limit else [])
    with tempfile.TemporaryDirectory() as place:
        if resume and checkpoint.exists():
            words += ["--resume", checkpoint]
        else:
            file = Path(place) / (scene.path.name if scene.path else "model.nml")
            file.write_text(str(scene))
            words += [file, "--output", folder, "--set", f"output.file={name}"] + ["--force"] * (force or resume)
        code, said = _follow([find_program(program or scene.program, scene.dimensions()), *map(str, words)], progress, Path(place) / "errors")
    if code == ModelError.exit_code and "--resume" not in words:
        scene.check(warn=False)                      # which tells each mistake apart
    errors, told = messages_of(said)
    for text in told:
        warnings.warn(text, HampmWarning, stacklevel=2)
    if code != 0:
        raise error_of(code, errors or [Message(f"ended by signal {-code}" if code < 0 else f"exit code {code}")])
    return History(folder / name)


def _follow(words: list[str | Path], progress: bool | Callable[[float], None], errors: Path) -> tuple[int, str]:
    """Run to the end; exit code and standard error. Where progress is asked for, the program writes to what it takes for a terminal, on which
    it tells several times a second how far it is."""
    tell = progress if callable(progress) else _shown if progress and (sys.stderr.isatty() or "ipykernel" in sys.modules) else None
    reader, writer = pty.openpty() if tell else (-1, subprocess.DEVNULL)
    with open(errors, "w+b") as file:
        process = subprocess.Popen(words if tell else [*words, "--quiet"], stdin=subprocess.DEVNULL, stdout=writer, stderr=file,
                                   start_new_session=True)
        stoppable = threading.current_thread() is threading.main_thread()
        before = signal.signal(signal.SIGINT, lambda number, frame: process.send_signal(signal.SIGTERM)) if stoppable else None
        try:
            if tell:
                os.close(writer)
                _read(reader, tell)
            code = process.wait()
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
            if stoppable:
                signal.signal(signal.SIGINT, before)
            if tell:
                os.close(reader)
        file.seek(0)
        return code, file.read().decode(errors="replace")


def _read(terminal: int, progress: Callable[[float], None]) -> None:
    """Take what the program writes, and hand on how far it is."""
    rest = ""
    while True:
        try:
            chunk = os.read(terminal, 65536)
        except OSError:                              # nobody writes any more
            return
        if not chunk:
            return
        *lines, rest = re.split(r"[\r\n]", rest + chunk.decode(errors="replace"))
        for line in [*lines, rest]:
            if found := PART.search(line):
                progress(min(float(found[1]) / 100, 1.0))


def _shown(part: float) -> None:
    """A bar on the terminal, or in a notebook."""
    width = 40
    print(f"\r[{'#' * round(part * width):{width}}] {part:4.0%}", end="\n" if part >= 1 else "", file=sys.stderr, flush=True)
