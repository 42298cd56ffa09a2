"""Points near a limit fly until it is decided: false passes stay below what the study allows, and what keeps it is kept."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.engine import LANES
from objectives.evaluator import Evaluator
from objectives.flown_system import FlightBatch
from objectives.metrics import parse
from objectives.problem import Constraint, Objective, Problem
from objectives.risk import Risk, flights_to_show
from plant.seeds import generator
from tuner.analysis import air_losses as air
from tuner.analysis.final_flights import FinalFlights
from tuner.analysis.limit_flights import BUDGET, LimitFlights, Look

FLIGHTS, MAX_GROWTH = 32, 16
# Steps of a usual flight and of a cheap one. Of the cheap, 32 x 32 flights fit into half of four million steps, twice as many do not.
STEPS, FEW_STEPS, CHEAP_GROWTH = 100_000, 1000, 32
ERROR = Objective(parse("itae.position"), Risk("mean"))
OVERSHOOT = Objective(parse("overshoot.x"), Risk("mean"))
FAILURE = Objective(parse("failure"), Risk("mean"))
FOLLOWED = Objective(parse("rms.position"), Risk("mean"))


class Given(Problem):
    """A problem whose flights are given: scores (rows, quantities, flights); a gains row is the number of its row."""

    system: Any = SimpleNamespace(timing=SimpleNamespace(steps=1), arithmetic=LANES)

    def __init__(self, scores, *constraints, lost=None):
        self.objectives, self.constraints, self.screens = (ERROR,), constraints, ()
        self.scores, self.flights_made = scores, 0
        self.lost = np.zeros((len(scores), scores.shape[-1]), dtype=bool) if lost is None else lost

    def chunks(self, batch):
        return [(batch.start, batch.count)]

    def scored(self, gains, flown, batch, first, last, on_flights_done=None):
        self.flights_made += len(gains) * (last - first)
        rows = gains[:, 0].astype(int)
        return self.scores[rows][..., first:last], self.lost[rows, first:last]


def looking(problem, count=FLIGHTS, steps=STEPS) -> tuple[LimitFlights, FinalFlights]:
    """Looks at the limits of a problem, and the held-out flights that they begin from."""
    rows, scores = len(problem.scores), problem.scores[..., :count]
    gains = np.arange(rows, dtype=float)[:, None]
    spec: Any = SimpleNamespace(name="gusts", steps=lambda _: steps)
    batch = FlightBatch(spec, "held-out", count)
    flown = FinalFlights(
        problem,
        1,
        scores,
        problem.lost[:, :count],
        np.repeat("gusts", count),
        np.zeros((rows, 0)),
        np.ones(count, dtype=bool),
        np.ones(rows, dtype=bool),
    )
    return LimitFlights(problem, gains, (batch,), 1), flown


def normal_scores(distance, key, rows=2, count=FLIGHTS * MAX_GROWTH):
    """Scores around a limit of 10 with a deviation of 1: row 1 lies a distance, in errors of the held-out mean, within it."""
    draw = generator(5, "test/limit-flights", key)
    scores = draw.standard_normal((rows, 2, count))
    scores[1:, 1] += 10.0 - distance / np.sqrt(FLIGHTS)
    return scores


def decided(distance, key, steps=STEPS) -> tuple[bool, int]:
    """Whether row 1 is found to keep the limit, and by how many flights."""
    scores = normal_scores(distance, key, count=FLIGHTS * CHEAP_GROWTH)
    limits, flown = looking(Given(scores, Constraint(OVERSHOOT, 10.0, confidence=0.95)), steps=steps)
    look = fly_on(limits, flown)
    return bool(look.excess[1, 0] <= 0.0), FLIGHTS + limits.flights


def fly_on(limits, flown) -> Look:
    """Return the look after which row 1 flies no further."""
    while (look := limits.look(flown)).is_open[1]:
        limits.fly(1, look.excess[1])
    return look


@pytest.mark.parametrize(("steps", "growth"), [(STEPS, MAX_GROWTH), (FEW_STEPS, CHEAP_GROWTH)])
def test_looks_together_spend_what_the_study_allows(steps, growth):
    limits, _ = looking(Given(normal_scores(0.0, 1), Constraint(OVERSHOOT, 10.0, confidence=0.95)), steps=steps)
    spent = [1.0 - limits.confidence(limits.problem.constraints[0], look) for look in range(limits.n_looks)]
    assert sum(spent) == pytest.approx(0.05) and 2 ** (limits.n_looks - 1) == growth


@pytest.mark.parametrize("steps", [STEPS, FEW_STEPS])
@pytest.mark.parametrize("count", [40, pytest.param(200, marks=pytest.mark.slow)])
def test_what_just_breaks_a_limit_passes_in_no_look_more_often_than_allowed(count, steps):
    passed = [decided(0.0, key, steps)[0] for key in range(count)]
    # One-sided 2.5 %, and three standard errors of that: 3.3 % from 200.
    assert np.mean(passed) <= 0.025 + 3.0 * np.sqrt(0.025 * 0.975 / count)


def test_flights_that_no_compiled_code_makes_are_never_cheap(monkeypatch):
    slow: Any = SimpleNamespace(timing=SimpleNamespace(steps=1), arithmetic="fmu")
    monkeypatch.setattr(Given, "system", slow)
    limits, _ = looking(Given(normal_scores(0.0, 1), Constraint(OVERSHOOT, 10.0, confidence=0.95)), steps=FEW_STEPS)
    assert 2 ** (limits.n_looks - 1) == MAX_GROWTH


def test_cheap_flights_find_more_of_what_keeps_a_limit_narrowly():
    shares = [np.mean([decided(0.7, key, steps)[0] for key in range(40)]) for steps in (STEPS, FEW_STEPS)]
    assert shares[1] > shares[0] + 0.1


@pytest.mark.parametrize("count", [10, pytest.param(200, marks=pytest.mark.slow)])
def test_what_just_breaks_a_limit_passes_by_a_neighbor_no_more_often_than_allowed(count):
    # Row 2 shares all but a fifth of its deviation with row 1, which flies to the last look.
    passed = []
    for key in range(count):
        scores = normal_scores(0.0, key, rows=3)
        scores[2, 1] = 10.0 + 0.2 * (scores[2, 1] - 10.0) + np.sqrt(0.96) * (scores[1, 1] - 10.0)
        limits, flown = looking(Given(scores, Constraint(OVERSHOOT, 10.0, confidence=0.95)))
        looks = [limits.look(flown)]
        while limits.fly(1, looks[-1].excess[1]):
            looks.append(limits.look(flown))
        assert limits.looked_at() == {1: FLIGHTS * MAX_GROWTH}
        passed.append(any(look.excess[2, 0] <= 0.0 for look in looks))
    assert np.mean(passed) <= 0.025 + 3.0 * np.sqrt(0.025 * 0.975 / count)


def test_a_neighbor_with_more_flights_halves_an_interval():
    scores = normal_scores(1.0, 3, rows=3)
    scores[2, 1] = 0.5 + scores[1, 1]
    limits, flown = looking(Given(scores, Constraint(OVERSHOOT, 10.0, confidence=0.95)))
    before = limits.look(flown)
    while limits.fly(1, limits.look(flown).excess[1]):
        pass
    after = limits.look(flown)
    # Both differ by 0.5 in every flight, so the interval of row 2 is that of row 1 at 16 times the flights.
    assert after.value[2, 0] == pytest.approx(0.5 + scores[1, 1].mean(), abs=1e-12)
    width = after.upper[:, 0] - after.low[:, 0]
    assert width[2] == pytest.approx(width[1], rel=1e-9)
    assert width[2] < 0.35 * (before.upper - before.low)[2, 0] and limits.flier(2) == 2


def test_what_keeps_a_limit_narrowly_is_found_by_flying_on():
    found = [decided(1.2, key) for key in range(60)]
    at_once = np.mean([passes and flights == FLIGHTS for passes, flights in found])
    assert at_once < 0.3 and np.mean([passes for passes, _ in found]) > 0.6


def test_what_is_far_from_a_limit_flies_no_further():
    assert decided(8.0, 0) == (True, FLIGHTS) and decided(-8.0, 0) == (False, FLIGHTS)


def test_the_budget_bounds_the_flights_of_all_together():
    scores = normal_scores(0.7, 3, rows=12)
    limits, flown = looking(Given(scores, Constraint(OVERSHOOT, 10.0, confidence=0.95)))
    while (rows := np.flatnonzero((look := limits.look(flown)).is_open)).size:
        limits.fly(int(rows[0]), look.excess[rows[0]])
    assert 0 < limits.flights <= BUDGET * FLIGHTS and limits.problem.flights_made == limits.flights
    assert sum(count - FLIGHTS for count in limits.looked_at().values()) == limits.flights


def test_a_row_makes_no_look_beyond_its_last_and_then_says_so():
    limits, flown = looking(Given(normal_scores(0.7, 3), Constraint(OVERSHOOT, 10.0, confidence=0.95)))
    entry = limits.problem.constraints[0]
    assert limits.confidence_of(entry, 1) == 0.95
    made = [limits.fly(1, limits.look(flown).excess[1]) for _ in range(5)]
    assert made == [True] * 4 + [False] and limits.looked_at() == {1: FLIGHTS * MAX_GROWTH}
    # Half of the error is left for four further looks.
    assert limits.confidence_of(entry, 1) == 1.0 - 0.05 / 8.0 and limits.confidence_of(entry, 0) == 0.95


def test_flights_that_would_settle_it_are_those_at_which_the_interval_ends_at_the_limit():
    limits, flown = looking(Given(normal_scores(1.0, 8), Constraint(OVERSHOOT, 10.0, confidence=0.95)))
    look = limits.look(flown)
    value, upper = look.value[1, 0], look.upper[1, 0]
    wanted = limits.flights_to_settle(look, flown, 1)
    assert wanted is not None and value < 10.0 < upper
    assert value + (upper - value) * np.sqrt(FLIGHTS / wanted) == pytest.approx(10.0, abs=1e-2)
    beyond, flown = looking(Given(normal_scores(-9.0, 7), Constraint(OVERSHOOT, 10.0, confidence=0.95)))
    assert beyond.flights_to_settle(beyond.look(flown), flown, 1) is None


@pytest.mark.parametrize("most", [0.0, 0.01, 0.005])
def test_a_limit_on_losses_flies_what_it_needs(most):
    flights = 2048
    scores = np.zeros((2, 2, flights))
    limits, flown = looking(Given(scores, Constraint(FAILURE, most, confidence=0.95)), 256)
    assert fly_on(limits, flown).excess[1, 0] == 0.0
    made = 256 + limits.flights
    # None of those flown is lost; a share takes so many that the interval of none ends within it.
    assert made == 256 if most == 0.0 else flights_to_show(most, 0.95) <= made < 4.0 * flights_to_show(most, 0.95)


def test_an_automatic_limit_asks_for_no_more_than_the_default_does():
    scores = np.zeros((4, 2, FLIGHTS))
    scores[:, 1] = np.array([0.62, 0.625, 0.60, 0.9])[:, None]
    limits, flown = looking(Given(scores, Constraint(FOLLOWED, 0.606, floor="mission.followed", confidence=0.95)))
    look = limits.look(flown)
    assert (look.excess[:, 0] > 0.0).tolist() == [False, False, False, True]
    assert not look.is_open.any()
    # 0.625 is 0.8 % more than the default, which a study may hold to be relevant.
    limits.relevant = 0.005
    assert (limits.look(flown).excess[:, 0] > 0.0).tolist() == [False, True, False, True]


def test_another_programs_trials_are_judged_as_they_are():
    problem: Any = SimpleNamespace(constraints=(), objectives=())
    assert not isinstance(problem, Problem) and issubclass(Problem, Evaluator)
    limits = LimitFlights(problem, np.zeros((2, 1)), (), 1)
    assert limits.confidence(Constraint(OVERSHOOT, 1.0, confidence=0.95), 0) == 0.95 and not limits.may_fly


def test_a_further_flight_that_everyone_loses_counts_for_nobody(monkeypatch):
    """The air loses flight 40, beyond the held-out ones, whatever flies it; flight 50 only row 1 loses."""
    for number, kept in ((40, True), (50, False)):
        scores, lost = normal_scores(1.2, 2, rows=3), np.zeros((3, FLIGHTS * MAX_GROWTH), dtype=bool)
        failure = np.zeros((3, 1, FLIGHTS * MAX_GROWTH))
        lost[1, number], failure[1, 0, number], scores[1, 1, number] = True, 1.0, 1e3
        monkeypatch.setattr(
            air, "is_lost", lambda _, row, __, numbers, n=number: [n == 40 or row[0] == 1 for _ in numbers]
        )
        given = Given(
            np.concatenate([scores, failure], axis=1),
            Constraint(OVERSHOOT, 10.0, confidence=0.95),
            Constraint(FAILURE, 0.0),
            lost=lost,
        )
        limits, flown = looking(given)
        limits.fly(1, limits.look(flown).excess[1])
        assert (limits.look(flown).excess[1, 1] == 0.0) == kept
