"""The package `hampm` of this checkout, or that is installed beside these scripts, which are its command line for sweeps."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "python/src"))

try:
    from hampm.batch import yaml_text  # noqa: F401
    from hampm.batch.declaration import read_sweep  # noqa: F401
    from hampm.program import program_of_model, program_of_scripts  # noqa: F401
    from hampm.scripts import ResultError, run  # noqa: F401
except ImportError as missing:
    sys.exit(f"{missing}: run tools/setup.sh batch with a Python of 3.11 to 3.13 and use .venv/bin/python")

PROGRAM = program_of_scripts()
