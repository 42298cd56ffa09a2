"""Plan of an identification flight: chosen, checked in simulation, and validated by identification from a simulated log."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError, check_name
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.vehicle import late_periods
from tuner.extensions.flight_plans import choosing, limits
from tuner.extensions.flight_plans.choosing import (
    AccuracyTarget,
    CandidateExcitation,
    ExcitationSet,
    TargetCapabilities,
    Task,
)
from tuner.extensions.flight_plans.excitation import Excitation
from tuner.extensions.flight_plans.expected_accuracy import ExpectedAccuracy, expected_accuracy
from tuner.extensions.flight_plans.flying import FLIGHTS, Flown, SimulatedVehicle
from tuner.extensions.flight_plans.informativeness import QUANTILE, check_is_informative, is_identified
from tuner.extensions.flight_plans.limits import peaks_of_hover, reduce_amplitudes, shares_of_limits
from tuner.extensions.identification.identify import Identified, identify_vehicle
from tuner.extensions.vehicle_fit.identifiability import GIVEN, NARROWED, OF_OUTPUT, WEIGHED
from tuner.extensions.vehicle_fit.parameters import Parameter, ParameterSpace, space_of

Array = NDArray[np.float64]

MAX_CORRECTIONS = 8
"""Simulations of a flight, each followed by a correction."""
PATIENCE = 2
"""Iterations without improvement before stopping."""
MIN_GROWTH = 1.3
"""Smallest factor by which a correction lengthens excitations."""
MIN_WIDTH_RATIO = 1.25
"""Smallest ratio of a target width to the width that the longest flight reaches; up to it a wider interval is a near miss."""
MAX_GIVEN_SHARE = 0.8
"""Largest share of an interval from weighed and measured values at which a longer flight still helps."""


@dataclass(frozen=True)
class ExperimentSpec:
    """Parameters to be identified by a flight, and its limits.

    Attributes:
        numbers: Names, empty for all that such a flight can identify to this accuracy.
        within: Largest half-width of a 95 % interval, relative; of the dead time over the mean lag, of the center of mass over
            the arm.
        tilt: Limit [rad].
        rate: Limit [rad/s].
        mass, arm: Relative standard deviations of the weighed mass and the measured arm.
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
        return {
            "tilt": self.tilt,
            "rate": self.rate,
            "height": limits.MAX_HEIGHT,
            "motors": limits.MOTOR_RANGE,
            "rotor_rms": limits.ROTOR_RMS,
            "rotor_peak": limits.ROTOR_PEAK,
        }


@dataclass(frozen=True, eq=False)
class Experiment:
    """A planned flight.

    Attributes:
        excitations: Excitations in their order.
        accuracy: Parameters to be identified, and their accuracy.
        checked: Flights over the airframe's uncertainty.
        expected: Accuracy that the flight should give.
        proof: Result of an identification from one simulated flight.
    """

    task: Task
    request: ExperimentSpec
    excitations: tuple[Excitation, ...]
    accuracy: AccuracyTarget
    checked: Flown
    expected: ExpectedAccuracy
    proof: Identified

    @property
    def wanted(self) -> tuple[str, ...]:
        """Names of the numbers that are to be known."""
        return tuple(self.task.space.names[place] for place in self.accuracy.places)


def plan_experiment(
    simulated: SimulatedVehicle,
    airframe: Airframe,
    request: ExperimentSpec,
    capabilities: TargetCapabilities,
    on_progress: Callable[[str], None],
) -> Experiment:
    """Plan an identification flight.

    InputError where no flight can reach the accuracy, or where the limits leave no room for one; on_progress: called with texts.
    """
    space = space_of(airframe.vehicle, ["1"], request.mass, request.arm)
    allowed = {name: choosing.MARGIN * limit for name, limit in request.limits.items()}
    on_progress("Planning an experiment; this takes half a minute.")
    simulated = nominal_vehicle(simulated, space)
    task = Task(
        simulated,
        airframe,
        space,
        truth_of(space, simulated),
        capabilities,
        allowed,
        peaks_of_hover(simulated, request.limits),
    )
    trials = {axis: choosing.candidate_excitations(task, axis) for axis in capabilities.quantities}
    accuracy = accuracy_target(task, request, trials)
    excitations, checked, expected = _excite(task, request, accuracy, trials)
    identified = is_identified(space, expected.deviations)[accuracy.places]
    if not request.numbers and identified.any() and not identified.all():
        # Parameters that are not identifiable would only lengthen the flight.
        accuracy = AccuracyTarget(accuracy.places[identified], accuracy.deviations[identified])
        excitations, checked, expected = _excite(task, request, accuracy, trials)
    check_is_informative(bool(request.numbers), space, accuracy, expected.deviations)
    on_progress("Identifying the vehicle from a simulated log of it.")
    log = simulated.alone.flown(excitations, f"{choosing.STREAM}/proof", 1).log(0, "simulated flight")
    proof = identify_vehicle([log], airframe, mass=request.mass, arm=request.arm)
    return Experiment(task, request, excitations, accuracy, checked, expected, proof)


