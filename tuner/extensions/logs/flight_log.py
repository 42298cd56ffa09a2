"""A flight log in one form: time, gyro, accelerometer and motor commands, in SI units and body axes FLU."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError

Array = NDArray[np.float64]
STANDARD_GRAVITY = 9.80665
"""Acceleration that a log calls 1 g [m/s2]."""
FRD_TO_FLU = np.array([1.0, -1.0, -1.0])
# Fewest samples that anything can be said of, and longest flight that is read [s].
MIN_SAMPLES, LONGEST = 200, 7200.0
MAX_LOG_BYTES = 2**28
"""Largest log that is read [bytes]: an hour of a Crazyflie's is 180 MB."""
# A pause longer than this breaks a log into stretches, in median sampling periods and [s].
PAUSE_PERIODS, PAUSE = 25.0, 0.1
# A gap of more than so many median periods lost samples.
LOST = 1.7


@dataclass(frozen=True, eq=False)
class FlightLog:
    """Samples of one flight; body axes FLU.

    Attributes:
        name: File name.
        kind: Kind of log, as `tuner.extensions.logs.reading.READERS` has it.
        digest: SHA-256 of the file.
        time: Rising times (n,) [s].
        gyro: Body rates (n, 3) [rad/s].
        acceleration: Specific force (n, 3) [m/s2], +g along z at rest.
        command: Share of full command (n, 4), 0 to 1, rotors as in an airframe: front left, front right, rear left,
            rear right.
        notes: The reader's assumptions and omissions.
        setpoint: Body rates (n, 3) that the rate loops are given [rad/s]; None where the log has none.
    """

    name: str
    kind: str
    digest: str
    time: Array
    gyro: Array
    acceleration: Array
    command: Array
    notes: tuple[str, ...] = ()
    setpoint: Array | None = None

    @cached_property
    def period(self) -> float:
        """Median sampling period [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def rate(self) -> float:
        """Samples in a second, of the median period [Hz]."""
        return 1.0 / self.period

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def lost(self) -> int:
        """Number of samples that gaps in the time base lack."""
        gaps = np.diff(self.time) / self.period
        return int(np.sum(np.round(gaps[gaps > LOST]) - 1.0))

    def between(self, begin: float, end: float) -> "FlightLog":
        """Return the samples between two times [s] of the log's clock; InputError where too few are left."""
        chosen = (self.time >= begin) & (self.time <= end)
        if np.count_nonzero(chosen) < MIN_SAMPLES:
            raise InputError(
                f"has {np.count_nonzero(chosen)} samples from {begin:g} to {end:g} s; it goes from {self.time[0]:.1f} to "
                f"{self.time[-1]:.1f} s and at least {MIN_SAMPLES} samples are needed",
                file=self.name,
            )
        return self.where(chosen)

    def where(self, chosen: NDArray[np.bool_]) -> "FlightLog":
        """Return the samples that are chosen by a mask (n,)."""
        return replace(
            self,
            time=self.time[chosen],
            gyro=self.gyro[chosen],
            acceleration=self.acceleration[chosen],
            command=self.command[chosen],
            setpoint=None if self.setpoint is None else self.setpoint[chosen],
        )

    def stretches(self) -> list["FlightLog"]:
        """Return the parts between pauses of the time base: each of at least `MIN_SAMPLES`."""
        longest = max(PAUSE, PAUSE_PERIODS * self.period)
        ends = [0, *(np.flatnonzero(np.diff(self.time) > longest) + 1).tolist(), len(self.time)]
        index = np.arange(len(self.time))
        parts = [(first, last) for first, last in pairwise(ends) if last - first >= MIN_SAMPLES]
        return [self.where((index >= first) & (index < last)) for first, last in parts]


def checked(log: FlightLog) -> FlightLog:
    """Return a log as it was read with its samples in order; raises InputError where nothing can be made of it."""
    columns = np.column_stack([log.time, log.gyro, log.acceleration, log.command])
    finite = np.all(np.isfinite(columns), axis=1)
    log = (
        log
        if finite.all()
        else replace(log.where(finite), notes=(*log.notes, f"{np.sum(~finite):,} samples are no numbers"))
    )
    if log.setpoint is not None and not np.isfinite(log.setpoint).all():
        log = replace(log, setpoint=None, notes=(*log.notes, "setpoints are left out, because some are no numbers"))
    if len(log.time) < MIN_SAMPLES:
        raise InputError(f"has {len(log.time)} usable samples; at least {MIN_SAMPLES} are needed", file=log.name)
    forward = np.concatenate([[True], log.time[1:] > np.maximum.accumulate(log.time)[:-1]])
    if not forward.all():
        log = replace(
            log.where(forward), notes=(*log.notes, f"{np.sum(~forward):,} samples stand before their predecessors")
        )
    if len(log.time) < MIN_SAMPLES or not 0.0 < log.duration <= LONGEST:
        raise InputError(
            f"lasts {log.duration:g} s with {len(log.time)} samples in order; allowed: up to {LONGEST:g} s and at least "
            f"{MIN_SAMPLES} samples: check the time base",
            file=log.name,
        )
    return log
