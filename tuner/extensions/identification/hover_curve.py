"""Thrust curve with value and slope of the identified one at hover.

    T = T_max ((1 - a) u^2 + a u)
    x = d log T/d log u at hover,    D = x - 1 + u (2 - x),    a = u (2 - x)/D,    da/dx = -u/D^2

The identified curve is a parabola through thrusts at `NODES`. Away from hover, and at full command above all, the two differ.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.thrust_curve import MAX_LINEAR
from tuner.extensions.vehicle_fit.parameters import NODES, PhysicalParameters

Array = NDArray[np.float64]

MIN_COMMAND = 0.02
"""Least motor command at hover."""
MIN_LINEAR_SHARE = -0.9
"""Least share a."""
MIN_THRUST_SHARE = 0.01
"""Least thrust at hover over that at full command [1]."""
EXPONENTS = (1.0, 4.0)
"""Range of the exponent x: that of a line up to that of a rotor that hardly turns below hover."""


class HoverCurve(NamedTuple):
    """The identified curve at hover.

    Attributes:
        command: Motor command at hover [1].
        thrust: Thrust of a rotor there [N].
        linear: Share a of the full thrust that is linear in the command [1].
        by_thrust (3,): Gradient of log thrust at this command by the logarithms of the thrusts at the nodes.
        by_linear (3,): Gradient of a by the same.
    """

    command: float
    thrust: float
    linear: float
    by_thrust: Array
    by_linear: Array

    def share(self, linear: float) -> float:
        """Return the hover thrust over that at full command; linear: share a."""
        return max((1.0 - linear) * self.command**2 + linear * self.command, MIN_THRUST_SHARE)

    def thrust_by_linear(self, linear: float) -> float:
        """Return d log T/da at hover, full thrust held; linear: share a."""
        return (self.command - self.command**2) / self.share(linear)


def hover_curve(numbers: PhysicalParameters, weight: float) -> HoverCurve:
    """Return the identified curve at hover; weight: on a rotor [N]."""
    c0, c1, c2 = numbers.curve.tolist()
    root = sqrt(max(c1 * c1 + 4.0 * c2 * (weight - c0), 0.0))
    u = min(max(2.0 * (weight - c0) / max(c1 + root, 1e-12), MIN_COMMAND), 1.0)
    to_curve = np.linalg.inv(np.vander(NODES, 3, increasing=True))
    values = np.array([1.0, u, u * u]) @ to_curve * numbers.thrust
    slopes = np.array([0.0, 1.0, 2.0 * u]) @ to_curve * numbers.thrust
    thrust = float(np.sum(values))
    exponent = u * float(np.sum(slopes)) / thrust
    x = min(max(exponent, EXPONENTS[0]), EXPONENTS[1])
    divisor = x - 1.0 + u * (2.0 - x)
    by_exponent = (u * slopes - exponent * values) / thrust
    linear = min(max(u * (2.0 - x) / divisor, MIN_LINEAR_SHARE), MAX_LINEAR)
    return HoverCurve(u, thrust, linear, values / thrust, -u / divisor**2 * by_exponent)
