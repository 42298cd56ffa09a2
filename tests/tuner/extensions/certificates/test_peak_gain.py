"""The ultimate bound against exact peak gains, the closed form of a linear loop, and flights under bang-bang disturbances."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_lyapunov

from objectives.linear_axis.channel_model import AxisLoop, TiltLoop, closed_loop, sector
from plant.laws import hybrid, ladrc, pid
from plant.laws.hybrid import sliding_term
from tests.objectives.linear_axis.cases import HYBRID, LADRC, PID, Array
from tuner.extensions.certificates.certificate import Certificate
from tuner.extensions.certificates.peak_gain import disturbed, run

MILD = replace(HYBRID, gains=hybrid.Gains(10.0, 5.0, 4.0, 8.0, 0.1))


def impulse(axis: AxisLoop, duration: float = 12.0) -> tuple[Array, Array]:
    """Response of the linear loop to an impulse of the disturbance."""
    a, d, c = closed_loop(axis).channel("disturbance", "value")
    t = np.linspace(0.0, duration, round(2000 * duration) + 1)
    step, x = expm(t[1] * a), d[:, 0]
    values = []
    for _ in t:
        values.append((c @ x).item())
        x = step @ x
    return t, np.array(values)


def peak(axis: AxisLoop) -> float:
    """Exact peak gain: the L1 norm of the impulse response."""
    t, g = impulse(axis)
    return float(np.trapezoid(np.abs(g), t))


def bound(certificate: Certificate) -> float:
    assert certificate.verified and certificate.value is not None
    return certificate.value


@pytest.mark.parametrize("axis", [LADRC, PID], ids=lambda axis: axis.law)
def test_bound_of_a_linear_loop_is_its_star_norm(axis: AxisLoop) -> None:
    """For a linear loop the smallest ellipsoid solves A Q + Q A' + alpha Q + D D'/alpha = 0; the best of 400 alpha."""
    of = disturbed(axis)
    fastest = -2.0 * np.linalg.eigvals(of.a).real.max(axis=0)
    star = np.inf
    for alpha in fastest * np.linspace(0.0025, 0.9975, 399):
        q = solve_continuous_lyapunov(of.a + 0.5 * alpha * np.eye(len(of.a)), -of.d @ of.d.T / alpha)
        star = min(star, float(np.sqrt((of.c @ q @ of.c.T).item())))
    assert (1.0 - 1e-6) * star < bound(run(axis)) < 1.005 * star


@pytest.mark.parametrize("axis", [LADRC, PID, replace(LADRC, from_observer=True)], ids=["ladrc", "pid", "ladrc/z2"])
def test_bound_is_never_below_the_exact_peak_gain(axis: AxisLoop) -> None:
    exact = peak(axis)
    assert exact <= bound(run(axis)) < 1.5 * exact


def test_exact_peak_gain_of_a_known_loop() -> None:
    """A constant disturbance leaves 1/(b0 kp) under PD; its step response does not overshoot, so the L1 norm is that."""
    axis = replace(PID, gains=pid.Gains(20.0, 0.0, 14.0, 0.005))
    assert peak(axis) == pytest.approx(1.0 / 20.0, rel=1e-5)
    assert bound(run(axis)) > 1.0 / 20.0


def test_the_worst_bang_bang_disturbance_stays_inside() -> None:
    """w = sign of the impulse response run backwards reaches the L1 norm at the end, in simulation, and no more."""
    t, g = impulse(LADRC, 3.0)
    of = disturbed(LADRC)
    n = len(of.a)
    step = expm(t[1] * np.block([[of.a, of.d], [np.zeros((1, n + 1))]]))
    x, largest = np.zeros(n), 0.0
    for w in np.sign(g[::-1]):
        largest = max(largest, abs((of.c @ x).item()))
        x = (step @ np.append(x, w))[:n]
    limit = bound(run(LADRC))
    assert 0.98 * peak(LADRC) < largest < limit


def fly(axis: AxisLoop, kind: str, size: float, seconds: float = 5.0) -> float:
    """Largest |y| in the last half of a flight of the whole law, sliding term and all, and disturbance of that size."""
    loop = closed_loop(axis)
    d, power, (y, _, _, s) = loop.b[:, 1], loop.b[:, 2], loop.c
    constants = hybrid.LAW.prepare(axis.gains, 0.004)
    velocity = loop.c[1]

    def push(t: float, x: Array) -> float:
        if kind == "resonant":
            return size * float(np.sign(np.sin(5.0 * t)))
        return size * float(np.sign(velocity @ x)) if kind == "with the motion" else size

    def slopes(t: float, x: Array) -> Array:
        value = float(s @ x)
        phi = sliding_term(value, constants) - axis.gains.k2 * value
        return loop.a @ x + power * phi + d * push(t, x)

    x0 = np.zeros(len(loop.a))
    x0[1] = 1e-3
    t = np.linspace(0.0, seconds, 1001)
    flown = solve_ivp(slopes, (0.0, seconds), x0, t_eval=t, method="LSODA", max_step=0.02, rtol=1e-5, atol=1e-9).y.T
    late = flown[len(t) // 2 :]
    return float(np.abs(late @ y).max(axis=0))


@pytest.mark.parametrize("size", [0.1, 10.0])
@pytest.mark.parametrize("kind", ["constant", "resonant", "with the motion"])
def test_no_flight_of_the_hybrid_leaves_its_bound(kind: str, size: float) -> None:
    """At small and large amplitude, with disturbances made to hurt."""
    assert fly(MILD, kind, size) <= size * bound(run(MILD))


def test_the_bound_of_the_hybrid_covers_every_equivalent_gain() -> None:
    """phi(S) = k S with k anywhere in the sector is one of the loops it speaks for."""
    value = bound(run(MILD))
    for share in (0.0, 0.3, 1.0):
        k2 = MILD.gains.k2 + share * sector(MILD)
        assert peak(replace(MILD, gains=MILD.gains._replace(k1=0.0, k2=k2))) <= value


@pytest.mark.parametrize("axis", [LADRC, MILD], ids=lambda axis: axis.law)
def test_the_ellipsoid_is_inescapable(axis: AxisLoop) -> None:
    """On its surface, with w and phi at their extremes, x'Px does not grow. In the loop's own coordinates."""
    p = run(axis).data["P"]
    of = disturbed(axis)
    draw = np.random.default_rng(4).standard_normal((2000, len(p)))
    x = np.linalg.solve(np.linalg.cholesky(p).T, (draw / np.linalg.norm(draw, axis=1)[:, None]).T).T
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", x, p, x), 1.0, rtol=1e-6)
    s = (x @ of.s.T)[:, 0]
    for w in (-1.0, 1.0):
        for share in (0.0, 0.5, 1.0):
            # of.b enters with a minus: x' = a x - b phi + d w.
            rates = x @ of.a.T - np.outer(share * of.kappa * s, of.b[:, 0]) + w * of.d[:, 0]
            assert np.einsum("ni,ij,nj->n", x, p, rates).max(axis=0) <= 0.0


def test_bounds_scale_with_time() -> None:
    """Everything ten times as fast: y per acceleration falls a hundredfold."""
    fast = replace(
        LADRC, gains=ladrc.Gains(60.0, 1.0, 100.0), actuator=replace(LADRC.actuator, lag=0.002, delay=0.0006)
    )
    assert bound(run(fast)) == pytest.approx(bound(run(LADRC)) / 100.0, rel=1e-4)


def test_a_horizontal_axis_through_its_attitude_loop() -> None:
    axis = AxisLoop("ladrc", ladrc.Gains(1.2, 1.0, 4.0), TiltLoop(LADRC), "position")
    assert peak(axis) <= bound(run(axis)) < 1.5 * peak(axis)


def test_what_has_no_bound() -> None:
    wild = replace(HYBRID, gains=HYBRID.gains._replace(k1=400.0))
    unstable = replace(LADRC, gains=ladrc.Gains(60.0, 1.0, 75.0))
    for none, word in (
        (run(wild), "amplitude"),
        (run(unstable), "not stable"),
    ):
        assert none.value is None and not none.verified
        assert word in none.why
