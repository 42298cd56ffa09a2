"""Bands, amplitudes and lengths of the excitations that tell what is asked for.

Amplitudes are as large as the limits allow. The band of each axis is the one that tells most of what is asked for. Lengths grow,
axis by axis, where a second more tells most, until the intervals are as narrow as asked: a greedy design for the determinant of
the information (Goodwin and Payne, Dynamic System Identification, 1977, chapter 6).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plant.airframes import Airframe
from tuner.analysis.flight_plan.excitation import Excitation, Shape
from tuner.analysis.flight_plan.flying import FLIGHTS, Craft
from tuner.analysis.flight_plan.foresight import information_of, told_by_flights
from tuner.analysis.identification.fit import foreseen_covariance
from tuner.analysis.identification.identify import OF_OUTPUT
from tuner.analysis.identification.parameters import Space

Array = NDArray[np.float64]

BANDS = ((0.5, 4.0), (1.0, 6.0), (1.0, 12.0), (2.0, 20.0))
"""First and last frequencies that are tried [Hz]."""
TRIAL, STREAM = 8.0, "experiment"
"""Length of the excitations that bands are compared with [s]; name of the streams of their air."""
LEAST, STEP, USUAL, LONGEST = 8.0, 2.0, 20.0, 60.0
"""Shortest excitation, what it grows by, the longest where no number is named, and the longest of all [s]."""
MARGIN = 0.9
"""Share of a limit that excitations are made for."""
LIFT = 5.0
"""Largest acceleration along z that is asked for [m/s2]: half of gravity, so that the rotors keep half of their thrust."""
TRIES, CLOSE = 6, 1.05
"""Flights that an amplitude is sought in, and the room left to the nearest limit that ends it."""
FIRST_TRY = {"angle": 0.1, "rate": 0.5, "acceleration": 2.0}
"""Amplitudes that are flown first [rad, rad/s, m/s2]."""
RESOLUTION = {"angle": np.radians(0.1), "rate": np.radians(1.0), "acceleration": 0.05}
"""Steps of amplitudes [rad, rad/s, m/s2]: targets take no finer ones, and a pilot reads them."""
ENOUGH = 0.1
"""Weight of what is narrow enough already beside what is not."""


@dataclass(frozen=True)
class Ability:
    """The excitations that a target can fly.

    quantities: axis -> what of it can be excited. waves: that it has. shape: of its chirps. alike: whether band and length are
    the same on all axes. least: lowest frequency [Hz].
    """

    quantities: Mapping[str, str]
    waves: tuple[str, ...] = ("chirp",)
    shape: Shape = Shape()
    alike: bool = False
    least: float = 0.0

    @property
    def groups(self) -> list[tuple[str, ...]]:
        """Axes whose band and length are one choice."""
        return [tuple(self.quantities)] if self.alike else [(axis,) for axis in self.quantities]


@dataclass(frozen=True, eq=False)
class Task:
    """The task of a plan: vehicle, numbers to find, target and limits.

    truth (n,): coordinates of the nominal vehicle. limits: by the names of `Flown.peaks`; still: what flights without excitation
    come to.
    """

    craft: Craft
    airframe: Airframe
    space: Space
    truth: Array
    ability: Ability
    limits: Mapping[str, float]
    still: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Trial:
    """An excitation at its largest amplitude, and the information in a second of it (n, n)."""

    excitation: Excitation
    information: Array


@dataclass(frozen=True, eq=False)
class Wish:
    """Coordinates that are to be known, by their places, and the largest standard deviation of each."""

    places: NDArray[np.intp]
    deviations: Array

    def excess(self, covariance: Array) -> Array:
        """Return the standard deviations over the largest ones."""
        return np.sqrt(np.diag(covariance)[self.places]) / self.deviations


@dataclass(frozen=True, eq=False)
class Mix:
    """A trial for each axis, and what flights of these excitations leave open."""

    space: Space
    trials: Mapping[str, Trial]

    def covariance(self, lengths: Mapping[str, float]) -> Array:
        """Return the covariance (n, n) after excitations of these lengths [s]; numbers of an axis without one are not told."""
        parts = (lengths[axis] * trial.information for axis, trial in self.trials.items())
        still = {name for axis, names in OF_OUTPUT.items() if not lengths.get(axis) for name in names}
        free = told_by_flights(self.space) & np.array([name not in still for name in self.space.names])
        return foreseen_covariance(self.space, sum(parts, np.zeros_like(self.space.covariance)), free)

    def score(self, lengths: Mapping[str, float], wish: Wish) -> float:
        """Return the mean logarithm of intervals over those that are asked for; narrow ones count little."""
        excess = np.log(wish.excess(self.covariance(lengths)))
        return float(np.mean(np.where(excess > 0.0, excess, ENOUGH * excess)))

    def excitations(self, lengths: Mapping[str, float]) -> tuple[Excitation, ...]:
        """Return the excitations of every axis that has a length."""
        return tuple(
            replace(trial.excitation, duration=lengths[axis])
            for axis, trial in self.trials.items()
            if lengths[axis] > 0.0
        )


def trials_of(task: Task, axis: str) -> list[Trial]:
    """Return a trial of an axis for every wave and band that the target can fly."""
    ability, quantity = task.ability, task.ability.quantities[axis]
    tried = [
        Excitation(axis, quantity, FIRST_TRY[quantity], *band, TRIAL, wave, ability.shape)
        for wave in ability.waves
        for band in BANDS
        if band[0] >= ability.least
    ]
    return [_trial(task, amplified(task, entry)) for entry in tried]


def _trial(task: Task, excitation: Excitation) -> Trial:
    log = task.craft.alone.flown([excitation], STREAM, 1).log(0, STREAM)
    found = information_of(log, task.airframe, task.space, task.truth, excitation.axis)
    return Trial(excitation, found / TRIAL)


def amplified(task: Task, excitation: Excitation) -> Excitation:
    """Return an excitation as strong as the limits allow.

    A loop that is near linear has peaks that grow with the amplitude from those of the air; where motors saturate it has not, and
    what keeps the limits is told from what does not by halves.
    """
    kept, broken = 0.0, np.inf
    for _ in range(TRIES):
        amplitude = excitation.amplitude
        factor = min(_room(task, excitation), asked_room(excitation, task.limits))
        kept, broken = (max(kept, amplitude), broken) if factor >= 1.0 else (kept, min(broken, amplitude))
        if 1.0 <= factor < CLOSE:
            break
        goal = amplitude * float(np.clip(factor, 0.1, 10.0))
        between = kept < goal < broken
        excitation = replace(
            excitation, amplitude=goal if between else float(np.sqrt(max(kept, 0.01 * broken) * broken))
        )
    return coarse(replace(excitation, amplitude=kept) if kept else excitation)


def _room(task: Task, excitation: Excitation) -> float:
    """Return how much an excitation may grow until what follows it reaches a limit."""
    flown, still = task.craft.flown([excitation], STREAM, FLIGHTS), task.still
    if not flown.completed:
        return 0.0
    peaks = flown.peaks
    return min((limit - still[name]) / max(peaks[name] - still[name], 1e-9) for name, limit in task.limits.items())


def asked_room(excitation: Excitation, limits: Mapping[str, float]) -> float:
    """Return how much an excitation may grow until what it asks for reaches a limit, whatever follows."""
    rooms = [limits["tilt"] / excitation.angle] if excitation.axis in ("roll", "pitch") else []
    rooms += [limits["rate"] / excitation.amplitude] if excitation.quantity == "rate" else []
    rooms += [LIFT / excitation.amplitude] if excitation.quantity == "acceleration" else []
    return min(rooms)


def coarse(excitation: Excitation) -> Excitation:
    """Return an excitation whose amplitude is a whole number of steps, at least one, not larger than it was otherwise."""
    step = RESOLUTION[excitation.quantity]
    return replace(excitation, amplitude=float(step * max(np.floor(excitation.amplitude / step + 1e-9), 1.0)))


def best_mix(trials: Mapping[str, list[Trial]], space: Space, wish: Wish, ability: Ability) -> Mix:
    """Return for each axis the trial that tells most of what is asked for, the others' being as they are by then."""
    chosen = {axis: tried[len(tried) // 2] for axis, tried in trials.items()}
    lengths = dict.fromkeys(chosen, TRIAL)
    for axes in ability.groups:
        options = [Mix(space, chosen | {axis: trials[axis][k] for axis in axes}) for k in range(len(trials[axes[0]]))]
        chosen = dict(min(options, key=lambda option: option.score(lengths, wish)).trials)
    return Mix(space, chosen)


def lengths_for(mix: Mix, wish: Wish, ability: Ability) -> dict[str, float]:
    """Return the lengths of the excitations [s], 0 of those that are not needed; the longest where even these do not suffice."""
    lengths = dict.fromkeys(mix.trials, 0.0)
    while np.any(wish.excess(mix.covariance(lengths)) > 1.0):
        groups = [group for group in ability.groups if lengths[group[0]] < LONGEST]
        if not groups:
            break
        now = mix.score(lengths, wish)
        gains = [_gain(mix, lengths, _longer(lengths, group), now, wish) for group in groups]
        lengths = _longer(lengths, groups[int(np.argmax(gains))])
    return lengths


def _longer(lengths: dict[str, float], group: tuple[str, ...]) -> dict[str, float]:
    return lengths | {axis: lengths[axis] + STEP if lengths[axis] else LEAST for axis in group}


def _gain(mix: Mix, lengths: Mapping[str, float], longer: Mapping[str, float], now: float, wish: Wish) -> float:
    """Return what a second more tells."""
    return (now - mix.score(longer, wish)) / (sum(longer.values()) - sum(lengths.values()))
