#!/usr/bin/env python3
"""Kill runs at random moments (SIGKILL) and resume them, again and again.

After every kill the result and the checkpoint must be readable to their last byte, the checkpoint no older than before and the
result no older than the checkpoint, and the wall time since the last checkpoint no longer than the interval, up to --slack. A run
that comes to its end must have the bytes of one that was never stopped. Exit code 1 where anything of this does not hold.

    .venv/bin/python tests/program/kill_at_random.py --kills 200 --scene all
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py

from harness import differing

ROOT = Path(__file__).resolve().parents[2]
INPUT = ROOT / "input"
RESULT = "run.h5"
CHECKPOINT = RESULT + ".checkpoint"
MEETING = """\
&run end_time = 0.08 /
&grid cell = 0.25 cells = 32, 16 /
&material name = 'soft' law = 'neo_hookean' young = 1e5 density = 1000 poisson = 0.3 /
&body material = 'soft' shape = 'circle' center = 2.3, 2.0 radius = 1.0 velocity = 20, 0 /
&body material = 'soft' shape = 'circle' center = 5.6, 2.2 radius = 1.0 velocity = -20, 0 /
&contact bodies = 'friction' friction = 0.2 /
&method courant = 0.1 frame = 'updated' shape_functions = 'cpdi' /
&energy_release energy_balance = .true. /
&output history_interval = 2e-3 snapshot_interval = 10e-3 /
"""

# What each run keeps between its steps: cells that come and go, a crack that grows in motion and at rest, a law that remembers,
# bodies that meet, cells of order 2
SCENES = {
    "refined": [INPUT / "dcb.nml", "grid.cell=2.5e-3", "grid.cells=40,5", "run.end_time=1.5e-4", "output.history_interval=1e-6",
                "output.snapshot_interval=2e-6", "refine.indicator='gradient'", "refine.max_level=2", "refine.r_crit=0.02",
                "refine.region_lower=0.04,0.0", "refine.region_upper=0.06,0.005"],
    "growth in motion": [INPUT / "dcb_growth_dynamic.nml"],
    "growth at rest": [INPUT / "bend_path.nml"],
    "plastic": [INPUT / "plastic_notch.nml"],
    "meeting": [MEETING],
    "quadratic": [INPUT / "dcb.nml", "grid.cell=1.25e-3", "grid.cells=80,9", "grid.order=2", "body.points_per_cell=3",
                  "run.end_time=1e-4", "energy_release.estimators=domain_integral", "method.frame=total",
                  "output.history_interval=1e-6", "output.snapshot_interval=1e-5"],
    "quadratic consistent": [INPUT / "dcb.nml", "grid.cell=2.5e-3", "grid.cells=40,5", "grid.order=2", "body.points_per_cell=3", "run.end_time=1.5e-4",
                       "energy_release.estimators=domain_integral", "method.frame=total", "method.courant=0", "method.mass=consistent",
                       "refine.indicator=zz", "refine.tolerance=0.1", "refine.max_level=2", "refine.region_lower=0.04,0.0",
                       "refine.region_upper=0.06,0.005", "output.history_interval=1e-6", "output.snapshot_interval=1e-5"],
}


def read_whole(path):
    """Read all datasets of a file; None where there is none."""
    if not path.exists():
        return None
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]} if isinstance(item, h5py.Dataset) else {}))
    return found


class Kills:
    """The runs in a folder, one after the other, and what was found after each kill."""

    def __init__(self, program, folder, scene, interval, seed):
        self.program, self.interval = program, interval
        self.random = random.Random(seed)
        self.whole, self.folder = folder / "unbroken", folder / "killed"
        folder.mkdir(parents=True, exist_ok=True)
        source, *settings = SCENES[scene]
        if not isinstance(source, Path):
            (folder / "run.nml").write_text(source)
            source = folder / "run.nml"
        self.scene = [source, *(word for setting in [f"output.file={RESULT}", *settings] for word in ("--set", setting))]
        self.faults, self.kills, self.ends, self.in_writing, self.longest_lost = [], 0, 0, 0, 0.0
        self.steps = 0  # of the checkpoint after the last kill
        self.run(self.whole, *self.scene, "--set", "output.checkpoint_interval=0", "--force")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.clear()

    def run(self, folder, *arguments):
        subprocess.run(self.command(folder, *arguments), check=True, stderr=subprocess.DEVNULL)

    def command(self, folder, *arguments):
        return [str(word) for word in (self.program, *arguments, "--output", folder, "--quiet", "--threads", 1)]

    def clear(self):
        for path in self.folder.iterdir():
            path.unlink()
        self.steps = 0

    def complain(self, fault):
        self.faults.append(f"kill {self.kills}: {fault}")
        print(self.faults[-1], file=sys.stderr)

    def once(self):
        """Begin or resume the run, and kill it at a random moment unless it ends before."""
        checkpoint = self.folder / CHECKPOINT
        words = ["--resume", checkpoint] if checkpoint.exists() else [*self.scene, "--force"]
        command = self.command(self.folder, *words, "--set", f"output.checkpoint_interval={self.interval}")
        started = time.time()
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        try:
            process.wait(self.random.uniform(0, 5 * self.interval))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
        killed = time.time()
        message = process.communicate()[1]
        if process.returncode == -signal.SIGKILL:
            self.kills += 1
            self.check_files(started, killed)
        elif process.returncode == 0:
            self.check_end()
        else:
            self.complain(f"exit code {process.returncode}: {message}")
            self.clear()

    def check_files(self, started, killed):
        """Look at what a killed run has left."""
        result, checkpoint = self.folder / RESULT, self.folder / CHECKPOINT
        self.in_writing += any(path.name.startswith(CHECKPOINT) and path != checkpoint for path in self.folder.iterdir())
        try:
            history, state = read_whole(result), read_whole(checkpoint)
        except Exception as error:
            self.complain(f"unreadable: {error}")
            return
        if state is None and self.steps > 0:  # the run had come to its end, though not yet the program
            self.check_end()
            return
        if state:
            steps, samples = int(state["motion/steps"][0]), int(state["run/samples"][0])
            if steps < self.steps:
                self.complain(f"the checkpoint went back from step {self.steps} to {steps}")
            if history is None or samples > len(history["history/time"]):
                self.complain("the result is behind the checkpoint")
            self.steps = steps
        since = max(started, checkpoint.stat().st_mtime) if state else started
        self.longest_lost = max(self.longest_lost, killed - since)

    def check_end(self):
        """Compare a run that has come to its end."""
        self.ends += 1
        differences = differing(self.whole / RESULT, self.folder / RESULT)
        if differences:
            self.complain(f"differs from the unbroken run: {differences}")
        left = sorted(path.name for path in self.folder.iterdir() if path.name != RESULT)
        if left:
            self.complain(f"left behind: {left}")
        self.clear()


def kill_runs(program, folder, kills, interval, slack, seed, scene="refined"):
    """Kill so many runs, and let the last one come to its end; what was found."""
    found = Kills(program, Path(folder), scene, interval, seed)
    while found.kills < kills:
        found.once()
    if (found.folder / CHECKPOINT).exists():
        found.run(found.folder, "--resume", found.folder / CHECKPOINT, "--set", "output.checkpoint_interval=0")
        found.check_end()
    if found.longest_lost > interval + slack:
        found.complain(f"{found.longest_lost:.2f} s were lost, the interval is {interval} s")
    print(f"{scene}: {found.kills} kills, {found.in_writing} of them while a checkpoint was written; {found.ends} runs came to their end; "
          f"at most {found.longest_lost:.2f} s were lost, the interval is {interval} s; {len(found.faults)} faults")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/hampm", help="default: the release build")
    parser.add_argument("--kills", type=int, default=200, metavar="N", help="default: 200")
    parser.add_argument("--scene", default="refined", choices=[*SCENES, "all"], help="default: refined")
    parser.add_argument("--interval", type=float, default=0.1, metavar="S", help="between checkpoints; default: 0.1 s")
    parser.add_argument("--slack", type=float, default=1.0, metavar="S",
                        help="for what a start and a checkpoint take; default: 1 s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="where to run; default: a temporary folder")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        found = [kill_runs(options.program.resolve(), Path(options.folder or temporary) / scene, options.kills, options.interval,
                           options.slack, options.seed, scene)
                 for scene in (SCENES if options.scene == "all" else [options.scene])]
    return 1 if any(scene.faults for scene in found) else 0


if __name__ == "__main__":
    sys.exit(main())
