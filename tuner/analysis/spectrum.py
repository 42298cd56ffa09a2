"""Spectra of what rotors and inputs are asked for: how much of a command is noise, and at which frequencies.

Power densities by Welch's method (P. D. Welch, IEEE Trans. Audio Electroacoust. 15(2), 1967), averaged over inputs and flights,
then over bands of equal width on a logarithmic axis.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.flown_system import FlightBackend, FlownSystem
from plant.backends.flyer import FlightInputs
from plant.records import rows

Array = NDArray[np.float64]

SEGMENT = 1.0
"""Length of the windowed segments [s]: the resolution is some 2 Hz."""
MAX_BANDS = 120
"""Bands of a spectrum at most."""
MIN_SEGMENT = 16
"""Fewest samples of a segment."""


class Spectrum(NamedTuple):
    """frequency (bands,) [Hz] and density (bands,) [1/sqrt(Hz)] of commands, counted as the metric `noise` counts them."""

    frequency: Array
    density: Array


def command_spectrum(system: FlownSystem, flyer: FlightBackend, gains: Array, inputs: FlightInputs) -> Spectrum | None:
    """Fly one candidate, gains (n,), and return the `spectrum` of its commands.

    Of flights that are completed, counted as the metric `noise` counts them.
    """
    flight = system.loop.Flight
    traced = np.r_[rows(flight, system.command), rows(flight, "status")]
    trace = flyer.trace(gains, system.nominal, inputs, 1, traced)
    is_complete = np.all(trace[..., -1] == 0.0, axis=1)
    return spectrum(trace[is_complete, :, :-1] / system.command_scales, system.timing.control_period)


def spectrum(commands: Array, h: float) -> Spectrum | None:
    """Return the spectrum of commands (flights, instants, inputs), h [s] apart; None of no flights, or of too short ones."""
    from scipy.signal import welch

    segment = min(commands.shape[1], round(SEGMENT / h))
    if not len(commands) or segment < MIN_SEGMENT:
        return None
    frequency, power = welch(commands, 1.0 / h, "hann", segment, detrend="constant", axis=1)
    mean = power.mean(axis=(0, 2))
    # The lowest frequency is the mean itself, the next one what is left of it behind the window.
    edges = np.geomspace(frequency[2], frequency[-1] * (1.0 + 1e-9), MAX_BANDS + 1)
    band = np.digitize(frequency[2:], edges)
    means = [
        [series[2:][band == number].mean(axis=0) for number in np.unique(band).tolist()] for series in (frequency, mean)
    ]
    return Spectrum(np.array(means[0]), np.sqrt(means[1]))
