"""The interface of a simulated system: a quadrotor, a user-defined plant, an FMU.

Callers use these members and never test the type of a system.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self

import numpy as np

from objectives.failure_modes import FailureMode
from objectives.metrics.address import Axes, MetricAddress
from objectives.metrics.context import Bounds
from plant.backends.flyer import FlightInputs, Recording
from plant.laws.law import Law
from plant.loop import ClosedLoop, Timing
from plant.own_code import OwnCode
from plant.quadrotor.gains import GainAddress
from plant.seeds import RandomSource
from plant.status import Status

OnFlightsDone = Callable[[int], None]
NOT_FINITE = ("not finite", "finite numbers")
"""Cause of a flight that ended non-finite, and the limit that it exceeded."""


class Scenario(Protocol):
    """One kind of flight, with a name and a duration [s].

    The name is unique in a study, which flies the scenario through many draws.
    """

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def duration(self) -> float: ...  # noqa: D102

    def steps(self, timing: Timing) -> int:
        """Return the number of control periods."""
        ...


@dataclass(frozen=True)
class FlightBatch:
    """The flights of one scenario: which stream they are drawn from, and those from `start` to before `count`."""

    spec: Any
    stream: str
    count: int
    start: int = 0


class FlightBackend(Protocol):
    """Flies the closed loop of a system, see `plant.backends.flyer.Flyer`.

    Attributes:
        rows: Number of rows of a flight's result.
        cached: Whether nothing has to be compiled.
        records: Whether `fly` takes a recording.
        arithmetic: Name of its bits, see `objectives.engine`.
        say: Receives one line about flights that failed for reasons of the backend.
    """

    loop: ClosedLoop
    threads: int
    rows: int
    cached: bool
    records: bool
    arithmetic: str
    say: Callable[[str], None]

    def at(self, timing: Timing) -> Self:
        """Return the same with another plant step."""
        ...

    def fly(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        on_flights_done: OnFlightsDone | None = None,
        recording: Recording | None = None,
    ) -> np.ndarray:
        """Fly candidates (n, gains) through every scenario; return results (n, scenarios, rows)."""
        ...

    def trace(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        every: int = 1,
        traced: Sequence[int] | np.ndarray | None = None,
    ) -> np.ndarray:
        """Fly one candidate (gains,) and return every `every`-th instant (scenarios, instants, rows)."""
        ...


class SystemParts(Protocol):
    """Names and numbers from which a system is built; can be pickled.

    The user's code that it needs has to run first.
    """

    def system(self) -> "FlownSystem": ...  # noqa: D102


class FlownSystem(Protocol):
    """A closed loop under study; a frozen dataclass.

    Args:
        loop: The closed loop with its meters, and those of `metered`.
        limits: The record of states beyond which a flight ends.
        timing: Control period and plant step.
        nominal: The record of the controller's knowledge of the plant.
        watched: Signals that no law controls, with meters of their own.
        metered: Metrics whose own accumulators run with every flight.
        gains: All gains in the column order of a gains row.
        axes: The axes that its flights are judged on.
        arithmetic: Name of the bits that its flights have on this machine, see `objectives.engine`.
        laws: Control law of each group of axes.
        has_shared_laws: Whether a law flies several axes, those of its group, and not one channel alone.
        traced: Parts of the flight that `responses` are read from.
        signals: Names of the signals of `responses`, with their units.
        command: Part of the flight that holds the commands to the inputs.
        command_scales: Sizes (inputs,) that metrics count the commands in.
        failure_causes: Cause of each way to lose a flight, and the limit that it exceeds.
        failure_modes: Ways to lose a flight, with the demand over the capacity of each.
        disturbances: Names of what acts on it from outside, with their units.
        order: Order of its integration's error in the plant step.
        min_steps: Fewest plant steps of a control period that are accurate at rest.
        own_code: The user's code that its equations are, None where they are bundled. Raises InputError where no other
            machine can be given them.
        parts: Names and numbers from which another process builds it, without `metered`; raises as `own_code`.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @cached_property
    def loop(self) -> ClosedLoop: ...  # noqa: D102
    @property
    def limits(self) -> Any: ...  # noqa: D102
    @property
    def timing(self) -> Timing: ...  # noqa: D102
    @property
    def nominal(self) -> Any: ...  # noqa: D102
    @property
    def metered(self) -> tuple[MetricAddress, ...]: ...  # noqa: D102
    @property
    def watched(self) -> tuple[str, ...]: ...  # noqa: D102
    def watching(self, names: Iterable[str]) -> Self:
        """Return the system with meters of these axes; itself where it has them."""
        ...

    @property
    def gains(self) -> tuple[GainAddress, ...]: ...  # noqa: D102
    @property
    def axes(self) -> Axes: ...  # noqa: D102
    @property
    def arithmetic(self) -> str: ...  # noqa: D102
    @property
    def laws(self) -> dict[str, Law]: ...  # noqa: D102
    @property
    def has_shared_laws(self) -> bool: ...  # noqa: D102
    @property
    def traced(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def signals(self) -> dict[str, str]: ...  # noqa: D102
    @property
    def command(self) -> str: ...  # noqa: D102
    @property
    def command_scales(self) -> np.ndarray: ...  # noqa: D102
    @property
    def failure_causes(self) -> dict[Status, tuple[str, str]]: ...  # noqa: D102
    @property
    def failure_modes(self) -> tuple[FailureMode, ...]: ...  # noqa: D102
    @property
    def disturbances(self) -> dict[str, str]: ...  # noqa: D102
    @property
    def order(self) -> int: ...  # noqa: D102
    @property
    def min_steps(self) -> int: ...  # noqa: D102
    @property
    def own_code(self) -> OwnCode | None: ...  # noqa: D102
    @property
    def parts(self) -> SystemParts: ...  # noqa: D102

    def flyer(self, threads: int | None = None) -> FlightBackend:
        """Return its backend with some threads, by default one per core."""
        ...

    def responses(self, trace: np.ndarray, references: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signals and their references (scenarios, instants, signals); the reference of a command is NaN.

        Args:
            trace: Rows of `traced` (scenarios, instants, rows).
            references: References of the flight inputs, at the same instants (instants, rows).
        """
        ...

    # A system flies scenarios of its own kind, so their type is open here.
    def sample(self, spec: Any, root: int, stream: str, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios of a stream."""
        ...

    def draw(self, spec: Any, source: RandomSource, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios from a source of random numbers."""
        ...

    def names_of_draws(self, spec: Any) -> dict[str, tuple[str, ...]]:
        """Return names of the first numbers of each part of a draw."""
        ...

    def with_own_plant(
        self, drawn: FlightInputs, owner: Self, spec: Any, root: int, stream: str, indices: Iterable[int]
    ) -> FlightInputs:
        """Return another system's scenarios with this system's plant or channels.

        Scenarios that do not serve so are drawn as by `sample`.
        """
        ...

    def targets(self, spec: Any) -> Any:
        """Return the record of a scenario's levels and windows for metrics."""
        ...

    def content(self, spec: Any) -> dict[str, Any]:
        """Return all that determines its flights through a scenario, as JSON-able data.

        Seeds and gains are not part of it.
        """
        ...

    def metric_limits(self) -> Bounds:
        """Return bounds that no completed flight exceeds."""
        ...
