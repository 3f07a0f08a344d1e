"""The scripts of batch/, and what tries them at random, as modules."""

import sys

from paths import BATCH, ROOT

sys.path[:0] = [str(BATCH), str(ROOT / "tests/fuzz")]
