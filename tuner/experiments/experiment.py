"""The life of an experiment, the same for every kind.

Inputs are frozen and the environment noted, kernels compiled, the stages of the kind carried out, documents and tables written,
figures and report drawn, and the manifest sealed. A run that is interrupted leaves a folder that can be resumed, and its error
carries a note on how.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar, Generic, TypeVar, Unpack

from objectives.engine import LANES, Engine
from plant.threads import available_threads
from tuner.documents.resolved import Resolved
from tuner.experiments.options import Options
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.environment import environment, with_session
from tuner.store.folder import Folder
from tuner.store.inputs import freeze

StudyT = TypeVar("StudyT")
ResultT = TypeVar("ResultT")
DRAWN = ("report.html", "figures/*")
"""Files of a results folder that are drawn from its documents."""


class Experiment(ABC, Generic[StudyT, ResultT]):
    """An experiment on a study, in a results folder or in none.

    Some kinds allow none. A subclass gives the stages of its kind. engine: what flies instead of this machine's cores,
    where the kind takes one.
    """

    kind: ClassVar[str | None] = None
    """Name of the kind, as in run.json, where it is not that of the study."""
    inside: ClassVar[str] = "generations"
    """Folder that is made in a new results folder."""
    resumable: ClassVar[bool] = True
    """Whether run.json and inputs/ are written, from which an interrupted run goes on."""
    draw_figures: ClassVar[Callable[[Path], object]]
    """Writes figures/ of a results folder from its documents."""
    draw_page: ClassVar[Callable[[Path], object]]
    """Writes report.html of a results folder from its documents."""
    takes: ClassVar[frozenset[str]] = frozenset()
    """Names of the options that not every kind takes and this one does, see `tuner.experiments.options`."""

    def __init__(
        self,
        study: StudyT,
        folder: Folder | None,
        watcher: Watcher | None = None,
        engine: Engine | None = None,
        **options: Unpack[Options],
    ) -> None:
        self.begin = perf_counter()
        self.study: Any = study
        self.watcher = watcher or default_watcher()
        self.options = options
        self.threads = options.get("threads")
        self.engine = engine
        self._folder = folder
        self.on_documents: Callable[[ResultT], None] = lambda _: None
        """Called when the documents that hold the answer are written."""

    @property
    def folder(self) -> Folder:
        """The results folder; an error of ours where there is none."""
        assert self._folder is not None, "asked for only where results are written"
        return self._folder

    @property
    def seconds(self) -> float:
        """Seconds since the experiment began."""
        return perf_counter() - self.begin

    def carry_out(self) -> ResultT:
        """Carry out the experiment, seal its folder and return the result."""
        with self._folder or nullcontext():
            self.prepare()
            if self._folder is not None:
                self._write_inputs(self._folder)
            for name in self.damaged:
                self.watcher.on_warning(f"{name} is damaged; it is not used, and what it held is flown again.")
            self.warm_up()
            result = self.fly()
            if self._folder is not None:
                self.write(result)
                self._folder.seal()
        return result

    @classmethod
    def check(cls, study: StudyT) -> None:
        """Refuse a study that cannot be carried out; InputError names the key. No folder is made before."""

    @classmethod
    def notes(cls, study: StudyT) -> list[str]:
        """Return sentences that a person reads before the run."""
        return []

    @classmethod
    @contextmanager
    def engine_for(
        cls, study: StudyT, watcher: Watcher, recorded: Path | None, **options: Unpack[Options]
    ) -> Iterator[Engine | None]:
        """Yield what flies instead of this machine's cores; recorded: the results folder to go on with, if any."""
        yield None

    def prepare(self) -> None:
        """Read the records and build what flies, before anything is written."""

    @property
    def damaged(self) -> Sequence[str]:
        """Names of damaged files whose flights are made again."""
        return ()

    @property
    def arithmetic(self) -> str:
        """Arithmetic of the engine that flies, see `objectives.engine`."""
        return LANES

    def warm_up(self) -> None:
        """Have kernels compiled before anything is timed."""

    @abstractmethod
    def fly(self) -> ResultT:
        """Carry out the stages of the kind: all that takes flights."""

    @abstractmethod
    def write_documents(self, result: ResultT) -> None:
        """Write documents and tables."""

    @classmethod
    def draw(cls, path: Path, watcher: Watcher) -> None:
        """Draw figures and report of a results folder from its documents."""
        watcher.on_writing("figures")
        cls.draw_figures(path)
        watcher.on_writing("report")
        cls.draw_page(path)

    def write(self, result: ResultT) -> None:
        """Write documents and tables, then figures and report."""
        self.write_documents(result)
        self.on_documents(result)
        self.draw(self.folder.path, self.watcher)
        self.folder.written(*DRAWN)

    @staticmethod
    def is_feasible(result: ResultT) -> bool:
        """Whether what was found may be recommended."""
        return True

    def resolved(self) -> Any:
        """Return every value of the study for resolved.json; None where the kind writes no such file."""
        return Resolved.of(self.study.resolved())

    def _write_inputs(self, folder: Folder) -> None:
        """Write what the run starts from; a resumed run adds its session to what is there."""
        if not folder.keep("study.toml"):
            folder.write_text("study.toml", self.study.text)
        resolved = self.resolved()
        if resolved is not None:
            folder.write_json("resolved.json", resolved)
        now = environment(self.threads or available_threads())
        folder.write_json("environment.json", with_session(folder.path / "environment.json", now))
        if self.resumable:
            study = self.study
            freeze(
                folder,
                self.kind or study.kind,
                study.path,
                study.content,
                study.digest(),
                study.generations,
                self.arithmetic,
            )


def default_folder(study: Any) -> Path:
    """Return the folder that results go to unless another is given: results/NAME."""
    return Path("results") / study.path.stem
