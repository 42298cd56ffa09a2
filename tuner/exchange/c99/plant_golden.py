"""Golden vectors of a plant's controller: what it takes, gives and keeps over a short flight with noise, by the model functions.

Every eighth measurement is far off, which takes commands to their limits; another eighth lies next to what is asked for, where
sliding mode laws are linear. The flight ends early where something becomes infinite or NaN, which exported C refuses.
"""

from math import isfinite
from typing import Any

import numpy as np

from plant.backends.c_code import Real
from plant.backends.stepping import lane_of
from plant.errors import InputError
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Step
from plant.records import flatten, pack, zeros
from tuner.exchange.c99.golden import FAR_OFF, NEXT_TO, OFTEN, STEPS, Log, Vectors
from tuner.exchange.c99.plant_sources import TunedPlant
from tuner.exchange.c99.precision import as_signals, matrix, rebinder, signals

# Step and noise as shares of a channel's limit; next to what is asked for, the noise is so much smaller.
STEP, NOISE, NEAR = 0.3, 0.002, 1e-2


def plant_golden(tuned: TunedPlant, real: Real, steps: int = STEPS) -> Vectors:
    """Fly the plant in float64 under its controller in that precision, and note; InputError where the first step overflows."""
    system, controller, knowledge = tuned.system, tuned.controller, tuned.system.nominal
    start, step, constants = rebinder(real)(controller.start), rebinder(real)(controller.step), tuned.constants
    drawn = system.sample(_scenario(tuned, steps), 0, "export/golden", [0])
    flown = lane_of(drawn, 0)
    loop, log, state = system.loop, Log(), None
    body, dynamics = pack(loop.Body, flown.starts.tolist()), pack(loop.records.Dynamics, flown.dynamics.tolist())
    with np.errstate(all="ignore"):
        for k, row in enumerate(flown.references):
            goals = pack(loop.records.Reference, row.tolist())
            measured = signals(tuned.Measured, _seen(tuned, body, goals, flown.noises[k], k), real)
            setpoints = [leaf for each in system.plan.outer for leaf in getattr(goals, each.name)]
            reference = signals(tuned.Reference, [[leaf] for leaf in setpoints], real)
            if state is None:
                held = as_signals(body.actuators, real, 1)
                state = as_signals(start(constants, knowledge, measured, held), real, 1)
                log.begin((measured, held), (state,))
            state = as_signals(step(state, constants, knowledge, reference, measured, tuned.period), real, 1)
            if not log.note((reference, measured), state.command, state):
                _check_flown(k, real)
                break
            try:
                body = _advanced(tuned, body, dynamics, matrix(state.in_force)[:, 0].tolist())
            except (ArithmeticError, ValueError):
                break
    return log.vectors()


def _check_flown(steps: int, real: Real) -> None:
    if not steps:
        raise InputError(
            f"given gains under which the first command is no finite {real.name}; take others", key="gains"
        )


def _scenario(tuned: TunedPlant, steps: int) -> PlantScenario:
    """A step of every outer channel after a tenth of the flight, with noise on all that is measured."""
    plan, duration = tuned.system.plan, steps * tuned.period
    sizes = {each.name: each.limit if isfinite(each.limit) else 1.0 for each in plan.channels}
    noises = {name: sizes[each.name] for each in plan.channels for name in (each.rate_output, each.output) if name}
    return PlantScenario(
        "golden",
        duration,
        references={each.name: Step(STEP * sizes[each.name], 0.1 * duration) for each in plan.outer},
        sensors={name: SensorNoise(NOISE * width) for name, width in noises.items()},
    )


def _seen(tuned: TunedPlant, body: Any, goals: Any, noise: np.ndarray, k: int) -> list[list[float]]:
    """Return the measurements at a step, a row for each output that channels read."""
    outputs = tuned.system.plant.Output._fields
    errors = dict(zip(outputs, noise.tolist(), strict=True))
    shown = dict(zip(outputs, flatten(body.shown), strict=True))
    if k % OFTEN == OFTEN - 1:
        errors = {name: FAR_OFF * error for name, error in errors.items()}
    if k % OFTEN == NEXT_TO:
        for each in tuned.system.plan.outer:
            shown[each.output] = getattr(goals, each.name).value
            errors[each.output] *= NEAR
    return [[shown[name] + errors[name]] for name in tuned.Measured._fields]


def _advanced(tuned: TunedPlant, body: Any, dynamics: Any, command: list[float]) -> Any:
    """Return the body one period later."""
    system = tuned.system
    quiet = zeros(system.plant.Disturbance)
    for _ in range(system.timing.steps):
        body = system.loop.advance(body, pack(system.plant.Input, command), quiet, dynamics, system.timing.plant_step)
    return body
