"""Results of an evaluation of margins: the worst over the conditions, and everything it was taken from."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.describing import Case
from objectives.margins.disk import DiskRange, disk_range
from plant.quadrotor.cascade import AXES

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]
# Relative difference up to which two conditions count as equally bad.
ALIKE = 1e-6


class Worst(NamedTuple):
    """A quantity in the worst of the conditions, each field (n, channels): value; frequency [rad/s] where it is met, 0 for none;
    case: index in `Margins.cases`, -1 for a loop without nonlinear terms; vehicle: index in the model's vehicles.
    """

    value: Array
    frequency: Array
    case: Index
    vehicle: Index


@dataclass(frozen=True)
class Margins:
    """Margins of n candidates in `channels`, in the worst amplitude and vehicle.

    A loop that is not stable in every condition has no margin: factors 1, angles, delays and disks 0, peaks infinite. A margin is
    infinite where no crossing limits it. Nothing is ever NaN.

    stable (n, channels): all poles of the channel's block inside the unit circle, in all conditions. growth (n, channels) [1/s]:
    rate of the slowest decay or fastest growth, above 0 where unstable, infinite where no steady flight was found and minus
    infinite for a channel without loop. multiloop, with fields (n,): disk margin alpha in all
    plant inputs (z, roll, pitch, yaw) at once.
    """

    cases: tuple[Case, ...]
    control_period: float
    skew: float
    stable: Mask
    growth: Array
    gain_up: Worst
    gain_down: Worst
    phase: Worst
    delay: Worst
    sensitivity: Worst
    complementary: Worst
    disk: Worst
    crossover: Worst
    bandwidth: Worst
    load_index: Worst
    group_delay: Worst
    rejection: Worst
    multiloop: Worst
    channels: tuple[str, ...] = AXES

    def of(self, row: int) -> "Margins":
        """Return the margins of one candidate."""
        rows = slice(row, row + 1)

        def only(part: Any) -> Any:
            if isinstance(part, Worst):
                return Worst(part.value[rows], part.frequency[rows], part.case[rows], part.vehicle[rows])
            return part[rows] if isinstance(part, np.ndarray) else part

        return replace(self, **{field.name: only(getattr(self, field.name)) for field in fields(self)})

    @property
    def delay_periods(self) -> Array:
        """Delay margin in control periods, (n, channels)."""
        return self.delay.value / self.control_period

    @property
    def disk_range(self) -> DiskRange:
        """Factors and phases that the disk margin guarantees, (n, channels)."""
        return disk_range(self.disk.value, self.skew)


@dataclass(frozen=True)
class LoopResponse:
    """One loop for plots: frequency (f,) [rad/s]; t (f,): from injected to commanded signal, 0 for a channel without loop."""

    frequency: Array
    t: NDArray[np.complex128]

    @property
    def s(self) -> NDArray[np.complex128]:
        """Sensitivity 1/(1 + L)."""
        return 1.0 + self.t

    @property
    def loop(self) -> NDArray[np.complex128]:
        """Loop transfer function L."""
        return -self.t / (1.0 + self.t)


@dataclass(frozen=True)
class Realization:
    """State-space realization of one closed loop from injected to commanded signal.

    T(z) = c (z I - a)^-1 b, with a (x, x), b (x,) and c (x,); period [s].
    """

    a: Array
    b: Array
    c: Array
    period: float

    def response(self, frequency: Array) -> LoopResponse:
        """Response at frequencies (f,) [rad/s]; 0 for those that a loop of this period cannot have."""
        z = np.exp(1j * frequency * self.period)[:, None, None]
        state = np.linalg.solve(
            z * np.eye(len(self.a)) - self.a, np.broadcast_to(self.b[:, None], (len(z), len(self.b), 1))
        )
        answer = (self.c @ state)[:, 0].astype(complex)
        return LoopResponse(frequency, np.where(frequency <= np.pi / self.period * (1.0 + 1e-12), answer, 0.0))


def joined(parts: Sequence[Margins]) -> Margins:
    """Margins of several batches as those of one."""
    if len(parts) == 1:
        return parts[0]
    together: dict[str, Any] = {}
    for field in fields(Margins):
        of_parts = [getattr(part, field.name) for part in parts]
        if isinstance(of_parts[0], Worst):
            together[field.name] = Worst(*[np.concatenate(column, axis=0) for column in zip(*of_parts, strict=True)])
        elif isinstance(of_parts[0], np.ndarray):
            together[field.name] = np.concatenate(of_parts, axis=0)
    return replace(parts[0], **together)


def worst(values: Array, frequency: Array, sense: str, case: Index) -> Worst:
    """Worst over vehicles and cases of values (n, vehicles, cases, channels); case (channels, cases): index to report."""
    n, vehicles, cases, channels = values.shape
    flat = np.moveaxis(values, -1, 1).reshape(n, channels, vehicles * cases)
    at = np.argmin(flat, axis=-1) if sense == "min" else np.argmax(flat, axis=-1)
    extreme = np.take_along_axis(flat, at[..., None], axis=-1)
    vehicle, which = np.divmod(first_alike(flat, extreme, at), cases)
    n_index, channel = np.ogrid[:n, :channels]
    return Worst(extreme[..., 0], frequency[n_index, vehicle, which, channel], case[channel, which], vehicle)


def first_alike(values: Array, extreme: Array, at: Index) -> Index:
    """Return the first places of values (..., n) within `ALIKE` of their extreme (..., 1); at: those of the extreme.

    Rounding, which differs between machines, must not decide which of several alike cases is named.
    """
    with np.errstate(invalid="ignore"):
        near = np.isfinite(extreme) & (np.abs(values - extreme) <= ALIKE * np.abs(extreme))
    alike = near | (values == extreme)
    return np.where(alike.any(axis=-1), np.argmax(alike, axis=-1), at)
