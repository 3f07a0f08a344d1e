#!/usr/bin/env python3
"""Print the module `hampm.groups`, which tells editors the groups and keys of models: their types, units, defaults and meaning. Or the JSON
schema of models as f90nml reads them, of the plane and of solids:

    .venv/bin/python tools/python_groups.py > python/src/hampm/groups.py
    .venv/bin/python tools/python_groups.py --schema > python/src/hampm/model.schema.json

Or the columns of results, of the tables of docs/reference/results.md:

    .venv/bin/python tools/python_groups.py --columns > python/src/hampm/columns.json
"""

import json
import re
import sys
from keyword import iskeyword
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python/src"))

from hampm.program import SOLID, find_program, key_table  # noqa: E402

PAGE = Path(__file__).resolve().parents[1] / "docs/reference/results.md"
LATTICE = "grid"        # the group that a model needs unless its errors are asked: then it may be chosen
TYPES = {"real": "float", "integer": "int", "logical": "bool", "text": "str"}
HEAD = '''"""The groups of a model and their keys, for editors and checkers of types: what `hampm --keys --json` says, printed by tools/python_groups.py."""

from collections.abc import Sequence
from typing import Literal

from .namelist import Group, GroupList, RunGroup
'''


def main():
    if sys.argv[1:] == ["--schema"]:
        print(in_lines(schema_of(key_table(), key_table(find_program(dimensions=SOLID))), 4))
        return
    if sys.argv[1:] == ["--columns"]:
        print("[\n " + ",\n ".join(json.dumps(column, ensure_ascii=False) for column in columns_of(PAGE.read_text())) + "\n]")
        return
    table = key_table()
    print(HEAD, end="")
    for name, group in table.items():
        print(f"\n\nclass {class_name(name)}({'RunGroup' if name == 'run' else 'Group'}):")
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


# --- the columns of results ---------------------------------------------------------------------------------------------

def columns_of(page):
    """Name, unit, meaning and where it is recorded of each column in the tables of a page. Those of fronts, which have names of histories, come last."""
    found = {}
    for head, name, *about in columns_in_tables(page):
        found.setdefault((head.startswith("| of solids"), re.sub(r"^J_\d$", "J_[0-9]+", name)), dict(zip(("unit", "meaning", "recorded"), about)))
    return [{"name": name} | about for (_, name), about in sorted(found.items(), key=lambda item: item[0][0])]


def columns_in_tables(page):
    """Head of the table, name, unit, meaning and where it is recorded of each column. A name such as `_y` has the beginning of the first of its row;
    behind ± each name has a column of its estimated error."""
    for head, table in re.findall(r"^(\|[^\n]*column[^\n]* \| units \|[^\n]*|\| of solids \| units \|[^\n]*)\n\|[-|]+\n((?:\|[^\n]*\n)+)", page, re.MULTILINE):
        for row in table.splitlines():
            names, unit, meaning, recorded = (cell.strip() for cell in row.strip("|").split(" | "))
            recorded = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", recorded).replace("`", "")
            first, *others = re.findall(r"`([\w<>]+)`", names)
            for name in (first, *(first.rpartition("_")[0] + other if other.startswith("_") else other for other in others)):
                part, of_first = (re.search(r"_(I+|[xyz]+)(?=_by|$)", word) for word in (name, first))
                yield head, name, unit, re.sub(rf"\b{of_first[1]}$", part[1], meaning) if part and of_first else meaning, recorded
                if names.endswith("±"):
                    yield head, f"{name}_error", unit, f"estimated error of {name}", recorded


# --- the JSON schema ----------------------------------------------------------------------------------------------------

def schema_of(plane, solid):
    """The schema, from the tables of keys of both programs."""
    groups = {name: {"type": "object", "description": group["meaning"], "additionalProperties": False,
                     "required": [key["key"] for key in group["keys"].values() if key["required"]],
                     "properties": {key: schema_of_key(row, solid[name]["keys"][key]) for key, row in group["keys"].items()}}
              for name, group in plane.items()}
    places = {name: {"$ref": f"#/$defs/{name}"} for name in groups}
    for name, group in plane.items():
        if group["repeats"]:
            places[name] = {"anyOf": [places[name], {"type": "array", "items": places[name]}]}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "model of hampm", "type": "object",
            "description": "The groups of a namelist and their keys, in lower case, as f90nml reads them. Numbers are in SI units.",
            "required": [name for name, group in plane.items() if group["required"] and name != LATTICE],
            "anyOf": [{"required": [LATTICE]}, {"required": ["accuracy"]}], "additionalProperties": False, "properties": places, "$defs": groups}


def in_lines(value, depth):
    """JSON whose outer levels have a member a line."""
    if depth == 0 or not isinstance(value, dict):
        return json.dumps(value)
    return "{\n" + ",\n".join(f"{json.dumps(name)}: {in_lines(of, depth - 1)}" for name, of in value.items()) + "\n}"


def schema_of_key(key, solid):
    """The schema of the value of a key: one, or a list of as many as it takes in the plane or in solids."""
    one = {"type": {"real": "number", "logical": "boolean", "text": "string"}.get(key["type"], key["type"])}
    must = "must be text" if key["type"] == "text" else "must be true or false"
    if "choices" in key:
        one["enum"] = list(dict.fromkeys(key["choices"] + solid["choices"]))
        must = f"must be {', '.join(map(repr, one['enum'][:-1]))} or {one['enum'][-1]!r}"
    if "allowed" in key:
        lower, upper = key["allowed"][1:-1].split(", ")
        for bound, name, is_open in ((lower, "inimum", key["allowed"][0] == "("), (upper, "aximum", key["allowed"][-1] == ")")):
            if "inf" not in bound:
                one[f"exclusiveM{name}" if is_open else f"m{name}"] = float(bound)
        must = f"must be {'an integer ' if key['type'] == 'integer' else ''}in {key['allowed']}"
    unit = f" [{key['unit']}]" if key["unit"] else ""
    fewest, most = min(key["fewest"], solid["fewest"]), max(key["most"], solid["most"])
    value = one
    if most > 1:
        value = {"type": "array", "items": one, "minItems": fewest, "maxItems": most}
        value = {"anyOf": [one, value]} if fewest <= 1 else value
        must = f"must be {fewest} to {most} values, each {must.removeprefix('must be ')}"
    default = {} if key["default"] in (None, []) else {"default": key["default"]}
    return {**value, "description": key["meaning"] + unit, **default, "errorMessage": must + unit}


if __name__ == "__main__":
    main()
