"""The study of an autotune: the firmware's own attitude loops over the set of vehicles that a log leaves open.

Gains and filters are those that the shipped study of the firmware searches; air and reference are of the shipped study of a
vehicle of that size; objectives and margins are those of roll and pitch, which a log tells most of.
"""

from collections.abc import Mapping
from math import degrees, inf
from pathlib import Path
from typing import Any

from plant.quadrotor.airframes import Airframe
from plant.texts import PlainTable
from tuner.api.gains import QuadrotorGains
from tuner.study.files import shipped_studies
from tuner.study.layers import merged_layers, read_layers
from tuner.text.toml_text import toml_text

STUDIES = {"px4": "px4", "ardupilot": "ardupilot", "betaflight": "betaflight", "crazyflie": "crazyflie_firmware"}
"""Firmware -> its shipped study."""
SIZES = ((0.1, "crazyflie_firmware"), (1.0, "betaflight"), (inf, "px4"))
"""Mass below which a vehicle meets the air of a shipped study [kg]."""
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
        "scenario": [_scenario(airframe.vehicle.mass)],
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


def _scenario(mass: float) -> PlainTable:
    """Return the scenario of a vehicle's size; the gyro's noise is the one of its log."""
    shipped: Any = _shipped(next(name for most, name in SIZES if mass < most))
    (scenario, *_) = shipped["scenario"]
    sensors = {key: value for key, value in scenario.pop("sensors", {}).items() if key != "rate"}
    changed = {"search": FLIGHTS, "held_out": HELD_OUT, "spread": {"from": "airframe"}}
    return {**scenario, **({"sensors": sensors} if sensors else {}), **changed}


def _shipped(name: str) -> PlainTable:
    return merged_layers(read_layers(shipped_studies()[name]))
