"""Lost flights have names, times and causes, and are flown again and drawn by name."""

from math import cos, radians

import numpy as np
import pytest

import tuner
from objectives.system import System
from plant.errors import InputError
from plant.quadrotor.closed_loop import Limits
from plant.status import Status
from tests.tuner.conftest import QUICKSTART
from tuner.cli.printers.gains import print_flights
from tuner.cli.terminal import Console
from tuner.study.build import load_study

SEEDS = 24


@pytest.fixture(scope="module")
def study():
    """The quickstart's steps in a strong wind, with a narrow limit on the error: some flights leave it, others do not."""
    changes = {
        "scenario.0.duration": 3.0,
        "scenario.0.air.intensity": "moderate",
        "scenario.0.air.mean_wind": False,
        "limits.position": 1.2,
        "margin": [],
    }
    return tuner.load_study(QUICKSTART, changes)


@pytest.fixture(scope="module")
def flown(study):
    return tuner.fly(tuner.default_gains("hybrid", "ladrc"), study=study, flights=SEEDS)


def test_lost_flights_are_named_with_time_cause_and_limit(flown):
    lost, failure = flown.document.lost, flown.table.loc["failure"]
    assert 0 < len(lost) < SEEDS and failure["mean"] == pytest.approx(len(lost) / SEEDS)
    assert [entry.name for entry in lost] == [f"held-out-{entry.index}" for entry in lost]
    for entry in lost:
        assert 0.0 < entry.time < 3.0 and (entry.cause, entry.limit) == ("position", "1.2 m off along an axis")
    count = next(row.count for row in flown.document.metrics if row.metric == "failure")
    assert count is not None and (count.events, count.flights) == (len(lost), SEEDS)


def test_one_of_them_flown_by_name_ends_as_it_did(flown, study):
    entry = flown.document.lost[-1]
    again = tuner.fly(tuner.default_gains("hybrid", "ladrc"), study=study, flight=entry.name)
    assert again.document.lost == [entry] and again.count == 1
    # The recorder saw the same flight: within its limit until its end, to within an instant of 12 ms at some 5 m/s.
    responses = again.recorded
    error = np.abs(responses.actual[0, :, :3] - responses.reference[0, :, :3]).max(axis=1)
    assert error[responses.time < entry.time - 0.012].max() < 1.2
    assert error[responses.time > entry.time - 0.012].max() > 1.2 - 0.06
    whole = tuner.fly(tuner.default_gains("hybrid", "ladrc"), study=study, flight=f"held-out-{_kept(flown)}")
    assert whole.document.lost == []


def test_the_terminal_says_what_lost_flights_do_to_metrics(flown, study, capsys):
    print_flights(flown, Console(width=160))
    lost = flown.document.lost
    text = capsys.readouterr().out
    assert f"{len(lost)} of {SEEDS} flights were lost; in every metric each of them has the cost of a loss." in text
    alone = tuner.fly(tuner.default_gains("hybrid", "ladrc"), study=study, flight=lost[0].name)
    print_flights(alone, Console(width=160))
    text = capsys.readouterr().out
    # Its metrics are costs of the loss alone.
    assert f"Lost: {lost[0].words}." in text and "travel" not in text


def _kept(flown):
    return min(set(range(SEEDS)) - {entry.index for entry in flown.document.lost})


@pytest.mark.parametrize(
    "name", ["4679", "held-out-", "held-out-x", "heldout-3", "held-out--3", "held-out-99999999999"]
)
def test_names_of_no_flight_are_refused(name):
    with pytest.raises(InputError, match="held-out-INDEX"):
        tuner.fly(tuner.default_gains("hybrid", "ladrc"), flight=name)


def test_no_interval_of_a_metric_lies_below_zero_or_has_no_width_where_flights_differ(flown, study):
    for row in flown.document.metrics:
        assert 0.0 <= row.low <= row.mean <= row.high
    calm = tuner.fly(tuner.default_gains("hybrid", "ladrc"), flights=16).document
    failure = next(row for row in calm.metrics if row.metric == "failure")
    assert (failure.mean, failure.low) == (0.0, 0.0) and failure.high == pytest.approx(1.0 - 0.025 ** (1 / 16))
    assert failure.count is not None and failure.count.words == "0 of 16: at most 21 %"


@pytest.mark.parametrize(
    ("status", "cause", "limit"),
    [
        (Status.TILTED, "tilt", "70 deg of tilt"),
        (Status.LOST, "position", "4 m off along an axis"),
        (Status.NON_FINITE, "not finite", "finite numbers"),
    ],
)
def test_every_status_has_its_limit_in_words(status, cause, limit):
    base = load_study(QUICKSTART, {}).system
    system = System(base.vehicle, base.cascade, base.nominal, Limits(4.0, cos(radians(70.0))), base.timing)
    assert system.failure_causes[status] == (cause, limit)
