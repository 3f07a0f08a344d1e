"""What the measuring scripts share: their command line, tables of references, and tables on the screen, as CSV and in documents."""

import argparse
import csv
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def write(rows, name, folder):
    """Print a table, the first row being its head, and write it as FOLDER/NAME.csv."""
    with open(folder / f"{name}.csv", "w", newline="") as file:
        csv.writer(file).writerows(rows)
    widths = [max(len(str(row[k])) for row in rows) for k in range(len(rows[0]))]
    print(f"\n{name}: {folder / name}.csv")
    for row in rows:
        print("  ".join(str(value).ljust(width) for value, width in zip(row, widths)).rstrip())
    sys.stdout.flush()


def reference(path):
    """The rows of a table as dictionaries; lines that begin with # say where it is from."""
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def rewrite(name, lines, text, path):
    """The text of a document with what stands between the two markers of a name replaced; `path` names it in a message."""
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"{path} has no markers of {name}")
    return pattern.sub(lambda match: match[1] + "\n".join(lines) + "\n" + match[2], text)


def command_line(description, parts, folder, program=ROOT / "build/release/hampm", **numbers):
    """The arguments of a script that measures `parts` of a program and writes into `folder`; `numbers`: name=(default, help)."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", nargs="*", help=f"{', '.join(parts)}; default: all")
    parser.add_argument("--output", metavar="DIR", type=Path, default=Path(folder), help="folder of the tables")
    parser.add_argument("--program", metavar="FILE", type=Path, default=program)
    for name, (default, text) in numbers.items():
        parser.add_argument(f"--{name}", metavar="FILE" if isinstance(default, Path) else "N", type=type(default), default=default, help=text)
    arguments = parser.parse_args()
    arguments.part = arguments.part or parts
    if set(arguments.part) - set(parts):
        parser.error(f"a part is {', '.join(parts[:-1])} or {parts[-1]}")
    if not arguments.program.is_file():
        sys.exit(f"{arguments.program}: no such program; build it with make")
    arguments.output.mkdir(parents=True, exist_ok=True)
    return arguments
