"""Frequency responses of the logs next to those of the fitted model.

Measured is the response of body rate, or lift, to the motor commands of the axis. If the log has setpoints of the rates, they
are the instrument; without them feedback biases the estimate towards the inverse of the controller, the more the larger noise and
air are relative to the effect of the commands (Ljung, System Identification, 2nd ed., section 13.5).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.vehicle_fit.fit import Fit, Problem
from tuner.extensions.vehicle_fit.frequency_response import FrequencyResponse, Record, estimate_response
from tuner.extensions.vehicle_fit.model_response import axis_commands, model_response, response_deviation
from tuner.extensions.vehicle_fit.samples import OUTPUTS, LogSegment
from tuner.text.sentences import listing

Array = NDArray[np.float64]

N_SEGMENTS = 8.0
"""Segments of a log, whose lengths stay within the limits below."""
MIN_SEGMENT, MAX_SEGMENT = 1.0, 2.0
MAX_FREQUENCY = 100.0
"""Highest compared frequency [Hz]."""
MAX_RATE_SHARE = 0.4
"""Highest compared frequency as a share of the sampling rate."""
MIN_COHERENCE = 0.6
"""Coherence above which a response is compared (Tischler and Remple, Aircraft and Rotorcraft System Identification, 2nd ed.)."""
ABOVE_NOISE = 100.0
"""Power of an output over that of its sensor's noise, below which feedback of that noise biases a direct estimate by a tenth."""
ERROR_RATE = 0.05
"""Probability of a false alarm for an axis."""
MIN_DIFFERENCE = 0.115
"""Smallest difference that is named: 1 dB or 6.6 degrees."""
MIN_BAND = 3
"""Fewest frequencies in a row that are named."""
DECIBELS = 20.0 / np.log(10.0)


@dataclass(frozen=True, eq=False)
class ResponseComparison:
    """Measured and modeled response of an output.

    Attributes:
        output: Its name.
        has_instrument: Whether setpoints were the instrument.
        measured: From the logs.
        modeled (f,): From the fitted parameters.
        model_deviation: Standard deviations (f,) of its magnitude, relative, and of its phase [rad].
        trusted (f,): Mask of what can be compared.
    """

    output: str
    has_instrument: bool
    measured: FrequencyResponse
    modeled: NDArray[np.complex128]
    model_deviation: tuple[Array, Array]
    trusted: NDArray[np.bool_]

    @property
    def difference(self) -> NDArray[np.complex128]:
        """Logarithm (f,) of measured over modeled: relative difference of magnitudes, and of phases [rad]."""
        return np.log(self.measured.response / self.modeled)

    @property
    def band(self) -> slice | None:
        """Frequencies of the widest band of significant differences that are not small; None without one."""
        magnitude, phase = (np.hypot(self.measured.deviation, part) for part in self.model_deviation)
        off = self.difference
        bound = -2.0 * np.log(ERROR_RATE / max(np.count_nonzero(self.trusted), 1))
        significant = (off.real / magnitude) ** 2 + (off.imag / phase) ** 2 > bound
        bands = bands_of(self.trusted & significant & (np.abs(off) > MIN_DIFFERENCE))
        widest = max(bands, key=lambda band: band.stop - band.start, default=slice(0, 0))
        return widest if widest.stop - widest.start >= MIN_BAND else None


def bands_of(mask: NDArray[np.bool_]) -> list[slice]:
    """Return the bands of consecutive frequencies in which a mask (f,) holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int))).tolist()
    return [slice(begin, end) for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def compare_responses(fit: Fit, problem: Problem, noise: Sequence[float], rate: float) -> list[ResponseComparison]:
    """Compare the responses of all outputs that the fit uses.

    Args:
        fit: To the logs.
        problem: With their segments.
        noise: RMS of the white noise of the outputs' sensors.
        rate: Least sampling rate of the logs [Hz]; the grid of the segments may be finer.
    """
    samples, vehicle = problem.samples, problem.vehicle
    total = sum(len(part.lift) * part.period for part in samples)
    length = float(np.clip(total / N_SEGMENTS, MIN_SEGMENT, MAX_SEGMENT))
    period = max(part.period for part in samples)
    commands = [axis_commands(vehicle, part.command) for part in samples]
    center = float(np.mean(np.concatenate([part.command for part in samples])))
    estimates: dict[int, tuple[bool, FrequencyResponse]] = {}
    for k in np.flatnonzero(problem.outputs).tolist():
        has_instrument = k < 3 and all(part.setpoint is not None and np.ptp(part.setpoint[:, k]) for part in samples)
        records = [_record(part, mixed[:, k], k, has_instrument) for part, mixed in zip(samples, commands, strict=True)]
        measured = estimate_response(records, length, min(MAX_FREQUENCY, MAX_RATE_SHARE * rate))
        if measured is not None:
            estimates[k] = (has_instrument, measured)
    if not estimates:
        return []
    # Records of all outputs are as long, so their frequencies are the same.
    frequency = next(iter(estimates.values()))[1].frequency
    setting = (vehicle, center, frequency, period)
    magnitude, phase = response_deviation(fit.space, fit.estimate, fit.covariance, setting)
    modeled = model_response(fit.space.numbers(fit.estimate), *setting)
    compared = []
    for k, (has_instrument, measured) in estimates.items():
        trusted = (measured.coherence >= MIN_COHERENCE) & ~measured.leaks
        if not has_instrument:
            trusted &= measured.output_power > ABOVE_NOISE * 2.0 / rate * noise[k] ** 2
        deviation = (magnitude[:, k], phase[:, k])
        compared.append(ResponseComparison(OUTPUTS[k], has_instrument, measured, modeled[:, k], deviation, trusted))
    return compared


def _record(part: LogSegment, command: Array, k: int, has_instrument: bool) -> Record:
    output = part.lift if k == 3 else part.gyro[:, k]
    instrument = part.setpoint[:, k] if has_instrument and part.setpoint is not None else command
    return Record(part.period, command, output, instrument, integrates=k < 3)


def difference_words(compared: Sequence[ResponseComparison]) -> list[str]:
    """Return sentences on outputs whose responses differ, and on all others."""
    words = [_difference(entry, entry.band) for entry in compared if entry.band is not None]
    agreed = [entry.output for entry in compared if entry.trusted.any() and entry.band is None]
    if agreed:
        words.append(f"The model agrees with the frequency response of {listing(agreed)} where the logs show it.")
    return words


def _difference(entry: ResponseComparison, band: slice) -> str:
    frequency, off = entry.measured.frequency[band], entry.difference[band]
    worst = off[np.argmax(np.abs(off))]
    reason = "" if entry.has_instrument else "; without an instrument, feedback of noise and air may be the reason too"
    return (
        f"The frequency response of {entry.output} differs from the model from {frequency[0]:.2g} to {frequency[-1]:.2g} Hz, "
        f"by up to {DECIBELS * worst.real:+.1f} dB and {np.degrees(worst.imag):+.0f} degrees{reason}."
    )