def _excite(
    task: Task, request: ExperimentSpec, accuracy: AccuracyTarget, trials: Mapping[str, list[CandidateExcitation]]
) -> tuple[tuple[Excitation, ...], Flown, ExpectedAccuracy]:
    """Return the excitations for an accuracy, their checked flights and expected accuracy."""
    selection = choosing.select_excitations(trials, task.space, accuracy, task.capabilities)
    lengths = choosing.required_durations(selection, accuracy, task.capabilities)
    return _iterate(task, request, accuracy, selection.excitations(lengths))


def nominal_vehicle(simulated: SimulatedVehicle, space: ParameterSpace) -> SimulatedVehicle:
    """Return the simulated vehicle at the prior's center: with drag and damping, which its file may lack."""
    numbers, vehicle = space.numbers(space.center), simulated.system.vehicle
    drag, damping = vehicle.drag_linear, vehicle.rate_damping
    nominal = vehicle._replace(
        drag_linear=drag._replace(z=numbers.climb_drag),
        rate_damping=damping._replace(x=numbers.rate_damping, y=numbers.rate_damping),
    )
    return replace(simulated, system=replace(simulated.system, vehicle=nominal))


def truth_of(space: ParameterSpace, simulated: SimulatedVehicle) -> Array:
    """Return the coordinates (n,) of the nominal vehicle as its log shows it."""
    period, point = simulated.system.timing.control_period, space.center
    point[space.names.index("dead_time")] = period * late_periods(simulated.system.vehicle, period)
    return point


def check_names(numbers: Sequence[str], space: ParameterSpace) -> None:
    """Raise InputError for names of parameters that no flight identifies."""
    identifiable = [name for name in space.names[: space.physical] if name not in GIVEN]
    for name in numbers:
        if name in GIVEN:
            instead = (
                f"weigh or measure it, and say how well with --{name}"
                if name in WEIGHED
                else "what the airframe says of it counts"
            )
            raise InputError(f"given {name}, which no flight identifies; {instead}", key="--numbers")
        check_name("parameter that a flight identifies", name, identifiable, key="--numbers")


def accuracy_target(
    task: Task, request: ExperimentSpec, trials: Mapping[str, list[CandidateExcitation]]
) -> AccuracyTarget:
    """Return the accuracy target; InputError where a requested parameter cannot reach it."""
    space, names = task.space, task.space.names[: task.space.physical]
    largest = np.array([_largest(entry, request.within, task.airframe) for entry in space.parameters[: space.physical]])
    longest = choosing.select_excitations(
        trials, space, AccuracyTarget(np.arange(len(names)), largest), task.capabilities
    )
    length = choosing.MAX_LENGTH if request.numbers else choosing.DEFAULT_LENGTH
    least = np.sqrt(np.diag(longest.covariance(dict.fromkeys(trials, length))))[: len(names)]
    is_identifiable = np.array([name not in GIVEN for name in names]) & (
        least <= NARROWED * space.initial_std[: len(names)]
    )
    reached = is_identifiable & (least <= largest)
    requested = [names.index(name) for name in request.numbers]
    missed = [place for place in requested if not reached[place]]
    if missed or not reached.any():
        place = missed[0] if missed else int(np.argmin(np.where(is_identifiable, least / largest, np.inf)))
        text = out_of_reach(names[place], float(least[place] / largest[place]), request, longest)
        raise InputError(text, key="--numbers" if missed else "--within")
    places = np.array(requested or np.flatnonzero(is_identifiable).tolist())
    return AccuracyTarget(places, np.maximum(largest, MIN_WIDTH_RATIO * least)[places])


