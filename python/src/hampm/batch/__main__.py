"""`python -m hampm.batch` runs one case of a sweep, as `batch/run_case.py` does."""

import sys

from .case import main

sys.exit(main())
