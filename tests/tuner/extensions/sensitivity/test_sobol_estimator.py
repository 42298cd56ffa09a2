"""Sobol indices: closed forms through the whole path, coverage of the intervals, invariances, and what failures may not do."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import rankdata

from plant.errors import InputError
from plant.seeds import generator
from plant.ties import mean_ranks
from tuner.extensions.sensitivity import analysis as module
from tuner.extensions.sensitivity.analysis import Sampled, analyze, estimate
from tuner.extensions.sensitivity.design import SobolDesign, checked_base, sobol_design
from tuner.extensions.sensitivity.indices import RANK, VALUE, clip_to_completed, sobol_spans

G = np.array([0.0, 0.5, 3.0, 9.0])


def ishigami(points):
    x = pi * (2.0 * points - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def g_function(points):
    return np.prod((np.abs(4.0 * points - 2.0) + G) / (1.0 + G), axis=1)


def sampled(*functions, failures=None):
    def evaluate(points):
        values = np.stack([function(points) for function in functions], axis=1)
        lost = np.zeros(len(points)) if failures is None else failures(points)
        scores = tuple(column[:, None] + np.zeros(3) for column in values.T)
        return Sampled(values, lost, np.ones(len(points), dtype=bool), scores)

    return evaluate


def test_places_are_the_ranks_of_scipy():
    values = np.random.default_rng(1).integers(0, 9, 40).astype(float)
    assert np.array_equal(mean_ranks(values), rankdata(values))


def near(spans, row, expected):
    """Within four of its own standard errors, and the error itself below 0.05."""
    error = np.abs(spans.value[row] - expected)
    assert np.all(error <= 4.0 * (spans.high[row] - spans.low[row]) / 3.92 + 1e-12)
    assert np.all(error < 0.05)


def test_ishigami_function_has_its_closed_form():
    # T. Ishigami, T. Homma, ISUMA 1990, with a = 7, b = 0.1.
    a, b = 7.0, 0.1
    v1, v2, v13 = 0.5 * (1.0 + b * pi**4 / 5.0) ** 2, a**2 / 8.0, 8.0 * b**2 * pi**8 / 225.0
    found = analyze(2048, 3, sampled(ishigami), 1).indices[VALUE]
    total = v1 + v2 + v13
    near(found.first, 0, np.array([v1, v2, 0.0]) / total)
    near(found.total, 0, np.array([v1 + v13, v2, v13]) / total)


def test_g_function_has_its_closed_form_beside_another_output():
    v = 1.0 / (3.0 * (1.0 + G) ** 2)
    whole = np.prod(1.0 + v, axis=0) - 1.0
    found = analyze(2048, 4, sampled(lambda points: 3.0 * points[:, 3] - 5.0, g_function), 2).indices[VALUE]
    near(found.first, 1, v / whole)
    near(found.total, 1, v * np.prod(1.0 + v, axis=0) / (1.0 + v) / whole)
    near(found.first, 0, np.array([0.0, 0.0, 0.0, 1.0]))
    near(found.total, 0, np.array([0.0, 0.0, 0.0, 1.0]))


def test_rank_indices_are_those_of_the_distribution_function():
    # P(x1 x2 <= z) = z - z ln z; the mean of that rank given x1 by quadrature, its variance over x1 by another.
    def rank(z):
        return z - z * np.log(z)

    given = lambda x1: quad(lambda x2: rank(x1 * x2), 0.0, 1.0)[0]  # noqa: E731
    first = (quad(lambda x1: given(x1) ** 2, 0.0, 1.0)[0] - 0.25) * 12.0
    found = analyze(2048, 2, sampled(lambda points: points[:, 0] * points[:, 1]), 3).indices[RANK]
    near(found.first, 0, np.array([first, first]))
    near(found.total, 0, np.array([1.0 - first, 1.0 - first]))


@pytest.mark.slow
@pytest.mark.parametrize("base", [128])
def test_intervals_cover_the_truth_where_the_samples_are_independent(base):
    weights, runs, hits = np.array([1.0, 2.0, 3.0]), 300, np.zeros((2, 3))
    truth = weights**2 / np.sum(weights**2)
    for run in range(runs):
        draw = generator(7, "test/coverage", run)
        a, b = draw.uniform(size=(2, base, 3))
        pages = [np.where(np.arange(3) == i, b, a) for i in range(3)]
        design = SobolDesign(np.concatenate([a, b, *pages]), base)
        found = sobol_spans(design, (design.points @ weights)[:, None], draw, replicates=400)
        for order, spans in enumerate(found):
            hits[order] += (spans.low[0] <= truth) & (truth <= spans.high[0])
    # Binomial, three standard deviations of 1.3 %, and a percentile bootstrap's deficit of up to 2 % at 128 samples.
    assert np.all(np.abs(hits / runs - 0.95) < 0.06), hits / runs


@pytest.mark.slow
def test_intervals_of_a_sobol_sequence_are_not_too_narrow():
    truth, hits, runs = np.array([0.1, 0.9]), np.zeros((2, 2)), 100
    for run in range(runs):
        found = analyze(64, 2, sampled(lambda points: points[:, 0] + 3.0 * points[:, 1]), run).indices[VALUE]
        for order, spans in enumerate(found):
            hits[order] += (spans.low[0] <= truth) & (truth <= spans.high[0])
    assert np.all(hits / runs > 0.9), hits / runs


def test_a_failure_s_price_changes_no_rank_and_no_held_value():
    def lost(points):
        return np.where(points[:, 0] > 0.9, 0.25, 0.0)

    def priced(price):
        return sampled(
            lambda points: np.where(lost(points) > 0.0, price + points[:, 1], ishigami(points)), failures=lost
        )

    cheap, dear = (analyze(256, 3, priced(price), 4) for price in (100.0, 1e9))
    for scale in (RANK, VALUE):
        for mine, other in zip(cheap.indices[scale], dear.indices[scale], strict=True):
            assert all(np.array_equal(a, b) for a, b in zip(mine, other, strict=True))
    assert cheap.failed_share == pytest.approx(0.1, abs=0.02)
    # Only the first variable decides which flights are lost: row 1 is the share of failures.
    near(cheap.indices[VALUE].first, 1, np.array([1.0, 0.0, 0.0]))
    near(cheap.indices[RANK].total, 1, np.array([1.0, 0.0, 0.0]))


def test_values_are_held_to_the_worst_that_completed():
    values, failures = np.array([[1.0, 5.0], [9.0, 2.0], [3.0, 3.0]]), np.array([0.0, 0.5, 0.0])
    assert clip_to_completed(values, failures).tolist() == [[1.0, 5.0], [3.0, 2.0], [3.0, 3.0]]
    assert clip_to_completed(values, np.ones(3)) is values


def test_a_monotone_scale_changes_no_rank():
    plain, bent = (analyze(128, 3, sampled(f), 5) for f in (ishigami, lambda points: np.exp(ishigami(points))))
    for mine, other in zip(plain.indices[RANK], bent.indices[RANK], strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(mine, other, strict=True))


def test_relabelled_variables_have_their_own_indices():
    design = sobol_design(128, 3, generator(1, "test/points", 0))
    order = np.array([2, 0, 1])
    blocks = design.points.reshape(5, 128, 3)
    turned = SobolDesign(np.concatenate([blocks[:2], blocks[2:][order]]).reshape(-1, 3)[:, order], 128)

    def judge(design, values):
        ones = np.ones(len(values), dtype=bool)
        return estimate(design, values[:, None], np.zeros(len(values)), ones, [np.zeros((256, 2))], 1)

    plain = judge(design, ishigami(design.points))
    moved = judge(turned, ishigami(turned.points[:, np.argsort(order)]))
    for scale in (RANK, VALUE):
        for mine, other in zip(plain.indices[scale], moved.indices[scale], strict=True):
            for a, b in zip(mine, other, strict=True):
                np.testing.assert_allclose(a[:, order], b, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize("dimensions", [1, 2])
def test_a_constant_has_zeros_and_no_warning(dimensions):
    # 0.1 is no binary fraction: its mean over samples differs from it in the last bit.
    found = analyze(8, dimensions, sampled(lambda points: np.full(len(points), 0.1)), 6)
    for scale in (RANK, VALUE):
        for spans in found.indices[scale]:
            assert all(part.shape == (2, dimensions) and not part.any() for part in spans)
    assert found.variance[0] is not None and not any(found.variance[0].of_components)


def test_one_variable_explains_everything():
    found = analyze(256, 1, sampled(lambda points: points[:, 0] ** 3), 8).indices[VALUE]
    near(found.total, 0, np.array([1.0]))
    near(found.first, 0, np.array([1.0]))


def test_the_same_bits_for_one_seed_and_any_batch(monkeypatch):
    runs = [analyze(32, 3, sampled(ishigami), seed) for seed in (1, 1, 2)]
    monkeypatch.setattr(module, "BATCH", 7)
    runs.insert(2, analyze(32, 3, sampled(ishigami), 1))
    for one, other in pairwise(runs[:3]):
        assert np.array_equal(one.values, other.values)
        assert np.array_equal(one.indices[RANK].first.high, other.indices[RANK].first.high)
        assert one.variance == other.variance and one.candidates == other.candidates == 64
    assert not np.array_equal(runs[0].values, runs[3].values)


def test_the_design_changes_one_variable_at_a_time():
    design = sobol_design(16, 3, generator(1, "test/points", 0))
    a, b, *pages = design.points.reshape(5, 16, 3)
    for i, page in enumerate(pages):
        assert np.array_equal(page[:, i], b[:, i])
        others = [k for k in range(3) if k != i]
        assert np.array_equal(page[:, others], a[:, others])
    # Every column of A and of B has one point in each sixteenth.
    for column in np.concatenate([a, b], axis=1).T:
        assert sorted((16.0 * column).astype(int)) == list(range(16))


@pytest.mark.parametrize(("given", "near_by"), [(100, "128"), (4, "8"), (0, "8"), (-8, "8"), (2**20, "65536")])
def test_other_counts_are_refused(given, near_by):
    with pytest.raises(InputError, match=f"--samples: given {given}; .* for instance {near_by}$"):
        checked_base(given)
