"""How much an axis sways: the way that it goes, back and forth."""

from typing import NamedTuple

from objectives.metrics import Accumulator, Metric
from plant.primitives import absolute


class Sway(NamedTuple):
    """previous: actual value one instant ago; way: sum of its changes."""

    previous: float
    way: float


def start(sample, target):
    return Sway(sample.actual, 0.0)


def update(state, sample, target, t, h):
    return Sway(sample.actual, state.way + absolute(sample.actual - state.previous))


METRIC = Metric(
    name="sway",
    symbol="sway",
    unit="{}",
    scope="axis",
    definition="way that the actual value goes, back and forth",
    value=lambda view: view.accumulated.way,
    bound=lambda view: 2.0 * view.limit * view.context.periods,
    accumulator=Accumulator(Sway, start, update),
)
