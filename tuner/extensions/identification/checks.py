"""Checks of a log by physics, before anything is estimated: time base, rates, units, axes, order of motors."""

from collections.abc import Iterator
from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes import Airframe
from plant.quadrotor.nominal import mixer_matrix
from tuner.extensions.logs.flight_log import STANDARD_GRAVITY, FlightLog
from tuner.extensions.vehicle_fit.model import Actuator, lagging
from tuner.extensions.vehicle_fit.prediction import HORIZON
from tuner.extensions.vehicle_fit.regression import LAGS
from tuner.extensions.vehicle_fit.samples import COMPARED_RATE, LogSegment, resample

Array = NDArray[np.float64]

MIN_RATE = 50.0
"""Rate of a log [Hz] below which nothing can be identified."""
USUAL_RATE = 200.0
"""Rate of a log [Hz] below which little can be identified."""
MIN_COMMAND_RATE = 20.0
"""Changes of motor commands in a second below which nothing can be identified: rotors lag by 20 to 100 ms."""
USUAL_COMMAND_RATE = 100.0
"""Changes of motor commands in a second below which little can be identified."""
MAX_LOST_SHARE = 0.02
"""Largest share of lost samples."""
MAX_SATURATED_SHARE = 0.02
"""Largest share of saturated samples."""
HOVER = (0.8, 1.25)
"""Median specific force along z of a flight that neither climbs nor falls for long, over gravity."""
SHAPED = 0.3
"""Correlation of rotation with the motor commands below which their order is not judged."""
SIZED = 0.6
"""Correlation below which an axis is too calm, and its size is not judged."""
MIN_SEGMENT = 0.5
"""Shortest part without a pause that turning is compared on [s]."""
TELLING = 0.5
"""Share of an output's variance that the motors explain, below which the output does not count."""
FACTOR = 6.0
"""Factor between turning and what the airframe would do, beyond which a unit is wrong and not an inertia."""
DEGREES = 180.0 / np.pi
ROTORS = ("front left", "front right", "rear left", "rear right")
AXES = ("roll", "pitch", "yaw")


SILENT = (
    "its data do not identify the vehicle: rotation and lift are uncorrelated with the motors; fly short doublets of roll, "
    "pitch, yaw and thrust"
)


class LogIssue(NamedTuple):
    """A problem of a log: fatal to identification or not, and a sentence with the remedy."""

    fatal: bool
    text: str


def check_flight(log: FlightLog, airframe: Airframe) -> tuple[LogIssue, ...]:
    """Return the issues of a log's flight, the worst first: against an approximate airframe."""
    findings = [
        *(LogIssue(False, text) for text in log.notes),
        *_time_base(log),
        *_command_rate(log),
        *_commands(log),
        *_gravity(log, airframe),
    ]
    silent = is_silent(log)
    # Where nothing follows the motors, nothing is known of their order either.
    findings += [finding for finding in _turning(log, airframe) if not (silent and finding.fatal)]
    return tuple(sorted(findings, key=lambda entry: not entry.fatal))


