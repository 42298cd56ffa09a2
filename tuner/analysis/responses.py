"""Monte Carlo fans: what the axes and rotors do over many scenarios, as 5 %, 50 % and 95 % at every instant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan, cos, radians

import numpy as np

from objectives.flown_system import FlightBackend, FlownSystem
from objectives.system import SIGNALS, System
from plant.air.intensity import wind_at_20_feet
from plant.air.spec import AirSpec
from plant.backends.flyer import FlightInputs
from plant.loop import Timing
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.nominal import nominal
from plant.quadrotor.scenarios import ScenarioSpec
from plant.quadrotor.trim import within_limits
from plant.records import rows
from plant.references.steps import Steps
from tuner.gains import Controller
from tuner.store.columns import Columns, stacked
from tuner.study.trim import trimmed_flights

LEVELS = (0.05, 0.5, 0.95)
# Instants of a fan; more do not show on a screen.
INSTANTS = 400


@dataclass(frozen=True)
class Responses:
    """time (instants,) [s]; actual and reference (scenarios, instants, signals); the reference of a command is NaN.

    signals, units: of the last axis.
    """

    time: np.ndarray
    actual: np.ndarray
    reference: np.ndarray
    signals: tuple[str, ...] = tuple(SIGNALS)
    units: tuple[str, ...] = tuple(SIGNALS.values())

    def fans(self) -> np.ndarray:
        """Return low, median, high (3, instants, signals) over the scenarios."""
        return quantiles(self.actual, LEVELS)


def quantiles(values: np.ndarray, levels: Sequence[float]) -> np.ndarray:
    """Return `np.quantile` along the first axis, to the last bit.

    It takes an eighth of the time for a few dozen values.
    """
    ordered = np.sort(values, axis=0)
    out = np.empty((len(levels), *values.shape[1:]))
    for i, level in enumerate(levels):
        place = level * (len(ordered) - 1)
        low, share = int(place), place - int(place)
        first, second = ordered[low], ordered[min(low + 1, len(ordered) - 1)]
        out[i] = first + (second - first) * share if share < 0.5 else second - (second - first) * (1.0 - share)
    # NaN stand last.
    out[:, np.isnan(ordered[-1])] = np.nan
    return out


def responses_of(system: FlownSystem, flyer: FlightBackend, gains: np.ndarray, inputs: FlightInputs) -> Responses:
    """Fly one candidate, gains (n,), and return its responses."""
    every = spacing(len(inputs.references))
    trace = flyer.trace(gains, system.nominal, inputs, every, traced_rows(system))
    return responses_from(system, trace, inputs.references)


def traced_rows(system: FlownSystem) -> np.ndarray:
    """Return the rows of a flight that responses are made of."""
    return np.r_[*[rows(system.loop.Flight, part) for part in system.traced]]


def responses_from(system: FlownSystem, trace: np.ndarray, references: np.ndarray) -> Responses:
    """Return the responses in flights of which `traced_rows` were recorded: trace (scenarios, instants, rows).

    references (steps, ...): of `plant.backends.flyer.FlightInputs`.
    """
    every = spacing(len(references))
    actual, reference = system.responses(trace, references[::every])
    time = np.arange(0, len(references), every) * system.timing.control_period
    return Responses(time, actual, reference, tuple(system.signals), tuple(system.signals.values()))


def spacing(steps: int) -> int:
    """Return the number of control instants between two instants of the responses."""
    return max(1, steps // INSTANTS)


def fan_table(responses: Responses, point: str, scenario: str) -> Columns:
    """Return the fans as a long table: one row for each signal and instant."""
    low, median, high = responses.fans()
    reference = responses.reference.mean(axis=0)
    n = len(responses.time)
    parts = [
        {
            "point": point,
            "scenario": scenario,
            "signal": signal,
            "unit": unit,
            "time": responses.time,
            "reference": reference[:n, i],
            "low": low[:, i],
            "median": median[:, i],
            "high": high[:, i],
        }
        for i, (signal, unit) in enumerate(zip(responses.signals, responses.units, strict=True))
    ]
    return stacked(parts)


SCENARIO = ScenarioSpec(
    "steps in a fresh breeze",
    10.0,
    Steps(x=1.0, y=-1.0, z=0.5, yaw_deg=20.0, time=0.5),
    AirSpec(intensity="light"),
)
"""Default scenario of commands without a study: one metre steps and a turn of 20 deg in a fresh breeze at 10 m, for 10 s."""
# Share of the tilt limit that holding against the mean wind may take: gusts and steps need the rest.
TRIM_SHARE = 2.0 / 3.0
# Shares of the fresh breeze, the strongest first.
BREEZES = np.linspace(1.0, 0.0, 21)
LIMITS = Limits(5.0, cos(radians(80.0)))
"""Largest position error [m] and cosine of the largest tilt."""


def usual_scenario(system: System) -> ScenarioSpec:
    """Return the usual steps in the strongest wind with tilt left.

    The wind is a fresh breeze at most, and leaves the tilt limit room for gusts.
    """
    air, limit = SCENARIO.air, atan(system.nominal.tilt_tangent)
    flight = trimmed_flights(SCENARIO, system, BREEZES)
    is_held = within_limits(flight, system.nominal) & (flight.tilt <= TRIM_SHARE * limit)
    share = float(BREEZES[is_held.reshape(len(BREEZES), -1).all(axis=1)].max(initial=0.0))
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
