"""Tables for a terminal of any width: columns narrow between words and never inside one; what is wider still is rearranged."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from rich import console as rich_console
from rich.box import SIMPLE_HEAD, Box
from rich.measure import Measurement
from rich.table import Column
from rich.table import Table as RichTable
from rich.text import Text

from tuner.cli.terminal import Console
from tuner.text.tables import Table

# A pipe has no width, and 80 columns would fold meanings into ribbons.
PIPE_WIDTH = 160
# Columns between two columns of a table.
GAP = 2


def wide_console() -> Console:
    """Return a console with the width of COLUMNS, the terminal or `PIPE_WIDTH`.

    COLUMNS comes first; `PIPE_WIDTH` is that of a pipe.
    """
    has_width = sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdigit()
    return Console(width=None if has_width else PIPE_WIDTH)


def say_files(console: Console, **files: Path) -> None:
    """Print where files lie, a line each, which no width breaks."""
    for name, path in files.items():
        console.print(f"{name}: {path}", markup=False, soft_wrap=True)


class TerminalTable(RichTable):
    """A table that fits: the widest columns wrap between words, those with no_wrap stay whole; a blank line follows a title's.

    If that is not enough, a table with keys is split into several, each with those first columns; one without becomes a
    block for each row, a line for each column.
    """

    def __init__(
        self, title: str = "", *, keys: int = 0, box: Box | None = SIMPLE_HEAD, show_header: bool = True
    ) -> None:
        super().__init__(title=title or None, box=box, show_header=show_header)
        self.keys = keys

    def columns_of(self, *names: str, left: Sequence[str] = (), wrap: Sequence[str] = ()) -> "TerminalTable":
        """Add columns, right-aligned and unwrapped by default; return the table.

        left, wrap: names of left-aligned columns, and of those that may wrap.
        """
        for name in names:
            self.add_column(name, justify="left" if name in left else "right", no_wrap=name not in wrap)
        return self

    @classmethod
    def of(cls, view: Table) -> "TerminalTable":
        """Draw a table of texts."""
        table = cls(view.title, keys=1).columns_of(*view.head, left=view.words)
        for i, row in enumerate(view.rows):
            table.add_row(*row, style="yellow" if i in view.marked else None)
        return table

    def __rich_console__(
        self, console: rich_console.Console, options: rich_console.ConsoleOptions
    ) -> rich_console.RenderResult:
        """Yield the title, then the table in the form for the width."""
        if self.title:
            yield console.render_str(str(self.title), style="table.title")
        spans = [_span(console, options, column) for column in self.columns]
        parts = self._parts([span.minimum for span in spans], options.max_width)
        if any(_table_width([spans[i].minimum for i in part]) > options.max_width for part in parts):
            yield from self._blocks(console)
        else:
            for part in parts:
                if part != parts[0]:
                    yield ""
                yield from self._part(part, _widths([spans[i] for i in part], options.max_width), console, options)
        if self.title:
            yield ""

    def _parts(self, least: list[int], width: int) -> list[list[int]]:
        """Return the columns of each table: all in one where they fit or where there are no keys."""
        keys = list(range(self.keys))
        if not keys:
            return [list(range(len(least)))]
        parts = [keys]
        for i in range(len(keys), len(least)):
            if len(parts[-1]) > len(keys) and _table_width([least[j] for j in [*parts[-1], i]]) > width:
                parts.append(keys)
            parts[-1] = [*parts[-1], i]
        return parts

    def _part(
        self, part: list[int], widths: list[int], console: rich_console.Console, options: rich_console.ConsoleOptions
    ) -> rich_console.RenderResult:
        """Yield a table of some columns."""
        # A box puts a column of its own between two columns.
        table = RichTable(
            box=self.box,
            show_header=self.show_header,
            show_edge=False,
            pad_edge=False,
            padding=(0, GAP - (self.box is not None), 0, 0),
        )
        for i, width in zip(part, widths, strict=True):
            column = self.columns[i]
            table.add_column(column.header, justify=column.justify, style=column.style, width=width)
        for cells, row in zip(zip(*[self.columns[i].cells for i in part], strict=True), self.rows, strict=True):
            table.add_row(*cells, style=row.style, end_section=row.end_section)
        yield from table.__rich_console__(console, options)

    def _blocks(self, console: rich_console.Console) -> rich_console.RenderResult:
        """Yield each row as a block: its first cell, then a line for each other column."""
        names = [_flat(console, column.header if self.show_header else "") for column in self.columns]
        for cells in zip(*[column.cells for column in self.columns], strict=True):
            first, *others = [_flat(console, cell) for cell in cells]
            first.stylize("bold")
            yield first
            block = RichTable.grid(
                Column(no_wrap=True), Column(overflow="fold"), padding=(0, GAP, 0, 0), pad_edge=False
            )
            for name, cell in zip(names[1:], others, strict=True):
                if cell.plain:
                    block.add_row(Text.assemble("  ", name), cell)
            if block.rows:
                yield block


def _span(console: rich_console.Console, options: rich_console.ConsoleOptions, column: Column) -> Measurement:
    """Return the widths of a column's longest word and longest line.

    Both are the latter where the column does not wrap.
    """
    spans = [Measurement.get(console, options.update(width=10_000), cell) for cell in [column.header, *column.cells]]
    most = max(span.maximum for span in spans)
    return Measurement(most if column.no_wrap else max(span.minimum for span in spans), most)


def _table_width(widths: Sequence[int]) -> int:
    """Return the width of a table with columns of these widths."""
    return sum(widths) + GAP * (len(widths) - 1)


def _widths(spans: Sequence[Measurement], room: int) -> list[int]:
    """Return widths within the spans that fill the room: no column that wraps is wider than one that could use it more."""

    def at(level: int) -> list[int]:
        return [min(max(level, span.minimum), span.maximum) for span in spans]

    return at(max((level for level in range(room + 1) if _table_width(at(level)) <= room), default=0))


def _flat(console: rich_console.Console, cell: rich_console.RenderableType) -> Text:
    """Return a cell in one line."""
    text = cell.copy() if isinstance(cell, Text) else console.render_str(str(cell))
    return Text(" ").join(line for line in text.split() if line.plain.strip())
