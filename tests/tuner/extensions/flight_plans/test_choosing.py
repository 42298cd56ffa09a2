"""Choice of excitations: amplitudes that fill the room within limits, and durations that end where more data harm."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plant.quadrotor.airframes import load
from tuner.extensions.flight_plans import choosing
from tuner.extensions.flight_plans.choosing import (
    MIN_LENGTH,
    AccuracyTarget,
    CandidateExcitation,
    ExcitationSet,
    TargetCapabilities,
    maximize_amplitude,
    required_durations,
)
from tuner.extensions.flight_plans.excitation import Excitation
from tuner.extensions.flight_plans.expected_accuracy import OutputPower
from tuner.extensions.vehicle_fit.parameters import space_of

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


def test_an_amplitude_at_which_a_flight_is_lost_is_too_large_however_small_its_peaks():
    """A flight that ends early has hardly begun to turn."""

    def flown(excitations, stream, count):
        (excitation,) = excitations
        return SimpleNamespace(completed=excitation.amplitude < 1.2, peaks={"rate": 0.1 * excitation.amplitude})

    simulated = SimpleNamespace(flown=flown)
    task: Any = SimpleNamespace(simulated=simulated, still={"rate": 0.0}, limits={"rate": 10.0})
    assert 0.85 * 1.2 <= maximize_amplitude(task, YAW).amplitude < 1.2


def test_durations_end_where_more_of_an_axis_carries_in_more_error_than_it_tells():
    """Of a racer, 60 s of roll and pitch left inertias wider than before the flight: damping is given to 50 % only."""
    at, given = SPACE.names.index("inertia.x"), SPACE.names.index("rate_damping")
    row = np.zeros(len(SPACE.names))
    row[at], row[given] = 1.0, 2.0
    candidate = CandidateExcitation(replace(YAW, axis="roll"), 0.5 * np.outer(row, row))
    selection = ExcitationSet(SPACE, {"roll": candidate})
    accuracy = AccuracyTarget(np.array([at]), np.array([0.01]))
    capabilities = TargetCapabilities({"roll": "angle"})
    lengths = required_durations(selection, accuracy, capabilities)
    scores = [accuracy.score(selection.covariance({"roll": length})) for length in (0.0, MIN_LENGTH, 60.0)]
    assert scores[2] > scores[1] and lengths["roll"] in (0.0, MIN_LENGTH)


def test_an_output_counts_from_the_length_on_at_which_the_model_explains_it():
    """Of 8 s of lift among 37 s of noise 35 % were explained: identification left the thrust at its prior."""
    at = SPACE.names.index("thrust.65")
    information = np.zeros((len(SPACE.names),) * 2)
    information[at, at] = 1e4
    lift = Excitation("lift", "acceleration", 2.0, 1.0, 6.0, 8.0)
    power = OutputPower(excited=1.0, residual=0.2, still=0.2, still_residual=0.2)
    selection = ExcitationSet(SPACE, {"lift": CandidateExcitation(lift, information, power)})
    # LEAD, PAUSE and TAIL are 7 s of rest: (0.2 L + 1.4) / (L + 1.4) is to fall below 0.25.
    needed = (1.4 - 0.25 * 1.4) / 0.05
    assert power.explained(needed, 7.0) == pytest.approx(0.75)
    deviations = [np.sqrt(selection.covariance({"lift": length})[at, at]) for length in (needed - 1.0, needed + 1.0)]
    assert deviations[0] == pytest.approx(SPACE.prior_std[at]) and deviations[1] < 0.01
    accuracy = AccuracyTarget(np.array([at]), np.array([0.05]))
    found = required_durations(selection, accuracy, TargetCapabilities({"lift": "acceleration"}))
    assert needed <= found["lift"] <= 1.5 * needed


def test_lift_has_a_length_of_its_own_where_other_axes_share_theirs():
    capabilities = TargetCapabilities({"roll": "rate", "yaw": "rate", "lift": "acceleration"}, alike=True)
    assert capabilities.groups == [("roll", "yaw"), ("lift",)]
    assert TargetCapabilities({"roll": "angle", "lift": "acceleration"}).groups == [("roll",), ("lift",)]
    steps = replace(capabilities, lift_waves=("steps",)).shapes("lift")
    assert [(wave, band) for wave, band, _ in steps] == [("steps", (0.5, 0.5)), ("steps", (1.0, 1.0))]
