"""A study before anything flies: its vehicle, its trim in the mean wind, the default's margins, limits out of reach."""

from math import atan, cos, degrees, inf, isfinite, radians, sin
from typing import Any

import numpy as np

from plant.airframes.derived import quantities
from plant.nominal import Nominal
from plant.scenarios import ScenarioSpec
from plant.seeds import generator
from plant.trim import trim_of, within_limits
from plant.vehicle import Vehicle
from tuner.diagnosis import Diagnosis, Obstacle
from tuner.search.first_generation import latin_hypercube
from tuner.study.margins import holds_place
from tuner.study.study import Study

Row = dict[str, Any]

# Points of the ranges at which limits that are known without flying are asked.
DRAWS = 128
# Directions [deg] that a wind without one of its own is tried in; drag may differ between the body axes.
DIRECTIONS = (0.0, 45.0, 90.0)
# Of a trim: margins to the limit of tilt [deg] below which gusts will reach it.
NARROW = 5.0


def vehicle_row(vehicle: Vehicle) -> Row:
    """Return what a vehicle has to fly with."""
    known = quantities(vehicle)
    row = {name: {"value": known[name].value, "unit": known[name].unit} for name in ("thrust_to_weight", "hover_speed")}
    share = known["hover_speed"].value / vehicle.speed_max
    return {"mass": {"value": vehicle.mass, "unit": "kg"}, **row, "hover_speed_share": {"value": share, "unit": "1"}}


def has_trim(study: Study, spec: ScenarioSpec) -> bool:
    """Return whether a mean wind blows on flights of a scenario that hold a place against it."""
    return spec.air.mean_wind and spec.air.wind_speed > 0.0 and holds_place((spec,), study.system.timing)


def trim_row(study: Study, spec: ScenarioSpec) -> Row:
    """Return the steady flight in the mean wind of a scenario, in the direction that takes the most tilt.

    tilt_deg, margin_deg (to the tilt limit) and thrust (over the weight) are null where nothing balances.
    """
    known, wind = study.system.nominal, spec.air.wind_speed
    given = spec.air.wind_direction_deg
    found = [_trim(study.system.vehicle, known, wind, angle) for angle in (DIRECTIONS if given is None else (given,))]
    tilt, thrust, held = max(found, key=lambda entry: entry[0])
    limit = degrees(atan(known.tilt_tangent))
    return {
        "scenario": spec.name,
        "wind": wind,
        "tilt_deg": tilt if isfinite(tilt) else None,
        "tilt_limit_deg": limit,
        "margin_deg": limit - tilt if isfinite(tilt) else None,
        "thrust": thrust if isfinite(tilt) else None,
        "held": held,
    }


def _trim(vehicle: Vehicle, known: Nominal, wind: float, angle: float) -> tuple[float, float, bool]:
    """Return tilt [deg], thrust over weight and whether the controller's limits let it be held."""
    flight = trim_of(vehicle, (wind * cos(radians(angle)), wind * sin(radians(angle)), 0.0))
    if not flight.balanced[0]:
        return inf, inf, False
    return degrees(float(flight.tilt[0])), float(flight.thrust[0]), bool(within_limits(flight, known)[0])


def default_rows(study: Study, diagnosis: Diagnosis) -> list[Row]:
    """Return how the default stands to each limit that is known without flying, loop by loop; infinite values are null."""
    values = diagnosis.values(study.default_row[None])[0].tolist()
    rows = []
    for probe, value in zip(diagnosis.probes, values, strict=True):
        asked = probe.requirement
        rows.append(
            {
                "label": asked.label, "loop": probe.loop, "value": value if isfinite(value) else None, "unit": asked.unit,
                "sense": asked.sense, "limit": asked.limit, "hard": asked.hard, "kept": bool(asked.kept(np.array([value]))[0]),
            }
        )  # fmt: skip
    return rows


def beyond_reach(study: Study, diagnosis: Diagnosis) -> list[Obstacle]:
    """Return what stands behind the limits that neither the default nor a draw from the ranges keeps."""
    if not study.requirements:
        return []
    searched = len(study.space.variables)
    drawn = latin_hypercube(DRAWS, searched, generator(study.seed, "check/reach", 0)) if searched else np.empty((0, 0))
    points = np.concatenate([study.space.point(study.default_row)[None].reshape(1, searched), drawn])
    names = ["default", *[f"draw {i + 1}" for i in range(len(drawn))]]
    values = diagnosis.values(study.space.gains(points))
    kept = np.stack([probe.broken(values[:, i]) <= 0.0 for i, probe in enumerate(diagnosis.probes)], axis=1)
    labels = []
    for requirement in study.requirements:
        mine = [i for i, probe in enumerate(diagnosis.probes) if probe.requirement.label == requirement.label]
        if not kept[:, mine].all(axis=1).any():
            labels.append(requirement.label)
    return diagnosis.obstacles(points, names, labels)


def is_certain(found: Obstacle) -> bool:
    """Return whether no search can help: nothing that is searched moves it."""
    return not found.moved_by
