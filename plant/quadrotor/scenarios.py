"""Scenarios: what is asked of the vehicle, what the air does, what the sensors add, and how far the vehicle varies.

Scenario i of a stream is a pure function of (root seed, stream, scenario name, i). Every candidate meets the same scenarios.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import isfinite

import numpy as np

from plant.air.air import COLUMNS, WIND_COLUMNS, AirSpec, draw_air, steady_wind
from plant.backends.flyer import FlightInputs, filled_lanes, to_lanes
from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.quadrotor.features import hears_rotors
from plant.quadrotor.gyro import TURNS
from plant.quadrotor.nominal import arm_of, shift_center_of_mass, vary
from plant.quadrotor.rigid_body import dynamics
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import NOISE_ROWS, SensorSpec, draw_noise
from plant.quadrotor.trim import steady_flight
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten
from plant.references import ReferenceSpec, Track, build
from plant.references.hover import Hover
from plant.references.spec import HOLD
from plant.sample import Target
from plant.seeds import RandomSource, source_of

SEARCH, HELD_OUT, CONFIRMATION = "search", "held-out", "confirmation"


# What of a vehicle varies by a factor, in the order of `plant.quadrotor.nominal.vary`, and the least factor that is flown.
FACTORS = ("mass", "inertia", "thrust", "lag")
MIN_FACTOR, LARGEST_SHIFT = 0.25, 3.0


@dataclass(frozen=True)
class Spread:
    """Spread of vehicles about the nominal one, which is the controller's.

    Attributes:
        mass, inertia, thrust, lag: half-widths of the uniform spread of a factor on the nominal number, 0.1 for
            +-10 %.
        thrust is that of the rotors at any command, full command included.
        mass_shift, inertia_shift, thrust_shift, lag_shift: how far the middle of that spread is from 1: mass =
            mass_shift = 0.15 is a payload of 0 to 30 %, lag_shift = 1 rotors that are twice as slow.
        centre: half-width of the uniform offset of the centre of mass along body x and along body y, as a share
            of the arm.
    """

    mass: float = 0.0
    inertia: float = 0.0
    thrust: float = 0.0
    lag: float = 0.0
    mass_shift: float = 0.0
    inertia_shift: float = 0.0
    thrust_shift: float = 0.0
    lag_shift: float = 0.0
    centre: float = 0.0

    def __post_init__(self) -> None:
        for key in (*FACTORS, "centre"):
            value = getattr(self, key)
            if not (isfinite(value) and 0.0 <= value <= 0.5):
                raise InputError(f"given {value}; allowed: 0 to 0.5 (+-50 %)", key=key)
        for name, (middle, width) in zip(FACTORS, self.factors, strict=True):
            lowest = MIN_FACTOR - 1.0 + width
            if not (isfinite(middle) and lowest <= middle - 1.0 <= LARGEST_SHIFT):
                raise InputError(
                    f"given {middle - 1.0:g}; with {name} = {width:g} allowed: {lowest:g} to {LARGEST_SHIFT:g}, so that no "
                    f"vehicle has less than {MIN_FACTOR:g} of its nominal {name}",
                    key=f"{name}_shift",
                )

    @property
    def factors(self) -> tuple[tuple[float, float], ...]:
        """Middle and half-width of the factor on mass, inertia, thrust and lag."""
        return tuple((1.0 + getattr(self, f"{name}_shift"), getattr(self, name)) for name in FACTORS)


@dataclass(frozen=True)
class Bands:
    """Half-widths of the bands that settling and recovery are judged by.

    settling: share of the step on an axis that makes one. position [m], attitude [rad]: half-width on an axis without a
    step, and of the recovery band on every axis.
    """

    settling: float = 0.05
    position: float = 0.1
    attitude: float = 0.035

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"given {value}; a band must be finite and positive", key=entry.name)


@dataclass(frozen=True)
class ScenarioSpec:
    """One kind of flight; a study flies it through many draws.

    Attributes:
        name: unique in a study, part of the random streams.
        duration [s].
        recovery_from: when the gust is over [s], by default the end of the air's gating window.
        steady_share: share of the flight, at its end, that the steady-state error looks at.
        uncertainty: uncertainty of the airframe, from which vehicles are drawn in place of a spread.
    """

    name: str
    duration: float = 10.0
    reference: ReferenceSpec = field(default_factory=Hover)
    air: AirSpec = field(default_factory=AirSpec)
    sensors: SensorSpec = field(default_factory=SensorSpec)
    spread: Spread = field(default_factory=Spread)
    bands: Bands = field(default_factory=Bands)
    recovery_from: float | None = None
    steady_share: float = 0.2
    uncertainty: Uncertainty | None = None

    def __post_init__(self) -> None:
        if not (isfinite(self.duration) and self.duration > 0.0):
            raise InputError(f"given {self.duration} s; a flight must last a finite, positive time", key="duration")
        if not 0.0 < self.steady_share <= 1.0:
            raise InputError(f"given {self.steady_share}; allowed: above 0, at most 1", key="steady_share")
        if self.recovery_from is not None and not 0.0 <= self.recovery_from < self.duration:
            raise InputError(
                f"given {self.recovery_from} s; allowed: 0 s up to the duration of {self.duration} s",
                key="recovery_from",
            )

    def steps(self, timing: Timing) -> int:
        """Return the number of control periods of a flight."""
        return round(self.duration / timing.control_period)

    def track(self, timing: Timing) -> Track:
        """Return the sampled reference."""
        return build(self.reference, timing.control_period, self.steps(timing))

    @cached_property
    def _targets(self) -> dict[Timing, Targets]:
        return {}

    def targets(self, timing: Timing) -> Targets:
        """Return the levels and times of step and recovery metrics."""
        # Each metric of a study asks for them; the reference has 14 numbers for each control period.
        if timing not in self._targets:
            self._targets[timing] = self._targets_of(self.track(timing))
        return self._targets[timing]

    def _targets_of(self, track: Track) -> Targets:
        window = self.air.window
        after = self.recovery_from if self.recovery_from is not None else (window[1] if window else 0.0)
        steady = self.duration * (1.0 - self.steady_share)
        targets: list[Target] = []
        for axis, (start, final) in enumerate(zip(track.start.tolist(), track.final.tolist(), strict=True)):
            band = self.bands.position if axis < 3 else self.bands.attitude
            step = abs(final - start)
            settling = self.bands.settling * step if step > 0.0 else band
            targets.append(Target(start, final, track.step_time, settling, min(after, self.duration), band, steady))
        return Targets(*targets)


def sample_scenarios(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, root: int, stream: str, indices: Iterable[int]
) -> FlightInputs:
    """Draw scenarios of a stream; scenario i is a pure function of root seed, stream, name of the spec and i.

    Args:
        spec: The scenario that is drawn from: reference, air, sensors, spread of the vehicle.
        vehicle: The nominal vehicle, about which the spread is drawn.
        timing: Control period and plant step [s].
        root: Root seed.
        stream: Name of the stream, such as `SEARCH`; streams share no scenario.
        indices: Numbers of the scenarios in the stream.

    Returns:
        The scenarios in blocks of lanes, in the order of the indices.
    """
    return draw_scenarios(spec, vehicle, timing, source_of(root, f"{stream}/{spec.name}"), indices)


def draw_scenarios(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, source: RandomSource, indices: Iterable[int]
) -> FlightInputs:
    """Draw scenarios from a source of random numbers; see `sample_scenarios`."""
    indices = list(indices)
    references = np.ascontiguousarray(spec.track(timing).samples)
    bodies, starts = _vehicles(spec, vehicle, references, source, indices)
    return FlightInputs(
        dynamics=to_lanes(bodies),
        starts=to_lanes(starts),
        disturbances=_airs(spec, timing, source, indices),
        noises=_noises(spec, vehicle, timing, source, indices),
        references=references,
        targets=spec.targets(timing),
        count=len(indices),
    )


def for_vehicle(
    inputs: FlightInputs, spec: ScenarioSpec, vehicle: Vehicle, root: int, stream: str, indices: Iterable[int]
) -> FlightInputs:
    """Return drawn scenarios with another vehicle in them: same air, noise and relative spread, as if drawn for it."""
    chosen, source = list(indices), source_of(root, f"{stream}/{spec.name}")
    bodies, starts = _vehicles(spec, vehicle, inputs.references, source, chosen)
    noises = np.ascontiguousarray(inputs.noises[:, :, :NOISE_ROWS])
    if hears_rotors(vehicle):
        noises = _with_turns(noises, source, chosen)
    return replace(inputs, dynamics=to_lanes(bodies), starts=to_lanes(starts), noises=noises)


def draw_vehicle(spread: Spread, vehicle: Vehicle, draw: np.random.Generator) -> Vehicle:
    """Draw a vehicle around the nominal one: four numbers for its factors, then two for its centre of mass."""
    middles, widths = np.array(spread.factors).T
    mass, inertia, thrust, lag = (middles + draw.uniform(-1.0, 1.0, 4) * widths).tolist()
    x, y = (draw.uniform(-1.0, 1.0, 2) * spread.centre * arm_of(vehicle)).tolist()
    return shift_center_of_mass(vary(vehicle, mass, inertia, thrust, lag), x, y)


def drawn_numbers(spec: ScenarioSpec, vehicle: Vehicle, root: int, stream: str, indices: Iterable[int]) -> np.ndarray:
    """Return the deviations of scenarios' vehicles (n, names of the uncertainty), in standard deviations."""
    assert spec.uncertainty is not None, "asked of a scenario that draws from an airframe's uncertainty"
    steps: list[np.ndarray] = []
    source = source_of(root, f"{stream}/{spec.name}")
    for i in indices:
        draw = source("vehicle", i)
        steps.append(spec.uncertainty.step(draw_vehicle(spec.spread, vehicle, draw), draw))
    return np.array(steps) / np.array(spec.uncertainty.deviations)


