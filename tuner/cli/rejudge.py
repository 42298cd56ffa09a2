"""`tuner rejudge`: the flights of a run, judged in another way."""

from pathlib import Path

from tuner.cli.commands import overrides, print_run


def rejudge_command(
    results: Path, out: Path, study: Path | None, changes: list[str], threads: int | None, as_json: bool
) -> None:
    """Judge the candidates of a run again and print what is found."""
    from tuner.experiments.again.rejudge import rejudge

    print_run(lambda watcher: rejudge(results, out, study, overrides(changes), watcher, threads=threads), as_json)
