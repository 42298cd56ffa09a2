"""The box in which a search's hypervolume is measured: the default's, or its own where the default breaks limits."""

import numpy as np
import pytest

from objectives.evaluator import Evaluation
from tuner.search.convergence import StoppingRule
from tuner.search.front import feasible_front, hypervolume
from tuner.search.loop import archive, search_generations

GENERATIONS, POPULATION = 16, 6
# A candidate is feasible where x + y >= 1: the front is that line, and a default below it breaks the limit.
LIMIT = 1.0


class Scripted:
    """A search that comes ever closer to the front; the very first candidate is the default."""

    def __init__(self, default):
        self.draw, self.asked, self.default = np.random.default_rng(1), 0, np.array(default)

    def ask(self):
        along = self.draw.uniform(size=(POPULATION, 1))
        above = self.draw.uniform(0.5, 1.0, (POPULATION, 1)) * 0.6**self.asked
        points = np.concatenate([along, 1.0 - along], axis=1) + above
        if not self.asked:
            points[0] = self.default
        self.asked += 1
        return points

    def tell(self, values, violations):
        """Learn nothing: the script is given."""


def evaluate(points):
    none, n = np.zeros((len(points), 0)), len(points)
    excess = (LIMIT - points.sum(axis=1))[:, None]
    return Evaluation(points, excess, np.zeros(n), points[..., None], np.array([""]), none, np.ones(n, dtype=bool))


def searched(default):
    return list(search_generations(Scripted(default), evaluate, StoppingRule(GENERATIONS)))[-1]


@pytest.mark.parametrize("default", [(0.05, 0.05), (1e6, -1e6)], ids=["below the front", "far off"])
def test_a_default_that_breaks_limits_does_not_make_the_box(default):
    """In the box of a default below the front no candidate counts; in that of one far off all count alike."""
    generations = searched(default)
    volumes = [entry.hypervolume for entry in generations]
    assert 0.01 < volumes[0] < 0.9 and volumes == sorted(volumes)
    assert volumes[-1] > 1.05 * volumes[0]
    first = archive(generations[:1])
    front = first.values[first.front()]
    last = archive(generations)
    assert volumes[-1] == pytest.approx(hypervolume(last.values[last.front()], front.max(axis=0)), rel=1e-12)


def test_a_default_within_limits_makes_the_box():
    generations = searched((0.9, 0.8))
    last = archive(generations)
    rows = feasible_front(last.values, last.violations)
    assert generations[-1].hypervolume == hypervolume(last.values[rows], np.array([0.9, 0.8]))


def test_without_a_feasible_candidate_there_is_no_volume_and_the_first_one_makes_the_box():
    class Late(Scripted):
        def ask(self):
            points = super().ask()
            return points - 2.0 if self.asked < 5 else points

    generations = list(search_generations(Late((0.1, 0.1)), evaluate, StoppingRule(GENERATIONS)))[-1]
    volumes = [entry.hypervolume for entry in generations]
    assert volumes[:4] == [0.0] * 4 and volumes[4] > 0.0 and volumes == sorted(volumes)
