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
