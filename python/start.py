#!python
"""Start the program that has the name of this file, hampm or hampm3d: it is in the package, which has its libraries beside it."""

import os
import sys

name = os.path.basename(os.path.realpath(__file__))
for folder in sys.path:
    program = os.path.join(folder, "hampm", "bin", name)
    if os.path.isfile(program):
        os.execv(program, sys.argv)
sys.exit(f"{name}: the package hampm of this Python is without its programs: install it anew")
