"""Choice of excitations: amplitudes that fill the room within limits, and durations that end where more data harm."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant.quadrotor.airframes import load
from tuner.analysis.flight_plan import choosing
from tuner.analysis.flight_plan.choosing import (
    LEAST,
    AccuracyTarget,
    CandidateExcitation,
    ExcitationSet,
    TargetCapabilities,
    maximize_amplitude,
    required_durations,
)
from tuner.analysis.flight_plan.excitation import Excitation
from tuner.analysis.identification.parameters import space_of

SPACE = space_of(load("racer5").vehicle, ["1"])
YAW = Excitation("yaw", "rate", 0.5, 1.0, 6.0, 8.0)


@pytest.mark.parametrize(
    ("peak", "largest"),
    [
        (lambda amplitude: amplitude, 3.0),
        (lambda amplitude: amplitude**1.5, 3.0 ** (1.0 / 1.5)),
        (lambda amplitude: amplitude + 0.2 if amplitude > 1.0 else amplitude - 0.05, 2.8),
    ],
    ids=["linear", "steeper", "with an offset"],
)
def test_an_amplitude_fills_the_room_within_its_limits(peak, largest, monkeypatch):
    """Tries that came to the limit from above alone ended at the first amplitude: 28 deg/s of yaw out of 155."""
    monkeypatch.setattr(choosing, "_room", lambda task, excitation: 3.0 / peak(excitation.amplitude))
    task: Any = type("Task", (), {"limits": {"rate": 10.0}})
    amplitude = maximize_amplitude(task, YAW).amplitude
    assert 0.85 * largest <= amplitude <= largest


def test_durations_end_where_more_of_an_axis_carries_in_more_error_than_it_tells():
    """Of a racer, 60 s of roll and pitch left inertias wider than before the flight: damping is given to 50 % only."""
    at, given = SPACE.names.index("inertia.x"), SPACE.names.index("rate_damping")
    row = np.zeros(len(SPACE.names))
    row[at], row[given] = 1.0, 2.0
    told = CandidateExcitation(replace(YAW, axis="roll"), 0.5 * np.outer(row, row))
    selection = ExcitationSet(SPACE, {"roll": told})
    accuracy = AccuracyTarget(np.array([at]), np.array([0.01]))
    capabilities = TargetCapabilities({"roll": "angle"})
    lengths = required_durations(selection, accuracy, capabilities)
    scores = [accuracy.score(selection.covariance({"roll": length})) for length in (0.0, LEAST, 60.0)]
    assert scores[2] > scores[1] and lengths["roll"] in (0.0, LEAST)
