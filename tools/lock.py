"""Write requirements.lock: the version of every Python package that those of requirements.txt need, as .venv has them.

    .venv/bin/python tools/lock.py [--check]

With --check nothing is written, and exit code 1 tells that the file is not what .venv has.
"""

import re
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEAD = "# Written by tools/lock.py: what the packages of requirements.txt need, for Python 3.11 or later on Linux.\n"


def name_of(requirement):
    """The normal form of the name of the package that a line of a requirements file, or of a package's needs, begins with."""
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", requirement)[0]).lower()


def is_for_an_extra(requirement):
    """Whether only those who ask for an extra of a package need this."""
    return re.search(r";.*\bextra\b", requirement)


def needed(requirements):
    """The versions of these packages and of all that they need, by name. What is not installed is for another system."""
    versions, open_names = {}, [name_of(line) for line in requirements]
    while open_names:
        name = open_names.pop()
        if name in versions:
            continue
        try:
            package = distribution(name)
        except PackageNotFoundError:
            continue
        versions[name] = package.version
        open_names += [name_of(text) for text in package.requires or () if not is_for_an_extra(text)]
    return versions


def lock():
    """The text of requirements.lock."""
    requirements = (ROOT / "requirements.txt").read_text().split("\n")
    versions = needed(line for line in requirements if line.strip())
    return HEAD + "".join(f"{name}=={versions[name]}\n" for name in sorted(versions))


if __name__ == "__main__":
    file = ROOT / "requirements.lock"
    if sys.argv[1:] == ["--check"]:
        sys.exit(not file.exists() or file.read_text() != lock())
    file.write_text(lock())
