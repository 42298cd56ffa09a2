"""Controllers for the tests of exports."""

from functools import cache

from plant.law_registry import law
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tuner.gains import Controller

# Every worker makes two hundred controllers where cases are collected.
airframe_called = cache(load)


def controller(
    position="ladrc", attitude="hybrid", airframe="hummingbird", period=0.004, options=None, every=1, **gains
):
    """A law's default gains with some replaced, written roll__kp=60."""
    cascade = close_cascade(law(position), law(attitude), every)
    row = default_row(cascade)
    columns = {gain.address: gain.column for gain in gain_addresses(cascade)}
    for name, value in gains.items():
        row[columns[name.replace("__", ".")]] = float(value)
    frame = airframe if not isinstance(airframe, str) else airframe_called(airframe, allow_unphysical=True)
    return Controller(frame, cascade, options or ControlOptions(), period, period / 4.0, tuple(row))


def pid(airframe="hummingbird", **gains):
    """A PID in both loops that every autopilot's form can hold: ki below kp^2/(4 kd)."""
    values = {
        **{
            f"{axis}__{name}": value
            for axis in ("x", "y", "z")
            for name, value in (("kp", 2.5), ("ki", 0.3), ("kd", 2.6))
        },
        **{
            f"{axis}__{name}": value
            for axis in ("roll", "pitch")
            for name, value in (("kp", 90.0), ("ki", 60.0), ("kd", 15.0))
        },
        "yaw__kp": 50.0,
        "yaw__ki": 40.0,
        "yaw__kd": 9.0,
    }
    return controller("pid", "pid", airframe, **{**values, **gains})
