"""Noise to the motors: what the commands do faster than the vehicle can follow, which costs heat and wear and moves nothing.

Gusts and manoeuvres ask little of the motors above some 20 Hz, sensor noise behind high gains and wide filters asks most of it
there. Each command goes through a high-pass of first order, the command less its low-pass (`plant.laws.filters`): with
s = w h/(1 + w h) and w = 2 pi 20 Hz it is (1 - s)(1 - 1/z)/(1 - (1 - s)/z). It is not steep: 2 Hz pass by a tenth, so of
flights of steps it gives 2.0 times the RMS of the band above 20 Hz.
"""

from typing import Any, NamedTuple

import numpy as np

from objectives.metrics.metric import Accumulator, Metric
from plant.laws.filters import stage_share, step_stage

CUTOFF = 20.0
"""Corner of the high-pass behind which a command counts as noise [Hz]."""


class Noise(NamedTuple):
    """low: the command behind the low-pass; squares: sum of the squares of what is left of the command."""

    low: float
    squares: float


def start(command: float) -> Noise:
    """Begin settled at the first command."""
    return Noise(command, 0.0)


def update(state: Noise, command: float, h: float) -> Noise:
    """Take one more command [hover thrusts, or the input's scale]; h: control period [s]."""
    low = step_stage(state.low, command, stage_share(CUTOFF, h))
    return Noise(low, state.squares + (command - low) * (command - low))


def mean_square(view: Any) -> Any:
    """Mean square of the commands' fast part, over instants and inputs."""
    return sum(noise.squares for noise in view.accumulated) / (len(view.accumulated) * view.context.periods)


NOISE = Metric(
    name="noise",
    symbol="N_u",
    title="rotor command noise",
    unit="1",
    scope="flight",
    definition="root mean square of the commands behind a first-order high-pass at 20 Hz, of rotors in hover thrusts, of "
    "inputs in their scales; on flights of steps twice that of the band above 20 Hz",
    value=lambda view: np.sqrt(mean_square(view)),
    # A low-pass of first order stays among the commands that it has seen, none of which is further from 0 than the peak.
    bound=lambda view: 2.0 * view.context.limits.command_peak,
    accumulator=Accumulator(Noise, start, update, each_input=True, counts_above=CUTOFF),
)
