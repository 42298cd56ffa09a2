"""RotorPy's batched multirotor on torch: its own Hummingbird and SE(3) controller after a 1 m step.

Runge-Kutta at 1 kHz, control at 250 Hz; its motor noise, but no wind, sensor noise or meters.
"""

from pathlib import Path

import torch
from rotorpy.controllers.quadrotor_control import BatchedSE3Control
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams

from benchmarks.course import SUBSTEPS, TIMING, Course
from benchmarks.peers.contestant import Work


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Build vehicles and controllers; nothing to compile."""
    device = torch.device("cpu")
    params = BatchedMultirotorParams([quad_params] * batch, batch, device)
    zeros = torch.zeros(batch, 3, dtype=torch.float64)
    hover = (quad_params["mass"] * 9.81 / (4.0 * quad_params["k_eta"])) ** 0.5
    begin = {
        "x": zeros,
        "v": zeros,
        "q": torch.tensor([0.0, 0.0, 0.0, 1.0], dtype=torch.float64).repeat(batch, 1),
        "w": zeros,
        "wind": zeros,
        "rotor_speeds": torch.full((batch, 4), hover, dtype=torch.float64),
    }
    vehicle = BatchedMultirotor(params, batch, begin, device, integrator="rk4")
    controller = BatchedSE3Control(params, batch, device)
    goal = {key: zeros for key in ("x_dot", "x_ddot", "x_dddot")} | {
        "x": torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64).repeat(batch, 1),
        "yaw": torch.zeros(batch, dtype=torch.float64),
        "yaw_dot": torch.zeros(batch, dtype=torch.float64),
    }

    def fly() -> None:
        state = {key: value.clone() for key, value in begin.items()}
        with torch.no_grad():
            for k in range(periods):
                command = controller.update(k * TIMING.control_period, state, goal)
                for _ in range(SUBSTEPS):
                    state = vehicle.step(state, command, TIMING.plant_step)

    return fly
