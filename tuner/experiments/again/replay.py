"""A search asked again and told what is recorded: the candidates of a run, generation by generation, without flying."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from objectives.problem import Evaluation, Problem
from plant.errors import StoreError
from tuner.experiments.tuning.run import algorithm_of, evaluated
from tuner.search.loop import Generation, search_generations
from tuner.store.start import FILE, read_start
from tuner.study.study import Study


def replayed(path: Path, study: Study, problem: Problem, count: int) -> Iterator[Generation]:
    """Yield the first `count` generations of a results folder; flights that the problem's memory does not hold are flown."""
    known = read_start(path, len(study.space.variables))
    if known is None:
        raise StoreError(f"{path / FILE} is missing or damaged; `tuner resume {path}` writes it again")
    done: list[Generation] = []

    def evaluate(points: np.ndarray) -> Evaluation:
        default = np.arange(len(points)) == 0 if not done else False
        return evaluated(problem, study, points, done, fly_all=default)

    for record in search_generations(algorithm_of(study, known[0]), evaluate, count):
        done.append(record)
        yield record
