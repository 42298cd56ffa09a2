"""Comparison of two flight logs: rotor commands and vibration, with intervals.

Values are means over blocks of a second, taken as independent; their logarithms are near normal, so a ratio has an interval by
Student's t with the smaller number of blocks.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from objectives.metrics.noise import CUTOFF
from plant.errors import InputError
from plant.laws.filters import stage_share
from tuner.extensions.logs.flight_log import FlightLog

Array = NDArray[np.float64]

BLOCK = 1.0
"""Length of a block [s]."""
MIN_BLOCKS = 6
"""Fewest blocks of a comparison."""
WIDTH = 0.975
"""Quantile of a two-sided interval of 95 %."""


class Measure(NamedTuple):
    """A quantity of a log: unit, meaning, and whether it is a root mean square or a mean over blocks."""

    unit: str
    meaning: str
    root: bool = True


MEASURES = {
    "noise": Measure("1", f"rotor commands behind a high-pass of first order at {CUTOFF:g} Hz, in hover thrusts"),
    "travel": Measure("1/s", "how far all rotor commands move in a second, in hover thrusts", root=False),
    "rate.roll": Measure("rad/s", "roll rate"),
    "rate.pitch": Measure("rad/s", "pitch rate"),
    "rate.yaw": Measure("rad/s", "yaw rate"),
    "lift": Measure("m/s2", "specific force along z, about its mean"),
}
"""Name -> measure; `noise` and `travel` are the metrics of a flight that have these names."""


class Spread(NamedTuple):
    """A value with its 95 % interval; relative: standard deviation of its logarithm; blocks: behind it."""

    value: float
    low: float
    high: float
    relative: float
    blocks: int


def measured(log: FlightLog) -> dict[str, Spread]:
    """Return every measure of a flight; InputError where it is too short."""
    parts = [part for part in log.stretches() if part.duration >= BLOCK]
    lasts = sum(int(part.duration / BLOCK) * BLOCK for part in parts)
    if lasts < MIN_BLOCKS * BLOCK:
        raise InputError(
            f"its flight lasts {lasts:.1f} s without pauses; at least {MIN_BLOCKS * BLOCK:g} s are compared",
            file=log.name,
        )
    blocks = [_blocks(part, log) for part in parts]
    return {
        name: _spread(np.concatenate([part[name] for part in blocks]), measure.root)
        for name, measure in MEASURES.items()
    }


def ratio_of(after: Spread, before: Spread) -> tuple[float, float, float]:
    """Return after over before with its 95 % interval."""
    wide = stdtrit(min(after.blocks, before.blocks) - 1, WIDTH) * float(np.hypot(after.relative, before.relative))
    ratio = after.value / before.value
    return ratio, ratio * float(np.exp(-wide)), ratio * float(np.exp(wide))


def _blocks(part: FlightLog, log: FlightLog) -> Mapping[str, Array]:
    """Return block means of each measure over a part without pauses; the last block takes the remainder."""
    count = int(part.duration / BLOCK)
    block = np.minimum((part.time - part.time[0]) // BLOCK, count - 1).astype(int)
    samples = np.bincount(block, minlength=count)
    return {name: np.bincount(block, values, count) / samples for name, values in _series(part, log).items()}


def _series(part: FlightLog, log: FlightLog) -> Mapping[str, Array]:
    """Return the series (n,) of each measure in a part: about the means of the log."""
    thrust = part.command**2 / np.mean(log.command**2)
    rates = part.gyro - log.gyro.mean(axis=0)
    lift = part.acceleration[:, 2] - log.acceleration[:, 2].mean()
    moved = np.abs(np.diff(thrust, axis=0, prepend=thrust[:1])).sum(axis=1) / part.period
    squares = {f"rate.{axis}": rates[:, k] ** 2 for k, axis in enumerate(("roll", "pitch", "yaw"))}
    return {"noise": np.mean(_fast(thrust, part.period) ** 2, axis=1), "travel": moved, **squares, "lift": lift**2}


def _fast(thrust: Array, period: float) -> Array:
    """Return high-passed commands (n, 4), as in the metric `noise`."""
    # It takes a second to import.
    from scipy.signal import lfilter

    share = float(stage_share(CUTOFF, period))
    low, _ = lfilter([share], [1.0, share - 1.0], thrust, axis=0, zi=(1.0 - share) * thrust[:1])
    return thrust - low


def _spread(blocks: Array, root: bool) -> Spread:
    count, mean = len(blocks), float(np.mean(blocks))
    mean = max(mean, 1e-300)
    relative = float(np.std(blocks, ddof=1)) / (mean * np.sqrt(count)) * (0.5 if root else 1.0)
    value = float(np.sqrt(mean)) if root else mean
    factor = float(np.exp(stdtrit(count - 1, WIDTH) * relative))
    return Spread(value, value / factor, value * factor, relative, count)
