"""A study of any kind before anything flies: its content in numbers, and what is known to stand in its way."""

from collections.abc import Callable
from typing import Any

from tuner.experiments.planning.contest import comparison_flights
from tuner.experiments.tuning.preview import search_flights, study_preview
from tuner.study.contest import Contender, Contest
from tuner.study.inference import Inference
from tuner.study.kinds import AnyStudy
from tuner.study.study import Study

Row = dict[str, Any]


def preview(study: AnyStudy) -> Row:
    """Return what a study would fly and what is known of it without flying."""
    return PREVIEWS[study.kind](study)


def contest_preview(contest: Contest) -> Row:
    """Return what a contest would fly."""
    return {
        "kind": "contest",
        "title": contest.title,
        "contenders": [_described(contender) for contender in contest.contenders],
        "quantities": [quantity.label for quantity in contest.quantities],
        "published": len(contest.published),
        "claims": len(contest.claims),
        "search_flights": sum(search_flights(entry.study) for entry in contest.contenders if entry.tuned),
        "comparison_flights_at_most": comparison_flights(contest),
    }


def _described(contender: Contender) -> str:
    searched = len(contender.study.space.variables)
    return f"{contender.name} ({f'{searched} searched' if searched else 'as given'})"


def inference_preview(inference: Inference) -> Row:
    """Return what an inference would fly."""
    search = inference.contest.base.search
    flown = {(cell.contender, cell.scenario) for cell in inference.cells}
    return {
        "kind": "inference",
        "title": inference.title,
        "contenders": [contender.name for contender in inference.contest.contenders],
        "unknowns": [unknown.variable.name for unknown in inference.unknowns],
        "cells": [cell.label for cell in inference.cells],
        "search_flights": search.population * search.generations * len(flown) * inference.flights,
    }


PREVIEWS: dict[str, Callable[[Any], Row]] = {
    Study.kind: study_preview,
    Contest.kind: contest_preview,
    Inference.kind: inference_preview,
}
"""Previews by the kind of study."""
