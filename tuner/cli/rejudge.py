"""`tuner rejudge`: the flights of a run, judged in another way."""

from pathlib import Path

from tuner.cli.commands import overrides, print_run


def rejudge_command(
    results: Path, out: Path, study: Path | None, changes: list[str], threads: int | None, as_json: bool
) -> None:
    """Judge the candidates of a run again and print what is found."""
    from tuner.experiments.again.rejudge import judging_study, rejudge
    from tuner.store.folder import Folder

    first, asked = judging_study(results, study, overrides(changes))
    folder = Folder.create(out)
    print_run(asked, folder, as_json, lambda watcher: rejudge(results, first, asked, folder, watcher, threads))
