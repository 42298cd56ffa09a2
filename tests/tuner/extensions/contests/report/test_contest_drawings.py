"""Looks and small drawings: told apart without colour, and true to scale."""

import re
from itertools import product

import numpy as np
import pytest

from tuner.documents.parts import Estimate
from tuner.report.charts.chart import span_of, value_axis
from tuner.report.charts.look import COUNT, DASHES, INKS, SYMBOLS, looks, sample
from tuner.report.charts.strip import INSET, StripScale, interval, pinned, ruler, scale, stacked, ticks
from tuner.report.charts.web import line_of, marker_of
from tuner.report.comparison.contenders_section import Gain, joined
from tuner.report.page import asset


def test_every_look_can_be_told_apart_without_colour():
    assert len(list(SYMBOLS)[:COUNT]) == len(DASHES) == len([name for name in INKS if name.startswith("c")]) == COUNT
    different = looks([(str(i), "one") for i in range(COUNT)])
    assert len({look.symbol for look in different}) == len({look.dash for look in different}) == COUNT
    assert len({line_of(look)["dash"] for look in different}) == COUNT
    many = looks([(str(i), "one") for i in range(3 * COUNT)])
    assert len({(look.colour, look.symbol) for look in many}) == 3 * COUNT


def test_the_same_laws_on_another_airframe_are_kin():
    pid, adrc, kin, other, twin = looks([("pid", "a"), ("adrc", "a"), ("pid", "b"), ("adrc", "b"), ("pid", "a")])
    assert (pid.colour, pid.symbol) == (kin.colour, kin.symbol) != (adrc.colour, adrc.symbol)
    assert (pid.hollow, kin.hollow) == (False, True) and marker_of(kin)["symbol"] == "circle-open"
    assert (adrc.colour, other.hollow) == (other.colour, True)
    # The same laws twice on one airframe, say with other gains, are no kin.
    assert (twin.colour, twin.symbol) != (pid.colour, pid.symbol)
    assert len({look.dash for look in (pid, adrc, kin, other, twin)}) == 5


def test_every_colour_is_in_the_style_sheet():
    style = asset("page.css")
    for number in range(COUNT):
        # Once for light, once for dark; the figures for a paper have those of light.
        assert re.findall(rf"--c{number}: (#[0-9a-f]{{6}})", style)[0] == INKS[f"c{number}"]
        assert len(re.findall(rf"--c{number}: #[0-9a-f]{{6}}", style)) == 2
        assert f"c{number}" in sample(looks([(str(i), "one") for i in range(COUNT)])[number])


@pytest.mark.parametrize(
    ("numbers", "low", "high", "log"),
    [
        ([1.0, 2.0, None], 0.0, 2.0, False),
        ([-1.0, 3.0], -1.0, 3.0, False),
        ([-3.0, -1.0], -3.0, 0.0, False),
        ([0.001, 0.1], 0.001, 0.1, True),
        ([0.0, 0.001, 0.1], 0.0, 0.1, False),
        ([float("inf"), 1.0], 0.0, 1.0, False),
        ([], 0.0, 0.0, False),
        ([0.0], 0.0, 0.0, False),
    ],
)
def test_a_scale_holds_all_numbers_and_zero(numbers, low, high, log):
    shown = scale(numbers)
    assert shown.log == log and shown.low <= low and shown.high >= high and shown.high > shown.low
    places = [shown.place(value) for value in (low, high)]
    assert INSET <= places[0] <= places[1] <= shown.width - INSET


def test_places_are_proportional_or_logarithmic():
    linear, log = StripScale(-1.0, 3.0, False, 124.0), StripScale(1e-3, 1e1, True, 124.0)
    assert [linear.place(value) for value in (-1.0, 0.0, 3.0, 9.0)] == [12.0, 37.0, 112.0, 112.0]
    assert [log.place(value) for value in (1e-3, 1e-2, 1e1, 1e-9)] == pytest.approx([12.0, 37.0, 112.0, 12.0])


@pytest.mark.parametrize(("low", "span"), list(product((0.0, -0.37, 2.2, -1e6), (1e-7, 0.0042, 1.0, 17.0, 2.3e5))))
def test_ticks_are_few_round_and_inside(low, span):
    shown = StripScale(low, low + span)
    found = ticks(shown)
    assert 1 <= len(found) <= 6
    assert all(low - 1e-6 * span <= value <= low + span * (1.0 + 1e-6) for value in found)
    steps = {float(f"{b - a:.3g}") for a, b in zip(found, found[1:], strict=False)}
    if abs(low) < 1e3 * span:
        assert len(found) >= 2 and len(steps) == 1 and f"{steps.pop():.0e}"[0] in "125"


