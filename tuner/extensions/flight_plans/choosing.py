"""Bands, amplitudes and durations of excitations: greedy D-optimal input design.

Amplitudes are as large as the limits allow. The band of each axis is the most informative one for the accuracy target. Durations
grow, axis by axis, where a second more is most informative, until the target is met (Goodwin and Payne, Dynamic System
Identification, 1977, chapter 6).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes import Airframe
from tuner.extensions.flight_plans.excitation import Excitation, Shape, length_of
from tuner.extensions.flight_plans.expected_accuracy import (
    OutputPower,
    identifiable_parameters,
    information_of,
    output_power,
    problem_of,
)
from tuner.extensions.flight_plans.flying import FLIGHTS, SimulatedVehicle
from tuner.extensions.vehicle_fit.fit import cramer_rao_covariance
from tuner.extensions.vehicle_fit.identifiability import EXPLAINED, OF_OUTPUT
from tuner.extensions.vehicle_fit.parameters import ParameterSpace

Array = NDArray[np.float64]

BANDS = ((0.5, 4.0), (1.0, 6.0), (1.0, 12.0), (2.0, 20.0))
"""First and last frequencies that are tried [Hz]."""
STEPS = ((0.5, 0.5), (1.0, 1.0))
"""Frequencies of throttle steps that are tried [Hz]: a pilot keeps time with one or two steps a second."""
SQUARE = Shape(dwell=0.0, fade_in=0.0, fade_out=0.0, cosine=True)
"""Shape of throttle steps."""
TRIAL_LENGTH = 8.0
"""Length of the excitations that compare bands [s]."""
STREAM = "experiment"
"""Name of the streams of their air."""
MIN_LENGTH, LENGTH_STEP, DEFAULT_LENGTH, MAX_LENGTH = 12.0, 2.0, 20.0, 60.0
"""Shortest excitation, what it grows by, the longest where no number is named, and the longest of all [s].

The width of an interval comes from scores of blocks of 0.2 s: of 60 blocks it is right to 9 %, 1 / sqrt(2 n).
"""
MARGIN = 0.9
"""Share of a limit that excitations are made for."""
LIFT = 5.0
"""Largest acceleration along z that is asked for [m/s2]: half of gravity, so that the rotors keep half of their thrust."""
MAX_TRIALS = 6
"""Flights of the search for an amplitude."""
LIMIT_MARGIN = 1.05
"""Factor to the nearest limit at which the search for an amplitude ends."""
FIRST_TRY = {"angle": 0.1, "rate": 0.5, "acceleration": 2.0}
"""Amplitudes that are flown first [rad, rad/s, m/s2]."""
RESOLUTION = {"angle": np.radians(0.1), "rate": np.radians(1.0), "acceleration": 0.05}
"""Steps of amplitudes [rad, rad/s, m/s2]: targets take no finer ones, and a pilot reads them."""
SPARE = 0.05
"""Spare share of an output's variance that is explained, above the least that identification believes."""
LONGER = (1.5, 2.0, 3.0, 4.0, 6.0)
"""Factors on a length that are tried next to the step: an output may count from some length on only."""
ENOUGH = 0.1
"""Weight of intervals within their target, relative to those above it."""


@dataclass(frozen=True)
class TargetCapabilities:
    """Excitations that an export target can fly.

    Attributes:
        quantities: Axis -> excited quantity.
        waves: Waves of the target.
        lift_waves: Waves of its lift.
        shape: Shape of its chirps.
        alike: True if band and length of all axes but the lift are the same.
        least: Lowest frequency [Hz].
    """

    quantities: Mapping[str, str]
    waves: tuple[str, ...] = ("chirp",)
    lift_waves: tuple[str, ...] = ("chirp",)
    shape: Shape = Shape()
    alike: bool = False
    least: float = 0.0

    @property
    def groups(self) -> list[tuple[str, ...]]:
        """Axes whose band and length are one choice."""
        alike = tuple(axis for axis in self.quantities if self.alike and axis != "lift")
        return [axes for axes in (alike, *[(axis,) for axis in self.quantities if axis not in alike]) if axes]

    def shapes(self, axis: str) -> list[tuple[str, tuple[float, float], Shape]]:
        """Return wave, band and shape of every possible excitation of an axis."""
        waves = self.lift_waves if axis == "lift" else self.waves
        bands = [band for band in BANDS if band[0] >= self.least]
        return [
            (wave, band, SQUARE if wave == "steps" else self.shape)
            for wave in waves
            for band in (STEPS if wave == "steps" else bands)
        ]


