"""The JSON schema of models, `model.schema.json`, for editors and for programs that write models, and what a model breaks of it.

It is of what f90nml reads: {"grid": {"cell": 1e-3, ...}, "load": [{...}, {...}], ...}. It knows each key by itself: what keys need of each other, and
where things have to be, the program tells.
"""

import json
from collections.abc import Iterator
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

from .errors import Message
from .namelist import shown

TYPES: dict[str, tuple[type, ...]] = {"number": (int, float), "integer": (int,), "boolean": (bool,), "string": (str,)}


@cache
def model_schema() -> dict[str, Any]:
    """The schema, of the plane and of solids."""
    return json.loads((Path(__file__).parent / "model.schema.json").read_text(encoding="utf-8"))


def mistakes(groups: list[tuple[str, dict[str, Any]]]) -> Iterator[Message]:
    """What the groups of a model, (name, {key: value}) in their order, break of the schema."""
    schema = model_schema()
    there = {group for group, _ in groups}
    either = [one["required"][0] for one in schema["anyOf"]]
    needed = schema["required"][:1] + either[:not there.intersection(either)] + schema["required"][1:]
    for name in needed:
        if name not in there:
            yield Message(f"the group &{name} is missing: {schema['$defs'][name]['description']}", group=name)
    for name, values in groups:
        of = schema["$defs"][name]
        for key in of["required"]:
            if values.get(key) is None:
                yield Message(f"is missing: {of['properties'][key]['description']}", group=name, key=key)
        for key, value in values.items():
            if not _allows(of["properties"][key], value):
                yield Message(of["properties"][key]["errorMessage"], group=name, key=key, value=shown(value))


def _allows(schema: dict[str, Any], value: Any) -> bool:
    """Whether a value, or each of a list, is as a schema has it; null values stand for defaults."""
    if "anyOf" in schema:
        return any(_allows(one, value) for one in schema["anyOf"])
    if schema.get("type") == "array":
        return isinstance(value, (list, tuple)) and schema["minItems"] <= len(value) <= schema["maxItems"] and \
            all(item is None or _allows(schema["items"], item) for item in value)
    if isinstance(value, (list, tuple)):
        return len(value) == 1 and _allows(schema, value[0])
    if not isinstance(value, TYPES[schema["type"]]) or isinstance(value, bool) and schema["type"] != "boolean":
        return False
    if "enum" in schema:
        return str(value).lower().rstrip() in schema["enum"]
    if isinstance(value, str) or isinstance(value, bool):
        return True
    return schema.get("minimum", -inf) <= value <= schema.get("maximum", inf) and \
        schema.get("exclusiveMinimum", -inf) < value < schema.get("exclusiveMaximum", inf)
