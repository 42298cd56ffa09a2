"""The kinds of experiments by name, and functions on all: `run` a study, `draw` a results folder again."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Unpack

from objectives.engine import LANES
from plant.errors import InputError, StoreError
from tuner.documents.opening import open_results
from tuner.engines.registry import check
from tuner.experiments.experiment import DRAWN, Experiment, default_folder
from tuner.experiments.options import OPTIONS, RunOptions, reused
from tuner.extension import objects, refuse_lacking
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.advice import JUDGEMENT, PLANT, TUNING, kind_of
from tuner.store.folder import Folder
from tuner.store.inputs import compute_as_recorded, read_record
from tuner.study.kinds import AnyStudy


@dataclass(frozen=True)
class ExperimentKind:
    """A kind of experiment.

    Args:
        name: Name in run.json.
        module: Module of its `run`.
        life: Name of its class there.
        document: The file of its folder that holds the findings.
        noun: With its article.
        lacks: Options that its class takes and it does not.
        progress: "module:function" that returns the progress of an unfinished folder from folder, title and commands, "" for that
            of a search.
    """

    name: str
    module: str
    life: str
    document: str
    noun: str
    lacks: frozenset[str] = frozenset()
    progress: str = ""

    @property
    def run(self) -> type[Experiment[Any, Any]]:
        """Its life; imported when it is asked for, because a run of one kind would wait 0.1 s for all others."""
        return getattr(import_module(self.module), self.life)


EXPERIMENTS = {
    kind.name: kind
    for kind in (
        ExperimentKind(TUNING, "tuner.experiments.tuning.run", "TuningRun", "summary.json", "a tuning run"),
        ExperimentKind(
            PLANT,
            "tuner.experiments.tuning.run",
            "TuningRun",
            "summary.json",
            "a tuning run of a plant",
            frozenset(("backend",)),
        ),
        ExperimentKind(JUDGEMENT, "tuner.experiments.tuning.run", "JudgementRun", "summary.json", "a judgement"),
        ExperimentKind(
            "comparison", "tuner.experiments.compare.run", "ComparisonRun", "comparison.json", "a comparison"
        ),
    )
}
"""Kinds of experiments of the core whose folders are drawn, by name; those of extensions are in their records."""


@cache
def experiments() -> dict[str, ExperimentKind]:
    """Return the kinds of experiments by name."""
    return EXPERIMENTS | objects("experiments")


@dataclass(frozen=True)
class CompletedRun:
    """A completed run.

    Attributes:
        path: Its folder.
        outcome: Its results, of a type that its kind has.
        feasible: Whether the outcome may be recommended.
    """

    path: Path
    kind: ExperimentKind
    outcome: Any
    feasible: bool

    @property
    def document(self) -> Path:
        """The JSON file that holds what was found."""
        return self.path / self.kind.document


def refuse_options(kind: ExperimentKind, **given: object) -> None:
    """Refuse options that a kind does not take; InputError names the key."""
    for name, value in given.items():
        option = OPTIONS[name]
        if value and value != option.default and option.why and name not in kind.run.takes - kind.lacks:
            raise InputError(option.why, key=option.flag_of(name))


def run(
    study: AnyStudy,
    out: Path | None = None,
    watcher: Watcher | None = None,
    **options: Unpack[RunOptions],
) -> CompletedRun:
    """Run a study of any kind into a new results folder.

    The default folder is results/NAME. Raises InputError, and StoreError where the folder cannot be written.
    """
    watcher, kind, reuse = watcher or default_watcher(), experiments()[study.kind], reused(options)
    for results in reuse:
        if not results.is_dir():
            raise InputError(f"there is no results folder {results}", key="--reuse")
    check_backend(options.get("backend", LANES), options.get("dask"))
    refuse_options(kind, **options)
    kind.run.check(study)
    compute_as_reused(reuse)
    # Before the folder is made: where there is no cluster, nothing is left behind.
    with kind.run.engine_for(study, watcher, None, **options) as engine:
        folder = Folder.create(out or default_folder(study), inside=kind.run.inside)
        watcher.on_start(study, folder.path, kind.run.notes(study))
        return completed(kind.run(study, folder, watcher, engine, **options), kind)


def completed(experiment: Experiment[Any, Any], kind: ExperimentKind) -> CompletedRun:
    """Carry out an experiment and return it with its folder; its watcher hears of the answer once it is written."""

    def announce(result: Any) -> None:
        experiment.watcher.on_answer(experiment.folder.path, getattr(result, "flights_made", None))

    experiment.on_documents = announce
    result = experiment.carry_out()
    return CompletedRun(experiment.folder.path, kind, result, experiment.is_feasible(result))


def check_backend(backend: str, dask: str | None) -> None:
    """Refuse a backend that there is not, or with a cluster."""
    check(backend)
    if backend != LANES and dask is not None:
        raise InputError(
            f"given {backend}; the workers of a cluster fly lanes, so give --dask or --backend", key="--backend"
        )


def compute_as_reused(paths: tuple[Path, ...]) -> None:
    """Set the arithmetic of the runs whose flights are reused; StoreError where it is not available."""
    for path in paths:
        try:
            record = read_record(path)
        except StoreError:
            # What is left of it is taken over all the same, where its keys are those of this run.
            continue
        compute_as_recorded(path, record, "leave --reuse out")


def folder_kind(path: Path) -> ExperimentKind | None:
    """Return a folder's experiment kind by run.json, or else by document; None where neither tells."""
    name = kind_of(path) or ""
    refuse_lacking("experiments", name, file=path)
    recorded = experiments().get(name)
    return recorded or next((kind for kind in experiments().values() if (path / kind.document).exists()), None)


def draw(path: Path, watcher: Watcher | None = None) -> Path:
    """Draw a finished folder's figures and report again, and return the page; StoreError where it is not finished."""
    kind = folder_kind(path)
    if kind is None or not (path / kind.document).exists():
        raise StoreError(f"{path} is no finished results folder: it holds no summary.json")
    # What cannot be read is told before the folder is touched: a lock would stay behind.
    open_results(path)
    with Folder.open(path) as folder:
        kind.run.draw(path, watcher or default_watcher())
        folder.amend(*DRAWN)
    return path / "report.html"
