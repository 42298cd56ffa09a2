"""Linear extended state observer of y'' = f + b0 u, as a sampled current estimator.

z1, z2, z3 estimate y, y' and the total disturbance f. All three poles stand at exp(-omega_o h), so the estimator is stable
for every positive omega_o. Z. Gao, "Scaling and bandwidth-parameterization based controller tuning", ACC 2003; sampled form
after R. Miklosovic, A. Radke, Z. Gao, "Discrete implementation and generalization of the extended state observer",
ACC 2006. The input is what the actuators delivered, so saturation cannot wind the observer up.
"""

from typing import Any, NamedTuple

from plant.primitives import exp

SAMPLING = "observer: current estimator for a held input, three poles at exp(-omega_o h)"
FEEDBACK = "feedback of the same instant"


class ObserverConstants(NamedTuple):
    """Correction gains of the current estimator: l1 [1], l2 [1/s], l3 [1/s2]."""

    l1: float
    l2: float
    l3: float


class Observer(NamedTuple):
    """Estimates of y, y' and of the total disturbance (per s2)."""

    z1: float
    z2: float
    z3: float


def triple_pole(omega_o: Any) -> tuple[Any, Any, Any]:
    """Return the gains (b1 [1/s], b2 [1/s2], b3 [1/s3]) of the continuous observer with all poles at -omega_o [rad/s].

    They are the coefficients of (s + omega_o)^3. omega_o: a number, an array or an expression.
    """
    return 3.0 * omega_o, 3.0 * omega_o**2, omega_o**3


def observer_constants(omega_o: float, h: float) -> ObserverConstants:
    """Place all poles of the sampled estimator at beta = exp(-omega_o h)."""
    beta = exp(-omega_o * h)
    gap = 1.0 - beta
    return ObserverConstants(1.0 - beta * beta * beta, 1.5 * gap * gap * (1.0 + beta) / h, gap * gap * gap / (h * h))


def placed(gap: float, pair_sum: float, pair_product: float, h: float) -> ObserverConstants:
    """Place the poles p1, p2, p3 of the sampled estimator anywhere: gap = 1 - p1, and sum and product of 1 - p2 and 1 - p3.

    Written in distances from 1, where sampled poles lie close together, nothing cancels; p2 and p3 may be conjugate.
    """
    total = gap + pair_sum
    pairs = gap * pair_sum + pair_product
    product = gap * pair_product
    return ObserverConstants(total - pairs + product, (pairs - 1.5 * product) / h, product / (h * h))


def observe(z: Observer, constants: ObserverConstants, measured: float, acceleration: float, h: float) -> Observer:
    """Predict over one period under the known acceleration b0 u, then correct with the measurement at its end."""
    drift = z.z3 + acceleration
    predicted = z.z1 + h * z.z2 + 0.5 * h * h * drift
    error = measured - predicted
    return Observer(
        predicted + constants.l1 * error, z.z2 + h * drift + constants.l2 * error, z.z3 + constants.l3 * error
    )
