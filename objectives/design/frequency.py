"""Frequency responses of one axis with exact dead time.

They serve designs and their checks:

    L = G_a C/s^2,   C = -(K_y + s K_v)/(1 - K_e G_k)

K: the law from (r, y, y', known) to u; G_a: from u to the acceleration delivered; G_k: from u to the law's model of it.
"""

from dataclasses import dataclass

import numpy as np

from objectives.linear_axis.channel_model import AxisLoop, Factors, RotorLag, TiltLoop, closed_loop, controller

Array = np.ndarray


@dataclass(frozen=True)
class AxisResponses:
    """One axis at the frequencies j omega, each (k,): delivered G_a, known G_k, and the law's K_r, K_y + s K_v, K_e."""

    s: Array
    delivered: Array
    seen: Array
    reference: Array
    feedback: Array
    command: Array

    def feedback_gain(self) -> Array:
        """Return C, from -y to u."""
        return -self.feedback / (1.0 - self.command * self.seen)

    def loop(self) -> Array:
        """Return L, broken where the command leaves the law; the law's model of its own command stays closed."""
        return self.delivered * self.feedback_gain() / self.s**2

    def closed(self) -> Array:
        """Return the transfer function from the reference to y."""
        ahead = self.delivered * self.reference
        return ahead / (self.s**2 * (1.0 - self.command * self.seen) - self.delivered * self.feedback)


def actuator_response(actuator: RotorLag | TiltLoop, s: Array) -> tuple[Array, Array]:
    """Return (delivered, known) at complex frequencies s (k,)."""
    if isinstance(actuator, TiltLoop):
        delivered = responses(actuator.attitude, s).closed()
        return delivered, delivered if actuator.lag_aware else np.ones_like(delivered)
    delayed = np.exp(-s * actuator.delay) / (actuator.smoothing * s + 1.0)
    reached = delayed / (actuator.lag * s + 1.0)
    return (actuator.lead * s + 1.0) * reached, reached if actuator.lag_aware else delayed


def mean_delays(actuator: RotorLag | TiltLoop) -> tuple[float, float]:
    """Return the delays [s] of (delivered, known) at low frequency; those of a Pade approximant are exact."""
    model = actuator.model(Factors())
    slopes = model.c @ np.linalg.solve(model.a, np.linalg.solve(model.a, model.b))
    return float(slopes[0, 0]), float(slopes[1, 0])


def responses(axis: AxisLoop, s: Array, power: float = 0.0) -> AxisResponses:
    """Return the responses of an axis; power [1/s]: the gain that represents the power-rate term, phi(S) = power S."""
    law = controller(axis.law, axis.gains, axis.from_observer).at(s)
    r, y, v, by_command = np.moveaxis(law[:, 0] - power * law[:, 1], -1, 0)
    return AxisResponses(s, *actuator_response(axis.actuator, s), r, y + s * v, by_command)


def peaks(axis: AxisLoop, omega: Array, power: float = 0.0) -> tuple[float, float]:
    """Return the largest |S| and |T| over frequencies [rad/s]."""
    loop = responses(axis, 1j * omega, power).loop()
    distance = np.abs(1.0 + loop)
    return float((1.0 / distance).max(axis=0)), float((np.abs(loop) / distance).max(axis=0))


def closed_matrix(axis: AxisLoop, power: float = 0.0) -> Array:
    """Return A of the closed loop with phi(S) = power S."""
    a, b, s = closed_loop(axis).channel("power", "sliding")
    return a + power * b @ s
