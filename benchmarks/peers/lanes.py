"""Our lanes: the kernel that every study runs on."""

from pathlib import Path

import numpy as np

from benchmarks.course import LIMITS, TIMING, Course, loop, split
from benchmarks.peers.contestant import Work
from plant.backends.flyer import FlightInputs, Flyer, to_lanes
from plant.threads import available_threads


def inputs_of(course: Course) -> FlightInputs:
    """Lay a course out in blocks of lanes."""
    dynamics, starts, winds, noises = (
        to_lanes(np.moveaxis(part, -1, 0)) for part in (course.dynamics, course.starts(), course.winds, course.noises)
    )
    return FlightInputs(
        dynamics, starts, winds, noises, course.references, course.targets_record(), course.dynamics.shape[-1]
    )


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Load or compile the kernel (into `scratch`, see `benchmarks.peers.worker`)."""
    candidates, scenarios = split(batch)
    inputs = inputs_of(course.part(scenarios, periods))
    flyer = Flyer(loop(), LIMITS, TIMING, threads or available_threads())
    nominal, gains = course.nominal_record(), np.tile(course.gains, (candidates, 1))
    flyer.fly(gains[:1], nominal, inputs_of(course.part(1, 1)))
    return lambda: flyer.fly(gains, nominal, inputs)
