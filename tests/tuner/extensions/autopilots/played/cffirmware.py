"""Plays the Crazyflie's Python module: the same names, our own reading of its loops, gains in a library as the true one has them.

Its gyro is not filtered. The test compiles played.c beside it as `_cffirmware.so`.
"""

import ctypes
from pathlib import Path
from types import SimpleNamespace

_cffirmware = SimpleNamespace(__file__=str(Path(__file__).with_name("_cffirmware.so")))
library = ctypes.CDLL(_cffirmware.__file__)
modeDisable, modeAbs, modeVelocity = range(3)  # noqa: N816
PERIOD = 0.002
AXES = ("Roll", "Pitch", "Yaw")


def vector():
    return SimpleNamespace(x=0.0, y=0.0, z=0.0)


def attitude_t():
    return SimpleNamespace(roll=0.0, pitch=0.0, yaw=0.0)


def control_t():
    return SimpleNamespace(roll=0, pitch=0, yaw=0, thrust=0.0)


def setpoint_t():
    names = ("x", "y", "z", "roll", "pitch", "yaw", "quat")
    return SimpleNamespace(attitude=attitude_t(), thrust=0.0, mode=SimpleNamespace(**dict.fromkeys(names, modeDisable)))


def sensorData_t():  # noqa: N802
    return SimpleNamespace(gyro=vector())


def state_t():
    return SimpleNamespace(attitude=attitude_t())


def motors_thrust_uncapped_t():
    return SimpleNamespace(motors=SimpleNamespace(m1=0, m2=0, m3=0, m4=0))


motors_thrust_pwm_t = motors_thrust_uncapped_t


class Pid:
    """P, I in force at once, D on the measurement, feed-forward of what is asked for."""

    def __init__(self, name):
        gains = ctypes.c_float * 5
        self.gains, self.sum, self.last = gains.in_dll(library, f"pid{name}"), 0.0, 0.0

    def reset(self, measured):
        self.sum, self.last = 0.0, measured

    def update(self, asked, measured):
        kp, ki, kd, kff, _ = self.gains
        self.sum += PERIOD * (asked - measured)
        turning, self.last = (measured - self.last) / PERIOD, measured
        return kp * (asked - measured) + ki * self.sum - kd * turning + kff * asked


outer, inner = [Pid(axis) for axis in AXES], [Pid(f"{axis}Rate") for axis in AXES]
ticks = []


def controllerPidInit():  # noqa: N802
    print("printed while it starts")


def controllerPid(control, setpoint, sensors, state, tick):  # noqa: N802
    if ticks != list(range(tick)) or setpoint.mode.z != modeDisable or setpoint.mode.yaw != modeAbs:
        raise AssertionError("ticks are counted from 0, thrust and angles are asked for")
    ticks.append(tick)
    seen, goal = state.attitude, setpoint.attitude
    angles, goals = (seen.roll, seen.pitch, seen.yaw), (goal.roll, goal.pitch, goal.yaw)
    if tick % 2 == 0:
        rates = sensors.gyro.x, -sensors.gyro.y, sensors.gyro.z
        asked = list(map(Pid.update, outer, goals, angles))
        roll, pitch, yaw = map(int, map(Pid.update, inner, asked, rates))
        control.roll, control.pitch, control.yaw = roll, pitch, -yaw
    control.thrust = setpoint.thrust
    if setpoint.thrust == 0.0:
        control.roll = control.pitch = control.yaw = 0
        for loop, angle in zip([*outer, *inner], (*angles, 0.0, 0.0, 0.0), strict=True):
            loop.reset(angle)


def powerDistribution(control, asked):  # noqa: N802
    r, p = int(control.roll / 2.0), int(control.pitch / 2.0)
    motors, thrust, yaw = asked.motors, control.thrust, control.yaw
    motors.m1, motors.m2 = int(thrust - r + p + yaw), int(thrust - r - p - yaw)
    motors.m3, motors.m4 = int(thrust + r - p + yaw), int(thrust + r + p - yaw)


def powerDistributionCap(asked, given):  # noqa: N802
    over = max(0, *(count - 65535 for count in vars(asked.motors).values()))
    for name, count in vars(asked.motors).items():
        setattr(given.motors, name, max(count - over, 0))
