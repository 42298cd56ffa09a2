"""A study of any kind before anything flies: its content in numbers, and what is known to stand in its way.

Of a tuning study: its vehicle, its trim in the mean wind, the default's margins, and limits out of reach.
"""

from collections.abc import Callable
from math import degrees, isfinite, radians
from typing import Any, NamedTuple

import numpy as np

from plant.airframes.derived import quantities
from plant.seeds import generator
from plant.vehicle import Vehicle
from tuner.documents.summary import ObstacleRow
from tuner.experiments.planning.counts import comparison_flights, search_flights
from tuner.experiments.tuning.conflicts import automatic_limit_texts, automatic_rows
from tuner.experiments.tuning.diagnosis import Diagnosis, obstacle_texts
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.search.first_generation import latin_hypercube
from tuner.study.contest import Contender, Contest
from tuner.study.inference import Inference
from tuner.study.kinds import AnyStudy
from tuner.study.study import Study
from tuner.study.trim import MeanWindTrim, mean_wind_trim

Row = dict[str, Any]

# Points of the ranges at which limits that are known without flying are asked.
DRAWS = 128
# Margin of a trim to the tilt limit [rad] below which gusts will take it.
NARROW = radians(5.0)


class Preview(NamedTuple):
    """What is known of a study before anything flies, as data; hopeless: whether it asks for what nothing can reach."""

    document: Row
    hopeless: bool = False


def preview(study: AnyStudy) -> Preview:
    """Return what a study would fly and what is known of it without flying."""
    return PREVIEWS[study.kind](study)


def vehicle_row(vehicle: Vehicle) -> Row:
    """Return what a vehicle has to fly with."""
    known = quantities(vehicle)
    shown = {name: known[name] for name in ("thrust_to_weight", "hover_speed")}
    *_, hover = shown.values()
    return {
        "mass": {"value": vehicle.mass, "unit": "kg"},
        **{name: {"value": entry.value, "unit": entry.unit} for name, entry in shown.items()},
        "hover_speed_share": {"value": hover.value / vehicle.speed_max, "unit": "1"},
    }


def trim_row(scenario: str, trim: MeanWindTrim) -> Row:
    """Return steady flight in the mean wind of a scenario; angles [rad] and thrust over the weight null where nothing balances.

    margin: to the tilt limit [rad].
    """
    balanced = isfinite(trim.tilt)
    return {
        "scenario": scenario,
        "wind": trim.wind,
        "tilt": trim.tilt if balanced else None,
        "tilt_limit": trim.tilt_limit,
        "margin": _margin(trim) if balanced else None,
        "thrust": trim.thrust if balanced else None,
        "held": trim.held,
    }


def _margin(trim: MeanWindTrim) -> float:
    return trim.tilt_limit - trim.tilt


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


def study_preview(asked: Study) -> Preview:
    """Return what a study would fly and what is known of it without flying."""
    diagnosis = Diagnosis(asked)
    beyond = beyond_reach(asked, diagnosis)
    trims = [(entry.spec.name, mean_wind_trim(entry.spec, asked.system)) for entry in asked.scenarios]
    held = {name: trim for name, trim in trims if trim is not None}
    document = {
        "kind": "study",
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [entry.objective.label for entry in asked.constraints],
        "automatic_limits": [row.content() for row in automatic_rows(asked.automatic_limits)],
        "requirements": [requirement.label for requirement in asked.requirements],
        "search_flights": search_flights(asked),
        "digest": asked.digest(),
        "vehicle": {"name": asked.airframe.name, **vehicle_row(asked.system.vehicle)},
        "trim": [trim_row(name, trim) for name, trim in held.items()],
        "default": default_rows(asked, diagnosis),
        "out_of_reach": [{**entry.content(), "certain": is_certain(entry)} for entry in beyond],
        "problems": [*trim_problems(held), *obstacle_texts(beyond)],
        "warnings": warnings_before_run(asked),
        "told": automatic_limit_texts(asked.automatic_limits),
    }  # fmt: skip
    return Preview(document, is_hopeless(asked, held, beyond))


def trim_problems(trims: dict[str, MeanWindTrim]) -> list[str]:
    """Return a sentence for each scenario in whose mean wind little or nothing is left of the tilt limit."""
    return [_problem(*entry) for entry in trims.items() if not entry[1].held or _margin(entry[1]) < NARROW]


def _problem(scenario: str, trim: MeanWindTrim) -> str:
    wind = f'scenario "{scenario}": the mean wind of {trim.wind:.3g} m/s'
    if trim.held:
        return f"{wind} leaves {degrees(_margin(trim)):.1f} deg to the tilt limit, which gusts will take."
    remedy = "choose a weaker intensity or mean_wind = false, or raise controller.tilt_limit_deg"
    return f"{wind} is more than the vehicle holds its place in; {remedy}."


def is_hopeless(study: Study, trims: dict[str, MeanWindTrim], beyond: list[ObstacleRow]) -> bool:
    """Whether a hard limit is out of reach for certain, or a mean wind is more than the vehicle can hold."""
    soft = {requirement.label for requirement in study.requirements if not requirement.hard}
    lost = any(not trim.held for trim in trims.values())
    return lost or any(is_certain(row) and row.label not in soft for row in beyond)


def contest_preview(contest: Contest) -> Preview:
    """Return what a contest would fly."""
    document = {
        "kind": "contest",
        "title": contest.title,
        "contenders": [_described(contender) for contender in contest.contenders],
        "quantities": [quantity.label for quantity in contest.quantities],
        "published": len(contest.published),
        "claims": len(contest.claims),
        "search_flights": sum(search_flights(entry.study) for entry in contest.contenders if entry.tuned),
        "comparison_flights_at_most": comparison_flights(contest),
    }
    return Preview(document)


def _described(contender: Contender) -> str:
    searched = len(contender.study.space.variables)
    return f"{contender.name} ({f'{searched} searched' if searched else 'as given'})"


def inference_preview(inference: Inference) -> Preview:
    """Return what an inference would fly."""
    search = inference.contest.base.search
    flown = {(cell.contender, cell.scenario) for cell in inference.cells}
    document = {
        "kind": "inference",
        "title": inference.title,
        "contenders": [contender.name for contender in inference.contest.contenders],
        "unknowns": [unknown.variable.name for unknown in inference.unknowns],
        "cells": [cell.label for cell in inference.cells],
        "search_flights": search.population * search.generations * len(flown) * inference.flights,
    }
    return Preview(document)


PREVIEWS: dict[str, Callable[[Any], Preview]] = {
    Study.kind: study_preview,
    Contest.kind: contest_preview,
    Inference.kind: inference_preview,
}
"""Previews by the kind of study."""
