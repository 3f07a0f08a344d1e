"""Run sweeps on a real Slurm of one machine, with what happens to jobs on clusters, and hold their tables to those of local runs.

    requests     what a Slurm job asks for: cores and memory of one case, time of all its cases
    ended        the sweep in one job a case; one job is cancelled (scancel), the program of another is killed (kill -9); the same command goes on
    limit        a job that Slurm ends at its limit of time; the same command goes on from its checkpoint
    preempted    jobs that have to make room for one of a higher priority, and begin anew by themselves
    one_job      Snakemake on the cores of one Slurm job that reaches its limit of time, and the same again

Run by `make slurm`, or for some parts: .venv/bin/python tools/slurm.py requests limit [--sweep SWEEP.yaml] [--keep]
Nothing is installed, nothing is left running (tools/slurm_cluster.py). With a difference the script ends with exit code 1.
"""

import argparse
import csv
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from slurm_cluster import ROOT, Cluster, SlurmError

sys.path.insert(0, str(ROOT / "python/src"))
from hampm.batch.declaration import read_sweep
from hampm.batch.needs import memory
from hampm.errors import ResultError

PROGRAM = ROOT / "build/release/hampm"
PROFILE = ROOT / "batch/profiles/slurm"
CPUS, MEMORY = 4, 8000                # that the node says to have, whatever it has [1], [MB]
OF_THE_RUN = {"starts", "cpu_seconds", "wall_seconds", "peak_megabytes"}  # columns that differ from run to run
PATIENCE = 900                        # for anything to happen [s]
# A scene of some seconds, and one of a moment
LONG = """\
namelist: {scenes}/dcb.nml
output: {output}
checkpoint: 0.5
runtime: 1
product:
  method.mass: [lumped, consistent]
  grid.cell: [2.5e-3]
  grid.cells: [[40, 5]]
columns: [time, G_vcct_I, J, kinetic_energy]
"""
SHORT = """\
namelist: {scenes}/dcb.nml
output: {output}
memory: 150
threads: 2
runtime: 7
product:
  grid.cell: [5e-3]
  grid.cells: [[20, 3]]
  run.end_time: [1e-4, 2e-4, 3e-4, 4e-4, 5e-4]
columns: [time, G_vcct_I, kinetic_energy]
"""


class Difference(Exception):
    """Something is not as it should be."""


class Sweep:
    """A sweep in a folder of its own."""

    def __init__(self, folder, text, program):
        folder.mkdir()
        self.folder, self.path, self.program = folder, folder / "sweep.yaml", program
        self.path.write_text(text)
        self.declared = read_sweep(self.path, program)
        self.process = None                     # of Snakemake on the cluster

    def command(self, *options):
        return [sys.executable, "-m", "snakemake", "-s", str(ROOT / "batch/Snakefile"), *options,
                "--config", f"sweep={self.path}", f"program={self.program}"]

    def locally(self):
        return run(self.command("--cores", "all"), self.folder)

    def on(self, cluster, *options):
        """The process that runs the sweep on a cluster: as docs/how-to/batches.md says, but that it asks more often."""
        words = self.command("--profile", str(PROFILE), "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2",
                             "--seconds-between-status-checks", "2", "--slurm-no-account", *options)
        self.process = subprocess.Popen(words, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
                                        env=os.environ | {"PATH": f"{cluster.bin}:{os.environ['PATH']}"})
        return self.process

    def stop(self):
        """End Snakemake where it still runs."""
        if self.process is not None and self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()

    def outcome(self, case):
        return json.loads((self.declared.folder(case) / "outcome.json").read_text())

    def log(self, case):
        return (self.declared.folder(case) / "hampm.log").read_text()

    def table(self):
        with open(self.declared.output / "table.csv", newline="") as file:
            return [{name: value for name, value in row.items() if name not in OF_THE_RUN} for row in csv.DictReader(file)]

    def running(self):
        """The process of hampm of each case that has a checkpoint."""
        found = {}
        for entry in Path("/proc").iterdir():
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                if words[0] == os.fsencode(self.program):
                    for case in self.declared.cases:
                        folder = self.declared.folder(case)
                        if any(os.fsencode(folder) in word for word in words) and list(folder.glob("*.h5.checkpoint")):
                            found[case] = int(entry.name)
            except (OSError, IndexError):
                pass
        return found


def run(words, folder):
    """Exit code and what was said."""
    result = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


def end(process):
    said, _ = process.communicate(timeout=PATIENCE)
    return process.returncode, said


