"""`tuner resume`: go on with a run of any kind."""

from pathlib import Path

from tuner.cli.commands import print_run


def resume_command(
    results: Path, budget: int | None, threads: int | None, as_json: bool, dask: str | None = None, here: bool = False
) -> None:
    """Go on with a run and print what it found."""
    from tuner.experiments.again.resume import resume

    print_run(lambda watcher: resume(results, watcher, threads=threads, budget=budget, dask=dask, here=here), as_json)
