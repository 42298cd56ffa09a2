"""Step and load responses of the linearized loop, by amplitude.

Position steps fly with all loops closed. Attitude steps and loads fly in attitude mode where that has a steady state, as an
attitude loop would be flown by hand; else the position loops answer as well. The map of one control period is exact for both: a
load and a reference that stand still over it.
"""

from dataclasses import dataclass, replace

import numpy as np

from objectives.margins.linearise import LinearLoops
from objectives.margins.trim import Trim
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.analysis.margins.linear import Linear
from tuner.gains import Controller

Array = np.ndarray

# Longest response [s] of position and of attitude channels, and the share of its largest value within which it counts as over.
LONGEST = {"position": 20.0, "attitude": 4.0}
SETTLED = 0.02


@dataclass(frozen=True)
class LinearResponses:
    """Responses of one channel, NaN for cases that are not stable; loops that depend on no amplitude have one case.

    time (t,) [s]; step (cases, t): output after a unit step of the set point; load (cases, t): output after a unit step of the
    acceleration that acts on the vehicle, in m per m/s2 or rad per rad/s2.
    """

    channel: str
    time: Array
    step: Array
    load: Array


def time_responses(controller: Controller, trim: Trim, channels: tuple[str, ...]) -> list[LinearResponses]:
    """Return the responses of some channels."""
    held = Linear(controller, trim)
    free = Linear(controller, replace(trim, hold=False)) if trim.hold and not trim.moves else held
    return [_responses(channel, free if channel in ATTITUDE_AXES else held) for channel in channels]


def _responses(channel: str, linear: Linear) -> LinearResponses:
    loops, i, stable = linear.closed(channel)
    steps = round(LONGEST["attitude" if channel in ATTITUDE_AXES else "position"] / linear.control_period)
    step, load = [
        np.where(stable[:, None], simulate(loops, start.start + i, loops.output.start + i, steps), np.nan)
        for start in (loops.reference, loops.load)
    ]
    count = max(_until_settled(step), _until_settled(load))
    return LinearResponses(channel, linear.control_period * np.arange(count), step[:, :count], load[:, :count])


def simulate(loops: LinearLoops, column: int, row: int, steps: int) -> Array:
    """Return the output (cases, steps) of a row after a unit step.

    The step is of the input of a column, from rest.
    """
    a, b, c, d = loops.a, loops.b[..., column], loops.c[:, row], loops.d[:, row, column]
    x, out = np.zeros_like(b), np.empty((len(a), steps))
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(steps):
            out[:, k] = np.einsum("nx,nx->n", c, x) + d
            x = np.einsum("nxy,ny->nx", a, x) + b
    return out


def _until_settled(response: Array) -> int:
    """Return the settling time of all cases in samples, plus 30 %."""
    bounded = response[np.isfinite(response).all(axis=1)]
    if not len(bounded):
        return response.shape[1]
    away = np.abs(bounded - bounded[:, -1:]) > SETTLED * np.abs(bounded).max(axis=None)
    last = int(np.nonzero(away.any(axis=0))[0].max(initial=0))
    return min(int(1.3 * last) + 2, response.shape[1])
