"""Flights of an FMU: the model functions of controller and meters in Python, the plant by steps of an instance.

The plant gets the mean of a lagged actuator's exact output over a step: the FMU holds its inputs over each.
"""

from collections.abc import Callable, Sequence
from math import exp, nan
from typing import Any

import numpy as np

from plant.backends.stepping import Inputs
from plant.loop import Timing
from plant.model.closing import PlantLoop
from plant.records import flatten, pack, size
from plant.status import NON_FINITE
from tuner.extensions.fmu.instance import FmuError, Instance

Watch = Callable[[int, Any], None]


class FmuPlant:
    """An instance as the plant of a loop.

    period: of control [s]. failed: what the FMU said where it ended a flight, else "".
    """

    def __init__(self, loop: PlantLoop, instance: Instance, timing: Timing) -> None:
        self._loop, self._instance, self._timing = loop, instance, timing
        self._parameters = size(loop.plant.Parameters)
        self.period = timing.control_period
        self.failed = ""

    def begin(self, dynamics: Sequence[float], states: Sequence[float] | None = None) -> Any:
        """Return the body with which a flight starts; dynamics: its constants."""
        self._poles = list(dynamics[self._parameters :])
        self._instance.begin(dynamics[: self._parameters], states)
        _, held, _ = self._loop.plant.at_rest(None)
        return self._body(list(held), self._instance.shown())

    def advance(self, body: Any, command: Sequence[float], disturbance: Sequence[float], start: float) -> Any:
        """Return the body a control period later; start: of the period [s].

        It is no number once the FMU has failed.
        """
        step = self._timing.plant_step
        positions = list(body.actuators)
        try:
            for j in range(self._timing.steps):
                means, positions = _lagged(positions, command, self._poles, step)
                self._instance.move([*means, *disturbance], start + j * step, step)
            return self._body(positions, self._instance.shown())
        except FmuError as error:
            self.failed = self.failed or str(error)
            return pack(self._loop.Body, [nan] * size(self._loop.Body))

    def _body(self, actuators: list[float], shown: list[float]) -> Any:
        n = size(self._loop.plant.State)
        return pack(self._loop.Body, [*shown[:n], *actuators, *shown[n:]])


def _lagged(
    at: Sequence[float], command: Sequence[float], poles: Sequence[float], step: float
) -> tuple[list[float], list[float]]:
    """Return actuators' mean output over a step [s] and their output after it: without a lag, the command."""
    means, after = [], []
    for position, wanted, pole in zip(at, command, poles, strict=True):
        left = exp(-pole * step) if pole > 0.0 else 0.0
        means.append(wanted + (position - wanted) * (1.0 - left) / (pole * step) if pole > 0.0 else wanted)
        after.append(wanted + (position - wanted) * left)
    return means, after


def fly(
    loop: PlantLoop,
    fmu_plant: FmuPlant,
    gains: np.ndarray,
    nominal: Any,
    inputs: Inputs,
    targets: Any,
    limits: Any,
    timing: Timing,
    watch: Watch | None = None,
) -> Any:
    """Fly to the end or a failure; return the final Flight record.

    watch(k, flight) sees every instant. Raises FmuError where the FMU cannot be begun.
    """
    h, kinds = timing.control_period, loop.records
    noises = [pack(kinds.Noise, row) for row in inputs.noises.tolist()]
    references = [pack(kinds.Reference, row) for row in inputs.references.tolist()]
    disturbances = inputs.disturbances.tolist()
    constants = loop.prepare(pack(kinds.Gains, gains.tolist()), h)
    body = fmu_plant.begin(inputs.dynamics.tolist())
    dynamics = pack(kinds.Dynamics, inputs.dynamics.tolist())
    flight = loop.start(body, constants, nominal, references[0], noises[0], targets, dynamics)
    for k, reference in enumerate(references):
        try:
            flight = loop.decide(flight, constants, nominal, reference, noises[k], targets, limits, k * h, h)
        except (ArithmeticError, ValueError):
            # Compiled functions give infinity or NaN where those of Python raise.
            flight = flight._replace(status=NON_FINITE)
        if watch is not None:
            watch(k, flight)
        if flight.status > 0.0:
            break
        flight = flight._replace(body=fmu_plant.advance(flight.body, flight.speed, disturbances[k], k * h))
    return flight


def result(loop: PlantLoop, flight: Any) -> list[float]:
    """Return the numbers of a flight as backends return them: meters, status, end time [s]."""
    return [*flatten(flight.meters), flight.status, flight.end_time]
