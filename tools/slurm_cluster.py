"""A Slurm of one machine for as long as a test takes: slurmctld, slurmd and munged from the packages of the distribution (Debian, Ubuntu).

The packages are unpacked below build/, not installed: neither /etc nor a Slurm of this machine is touched, and no rights of root are needed. The
daemons have a folder, a configuration, a key and free ports of their own, and stop with the process that has started them. Processes are followed
through /proc, not by cgroups, which containers may lack.
"""

import ctypes
import getpass
import os
import platform
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = "slurmctld", "slurmd", "slurm-client", "slurm-wlm-basic-plugins", "munge"
UNPACKED = ROOT / "build/slurm"
PR_SET_PDEATHSIG = 1
PATIENCE = 30       # for a daemon to answer [s]
LONGEST_SOCKET = 90  # characters of the path of a socket

CONFIGURATION = """\
ClusterName=hampm
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
PluginDir={plugins}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2
ReturnToService=2
MinJobAge=3600
KillWait=10
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=high Nodes=ALL PriorityTier=10 PreemptMode=OFF MaxTime=INFINITE State=UP
PartitionName=main Nodes=ALL PriorityTier=1 GraceTime={grace} MaxTime=INFINITE State=UP Default=YES
"""


class SlurmError(Exception):
    """What keeps Slurm from being set up or from doing what is asked, in one line."""


def unpacked_packages():
    """The folder in which the packages of Slurm, and those that they need and this machine lacks, are unpacked; made where there is none."""
    for name in ("apt-get", "dpkg-deb"):
        if not shutil.which(name):
            raise SlurmError(f"there is no {name}: the packages of Slurm are taken from Debian or Ubuntu")
    uris = ask_apt("install", "--print-uris", "-qq", "--no-install-recommends", *PACKAGES)
    needed = {Path(line.split()[1]).name.split("_")[0] for line in uris.splitlines()} | set(PACKAGES)
    stamp = UNPACKED / "packages.txt"
    text = "".join(f"{name}\n" for name in sorted(needed)) + uris
    if stamp.exists() and stamp.read_text() == text:
        return UNPACKED
    shutil.rmtree(UNPACKED, ignore_errors=True)
    UNPACKED.mkdir(parents=True)
    ask_apt("download", "-qq", *sorted(needed), cwd=UNPACKED)
    for package in UNPACKED.glob("*.deb"):
        subprocess.run(["dpkg-deb", "-x", package, UNPACKED], check=True)
        package.unlink()
    stamp.write_text(text)
    return UNPACKED


def ask_apt(*words, cwd=None):
    """What apt-get says. Root is asked for nothing but fresh lists of packages, where there are none."""
    def ask():
        return subprocess.run(["apt-get", *words], cwd=cwd, capture_output=True, text=True, env=os.environ | {"LC_ALL": "C"})
    answer = ask()
    if answer.returncode and os.geteuid() == 0:
        subprocess.run(["apt-get", "-qq", "update"], capture_output=True)
        answer = ask()
    if answer.returncode:
        said = [line for line in answer.stderr.splitlines() if line.startswith("E: ")] or ["E: it failed"]
        raise SlurmError(f"apt-get {words[0]}: {said[0].removeprefix('E: ')}; `apt-get update` by root may help")
    return answer.stdout


