"""A tuning run: search, re-fly the finalists on held-out scenarios, pick, write everything down.

A judgement is a tuning run that searches nothing: flights already flown, judged by other objectives, risks, limits or pick rules.
A run records the meters of every flight, from which any metric follows. A candidate that the first study did not fly
and that the second finds worth it is flown; so are finalists on held-out scenarios that they have not seen.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import Unpack

import numpy as np

from objectives.engine import LANES, Engine
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.texts import PlainTable
from plant.threads import use_threads
from tuner import report
from tuner.analysis.finals import draw_ahead
from tuner.documents.summary import Summary, gains_name
from tuner.engines.registry import cluster_engine, engine_named, recorded_engine
from tuner.experiments.experiment import DRAWN, Experiment
from tuner.experiments.options import Options, reused
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.experiments.tuning.fans import Fans, response_table
from tuner.experiments.tuning.gains_of_run import gains_document
from tuner.experiments.tuning.named_points import possible_names
from tuner.experiments.tuning.outcome import FlightOutcome
from tuner.experiments.tuning.problem import batches, check_searched, problem_of, warm_up
from tuner.experiments.tuning.search import algorithm_of, first_points, flight_store, search
from tuner.experiments.tuning.stages import stage_flights
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import (
    WORST_STATES,
    constraint_table,
    front_table,
    margin_table,
    spectrum_table,
    worst_state_table,
)
from tuner.search.convergence import StoppingRule
from tuner.search.loop import Search
from tuner.search.watcher import Watcher
from tuner.store.advice import JUDGEMENT, POINTS
from tuner.store.clock import Clock
from tuner.study.tuning_study import TuningStudy


class TuningRun(Experiment[TuningStudy, FlightOutcome]):
    """A study run in a results folder; every generation is on disk before the next one flies.

    Flights that are in the folder already, or in the results folders `reuse`, are not flown again: a run that was stopped goes
    on where it was, and ends with the bits that it would have ended with.
    """

    takes = frozenset({"reuse", "dask", "backend", "budget", "search_flights", "recompute"})
    draw_figures = staticmethod(report.write_figures)
    draw_page = staticmethod(report.write_report)

    @classmethod
    def check(cls, study: TuningStudy) -> None:
        """Refuse a study that searches no gain."""
        check_searched(study)

    @classmethod
    def notes(cls, study: TuningStudy) -> list[str]:
        """Return notes on search, rotor lag, steady wind and automatic limits."""
        return [study.search.text, *study.start_texts, *study.notes, *automatic_limit_texts(study.automatic_limits)]

    @classmethod
    @contextmanager
    def engine_for(
        cls, study: TuningStudy, watcher: Watcher, recorded: Path | None, **options: Unpack[Options]
    ) -> Iterator[Engine | None]:
        """Yield a cluster, a graphics card, or None for this machine's cores; recorded: the folder to go on with."""
        with cluster_engine(options.get("dask"), study, options.get("threads"), watcher.on_message) as cluster:
            if recorded is not None:
                yield recorded_engine(recorded, study.system, study.seed, cluster)
            else:
                backend = options.get("backend", LANES)
                yield cluster or engine_named(backend, study.system, study.seed)

    def prepare(self) -> None:
        """Index the flights on record and pose the problem."""
        use_threads(self.threads)
        self.clock = Clock()
        self.store = flight_store(self.study, self.folder, reused(self.options))
        self.problem = problem_of(self.study, self.threads, self.store, self.engine)
        self.problem.flyer.say = self.watcher.on_warning
        self.fans = Fans(self.study, self.problem)

    @property
    def damaged(self) -> list[str]:
        """Names of damaged files of flights."""
        return self.store.damaged

    @property
    def arithmetic(self) -> str:
        """Arithmetic of the engine that flies."""
        return self.problem.engine.arithmetic

    def warm_up(self) -> None:
        """Have the kernel compiled where anything is left to search."""
        if self.store.generations < self.study.search.generations:
            warm_up(self.problem, self.study, self.watcher, self._folder.path if self._folder else None)

    @property
    def budget(self) -> StoppingRule:
        """Number of generations, and whether the search may end before."""
        return self.study.search.budget

    def algorithm(self) -> tuple[Search, list[str]]:
        """Return the search, at its beginning, and warnings about its starting points."""
        first, warnings = first_points(self.problem, self.study, self.folder)
        return algorithm_of(self.problem, self.study, first), warnings

    def fly(self) -> FlightOutcome:
        """Search, re-fly the finalists and pick."""
        # It imports while one core of this process rests.
        self.drawing = report.start_figures(self.folder.path)
        with self.given_up_on_error():
            if self.store.generations < self.study.search.generations:
                Thread(target=self.prepare_end, daemon=True).start()
            self.watcher.on_plan(stage_flights(self.study))
            algorithm, warnings = self.algorithm()
            generations = search(
                self.problem, self.study, self.folder, self.watcher, algorithm, self.budget, self.clock
            )
            # What earlier sessions took counts.
            self.begin -= max(generations[-1].seconds - self.seconds, 0.0)
            self.fans.record()
            outcome = conclude(self.problem, self.study, generations, self.watcher, self.begin, warnings)
            self.store.commit(HELD_OUT)
        return outcome

    def prepare_end(self) -> None:
        """Import and draw what the run's end takes, on idle cores."""
        # Whatever goes wrong here goes wrong again where it is needed, and is told there.
        with suppress(Exception):
            report.prepare()
            draw_ahead(self.problem, batches(self.study, HELD_OUT), batches(self.study, CONFIRMATION))

    @contextmanager
    def given_up_on_error(self) -> Iterator[None]:
        """Give the figures up where an error ends the run."""
        try:
            yield
        except BaseException:
            self.drawing.stop()
            raise

    @staticmethod
    def is_feasible(result: FlightOutcome) -> bool:
        """Whether the run recommends gains."""
        return result.feasible

    def write(self, result: FlightOutcome) -> None:
        """Write documents, tables and report while another process draws the figures."""
        folder, watcher = self.folder, self.watcher
        with self.given_up_on_error():
            self.write_documents(result)
            watcher.on_writing("margins")
            margins = margin_table(result)
            if margins is not None:
                folder.write_table("margins.npz", margins)
            worst = worst_state_table(result, self.results.requirements)
            folder.remove(WORST_STATES)
            if worst is not None:
                folder.write_table(WORST_STATES, worst)
            watcher.on_writing("report")
            report.write_report(folder.path, self.results)
            watcher.on_writing("figures")
            self.drawing.wait()
        folder.written(*DRAWN)

    def write_documents(self, result: FlightOutcome) -> None:
        """Write what the figures show: front, summary, responses; and gains."""
        folder = self.folder
        summary = summary_document(result)
        folder.write_table("front.csv", front_table(result))
        folder.write_json("summary.json", summary)
        self.results = report.opened(folder.path)
        self.drawing.begin(self.results)
        folder.remove(gains_name(not result.feasible))
        folder.write_json(gains_name(result.feasible), gains_document(result, summary))
        self.write_points(result, summary)
        self.on_documents(result)
        self.watcher.on_writing("responses")
        spectra = spectrum_table(result)
        if spectra is not None:
            folder.write_table("spectra.npz", spectra)
        folder.write_table("responses.npz", response_table(result, self.fans))
        self.drawing.go_on(self.results)
        if result.study.constraints:
            folder.write_table("constraints.csv", constraint_table(result))

    def write_points(self, result: FlightOutcome, summary: Summary) -> None:
        """Write the gains of the named points; what an earlier end of this run left goes."""
        names = {entry.name: entry.point for entry in summary.points}
        for name in possible_names(result.study.objectives):
            if name not in names:
                self.folder.remove(f"{POINTS}/{name}.json")
                continue
            row = result.names.index(names[name])
            parts: PlainTable = {"study": result.study.origin(names[name])}  # pyright: ignore[reportAssignmentType]
            self.folder.write_json(f"{POINTS}/{name}.json", result.study.gains_document(result.gains(row), parts))


class Recorded:
    """A search that asks for the candidates of another one."""

    def __init__(self, generations: Iterator[np.ndarray]) -> None:
        self._generations = generations

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d)."""
        return next(self._generations)

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Learn nothing: the candidates are given."""


class JudgementRun(TuningRun):
    """A tuning run that asks for recorded candidates. candidates: one array (n, d) a generation."""

    kind = JUDGEMENT
    takes = frozenset()
    candidates: list[np.ndarray]

    @property
    def budget(self) -> StoppingRule:
        """Number of recorded generations: where the first judge stopped, nothing else is known."""
        return StoppingRule(len(self.candidates))

    def algorithm(self) -> tuple[Search, list[str]]:
        """Return the recorded search."""
        return Recorded(iter(self.candidates)), []
