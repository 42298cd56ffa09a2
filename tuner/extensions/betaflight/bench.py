"""Betaflight's simulator build on the bench: the settings that let a computer fly it, and what of them the gains' file decides.

Facts of Betaflight 2025.12: src/main/fc/rc.c, flight/pid.c, flight/mixer.c, src/platform/SIMULATOR/sitl.c.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from plant.errors import InputError
from plant.laws.channel import Measured, Setpoint
from plant.quadrotor.airframes.actuation import Actuation
from tuner.extensions.autopilots.firmware import Bench, Firmware, period_check
from tuner.extensions.betaflight.board import BetaflightBoard, Sticks, shim_in
from tuner.extensions.betaflight.command_line import load
from tuner.extensions.betaflight.wiring import learn_wiring

# The gyro's period [s] and the most of them in a period of the loops.
GYRO_PERIOD, MAX_DIVIDER = 125e-6, 16
# Full deflection of the yaw stick [deg/s].
YAW_RATE = 100
# Full deflection of the other sticks where they ask for rates [deg/s]; in angle mode it cancels.
TILT_RATE = 200
SETTINGS = {
    "gyro_calib_noise_limit": 0, "baro_hardware": "NONE", "pwr_on_arm_grace": 1, "small_angle": 180,
    "runaway_takeoff_prevention": "OFF", "failsafe_delay": 200, "motor_pwm_protocol": "PWM", "motor_idle": 0, "min_check": 1000,
    "rates_type": "ACTUAL", "rc_smoothing": "OFF", "throttle_boost": 0,
    **{f"{axis}_{name}": TILT_RATE // 10 for axis in ("roll", "pitch") for name in ("rc_rate", "srate")},
    **{f"yaw_{name}": YAW_RATE // 10 for name in ("rc_rate", "srate")},
    **{f"{axis}_expo": 0 for axis in ("roll", "pitch", "yaw")},
}  # fmt: skip
"""Sensors that need no calibration, arming without a person, sticks that are set points, motor commands from 0 to 1."""
MODES = ("aux 0 0 0 1700 2100 0 0", "aux 1 1 1 1700 2100 0 0")
"""Arming by the first switch, angle mode by the second."""
ANGLE_LIMIT = re.compile(r"^set angle_limit = (\d+)\s*$", re.MULTILINE)


def heading_rate(constants: Any, setpoint: Setpoint, measured: Measured) -> float:
    """Rate of yaw that the pilot asks for: the heading loop, which Betaflight leaves to its pilot."""
    return constants.outer * (setpoint.value - measured.value) + setpoint.rate


def bench_lines(rotors: Actuation, control_period: float) -> list[str]:
    """Return the command lines that set up the bench, without gains."""
    settings: dict[str, object] = {
        **SETTINGS,
        "pid_process_denom": round(control_period / GYRO_PERIOD),
        "yaw_motors_reversed": "OFF" if rotors.rotors[0].spin > 0.0 else "ON",
    }
    return [*(f"set {name} = {value}" for name, value in settings.items()), *MODES, "save"]


def install(bench: Bench, content: bytes) -> Callable[[], BetaflightBoard]:
    """Set up a board with the bench's settings, then the gains' file; as a person loads it."""
    text = content.decode("ascii")
    match = ANGLE_LIMIT.search(text)
    if match is None:
        raise InputError("the exported file sets no angle_limit, by which sticks are scaled", key="angle_limit")
    if any(mount.x * mount.y == 0.0 for mount in bench.rotors.rotors):
        raise InputError("the frame is a plus; the bench needs an X, Betaflight's mixer QUADX", key="airframe")
    bench.folder.mkdir(parents=True, exist_ok=True)
    shim = shim_in(bench.folder)
    for lines in (bench_lines(bench.rotors, bench.control_period), text.splitlines()):
        load(bench.binary, bench.folder, shim, lines)
    sticks = Sticks(float(match[1]), float(YAW_RATE))
    power_up = partial(BetaflightBoard, bench.binary, bench.folder, shim, sticks, bench.control_period)
    spins = [mount.spin for mount in bench.rotors.rotors]
    return partial(power_up, learn_wiring(power_up, spins, bench.control_period, bench.binary))


BETAFLIGHT = Firmware(
    name="betaflight",
    title="Betaflight",
    target="betaflight",
    file="gainproof.betaflight.txt",
    law="betaflight",
    heading=heading_rate,
    curve=None,
    binary="the program of its simulator build, under obj/",
    check=period_check(
        lambda period: period / GYRO_PERIOD,
        1,
        MAX_DIVIDER,
        f"Betaflight's loops run each 0.125 ms times 1 to {MAX_DIVIDER}",
    ),
    program=Path,
    install=install,
    lockstep=True,
    loses=(
        "Sticks are whole microseconds: angle_limit/500 of tilt (0.06 deg at 30 deg), 0.2 deg/s of yaw rate, 0.1 % of throttle.",
        "The gyro is read each 0.125 ms: a sample of ours as often as fits into a control period; its second low-pass runs then.",
        "The gyro is read in steps of 0.061 deg/s, the attitude in steps of 0.1 deg, motor commands in steps of 0.1 %.",
    ),
)
