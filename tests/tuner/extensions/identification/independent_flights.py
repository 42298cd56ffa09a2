"""Flights of a simulator that shares no code with the product: many vehicles side by side, and what the product's model lacks.

Rotation matrices in place of quaternions, the midpoint rule, rotors by momentum theory: thrust exponents of 1.5 to 2, inflow of a
climb, of turning and of horizontal speed, sag, an offset center of mass, gusts, a second-order filter of the gyro, coloured noise.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

STEP, EVERY = 0.001, 2
"""Step of the integration [s], and steps from one logged sample to the next."""
GRAVITY = 9.81
X, Y, SPIN = (np.array(row, dtype=float)[:, None] for row in ([1, 1, -1, -1], [1, -1, 1, -1], [-1, 1, 1, -1]))
"""Places of the rotors in units of the arm's projections, and the signs of their reaction torques: rows front left, front right,
rear left, rear right.
"""


class Truth(NamedTuple):
    """Numbers (n,) of the vehicles, SI units.

    Attributes:
        mass: Mass.
        lever: Of a rotor along x and y.
        inertia (3, n): Moments of inertia.
        full: Thrust of a rotor at full command.
        exponent: Of thrust over rotor speed.
        speed: Of a rotor at full command [rad/s].
        lag_up: Time constant of a rotor that speeds up [s].
        lag_down: Of one that slows down [s].
        late: Steps from a command to the rotor.
        center (2, n): Center of mass from the middle of the rotors.
        torque_ratio: Yaw torque of a rotor per thrust.
        rotor_inertia: Of a rotor about its axis.
        inflow: Thrust that a rotor loses to axial speed at hover [N s/m].
        side: Drag along body x and y [N s/m].
        sag: Share of the thrust lost from begin to end.
        cutoff: Of the gyro's filter [Hz]; damping 0.7.
        gyro_noise: RMS of the gyro's white noise [rad/s].
        lift_noise: RMS of the accelerometer's [m/s2].
        gust: RMS of the wind's changes along x and y, twice that along z [m/s].
        shake (4, n): Excitation of roll and pitch [rad], yaw [rad/s] and climb [m/s2].
    """

    mass: np.ndarray
    lever: np.ndarray
    inertia: np.ndarray
    full: np.ndarray
    exponent: np.ndarray
    speed: np.ndarray
    lag_up: np.ndarray
    lag_down: np.ndarray
    late: np.ndarray
    center: np.ndarray
    torque_ratio: np.ndarray
    rotor_inertia: np.ndarray
    inflow: np.ndarray
    side: np.ndarray
    sag: np.ndarray
    cutoff: np.ndarray
    gyro_noise: np.ndarray
    lift_noise: np.ndarray
    gust: np.ndarray
    shake: np.ndarray

    @property
    def delay(self) -> np.ndarray:
        """Delay (n,) from a command to the logged rate beside the rotors' lag [s]: dead time and filter."""
        return STEP * self.late + 1.4 / (2.0 * np.pi * self.cutoff)


def draw_truths(draw: np.random.Generator, count: int) -> Truth:
    """Return vehicles of 20 g to 7 kg, log-uniform; lengths, inertias, thrusts and lags scale with mass as of real ones."""

    def between(low, high, *shape):
        return np.exp(draw.uniform(np.log(low), np.log(high), (*shape, count)))

    mass = between(0.02, 7.0)
    lever = 0.13 * np.sqrt(mass) * between(0.8, 1.25)
    # Of a cross: each arm carries a share of the mass.
    about = mass * lever**2 * between(0.25, 0.6)
    inertia = np.stack([about, about * between(1.0, 1.4), np.zeros(count)])
    inertia[2] = (inertia[0] + inertia[1]) * draw.uniform(0.75, 0.95, count)
    full = 0.25 * mass * GRAVITY * between(1.8, 5.0)
    lag = 0.03 * mass**0.2 * between(0.7, 1.4)
    speed = 900.0 * mass**-0.25 * between(0.8, 1.25)
    # Momentum theory: a rotor in hover loses about T / (4 v_i) to axial speed, v_i its induced velocity.
    radius = 0.6 * lever
    induced = np.sqrt(0.25 * mass * GRAVITY / (2.0 * 1.2 * np.pi * radius**2))
    inflow = 0.25 * mass * GRAVITY / (4.0 * induced) * between(0.5, 1.2)
    strength = between(0.4, 1.6)
    size = np.array([[0.12], [0.12], [0.8], [1.5]])
    return Truth(
        mass=mass,
        lever=lever,
        inertia=inertia,
        full=full,
        exponent=draw.uniform(1.5, 2.0, count),
        speed=speed,
        lag_up=lag,
        lag_down=lag * draw.uniform(1.0, 1.8, count),
        late=draw.integers(0, 9, count),
        center=0.03 * lever * draw.normal(size=(2, count)),
        torque_ratio=0.12 * radius * between(0.7, 1.4),
        rotor_inertia=1.6e-3 * about * between(0.5, 2.0),
        inflow=inflow,
        side=0.25 * mass * between(0.4, 2.0),
        sag=draw.uniform(0.0, 0.08, count),
        cutoff=between(60.0, 250.0),
        gyro_noise=between(0.004, 0.03),
        lift_noise=between(0.1, 0.6),
        gust=between(0.2, 1.5),
        shake=size * strength,
    )


