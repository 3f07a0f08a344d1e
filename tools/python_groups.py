#!/usr/bin/env python3
"""Print the module `hampm.groups`, which tells editors the groups and keys of models: their types, units, defaults and meaning.

    .venv/bin/python tools/python_groups.py > python/src/hampm/groups.py
"""

import sys
from keyword import iskeyword
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python/src"))

from hampm.program import key_table  # noqa: E402

TYPES = {"real": "float", "integer": "int", "logical": "bool", "text": "str"}
HEAD = '''"""The groups of a model and their keys, for editors and checkers of types: what `hampm --keys --json` says, printed by tools/python_groups.py."""

from collections.abc import Sequence
from typing import Literal

from .namelist import Group, GroupList
'''


def main():
    table = key_table()
    print(HEAD, end="")
    for name, group in table.items():
        print(f"\n\nclass {class_name(name)}(Group):")
        print(f'    """{sentence(group["meaning"])}"""\n')
        for key in group["keys"].values():
            if iskeyword(key["key"]):
                print(f"    # {key['key']}, a word of Python: group[\"{key['key']}\"]: {type_of(key)}; {about(key)}")
                continue
            print(f"    {key['key']}: {type_of(key)}")
            print(f'    """{about(key)}"""')
    print("\n\nclass Groups:\n    \"\"\"The groups of a model.\"\"\"\n")
    for name, group in table.items():
        print(f"    {name}: {f'GroupList[{class_name(name)}]' if group['repeats'] else class_name(name)}")
        print(f'    """{sentence(group["meaning"])}"""')


def class_name(group):
    return "".join(word.capitalize() for word in group.split("_"))


def sentence(text):
    return text[0].upper() + text[1:] + "."


def type_of(key):
    """The type of the value of a key that is set, or None."""
    one = f"Literal[{', '.join(map(repr, key['choices']))}]" if key.get("choices") else TYPES[key["type"]]
    return f"{one} | Sequence[{one}] | None" if key["most"] > 1 else f"{one} | None"


def about(key):
    """Meaning, unit, range and default of a key."""
    words = [sentence(key["meaning"]).rstrip(".") + (f" [{key['unit']}]" if key["unit"] else "")]
    if key.get("allowed"):
        words.append(key["allowed"])
    words.append("required" if key["required"] else "no default" if key["default"] in (None, []) else f"default {key['default']!r}")
    return "; ".join(words).replace("\\", "")


if __name__ == "__main__":
    main()
