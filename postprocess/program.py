"""Where the program is that the scripts run when none is named."""

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def find_program(root=ROOT):
    """The release of these sources, or the program that is installed with these scripts (PREFIX/share/hampm, PREFIX/bin), or the one in PATH."""
    built, installed = root / "build/release/hampm", root.parent.parent / "bin/hampm"
    for path in (built, installed):
        if path.is_file():
            return path
    return Path(shutil.which("hampm") or built)
