"""Risk measures against their definitions as optimisation and counting, and the axioms they promise."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from objectives.risk import RISKS, Risk, minimum_samples
from plant.errors import InputError, UnknownNameError

LEVELS = (0.05, 0.3, 0.55, 0.9, 0.99)
ALL = [Risk(name, level) for name in RISKS for level in (LEVELS if RISKS[name].has_level else (None,))]
COHERENT = [risk for risk in ALL if risk.name != "quantile"]


def samples() -> Iterator[NDArray[np.float64]]:
    """Yield samples of several sizes and shapes, with ties, none of them centred at 0."""
    rng = np.random.default_rng(3)
    for n in (1, 2, 3, 10, 17, 100):
        yield rng.normal(5.0, 2.0, n)
        yield rng.exponential(1.0, n) - 3.0
        yield np.round(rng.normal(-1.0, 1.0, n))


@pytest.mark.parametrize("level", LEVELS)
def test_cvar_is_the_minimum_over_v(level: float) -> None:
    for x in samples():
        # v + mean (x - v)^+ / (1 - a) is convex, piecewise linear in v, with kinks at the values: a minimum is at one.
        candidates = [v + np.mean(np.maximum(x - v, 0.0), axis=0) / (1.0 - level) for v in x]
        assert Risk("cvar", level).apply(x) == pytest.approx(min(candidates), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("level", LEVELS)
def test_cvar_is_the_optimum_of_its_dual_programme(level: float) -> None:
    for x in samples():
        # max sum w_i x_i over weights with sum 1, 0 <= w_i <= 1/((1 - a) n).
        n = len(x)
        found = linprog(-x, A_eq=np.ones((1, n)), b_eq=[1.0], bounds=[(0.0, 1.0 / ((1.0 - level) * n))] * n)
        assert found.success
        assert Risk("cvar", level).apply(x) == pytest.approx(-found.fun, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("level", LEVELS)
def test_quantile_is_the_smallest_value_that_enough_scenarios_stay_within(level: float) -> None:
    for x in samples():
        enough = [v for v in x if np.count_nonzero(x <= v, axis=0) >= level * len(x) - 1e-9]
        assert Risk("quantile", level).apply(x) == min(enough)


def test_quantile_does_not_stumble_over_rounding() -> None:
    assert 0.55 * 100 > 55
    assert Risk("quantile", 0.55).apply(np.arange(1.0, 101.0)) == 55.0


def test_known_values() -> None:
    x = np.array([4.0, 1.0, 3.0, 2.0, 10.0])
    assert Risk("mean").apply(x) == 4.0
    assert Risk("worst").apply(x) == 10.0
    assert Risk("quantile", 0.5).apply(x) == 3.0
    assert Risk("cvar", 0.6).apply(x) == pytest.approx(7.0)
    # The worst 30 % of five are one and a half values: (10 + 4/2)/1.5.
    assert Risk("cvar", 0.7).apply(x) == pytest.approx(8.0)


@pytest.mark.parametrize("risk", ALL, ids=str)
def test_translation_homogeneity_monotonicity_and_range(risk: Risk) -> None:
    rng = np.random.default_rng(4)
    for x in samples():
        value = risk.apply(x)
        assert risk.apply(x + 7.5) == pytest.approx(value + 7.5, rel=1e-12)
        assert risk.apply(3.5 * x) == pytest.approx(3.5 * value, rel=1e-12)
        assert risk.apply(x + rng.exponential(1.0, len(x))) >= value - 1e-12
        assert np.min(x, axis=0) - 1e-12 <= value <= np.max(x, axis=0) + 1e-12
        assert risk.apply(np.full(len(x), 2.5)) == pytest.approx(2.5, rel=1e-12)


@pytest.mark.parametrize("risk", COHERENT, ids=str)
def test_coherent_measures_are_subadditive_and_at_least_the_mean(risk: Risk) -> None:
    rng = np.random.default_rng(5)
    for x in samples():
        y = rng.normal(1.0, 3.0, len(x))
        assert risk.apply(x + y) <= risk.apply(x) + risk.apply(y) + 1e-12
        assert risk.apply(x) >= np.mean(x, axis=0) - 1e-12


@pytest.mark.parametrize("risk", ALL, ids=str)
def test_order_of_scenarios_does_not_matter_and_values_stay_untouched(risk: Risk) -> None:
    x = np.random.default_rng(6).normal(0.0, 1.0, 40)
    before = x.copy()
    assert risk.apply(x[::-1]) == risk.apply(x)
    np.testing.assert_array_equal(x, before)


@pytest.mark.parametrize("risk", ALL, ids=str)
@pytest.mark.parametrize("axis", [0, 1, 2, -1, -2])
def test_any_axis_holds_the_scenarios(risk: Risk, axis: int) -> None:
    values = np.random.default_rng(7).normal(2.0, 1.0, (4, 5, 6))
    found = risk.apply(values, axis=axis)
    moved = np.moveaxis(values, axis, 0)
    for index in np.ndindex(found.shape):
        assert found[index] == pytest.approx(float(risk.apply(moved[(slice(None), *index)])), rel=1e-14)


@pytest.mark.parametrize("name", RISKS)
def test_is_documented(name: str) -> None:
    assert len(RISKS[name].definition) > 10


def test_minimum_samples_put_eight_scenarios_in_the_tail() -> None:
    assert minimum_samples(Risk("cvar", 0.9)) == 80
    assert minimum_samples(Risk("quantile", 0.95)) == 160
    assert minimum_samples(Risk("quantile", 0.05)) == 160
    assert minimum_samples(Risk("mean")) == 8
    # Wilks: n = 59 is the least with 1 - 0.95^n >= 0.95.
    assert 1.0 - 0.95 ** minimum_samples(Risk("worst")) >= 0.95 > 1.0 - 0.95 ** (minimum_samples(Risk("worst")) - 1)


def test_unknown_risk_names_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'cvar'"):
        Risk("cvr", 0.9)


@pytest.mark.parametrize(
    ("name", "level", "says"),
    [
        ("cvar", None, "needs a level"),
        ("cvar", 1.0, "between 0 and 1"),
        ("quantile", 0.0, "between 0 and 1"),
        ("quantile", float("nan"), "between 0 and 1"),
        ("mean", 0.9, "leave it out"),
        ("worst", 0.0, "leave it out"),
    ],
)
def test_wrong_level_is_refused(name: str, level: float | None, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Risk(name, level)
