"""Monte Carlo fans: what the axes and rotors do over many scenarios, as 5 %, 50 % and 95 % at every instant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from math import atan, cos, radians
from typing import Any

import numpy as np

from objectives.plant_system import PlantSystem
from objectives.system import System
from plant.air.intensity import wind_at_20_feet
from plant.air.spec import AirSpec
from plant.attitude import euler_angles
from plant.backends.array import rebinder
from plant.backends.flyer import FlightInputs, Flyer
from plant.closed_loop import Limits
from plant.loop import Timing
from plant.nominal import nominal
from plant.records import paths, rows, size
from plant.references.steps import Steps
from plant.scenarios import ScenarioSpec
from plant.trim import within_limits
from plant.vectors import Quaternion
from tuner.gains import Controller
from tuner.store.columns import Columns, stacked
from tuner.study.trim import trimmed_flights

SIGNALS = ("x", "y", "z", "roll", "pitch", "yaw", "rotor1", "rotor2", "rotor3", "rotor4")
UNITS = ("m", "m", "m", "rad", "rad", "rad", "1", "1", "1", "1")
LEVELS = (0.05, 0.5, 0.95)
# Instants of a fan; more do not show on a screen.
INSTANTS = 400


TRACED = ("body.position", "body.attitude", "pending", "control.tilt")
"""Parts of the flight that signals and their references are made of."""


@dataclass(frozen=True)
class Responses:
    """time (instants,) [s]; actual and reference (scenarios, instants, signals); the reference of a command is NaN.

    signals, units: of the last axis.
    """

    time: np.ndarray
    actual: np.ndarray
    reference: np.ndarray
    signals: tuple[str, ...] = SIGNALS
    units: tuple[str, ...] = UNITS

    def fans(self) -> np.ndarray:
        """Return low, median, high (3, instants, signals) over the scenarios."""
        return quantiles(self.actual, LEVELS)


def quantiles(values: np.ndarray, levels: Sequence[float]) -> np.ndarray:
    """Return what `np.quantile` does along the first axis, to the last bit, in an eighth of its time for a few dozen values."""
    ordered = np.sort(values, axis=0)
    found = np.empty((len(levels), *values.shape[1:]))
    for i, level in enumerate(levels):
        place = level * (len(ordered) - 1)
        low, share = int(place), place - int(place)
        first, second = ordered[low], ordered[min(low + 1, len(ordered) - 1)]
        found[i] = first + (second - first) * share if share < 0.5 else second - (second - first) * (1.0 - share)
    # NaN stand last.
    found[:, np.isnan(ordered[-1])] = np.nan
    return found


def responses_of(system: Any, flyer: Flyer, gains: np.ndarray, inputs: FlightInputs) -> Responses:
    """Fly one candidate, gains (n,), through the scenarios and return what its axes and commands did."""
    every = spacing(len(inputs.references))
    trace = flyer.trace(gains, system.nominal, inputs, every, traced_rows(system, flyer.loop.Flight))
    return responses_from(system, trace, inputs.references)


def spacing(steps: int) -> int:
    """Return each how many-th of so many control instants is an instant of the responses."""
    return max(1, steps // INSTANTS)


@singledispatch
def traced_rows(system: Any, flight: Any) -> np.ndarray:
    """Return the rows of a flight that responses are made of."""
    raise TypeError(f"nothing draws the responses of {type(system).__name__}")


@traced_rows.register
def _(system: System, flight: Any) -> np.ndarray:  # noqa: ARG001
    return np.r_[*[rows(flight, part) for part in TRACED]]


@traced_rows.register
def _(system: PlantSystem, flight: Any) -> np.ndarray:  # noqa: ARG001
    return np.r_[*[rows(flight, part) for part in ("body.shown", "control.command", "control.commands")]]


@singledispatch
def responses_from(system: Any, trace: np.ndarray, references: np.ndarray) -> Responses:
    """Return the responses in flights of which `traced_rows` were recorded: trace (scenarios, instants, rows).

    references (steps, ...): of `plant.backends.flyer.FlightInputs`.
    """
    raise TypeError(f"nothing draws the responses of {type(system).__name__}")


@responses_from.register
def _(system: System, trace: np.ndarray, references: np.ndarray) -> Responses:
    every = spacing(len(references))
    position, q, commands, tilt = np.split(trace, (3, 7, 11), axis=-1)
    reference = np.full((*trace.shape[:2], len(SIGNALS)), np.nan)
    asked = references[::every]
    reference[..., 0:3] = asked[None, :, 0:3]
    reference[..., 3:5] = tilt
    reference[..., 5] = asked[None, :, 11]
    actual = np.concatenate([position, _euler(q), commands / system.nominal.hover], axis=-1)
    return Responses(np.arange(0, len(references), every) * system.timing.control_period, actual, reference)


@responses_from.register
def _(system: PlantSystem, trace: np.ndarray, references: np.ndarray) -> Responses:
    every, plant, plan = spacing(len(references)), system.plant, system.plan
    names, n, m = plan.names, size(plant.Output), size(plant.Input)
    shown, asked, commands = np.split(trace, (n, n + m), axis=-1)
    outputs, inputs_of = paths(plant.Output), paths(plant.Input)
    actual = [shown[..., outputs.index(channel.output)] for channel in plan.channels]
    given = references[::every, ::3]
    reference = [
        commands[..., names.index(plan.commanded[name])]
        if name in plan.commanded
        else np.broadcast_to(given[:, i], actual[i].shape)
        for i, name in enumerate(names)
    ]
    return Responses(
        np.arange(0, len(references), every) * system.timing.control_period,
        np.concatenate([np.stack(actual, axis=-1), asked], axis=-1),
        np.concatenate([np.stack(reference, axis=-1), np.full_like(asked, np.nan)], axis=-1),
        (*names, *inputs_of),
        (
            *[plant.unit(f"Output.{channel.output}") for channel in plan.channels],
            *[plant.unit(f"Input.{name}") for name in inputs_of],
        ),
    )


def _euler(q: np.ndarray) -> np.ndarray:
    angles = rebinder()(euler_angles)(Quaternion(*np.moveaxis(q, -1, 0)))
    return np.stack([angles.x, angles.y, np.unwrap(angles.z, axis=1)], axis=-1)


def fan_table(responses: Responses, point: str, scenario: str) -> Columns:
    """Return the fans as a long table: one row for each signal and instant."""
    low, median, high = responses.fans()
    reference = responses.reference.mean(axis=0)
    n = len(responses.time)
    parts = [
        {
            "point": point, "scenario": scenario, "signal": signal, "unit": unit, "time": responses.time,
            "reference": reference[:n, i], "low": low[:, i], "median": median[:, i], "high": high[:, i],
        }
        for i, (signal, unit) in enumerate(zip(responses.signals, responses.units, strict=True))
    ]  # fmt: skip
    return stacked(parts)


SCENARIO = ScenarioSpec(
    "steps in a fresh breeze", 10.0, Steps(x=1.0, y=-1.0, z=0.5, yaw_deg=20.0, time=0.5), AirSpec(intensity="light"),
)  # fmt: skip
"""Default scenario of commands without a study: one metre steps and a turn of 20 deg in a fresh breeze at 10 m, for 10 s."""
# Share of the tilt limit that holding against the mean wind may take: gusts and steps need the rest.
TRIM_SHARE = 2.0 / 3.0
# Shares of the fresh breeze, the strongest first.
BREEZES = np.linspace(1.0, 0.0, 21)
LIMITS = Limits(5.0, cos(radians(80.0)))
"""Largest position error [m] and cosine of the largest tilt."""


def usual_scenario(system: System) -> ScenarioSpec:
    """Return the usual steps in the strongest wind, up to a fresh breeze, that leaves the tilt limit room for gusts."""
    air, limit = SCENARIO.air, atan(system.nominal.tilt_tangent)
    flight = trimmed_flights(SCENARIO, system, BREEZES)
    held = within_limits(flight, system.nominal) & (flight.tilt <= TRIM_SHARE * limit)
    share = float(BREEZES[held.reshape(len(BREEZES), -1).all(axis=1)].max(initial=0.0))
    if share == 1.0:
        return SCENARIO
    milder = replace(air, intensity=share * wind_at_20_feet(air.intensity))
    return replace(SCENARIO, name=f"steps in a wind of {milder.wind_speed:.2g} m/s", air=milder)


def system_of(controller: Controller, limits: Limits = LIMITS) -> System:
    """Return a controller on its own airframe as a system; limits: beyond them a flight has failed."""
    vehicle = controller.airframe.vehicle
    knowledge = nominal(vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    return System(vehicle, controller.cascade, knowledge, limits, timing)
