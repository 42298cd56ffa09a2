"""`tuner resume`: go on with a run, be it of a study, a contest or an inference."""

from pathlib import Path

from plant.errors import InputError
from tuner.cli.terminal import Console
from tuner.store.advice import CONTEST, INFERENCE
from tuner.store.inputs import read_record


def resume_command(
    results: Path, budget: int | None, threads: int | None, as_json: bool, dask: str | None = None, here: bool = False
) -> None:
    """Go on with a run and print what it found."""
    kind = read_record(results).kind
    if dask is not None and kind in (CONTEST, INFERENCE):
        raise InputError("only a tuning study flies on a cluster", key="--dask")
    if here and kind in (CONTEST, INFERENCE):
        raise InputError("only a tuning study is computed anew; run this one again", key="--here")
    if kind == CONTEST:
        _resume_contest(results, budget, threads, as_json)
    elif kind == INFERENCE:
        _resume_inference(results, budget, threads, as_json)
    else:
        _resume_study(results, budget, threads, as_json, dask, here)


def _resume_study(
    results: Path, budget: int | None, threads: int | None, as_json: bool, dask: str | None, here: bool
) -> None:
    from tuner.cli.commands import print_run
    from tuner.engines.cluster.connect import engine_at
    from tuner.engines.cuda import engine_again
    from tuner.experiments.again.resume import reopen
    from tuner.experiments.tuning.run import run_study

    study, folder = reopen(results, budget, here)
    with engine_at(dask, study, threads, Console(stderr=as_json).print) as cluster:
        engine = engine_again(results, study.system, study.seed, cluster)
        print_run(study, folder, as_json, lambda watcher: run_study(study, folder, watcher, threads, (), engine))


def _resume_contest(results: Path, budget: int | None, threads: int | None, as_json: bool) -> None:
    from tuner.cli.contest import print_contest
    from tuner.experiments.contest.resume import reopen_contest

    contest, folder = reopen_contest(results, budget)
    print_contest(contest, folder, threads, as_json)


def _resume_inference(results: Path, budget: int | None, threads: int | None, as_json: bool) -> None:
    from tuner.cli.inference import print_inference
    from tuner.experiments.inference.resume import reopen_inference

    inference, folder = reopen_inference(results, budget)
    print_inference(inference, folder, threads, as_json)
