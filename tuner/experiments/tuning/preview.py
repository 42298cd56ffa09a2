"""A study before anything flies: its vehicle, its trim in the mean wind, the default's margins, limits out of reach."""

from math import degrees, isfinite, radians
from typing import Any

import numpy as np

from plant.airframes.derived import quantities
from plant.seeds import generator
from plant.vehicle import Vehicle
from tuner.documents.summary import ObstacleRow
from tuner.experiments.tuning.conflicts import automatic_limit_texts, automatic_rows
from tuner.experiments.tuning.diagnosis import Diagnosis, obstacle_texts
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.search.first_generation import latin_hypercube
from tuner.study.study import Study
from tuner.study.trim import MeanWindTrim, mean_wind_trim

Row = dict[str, Any]

# Points of the ranges at which limits that are known without flying are asked.
DRAWS = 128
# Margin of a trim to the tilt limit [rad] below which gusts will take it.
NARROW = radians(5.0)


def vehicle_row(vehicle: Vehicle) -> Row:
    """Return what a vehicle has to fly with."""
    known = quantities(vehicle)
    row = {name: {"value": known[name].value, "unit": known[name].unit} for name in ("thrust_to_weight", "hover_speed")}
    share = known["hover_speed"].value / vehicle.speed_max
    return {"mass": {"value": vehicle.mass, "unit": "kg"}, **row, "hover_speed_share": {"value": share, "unit": "1"}}


def trim_rows(study: Study) -> list[Row]:
    """Return the steady flight in the mean wind of each scenario that has one; angles and thrust null where nothing balances.

    tilt, tilt_limit, margin: to the limit [rad]; thrust: over the weight.
    """
    found = [(entry.spec.name, mean_wind_trim(entry.spec, study.system)) for entry in study.scenarios]
    return [_trim_row(name, trim) for name, trim in found if trim is not None]


def _trim_row(scenario: str, trim: MeanWindTrim) -> Row:
    tilt, limit, balanced = trim.tilt, trim.tilt_limit, isfinite(trim.tilt)
    return {
        "scenario": scenario,
        "wind": trim.wind,
        "tilt": tilt if balanced else None,
        "tilt_limit": limit,
        "margin": limit - tilt if balanced else None,
        "thrust": trim.thrust if balanced else None,
        "held": trim.held,
    }


def default_rows(study: Study, diagnosis: Diagnosis) -> list[Row]:
    """Return how the default stands to each limit that is known without flying, loop by loop; infinite values are null."""
    values = diagnosis.values(study.default_row[None])[0].tolist()
    rows = []
    for probe, value in zip(diagnosis.probes, values, strict=True):
        asked = probe.requirement
        rows.append(
            {
                "label": asked.label, "loop": probe.loop, "value": asked.in_file(value) if isfinite(value) else None,
                **asked.units(), "sense": asked.sense, "limit": asked.in_file(asked.limit), "hard": asked.hard,
                "kept": bool(asked.kept(np.array([value]))[0]),
            }
        )  # fmt: skip
    return rows


def beyond_reach(study: Study, diagnosis: Diagnosis) -> list[ObstacleRow]:
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


def is_certain(found: ObstacleRow) -> bool:
    """Return whether no search can help: nothing that is searched moves it."""
    return not found.moved_by


def search_flights(study: Study) -> int:
    """Return how many flights the search takes at most."""
    return study.search.generations * study.search.population * sum(entry.search for entry in study.scenarios)


def study_preview(asked: Study) -> Row:
    """Return what a study would fly and what is known of it without flying."""
    diagnosis = Diagnosis(asked)
    beyond = beyond_reach(asked, diagnosis)
    trims = trim_rows(asked)
    return {
        "kind": "study",
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [entry.objective.label for entry in asked.constraints],
        "automatic_limits": automatic_rows(asked.constraints),
        "requirements": [requirement.label for requirement in asked.requirements],
        "search_flights": search_flights(asked),
        "digest": asked.digest(),
        "vehicle": {"name": asked.airframe.name, **vehicle_row(asked.system.vehicle)},
        "trim": trims,
        "default": default_rows(asked, diagnosis),
        "out_of_reach": [{**entry.content(), "certain": is_certain(entry)} for entry in beyond],
        "problems": [*trim_problems(trims), *obstacle_texts(beyond)],
        "warnings": warnings_before_run(asked),
        "told": automatic_limit_texts(asked.constraints),
    }  # fmt: skip


def trim_problems(trims: list[Row]) -> list[str]:
    """Return a sentence for each scenario in whose mean wind little or nothing is left of the tilt limit."""
    return [_problem(row) for row in trims if not row["held"] or row["margin"] < NARROW]


def _problem(row: Row) -> str:
    wind = f'scenario "{row["scenario"]}": the mean wind of {row["wind"]:.3g} m/s'
    if row["held"]:
        return f"{wind} leaves {degrees(row['margin']):.1f} deg to the tilt limit, which gusts will take."
    remedy = "choose a weaker intensity or mean_wind = false, or raise controller.tilt_limit_deg"
    return f"{wind} is more than the vehicle holds its place in; {remedy}."


def is_hopeless(figures: Row) -> bool:
    """Return whether a hard limit is out of reach for certain, or a mean wind is more than the vehicle can hold."""
    soft = {row["label"] for row in figures["default"] if not row["hard"]}
    return any(not row["held"] for row in figures["trim"]) or any(
        row["certain"] and row["label"] not in soft for row in figures["out_of_reach"]
    )
