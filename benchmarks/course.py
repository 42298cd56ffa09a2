"""The course that every contestant flies: a 1 m step of the Hummingbird in moderate turbulence, hybrid law in all channels.

Runge-Kutta at 1 kHz, control at 250 Hz, rotor lag, sensor noise, all meters. 64 scenarios are drawn once; a larger batch flies
them with several candidates, as a search does, so that wind and noise come from the same 80 MB for everyone. A shorter
flight is the beginning of the long one: the speed of a loop with a fixed step does not depend on the length of the flight.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from objectives import meters
from plant.law_registry import law
from plant.loop import MeterModel, Timing
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import CascadeLoop, Limits, close_loop
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.sample import Targets
from plant.records import pack

SEED, SCENARIOS, DURATION = 1, 64, 10.0
TIMING, LIMITS = Timing(0.004, 0.001), Limits(5.0, 0.17)
SUBSTEPS = TIMING.steps
POSITION_LAW, ATTITUDE_LAW = "hybrid", "hybrid"
LAST = ("dynamics", "winds", "noises")
"""Arrays whose last axis is the scenario."""


class Split(NamedTuple):
    """A batch as candidates times scenarios."""

    candidates: int
    scenarios: int


@dataclass(frozen=True)
class Course:
    """gains (30,), nominal, targets: flat records; dynamics (35, S), winds (K, 3, S), noises (K, 12, S), references (K, 14)."""

    gains: np.ndarray
    nominal: np.ndarray
    targets: np.ndarray
    dynamics: np.ndarray
    winds: np.ndarray
    noises: np.ndarray
    references: np.ndarray

    @property
    def periods(self) -> int:
        """Number of control periods of the whole flight."""
        return len(self.references)

    def nominal_record(self) -> Nominal:
        """What the controller knows, as a record."""
        return pack(Nominal, self.nominal.tolist())

    def targets_record(self) -> Targets:
        """What the meters measure against, as a record."""
        return pack(Targets, self.targets.tolist())

    def starts(self) -> np.ndarray:
        """Return the bodies (17, S) in which its flights start: hover, for its air has no mean wind."""
        from plant.quadrotor.trim import steady_flight

        return steady_flight(self.dynamics.T, np.zeros((self.dynamics.shape[1], 3))).body.T

    def part(self, scenarios: int, periods: int) -> "Course":
        """Return the first scenarios and control periods."""
        return Course(
            self.gains,
            self.nominal,
            self.targets,
            np.ascontiguousarray(self.dynamics[:, :scenarios]),
            np.ascontiguousarray(self.winds[:periods, :, :scenarios]),
            np.ascontiguousarray(self.noises[:periods, :, :scenarios]),
            np.ascontiguousarray(self.references[:periods]),
        )

    def save(self, file: Path) -> None:
        """Write the course for processes that cannot draw it."""
        np.savez(file, **vars(self))


def loop() -> CascadeLoop:
    """Return the closed loop of the course."""
    cascade = close_cascade(law(POSITION_LAW), law(ATTITUDE_LAW))
    return close_loop(cascade, MeterModel(meters.Meters, meters.start, meters.update))


def split(batch: int) -> Split:
    """Return how a batch is flown: up to 64 scenarios, the rest are candidates."""
    scenarios = min(batch, SCENARIOS)
    assert batch % scenarios == 0, batch
    return Split(batch // scenarios, scenarios)


def read(file: Path) -> Course:
    """Read a course that `Course.save` wrote."""
    with np.load(file) as stored:
        return Course(**{name: stored[name] for name in stored.files})


def draw(scenarios: int = SCENARIOS, duration: float = DURATION) -> Course:
    """Draw the course."""
    from plant.air.air import AirSpec
    from plant.quadrotor.airframes import load
    from plant.quadrotor.gains import default_row
    from plant.quadrotor.nominal import ControlOptions, nominal
    from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, sample_scenarios
    from plant.records import flatten
    from plant.references.steps import Steps

    vehicle = load("hummingbird").vehicle
    air = AirSpec(intensity="moderate", mean_wind=False)
    spec = ScenarioSpec("course", duration, Steps(x=1.0, time=min(1.0, 0.1 * duration)), air)
    inputs = sample_scenarios(spec, vehicle, TIMING, SEED, SEARCH, range(scenarios))
    rows: dict[str, Any] = {
        "dynamics": inputs.dynamics,
        "winds": inputs.disturbances,
        "noises": inputs.noises,
    }
    flat = {
        name: np.ascontiguousarray(np.concatenate(list(part), axis=-1)[..., :scenarios]) for name, part in rows.items()
    }
    return Course(
        gains=np.array(default_row(loop().cascade)),
        nominal=np.array(flatten(nominal(vehicle, ControlOptions(), TIMING.control_period)), dtype=float),
        targets=np.array(flatten(inputs.targets), dtype=float),
        references=inputs.references,
        **flat,
    )
