"""Tables of the public interface: pandas frames that carry the units of their columns, and how objects show themselves."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tuner.store import document as store
from tuner.store.document import DocumentPart
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import significant

if TYPE_CHECKING:
    import pandas as pd

    from tuner.api.figures import Figures
    from tuner.documents.comparison_document import EstimateRow
    from tuner.documents.parts import Estimate

MAX_ROWS = 20
"""Rows of a table that an object shows of itself."""


class Documented:
    """An object behind a JSON document, which the command line prints."""

    document: Any

    @property
    def json(self) -> str:
        """The document as JSON."""
        return json_text(self.document)


def json_text(document: Any, ascii_only: bool = True) -> str:
    """Return a document as JSON without its file's last line break.

    ascii_only: escape all other letters.
    """
    content = document.content() if isinstance(document, DocumentPart) else document
    return store.json_text(content, ascii_only).rstrip("\n")


def frame(
    rows: Iterable[Mapping[str, Any] | DocumentPart],
    index: str | Sequence[str] | None = None,
    units: Mapping[str, str] | None = None,
) -> "pd.DataFrame":
    """Return rows as a table; units: of its columns, kept in `attrs["units"]`."""
    import pandas as pd

    table = pd.DataFrame([row.content() if isinstance(row, DocumentPart) else row for row in rows])
    if index is not None and len(table):
        table = table.set_index([index] if isinstance(index, str) else list(index))
        table.index.name = index if isinstance(index, str) else None
    table.attrs["units"] = dict(units or {})
    return table


def figures(kind: str, *data: Any) -> "Figures":
    """Return the figures of a kind of results; data: what they are drawn from. Their library takes 0.4 s to import."""
    from tuner.api.figures import figures_of

    return figures_of(kind, *data)


def estimates(entry: "Estimate | EstimateRow", name: str) -> dict[str, float | None]:
    """Return a number with its 95 % interval as three columns: NAME, NAME low, NAME high."""
    return {name: entry.value, f"{name} low": entry.low, f"{name} high": entry.high}


def shown(title: str, lines: Iterable[str] = (), table: "pd.DataFrame | None" = None) -> str:
    """Return HTML for a notebook: title, lines and a table; all of it is text that may be a stranger's."""
    parts = [element("strong", title), *[element("div", line) for line in lines]]
    if table is not None and len(table):
        parts.append(html_table(table))
    return str(element("div", join(parts)))


def html_table(frame: "pd.DataFrame") -> Markup:
    """Return the first rows of a table as HTML, headed by units.

    Numbers have four significant digits.
    """
    units = frame.attrs.get("units", {})
    flat = frame.reset_index() if frame.index.name else frame
    head = [f"{name} [{units[name]}]" if units.get(name, "1") != "1" else str(name) for name in flat.columns]
    rows = [[cell(value) for value in row] for row in flat.head(MAX_ROWS).itertuples(index=False)]
    left = len(flat) - len(rows)
    more = element("div", f"and {left:,} more rows") if left else Markup("")
    return join([table(head, rows), more])


def cell(value: Any) -> str:
    """Return a value as text."""
    if isinstance(value, float):
        return significant(value)
    return "" if value is None else str(value)
