"""Tables of text under a header, for terminals and notebooks."""

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Generic, TypeVar


R = TypeVar("R", bound=Sequence[str])


class Table(Generic[R]):
    """Rows of text, each as many as the header has. `str` aligns them, a notebook shows them as a table."""

    def __init__(self, header: Sequence[str], rows: Iterable[R]):
        self.header, self.rows = header, list(rows)

    def __iter__(self) -> Iterator[R]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __str__(self) -> str:
        rows: list[Sequence[str]] = [self.header, *self.rows]
        widths = [max(map(len, cells)) for cells in zip(*rows)]
        return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        def line(cells: Sequence[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"
        return f"<table>{line(self.header, 'th')}{''.join(line(row, 'td') for row in self.rows)}</table>"
