"""Han's nonlinear extended state observer, as a sampled current estimator with a linear zone.

    z1' = z2 + l1 e,   z2' = z3 + b0 u + l2 fal(e, 1/2, delta),   z3' = l3 fal(e, 1/4, delta),   e = y - z1

J. Han, IEEE Trans. Ind. Electron. 56(3), 2009, pp. 900-906, with fal scaled to the slope 1: while |e| <= delta it is, to the
last bit, the linear observer of bandwidth omega_o (`observer`); larger innovations are answered with less than their share, so an
outlier or a jump of y excites it less and a large disturbance is found more slowly. At an innovation m delta the gains act as
l2 m^(-1/2) and l3 m^(-3/4). Frozen there, its poles lie in the unit circle for all m from 1 to 1e6 and omega_o h up to 20, where
Euler steps of the same equations would be unstable from omega_o h = 2 on; that is no proof for gains that change on the way.
"""

from typing import Any, NamedTuple

from plant.laws.fal import fal_1_2, fal_1_4
from plant.laws.law import Nonlinearity
from plant.laws.observer import Observer, ObserverConstants


class NonlinearObserverConstants(NamedTuple):
    """Gains in the linear zone, and its half-width delta [y]."""

    gains: ObserverConstants
    delta: float


def rate_correction(error: float, constants: Any) -> float:
    """Correction of z2 [y/s] for an innovation [y]; constants hold the part `observer`."""
    return constants.observer.gains.l2 * fal_1_2(error, constants.observer.delta)


def disturbance_correction(error: float, constants: Any) -> float:
    """Correction of z3 [y/s2] for an innovation [y]; constants hold the part `observer`."""
    return constants.observer.gains.l3 * fal_1_4(error, constants.observer.delta)


def observe_nonlinearly(z: Observer, constants: Any, measured: float, acceleration: float, h: float) -> Observer:
    """Predict over one period under the known acceleration b0 u, then correct with the measurement at its end."""
    drift = z.z3 + acceleration
    predicted = z.z1 + h * z.z2 + 0.5 * h * h * drift
    error = measured - predicted
    return Observer(
        predicted + constants.observer.gains.l1 * error,
        z.z2 + h * drift + rate_correction(error, constants),
        z.z3 + disturbance_correction(error, constants),
    )


NONLINEAR = (
    Nonlinearity("correction of the rate", rate_correction, "{y}"),
    Nonlinearity("correction of the disturbance", disturbance_correction, "{y}"),
)
