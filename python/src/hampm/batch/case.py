"""Run one case of a sweep in its own folder and record how it ended.

    hampm.log                  what hampm said on its last start
    NAME.h5                    its result, named as the folder; NAME.h5.checkpoint where it was stopped
    case.json                  what the case is, and what its starts have taken that did not end it
    outcome.json               how it ended; written only when it did
    ended-NUMBER               empty, for Snakemake; written after it. The number stands for the text of the namelist

A case has ended when hampm is done (exit code 0), or refuses the scene or fails in the computation (2, 3): these would end in the
same way again. Any other end, such as a full disk, a limit of time or a signal, is no outcome: the exit code is 1, and the next
start goes on from the checkpoint if there is one. A case whose outcome is there is not run again. A signal that ends batch jobs is
passed on to hampm, which then writes its checkpoint.
"""

import argparse
import ctypes
import fcntl
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from argparse import Namespace
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from ..errors import HampmError, Message, error_of
from .progress import count_end

OUTCOMES = {0: "done", 2: "refused", 3: "failed"}  # by exit code of hampm
SIGNALS = signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGUSR1, signal.SIGXCPU
PASSED_ON = signal.SIGUSR2  # of another kind than any of them: a second one of a kind would end hampm without a checkpoint
PR_SET_PDEATHSIG = 1
NOTHING_SPENT = {"starts": 0, "cpu_seconds": 0.0, "wall_seconds": 0.0, "peak_megabytes": 0.0}


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    with locked(options.folder):
        what = identity(options.namelist, dict(text.split("=", 1) for text in options.set))
        if known(options.folder / "outcome.json").get("case") != what and not has_ended(what, options):
            return 1
        marker(options.folder, what["namelist"]).touch()
    return 0


def has_ended(what: dict[str, Any], options: Namespace) -> bool:
    """Begin a case or go on with it; whether it came to an end, which is then recorded."""
    folder = options.folder
    for old in (folder / "outcome.json", *folder.glob("ended-*")):
        old.unlink(missing_ok=True)
    begin = known(folder / "case.json")
    if begin.get("case") != what:
        checkpoint_of(result_of(folder)).unlink(missing_ok=True)
        if result_of(folder) != own_result(folder):
            result_of(folder).unlink(missing_ok=True)
        begin = {"case": what, "spent": NOTHING_SPENT}
        write(folder / "case.json", begin)
    code, spent = start(command(options), options, begin["spent"])
    message = messages((folder / "hampm.log").read_text(errors="replace"))
    behind = f": {message}" if message else ""
    if code not in OUTCOMES:
        write(folder / "case.json", {"case": what, "spent": spent, "exit_code": code, "message": message})
        print(f"not finished: {folder.name}: {ending(code)}{behind}", file=sys.stderr)
        return False
    write(folder / "outcome.json", {"case": what, "outcome": OUTCOMES[code], "message": message, "spent": spent})
    print(f"{count_end(folder)}{OUTCOMES[code]}: {folder.name}{behind}")
    return True


def parse(arguments: list[str] | None) -> Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="of the case; made where there is none")
    parser.add_argument("namelist", metavar="CASE.nml", type=Path)
    parser.add_argument("--set", metavar="GROUP.KEY=VALUE", nargs="*", default=[], help="settings of the case")
    parser.add_argument("--program", metavar="FILE", type=Path, required=True, help="hampm")
    parser.add_argument("--threads", metavar="N", type=int, default=1)
    parser.add_argument("--checkpoint", metavar="SECONDS", type=float, default=600, help="wall time between checkpoints")
    return parser.parse_args(arguments)


def identity(namelist: Path, settings: Mapping[str, str]) -> dict[str, Any]:
    """What makes a case the same case: the text of its namelist and what it sets."""
    return {"namelist": digest(namelist), "settings": dict(settings)}


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def record_of(folder: Path, what: Mapping[str, Any]) -> dict[str, Any]:
    """What is known of a case in its folder: its `outcome` and `message` where it has ended, and what its starts have taken; empty where none is of
    this very case."""
    for file in ("outcome.json", "case.json"):
        record = known(folder / file)
        if record.get("case") == what:
            return record
    return {}


