"""The template of every page: one offline file, from the answer to its provenance, with the library that draws its charts."""

import json
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

from tuner.store.folder import put
from tuner.text.markup import Markup, coded, element, join, safe, table
from tuner.text.neutral import Neutral
from tuner.text.tables import Table

IN_SPACE = 'id="space"'
"""Attribute of the one chart that is drawn in three dimensions."""


class Section(NamedTuple):
    """A section of a page: its id, its heading, and what stands below it."""

    key: str
    title: str
    content: Markup


class Page(NamedTuple):
    """Content of a page.

    lead: the sentences under the title; opening: what stands before the links to the sections; bar: what stays in sight.
    """

    kind: str
    title: str
    lead: Markup
    opening: Markup
    sections: Sequence[Section]
    data: Mapping[str, Any]
    ending: Sequence[str] = ()
    warnings: Sequence[str] = ()
    bar: Markup = Markup()

    def text(self) -> str:
        """Return the page as HTML; sections without content are left out."""
        shown = [section for section in self.sections if section.content]
        sections = join((self.bar, *[page_section(section) for section in shown]))
        return Template(asset("page.html")).substitute(
            kind=safe(self.kind),
            title=safe(self.title),
            ending=ending_callout(self.ending),
            lead=self.lead,
            opening=self.opening,
            warnings=warnings_callout(self.warnings),
            navigation=join(element("li", element("a", section.title, href=f"#{section.key}")) for section in shown),
            sections=sections,
            data=in_script(self.data),
            style=asset("page.css"),
            script=scripts(),
            library=library(IN_SPACE in sections) if self.data.get("charts") else "",
        )


def neutral_page(page: Page, names: Iterable[str]) -> Page:
    """Return a page in neutral words, for plants that are no vehicles; names: of the user, which stay."""
    neutral = Neutral(names)
    sections = [
        Section(section.key, neutral.text(section.title), neutral.markup(section.content)) for section in page.sections
    ]
    opening, warnings = neutral.markup(page.opening), [neutral.text(text) for text in page.warnings]
    return page._replace(opening=opening, sections=sections, warnings=warnings)


def put_page(folder: Path, page: Page, name: str = "report.html") -> Path:
    """Write a page whole or not at all and return its path; StoreError where that cannot be done."""
    return put(folder, name, page.text().encode())


@cache
def library(in_space: bool = False) -> str:
    """Return the script of plotly.js, compressed to a third: browsers unpack it faster than they read it in full.

    in_space: whether it draws in three dimensions, too, which takes three times as much.
    """
    name = "plotly.min.js.gz" if in_space else "plotly-cartesian.min.js.gz"
    return b64encode(files("tuner.report").joinpath("plotly", name).read_bytes()).decode("ascii")


@cache
def scripts() -> str:
    """Return the scripts of the page one after the other, in the order of their names."""
    paths = files("tuner.report").joinpath("js").iterdir()
    return "\n".join(entry.read_text(encoding="utf-8") for entry in sorted(paths, key=lambda entry: entry.name))


def asset(name: str) -> str:
    """Return the text of a file that comes with this package."""
    return files("tuner.report").joinpath(name).read_text(encoding="utf-8")


def in_script(content: Mapping[str, Any]) -> str:
    """Return JSON that can stand inside a script element: no "<", so nothing can close it."""
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def page_section(section: Section) -> Markup:
    """Return a section of a page, which its heading folds away."""
    head = element("summary", element("h2", section.title, id=f"{section.key}-title"))
    content = element("details", head, section.content, class_="fold", open=True)
    return element("section", content, id=section.key, aria_labelledby=f"{section.key}-title")


def warnings_callout(warnings: Sequence[str]) -> Markup:
    """Return the warnings of the run as a box, nothing where there are none."""
    if not warnings:
        return Markup()
    listed = element("ul", *[element("li", coded(warning)) for warning in warnings])
    return element(
        "aside", element("strong", "Warnings"), listed, class_="warnings", id="warnings", aria_label="Warnings"
    )


def ending_callout(ending: Sequence[str]) -> Markup:
    """Return the ending of a run that found nothing feasible, nothing for any other."""
    if not ending:
        return Markup()
    head, *others = ending
    listed = element("ul", *[element("li", text) for text in others]) if others else ""
    return element("aside", element("strong", head), listed, class_="warnings", id="ending", aria_label="How it ended")


def wide(content: Markup, **attributes: str) -> Markup:
    """Return content in a box that scrolls sideways where it has to."""
    return element("div", content, class_="wide", **attributes)


def wide_table(view: Table) -> Markup:
    """Return a table that scrolls on narrow screens."""
    return wide(table(view.head, view.rows))


def titled_tables(views: Sequence[Table]) -> Markup:
    """Return tables below their titles."""
    return join(join((element("h3", view.title), wide_table(view))) for view in views)


def aid(text: str) -> Markup:
    """Return a line on how to read what follows."""
    return element("p", text, class_="aid")


def collapsible(title: str, *content: str, **attributes: str | bool) -> Markup:
    """Return content that is folded away under a title."""
    return element("details", element("summary", title), *content, **attributes)


def collapsible_text(title: str, text: str) -> Markup:
    """Return a text as it stands in a file, folded away."""
    return collapsible(title, element("pre", text, tabindex="0"))
