"""The mission floor: flights must do what they were sent for, or a tune that does nothing wins every objective of effort.

A scenario that moves asks that the median flight comes closer to the reference than one that never left its start: its root mean
square error is at most `FOLLOWED` of that one's. For a step, 0.7 is a first-order response that has made 55 % of it when the
flight ends. A scenario that rests asks that the median flight keeps to within half of the error at which a flight is lost.
Failed flights cost more than any completed one, so more than half of them must complete.

These limits are automatic: no study writes them, and each knows the key of the study that moves it. This is the general part and
that of quadrotors; `objectives.plant_mission` has that of plants of the user's own.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

import numpy as np

from objectives.metrics import MetricAddress, parse
from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from plant.errors import InputError, check_name
from plant.loop import Timing
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.scenarios import ScenarioSpec
from plant.references.spec import HOLD, PITCH, POSITION, ROLL, YAW

FOLLOWED, HELD = 0.7, 0.5
MEDIAN = Risk("quantile", 0.5)
# Metric that judges each group of columns of a reference; roll and pitch move on their own in attitude mode only.
MOVING = {"rms.position": POSITION, "rms.tilt": slice(ROLL, PITCH + 1), "rms.yaw": slice(YAW, YAW + 1)}
ANGLES = ("rms.tilt", "rms.yaw")
QUANTITIES = (*MOVING, "rms.z")
"""Everything that an automatic limit can be put on."""
FOLLOWED_KEY, HELD_KEY, OFF_KEY = "mission.followed", "mission.held", "mission.off"
"""Keys of a study that move the automatic limits of scenarios that move and that rest, and that switch them off."""


@dataclass(frozen=True)
class Mission:
    """[mission]: strictness of the automatic limits.

    Attributes:
        followed: share of the error of a flight that never leaves its start.
        held: share of the error at which a flight is lost.
        off: quantities without an automatic limit, QUANTITY or QUANTITY@SCENARIO.

    Raises InputError naming the key.
    """

    followed: float = FOLLOWED
    held: float = HELD
    off: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for key in ("followed", "held"):
            value = getattr(self, key)
            if not (isfinite(value) and 0.0 < value <= 1.0):
                allowed = "allowed: above 0 up to 1, or name the quantity in off to have no such limit"
                raise InputError(f"given {value:g}; {allowed}", key=key)

    def asks(self, quantity: str, scenario: str) -> bool:
        """Return True if a quantity of a scenario has an automatic limit."""
        return quantity not in self.off and f"{quantity}@{scenario}" not in self.off

    def check_names(self, scenarios: Iterable[str], quantities: tuple[str, ...] = QUANTITIES) -> None:
        """Raise InputError where `off` names no quantity or no scenario."""
        valid = (*quantities, *[f"{quantity}@{name}" for name in scenarios for quantity in quantities])
        for entry in self.off:
            check_name("quantity of an automatic limit", entry, valid, key="off")


USUAL = Mission()


class MissionLimit(NamedTuple):
    """An automatic limit on the median of a metric in a scenario; key: of the study, that moves it."""

    metric: MetricAddress
    scenario: str
    most: float
    key: str

    @property
    def objective(self) -> Objective:
        """The median of the metric."""
        return Objective(self.metric, MEDIAN, self.scenario)

    @property
    def constraint(self) -> Constraint:
        """The limit as a constraint."""
        return Constraint(self.objective, self.most, floor=self.key)


def is_of_mission(constraint: Constraint) -> bool:
    """Return True for an automatic limit or its replacement by the study."""
    objective = constraint.objective
    return bool(constraint.floor) or (
        objective.metric.metric.name == "rms" and objective.risk == MEDIAN and objective.scenario is not None
    )


def remaining_limits(
    limits: Iterable[MissionLimit], constraints: Iterable[Constraint], mission: Mission
) -> list[MissionLimit]:
    """Return the limits that neither `mission.off` nor the study replaces."""
    written = {constraint.objective.label for constraint in constraints}
    return [
        each for each in limits if mission.asks(each.metric.text, each.scenario) and each.objective.label not in written
    ]


def with_mission_floor(
    constraints: tuple[Constraint, ...],
    specs: Iterable[ScenarioSpec],
    limits: Limits,
    timing: Timing,
    mission: Mission = USUAL,
) -> tuple[Constraint, ...]:
    """Return the constraints of a study of a quadrotor and the floor; a limit of its own on the same quantity stands."""
    automatic = [limit for spec in specs for limit in _limits(spec, limits, timing, mission)]
    return (*constraints, *[each.constraint for each in remaining_limits(automatic, constraints, mission)])


def _limits(spec: ScenarioSpec, limits: Limits, timing: Timing, mission: Mission) -> list[MissionLimit]:
    samples = spec.track(timing).samples
    moving = [(address, error_at_start(samples, address)) for address in MOVING]
    judged = [(address, mission.followed * error, FOLLOWED_KEY) for address, error in moving if error > 0.0]
    resting = "rms.position" if np.all(samples[:, HOLD] > 0.5, axis=0) else "rms.z"
    judged = judged or [(resting, mission.held * limits.position, HELD_KEY)]
    return [MissionLimit(parse(address), spec.name, most, key) for address, most, key in judged]


def error_at_start(samples: np.ndarray, address: str) -> float:
    """Return the metric of a flight that stays at its first sample.

    samples: of its track (instants, 14).
    """
    away = samples[:, MOVING[address]] - samples[0, MOVING[address]]
    if address in ANGLES:
        away = (away + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.sqrt(np.square(away).sum(axis=1).mean(axis=0)))
