"""What the tests of the margins share: models of law pairs, random gains, and loops that are known in closed form."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.describing import Case
from objectives.margins.loop_margins import SMALL
from objectives.margins.margins import MarginModel
from objectives.margins.period import constants_of
from objectives.margins.results import Realization
from objectives.margins.trim import Trim
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import Cascade, close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Vec3

Array = NDArray[np.float64]

H = 0.004
TIMING = Timing(H, 0.001)
HUMMINGBIRD = load("hummingbird").vehicle
OPTIONS = {
    "gyro, lag-aware": ControlOptions(),
    "observer rates": ControlOptions(attitude_rate="observer", position_rate="observer", lag_aware=False),
    "delayed": ControlOptions(delay=True),
}

# Laws of which cascades of quadrotors can be made: that of y' = f + b0 u does not hold y'' = f + b0 u with any gains.
CASCADED = [name for name in LAWS if name != "adrc1"]


@cache
def cascade_of(position: str, attitude: str) -> Cascade:
    """Return the cascade of two laws by name."""
    return close_cascade(LAWS[position], LAWS[attitude])


@cache
def model_of(
    position: str,
    attitude: str,
    options: ControlOptions = OPTIONS["delayed"],
    trim: Trim | None = None,
    cases: tuple[Case, ...] = (Case(0.3),),
    vehicle: Vehicle = HUMMINGBIRD,
    timing: Timing = TIMING,
    others: tuple[Vehicle, ...] = (),
) -> MarginModel:
    """Return the margins of two laws; terms are closed at one amplitude unless told otherwise."""
    knowledge = nominal(vehicle, options, timing.control_period)
    return MarginModel(cascade_of(position, attitude), knowledge, timing, vehicle, trim, cases=cases, others=others)


def default_gains(position: str, attitude: str) -> Array:
    """Return the default gains row (g,)."""
    return np.array(default_row(cascade_of(position, attitude)))


def random_gains(position: str, attitude: str, n: int, seed: int, spread: float = 0.7) -> Array:
    """Return gains rows (n, g): defaults times exp(+-spread)."""
    row = default_gains(position, attitude)
    return row * np.exp(np.random.default_rng(seed).uniform(-spread, spread, (n, len(row))))


def gains_with(position: str, attitude: str, **changed: float) -> Array:
    """Return default gains (1, g) with those of some addresses changed: roll__omega_c = 3.0."""
    row = default_gains(position, attitude)
    for address, value in changed.items():
        gain = next(
            g for g in gain_addresses(cascade_of(position, attitude)) if g.address == address.replace("__", ".")
        )
        row[gain.column] = value
    return row[None]


def constants_of_hybrid(k1: float, k2: float, delta: float) -> Any:
    """Constants of the hybrid law's roll loop, as arrays."""
    gains = gains_with("hybrid", "hybrid", roll__k1=k1, roll__k2=k2, roll__delta=delta)
    return constants_of(cascade_of("hybrid", "hybrid"), gains, H).roll


def ideal_vehicle(lag: float) -> Vehicle:
    """A vehicle without drag or damping whose massless rotors follow with a time constant [s]."""
    none = Vec3(0.0, 0.0, 0.0)
    return HUMMINGBIRD._replace(
        drag_linear=none,
        drag_quadratic=none,
        rate_damping=none,
        drag_height=0.0,
        lag_up=lag,
        lag_down=lag,
        rotor_inertia=0.0,
    )


def realisation(model: MarginModel, gains: NDArray[np.float64], channel: str, case: Case = SMALL) -> Realization:
    """State space of a closed loop of the first vehicle under a gains row (g,), its block's channels all at one rate."""
    index, loops = model.channels.index(channel), model._linearizations[0]
    block = next(block for block in loops.blocks if index in block.channels)
    phases = loops.at(gains[None]).phases(block, np.ones(1, dtype=bool))
    closed, form = model._closed(loops, block, (index,), phases, model._term_gains(gains[None], (case,)))
    return Realization(closed.a[0], closed.b[0, :, 0], closed.c[0, 0], form.period)
