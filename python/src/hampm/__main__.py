"""`python -m hampm plot g A.h5`: the commands of the package."""

import sys

from .commands import main
from .scripts import run

run(lambda: main(sys.argv[1:]))
