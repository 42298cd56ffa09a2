"""When a search has come to rest: curves whose end is known, and steps as real searches make them."""

import numpy as np
import pytest

from tuner.search.convergence import (
    MAX_EXTRAPOLATION,
    MIN_GENERATIONS,
    TOLERANCE,
    StoppingRule,
    generations_to_convergence,
    has_converged,
    last_quarter_improvement,
)

POWERS = {
    "1/n": lambda n: 0.5 - 0.4 / n,
    "1/sqrt n": lambda n: 0.6 - 0.4 / np.sqrt(n),
    "1/n^2": lambda n: 0.4 - 0.4 / n**2,
}
EXPONENTIALS = {f"exp -n/{b}": lambda n, b=b: 0.5 - 0.5 * np.exp(-n / b) for b in (5, 10)}


def record(curve, generations):
    return [float(curve(float(n))) for n in range(1, generations + 1)]


def rest_of(curve, after):
    """The first number of generations behind `after` that brings rest, found by trying."""
    return next(n for n in range(after + 1, 1000) if last_quarter_improvement(record(curve, n)) <= TOLERANCE)


@pytest.mark.parametrize("name", POWERS)
@pytest.mark.parametrize("generations", [8, 14, 30])
def test_the_end_of_a_power_law_is_found_to_the_generation(name, generations):
    curve = POWERS[name]
    assert generations_to_convergence(record(curve, generations)) == pytest.approx(rest_of(curve, generations), abs=1)


@pytest.mark.parametrize("name", EXPONENTIALS)
@pytest.mark.parametrize("generations", [14, 20])
def test_the_end_of_an_exponential_is_found_within_a_tenth(name, generations):
    curve = EXPONENTIALS[name]
    assert generations_to_convergence(record(curve, generations)) == pytest.approx(rest_of(curve, generations), rel=0.1)


def test_steps_of_a_real_search_move_the_end_by_less_than_half():
    # A front moves in leaps: 1/n with noise of half a percent of the box, as far as it grows. Four of five within a factor of 1.5.
    truth = rest_of(POWERS["1/n"], 14)
    draws = [np.random.default_rng(key).normal(0.0, 0.005, 14) for key in range(40)]
    noisy = [np.maximum.accumulate(record(POWERS["1/n"], 14) + draw) for draw in draws]
    found = [generations_to_convergence(volumes.tolist()) for volumes in noisy]
    near = [end is not None and truth / 1.5 <= end <= truth * 1.5 for end in found]
    assert np.mean(near) >= 0.8


def test_a_search_that_never_slows_down_or_never_began_has_no_end():
    assert generations_to_convergence([0.01 * n for n in range(1, 11)]) is None
    assert generations_to_convergence([0.0] * 20) is None
    assert generations_to_convergence([0.0] * 16 + [0.1, 0.2, 0.3, 0.4]) is None
    ends = generations_to_convergence([0.0] * 10 + record(POWERS["1/n"], 10))
    assert ends is not None and 20 < ends <= MAX_EXTRAPOLATION * 20


def test_a_search_ends_where_a_quarter_of_it_brought_next_to_nothing():
    flat = [*np.linspace(0.1, 0.5, 9), 0.5, 0.5, 0.5]
    assert len(flat) == MIN_GENERATIONS and has_converged(flat)
    assert not has_converged(flat[:-1])
    assert not has_converged([*flat[:-1], 0.52])
    assert not has_converged([0.0] * 30)
    # What a long plateau was worth is forgotten as soon as the front moves again.
    assert has_converged([*flat, *[0.5] * 8]) and not has_converged([*flat, *[0.5] * 8, 0.6])


def test_a_rule_does_not_end_a_search_before_its_least_number():
    resting = [*np.linspace(0.1, 0.5, 9), *[0.5] * 9]
    assert [StoppingRule(30, True, least).is_met(resting) for least in (12, 18, 19)] == [True, True, False]
    assert StoppingRule(18, False).is_met(resting) and not StoppingRule(19, False).is_met(resting)


# Hypervolumes of three searches of the quickstart by `gaussian_process` (8 candidates, 4 flights each, seeds 2025, 2028, 2029) and
# the generation after which the last quarter of each had brought 2 % or less.
RECORDED = {
    26: "0 0 0 .076 .192 .271 .33 .392 .418 .442 .454 .459 .463 .465 .468 .471 .474 .477 .481 .485 .488 .49 .491 .493 .494 .494",
    16: "0 .116 .118 .239 .353 .402 .418 .438 .455 .465 .469 .472 .475 .477 .48 .481",
    23: ".024 .07 .114 .117 .208 .321 .374 .413 .431 .45 .458 .465 .47 .474 .479 .483 .487 .49 .491 .493 .494 .495 .496",
}


@pytest.mark.parametrize("end", RECORDED)
def test_recorded_searches_end_where_they_did_and_are_foretold_within_a_factor_of_two(end):
    volumes = [float(part) for part in RECORDED[end].split()]
    ended = [n for n in range(1, end + 1) if has_converged(volumes[:n])]
    assert ended == [end]
    for seen in range(10, end):
        foretold = generations_to_convergence(volumes[:seen])
        assert foretold is not None and end / 2 <= foretold <= 2 * end
