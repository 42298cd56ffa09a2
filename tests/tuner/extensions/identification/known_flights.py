"""Flights of vehicles whose numbers are known: the plant's own equations, a small controller, and what spoils a log.

Many flights are integrated side by side, few one by one. Each has its own vehicle, drawn about the airframe that is the prior, wind, noise of the
gyro and the accelerometer, commands in 16 bits, a delay, a bias and samples that are lost.
"""

from typing import NamedTuple

import numpy as np

from plant.backends.array import rebinder
from plant.primitives import clip, floor, sqrt
from plant.quadrotor.airframes import load
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.nominal import mixer_matrix
from plant.quadrotor.rigid_body import Body, Dynamics, axpy_body, body_rate, dynamics
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten, pack, zeros
from plant.vectors import Rotors, Vec3, renormalize, to_body
from tuner.extensions.logs.flight_log import FlightLog

PERIOD = 0.002
AIRFRAME = load("crazyflie-pybullet")
PRIOR = AIRFRAME.vehicle
AXES = ("roll", "pitch", "yaw", "lift")
FEW = 4
"""Flights that are quicker one by one: an operation on arrays takes as long as one on so many numbers."""
GYRO, LIFT = 0.02, 0.4
"""RMS of the sensors' noise: [rad/s], [m/s2]."""
DAMPING = PRIOR.drag_linear.z * PRIOR.rotor_y.r1**2
"""Of roll and pitch by rotors that climb as the vehicle turns [N m s]: each has a quarter of the drag of a climb."""


class KnownFlight(NamedTuple):
    """A log and the truth behind it: the vehicle, and the dead time from a logged command to the rotors [s]."""

    log: FlightLog
    vehicle: Vehicle
    dead_time: float


def drawn_vehicle(draw):
    """A vehicle about the prior: what people weigh and measure to 2 %, the rest to tens of per cent."""
    factor = np.exp(draw.normal(size=10) * [0.02, 0.02, 0.2, 0.2, 0.1, 0.15, 0.3, 0.2, 0.5, 0.3])
    lag = 0.04 * factor[6]
    x, y = (float(PRIOR.inertia[k] * factor[2 + k]) for k in (0, 1))
    # A share of 0.775 as the prior, below 1.
    inertia = Vec3(x, y, min(0.775 * float(factor[4]), 0.98) * (x + y))
    damping = float(DAMPING * factor[8])
    return PRIOR._replace(
        mass=PRIOR.mass * factor[0],
        inertia=inertia,
        thrust_coefficient=PRIOR.thrust_coefficient * factor[5],
        rotor_x=Rotors(*[factor[1] * x for x in PRIOR.rotor_x]),
        rotor_y=Rotors(*[factor[1] * y for y in PRIOR.rotor_y]),
        lag_up=lag,
        lag_down=lag * 1.3,
        torque_ratio=PRIOR.torque_ratio * factor[7],
        rate_damping=Vec3(damping, damping, 0.0),
        rotor_inertia=PRIOR.rotor_inertia * factor[9],
    )


def known_flights(
    count, duration: float | list[float] = 12.0, seed=1, excited=AXES, turbulence: float | np.ndarray = 1.0, lost=0.005
):
    """Fly and return so many flights.

    duration: of all or of each [s]; excited: axes that are shaken, of all or of each; turbulence: factor on what the air does.
    """
    shakes = list(excited) if excited and not isinstance(excited[0], str) else [excited] * count
    draws = [np.random.default_rng((seed, i)) for i in range(count)]
    vehicles = [drawn_vehicle(draw) for draw in draws]
    lengths = [round(each / PERIOD) for each in (duration if isinstance(duration, list) else [duration] * count)]
    delays = [int(draw.integers(0, 5)) for draw in draws]
    shaken = _together([_shaken(draw, n, axes) for draw, n, axes in zip(draws, lengths, shakes, strict=True)])
    air = np.asarray(turbulence) * _together([_air(draw, n) for draw, n in zip(draws, lengths, strict=True)])
    spread = [GYRO, GYRO, GYRO, LIFT]
    noise = _together([draw.normal(size=(n, 4)) * spread for draw, n in zip(draws, lengths, strict=True)])
    rates, lifts, commands = _flown(vehicles, shaken, air, noise, delays)
    flights = []
    for i, (draw, steps) in enumerate(zip(draws, lengths, strict=True)):
        kept = draw.random(steps) >= lost
        push = np.zeros((steps, 3))
        push[:, 2] = lifts[:steps, i] + 0.1 * draw.normal()
        time = PERIOD * np.arange(float(steps))
        log = FlightLog(
            f"log {i}",
            "made",
            "0" * 64,
            time,
            rates[:steps, :, i] + 0.01 * draw.normal(size=3),
            push,
            commands[:steps, :, i],
        )
        flights.append(KnownFlight(log.where(kept), vehicles[i], PERIOD * delays[i]))
    return flights