def is_silent(log: FlightLog) -> bool:
    """Return true for a flight in which no output follows the motors."""
    part = _longest_segment(log)
    if part is None:
        return True
    turned, thrust, lag = _changes(part, LAGS.tolist())
    turning = _explained(turned, thrust @ _gains(turned, thrust).T)
    lagged = lagging(part, [Actuator(lag, lag, 0.0)])[0]
    columns = np.column_stack([part.lift, lagged.sum(axis=1), (lagged**2).sum(axis=1)])
    # As in the windows of prediction, slow changes do not count.
    width = max(round(HORIZON / part.period), 1)
    windows = columns[: len(columns) // width * width].reshape(-1, width, 3)
    lift, *powers = (windows - windows.mean(axis=1, keepdims=True)).reshape(-1, 3).T
    return bool(max(*turning.tolist(), _explained(lift, _fitted(lift, np.column_stack(powers)))) < TELLING)


def _time_base(log: FlightLog) -> Iterator[LogIssue]:
    if log.rate < MIN_RATE:
        yield LogIssue(
            True, f"{log.rate:.0f} samples a second are too few; log gyro and motors at {COMPARED_RATE:.0f} Hz or more"
        )
    elif log.rate < USUAL_RATE:
        yield LogIssue(
            False, f"{log.rate:.0f} samples a second say little of lag and delay; {COMPARED_RATE:.0f} Hz or more would"
        )
    share = log.lost / (len(log.time) + log.lost)
    if share > MAX_LOST_SHARE:
        yield LogIssue(False, f"{log.lost:,} samples ({100.0 * share:.1f} %) are lost; use a faster card or log less")


def _command_rate(log: FlightLog) -> Iterator[LogIssue]:
    """Compare the rate of the motor commands with the log's: a logger may hold them between its own samples."""
    changes = np.any(np.diff(log.command, axis=0) != 0.0, axis=1)
    rate = float(np.count_nonzero(changes)) / log.duration
    if rate < min(USUAL_COMMAND_RATE, 0.5 * log.rate):
        text = (
            f"motor commands change {rate:.0f} times a second in a log of {log.rate:.0f} samples a second; log them at "
        )
        yield LogIssue(rate < MIN_COMMAND_RATE, f"{text}{COMPARED_RATE:.0f} Hz or more")


def _commands(log: FlightLog) -> Iterator[LogIssue]:
    outside = float(np.mean(np.any((log.command < -0.01) | (log.command > 1.01), axis=1)))
    if outside > MAX_SATURATED_SHARE:
        least, most = float(log.command.min()), float(log.command.max())
        yield LogIssue(
            True, f"motor commands go from {least:.3g} to {most:.3g} of full; correct idle and full of their scale"
        )
    full = float(np.mean(np.any(log.command >= 0.995, axis=1)))
    if outside <= MAX_SATURATED_SHARE < full:
        yield LogIssue(False, f"a motor is at full command {100.0 * full:.0f} % of the time; fly with more reserve")
    still = [name for name, column in zip(ROTORS, log.command.T, strict=True) if np.std(column) < 1e-4]
    if still:
        yield LogIssue(True, f"the commands of {', '.join(still)} never change; log all four motors")


def _gravity(log: FlightLog, airframe: Airframe) -> Iterator[LogIssue]:
    middle = float(np.median(log.acceleration[:, 2])) / airframe.vehicle.gravity
    low, high = HOVER
    for sign, axes in ((1.0, ""), (-1.0, "z points down (NED, FRD)")):
        for factor, units in (
            (1.0, ""),
            (STANDARD_GRAVITY, "values are in g, not m/s2"),
            (1.0 / STANDARD_GRAVITY, "values are in m/s2, not g"),
        ):
            if low <= sign * factor * middle <= high:
                errors = " and ".join(text for text in (axes, units) if text)
                if errors:
                    yield LogIssue(
                        True,
                        f"the accelerometer reads {middle:+.2f} g along z in flight: {errors}; correct axes or unit",
                    )
                return
    yield LogIssue(
        True,
        f"the accelerometer reads {middle:+.2f} g along z in flight, where a hovering vehicle has +1; check its unit and axes",
    )


def _turning(log: FlightLog, airframe: Airframe) -> Iterator[LogIssue]:
    """Compare angular accelerations with motor commands: in every order of the motors and with all signs of the axes."""
    part = _longest_segment(log)
    if part is None or log.rate < MIN_RATE:
        return
    turned, best, lag = _changes(part, LAGS.tolist())
    mixer = mixer_matrix(airframe.vehicle)[1:]
    gain = _gains(turned, best)
    inertia = np.array(airframe.vehicle.inertia)
    size = np.sqrt(np.mean((best @ gain.T) ** 2, axis=0) / np.maximum(np.mean(turned**2, axis=0), 1e-300))
    calm = [name for name, share in zip(AXES[:2], size.tolist(), strict=False) if share < SIZED]
    if calm:
        text = f"{' and '.join(calm)} hardly follow the motors; excite them: short doublets of some 10 degrees"
        yield LogIssue(False, text)
    if not np.any(size[:2] > SHAPED):
        return
    # Yaw is weak; where it does not follow, it decides nothing.
    weight = np.where(size > SHAPED, size, 0.0)
    order, signs = _arrangement(gain, mixer, weight)
    if order != (0, 1, 2, 3) or any(sign < 0.0 and size[k] > SHAPED for k, sign in enumerate(signs)):
        yield LogIssue(True, _disorder(order, signs, size))
        return
    full = airframe.vehicle.thrust_coefficient * airframe.vehicle.speed_max**2
    ratios = [
        float(np.linalg.norm(gain[k]) / np.linalg.norm(full * mixer[k] / inertia[k]))
        for k in range(2)
        if size[k] > SIZED
    ]
    if ratios:
        yield from _scale(float(np.exp(np.mean(np.log(ratios)))), lag)


def _longest_segment(log: FlightLog) -> LogSegment | None:
    """Return the longest of a log's stretches on a uniform grid; None where all are short."""
    longest = max(log.stretches(), key=lambda part: part.duration, default=None)
    if longest is None or longest.duration < MIN_SEGMENT:
        return None
    return resample(longest, 0, float(log.time[0]), log.duration)


def _fitted(measured: Array, columns: Array) -> Array:
    """Return the least squares fit (m,) of columns (m, k) to a series (m,)."""
    return columns @ np.linalg.lstsq(columns, measured, rcond=None)[0]


def _explained(measured: Array, modeled: Array) -> Array:
    """Return the share (...) of the variance of series (m, ...) that a model explains."""
    return 1.0 - np.var(measured - modeled, axis=0) / np.maximum(np.var(measured, axis=0), 1e-300)


def _scale(ratio: float, lag: float) -> Iterator[LogIssue]:
    if ratio > DEGREES / FACTOR:
        yield LogIssue(
            True,
            f"it turns {ratio:.0f} times as fast as the airframe could: values are in deg/s, not rad/s; correct the unit of the "
            "gyro",
        )
    elif ratio < FACTOR / DEGREES:
        yield LogIssue(
            True,
            f"it turns {1.0 / ratio:.0f} times as slowly as the airframe would: values are in rad/s, not deg/s; correct the unit",
        )
    elif not 1.0 / 1.6 < ratio < 1.6:
        how = f"{ratio:.2g} times as fast" if ratio > 1.0 else f"{1.0 / ratio:.2g} times as slowly"
        yield LogIssue(
            False,
            f"it turns {how} as the airframe would, with a lag of some {1000.0 * lag:.0f} ms: another vehicle, or the range of "
            "the gyro or the time base is wrong, often by 2; compare the length of the log with a clock",
        )


def _changes(part: LogSegment, lags: list[float]) -> tuple[Array, Array, float]:
    """Return angular accelerations (m, 3), squared lagging commands (m, 4) and their lag: about their means, best fit."""
    width = part.share * max(round(0.03 / (part.period * part.share)), 1)
    count = len(part.lift) // width * width
    means = part.gyro[:count].reshape(-1, width, 3).mean(axis=1)
    turned = np.diff(means, axis=0) / (width * part.period)
    turned -= turned.mean(axis=0)
    tried = []
    for lag in lags:
        thrust = lagging(part, [Actuator(lag, lag, 0.0)])[0][:count] ** 2
        held = thrust.reshape(-1, width, 4).mean(axis=1)
        commands = 0.5 * (held[1:] + held[:-1])
        commands -= commands.mean(axis=0)
        residuals = turned - commands @ _gains(turned, commands).T
        tried.append((float(np.sum(np.log(np.mean(residuals[:, :2] ** 2, axis=0)))), commands, lag))
    _, commands, lag = min(tried, key=lambda trial: trial[0])
    return turned, commands, lag


def _gains(turned: Array, commands: Array) -> Array:
    """Return least squares (3, 4) of turning over the motors."""
    return np.asarray(np.linalg.lstsq(commands, turned, rcond=None)[0].T, float)


def _arrangement(gain: Array, mixer: Array, weight: Array) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return the motor order and axis signs that match the gains best; unchanged in doubt."""
    shape = gain / np.maximum(np.linalg.norm(gain, axis=1, keepdims=True), 1e-300)
    form = mixer / np.linalg.norm(mixer, axis=1, keepdims=True)
    best, match = -np.inf, ((0, 1, 2, 3), (1.0, 1.0, 1.0))
    # What asks for the least change stands first, for yaw alone tells some of them apart.
    turns = ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0))
    flips = sorted(product((1.0, -1.0), repeat=3), key=lambda signs: signs.count(-1.0))
    tried = [*[(turn, (0, 1, 2, 3)) for turn in turns], *product(flips, permutations(range(4)))]
    for signs, order in tried:
        likeness = float(np.sum(weight * np.array(signs) * np.sum(shape * form[:, order], axis=1)))
        if likeness > best + 1e-3:
            best, match = likeness, (order, signs)
    return match


def _disorder(order: tuple[int, ...], signs: tuple[float, ...], size: Array) -> str:
    turned = [AXES[k] for k, sign in enumerate(signs) if sign < 0.0 and size[k] > SHAPED]
    errors = []
    if order != (0, 1, 2, 3):
        errors.append(
            f"the four motors act as {', '.join(ROTORS[k] for k in order)}: give them in the order {', '.join(ROTORS)}"
        )
    if turned:
        reason = "propellers that turn the other way than the airframe's, " if turned == ["yaw"] else ""
        errors.append(f"{' and '.join(turned)} turn against the motors: {reason}axes FRD taken for FLU, or a sign")
    return "; ".join(errors)
