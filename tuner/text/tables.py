"""Tables of texts, described once; terminal, page and Markdown draw them."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from tuner.text.latex import latex_table


class Table(NamedTuple):
    """A table of texts; its first column names the rows.

    Attributes:
        title: Title over the table.
        words: Heads of columns of words, which begin at the left, as numbers end at the right.
        marked: Places of rows that stand out.
    """

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: Sequence[str] = ("",)
    marked: Collection[int] = ()

    @property
    def latex(self) -> str:
        """The table as a LaTeX tabular with rules of booktabs; its title is a comment."""
        return latex_table(self.title, self.head, self.rows, self.words)

    @property
    def markdown(self) -> str:
        """The table without its title in Markdown; cells are texts that may hold a bar."""
        lines = [self.head, ["---"] * len(self.head), *self.rows]
        return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
