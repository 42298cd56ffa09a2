"""Targets that can fly an experiment: what each can excite, and the files that make it do so.

A new one is a module with an `EXCITATIONS` and an entry here.
"""

from plant.errors import InputError, check_name
from tuner.extensions.flight_plans import ardupilot as ardupilot
from tuner.extensions.flight_plans import betaflight as betaflight
from tuner.extensions.flight_plans import excitation_table
from tuner.extensions.flight_plans.excitation_target import ExcitationTarget

MODULES = (excitation_table, ardupilot, betaflight)
EXCITERS: dict[str, ExcitationTarget] = {module.EXCITATIONS.name: module.EXCITATIONS for module in MODULES}
"""Every target that can fly an experiment, in the order of listings."""
USUAL = excitation_table.EXCITATIONS.name
INSTEAD = "take 'csv', and send it as attitude set points"
UNABLE = {
    "px4": "PX4's autotune makes steps of its own, MC_AT_SYSID_AMP rad/s high, and takes neither a band nor a length; "
    f"{INSTEAD} in offboard mode",
    "crazyflie": f"its firmware has no mode that excites; {INSTEAD} with height from a computer",
}
"""Target -> why it flies no experiment of its own, and what to do."""


def exciter(name: str) -> ExcitationTarget:
    """Return the target of a name; InputError where it cannot excite a vehicle."""
    if name in UNABLE:
        raise InputError(UNABLE[name], key="--to")
    check_name("target that can excite a vehicle", name, EXCITERS, key="--to")
    return EXCITERS[name]
