"""Filters against scipy.signal: designs, frequency responses and samples; passing through where there is nothing to filter."""

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy import signal as scipy_signal

from plant.laws import filters
from plant.laws.filters import Section, Stages

# scipy tells pyright less than it knows.
signal: Any = scipy_signal
RATES = (400.0, 1000.0, 4000.0, 8000.0)


def coefficients(section: Section) -> tuple[list[float], list[float]]:
    return [section.b0, section.b1, section.b2], [1.0, section.a1, section.a2]


def sections_output(section: Section, x: Any) -> Any:
    kept, y = filters.settled_section(float(x[0]), section), []
    for sample in x.tolist():
        out, kept = filters.step_section(kept, sample, section)
        y.append(out)
    return np.array(y)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("cutoff", [5.0, 30.0, 98.0, 195.0])
def test_the_low_pass_is_butterworths(rate: float, cutoff: float) -> None:
    if cutoff >= 0.5 * rate:
        pytest.skip("above Nyquist")
    b, a = signal.butter(2, cutoff, fs=rate)
    for mine, its in zip(coefficients(filters.low_pass(cutoff, 1.0 / rate)), (b, a), strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize(("centre", "q"), [(60.0, 3.0), (120.0, 5.0), (180.0, 1.2)])
def test_the_notch_by_quality_has_its_zero_and_its_gain(rate: float, centre: float, q: float) -> None:
    b, a = coefficients(filters.notch_by_q(centre, q, 1.0 / rate))
    _, response = signal.freqz(b, a, [0.0, centre, 0.499999 * rate], fs=rate)
    np.testing.assert_allclose(np.abs(response), [1.0, 0.0, 1.0], atol=1e-6)
    # The analogue notch (s2 + w2)/(s2 + s w/q + w2), transformed by scipy with its centre kept.
    turn = np.tan(pi * centre / rate)
    expected = signal.bilinear([1.0, 0.0, turn**2], [1.0, turn / q, turn**2], fs=0.5)
    for mine, its in zip((b, a), expected, strict=True):
        np.testing.assert_allclose(mine, np.asarray(its) / expected[1][0], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize(("centre", "width"), [(60.0, 20.0), (150.0, 40.0)])
def test_the_notch_by_width_is_three_decibels_down_that_far_apart(rate: float, centre: float, width: float) -> None:
    b, a = signal.iirnotch(centre, centre / width, fs=rate)
    for mine, its in zip(coefficients(filters.notch(centre, width, 1.0 / rate)), (b, a), strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_stages_in_series_are_three_decibels_down_at_the_cutoff(order: int) -> None:
    """With a sampling rate far above: backward Euler then is the continuous filter."""
    h, cutoff = 1e-7, 100.0
    share = filters.stages_share(cutoff, float(order), h)
    _, one = signal.freqz([share], [1.0, share - 1.0], [cutoff], fs=1.0 / h)
    assert abs(one[0]) ** order == pytest.approx(1.0 / sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_samples_of_stages_are_scipys(order: int) -> None:
    h, x = 1.0 / 4000.0, np.random.default_rng(1).standard_normal(300)
    share = filters.stages_share(90.0, float(order), h)
    kept, y = Stages(0.0, 0.0, 0.0), []
    for sample in x.tolist():
        out, kept = filters.step_stages(kept, sample, share, float(order))
        y.append(out)
    expected = x
    for _ in range(order):
        expected = signal.lfilter([share], [1.0, share - 1.0], expected)
    np.testing.assert_allclose(y, expected, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("section", [filters.low_pass(80.0, 1e-3), filters.notch(120.0, 30.0, 1e-3)])
def test_samples_of_sections_are_scipys_from_rest_at_the_first(section: Section) -> None:
    x = 3.0 + np.random.default_rng(2).standard_normal(300)
    b, a = coefficients(section)
    expected, _ = signal.lfilter(b, a, x, zi=signal.lfilter_zi(b, a) * x[0])
    np.testing.assert_allclose(sections_output(section, x), expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("h", [1e-3, 1.0 / 8000.0])
def test_without_a_cutoff_or_beyond_half_the_rate_the_signal_passes(h: float) -> None:
    through = Section(1.0, 0.0, 0.0, 0.0, 0.0)
    assert filters.low_pass(0.0, h) == filters.low_pass(0.5 / h, h) == filters.low_pass(3.0 / h, h) == through
    assert filters.notch(0.0, 20.0, h) == filters.notch(80.0, 0.0, h) == filters.notch(0.6 / h, 20.0, h) == through
    assert filters.notch_by_q(0.0, 3.0, h) == filters.notch_by_q(80.0, 0.0, h) == through
    assert filters.stage_share(0.0, h) == 1.0
