"""The sliding surface of a second-order channel: e = y - r, S = e' + lambda e. On S = 0 the error decays as exp(-lambda t)."""

from typing import NamedTuple

from plant.laws.channel import Channel, Measured, Setpoint
from plant.primitives import select


class Surface(NamedTuple):
    """Sliding variable s = S [y/s] and error rate e' [y/s]."""

    s: float
    error_rate: float


def surface(lambda_: float, channel: Channel, setpoint: Setpoint, measured: Measured, estimated_rate: float) -> Surface:
    """Return the sliding variable; its rate is measured, or the observer's estimate."""
    rate = select(channel.rate_from_observer > 0.5, estimated_rate, measured.rate)
    error_rate = rate - setpoint.rate
    return Surface(error_rate + lambda_ * (measured.value - setpoint.value), error_rate)
