"""Autopilots that a study may name as its target: what [controller] is then where the study says nothing else.

The laws are the target's own loops, at its own rates; their gains are its parameters, with its defaults and its resolution, so
that what is found can be exported as it is. A range beyond the law's own is refused.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from objectives.decisions import DecisionSpace
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.gains import GainAddress
from plant.texts import PlainValue


@dataclass(frozen=True)
class StudyTarget:
    """Laws and rates of an autopilot: keys of [controller]."""

    attitude: str
    position: str
    control_period: float
    position_every: int


TARGETS = {
    # 400 Hz is IMU_GYRO_RATEMAX.
    "px4": StudyTarget("px4", "px4_position", 0.0025, 8),
    # 400 Hz is SCHED_LOOP_RATE; the position loops are our PID.
    "ardupilot": StudyTarget("ardupilot", "pid", 0.0025, 1),
    # 4 kHz is the rate of the loops on most boards; it has no position loops, so those are our PID at 250 Hz.
    "betaflight": StudyTarget("betaflight", "pid", 0.00025, 16),
    "betaflight_adrc": StudyTarget("betaflight_adrc", "pid", 0.00025, 16),
    # 500 Hz and 100 Hz are ATTITUDE_RATE and POSITION_RATE.
    "crazyflie": StudyTarget("crazyflie", "pid", 0.002, 5),
}
LAWS = ("attitude", "position")


def with_target(table: Mapping[str, PlainValue], path: Path) -> Mapping[str, PlainValue]:
    """Return the tables of a study with the [controller] of its target; InputError if the study contradicts it."""
    name, controller = table.get("target"), table.get("controller", {})
    # Types are checked with all others.
    if not isinstance(name, str) or not isinstance(controller, Mapping):
        return table
    if name not in TARGETS:
        raise UnknownNameError("target", name, TARGETS, key="target").located(file=path)
    usual = asdict(TARGETS[name])
    if controller.get("attitude", usual["attitude"]) != usual["attitude"]:
        raise InputError(
            f"given '{controller['attitude']}'; the attitude loops of '{name}' are '{usual['attitude']}': leave this key or "
            "target out",
            file=path,
            key="controller.attitude",
        )
    return {**table, "controller": {**usual, **controller}}


def check_target(space: DecisionSpace, every_gain: tuple[GainAddress, ...], present: np.ndarray | None = None) -> None:
    """Raise InputError for gains of a study beyond its target's usual ranges.

    present: gains row (g,) that a vehicle flies. Its firmware takes all of them, such as 0 Hz for a filter that is off.
    """
    spans = {gain.address: gain for gain in every_gain if not (gain.info.airframe or gain.info.firmware)}
    for variable in space.variables:
        for address in variable.addresses:
            _check_inside(spans[address], variable.name, variable.low, variable.high)
    searched = {column for group in space.columns for column in group}
    for gain in spans.values():
        is_flown = present is not None and space.base[gain.column] == present[gain.column]
        if gain.column not in searched and not is_flown:
            _check_inside(gain, gain.address, space.base[gain.column], space.base[gain.column])


def _check_inside(gain: GainAddress, key: str, low: float, high: float) -> None:
    span = gain.span
    if not span.low <= low <= high <= span.high:
        given = f"{low:g}" if low == high else f"{low:g} to {high:g}"
        raise InputError(
            f"given {given} {gain.unit} for {gain.address} ({gain.info.symbol}); allowed with this target: {span.low:g} to "
            f"{span.high:g}; or leave target out and name the laws in [controller]",
            key=key,
        )
