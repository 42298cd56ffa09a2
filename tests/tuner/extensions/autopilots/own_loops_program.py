"""A program that speaks to the bench in doubles and flies our own attitude loops: what a perfect firmware would answer.

In: measured angles and rates, tilt, yaw rate, lift of a rotor; out: rotor thrusts. Ends where nothing more comes.
"""

import json
import struct
import sys

from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.records import pack
from tests.plant.attitude_outside import AttitudeOutside
from tuner.extensions.autopilots.instants import Instant

IN, OUT = struct.Struct("<10d"), struct.Struct("<4d")


def main():
    told = json.loads(sys.argv[1])
    cascade = close_cascade(LAWS["pid"], LAWS["betaflight"])
    known = nominal(load("racer5").vehicle, ControlOptions(delay=True), told["period"])
    loops = AttitudeOutside(cascade.attitude, pack(cascade.Gains, told["gains"]), known, told["period"])
    while len(given := sys.stdin.buffer.read(IN.size)) == IN.size:
        numbers = IN.unpack(given)
        asked = Instant(numbers[0:3], numbers[3:6], numbers[6:8], *numbers[8:])
        sys.stdout.buffer.write(OUT.pack(*loops.thrusts(asked)))
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
