"""Groups of a namelist and their keys."""

import re
import sys
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, SupportsIndex, TypeVar

if TYPE_CHECKING:
    from .history import History
    from .scene import Scene

G = TypeVar("G", bound="Group")
PACKAGE = str(Path(__file__).parent)
ASIDE = re.compile(r"'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\"|![^\n]*")          # texts and comments
TOKEN = re.compile(r"&(\w+)|(?<![\w%])([a-z]\w*)\s*(?:\([^()]*\)\s*)?=|/", re.IGNORECASE)


class Place(NamedTuple):
    """Where a user has written something: a line of a file."""

    file: str
    line: int | None = None


class Group:
    """A group of a namelist: its keys are attributes, and items.

    Keys of the program that the model does not set are None: they have the defaults of `hampm --keys`. To set a key to None unsets it.
    Points are arrays (n, 2), pairs, or one number behind the other.
    """

    __slots__ = ("_values", "_name", "_keys", "_places")

    _values: dict[str, Any]
    _name: str
    _keys: dict[str, Any]
    _places: dict[str, Place]     # where its keys have been set, and under "" where it begins

    def __init__(self, name: str, keys: dict[str, Any], values: dict[str, Any]):
        for slot, value in (("_name", name), ("_keys", keys), ("_values", values), ("_places", {"": _place_of_caller()})):
            object.__setattr__(self, slot, value)

    def _copy(self: G, scene: Any) -> G:
        """A copy in another scene."""
        other = object.__new__(type(self))
        values = {key: list(value) if isinstance(value, list) else value for key, value in self._values.items()}
        own = {"_scene": scene} if isinstance(self, RunGroup) else {}
        other.__setstate__((None, {"_name": self._name, "_keys": self._keys, "_values": values, "_places": dict(self._places)} | own))
        return other

    def __setstate__(self, state: tuple[None, dict[str, Any]]) -> None:
        """A copy, or what comes from another process: slots are set as they are, not as keys."""
        for slot, value in state[1].items():
            object.__setattr__(self, slot, value)

    def _known(self, key: str) -> str:
        key = str(key).lower()
        if key not in self._keys:
            close = [name for name, row in self._keys.items() if key in row.get("also", "").split("|")] or get_close_matches(key, self._keys, 1)
            meant = f"; did you mean '{close[0]}'?" if close else f"; it has {', '.join(self._keys)}"
            raise AttributeError(f"&{self._name} has no key '{key}'{meant}")
        return key

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_"):
            raise AttributeError(key)
        value = self._values.get(self._known(key))
        return None if is_null(value) else value

    def __setattr__(self, key: str, value: Any) -> None:
        key = self._known(key)
        if is_null(value):
            self._values.pop(key, None)
        else:
            self._values[key] = flat(value)
            self._places[key] = _place_of_caller()

    def __getitem__(self, key: str) -> Any:
        try:
            return getattr(self, key)
        except AttributeError as error:
            raise KeyError(str(error)) from None

    def __setitem__(self, key: str, value: Any) -> None:
        try:
            setattr(self, key, value)
        except AttributeError as error:
            raise KeyError(str(error)) from None

    def __delattr__(self, key: str) -> None:
        self._values.pop(self._known(key), None)

    def __dir__(self) -> list[str]:
        return [*self._keys, "set", "items"]

    def __iter__(self) -> Iterator[str]:
        return iter(key for key, value in self._values.items() if not is_null(value))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Group) and self._name == other._name and dict(self.items()) == dict(other.items())

    __hash__ = None  # type: ignore[assignment]

    def set(self: G, **values: Any) -> G:
        """Set several keys. Returns the group."""
        for key, value in values.items():
            setattr(self, key, value)
        return self

    def items(self) -> list[tuple[str, Any]]:
        """(key, value) of the keys that are set."""
        return [(key, self._values[key]) for key in self]

    def __repr__(self) -> str:
        return f"&{self._name} " + "  ".join(f"{key} = {shown(value)}" for key, value in self.items()) + " /"


class RunGroup(Group):
    """The group &run, which runs the model where it is called."""

    __slots__ = ("_scene",)

    _scene: "Scene"

    def __call__(self, *, force: bool = False, **options: Any) -> "History":
        """Run the model to its end, as `hampm.run` does with these options, and read its history. An old result is replaced with `force` only."""
        from .running import run
        return run(self._scene, force=force, **options)


class GroupList(list[G]):
    """The groups of one name, in their order. `add(key=value, ...)` appends one."""

    def __init__(self, scene: Any, name: str, groups: list[G]):
        super().__init__(groups)
        self._scene, self._name = scene, name

    def add(self, **values: Any) -> G:
        """Append a group with these keys. Returns it."""
        group: G = self._scene.add(self._name, **values)
        self.append(group)
        return group

    def __delitem__(self, index: SupportsIndex | slice) -> None:
        for group in self[index] if isinstance(index, slice) else [self[index]]:
            self._scene._remove(group)
        super().__delitem__(index)


def is_null(value: Any) -> bool:
    """Whether a value leaves its key unset."""
    return value is None or isinstance(value, (list, tuple)) and all(item is None for item in value)


def plain(value: Any) -> Any:
    """A value as f90nml writes it: numbers of numpy as those of Python, arrays, tuples and ranges as lists, paths as text."""
    value = value.__array__().tolist() if hasattr(value, "__array__") else fspath(value) if isinstance(value, PathLike) else value
    return [plain(item) for item in value] if isinstance(value, Iterable) and not isinstance(value, (str, bytes, dict)) else value


def flat(value: Any) -> Any:
    """A value of a key: rows of an array, such as points, stand one behind the other."""
    value = plain(value)
    return [part for item in value for part in (flat(item) if isinstance(item, list) else [item])] if isinstance(value, list) else value


def places(text: str, file: str) -> list[dict[str, Place]]:
    """Where keys of each group of a namelist stand, and under "" where it begins."""
    found: list[dict[str, Place]] = []
    is_within = False
    text = ASIDE.sub(lambda aside: re.sub(r"[^\n]", " ", aside[0]), text)
    for token in TOKEN.finditer(text):
        group, key = token.groups()
        place = Place(file, text.count("\n", 0, token.start()) + 1)
        if group and not is_within:
            found.append({"": place})
        elif key and is_within:
            found[-1].setdefault(key.lower(), place)
        is_within = bool(group) or bool(key) and is_within
    return found


def _place_of_caller() -> Place:
    """The line outside of this package that is carried out; of a notebook in its cell, In [3]."""
    frame = sys._getframe(1)
    while frame.f_back and frame.f_code.co_filename.startswith(PACKAGE):
        frame = frame.f_back
    file, cells = frame.f_code.co_filename, frame.f_globals.get("In")
    if isinstance(cells, list) and re.search(r"ipykernel_\d+|^<ipython-input", file):
        file = f"In [{len(cells) - 1}]"
    return Place(file, frame.f_lineno)


def shown(value: Any) -> str:
    """A value as a namelist has it."""
    if isinstance(value, (list, tuple)):
        return ", ".join(map(shown, value))
    return f".{str(value).lower()}." if isinstance(value, bool) else repr(value)
