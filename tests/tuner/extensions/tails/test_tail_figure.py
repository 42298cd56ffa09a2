"""The chart of tails: one panel an event, one line the gains, whatever the probabilities are."""

import numpy as np
import pytest

from tests.undrawn import drawn
from tuner.documents.tail import TailEvent, TailLevel
from tuner.extensions.tails.document import TailDocument, TailGains
from tuner.extensions.tails.figure import tail_figure


@pytest.fixture(scope="module", autouse=True)
def drawn_figures():
    """Have figures drawn as they are; elsewhere they are blank."""
    with drawn():
        yield


def event(text, levels, **changes):
    curve = [TailLevel(level=x, probability=p, low=0.8 * p, high=1.2 * p) for x, p in levels]
    values = {
        "event": text, "metric": "peak.roll", "unit": "rad", "limit": 0.5, "status": "estimated", "method": "splitting",
        "probability": levels[-1][1] if levels else 0.0, "low": 0.0, "high": 1.0, "flights": 9, "count": None, "replicas": 2,
        "modes": [], "curve": curve,
    }  # fmt: skip
    return TailEvent(**{**values, **changes})


def document(*gains):
    return TailDocument(
        format="gainproof-tail", version="0.1", scenario="gusts", duration=8.0, seed=1, smallest=1e-6, width=0.5,
        most_flights=100, parts={}, gains=[TailGains(gains=name, laws="", events=events) for name, events in gains], ratios=[],
    )  # fmt: skip


def test_every_event_has_a_panel_and_all_gains_a_line_in_degrees():
    levels = [(0.25, 0.1), (0.5, 1e-5)]
    both = [event("peak.roll > 0.5", levels), event("failure", levels, metric=None, unit="1", limit=1.0)]
    first, second = tail_figure(document(("a", both), ("b", both))).axes[:2]
    assert first.get_yscale() == "log"
    assert first.get_xlabel() == "peak.roll [°]"
    assert second.get_xlabel() == "demand over capacity"
    lines = [np.asarray(line.get_data()) for line in first.get_lines()]
    ends = [line[1, 1] for line in lines if line.shape[1] == 2 and line[0, 1] > 28.0]
    assert [end for end in ends if end < 1.0] == pytest.approx([1e-5, 1e-5])
    assert first.get_ylim()[0] == pytest.approx(3e-7)


@pytest.mark.parametrize("levels", [[], [(0.5, 0.0)], [(0.25, 1.0), (0.5, 1.0)]])
def test_probabilities_0_and_1_are_drawn_too(levels):
    assert tail_figure(document(("a", [event("peak.roll > 0.5", levels)]))).axes
