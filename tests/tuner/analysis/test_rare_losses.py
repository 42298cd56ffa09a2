"""Early ends of held-out flights on a family with rare costly losses: the recommended point is that of all flights."""

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.flown_system import FlightBatch
from objectives.metrics import parse
from objectives.problem import Constraint, Objective, Problem
from objectives.risk import Risk
from plant.seeds import generator
from tuner.analysis.finals import Finals
from tuner.experiments.tuning.recommendation import best_row

FLIGHTS, POINTS = 256, 16
# Share of the flights that are lost, and what a lost one costs: as much as 40 that are completed.
LOSS, COST = 0.002, 40.0
LABELS = [Objective(parse("itae.position"), Risk("cvar", 0.8)), Objective(parse("travel"), Risk("mean"))]
LIMIT = Constraint(Objective(parse("failure"), Risk("mean")), 0.0)
STUDY: Any = SimpleNamespace(pick="knee", objectives=LABELS, table=SimpleNamespace(relevant=0.02))


class Family(Problem):
    """Points of a front whose flights are given, scores (rows, quantities, flights); a gains row is the number of its row."""

    def __init__(self, scores, lost, limited):
        self.objectives, self.constraints, self.screens = tuple(LABELS), (LIMIT,) if limited else (), ()
        self.scores, self.lost, self.flights_made = scores, lost, 0

    def chunks(self, batch):
        return [(0, batch.count)]

    def scored(self, gains, flown, batch, first, last, on_flights_done=None):
        self.flights_made += len(gains) * (last - first)
        rows = gains[:, 0].astype(int)
        quantities = len(self.objectives) + len(self.constraints)
        return self.scores[rows, :quantities, first:last], self.lost[rows, first:last]


def family(key, common):
    """A default and points around a bent front; lognormal flights that share their air, some of them lost: together or each alone."""
    draw = generator(3, "test/rare-losses", key)
    along = np.linspace(0.3, 3.0, POINTS)
    centres = np.concatenate([[[6.0, 6.0]], np.stack([along, 1.0 / along], axis=1)]) * draw.uniform(
        1.0, 1.05, (POINTS + 1, 2)
    )
    air = draw.standard_normal((1, 2, FLIGHTS)) + 0.2 * draw.standard_normal((POINTS + 1, 2, FLIGHTS))
    lost = draw.uniform(size=(1 if common else POINTS + 1, FLIGHTS)) < LOSS
    lost = np.broadcast_to(lost, (POINTS + 1, FLIGHTS))
    scores = np.where(lost[:, None], COST, centres[..., None] * np.exp(0.3 * air))
    return np.concatenate([scores, lost[:, None].astype(float)], axis=1), lost


def flown(scores, lost, limited, early):
    """Finalists with or without early ends, the row that is recommended, and their problem."""
    problem, choose = Family(scores, lost, limited), partial(best_row, STUDY, np.zeros(2, dtype=bool))
    batch: Any = FlightBatch(SimpleNamespace(name="gusts"), "held-out", FLIGHTS)  # pyright: ignore[reportArgumentType]
    finals = Finals(problem, np.arange(len(scores), dtype=float)[:, None], (batch,), choose, 1)
    everyone = np.arange(len(scores))
    found = finals.fly() if early else finals.complete(finals.fly_early(), everyone)
    return found, choose(found.evaluation.values, np.all(found.evaluation.violations <= 0.0, axis=1)), problem


def changes(repeats, limited, common):
    """Share of the runs in which early ends change the recommended point, of those clearly worse in everything, and of flights."""
    changed, worse, made = 0, 0, 0
    for key in range(repeats):
        scores, lost = family(key, common)
        _, mine, problem = flown(scores, lost, limited, early=True)
        made += problem.flights_made
        whole, theirs, _ = flown(scores, lost, limited, early=False)
        if mine == theirs:
            continue
        changed += 1
        apart = [whole.difference_to(i, theirs) for i in range(2)]
        worse += all(entry.low[mine] > 0.0 for entry in apart)
    return changed / repeats, worse, made / (repeats * (POINTS + 1) * FLIGHTS)


# Before losses not seen counted, 15 % of the runs changed where points lose flights each alone, 5 to 7 % where together.
@pytest.mark.slow
def test_early_ends_rarely_change_the_recommended_point():
    changed, worse, share = changes(16, limited=True, common=False)
    assert changed == 0.0 and worse == 0
    assert share < 0.8


@pytest.mark.slow
@pytest.mark.parametrize("limited", [True, False])
@pytest.mark.parametrize("common", [True, False])
def test_early_ends_change_the_recommended_point_in_at_most_3_percent_of_runs_and_never_for_the_worse(limited, common):
    changed, worse, _ = changes(300, limited, common)
    assert changed <= 0.03
    assert worse == 0
