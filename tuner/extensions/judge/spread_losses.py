"""Losses that come from the ranges of an airframe: the number that decides them, with the vehicle in the middle for comparison.

A parts list gives thrust within a factor of 11 and rotor lag within 8. If vehicles at the ends of such ranges are lost and
the vehicle in their middle is not, gains are neither refused nor accepted: a measured number decides.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.risk import clopper_pearson
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.quadrotor.scenarios import ScenarioSpec, Spread, drawn_numbers
from plant.quadrotor.vehicle import Vehicle
from tuner.api.flight_setup import FlightSetup
from tuner.documents.parts import ShareCount
from tuner.extensions.autopilots.vehicle_facts import HOVER, hover_command
from tuner.extensions.judge.vehicle_facts import WARNING_FACTOR
from tuner.extensions.parts_list.estimate import QUANTILE

Flags = NDArray[np.bool_]
MAX_LOSS = 0.01
"""Largest probability of loss."""
MAX_DEVIATION = log(WARNING_FACTOR) / QUANTILE
"""Largest standard deviation of a number's logarithm with which the number counts as known."""
MIN_SHIFT = 0.5
"""Smallest mean deviation of lost vehicles, in standard deviations, with which a number decides."""
WORDS = {
    "arm": ("arm", " m"),
    "inertia.x": ("inertia about x", " kg m2"),
    "inertia.y": ("inertia about y", " kg m2"),
    "inertia.z": ("inertia about z", " kg m2"),
    "torque_ratio": ("torque over thrust", " m"),
    "lag_up": ("rotor lag", " s"),
    "lag_down": ("rotor lag", " s"),
}
"""Numbers of an uncertainty in words, with their units; mass and thrust act through the hover command."""


class Candidate(NamedTuple):
    """A number that vehicles differ in: words, unit, value in the middle, values (n,) of the vehicles."""

    words: str
    unit: str
    middle: float
    values: NDArray[np.float64]


def spread_reason(setup: FlightSetup, nominal: Vehicle, lost: Flags, fly_middle: Callable[[FlightSetup], Flags]) -> str:
    """Return the reason of losses from an airframe's ranges, or "".

    Args:
        setup: Flights of the gains.
        nominal: Vehicle in the middle of the ranges.
        lost: Lost flights (n,).
        fly_middle: Return the lost flights of the same air and noise with another spread.
    """
    spec, share = setup.spec, ShareCount.of(lost)
    if not isinstance(spec, ScenarioSpec) or spec.uncertainty is None or not exceeds_limit(share):
        return ""
    steps = drawn_numbers(spec, nominal, setup.root, *setup.draws) * np.array(spec.uncertainty.deviations)
    candidates = [row for row in _candidates(spec.uncertainty, nominal, steps) if _deviation(row) > MAX_DEVIATION]
    if not candidates:
        return ""
    middle = ShareCount.of(fly_middle(replace(setup, spec=replace(spec, uncertainty=None, spread=Spread()))))
    if exceeds_limit(middle):
        return ""
    per_cent, at_middle = 100.0 * share.events / share.flights, f"{middle.events} of {middle.flights}"
    return (
        f"{per_cent:.2g} % of the vehicles that the airframe's ranges allow are lost ({spec.name}: {share.events} of "
        f"{share.flights}; {at_middle} with the vehicle in their middle): {_advice(candidates, lost)}"
    )


def spread_reasons(
    flown: Sequence[tuple[FlightSetup, Flags]], nominal: Vehicle, fly_middle: Callable[[FlightSetup], Flags]
) -> dict[str, str]:
    """Return scenario -> reason of `spread_reason`; flown: flights of each scenario, and those that are lost."""
    reasons = {setup.spec.name: spread_reason(setup, nominal, lost, fly_middle) for setup, lost in flown}
    return {name: reason for name, reason in reasons.items() if reason}


def exceeds_limit(share: ShareCount, limit: float = MAX_LOSS) -> bool:
    """Return True for significantly more losses than a limit allows."""
    return float(clopper_pearson(share.events, share.flights).low) > limit


def _candidates(ranges: Uncertainty, nominal: Vehicle, steps: NDArray[np.float64]) -> Iterator[Candidate]:
    """Yield the numbers that vehicles differ in, the hover command first; steps: deviations (n, names) of the vehicles."""
    commands = [hover_command(ranges.moved(nominal, step)) for step in steps]
    yield Candidate(HOVER.name, HOVER.unit, hover_command(nominal), np.array(commands))
    for column, name in enumerate(ranges.names):
        if name in WORDS:
            words, unit = WORDS[name]
            middle = _number(nominal, name)
            yield Candidate(words, unit, middle, middle * np.exp(steps[:, column]))


def _number(vehicle: Vehicle, name: str) -> float:
    """Return a number of a vehicle by its name in an uncertainty."""
    group, _, axis = name.partition(".")
    if name == "arm":
        return float(np.hypot(vehicle.rotor_x[0], vehicle.rotor_y[0]))
    value = getattr(vehicle, group)
    return float(getattr(value, axis) if axis else value)


def _deviation(row: Candidate) -> float:
    return float(np.std(np.log(row.values)))


def _shift(row: Candidate, lost: Flags) -> float:
    """Return the mean deviation of the lost vehicles, in standard deviations."""
    logarithms = np.log(row.values)
    return float((logarithms[lost].mean() - logarithms.mean()) / _deviation(row))


def _advice(candidates: list[Candidate], lost: Flags) -> str:
    """Return the number that decides, and how to get it."""
    deciding = max(candidates, key=lambda row: abs(_shift(row, lost)))
    shift = _shift(deciding, lost)
    if abs(shift) < MIN_SHIFT:
        return "identify the vehicle from a log"
    half = float(np.median(deciding.values[lost]))
    side = "above" if shift > 0.0 else "below"
    measure = "give the hover command, or identify" if deciding.words == HOVER.name else "identify"
    return (
        f"{measure} the vehicle from a log; in half of those lost the {deciding.words} is {side} {half:.3g}{deciding.unit}, "
        f"in the middle {deciding.middle:.3g}{deciding.unit}"
    )
