"""Reasons against a point, and limits in charts of loops: by numbers of the folder and by closed forms."""

import csv
import re
from math import sqrt

import numpy as np
import pytest

from tests.tuner.report.fabricate import fabricate
from tuner.documents.states import tightest_margins
from tuner.documents.summary import RequiredRow
from tuner.documents.tuning import TuningFolder
from tuner.report.charts.chart import Axis, Band, Disc, Line
from tuner.report.charts.shaded import ShadedLimit, limit_marks, odd_half_turns, shaded_limits
from tuner.report.labels import titles_of
from tuner.report.tuning_charts import study_limits
from tuner.report.why_not import why_not

FREQUENCY, PHASE = Axis(low=0.1, high=100.0), Axis(low=-600.0, high=0.0)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return TuningFolder(fabricate(tmp_path_factory.mktemp("why") / "made-up"))


def front(results):
    with open(results.home / "front.csv", newline="", encoding="utf-8") as file:
        return {row["point"]: row for row in csv.DictReader(file)}


def why(results, point):
    return why_not(results, results.held_out_front.points.index(point))


def test_a_point_within_all_limits_is_compared_with_the_recommended_one(results):
    rows = front(results)
    change = {
        label: float(rows["p0107"][f"held_out:{label}"]) - float(rows["p0101"][f"held_out:{label}"])
        for label in ("cvar90(itae.position)", "mean(travel)")
    }
    text = why(results, "p0107")
    worse, better = re.findall(r"(?:worse|better) by ([\d.]+) ", text)
    assert change["cvar90(itae.position)"] > 0.0 > change["mean(travel)"]
    assert float(worse) == pytest.approx(change["cvar90(itae.position)"], rel=5e-3)
    assert float(better) == pytest.approx(-change["mean(travel)"], rel=5e-3)
    assert text.startswith("Why not this point: Against the tuned gains (p0101)")


def test_a_point_beyond_a_limit_says_by_how_much(results):
    # p0103 has 33 deg of the 35 that are asked, p0112 0.36 rad of 0.35.
    assert "phase margin 33 ° (min 35, 2 too low)" in why(results, "p0103")
    assert "20.63 ° (max 20.0535, 0.573 too high)" in why(results, "p0112")


def test_the_recommended_point_has_the_reason_of_the_pick(results):
    assert why(results, "p0101").startswith("Recommended: knee of the held-out front")


def test_points_have_words_before_their_codes(results):
    titles = titles_of(results)
    assert titles["p0101"] == "tuned gains (p0101)" and titles["default"] == "default gains"
    assert titles["p0107"] == "p0107"


def test_limits_are_shaded_where_margins_are_read():
    limits = [ShadedLimit("phase_margin", 60.0), ShadedLimit("gain_margin", 20.0), ShadedLimit("ms", 4.0)]
    (gain,), phase, (arc, segment, disc) = limit_marks(limits, FREQUENCY, PHASE)
    assert isinstance(gain, Band) and gain.x.tolist() == [0.1, 100.0]
    assert (gain.low[0], gain.high[0]) == (-20.0, 20.0)
    bands = [band for band in phase if isinstance(band, Band)]
    assert [(band.low[0], band.high[0]) for band in bands] == [(-600.0, -480.0), (-240.0, -120.0)]
    # 60 deg from -1 on the unit circle, a factor of ten on the real axis, and 1 / Ms around -1.
    assert isinstance(arc, Line) and isinstance(segment, Line) and isinstance(disc, Disc)
    assert np.allclose([arc.x[0], arc.x[-1]], -0.5) and np.allclose(np.abs([arc.y[0], arc.y[-1]]), sqrt(3.0) / 2.0)
    assert segment.x == pytest.approx([-10.0, -0.1]) and (disc.x, disc.radius) == (-1.0, 0.25)


def test_a_limit_on_some_loops_is_shaded_with_these_alone():
    channels = ["x", "y", "z", "roll", "pitch", "yaw"]
    given = [("phase_margin(attitude, spread)", 35.0), ("ms(z)", 2.0), ("disk", 0.5), ("gain_margin", 6.0)]
    shown = shaded_limits(given, channels)
    assert [entry.show for entry in shown] == [{"channel": ["roll", "pitch", "yaw"]}, {"channel": ["z"]}, {}]
    assert shaded_limits([("ms(tank)", 2.0)], ["tank"])[0].channels == ("tank",)
    assert odd_half_turns(Axis()) == [-180.0]


def test_usual_limits_are_shaded_if_a_study_has_none(results):
    assert [(entry.quantity, entry.limit) for entry in shaded_limits([("disk", 0.5)], [])] == [
        ("gain_margin", 6.0),
        ("phase_margin", 35.0),
        ("ms", 2.0),
    ]
    assert [entry.name for entry in study_limits(results)] == ["phase margin, min 35 deg"]


def limit(label, value, sense, default, tuned):
    none = {"value": None, "low": None, "high": None}
    states = [{"state": name, "default": None, "tuned": None} for name in ("hover", "wind")]
    return RequiredRow.model_validate(
        {
            "label": label, "quantity": "", "unit": "", "kind": "requirement", "limit": value, "sense": sense,
            "default": none | {"value": default}, "tuned": none | {"value": tuned}, "difference": none,
            "verdict": "kept", "states": states,
        }
    )  # fmt: skip


def test_the_worst_state_is_that_of_the_margin_nearest_to_its_limit():
    rows = [limit("phase_margin", 35.0, "min", 10.0, 40.0), limit("ms", 2.0, "max", 6.0, 1.9)]
    # A peak of 6 is two limits beyond 2; 1.9 is a twentieth of the limit within it, 40 a seventh.
    assert {role: row.label for role, row in tightest_margins(rows).items()} == {"default": "ms", "tuned": "ms"}
    rows[1] = limit("ms", 2.0, "max", 2.1, 1.2)
    assert {role: row.label for role, row in tightest_margins(rows).items()} == {
        "default": "phase_margin",
        "tuned": "phase_margin",
    }
    assert tightest_margins([row.model_copy(update={"states": []}) for row in rows]) == {}
