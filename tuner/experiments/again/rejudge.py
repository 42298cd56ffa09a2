"""Judge the flights of a tuning run again: by other objectives, risks, limits or pick rules, without a search."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plant.errors import InputError, StoreError
from plant.texts import PlainValue
from tuner.engines.registry import recorded_engine
from tuner.experiments.again.resume import recorded_study
from tuner.experiments.registry import CompletedRun, completed, experiments
from tuner.experiments.tuning.flight_growth import grown_study
from tuner.experiments.tuning.problem import problem_of
from tuner.experiments.tuning.run import JudgementRun
from tuner.experiments.tuning.search import flight_store, replayed
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.advice import JUDGEMENT
from tuner.store.folder import Folder
from tuner.store.inputs import as_recorded, check_model
from tuner.study.kinds import load_gains_study
from tuner.study.study import TuningStudy

# What a second judgement may differ in.
FREE = (
    "objective",
    "constraint",
    "metric",
    "mission",
    "confidence",
    "relevant",
    "guarantee",
    "margin",
    "pick",
    "title",
    "description",
)


def rejudge(
    path: Path,
    out: Path,
    study: Path | None = None,
    overrides: Mapping[str, PlainValue] | None = None,
    watcher: Watcher | None = None,
    *,
    threads: int | None = None,
) -> CompletedRun:
    """Judge the candidates of a tuning run by another study.

    Without one, the study of the run with overrides judges. The judgement goes into a new folder. Raises InputError where
    the study asks for other flights, StoreError where the run is not finished or cannot be had again.
    """
    watcher = watcher or default_watcher()
    first, judging = judging_study(path, study, overrides or {})
    folder = Folder.create(out)
    watcher.on_start(judging, folder.path, JudgementRun.notes(judging))
    return completed(judgement(path, first, judging, folder, watcher, threads), experiments()[JUDGEMENT])


def judging_study(
    path: Path, study: Path | None, overrides: Mapping[str, PlainValue]
) -> tuple[TuningStudy, TuningStudy]:
    """Return the recorded study and the judging study; InputError where the latter asks for other flights."""
    first, record = recorded_study(path)
    check_model(path, record)
    if not (path / "summary.json").exists():
        raise StoreError(f"the run in {path} is not finished; go on with it by `tuner resume {path}` first")
    file = study or path / record.study
    judging = load_gains_study(file, "tuner rejudge", as_recorded(record, file) | dict(overrides))
    mine, theirs = first.comparable(FREE), judging.comparable(FREE)
    for key in mine | theirs:
        if mine.get(key) != theirs.get(key):
            free = ", ".join(FREE)
            raise InputError(f"[{key}] differs from the run's; only these may: {free}", file=judging.path, key=key)
    return first, judging


def judgement(
    path: Path, first: TuningStudy, judging: TuningStudy, folder: Folder, watcher: Watcher, threads: int | None
) -> JudgementRun:
    """Return the experiment that judges the results folder `path` (study `first`) by another study."""
    engine = recorded_engine(path, first.system, first.seed)
    problem = problem_of(first, threads, flight_store(first, None, (path,)), engine)
    *_, generations = replayed(path, first, problem, first.search.budget)
    judging = replace(judging, search=grown_study(first, generations).search)
    experiment = JudgementRun(judging, folder, watcher, engine, threads=threads, reuse=(path,))
    experiment.candidates = [record.points for record in generations]
    return experiment
