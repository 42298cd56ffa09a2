"""A quadrotor under study."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache, partial
from math import acos, degrees
from typing import Any, Self

import numpy as np

from objectives import meters
from objectives.failure_modes import FailureMode, diverged, largest_error
from objectives.flown_system import NOT_FINITE
from objectives.metrics import MetricAddress, MetricLimits
from objectives.metrics.address import CASCADE, Axes
from objectives.metrics.context import ROTORS
from objectives.own_meters import code_of, with_accumulators
from objectives.tilt import TILT
from plant.backends.array import rebinder
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.identity import identity
from plant.law_registry import law
from plant.laws.law import Law
from plant.loop import ClosedLoop, MeterModel, Timing
from plant.origin import origins
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import ATTITUDE_AXES, POSITION_AXES, Cascade, close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.features import VehicleFeatures, vehicle_features
from plant.quadrotor.gains import GainAddress, gain_addresses
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.sample import Targets
from plant.quadrotor.scenarios import FACTORS, ScenarioSpec, draw_scenarios, for_vehicle
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten
from plant.seeds import RandomSource, source_of
from plant.status import Status
from plant.vectors import Quaternion

SIGNALS = {
    **{name: "m" for name in POSITION_AXES},
    **{name: "rad" for name in ATTITUDE_AXES},
    **{f"rotor{i + 1}": "1" for i in range(ROTORS)},
}
"""Names and units of the signals of a quadrotor's responses."""
DISTURBANCES = {
    f"{name}_{axis}": unit
    for name, unit in {
        "wind": "m/s",
        "gust_rate": "rad/s",
        "acceleration": "m/s^2",
        "angular_acceleration": "rad/s^2",
    }.items()
    for axis in "xyz"
}
"""Columns of the air in the order of `plant.air.air`, with units; world is ENU, body is FLU."""


MAX_LOOPS = 16


@lru_cache(MAX_LOOPS)
def _loop_of(cascade: Cascade, metered: tuple[MetricAddress, ...], fitted: VehicleFeatures) -> ClosedLoop:
    """Return the closed loop of these parts: kernels are kept by loop, and to find one on disk takes up to 60 ms."""
    return close_loop(cascade, _meter_of(metered), fitted)


def _meter_of(metered: tuple[MetricAddress, ...]) -> MeterModel:
    return with_accumulators(MeterModel(meters.Meters, meters.start, meters.update), metered)


@dataclass(frozen=True)
class CascadeParts:
    """The parts of a quadrotor's system."""

    position: str
    attitude: str
    position_every: int
    vehicle: Vehicle
    nominal: Nominal
    limits: Limits
    timing: Timing

    def system(self) -> "System":
        """Build the system."""
        cascade = close_cascade(law(self.position), law(self.attitude), self.position_every)
        return System(self.vehicle, cascade, self.nominal, self.limits, self.timing)


