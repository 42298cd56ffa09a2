"""A closed loop, whatever flies in it: the types of its records, and the functions that every backend runs.

A flight is a sampled system: sense, decide, hold, fly, judge. At t = k h the controller measures, decides and the meters look;
the command that is in force is held for the period while the plant is integrated in sub-steps.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from plant.records import parts, paths, source_of

# Squared size of the state beyond which a flight counts as non-finite; comparisons with NaN are false.
LARGEST_STATE = 1e12


class Timing(NamedTuple):
    """Control period [s] and plant step [s]."""

    control_period: float
    plant_step: float

    @property
    def steps(self) -> int:
        """Number of plant steps in a control period."""
        return round(self.control_period / self.plant_step)

    @property
    def halved(self) -> "Timing":
        """The same with plant steps half as long."""
        return self._replace(plant_step=0.5 * self.plant_step)


@dataclass(frozen=True)
class MeterModel:
    """Streaming accumulators of a flight, supplied by the study's metrics.

    Meters: record type; start(sample, targets) -> Meters; update(meters, sample, targets, h) -> Meters.
    """

    Meters: Any
    start: Callable[..., Any]
    update: Callable[..., Any]


class LoopRecords(NamedTuple):
    """Types of the records that a closed loop is handed.

    Attributes:
        Gains: type of the controller's gains.
        Nominal: its knowledge of the plant.
        Reference, Disturbance, Noise: one of each for every control period.
        Dynamics: constants of the plant that flies.
        Targets, Limits: levels and bands that meters judge by, and states beyond which a flight ends.
        n_wind_leaves: number of leaves of Disturbance that are not zero in most batches; a compiler sees the zeros.
    """

    Gains: Any
    Nominal: Any
    Reference: Any
    Disturbance: Any
    Noise: Any
    Dynamics: Any
    Targets: Any
    Limits: Any
    n_wind_leaves: int


@dataclass(frozen=True)
class ClosedLoop:
    """A closed loop bound to a controller and to meters.

    Attributes:
        name: name of its kernels.
        records: types of all that it is handed.
        Flight: record of everything that changes; its parts are body, speed (the command to the plant), whatever
            the controller keeps, meters, status and end_time, the last three last.
        prepare(gains, h) -> Constants.
        place(body, reference) -> the body where the reference starts.
        start(body, constants, nominal, reference, noise, targets, dynamics) -> Flight.
        decide(flight, constants, nominal, reference, noise, targets, limits, time, h) -> Flight at a control
            instant.
        advance(body, speed, disturbance, dynamics, plant_step) -> Body over one plant step.
    """

    name: str
    records: LoopRecords
    Constants: Any
    Flight: Any
    prepare: Callable[..., Any]
    place: Callable[..., Any]
    start: Callable[..., Any]
    decide: Callable[..., Any]
    advance: Callable[..., Any]

    @property
    def Body(self) -> Any:  # noqa: N802
        """Type of the state of the plant."""
        return self.Flight.__annotations__["body"]

    @property
    def Meters(self) -> Any:  # noqa: N802
        """Type of its meters."""
        return self.Flight.__annotations__["meters"]

    @property
    def results(self) -> tuple[str, ...]:
        """Names of the numbers of a flight that backends return: the meters, status and end time."""
        return (*paths(self.Meters), "status", "end_time")

    @property
    def sources(self) -> set[Path]:
        """Files that its records were written in."""
        kinds = [self.Flight, self.Constants, *self.records[:-1]]
        return {source_of(part) for kind in kinds for part in parts(kind)}
