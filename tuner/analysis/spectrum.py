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
BANDS = 120


class Spectrum(NamedTuple):
    """frequency (bands,) [Hz] and density (bands,) [1/sqrt(Hz)] of commands, counted as the metric `noise` counts them."""

    frequency: Array
    density: Array


def command_spectrum(system: Any, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Spectrum:
    """Fly one candidate, gains (n,), through the scenarios and return the spectrum of its commands."""
    return spectrum(commands_of(system, flyer, gains, inputs), system.timing.control_period)


@singledispatch
def commands_of(system: Any, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    """Return the commands (flights, instants, inputs) of a candidate, counted as the metric `noise` counts them."""
    raise TypeError(f"nothing records the commands of {type(system).__name__}")


@commands_of.register
def _(system: System, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    traced = rows(flyer.loop.Flight, "pending")
    return flyer.trace(gains, system.nominal, inputs, 1, np.r_[traced]) / system.nominal.hover


@commands_of.register
def _(system: PlantSystem, flyer: Flyer, gains: Array, inputs: FlightInputs) -> Array:
    traced = rows(flyer.loop.Flight, "control.command")
    return flyer.trace(gains, system.nominal, inputs, 1, np.r_[traced]) / np.array(list(system.plan.scales.values()))


def spectrum(commands: Array, h: float) -> Spectrum:
    """Return the spectrum of commands (flights, instants, inputs), h [s] apart; flights that are not known are left out."""
    from scipy.signal import welch

    known = commands[np.isfinite(commands).all(axis=(1, 2))]
    segment = min(known.shape[1], max(round(SEGMENT / h), 8))
    frequency, power = welch(known, 1.0 / h, "hann", segment, detrend="constant", axis=1)
    mean = power.mean(axis=(0, 2))
    # The lowest frequency is the mean itself, the next one what is left of it behind the window.
    edges = np.geomspace(frequency[2], frequency[-1] * (1.0 + 1e-9), BANDS + 1)
    band = np.digitize(frequency[2:], edges)
    bands = np.unique(band)
    means = [[series[2:][band == number].mean(axis=0) for number in bands.tolist()] for series in (frequency, mean)]
    return Spectrum(np.array(means[0]), np.sqrt(means[1]))
