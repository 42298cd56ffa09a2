"""Tables and lists of a contest's page as a reader sees them, and the files that they are read from."""

import csv
import json
import re
from functools import lru_cache
from html.parser import HTMLParser

import pyarrow.parquet as pq

from tests.tuner.report.reading import Page, read

VOID = ("br", "meta", "input")


class Rows(HTMLParser):
    """The rows of the tables of a class: text of the heading cell under "", of the others under their label."""

    def __init__(self, source, name):
        super().__init__()
        self.name, self.inside, self.rows, self.cell = name, False, [], None
        self.feed(source)

    def handle_starttag(self, tag, attrs):
        known = dict(attrs)
        if tag == "table":
            self.inside = self.name in (known.get("class") or "").split()
        elif self.inside and tag == "tr":
            self.rows.append({})
        elif self.inside and tag in ("td", "th"):
            self.cell = known.get("data-label") or ""
            self.rows[-1].setdefault(self.cell, "")
        elif self.inside and tag in ("small", "br", "span", "div"):
            self.handle_data(" ")

    def handle_endtag(self, tag):
        if tag == "table":
            self.inside = False

    def handle_data(self, data):
        if self.inside and self.cell is not None:
            text = f"{self.rows[-1].get(self.cell, '')}{data}"
            self.rows[-1][self.cell] = " ".join(text.split()) + (" " if text.endswith(" ") else "")


class Lists(HTMLParser):
    """The texts of list items of a class, each with the caption of the figure it stands in."""

    def __init__(self, source, name):
        super().__init__()
        self.name, self.caption, self.items, self.open = name, "", [], None
        self.feed(source)

    def handle_starttag(self, tag, attrs):
        if tag == "figcaption":
            self.caption, self.open = "", "caption"
        elif tag == "li":
            self.open = "item" if self.name in (dict(attrs).get("class") or "").split() else None
            if self.open:
                self.items.append([self.caption, ""])

    def handle_endtag(self, tag):
        if tag in ("figcaption", "li"):
            self.open = None

    def handle_data(self, data):
        if self.open == "caption":
            self.caption += data
        elif self.open == "item":
            self.items[-1][1] += data


def source_of(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


@lru_cache
def read_once(folder):
    """The page of a folder that nobody writes into any more."""
    return read(folder)


def markup_of(folder):
    """The page without its scripts, which are most of it."""
    return source_of(folder).split('<script type="application/json"')[0]


@lru_cache
def said_once(folder):
    """`said` of a folder that nobody writes into any more."""
    return said(folder)


def said(folder):
    """The text of the page without the files that it repeats at its end."""
    return Page(re.sub(r"<pre.*?</pre>", "", markup_of(folder) + "</body></html>", flags=re.S)).text


def table_rows(folder, name):
    return [row for row in Rows(markup_of(folder), name).rows if len(row) > 1]


def strip_rows(folder):
    return [(caption, " ".join(text.split())) for caption, text in Lists(markup_of(folder), "strip-row").items]


def content(folder):
    return json.loads((folder / "contest.json").read_text(encoding="utf-8"))


def front_rows(folder):
    if not (folder / "fronts.csv").exists():
        return []
    with open(folder / "fronts.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@lru_cache
def table_of(file):
    return pq.read_table(file).to_pandas()


def rows_of(folder, file, **wanted):
    """Columns by name of the rows of a Parquet file that have certain names."""
    table = table_of(folder / file)
    for key, value in wanted.items():
        table = table[table[key] == value]
    return {name: table[name].tolist() for name in table}
