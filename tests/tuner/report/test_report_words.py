"""Sentences of the report that judge: what a gap between search and held-out says, and what a gain at an end of its range says."""

from typing import Any

import pytest

from tuner.cli.printers.margins import reading
from tuner.documents.margins import Reading
from tuner.documents.parts import Estimate
from tuner.documents.summary import SelectionValues, VariableRow
from tuner.report.changes import headline_change
from tuner.report.gains_section import gains_table
from tuner.report.labels import time_unit
from tuner.report.words import gap_words


def picked(**lost):
    return SelectionValues(probability=0.5, objectives=[], **lost)


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (0.1, 0.3, "optimistic"),
        (-0.1, 0.3, "no significant"),
        (-29.0, -28.0, "pessimistic"),
        (0.0, 0.3, "no significant"),
    ],
)
def test_a_gap_is_judged_by_its_interval(low, high, said):
    assert said in gap_words(picked(lost_in_search=0.0), Estimate(None, low, high))
    # A folder of an earlier version does not tell what was lost.
    assert said in gap_words(picked(), Estimate(None, low, high))


@pytest.mark.parametrize("low", [-29.0, 1.0])
def test_a_gap_to_lost_flights_says_nothing_of_optimism(low):
    """30.00 m in the search, gap -28.49: the value of a flight that was lost, or never made."""
    gap = Estimate(None, low, low + 1.0)
    assert gap_words(picked(lost_in_search=0.25), gap).startswith("it lost 25 % of its flights in the search")
    assert gap_words(picked(lost_in_search=None), gap).startswith("it was not flown in the search")
    for lost in (0.25, None):
        assert "optimis" not in gap_words(picked(lost_in_search=lost), gap)


def remark(tuned, *natural_ends):
    results: Any = type("Results", (), {"shown_as": "tuned"})()
    results.variables = [
        VariableRow(
            name="tilt.k1",
            symbol="k1",
            unit="1",
            low=0.0,
            high=40.0,
            scale="linear",
            natural_ends=list(natural_ends),
            default=20.0,
            tuned=tuned,
        )
    ]
    return gains_table(results)


def test_a_wider_range_is_advised_only_where_the_end_can_be_moved():
    assert "at the low end: which cannot be moved" in remark(0.0, "low")
    assert "at the low end: a wider range may do better" in remark(0.0, "high")
    assert "at the high end: a wider range may do better" in remark(40.0, "low")
    assert "end:" not in remark(20.0, "low")


@pytest.mark.parametrize(
    ("default", "difference", "text"),
    [
        ((2.0, 1.9, 2.1), (-0.5, -0.7, -0.3), "\u221225 % [\u221235, \u221215]"),
        # Of next to nothing 43,260 % has no meaning, nor has a fall by more than all of it, nor a share of what may be 0.
        ((1e-5, 1e-5, 1e-5), (4.326e-3, 4.2e-3, 4.4e-3), "+0.00433 rad [+0.00420, +0.00440]"),
        ((2e-4, 1e-4, 3e-4), (-2e-4, -2.8e-4, -1.4e-4), "\u22120.00020 rad [\u22120.00028, \u22120.00014]"),
        ((0.1, -0.1, 0.3), (0.05, 0.04, 0.06), "+0.050 rad [+0.040, +0.060]"),
    ],
)
def test_a_headline_is_in_per_cent_where_that_has_a_meaning(default, difference, text):
    assert headline_change(Estimate(*default), Estimate(*difference), "rad") == text


@pytest.mark.parametrize(
    ("delays", "unit", "texts"),
    [
        ([0.0058, None], "ms", ["5.8", "inf"]),
        ([12.5, 300.0], "s", ["12.50", "300"]),
        ([1670.0, 60.0], "min", ["27.83", "1.00"]),
    ],
)
def test_delays_are_printed_in_a_unit_of_their_size(delays, unit, texts):
    shown, per_unit = time_unit("delay_margin", delays)
    assert shown == unit
    found = [
        reading(Reading(value=value, unit="s", frequency=None, case=None, note=None), "delay_margin", per_unit)
        for value in delays
    ]
    assert found == texts
    assert time_unit("phase_margin", [100.0]) == ("deg", 1.0)
