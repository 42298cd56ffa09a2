"""`tuner resume`: go on with a run."""

from pathlib import Path

from tuner.cli.commands import print_run


def resume_command(results: Path, budget: int | None, threads: int | None, as_json: bool) -> None:
    """Go on with a tuning run or a contest and print what it found."""
    from tuner.contest.resume import reopen_contest
    from tuner.resume import reopen
    from tuner.run import run_study
    from tuner.store.inputs import CONTEST, read_record

    if read_record(results).kind == CONTEST:
        from tuner.cli.contest import print_contest

        contest, folder = reopen_contest(results, budget)
        print_contest(contest, folder, threads, as_json)
        return
    study, folder = reopen(results, budget)
    print_run(study, folder, as_json, lambda watcher: run_study(study, folder, watcher, threads))
