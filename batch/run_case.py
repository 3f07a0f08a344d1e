#!/usr/bin/env python3
"""Run one case of a sweep in its own folder and record how it ended: `hampm.batch.case` of the package, which explains it."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python/src"))

from hampm.batch.case import main

if __name__ == "__main__":
    sys.exit(main())
