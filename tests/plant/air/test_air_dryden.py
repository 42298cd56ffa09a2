"""Dryden processes: spectra, autocovariances and coherence of what is sampled, against closed forms."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import coherence, welch

from plant.air.dryden import forming, transverse
from plant.air.linear_process import gauss_markov, sample
from plant.air.turbulence_field import TurbulenceField
from tests.plant.air.spectra import (
    longitudinal_autocovariance,
    phi_p,
    phi_q,
    phi_r,
    phi_u,
    phi_v,
    phi_w,
    transverse_autocovariance,
)

# tau: u 10, v 9, w 2 s; lags of the rates 0.087, 0.087, 0.065 s.
FIELD = TurbulenceField("8785C", 5.0, (50.0, 45.0, 10.0), (1.3, 1.1, 0.8), 0.342)
HALVED = FIELD._replace(spec="1797", length=(50.0, 22.5, 5.0))
OMEGA = np.geomspace(1e-3, 1e3, 200)
ALL_PHI = (phi_u, phi_v, phi_w, phi_p, phi_q, phi_r)


def whole(phi, field):
    """Integral over omega in (0, inf), in the variable ln(omega)."""
    return quad(lambda x: np.exp(x) * phi(np.exp(x), field), -25.0, 25.0, limit=400, epsabs=0.0, epsrel=1e-9)[0]


def covariance(sampled, lag):
    """C A^k P C' of the outputs, k = lag."""
    stationary = sampled.start @ sampled.start.T
    return sampled.output @ np.linalg.matrix_power(sampled.transition, lag) @ stationary @ sampled.output.T


@pytest.mark.parametrize("field", [FIELD, HALVED], ids=["8785C", "1797"])
def test_spectra_integrate_to_the_variances(field):
    assert [whole(phi, field) for phi in (phi_u, phi_v, phi_w)] == pytest.approx([1.69, 1.21, 0.64], rel=1e-7)
    assert whole(phi_p, field) == pytest.approx(field.roll_rate_sigma**2, rel=1e-7)


def test_the_specifications_agree_where_each_meets_its_own_lengths():
    for phi in ALL_PHI:
        np.testing.assert_allclose(phi(OMEGA, HALVED), phi(OMEGA, FIELD), rtol=1e-14)
    assert HALVED.tau == FIELD.tau
    assert HALVED.roll_rate_sigma == FIELD.roll_rate_sigma
    mixed = HALVED._replace(spec="8785C")  # the classic error: lengths of one with formulas of the other
    assert np.abs(phi_v(OMEGA, mixed) / phi_v(OMEGA, FIELD) - 1.0).max(axis=0) > 0.9


def test_levels_and_slopes():
    tau_u, tau_v, tau_w = FIELD.tau
    assert (tau_u, tau_v, tau_w) == (10.0, 9.0, 2.0)
    assert phi_u(0.0, FIELD) == pytest.approx(2.0 * 1.69 * 10.0 / pi)
    assert phi_v(0.0, FIELD) == pytest.approx(1.21 * 9.0 / pi)
    assert phi_u(1.0 / tau_u, FIELD) == pytest.approx(1.69 * 10.0 / pi)
    assert phi_w(1.0 / tau_w, FIELD) == pytest.approx(0.64 * 2.0 / pi)
    for phi in (phi_u, phi_v, phi_w):
        assert phi(2e5, FIELD) / phi(1e5, FIELD) == pytest.approx(0.25, rel=1e-6)


def test_roll_rate_of_a_known_case():
    """sigma_p = 0.954 sigma_w / (Lw^(1/3) b^(2/3)): 0.906 rad/s per m/s at Lw = 10 m, b = 0.342 m."""
    assert FIELD._replace(sigma=(0.0, 0.0, 1.0)).roll_rate_sigma == pytest.approx(0.906, abs=1e-3)


