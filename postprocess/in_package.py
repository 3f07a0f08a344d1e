"""Scripts and modules of this folder stand for those of `hampm.postprocess`, the package of this checkout, or that is installed beside them."""

import sys
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python/src"))
NEEDED = "run tools/setup.sh and use .venv/bin/python (gnuplot: set HAMPM_PYTHON to it)"


def hand_over(name, file):
    """Run the module of the package that has the name of this file where it is the program, else put it in the place of this one."""
    try:
        from hampm.scripts import run
        module = import_module(f"hampm.postprocess.{Path(file).stem}")
    except ImportError as missing:
        sys.exit(f"{missing}: {NEEDED}")
    if name == "__main__":
        run(module.main)
    sys.modules[name] = module
