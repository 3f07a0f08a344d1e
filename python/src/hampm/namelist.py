"""Groups of a namelist and their keys."""

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, SupportsIndex, TypeVar

G = TypeVar("G", bound="Group")


class Group:
    """A group of a namelist: its keys are attributes, and items.

    Keys of the program that the model does not set are None: they have the defaults of `hampm --keys`. To set a key to None unsets it.
    """

    __slots__ = ("_values", "_name", "_keys")

    _values: dict[str, Any]
    _name: str
    _keys: dict[str, Any]

    def __init__(self, name: str, keys: dict[str, Any], values: dict[str, Any]):
        for slot, value in (("_name", name), ("_keys", keys), ("_values", values)):
            object.__setattr__(self, slot, value)

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
            self._values[key] = plain(value)

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
    """A value of numpy or a tuple as f90nml writes it."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def shown(value: Any) -> str:
    """A value as a namelist has it."""
    if isinstance(value, (list, tuple)):
        return ", ".join(map(shown, value))
    return f".{str(value).lower()}." if isinstance(value, bool) else repr(value)
