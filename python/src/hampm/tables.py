"""Tables of text under a header, for terminals and notebooks."""

from html import escape


class Table:
    """Rows of text, each as many as the header has. `str` aligns them, a notebook shows them as a table."""

    def __init__(self, header, rows):
        self.header, self.rows = header, list(rows)

    def __iter__(self):
        return iter(self.rows)

    def __len__(self):
        return len(self.rows)

    def __str__(self):
        widths = [max(map(len, cells)) for cells in zip(self.header, *self.rows)]
        return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in (self.header, *self.rows))

    __repr__ = __str__

    def _repr_html_(self):
        def line(cells, tag):
            return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"
        return f"<table>{line(self.header, 'th')}{''.join(line(row, 'td') for row in self.rows)}</table>"
