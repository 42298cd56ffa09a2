"""Fly given gains through turbulence."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk, binary_interval
from plant.errors import InputError
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT, SEARCH
from tuner.analysis.judgement import CHECK
from tuner.analysis.lost_flights import lost_among
from tuner.analysis.responses import Responses, fan_table, responses_of
from tuner.api.flight_setup import FlightSetup
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import GainsLike, PlantGains, as_gains
from tuner.api.studies import StudyLike
from tuner.documents.parts import LostFlight, ShareCount
from tuner.extension import added, load
from tuner.search.watcher import Watcher, compilation, default_watcher
from tuner.store.document import DocumentPart
from tuner.study.size import MAX_FLIGHTS

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

FLYING = "Flying"
FAN_FLIGHTS = 64
DEFAULT_SEED = 1
STREAMS = (HELD_OUT, CONFIRMATION, SEARCH, CHECK)


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
        flight_setup: The system, gains, scenario and seed that were flown.

    """

    document: FlightsDocument
    flight_setup: FlightSetup
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
        return recorded_flights(self.problem, self.flight_setup)

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
    seed: int | None = None,
    flight: str | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> Flights:
    """Fly gains through turbulence, or through a scenario of their plant's study.

    Args:
        gains: Gains, a gains.json or a results folder; of a plant, name its code with `use` or give the study.
        study: Study whose scenario, limits and seed are flown; by default one metre steps in a fresh breeze, or the study of the
            results folder where a plant's gains lie in one.
        scenario: Number of a scenario of the study, from 0.
        flights: Number of flights, each in its own turbulence.
        seed: Root seed if no study gives one, by default 1.
        flight: Name of a single flight, STREAM-INDEX, such as those that `lost` names, or FOLDER/point-N of a tail; it alone is
            flown.
        watcher: Callbacks that hear of compilation and flights.
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
    given = as_gains(gains)
    if seed is not None and (study is not None or isinstance(given, PlantGains)):
        raise InputError(f"given {seed}, and the study has a seed; remove it, or change seed in the study", key="seed")
    flight_setup = drawn_setup(
        given.flight_setup(study, scenario, DEFAULT_SEED if seed is None else seed), flights, flight
    )
    problem, watcher = problem_of(flight_setup, threads), watcher or default_watcher()
    if not problem.flyer.cached:
        with compilation(watcher):
            problem.warm_up(flight_setup.gains, flight_setup.spec)
    scores, lost = flown_scores(problem, flight_setup, watcher)
    metrics, count = statistics(problem.objectives, scores), scores.shape[-1]
    document = FlightsDocument(scenario=flight_setup.spec.name, flights=count, metrics=metrics, lost=lost)
    return Flights(document, flight_setup, problem)


def drawn_setup(flight_setup: FlightSetup, flights: int, flight: str | None) -> FlightSetup:
    """Return a setup with its draws: so many flights, or one by its name."""
    if flight is None:
        if flights < 1:
            raise InputError(f"given {flights}; allowed: 1 or more", key="flights")
        return replace(flight_setup, draws=(HELD_OUT, range(flights)))
    for reference in added("flights").values():
        single: FlightSetup | None = load(reference)(flight_setup, flight)
        if single is not None:
            return single
    return replace(flight_setup, draws=named_draw(flight))


def named_draw(name: str) -> tuple[str, range]:
    """Return stream and number of a flight by its name; InputError where it is none."""
    stream, _, index = name.rpartition("-")
    if stream not in STREAMS or not (index.isascii() and index.isdigit()) or int(index) >= MAX_FLIGHTS:
        allowed = " or ".join(f"{name_of_stream}-INDEX" for name_of_stream in STREAMS)
        raise InputError(
            f"given '{name}'; write {allowed}, for instance {HELD_OUT}-12, or the FOLDER/point-N of a tail",
            key="--flight",
        )
    return stream, range(int(index), int(index) + 1)


def flown_scores(problem: Problem, flight_setup: FlightSetup, watcher: Watcher) -> tuple[np.ndarray, list[LostFlight]]:
    """Return the scores (metrics, flights) of a flight setup and its lost flights."""
    (stream, indices), scores, lost = flight_setup.draws, [], list[LostFlight]()
    batch = FlightBatch(flight_setup.spec, stream, indices.stop, indices.start)
    watcher.on_stage(FLYING, len(indices))
    for first, last in problem.chunks(batch):
        if flight_setup.single is None:
            results = problem.results(flight_setup.gains[None], batch, first, last)
        else:
            results = problem.flyer.fly(flight_setup.gains[None], problem.system.nominal, flight_setup.inputs(indices))
        scores.append(problem.score(results, flight_setup.spec)[0][0])
        lost += lost_among(results[0], flight_setup.system, flight_setup.spec, stream, range(first, last))
        watcher.on_flights_done(last - first)
    return np.concatenate(scores, axis=-1), lost


def problem_of(flight_setup: FlightSetup, threads: int | None) -> Problem:
    """Return the problem with all metrics of a flight setup as objectives."""
    return Problem(
        flight_setup.system,
        DecisionSpace((), (), tuple(flight_setup.gains.tolist())),
        tuple(Objective(metric, Risk("mean")) for metric in flight_setup.metrics),
        (),
        flight_setup.root,
        threads,
    )


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
        row = MetricRow(
            metric=objective.metric.text,
            unit=objective.metric.unit,
            mean=mean,
            low=low,
            high=high,
            median=float(np.median(values)),
            q95=float(np.quantile(values, 0.95)),
            worst=float(values.max()),
        )
        rows.append(row.model_copy(update={"count": ShareCount.of(values)}) if objective.is_binary else row)
    return rows


def recorded_flights(problem: Problem, flight_setup: FlightSetup) -> Responses:
    """Fly the first `FAN_FLIGHTS` again with a recorder on."""
    inputs = flight_setup.inputs(flight_setup.draws[1][:FAN_FLIGHTS])
    return responses_of(flight_setup.system, problem.flyer, flight_setup.gains, inputs)
