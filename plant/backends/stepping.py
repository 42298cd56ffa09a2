"""The closed loop stepped in Python: one flight in plain floats, or many at once as NumPy arrays.

Slow and plain: it reads like the definition of a flight (`plant.closed_loop`), and the compiled lanes are tested against it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from plant.closed_loop import ClosedLoop, Limits, Timing, place
from plant.disturbance import Disturbance
from plant.nominal import Nominal
from plant.records import pack, size
from plant.references.track import Reference
from plant.rigid_body import Body, Dynamics
from plant.sensors import Noise
from plant.targets import Targets

Bind = Callable[[Callable[..., Any]], Any]


class Inputs(NamedTuple):
    """Scenario inputs of a batch of flights; a lane is one scenario.

    dynamics: (rows of Dynamics, lanes); starts: (rows of Body, lanes), about where the reference starts;
    disturbances (K, up to 12, lanes) and noises (K, up to 12, lanes): missing rows are zero; references (K, 14).
    """

    dynamics: np.ndarray
    starts: np.ndarray
    disturbances: np.ndarray
    noises: np.ndarray
    references: np.ndarray


def lane_of(drawn: Any, lane: int | slice, block: int = 0) -> Inputs:
    """Return what one lane of drawn scenarios (`plant.backends.flyer.FlightInputs`) meets, or several lanes."""
    return Inputs(
        drawn.dynamics[block, ..., lane], drawn.starts[block, ..., lane], drawn.disturbances[block, ..., lane],
        drawn.noises[block, ..., lane], drawn.references,
    )  # fmt: skip


def unchanged(function: Callable[..., Any]) -> Any:
    """Bind of the python backend: the model function itself."""
    return function


def fly_steps(
    loop: ClosedLoop, bind: Bind, gains: Any, nominal: Nominal, inputs: Inputs, targets: Targets, limits: Limits,
    timing: Timing, watch: Callable[[int, Any], None] | None = None,
) -> Any:  # fmt: skip
    """Fly to the end and return the final Flight record; watch(k, flight) sees every control instant.

    Leaves are whatever `bind` computes with: floats for one lane in the python backend, arrays over lanes in numpy.
    """
    h, plant_step = timing
    constants = bind(loop.cascade.prepare)(gains, h)
    start, decide, advance = bind(loop.start), bind(loop.decide), bind(loop.advance)
    dynamics = pack(Dynamics, inputs.dynamics)
    references = [pack(Reference, row.tolist()) for row in inputs.references]
    flight: Any = None
    for k, reference in enumerate(references):
        noise = _record(Noise, inputs.noises[k])
        disturbance = _record(Disturbance, inputs.disturbances[k])
        if k == 0:
            body = bind(place)(pack(Body, inputs.starts), reference)
            flight = start(body, constants, nominal, reference, noise, targets)
        flight = decide(flight, constants, nominal, reference, noise, targets, limits, k * h, h)
        if watch is not None:
            watch(k, flight)
        for _ in range(timing.steps):
            flight = flight._replace(body=advance(flight.body, flight.speed, disturbance, dynamics, plant_step))
    return flight


def _record(kind: Any, rows: np.ndarray) -> Any:
    zero = rows[0] * 0.0 if len(rows) else 0.0
    return pack(kind, [*rows, *[zero] * (size(kind) - len(rows))])
