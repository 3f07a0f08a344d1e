"""What the scripts take from the package `hampm` of this checkout, or that is installed beside them: histories, curves, and how scripts end."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python/src"))
try:
    from hampm.errors import UNREADABLE, USAGE, ResultError, printable  # noqa: F401
    from hampm.history import ERROR, OF_TIP, REST, History, error_name, is_error, is_rate, matches  # noqa: F401
    from hampm.scripts import add_strict, refuse_to_replace, run, tell, tell_of_motion  # noqa: F401
    from hampm.signals import Mode, first_frequency, fit_modes, lowpass, moving_mean, read_curve  # noqa: F401
    from hampm.stored import opened  # noqa: F401
except ImportError as missing:
    sys.exit(f"{missing}: run tools/setup.sh and use .venv/bin/python (gnuplot: set HAMPM_PYTHON to it)")
