"""Tables of the public interface: pandas frames that carry the units of their columns, and how objects show themselves."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tuner.store import document as store
from tuner.store.document import DocumentPart
from tuner.text.markup import Markup, element, join
from tuner.text.markup import table as html_rows
from tuner.text.numbers import significant
from tuner.text.tables import Table

if TYPE_CHECKING:
    import pandas as pd

    from tuner.api.figures import Figures
    from tuner.documents.comparison_document import EstimateRow
    from tuner.documents.parts import Estimate
    from tuner.report.charts.paper import Figure

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


def shown(
    title: str,
    lines: Iterable[str] = (),
    table: "pd.DataFrame | Table | Markup | None" = None,
    figure: "Figure | None" = None,
) -> str:
    """Return HTML for a notebook; all text may be a stranger's.

    Args:
        title: Text in bold.
        lines: Lines of text below it.
        table: Table below these; of a frame there are the first rows.
        figure: Figure at the end, as a PNG.
    """
    parts = [element("strong", title), *[element("div", line) for line in lines]]
    if isinstance(table, Table):
        parts.append(texts_table(table))
    elif isinstance(table, Markup):
        parts.append(table)
    elif table is not None and len(table):
        parts.append(html_table(table))
    if figure is not None:
        content = b64encode(figure._repr_png_()).decode()  # pyright: ignore[reportPrivateUsage]
        parts.append(element("img", src=f"data:image/png;base64,{content}", alt=title, style="max-width: 100%"))
    return str(element("div", join(parts)))


def texts_table(table: Table) -> Markup:
    """Return a table of texts as HTML."""
    return html_rows(table.head, table.rows) if table.rows else Markup("")


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
    return join([html_rows(head, rows), more])


def cell(value: Any) -> str:
    """Return a value as text."""
    if isinstance(value, float):
        return significant(value)
    return "" if value is None else str(value)
