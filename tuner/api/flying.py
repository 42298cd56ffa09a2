"""Fly given gains through turbulence."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.metrics import METRICS, parse
from objectives.problem import FlightBatch, Objective, Problem, System
from objectives.risk import Risk
from plant.errors import InputError
from plant.scenarios import HELD_OUT, ScenarioSpec, sample_scenarios
from tuner.analysis.responses import LIMITS, SCENARIO, Responses, fan_table, fly_responses, system_of
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import GainsLike, as_gains
from tuner.api.studies import StudyLike, tuning_study
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation
from tuner.store.document import DocumentPart

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

SHOWN_GROUPS = ("position", "attitude")
FAN_FLIGHTS = 64


@dataclass(frozen=True)
class Sortie:
    """A system, its gains row, a scenario and the root seed of the draws."""

    system: System
    gains: np.ndarray
    spec: ScenarioSpec
    root: int


class MetricRow(DocumentPart):
    """Statistics of a metric over flights: mean with its 95 % interval (normal), median, 95 % quantile, worst."""

    metric: str
    unit: str
    mean: float
    low: float
    high: float
    median: float
    q95: float
    worst: float


class FlightsDocument(DocumentPart):
    """Flights of one controller, as `tuner fly --json` prints them."""

    scenario: str
    flights: int
    metrics: list[MetricRow]


@dataclass(frozen=True)
class Flights(Documented):
    """Flights of one controller.

    Attributes:
        document: Scenario, number of flights, and statistics of each metric in SI units.
        sortie: The system, gains, scenario and seed that were flown.

    """

    document: FlightsDocument
    sortie: Sortie
    problem: Problem

    @property
    def scenario(self) -> str:
        """Name of the scenario."""
        return self.document.scenario

    @property
    def count(self) -> int:
        """Number of flights."""
        return self.document.flights

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each metric: mean with its 95 % interval, median, 95 % quantile, worst."""
        return frame(self.document.metrics, "metric")

    @cached_property
    def recorded(self) -> Responses:
        """The same flights with a recorder on, 64 of them at most."""
        return responses_of(self.problem, self.sortie, min(self.count, FAN_FLIGHTS))

    @cached_property
    def responses(self) -> "pd.DataFrame":
        """Responses by signal and time [s]: reference, 5 %, 50 % and 95 % over flights."""
        return fan_table(self.recorded, "gains", self.scenario)

    def figure(self) -> "Figure":
        """Draw the responses.

        Returns:
            The figure, made without pyplot.

        Examples:
            >>> tuner.fly(gains, flights=4).figure().savefig("responses.png")

        """
        return figures("flights", self.recorded, self.scenario).draw("responses")

    def write_figure(self, path: str | Path) -> None:
        """Draw the responses into a file.

        Args:
            path: The file; its ending, .png, .pdf or .svg, says the format.

        Returns:
            Nothing.

        Raises:
            InputError: The ending is none of these, or the file cannot be written.

        Examples:
            >>> tuner.fly(gains, flights=4).write_figure("responses.pdf")
        """
        from tuner.report.figures import write_responses

        write_responses(self.recorded, self.scenario, Path(path))

    def _repr_html_(self) -> str:
        return shown(f"{self.count} flights: {self.scenario}", (), self.table)


def fly(
    gains: GainsLike,
    *,
    study: StudyLike | None = None,
    scenario: int = 0,
    flights: int = 64,
    seed: int = 1,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> Flights:
    """Fly gains through turbulence.

    Args:
        gains: Gains, or a gains.json.
        study: Study whose scenario, limits and seed are flown; by default one metre steps in a fresh breeze.
        scenario: Which scenario of the study, from 0.
        flights: Number of flights, each in its own turbulence.
        seed: Root seed where no study gives one.
        watcher: Callbacks that hear of compilation.
        threads: Threads, by default one for each core.

    Returns:
        The flights: metrics, responses, a figure.

    Raises:
        InputError: The gains or the study are wrong, or there is no such scenario.

    Examples:
        >>> flown = tuner.fly(gains, flights=4)
        >>> float(flown.table.loc["failure", "mean"])
        0.0

    """
    sortie = prepare(as_gains(gains).controller, study, scenario, seed)
    problem = problem_of(sortie, threads)
    if not problem.flyer.cached:
        with compilation(watcher or Watcher()):
            problem.warm_up(sortie.gains, sortie.spec)
    evaluation = problem.evaluate_gains(sortie.gains[None], (FlightBatch(sortie.spec, HELD_OUT, flights),))
    metrics = statistics(problem.objectives, evaluation.scores[0])
    return Flights(FlightsDocument(scenario=sortie.spec.name, flights=flights, metrics=metrics), sortie, problem)


def prepare(controller: Controller, study: StudyLike | None, scenario: int, seed: int) -> Sortie:
    """Return what to fly: the study's scenario and limits where a study is given, the usual ones else."""
    row = np.array(controller.gains)
    if study is None:
        return Sortie(system_of(controller, LIMITS), row, SCENARIO, seed)
    asked = tuning_study(study, "tuner fly --study")
    if scenario >= len(asked.scenarios):
        raise InputError(
            f"given scenario {scenario}; allowed: 0 to {len(asked.scenarios) - 1}", file=asked.path, key="--scenario"
        )
    return Sortie(system_of(controller, asked.system.limits), row, asked.scenarios[scenario].spec, asked.seed)


def problem_of(sortie: Sortie, threads: int | None) -> Problem:
    """Return the problem that has every metric of a sortie as an objective."""
    return Problem(
        sortie.system, DecisionSpace((), (), tuple(sortie.gains.tolist())),
        tuple(Objective(parse(address), Risk("mean")) for address in shown_addresses(sortie)), (), sortie.root, threads,
    )  # fmt: skip


def shown_addresses(sortie: Sortie) -> list[str]:
    """Return the metrics that a flight of this scenario can be judged by, position and attitude."""
    track = sortie.spec.track(sortie.system.timing)
    steps = track.start != track.final
    stepping = {"position": steps[:3].any(), "attitude": steps[3:].any()}
    addresses = []
    for metric in METRICS.values():
        if metric.scope == "flight":
            addresses.append(metric.name)
        else:
            addresses += [f"{metric.name}.{g}" for g in SHOWN_GROUPS if stepping[g] or not metric.needs_step]
    return addresses


def statistics(objectives: tuple[Objective, ...], scores: np.ndarray) -> list[MetricRow]:
    """Return the statistics of each metric; scores (metrics, flights)."""
    n = scores.shape[1]
    rows = []
    for objective, values in zip(objectives, scores, strict=True):
        half = 1.96 * float(values.std(ddof=1)) / n**0.5 if n > 1 else 0.0
        mean = float(values.mean())
        rows.append(
            MetricRow(
                metric=objective.metric.text, unit=objective.metric.unit, mean=mean, low=mean - half, high=mean + half,
                median=float(np.median(values)), q95=float(np.quantile(values, 0.95)), worst=float(values.max()),
            )
        )  # fmt: skip
    return rows


def responses_of(problem: Problem, sortie: Sortie, count: int) -> Responses:
    """Fly again with a recorder on."""
    system = sortie.system
    inputs = sample_scenarios(sortie.spec, system.vehicle, system.timing, sortie.root, HELD_OUT, range(count))
    return fly_responses(problem.flyer, sortie.gains, system.nominal, inputs, system.timing.control_period)
