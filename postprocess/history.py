"""What scripts and tests take from the package: histories, curves, and how scripts end."""

import sys

from in_package import NEEDED

try:
    from hampm.errors import UNREADABLE, USAGE, ResultError, printable  # noqa: F401
    from hampm.history import ERROR, OF_TIP, REST, History, error_name, is_error, is_rate, matches  # noqa: F401
    from hampm.scripts import add_strict, refuse_to_replace, run, tell, tell_of_motion  # noqa: F401
    from hampm.signals import Mode, first_frequency, fit_modes, lowpass, moving_mean, read_curve  # noqa: F401
    from hampm.stored import opened  # noqa: F401
except ImportError as missing:
    sys.exit(f"{missing}: {NEEDED}")
