"""A tuning run: search, re-fly the finalists on held-out scenarios, pick, write everything down."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from objectives.engine import Engine
from plant.scenarios import HELD_OUT
from tuner.documents.ending import gains_name
from tuner.experiments.experiment import DRAWN, Experiment
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.experiments.tuning.gains_of_run import gains_document
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.problem import check_searched, flight_store, problem_of, warm_up
from tuner.experiments.tuning.search import algorithm_of, first_points, search
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import front_table
from tuner.search.loop import Search
from tuner.search.watcher import Watcher
from tuner.store.advice import TUNING
from tuner.store.clock import Clock
from tuner.store.folder import Folder
from tuner.study.study import Study
from tuner.study.trim import trim_texts


class TuningRun(Experiment[Study, Outcome]):
    """A study run in a results folder; every generation is on disk before the next one flies.

    Flights that are in the folder already, or in the results folders `reuse`, are not flown again: a run that was stopped goes
    on where it was, and ends with the bits that it would have ended with.
    """

    kind = TUNING
    options = frozenset({"reuse", "dask", "backend", "budget", "here"})

    @classmethod
    def check(cls, study: Study) -> None:
        """Refuse a study that searches no gain."""
        check_searched(study)

    @classmethod
    def notes(cls, study: Study) -> list[str]:
        """Say what a steady wind takes and which limits the study does not write."""
        specs = [entry.spec for entry in study.scenarios]
        return [*trim_texts(specs, study.system), *automatic_limit_texts(study.constraints)]

    @classmethod
    @contextmanager
    def engine_for(
        cls,
        study: Study,
        threads: int | None,
        dask: str | None,
        backend: str | None,
        watcher: Watcher,
        recorded: Path | None,
    ) -> Iterator[Engine | None]:
        """Yield a cluster, a graphics card, or None for this machine's cores; recorded: the folder to go on with."""
        from tuner.engines.cluster.connect import engine_at
        from tuner.engines.cuda import LANES, engine_again, engine_named

        with engine_at(dask, study, threads, watcher.on_message) as cluster:
            if recorded is not None:
                yield engine_again(recorded, study.system, study.seed, cluster)
            else:
                yield cluster or engine_named(backend or LANES, study.system, study.seed, watcher.on_message)

    def prepare(self) -> None:
        """Index the flights on record and pose the problem."""
        self.clock = Clock()
        self.store = flight_store(self.study, self.folder, self.reuse)
        self.problem = problem_of(self.study, self.threads, self.store, self.engine)

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
            warm_up(self.problem, self.study, self.watcher)

    def algorithm(self) -> tuple[Search, list[str]]:
        """Return the search, at its beginning, and warnings about its starting points."""
        first, warnings = first_points(self.problem, self.study, self.folder)
        return algorithm_of(self.problem, self.study, first), warnings

    def fly(self) -> Outcome:
        """Search, re-fly the finalists and pick."""
        algorithm, warnings = self.algorithm()
        generations = search(self.problem, self.study, self.folder, self.watcher, algorithm, self.clock)
        # What earlier sessions took counts.
        self.begin -= max(generations[-1].seconds - self.seconds, 0.0)
        outcome = conclude(self.problem, self.study, generations, self.watcher, self.begin, warnings)
        self.store.commit(HELD_OUT)
        return outcome

    @staticmethod
    def is_feasible(found: Outcome) -> bool:
        """Whether the run recommends gains."""
        return found.feasible

    def write(self, found: Outcome) -> None:
        """Write documents and tables while the process that draws the figures starts, then the report."""
        from tuner.experiments.tuning.run_margins import margin_table
        from tuner.report import start_figures, write_report

        folder, watcher = self.folder, self.watcher
        drawing = start_figures(folder.path)
        try:
            self.write_documents(found)
            drawing.begin()
            watcher.on_writing("margins")
            margins = margin_table(found)
            if margins is not None:
                folder.write_table("margins.parquet", margins)
            watcher.on_writing("report")
            write_report(folder.path)
            watcher.on_writing("figures")
            drawing.wait()
        except BaseException:
            drawing.stop()
            raise
        folder.written(*DRAWN)

    def write_documents(self, found: Outcome) -> None:
        """Write what the figures show: front, summary, responses; and gains."""
        from tuner.experiments.tuning.run_constraints import constraint_table
        from tuner.experiments.tuning.run_responses import response_table

        folder = self.folder
        summary = summary_document(found)
        folder.write_table("front.csv", front_table(found))
        folder.remove(gains_name(not found.feasible))
        folder.write_json(gains_name(found.feasible), gains_document(found, summary))
        folder.write_json("summary.json", summary)
        self.watcher.on_writing("responses")
        folder.write_table("responses.parquet", response_table(found))
        if found.study.constraints:
            folder.write_table("constraints.csv", constraint_table(found))

    @staticmethod
    def draw(path: Path, watcher: Watcher) -> None:
        """Draw figures and report again."""
        from tuner.report import write_figures, write_report

        watcher.on_writing("figures")
        write_figures(path)
        watcher.on_writing("report")
        write_report(path)


def run_study(
    study: Study,
    folder: Folder,
    watcher: Watcher | None = None,
    threads: int | None = None,
    reuse: tuple[Path, ...] = (),
    engine: Engine | None = None,
) -> Outcome:
    """Carry out a tuning run in a results folder, see `TuningRun`."""
    return TuningRun(study, folder, watcher, threads, reuse, engine).carry_out()
