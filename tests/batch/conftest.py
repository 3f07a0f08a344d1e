"""The scripts of batch/ as modules."""

import sys

from paths import BATCH

sys.path.insert(0, str(BATCH))
