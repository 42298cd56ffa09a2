"""Verification of an export: gains, margins and flights of a controller before and after rounding to a target's resolution.

Quadrotors fly the usual flight (`tuner.analysis.responses`) through the same turbulence, plants the first scenario of their
study, on a stream that no search and no check has seen.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.trim import Trim
from objectives.metrics import parse
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.errors import InputError
from plant.seeds import generator
from tuner.analysis.judged_metrics import is_judged
from tuner.analysis.margins.document import default_requirements, requirements_in
from tuner.analysis.margins.readings import plant_subject, subject_of
from tuner.analysis.responses import system_of, usual_scenario
from tuner.documents.export import (
    FilteredLoop,
    GyroFilterPart,
    RoundedGain,
    RoundedMargin,
    RoundedMetric,
    VerificationPart,
)
from tuner.documents.margins import LimitRow
from tuner.exchange.target import GyroFilter
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation
from tuner.study.plant_controller import PlantController

STREAM, SEED = "export", 1
FAILURE = "failure"
FLIGHTS = 64
METRICS = ("itae.position", "itae.attitude", "rms.position", "travel", "saturation", FAILURE)
REPLICATES = 400


@dataclass(frozen=True)
class Loops:
    """A controller under verification.

    Attributes:
        system: System that flies it.
        row: Its gains (g,).
        spec: Scenario that it flies.
        metrics: Addresses of the metrics compared, failure among them.
        limits: Return how its loops stand to limits on their margins, none where nothing rests.
        structure: Limits that no target may change.
        content: With the gains, all that rounding may change.
        filtered: Return the loops under a target's low-pass of the gyro.
    """

    system: Any
    row: tuple[float, ...]
    spec: Any
    metrics: tuple[str, ...]
    limits: Callable[[], list[LimitRow]]
    structure: tuple[str, ...]
    content: object = None
    filtered: Callable[[GyroFilter], list[FilteredLoop]] = lambda _: []


def quadrotor_loops(controller: Controller) -> Loops:
    """Return a quadrotor's loops in the usual flight, with usual margin limits."""
    system = system_of(controller)
    return Loops(
        system,
        controller.gains,
        usual_scenario(system),
        METRICS,
        lambda: requirements_in(subject_of(controller, Trim())),
        (controller.cascade.position.name, controller.cascade.attitude.name),
        controller.airframe.vehicle,
        lambda gyro: gyro.margins(controller, gyro.cutoff),
    )


def plant_loops(controller: PlantController) -> Loops:
    """Return a plant's loops in its study's first scenario; with its objectives and the usual limits."""
    study = controller.study
    spec = study.scenarios[0].spec
    metrics = [metric.text for metric in study.judged_metrics if is_judged(study.system, metric, spec)]
    return Loops(
        study.system,
        controller.gains,
        spec,
        tuple(dict.fromkeys((*metrics, FAILURE))),
        lambda: default_requirements(plant_subject(study.system, np.array(controller.gains))),
        study.system.plan.names,
    )


def verify_export(
    tuned: Loops, held: Loops, flights: int, watcher: Watcher, gyro: GyroFilter | None = None
) -> VerificationPart:
    """Compare margins and flights of a controller before and after rounding; gyro: the target's low-pass, or None."""
    assert tuned.structure == held.structure, f"an exporter turned {tuned.structure} into {held.structure}"
    after = tuned if (tuned.row, tuned.content) == (held.row, held.content) else held
    margins = margin_rows(tuned, after)
    metrics, lost = fly_both(tuned, after, flights, watcher)
    broken = [row.label for row in margins if row.kept_asked and not row.kept_held]
    broken += [FAILURE] if lost[1] > lost[0] else []
    lag = None
    if gyro is not None:
        lag = GyroFilterPart(name=gyro.name, cutoff=gyro.cutoff, known=gyro.is_from_vehicle, rows=held.filtered(gyro))
    return VerificationPart(
        passed=not broken and lost == (0, 0),
        broken=broken,
        scenario=tuned.spec.name,
        stream=STREAM,
        seed=SEED,
        flights=flights,
        lost_asked=lost[0],
        lost_held=lost[1],
        gains=gain_rows(tuned, held),
        margins=margins,
        metrics=metrics,
        gyro_filter=lag,
    )


