"""A scene of a moment, sweeps of it, and what is seen of their runs."""

import time
from pathlib import Path

FLIGHT = """\
&run end_time = 1e-3 /
&grid cell = 1.0 cells = 8, 4 /
&material name = 'soft' law = 'neo_hookean' young = 1e5 density = 1000 poisson = 0.3 /
&body material = 'soft' lower = 1.25, 1.0 upper = 2.25, 2.0 velocity = 30, 0 /
&method frame = 'updated' courant = 0.1 /
&load kind = 'body' lower = 1.0, 1.0 upper = 3.0, 2.0 force = 0, 0 /
&output history_interval = 1e-4 /
"""
MASS = 1000.0  # of the body [kg]
# A second of processor time
SLOW = {"run.end_time": "2000", "body.velocity": "0.0005,0", "output.history_interval": "10", "method.courant": "0.02"}
HEAD = "namelist: flight.nml\noutput: out\n"


def write_sweep(folder, text):
    """A sweep file, and the scene beside it; its path."""
    (folder / "flight.nml").write_text(FLIGHT)
    path = folder / "sweep.yaml"
    path.write_text(text)
    return path


def runs_of(folder, program):
    """Identities of the processes of a program that have something of a folder on their command line."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if words[0] == str(program) and any(str(folder) in word for word in words):
            found.append(int(path.parent.name))
    return found


def wait_for(condition, seconds=120):
    """Until a condition holds; its value."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline, "this has taken too long"
        time.sleep(0.02)
    return value
