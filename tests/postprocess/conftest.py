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


@pytest.fixture(autouse=True)
def closed_figures():
    """Drop the figures that a test has made."""
    yield
    if "pictures" in sys.modules:
        sys.modules["pictures"].plt.close("all")


MODELS = {
    "vertical": """&run plane = 'stress'  end_time = 4e-6 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 21, 11 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, 0.0  upper = 20e-3, 10e-3 /
&load kind = 'traction'  lower = 20e-3, 0.0  upper = 20e-3, 10e-3  force = 1e4, 0.0 /
&constraint lower = 0.0, 0.0  upper = 0.0, 10e-3  fix = 'xy' /
&crack kind = 'line'  tip = 10e-3, 5e-3  direction = 0, 1 /
&output history_interval = 4e-8  snapshot_interval = 2e-6 /
""",
    "running": """&run plane = 'strain'  end_time = 8e-6 /
&grid lower = -10e-3, 0.0  cell = 1e-3  cells = 30, 11 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 5000 /
&body material = 'a'  lower = -10e-3, 0.0  upper = 20e-3, 10e-3 /
&constraint lower = 0.0, 0.0  upper = 20e-3, 0.0  fix = 'y' /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 20e-3, 10e-3  force = 0.0, 1e4 /
&crack kind = 'symmetry'  tip = 0.0, 0.0 /
&growth law = 'prescribed'  speed = 1000  start = 3e-6  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
&output history_interval = 8e-8  snapshot_interval = 4e-6 /
"""}
PLATE = """&grid lower = -13e-3, -13e-3  cell = 1e-3  cells = 26, 26 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = -12e-3, -12e-3  upper = 12e-3, 12e-3 /
&load kind = 'traction'  lower = -12e-3, 12e-3  upper = 12e-3, 12e-3  force = 0.0, 24e3 /
&load kind = 'traction'  lower = -12e-3, -12e-3  upper = 12e-3, -12e-3  force = 0.0, -24e3 /
&refine indicator = 'tip'  max_level = 1  rings = 3 /
&output snapshot_interval = 1.0 /
"""
MODELS["slanted"] = PLATE + """&run plane = 'strain'  end_time = 1.0 /
&method time = 'static' /
&crack kind = 'path'  points = -4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3 /
&crack kind = 'path'  points = -12e-3, 6.3e-3, -8.2e-3, 7.1e-3, -6.3e-3, 8.7e-3 /
"""
MODELS["grown"] = PLATE + """&run plane = 'strain'  end_time = 3.0 /
&method time = 'static'  load_steps = 3 /
&crack kind = 'path'  points = -12e-3, 0.4e-3, -3e-3, 2.4e-3 /
&growth direction = 'hoop_stress'  toughness = 100.0  increment = 1.5e-3 /
&energy_release estimators = 'domain_integral' /
"""


RUBBER = """&grid lower = -8e-3, -2e-3  cell = 1e-3  cells = 26, 8 /
&material name = 'rubber'  law = 'neo_hookean'  young = 1e3  poisson = 0.0  density = 1000 /
&output snapshot_interval = 1.0 /
"""
MODELS["stretched"] = RUBBER + """&run plane = 'strain'  end_time = 1.0 /
&body material = 'rubber'  lower = 0.0, 0.0  upper = 10e-3, 4e-3 /
&constraint lower = 0.0, 0.0  upper = 0.0, 4e-3  fix = 'xy' /
&constraint lower = 10e-3, 0.0  upper = 10e-3, 4e-3  fix = 'xy'  displacement = 10e-3, 0.0 /
&method time = 'static'  load_steps = 10 /
"""
MODELS["stretched_updated"] = RUBBER.replace("1.0 /", "1e-3 /") + """&run plane = 'strain'  end_time = 1e-3 /
&method frame = 'updated' /
""" + "".join(f"&body material = 'rubber'  lower = {k}e-3, 0.0  upper = {k + 1}e-3, 4e-3  velocity = {(k - 4.5) / 3}, 0.0 /\n"
              for k in range(10))
MODELS["notched"] = PLATE + """&run plane = 'strain'  end_time = 1.0 /
&method time = 'static' /
&crack kind = 'path'  points = 0.3e-3, 12.9e-3, 0.3e-3, 4.2e-3 /
"""


def result_of(name, meaning):
    """A fixture of the whole session: the result file of a model."""
    @pytest.fixture(scope="session")
    def result(run_hampm, tmp_path_factory):
        folder = tmp_path_factory.mktemp(name)
        (folder / f"{name}.nml").write_text(MODELS[name])
        run_of = run_hampm(f"{name}.nml", cwd=folder)
        assert run_of.returncode == 0, run_of.stderr
        return folder / f"{name}.h5"
    result.__doc__ = meaning
    return result


vertical_crack = result_of("vertical", "A plate with a crack from the middle of its lower edge upwards, x = 10 mm, y = 0 to 5 mm, that opens.")
slanted_crack = result_of("slanted", "A plate under tension with a slanted crack, tips 1 and 2, and a kinked one from its left edge, tip 3.")
grown_crack = result_of("grown", "A plate under tension with a slanted crack from its left edge that grows in static equilibrium by three increments of 1.5 mm.")
running_crack = result_of("running", "Half a plate whose crack on the plane of symmetry runs at 1000 m/s from 3 us on.")


stretched = result_of("stretched", "A block of rubber that is stretched to twice its length, at rest.")
stretched_updated = result_of("stretched_updated", "The same, whose slices fly apart, in the updated frame.")
notched = result_of("notched", "A plate under tension with a crack that begins 0.9 mm above it.")


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