def failure_of(record: Mapping[str, Any]) -> HampmError | None:
    """The exception for how a case has ended, or for the last end of one that is not finished; None where it is done or was not begun."""
    codes = {outcome: code for code, outcome in OUTCOMES.items()}
    code = codes.get(record.get("outcome", ""), record.get("exit_code", 0))
    return error_of(code, [Message(record.get("message") or ending(code))]) if code else None


def own_result(folder: Path) -> Path:
    """What a case calls its result: as its folder."""
    return folder / f"{folder.resolve().name}.h5"


def checkpoint_of(result: Path) -> Path:
    return result.with_name(result.name + ".checkpoint")


def result_of(folder: Path) -> Path:
    """The result of a case, which has another name where the case had one when it was begun."""
    own = own_result(folder)
    others = sorted({*folder.glob("*.h5"), *(path.with_suffix("") for path in folder.glob("*.h5.checkpoint"))})
    return own if own.exists() or checkpoint_of(own).exists() or not others else others[0]


def marker(folder: Path, text: str) -> Path:
    """The file that says that a case has ended, for a namelist whose text has this digest."""
    return folder / f"ended-{text[:8]}"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait until nobody else runs this case; where the file system has no locks, hope so."""
    with open(folder / "lock", "w") as file:
        try:
            fcntl.lockf(file, fcntl.LOCK_EX)
        except OSError:
            pass
        yield


def known(path: Path) -> dict[str, Any]:
    """A JSON file; empty where there is none or not a whole one."""
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def write(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file under a partial name, and rename it."""
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(content, indent=1) + "\n")
    part.replace(path)


def command(options: Namespace) -> list[str | Path]:
    """The command line that goes on from the checkpoint, or begins the case."""
    checkpoint = checkpoint_of(result_of(options.folder))
    interval = "--set", f"output.checkpoint_interval={options.checkpoint:g}"
    common = [options.program, "--quiet", "--threads", str(options.threads), *interval]
    if checkpoint.exists():
        return [*common, "--resume", checkpoint]
    settings = [word for text in (*options.set, f"output.file={own_result(options.folder).name}") for word in ("--set", text)]
    return [*common, options.namelist, "--output", options.folder, "--force", *settings]


def start(words: list[str | Path], options: Namespace, before: Mapping[str, float]) -> tuple[int, dict[str, float]]:
    """Run hampm to its end. Its exit code, negative for a signal, and what all starts of the case have taken."""
    environment = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), str(options.threads))
    begin = time.monotonic()
    with open(options.folder / "hampm.log", "w") as log:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=environment,
                                   start_new_session=True, preexec_fn=stop_with_parent)
    pass_on_signals(process.pid)
    _, status, usage = os.wait4(process.pid, 0)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)   # the outcome is about to be written
    return os.waitstatus_to_exitcode(status), {
        "starts": before["starts"] + 1,
        "cpu_seconds": round(before["cpu_seconds"] + usage.ru_utime + usage.ru_stime, 3),
        "wall_seconds": round(before["wall_seconds"] + time.monotonic() - begin, 3),
        "peak_megabytes": round(max(before["peak_megabytes"], usage.ru_maxrss / 1024), 1)}


def stop_with_parent() -> None:
    """Have Linux send the calling process a signal when its parent dies, so that no run goes on without one."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, PASSED_ON)


def pass_on_signals(process: int) -> None:
    """Send the process one signal to stop for the first that comes."""
    def stop(number: int, frame: FrameType | None) -> None:
        for each in SIGNALS:
            signal.signal(each, signal.SIG_IGN)
        os.kill(process, PASSED_ON)
    for number in SIGNALS:
        signal.signal(number, stop)


def messages(text: str) -> str:
    """The messages of hampm in one line, without what a terminal would take for a command."""
    said = "; ".join(line.removeprefix("hampm: ").strip() for line in text.splitlines() if line.strip())
    return "".join(letter if letter.isprintable() else "?" for letter in said)


def ending(code: int) -> str:
    return f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"

