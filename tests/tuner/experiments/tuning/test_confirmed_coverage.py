"""Coverage of the recommended point's intervals with the selection inside: finalists of 8 flights, looks, up to five confirmations.

Flights are real ones of two linear plants with a limit that binds. A bank of 20,000 of them per candidate holds the truth, and
every run draws its own search, held-out and confirmation flights from it.
"""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom

from benchmarks.binding_limits import LAG, THIRD, Case, study_of
from objectives.evaluator import Evaluator
from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.seeds import generator
from plant.ties import increasing_order
from tuner.analysis.held_out import SearchEstimate, compare
from tuner.documents.summary import ComparedRow
from tuner.experiments.tuning import validation
from tuner.experiments.tuning.survivors import layers
from tuner.experiments.tuning.validation import Validated, Validation
from tuner.search.watcher import Watcher

BANK, CANDIDATES, FINALISTS, TRIED = 20_000, 32, 8, 2000
SEARCHED, FLIGHTS, MAX_FLIGHTS = 8, 64, 4096
FAMILIES = {
    "overshoot": Case(LAG, "iae.level", "overshoot.level", 5.0),
    "settling": Case(THIRD, "travel", "settling.level", 9.0),
}


class Bank(Problem):
    """A problem whose flights are those of a bank (rows, quantities, flights), by stream in an order of one's own."""

    def __init__(self, problem: Problem, confidence: float, scores: np.ndarray, order: np.ndarray) -> None:
        self.constraints = tuple(replace(entry, confidence=confidence) for entry in problem.constraints)
        self.objectives, self.screens, self.system = problem.objectives, (), problem.system
        self.scores, self.flights_made = scores, 0
        self.order = {HELD_OUT: order[:MAX_FLIGHTS], CONFIRMATION: order[MAX_FLIGHTS:]}

    def chunks(self, batch):
        return [(batch.start, batch.count)]

    def scored(self, gains, flown, batch, first, last, on_flights_done=None):
        rows = self.scores[gains[:, 0].astype(int)][..., self.order[batch.stream][first:last]]
        return rows, np.zeros((len(gains), last - first), dtype=bool)


@cache
def banked(name: str) -> tuple[Problem, np.ndarray, Any]:
    """Return problem, bank of the default and of candidates beside the limit, and study."""
    case = FAMILIES[name]
    study = study_of(case)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, 1, None, study.screens)
    spec = study.scenarios[0].spec
    tried = study.space.gains(generator(1, "test/bank", 0).random((TRIED, len(study.space.variables))))
    seen = problem.evaluate_gains(tried, (FlightBatch(spec, "look", 32),))
    limited = seen.excess[:, 0] + case.most
    beside = seen.flown & np.all(seen.violations[:, 1:] <= 0.0, axis=1) & (np.abs(limited / case.most - 1.0) < 0.3)
    rows = np.flatnonzero(beside)
    # What is better by objective is nearer to the limit or beyond it.
    chosen = rows[increasing_order(layers(np.stack([seen.values[rows, 0], limited[rows]], axis=1)))[:CANDIDATES]]
    gains = np.concatenate([study.default_row[None], tried[chosen]])
    flown = problem.evaluate_gains(gains, (FlightBatch(spec, "bank", BANK),), fly_all=True, complete=True)
    return problem, flown.scores, study


def found_by(
    problem: Problem, bank: np.ndarray, study: Any, confidence: float, key: int, monkeypatch
) -> tuple[np.ndarray, list[ComparedRow], Validated]:
    """Return the finalists' rows of the bank, the table, and what is validated in one run."""
    draw = generator(key, "test/confirmed", 0)
    order = draw.permutation(BANK)[: MAX_FLIGHTS + FLIGHTS + SEARCHED]
    search = bank[..., order[-SEARCHED:]]
    rows = 1 + draw.permutation(len(bank) - 1)[: len(bank) // 2]
    risks = Evaluator.risks(problem, search, np.repeat("day", SEARCHED))
    kept = rows[np.all(problem.constraint_excess(risks)[rows] <= 0.0, axis=1)]
    kept = kept if len(kept) else rows[:1]
    rows = np.concatenate([[0], kept[increasing_order(risks[kept, 0])[:FINALISTS]]])
    seen = [SearchEstimate(risks[row, :1], search[row], np.repeat("day", SEARCHED)) for row in rows]
    monkeypatch.setattr(
        validation, "batches", lambda _, stream: (FlightBatch(study.scenarios[0].spec, stream, FLIGHTS),)
    )
    given = Bank(problem, confidence, bank[rows], order[:-SEARCHED])
    gains, names = np.arange(len(rows), dtype=float)[:, None], [f"p{row}" for row in rows]
    own: Any = SimpleNamespace(seed=key, pick="knee", objectives=study.objectives, table=study.table)
    worst = np.zeros(len(study.objectives), dtype=bool)
    validated = Validation(given, own, gains, names, seen, worst, Watcher()).conclude()
    return rows, compare(given, validated.confirmation, key), validated


@pytest.mark.slow
@pytest.mark.parametrize("confidence", [0.95, 0.0])
@pytest.mark.parametrize("name", FAMILIES)
def test_intervals_of_the_confirmed_point_hold_the_truth(name, confidence, monkeypatch):
    """Objective, limited quantity and the differences of both to the default, in 300 runs."""
    repeats = 300
    problem, bank, study = banked(name)
    truth, hits = problem.risks(bank, np.repeat("day", BANK)), list[np.ndarray]()
    for key in range(repeats):
        rows, table, validated = found_by(problem, bank, study, confidence, key, monkeypatch)
        if validated.keeps and validated.tuned:
            of_row, of_default = truth[rows[validated.tuned], :2], truth[0, :2]
            pairs = [*zip(of_row, [row.tuned for row in table[:2]], strict=True)]
            pairs += zip(of_row - of_default, [row.difference for row in table[:2]], strict=True)
            hits.append(np.array([each.low <= value <= each.high for value, each in pairs]))
    counts, made = np.sum(hits, axis=0), len(hits)
    # Fewer hits than the 1e-4 quantile of the binomial at 0.93 come once in 10,000.
    assert made > 0.9 * repeats
    assert np.all(counts >= binom.ppf(1e-4, made, 0.93)), counts / made
