"""summary.json of a run: what was found, in numbers that a person or a program can read."""

from typing import Any

import numpy as np

from objectives.problem import Objective
from objectives.scales import in_file, units_of
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from tuner.analysis.lost_flights import named_losses, unseen_losses
from tuner.documents.obstacles import ConflictPart, ConstraintPrice, RelaxationRow, RelaxedLimit
from tuner.documents.parts import Estimate, LostFlight
from tuner.documents.summary import (
    AirRow,
    Pick,
    PickedObjective,
    SearchSeconds,
    SelectionValues,
    SkippedFlights,
    Summary,
    VariableRow,
)
from tuner.experiments.tuning.bounds import ENDS
from tuner.experiments.tuning.conclusion import default_candidate, remarks
from tuner.experiments.tuning.conflicts import Conflict, Limit, LimitPrice, Relaxation, limits_of
from tuner.experiments.tuning.ending import ending_of
from tuner.experiments.tuning.named_points import named_points
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.uncertainty import uncertainty_costs
from tuner.search.acquisition import FURTHER_WEIGHT
from tuner.search.automatic import MODEL
from tuner.search.loop import point_name
from tuner.search.objective_models import reference_point
from tuner.text.numbers import significant
from tuner.text.sentences import listing
from tuner.text.units import after_number, in_degrees


def summary_document(outcome: Outcome) -> Summary:
    """Return the content of summary.json."""
    study, finalists, last = outcome.study, outcome.finalists, outcome.generations[-1]
    shown, feasible = outcome.names[outcome.tuned], outcome.feasible
    limits = limits_of(study.constraints, study.requirements)
    uncertain: dict[str, Any] = {"uncertainty": rows} if (rows := uncertainty_costs(outcome)) else {}
    return Summary(
        feasible=feasible,
        ending=ending_of(outcome),
        title=study.title,
        study=study.path.name,
        tuned=shown if feasible else None,
        nearest=None if feasible else shown,
        pick=Pick(rule=study.pick, why=outcome.why),
        search=search_text(outcome),
        flights=outcome.flights,
        screened=SkippedFlights(candidates=last.screened, flights=last.flights_saved),
        raced=SkippedFlights(candidates=last.raced, flights=last.flights_raced),
        settled=SkippedFlights(
            candidates=int(np.sum(~finalists.flown.complete, axis=0)), flights=finalists.evaluation.flights_raced
        ),
        wall_seconds=outcome.seconds,
        search_seconds=SearchSeconds(
            screening=sum(entry.evaluation.screening_seconds for entry in outcome.generations),
            flights=sum(entry.evaluation.flight_seconds for entry in outcome.generations),
        ),
        held_out=sum(entry.held_out for entry in study.scenarios),
        front_size=int(finalists.non_dominated.sum()),
        hypervolume=last.hypervolume,
        picked_on=picked_on(outcome),
        points=named_points(outcome),
        conflict=conflict_part(outcome.conflict, limits, default_candidate(outcome.archive, study)),
        obstacles=outcome.obstacles,
        costs=[cost_row(cost, limits, study.objectives) for cost in outcome.costs],
        remarks=remarks(outcome),
        warnings=outcome.warnings,
        variables=variable_rows(outcome),
        table=[*outcome.table, *outcome.required_rows],
        air=[AirRow.model_validate(row) for row in study.air],
        plant_step=outcome.plant_step,
        **uncertain,
        unseen=unseen_losses(outcome.problem, batches(study, CONFIRMATION), outcome.confirmation, 1),
        lost_flights=lost_flights(outcome),
    )


def lost_flights(outcome: Outcome) -> list[LostFlight]:
    """Return the lost flights of default and shown point; held out and confirmation."""
    study, confirmed = outcome.study, outcome.confirmation.failed
    lost = list[LostFlight]()
    for row, place in ((0, 0), (outcome.tuned, 1)):
        gains, point = outcome.gains(row), outcome.names[row]
        flown = [
            (HELD_OUT, outcome.finalists.flown.failed[row]),
            *([] if confirmed is None else [(CONFIRMATION, confirmed[place])]),
        ]
        for stream, failed in flown:
            lost += named_losses(outcome.problem, gains, batches(study, stream), failed, point)
    return lost


def search_text(outcome: Outcome) -> str:
    """Return a search's algorithm and reason; of a search in stages, its number of survivors too."""
    search, survivors = outcome.study.search, outcome.survivors
    text = " ".join([search.text, *outcome.study.start_texts, *reference_texts(outcome)])
    if search.first is None:
        return text
    tried, flights = len(outcome.archive.points), survivors.evaluation.scores.shape[-1]
    return f"{text} Of {tried:,} candidates {len(survivors.candidates)} survived and made all {flights} flights."


