"""Designs of whole cascades that several tests look at, each worked out once."""

from functools import cache
from typing import Any

import numpy as np

from objectives.design import AxisDesign, DesignRequirements, design_axes
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.cascade import AXES, close_cascade
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from tests.plant.harness import VEHICLES

TIMING = Timing(0.004, 0.001)
H = TIMING.control_period
HUMMINGBIRD = VEHICLES["hummingbird"]
REQUIREMENTS = DesignRequirements()
NAMES = ("pid", "ladrc", "hybrid")


def known(vehicle: str = "hummingbird", **options: Any) -> Nominal:
    return nominal(VEHICLES[vehicle], ControlOptions(delay=True, **options), H)


def designs(law: str, vehicle: str = "hummingbird") -> dict[str, AxisDesign]:
    return _designs(law, vehicle)


@cache
def _designs(law: str, vehicle: str) -> dict[str, AxisDesign]:
    return design_axes(close_cascade(LAWS[law], LAWS[law]), known(vehicle), TIMING)


def row_of(cascade: Any, found: dict[str, AxisDesign]) -> np.ndarray:
    return np.array([value for axis in AXES for value in found[axis].gains])
