"""Judge flights already flown by other objectives, risks, limits or pick rules: the candidates stay, nothing is searched.

What a run recorded are the meters of every flight, from which any metric follows. A candidate that the first study did not fly
and that the second finds worth it is flown; so are finalists on held-out scenarios that they have not seen.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from plant.errors import InputError, StoreError
from plant.scenarios import HELD_OUT
from tuner.engines.cuda import engine_again
from tuner.experiments.again.replay import replayed
from tuner.experiments.again.resume import recorded_study
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.run import flight_store, problem_of, search, write_inputs, write_outcome
from tuner.search.watcher import Watcher
from tuner.store.advice import JUDGEMENT
from tuner.store.folder import Folder
from tuner.study import load_study
from tuner.study.study import Study

# What a second judgement may differ in.
FREE = ("objective", "constraint", "mission", "guarantee", "margin", "pick", "title", "description")


class Recorded:
    """A search that asks for the candidates of another one."""

    def __init__(self, generations: Iterator[np.ndarray]) -> None:
        self._generations = generations

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d)."""
        return next(self._generations)

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Learn nothing: the candidates are given."""


def judging_study(path: Path, study: Path | None, overrides: Mapping[str, Any]) -> tuple[Study, Study]:
    """Return the study of a results folder and the one to judge it by; InputError where that asks for other flights."""
    first, record = recorded_study(path)
    if not (path / "summary.json").exists():
        raise StoreError(f"the run in {path} is not finished; go on with it by `tuner resume {path}` first")
    asked = load_study(study or path / record.study, {"search.generations": record.generations, **overrides})
    mine, theirs = first.comparable(FREE), asked.comparable(FREE)
    for key in mine:
        if mine[key] != theirs[key]:
            free = ", ".join(FREE)
            raise InputError(f"[{key}] differs from the run's; only these may: {free}", file=asked.path, key=key)
    return first, asked


def rejudge(path: Path, first: Study, asked: Study, folder: Folder, watcher: Watcher, threads: int | None) -> Outcome:
    """Judge the candidates of the results folder `path`, of the study `first`, by another study, into a new folder."""
    begin = perf_counter()
    generations = asked.search.generations
    engine = engine_again(path, first.system, first.seed)
    recorded = replayed(
        path, first, problem_of(first, threads, flight_store(first, None, (path,)), engine), generations
    )
    candidates = [record.points for record in recorded]
    store = flight_store(asked, folder, (path,))
    problem = problem_of(asked, threads, store, engine)
    write_inputs(asked, folder, problem, JUDGEMENT)
    found = search(problem, asked, folder, watcher, Recorded(iter(candidates)))
    outcome = conclude(problem, asked, found, watcher, begin, [])
    store.commit(HELD_OUT)
    write_outcome(outcome, folder, watcher)
    folder.seal()
    return outcome
