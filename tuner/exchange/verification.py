"""Verification of an export: gains, margins and flights of a controller before and after rounding to a target's resolution.

Both fly the usual flight (`tuner.analysis.responses`) through the same turbulence, on a stream that no search
and no check has seen.
"""

from dataclasses import asdict, dataclass

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.trim import Trim
from objectives.metrics import parse
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.errors import InputError
from plant.gains import gain_addresses
from plant.seeds import generator
from plant.vectors import Vec3
from tuner.analysis.margins.document import default_requirements
from tuner.analysis.margins.readings import subject_of
from tuner.analysis.responses import SCENARIO, system_of
from tuner.documents.export import (
    FilteredLoop,
    GyroFilterPart,
    RoundedGain,
    RoundedMargin,
    RoundedMetric,
    VerificationPart,
)
from tuner.documents.margins import LimitRow
from tuner.exchange.autopilot.gyro_filter import filter_rows
from tuner.exchange.target import Bundle, GyroFilter, Request
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation

STREAM, SEED = "export", 1
FLIGHTS = 64
METRICS = ("itae.position", "itae.attitude", "rms.position", "travel", "saturation", "failure")
REPLICATES = 400


@dataclass(frozen=True)
class Verification:
    """Rows for gains, margins and flights; broken: labels of limits that hold before rounding and not after it; filter: of
    `filter_rows`, which rounding does not hold.
    """

    gains: list[RoundedGain]
    margins: list[RoundedMargin]
    metrics: list[RoundedMetric]
    broken: list[str]
    flights: int
    gyro: GyroFilter | None = None
    filter: tuple[FilteredLoop, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether the target keeps what the gains keep."""
        return not self.broken

    def document(self) -> VerificationPart:
        """Return everything as a part of export.json."""
        gyro = None if self.gyro is None else GyroFilterPart(**asdict(self.gyro), rows=list(self.filter))
        return VerificationPart(
            passed=self.passed, broken=self.broken, scenario=SCENARIO.name, stream=STREAM, seed=SEED, flights=self.flights,
            gains=self.gains, margins=self.margins, metrics=self.metrics, gyro_filter=gyro,
        )  # fmt: skip


def verify_export(request: Request, bundle: Bundle, flights: int, watcher: Watcher) -> Verification:
    """Work out margins and flights of the controller as tuned and as the target holds it; the watcher hears of both."""
    asked, held = request.controller, bundle.held
    check_same_structure(asked, held)
    same = asked.gains == held.gains and asked.airframe.vehicle == held.airframe.vehicle
    margins = margin_rows(asked, asked if same else held)
    metrics = metric_rows(asked, asked if same else held, flights, watcher)
    broken = [row.label for row in margins if row.kept_asked and not row.kept_held]
    broken += [row.metric for row in metrics if row.metric == "failure" and row.held > row.asked]
    lag = () if bundle.gyro is None else tuple(filter_rows(held, bundle.gyro))
    return Verification(gain_rows(asked, held), margins, metrics, broken, flights, bundle.gyro, lag)


def check_same_structure(asked: Controller, held: Controller) -> None:
    """An exporter gives back the laws that it was given."""
    mine = (asked.cascade.position.name, asked.cascade.attitude.name)
    its = (held.cascade.position.name, held.cascade.attitude.name)
    assert mine == its, f"an exporter turned {mine} into {its}"


def gain_rows(asked: Controller, held: Controller) -> list[RoundedGain]:
    """Return every gain before and after rounding."""
    return [
        RoundedGain(
            gain=gain.address, unit=gain.unit, asked=asked.gains[gain.column], held=held.gains[gain.column],
            relative=_relative(asked.gains[gain.column], held.gains[gain.column]),
        )
        for gain in gain_addresses(asked.cascade)
    ]  # fmt: skip


def _relative(asked: float, held: float) -> float:
    """Return the change relative to the tuned gain, or to 1 where that is 0."""
    return (held - asked) / (abs(asked) or 1.0)


def margin_rows(asked: Controller, held: Controller) -> list[RoundedMargin]:
    """Return the usual limits on every loop's margins at hover, before and after rounding; none where nothing can hover."""
    before = _requirements(asked)
    after = before if held is asked else _requirements(held)
    return [
        RoundedMargin(
            **one.model_dump(include={"label", "quantity", "unit", "shown_unit", "limit", "sense"}, exclude_unset=True),
            asked=one.value, held=other.value, kept_asked=one.kept, kept_held=other.kept,
        )
        for one, other in zip(before, after, strict=True) if one.hard
    ]  # fmt: skip


def _requirements(controller: Controller) -> list[LimitRow]:
    still = Vec3(0.0, 0.0, 0.0)
    try:
        return default_requirements(subject_of(controller, Trim(0.0, still, still, True)))
    except InputError:
        return []


def metric_rows(asked: Controller, held: Controller, flights: int, watcher: Watcher) -> list[RoundedMetric]:
    """Return mean metrics over the same flights before and after rounding, with the difference flight by flight and its 95 %
    interval.
    """
    first, second = _problem(asked), _problem(held)
    if not first.flyer.cached:
        with compilation(watcher):
            first.warm_up(np.array(asked.gains), SCENARIO)
    watcher.on_stage("Flying before and after rounding", flights * (1 if held is asked else 2))
    before = _fly(first, asked, flights, watcher)
    after = before if held is asked else _fly(second, held, flights, watcher)
    rows = []
    for i, name in enumerate(METRICS):
        low, high = 0.0, 0.0
        if held is not asked:
            drawn = generator(SEED, "bootstrap/export", i)
            low, high = _interval(first.objectives[i], after[i], before[i], drawn)
        row = RoundedMetric(
            metric=name, unit=parse(name).unit, asked=float(before[i].mean(axis=0)), held=float(after[i].mean(axis=0)),
            difference=float((after[i] - before[i]).mean(axis=0)), low=low, high=high,
        )  # fmt: skip
        rows.append(row)
    return rows


def _interval(
    metric: Objective, after: np.ndarray, before: np.ndarray, draw: np.random.Generator
) -> tuple[float, float]:
    resample = draw.integers(len(after), size=(REPLICATES, len(after)), dtype=np.intp)
    _, low, high = metric.difference(after, before, resample)
    return float(low), float(high)


def _problem(controller: Controller) -> Problem:
    system = system_of(controller)
    objectives = tuple(Objective(parse(name), Risk("mean")) for name in METRICS)
    return Problem(system, DecisionSpace((), (), controller.gains), objectives, (), SEED, None)


def _fly(problem: Problem, controller: Controller, flights: int, watcher: Watcher) -> np.ndarray:
    """Return the metrics (metrics, flights) of a controller on the export's flights."""
    batches = (FlightBatch(SCENARIO, STREAM, flights),)
    return problem.evaluate_gains(np.array([controller.gains]), batches, watcher.on_flights_done).scores[0]
