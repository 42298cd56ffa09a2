"""The mission floor: flights must do what they were sent for, or a tune that does nothing wins every objective of effort.

A scenario that moves asks that the median flight comes closer to the reference than one that never left its start: its root mean
square error is at most `FOLLOWED` of that one's. For a step, 0.7 is a first-order response that has made 55 % of it when the
flight ends. A scenario that rests asks that the median flight keeps to within half of the error at which a flight is lost.
Failed flights cost more than any completed one, so more than half of them must complete.
"""

from collections.abc import Iterable

import numpy as np

from objectives.metrics import parse
from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from plant.closed_loop import Limits, Timing
from plant.references.spec import HOLD, PITCH, POSITION, ROLL, YAW
from plant.scenarios import ScenarioSpec

FOLLOWED, HELD = 0.7, 0.5
MEDIAN = Risk("quantile", 0.5)
# Metric that judges each group of columns of a reference; roll and pitch move on their own in attitude mode only.
MOVING = {"rms.position": POSITION, "rms.tilt": slice(ROLL, PITCH + 1), "rms.yaw": slice(YAW, YAW + 1)}
ANGLES = ("rms.tilt", "rms.yaw")


def mission_floor(specs: Iterable[ScenarioSpec], limits: Limits, timing: Timing) -> tuple[Constraint, ...]:
    """Return what every scenario asks at least, as constraints beside those of the study."""
    return tuple(
        Constraint(Objective(parse(address), MEDIAN, spec.name), most, floor=True)
        for spec in specs
        for address, most in _asked(spec, limits, timing)
    )


def with_mission_floor(
    constraints: tuple[Constraint, ...], specs: Iterable[ScenarioSpec], limits: Limits, timing: Timing
) -> tuple[Constraint, ...]:
    """Return the constraints of a study and the floor; where the study limits the same quantity itself, its limit stands."""
    own = {constraint.objective.label for constraint in constraints}
    floor = mission_floor(specs, limits, timing)
    return (*constraints, *[entry for entry in floor if entry.objective.label not in own])


def _asked(spec: ScenarioSpec, limits: Limits, timing: Timing) -> list[tuple[str, float]]:
    samples = spec.track(timing).samples
    moving = [(address, error_at_start(samples, address)) for address in MOVING]
    asked = [(address, FOLLOWED * error) for address, error in moving if error > 0.0]
    resting = "rms.position" if np.all(samples[:, HOLD] > 0.5, axis=0) else "rms.z"
    return asked or [(resting, HELD * limits.position)]


def error_at_start(samples: np.ndarray, address: str) -> float:
    """Return the metric of a flight along samples (instants, 14) that never leaves the first of them."""
    away = samples[:, MOVING[address]] - samples[0, MOVING[address]]
    if address in ANGLES:
        away = (away + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.sqrt(np.square(away).sum(axis=1).mean(axis=0)))