def test_process_spectra_are_the_printed_filters():
    """|C (i omega - A)^-1 b|^2 / pi is the one-sided spectrum of a filter on noise of unit intensity."""
    _, tau_v, tau_w = FIELD.tau
    tau_p, tau_q, tau_r = FIELD.rate_tau
    v, w = transverse(tau_v, tau_r, -1.0 / FIELD.airspeed), transverse(tau_w, tau_q, 1.0 / FIELD.airspeed)
    cases = [(v, 0, phi_v, 1.1), (v, 1, phi_r, 1.1), (w, 0, phi_w, 0.8), (w, 1, phi_q, 0.8)]
    cases += [(gauss_markov(tau_p), 0, phi_p, FIELD.roll_rate_sigma), (gauss_markov(FIELD.tau[0]), 0, phi_u, 1.3)]
    for process, output, phi, sigma in cases:
        resolvent = np.linalg.inv(1j * OMEGA[:, None, None] * np.eye(len(process.a)) - process.a)
        response = resolvent @ process.b @ process.c[output]
        np.testing.assert_allclose(np.abs(sigma * response) ** 2 / pi, phi(OMEGA, FIELD), rtol=1e-9)


def test_rates_are_signed_gradients():
    """Integrated, q V is +w and r V is -v, each behind a lag of the span: 10 ms here, against tau of 2 and 9 s."""
    dt = 1e-3
    processes = forming(FIELD._replace(span=0.01 * pi * FIELD.airspeed / 4.0), dt)
    for process, sign in ((processes.w, 1.0), (processes.v, -1.0)):
        velocity, rate = sample(process, np.random.default_rng(3).standard_normal((60000, 3))).T
        # The rectangle rule of the integral and the lag cost about dt / lag and lag / tau of the slope.
        slope = np.polyfit(velocity, np.cumsum(rate) * dt * FIELD.airspeed * sign, 1)[0]
        assert slope == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 1.0, 10.0])
def test_variance_and_autocovariance_are_exact_at_any_step(dt):
    u, v, w, p = forming(FIELD, dt)
    tau_u, tau_v, tau_w = FIELD.tau
    for k in (0, 1, 2, 7, 40):
        lag = k * dt
        assert covariance(u, k)[0, 0] == pytest.approx(longitudinal_autocovariance(lag, 1.0, tau_u), abs=1e-12)
        assert covariance(v, k)[0, 0] == pytest.approx(transverse_autocovariance(lag, 1.0, tau_v), abs=1e-12)
        assert covariance(w, k)[0, 0] == pytest.approx(transverse_autocovariance(lag, 1.0, tau_w), abs=1e-12)
        assert covariance(p, k)[0, 0] == pytest.approx(np.exp(-lag / FIELD.rate_tau[0]), abs=1e-12)
    assert 0.64 * covariance(w, 0)[1, 1] == pytest.approx(whole(phi_q, FIELD), rel=1e-7)
    assert 1.21 * covariance(v, 0)[1, 1] == pytest.approx(whole(phi_r, FIELD), rel=1e-7)


def test_autocovariances_are_the_transforms_of_the_spectra():
    """R(t) = int Phi(omega) cos(omega t) d omega, by Gauss-type quadrature for oscillating tails."""
    field = FIELD._replace(length=(5.0, 5.0, 5.0))  # tau = 1 s
    for lag in (0.3, 1.0, 3.0):
        for phi, closed, sigma in ((phi_u, longitudinal_autocovariance, 1.3), (phi_v, transverse_autocovariance, 1.1)):
            integral = quad(lambda x, phi=phi: phi(x, field), 0.0, np.inf, weight="cos", wvar=lag, epsabs=1e-9)[0]
            assert closed(lag, sigma, 1.0) == pytest.approx(integral, abs=1e-7)


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
def test_sampled_variance_and_autocovariance(dt):
    """At three steps; 2^19 samples, tau of 1 s."""
    field = FIELD._replace(length=(5.0, 5.0, 5.0), airspeed=5.0)
    generator, samples = np.random.default_rng(21), 2**19
    u, v, _, _ = forming(field, dt)
    series = {
        longitudinal_autocovariance: sample(u, generator.standard_normal((samples, 1)))[:, 0],
        transverse_autocovariance: sample(v, generator.standard_normal((samples, 3)))[:, 0],
    }
    for closed, x in series.items():
        # Bartlett: var of an autocovariance estimate is at most (2 / n) sum_k R(k)^2 over all k, both signs of k.
        lags = np.arange(-2000, 2001) * dt
        deviation = sqrt(2.0 / samples * np.sum(closed(lags, 1.0, 1.0) ** 2))
        for k in (0, 1, round(1.0 / dt), round(3.0 / dt)):
            estimate = np.mean(x[: samples - k] * x[k:])
            assert abs(estimate - closed(k * dt, 1.0, 1.0)) < 5.0 * deviation


