"""Document of a comparison: numbers and sentences; results/README.md lists the keys."""

from collections.abc import Sequence
from typing import Any, TypedDict

from objectives.flown_system import FlownSystem
from objectives.risk import RISKS
from tuner.documents.comparison_document import (
    BestRow,
    BestUnder,
    ComparedOn,
    ContenderPick,
    ContenderRow,
    DifferenceRow,
    EstimateRow,
    FrontSize,
    FrontsPart,
    QuantityRow,
    SearchBudget,
    VolumeDifference,
    VolumeRow,
)
from tuner.documents.parts import GainValue, LawNames, SampledValue, ShareCount
from tuner.experiments.compare.fronts import Best, Volumes
from tuner.experiments.compare.result import Result
from tuner.experiments.compare.statistics import Difference
from tuner.study.comparison import Quantity
from tuner.study.study import TuningStudy

BOX = "share that a front dominates of the box from ideal to reference, 1.1 times the nadir of the union of all fronts"


def shared_keys(result: Result, words: list[str], warnings: list[str]) -> dict[str, Any]:
    """Return the keys that the documents of all comparisons have; words: the result in sentences."""
    study = result.study
    return dict(
        feasible=all(entrant.feasible for entrant in result.prepared),
        ending=[text for entrant in result.prepared for text in entrant.ending],
        title=study.title,
        description=study.description,
        study=study.path.name,
        seed=study.seed,
        flights=result.flights,
        stream=study.stream,
        compared_on=[
            ComparedOn(scenario=entry.spec.name, flights=entry.held_out, duration=entry.spec.duration)
            for entry in study.scenarios
        ],
        wall_seconds=result.seconds,
        contenders=[contender_row(result, k) for k in range(len(result.names))],
        quantities=[quantity_row(quantity) for quantity in study.quantities],
        estimates=[estimate_row(result, k, i) for k in range(len(result.names)) for i in range(len(study.quantities))],
        differences=[difference_row(result, entry) for entry in result.comparison.differences],
        fronts=fronts_part(result),
        best_under=[best_row(result, best) for best in result.best_under],
        words=words,
        warnings=warnings,
    )


def estimate_row(result: Result, k: int, i: int) -> EstimateRow:
    """Return a contender's estimate of a quantity; that of a share (of zeros and ones) with its count."""
    objective, estimate = result.study.quantities[i].objective, result.comparison.estimates[k][i]
    row = EstimateRow(contender=result.names[k], quantity=objective.label, **estimate.content())
    samples = result.flown.samples(i, objective.scenario)[k]
    return row.model_copy(update={"count": ShareCount.of(samples)}) if objective.is_binary else row


def contender_row(result: Result, k: int) -> ContenderRow:
    """Return a contender's row."""
    entrant, study = result.prepared[k], result.prepared[k].contender.study
    tuned = entrant.contender.tuned
    return ContenderRow(
        name=entrant.contender.name,
        slug=entrant.contender.slug,
        **flown_under(study.system, study.flown),
        tuned=tuned,
        feasible=entrant.feasible,
        folder=entrant.folder,
        point=entrant.entry.point,
        pick=ContenderPick(rule=study.pick if tuned else None, why=entrant.why),
        budget=search_budget(study) if tuned else None,
        gains={
            gain.address: GainValue(value=float(entrant.entry.row[gain.column]), unit=gain.unit)
            for gain in study.system.gains
        },
        searched=[variable.name for variable in study.space.variables],
        cost=result.costs[k],
        on_bounds=result.bounds[k],
        failures=float(result.flown.failed[k].mean(axis=0)),
    )


class FlownThing(TypedDict, total=False):
    """Keys of a contender that say what flew.

    laws, airframe: of a quadrotor; channels, plant: of anything else.
    """

    laws: LawNames
    airframe: str
    plant: str
    channels: dict[str, str]


def flown_under(system: FlownSystem, name: str) -> FlownThing:
    """Return laws and airframe or plant as keys of a contender."""
    laws = {loop: law.name for loop, law in system.laws.items()}
    return {"laws": LawNames(**laws), "airframe": name} if system.has_shared_laws else {"plant": name, "channels": laws}


def search_budget(study: TuningStudy) -> SearchBudget:
    """Return the size of a contender's search."""
    candidates = study.search.population * study.search.generations
    return SearchBudget(
        population=study.search.population,
        generations=study.search.generations,
        flights=candidates * sum(entry.search for entry in study.scenarios),
    )


def quantity_row(quantity: Quantity) -> QuantityRow:
    """Return a quantity's row."""
    objective = quantity.objective
    return QuantityRow(
        label=quantity.label,
        metric=objective.metric.text,
        unit=objective.metric.unit,
        risk=objective.risk.name,
        level=objective.risk.level,
        scenario=objective.scenario,
        definition=objective.metric.metric.definition,
        risk_definition=RISKS[objective.risk.name].definition,
        kind=quantity.kind,
        limit=quantity.limit,
    )


def difference_row(result: Result, entry: Difference) -> DifferenceRow:
    """Return the paired difference of two contenders in one quantity."""
    winner = entry.winner
    return DifferenceRow(
        first=result.names[entry.first],
        second=result.names[entry.second],
        quantity=result.study.quantities[entry.quantity].label,
        difference=entry.estimate.value,
        low=entry.estimate.low,
        high=entry.estimate.high,
        verdict=entry.word if winner is None else f"{result.names[winner]} is lower",
        lower=None if winner is None else result.names[winner],
    )


def fronts_part(result: Result) -> FrontsPart | None:
    """Return box and sizes of the fronts, None where nothing was tuned."""
    volumes = result.volumes
    if volumes is None:
        return None
    labels = [objective.label for objective in result.study.base.objectives]
    return FrontsPart(
        objectives=labels,
        ideal=dict(zip(labels, volumes.ideal.tolist(), strict=True)),
        reference=dict(zip(labels, volumes.reference.tolist(), strict=True)),
        meaning=BOX,
        sizes=[
            FrontSize(contender=name, points=len(front.points), broken=front.broken)
            for name, front in zip(result.names, result.fronts, strict=True)
        ],
        hypervolume=[
            VolumeRow(contender=name, **entry.content())
            for name, entry in zip(result.names, volumes.volumes, strict=True)
        ],
        differences=[volume_difference(result.names, volumes, *entry) for entry in volumes.differences],
    )


def volume_difference(
    names: Sequence[str], volumes: Volumes, first: int, second: int, gap: SampledValue
) -> VolumeDifference:
    """Return the share of the second front minus that of the first."""
    larger = volumes.larger(first, second, gap)
    return VolumeDifference(
        first=names[first],
        second=names[second],
        difference=gap.value,
        low=gap.low,
        high=gap.high,
        larger=None if larger is None else names[larger],
    )


def best_row(result: Result, best: Best) -> BestUnder:
    """Return every front's best point under a limit; None where there is none."""
    labels = [objective.label for objective in result.study.base.objectives]
    rows = []
    for name, front, row in zip(result.names, result.fronts, best.rows, strict=True):
        if row is None:
            rows.append(BestRow(contender=name, value=None, low=None, high=None, point=None))
            continue
        value, low, high = (float(part[row, best.objective]) for part in (front.values, front.low, front.high))
        rows.append(BestRow(contender=name, value=value, low=low, high=high, point=front.points[row]))
    return BestUnder(objective=labels[best.objective], subject_to=labels[best.subject_to], limit=best.limit, rows=rows)
