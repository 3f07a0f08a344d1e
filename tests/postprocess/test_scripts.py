"""What all scripts share: help, a line in the README, and pictures that need no display."""

import re

import pytest

from paths import ROOT, SCRIPTS

PROGRAMS = sorted(path.name for path in SCRIPTS.glob("*.py") if '__name__ == "__main__"' in path.read_text())


@pytest.mark.parametrize("name", PROGRAMS)
def test_each_has_help(script, name):
    result = script(name, "--help")
    assert result.returncode == 0 and result.stdout.startswith("usage: ")


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_readme_names_each(name):
    assert f"`postprocess/{name} " in (ROOT / "README.md").read_text()


def test_only_one_module_sets_matplotlib_up():
    """So that all pictures look alike and are drawn without a display."""
    modules = [path for folder in (SCRIPTS, ROOT / "bench") for path in folder.glob("*.py")]
    direct = [path.name for path in modules if re.search(r"^import matplotlib|import pyplot", path.read_text(), re.MULTILINE)]
    assert direct == ["pictures.py"]
