"""Largest tilt of a flight: how near it came to the limit of its tilt. No metric of studies, because plants have no tilt."""

from typing import NamedTuple

import numpy as np

from objectives.metrics.address import MetricAddress
from objectives.metrics.metric import Accumulator, Metric
from plant.primitives import cos, minimum
from plant.quadrotor.sample import Sample, Targets


class Tilt(NamedTuple):
    """cosine: smallest cosine of the angle between thrust and vertical."""

    cosine: float


def start(sample: Sample, targets: Targets) -> Tilt:  # noqa: ARG001
    """Begin level."""
    return Tilt(1.0)


def update(tilt: Tilt, sample: Sample, targets: Targets, h: float) -> Tilt:  # noqa: ARG001
    """Take one more instant."""
    return Tilt(minimum(tilt.cosine, cos(sample.roll.actual) * cos(sample.pitch.actual)))


TILT = MetricAddress(
    "tilt",
    Metric(
        name="tilt",
        symbol="theta_max",
        title="largest tilt",
        unit="rad",
        scope="flight",
        definition="largest angle between thrust and vertical",
        value=lambda view: np.arccos(np.clip(view.accumulated.cosine, -1.0, 1.0)),
        bound=lambda _: np.pi,
        accumulator=Accumulator(Tilt, start, update),
    ),
    (),
)
