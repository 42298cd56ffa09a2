"""Spectra of what rotors and inputs are asked for: how much of a command is noise, and at which frequencies.

Power densities by Welch's method (P. D. Welch, IEEE Trans. Audio Electroacoust. 15(2), 1967), averaged over inputs and flights,
then over bands of equal width on a logarithmic axis.
"""

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.plant_system import PlantSystem
from objectives.system import System
from plant.backends.flyer import FlightInputs, Flyer
from plant.records import rows

Array = NDArray[np.float64]

SEGMENT = 1.0
"""Length of the windowed segments [s]: frequencies are told apart to some 2 Hz."""
BANDS, LEAST = 120, 16
"""Bands at most, and the fewest samples of a segment."""


class Spectrum(NamedTuple):
    """frequency (bands,) [Hz] and density (bands,) [1/sqrt(Hz)] of commands, counted as the metric `noise` counts them."""

    frequency: Array
    density: Array


def command_spectrum(system: Any, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Spectrum | None:
    """Fly one candidate, gains (n,), through the scenarios and return the spectrum of its commands, as `spectrum` does."""
    return spectrum(commands_of(system, flyer, gains, inputs), system.timing.control_period)


@singledispatch
def commands_of(system: Any, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    """Return the commands (flights, instants, inputs) of the flights that are completed, as the metric `noise` counts them."""
    raise TypeError(f"nothing records the commands of {type(system).__name__}")


@commands_of.register
def _(system: System, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    return _recorded(flyer, gains, system.nominal, inputs, "pending") / system.nominal.hover


@commands_of.register
def _(system: PlantSystem, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    scales = np.array(list(system.plan.scales.values()))
    return _recorded(flyer, gains, system.nominal, inputs, "control.command") / scales


def _recorded(flyer: Flyer, gains: Array, nominal: Any, inputs: FlightInputs, path: str) -> Array:
    """Return a part of the flight at every instant (flights, instants, rows), of the flights that are completed."""
    flight = flyer.loop.Flight
    trace = flyer.trace(gains, nominal, inputs, 1, np.r_[rows(flight, path), rows(flight, "status")])
    return trace[np.all(trace[..., -1] == 0.0, axis=1), :, :-1]


def spectrum(commands: Array, h: float) -> Spectrum | None:
    """Return the spectrum of commands (flights, instants, inputs), h [s] apart; None of no flights, or of too short ones."""
    from scipy.signal import welch

    segment = min(commands.shape[1], round(SEGMENT / h))
    if not len(commands) or segment < LEAST:
        return None
    frequency, power = welch(commands, 1.0 / h, "hann", segment, detrend="constant", axis=1)
    mean = power.mean(axis=(0, 2))
    # The lowest frequency is the mean itself, the next one what is left of it behind the window.
    edges = np.geomspace(frequency[2], frequency[-1] * (1.0 + 1e-9), BANDS + 1)
    band = np.digitize(frequency[2:], edges)
    means = [
        [series[2:][band == number].mean(axis=0) for number in np.unique(band).tolist()] for series in (frequency, mean)
    ]
    return Spectrum(np.array(means[0]), np.sqrt(means[1]))
