"""Scenarios of a plant: what its channels follow, what disturbs it, what its sensors add, and how far its parameters vary.

Scenario i of a stream is a pure function of (root seed, stream, scenario name, i). Every candidate meets the same scenarios.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np

from plant.backends.flyer import FlightInputs, to_lanes
from plant.errors import InputError, check_name
from plant.loop import Timing
from plant.model.closing import PlantLoop, resting
from plant.model.signals import Constant, Signal
from plant.records import flatten, pack, paths, size
from plant.sample import Target
from plant.seeds import RandomSource

Array = np.ndarray
# Largest half-width of a parameter's spread: beyond it a factor could be zero.
MAX_SPREAD = 0.95


@dataclass(frozen=True)
class SensorNoise:
    """White noise of one output and the bias that is drawn once a flight, both rms in its unit."""

    rms: float = 0.0
    bias: float = 0.0

    def __post_init__(self) -> None:
        for key in ("rms", "bias"):
            value = getattr(self, key)
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"given {value}; an rms value must be finite and not negative", key=key)


@dataclass(frozen=True)
class PlantScenario:
    """One kind of flight of a plant; a study flies it through many draws.

    name: unique in a study, part of the random streams. duration [s]. references: signal of every outer channel, counted from its
    output at rest (of an FMU, which does not tell it, from 0), 0 where none is given. disturbances: signal of each field of
    Disturbance. sensors: of each output. spread: half-width of the uniform factor on each parameter, 0.2 for +-20 %.
    joint_spread: half-widths of parameters that one uniform number moves together. settling:
    band of the settling time as a share of the step; band: of channels without a step, in the unit of each, by default a
    hundredth of its limit. recovery_from: when the disturbance is over [s]. steady_share: share of the flight, at its end,
    that the steady-state error looks at.
    """

    name: str
    duration: float
    references: Mapping[str, Signal] = field(default_factory=dict)
    disturbances: Mapping[str, Signal] = field(default_factory=dict)
    sensors: Mapping[str, SensorNoise] = field(default_factory=dict)
    spread: Mapping[str, float] = field(default_factory=dict)
    settling: float = 0.02
    band: Mapping[str, float] = field(default_factory=dict)
    recovery_from: float = 0.0
    steady_share: float = 0.2
    joint_spread: Sequence[Mapping[str, float]] = ()

    def __post_init__(self) -> None:
        if not (isfinite(self.duration) and self.duration > 0.0):
            raise InputError(f"given {self.duration} s; a flight must last a finite, positive time", key="duration")
        if not 0.0 < self.steady_share <= 1.0:
            raise InputError(f"given {self.steady_share}; allowed: above 0, at most 1", key="steady_share")
        if not 0.0 < self.settling < 1.0:
            raise InputError(f"given {self.settling}; allowed: above 0 and below 1", key="settling")
        if not 0.0 <= self.recovery_from < self.duration:
            raise InputError(
                f"given {self.recovery_from} s; allowed: 0 s up to the duration of {self.duration} s",
                key="recovery_from",
            )
        for name, width in self.spread.items():
            if not (isfinite(width) and 0.0 <= width <= MAX_SPREAD):
                raise InputError(f"given {width}; allowed: 0 to {MAX_SPREAD}", key=f"spread.{name}")
        for name in {name for widths in self.joint_spread for name in widths}:
            width = self.spread.get(name, 0.0) + sum(abs(widths.get(name, 0.0)) for widths in self.joint_spread)
            if not width <= MAX_SPREAD:
                raise InputError(
                    f"{name} varies by {width:g} in all; allowed: up to {MAX_SPREAD} with its spread",
                    key="joint_spread",
                )
        for name, signal in self.references.items():
            if signal.random:
                raise InputError(f"given '{signal.kind}'; a reference must not be random", key=f"reference.{name}")

    def __hash__(self) -> int:
        return hash((self.name, self.duration))

    def steps(self, timing: Timing) -> int:
        """Return the number of control periods of a flight."""
        return round(self.duration / timing.control_period)

    def check(self, loop: PlantLoop) -> None:
        """Raise UnknownNameError where a signal, a sensor or a spread names nothing of the plant."""
        plant, plan = loop.plant, loop.plan
        outer = [channel.name for channel in plan.outer]
        for key, given, valid in (
            ("reference", self.references, outer),
            ("disturbance", self.disturbances, paths(plant.Disturbance)),
            ("sensors", self.sensors, paths(plant.Output)),
            ("spread", self.spread, paths(plant.Parameters)),
            *[("joint_spread", widths, paths(plant.Parameters)) for widths in self.joint_spread],
            ("band", self.band, plan.judged),
        ):
            for name in given:
                check_name(key, name, valid, key=f"{key}.{name}")

    def check_jumps(self, loop: PlantLoop, timing: Timing) -> None:
        """Raise InputError where a reference jumps beyond recovery."""
        times = timing.control_period * np.arange(self.steps(timing))
        still = np.random.default_rng(0)
        for channel in loop.plan.outer:
            values = self.references.get(channel.name, Constant()).values(times, still)[0]
            jump = float(np.abs(np.diff(values, prepend=0.0)).max(initial=0.0))
            if jump >= channel.limit:
                raise InputError(
                    f"it jumps by {jump:g} within a control period, and a flight is lost from an error of {channel.limit:g} "
                    f'on, so every flight would be lost there: raise lost_beyond of channel "{channel.name}" above '
                    f"{jump:g}, or let the reference jump by less",
                    key=f"reference.{channel.name}",
                )

    def targets_of(self, loop: PlantLoop, parameters: Any) -> Any:
        """Return the targets of the step and recovery metrics by channel; parameters: the nominal ones."""
        steady = self.duration * (1.0 - self.steady_share)
        targets = []
        rests = [*outputs_at_rest(loop, parameters), *[0.0] * len(loop.plan.watched)]
        for (name, limit), rest in zip(loop.plan.limits.items(), rests, strict=True):
            start, final, time = self.references.get(name, Constant()).step
            usual = 0.01 * limit if isfinite(limit) else 1.0
            band = self.band.get(name, usual)
            settling = self.settling * abs(final - start) or band
            targets.append(Target(rest + start, rest + final, time, settling, self.recovery_from, band, steady))
        return loop.records.Targets(*targets)


def draw_plant_scenarios(
    spec: PlantScenario, loop: PlantLoop, parameters: Any, timing: Timing, source: RandomSource, indices: Iterable[int]
) -> FlightInputs:
    """Draw scenarios in blocks of lanes, in the order of the indices; parameters: the nominal ones."""
    indices = list(indices)
    times = timing.control_period * np.arange(spec.steps(timing))
    rows = [_plant(spec, loop, parameters, source("plant", i)) for i in indices]
    return FlightInputs(
        dynamics=to_lanes([dynamics for dynamics, _ in rows]),
        starts=to_lanes([start for _, start in rows]),
        disturbances=to_lanes([_disturbances(spec, loop, times, source, i) for i in indices]),
        noises=to_lanes([_noises(spec, loop, len(times), source, i) for i in indices]),
        references=references_of(spec, loop, times, parameters),
        targets=spec.targets_of(loop, parameters),
        count=len(indices),
    )


def references_of(spec: PlantScenario, loop: PlantLoop, times: Array, parameters: Any) -> Array:
    """Return the references of all channels at times (K,) [s]: (K, 3 channels); those of inner ones are never read.

    They count from where a plant of the nominal parameters rests: a controller does not know those that are drawn.
    """
    still = np.random.default_rng(0)
    columns = [spec.references.get(name, Constant()).values(times, still) for name in loop.plan.names]
    places = [np.array([[rest], [0.0], [0.0]]) for rest in outputs_at_rest(loop, parameters)]
    return np.ascontiguousarray(np.concatenate([c + p for c, p in zip(columns, places, strict=True)], axis=0).T)


def outputs_at_rest(loop: PlantLoop, parameters: Any) -> list[float]:
    """Return the channels' outputs of a plant at rest, in their units."""
    _, _, shown = loop.plant.at_rest(parameters)
    return [getattr(shown, channel.output) for channel in loop.plan.channels]


