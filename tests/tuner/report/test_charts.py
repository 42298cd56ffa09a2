"""Every mark of the vocabulary of charts is drawn in the page and on paper."""

import re
import zlib
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from fontTools import subset
from fontTools.ttLib import TTFont

from tuner.report.charts.chart import Axis, Band, Bars, Disc, Line, Mark, Panel, Points, Region, Rule, Words
from tuner.report.charts.look import FRONT, TUNED
from tuner.report.charts.paper import figure_of, printed, style
from tuner.report.charts.sketch import sketch
from tuner.report.charts.web import Arrays, to_web

X, Y = np.array([1.0, 2.0, 4.0]), np.array([2.0, 1.0, 3.0])
GRID = np.array([[-1.0, 1.0, np.nan], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]])
MARKS = {
    Points: Points(look=TUNED, name="points", x=X, y=Y, x_ends=(X - 0.1, X + 0.1), texts=["a", "b", "c"]),
    Line: Line(look=FRONT, name="line", x=X, y=Y, marked=slice(0, None, 2)),
    Band: Band(look=FRONT, x=X, low=Y - 1.0, high=Y + 1.0),
    Bars: Bars(look=FRONT, x=X, y=Y, ends=(X - 0.1, X + 0.1), across=True),
    Rule: Rule(look=FRONT, axis="x", value=2.0),
    Disc: Disc(look=FRONT, x=2.0, y=2.0, radius=0.5, fill="hatched"),
    Region: Region(look=FRONT, name="region", x=X, y=Y, values=GRID, low=0.0),
    Words: Words(look=FRONT, x=0.9, y=0.5, text="words", place="inside"),
}


def panel(*marks):
    return Panel("key", "A title", Axis("across [m]", 0.0, 5.0), Axis("up [s]", 0.0, 5.0), marks)


def test_no_mark_is_forgotten():
    assert set(MARKS) == set(Mark.__subclasses__())


@pytest.mark.parametrize("kind", MARKS, ids=lambda kind: kind.__name__)
def test_a_mark_is_drawn_in_the_page_and_on_paper(kind):
    with style():
        (bare, drawn) = (figure_of([panel(*marks)], 1, 2.0) for marks in ((), (MARKS[kind],)))
        assert printed(bare)[".png"] != printed(drawn)[".png"]
    made = to_web(panel(MARKS[kind]), Arrays())
    assert made["traces"] or made["layout"].get("shapes") or made["layout"].get("annotations")


def test_a_font_in_a_pdf_has_the_glyphs_of_the_figure_and_no_tables_that_join_or_place_them():
    usual = subset.load_font
    with style():
        content = printed(figure_of([panel()], 1, 2.0))[".pdf"]
    fonts = [
        TTFont(BytesIO(zlib.decompressobj().decompress(content[found.end() :])))
        for found in re.finditer(rb"/Length1 [^>]*>>\s*stream\r?\n", content)
    ]
    assert fonts
    letters = {name for font in fonts for name in font.getGlyphOrder() if font["glyf"][name].numberOfContours}
    # The axes are titled "across [m]" and "up [s]", their ends 0 and 5.
    assert {"a", "c", "r", "o", "s", "bracketleft", "m", "u", "p", "zero", "five"} <= letters and "z" not in letters
    assert {"GDEF", "GPOS", "GSUB", "kern", "MATH"}.isdisjoint(tag for font in fonts for tag in font.keys())  # noqa: SIM118
    # Whoever else takes fonts apart in this process finds what was there.
    assert subset.load_font is usual


def test_a_region_ends_where_its_quantity_leaves_it():
    trace: dict[str, Any]
    (trace,) = to_web(panel(MARKS[Region]), Arrays())["traces"]
    assert trace["contours"]["value"][0] == 0.0 and trace["contours"]["value"][1] > GRID[np.isfinite(GRID)].max()
    assert trace["z"][0] == [-1.0, 1.0, None]


def test_a_sketch_holds_points_beyond_an_axis_at_its_end():
    far = Points(look=TUNED, name="<tuned>", x=np.array([2.5, 50.0]), y=np.array([2.5, 50.0]))
    drawn = sketch(panel(far))
    # The middle of the area inside the axes, and its corner at the top right.
    assert "translate(311.3 186.3)" in drawn and "translate(582.3 2.3)" in drawn
    assert "&lt;tuned&gt;" in drawn and "<tuned>" not in drawn
