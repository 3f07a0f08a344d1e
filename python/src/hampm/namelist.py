"""Groups of a namelist and their keys."""

from difflib import get_close_matches
from typing import TypeVar

G = TypeVar("G", bound="Group")


class Group:
    """A group of a namelist: its keys are attributes, and items.

    Keys of the program that the model does not set are None: they have the defaults of `hampm --keys`. To set a key to None unsets it.
    """

    __slots__ = ("_values", "_name", "_keys")

    def __init__(self, name, keys, values):
        for slot, value in (("_name", name), ("_keys", keys), ("_values", values)):
            object.__setattr__(self, slot, value)

    def _known(self, key: str) -> str:
        key = str(key).lower()
        if key not in self._keys:
            close = get_close_matches(key, self._keys, 1)
            meant = f"; did you mean '{close[0]}'?" if close else f"; it has {', '.join(self._keys)}"
            raise AttributeError(f"&{self._name} has no key '{key}'{meant}")
        return key

    def __getattr__(self, key):
        if key.startswith("_"):
            raise AttributeError(key)
        value = self._values.get(self._known(key))
        return None if is_null(value) else value

    def __setattr__(self, key, value):
        key = self._known(key)
        if is_null(value):
            self._values.pop(key, None)
        else:
            self._values[key] = plain(value)

    def __getitem__(self, key):
        try:
            return getattr(self, key)
        except AttributeError as error:
            raise KeyError(str(error)) from None

    def __setitem__(self, key, value):
        try:
            setattr(self, key, value)
        except AttributeError as error:
            raise KeyError(str(error)) from None

    def __delattr__(self, key):
        self._values.pop(self._known(key), None)

    def __dir__(self):
        return [*self._keys, "set", "items"]

    def __iter__(self):
        return iter(key for key, value in self._values.items() if not is_null(value))

    def __eq__(self, other):
        return isinstance(other, Group) and self._name == other._name and dict(self.items()) == dict(other.items())

    __hash__ = None

    def set(self, **values) -> "Group":
        """Set several keys. Returns the group."""
        for key, value in values.items():
            setattr(self, key, value)
        return self

    def items(self) -> list[tuple[str, object]]:
        """(key, value) of the keys that are set."""
        return [(key, self._values[key]) for key in self]

    def __repr__(self):
        return f"&{self._name} " + "  ".join(f"{key} = {shown(value)}" for key, value in self.items()) + " /"


class GroupList(list[G]):
    """The groups of one name, in their order. `add(key=value, ...)` appends one."""

    def __init__(self, scene, name: str, groups: list[G]):
        super().__init__(groups)
        self._scene, self._name = scene, name

    def add(self, **values) -> G:
        """Append a group with these keys. Returns it."""
        group = self._scene.add(self._name, **values)
        self.append(group)
        return group

    def __delitem__(self, index):
        for group in self[index] if isinstance(index, slice) else [self[index]]:
            self._scene._remove(group)
        super().__delitem__(index)


def is_null(value):
    return value is None or isinstance(value, (list, tuple)) and all(item is None for item in value)


def plain(value):
    """A value of numpy or a tuple as f90nml writes it."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def shown(value):
    if isinstance(value, (list, tuple)):
        return ", ".join(map(shown, value))
    return f".{str(value).lower()}." if isinstance(value, bool) else repr(value)
