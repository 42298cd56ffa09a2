"""Where a plant rests, and its slope there over a control period: of its equations by CasADi, of an FMU by its worker process."""

from functools import singledispatch
from typing import Any

import casadi as ca
import numpy as np

from objectives.fmu.messages import Linearise
from objectives.fmu.system import FmuSystem
from objectives.margins.derivative import Derivative, column_of, record_of
from objectives.plant_system import PlantSystem
from plant.backends import symbolic
from plant.fmu.slope import Slope
from plant.model.closing import PlantLoop, resting
from plant.records import flatten, size, zeros

Array = np.ndarray


@singledispatch
def slope_of(system: Any, loop: PlantLoop, parameters: Any) -> Slope:
    """Return the body (b,) of a plant of these parameters at rest, and its derivative a period later by body and commands."""
    raise TypeError(f"nothing linearises {type(system).__name__}")


@slope_of.register
def _(system: FmuSystem, loop: PlantLoop, parameters: Any) -> Slope:
    dynamics, _ = resting(loop, parameters)
    return system.ask(Linearise(np.array(flatten(dynamics), dtype=float)))


@slope_of.register
def _(system: PlantSystem, loop: PlantLoop, parameters: Any) -> Slope:
    constants, body = (np.array(flatten(part), dtype=float) for part in resting(loop, parameters))
    b, m, shown = len(body), size(system.plant.Input), size(system.plant.Output)
    inputs, symbols = ca.SX.sym("a", b + m), ca.SX.sym("f", len(constants))
    moved = symbolic.rebinder()(loop.advance)(
        record_of(loop.Body, inputs[:b]), record_of(system.plant.Input, inputs[b:]), zeros(system.plant.Disturbance),
        record_of(loop.records.Dynamics, symbols), system.timing.plant_step,
    )  # fmt: skip
    step = Derivative("advance", inputs, [inputs, symbols], column_of(moved), ca.SX(0, 1))
    held = body[-shown - m : -shown]
    at, unit = body[None], np.eye(b + m)
    slope = unit[:b]
    for _ in range(system.timing.steps):
        at, entries, _ = step(np.concatenate([at, held[None]], axis=1), constants)
        slope = step.full(entries)[0] @ np.concatenate([slope, unit[b:]], axis=0)
    return Slope(body, slope)
