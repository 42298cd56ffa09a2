"""Torques of a firmware's board beside those of our law, axis by axis and sample by sample."""

import numpy as np

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.rigid_body import rotor_torque
from plant.records import pack
from plant.vectors import Rotors
from tuner.extensions.autopilots.flying import thrusts_of
from tuner.extensions.autopilots.instants import Instant

AXES = ("roll", "pitch", "yaw")
COUNT, THROTTLE = 600, 0.5
HELD = (THROTTLE,) * 4


def random_gains(law, rng, fixed):
    """Return gains by address: uniform in the law's spans, one number where the parameter is shared."""
    chosen = {}
    for gain in law.gains:
        if gain.airframe or gain.firmware:
            continue
        spans = {axis: law.span(gain, axis, "attitude") for axis in AXES}
        if gain.name in law.shared:
            value = rng.uniform(spans["roll"].low, spans["roll"].high)
            chosen |= dict.fromkeys((f"{axis}.{gain.name}" for axis in AXES), value)
        else:
            chosen |= {f"{axis}.{gain.name}": rng.uniform(span.low, span.high) for axis, span in spans.items()}
    return chosen | fixed


def motion(rng, axis, speed=0.02):
    """Return instants of rates that wander about all axes, of set points about one axis, about yaw with the rate asked for."""
    walks = np.cumsum(rng.standard_normal((COUNT, 5)), axis=0) / np.sqrt(COUNT)
    rates = speed * (walks[:, :3] + 0.02 * rng.standard_normal((COUNT, 3)))
    goals = np.zeros((COUNT, 3))
    # Never zero, where a firmware may take an error for none.
    goals[:, axis] = 1e-3 * (1.5 + 0.4 * walks[:, 3])
    turning = 2.0 * speed * walks[:, 4] * (axis == 2)
    rows = zip(rates.tolist(), goals.tolist(), turning.tolist(), strict=True)
    level = (0.0, 0.0, 0.0)
    return [Instant(level, tuple(rate), (goal[0], goal[1]), goal[2], 0.0, turn) for rate, goal, turn in rows]


def law_torques(given, instants, smoothing=1.0):
    """Return torques [N m] (n, 3) of our law; smoothing: share of a new yaw torque that its low-pass takes over."""
    law, gains, period = given.cascade.attitude, pack(given.cascade.Gains, given.gains), given.control_period
    torques = np.zeros((len(instants), 3))
    for i, axis in enumerate(AXES):
        constants = law.prepare(getattr(gains, axis), period)
        memory = law.start(constants, Measured(0.0, instants[0].rate[i]), 0.0)
        channel, last = Channel(1.0 / given.airframe.vehicle.inertia[i], 0.0), 0.0
        for k, asked in enumerate(instants):
            goal = Setpoint((*asked.tilt, asked.yaw)[i], asked.yaw_rate if i == 2 else 0.0, 0.0)
            seen = Measured(asked.angles[i], asked.rate[i])
            torque, memory = law.step(memory, constants, channel, goal, seen, Applied(0.0, 0.0), period)
            last = torque if i < 2 else last + smoothing * (torque - last)
            torques[k, i] = last
    return torques


def board_torques(board, firmware, given, instants):
    """Return torques [N m] (n, 3) of the rotors that a board commands, armed where the instants begin."""
    vehicle, rotors = given.airframe.vehicle, actuation(given.airframe.vehicle, firmware.curve)
    board.arm(instants[0], THROTTLE, HELD)
    torques = []
    for asked in instants:
        commands = board.step(asked, THROTTLE)
        assert 0.01 < min(commands) and max(commands) < 0.99
        thrusts = Rotors(*thrusts_of(commands, rotors, firmware))
        torques.append(rotor_torque(thrusts, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio))
    return np.array(torques)
