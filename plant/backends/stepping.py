"""The closed loop stepped in Python: one flight in plain floats, or many at once as NumPy arrays.

Slow and plain: it reads like the definition of a flight, and the compiled lanes are tested against it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from plant.loop import ClosedLoop, Timing
from plant.records import pack, size

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
    """Return the inputs of lanes of sampled scenarios (`plant.backends.flyer.FlightInputs`)."""
    return Inputs(
        drawn.dynamics[block, ..., lane],
        drawn.starts[block, ..., lane],
        drawn.disturbances[block, ..., lane],
        drawn.noises[block, ..., lane],
        drawn.references,
    )


def unchanged(function: Callable[..., Any]) -> Any:
    """Bind of the python backend: the model function itself."""
    return function


def fly_steps(
    loop: ClosedLoop,
    bind: Bind,
    gains: Any,
    nominal: Any,
    inputs: Inputs,
    targets: Any,
    limits: Any,
    timing: Timing,
    watch: Callable[[int, Any], None] | None = None,
) -> Any:
    """Fly to the end and return the final Flight record; watch(k, flight) sees every control instant.

    Leaves are whatever `bind` computes with: floats for one lane in the python backend, arrays over lanes in numpy.
    """
    h, plant_step = timing
    kinds = loop.records
    constants = bind(loop.prepare)(gains, h)
    start, decide, advance = bind(loop.start), bind(loop.decide), bind(loop.advance)
    dynamics = pack(kinds.Dynamics, inputs.dynamics)
    references = [pack(kinds.Reference, row.tolist()) for row in inputs.references]
    flight: Any = None
    for k, reference in enumerate(references):
        noise = _record(kinds.Noise, inputs.noises[k])
        disturbance = _record(kinds.Disturbance, inputs.disturbances[k])
        if k == 0:
            body = bind(loop.place)(pack(loop.Body, inputs.starts), reference)
            flight = start(body, constants, nominal, reference, noise, targets, dynamics)
        flight = decide(flight, constants, nominal, reference, noise, targets, limits, k * h, h)
        if watch is not None:
            watch(k, flight)
        for _ in range(timing.steps):
            flight = flight._replace(body=advance(flight.body, flight.speed, disturbance, dynamics, plant_step))
    return flight


def _record(kind: Any, rows: np.ndarray) -> Any:
    zero = rows[0] * 0.0 if len(rows) else 0.0
    return pack(kind, [*rows, *[zero] * (size(kind) - len(rows))])