@dataclass(frozen=True, eq=False)
class Task:
    """Inputs of a plan: vehicle, parameters, capabilities and limits.

    Attributes:
        truth (n,): Coordinates of the nominal vehicle.
        limits: Limits by the names of `Flown.peaks`.
        still: Peaks of flights without excitation, by the same names.
    """

    simulated: SimulatedVehicle
    airframe: Airframe
    space: ParameterSpace
    truth: Array
    capabilities: TargetCapabilities
    limits: Mapping[str, float]
    still: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class CandidateExcitation:
    """An excitation at its largest amplitude.

    Attributes:
        information (n, n): Per second.
        power: Power of the output of its axis.
    """

    excitation: Excitation
    information: Array
    power: OutputPower = OutputPower()


@dataclass(frozen=True, eq=False)
class AccuracyTarget:
    """Indices of the coordinates to be identified, and their largest standard deviations."""

    places: NDArray[np.intp]
    deviations: Array

    def excess(self, covariance: Array) -> Array:
        """Return the standard deviations over the largest ones."""
        return np.sqrt(np.diag(covariance)[self.places]) / self.deviations

    def score(self, covariance: Array) -> float:
        """Return the mean log ratio of intervals to their targets; narrow ones count little."""
        excess = np.log(self.excess(covariance))
        return float(np.mean(np.where(excess > 0.0, excess, ENOUGH * excess)))


@dataclass(frozen=True, eq=False)
class ExcitationSet:
    """A candidate excitation for each axis, and the covariance after such flights."""

    space: ParameterSpace
    trials: Mapping[str, CandidateExcitation]

    def covariance(self, lengths: Mapping[str, float]) -> Array:
        """Return the covariance (n, n) after excitations of these lengths [s]: 0 leaves an axis unidentified."""
        counted = [axis for axis in self.trials if self._counts(axis, lengths)]
        parts = (lengths[axis] * self.trials[axis].information for axis in counted)
        still = {name for axis, names in OF_OUTPUT.items() if axis not in counted for name in names}
        free = identifiable_parameters(self.space) & np.array([name not in still for name in self.space.names])
        return cramer_rao_covariance(self.space, sum(parts, np.zeros_like(self.space.covariance)), free)

    def _counts(self, axis: str, lengths: Mapping[str, float]) -> bool:
        """Return true where identification would believe the output of an axis."""
        length = lengths.get(axis, 0.0)
        rest = length_of(self.excitations(lengths)) - length
        return length > 0.0 and self.trials[axis].power.explained(length, rest) >= EXPLAINED + SPARE

    def excitations(self, lengths: Mapping[str, float]) -> tuple[Excitation, ...]:
        """Return the excitations of every axis that has a length."""
        return tuple(
            replace(trial.excitation, duration=lengths[axis])
            for axis, trial in self.trials.items()
            if lengths.get(axis, 0.0) > 0.0
        )


def candidate_excitations(task: Task, axis: str) -> list[CandidateExcitation]:
    """Return a candidate of an axis for every available wave and band."""
    quantity = task.capabilities.quantities[axis]
    tried = [
        Excitation(axis, quantity, FIRST_TRY[quantity], *band, TRIAL_LENGTH, wave, shape)
        for wave, band, shape in task.capabilities.shapes(axis)
    ]
    return [_trial(task, maximize_amplitude(task, entry)) for entry in tried]


def _trial(task: Task, excitation: Excitation) -> CandidateExcitation:
    log = task.simulated.alone.flown([excitation], STREAM, 1).log(0, STREAM)
    problem = problem_of(log, task.airframe, task.space)
    information = information_of(problem, task.truth, excitation.axis) / TRIAL_LENGTH
    return CandidateExcitation(excitation, information, output_power(problem, task.truth, excitation))


def maximize_amplitude(task: Task, excitation: Excitation) -> Excitation:
    """Return an excitation as strong as the limits allow.

    Peaks of a nearly linear loop grow with the amplitude from those of the disturbances; where motors saturate they do not, and
    the amplitude is bisected.
    """
    allowed, excessive = 0.0, np.inf
    for _ in range(MAX_TRIALS):
        amplitude = excitation.amplitude
        factor = min(_room(task, excitation), command_headroom(excitation, task.limits))
        if factor >= 1.0:
            allowed = max(allowed, amplitude)
        else:
            excessive = min(excessive, amplitude)
        if 1.0 <= factor < LIMIT_MARGIN:
            break
        # Into the middle of the room that is left: an amplitude that comes from above meets the limit itself never.
        goal = amplitude * float(np.clip(factor, 0.1, 10.0)) / sqrt(LIMIT_MARGIN)
        if not allowed < goal < excessive:
            goal = float(np.sqrt(max(allowed, 0.01 * excessive) * excessive))
        excitation = replace(excitation, amplitude=goal)
    return quantize_amplitude(replace(excitation, amplitude=allowed) if allowed else excitation)


