"""The ledger of a release, with parts of its own in a repository of its own; and the parts that there are."""

import csv
import os
import re
import signal
import subprocess
import sys
import time
import tomllib

import pytest

from paths import ROOT

SCRIPT, PARTS = ROOT / "tools/release_check.py", ROOT / "tools/release_parts.toml"
PAGE = "# Page\n\n<!-- release -->\n<!-- end of release -->\nBehind.\n"


class Checkout:
    """A repository with parts, by name: the lines of a shell and other keys."""

    def __init__(self, folder):
        self.root, self.parts = folder / "source", folder / "parts.toml"
        (self.root / "docs/evidence").mkdir(parents=True)
        (self.root / "docs/evidence/release.md").write_text(PAGE)
        (self.root / ".gitignore").write_text("build/\n")
        (self.root / "file").write_text("1\n")
        self.git("init", "-q")
        self.commit()

    def git(self, *words):
        return subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=self.root, check=True, capture_output=True, text=True).stdout

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "a")

    def declare(self, **parts):
        lines = [f'[[part]]\nname = "{name}"\ngroup = "g"\nwhat = "{name} of it"\ncommands = {[command]}\n{more}\n' for name, (command, more) in parts.items()]
        self.parts.write_text("\n".join(lines))

    def command(self, *words):
        return [sys.executable, SCRIPT, "--root", self.root, "--parts", self.parts, *words]

    def run(self, *words):
        return subprocess.run(self.command(*words), capture_output=True, text=True, timeout=60)

    @property
    def rows(self):
        with open(self.root / "docs/evidence/release.csv", newline="") as file:
            return [(row["part"], row["result"], row["failed"]) for row in csv.DictReader(file)]

    @property
    def page(self):
        return (self.root / "docs/evidence/release.md").read_text()


@pytest.fixture
def checkout(tmp_path):
    return Checkout(tmp_path)


def test_what_has_passed_is_not_run_again_and_the_exit_code_tells(checkout):
    checkout.declare(good=("true", ""), bad=("echo 'FAILED tests/a.py::test_b - no'; test -e build/mended", ""), last=("true", ""))
    first = checkout.run()
    assert first.returncode == 1 and first.stderr.endswith(": bad\n")
    assert checkout.rows == [("good", "passed", ""), ("bad", "failed", "tests/a.py::test_b"), ("last", "passed", "")]
    (checkout.root / "build/mended").write_text("")
    second = checkout.run()
    assert (second.returncode, second.stdout) == (0, "bad: passed\n")
    assert "| 3 | 3 |" in checkout.page and checkout.page.startswith("# Page\n") and checkout.page.endswith("Behind.\n")
    assert checkout.run("--list").returncode == 0 and checkout.run().stdout == ""
    assert checkout.run("good", "--again").stdout == "good: passed\n"


def test_a_part_of_another_commit_is_shown_as_such(checkout):
    checkout.declare(one=("true", ""))
    checkout.run()
    checkout.commit()                                # of the ledger alone: the state is the same
    assert checkout.run("--list").returncode == 0
    (checkout.root / "VERSION").write_text("3.0.0\n")
    checkout.commit()
    assert checkout.run("--list").returncode == 0
    (checkout.root / "file").write_text("2\n")
    checkout.commit()
    listed = checkout.run("--list")
    assert listed.returncode == 1 and listed.stdout == "one  passed, on another commit\n"
    checkout.run("--page")
    assert "passed, on another commit" in checkout.page
    assert checkout.run().returncode == 0 and [row[0] for row in checkout.rows] == ["one", "one"]


def test_a_checkout_with_changes_is_refused(checkout):
    checkout.declare(one=("true", ""))
    (checkout.root / "file").write_text("2\n")
    result = checkout.run()
    assert result.returncode == 1 and "is not clean:\n M file\n" in result.stderr
    assert not (checkout.root / "docs/evidence/release.csv").exists()


def test_what_a_part_changes_is_put_back_and_kept(checkout):
    checkout.declare(one=("echo 2 > file; touch new", ""))
    checkout.run()
    assert checkout.rows == [("one", "passed", "wrote anew: file; left: new")]
    assert (checkout.root / "file").read_text() == "1\n" and "+2" in (checkout.root / "build/release_check/one.diff").read_text()


def test_a_part_ends_at_its_limit_with_all_that_it_started(checkout):
    checkout.declare(long=("sleep 50 & echo $! > build/child; wait", "minutes = 0.01"), next=("true", ""))
    (checkout.root / "build").mkdir()
    assert checkout.run().returncode == 1
    assert checkout.rows == [("long", "stopped", "not done after 0.01 minutes"), ("next", "passed", "")]
    with pytest.raises(ProcessLookupError):
        os.kill(int((checkout.root / "build/child").read_text()), 0)


def test_one_that_is_stopped_by_hand_goes_on_where_it_was(checkout):
    checkout.declare(one=("true", ""), two=("test -e build/second || { touch build/begun; sleep 50; }", ""), three=("true", ""))
    process = subprocess.Popen(checkout.command(), stdout=subprocess.PIPE, text=True)
    while not (checkout.root / "build/begun").exists():
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=30)[0] == "one: passed\ntwo: stopped: by hand\n" and process.returncode == 1
    (checkout.root / "build/second").write_text("")
    assert checkout.run().stdout == "two: passed\nthree: passed\n"


def test_what_a_part_needs_is_told(checkout):
    checkout.declare(one=("true", 'needs = ["no_such_command"]'))
    assert checkout.run().returncode == 1
    assert checkout.rows == [("one", "not possible here", "needs no_such_command")]


def test_an_unknown_part_is_refused(checkout):
    checkout.declare(one=("true", ""))
    assert "no part two; there are one" in checkout.run("two").stderr


# --- the parts --------------------------------------------------------------------------------------------------------

ALL = tomllib.loads(PARTS.read_text())["part"]


def test_each_part_has_a_name_of_its_own_and_at_most_40_minutes():
    names = [part["name"] for part in ALL]
    assert len(set(names)) == len(names) and all(part.get("minutes", 40) <= 40 for part in ALL)


@pytest.mark.parametrize("part", ALL, ids=[part["name"] for part in ALL])
def test_what_a_part_runs_is_there(part):
    for command in part["commands"]:
        for word in re.findall(r"(?:tools|tests|bench|input)/[\w/]+\.(?:py|sh|nml)", command):
            assert (ROOT / word).exists(), word
        if found := re.match(r"make (-C bench )?(.*)", command):
            makefile = (ROOT / ("bench/Makefile" if found[1] else "Makefile")).read_text()
            for target in (word for word in found[2].split() if word[0] != "-" and "=" not in word and not word.startswith("build/")):
                assert re.search(rf"^{re.escape(target)}:", makefile, re.MULTILINE), target


def test_each_test_that_takes_long_is_in_one_part():
    asked = [word for part in ALL for command in part["commands"] if "-m verify " in command for word in command.split() if word.startswith("tests/")]
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        name = path.relative_to(ROOT)
        assert sum(name.match(word) or word in map(str, name.parents) for word in asked) == 1, name
