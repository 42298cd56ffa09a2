"""Designed cascades as they fly: margins of the sampled loops by python-control, and flights in turbulence."""

from math import cos, radians, sqrt
from typing import Any

import numpy as np
import pytest

from objectives import meters
from plant.air.spec import AirSpec
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.law_registry import LAWS
from plant.loop import MeterModel
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.scenarios import HELD_OUT, ScenarioSpec, sample_scenarios
from plant.records import pack
from plant.references.steps import Steps
from tests.objectives.design.designed import HUMMINGBIRD, NAMES, REQUIREMENTS, TIMING, H, designs, known, row_of
from tests.objectives.design.discrete import Loop, Rotors, attitude_step, margins, position_step
from tests.plant.harness import VEHICLES


def linear(law: str, gains: Any, share: float = 0.0) -> Loop:
    """The law at an equivalent gain of its power-rate term: none of it (0) up to its largest describing function (1)."""
    if law == "hybrid":
        gains = gains._replace(k1=0.0, k2=gains.k2 + share * 0.9265 * gains.k1 / gains.delta**0.5)
    return Loop(law, gains)


def sampled(law: str, axis: str, share: float = 0.0, vehicle: str = "hummingbird") -> Any:
    v, found = VEHICLES[vehicle], designs(law, vehicle)
    # Yaw leads by J / (2 k_m w_hover): accelerating rotors push before their drag has grown.
    hover = sqrt(0.25 * v.mass * v.gravity / v.thrust_coefficient)
    lead = v.rotor_inertia / (2.0 * v.thrust_coefficient * v.torque_ratio * hover) if axis == "yaw" else 0.0
    rotors = Rotors(0.5 * (v.lag_up + v.lag_down), H, lead=lead)
    loop = linear(law, found[axis].gains, share)
    inner = {"x": "pitch", "y": "roll"}.get(axis)
    return (
        attitude_step(loop, rotors) if inner is None else position_step(loop, linear(law, found[inner].gains), rotors)
    )


@pytest.mark.parametrize("axis", ["roll", "yaw", "z", "x"])
@pytest.mark.parametrize("law", NAMES)
def test_margins_of_the_sampled_loops(law: str, axis: str) -> None:
    """Built without the design's models. Dead time for sampling is right to 2 % of the peaks; Mt 1.5 means 39 deg, 1/3, 3."""
    assert designs(law)[axis].designed
    for share in (0.0, 0.5, 1.0) if law == "hybrid" else (0.0,):
        found = margins(sampled(law, axis, share), H)
        assert found.ms < 1.02 * REQUIREMENTS.ms
        assert found.mt < 1.02 * REQUIREMENTS.mt
        assert found.phase > 38.0
        assert found.rise > 2.4
        assert found.fall > 2.9


def test_margins_on_another_airframe() -> None:
    # Its yaw leads from 15 rad/s on.
    for axis in ("roll", "yaw", "x"):
        found = margins(sampled("ladrc", axis, vehicle="crazyflie-rotors"), H)
        assert found.ms < 1.02 * REQUIREMENTS.ms and found.mt < 1.02 * REQUIREMENTS.mt


def fly(law: str, index: int, duration: float = 4.0) -> Any:
    """One flight in moderate turbulence, in plain Python; the final record and the largest distance from the reference [m]."""
    cascade = close_cascade(LAWS[law], LAWS[law])
    loop = close_loop(cascade, MeterModel(meters.Meters, meters.start, meters.update))
    spec = ScenarioSpec(
        "moderate",
        duration,
        Steps(x=1.0, y=-1.0, z=0.5, yaw_deg=20.0, time=0.5),
        AirSpec(intensity="moderate", mean_wind=False),
    )
    batch = sample_scenarios(spec, HUMMINGBIRD, TIMING, 1, HELD_OUT, [index])
    inputs = lane_of(batch, 0)
    row = row_of(cascade, designs(law))
    away: list[float] = []

    def watch(k: int, flight: Any) -> None:
        if k * H > 3.0:
            away.append(float(np.linalg.norm(np.array(flight.body.position) - batch.references[k, :3])))

    gains = pack(cascade.Gains, row.tolist())
    limits = Limits(5.0, cos(radians(80.0)))
    final = fly_steps(loop, unchanged, gains, known(), inputs, batch.targets, limits, TIMING, watch)
    return final, max(away)


@pytest.mark.slow
@pytest.mark.parametrize("law", NAMES)
def test_designed_gains_fly_in_moderate_turbulence(law: str) -> None:
    final, away = fly(law, 0)
    assert final.status == 0.0
    assert final.end_time == pytest.approx(4.0)
    assert away < 1.5
