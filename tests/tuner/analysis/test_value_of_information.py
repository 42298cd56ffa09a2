"""The worth of knowing a number, against the unit normal loss and against numbers that nobody needs to know."""

import numpy as np
import pytest
from scipy.stats import norm

from tuner.analysis.value_of_information import correlation_ratio, evppi, regression_basis, values_of_information

FLIGHTS = 1000


def linear(slope, offset, noise=0.5, seed=1):
    """Two points over three numbers of unit size: the second is better where the first number is small; common air besides."""
    draw = np.random.default_rng(seed)
    parameters, air = draw.standard_normal((FLIGHTS, 3)), draw.standard_normal(FLIGHTS)
    apart = offset + slope * parameters[:, 0] + noise * draw.standard_normal(FLIGHTS)
    first = 5.0 + 0.8 * parameters[:, 1] + air
    return np.array([first, first + apart]), parameters


@pytest.mark.parametrize(("slope", "offset"), [(1.0, 0.0), (1.0, 0.7), (0.5, 0.2)])
def test_the_worth_of_a_number_is_the_unit_normal_loss(slope, offset):
    """With a difference of mean m and slope s of one normal number: s phi(m / s) - m Phi(-m / s).

    Its standard deviation over flights is below that of the smaller of zero and the difference, 0.6, over their root.
    """
    samples, parameters = linear(slope, offset)
    everything, each = values_of_information(samples, parameters, 0, np.random.default_rng(2))
    expected = slope * norm.pdf(offset / slope) - offset * norm.cdf(-offset / slope)
    for found in (everything, each[0]):
        assert found.is_significant and found.value == pytest.approx(expected, abs=4.0 * 0.6 * slope / np.sqrt(FLIGHTS))


def test_numbers_that_change_no_choice_are_worth_nothing_whatever_they_explain():
    """The second number moves both points alike, the third none; the shares are those of the variances."""
    samples, parameters = linear(1.0, 0.0)
    _, (_, second, third) = values_of_information(samples, parameters, 0, np.random.default_rng(2))
    assert second.value < 0.03 and third.value < 0.03
    assert second.share == pytest.approx(0.64 / 1.64, abs=0.08) and third.share < 0.02


def test_chance_is_told_from_worth_as_often_as_it_says():
    """Points that differ by noise alone: of 30 sets, 5 % pass for worth something; three standard deviations of that are 17 %."""
    draw = np.random.default_rng(3)
    told = []
    for _ in range(30):
        samples, parameters = draw.standard_normal((8, 64)), draw.standard_normal((64, 1))
        told.append(values_of_information(samples, parameters, 0, draw)[0].is_significant)
    assert np.mean(told) < 0.17


def test_a_single_point_leaves_nothing_to_choose():
    samples, parameters = linear(1.0, 0.0)
    assert evppi(samples[:1], regression_basis(parameters, True)) == pytest.approx(0.0, abs=1e-12)
    assert correlation_ratio(np.ones(10), regression_basis(parameters[:10, :1], False)) == 0.0


def test_what_chance_gives_is_taken_away_from_the_worth():
    """Chance: numbers drawn anew, of which nothing depends, in place of pairings; it is a third of what is found here."""
    draw = np.random.default_rng(5)
    parameters = draw.standard_normal((200, 1))
    samples = np.linspace(-0.4, 0.4, 12)[:, None] * parameters[:, 0] + draw.standard_normal((12, 200))
    found = values_of_information(samples, parameters, 0, draw)[1][0]
    chance = [evppi(samples, regression_basis(draw.standard_normal((200, 1)), True)) for _ in range(400)]
    raw = evppi(samples, regression_basis(parameters, True))
    assert found.is_significant and np.mean(chance) > 0.15 * raw
    assert found.value == pytest.approx(raw - np.mean(chance), abs=0.25 * float(np.mean(chance)))


def test_a_share_counts_its_terms():
    """Noise alone, 40 terms of 100 flights: of an estimate without a bias, half lies below 0 and is shown as 0; its deviation is 0.115."""
    draw, shares = np.random.default_rng(6), []
    for _ in range(60):
        shares.append(
            correlation_ratio(draw.standard_normal(100), regression_basis(draw.standard_normal((100, 39)), False))
        )
    assert np.mean(shares) == pytest.approx(0.115 / np.sqrt(2.0 * np.pi), abs=0.03)
