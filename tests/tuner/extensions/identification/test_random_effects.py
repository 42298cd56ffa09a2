"""Random effects between flights against closed forms and their distributions, and on flights of vehicles that are known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from plant.errors import InputError
from plant.quadrotor.airframes import load
from tests.tuner.extensions.identification.conftest import CRAZYFLIE
from tests.tuner.extensions.identification.known_flights import AIRFRAME
from tuner.extensions.identification.building import earlier_posterior, identification_document
from tuner.extensions.identification.document import IdentificationDocument
from tuner.extensions.identification.flight_rows import after_change, check_agreement
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit.random_effects import (
    CAUSES,
    FlightEstimate,
    HomogeneityTest,
    between_flight_std,
    compare_estimates,
    compare_flights,
    pooled_estimate,
    predictive_variance,
)

NAMES = ("lag_up", "thrust.30", "inertia.x")


def estimate(point, covariance, names=NAMES, flight="one"):
    return FlightEstimate(flight, tuple(names), np.array(point, float), np.array(covariance, float))


def test_scatter_of_two_flights_is_what_the_difference_exceeds_their_errors_by():
    first, second = (estimate([value], [[0.04]], ["lag_up"]) for value in (0.0, 1.0))
    # E d^2 = 2 tau^2 + v1 + v2.
    assert between_flight_std([first, second])["lag_up"] == pytest.approx(np.sqrt((1.0 - 0.08) / 2.0))
    assert predictive_variance([first, second])["lag_up"] == pytest.approx(1.5 * (1.0 - 0.08) / 2.0)
    assert between_flight_std([first, first])["lag_up"] == 0.0
    assert between_flight_std([first]) == {}


def test_scatter_of_many_flights_is_that_of_the_draws():
    draw = np.random.default_rng(4)
    variances = draw.uniform(0.01, 0.2, 12)
    found = [
        between_flight_std(
            [estimate([draw.normal(0.0, np.sqrt(0.09 + v))], [[v]], ["lag_up"]) for v in variances.tolist()]
        )["lag_up"]
        ** 2
        for _ in range(800)
    ]
    # Truncation at 0 lifts the mean a little; three standard errors.
    assert np.mean(found) == pytest.approx(0.09, abs=3.0 * np.std(found) / np.sqrt(800) + 0.005)


def test_independent_differences_have_the_chi_square_of_as_many_degrees():
    first, second = estimate([0.1, 0.2, -0.3], np.diag([0.01, 0.02, 0.03])), estimate([0.0] * 3, np.diag([0.01] * 3))
    found = compare_estimates(first, second)
    z = np.array([0.1, 0.2, -0.3]) / np.sqrt([0.02, 0.03, 0.04])
    assert (found.statistic, found.degrees) == pytest.approx((z @ z, 3.0))
    assert found.probability == pytest.approx(stats.chi2.sf(z @ z, 3))
    assert not found.differences


@pytest.mark.parametrize("shared", [0.0, 0.5, 0.9])
def test_correlated_flights_of_one_vehicle_are_rejected_as_often_as_allowed(shared):
    draw, tries = np.random.default_rng(7), 4000
    covariance = 0.01 * (shared + (1.0 - shared) * np.eye(3))
    others = estimate([0.0] * 3, 0.5 * covariance)
    points = draw.multivariate_normal(np.zeros(3), 1.5 * covariance, tries)
    rejected = np.mean([compare_estimates(estimate(point, covariance), others).is_rejected for point in points])
    # Satterthwaite's approximation is a little liberal in the tail: 1 % may become 1.7 %.
    assert rejected < 0.017 + 3.0 * np.sqrt(0.01 / tries)


def test_what_differs_is_named_with_its_causes():
    others = estimate([0.0] * 3, 0.001 * np.eye(3))
    found = compare_estimates(estimate([0.0, 0.4, 0.0], 0.001 * np.eye(3)), others)
    assert found.is_rejected and list(found.differences) == ["thrust.30"]
    assert set(found.causes) == {cause for cause, names in CAUSES.items() if "thrust.30" in names}
    # Scatter that is as large explains it.
    assert not compare_estimates(estimate([0.0, 0.4, 0.0], 0.001 * np.eye(3)), others, {"thrust.30": 0.2}).is_rejected


def test_of_many_flights_of_one_vehicle_any_is_rejected_as_often_as_allowed():
    draw, tries, flights = np.random.default_rng(11), 800, 5
    rejected = 0
    for _ in range(tries):
        drawn = [estimate(0.1 * draw.normal(size=3), 0.01 * np.eye(3), flight=str(k)) for k in range(flights)]
        rejected += any(test.is_rejected for test in compare_flights(drawn))
    assert rejected <= 0.01 * tries + 3.0 * np.sqrt(0.01 * tries)


def test_flights_without_a_common_number_agree():
    one, other = estimate([0.0], [[1.0]], ["lag_up"]), estimate([9.0], [[0.1]], ["inertia.x"])
    assert compare_estimates(one, other).probability == 1.0


def test_the_pooled_estimate_is_the_weighted_mean_and_has_every_name():
    first, second = estimate([1.0, 5.0], np.diag([0.1, 1.0]), NAMES[:2]), estimate([3.0], [[0.3]], NAMES[:1])
    pooled = pooled_estimate([first, second])
    assert pooled.names == NAMES[:2]
    assert pooled.point == pytest.approx([(10.0 + 10.0) / (10.0 + 10.0 / 3.0), 5.0])
    assert np.diag(pooled.covariance) == pytest.approx([1.0 / (10.0 + 10.0 / 3.0), 1.0])


def test_scatter_between_flights_evens_the_weights_of_the_pooled_estimate():
    """Each flight counts by 1 / (its variance + that between flights); errors of the mean are the flights' own."""
    first, second = estimate([1.0], [[0.1]], ["lag_up"]), estimate([3.0], [[0.9]], ["lag_up"])
    pooled = pooled_estimate([first, second], {"lag_up": np.sqrt(0.3)})
    # 1 / 0.4 and 1 / 1.2: shares of 3/4 and 1/4, where they would be 9/10 and 1/10 without scatter.
    assert pooled.point == pytest.approx([0.75 * 1.0 + 0.25 * 3.0])
    assert pooled.covariance[0, 0] == pytest.approx(0.75**2 * 0.1 + 0.25**2 * 0.9)
    assert pooled_estimate([first, second], {"inertia.x": 9.0}).point == pytest.approx([0.9 * 1.0 + 0.1 * 3.0])