def wait_for(what, process=None):
    """Wait until `what` gives something, which is returned."""
    last = time.monotonic() + PATIENCE
    while not (found := what()):
        if time.monotonic() > last or process is not None and process.poll() is not None:
            raise Difference("it has not come so far" + (f": {process.stdout.read()[-1500:]}" if process and process.poll() is not None else ""))
        time.sleep(0.05)
    return found


def suspend(sweep, number, process=None):
    """Stop the programs of so many cases that have a checkpoint: the process of each case."""
    found = {}

    def look():
        for case, program in sweep.running().items():
            try:
                if case not in found and len(found) < number:
                    os.kill(program, signal.SIGSTOP)
                    job_of(program)
                    found[case] = program
            except (OSError, KeyError):         # it has come to its end meanwhile
                pass
        return len(found) == number
    wait_for(look, process)
    return found


def hold(holds, what, said=""):
    """A line for what was asked, or the end."""
    if not holds:
        raise Difference(f"{what}: no{': ' + str(said)[-3000:] if said else ''}")
    print(f"   {what}: yes", flush=True)


def job_of(process):
    """The number of the Slurm job that a process belongs to."""
    words = dict(word.split(b"=", 1) for word in Path(f"/proc/{process}/environ").read_bytes().split(b"\0") if b"=" in word)
    return int(words[b"SLURM_JOB_ID"])


def compare(sweep, local):
    """Tables have the same text in every column that a run determines."""
    mine, other = sweep.table(), local.table()
    hold(mine == other and all(row["outcome"] == "done" for row in mine),
         f"{len(mine)} rows and {len(mine[0])} columns of the table are those of the local run", [mine, other])


def requests(cluster, new):
    local, sweep = new(SHORT), new(SHORT)
    local.locally()
    process = sweep.on(cluster, "--group-components", "cases=5")
    code, said = end(process)
    job = cluster.jobs()[max(cluster.jobs())]
    hold(code == 0, "a Slurm job of five cases ends well", said)
    hold((job["CPUs/Task"], job["MinMemoryNode"], job["TimeLimit"]) == ("2", "150M", "00:35:00"),
         "it has asked for 2 cores, 150 MB and 35 minutes", job)
    compare(sweep, local)


def ended(cluster, new, text):
    local, sweep = new(text), new(text + "\ncheckpoint: 1\n" if "checkpoint:" not in text else text)
    local.locally()
    process = sweep.on(cluster, "--group-components", "cases=1")
    (cancelled, first), (killed, second) = suspend(sweep, 2, process).items()
    asked = cluster.jobs()[job_of(first)]
    hold(asked["MinMemoryNode"] == f"{memory(sweep.declared, cancelled, sweep.program)}M", f"a case asks for {asked['MinMemoryNode']}B, twice what "
         "--check says and 100", asked)
    cluster.run("scancel", job_of(first))       # which wakes it
    os.kill(second, signal.SIGKILL)
    code, said = end(process)
    states = [job["JobState"] for job in cluster.jobs().values()]
    hold(code == 1 and "CANCELLED" in states and "FAILED" in states, "after scancel and kill -9 two cases are not finished", said)
    hold("stopped by SIG" in sweep.log(cancelled), "the cancelled one has written a checkpoint in time", sweep.log(cancelled))
    code, said = end(sweep.on(cluster, "--group-components", "cases=1"))
    hold(code == 0 and [sweep.outcome(case)["spent"]["starts"] for case in (cancelled, killed)] == [2, 2], "the same command goes on with them", said)
    compare(sweep, local)


def limit(cluster, new):
    local, sweep = new(LONG), new(LONG)
    local.locally()
    process = sweep.on(cluster, "--group-components", "cases=1")
    (case, number), = suspend(sweep, 1, process).items()
    job = job_of(number)                        # which Slurm ends at its limit; that wakes the program
    code, said = end(process)
    hold(code == 1 and cluster.jobs()[job]["JobState"] == "TIMEOUT", "Slurm ends a job at its limit of a minute", [said, cluster.jobs()[job]])
    hold("stopped by SIG" in sweep.log(case), "its case has written a checkpoint in time", sweep.log(case))
    code, said = end(sweep.on(cluster, "--group-components", "cases=1"))
    hold(code == 0 and sweep.outcome(case)["spent"]["starts"] == 2, "the same command goes on from there", said)
    compare(sweep, local)


