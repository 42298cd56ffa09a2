"""The plant of each axis from a flight log: acceleration gain, motor lag, dead time, and the zero of yaw, with intervals.

In a closed loop output u and rate y share the noise, and the setpoint r, a chirp or sticks, is an instrument: with transforms R,
U, Y of their differences and the response G of the plant behind the gyro's filters, the sums over a band of frequencies

    Z_b = sum conj(R) (Y - G U),    var Z_b = S_n sum |R|^2

have the mean 0 at the true plant (L. Ljung, System Identification, 2nd ed., section 7.6). S_n is the mean of |Y - G U|^2 in the
band. Weighted least squares give the numbers, their slopes the intervals. The output is the
mix of the motors in the log, so it holds what the mixer made of it. Sticks move little above a few hertz: then the lag has a
wide interval, and the axis is refused.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as student

from plant.errors import InputError
from plant.laws.filters import stage_share
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling, plant_response, stage_response
from tuner.extensions.betaflight_adrc.settings import AXES
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.logs.reading import read_log

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MIX = np.array([[1.0, -1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0]])
"""Signs of the motors (front left, front right, rear left, rear right) by axis, of the mixer QUADX."""
FULL_RANGE = 1000.0
"""Units of output for the whole range of a motor."""
MIN_DURATION = 8.0
"""Shortest log [s]."""
MIN_RATE = 400.0
"""Lowest rate of a log [Hz]."""
BAND_ENDS = (1.5, 100.0)
"""Lowest and highest frequency of the bands [Hz]."""
MAX_SHARE = 0.3
"""Highest frequency over the rate of the log."""
N_BANDS, MIN_BINS, N_ROUNDS = 32, 6, 4
STARTS = tuple((lag, delay) for lag in (0.01, 0.02, 0.04) for delay in (0.001, 0.003))
"""Motor lags and dead times from which a search starts [s]."""
START_ZERO, MAX_LOG_GAIN = 0.1, 20.0
BOUNDS = ((1e-3, 0.2), (0.0, 0.03), (1e-3, 3.0))
"""Ranges of lag, dead time and zero [s]."""
TAPER_SHARE = 0.02
MAX_HALF_WIDTH = 0.3
"""Half-width of a relative interval, beyond which an axis is not identified."""
SLOPES = {
    "roll": {"acceleration gain": (1.0, 0.0, 0.0), "motor lag": (0.0, 1.0, 0.0)},
    "pitch": {"acceleration gain": (1.0, 0.0, 0.0), "motor lag": (0.0, 1.0, 0.0)},
    "yaw": {"gain above its zero": (1.0, -1.0, 0.0, 1.0)},
}
"""Axis -> numbers that decide where it rings, as sums of the parameters: yaw rings far above its zero."""
STEPS = np.array([1.0, 1.0, 1e-3, 1.0])
"""Scales of the parameters."""
MIN_DEVIATION = 1e-9
"""Lower limit of a deviation, for bands that nothing moves."""
MIN_COHERENCE = 0.5
"""Coherence of output and setpoint from which a band counts as excited."""


@dataclass(frozen=True)
class IdentifiedAxis:
    """The plant of an axis with 95 % intervals.

    Attributes:
        plant: Plant at the collective of the log.
        intervals: Intervals of gain [deg/s2], lag, dead_time and zero [s], and b0 [deg/s3]; a zero has yaw alone.
        excited: Highest frequency of the bands with an excited output [Hz].
        reason: Sentence on an axis that is not identified, "" otherwise.
    """

    plant: AxisPlant
    intervals: dict[str, tuple[float, float]]
    excited: float
    reason: str


@dataclass(frozen=True)
class Bands:
    """Transforms of a log on the frequencies of its bands.

    Attributes:
        frequency: Frequencies [Hz].
        r, u, y: Transforms of the differences of setpoint, output and rate.
        begins: Places at which the bands begin.
    """

    frequency: Array
    r: ComplexArray
    u: ComplexArray
    y: ComplexArray
    begins: NDArray[np.int64]

    def sums(self, values: ComplexArray | Array) -> ComplexArray:
        """Return the sums over each band."""
        return np.add.reduceat(np.asarray(values, dtype=np.complex128), self.begins)


def identify_axes(path: Path, sampling: Sampling) -> dict[str, IdentifiedAxis]:
    """Return the axes of a log, identified or refused; raises InputError for a log that shows none."""
    log = read_log(path)
    if log.setpoint is None:
        raise InputError("holds no rate setpoints; log setpoint[0] to setpoint[2]", file=path)
    if log.rate < MIN_RATE or log.duration < MIN_DURATION:
        given = f"holds {log.duration:.1f} s at {log.rate:.0f} Hz"
        raise InputError(f"{given}; give a log of {MIN_DURATION:g} s or more at {MIN_RATE:.0f} Hz or more", file=path)
    return {axis: identify_axis(log, axis, sampling) for axis in AXES}


def bands_of(log: FlightLog, axis: str) -> Bands:
    """Return the transforms of an axis."""
    k = AXES.index(axis)
    setpoint = np.zeros_like(log.gyro) if log.setpoint is None else log.setpoint
    signals = np.column_stack(
        [np.degrees(setpoint[:, k]), FULL_RANGE * log.command @ MIX[k] / 4.0, np.degrees(log.gyro[:, k])]
    )
    moving = np.diff(signals, axis=0)
    spectra = np.fft.rfft(moving * taper(len(moving))[:, None], axis=0)
    frequency = np.asarray(np.fft.rfftfreq(len(moving), log.period), dtype=np.float64)
    high = min(BAND_ENDS[1], MAX_SHARE * log.rate)
    edges = np.searchsorted(frequency, np.geomspace(BAND_ENDS[0], high, N_BANDS + 1))
    begins = [int(edges[0])]
    for edge in edges[1:-1]:
        if edge - begins[-1] >= MIN_BINS:
            begins.append(int(edge))
    rows = slice(begins[0], int(edges[-1]))
    r, u, y = spectra[rows].T
    return Bands(np.asarray(frequency[rows], dtype=np.float64), r, u, y, np.array(begins) - begins[0])


def taper(n: int) -> Array:
    """Return a window that rises and falls at the ends alone.

    A longer one tilts the phase of a chirp, whose frequencies pass one after the other.
    """
    rise = max(round(TAPER_SHARE * n), 1)
    window = np.ones(n)
    window[:rise] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(rise) + 0.5) / rise)
    window[-rise:] = window[:rise][::-1]
    return window


def identify_axis(log: FlightLog, axis: str, sampling: Sampling) -> IdentifiedAxis:
    """Return the plant of an axis; its reason says why it is not identified."""
    bands = bands_of(log, axis)
    fit = _fitted(bands, _filters(bands.frequency, sampling), sampling.period, axis)
    plant, quantile = _plant(fit.x), float(student.ppf(0.975, fit.degrees))
    half = quantile * np.sqrt(np.diag(fit.covariance))
    # The instants of gyro and motors within a loop are not in the log.
    half[2] = np.hypot(half[2], 0.5 * sampling.period)
    slope = np.zeros(len(fit.x))
    slope[:2] = 1.0, -1.0
    of_b0 = quantile * float(np.sqrt(slope @ fit.covariance @ slope))
    intervals = {
        "gain": _around(plant.gain, half[0]),
        "lag": _around(plant.lag, half[1]),
        "dead_time": (plant.dead_time - float(half[2]), plant.dead_time + float(half[2])),
        "b0": _around(plant.b0, of_b0),
    }
    if axis == "yaw":
        intervals["zero"] = _around(plant.zero, half[3])
    return IdentifiedAxis(plant, intervals, _excited(bands), _reason(axis, fit, quantile))


class Fit(NamedTuple):
    """Logarithms of gain and lag, dead time, logarithm of the zero; covariance, and degrees of freedom."""

    x: Array
    covariance: Array
    degrees: float


@dataclass(frozen=True)
class _Criterion:
    """Weighted sums Z_b of an axis as a function of its parameters.

    Attributes:
        bands: Transforms of the log.
        filters: Response of the gyro's filters.
        z: Points of the loop's rate.
        period: Period of the loop [s].
        sign: Sense of the axis, 1 or -1.
        n: Number of parameters.
    """

    bands: Bands
    filters: ComplexArray
    z: ComplexArray
    period: float
    sign: float
    n: int

    def noise(self, x: Array) -> ComplexArray:
        """Return Y - G U."""
        return self.bands.y - self.modeled(x)

    def modeled(self, x: Array) -> ComplexArray:
        """Return G U."""
        return self.sign * self.filters * plant_response(_plant(x), self.z, self.period) * self.bands.u

    def instrumented(self, signal: ComplexArray) -> ComplexArray:
        """Return the sums of conj(R) times a signal."""
        return self.bands.sums(np.conj(self.bands.r) * signal)

    def deviations(self, noise: ComplexArray) -> Array:
        """Return the standard deviations of the parts of Z_b."""
        count = self.bands.sums(np.ones(len(self.bands.frequency)))
        level, power = (np.real(self.bands.sums(np.abs(each) ** 2)) for each in (noise, self.bands.r))
        return np.sqrt(0.5 * level / np.real(count) * power) + MIN_DEVIATION

    def errors(self, x: Array, scale: Array) -> Array:
        """Return the real and imaginary parts of Z_b over their deviations."""
        sums = self.instrumented(self.noise(x)) / scale
        return np.concatenate([np.real(sums), np.imag(sums)])

    def start(self, lag: float, delay: float) -> Array:
        """Return parameters with a lag, a dead time and the best gain."""
        x = np.array([0.0, np.log(lag), delay, np.log(START_ZERO)])[: self.n]
        unit, measured = (np.sum(np.abs(self.instrumented(each))) for each in (self.modeled(x), self.bands.y))
        x[0] = np.clip(
            np.log(max(float(measured), 1e-12) / max(float(unit), 1e-12)), 1.0 - MAX_LOG_GAIN, MAX_LOG_GAIN - 1.0
        )
        return x

    def polished(self, x: Array) -> tuple[float, Array, Array]:
        """Return the likelihood's loss, the parameters and the slopes of a minimum."""
        (lag, delay, zero) = BOUNDS
        low = np.array([-MAX_LOG_GAIN, np.log(lag[0]), delay[0], np.log(zero[0])])[: self.n]
        high = np.array([MAX_LOG_GAIN, np.log(lag[1]), delay[1], np.log(zero[1])])[: self.n]
        scale, slopes = self.deviations(self.bands.y), np.zeros((1, self.n))
        for _ in range(N_ROUNDS):
            fit = least_squares(self.errors, x, args=(scale,), bounds=(low, high), x_scale=STEPS[: self.n])
            x, slopes, scale = fit.x, fit.jac, self.deviations(self.noise(fit.x))
        # Errors have unit variance, so the level of the noise counts as in a likelihood.
        return float(np.sum(self.errors(x, scale) ** 2) + 4.0 * np.sum(np.log(scale))), x, slopes


