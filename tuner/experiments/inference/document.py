"""inference.json: what an inference found, in numbers and sentences; every time in s, every angle in rad."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.experiments.inference.evaluated import EvaluatedSettings, published_ratios, ratio_scores
from tuner.experiments.inference.misfit import CENTRAL_68, CENTRAL_95, is_inside, log_ratio, percentile, tolerance
from tuner.experiments.inference.ranges import Range, near_rows
from tuner.experiments.inference.words import sentences
from tuner.search.loop import point_name
from tuner.study.inference import Unknown

if TYPE_CHECKING:
    from tuner.experiments.inference.findings import Findings

Document = dict[str, Any]
# Rows of `Findings.checked`.
DEFAULT, CHOSEN, MOST, SHOWN = 0, 1, 2, 3


def inference_document(findings: "Findings") -> Document:
    """Return the content of inference.json."""
    inference = findings.inference
    contest, search = inference.contest, inference.contest.base.search
    document = {
        "title": contest.title,
        "description": contest.description,
        "study": inference.path.name,
        "seed": contest.seed,
        "contenders": [contender.name for contender in contest.contenders],
        "settings": {
            "flights": inference.flights, "held_out": inference.held_out, "near": inference.near,
            "population": search.population, "generations": search.generations, "tried": len(findings.found.values),
        },
        "inferred": point_name(findings.chosen),
        "unknowns": [
            unknown_row(unknown, findings.found.values[findings.chosen, i], findings.ranges[i])
            for i, unknown in enumerate(inference.unknowns)
        ],
        "kinds": [{"metric": kind.name, "definition": kind.definition} for kind in inference.kinds],
        "cells": [cell_row(findings, i) for i in range(len(inference.cells))],
        "ratios": [ratio_row(findings, i) for i in range(len(inference.ratios))],
        "misfit": {"default": misfit_row(findings, 0, DEFAULT), "inferred": misfit_row(findings, findings.chosen, CHOSEN)},
        "together": together(findings),
        "front": [front_row(findings, i) for i in range(len(findings.shown))],
        "failures": failures(findings),
        "flights": findings.flights,
        "wall_seconds": findings.seconds,
    }  # fmt: skip
    return {**document, "words": sentences(document)}


def unknown_row(unknown: Unknown, inferred: float, told: Range) -> Document:
    """Return what was found of an unknown; ranges as told in `tuner.experiments.inference.ranges`."""
    variable = unknown.variable
    return {
        "name": variable.name, "unit": unknown.unit, "set": list(variable.addresses), "low": variable.low,
        "high": variable.high, "scale": variable.scale, "default": unknown.default, "inferred": float(inferred),
        "near_low": told.near_low, "near_high": told.near_high, "low68": told.low68, "high68": told.high68,
        "share": told.share, "at_end": told.at_end, "verdict": told.verdict,
    }  # fmt: skip


def cell_row(findings: "Findings", i: int) -> Document:
    """Return a published number beside ours at the inferred setting, and what the best of all settings made of it."""
    cell = findings.inference.cells[i]
    value = np.array([cell.value])
    ours, default = (spread(scores[[i]], value) for scores in (findings.scores, findings.default_scores))
    return {
        "contender": cell.contender, "metric": cell.metric.text, "kind": cell.metric.metric.name, "unit": cell.metric.unit,
        "scenario": cell.scenario, "published": cell.value, "ours": ours, "default": default,
        "percentile": ours["percentile"], **verdicts(findings, findings.found.inside[:, i], findings.checked.inside[:, i]),
        "ratio": ours["median"] / cell.value, "tolerance": float(tolerance(findings.scores[[i]], value)[0]),
        "best_ratio": nearest(findings.found.median[:, i] / cell.value),
    }  # fmt: skip


def ratio_row(findings: "Findings", i: int) -> Document:
    """Return the ratio of two contenders in one cell, second to first, flight by flight."""
    inference = findings.inference
    pair = inference.ratios[i]
    first, second = inference.cells[pair.first], inference.cells[pair.second]
    published = published_ratios(inference)[[i]]
    ours, default = (
        spread(ratio_scores(inference, scores[None])[0, [i]], published)
        for scores in (findings.scores, findings.default_scores)
    )
    for part in (ours, default):
        # One flight in which the first is 0 would decide it.
        del part["mean"]
    return {
        "first": first.contender, "second": second.contender, "metric": first.metric.text, "scenario": first.scenario,
        "published": float(published[0]), "ours": ours, "default": default, "percentile": ours["percentile"],
        **verdicts(findings, findings.found.ratio_inside[:, i], findings.checked.ratio_inside[:, i]),
        "nearest": float(published[0]) * nearest(findings.found.ratio[:, i] / published[0]),
    }  # fmt: skip


def verdicts(findings: "Findings", inside: np.ndarray, checked: np.ndarray) -> dict[str, bool]:
    """Return where a published value lies inside: at the inferred setting, at one near the least misfit, at any.

    inside (n,): under the settings that were flown; checked: under those that were flown held out.
    """
    near = near_rows(findings.inference, findings.found)
    at_inferred = bool(checked[CHOSEN])
    consistent = at_inferred or bool(inside[near].any(axis=0))
    reproducible = consistent or bool(inside.any(axis=0) or checked.any(axis=0))
    return {"inside": at_inferred, "consistent": consistent, "reproducible": reproducible}


def spread(scores: np.ndarray, published: np.ndarray) -> Document:
    """Return the distribution of scores (1, flights) over the flights, and where the published value (1,) stands in it."""
    low68, high68 = np.quantile(scores[0], CENTRAL_68, axis=-1)
    low95, high95 = np.quantile(scores[0], CENTRAL_95, axis=-1)
    where = percentile(scores, published)
    return {
        "mean": float(scores[0].mean(axis=-1)), "median": float(np.median(scores[0], axis=-1)),
        "low68": float(low68), "high68": float(high68), "low95": float(low95), "high95": float(high95),
        "percentile": float(where[0]), "inside": bool(is_inside(where)[0]),
    }  # fmt: skip


def nearest(ratios: np.ndarray) -> float:
    """Return the ratio (n,) that is nearest to 1 by its logarithm."""
    distance = np.abs(log_ratio(ratios, np.ones_like(ratios)))
    return float(ratios[np.argmin(distance)])


def misfit_row(findings: "Findings", row: int, checked: int) -> Document:
    """Return the misfits of a setting, in the search and held out, and how many published cells lie inside."""
    return {
        "search": misfit_of(findings, findings.found, row),
        "held_out": misfit_of(findings, findings.checked, checked),
        "inside": int(findings.checked.inside[checked].sum(axis=0)),
        "ratios_inside": int(findings.checked.ratio_inside[checked].sum(axis=0)),
    }


def misfit_of(findings: "Findings", settings: EvaluatedSettings, row: int) -> dict[str, float]:
    """Return the misfit of each kind and over all cells of one setting."""
    inference = findings.inference
    values = settings.misfits(inference)[row]
    named = {kind.name: float(value) for kind, value in zip(inference.kinds, values, strict=True)}
    return {**named, "all": float(settings.overall(inference)[row])}


def together(findings: "Findings") -> Document:
    """Return the setting of the search under which the most cells lie inside at once, and what it misses held out."""
    inside = findings.checked.inside[MOST]
    missed = [
        {"contender": cell.contender, "metric": cell.metric.text, "scenario": cell.scenario}
        for cell, good in zip(findings.inference.cells, inside, strict=True)
        if not good
    ]
    return {
        "candidate": point_name(findings.most), "search": int(findings.found.inside[findings.most].sum(axis=0)),
        "held_out": int(inside.sum(axis=0)), "of": len(inside), "missed": missed,
    }  # fmt: skip


def front_row(findings: "Findings", i: int) -> Document:
    """Return a setting of the front."""
    inference, row = findings.inference, int(findings.shown[i])
    names = [unknown.variable.name for unknown in inference.unknowns]
    values = findings.found.values[row].tolist()
    return {
        "candidate": point_name(row),
        "unknowns": dict(zip(names, values, strict=True)),
        **misfit_row(findings, row, SHOWN + i),
    }


def failures(findings: "Findings") -> list[Document]:
    """Return the share of held-out flights that failed, of each contender, under the default and the inferred setting."""
    checked, rows = findings.checked.failures, []
    for name in dict.fromkeys(cell.contender for cell in findings.inference.cells):
        mine = [i for i, cell in enumerate(findings.inference.cells) if cell.contender == name]
        default, inferred = (float(checked[row, mine].max(axis=0)) for row in (DEFAULT, CHOSEN))
        rows.append({"contender": name, "default": default, "inferred": inferred})
    return rows
