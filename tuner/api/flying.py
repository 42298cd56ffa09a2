"""Fly given gains through turbulence."""

from dataclasses import dataclass, replace
from functools import cached_property, singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.metrics import METRICS, MetricAddress, check, parse
from objectives.own_meters import metering
from objectives.plant_system import PlantSystem
from objectives.problem import FlightBatch, Objective, Problem, System
from objectives.risk import Risk, binary_interval
from plant.errors import InputError
from plant.model.scenario import PlantScenario
from plant.scenarios import CONFIRMATION, HELD_OUT, SEARCH, ScenarioSpec
from tuner.analysis.judging.judge import CHECK
from tuner.analysis.lost_flights import lost_among
from tuner.analysis.responses import LIMITS, Responses, fan_table, responses_of, system_of, usual_scenario
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import Gains, GainsLike, as_gains
from tuner.api.plant_margins import plant_study
from tuner.api.plants import study_of
from tuner.api.studies import StudyLike, tuning_study
from tuner.documents.parts import LostFlight, ShareCount
from tuner.gains import Controller
from tuner.gains.plant_document import is_plant_gains
from tuner.search.watcher import Watcher, compilation
from tuner.store.document import DocumentPart
from tuner.study.plant_study import check_bounds
from tuner.study.size import MOST_FLIGHTS
from tuner.study.study import TuningStudy
from tuner.study.tuned_loops import read_plant_row

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

SHOWN_GROUPS = ("position", "attitude")
FAN_FLIGHTS = 64
STREAMS = (HELD_OUT, CONFIRMATION, SEARCH, CHECK)


@dataclass(frozen=True)
class Sortie:
    """A system, its gains row, a scenario, the root seed of the draws, and the laws in words.

    draws: stream and numbers of the flights.
    """

    system: Any
    gains: np.ndarray
    spec: Any
    root: int
    laws: str
    draws: tuple[str, range] = (HELD_OUT, range(0))


class MetricRow(DocumentPart):
    """Statistics of a metric over flights: mean with its 95 % interval, median, 95 % quantile, worst.

    The interval is normal, within what the metric can be; of a quantity that is 0 or 1 it is exact, and `count` tells how often.
    """

    metric: str
    unit: str
    mean: float
    low: float
    high: float
    median: float
    q95: float
    worst: float
    count: ShareCount | None = None


class FlightsDocument(DocumentPart):
    """Flights of one controller, as `tuner fly --json` prints them; lost: those that ended before their time."""

    scenario: str
    flights: int
    metrics: list[MetricRow]
    lost: list[LostFlight] = []


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
        return recorded_flights(self.problem, self.sortie)

    @cached_property
    def responses(self) -> "pd.DataFrame":
        """Responses by signal and time [s]: reference, 5 %, 50 % and 95 % over flights."""
        import pandas as pd

        return pd.DataFrame(fan_table(self.recorded, "gains", self.scenario))

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
    flight: str | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> Flights:
    """Fly gains through turbulence, or those of a plant of your own through a scenario of its study.

    Args:
        gains: Gains, or a gains.json; of a plant of your own where its code has been named with `use`, or with its study.
        study: Study whose scenario, limits and seed are flown; by default one metre steps in a fresh breeze, or the study of the
            results folder where a plant's gains lie in one.
        scenario: Which scenario of the study, from 0.
        flights: Number of flights, each in its own turbulence.
        seed: Root seed where no study gives one.
        flight: Name of a single flight, STREAM-INDEX, such as those that `lost` names; it alone is flown.
        watcher: Callbacks that hear of compilation.
        threads: Threads, by default one for each core.

    Returns:
        The flights: metrics, responses, a figure.

    Raises:
        InputError: The gains or the study are wrong, or there is no such scenario or flight.

    Examples:
        >>> flown = tuner.fly(gains, flights=4)
        >>> float(flown.table.loc["failure", "mean"])
        0.0

    """
    if not isinstance(gains, Gains) and is_plant_gains(Path(gains)):
        sortie = plant_sortie(Path(gains), study, scenario)
    else:
        sortie = prepare(as_gains(gains).controller, study, scenario, seed)
    sortie = replace(sortie, draws=(HELD_OUT, range(flights)) if flight is None else named_draw(flight))
    problem = problem_of(sortie, threads)
    if not problem.flyer.cached:
        with compilation(watcher or Watcher()):
            problem.warm_up(sortie.gains, sortie.spec)
    scores, lost = flown_scores(problem, sortie)
    metrics, count = statistics(problem.objectives, scores), scores.shape[-1]
    document = FlightsDocument(scenario=sortie.spec.name, flights=count, metrics=metrics, lost=lost)
    return Flights(document, sortie, problem)


def named_draw(name: str) -> tuple[str, range]:
    """Return stream and number of a flight by its name; InputError where it is none."""
    stream, _, index = name.rpartition("-")
    if stream not in STREAMS or not (index.isascii() and index.isdigit()) or int(index) >= MOST_FLIGHTS:
        allowed = " or ".join(f"{known}-INDEX" for known in STREAMS)
        raise InputError(f"given '{name}'; write {allowed}, for instance {HELD_OUT}-12", key="--flight")
    return stream, range(int(index), int(index) + 1)


