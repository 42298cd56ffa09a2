"""Plan of an experiment: chosen, checked in simulation, and proved by identifying the vehicle from a simulated log."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from plant.airframes import Airframe
from plant.errors import InputError, UnknownNameError
from plant.vehicle import late_periods
from tuner.analysis.flight_plan.choosing import (
    LONGEST,
    MARGIN,
    STREAM,
    USUAL,
    Ability,
    Mix,
    Task,
    Trial,
    Wish,
    best_mix,
    coarse,
    lengths_for,
    trials_of,
)
from tuner.analysis.flight_plan.excitation import Excitation
from tuner.analysis.flight_plan.flying import FLIGHTS, Craft, Flown
from tuner.analysis.flight_plan.foresight import Foresight, foresee
from tuner.analysis.identification.identify import GIVEN, NARROWED, OF_OUTPUT, WEIGHED, Identified, identify_vehicle
from tuner.analysis.identification.parameters import Parameter, Space, space_of

Array = NDArray[np.float64]

QUANTILE = 1.96
"""Of a 95 % interval, in standard deviations."""
HEIGHT, MOTORS = 1.0, 0.9
"""Largest excursion of the height [m], and share of the way from hover to idle or full command that motors may go."""
MOVED = {"tilt": ("roll", "pitch"), "rate": ("roll", "pitch", "yaw"), "height": ("lift",), "motors": tuple(OF_OUTPUT)}
"""Axes whose excitation moves what has a limit."""
ROUNDS, GROWTH = 8, 1.3
"""Times that a whole flight is flown and mended, and the least that its excitations grow by."""
STILL = 0.5
"""Share of a limit that air and noise alone may take."""
NEARLY = 1.25
"""Room that is left to the narrowest interval where nobody asks for a number that stays wider than the others may."""
TELLING = 0.9
"""Half-width after a flight over that before it, above which the flight tells nothing."""
FORGIVEN = 0.8
"""Share of an interval that is left by what is weighed and measured beyond which a longer flight is no advice."""


@dataclass(frozen=True)
class Question:
    """The numbers that a flight is to tell, and the limits that it keeps.

    numbers: names, empty for all that such a flight can tell so well. within: largest half-width of a 95 % interval, relative; of
    the dead time over the mean lag, of the centre of mass over the arm. tilt [rad], rate [rad/s]: limits. mass, arm: relative
    standard deviations of what is weighed and measured.
    """

    numbers: tuple[str, ...]
    within: float
    tilt: float
    rate: float
    mass: float
    arm: float

    @property
    def limits(self) -> dict[str, float]:
        """Limits by the names of `Flown.peaks`."""
        return {"tilt": self.tilt, "rate": self.rate, "height": HEIGHT, "motors": MOTORS}


@dataclass(frozen=True, eq=False)
class Experiment:
    """A planned flight.

    excitations: in their order. wish: what is to be known. checked: flights over the airframe's uncertainty. foresight: what the
    flight is to tell; proof: what was identified from one simulated flight.
    """

    task: Task
    question: Question
    excitations: tuple[Excitation, ...]
    wish: Wish
    checked: Flown
    foresight: Foresight
    proof: Identified

    @property
    def wanted(self) -> tuple[str, ...]:
        """Names of the numbers that are to be known."""
        return tuple(self.task.space.names[place] for place in self.wish.places)


def plan_experiment(
    craft: Craft, airframe: Airframe, question: Question, ability: Ability, told: Callable[[str], None]
) -> Experiment:
    """Plan the flight that answers a question; told(text) hears of progress.

    InputError where no flight can tell what is asked for, or where the limits leave no room for one.
    """
    space = space_of(airframe.vehicle, ["1"], question.mass, question.arm)
    limits = {name: MARGIN * limit for name, limit in question.limits.items()}
    told("Planning an experiment; this takes half a minute.")
    craft = as_known(craft, space)
    task = Task(craft, airframe, space, truth_of(space, craft), ability, limits, _still(craft, question.limits))
    trials = {axis: trials_of(task, axis) for axis in ability.quantities}
    wish = wish_of(task, question, trials)
    mix = best_mix(trials, space, wish, ability)
    excitations, checked, foresight = _settled(task, question, wish, mix.excitations(lengths_for(mix, wish, ability)))
    check_told(question, space, wish, foresight)
    told("Identifying the vehicle from a simulated log of it.")
    log = craft.alone.flown(excitations, f"{STREAM}/proof", 1).log(0, "simulated flight")
    proof = identify_vehicle([log], airframe, mass=question.mass, arm=question.arm)
    return Experiment(task, question, excitations, wish, checked, foresight, proof)


def is_told(after: float, before: float) -> bool:
    """Return whether a flight narrows an interval: half-widths after and before it."""
    return after < TELLING * before


def check_told(question: Question, space: Space, wish: Wish, foresight: Foresight) -> None:
    """Refuse a plan that tells nothing of a number that is named, or of none at all; raises InputError naming them."""
    after, before = (half_widths(space, deviations) for deviations in (foresight.deviations, space.deviations))
    untold = [space.names[k] for k in wish.places if not is_told(float(after[k]), float(before[k]))]
    if not untold or (len(untold) < len(wish.places) and not question.numbers):
        return
    raise InputError(
        f"no flight within these limits tells of {', '.join(untold)}: intervals would be as wide after it as before; allow more "
        "(--tilt, --rate), give gains that follow faster (--gains), or measure them on a test stand",
        key="--numbers" if question.numbers else "--within",
    )


def as_known(craft: Craft, space: Space) -> Craft:
    """Return the craft with the vehicle in the middle of what is known, which has a drag and a damping that its file may lack."""
    numbers, vehicle = space.numbers(space.centre), craft.system.vehicle
    drag, damping = vehicle.drag_linear, vehicle.rate_damping
    known = vehicle._replace(
        drag_linear=drag._replace(z=numbers.climb_drag),
        rate_damping=damping._replace(x=numbers.rate_damping, y=numbers.rate_damping),
    )
    return replace(craft, system=replace(craft.system, vehicle=known))


def truth_of(space: Space, craft: Craft) -> Array:
    """Return the coordinates (n,) of the nominal vehicle as its log shows it."""
    period, point = craft.system.timing.control_period, space.centre
    point[space.names.index("dead_time")] = period * late_periods(craft.system.vehicle, period)
    return point


def half_widths(space: Space, deviations: Array) -> Array:
    """Return the half-widths of 95 % intervals (n,): relative of positive numbers, in their units of the others."""
    positive = np.array([entry.positive for entry in space.parameters])
    return np.where(positive, np.expm1(QUANTILE * deviations), QUANTILE * deviations)


def check_names(numbers: Sequence[str], space: Space) -> None:
    """Refuse names of numbers that no flight tells."""
    told = [name for name in space.names[: space.physical] if name not in GIVEN]
    for name in numbers:
        if name in GIVEN:
            instead = (
                f"weigh or measure it, and say how well with --{name}"
                if name in WEIGHED
                else "what the airframe says of it counts"
            )
            raise InputError(f"given {name}, which no flight tells; {instead}", key="--numbers")
        if name not in told:
            raise UnknownNameError("number that a flight tells", name, told, key="--numbers")


def wish_of(task: Task, question: Question, trials: Mapping[str, list[Trial]]) -> Wish:
    """Return what is to be known; InputError where a number that is asked for cannot be known so well."""
    space, names = task.space, task.space.names[: task.space.physical]
    largest = np.array(
        [_largest(entry, question.within, task.airframe) for entry in space.parameters[: space.physical]]
    )
    longest = best_mix(trials, space, Wish(np.arange(len(names)), largest), task.ability)
    length = LONGEST if question.numbers else USUAL
    least = np.sqrt(np.diag(longest.covariance(dict.fromkeys(trials, length))))[: len(names)]
    told = np.array([name not in GIVEN for name in names]) & (least <= NARROWED * space.wide[: len(names)])
    reached = told & (least <= largest)
    asked = [names.index(name) for name in question.numbers]
    missed = [place for place in asked if not reached[place]]
    if missed or not reached.any():
        place = missed[0] if missed else int(np.argmin(np.where(told, least / largest, np.inf)))
        text = _out_of_reach(names[place], float(least[place] / largest[place]), question, longest)
        raise InputError(text, key="--numbers" if missed else "--within")
    places = np.array(asked or np.flatnonzero(told).tolist())
    return Wish(places, np.maximum(largest, NEARLY * least)[places])


def _largest(entry: Parameter, within: float, airframe: Airframe) -> float:
    """Return the largest standard deviation of a coordinate whose number is to be known within a share."""
    if entry.positive:
        return float(np.log1p(within)) / QUANTILE
    vehicle = airframe.vehicle
    scales = {"dead_time": 0.5 * (vehicle.lag_up + vehicle.lag_down)}
    scales |= dict.fromkeys(("centre.x", "centre.y"), hypot(vehicle.rotor_x.r1, vehicle.rotor_y.r1))
    return within * scales.get(entry.name, abs(entry.value)) / QUANTILE


def _out_of_reach(name: str, excess: float, question: Question, mix: Mix) -> str:
    """Return why a number cannot be known so well: the best that can be had, and what to do."""
    if excess > 1.0 / question.within:
        return f"{name} hardly shows in such a flight; leave it out, or allow more (--tilt, --rate)"
    best = (
        f"{name} comes to within {100.0 * excess * question.within:.1f} % at best, given {100.0 * question.within:g} %"
    )
    place = mix.space.names.index(name)
    given, all_of_it = (
        mix.covariance(dict.fromkeys(mix.trials, length))[place, place] for length in (1e6 * LONGEST, LONGEST)
    )
    if given > FORGIVEN**2 * all_of_it:
        return (
            f"{best}, for the mass is known to {100.0 * question.mass:g} % and lengths to {100.0 * question.arm:g} %; weigh and "
            "measure better (--mass, --arm), or ask for less (--within)"
        )
    return f"{best}; allow more (--tilt, --rate), or ask for less (--within)"


def _still(craft: Craft, limits: Mapping[str, float]) -> dict[str, float]:
    """Return what flights without excitation come to; InputError where that leaves no room for one."""
    flown = craft.flown([], STREAM, FLIGHTS)
    peaks = flown.peaks
    name, limit = max(limits.items(), key=lambda entry: peaks[entry[0]] / entry[1])
    if peaks[name] > STILL * limit or not flown.completed:
        raise InputError(
            f"air and noise alone take the {name} to {100.0 * peaks[name] / limit:.0f} % of its limit; raise the limit, or give "
            "gains that fly the vehicle well (--gains)",
            key=f"--{name}" if name in ("tilt", "rate") else "--gains",
        )
    return peaks


def _settled(
    task: Task, question: Question, wish: Wish, excitations: tuple[Excitation, ...]
) -> tuple[tuple[Excitation, ...], Flown, Foresight]:
    """Return excitations that as one flight keep the limits and tell what is asked for, and the flights that say so.

    Where the last of them still tell a little less, that is what they come to. InputError where none keeps the limits.
    """
    kept = None
    for _ in range(ROUNDS):
        checked = task.craft.flown(excitations, f"{STREAM}/check", FLIGHTS)
        shares = {name: checked.peaks[name] / limit for name, limit in question.limits.items()}
        if max(shares.values()) > 1.0 or not checked.completed:
            excitations = weaker(excitations, shares)
            continue
        log = task.craft.alone.flown(excitations, f"{STREAM}/check", 1).log(0, STREAM)
        kept = excitations, checked, foresee(log, task.airframe, task.space, task.truth)
        longer = _longer(task, wish, excitations, kept[2])
        if longer == excitations:
            break
        excitations = longer
    if kept is None:
        raise InputError("no excitation was found that keeps the limits; raise them (--tilt, --rate)", key="--tilt")
    return kept


def weaker(excitations: Sequence[Excitation], shares: Mapping[str, float]) -> tuple[Excitation, ...]:
    """Return excitations weaker by what exceeds a limit that they move, or all of them where none moves it.

    shares: of the limits that are taken; where none exceeds 1, a flight was lost, and all are weaker by the margin.
    """
    over = {axis: max(share for name, share in shares.items() if axis in MOVED[name]) for axis in OF_OUTPUT}
    if not any(over[entry.axis] > 1.0 for entry in excitations):
        return tuple(_by(entry, MARGIN / max(1.0, *shares.values())) for entry in excitations)
    return tuple(_by(entry, MARGIN / over[entry.axis]) if over[entry.axis] > 1.0 else entry for entry in excitations)


def _by(excitation: Excitation, factor: float) -> Excitation:
    return coarse(replace(excitation, amplitude=factor * excitation.amplitude))


def _longer(
    task: Task, wish: Wish, excitations: tuple[Excitation, ...], foresight: Foresight
) -> tuple[Excitation, ...]:
    """Return excitations as long as what is still too wide asks for: of its axis, of all where it belongs to none."""
    excess = wish.excess(foresight.fit.covariance)
    short = {task.space.names[place] for place in wish.places[excess > 1.0]}
    if not short:
        return excitations
    axes = {axis for axis, names in OF_OUTPUT.items() if short & set(names)} or set(OF_OUTPUT)
    factor = float(np.max(excess))
    return tuple(
        replace(entry, duration=_lengthened(entry.duration, factor)) if entry.axis in axes else entry
        for entry in excitations
    )


def _lengthened(duration: float, excess: float) -> float:
    """Return a length at which an interval that is too wide is narrow enough: widths fall with the root of the time."""
    return min(float(np.ceil(duration * np.clip(excess**2, GROWTH, 2.0))), LONGEST)
