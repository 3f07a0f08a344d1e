"""What the tests of the package share."""

import pytest

import hampm as package
from paths import PROGRAM


@pytest.fixture(autouse=True)
def the_program(monkeypatch):
    """The package runs the program that is tested."""
    monkeypatch.setenv("HAMPM", str(PROGRAM))


PLATE = """&run title = 'a crack in a plate'  plane = 'strain'  end_time = 1.0 /
&grid lower = -12e-3, -14e-3  cell = 2e-3  cells = 12, 14 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'steel'  lower = -12e-3, -12e-3  upper = 12e-3, 12e-3 /
&load kind = 'traction'  lower = -12e-3, 12e-3   upper = 12e-3, 12e-3   force = 0.0, 24e3 /
&load kind = 'traction'  lower = -12e-3, -12e-3  upper = 12e-3, -12e-3  force = 0.0, -24e3 /
&crack kind = 'path'  points = -4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3 /
&method time = 'static' /
&energy_release estimators = 'domain_integral' /
&output snapshot_interval = 1.0 /
"""


@pytest.fixture
def plate(tmp_path):
    """A plate under tension with a slanted crack, at rest."""
    (tmp_path / "plate.nml").write_text(PLATE)
    return package.Scene(tmp_path / "plate.nml")


@pytest.fixture(scope="session")
def plate_result(tmp_path_factory):
    """Its result."""
    folder = tmp_path_factory.mktemp("plate")
    (folder / "plate.nml").write_text(PLATE)
    return package.run(folder / "plate.nml", output=folder, progress=False, program=PROGRAM).path
