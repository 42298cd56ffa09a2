"""The Crazyflie's native attitude loops as parameters, gain by gain.

Around them is our PID in the form of its position loops. Other terms of the firmware (feed-forward, D and I where ours have none)
keep the vehicle's value if it is known, and are 0 otherwise.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import radians

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.quadrotor.cascade import ATTITUDE_AXES, POSITION_AXES
from tuner.exchange.aboard import VehicleParameters
from tuner.extensions.autopilots.native_loops import NativeLaw, native_gains
from tuner.extensions.autopilots.parameters import Values
from tuner.extensions.autopilots.pid import held_tilt, with_gains
from tuner.extensions.crazyflie.map import (
    FILTER_CUTOFFS,
    FILTER_SWITCH,
    NAMES,
    TABLE,
    TILT,
    Units,
    pid_gains,
    units,
    values,
)
from tuner.gains import Controller

NATIVE_LAW = NativeLaw(
    "crazyflie",
    {
        axis: {
            **{f"angle_{term}": f"pid_attitude.{axis}_k{term}" for term in "pid"},
            **{term: f"pid_rate.{axis}_k{term}" for term in ("p", "i", "d", "ff")},
        }
        for axis in ATTITUDE_AXES
    },
    frozenset({"p", "i", "d", "ff"}),
)
CARRIED = frozenset(
    {
        *NATIVE_LAW.parameters,
        FILTER_SWITCH,
        *FILTER_CUTOFFS.values(),
        *TILT,
        *(name for axis in POSITION_AXES for name in NAMES[axis][:3]),
    }
)
"""Parameters that our loops carry."""


def native_values(controller: Controller, full: float, present: VehicleParameters | None) -> dict[str, float]:
    """Return the parameters that are written, unrounded; full: thrust of one motor at 65535 counts [N].

    present: what is on the vehicle. Raises InputError naming gain or airframe where the firmware has no such loop.
    """
    every = values(controller, full, POSITION_AXES, {} if present is None else present.values)
    every |= NATIVE_LAW.to_parameters(controller, units(controller, full).turning) | _filters(controller)
    return every if present is None else {name: value for name, value in every.items() if name in CARRIED}


def _filters(controller: Controller) -> dict[str, float]:
    cutoffs = {axis: gains["d_cutoff"] for axis, gains in native_gains(controller, NATIVE_LAW.law).items()}
    on = {cutoff > 0.0 for cutoff in cutoffs.values()}
    if len(on) > 1:
        given = ", ".join(f"{cutoff:g} Hz for {axis}" for axis, cutoff in cutoffs.items())
        raise InputError(
            f"given {given}; {FILTER_SWITCH} switches the filter of all three axes", key="attitude.d_cutoff"
        )
    if on == {False}:
        return {FILTER_SWITCH: 0.0}
    return {FILTER_SWITCH: 1.0, **{FILTER_CUTOFFS[axis]: cutoff for axis, cutoff in cutoffs.items()}}


def native_held(controller: Controller, one: Units, written: Values, filters: Mapping[str, float]) -> Controller:
    """Return the controller that the firmware flies; written: complete; filters: t_f of our position loops by axis [s]."""
    on = written[FILTER_SWITCH] != 0.0
    gains = {
        axis: row._replace(d_cutoff=written[FILTER_CUTOFFS[axis]] if on else 0.0)
        for axis, row in NATIVE_LAW.to_gains(written, one.turning, controller).items()
    }
    limited = replace(controller, options=replace(controller.options, tilt_limit=held_tilt(radians(written[TILT[0]]))))
    return with_gains(limited, {**gains, **pid_gains(one, written, filters)})


def check_names(given: Values, file: ReadableFile) -> None:
    """Refuse a file without any parameter of these loops; raises InputError naming the file."""
    if not TABLE.keys() & given.keys():
        raise InputError(
            "holds no parameter of pid_attitude, pid_rate, posCtlPid or velCtlPid", file=file, key="params"
        )