def _together(series):
    """Series (steps, k) of flights side by side (longest, k, flights); the shorter ones end with zeros."""
    longest = max(map(len, series))
    return np.stack([np.pad(each, ((0, longest - len(each)), (0, 0))) for each in series], axis=-1)


def _shaken(draw, steps, excited):
    """What is asked for (steps, 4): roll and pitch [rad], yaw rate [rad/s], climb [m/s2]: sums of sines."""
    time = PERIOD * np.arange(steps)[:, None]
    found = np.zeros((steps, 4))
    for k, (axis, size) in enumerate(zip(AXES, (0.12, 0.12, 0.8, 1.5), strict=True)):
        frequency, phase = draw.uniform(0.3, 3.0, 6), draw.uniform(0.0, 2.0 * np.pi, 6)
        if axis in excited:
            found[:, k] = size * np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1) / np.sqrt(6.0)
    return found


def _air(draw, steps):
    """Angular accelerations [rad/s2] and accelerations [m/s2] that the air makes (steps, 6), of 0.3 s memory."""
    keep = np.exp(-PERIOD / 0.3)
    found, state = np.empty((steps, 6)), np.zeros(6)
    kicks = draw.normal(size=(steps, 6)) * np.sqrt(1.0 - keep**2) * [1.0, 1.0, 0.5, 0.2, 0.2, 0.1]
    for k, kick in enumerate(kicks):
        state = keep * state + kick
        found[k] = state
    return found


def _flown(vehicles, shaken, air, noise, delays):
    """Fly all and return measured rates (steps, 3, n), lift (steps, n) and commands (steps, 4, n)."""
    constants = np.array([flatten(dynamics(vehicle)) for vehicle in vehicles]).T
    if len(vehicles) > FEW:
        delays, each = np.array(delays), np.arange(len(vehicles))
        late = lambda commands, k: commands[np.maximum(k - delays, 0), :, each].T  # noqa: E731
        return _flown_steps(rebinder(), constants, shaken, air, noise, late)
    alone = []
    for i, delay in enumerate(delays):
        late = lambda commands, k, delay=delay: commands[max(k - delay, 0)].tolist()  # noqa: E731
        numbers, ask, gust, error = (part[..., i].tolist() for part in (constants, shaken, air, noise))
        alone.append(_flown_steps(lambda model: model, numbers, ask, gust, error, late))
    return [np.stack(part, axis=-1) for part in zip(*alone, strict=True)]


