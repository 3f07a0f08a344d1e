"""YAML as it is written: every value as its text, every text with the line where it stands."""

from pathlib import Path
from typing import Any

import yaml

from ..errors import UNREADABLE, ResultError, printable

MOST = 100_000  # values and letters that a file may come to by its aliases, beside ten times its own


class Text(str):
    """A text of a file and its line: `1.25e-3` stays what it is, and `no` does not become a truth value."""

    line: int = 0


def read_yaml(path: str | Path) -> Any:
    """The file's content as dictionaries, lists and Text; ResultError where it is none, or a key stands twice."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except (OSError, UnicodeDecodeError) as error:
        raise ResultError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})", UNREADABLE) from error
    except yaml.YAMLError as error:
        line = getattr(getattr(error, "problem_mark", None), "line", 0) + 1
        cause = getattr(error, "problem", None) or str(error).partition("\n")[0]
        raise ResultError(f"{path}:{line}: no YAML: {printable(cause)}") from error
    except RecursionError as error:
        raise ResultError(f"{path}:1: lists and keys are nested too deeply") from error
    try:
        return _Plain(path, MOST + 10 * len(text)).of(node) if node else {}
    except RecursionError as error:
        raise ResultError(f"{path}:1: lists and keys are nested too deeply, or contain themselves") from error


class _Plain:
    """Nodes as dictionaries, lists and Text, as long as they have not more than so many values and letters together: an alias stands for all
    that it names, and a few lines of aliases of aliases would fill any memory."""

    def __init__(self, path: str | Path, most: int):
        self._path, self._left = path, most

    def of(self, node: yaml.Node) -> Any:
        self._left -= 1 + (len(node.value) if isinstance(node, yaml.ScalarNode) else 0)
        if self._left < 0:
            raise ResultError(f"{self._path}:{node.start_mark.line + 1}: aliases make too much of this file")
        if isinstance(node, yaml.SequenceNode):
            return [self.of(item) for item in node.value]
        if isinstance(node, yaml.MappingNode):
            items = {}
            for key, value in node.value:
                text = _text(key)
                if text in items:
                    raise ResultError(f"{self._path}:{text.line}: '{printable(text)}' stands twice")
                items[text] = self.of(value)
            return items
        return _text(node)


def _text(node: yaml.Node) -> Text:
    text = Text(node.value if isinstance(node, yaml.ScalarNode) else "?")
    text.line = node.start_mark.line + 1
    return text