def reference_texts(outcome: Outcome) -> list[str]:
    """Return a sentence on the reference point; none where the search has none."""
    study, tried = outcome.study, outcome.archive
    front = tried.front()
    if study.search.algorithm != MODEL or len(study.objectives) < 2 or not len(front):
        return []
    given = study.search.reference_point(study.objectives)
    point = reference_point(tried.values, tried.flown, front, given)
    beyond = f", beyond that with a weight of {FURTHER_WEIGHT:g}" if np.isnan(given).any() else ""
    values = [
        f"{entry.label} {significant(value * shown.factor, 3)}{after_number(shown.unit)}"
        for entry, value in zip(study.objectives, point.tolist(), strict=True)
        for shown in [in_degrees(entry.metric.unit)]
    ]
    return [f"The front counts in full up to {listing(values)}{beyond}."]


def picked_on(outcome: Outcome) -> SelectionValues:
    """Return the selection values of the recommended point: held-out values and the probability to be on the front."""
    finalists, row = outcome.finalists, outcome.tuned
    return SelectionValues(
        probability=float(finalists.probability[row]),
        lost_in_search=lost_in_search(outcome),
        objectives=[
            PickedObjective(
                label=objective.label,
                unit=objective.metric.unit,
                search=float(finalists.search[row, i]),
                held_out=_estimate(finalists.evaluation.values, finalists.low, finalists.high, row, i),
                gap=_estimate(finalists.gap, finalists.gap_low, finalists.gap_high, row, i),
            )
            for i, objective in enumerate(outcome.study.objectives)
        ],
    )


def lost_in_search(outcome: Outcome) -> float | None:
    """Return the recommended point's share of flights lost in the search; None where it was not flown there."""
    failures = np.concatenate([entry.evaluation.failures for entry in outcome.generations])
    candidate = outcome.candidates[outcome.tuned - 1] if outcome.tuned else 0
    return float(failures[candidate]) if outcome.archive.flown[candidate] else None


def _estimate(value: np.ndarray, low: np.ndarray, high: np.ndarray, row: int, column: int) -> Estimate:
    return Estimate(*[float(part[row, column]) for part in (value, low, high)])


def conflict_part(conflict: Conflict | None, limits: list[Limit], default: int | None) -> ConflictPart | None:
    """Return the limits in conflict and their remedies; None where something was feasible.

    default: the candidate that is the default, None where the search did not try it.
    """
    if conflict is None:
        return None
    return ConflictPart(
        sets=[[limits[i].label for i in some] for some in conflict.sets],
        single=[relaxation_row(entry, limits, default) for entry in conflict.single],
        common=None if conflict.common is None else relaxation_row(conflict.common, limits, default),
    )


def relaxation_row(relaxation: Relaxation, limits: list[Limit], default: int | None) -> RelaxationRow:
    """Return the limits that would let a candidate in."""
    return RelaxationRow(
        candidate=point_name(relaxation.candidate),
        default=relaxation.candidate == default,
        share=relaxation.share,
        limits=[
            RelaxedLimit(
                label=limits[i].label,
                **units_of(limits[i].unit, limits[i].scale),
                sense=limits[i].sense,
                limit=in_file(limits[i].limit, limits[i].scale),
                relaxed=in_file(value, limits[i].scale),
            )
            for i, value in relaxation.changes
        ],
    )


def cost_row(cost: LimitPrice, limits: list[Limit], objectives: tuple[Objective, ...]) -> ConstraintPrice:
    """Return the best value of an objective with and without a limit."""
    objective = objectives[cost.objective]
    ends = {"with": cost.with_limit, "without": cost.without}
    return ConstraintPrice(
        limit=limits[cost.limit].label, objective=objective.label, unit=objective.metric.unit, **ends
    )


def variable_rows(outcome: Outcome) -> list[VariableRow]:
    """Return every decision variable with unit, range, default and tuned value."""
    study = outcome.study
    default, tuned = outcome.gains(0), outcome.gains(outcome.tuned)
    return [
        VariableRow(
            name=variable.name,
            **words._asdict(),
            low=variable.low,
            high=variable.high,
            scale=variable.scale,
            natural_ends=[end for end in ENDS if study.is_natural_end(i, getattr(variable, end))],
            default=float(default[columns[0]]),
            tuned=float(tuned[columns[0]]),
        )
        for i, (variable, columns, words) in enumerate(
            zip(study.space.variables, study.space.columns, study.variable_words, strict=True)
        )
    ]
