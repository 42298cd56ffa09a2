"""The super-twisting certificate against its closed form, and its function at states under the worst of disturbances."""

from math import sqrt

import numpy as np
import pytest

from plant.seeds import generator
from tuner.extensions.certificates.supertwisting import largest_rate

GAINS = [(1.5, 1.1), (2.0, 2.0), (0.3, 1.0), (2.4, 1.0), (150.0, 1.1e4), (0.02, 1e-3)]


def closed_form(k1: float, k2: float) -> float:
    """L* by Kalman-Yakubovich-Popov: k2 where k1^2 >= 4 k2, else (k1/4) sqrt(8 k2 - k1^2)."""
    return k2 if k1**2 >= 4.0 * k2 else 0.25 * k1 * sqrt(8.0 * k2 - k1**2)


def certified(k1: float, k2: float) -> float:
    certificate = largest_rate(k1, k2)
    assert certificate.verified and certificate.value is not None
    assert certificate.unit == "{y}/s3"
    return certificate.value


@pytest.mark.parametrize(("k1", "k2"), [*GAINS, (3.0, 1.0), (40.0, 5.0)])
def test_largest_rate_is_the_closed_form(k1: float, k2: float) -> None:
    """From below, and within the share by which the solver's optimum is backed off."""
    assert (1.0 - 2e-4) * closed_form(k1, k2) < certified(k1, k2) < closed_form(k1, k2)


@pytest.mark.parametrize(("k1", "k2", "rate"), [(1.5, 1.1, 0.9597), (2.0, 2.0, 1.7321)])
def test_numbers_of_record(k1: float, k2: float, rate: float) -> None:
    """T12."""
    assert certified(k1, k2) == pytest.approx(rate, abs=1e-4)


def test_the_popular_gains_are_just_outside() -> None:
    """1.5 sqrt(L), 1.1 L has no quadratic certificate; the threshold of k1 is sqrt(4.4 - sqrt(4.4^2 - 16)) = 1.60218."""
    assert certified(1.5, 1.1) < certified(1.602, 1.1) < 1.0
    assert certified(1.6023, 1.1) > 1.0
    assert sqrt(4.4 - sqrt(4.4**2 - 16.0)) == pytest.approx(1.60218, abs=1e-5)


def slope(p: np.ndarray, k1: float, k2: float, zeta: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """|zeta_1| V' at states (n, 2)."""
    rates = np.stack([0.5 * (zeta[:, 1] - k1 * zeta[:, 0]), -k2 * zeta[:, 0] + rho], axis=1)
    return 2.0 * np.einsum("ni,ij,nj->n", zeta, p, rates)


@pytest.mark.parametrize(("k1", "k2"), GAINS)
def test_the_lyapunov_function_falls_everywhere(k1: float, k2: float) -> None:
    """In the law's own units, at states all around, with the disturbance pushing either way at its full rate."""
    certificate = largest_rate(k1, k2)
    p, rate = certificate.data["P"], certificate.value
    assert rate is not None
    angle = generator(1, "tests/angles", 0).uniform(0.0, 2.0 * np.pi, 4000)
    # Of the size that a state has where both parts count alike.
    zeta = np.stack([np.cos(angle), k1 * np.sin(angle)], axis=1)
    assert np.linalg.eigvalsh(p / np.sqrt(np.outer(np.diag(p), np.diag(p)))).min(axis=0) > 0.0
    for sign in (-1.0, 0.0, 1.0):
        assert slope(p, k1, k2, zeta, sign * rate * np.abs(zeta[:, 0])).max(axis=0) < 0.0


@pytest.mark.parametrize(("k1", "k2", "mu"), [(1.7, 1.1, 0.4), (2.0, 2.0, 3.0)])
def test_it_covers_the_generalised_law(k1: float, k2: float, mu: float) -> None:
    """zeta = (phi1, v), v' = -2 k2 phi1 phi1' + d'; V' with the derivative of phi1 written out."""
    certificate = largest_rate(k1, k2)
    p, rate = certificate.data["P"], certificate.value
    assert rate is not None
    draw = generator(2, "tests/states", 0)
    s, v = draw.normal(size=3000) * 10.0 ** draw.uniform(-3, 2, 3000), 3.0 * draw.normal(size=3000)
    phi = np.sqrt(np.abs(s)) * np.sign(s) + mu * s
    dphi = 0.5 / np.sqrt(np.abs(s)) + mu
    zeta = np.stack([phi, v], axis=1)
    for d in (-rate, rate):
        rates = np.stack([dphi * (v - k1 * phi), -2.0 * k2 * phi * dphi + d], axis=1)
        assert np.einsum("ni,ij,nj->n", zeta, p, rates).max(axis=0) < 0.0


@pytest.mark.parametrize("factor", [1e-3, 7.0, 4e3])
def test_it_scales_with_the_law(factor: float) -> None:
    assert certified(sqrt(factor) * 1.7, factor * 1.1) == pytest.approx(factor * certified(1.7, 1.1), rel=2e-4)


@pytest.mark.parametrize(("k1", "k2"), [(0.0, 1.0), (1.0, 0.0), (-1.0, 1.0)])
def test_gains_that_are_not_positive_have_no_certificate(k1: float, k2: float) -> None:
    none = largest_rate(k1, k2)
    assert none.value is None and not none.verified
    assert "positive" in none.why
