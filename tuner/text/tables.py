"""Tables of texts, described once; terminal, page and Markdown draw them."""

from collections.abc import Collection, Sequence
from typing import NamedTuple


class Table(NamedTuple):
    """A table of texts; its first column names the rows.

    title: over the table; words: heads of columns of words, which begin at the left, as numbers end at the right; marked: places
    of rows that stand out.
    """

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: Sequence[str] = ("",)
    marked: Collection[int] = ()

    @property
    def markdown(self) -> str:
        """The table without its title in Markdown; cells are texts that may hold a bar."""
        lines = [self.head, ["---"] * len(self.head), *self.rows]
        return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
