"""The closed loop compiled for one flight at a time: what the lanes backend is measured against, never used by a study.

Same model functions, same compiler and flags, threads over flights by `prange`; only the lanes are missing.
"""

from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from plant.backends import lanes
from plant.backends.cache import load_kernel
from plant.backends.flyer import FlightInputs
from plant.backends.identity import identity
from plant.backends.lane_layout import result_rows
from plant.loop import ClosedLoop, Timing
from plant.records import flatten, paths, size

# The flight is a function of its own because `prange` cannot carry records into a thread, only arrays and numbers.
RUN = """
@inline
def fly_one(gains, nominal_row, dynamics_row, start_row, disturbances, noises, references, targets_row, limits_row, h, plant_step,
            substeps, out):
    nominal = load_nominal(nominal_row, 0)
    targets = load_targets(targets_row, 0)
    limits = load_limits(limits_row, 0)
    constants = prepare(load_gains(gains, 0), h)
    dynamics = load_dynamics(dynamics_row, 0)
    reference = load_reference(references[0], 0)
    body = place(load_body(start_row, 0), reference)
    flight = start(body, constants, nominal, reference, load_noise(noises[0], 0), targets, dynamics)
    for k in range(references.shape[0]):
        reference = load_reference(references[k], 0)
        disturbance = load_disturbance(disturbances[k], 0)
        flight = decide(flight, constants, nominal, reference, load_noise(noises[k], 0), targets, limits, k * h, h)
        body = flight.body
        for j in range(substeps):
            body = advance(body, flight.speed, disturbance, dynamics, plant_step)
        flight = with_body(flight, body)
    store_result(out, flight)


@jit(parallel=True, fastmath=FAST_MATH, error_model="numpy")
def run(gains, nominal_row, dynamics_rows, start_rows, disturbances, noises, references, targets_row, limits_row, h, plant_step,
        substeps, out):
    flights = dynamics_rows.shape[0]
    for i in prange(gains.shape[0] * flights):
        fly_one(gains[i // flights], nominal_row, dynamics_rows[i % flights], start_rows[i % flights], disturbances[i % flights],
                noises[i % flights], references, targets_row, limits_row, h, plant_step, substeps,
                out[i // flights, i % flights])
"""


@dataclass(frozen=True)
class ScalarKernel:
    """A compiled loop that flies one flight at a time."""

    run: Any
    rows: int
    loop: ClosedLoop

    def fly(
        self, gains: np.ndarray, nominal: Any, inputs: FlightInputs, limits: Any, timing: Timing, threads: int
    ) -> np.ndarray:
        """Fly every candidate through every scenario: results (candidates, scenarios, rows) as those of `Flyer.fly`."""
        numba.set_num_threads(threads)
        out = np.empty((len(gains), inputs.count, self.rows))
        h, plant_step = timing
        kinds = self.loop.records
        self.run(
            gains,
            np.array(flatten(nominal), dtype=float),
            _flat(inputs.dynamics, size(kinds.Dynamics))[: inputs.count],
            _flat(inputs.starts, size(self.loop.Body))[: inputs.count],
            _flat(inputs.disturbances, size(kinds.Disturbance))[: inputs.count],
            _flat(inputs.noises, size(kinds.Noise))[: inputs.count],
            inputs.references,
            np.array(flatten(inputs.targets), dtype=float),
            np.array(flatten(limits)),
            h,
            plant_step,
            timing.steps,
            out,
        )
        return out


def _flat(blocks: np.ndarray, rows: int) -> np.ndarray:
    """Turn (blocks, ..., rows, lanes) into (scenarios, ..., rows), missing rows zero."""
    moved = np.moveaxis(blocks, -1, 1)
    flat = moved.reshape(-1, *moved.shape[2:])
    missing = rows - flat.shape[-1]
    return np.ascontiguousarray(np.pad(flat, [(0, 0)] * (flat.ndim - 1) + [(0, missing)]))


def scalar_kernel(loop: ClosedLoop) -> ScalarKernel:
    """Return the scalar kernel of a loop: from the cache, or compiled by its first call."""
    names, sources = lanes.kernel_names(loop)
    flight, kinds = loop.Flight, loop.records
    result = result_rows(loop)
    parts = [
        lanes.vector_loaders(loop, names),
        lanes.loader(kinds.Dynamics, "load_dynamics", lanes.ENTRY, 0, names),
        lanes.loader(loop.Body, "load_body", lanes.ENTRY, 0, names),
        lanes.loader(kinds.Disturbance, "load_disturbance", lanes.ENTRY, 0, names),
        lanes.loader(kinds.Noise, "load_noise", lanes.ENTRY, 0, names),
        lanes.body_setter(flight, names),
        lanes.storer(paths(flight)[result], "store_result", "a", lanes.ENTRY),
        RUN,
    ]
    names["prange"] = numba.prange
    module, _ = load_kernel(f"scalar_{loop.name}", "\n".join(parts), names, sources, identity(loop))
    return ScalarKernel(module.run, result.stop - result.start, loop)
