"""Panels of tails: the probability that a flight exceeds a level, on a logarithmic scale, with its band."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from objectives.risk import clopper_pearson
from tuner.documents.parts import ShareCount
from tuner.documents.summary import ComparedRow
from tuner.documents.tail import LimitedTail, TailEvent
from tuner.documents.tuning import DEFAULT, TUNED, TuningFolder
from tuner.extensions.tails.document import TailDocument
from tuner.report.charts.chart import Axis, Band, Line, Mark, Panel, Points, Rule
from tuner.report.charts.look import BOUND, COUNT, DASHES, RULE, Look, role_look
from tuner.text.units import bracketed, in_degrees

OPACITY, SPREAD, TOP = 0.18, 0.3, 1.5
"""Opacity of a band; share of the smallest probability at which the axis ends, and its upper end."""
FLOOR = 1e-12
"""Probability that represents 0 on the axis."""


class Curve(NamedTuple):
    """An event under gains of a name."""

    name: str
    look: Look
    event: TailEvent


def document_panels(document: TailDocument) -> list[Panel]:
    """Return a panel for each event with a curve for all gains."""
    looks = [Look(f"c{i % COUNT}", dash=DASHES[i % COUNT]) for i in range(len(document.gains))]
    panels = []
    for number, event in enumerate(document.gains[0].events):
        curves = [
            Curve(gains.gains if number == 0 else "", look, gains.events[number])
            for gains, look in zip(document.gains, looks, strict=True)
        ]
        panels.append(_panel("", event.event, curves, document.smallest))
    return panels


def limited_panels(results: TuningFolder) -> list[Panel]:
    """Return a panel for each limit on a probability and scenario."""
    limited = [(row, tail) for row in results.document.compared for tail in row.tails]
    return [_limited(f"tail-{number}", row, tail, results.shown_as) for number, (row, tail) in enumerate(limited)]


def _limited(key: str, row: ComparedRow, tail: LimitedTail, shown_as: str) -> Panel:
    assert row.limit is not None, "a tail is of a limit"
    default, tuned = role_look(DEFAULT), role_look(TUNED)
    curves = [Curve(DEFAULT, default, tail.default), Curve(shown_as, tuned, tail.tuned)]
    marks = [
        Rule(look=BOUND, axis="y", value=row.limit),
        _counted(DEFAULT, default, tail.tuned.limit, tail.default_count, tail.confidence),
        _counted(shown_as, tuned, tail.tuned.limit, tail.tuned_count, tail.confidence),
    ]
    return _panel(key, f"{tail.tuned.event}, {tail.scenario}", curves, row.limit, marks)


def _counted(name: str, look: Look, level: float, count: ShareCount, confidence: float) -> Points:
    """Return a counted share with its interval, or its bound if 0."""
    low, high = clopper_pearson(count.events, count.flights, confidence)
    share = count.events / count.flights if count.events else count.upper
    # Both may have the same bound: the default's stands around the other.
    shown = look if count.events else look._replace(symbol="triangle-down", size=15.0 if look.hollow else 8.0)
    ends = (np.array([low]), np.array([high])) if count.events else None
    hover = [f"{name}, confirmation flights: {count.words}"]
    return Points(look=shown, x=np.array([level]), y=np.array([share]), y_ends=ends, hover=hover)


def _panel(key: str, title: str, curves: Sequence[Curve], smallest: float, more: Sequence[Mark] = ()) -> Panel:
    event = curves[0].event
    unit, factor = in_degrees(event.unit)
    marks: list[Mark] = [Rule(look=RULE, axis="x", value=factor * event.limit)]
    for curve in curves:
        marks += _curve(curve, factor)
    least = max(min(smallest, *(curve.event.probability or 1.0 for curve in curves)), FLOOR)
    x, y = Axis(bracketed(event.metric or "demand over capacity", unit)), Axis("probability", SPREAD * least, TOP, True)
    return Panel(key, title, x, y, [*marks, *more])


def _curve(curve: Curve, factor: float) -> list[Mark]:
    """Return line and band of an event: the line where its probability is positive, the band where it is bounded."""
    rows = np.array([(factor * each.level, each.probability, each.low, each.high) for each in curve.event.curve])
    level, probability, low, high = rows.reshape(-1, 4).T
    seen, bounded = probability > 0.0, high > 0.0
    return [
        Band(
            look=curve.look._replace(opacity=OPACITY),
            x=level[bounded],
            low=np.maximum(low[bounded], FLOOR),
            high=high[bounded],
        ),
        Line(
            look=curve.look,
            name=curve.name,
            x=level[seen],
            y=probability[seen],
            tips=(low[seen], high[seen]),
            tip="%{y:.2~g} [%{customdata[0]:.2~g}, %{customdata[1]:.2~g}]",
        ),
    ]