def _largest(entry: Parameter, within: float, airframe: Airframe) -> float:
    """Return the largest standard deviation of a coordinate for a relative half-width."""
    if entry.positive:
        return float(np.log1p(within)) / QUANTILE
    vehicle = airframe.vehicle
    scales = {"dead_time": 0.5 * (vehicle.lag_up + vehicle.lag_down)}
    scales |= dict.fromkeys(("centre.x", "centre.y"), hypot(vehicle.rotor_x.r1, vehicle.rotor_y.r1))
    return within * scales.get(entry.name, abs(entry.value)) / QUANTILE


def out_of_reach(name: str, excess: float, request: ExperimentSpec, selection: ExcitationSet) -> str:
    """Return the reason for a missed target: the best accuracy, and the remedy."""
    if excess > 1.0 / request.within:
        return f"{name} hardly shows in such a flight; leave it out, or allow more (--tilt, --rate)"
    best = f"{name} comes to within {100.0 * excess * request.within:.1f} % at best, given {100.0 * request.within:g} %"
    shares = _given_shares(name, selection)
    if sum(shares.values()) <= MAX_GIVEN_SHARE**2:
        return f"{best}; allow more (--tilt, --rate), or ask for less (--within)"
    largest = max(shares, key=lambda entry: shares[entry])
    if largest in WEIGHED:
        return (
            f"{best}, because the mass is known to {100.0 * request.mass:g} % and lengths to {100.0 * request.arm:g} %; weigh "
            "and measure better (--mass, --arm), or allow wider intervals (--within)"
        )
    entry = selection.space.parameters[selection.space.names.index(largest)]
    return (
        f"{best}: the {entry.meaning} is given to {100.0 * entry.deviation:g} % and not identified; allow wider intervals "
        "(--within), or name other parameters"
    )


def _given_shares(name: str, selection: ExcitationSet) -> dict[str, float]:
    """Return the share of a variance that each given parameter causes."""
    covariance = selection.covariance(dict.fromkeys(selection.trials, choosing.MAX_LENGTH))
    names, place = selection.space.names, selection.space.names.index(name)
    at = {given: names.index(given) for given in GIVEN}
    return {
        given: float(covariance[place, k] ** 2 / (covariance[k, k] * covariance[place, place]))
        for given, k in at.items()
    }


def _iterate(
    task: Task, request: ExperimentSpec, accuracy: AccuracyTarget, excitations: tuple[Excitation, ...]
) -> tuple[tuple[Excitation, ...], Flown, ExpectedAccuracy]:
    """Return excitations within limits and target, their checked flights and expected accuracy.

    They are the most informative ones that met the limits, and may still miss the target. InputError where none meets them.
    """
    best, least, behind = None, np.inf, 0
    for _ in range(MAX_CORRECTIONS):
        checked = task.simulated.flown(excitations, f"{choosing.STREAM}/check", FLIGHTS)
        shares = shares_of_limits(checked, excitations, request.limits)
        if max(checked.peaks[name] / limit for name, limit in request.limits.items()) > 1.0 or not checked.completed:
            excitations = reduce_amplitudes(excitations, shares)
            continue
        log = task.simulated.alone.flown(excitations, f"{choosing.STREAM}/check", 1).log(0, choosing.STREAM)
        expected = expected_accuracy(log, task.airframe, task.space, task.truth)
        score = accuracy.score(expected.fit.covariance)
        behind += 1
        if score < least:
            best, least, behind = (excitations, checked, expected), score, 0
        if behind == PATIENCE:
            break
        longer = _longer(task, accuracy, excitations, expected)
        if longer == excitations:
            break
        excitations = longer
    if best is None:
        raise InputError("no excitation within the limits was found; raise them (--tilt, --rate)", key="--tilt")
    return best


def _longer(
    task: Task, accuracy: AccuracyTarget, excitations: tuple[Excitation, ...], expected: ExpectedAccuracy
) -> tuple[Excitation, ...]:
    """Return excitations lengthened by the excess of the intervals: of their axes, or of all."""
    excess = accuracy.excess(expected.fit.covariance)
    short = {task.space.names[place] for place in accuracy.places[excess > 1.0]}
    if not short:
        return excitations
    axes = {axis for axis, names in OF_OUTPUT.items() if short & set(names)} or set(OF_OUTPUT)
    factor = float(np.max(excess))
    return tuple(
        replace(entry, duration=_lengthened(entry.duration, factor)) if entry.axis in axes else entry
        for entry in excitations
    )


def _lengthened(duration: float, excess: float) -> float:
    """Return the duration that narrows an interval to its target: widths fall with the root of time."""
    return min(float(np.ceil(duration * np.clip(excess**2, MIN_GROWTH, 2.0))), choosing.MAX_LENGTH)
