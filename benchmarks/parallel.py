"""`python -m benchmarks.parallel`: how well one evaluation of the contest (64 candidates, 32 flights each) uses all cores.

Two figures. By wall time, one thread over all threads and cores, in turns: right on a quiet machine. By processor time,
which other people's work does not touch: with B the processor time of all threads and M that of the main thread, which
works alone (margins, statistics), a quiet machine of n cores would need M + (B - M)/n; the flights are handed out one
candidate at a time.
"""

from pathlib import Path
from statistics import median
from time import perf_counter, process_time, thread_time
from typing import Any, NamedTuple

from benchmarks.measuring import RESULTS, machine, write_json
from plant.threads import available_threads

STUDY = Path(__file__).parents[1] / "studies" / "contest.toml"
CONTENDER, CANDIDATES, ROUNDS = "Hybrid A-ST-SMC", 64, 5


class Took(NamedTuple):
    """Seconds: wall, processor time of all threads, and of the main thread."""

    wall: float
    busy: float
    alone: float


def quiet_wall(took: Took, cores: int) -> float:
    """Return what it would take on a quiet machine with so many cores [s]."""
    return took.alone + (took.busy - took.alone) / cores


def run() -> dict[str, Any]:
    """Measure both figures."""
    from plant.scenarios import SEARCH
    from plant.seeds import generator
    from tuner.experiments.tuning.problem import batches, problem_of
    from tuner.study.contest import Contest
    from tuner.study.kinds import load_any

    contest = load_any(STUDY)
    assert isinstance(contest, Contest)
    study = next(entry.study for entry in contest.contenders if entry.name == CONTENDER)
    cores, flown = available_threads(), batches(study, SEARCH)
    problems = {threads: problem_of(study, threads, None) for threads in sorted({1, cores})}
    points = generator(1, "benchmarks/parallel", 0).uniform(size=(CANDIDATES, len(study.space.variables)))

    def evaluate(threads: int) -> Took:
        begin = perf_counter(), process_time(), thread_time()
        problems[threads].evaluate(points, flown, fly_all=True)
        return Took(perf_counter() - begin[0], process_time() - begin[1], thread_time() - begin[2])

    for threads in problems:
        evaluate(threads)
    rounds = [{threads: evaluate(threads) for threads in problems} for _ in range(ROUNDS)]
    return {
        "machine": machine(),
        "cores": cores,
        "efficiency_wall": median(entry[1].wall / entry[cores].wall / cores for entry in rounds),
        "efficiency_processor": median(entry[1].busy / quiet_wall(entry[cores], cores) / cores for entry in rounds),
        "alone_share": median(entry[1].alone / entry[1].busy for entry in rounds),
        "rounds": [{str(threads): took._asdict() for threads, took in entry.items()} for entry in rounds],
    }


def main() -> None:
    """Write parallel.json."""
    found = run()
    write_json(RESULTS / "parallel.json", found)
    print({key: round(found[key], 3) for key in ("efficiency_wall", "efficiency_processor", "alone_share")})


if __name__ == "__main__":
    main()