def _fitted(bands: Bands, filters: ComplexArray, period: float, axis: str) -> Fit:
    """Return the best fit of all starts."""
    z = np.asarray(np.exp(2j * np.pi * bands.frequency * period))
    n = 4 if axis == "yaw" else 3
    # The sense of yaw is that of the propellers, which a log does not name.
    criteria = [_Criterion(bands, filters, z, period, sign, n) for sign in ((1.0, -1.0) if axis == "yaw" else (1.0,))]
    fits = [each.polished(each.start(lag, delay)) for each in criteria for lag, delay in STARTS]
    _, x, slopes = min(fits, key=lambda fit: fit[0])
    return Fit(
        x, np.asarray(np.linalg.pinv(slopes.T @ slopes), dtype=np.float64), max(2.0 * len(bands.begins) - n, 1.0)
    )


def _plant(x: Array) -> AxisPlant:
    """Return the plant of parameters: logarithms, but for the dead time."""
    zero = float(np.exp(x[3])) if len(x) > 3 else 0.0
    return AxisPlant(float(np.exp(x[0])), float(np.exp(x[1])), float(x[2]), zero)


def _filters(frequency: Array, sampling: Sampling) -> ComplexArray:
    z = np.asarray(np.exp(2j * np.pi * frequency * sampling.gyro_period))
    response = np.ones_like(z)
    for cutoff in sampling.cutoffs:
        response = response * stage_response(stage_share(cutoff, sampling.gyro_period), z)
    return response


