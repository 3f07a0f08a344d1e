"""Result files, as the package `hampm` of this checkout reads them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python/src"))
try:
    from hampm.stored import UNREADABLE, USAGE, ResultError, Stored, opened, plain, printable  # noqa: F401
except ImportError as missing:
    sys.exit(f"{missing}: run tools/setup.sh and use .venv/bin/python (gnuplot: set HAMPM_PYTHON to it)")