def flown_scores(problem: Problem, sortie: Sortie) -> tuple[np.ndarray, list[LostFlight]]:
    """Return the scores (metrics, flights) of a sortie and its lost flights."""
    (stream, indices), scores, lost = sortie.draws, [], list[LostFlight]()
    batch = FlightBatch(sortie.spec, stream, indices.stop, indices.start)
    for first, last in problem.chunks(batch):
        results = problem.results(sortie.gains[None], batch, first, last)
        scores.append(problem.score(results, sortie.spec)[0][0])
        lost += lost_among(results[0], sortie.system, sortie.spec, stream, range(first, last))
    return np.concatenate(scores, axis=-1), lost


def prepare(controller: Controller, study: StudyLike | None, scenario: int, seed: int) -> Sortie:
    """Return what to fly: the study's scenario and limits where a study is given, the usual ones else."""
    row = np.array(controller.gains)
    laws = f"{controller.cascade.position.name} / {controller.cascade.attitude.name}"
    if study is None:
        system = system_of(controller, LIMITS)
        return Sortie(system, row, usual_scenario(system), seed, laws)
    asked = tuning_study(study, "tuner fly --study")
    return Sortie(system_of(controller, asked.system.limits), row, spec_of(asked, scenario), asked.seed, laws)


def plant_sortie(gains: Path, study: StudyLike | None, scenario: int) -> Sortie:
    """Return what a plant's gains.json is to fly: a scenario of the study given, or of that of its results folder."""
    asked = study_of(gains) if study is None else plant_study(study, "tuner fly --study")
    row, laws = read_plant_row(gains, asked.system), dict(asked.about)["laws"]
    return Sortie(asked.system, row, spec_of(asked, scenario), asked.seed, laws)


def spec_of(study: TuningStudy, scenario: int) -> Any:
    """Return a scenario of a study by its number from 0; InputError where there is none."""
    if scenario >= len(study.scenarios):
        raise InputError(
            f"given scenario {scenario}; allowed: 0 to {len(study.scenarios) - 1}", file=study.path, key="--scenario"
        )
    return study.scenarios[scenario].spec


def problem_of(sortie: Sortie, threads: int | None) -> Problem:
    """Return the problem that has every metric of a sortie as an objective."""
    return Problem(
        sortie.system, DecisionSpace((), (), tuple(sortie.gains.tolist())),
        tuple(Objective(metric, Risk("mean")) for metric in shown_metrics(sortie.system, sortie.spec)), (), sortie.root, threads,
    )  # fmt: skip


@singledispatch
def shown_metrics(system: Any, spec: Any) -> list[MetricAddress]:
    """Return the metrics that flights of a system through a scenario can be judged by."""
    raise TypeError(f"nothing judges {type(system).__name__} in {spec.name}")


@shown_metrics.register
def _(system: System, spec: ScenarioSpec) -> list[MetricAddress]:
    track = spec.track(system.timing)
    steps = track.start != track.final
    stepping = {"position": steps[:3].any(), "attitude": steps[3:].any()}
    addresses = []
    for metric in METRICS.values():
        if metric.scope == "flight":
            addresses.append(metric.name)
        else:
            addresses += [f"{metric.name}.{g}" for g in SHOWN_GROUPS if stepping[g] or not metric.needs_step]
    return [parse(address) for address in addresses]


@shown_metrics.register
def _(system: PlantSystem, spec: PlantScenario) -> list[MetricAddress]:
    names = [
        [metric.name] if metric.scope == "flight" else [f"{metric.name}.{name}" for name in system.plan.names]
        for metric in METRICS.values()
    ]
    found = [parse(address, system.axes) for group in names for address in group]
    return [metric for metric in found if _is_judged(system, metric, spec)]


def _is_judged(system: PlantSystem, metric: MetricAddress, spec: PlantScenario) -> bool:
    """Return whether a metric means something on flights of a plant: it has the steps, windows, limits and rate that it needs."""
    try:
        check(metric, system.targets(spec), spec.duration)
        check_bounds(system, [metric])
        metering(system, [metric])
    except InputError:
        return False
    return True


def statistics(objectives: tuple[Objective, ...], scores: np.ndarray) -> list[MetricRow]:
    """Return the statistics of each metric; scores (metrics, flights)."""
    n = scores.shape[1]
    rows = []
    for objective, values in zip(objectives, scores, strict=True):
        mean = float(values.mean())
        if objective.is_binary:
            low, high = (float(end) for end in binary_interval(values, objective.risk))
        else:
            half = 1.96 * float(values.std(ddof=1)) / n**0.5 if n > 1 else 0.0
            low, high = max(mean - half, 0.0), mean + half
        row = (
            MetricRow(
                metric=objective.metric.text, unit=objective.metric.unit, mean=mean, low=low, high=high,
                median=float(np.median(values)), q95=float(np.quantile(values, 0.95)), worst=float(values.max()),
            )
        )  # fmt: skip
        rows.append(row.model_copy(update={"count": ShareCount.of(values)}) if objective.is_binary else row)
    return rows


def recorded_flights(problem: Problem, sortie: Sortie) -> Responses:
    """Fly the first `FAN_FLIGHTS` again with a recorder on."""
    stream, indices = sortie.draws
    inputs = sortie.system.sample(sortie.spec, sortie.root, stream, indices[:FAN_FLIGHTS])
    return responses_of(sortie.system, problem.flyer, sortie.gains, inputs)
