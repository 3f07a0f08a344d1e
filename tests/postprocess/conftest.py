"""What the tests of the scripts share: running them as a user would."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from history import run
from paths import SCRIPTS
from synthetic import write_result


@pytest.fixture
def dcb_file(tmp_path):
    """A complete result file."""
    return write_result(tmp_path / "dcb.h5")


VERTICAL = """&run
   plane = 'stress'
   end_time = 4e-6
/
&grid
   lower = 0.0, 0.0
   cell = 1e-3
   cells = 21, 11
/
&material
   name = 'a'
   young = 70e9
   poisson = 0.3
   density = 2700
/
&body
   material = 'a'
   lower = 0.0, 0.0
   upper = 20e-3, 10e-3
/
&load
   kind = 'traction'
   lower = 20e-3, 0.0
   upper = 20e-3, 10e-3
   force = 1e4, 0.0
/
&constraint
   lower = 0.0, 0.0
   upper = 0.0, 10e-3
   fix = 'xy'
/
&crack
   kind = 'line'
   tip = 10e-3, 5e-3
   direction = 0, 1
/
&output
   history_interval = 4e-8
   snapshot_interval = 2e-6
/
"""


@pytest.fixture(scope="session")
def vertical_crack(run_hampm, tmp_path_factory):
    """The result file of a plate with a crack from the middle of its lower edge upwards, x = 10 mm, y = 0 to 5 mm, that opens."""
    folder = tmp_path_factory.mktemp("vertical")
    (folder / "vertical.nml").write_text(VERTICAL)
    result = run_hampm("vertical.nml", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "vertical.h5"


SLANTED = """&run
   plane = 'strain'
   end_time = 1.0
/
&grid
   lower = -13e-3, -13e-3
   cell = 1e-3
   cells = 26, 26
/
&material
   name = 'a'
   young = 200e9
   poisson = 0.3
   density = 7800
/
&body
   material = 'a'
   lower = -12e-3, -12e-3
   upper = 12e-3, 12e-3
/
&load
   kind = 'traction'
   lower = -12e-3, 12e-3
   upper = 12e-3, 12e-3
   force = 0.0, 24e3
/
&load
   kind = 'traction'
   lower = -12e-3, -12e-3
   upper = 12e-3, -12e-3
   force = 0.0, -24e3
/
&method
   time = 'static'
/
&refine
   indicator = 'tip'
   max_level = 1
   rings = 3
/
&crack
   kind = 'path'
   points = -4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3
/
&crack
   kind = 'path'
   points = -12e-3, 6.3e-3, -8.2e-3, 7.1e-3, -6.3e-3, 8.7e-3
/
&output
   snapshot_interval = 1.0
/
"""


@pytest.fixture(scope="session")
def slanted_crack(run_hampm, tmp_path_factory):
    """The result file of a plate under tension with a slanted crack, tips 1 and 2, and a kinked one from its left edge, tip 3."""
    folder = tmp_path_factory.mktemp("slanted")
    (folder / "slanted.nml").write_text(SLANTED)
    result = run_hampm("slanted.nml", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "slanted.h5"


GROWING = SLANTED[:SLANTED.index("&crack")].replace("end_time = 1.0", "end_time = 3.0").replace(
    "time = 'static'", "time = 'static'\n   load_steps = 3") + """&crack
   kind = 'path'
   points = -12e-3, 0.4e-3, -3e-3, 2.4e-3
/
&growth
   direction = 'hoop_stress'
   toughness = 100.0
   increment = 1.5e-3
/
&energy_release
   estimators = 'domain_integral'
/
&output
   snapshot_interval = 1.0
/
"""


@pytest.fixture(scope="session")
def grown_crack(run_hampm, tmp_path_factory):
    """The result file of a plate under tension with a slanted crack from its left edge that grows at rest by three increments of 1.5 mm."""
    folder = tmp_path_factory.mktemp("grown")
    (folder / "grown.nml").write_text(GROWING)
    result = run_hampm("grown.nml", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "grown.h5"


RUNNING = """&run
   plane = 'strain'
   end_time = 8e-6
/
&grid
   lower = -10e-3, 0.0
   cell = 1e-3
   cells = 30, 11
/
&material
   name = 'a'
   young = 200e9
   poisson = 0.3
   density = 5000
/
&body
   material = 'a'
   lower = -10e-3, 0.0
   upper = 20e-3, 10e-3
/
&constraint
   lower = 0.0, 0.0
   upper = 20e-3, 0.0
   fix = 'y'
/
&load
   kind = 'traction'
   lower = -10e-3, 10e-3
   upper = 20e-3, 10e-3
   force = 0.0, 1e4
/
&crack
   kind = 'symmetry'
   tip = 0.0, 0.0
/
&growth
   law = 'prescribed'
   speed = 1000
   start = 3e-6
   direction = 'straight'
/
&energy_release
   estimators = 'domain_integral'
/
&output
   history_interval = 8e-8
   snapshot_interval = 4e-6
/
"""


@pytest.fixture(scope="session")
def running_crack(run_hampm, tmp_path_factory):
    """The result file of half a plate whose crack on the plane of symmetry runs at 1000 m/s from 3 us on."""
    folder = tmp_path_factory.mktemp("running")
    (folder / "running.nml").write_text(RUNNING)
    result = run_hampm("running.nml", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "running.h5"


@pytest.fixture
def script(monkeypatch, capsys):
    """Call a script's main() as its process would: exit code, standard output, standard error."""
    def call(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name])
        module = importlib.import_module(Path(name).stem)
        with pytest.raises(SystemExit) as end:
            run(lambda: module.main([str(argument) for argument in arguments]))
        return subprocess.CompletedProcess(name, end.value.code or 0, *capsys.readouterr())
    return call


@pytest.fixture
def program(tmp_path):
    """Run a script in a process of its own, elsewhere and without a display."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MPLBACKEND")}

    def call(name, *arguments):
        return subprocess.run([sys.executable, SCRIPTS / name, *map(str, arguments)], env=environment, cwd=tmp_path,
                              capture_output=True, text=True)
    return call
