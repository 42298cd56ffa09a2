"""inference.json: what an inference found, in numbers and sentences; every time in s, every angle in rad."""

import numpy as np

from plant.ties import first_smallest
from tuner.documents.inference_document import (
    BestJointSetting,
    CellRow,
    DefaultAndInferred,
    FrontSetting,
    InferenceDocument,
    InferenceSettings,
    KindRow,
    LostFlights,
    MisfitPart,
    MissedCell,
    RatioRow,
    SpreadPart,
    UnknownRow,
)
from tuner.experiments.contest.judging import is_inside, percentile_of
from tuner.experiments.inference import misfit
from tuner.experiments.inference.findings import Findings
from tuner.experiments.inference.ranges import Range, near_rows
from tuner.experiments.inference.words import sentences
from tuner.search.loop import point_name
from tuner.study.inference import Unknown

# Rows of `Findings.checked`.
DEFAULT, CHOSEN, MOST, SHOWN = 0, 1, 2, 3


def inference_document(findings: Findings) -> InferenceDocument:
    """Return the content of inference.json."""
    inference = findings.inference
    contest = inference.contest
    document = InferenceDocument(
        title=contest.title,
        description=contest.description,
        study=inference.path.name,
        seed=contest.seed,
        contenders=[contender.name for contender in contest.contenders],
        settings=settings_part(findings),
        inferred=point_name(findings.chosen),
        unknowns=[
            unknown_row(unknown, findings.settings.values[findings.chosen, i], findings.ranges[i])
            for i, unknown in enumerate(inference.unknowns)
        ],
        kinds=[KindRow(metric=kind.name, definition=kind.definition) for kind in inference.kinds],
        cells=[cell_row(findings, i) for i in range(len(inference.cells))],
        ratios=[ratio_row(findings, i) for i in range(len(inference.ratios))],
        misfit=DefaultAndInferred(
            default=misfit_part(findings, 0, DEFAULT), inferred=misfit_part(findings, findings.chosen, CHOSEN)
        ),
        together=together(findings),
        front=[front_setting(findings, i) for i in range(len(findings.shown))],
        failures=lost_flights(findings),
        flights=findings.flights,
        wall_seconds=findings.seconds,
        words=[],
    )
    return document.model_copy(update={"words": sentences(document)})


def settings_part(findings: Findings) -> InferenceSettings:
    """Return the size of an inference."""
    inference, search = findings.inference, findings.inference.search
    return InferenceSettings(
        flights=inference.flights,
        held_out=inference.held_out,
        near=inference.near,
        population=search.population,
        generations=search.generations,
        tried=len(findings.settings.values),
    )


def unknown_row(unknown: Unknown, inferred: float, posterior: Range) -> UnknownRow:
    """Return the row of an unknown; posterior: see `tuner.experiments.inference.ranges`."""
    variable = unknown.variable
    return UnknownRow(
        name=variable.name,
        unit=unknown.unit,
        set=list(variable.addresses),
        low=variable.low,
        high=variable.high,
        scale=variable.scale,
        default=unknown.default,
        inferred=float(inferred),
        **vars(posterior),
        verdict=posterior.verdict,
    )


def cell_row(findings: Findings, i: int) -> CellRow:
    """Return the row of a published number: ours at the inferred setting, and the nearest of all settings."""
    cell = findings.inference.cells[i]
    value = np.array([cell.value])
    ours, default = (spread(scores[[i]], value) for scores in (findings.scores, findings.default_scores))
    return CellRow(
        contender=cell.contender,
        metric=cell.metric.text,
        kind=cell.metric.metric.name,
        unit=cell.metric.unit,
        scenario=cell.scenario,
        published=cell.value,
        ours=ours,
        default=default,
        percentile=ours.percentile,
        **verdicts(findings, findings.settings.inside[:, i], findings.checked.inside[:, i]),
        ratio=ours.median / cell.value,
        tolerance=float(misfit.tolerance(findings.scores[[i]], value)[0]),
        best_ratio=nearest(findings.settings.median[:, i] / cell.value),
    )


def ratio_row(findings: Findings, i: int) -> RatioRow:
    """Return the row of a ratio of two contenders: second to first, flight by flight."""
    inference = findings.inference
    pair = inference.ratios[i]
    first, second = inference.cells[pair.first], inference.cells[pair.second]
    published = misfit.published_ratios(inference)[[i]]
    # No mean: one flight in which the first is 0 would decide it.
    ours, default = (
        spread(misfit.ratio_scores(inference, scores[None])[0, [i]], published, with_mean=False)
        for scores in (findings.scores, findings.default_scores)
    )
    return RatioRow(
        first=first.contender,
        second=second.contender,
        metric=first.metric.text,
        scenario=first.scenario,
        published=float(published[0]),
        ours=ours,
        default=default,
        percentile=ours.percentile,
        **verdicts(findings, findings.settings.ratio_inside[:, i], findings.checked.ratio_inside[:, i]),
        nearest=float(published[0]) * nearest(findings.settings.ratio[:, i] / published[0]),
    )