def test_ticks_of_decades_are_powers_of_ten():
    assert ticks(StripScale(4e-4, 0.2, True)) == pytest.approx([1e-3, 1e-2, 1e-1])
    assert ticks(StripScale(0.02, 0.8, True)) == pytest.approx([0.03, 0.1, 0.3])


def numbers_of(markup, name):
    """The coordinates of the lines of a class."""
    lines = re.findall(rf'<line x1="([\d.-]+)" y1="[\d.-]+" x2="([\d.-]+)" y2="[\d.-]+" class="{name}">', markup)
    return [(float(a), float(b)) for a, b in lines]


def test_a_difference_is_drawn_where_it_is():
    shown = StripScale(-2.0, 2.0, False, 224.0)
    clear, unclear = (interval(shown, Estimate(-1.0, -1.5, -0.5), clear) for clear in (True, False))
    assert numbers_of(clear, "whisker clear") == [(37.0, 87.0)] and numbers_of(clear, "zero") == [(112.0, 112.0)]
    assert 'class="diamond clear"' in clear and 'd="M62.0' in clear
    assert 'class="diamond unclear"' in unclear
    assert "diamond" not in interval(shown, Estimate(None, None, None), False)


def test_a_printed_number_is_drawn_beside_the_bar():
    look = looks([("pid", "a")])[0]
    shown = StripScale(0.0, 10.0, False, 224.0)
    inside = pinned(shown, Estimate(4.0, 2.0, 6.0), 5.0, look, True)
    assert 'x="52.0"' in inside and 'width="80.0"' in inside and numbers_of(inside, "median c0") == [(92.0, 92.0)]
    assert numbers_of(inside, "pin") == [(112.0, 112.0)] and "pin inside" in inside
    assert "pin outside" in pinned(shown, Estimate(4.0, 2.0, 6.0), 9.0, look, False)


def test_contenders_stand_on_one_scale_with_the_limit():
    a, b = looks([("a", "x"), ("b", "x")])
    drawn = stacked(
        StripScale(0.0, 4.0, False, 224.0), [(a, Estimate(1.0, 0.5, 1.5)), (b, Estimate(3.0, 2.0, 4.0))], 2.0
    )
    assert numbers_of(drawn, "whisker c0") == [(37.0, 87.0)] and numbers_of(drawn, "whisker c1") == [(112.0, 212.0)]
    assert numbers_of(drawn, "limit") == [(112.0, 112.0)]


def test_numbers_of_a_ruler_do_not_touch():
    drawn = ruler(StripScale(0.0, 6e-7, False, 132.0))
    places = [float(x) for x in re.findall(r'<text x="([\d.]+)"', drawn)]
    texts = re.findall(r">([^<>]+)</text>", drawn)
    assert len(texts) >= 2
    for (x, text), (y, other) in zip(
        zip(places, texts, strict=True), list(zip(places, texts, strict=True))[1:], strict=False
    ):
        assert y - x > 3.0 * (len(text) + len(other))


def test_axes_cover_decades_logarithmically():
    assert span_of([], 25.0) == (0.0, 1.0, False)
    linear, log = span_of([np.array([1.0, 10.0]), np.array([np.inf])], 25.0), span_of([np.array([1e-3, 1.0])], 25.0)
    assert linear.log is False and linear.low < 1.0 and linear.high > 10.0
    assert log.log is True and 0.0 < log.low < 1e-3 and log.high > 1.0
    assert [text for _, text in value_axis("peak", "m", log).ticks[:4]] == ["0.001", "0.003", "0.01", "0.03"]
    many = span_of([np.array([1e-6, 1.0])], 25.0)
    assert many.ticks() == pytest.approx([10.0**power for power in range(-6, 1)])
    assert span_of([np.array([2.0])], 25.0).low < 2.0 < span_of([np.array([2.0])], 25.0).high


def test_gains_are_joined_where_a_whole_group_agrees():
    gains = [Gain(f"{axis}.k", 1.0, "1") for axis in ("x", "y", "z", "roll", "pitch")]
    gains += [Gain("yaw.k", 2.0, "1"), Gain("x.d", 1.0, "s"), Gain("y.d", 1.0, "s"), Gain("z.d", 3.0, "s")]
    found = [(gain.address, gain.value) for gain in joined(gains)]
    assert found == [("position.k", 1.0), ("tilt.k", 1.0), ("yaw.k", 2.0), ("horizontal.d", 1.0), ("z.d", 3.0)]
