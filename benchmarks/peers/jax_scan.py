"""A JAX backend of the model in a few lines, by rebinding, and flights as jit(vmap(scan)): what a JAX user would write."""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.course import LIMITS, SUBSTEPS, TIMING, Course, loop, split
from benchmarks.peers.contestant import Work
from plant.backends.rebind import Rebinder
from plant.quadrotor.closed_loop import hover_body, place
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.sensors import Noise
from plant.records import flatten, pack, size
from plant.references.track import Reference

jax.config.update("jax_enable_x64", True)
NAMES: dict[str, Any] = {
    "absolute": jnp.abs, "asin": jnp.arcsin, "atan2": jnp.arctan2, "both": jnp.logical_and, "clip": jnp.clip, "cos": jnp.cos,
    "either": jnp.logical_or, "exp": jnp.exp, "floor": jnp.floor, "maximum": jnp.maximum, "minimum": jnp.minimum,
    "select": jnp.where, "sign": jnp.sign, "sin": jnp.sin, "sqrt": jnp.sqrt,
}  # fmt: skip


def flight_of(course: Course) -> Any:
    """Return the function (gains, dynamics, winds, noises, references) -> meters, status and end time of one flight."""
    model, bind = loop(), Rebinder(NAMES)
    start, decide, advance = bind(model.start), bind(model.decide), bind(model.advance)
    nominal, targets = course.nominal_record(), course.targets_record()
    h, plant_step = TIMING

    def as_floats(record: Any) -> Any:
        return jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=jnp.float64), record)

    def fly(gains: Any, dynamics: Any, winds: Any, noises: Any, references: Any) -> Any:
        constants = bind(model.cascade.prepare)(pack(model.cascade.Gains, list(gains)), h)
        frame = pack(Dynamics, list(dynamics))
        first = pack(Reference, list(references[0]))
        body = bind(place)(bind(hover_body)(nominal), first)
        begun = start(body, constants, nominal, first, pack(Noise, list(noises[0])), targets, frame)

        def period(flight: Any, now: Any) -> Any:
            k, wind, noise, row = now
            air = pack(Disturbance, [*wind, *[0.0] * (size(Disturbance) - len(wind))])
            seen, goal = pack(Noise, list(noise)), pack(Reference, list(row))
            flight = decide(flight, constants, nominal, goal, seen, targets, LIMITS, k * h, h)
            # A loop, not four copies: XLA compiles copies twice as long, and they fly half as fast (0.49 for 0.95 M steps/s).
            body = jax.lax.fori_loop(
                0, SUBSTEPS, lambda _, b: advance(b, flight.speed, air, frame, plant_step), flight.body
            )
            return as_floats(flight._replace(body=body)), None

        last, _ = jax.lax.scan(period, as_floats(begun), (jnp.arange(len(references)) * 1.0, winds, noises, references))
        return jnp.stack([*flatten(last.meters), last.status, last.end_time])

    return fly


def compiled(course: Course, batch: int, periods: int) -> Work:
    """Return flights of a batch, compiled: results (candidates, scenarios, rows)."""
    candidates, scenarios = split(batch)
    part = course.part(scenarios, periods)
    many = jax.vmap(flight_of(course), (None, -1, -1, -1, None))
    many = jax.vmap(many, (0, None, None, None, None))
    given = (np.tile(course.gains, (candidates, 1)), part.dynamics, part.winds, part.noises, part.references)
    arguments = [jnp.asarray(array) for array in given]
    ready = jax.jit(many).lower(*arguments).compile()
    return lambda: ready(*arguments).block_until_ready()


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Trace and compile for the batch and the length of flight."""
    return compiled(course, batch, periods)
