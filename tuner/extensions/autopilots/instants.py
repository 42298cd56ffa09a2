"""One compiled flight that waits for rotor thrusts at every control instant (`tuner.extensions.autopilots.piloted`)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plant.backends.cache import load_kernel
from plant.backends.identity import identity
from plant.backends.lane_layout import result_rows
from plant.backends.stepping import Inputs
from plant.loop import ClosedLoop, Timing
from plant.records import flatten, paths, rows, size

BEFORE = -1
"""Instant that is given to begin a flight."""

RUN = """
@kernel
def run(gains, nominal_row, dynamics_row, start_row, disturbances, noises, references, targets_row, limits_row, h, plant_step,
        substeps, k, thrusts, state):
    nominal = load_nominal(nominal_row, 0)
    targets = load_targets(targets_row, 0)
    constants = prepare(load_gains(gains, 0), h)
    dynamics = load_dynamics(dynamics_row, 0)
    if k < 0:
        reference = load_reference(references[0], 0)
        body = place(load_start(start_row, 0), reference)
        flight = start(body, constants, nominal, reference, load_noise(noises[0], 0), targets, dynamics)
    else:
        for i in range(4):
            state[OUTSIDE + i] = thrusts[i]
        flight = decide(load_flight(state, 0), constants, nominal, load_reference(references[k], 0), load_noise(noises[k], 0),
                        targets, load_limits(limits_row, 0), k * h, h)
        store_flight(state, flight)
        disturbance = load_disturbance(disturbances[k], 0)
        for j in range(substeps):
            store_body(state, advance(load_body(state, 0), flight.speed, disturbance, dynamics, plant_step))
        flight = load_flight(state, 0)
    if k + 1 < references.shape[0]:
        flight = ask(flight, constants, nominal, load_reference(references[k + 1], 0), load_noise(noises[k + 1], 0), h)
    store_flight(state, flight)
