"""Fixtures that all tests of the program share."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent


@pytest.fixture
def hampm(tmp_path):
    """The program as a function: `hampm(*arguments, cwd=..., **options of subprocess.run)`, output as text.

    It runs in the test's own folder. The environment variable HAMPM names another build than the release build.
    """
    program = str((ROOT / os.environ.get("HAMPM", "build/release/hampm")).resolve())

    def run(*arguments, cwd=tmp_path, **options):
        options = {"timeout": 120, "errors": "replace"} | options
        return subprocess.run([program, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, **options)

    return run
