"""Flights of RotorPy, a simulator that nobody here wrote: its equations and integrator, vehicles of 30 g to 6 kg."""

import json
import subprocess

import numpy as np

from tests.clients import CLIENTS
from tests.tuner.extensions.identification.independent_flights import Recording, Truth

FLY = """
import json, sys
import numpy as np
from scipy.spatial.transform import Rotation
from rotorpy.vehicles.crazyflie_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

path, seed, duration = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
draw, h = np.random.default_rng((seed, 31)), 0.002
between = lambda low, high: float(np.exp(draw.uniform(np.log(low), np.log(high))))
# Masses are log-uniform; lengths go with their square root, times with their fifth one, speeds of rotors with its inverse.
scale = between(1.0, 200.0)
arm, mass = 0.0304 * scale**0.5 * between(0.8, 1.25), 0.03 * scale
full = 0.25 * mass * 9.81 * between(1.8, 4.0)
top = 2500.0 * scale**-0.25 * between(0.8, 1.25)
x = 1.43e-5 * scale**2 * between(0.7, 1.4)
y = x * between(1.0, 1.4)
z = (x + y) * draw.uniform(0.75, 0.95)
hover = np.sqrt(mass * 9.81 / (4 * full)) * top
climb, side = mass * between(0.15, 0.6), mass * between(0.1, 0.6)
corners = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]]) * arm
center = np.array([*(0.03 * arm * draw.normal(size=2)), 0])
ratio = 0.4 * arm * between(0.7, 1.4)
parameters = {**quad_params, "mass": mass, "Ixx": x, "Iyy": y, "Izz": z, "k_eta": full / top**2, "k_m": ratio * full / top**2,
    "k_d": side / (4 * hover), "k_z": climb / (4 * hover), "tau_m": 0.03 * scale**0.1 * between(0.7, 1.4), "rotor_speed_max": top,
    "rotor_pos": {f"r{k + 1}": corners[k] - center for k in range(4)}}
vehicle = Multirotor(parameters, control_abstraction="cmd_motor_speeds")
allocation = np.linalg.inv(np.vstack([np.ones(4), corners[:, 1], -corners[:, 0], ratio * np.array([1, -1, 1, -1])]))
strength, gust, late = between(0.4, 1.6), between(0.2, 1.5), int(draw.integers(0, 5))
noise = np.array([between(0.004, 0.03)] * 3 + [between(0.1, 0.6)] * 3)
quick = 0.25 / (vehicle.tau_m + h * late)
state = {"x": np.zeros(3), "v": np.zeros(3), "q": np.array([0, 0, 0, 1.0]), "w": np.zeros(3), "wind": np.zeros(3),
         "rotor_speeds": np.full(4, hover)}
steps = round(duration / h)
time = h * np.arange(steps)[:, None]
asked = strength * np.stack([
    size * np.sin(2 * np.pi * draw.uniform(0.3, 3, 6) * time + draw.uniform(0, 2 * np.pi, 6)).sum(axis=1) / np.sqrt(6)
    for size in (0.12, 0.12, 0.8, 1.5)], axis=1)
waiting, rows, colour = [np.full(4, hover)] * (late + 1), [], np.zeros(6)
bias = draw.normal(size=6) * [0.01, 0.01, 0.01, 0.1, 0.1, 0.1]
keep, keep_colour = np.exp(-h / 0.5), np.exp(-h / 0.02)
for k in range(steps):
    turned = Rotation.from_quat(state["q"])
    roll, pitch, _ = turned.as_euler("xyz")
    colour = keep_colour * colour + np.sqrt(1 - keep_colour**2) * draw.normal(size=6)
    error = noise * (0.8 * draw.normal(size=6) + 0.6 * colour) + bias
    rate = state["w"] + error[:3]
    turn = np.array([2 * quick**2 * (asked[k, 0] - roll) - 2 * quick * rate[0],
                     2 * quick**2 * (asked[k, 1] - pitch) - 2 * quick * rate[1], 0.5 * quick * (asked[k, 2] - rate[2])])
    lift = mass * (9.81 + asked[k, 3] - 1.5 * state["v"][2] - 0.5 * state["x"][2])
    thrust = np.clip(allocation @ [lift, *(np.array([x, y, z]) * turn)], 1e-5 * full, full)
    command = np.round(2047 * np.sqrt(thrust / full)) / 2047
    waiting = [command * top, *waiting[:late]]
    control = {"cmd_motor_speeds": waiting[-1]}
    force = vehicle.statedot(state, control, h)["vdot"] + [0, 0, 9.81]
    rows.append([*rate, *(turned.inv().apply(force) + error[3:]), *command[[0, 1, 3, 2]]])
    wind = keep * state["wind"] + np.sqrt(1 - keep**2) * draw.normal(size=3) * gust * [1, 1, 0.5]
    state = vehicle.step({**state, "wind": wind}, control, h)
np.save(path, np.array(rows))
print(json.dumps({"mass": mass, "lever": arm, "inertia": [x, y, z], "full": full, "speed": top, "lag_up": vehicle.tau_m,
    "lag_down": vehicle.tau_m, "late": 2 * late, "center": center[:2].tolist(), "torque_ratio": ratio, "inflow": climb / 4}))
"""
"""Flies a vehicle of a seed: excitation, gusts, noise and dead time drawn. Its rotors weigh nothing and its gyro has no low-pass."""

SPIN = (1.0, -1.0, -1.0, 1.0)
"""Signs of the reaction torques: front left, front right, rear left, rear right."""


def is_installed() -> bool:
    """Return whether the clients hold RotorPy."""
    return (CLIENTS / "rotorpy" / "installed.txt").exists()


def fly_rotorpy(folder: str, duration: float, seed: int) -> tuple[Recording, Truth]:
    """Return the flight of the vehicle of a seed and its numbers; folder: of the array that is handed over."""
    path = f"{folder}/{seed}.npy"
    command = [str(CLIENTS / "rotorpy" / "bin" / "python"), "-c", FLY, path, str(seed), str(duration)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    rows, numbers = np.load(path)[..., None], json.loads(done.stdout)
    columns = {name: np.array(numbers.get(name, 0.0))[..., None] for name in Truth._fields}
    truth = Truth(**columns)._replace(exponent=np.array([2.0]), cutoff=np.array([np.inf]))
    return Recording(rows[:, :3], rows[:, 3:6], rows[:, 6:]), truth
