"""Commands that tune: run, resume, rejudge, verify."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer

import tuner
from plant.texts import PlainTable
from tuner.cli.answer import answer, progress
from tuner.cli.app import AsJson, Folder, StudyChanges, StudyFile, Threads, app, option_of, parse_changes, study_option
from tuner.cli.printing import RunAnswer
from tuner.experiments.options import ResumeOptions, RunOptions, with_options
from tuner.extension import find
from tuner.report.charts import printer
from tuner.text.errors import BROKEN, NOTHING_FEASIBLE


@app.command()
@with_options(RunOptions, option_of)
def run(
    study: StudyFile,
    out: Annotated[Path | None, typer.Option(help="Results folder; must not exist. Default: results/NAME.")] = None,
    threads: Threads = None,
    change: StudyChanges = None,
    starts: Annotated[
        list[Path] | None,
        typer.Option(
            "--starts",
            help="Start the search from an earlier run, or a gains.json, of the same laws; repeatable. By default from the front "
            "of the laws that comes with the tool; --set search.starts=[] from none.",
        ),
    ] = None,
    live: Annotated[bool, typer.Option("--live", help="Show the run on a local page while it works.")] = False,
    as_json: AsJson = False,
    **options: Any,
) -> None:
    """Search gains, validate the finalists on held-out flights, write a report.

    Exit codes: 0 recommended, 2 bad input, 3 nothing feasible, 130 interrupted.

    Example: tuner run quickstart --out results/first --set search.generations=20
    """
    with ExitStack() as page:
        with printer.early():
            named: PlainTable = {"search.starts": list(map(str, starts))} if starts else {}
            loaded = tuner.load_study(study, parse_changes(change) | named)
            answered = RunAnswer(as_json, has_opinion=getattr(loaded, "present_gains", None) is not None)
            if live:
                from tuner.experiments.experiment import default_folder

                page.enter_context(find("companions", "page of a run", "live")(out or default_folder(loaded)))
            with progress(as_json, answer=answered) as watcher:
                result = tuner.run(loaded, out, watcher=watcher, threads=threads, **options)
        answered.end(result, 0 if result.feasible else NOTHING_FEASIBLE)


@app.command()
@with_options(ResumeOptions, option_of)
def resume(results: Folder, as_json: AsJson = False, **options: Any) -> None:
    """Resume an interrupted run; results are bit-identical.

    Example: tuner resume results/quickstart --budget 30
    """
    answered = RunAnswer(as_json)
    with printer.early(), progress(as_json, answer=answered) as watcher:
        result = tuner.resume(results, watcher=watcher, **options)
    answered.end(result, 0 if result.feasible else NOTHING_FEASIBLE)


@app.command()
def verify(
    results: Folder,
    sample: Annotated[
        int | None, typer.Option(help="Number of random candidates to re-simulate; default: all.", min=1)
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Re-simulate a run and compare every file bit by bit.

    Exit code 1 where anything but the last digits of margins differs.

    Example: tuner verify results/quickstart --sample 20
    """
    with progress(as_json) as watcher:
        result = tuner.verify(results, sample=sample, watcher=watcher, threads=threads)
    answer(result, as_json, 0 if result.same else BROKEN)


@app.command()
def rejudge(
    results: Folder,
    out: Annotated[Path, typer.Option(help="Results folder to write; must not exist.", show_default=False)],
    study: Annotated[Path | None, study_option("Judge by this study; default: that of the run.")] = None,
    change: StudyChanges = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Re-evaluate recorded flights under other objectives, risks or limits.

    Example: tuner rejudge results/quickstart --set objective.0.level=0.9 --out results/cvar90
    """
    answered = RunAnswer(as_json)
    with progress(as_json, answer=answered) as watcher:
        result = tuner.rejudge(
            results, out, study=study, changes=parse_changes(change), watcher=watcher, threads=threads
        )
    answered.end(result, 0 if result.feasible else NOTHING_FEASIBLE)
