"""Trials of rotorpy_hover.toml in RotorPy: a line of JSON in, a line of JSON out."""

import json
import sys
from contextlib import redirect_stdout

import numpy as np
from rotorpy.controllers.quadrotor_control import SE3Control
from rotorpy.environments import Environment
from rotorpy.trajectories.hover_traj import HoverTraj
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

RATE, SECONDS = 100, 4.0  # Hz, s
MEAN, DEVIATION, LENGTH = 3.0, 1.5, 1.0  # of the wind: m/s, m/s, s


class Gusts:
    """Wind of a first-order Gauss-Markov process, all of it from one seed."""

    def __init__(self, seed: int) -> None:
        draw = np.random.default_rng(seed)
        keep = np.exp(-1.0 / (RATE * LENGTH))
        noise = DEVIATION * draw.standard_normal((int(RATE * SECONDS) + 2, 3))
        for i in range(1, len(noise)):
            noise[i] = keep * noise[i - 1] + np.sqrt(1.0 - keep**2) * noise[i]
        self.wind = noise + np.array([MEAN, 0.0, 0.0])

    def update(self, t: float, position: np.ndarray) -> np.ndarray:
        """Return the wind [m/s] at a time [s]."""
        return self.wind[min(round(t * RATE), len(self.wind) - 1)]


def trial(seed: int, kp_pos: float, kd_pos: float, kp_att: float, kd_att: float) -> dict[str, float] | None:
    """Return the metrics of a trial; None where the vehicle was lost."""
    law = SE3Control({**quad_params, "kp_att": kp_att, "kd_att": kd_att})
    law.kp_pos, law.kd_pos = np.array([kp_pos, kp_pos, 15.0]), np.array([kd_pos, kd_pos, 9.0])
    # RotorPy draws the noise of its sensors from NumPy's global generator.
    np.random.seed(seed)
    flight = Environment(Multirotor(quad_params), law, HoverTraj(), Gusts(seed), sim_rate=RATE).run(t_final=SECONDS)
    if flight["exit"].name != "TIMEOUT":
        return None
    error = np.sqrt(np.mean(np.sum(flight["state"]["x"] ** 2, axis=1)))
    travel = np.abs(np.diff(flight["control"]["cmd_motor_speeds"], axis=0)).sum(axis=0).mean() / SECONDS
    return {"error": float(error), "travel": float(travel)}


for line in sys.stdin:
    asked = json.loads(line)
    # What RotorPy prints is no answer.
    with redirect_stdout(sys.stderr):
        metrics = trial(asked["seed"], **asked["variables"])
    answer = {"failed": True, "reason": "RotorPy lost it"} if metrics is None else {"metrics": metrics}
    print(json.dumps({"id": asked["id"], **answer}), flush=True)