def _drawn(spec: ScenarioSpec, vehicle: Vehicle, draw: np.random.Generator) -> Vehicle:
    varied = draw_vehicle(spec.spread, vehicle, draw)
    return varied if spec.uncertainty is None else spec.uncertainty.draw(varied, draw)


def _airs(spec: ScenarioSpec, timing: Timing, source: RandomSource, indices: list[int]) -> np.ndarray:
    """Draw the air of flights in blocks of lanes; columns behind the wind only if not all 0."""

    def draw(k: int, out: np.ndarray) -> None:
        draw_air(spec.air, timing.control_period, source("air", indices[k]), out)

    columns = WIND_COLUMNS if spec.air.only_wind else COLUMNS
    airs = filled_lanes(len(indices), (spec.steps(timing), columns), draw)
    return airs if airs[:, :, WIND_COLUMNS:].any() else np.ascontiguousarray(airs[:, :, :WIND_COLUMNS])


def _noises(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, source: RandomSource, indices: list[int]
) -> np.ndarray:
    """Draw the sensor errors of flights in blocks of lanes; none for perfect sensors, see `_with_turns`."""

    def draw(k: int, out: np.ndarray) -> None:
        if out.size:
            draw_noise(spec.sensors, source("sensors", indices[k]), out)

    rows = 0 if spec.sensors.silent() else NOISE_ROWS
    noises = filled_lanes(len(indices), (spec.steps(timing), rows), draw)
    return _with_turns(noises, source, indices) if hears_rotors(vehicle) else noises


