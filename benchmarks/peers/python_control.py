"""python-control: the same closed loop as a sampled system, one flight through `input_output_response`.

One call of the update is one control period with its plant steps, in plain Python floats; meters are part of the state.
"""

from pathlib import Path
from typing import Any

import control
import numpy as np

from benchmarks.course import LIMITS, SUBSTEPS, TIMING, Course, loop
from benchmarks.peers.contestant import Work
from plant.quadrotor.closed_loop import hover_body, place
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.sensors import Noise
from plant.records import flatten, pack, size
from plant.references.track import Reference


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Build the system; nothing to compile."""
    assert batch == 1, "one flight"
    model, (h, plant_step) = loop(), TIMING
    nominal, targets = course.nominal_record(), course.targets_record()
    frame = pack(Dynamics, course.dynamics[:, 0].tolist())
    constants = model.cascade.prepare(pack(model.cascade.Gains, course.gains.tolist()), h)
    rest = [0.0] * (size(Disturbance) - course.winds.shape[1])

    def update(t: float, state: np.ndarray, now: np.ndarray, params: dict[str, Any]) -> list[float]:
        wind, noise, row = np.split(now, [3, 3 + size(Noise)])
        seen, goal = pack(Noise, noise.tolist()), pack(Reference, row.tolist())
        flight = pack(model.Flight, state.tolist())
        flight = model.decide(flight, constants, nominal, goal, seen, targets, LIMITS, t, h)
        body, air = flight.body, pack(Disturbance, [*wind.tolist(), *rest])
        for _ in range(SUBSTEPS):
            body = model.advance(body, flight.speed, air, frame, plant_step)
        return flatten(flight._replace(body=body))

    part = course.part(1, periods)
    given = np.concatenate([part.winds[..., 0], part.noises[..., 0], part.references], axis=1).T
    system = control.nlsys(update, None, inputs=len(given), states=size(model.Flight), dt=h)
    goal = pack(Reference, part.references[0].tolist())
    body = place(hover_body(nominal), goal)
    noise = pack(Noise, part.noises[0, :, 0].tolist())
    first = model.start(body, constants, nominal, goal, noise, targets, frame)
    respond: Any = control.input_output_response
    return lambda: respond(system, h * np.arange(periods), given, flatten(first))
