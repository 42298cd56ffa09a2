"""The Crazyflie's stabilizer around its controllers, as a process: `python stabilizer.py FOLDER`.

Runs under the Python for which the module `cffirmware` in the folder was built, and imports nothing of this tool. First a line
of JSON comes in, parameter -> value, and one goes out: what is refused, empty where nothing is. Then frames come in (`IN`, in the
firmware's own units), and each is answered by the counts of motors 1 to 4 (`OUT`).
bitcraze/crazyflie-firmware: src/modules/src/stabilizer.c, src/hal/src/sensors_bmi088_bmp3xx.c, src/modules/src/controller/.
"""

import ctypes
import importlib
import json
import os
import struct
import sys
from typing import Any  # noqa: UP035  that Python may be an old one

# Gyro x, y, z [deg/s]; roll, pitch, yaw measured and asked for [deg, pitch nose up]; thrust [counts].
IN, OUT = struct.Struct("<10d"), struct.Struct("<4H")
# Rates of stabilizer and gyro, and of the controllers [Hz]; cut-off of the gyro's low-pass [Hz].
MAIN_RATE, ATTITUDE_RATE, GYRO_CUTOFF = 1000, 500, 80.0
PIDS = {
    **{f"pid_attitude.{axis}_": f"pid{axis.capitalize()}" for axis in ("roll", "pitch", "yaw")},
    **{f"pid_rate.{axis}_": f"pid{axis.capitalize()}Rate" for axis in ("roll", "pitch", "yaw")},
}
"""Beginning of a parameter's name -> the firmware's object."""
TERMS = {"kp": "pidSetKp", "ki": "pidSetKi", "kd": "pidSetKd", "kff": "pidSetKff"}
FILTER_SWITCH = "pid_rate.rateFiltEn"
FILTERS = {
    "pid_rate.omxFiltCut": "pidRollRate",
    "pid_rate.omyFiltCut": "pidPitchRate",
    "pid_rate.omzFiltCut": "pidYawRate",
}
SETTERS = {start + term: (thing, setter) for start, thing in PIDS.items() for term, setter in TERMS.items()}
"""Gain's parameter -> object, and the function that sets it."""
SETTABLE = frozenset({*SETTERS, *FILTERS, FILTER_SWITCH})
"""Parameters that can be set: the module has no parameter table, but the objects and functions behind it."""


class Stabilizer:
    """The loop of 1 kHz: gyro's filter, controller, mixing, limits; it runs once more before the controller is due again."""

    def __init__(self, firmware: Any, parameters: dict[str, float]) -> None:
        """Set the parameters, as stored ones are when a vehicle starts."""
        self.firmware, self.tick = firmware, 0
        library = ctypes.CDLL(firmware._cffirmware.__file__)
        self.pass_gyro = library.lpf2pApply
        self.pass_gyro.restype, self.pass_gyro.argtypes = ctypes.c_float, (ctypes.c_void_p, ctypes.c_float)
        # Room for the filter's seven floats, and more.
        self.filters = [(ctypes.c_double * 16)() for _ in range(3)]
        for memory in self.filters:
            library.lpf2pInit(memory, ctypes.c_float(MAIN_RATE), ctypes.c_float(GYRO_CUTOFF))
        set_gains(library, parameters)
        firmware.controllerPidInit()
        set_filters(library, parameters)
        self.control, self.setpoint = firmware.control_t(), firmware.setpoint_t()
        self.sensors, self.state = firmware.sensorData_t(), firmware.state_t()
        self.thrusts, self.motors = firmware.motors_thrust_uncapped_t(), firmware.motors_thrust_pwm_t()
        mode = self.setpoint.mode
        mode.x = mode.y = mode.z = firmware.modeDisable
        mode.roll = mode.pitch = mode.yaw = firmware.modeAbs

    def run(self, numbers: tuple[float, ...]) -> tuple[int, int, int, int]:
        """Run until the controller is due again; return the counts of the motors."""
        seen, goal, setpoint = self.state.attitude, self.setpoint.attitude, self.setpoint
        seen.roll, seen.pitch, seen.yaw, goal.roll, goal.pitch, goal.yaw, setpoint.thrust = numbers[3:]
        for _ in range(MAIN_RATE // ATTITUDE_RATE):
            self._step(numbers[:3])
        motors = self.motors.motors
        return motors.m1, motors.m2, motors.m3, motors.m4

    def _step(self, rates: tuple[float, ...]) -> None:
        gyro, firmware = self.sensors.gyro, self.firmware
        gyro.x, gyro.y, gyro.z = map(self.pass_gyro, self.filters, rates)
        firmware.controllerPid(self.control, self.setpoint, self.sensors, self.state, self.tick)
        firmware.powerDistribution(self.control, self.thrusts)
        firmware.powerDistributionCap(self.thrusts, self.motors)
        self.tick += 1


def address(library: Any, name: str) -> Any:
    """Return the address of an object of the library."""
    return ctypes.byref(ctypes.c_char.in_dll(library, name))


def set_gains(library: Any, parameters: dict[str, float]) -> None:
    """Set gains by the firmware's own functions."""
    for name, value in parameters.items():
        if name in SETTERS:
            thing, setter = SETTERS[name]
            getattr(library, setter)(address(library, thing), ctypes.c_float(value))


def set_filters(library: Any, parameters: dict[str, float]) -> None:
    """Switch on the low-passes on D as at a vehicle's start; where parameters do."""
    if parameters.get(FILTER_SWITCH):
        for name, thing in FILTERS.items():
            cutoff = ctypes.c_float(parameters[name])
            library.filterReset(address(library, thing), ctypes.c_float(ATTITUDE_RATE), cutoff, ctypes.c_bool(True))


def main() -> None:
    """Answer until nothing more comes."""
    # What the module prints must not reach the answers.
    heard, answers = os.fdopen(os.dup(0), "rb"), os.dup(1)
    os.dup2(2, 1)
    # Our own folder holds no module for it.
    sys.path[0] = sys.argv[1]
    parameters = json.loads(heard.readline())
    try:
        stabilizer = Stabilizer(importlib.import_module("cffirmware"), parameters)
    except Exception as error:  # noqa: BLE001
        refused = f"{type(error).__name__}: {error}"
        os.write(answers, json.dumps({"refused": refused}).encode() + b"\n")
        return
    os.write(answers, json.dumps({"refused": ""}).encode() + b"\n")
    while len(frame := heard.read(IN.size)) == IN.size:
        os.write(answers, OUT.pack(*stabilizer.run(IN.unpack(frame))))


if __name__ == "__main__":
    main()
