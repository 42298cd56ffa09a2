"""Frequency responses by averaged cross spectra, with coherence and intervals.

Records are cut into segments under a Hann window that overlap by half (Welch, IEEE Trans. Audio Electroacoust. 15, 1967). With
transforms u, y and r of input, output and instrument, H = S_ry / S_ru; without an instrument r = u, and H = S_uy / S_uu. Its
relative deviation is sqrt(S_ee S_rr / (2 n)) / |H S_ru|, where e = y - H u and n counts independent segments; for r = u that is
sqrt((1 - C) / (2 n C)) with the coherence C (Bendat and Piersol, Random Data, 4th ed., section 9.1). An instrument that no noise
of the loop enters, such as a chirp, gives the response inside a feedback without bias (Ljung, System Identification, 13.4).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

OVERLAP_CORRELATION = 1.0 / 36.0
"""Correlation of the spectra of neighboring segments under a Hann window."""
CONFIDENCE = 0.975
"""Quantile of a two-sided interval of 95 %."""
MIN_AVERAGES = 3.0
"""Fewest independent segments that have an interval."""

TINY = 1e-300
LEAKAGE_REACH = 6
"""Reach of the window's leakage in steps of frequency."""
LEAKAGE_SHARE = 0.01
"""Leakage as a share of the power of the strongest neighbor."""


class Record(NamedTuple):
    """Sampling period [s], and input, output and instrument (n,) of a record.

    integrates: the output integrates what the input does. It is taken by its differences then, for where it stands as a segment
    begins would leak into all of its low frequencies.
    """

    period: float
    input: Array
    output: Array
    instrument: Array
    integrates: bool = False


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """An estimated response.

    Attributes:
        frequency (f,): [Hz].
        response (f,): Complex, output per input.
        coherence (f,): Coherence of instrument and output, 0 to 1.
        deviation (f,): Relative standard deviation; that of the phase in radians as well.
        output_power (f,): One-sided power density of the output.
        leaks (f,): Mask where the instrument has no power but what leaks from its neighbors.
        averages: Independent segments.
    """

    frequency: Array
    response: ComplexArray
    coherence: Array
    deviation: Array
    output_power: Array
    leaks: NDArray[np.bool_]
    averages: float

    @property
    def half_width(self) -> Array:
        """Half of the 95 % interval (f,): relative, and of the phase [rad]."""
        return float(stdtrit(2.0 * (self.averages - 1.0), CONFIDENCE)) * self.deviation


def estimate_response(records: Sequence[Record], length: float, highest: float) -> FrequencyResponse | None:
    """Estimate the response of all records together; None where they have too few segments.

    Args:
        records: Records of one system.
        length: Length of a segment [s].
        highest: Frequency [Hz] of the last value, at most.
    """
    pieces = [transforms for record in records if (transforms := _transforms(record, length, highest)) is not None]
    count = sum(len(piece[0]) for piece in pieces)
    averages = count / (1.0 + 2.0 * OVERLAP_CORRELATION * (count - len(pieces)) / max(count, 1))
    if averages < MIN_AVERAGES:
        return None
    last = min(piece.shape[-1] for piece in pieces)
    u, y, r = np.concatenate([piece[..., :last] for piece in pieces], axis=1)
    s_ru, s_ry, s_uy = _cross(r, u), _cross(r, y), _cross(u, y)
    s_rr, s_uu, s_yy = (_cross(x, x).real for x in (r, u, y))
    response = s_ry / (s_ru + TINY)
    residual = s_yy - 2.0 * (response.conj() * s_uy).real + np.abs(response) ** 2 * s_uu
    variance = np.maximum(residual, 0.0) * s_rr / (2.0 * (averages - 1.0))
    return FrequencyResponse(
        np.arange(1.0, last + 1.0) / length,
        response,
        np.abs(s_ry) ** 2 / (s_rr * s_yy + TINY),
        np.sqrt(variance) / (np.abs(response * s_ru) + TINY),
        s_yy,
        _leaks(s_rr),
        averages,
    )


def _transforms(record: Record, length: float, highest: float) -> ComplexArray | None:
    """Return scaled transforms (3, segments, f) of input, output and instrument, without the mean; None where it is short."""
    width = round(length / record.period)
    if len(record.input) < width or width < 8:
        return None
    last = min(int(highest * length), (width - 1) // 2)
    series = np.stack([record.input, record.output, record.instrument])
    if record.integrates:
        series = np.stack([record.input[1:-1], 0.5 * (record.output[2:] - record.output[:-2]), record.instrument[1:-1]])
    starts = np.arange(0, series.shape[1] - width + 1, width // 2)
    segments = series[:, starts[:, None] + np.arange(width)]
    window = np.hanning(width + 1)[:-1]
    scale = np.sqrt(2.0 * record.period / np.sum(window**2))
    transforms = scale * np.fft.rfft(window * (segments - segments.mean(axis=-1, keepdims=True)))[..., 1 : last + 1]
    if record.integrates:
        transforms[1] /= 1j * np.sin(2.0 * np.pi * np.arange(1, last + 1) / width)
    return transforms


def _cross(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    return np.mean(a.conj() * b, axis=0)


def _leaks(power: Array) -> NDArray[np.bool_]:
    """Return the mask (f,) of a power density below leakage of its neighbors."""
    padded = np.pad(power, LEAKAGE_REACH)
    return power < LEAKAGE_SHARE * np.lib.stride_tricks.sliding_window_view(padded, 2 * LEAKAGE_REACH + 1).max(axis=1)
