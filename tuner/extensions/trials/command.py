"""Commands for a study whose trials another program makes: ask, tell."""

import sys
from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.app import Folder, StudyFile, app
from tuner.text.errors import NOTHING_FEASIBLE, USER_ERROR


@app.command()
def ask(
    study: StudyFile,
    out: Annotated[Path | None, typer.Option(help="Results folder, new or started. Default: results/NAME.")] = None,
    count: Annotated[int | None, typer.Option(help="Maximum number of lines; default: all pending.", min=1)] = None,
    command: Annotated[
        str | None, typer.Option("--run", help="Program that answers each line, until all results are in.")
    ] = None,
    timeout: Annotated[float | None, typer.Option(help="Time limit of a trial [s].", min=0.001)] = None,
) -> None:
    """Print pending trials as JSON lines; repeatable.

    Prints nothing once all results are in; front, report and gains.json are then in the folder. Exit codes as of `tuner run`.

    Example: tuner ask my_bench.toml --out results/bench > trials.jsonl

    Example: tuner ask my_bench.toml --run "python my_sim.py" --timeout 60
    """
    lacking = tuner.ask(study, out, command=command, timeout=timeout)
    for line in lacking.lines[:count]:
        print(line)
    sys.stdout.flush()
    print(lacking.words, file=sys.stderr)
    if lacking.is_concluded and not tuner.open_results(lacking.path).feasible:
        raise typer.Exit(NOTHING_FEASIBLE)


@app.command()
def tell(
    results: Folder,
    file: Annotated[Path, typer.Argument(help="Lines of JSON; - for standard input.", show_default=False)] = Path("-"),
) -> None:
    """Submit trial results as JSON lines.

    Each line has the trial's id and its metrics, or that it failed. A line that cannot be used is refused on
    standard error; the exit code is then 2.

    Example: tuner tell results/bench answers.jsonl
    """
    taken = tuner.tell(results, file)
    for error in taken.rejected:
        print(f"Refused: {error}", file=sys.stderr)
    print(taken.words, file=sys.stderr)
    if taken.rejected:
        raise typer.Exit(USER_ERROR)