def _plant(spec: PlantScenario, loop: PlantLoop, parameters: Any, draw: np.random.Generator) -> tuple[Array, Array]:
    """Draw the constants of a plant (rows,) and the body (rows,) at rest in which it starts."""
    places = draw.uniform(-1.0, 1.0, size(type(parameters)))
    flown = varied(spec, parameters, places, draw.uniform(-1.0, 1.0, len(spec.joint_spread)))
    dynamics, body = resting(loop, flown)
    return np.array(flatten(dynamics), dtype=float), np.array(flatten(body), dtype=float)


def varied(spec: PlantScenario, parameters: Any, places: Array, joint: Array) -> Any:
    """Return parameters in a spread.

    Args:
        spec: Scenario with the spread.
        parameters: Nominal parameters.
        places: Place of each parameter (n,) in its own spread, -1 to 1.
        joint: Place (m,) in each joint spread.
    """
    names = paths(type(parameters))
    factors = 1.0 + np.array([spec.spread.get(name, 0.0) for name in names]) * places
    for widths, place in zip(spec.joint_spread, joint, strict=True):
        factors += place * np.array([widths.get(name, 0.0) for name in names])
    return pack(type(parameters), (factors * np.array(flatten(parameters), dtype=float)).tolist())


def _disturbances(spec: PlantScenario, loop: PlantLoop, times: Array, source: RandomSource, i: int) -> Array:
    """Draw the disturbances of a flight (K, fields)."""
    out = np.zeros((len(times), size(loop.plant.Disturbance)))
    for column, name in enumerate(paths(loop.plant.Disturbance)):
        if name in spec.disturbances:
            draw = source(f"disturbance/{name}", i)
            out[:, column] = spec.disturbances[name].values(times, draw)[0]
    return out


def _noises(spec: PlantScenario, loop: PlantLoop, steps: int, source: RandomSource, i: int) -> Array:
    """Draw the sensor errors of a flight (K, outputs)."""
    out = np.zeros((steps, size(loop.plant.Output)))
    for column, name in enumerate(paths(loop.plant.Output)):
        if name in spec.sensors:
            sensor = spec.sensors[name]
            draw = source(f"sensor/{name}", i)
            out[:, column] = sensor.bias * draw.standard_normal() + sensor.rms * draw.standard_normal(steps)
    return out
