"""crazyflow: its own closed loop (Crazyflie, first-principles dynamics, Mellinger controller) after a 1 m step.

Single precision, as it is made for; Runge-Kutta at 1 kHz, state and attitude control at 250 Hz; no wind, noise or meters.
"""

from pathlib import Path

import jax
import numpy as np
from crazyflow.control import Control
from crazyflow.dynamics import Dynamics
from crazyflow.sim import Sim
from crazyflow.sim.integration import Integrator

from benchmarks.course import SUBSTEPS, Course
from benchmarks.peers.contestant import Work

# Position, velocity, acceleration, attitude (scalar last), rates.
STATE_LENGTH, SCALAR = 16, 12


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Build a simulation of that many worlds and compile its step."""
    rate = 250
    sim = Sim(
        n_worlds=batch,
        n_drones=1,
        dynamics=Dynamics.first_principles,
        control=Control.state,
        integrator=Integrator.rk4,
        freq=rate * SUBSTEPS,
        state_freq=rate,
        attitude_freq=rate,
        body_rate_freq=rate,
        force_torque_freq=rate,
        device="cpu",
    )
    goal = np.zeros((batch, 1, STATE_LENGTH), dtype=np.float32)
    goal[..., 0] = goal[..., 2] = goal[..., SCALAR] = 1.0

    def fly() -> None:
        sim.reset()
        sim.state_control(goal)
        sim.step(SUBSTEPS * periods)
        jax.block_until_ready(sim.data.states.pos)

    fly()
    return fly
