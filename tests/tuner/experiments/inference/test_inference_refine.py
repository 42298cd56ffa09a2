"""Least squares and what it allows to say, on problems whose answers are known in closed form or by simulation."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from tests.tuner.experiments.inference.asked import write
from tests.tuner.study.loading import load_inference
from tuner.experiments.inference.misfit import EvaluatedSettings, best_row, concatenate, evaluate_settings, overall
from tuner.experiments.inference.ranges import (
    MAX_IDENTIFIED,
    MAX_WEAK,
    PRIOR_VARIANCE,
    Range,
    covariance,
    ranges,
    scatter,
)
from tuner.experiments.inference.refine import CLOSE, FAR, Jacobian, neighbors, refine


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    return load_inference(write(tmp_path_factory.mktemp("files")))


@dataclass
class LogLinear:
    """Cells whose logarithms are linear in the point, and stand at the published values at `answer`."""

    asked: Any
    matrix: np.ndarray
    answer: np.ndarray
    flown: int = 0

    def fly(self, points):
        self.flown += len(points)
        ours = self.asked.published * np.exp((points - self.answer) @ self.matrix.T)
        scores = np.repeat(ours[:, :, None], 3, axis=-1)
        return evaluate_settings(
            self.asked, self.asked.space.values(points), -1, scores, np.zeros(scores.shape, dtype=bool)
        )


MATRIX = np.array([[4.0, 1.0], [3.0, -2.0], [0.5, 1.5], [-1.0, 2.0]])


def test_a_log_linear_problem_is_solved_in_a_round(asked):
    model = LogLinear(asked, MATRIX, np.array([0.3, 0.7]))
    start = np.array([0.6, 0.2])
    settings, jacobian = refine(asked, start, model.fly(start[None]), model.fly)
    assert overall(settings.misfits(asked)).min() < 1e-2
    assert jacobian.matrix == pytest.approx(MATRIX)
    assert asked.space.point(settings.values[best_row(settings.misfits(asked))]) == pytest.approx(
        model.answer, abs=2e-3
    )


def test_an_answer_outside_is_met_at_the_end_of_the_range(asked):
    model = LogLinear(asked, np.array([[4.0, 0.0], [3.0, 0.0], [0.0, 2.0], [0.0, 1.0]]), np.array([1.4, 0.5]))
    start = np.array([0.5, 0.1])
    settings, _ = refine(asked, start, model.fly(start[None]), model.fly)
    assert asked.space.point(settings.values[best_row(settings.misfits(asked))]) == pytest.approx([1.0, 0.5], abs=2e-3)


def test_an_unknown_that_moves_nothing_stays_where_it_is_and_has_no_slope(asked):
    matrix = MATRIX * np.array([1.0, 0.0])
    model = LogLinear(asked, matrix, np.array([0.3, 0.7]))
    start = np.array([0.6, 0.2])
    settings, jacobian = refine(asked, start, model.fly(start[None]), model.fly)
    assert np.all(jacobian.matrix[:, 1] == 0.0)
    assert overall(settings.misfits(asked)).min() < 1e-2


def test_what_was_flown_before_is_kept_and_the_best_is_never_lost(asked):
    model = LogLinear(asked, MATRIX, np.array([0.3, 0.7]))
    before = model.fly(np.array([[0.1, 0.1], [0.31, 0.69]]))
    settings, _ = refine(asked, np.array([0.31, 0.69]), before, model.fly)
    assert np.array_equal(settings.values[:2], before.values)
    assert len(settings.values) == model.flown
    assert overall(settings.misfits(asked)).min() <= overall(before.misfits(asked)).min()


def test_neighbours_are_drawn_closer_where_nothing_is_better(asked):
    """At the answer itself no neighbour is better: 0.04, 0.02, 0.01 are tried, each with 2 x 2 neighbours and 5 steps."""
    model = LogLinear(asked, MATRIX, np.array([0.5, 0.5]))
    start = np.array([0.5, 0.5])
    refine(asked, start, model.fly(start[None]), model.fly)
    assert (FAR, CLOSE) == (0.04, 0.01)
    assert model.flown == 1 + 3 * (4 + 5)


def test_neighbours_stay_in_the_cube():
    around = neighbors(np.array([0.0, 0.99]), 0.04)
    assert around == pytest.approx(np.array([[0.0, 0.99], [0.0, 0.95], [0.04, 0.99], [0.0, 1.0]]))


def test_the_covariance_is_what_many_tables_scatter_by():
    """Points drawn from the range, tables drawn at them with correlated noise, answered by ridge regression by augmented rows."""
    draw, n = np.random.default_rng(8), 200_000
    factor = 0.3 * np.tril(draw.normal(size=(4, 4)))
    noise = factor @ factor.T
    sigma = np.sqrt(np.trace(noise) / 4)
    points = np.sqrt(PRIOR_VARIANCE) * draw.standard_normal((n, 2))
    tables = points @ MATRIX.T + draw.standard_normal((n, 4)) @ factor.T
    rows = np.concatenate([MATRIX / sigma, np.eye(2) / np.sqrt(PRIOR_VARIANCE)], axis=0)
    data = np.concatenate([tables / sigma, np.zeros((n, 2))], axis=1)
    answers = np.linalg.lstsq(rows, data.T, rcond=None)[0].T
    settings = (answers - points).T @ (answers - points) / n
    # The variance of a sample variance of n normal values is 2 var^2 / n.
    assert np.diag(covariance(MATRIX, noise)) == pytest.approx(np.diag(settings), rel=4.0 * np.sqrt(2.0 / n))


def test_what_no_cell_depends_on_is_known_to_its_range_only():
    spread = covariance(MATRIX * np.array([1.0, 0.0]), 1e-4 * np.eye(4))
    assert spread[1, 1] == pytest.approx(PRIOR_VARIANCE)
    assert spread[0, 0] < 1e-3
    assert np.diag(covariance(0.0 * MATRIX, 0.0 * np.eye(4))) == pytest.approx(PRIOR_VARIANCE)


def test_scatter_is_that_of_the_logarithms(asked):
    draw = np.random.default_rng(9)
    factor = np.tril(0.2 * draw.normal(size=(4, 4)))
    n = 40_000
    scores = asked.published[:, None] * np.exp(factor @ draw.standard_normal((4, n)))
    expected = factor @ factor.T
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    # The variance of a sample covariance of n normal pairs is at most 2 var var / n.
    assert np.all(np.abs(scatter(asked, scores) - expected) < 4.0 * np.sqrt(2.0 / n) * scale)


def test_ranges_of_a_known_misfit(asked):
    """Near are the settings up to 1.1 times the least misfit; shares are those of the logarithmic range."""
    model = LogLinear(asked, np.array([[1.0, 0.0]] * 4), np.array([0.5, 0.5]))
    settings = model.fly(np.array([[0.45, 0.9], [0.6, 0.5], [0.61, 0.1], [0.62, 0.0]]))
    shift = replace(settings, median=settings.median * np.exp(-1.0))
    # Misfits 1.05, 0.9, 0.89, 0.88: 1.05 is more than 1.1 times 0.88, the others are less.
    jacobian, scores = Jacobian(np.array([0.62, 0.0]), np.zeros((4, 2))), np.ones((4, 50))
    first, second = ranges(asked, shift, 3, jacobian, scores)
    units = [asked.unknowns[0].variable.unit(value) for value in (first.near_low, first.near_high)]
    assert units == pytest.approx([0.6, 0.62])
    assert asked.unknowns[1].variable.unit(second.near_high) == pytest.approx(0.5)
    assert (first.at_end, second.at_end) == (False, True)
    # Without slope the deviation is that of the range, 0.289 on either side; the second is cut off at its end.
    assert first.share == pytest.approx(2.0 * np.sqrt(PRIOR_VARIANCE))
    assert asked.unknowns[1].variable.unit(second.low68) == pytest.approx(0.0, abs=1e-12)
    assert second.share == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("share", "verdict"),
    [(0.0, "told"), (MAX_IDENTIFIED, "told"), (0.3, "loosely"), (MAX_WEAK, "loosely"), (0.6, "not")],
)
def test_verdicts(share, verdict):
    assert Range(1.0, 2.0, 1.0, 2.0, share, False).verdict == verdict


def test_joined_settings_stand_one_behind_the_other(asked):
    model = LogLinear(asked, MATRIX, np.array([0.5, 0.5]))
    one, other = model.fly(np.array([[0.1, 0.2]])), model.fly(np.array([[0.3, 0.4], [0.5, 0.6]]))
    both = concatenate([one, other])
    assert isinstance(both, EvaluatedSettings)
    assert np.array_equal(both.median, np.concatenate([one.median, other.median]))
    assert both.values.shape == (3, 2)
