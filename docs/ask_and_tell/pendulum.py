"""Trials of pendulum.toml in Gymnasium's Pendulum-v1: a line of JSON in, a line of JSON out."""

import json
import sys

import gymnasium
import numpy as np

PERIOD, BAND = 0.05, 0.05  # s, rad
START = {"x_init": 0.3, "y_init": 0.5}  # largest angle [rad] and rate [rad/s] at the start, drawn from the seed
environment = gymnasium.make("Pendulum-v1", max_episode_steps=100)


def trial(seed: int, kp: float, kd: float) -> dict[str, float] | None:
    """Return the metrics of a trial; None where the pendulum fell."""
    (cosine, sine, rate), _ = environment.reset(seed=seed, options=START)
    torques, settled, step, ended = [], 0.0, 0, False
    while not ended:
        angle = np.arctan2(sine, cosine)
        if abs(angle) > 1.5:
            return None
        torques.append(np.clip(-kp * angle - kd * rate, -2.0, 2.0))
        (cosine, sine, rate), _, _, ended, _ = environment.step(np.array([torques[-1]]))
        step += 1
        settled = step * PERIOD if abs(np.arctan2(sine, cosine)) > BAND else settled
    return {"settling_time": settled, "torque": float(np.mean(np.abs(torques)))}


for line in sys.stdin:
    asked = json.loads(line)
    metrics = trial(asked["seed"], **asked["variables"])
    answer = {"failed": True, "reason": "it fell"} if metrics is None else {"metrics": metrics}
    print(json.dumps({"id": asked["id"], **answer}), flush=True)