def _with_turns(noises: np.ndarray, source: RandomSource, indices: list[int]) -> np.ndarray:
    """Return sensor errors (blocks, steps, 0 or 12, lanes) with the turns of the rotors behind them, 16 rows in all.

    How far each rotor has turned when a flight begins is drawn here [turns].
    """
    blocks, steps, rows, lanes = noises.shape
    errors = noises if rows else np.zeros((blocks, steps, NOISE_ROWS, lanes))
    turns = to_lanes([source("rotors", i).uniform(size=TURNS) for i in indices])
    return np.concatenate([errors, np.broadcast_to(turns[:, None], (blocks, steps, TURNS, lanes))], axis=2)


def _vehicles(
    spec: ScenarioSpec, vehicle: Vehicle, references: np.ndarray, source: RandomSource, indices: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Draw vehicles: their dynamics (n, rows) and the bodies (n, 17) in which they start.

    A flight that holds its place starts in steady flight in its own mean wind, one that does not level and in still air.
    """
    draws = [source("vehicle", i) for i in indices]
    rows = np.array([flatten(dynamics(_drawn(spec, vehicle, draw))) for draw in draws])
    wind = np.zeros((len(indices), 3))
    if references[0, HOLD] > 0.5:
        wind = np.array([steady_wind(spec.air, source("air", i)) for i in indices])
    return rows, steady_flight(rows, wind).body
