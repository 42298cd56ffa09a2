"""Loops of a quadrotor: drawn in their worst steady state, and limits near which the first answer reads nothing exactly."""

import numpy as np
import pytest

import tuner
from tests.tuner.extensions.studio.conftest import STUDIES
from tuner.extensions.studio.flights import Flights, search_values
from tuner.extensions.studio.loops import LoopCurves
from tuner.extensions.studio.session import Setting, open_session
from tuner.study.margins import INEXACT, MarginAnalysis


def peak(curve):
    return float(np.max(1.0 / np.abs(1.0 + curve.response)))


def test_the_drawn_loop_is_that_of_the_worst_state():
    session = open_session(STUDIES / "quickstart.toml")
    loops = LoopCurves(session)
    (limit,) = (
        row
        for row in tuner.margins(session.gains(session.default.row), study=session.study).document.requirements
        if row.quantity == "ms" and row.channel is None
    )
    drawn = {channel: loops.curve(session.default, channel) for channel in loops.channels}
    worst = max(drawn.values(), key=peak)
    # A grid of 300 frequencies misses the peak by little and never exceeds it.
    assert limit.value is not None and 0.99 * limit.value < peak(worst) <= limit.value * (1.0 + 1e-9)
    assert limit.states is not None and len(limit.states) > 1
    assert worst.case.partition(", ")[0] == limit.state


def test_a_moving_hand_looks_at_the_place_of_the_latest_setting_alone(monkeypatch):
    session = open_session(STUDIES / "quickstart.toml")
    loops = LoopCurves(session)
    rested = loops.curve(session.default, "roll")
    row = session.row({"attitude.k1": 1.1 * session.values(session.default.row)["attitude.k1"]})
    seen = []
    draw = loops._drawn
    monkeypatch.setattr(loops, "_drawn", lambda *given: (seen.append(given), draw(*given))[1])
    moved = loops.curve(Setting("here", row, "here"), "roll", rests=False)
    assert len(seen) == 1 and moved.case == rested.case
    # Once it rests all places are looked at.
    every = [draw(row, "roll", place) for place in loops._places]
    worst = loops.curve(Setting("here", row, "here"), "roll")
    assert len(every) > 4 and peak(worst) == max(map(peak, every)) and worst.case == max(every, key=peak).case


def test_the_first_answer_reads_no_margins_exactly(monkeypatch):
    """0.7 s of a move near a limit; the values are within the share by which those of a search are inexact."""
    session = open_session(STUDIES / "px4.toml")
    problem = Flights(session.study, 2).problem
    (gain,) = (each for each in session.study.space.variables if each.name == "horizontal.p")
    rows = session.row({gain.name: gain.high})[None]
    complete = problem.screens[0].complete
    assert complete is not None
    exact = complete(rows)
    monkeypatch.setattr(MarginAnalysis, "exact", lambda *_: pytest.fail("exact margins were read"))
    quick = search_values(problem, rows)
    limits = np.array([entry.limit for entry in problem.requirements])
    assert np.all(np.abs(quick - exact) <= INEXACT * np.abs(limits))
    # The row is one that the complete analysis reads again, or the test would show nothing.
    assert np.any(np.abs(exact - limits) < INEXACT * np.abs(limits))