def aliased(phi, field, frequency, rate):
    """The one-sided spectrum per Hz of samples taken at `rate`: all images folded, the far ones by their -2 slope."""
    images = np.arange(-300, 301)[:, None] * rate + frequency
    near = (2.0 * pi * phi(2.0 * pi * np.abs(images), field)).sum(axis=0)
    edge = (
        300.5 * rate
    )  # beyond, S(f) = S(edge) (edge / f)^2 integrates to S(edge) edge, at a spacing of `rate`, two sides
    return near + 2.0 * (2.0 * pi * phi(2.0 * pi * edge, field)) * edge / rate


@pytest.mark.slow
@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
def test_sampled_spectra(dt):
    """Welch at three steps against the folded closed form, in bands up to the Nyquist frequency; tau of 1 s."""
    field = TurbulenceField("8785C", 5.0, (5.0, 5.0, 5.0), (1.0, 1.0, 1.0), 0.342)
    generator, samples, segment = np.random.default_rng(8), 2**20, 8192  # a segment is 164 tau or more
    u, v, w, _ = forming(field, dt)
    series = [
        (phi_u, sample(u, generator.standard_normal((samples, 1)))[:, 0]),
        (phi_v, sample(v.leading(2, 1), generator.standard_normal((samples, 2)))[:, 0]),
        (phi_q, sample(w, generator.standard_normal((samples, 3)))[:, 1]),
    ]
    for phi, x in series:
        frequency, density = welch(x, 1.0 / dt, nperseg=segment)
        ratio = density[2:-1] / aliased(phi, field, frequency[2:-1], 1.0 / dt)
        edges = np.unique(np.geomspace(1, len(ratio), 12).astype(int))
        for low, high in zip(edges[3:-1], edges[4:], strict=True):
            # 128 segments, half overlapping, Hann: a bin varies by sqrt(0.53 / 128), neighbours correlate 1.94.
            deviation = sqrt(0.53 * 1.94 / (128 * (high - low)))
            # 1 % more for leakage where the spectrum bends within a bin.
            assert abs(ratio[low:high].mean(axis=0) - 1.0) < 5.0 * deviation + 0.01


def test_rates_share_the_noise_of_their_gusts_and_p_shares_none():
    dt, samples, segment = 0.004, 2**19, 4096
    generator = np.random.default_rng(2)
    u, v, w, p = forming(FIELD, dt)
    gust_u, roll = (sample(x, generator.standard_normal((samples, 1)))[:, 0] for x in (u, p))
    (gust_v, yaw), (gust_w, pitch) = (sample(x, generator.standard_normal((samples, 3))).T for x in (v, w))
    for gust, rate in ((gust_w, pitch), (gust_v, yaw)):
        frequency, shared = coherence(gust, rate, 1.0 / dt, nperseg=segment)
        # Folding mixes phases near Nyquist, leakage the first bins: between 0.5 and 25 Hz the loss is below 2 %.
        band = (frequency > 0.5) & (frequency < 25.0)
        assert shared[band].min(axis=0) > 0.98
    for other in (gust_u, gust_v, gust_w, pitch, yaw):
        _, shared = coherence(roll, other, 1.0 / dt, nperseg=segment)
        # Independent: the mean estimate over 128 half-overlapping segments is near 0.53 / 64 = 0.8 %, far below 3 %.
        assert shared[2:].mean(axis=0) < 0.03