def _room(task: Task, excitation: Excitation) -> float:
    """Return the headroom of an excitation's response: the factor until a limit is reached."""
    flown, still = task.simulated.flown([excitation], STREAM, FLIGHTS), task.still
    if not flown.completed:
        return 0.0
    peaks = flown.peaks
    return min((limit - still[name]) / max(peaks[name] - still[name], 1e-9) for name, limit in task.limits.items())


def command_headroom(excitation: Excitation, limits: Mapping[str, float]) -> float:
    """Return the headroom of an excitation's command: the factor until a limit is reached."""
    rooms = [limits["tilt"] / excitation.angle] if excitation.axis in ("roll", "pitch") else []
    rooms += [limits["rate"] / excitation.amplitude] if excitation.quantity == "rate" else []
    rooms += [LIFT / excitation.amplitude] if excitation.quantity == "acceleration" else []
    return min(rooms)


def quantize_amplitude(excitation: Excitation) -> Excitation:
    """Return an excitation with a quantized amplitude: a multiple of the step, rounded down, at least one."""
    step = RESOLUTION[excitation.quantity]
    return replace(excitation, amplitude=float(step * max(np.floor(excitation.amplitude / step + 1e-9), 1.0)))


def select_excitations(
    trials: Mapping[str, list[CandidateExcitation]],
    space: ParameterSpace,
    accuracy: AccuracyTarget,
    capabilities: TargetCapabilities,
) -> ExcitationSet:
    """Return the most informative candidate of each axis for the target: by coordinate descent."""
    chosen = {axis: tried[len(tried) // 2] for axis, tried in trials.items()}
    for axes in capabilities.groups:
        # Long enough for its output to count beside those of the others.
        lengths = dict.fromkeys(chosen, TRIAL_LENGTH) | dict.fromkeys(axes, DEFAULT_LENGTH)
        options = [
            ExcitationSet(space, chosen | {axis: trials[axis][k] for axis in axes}) for k in range(len(trials[axes[0]]))
        ]
        chosen = dict(min(options, key=lambda option: accuracy.score(option.covariance(lengths))).trials)
    return ExcitationSet(space, chosen)


def required_durations(
    selection: ExcitationSet, accuracy: AccuracyTarget, capabilities: TargetCapabilities
) -> dict[str, float]:
    """Return the durations of the excitations [s]: 0 if not needed, the longest where even these do not suffice."""
    lengths = dict.fromkeys(selection.trials, 0.0)
    while np.any(accuracy.excess(selection.covariance(lengths)) > 1.0):
        groups = [group for group in capabilities.groups if lengths[group[0]] < MAX_LENGTH]
        if not groups:
            break
        now = accuracy.score(selection.covariance(lengths))
        # All axes together come last: an inertia needs the thrust, which another axis tells.
        together = tuple(axis for group in groups for axis in group)
        options = [longer for axes in (*groups, together) for longer in _longer(lengths, axes)]
        gains = [_gain(selection, lengths, longer, now, accuracy) for longer in options]
        if max(gains) <= 0.0:
            # More data of one axis carries errors of given numbers along, which may outweigh what it tells.
            break
        lengths = options[int(np.argmax(gains))]
    return lengths


def _longer(lengths: dict[str, float], axes: Sequence[str]) -> list[dict[str, float]]:
    """Return the lengths with longer excitations of some axes: by a step, and by factors."""
    shortest = [lengths | {axis: lengths[axis] + LENGTH_STEP if lengths[axis] else MIN_LENGTH for axis in axes}]
    factored = [
        lengths
        | {
            axis: min(LENGTH_STEP * ceil(factor * max(lengths[axis], MIN_LENGTH) / LENGTH_STEP), MAX_LENGTH)
            for axis in axes
        }
        for factor in LONGER
    ]
    return shortest + factored


def _gain(
    selection: ExcitationSet,
    lengths: Mapping[str, float],
    longer: Mapping[str, float],
    now: float,
    accuracy: AccuracyTarget,
) -> float:
    """Return the improvement of the score per second."""
    return (now - accuracy.score(selection.covariance(longer))) / (sum(longer.values()) - sum(lengths.values()))
