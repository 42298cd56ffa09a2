"""Excitations of single axes, and the reference of their flight.

A chirp dwells at its first frequency, then sweeps exponentially to its last; doublets are the signs of a chirp, throttle steps
those of a sine. Exponential sweeps are what ArduPilot's SYSTEMID mode and Betaflight's CHIRP mode fly.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.references.spec import HOLD, PITCH, ROLL, YAW, YAW_RATE, blank

Array = NDArray[np.float64]

AXES = ("roll", "pitch", "yaw", "lift")
UNITS = {"angle": "rad", "rate": "rad/s", "acceleration": "m/s2"}
"""Excited quantity -> unit of its amplitude."""
WAVES = ("chirp", "doublets", "steps")
LEAD, PAUSE, TAIL = 3.0, 2.0, 2.0
"""Hover before the first excitation, between two, and after the last [s]."""
LAG_CORNER, LEAD_CORNER = 3.0, 30.0
"""Corners of the filter that lowers amplitudes at high frequencies [Hz].

They are those of Betaflight's chirp (`chirp_lag_freq_hz`, `chirp_lead_freq_hz`): up to some 30 Hz a rate loop differentiates its
set point, so that commands of a level chirp grow with the frequency (betaflight/betaflight, pull request 13105).
"""
_ANGLES = {"roll": ROLL, "pitch": PITCH, "yaw": YAW}


class Shape(NamedTuple):
    """Envelope of an excitation.

    Attributes:
        dwell: Periods at the first frequency.
        fade_in, fade_out: Fades [s].
        cosine: True if it begins at its top.
        lag, lead: Corners [Hz] of a lag-lead filter, between which the amplitude falls with the frequency; equal for none.
    """

    dwell: float = 2.0
    fade_in: float = 1.0
    fade_out: float = 0.5
    cosine: bool = False
    lag: float = 1.0
    lead: float = 1.0

    def share(self, frequency: Array) -> Array:
        """Return the share of the amplitude at frequencies (n,) [Hz]."""
        return np.sqrt((1.0 + (frequency / self.lead) ** 2) / (1.0 + (frequency / self.lag) ** 2))


@dataclass(frozen=True)
class Excitation:
    """An excitation of one axis.

    Attributes:
        axis: One of `AXES`.
        quantity: Excited quantity of the axis, one of `UNITS`.
        amplitude: Amplitude in the unit of the quantity.
        first, last: Frequencies [Hz].
        duration: Total time, dwell and fades included [s].
        wave: One of `WAVES`.
    """

    axis: str
    quantity: str
    amplitude: float
    first: float
    last: float
    duration: float
    wave: str = "chirp"
    shape: Shape = Shape()

    def values(self, time: Array) -> Array:
        """Return the excitation at two or more times from its begin (n,) [s]; zero outside."""
        phase = self._phase(time) + (0.5 * np.pi if self.shape.cosine else 0.0)
        wave = np.sin(phase) if self.wave == "chirp" else _mean_sign(phase)
        return self.amplitude * self.envelope(time) * self.shape.share(self._frequency(time)) * wave

    @property
    def angle(self) -> float:
        """Largest angle that is asked for [rad]; 0 of a lift."""
        return {"angle": self.amplitude, "rate": self.amplitude / (2.0 * np.pi * self.first)}.get(self.quantity, 0.0)

    def envelope(self, time: Array) -> Array:
        """Return the share of the amplitude that is in force (n,): it fades in and out, and is zero before and after."""
        inside = (time >= 0.0) & (time <= self.duration)
        return inside * _faded(time, self.shape.fade_in) * _faded(self.duration - time, self.shape.fade_out)

    def _frequency(self, time: Array) -> Array:
        """Return the frequency (n,) [Hz]."""
        dwell = self.shape.dwell / self.first
        sweep = self.duration - dwell
        return self.first * (self.last / self.first) ** (np.clip(time - dwell, 0.0, sweep) / sweep)

    def _phase(self, time: Array) -> Array:
        begin = 2.0 * np.pi * self.first
        dwell = self.shape.dwell / self.first
        sweep, growth = self.duration - dwell, np.log(self.last / self.first)
        late = np.clip(time - dwell, 0.0, sweep)
        swept = late if self.first == self.last else sweep / growth * np.expm1(growth * late / sweep)
        return np.where(time < dwell, begin * (time - dwell), begin * swept)


def _mean_sign(phase: Array) -> Array:
    """Return the mean sign (n,) of the sine over each sample.

    Signs at the samples themselves would be late by up to a sample, and the climb that is their integral would wander.
    """
    middle = 0.5 * (phase[1:] + phase[:-1])
    edges = np.concatenate([[2.0 * phase[0] - middle[0]], middle, [2.0 * phase[-1] - middle[-1]]])
    width, area = np.diff(edges), np.diff(np.arccos(np.cos(edges)))
    return np.divide(area, width, out=np.copysign(1.0, np.sin(phase)), where=width > 0.0)


def halved(excitations: Sequence[Excitation]) -> list[Excitation]:
    """Return the excitations with half the amplitude."""
    return [replace(entry, amplitude=0.5 * entry.amplitude) for entry in excitations]


def _faded(time: Array, fade: float) -> Array:
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(time / fade, 0.0, 1.0)) if fade > 0.0 else np.ones_like(time)


def begins(excitations: Sequence[Excitation]) -> list[float]:
    """Return the begins of the excitations of a flight [s]."""
    lengths = [entry.duration + PAUSE for entry in excitations]
    return [LEAD + sum(lengths[:k]) for k in range(len(lengths))]


def length_of(excitations: Sequence[Excitation]) -> float:
    """Return the length of a flight through all excitations [s]."""
    return LEAD + sum(entry.duration + PAUSE for entry in excitations) + TAIL


def references(excitations: Sequence[Excitation], period: float) -> Array:
    """Return the reference (steps, 14) of an attitude-mode flight through excitations; period [s]."""
    samples = blank(round(length_of(excitations) / period))
    samples[:, HOLD] = 0.0
    for entry, begin in zip(excitations, begins(excitations), strict=True):
        _excite(samples, entry, begin, period)
    return samples


def _excite(samples: Array, entry: Excitation, begin: float, period: float) -> None:
    """Add an excitation that begins at a time [s] to a reference."""
    time = period * np.arange(float(len(samples))) - begin
    values = entry.values(time)
    if entry.axis == "lift":
        climb = _centred(np.cumsum(values) * period, entry.envelope(time))
        samples[:, 2] += np.cumsum(climb) * period
        samples[:, 5] += climb
        samples[:, 8] += values
        return
    angle = values if entry.quantity == "angle" else np.cumsum(values) * period
    samples[:, _ANGLES[entry.axis]] += angle
    if entry.axis == "yaw":
        samples[:, YAW_RATE] += values if entry.quantity == "rate" else np.gradient(angle, period)


def _centred(series: Array, envelope: Array) -> Array:
    """Return a series (n,) about its mean inside an envelope, and zero outside."""
    return envelope * (series - np.sum(envelope * series) / np.sum(envelope))
