"""Noise of forming filters against the spectra that define it: variance, correlation and power, within what chance allows."""

from functools import cache

import numpy as np
import pytest
from scipy.signal import welch
from scipy.stats import chi2

from plant.errors import InputError, UnknownNameError
from plant.model.signals import SIGNALS, Coloured, Ramp, Sine, Step, VerticalGust, signal_from

STEP, SAMPLES, FLIGHTS = 0.05, 400, 1000
# Gusts of 2 m/s with a scale of 50 m at 25 m/s: 2 s of correlation.
GUST = VerticalGust(2.0, 50.0, 25.0)
COLOURED = Coloured(0.3, 0.4)


@cache
def drawn(signal, flights=FLIGHTS, step=STEP, samples=SAMPLES):
    times = step * np.arange(samples)
    return np.array([signal.values(times, np.random.default_rng([5, i]))[0] for i in range(flights)])


def share(samples):
    """Where a sample variance of independent normals of variance 1 lies with a probability of 1 - 1e-6."""
    return chi2.ppf([5e-7, 1.0 - 5e-7], samples) / samples


@pytest.mark.parametrize("signal", [GUST, COLOURED], ids=lambda s: s.kind)
def test_variance_at_every_instant(signal):
    """Flights are independent, so that the count of flights says how far chance reaches; the first instant is no other."""
    low, high = signal.rms**2 * share(FLIGHTS)
    variance = np.mean(drawn(signal) ** 2, axis=0)
    assert low < variance[0] < high
    assert low < variance[-1] < high


def autocorrelation(signal, lag):
    """Closed forms: exp(-|t|/T) for the first order; (1 - t/(2 tau)) exp(-t/tau) of a transverse gust."""
    if signal is COLOURED:
        return np.exp(-lag / 0.4)
    return (1.0 - lag / 4.0) * np.exp(-lag / 2.0)


@pytest.mark.parametrize("signal", [GUST, COLOURED], ids=lambda s: s.kind)
def test_autocorrelation(signal):
    values = drawn(signal)
    for lag in (1, 8, 40, 120):
        found = np.mean(values[:, 0] * values[:, lag], axis=0) / signal.rms**2
        wanted = autocorrelation(signal, lag * STEP)
        # The mean of products of two normals varies by (1 + r^2)/n; 5 of these are met once in a million.
        assert abs(found - wanted) < 5.0 * np.sqrt((1.0 + wanted**2) / FLIGHTS)


def power(signal, w):
    """Two-sided power per rad/s over all w: MIL-F-8785C for the gust, with sigma^2 as its integral over 2 pi."""
    if signal is COLOURED:
        return signal.rms**2 * 2.0 * 0.4 / (1.0 + (0.4 * w) ** 2)
    return signal.rms**2 * 2.0 * (1.0 + 3.0 * (2.0 * w) ** 2) / (1.0 + (2.0 * w) ** 2) ** 2


@pytest.mark.parametrize("signal", [GUST, COLOURED], ids=lambda s: s.kind)
def test_spectrum(signal):
    """Power of 200 flights, each a Hann window of its own, against the sampled spectrum: the continuous one with its aliases."""
    values = drawn(signal, 200, STEP, 2048)
    f, found = welch(values, 1.0 / STEP, window="hann", nperseg=2048, detrend=False)  # pyright: ignore[reportArgumentType]
    found = np.mean(found, axis=0) / 2.0
    aliases = np.sum([power(signal, 2.0 * np.pi * (f + m / STEP)) for m in range(-400, 401)], axis=0)
    # Bins far below the width of the window and the last one, which stands alone, are left out.
    inner = slice(8, -2)
    low, high = chi2.ppf([1e-8, 1.0 - 1e-8], 2 * 200) / (2 * 200)
    ratio = found[inner] / aliases[inner]
    assert ratio.min() > low * 0.995 and ratio.max() < high * 1.005
    assert np.mean(ratio, axis=0) == pytest.approx(1.0, abs=0.01)


def test_a_gust_is_the_transfer_function_of_the_specification():
    """H_w = sigma sqrt(tau) (1 + sqrt(3) tau s)/(1 + tau s)^2 at a few frequencies."""
    a, b, c = GUST.process
    tau = 2.0
    for w in (0.01, 0.3, 2.0, 40.0):
        found = c[0] @ np.linalg.solve(1j * w * np.eye(len(a)) - a, b)
        assert found == pytest.approx(
            np.sqrt(tau) * (1 + np.sqrt(3) * tau * 1j * w) / (1 + tau * 1j * w) ** 2, rel=1e-12
        )


@pytest.mark.parametrize("step", [0.001, 0.5])
def test_noise_does_not_depend_on_the_step(step):
    """The variance is that of the filter whatever the period; a sampled filter of the wrong gain would tell."""
    low, high = share(FLIGHTS)
    assert low < np.mean(drawn(GUST, FLIGHTS, step, 200)[:, -1] ** 2, axis=0) / 4.0 < high


@pytest.mark.parametrize("signal", [Ramp(2.0, 0.5, 1.5), Sine(0.7, 0.4)])
def test_rates_are_derivatives(signal):
    """Differences over a fine grid, away from the corners of the ramp."""
    t = np.linspace(0.0, 2.0, 20001)
    value, rate, acceleration = signal.values(t, np.random.default_rng(0))
    smooth = np.abs(t[1:-1, None] - [0.5, 1.5]).min(axis=1) > 1e-3
    np.testing.assert_allclose(np.gradient(value, t)[1:-1][smooth], rate[1:-1][smooth], atol=1e-6)
    np.testing.assert_allclose(np.gradient(rate, t)[1:-1][smooth], acceleration[1:-1][smooth], atol=1e-5)


def test_a_step_begins_at_its_sample_and_goes_back():
    t = 0.0055 * np.arange(20)
    value = Step(2.0, 0.0275, 0.055).values(t, np.random.default_rng(0))[0]
    assert value.tolist() == [0.0] * 5 + [2.0] * 5 + [0.0] * 10


BAD = [
    ({"kind": "stepp"}, UnknownNameError, "step"),
    ({"kind": "step", "sise": 1.0}, UnknownNameError, "size"),
    ({"kind": "step", "size": True}, InputError, "a number"),
    ({"kind": "step", "size": float("nan")}, InputError, "finite"),
    ({"kind": "ramp", "time": 1.0, "until": 1.0}, InputError, "after the start"),
    ({"kind": "sine", "frequency": 0.0}, InputError, "positive"),
    ({"kind": "dryden", "length": -1.0}, InputError, "positive"),
    ({"kind": "coloured", "correlation_time": 0.0}, InputError, "positive"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "error", "said"), BAD)
def test_bad_signals_are_told_in_a_line(table, error, said):
    with pytest.raises(error, match=said) as caught:
        signal_from(table)
    assert "\n" not in str(caught.value)


def test_every_signal_is_read_from_its_table():
    assert {type(signal_from({"kind": kind})) for kind in SIGNALS} == set(SIGNALS.values())
