"""HTML from Python, escaped unless marked: a plain string is text, `Markup` is markup."""

from collections.abc import Iterable
from html import escape

_VOID = frozenset({"br", "img", "meta", "input"})


class Markup(str):
    """HTML that is already safe to insert."""


def safe(content: str) -> Markup:
    """Return content as markup, escaped if it is plain text."""
    return content if isinstance(content, Markup) else Markup(escape(content))


def join(parts: Iterable[str], separator: str = "") -> Markup:
    """Return the joined parts, each escaped unless it is markup."""
    return Markup(safe(separator).join(safe(part) for part in parts))


def element(tag: str, *content: str, **attributes: str | float | bool) -> Markup:
    """Return one element.

    Attribute names: a trailing underscore is dropped, inner ones become hyphens (class_, data_layer, stroke_width). A
    value True leaves the bare name, False leaves the attribute out.
    """
    opened = "".join(_attribute(name, value) for name, value in attributes.items())
    inner = join(content)
    return Markup(f"<{tag}{opened}>" if tag in _VOID else f"<{tag}{opened}>{inner}</{tag}>")


def coded(text: str) -> Markup:
    """Return text in which words between backticks are set as code."""
    parts = text.split("`")
    return join(element("code", part) if i % 2 else part for i, part in enumerate(parts))


def table(head: Iterable[str], rows: Iterable[Iterable[str]], **attributes: str) -> Markup:
    """Return a table whose first column heads its rows; cells carry their column's name for narrow screens."""
    names = list(head)
    body = join(element("tr", join(cells(names, row))) for row in rows)
    top = element("tr", join(element("th", name, scope="col") for name in names))
    return element("table", element("thead", top), element("tbody", body), **attributes)


def cells(names: list[str], row: Iterable[str]) -> Iterable[Markup]:
    """Return the cells of a row with the names of their columns; inside, one element, so that a cell may be a grid."""
    for i, (name, cell) in enumerate(zip(names, row, strict=True)):
        yield element("td", element("div", cell), data_label=str(name)) if i else element("th", cell, scope="row")


def described(pairs: Iterable[tuple[str, str]], **attributes: str) -> Markup:
    """Return a description list of terms and what they are."""
    inner = join(element("div", element("dt", term), element("dd", meaning)) for term, meaning in pairs)
    return element("dl", inner, **attributes)


def _attribute(name: str, value: str | float | bool) -> str:
    if value is False:
        return ""
    name = name.rstrip("_").replace("_", "-")
    return f" {name}" if value is True else f' {name}="{escape(str(value))}"'
