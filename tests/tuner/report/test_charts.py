"""Every mark of the vocabulary of charts is drawn in the page and on paper."""

import re
import zlib
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from fontTools import subset
from fontTools.ttLib import TTFont

from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Band, Bars, Disc, Line, Mark, Panel, Points, Region, Rule, Words
from tuner.report.charts.look import DEFAULT, FRONT, REFERENCE, TUNED, worst_look
from tuner.report.charts.loops import axes_of, gain_crossing, phase_crossing
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


def test_a_bound_is_cut_off_where_it_lies_beyond_what_is_shown():
    time, reference = np.arange(3.0), np.array([0.0, 5.0, 20.0])
    lines = fans.bounds(time, reference, 10.0, "limit", (-12.0, 20.0), {})
    assert [list(mark.y) for mark in lines if isinstance(mark, Line)] == [
        [-10.0, -5.0, 10.0],
        pytest.approx([10.0, 15.0, np.nan], nan_ok=True),
    ]


def test_a_bound_beyond_what_is_shown_is_a_note_instead():
    (note,) = fans.bounds(np.arange(2.0), np.zeros(2), 80.0, "peak at most 80 °", (-25.0, 25.0), {"scenario": "gusts"})
    assert isinstance(note, Words) and "80 °" in note.text and note.show == {"scenario": "gusts"}


def test_worst_flights_of_default_and_tuned_differ_in_colour_and_strokes():
    default, tuned = worst_look(DEFAULT), worst_look(TUNED)
    assert default.colour != tuned.colour and default.dash != tuned.dash
    assert not {default.dash, tuned.dash} & {DEFAULT.dash, TUNED.dash, REFERENCE.dash}


def ends_of(axis):
    assert axis.ends is not None
    return axis.ends


@pytest.mark.parametrize("gain", [0.5, 1.0, 3.0])
def test_axes_of_loops_hold_the_point_minus_one_and_the_margins(gain):
    w = np.geomspace(1e-3, 1e3, 2000)
    loop = gain * np.exp(-0.4j * w) / (1j * w)
    axes = axes_of([(w, loop)])
    met = [crossing.point for crossing in (phase_crossing(w, loop), gain_crossing(w, loop)) if crossing is not None]
    (left, right), (bottom, top), (low, high) = (ends_of(axis) for axis in (axes.real, axes.imaginary, axes.phase))
    for point in (-1.0 + 0.0j, *[point for point in met if abs(point) < 2.5]):
        assert left < point.real < right and bottom < point.imag < top
    assert right - left < 6.0
    # Frequencies at which the gain is shown, -60 to 60 dB: |L| = gain / w.
    assert axes.frequency.ends == pytest.approx((1e-3 * max(gain, 1.0), 1e3 * min(gain, 1.0)), rel=0.02)
    assert axes.phase.step in (90.0, 180.0) and high - low < 8.0 * axes.phase.step