def verdicts(findings: Findings, inside: np.ndarray, checked: np.ndarray) -> dict[str, bool]:
    """Return the verdicts on a published value: inside at the inferred setting, near the least misfit, at any.

    inside (n,): under the settings that were flown; checked: under those that were flown held out.
    """
    near = near_rows(findings.inference, findings.settings)
    at_inferred = bool(checked[CHOSEN])
    consistent = at_inferred or bool(inside[near].any(axis=0))
    reproducible = consistent or bool(inside.any(axis=0) or checked.any(axis=0))
    return {"inside": at_inferred, "consistent": consistent, "reproducible": reproducible}


def spread(scores: np.ndarray, published: np.ndarray, with_mean: bool = True) -> SpreadPart:
    """Return the distribution of scores (1, flights) with the published value's percentile."""
    low68, high68 = np.quantile(scores[0], misfit.CENTRAL_68, axis=-1)
    low95, high95 = np.quantile(scores[0], misfit.CENTRAL_95, axis=-1)
    percentile = percentile_of(published, scores)
    mean = {"mean": float(scores[0].mean(axis=-1))} if with_mean else {}
    return SpreadPart(
        **mean,
        median=float(np.median(scores[0], axis=-1)),
        low68=float(low68),
        high68=float(high68),
        low95=float(low95),
        high95=float(high95),
        percentile=float(percentile[0]),
        inside=bool(is_inside(percentile)[0]),
    )


def nearest(ratios: np.ndarray) -> float:
    """Return the ratio (n,) that is nearest to 1 by its logarithm."""
    distance = np.abs(misfit.log_ratio(ratios, np.ones_like(ratios)))
    return float(ratios[first_smallest(distance, scale=1.0)])


def misfit_part(findings: Findings, row: int, checked: int) -> MisfitPart:
    """Return the misfits of a setting and its numbers of cells inside."""
    return MisfitPart(
        search=misfit_of(findings, findings.settings, row),
        held_out=misfit_of(findings, findings.checked, checked),
        inside=int(findings.checked.inside[checked].sum(axis=0)),
        ratios_inside=int(findings.checked.ratio_inside[checked].sum(axis=0)),
    )


def misfit_of(findings: Findings, settings: misfit.EvaluatedSettings, row: int) -> dict[str, float]:
    """Return the misfits of a setting: of each kind, and over all cells."""
    inference = findings.inference
    values = settings.misfits(inference)[row]
    named = {kind.name: float(value) for kind, value in zip(inference.kinds, values, strict=True)}
    return {**named, "all": float(settings.overall(inference)[row])}


def together(findings: Findings) -> BestJointSetting:
    """Return the setting with the most cells inside: in the search, and held out."""
    inside = findings.checked.inside[MOST]
    return BestJointSetting(
        candidate=point_name(findings.most),
        search=int(findings.settings.inside[findings.most].sum(axis=0)),
        held_out=int(inside.sum(axis=0)),
        of=len(inside),
        missed=[
            MissedCell(contender=cell.contender, metric=cell.metric.text, scenario=cell.scenario)
            for cell, good in zip(findings.inference.cells, inside, strict=True)
            if not good
        ],
    )


def front_setting(findings: Findings, i: int) -> FrontSetting:
    """Return a setting of the front."""
    inference, row = findings.inference, int(findings.shown[i])
    names = [unknown.variable.name for unknown in inference.unknowns]
    values = findings.settings.values[row].tolist()
    return FrontSetting(
        candidate=point_name(row),
        unknowns=dict(zip(names, values, strict=True)),
        **vars(misfit_part(findings, row, SHOWN + i)),
    )


def lost_flights(findings: Findings) -> list[LostFlights]:
    """Return each contender's share of failed held-out flights: at the default and the inferred setting."""
    checked, rows = findings.checked.failures, []
    for name in dict.fromkeys(cell.contender for cell in findings.inference.cells):
        mine = [i for i, cell in enumerate(findings.inference.cells) if cell.contender == name]
        default, inferred = (float(checked[row, mine].max(axis=0)) for row in (DEFAULT, CHOSEN))
        rows.append(LostFlights(contender=name, default=default, inferred=inferred))
    return rows