@dataclass(frozen=True)
class System:
    """The closed loop under study: vehicle, cascade bound to its laws, the controller's knowledge, limits and timing.

    metered: metrics whose own accumulators run with every flight.
    """

    order = 4
    min_steps = 1
    has_shared_laws = True
    own_code = None
    command = "pending"
    traced = ("body.position", "body.attitude", "pending", "control.tilt")
    signals = SIGNALS
    disturbances = DISTURBANCES

    vehicle: Vehicle
    cascade: Cascade
    nominal: Nominal
    limits: Limits
    timing: Timing
    metered: tuple[MetricAddress, ...] = ()

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop with this package's meters and those of `metered`."""
        return _loop_of(self.cascade, self.metered, self.fitted)

    @cached_property
    def meter(self) -> MeterModel:
        """The meters that judge its flights."""
        return _meter_of(self.metered)

    @property
    def fitted(self) -> VehicleFeatures:
        """The fittings of its vehicle and its controller."""
        nominal = self.nominal
        return vehicle_features(self.vehicle, self.timing.control_period, nominal.harmonics, nominal.vehicle)

    def flyer(self, threads: int | None = None) -> Flyer:
        """Return its flyer: the compiled lanes on so many threads, by default one for each core."""
        return Flyer(self.loop, self.limits, self.timing, threads)

    @property
    def arithmetic(self) -> str:
        """Name of the arithmetic of its flights on this machine, see `objectives.engine`."""
        return Flyer.arithmetic

    @property
    def gains(self) -> tuple[GainAddress, ...]:
        """All gains in the column order of a gains row."""
        return gain_addresses(self.cascade)

    @property
    def axes(self) -> Axes:
        """The axes that its flights are judged on."""
        return CASCADE

    @property
    def watched(self) -> tuple[str, ...]:
        """No signal: laws control every axis that is judged."""
        return ()

    def watching(self, names: Iterable[str]) -> Self:  # noqa: ARG002
        """Return the system itself, which meters every axis."""
        return self

    @property
    def laws(self) -> dict[str, Law]:
        """The laws of position and attitude."""
        return {"position": self.cascade.position, "attitude": self.cascade.attitude}

    def responses(self, trace: np.ndarray, references: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signals and their references (scenarios, instants, signals), see `FlownSystem`."""
        position, q, commands, tilt = np.split(trace, (3, 7, 11), axis=-1)
        reference = np.full((*trace.shape[:2], len(SIGNALS)), np.nan)
        reference[..., 0:3] = references[None, :, 0:3]
        reference[..., 3:5] = tilt
        reference[..., 5] = references[None, :, 11]
        return np.concatenate([position, _euler(q), commands / self.nominal.hover], axis=-1), reference

    @property
    def command_scales(self) -> np.ndarray:
        """The thrust at hover, of each rotor."""
        return np.full(ROTORS, self.nominal.hover)

    @property
    def failure_causes(self) -> dict[Status, tuple[str, str]]:
        """Cause of each failure, and the limit that it exceeds."""
        return {
            Status.TILTED: ("tilt", f"{degrees(acos(self.limits.cosine_tilt)):.4g} deg of tilt"),
            Status.LOST: ("position", f"{self.limits.position:g} m off along an axis"),
            Status.NON_FINITE: NOT_FINITE,
        }

    @property
    def failure_modes(self) -> tuple[FailureMode, ...]:
        """Position along an axis and tilt, each over its limit."""
        farthest, steepest = self.limits.position, acos(self.limits.cosine_tilt)
        return (
            FailureMode("position", Status.LOST, partial(largest_error, POSITION_AXES, farthest)),
            FailureMode("tilt", Status.TILTED, lambda meters: np.arccos(meters.own_tilt.cosine) / steepest, TILT),
            diverged(POSITION_AXES),
        )

    @property
    def parts(self) -> CascadeParts:
        """Names and numbers from which another process builds it."""
        return CascadeParts(
            self.cascade.position.name,
            self.cascade.attitude.name,
            self.cascade.position_every,
            self.vehicle,
            self.nominal,
            self.limits,
            self.timing,
        )

    def sample(self, spec: ScenarioSpec, root: int, stream: str, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios of a stream."""
        return self.draw(spec, source_of(root, f"{stream}/{spec.name}"), indices)

    def draw(self, spec: ScenarioSpec, source: RandomSource, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios from a source of random numbers."""
        return draw_scenarios(spec, self.vehicle, self.timing, source, indices)

    def names_of_draws(self, spec: ScenarioSpec) -> dict[str, tuple[str, ...]]:
        """Return names of the numbers of vehicle and air.

        An uncertainty has numbers along its principal axes; those of the air stand in `plant.air.air`.
        """
        axes = () if spec.uncertainty is None else range(1, len(spec.uncertainty.names) + 1)
        uncertain = [f"uncertainty axis {axis}" for axis in axes]
        air = ("wind direction", "initial u", "initial v 1", "initial v 2", "initial w 1", "initial w 2")
        return {"vehicle": (*FACTORS, "centre.x", "centre.y", *uncertain), "air": air}

    def with_own_plant(
        self, drawn: FlightInputs, owner: "System", spec: ScenarioSpec, root: int, stream: str, indices: Iterable[int]
    ) -> FlightInputs:
        """Return scenarios that another system drew with this system's vehicle in them."""
        same = self.vehicle == owner.vehicle
        return drawn if same else for_vehicle(drawn, spec, self.vehicle, root, stream, indices)

    def targets(self, spec: ScenarioSpec) -> Targets:
        """Return the targets of the flights of a scenario."""
        return spec.targets(self.timing)

    def content(self, spec: ScenarioSpec) -> dict[str, Any]:
        """Return all that determines its flights through a scenario, as JSON-able data.

        Seeds and gains are not part of it.
        """
        reference = asdict(spec.reference)
        # What is in a waypoint file decides, not where it lies.
        reference.pop("path", None)
        code = origins(self.laws.values()) | origins([type(spec.reference)], "kind")
        return {
            **({"code": code} if code else {}),
            **({"meters": identity(code_of(self.metered))} if self.metered else {}),
            "laws": [each.name for each in self.laws.values()],
            **({} if self.cascade.position_every == 1 else {"position_every": self.cascade.position_every}),
            "numbers": [flatten(part) for part in (self.vehicle, self.nominal, self.limits, self.timing)],
            "scenario": {**asdict(spec), "reference": {**reference, "kind": spec.reference.kind}},
        }

    def metric_limits(self) -> MetricLimits:
        """Return the bounds of a completed flight."""
        return MetricLimits(self.limits.position, self.nominal.thrust_max / self.nominal.hover)


def _euler(q: np.ndarray) -> np.ndarray:
    angles = rebinder()(euler_angles)(Quaternion(*np.moveaxis(q, -1, 0)))
    return np.stack([angles.x, angles.y, np.unwrap(angles.z, axis=1)], axis=-1)
