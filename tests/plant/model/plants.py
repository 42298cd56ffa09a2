"""Plants that tests fly: those of the shipped studies and a nonlinear one, as a user's file is read."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import PlantModel, plant_from
from plant.own_code import run_own_code
from plant.records import flatten, pack

ROOT = Path(__file__).parents[3]
FILES = {path.stem: path for path in (ROOT / "studies").glob("*.py")}
for name in ("pendulum", "kiln", "modal"):
    FILES[name] = Path(__file__).with_name(f"{name}.py")


def read(file: Path) -> PlantModel:
    """Return the plant of a file."""
    return plant_from(run_own_code(file).names, file.stem, str(file))


@cache
def plant_of(name: str) -> PlantModel:
    """Return a plant by the name of its file."""
    return read(FILES[name])


def system_of(name: str, channels: list[Channel], actuators: list[Actuator], timing: Timing) -> PlantSystem:
    """Return a plant under these channels."""
    plant = plant_of(name)
    return PlantSystem(plant, plan_loop(plant, channels, actuators), plant.parameters, timing)


def pid(name: str, output: str, to: str, **rest: Any) -> Channel:
    """Return a PID channel in units of the command."""
    return Channel(name, LAWS["pid"], output, to, **rest)


def cascade() -> PlantSystem:
    """Return a pendulum whose angle commands its speed, with all that an actuator can have, the outer channel at a quarter rate."""
    outer = Channel("angle", LAWS["ladrc"], "angle", "speed", b0=8.0, every=4, limit=4.0, low=-3.0, high=2.5)
    inner = pid("speed", "speed", "torque", b0=50.0, limit=50.0)
    motor = Actuator("torque", -0.6, 0.9, rate=12.0, delay=0.006, lag=0.004)
    return system_of("pendulum", [inner, outer], [motor], Timing(0.002, 0.001))


CASCADE_GAINS = np.array([4.0, 1.0, 12.0, 1500.0, 4000.0, 1.0, 0.003])
"""omega_c, zeta and omega_o of the outer channel, then kp, ki, kd and t_f of the inner one."""


def stepped(system: PlantSystem, gains: np.ndarray, drawn: Any, lane: int = 0) -> tuple[np.ndarray, Any]:
    """Fly one lane in Python: the body (K, rows) at every control instant, and the last flight."""
    seen = []
    flight = fly_steps(
        system.loop,
        unchanged,
        pack(system.loop.records.Gains, gains.tolist()),
        system.nominal,
        lane_of(drawn, lane),
        drawn.targets,
        system.limits,
        system.timing,
        lambda k, flight: seen.append(flatten(flight.body)),
    )
    return np.array(seen), flight
