"""requirements.lock serves every Python that is promised: resolved for each from wheels alone, without installing anything."""

import re
import subprocess

import pytest

from paths import ROOT

LOCK = ROOT / "tools/lock.sh"
PINS = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(), re.MULTILINE))


def normal(name):
    """A name as the index of packages has it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_python_gets_all_packages_from_wheels():
    """From 3.11.2, which Debian 12 has, to the newest; asked of the index of packages, where that can be reached."""
    run = subprocess.run([LOCK, "--check"], capture_output=True, text=True, timeout=300)
    if run.returncode == 3:
        pytest.skip(f"the index of packages cannot be reached: {run.stderr.splitlines()[0]}")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert re.search(r'^pythons="3\.11\.2 ', LOCK.read_text(), re.MULTILINE)


def test_parts_name_the_versions_of_the_lock():
    """Of every Python but those older than the lock."""
    files = (ROOT / "requirements.txt").read_text().split()[1::2]
    rows = [line for file in files for line in (ROOT / file).read_text().splitlines() if line[0] != "#"]
    named = [re.fullmatch(r"([\w.-]+)==([\w.]+)(?:; (.*))?", row).groups() for row in rows]
    assert {name: version for name, version, where in named if where != 'python_version < "3.11"' and PINS.get(normal(name)) not in (version, version.removesuffix(".0"))} == {}


def test_a_package_has_one_version():
    """Whatever the Python."""
    lines = [line for line in (ROOT / "requirements.lock").read_text().splitlines() if line[0] != "#"]
    assert len(PINS) == len(lines) and all(name == normal(name) for name in PINS)


def test_another_word_is_told_what_there_is():
    run = subprocess.run([LOCK, "--chekc"], capture_output=True, text=True)
    assert run.returncode == 2 and "--check" in run.stderr
