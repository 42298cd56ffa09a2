"""The parts of every reference: a validated description, and the samples that the closed loop reads.

References are relative: position (0, 0, 0) is where the scenario hovers. The vehicle starts at rest at the first
sample, so every reference has zero velocity at t = 0.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plant.origin import Origin
from plant.references.parameters import check_numbers

POSITION, VELOCITY, ACCELERATION = slice(0, 3), slice(3, 6), slice(6, 9)
ROLL, PITCH, YAW, YAW_RATE, HOLD = 9, 10, 11, 12, 13
WIDTH = 14
"""Columns of `Track.samples`, the leaves of `plant.references.track.Reference` in their order."""


@dataclass(frozen=True)
class Track:
    """A reference sampled at t_k = k dt, in SI units and radians, world ENU.

    Attributes:
        samples: (K, 14) float64, columns as named in this module.
        start, final: (6,), levels r0 and r1 of the axes before and after the step, equal on an axis that makes none.
        step_time: when the step happens [s]; 0 where no axis makes one.
    """

    samples: np.ndarray
    start: np.ndarray
    final: np.ndarray
    step_time: float


@dataclass(frozen=True, kw_only=True)
class ReferenceSpec(ABC):
    """A reference as a study file describes it: frozen, checked when made (InputError with the field as key).

    kind: name in study files. origin: the file or package that it comes from, None where it is bundled.
    """

    kind: ClassVar[str]
    origin: ClassVar[Origin | None] = None

    def __post_init__(self) -> None:
        """Check every number against its declared range."""
        check_numbers(self)

    @abstractmethod
    def track(self, t: np.ndarray) -> Track:
        """Return the reference at times t (K,) [s], which start at 0 and increase."""


def blank(steps: int) -> np.ndarray:
    """Return samples (steps, 14) of holding position 0, level, yaw 0."""
    samples = np.zeros((steps, WIDTH))
    samples[:, HOLD] = 1.0
    return samples


def without_step(samples: np.ndarray) -> Track:
    """Return the track of a reference that makes no step: both levels are those of the first sample."""
    level = samples[0, [0, 1, 2, ROLL, PITCH, YAW]]
    return Track(samples, level, level.copy(), 0.0)


def motion(
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    yaw: np.ndarray | float = 0.0,
    yaw_rate: np.ndarray | float = 0.0,
) -> Track:
    """Return the track of a motion without a step: position and its derivatives (K, 3), yaw and its rate (K,)."""
    samples = blank(len(position))
    samples[:, POSITION], samples[:, VELOCITY], samples[:, ACCELERATION] = position, velocity, acceleration
    samples[:, YAW], samples[:, YAW_RATE] = yaw, yaw_rate
    return without_step(samples)


def build(spec: ReferenceSpec, dt: float, steps: int) -> Track:
    """Return the reference of `spec` at t_k = k dt, k = 0..steps-1; InputError if a step comes after the end."""
    assert dt > 0.0, dt
    assert steps > 0, steps
    return spec.track(dt * np.arange(steps))
