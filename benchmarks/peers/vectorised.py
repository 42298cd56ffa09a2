"""The numpy backend: the model's functions on arrays (candidates, scenarios)."""

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.course import LIMITS, TIMING, Course, loop, split
from benchmarks.peers.contestant import Work
from plant.backends.array import rebinder
from plant.backends.stepping import Inputs, fly_steps
from plant.records import pack


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Nothing to compile."""
    candidates, scenarios = split(batch)
    part, model, bind = course.part(scenarios, periods), loop(), rebinder()
    gains = pack(model.cascade.Gains, [np.full((candidates, 1), value) for value in course.gains])
    inputs = Inputs(part.dynamics, part.starts(), part.winds, part.noises, part.references)

    def fly() -> Any:
        with np.errstate(all="ignore"):
            nominal, targets = course.nominal_record(), course.targets_record()
            return fly_steps(model, bind, gains, nominal, inputs, targets, LIMITS, TIMING)

    return fly
