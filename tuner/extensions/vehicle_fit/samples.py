"""Flight logs on a uniform grid, and the means for estimation."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.logs.flight_log import FlightLog

Array = NDArray[np.float64]

COMPARED_RATE = 250.0
"""Rate of the means that are compared [Hz]; what rotors do to a body is slower."""
MODEL_RATE = 1000.0
"""Rate of the grid that the model runs on [Hz]: that of the log times a whole number, or this where the log is faster. At 500 Hz
the low-pass of a gyro of 300 Hz could not be distinguished from dead time.
"""
ROUNDING = 0.01
"""Share of a period by which a sample may stand late on the grid."""
OUTPUTS = ("roll", "pitch", "yaw", "lift")


@dataclass(frozen=True, eq=False)
class LogSegment:
    """A segment of a log on a uniform grid.

    Attributes:
        log: Index of the log.
        age (n,): Share of the log's time that has passed.
        begin: Time of the first sample [s].
        period: Period of the grid [s].
        share: Samples in a mean.
        gyro (n, 3): Body rates [rad/s].
        lift (n,): Specific force along z [m/s2].
        command (n, 4): Commands of the motors.
        setpoint (n, 3): Body rates that the loops are given [rad/s]; None where the log has none.
    """

    log: int
    age: Array
    begin: float
    period: float
    share: int
    gyro: Array
    lift: Array
    command: Array
    setpoint: Array | None = None

    @cached_property
    def measured(self) -> Array:
        """Measured outputs (m, 4): changes of the body rates from mean to mean [rad/s], and means of the lift [m/s2]."""
        return model_outputs(self.gyro, self.lift, self.share)

    @property
    def time(self) -> Array:
        """Times of the outputs (m,) [s]."""
        count = len(self.lift) // self.share - 1
        return self.begin + self.period * self.share * np.arange(1.0, count + 1.0)

    @property
    def output_age(self) -> Array:
        """Share (m,) of the log's time that has passed at the outputs."""
        count = len(self.age) // self.share
        return self.age[: count * self.share].reshape(-1, self.share).mean(axis=1)[1:]


def resample(stretch: FlightLog, log: int, begin: float, duration: float) -> LogSegment:
    """Return a stretch on a uniform grid: commands held, measurements linearly interpolated.

    begin, duration: of its log [s].
    """
    rate = min(stretch.rate * max(round(MODEL_RATE / stretch.rate), 1), MODEL_RATE)
    time = np.arange(stretch.time[0], stretch.time[-1], 1.0 / rate)
    # Rounding must not take the sample before.
    held = np.searchsorted(stretch.time, time + ROUNDING / rate, side="right") - 1
    gyro = _interpolated(time, stretch.time, stretch.gyro)
    setpoint = None if stretch.setpoint is None else _interpolated(time, stretch.time, stretch.setpoint)
    lift = np.interp(time, stretch.time, stretch.acceleration[:, 2])
    share = max(round(rate / COMPARED_RATE), 1)
    age = (time - begin) / duration
    return LogSegment(log, age, float(time[0]), 1.0 / rate, share, gyro, lift, stretch.command[held], setpoint)


def _interpolated(time: Array, sampled: Array, columns: Array) -> Array:
    return np.column_stack([np.interp(time, sampled, column) for column in columns.T])


def model_outputs(rates: Array, lift: Array, share: int) -> Array:
    """Return changes of mean rates, and mean lift (..., m, 4): of rates (..., n, 3) and lift (..., n)."""
    return np.concatenate([np.diff(_means(rates, share), axis=-2), _means(lift[..., None], share)[..., 1:, :]], axis=-1)


def _means(series: Array, share: int) -> Array:
    count = series.shape[-2] // share
    # Sample by sample: a mean along so short an axis takes four times as long.
    first, *others = (series[..., k : count * share : share, :] for k in range(share))
    return sum(others, start=first) / share
