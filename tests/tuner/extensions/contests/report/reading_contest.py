"""Tables and lists of a contest's page as a reader sees them, and the files that they are read from."""

import csv
import json
import re
from functools import lru_cache
from html.parser import HTMLParser

import numpy as np

from tests.tables import read_frame
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


@lru_cache
def data_once(folder):
    """The data of such a page, parsed once for all readers."""
    return read_once(folder).data


def near(values, wanted, share, least=0.0):
    """Whether all values are as wanted but for a share, or `least`: as `pytest.approx` of as many, which takes 50 times as long."""
    values, wanted = np.asarray(values), np.asarray(wanted)
    return values.shape == wanted.shape and bool(
        np.all(np.abs(values - wanted) <= np.maximum(share * np.abs(wanted), least))
    )


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


def stored(folder):
    """contest.json as it stands, angles in rad."""
    return json.loads((folder / "contest.json").read_text(encoding="utf-8"))


def factor_of(unit):
    """Return the factor from a unit of the files to the one that a page shows: angles in rad become degrees."""
    powers = {"rad": 1, "rad/s": 1, "rad s": 1, "rad/s^2": 1, "rad^2 s": 2}
    return float(np.degrees(1.0)) ** powers.get(unit, 0)


def content(folder):
    """contest.json with the numbers that a page shows, angles in degrees."""
    told = stored(folder)
    factors = {quantity["label"]: factor_of(quantity["unit"]) for quantity in told["quantities"]}

    def scale(row, factor, *keys):
        row.update({key: row[key] * factor for key in keys if row.get(key) is not None})

    for quantity in told["quantities"]:
        scale(quantity, factor_of(quantity["unit"]), "limit")
    for row in told["estimates"]:
        scale(row, factors[row["quantity"]], "value", "low", "high")
    for row in [*told["differences"], *(row for claim in told["claims"] for row in claim["rows"])]:
        scale(row, factors.get(row["quantity"], 1.0), "difference", "low", "high")
    for cell in told["published"]:
        scale(cell, factor_of(cell["unit"]), "value", "mean", "median", "p2_5", "p97_5")
    for question in told["best_under"]:
        scale(question, factors.get(question["subject_to"], 1.0), "limit")
        for row in question["rows"]:
            scale(row, factors.get(question["objective"], 1.0), "value", "low", "high")
    return told


def front_rows(folder):
    if not (folder / "fronts.csv").exists():
        return []
    with open(folder / "fronts.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@lru_cache
def table_of(file):
    return read_frame(file)


def rows_of(folder, file, **wanted):
    """Columns by name of the rows of a Parquet file that have certain names."""
    table = table_of(folder / file)
    for key, value in wanted.items():
        table = table[table[key] == value]
    return {name: table[name].tolist() for name in table}


def shown_rows_of(folder, file, **wanted):
    """Likewise with the numbers that a page shows, angles in degrees."""
    rows = rows_of(folder, file, **wanted)
    factor = factor_of(rows["unit"][0]) if rows.get("unit") else 1.0
    scaled = ("value", "reference", "low", "median", "high")
    return {name: [factor * value for value in values] if name in scaled else values for name, values in rows.items()}