def gain_rows(tuned: Loops, held: Loops) -> list[RoundedGain]:
    """Return every gain before and after rounding."""
    pairs = [(gain, tuned.row[gain.column], held.row[gain.column]) for gain in tuned.system.gains]
    return [
        RoundedGain(gain=gain.address, unit=gain.unit, asked=before, held=after, relative=_relative(before, after))
        for gain, before, after in pairs
    ]


def _relative(tuned: float, held: float) -> float:
    """Return the change relative to the tuned gain; to 1 where that is 0."""
    return (held - tuned) / (abs(tuned) or 1.0)


def margin_rows(tuned: Loops, held: Loops) -> list[RoundedMargin]:
    """Return the usual limits on every loop's margins before and after rounding; none where nothing can hover.

    They are judged at hover and in the steady states that the gains are for, those of a plant at rest.
    """
    before = _requirements(tuned)
    after = before if held is tuned else _requirements(held)
    return [_rounded(one, other) for one, other in zip(before, after, strict=True) if one.hard]


def _rounded(before: LimitRow, after: LimitRow) -> RoundedMargin:
    same = {"label", "quantity", "unit", "shown_unit", "limit", "sense"}
    row = RoundedMargin(
        **before.model_dump(include=same, exclude_unset=True),
        asked=before.value,
        held=after.value,
        kept_asked=before.is_satisfied,
        kept_held=after.is_satisfied,
    )
    return row if after.state is None else row.model_copy(update={"state": after.state})


def _requirements(loops: Loops) -> list[LimitRow]:
    try:
        return loops.limits()
    except InputError:
        return []


def fly_both(tuned: Loops, held: Loops, flights: int, watcher: Watcher) -> tuple[list[RoundedMetric], tuple[int, int]]:
    """Return mean metrics and numbers of lost flights before and after rounding.

    Both fly the same flights. Means are over the flights that neither loses, none where every flight is lost.
    """
    first, second = _problem(tuned), _problem(held)
    if not first.flyer.cached:
        with compilation(watcher):
            first.warm_up(np.array(tuned.row), tuned.spec)
    watcher.on_stage("Flying before and after rounding", flights * (1 if held is tuned else 2))
    before = _fly(first, tuned, flights, watcher)
    after = before if held is tuned else _fly(second, held, flights, watcher)
    lost = [scores[tuned.metrics.index(FAILURE)] > 0.0 for scores in (before, after)]
    completed = ~(lost[0] | lost[1])
    rows = []
    for i, metric in enumerate(first.objectives):
        among = np.ones(flights, dtype=bool) if metric.metric.text == FAILURE else completed
        rows.append(_row(i, metric, before[i, among], after[i, among], held is not tuned))
    return rows, (int(lost[0].sum()), int(lost[1].sum()))


def _row(i: int, metric: Objective, before: np.ndarray, after: np.ndarray, rounded: bool) -> RoundedMetric:
    name, unit = metric.metric.text, metric.metric.unit
    if len(before) == 0:
        return RoundedMetric(metric=name, unit=unit, asked=None, held=None, difference=None, low=None, high=None)
    low, high = 0.0, 0.0
    if rounded:
        low, high = _interval(metric, after, before, generator(SEED, "bootstrap/export", i))
    return RoundedMetric(
        metric=name,
        unit=unit,
        asked=float(before.mean(axis=0)),
        held=float(after.mean(axis=0)),
        difference=float((after - before).mean(axis=0)),
        low=low,
        high=high,
    )


def _interval(
    metric: Objective, after: np.ndarray, before: np.ndarray, draw: np.random.Generator
) -> tuple[float, float]:
    resample = draw.integers(len(after), size=(REPLICATES, len(after)), dtype=np.intp)
    _, low, high = metric.difference(after, before, resample)
    return float(low), float(high)


def _problem(loops: Loops) -> Problem:
    metrics = [parse(name, loops.system.axes) for name in loops.metrics]
    objectives = tuple(Objective(metric, Risk("mean")) for metric in metrics)
    return Problem(loops.system, DecisionSpace((), (), loops.row), objectives, (), SEED, None)


def _fly(problem: Problem, loops: Loops, flights: int, watcher: Watcher) -> np.ndarray:
    """Return the metrics (metrics, flights) of a controller on the export's flights."""
    batches = (FlightBatch(loops.spec, STREAM, flights),)
    return problem.evaluate_gains(np.array([loops.row]), batches, watcher.on_flights_done).scores[0]