def preempted(cluster, new):
    local, sweep = new(LONG), new(LONG)
    local.locally()
    process = sweep.on(cluster, "--group-components", "cases=1")
    wait_for(lambda: len(sweep.running()) > 1, process)
    cluster.run("sbatch", "--partition=high", f"--cpus-per-task={CPUS}", "--output=/dev/null", "--wrap", "sleep 2")
    code, said = end(process)
    restarts = [int(job["Restarts"]) for job in cluster.jobs().values() if job["Partition"] == "main"]
    hold(code == 0 and max(restarts) > 0, f"jobs that made room have begun anew by themselves ({sum(restarts)} times)", [said, restarts])
    starts = [sweep.outcome(case)["spent"]["starts"] for case in sweep.declared.cases]
    hold(max(starts) > 1, "and gone on from their checkpoints", starts)
    compare(sweep, local)


def one_job(cluster, new):
    local, sweep = new(LONG), new(LONG)
    local.locally()
    words = shlex.join(sweep.command("--cores", "2"))

    def submit():
        """Wait for the end of a job of two cores and a minute."""
        job = int(cluster.run("sbatch", "--parsable", "--cpus-per-task=2", "--time=1", f"--chdir={sweep.folder}", f"--output={sweep.folder}/said.txt",
                              "--wrap", f"exec {words}").strip())
        if not sweep.declared.output.exists():
            suspend(sweep, 1)
        wait_for(lambda: cluster.jobs()[job]["JobState"] not in ("PENDING", "RUNNING", "COMPLETING"))
        return cluster.jobs()[job]["JobState"]

    hold(submit() == "TIMEOUT", "Slurm ends the job at its limit of a minute")
    hold(submit() == "COMPLETED", "the same job goes on with its cases", (sweep.folder / "said.txt").read_text())
    hold(max(sweep.outcome(case)["spent"]["starts"] for case in sweep.declared.cases) > 1, "from a checkpoint")
    compare(sweep, local)


PARTS = {"requests": requests, "ended": ended, "limit": limit, "preempted": preempted, "one_job": one_job}


def main():
    options = parse()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, frame: sys.exit(128 + number))
    folder = Path(tempfile.mkdtemp(prefix="hampm-sweeps-"))
    begun = []
    try:
        with Cluster(CPUS, MEMORY, options.port) as cluster:
            print(f"{cluster.run('sinfo', '--version').strip()}, one node of {CPUS} cores and {MEMORY} MB", flush=True)
            try:
                for name in options.parts or PARTS:
                    print(f"{name}", flush=True)
                    try_part(name, cluster, folder, options, begun)
            finally:
                for sweep in begun:
                    sweep.stop()
        print("all as it should be")
    except KeyboardInterrupt:
        sys.exit(130)
    except (SlurmError, Difference, ResultError, subprocess.TimeoutExpired) as error:
        sys.exit(f"slurm.py: {error}")
    finally:
        if options.keep:
            print(f"kept: {folder}")
        else:
            shutil.rmtree(folder, ignore_errors=True)


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="; ".join(PARTS))
    parser.add_argument("--sweep", type=Path, default=ROOT / "input/dcb_sweep.yaml", metavar="FILE", help="of the part `ended`")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE", help="hampm")
    parser.add_argument("--port", type=int, nargs=2, default=(), metavar="N", help="of slurmctld and slurmd; free ones by default")
    parser.add_argument("--keep", action="store_true", help="leave the folder of the sweeps")
    options = parser.parse_args()
    unknown = [name for name in options.parts if name not in PARTS]
    if unknown:
        parser.error(f"there is no part '{unknown[0]}'; there are {', '.join(PARTS)}")
    if not options.program.exists():
        sys.exit(f"slurm.py: there is no {options.program}: make program")
    return options


def try_part(name, cluster, folder, options, begun):
    """Run a part. Sweeps have folders of their own; the declared one is copied there, with its paths as they are meant."""
    def new(text):
        place = folder / f"{name}_{len(begun) + 1}"
        begun.append(Sweep(place, text.format(scenes=ROOT / "input", output=place / "out"), options.program.resolve()))
        return begun[-1]
    if name == "ended":
        lines = options.sweep.read_text().replace("{", "{{").replace("}", "}}").splitlines()
        scene = next(line for line in lines if line.startswith("namelist:")).split(":")[1].split("#")[0].strip()
        lines = [line for line in lines if not line.startswith(("namelist:", "output:", "checkpoint:"))]
        text = "\n".join([f"namelist: {(options.sweep.parent / scene).resolve()}", "output: {output}", "checkpoint: 1", *lines, ""])
        PARTS[name](cluster, new, text)
    else:
        PARTS[name](cluster, new)


if __name__ == "__main__":
    main()
