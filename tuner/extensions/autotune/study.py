"""The study of an autotune: the firmware's own attitude loops over the set of vehicles that a log leaves open.

Gains and filters are those that the shipped study of the firmware searches; the flight is the one that `tuner judge` judges the
result by; objectives and margins are those of roll and pitch, which a log identifies best.
"""

from collections.abc import Mapping
from dataclasses import fields
from math import degrees
from pathlib import Path
from typing import Any

from plant.quadrotor.airframes import Airframe
from plant.texts import PlainTable
from tuner.api.gains import QuadrotorGains
from tuner.extensions.judge.scenarios import FIRST_FLIGHT
from tuner.study.files import shipped_studies
from tuner.study.layers import merged_layers, read_layers
from tuner.text.toml_text import toml_text

STUDIES = {"px4": "px4", "ardupilot": "ardupilot", "betaflight": "betaflight", "crazyflie": "crazyflie_firmware"}
"""Firmware -> its shipped study."""
SEARCHED = ("tilt.", "attitude.")
"""Beginnings of the addresses of gains that are searched."""
SEED, FLIGHTS, HELD_OUT = 2026, 8, 256
SEARCH = {"algorithm": "nsga2", "population": 16, "generations": 12}
"""Margins at the ends of the set take 100 times the time of the flights, so the algorithm that computes few of them is quicker:
12 generations took 1.8 minutes of a processor, 19 of the usual one 7, with log15 of docs/identify.md.
"""
LIMITS: tuple[tuple[str, str, float], ...] = (
    ("phase_margin", "min", 35.0),
    ("gain_margin", "min", 6.0),
    ("ms", "max", 2.0),
)
"""Quantity, sense and bound of a margin [deg], [dB], [1]."""


def autotune_study(source: str, airframe: Airframe, vehicle: Path, present: QuadrotorGains, default: Path) -> str:
    """Return the study as TOML.

    Args:
        source: firmware.
        airframe: the identified one.
        vehicle: its file, as the study names it.
        present: what the vehicle flies.
        default: its gains.json, as the study names it.
    """
    controller = present.controller
    table: PlainTable = {
        "title": f"{airframe.title}: roll and pitch of {source}",
        "seed": SEED,
        "airframe": {"file": str(vehicle)},
        "controller": {
            # Laws by name and no target: of gains that are not searched, the vehicle's may be beyond usual ranges.
            "attitude": controller.cascade.attitude.name,
            "position": controller.cascade.position.name,
            "control_period": controller.control_period,
            "position_every": controller.cascade.position_every,
            "delay": True,
            "tilt_limit_deg": round(degrees(controller.options.tilt_limit), 6),
            "default": str(default),
        },
        "gains": _searched_gains(source),
        "scenario": [_scenario()],
        "objective": [{"metric": "rms.tilt", "risk": "cvar", "level": 0.8}, {"metric": "noise"}],
        "constraint": [{"metric": "failure", "max": 0.0}],
        "margin": [
            {"quantity": quantity, "axis": "tilt", sense: bound, "spread": True} for quantity, sense, bound in LIMITS
        ],
        "search": dict(SEARCH),
        "pick": {"rule": "closest"},
    }
    return toml_text(table)


def _searched_gains(source: str) -> PlainTable:
    given: Any = _shipped(STUDIES[source])["gains"]
    return {address: dict(entry) for address, entry in given.items() if _is_searched(address, entry)}


def _is_searched(address: str, entry: object) -> bool:
    return address.startswith(SEARCHED) and isinstance(entry, Mapping)


def _scenario() -> PlainTable:
    """Return the first flight; the gyro's noise is the one of the log."""
    flight = FIRST_FLIGHT
    return {
        "name": flight.name,
        "duration": flight.duration,
        "search": FLIGHTS,
        "held_out": HELD_OUT,
        "reference": {"kind": flight.reference.kind, **_given(flight.reference)},
        "air": _given(flight.air),
        "spread": {"from": "airframe"},
    }


def _given(spec: Any) -> PlainTable:
    """Return the fields of a dataclass that are not at their default."""
    return {field.name: value for field in fields(spec) if (value := getattr(spec, field.name)) != field.default}


def _shipped(name: str) -> PlainTable:
    return merged_layers(read_layers(shipped_studies()[name]))