class Recording(NamedTuple):
    """Logs: rates (steps, 3, n) [rad/s], specific force (steps, 3, n) [m/s2], commands (steps, 4, n)."""

    rates: np.ndarray
    force: np.ndarray
    commands: np.ndarray


def fly(truth: Truth, duration: float, seed: int) -> Recording:
    """Return the recording of all vehicles, shaken by sums of sines in gusts, `EVERY` steps a sample."""
    draw = np.random.default_rng((seed, 77))
    count, steps = len(truth.mass), round(duration / STEP)
    arms = np.stack([truth.lever * Y - truth.center[1], -(truth.lever * X - truth.center[0])])
    hover = (0.25 * truth.mass * GRAVITY / truth.full) ** (1.0 / truth.exponent)
    reaction = SPIN * truth.torque_ratio
    mix = np.linalg.inv(
        np.moveaxis(np.stack([np.ones((4, count)), truth.lever * Y, -truth.lever * X, reaction], axis=0), -1, 0)
    )
    attitude = np.tile(np.eye(3)[..., None], (1, 1, count))
    rate, velocity, place, wind = (np.zeros((3, count)) for _ in range(4))
    speed = np.tile(hover, (4, 1))
    filtered, slope = np.zeros((3, count)), np.zeros((3, count))
    pending = np.tile(hover, (int(truth.late.max(initial=0)) + 1, 4, 1))
    filter_step = np.array(
        [expm(STEP * np.array([[0.0, 1.0], [-(w**2), -1.4 * w]])) for w in 2.0 * np.pi * truth.cutoff]
    )
    frequency, phase = draw.uniform(0.3, 3.0, (4, 6, count)), draw.uniform(0.0, 2.0 * np.pi, (4, 6, count))
    quick = 0.25 / np.sqrt(truth.lag_up * (truth.lag_up + truth.delay))
    colour, bias = (
        np.zeros((6, count)),
        np.concatenate([0.01 * draw.normal(size=(3, count)), 0.1 * draw.normal(size=(3, count))]),
    )
    sensors = np.concatenate([np.tile(truth.gyro_noise, (3, 1)), np.tile(truth.lift_noise, (3, 1))])
    samples = steps // EVERY
    rates, force, commands = np.empty((samples, 3, count)), np.empty((samples, 3, count)), np.empty((samples, 4, count))
    measured = np.zeros((3, count))
    command = speed.copy()
    keep_wind, keep_colour = np.exp(-STEP / 0.7), np.exp(-STEP * EVERY / 0.02)
    for k in range(steps):
        time = k * STEP
        wind = keep_wind * wind + np.sqrt(1.0 - keep_wind**2) * draw.normal(size=(3, count)) * truth.gust * [
            [1.0],
            [1.0],
            [0.5],
        ]
        charge = 1.0 - truth.sag * time / duration
        if k % EVERY == 0:
            colour = keep_colour * colour + np.sqrt(1.0 - keep_colour**2) * draw.normal(size=(6, count))
            noise = sensors * (0.8 * draw.normal(size=(6, count)) + 0.6 * colour) + bias
            measured = filtered + noise[:3]
            lifted = accelerations(truth, attitude, rate, velocity - wind, speed, charge, arms)[0]
            target = truth.shake * np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1) / np.sqrt(6.0)
            roll, pitch = np.arctan2(attitude[2, 1], attitude[2, 2]), -np.arcsin(np.clip(attitude[2, 0], -1.0, 1.0))
            wanted = np.stack(
                [
                    quick**2 * 2.0 * (target[0] - roll) - 2.0 * quick * measured[0],
                    quick**2 * 2.0 * (target[1] - pitch) - 2.0 * quick * measured[1],
                    0.5 * quick * (target[2] - measured[2]),
                ]
            )
            climb = truth.mass * (GRAVITY + target[3] - 1.5 * velocity[2] - 0.5 * place[2])
            demand = np.concatenate([climb[None], truth.inertia * wanted])
            thrust = np.einsum("nij,jn->in", mix, demand)
            command = np.clip(thrust / truth.full, 0.002, 1.0) ** (1.0 / truth.exponent)
            command = np.round(2047.0 * command) / 2047.0
            rates[k // EVERY], commands[k // EVERY] = measured, command
            force[k // EVERY] = lifted + noise[3:]
        pending = np.concatenate([command[None], pending[:-1]])
        late = pending[truth.late, :, np.arange(count)].T
        lag = np.where(late > speed, truth.lag_up, truth.lag_down)
        spin_up = late + (speed - late) * np.exp(-STEP / lag)
        half = 0.5 * (speed + spin_up)
        change = (spin_up - speed) / STEP * truth.speed
        first = accelerations(truth, attitude, rate, velocity - wind, speed, charge, arms)
        mid_attitude = _turned(attitude, rate, 0.5 * STEP)
        mid_rate = rate + 0.5 * STEP * _spun(truth, rate, first[1], half, change)
        mid_velocity = velocity + 0.5 * STEP * _free(attitude, first[0])
        second = accelerations(truth, mid_attitude, mid_rate, mid_velocity - wind, half, charge, arms)
        place = place + STEP * mid_velocity
        velocity = velocity + STEP * _free(mid_attitude, second[0])
        before, rate = rate, rate + STEP * _spun(truth, mid_rate, second[1], half, change)
        attitude = _turned(attitude, mid_rate, STEP)
        mean = 0.5 * (before + rate)
        behind = np.einsum("nij,jkn->ikn", filter_step, np.stack([filtered - mean, slope]))
        filtered, slope = behind[0] + mean, behind[1]
        speed = spin_up
    return Recording(rates, force, commands)


def accelerations(truth, attitude, rate, through, speed, charge, arms):
    """Return specific force (3, n) in body axes, and torque of air and thrust (3, n); through (3, n): speed through the air."""
    air = np.einsum("jin,jn->in", attitude, through)
    # Axial speed of every rotor: of the climb, and of roll and pitch at its place.
    axial = air[2] + rate[0] * arms[0] + rate[1] * arms[1]
    hover = (0.25 * truth.mass * GRAVITY / truth.full) ** (1.0 / truth.exponent)
    across = air[0] ** 2 + air[1] ** 2
    thrust = truth.full * speed**truth.exponent - truth.inflow * (speed / hover) * axial
    thrust = thrust * (1.0 + 0.004 * across) * charge
    side = -truth.side * air
    force = np.stack([side[0], side[1], thrust.sum(axis=0) + 0.2 * side[2]]) / truth.mass
    torque = np.stack(
        [
            (thrust * arms[0]).sum(axis=0),
            (thrust * arms[1]).sum(axis=0),
            (SPIN * truth.torque_ratio * thrust).sum(axis=0),
        ]
    )
    return force, torque


def _free(attitude, force):
    """Return the acceleration (3, n) of a specific force in body axes."""
    result = np.einsum("ijn,jn->in", attitude, force)
    result[2] -= GRAVITY
    return result


def _spun(truth, rate, torque, speed, change):
    """Return the angular acceleration (3, n); change (4, n): of the rotors' speeds [rad/s2]."""
    stored = (-SPIN * truth.rotor_inertia * truth.speed * speed).sum(axis=0)
    momentum = truth.inertia * rate
    momentum[2] += stored
    gained = torque.copy()
    gained[2] += (SPIN * truth.rotor_inertia * change).sum(axis=0)
    return (gained - np.cross(rate, momentum, axis=0)) / truth.inertia


def _turned(attitude, rate, time):
    """Return attitudes (3, 3, n) turned at body rates (3, n) for a time [s], by Rodrigues' formula."""
    angle = np.sqrt((rate**2).sum(axis=0)) * time
    x, y, z = rate * time
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
    a, b = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    turn = np.eye(3)[..., None] + a * cross + b * np.einsum("ijn,jkn->ikn", cross, cross)
    return np.einsum("ijn,jkn->ikn", attitude, turn)