def _flown_steps(bind, constants, shaken, air, noise, late):
    """Fly numbers or arrays side by side.

    bind: makes functions of the model for them; late(commands, step): what reaches the rotors at a step.
    """
    step, rate, angles, inside = (bind(f) for f in (_midpoint_step, body_rate, euler_angles, to_body))
    bounded, root, whole = (bind(f) for f in (_bounded, _root, _whole))
    f = pack(Dynamics, constants)
    full = PRIOR.thrust_coefficient * PRIOR.speed_max**2
    mixer, inertia = np.linalg.inv(mixer_matrix(PRIOR)).tolist(), PRIOR.inertia
    calm = Disturbance(*[zeros(Vec3)] * 4)
    still = 0.0 * f.gravity
    start = root(f.gravity / (4.0 * f.inverse_mass * f.thrust_coefficient))
    body = pack(Body, [*[still] * 6, 1.0 + still, *[still] * 6, *[start] * 4])
    rates, lifts, commands = (np.empty((len(shaken), *size, *np.shape(still))) for size in ((3,), (), (4,)))
    for k, (ask, gust, error) in enumerate(zip(shaken, air, noise, strict=True)):
        roll, pitch, _ = angles(body.attitude)
        p, q, r = body.rate.x + error[0], body.rate.y + error[1], body.rate.z + error[2]
        climb = PRIOR.mass * (PRIOR.gravity + ask[3] - 1.5 * body.velocity.z - 0.5 * body.position.z)
        turn_x = inertia.x * (64.0 * (ask[0] - roll) - 14.0 * p)
        turn_y = inertia.y * (64.0 * (ask[1] - pitch) - 14.0 * q)
        turn_z = inertia.z * 4.0 * (ask[2] - r)
        rates[k] = p, q, r
        commands[k] = [
            whole(65535.0 * root(bounded((a * climb + b * turn_x + c * turn_y + d * turn_z) / full))) / 65535.0
            for a, b, c, d in mixer
        ]
        speed = Rotors(*(PRIOR.speed_max * sent for sent in late(commands, k)))
        pushed = calm._replace(angular_acceleration=Vec3(*gust[:3]), acceleration=Vec3(*gust[3:]))
        now = rate(body, speed, pushed, f)
        free = Vec3(now.velocity.x, now.velocity.y, now.velocity.z + f.gravity)
        lifts[k] = inside(body.attitude, free).z + error[3]
        body = step(body, now, speed, pushed, f, PERIOD)
    return rates, lifts, commands


def _midpoint_step(body, now, command, disturbance, f, h):
    """Advance by h from a state and its rate: of second order, with a third of the rates of the plant's own method."""
    middle = body_rate(axpy_body(body, 0.5 * h, now), command, disturbance, f)
    end = axpy_body(body, h, middle)
    return Body(end.position, end.velocity, renormalize(end.attitude), end.rate, end.rotor_speed)


def _bounded(share):
    return clip(share, 0.01, 1.0)


def _root(a):
    return sqrt(a)


def _whole(a):
    return floor(a + 0.5)


def truth_of(flight):
    """The numbers behind a flight by the names of the coordinates."""
    vehicle, full = flight.vehicle, flight.vehicle.thrust_coefficient * PRIOR.speed_max**2
    x, y, z = vehicle.inertia
    # An identified airframe keeps its thrust coefficient, so its rotors turn the faster the more they lift.
    turned = (
        vehicle.rotor_inertia / PRIOR.rotor_inertia * np.sqrt(PRIOR.thrust_coefficient / vehicle.thrust_coefficient)
    )
    return {
        "mass": vehicle.mass,
        "arm": vehicle.rotor_x.r1 / PRIOR.rotor_x.r1,
        "inertia.x": x,
        "inertia.y": y,
        "inertia_share": z / (x + y),
        "thrust.30": 0.09 * full,
        "thrust.65": 0.4225 * full,
        "thrust.100": full,
        "lag_up": vehicle.lag_up,
        "lag_down": vehicle.lag_down,
        "dead_time": flight.dead_time,
        "centre.x": 0.0,
        "centre.y": 0.0,
        "torque_ratio": vehicle.torque_ratio,
        "drag_linear.z": vehicle.drag_linear.z,
        "rate_damping": vehicle.rate_damping.x,
        "rotor_inertia": turned,
    }


def misses(found, flight):
    """Distances of what was identified from the truth of a flight, in its standard deviations, by name."""
    return distances(found, truth_of(flight))


def distances(found, truth):
    """Distances of what was identified from true numbers by name, in its standard deviations, by name."""
    deviations = np.sqrt(np.diag(found.fit.covariance))
    return {
        entry.name: (value - (np.log(truth[entry.name]) if entry.positive else truth[entry.name])) / deviation
        for entry, value, deviation in zip(
            found.space.parameters, found.fit.estimate.tolist(), deviations.tolist(), strict=True
        )
        if entry.name in truth
    }