def _excited(bands: Bands) -> float:
    """Return the highest frequency at which the setpoint moves the output [Hz]."""
    cross = np.abs(bands.sums(np.conj(bands.r) * bands.u)) ** 2
    power = np.real(bands.sums(np.abs(bands.r) ** 2)) * np.real(bands.sums(np.abs(bands.u) ** 2))
    excited = np.flatnonzero(cross > MIN_COHERENCE * power)
    ends = np.append(bands.frequency[bands.begins[1:] - 1], bands.frequency[-1])
    return float(ends[excited[-1]]) if len(excited) else 0.0


def _around(value: float, half: float) -> tuple[float, float]:
    """Return the interval of a number; half: half-width of its logarithm."""
    factor = float(np.exp(min(half, 20.0)))
    return value / factor, value * factor


def _reason(axis: str, fit: Fit, quantile: float) -> str:
    """Return the sentence on a number that is not identified, or ""."""
    for name, slope in SLOPES[axis].items():
        width = quantile * float(np.sqrt(np.array(slope) @ fit.covariance @ np.array(slope)))
        if not width <= MAX_HALF_WIDTH:
            shown = f"+-{100.0 * width:.0f} %" if width < 5.0 else "without bound"
            return f"{axis}: the {name} is not identified ({shown}); fly a chirp on this axis."
    return ""
