"""`python -m benchmarks.parallel`: how well all cores are used by one evaluation of the contest, and by the quickstart's search.

The evaluation flies 64 candidates 32 times each; the search is all models, margins and flights of the quickstart's generations.
Two figures each. By wall time, one thread over all threads and cores, in turns: right on a quiet machine. By processor time,
which other people's work does not touch: with B the processor time of all threads and M that of the main thread, beside which
nobody works, a quiet machine of n cores would need M + (B - M)/n. Beyond the cores at hand that is a bound: there may be fewer
tasks than cores.
"""

from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, process_time, thread_time
from typing import Any, NamedTuple

from benchmarks.measuring import RESULTS, machine, write_json
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from plant.threads import available_threads, use_threads
from tuner.experiments.tuning.problem import batches, first_batches, problem_of
from tuner.experiments.tuning.search import algorithm_of
from tuner.experiments.tuning.starts import starting_points
from tuner.extensions.contests.study import Contest
from tuner.search.initial_design import initial_design
from tuner.search.loop import search_generations
from tuner.study.build import load_study
from tuner.study.kinds import load_any

STUDIES = Path(__file__).parents[1] / "studies"
CONTENDER, CANDIDATES, ROUNDS = "Hybrid A-ST-SMC", 64, 5
# Numbers of cores for which the efficiency is worked out.
CORES = (2, 4, 8, 16, 64)

Work = Callable[[int], None]
"""A piece of work on so many threads."""


class Took(NamedTuple):
    """Seconds: wall, processor time of all threads, and of the main thread."""

    wall: float
    busy: float
    alone: float


def quiet_wall(took: Took, cores: int) -> float:
    """Return what it would take on a quiet machine with so many cores [s]."""
    return took.alone + (took.busy - took.alone) / cores


def evaluation() -> Work:
    """Return one evaluation of a contender of the contest."""
    contest = load_any(STUDIES / "contest.toml")
    assert isinstance(contest, Contest)
    study = next(entry.study for entry in contest.contenders if entry.name == CONTENDER)
    flown = batches(study, SEARCH)
    problems = {threads: problem_of(study, threads, None) for threads in sorted({1, available_threads()})}
    points = generator(1, "benchmarks/parallel", 0).uniform(size=(CANDIDATES, len(study.space.variables)))

    def evaluate(threads: int) -> None:
        problems[threads].evaluate(points, flown, fly_all=True)

    return evaluate


def quickstart() -> Work:
    """Return the search of the quickstart; the study is read each time, because it keeps the margins that it was asked for."""

    def search(threads: int) -> None:
        study = load_study(STUDIES / "quickstart.toml")
        problem, flown = problem_of(study, threads, None), first_batches(study)
        draw = generator(study.seed, "search/initial", 0)
        first = initial_design(starting_points(study)[0], study.search.population, draw, problem.excess)
        algorithm = algorithm_of(problem, study, first)
        for _ in search_generations(algorithm, lambda points: problem.evaluate(points, flown), study.search.budget):
            pass

    return search


def measured(work: Work) -> dict[str, Any]:
    """Measure both figures of a piece of work."""
    cores = available_threads()

    def take(threads: int) -> Took:
        use_threads(threads)
        begin = perf_counter(), process_time(), thread_time()
        work(threads)
        return Took(perf_counter() - begin[0], process_time() - begin[1], thread_time() - begin[2])

    counts = sorted({1, cores})
    for threads in counts:
        take(threads)
    rounds = [{threads: take(threads) for threads in counts} for _ in range(ROUNDS)]
    return {
        "efficiency_wall": median(entry[1].wall / entry[cores].wall / cores for entry in rounds),
        "efficiency_processor": {
            str(n): median(entry[1].busy / quiet_wall(entry[cores], n) / n for entry in rounds) for n in CORES
        },
        "alone_share": median(entry[cores].alone / entry[cores].busy for entry in rounds),
        "rounds": [{str(threads): took._asdict() for threads, took in entry.items()} for entry in rounds],
    }


def main() -> None:
    """Write parallel.json."""
    found = {"machine": machine(), "cores": available_threads()}
    found |= {name: measured(work()) for name, work in (("evaluation", evaluation), ("quickstart", quickstart))}
    write_json(RESULTS / "parallel.json", found)
    for name in ("evaluation", "quickstart"):
        print(name, {key: found[name][key] for key in ("efficiency_wall", "efficiency_processor", "alone_share")})


if __name__ == "__main__":
    main()
