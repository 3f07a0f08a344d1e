#!python
"""Start the program that has the name of this file, hampm or hampm3d: it is in the package, which has its libraries beside it; or a command of the package."""

import os
import sys

name = os.path.basename(os.path.realpath(__file__))
for folder in sys.path:
    program = os.path.join(folder, "hampm", "bin", name)
    if os.path.isfile(program):
        word = sys.argv[1].replace("-", "_") if len(sys.argv) > 1 else "-"
        if word == "plot" or os.path.isfile(os.path.join(folder, "hampm", "postprocess", word + ".py")):   # pictures and tables: of Python
            os.execv(sys.executable, [sys.executable, "-m", "hampm", *sys.argv[1:]])
        os.execv(program, sys.argv)
sys.exit(f"{name}: the package hampm of this Python is without its programs: install it anew")
