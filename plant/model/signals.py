"""Signals of one number over time: what a channel is asked to follow, and what disturbs a plant.

A reference has a value, counted from the output at rest, a rate and an acceleration, all in closed form. A disturbance is such a
signal, or noise shaped by a forming filter that is sampled exactly (`plant.air.linear_process`), drawn again for every flight.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from math import isfinite, pi
from typing import Any, ClassVar

import numpy as np

from plant.air.dryden import transverse
from plant.air.linear_process import LinearProcess, SampledProcess, discretize, gauss_markov, sample
from plant.errors import InputError, UnknownNameError, check_name

Array = np.ndarray
# A step at 0.0275 s belongs to sample 5 at 5.5 ms, although 5 * 0.0055 falls an ulp short of 0.0275.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Signal(ABC):
    """A signal as a study describes it; every number is finite."""

    kind: ClassVar[str]
    meaning: ClassVar[str]
    random: ClassVar[bool] = False
    """Whether it is drawn again for every flight; then it can only disturb."""
    positive: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers that must be positive."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not isfinite(value):
                raise InputError(f"given {value}; numbers must be finite", key=entry.name)
        for name in self.positive:
            value = getattr(self, name)
            if not value > 0.0:
                raise InputError(f"given {value:g}; it must be positive", key=name)

    @abstractmethod
    def values(self, t: Array, draw: np.random.Generator) -> Array:
        """Return the signal at times t (K,) [s], which begin at 0 and increase by one step: value, rate, acceleration (3, K)."""

    @property
    def step(self) -> tuple[float, float, float]:
        """Level before, level after, and time [s] of the step that it makes; equal levels where it makes none."""
        return 0.0, 0.0, 0.0

    @property
    def begin(self) -> float:
        """Time [s] from which on it moves."""
        return 0.0


def _without_rate(values: Array) -> Array:
    """Return a signal (3, K) of values (K,), its rate and acceleration taken as 0."""
    return np.stack([values, np.zeros(len(values)), np.zeros(len(values))])


@dataclass(frozen=True)
class Constant(Signal):
    """The same value all the time."""

    kind: ClassVar[str] = "constant"
    meaning: ClassVar[str] = "the same value all the time"
    value: float = 0.0

    def values(self, t: Array, draw: np.random.Generator) -> Array:  # noqa: ARG002
        """Return the value, at rest."""
        return _without_rate(np.full(len(t), self.value))

    @property
    def step(self) -> tuple[float, float, float]:
        """No step."""
        return self.value, self.value, 0.0


@dataclass(frozen=True)
class Step(Signal):
    """A step from 0 to a size, and back at `until` where that is given."""

    kind: ClassVar[str] = "step"
    meaning: ClassVar[str] = "a step of `size` at `time` [s]; back to 0 at `until` [s] where that is above 0"
    size: float = 1.0
    time: float = 0.0
    until: float = 0.0

    def values(self, t: Array, draw: np.random.Generator) -> Array:  # noqa: ARG002
        """Return the levels."""
        on = t >= self.time - ROUNDING
        if self.until > 0.0:
            on &= t < self.until - ROUNDING
        return _without_rate(self.size * on)

    @property
    def step(self) -> tuple[float, float, float]:
        """From 0 to the size; none where it goes back."""
        return 0.0, 0.0 if self.until > 0.0 else self.size, self.time

    @property
    def begin(self) -> float:
        """Time of the step."""
        return self.time


@dataclass(frozen=True)
class Ramp(Signal):
    """A ramp between two times."""

    kind: ClassVar[str] = "ramp"
    meaning: ClassVar[str] = "from 0 to `size` between `time` and `until` [s]"
    size: float = 1.0
    time: float = 0.0
    until: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.until > self.time:
            raise InputError(
                f"given {self.until:g} s; the end must come after the start at {self.time:g} s", key="until"
            )

    def values(self, t: Array, draw: np.random.Generator) -> Array:  # noqa: ARG002
        """Return the ramp and its slope."""
        slope = self.size / (self.until - self.time)
        climbing = (t >= self.time) & (t < self.until)
        return np.stack([slope * (np.clip(t, self.time, self.until) - self.time), slope * climbing, np.zeros(len(t))])

    @property
    def begin(self) -> float:
        """Time at which it leaves 0."""
        return self.time


@dataclass(frozen=True)
class Sine(Signal):
    """A sine wave."""

    kind: ClassVar[str] = "sine"
    meaning: ClassVar[str] = "`size` times the sine of 2 pi `frequency` [Hz] t"
    positive: ClassVar[tuple[str, ...]] = ("frequency",)
    size: float = 1.0
    frequency: float = 1.0

    def values(self, t: Array, draw: np.random.Generator) -> Array:  # noqa: ARG002
        """Return the wave with its derivatives."""
        w = 2.0 * pi * self.frequency
        return self.size * np.stack([np.sin(w * t), w * np.cos(w * t), -w * w * np.sin(w * t)])


class Noise(Signal):
    """Noise of a forming filter with unit variance, scaled."""

    random: ClassVar[bool] = True
    rms: float

    @property
    @abstractmethod
    def process(self) -> LinearProcess:
        """The forming filter; its first output is the signal."""

    def values(self, t: Array, draw: np.random.Generator) -> Array:
        """Draw the signal; noise has no rate."""
        sampled = _sampled(self, float(t[1] - t[0]) if len(t) > 1 else 1.0)
        normals = draw.standard_normal((len(t), len(sampled.transition)))
        return _without_rate(self.rms * sample(sampled, normals)[:, 0])


@cache
def _sampled(noise: Noise, step: float) -> SampledProcess:
    """Return the forming filter at a step [s]; worked out once, because it takes longer than the noise of a flight."""
    return discretize(noise.process, step)


@dataclass(frozen=True)
class Coloured(Noise):
    """First-order Gauss-Markov noise."""

    kind: ClassVar[str] = "coloured"
    meaning: ClassVar[str] = "noise of `rms` with autocovariance exp(-|t|/`correlation_time` [s])"
    positive: ClassVar[tuple[str, ...]] = ("rms", "correlation_time")
    rms: float = 1.0
    correlation_time: float = 1.0

    @property
    def process(self) -> LinearProcess:
        """First order."""
        return gauss_markov(self.correlation_time)


@dataclass(frozen=True)
class VerticalGust(Noise):
    """Dryden turbulence across the flight path: MIL-F-8785C, H_w = sigma sqrt(tau) (1 + sqrt(3) tau s)/(1 + tau s)^2."""

    kind: ClassVar[str] = "dryden"
    meaning: ClassVar[str] = (
        "Dryden gust across the flight path [m/s]: `rms`, `length` of its scale [m], `airspeed` [m/s] (MIL-F-8785C)"
    )
    positive: ClassVar[tuple[str, ...]] = ("rms", "length", "airspeed")
    rms: float = 1.0
    length: float = 150.0
    airspeed: float = 20.0

    @property
    def process(self) -> LinearProcess:
        """Two lags of the correlation time; the rate that `transverse` adds is not used, its lag is the same."""
        tau = self.length / self.airspeed
        gust = transverse(tau, tau, 1.0 / self.airspeed)
        return LinearProcess(gust.a[:2, :2], gust.b[:2], gust.c[:1, :2])


SIGNALS: Mapping[str, type[Signal]] = {
    entry.kind: entry for entry in (Constant, Step, Ramp, Sine, Coloured, VerticalGust)
}
"""Every signal by the name of its kind."""


def signal_from(values: Mapping[str, Any]) -> Signal:
    """Return the signal that a table describes: its `kind`, and the numbers of that kind; InputError names the key."""
    kind = str(values.get("kind", ""))
    check_name("signal", kind, SIGNALS, key="kind")
    allowed = [entry.name for entry in fields(SIGNALS[kind])]
    numbers = {key: value for key, value in values.items() if key != "kind"}
    for key, value in numbers.items():
        if key not in allowed:
            raise UnknownNameError("key", key, ["kind", *allowed], key=key)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"given {value!r}; allowed: a number", key=key)
    return SIGNALS[kind](**{key: float(value) for key, value in numbers.items()})
