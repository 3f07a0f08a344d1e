"""The command `hampm WORDS ...` beside runs: hampm plot g A.h5, hampm compare A.h5 B.h5. Where the program is built and not installed: python -m hampm."""

import sys
from importlib import import_module
from pathlib import Path

FOLDER = Path(__file__).parent / "postprocess"


def commands() -> dict[str, str]:
    """Words -> module of `postprocess` of each command."""
    modules = (path.stem for path in sorted(FOLDER.glob("*.py")) if "\ndef main(" in path.read_text())
    return {name.replace("plot_", "plot "): name for name in modules}


def main(words: list[str]) -> int | None:
    """Run a command by its words; without any, list them."""
    known = commands()
    for count in (2, 1):
        name = " ".join(words[:count]).replace("-", "_")
        if len(words) >= count and name in known:
            sys.argv[0] = f"hampm {name}"
            module = import_module(f".postprocess.{known[name]}", __package__)
            return module.main(words[count:])
    wanted = [name for name in known if words and name.split()[0] == words[0]] or known
    lines = [f"{'hampm ' + name:28}{first_line(known[name])}" for name in wanted]
    print(*lines, sep="\n", file=sys.stdout if not words or words[-1] in ("--help", "-h") else sys.stderr)
    return 0 if not words or words[-1] in ("--help", "-h") else 2


def first_line(name: str) -> str:
    """What a command does."""
    return (FOLDER / f"{name}.py").read_text().lstrip('"').partition("\n")[0].rstrip('"')
