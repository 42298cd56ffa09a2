"""Validation on made-up flights: who flies on, who makes way, what the air loses, and when the default is the answer."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.engine import LANES
from objectives.flown_system import FlightBatch
from objectives.metrics import parse
from objectives.problem import Constraint, Objective, Problem
from objectives.risk import Risk
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.seeds import generator
from tuner.analysis import air_losses
from tuner.analysis.held_out import SearchEstimate
from tuner.experiments.tuning import validation
from tuner.experiments.tuning.validation import Validation
from tuner.search.watcher import Watcher

MEAN, FLIGHTS, MAX_FLIGHTS = Risk("mean"), 64, 1024
ERROR = Objective(parse("itae.position"), MEAN)
OVERSHOOT = Constraint(Objective(parse("overshoot.x"), MEAN), 15.0, confidence=0.95)
FAILURE = Constraint(Objective(parse("failure"), MEAN), 0.0, confidence=0.95)
FOLLOWED = Constraint(Objective(parse("rms.position"), MEAN), 0.6, floor="mission.followed", confidence=0.95)


class Made(Problem):
    """A problem whose flights are given by stream: scores (rows, quantities, flights), lost (rows, flights)."""

    system: Any = SimpleNamespace(timing=SimpleNamespace(steps=1), arithmetic=LANES)

    def __init__(self, scores, lost, *constraints):
        self.objectives, self.constraints, self.screens = (ERROR,), constraints, ()
        self.scores, self.lost, self.flights_made = scores, lost, 0

    def chunks(self, batch):
        return [(batch.start, batch.count)]

    def scored(self, gains, flown, batch, first, last, on_flights_done=None):
        self.flights_made += len(gains) * (last - first)
        rows = gains[:, 0].astype(int)
        return self.scores[batch.stream][rows][..., first:last], self.lost[batch.stream][rows, first:last]


def made(errors, *limited, constraints=(OVERSHOOT,), spread=1.0) -> Made:
    """Points with a mean error and means of limited quantities each, whose flights share little of their air."""
    scores, means = (
        {},
        np.stack([np.array(errors, dtype=float), *[np.array(row, dtype=float) for row in limited]], axis=1),
    )
    for key, stream in enumerate((HELD_OUT, CONFIRMATION)):
        noise = generator(6, "test/validation", key).standard_normal((*means.shape, MAX_FLIGHTS))
        # Exact means of the held-out flights, and of those up to each further look.
        parts = np.split(noise, [FLIGHTS, 2 * FLIGHTS, 4 * FLIGHTS, 8 * FLIGHTS], axis=-1)
        noise = np.concatenate([part - part.mean(axis=-1, keepdims=True) for part in parts], axis=-1)
        scale = np.array([0.01, *[spread] * len(limited)])[:, None]
        scores[stream] = means[..., None] + scale * noise
    lost = {stream: np.zeros((len(means), MAX_FLIGHTS), dtype=bool) for stream in scores}
    return Made(scores, lost, *constraints)


def validated(problem, monkeypatch):
    rows = len(problem.scores[HELD_OUT])

    def batches(_, stream):
        # So many steps that no flights are cheap.
        spec: Any = SimpleNamespace(name="gusts", steps=lambda _: 100_000)
        return (FlightBatch(spec, stream, FLIGHTS),)

    monkeypatch.setattr(validation, "batches", batches)
    monkeypatch.setattr(
        air_losses, "is_lost", lambda made, row, batch, numbers: made.lost[batch.stream][int(row[0]), numbers]
    )
    named = SimpleNamespace(name="held-out-19", scenario="gusts")
    monkeypatch.setattr(validation, "named_losses", lambda *_: [named])
    study: Any = SimpleNamespace(
        seed=1, pick="knee", objectives=(SimpleNamespace(label="error"),), table=SimpleNamespace(relevant=0.02)
    )
    seen = [SearchEstimate(row[:1, 0], row[:, :8], np.repeat("gusts", 8)) for row in problem.scores[HELD_OUT]]
    names = ["default", *[f"p{row}" for row in range(1, rows)]]
    gains = np.arange(rows, dtype=float)[:, None]
    return Validation(problem, study, gains, names, seen, np.zeros(1, dtype=bool), Watcher()).conclude()


def test_who_straddles_the_limit_flies_on_and_the_best_that_keeps_it_is_recommended(monkeypatch):
    # Ends of the intervals of 64 flights lie 0.28 above the values: p1 is beyond, p2 straddles and keeps, p3 keeps at once.
    problem = made([20.0, 8.0, 9.0, 10.0], [20.0, 15.5, 14.8, 14.0])
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (2, True) and found.further_flights > 0
    assert problem.flights_made == 4 * FLIGHTS + found.further_flights + 2 * FLIGHTS
    assert any("p2 keeps every limit by" in text for text in found.warnings)


def test_points_that_no_look_would_settle_leave_the_flights_to_those_behind_them(monkeypatch):
    # The budget is 2,048 flights. p1 and p2 would take some 6,000 and 2,500, and each may make 1,024; p3 takes 256.
    problem = made([20.0, 8.18, 8.19, 8.2, 12.0], [20.0, 14.97, 14.955, 14.8, 14.0])
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (3, True) and found.further_flights == 3 * FLIGHTS
    # Where nothing else keeps the limit, they fly all the same.
    assert validated(made([20.0, 8.0], [20.0, 14.975]), monkeypatch).further_flights == MAX_FLIGHTS - FLIGHTS


def test_a_point_beyond_a_limit_by_value_flies_on_if_it_may_keep_it_and_is_better(monkeypatch):
    # Intervals of 64 flights end 0.28 from the values. Further flights are milder by 0.8: p1 keeps the limit by all of them.
    problem = made([20.0, 8.0, 10.0], [20.0, 15.05, 14.0])
    problem.scores[HELD_OUT][1, 1, FLIGHTS:] -= 0.8
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (1, True) and found.further_flights > 0
    # An objective smaller by a quarter of a relevant difference is worth no flights; nor are values surely beyond the limit.
    for error, value in ((9.96, 15.05), (8.0, 15.4)):
        problem = made([20.0, error, 10.0], [20.0, value, 14.0])
        assert (found := validated(problem, monkeypatch)).tuned == 2 and found.further_flights == 0


def test_the_point_with_the_most_flights_decides_its_neighbors(monkeypatch):
    # Both share their air, so p2 is 0.04 below p1 in every flight. 1,024 flights end 0.08 above a value: p1 stays open.
    problem = made([20.0, 8.0, 9.0, 12.0], [20.0, 14.94, 14.9, 14.0])
    problem.scores[HELD_OUT][2, 1] = problem.scores[HELD_OUT][1, 1] - 0.04
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (2, True) and found.further_flights == MAX_FLIGHTS - FLIGHTS
    (text,) = [text for text in found.warnings if "further held-out flights" in text]
    assert "p1 does not surely keep every limit by 1,024 flights" in text and "p2" not in text


def test_nobody_flies_on_who_would_not_be_recommended(monkeypatch):
    assert validated(made([20.0, 8.0, 9.0], [20.0, 14.0, 14.8]), monkeypatch).further_flights == 0


def test_without_a_decision_the_nearest_within_the_limits_by_value_is_named_with_its_flights(monkeypatch):
    problem = made([20.0, 8.0, 9.0], [20.0, 15.5, 14.999])
    found = validated(problem, monkeypatch)
    assert not found.keeps and found.tuned == 2
    assert found.to_settle is not None and found.to_settle > 8 * FLIGHTS
    nothing = validated(made([20.0, 8.0], [20.0, 15.5]), monkeypatch)
    assert not nothing.keeps and nothing.to_settle is None


def test_the_nearest_is_who_is_the_smallest_share_beyond_its_limits(monkeypatch):
    # 1 % of overshoot beyond 15 % is 7 % of the limit; 0.5 m beyond 0.6 m are 83 % of it.
    limits = (OVERSHOOT, Constraint(Objective(parse("rms.position"), MEAN), 0.6, confidence=0.95))
    problem = made([20.0, 8.0, 9.0], [40.0, 16.0, 10.0], [0.1, 0.1, 1.1], constraints=limits, spread=0.01)
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (1, False) and "violates them least" in found.why


def test_a_default_that_alone_keeps_the_limits_is_the_answer(monkeypatch):
    found = validated(made([20.0, 8.0, 9.0], [10.0, 20.0, 20.0]), monkeypatch)
    assert (found.tuned, found.keeps) == (0, True)


def test_a_default_that_is_as_good_stays(monkeypatch):
    found = validated(made([10.0, 9.9, 12.0], [10.0, 10.0, 10.0]), monkeypatch)
    assert (found.tuned, found.keeps) == (0, True) and "no finalist is better" in found.why


def test_who_breaks_a_limit_on_confirmation_flights_makes_way_for_the_next(monkeypatch):
    problem = made([20.0, 8.0, 9.0], [20.0, 14.0, 14.0])
    problem.scores[CONFIRMATION][1, 1] += 5.0
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (2, True)
    assert any(text.startswith("p1 satisfies every limit on held-out flights and breaks") for text in found.warnings)
    # Nobody is left, not even the default: the first one picked is told.
    problem.scores[CONFIRMATION][2, 1] += 5.0
    found = validated(problem, monkeypatch)
    assert found.tuned == 1 and not found.keeps and found.broken.tolist() == [0]
    # A default that keeps them is the answer then.
    problem.scores[HELD_OUT][0, 1] -= 10.0
    problem.scores[CONFIRMATION][0, 1] -= 10.0
    assert validated(problem, monkeypatch).tuned == 0


def test_neighbors_of_refuted_points_make_way_together_for_those_further_inside(monkeypatch):
    """Confirmation flights are harsher by 4 % of overshoot for all: seven points at the limit break it, the eighth keeps it."""
    errors = [20.0, *np.arange(8.0, 16.0).tolist()]
    problem = made(errors, [20.0, *np.linspace(14.0, 13.4, 7).tolist(), 10.0])
    problem.scores[CONFIRMATION][:, 1] += 4.0
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (8, True)
    first, second = [text for text in found.warnings if "makes way" in text]
    assert first.startswith("p1 ") and "with it" not in first
    assert (
        second.startswith("p2 ")
        and "five further points with it that the same difference would put beyond the limit" in second
    )
    # Where it would put all of them beyond, they are confirmed one after the other.
    problem = made(errors[:5], [20.0, 14.0, 13.9, 13.8, 13.7])
    problem.scores[CONFIRMATION][:4, 1] += 4.0
    assert validated(problem, monkeypatch).tuned == 4


def test_confirmation_flights_a_little_beyond_refute_nothing_that_all_flights_together_show(monkeypatch):
    problem = made([20.0, 8.0, 9.0], [20.0, 14.4, 14.0])
    problem.scores[CONFIRMATION][1, 1] += 0.65
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (1, True)


@pytest.mark.parametrize("stream", [HELD_OUT, CONFIRMATION])
def test_a_flight_that_everyone_loses_is_the_airs_and_one_that_a_point_loses_alone_is_its_own(monkeypatch, stream):
    problem = made([20.0, 8.0, 9.0], [0.0, 0.0, 0.0], constraints=(FAILURE,), spread=0.0)
    problem.scores[stream][:, 1, 19], problem.lost[stream][:, 19] = 1.0, True
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (1, True)
    assert any("held-out-19" in text and "the air loses it" in text for text in found.warnings)
    problem.scores[stream][1, 1, 30], problem.lost[stream][1, 30] = 1.0, True
    assert validated(problem, monkeypatch).tuned == 2


def test_all_that_lose_a_flight_make_way_together_where_none_may_be_lost(monkeypatch):
    """Seven points lose a flight that the default loses too, and the eighth keeps the limit: it is the answer."""
    errors = [20.0, *np.arange(8.0, 16.0).tolist()]
    problem = made(errors, [0.0] * 9, constraints=(FAILURE,), spread=0.0)
    problem.scores[CONFIRMATION][:8, 1, 19], problem.lost[CONFIRMATION][:8, 19] = 1.0, True
    found = validated(problem, monkeypatch)
    assert (found.tuned, found.keeps) == (8, True)
    (text,) = [text for text in found.warnings if "makes way" in text]
    assert (
        text.startswith("p1 satisfies every limit") and "six further points with it that lose the same flights" in text
    )


def test_an_automatic_limit_never_ends_a_run(monkeypatch):
    kept = {"constraints": (OVERSHOOT, FOLLOWED), "spread": 1e-6}
    # No worse than the default: kept.
    found = validated(made([20.0, 8.0, 9.0], [20.0, 14.0, 14.0], [0.7, 0.7, 0.5], **kept), monkeypatch)
    assert (found.tuned, found.keeps) == (1, True)
    # All that keep the study's own limit are worse than the default in it.
    found = validated(made([20.0, 8.0, 9.0], [20.0, 14.0, 20.0], [0.61, 0.9, 0.5], **kept), monkeypatch)
    assert (found.tuned, found.keeps) == (1, True) and found.further_flights == 0
