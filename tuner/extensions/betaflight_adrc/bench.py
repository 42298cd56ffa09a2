"""The simulator build of Betaflight with ADRC as a firmware.

Pull request 15400; `tuner confirm` flies finalists in it, see docs/how_to/confirm.md.
"""

import re
from collections.abc import Callable
from dataclasses import replace

from plant.errors import InputError
from plant.output_files import make_folders
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.betaflight import bench as betaflight
from tuner.extensions.betaflight.board import BetaflightBoard, shim_in
from tuner.extensions.betaflight.command_line import CommandLine
from tuner.extensions.betaflight_adrc.adrc_law import LAW
from tuner.extensions.betaflight_adrc.settings import BUILDS, SCHEDULE
from tuner.extensions.betaflight_adrc.target import TARGET

OPEN_GATE = "set adrc_liftoff_throttle = 1"
"""Line by which the gate opens as soon as there is throttle; the flights begin in the air."""
SCHEDULE_LINE = re.compile(rf"^set {SCHEDULE} = (\w+)\n", re.MULTILINE)
ALLOWED = "Allowed values"
"""Part of the answer to `get` of a setting that the program has."""
ONLY_SCHEDULE = BUILDS["pr-august"].schedule


def install(bench: Bench, content: bytes) -> Callable[[], BetaflightBoard]:
    """Set up a board whose gate opens with the throttle; raises InputError for a schedule that the program lacks."""
    text = content.decode("ascii").replace("\nsave\n", f"\n{OPEN_GATE}\nsave\n")
    if not _has_schedules(bench):
        text = SCHEDULE_LINE.sub(_only_quadratic, text)
    return betaflight.install(bench, text.encode("ascii"))


def _has_schedules(bench: Bench) -> bool:
    """Return True for a program that has the setting of the schedule; raises InputError for one without the law."""
    make_folders(bench.folder)
    line = CommandLine(bench.binary, bench.folder, shim_in(bench.folder))
    try:
        has_law, has_schedules = (ALLOWED in line.say(f"get {name}") for name in ("pid_type", SCHEDULE))
    finally:
        line.close()
    if not has_law:
        message = "has no pid_type = ADRC; build pull request 15400 as docs/how_to/confirm.md says"
        raise InputError(message, file=bench.binary, key="--binary")
    return has_schedules


def _only_quadratic(line: re.Match[str]) -> str:
    if line[1] != ONLY_SCHEDULE:
        message = f'given {line[1]}; this program has {ONLY_SCHEDULE} alone: write "attitude.schedule" = 0 in [gains]'
        raise InputError(message, key=SCHEDULE)
    return ""


BETAFLIGHT_ADRC = replace(
    betaflight.BETAFLIGHT,
    name="betaflight_adrc",
    title="Betaflight with ADRC",
    target=TARGET.name,
    law=LAW.name,
    install=install,
    loses=(
        *betaflight.BETAFLIGHT.loses,
        "The gate opens with the throttle: adrc_liftoff_throttle is 1 % in these flights.",
        "The schedule of b0 follows the collective of the mixer; that of the model has the collective of hover.",
    ),
)
"""Simulator build of the pull request as a process in lockstep."""