@pytest.mark.parametrize("cause", CAUSES)
def test_the_cause_that_explains_most_comes_first(cause):
    found = HomogeneityTest(99.0, 1.0, 0.0, dict.fromkeys(CAUSES[cause], 3.0))
    explained = [len(set(CAUSES[name]) & set(CAUSES[cause])) for name in found.causes]
    assert explained == sorted(explained, reverse=True) and explained[0] == len(CAUSES[cause]) and explained[-1] > 0


def weakened(log):
    """The log of a vehicle whose propellers give a fifth less thrust at the same command."""
    return replace(log, command=np.sqrt(1.25) * log.command)


def shifted(identified, flight, moves):
    """The identified vehicle with some numbers of one of its flights moved: a contradiction without a fit."""
    estimate = identified.flights[flight]
    point = estimate.point + [moves.get(name, 0.0) for name in estimate.names]
    flights = list(identified.flights)
    flights[flight] = estimate._replace(point=point)
    return replace(identified, flights=tuple(flights))


WEAKER = dict.fromkeys(("thrust.30", "thrust.65", "thrust.100"), np.log(0.8))
"""Numbers that a fifth less thrust moves, see `weakened`."""


def test_a_flight_that_agrees_passes_and_one_that_contradicts_is_refused_until_it_is_explained(rough_halves):
    same = rough_halves.second
    check_agreement(same, Path("first.json"))
    assert len(same.all_flights) == 2
    other = shifted(same, 0, WEAKER)
    with pytest.raises(InputError, match=r"contradicts first.json .*thrust.65 by -.* --changed"):
        check_agreement(other, Path("first.json"))
    space = same.space.with_prior(after_change(rough_halves.earlier, "propellers"))
    check_agreement(replace(other, fit=replace(same.fit, space=space)), Path("first.json"))


@pytest.mark.slow
def test_weaker_propellers_are_refused_until_they_are_named_and_then_told(halves):
    earlier, lighter = halves.earlier, weakened(halves.logs[1])
    other = identify_vehicle([lighter], AIRFRAME, earlier=earlier)
    with pytest.raises(InputError, match=r"contradicts first.json .*thrust.65 by -.* --changed"):
        check_agreement(other, Path("first.json"))
    changed = identify_vehicle([lighter], AIRFRAME, earlier=after_change(earlier, "propellers"))
    check_agreement(changed, Path("first.json"))
    at = changed.space.names.index("thrust.65")
    drop = changed.fit.estimate[at] - halves.second.fit.estimate[at]
    spread = np.sqrt(changed.covariance[at, at] + halves.second.covariance[at, at])
    assert drop == pytest.approx(np.log(0.8), abs=4.0 * spread)


def assert_named_and_wide(contradicting):
    document = identification_document(contradicting, [], None)
    assert "contradicts the other flights" in document.verdict and "Between flights scatter" in document.verdict
    at = contradicting.space.names.index("thrust.65")
    # Two flights that differ by d have intervals of the next that hold both.
    values = [flight.point[flight.names.index("thrust.65")] for flight in contradicting.flights]
    assert 1.96 * np.sqrt(contradicting.covariance[at, at]) > abs(values[0] - values[1])
    again = IdentificationDocument.parse(document.text())
    assert again.flights == document.flights


def test_flights_that_contradict_each_other_are_named_and_widen_the_intervals(rough_halves):
    assert "The flights agree" in identification_document(rough_halves.both, [], None).verdict
    assert_named_and_wide(shifted(rough_halves.both, 1, WEAKER))


@pytest.mark.slow
def test_a_flight_with_weaker_propellers_contradicts_the_other(halves):
    assert_named_and_wide(identify_vehicle([halves.logs[0], weakened(halves.logs[1])], AIRFRAME))


def test_an_unknown_change_and_a_payload_are_refused(rough_halves):
    with pytest.raises(InputError, match="battery"):
        after_change(rough_halves.earlier, "weather")
    with pytest.raises(InputError, match="weigh the vehicle"):
        after_change(rough_halves.earlier, "payload")


def test_a_document_with_an_impossible_flight_is_refused(rough_halves):
    first = identification_document(rough_halves.first, [], None)
    number = first.flights[0].numbers[0]
    numbers = [number.model_copy(update={"low": 2.0 * number.high}), *first.flights[0].numbers[1:]]
    broken = first.model_copy(update={"flights": [first.flights[0].model_copy(update={"numbers": numbers})]})
    with pytest.raises(InputError, match="cannot be"):
        earlier_posterior(broken, AIRFRAME, Path("first.json"))


@pytest.mark.slow
def test_two_parts_of_a_real_flight_agree():
    log = read_log(CRAZYFLIE)
    begin = float(log.time[0])
    parts = [log.between(begin, begin + 7.0), log.between(begin + 8.0, begin + 15.0)]
    identified = identify_vehicle(parts, load("crazyflie-pybullet"))
    assert not any(test.is_rejected for test in identified.tests)
