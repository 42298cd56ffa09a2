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
from plant.scenarios import ScenarioSpec
from plant.seeds import generator
from tuner.analysis.margins.document import requirements_in
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
from tuner.exchange.autopilot.gyro_filter import filter_rows
from tuner.exchange.target import Bundle, GyroFilter, Request
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation

STREAM, SEED = "export", 1
FAILURE = "failure"
FLIGHTS = 64
METRICS = ("itae.position", "itae.attitude", "rms.position", "travel", "saturation", FAILURE)
REPLICATES = 400


@dataclass(frozen=True)
class Verification:
    """Rows for gains, margins and flights; broken: labels of limits that hold before rounding and not after it; filter: of
    `filter_rows`, which rounding does not hold; scenario: name of what was flown; lost: flights lost before and after rounding.
    """

    gains: list[RoundedGain]
    margins: list[RoundedMargin]
    metrics: list[RoundedMetric]
    broken: list[str]
    flights: int
    scenario: str
    lost: tuple[int, int]
    gyro: GyroFilter | None = None
    filter: tuple[FilteredLoop, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether the target keeps what the gains keep, and no flight is lost."""
        return not self.broken and self.lost == (0, 0)

    def document(self) -> VerificationPart:
        """Return everything as a part of export.json."""
        gyro = None if self.gyro is None else GyroFilterPart(**asdict(self.gyro), rows=list(self.filter))
        return VerificationPart(
            passed=self.passed, broken=self.broken, scenario=self.scenario, stream=STREAM, seed=SEED, flights=self.flights,
            lost_asked=self.lost[0], lost_held=self.lost[1],
            gains=self.gains, margins=self.margins, metrics=self.metrics, gyro_filter=gyro,
        )  # fmt: skip


def verify_export(request: Request, bundle: Bundle, flights: int, watcher: Watcher) -> Verification:
    """Work out margins and flights of the controller as tuned and as the target holds it; the watcher hears of both."""
    asked, held = request.controller, bundle.held
    check_same_structure(asked, held)
    same = asked.gains == held.gains and asked.airframe.vehicle == held.airframe.vehicle
    margins = margin_rows(asked, asked if same else held)
    flown = fly_both(asked, asked if same else held, flights, watcher)
    broken = [row.label for row in margins if row.kept_asked and not row.kept_held]
    broken += [FAILURE] if flown.lost[1] > flown.lost[0] else []
    lag = () if bundle.gyro is None else tuple(filter_rows(held, bundle.gyro))
    return Verification(
        gain_rows(asked, held), margins, flown.rows, broken, flights, flown.scenario, flown.lost, bundle.gyro, lag
    )


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
    """Return the usual limits on every loop's margins before and after rounding; none where nothing can hover.

    They are judged at hover and in the steady states that the gains are for.
    """
    before = _requirements(asked)
    after = before if held is asked else _requirements(held)
    return [_rounded(one, other) for one, other in zip(before, after, strict=True) if one.hard]


def _rounded(before: LimitRow, after: LimitRow) -> RoundedMargin:
    same = {"label", "quantity", "unit", "shown_unit", "limit", "sense"}
    row = RoundedMargin(
        **before.model_dump(include=same, exclude_unset=True),
        asked=before.value, held=after.value, kept_asked=before.kept, kept_held=after.kept,
    )  # fmt: skip
    return row if after.state is None else row.model_copy(update={"state": after.state})


def _requirements(controller: Controller) -> list[LimitRow]:
    try:
        return requirements_in(controller, Trim())
    except InputError:
        return []


@dataclass(frozen=True)
class FlownPair:
    """Mean metrics of the same flights before and after rounding; scenario: its name; lost: flights lost before and after."""

    rows: list[RoundedMetric]
    scenario: str
    lost: tuple[int, int]


def fly_both(asked: Controller, held: Controller, flights: int, watcher: Watcher) -> FlownPair:
    """Fly both in the same air; metrics are means over the flights that neither loses, none where every flight is lost."""
    first, second = _problem(asked), _problem(held)
    spec = usual_scenario(first.system)
    if not first.flyer.cached:
        with compilation(watcher):
            first.warm_up(np.array(asked.gains), spec)
    watcher.on_stage("Flying before and after rounding", flights * (1 if held is asked else 2))
    before = _fly(first, asked, spec, flights, watcher)
    after = before if held is asked else _fly(second, held, spec, flights, watcher)
    lost = [scores[METRICS.index(FAILURE)] > 0.0 for scores in (before, after)]
    completed = ~(lost[0] | lost[1])
    rows = []
    for i, name in enumerate(METRICS):
        among = np.ones(flights, dtype=bool) if name == FAILURE else completed
        rows.append(_row(i, first.objectives[i], before[i, among], after[i, among], held is not asked))
    return FlownPair(rows, spec.name, (int(lost[0].sum()), int(lost[1].sum())))


def _row(i: int, metric: Objective, before: np.ndarray, after: np.ndarray, rounded: bool) -> RoundedMetric:
    name = METRICS[i]
    if len(before) == 0:
        return RoundedMetric(
            metric=name, unit=parse(name).unit, asked=None, held=None, difference=None, low=None, high=None
        )
    low, high = 0.0, 0.0
    if rounded:
        low, high = _interval(metric, after, before, generator(SEED, "bootstrap/export", i))
    return RoundedMetric(
        metric=name, unit=parse(name).unit, asked=float(before.mean(axis=0)), held=float(after.mean(axis=0)),
        difference=float((after - before).mean(axis=0)), low=low, high=high,
    )  # fmt: skip


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


def _fly(problem: Problem, controller: Controller, spec: ScenarioSpec, flights: int, watcher: Watcher) -> np.ndarray:
    """Return the metrics (metrics, flights) of a controller on the export's flights."""
    batches = (FlightBatch(spec, STREAM, flights),)
    return problem.evaluate_gains(np.array([controller.gains]), batches, watcher.on_flights_done).scores[0]