class Cluster:
    """A node that stands for a cluster, with the partitions main, whose jobs go back into the queue for those of high. `with` starts and ends it."""

    def __init__(self, cpus, memory, ports=(), grace=0):
        self.cpus, self.memory, self.grace = cpus, memory, grace  # of the node [1], [MB]; time that a preempted job has [s]
        self.ports = list(ports)                                  # of slurmctld and slurmd; free ones where none are given
        self.daemons = []

    def __enter__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="hampm-slurm-"))
        try:
            self.start()
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *_):
        """Stop jobs and daemons, and remove all that they have written."""
        handlers = {number: signal.signal(number, signal.SIG_IGN) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
        if len(self.daemons) == 3:
            self.end_jobs()
        for process in reversed(self.daemons):
            process.terminate()
        for process in self.daemons:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
        for number, handler in handlers.items():
            signal.signal(number, handler)

    def start(self):
        root = unpacked_packages()
        libraries = next(root.glob("usr/lib/*/slurm-wlm/libslurmfull.so")).parent
        if len(str(self.folder)) > LONGEST_SOCKET:
            raise SlurmError(f"{self.folder}: is too long a name for the folder of a socket; set TMPDIR to a short one")
        self.folder.chmod(0o711)                # munge wants its socket to be in reach of all
        self.ports = self.ports or free_ports(2)
        for port in self.ports:
            if not is_free(port):
                raise SlurmError(f"port {port} is taken")
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(secrets.token_bytes(128))
        self.configuration = self.folder / "slurm.conf"
        self.configuration.write_text(CONFIGURATION.format(
            folder=self.folder, user=getpass.getuser(), host=platform.node().split(".")[0], ports=self.ports, plugins=libraries,
            cpus=self.cpus, memory=self.memory, grace=self.grace))
        self.environment = {"LD_LIBRARY_PATH": f"{libraries.parent}:{libraries}", "SLURM_CONF": str(self.configuration)}
        self.wrap_commands(root / "usr/bin")
        self.begin(root, "munged", "-F", f"--key-file={key}", f"--socket={self.folder}/munge.socket", "--num-threads=2",
                   f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/munged.log", f"--seed-file={self.folder}/munge.seed")
        self.wait_until(lambda: (self.folder / "munge.socket").exists())
        self.begin(root, "slurmctld", "-D", "-c", "-f", self.configuration)
        self.begin(root, "slurmd", "-D", "-f", self.configuration, "-d", program(root, "slurmstepd"))
        self.wait_until(lambda: self.run("sinfo", "--noheader", "--format=%T", "-p", "main", check=False).strip() == "idle")

    def wrap_commands(self, programs):
        """Commands in `bin` that know this cluster by themselves: what a job step calls may have lost its environment."""
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        settings = " ".join(f"{name}={value}" for name, value in self.environment.items())
        for path in programs.iterdir():
            command = self.bin / path.name
            command.write_text(f'#!/bin/sh\n{settings} exec {path} "$@"\n')
            command.chmod(0o755)

    def begin(self, root, name, *words):
        """Start a daemon, which is told to stop when this process ends."""
        log = open(self.folder / f"{name}.out", "w")
        self.daemons.append(subprocess.Popen(
            [program(root, name), *words], stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.folder,
            env=os.environ | self.environment, preexec_fn=stop_with_parent, start_new_session=True))

    def wait_until(self, holds):
        """Wait for the daemons; an error with what they have said where one has ended, or takes too long."""
        end = time.monotonic() + PATIENCE
        while not holds():
            ended = [process for process in self.daemons if process.poll() is not None]
            if ended or time.monotonic() > end:
                process = (ended or self.daemons)[-1]
                name = Path(process.args[0]).name.removesuffix("-wlm")
                lines = [line for path in (f"{name}.out", f"{name}.log") if (self.folder / path).exists()
                         for line in (self.folder / path).read_text(errors="replace").splitlines()]
                said = [line for line in lines if "rror" in line or "fatal" in line] or lines or ["it says nothing"]
                raise SlurmError(f"{name} does not run: {said[-1].strip()}")
            time.sleep(0.2)

    def run(self, command, *words, check=True):
        """What a command of Slurm says."""
        result = subprocess.run([self.bin / command, *map(str, words)], capture_output=True, text=True)
        if check and result.returncode:
            raise SlurmError(f"{command}: {result.stderr.strip().splitlines()[-1]}")
        return result.stdout

    def jobs(self):
        """All jobs so far: for each number what scontrol says of it."""
        text = self.run("scontrol", "--oneliner", "show", "job")
        found = [dict(word.split("=", 1) for word in line.split() if "=" in word) for line in text.splitlines()]
        return {int(job["JobId"]): job for job in found if "JobId" in job}

    def end_jobs(self):
        """Cancel what runs, and wait until nothing does."""
        self.run("scancel", "--user", getpass.getuser(), check=False)
        end = time.monotonic() + PATIENCE
        while self.run("squeue", "--noheader", check=False).strip() and time.monotonic() < end:
            time.sleep(0.5)


def program(root, name):
    """The path of a daemon; Debian adds -wlm to its name, as there is another Slurm."""
    return next(path for path in (root / f"usr/sbin/{name}-wlm", root / f"usr/sbin/{name}") if path.exists())


def stop_with_parent():
    """Have Linux tell the calling process to stop when its parent dies."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def free_ports(number):
    """Ports that nobody listens at."""
    sockets = [socket.socket() for _ in range(number)]
    for each in sockets:
        each.bind(("", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def is_free(port):
    with socket.socket() as each:
        each.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            each.bind(("", port))
        except OSError:
            return False
    return True