"""


@dataclass(frozen=True)
class Instant:
    """The question to the outside at a control instant.

    Attributes:
        angles, rate: measured roll, pitch, yaw [rad] and body rates FLU [rad/s].
        tilt: roll and pitch asked for [rad].
        yaw: what the pilot asks for about z up, a rate [rad/s] or an angle [rad].
        lift: thrust asked of one rotor [N].
        yaw_rate: rate of the heading asked for [rad/s].
    """

    angles: tuple[float, float, float]
    rate: tuple[float, float, float]
    tilt: tuple[float, float]
    yaw: float
    lift: float
    yaw_rate: float = 0.0


class Stepper:
    """Flights of one loop, gains and scenario after another, instant by instant; loop, ask: of a loop flown from outside."""

    def __init__(self, loop: ClosedLoop, ask: Callable[..., Any], limits: Any, timing: Timing) -> None:
        """Load or compile the kernel."""
        self.loop = loop
        self._limits, self._timing = np.array(flatten(limits)), timing
        self.run = _kernel(loop, ask)
        control = "control"
        self.setpoint_rows = [
            paths(loop.Flight).index(f"{control}.{path}")
            for path in (
                "angles.x",
                "angles.y",
                "angles.z",
                "rate.x",
                "rate.y",
                "rate.z",
                "tilt.roll",
                "tilt.pitch",
                "controller.yaw.wish",
                "controller.yaw.rate",
            )
        ]
        self.lift = rows(loop.Flight, f"{control}.lift")
        self.outside = rows(loop.Flight, f"{control}.outside")
        self.result = result_rows(loop)

    def begin(self, gains: np.ndarray, nominal: Any, inputs: Inputs, targets: Any) -> "SteppedFlight":
        """Return a flight at its first instant; gains (g,)."""
        kinds = self.loop.records
        fixed = (
            np.ascontiguousarray(gains, dtype=float),
            np.array(flatten(nominal), dtype=float),
            inputs.dynamics.copy(),
            inputs.starts.copy(),
            _filled(inputs.disturbances, size(kinds.Disturbance)),
            _filled(inputs.noises, size(kinds.Noise)),
            inputs.references,
            np.array(flatten(targets), dtype=float),
            self._limits,
            *self._timing,
            self._timing.steps,
        )
        return SteppedFlight(self, fixed, len(inputs.references))


class SteppedFlight:
    """A flight that waits for thrusts; `instants` of them, then `result` is that of `Flyer.fly`."""

    def __init__(self, stepper: Stepper, fixed: tuple[Any, ...], instants: int) -> None:
        self._stepper, self._fixed, self.instants = stepper, fixed, instants
        self._state, self._at = np.zeros(size(stepper.loop.Flight)), BEFORE
        self._thrusts = np.zeros(4)
        self._stepper.run(*self._fixed, self._at, self._thrusts, self._state)

    @property
    def over(self) -> bool:
        """Whether every instant has had its thrusts."""
        return self._at + 1 == self.instants

    @property
    def lost(self) -> bool:
        """Whether it left its limits, so that nothing more is counted."""
        return bool(self._state[-2] != 0.0)

    @property
    def pilot_command(self) -> Instant:
        """The question of the instant that waits for thrusts."""
        seen = self._state[self._stepper.setpoint_rows].tolist()
        lift = 0.25 * float(np.sum(self._state[self._stepper.lift], axis=0))
        angles, rate, tilt = (seen[0], seen[1], seen[2]), (seen[3], seen[4], seen[5]), (seen[6], seen[7])
        return Instant(angles, rate, tilt, seen[8], lift, seen[9])

    @property
    def held(self) -> tuple[float, float, float, float]:
        """The thrusts that were last decided [N]; before the first, those that hold the vehicle where the flight begins."""
        first, second, third, fourth = self._state[self._stepper.outside].tolist()
        return first, second, third, fourth

    def fly(self, thrusts: tuple[float, float, float, float]) -> None:
        """Fly one control period.

        thrusts: New thrusts [N] in our order of the rotors.
        """
        self._at += 1
        self._thrusts[:] = thrusts
        self._stepper.run(*self._fixed, self._at, self._thrusts, self._state)

    @property
    def result(self) -> np.ndarray:
        """Meters, status and end time (rows,)."""
        return self._state[self._stepper.result].copy()


def _kernel(loop: ClosedLoop, ask: Callable[..., Any]) -> Any:
    # Here, because a list of firmwares needs no compiler.
    from plant.backends import lanes

    names, sources = lanes.kernel_names(loop)
    bind = lanes.rebinder()
    names["ask"] = bind(ask)
    kinds, flight = loop.records, loop.Flight
    body = rows(flight, "body")
    parts = [
        f"OUTSIDE = {rows(flight, 'control.outside').start}",
        lanes.vector_loaders(loop, names),
        lanes.loader(flight, "load_flight", lanes.ENTRY, 0, names),
        lanes.loader(loop.Body, "load_body", lanes.ENTRY, body.start, names),
        lanes.loader(loop.Body, "load_start", lanes.ENTRY, 0, names),
        lanes.loader(kinds.Dynamics, "load_dynamics", lanes.ENTRY, 0, names),
        lanes.loader(kinds.Disturbance, "load_disturbance", lanes.ENTRY, 0, names),
        lanes.loader(kinds.Noise, "load_noise", lanes.ENTRY, 0, names),
        lanes.storer(paths(flight), "store_flight", "a", lanes.ENTRY),
        lanes.storer(paths(loop.Body), "store_body", "a", lanes.ENTRY, body.start),
        RUN,
    ]
    module, _ = load_kernel(f"instants_{loop.name}", "\n".join(parts), names, sources | bind.sources, identity(loop))
    return module.run


def _filled(given: np.ndarray, wanted: int) -> np.ndarray:
    """Return rows (instants, wanted), those that are missing zero."""
    return np.ascontiguousarray(np.pad(given, [(0, 0), (0, wanted - given.shape[-1])]))
