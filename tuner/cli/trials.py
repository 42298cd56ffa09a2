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
    out: Annotated[Path | None, typer.Option(help="Results folder, begun or not. Default: results/NAME.")] = None,
    count: Annotated[int | None, typer.Option(help="Lines at most; by default all that are lacking.", min=1)] = None,
    command: Annotated[
        str | None, typer.Option("--run", help="Command line of a program that answers each line, until all is told.")
    ] = None,
    timeout: Annotated[
        float | None, typer.Option(help="Time that this program may take over a trial [s].", min=0.001)
    ] = None,
) -> None:
    """Print the trials that another program is to make next, a line of JSON each; asked twice, the same lines.

    Once all is told it prints nothing, and front, report and gains.json are in the folder. Exit codes as of `tuner run`.

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
    """Tell what trials gave, a line of JSON each with its id, and its metrics or that it failed.

    A line that cannot be used is refused, told on standard error and changes nothing; then the exit code is 2.

    Example: tuner tell results/bench answers.jsonl
    """
    taken = tuner.tell(results, file)
    for error in taken.rejected:
        print(f"Refused: {error}", file=sys.stderr)
    print(taken.words, file=sys.stderr)
    if taken.rejected:
        raise typer.Exit(USER_ERROR)
