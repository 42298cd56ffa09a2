"""A contest from beginning to end: tune who is to be tuned, fly all through the same air, compare, write everything down."""

from pathlib import Path
from time import perf_counter

from plant.backends.flyer import available_threads
from plant.input_files import read_input_text
from plant.scenarios import HELD_OUT
from tuner.experiments.contest.document import contest_document
from tuner.experiments.contest.flying import fly_groups
from tuner.experiments.contest.records import response_tables, wind_table
from tuner.experiments.contest.result import Result, groups_of, judge_contest
from tuner.experiments.contest.tables import fronts_table, listed_table, scores_table
from tuner.experiments.contest.tuning import Prepared, prepare
from tuner.experiments.tuning.guards.before import few_scenarios
from tuner.experiments.tuning.run import warm_up
from tuner.search.watcher import COMPARING, Watcher
from tuner.store.advice import CONTEST
from tuner.store.environment import environment, with_session
from tuner.store.folder import Folder
from tuner.store.inputs import freeze
from tuner.study.contest import Contest


def run_contest(contest: Contest, folder: Folder, watcher: Watcher, threads: int | None = None) -> Result:
    """Run a contest into a results folder; what a finished contender left there is kept whatever happens later."""
    begin = perf_counter()
    write_inputs(contest, folder, threads or available_threads())
    prepared = prepare_all(contest, folder, watcher, threads)
    for own in prepared:
        warm_up(own.entry.problem, own.contender.study, watcher)
    groups = groups_of(prepared)
    watcher.on_stage(COMPARING, contest.flights_each * sum(map(len, groups)))
    flown = fly_groups(contest, groups, threads, watcher.on_flights_done)
    result = judge_contest(contest, prepared, flown, perf_counter() - begin)
    write_result(result, folder, watcher)
    folder.seal()
    return result


def write_inputs(contest: Contest, folder: Folder, threads: int) -> None:
    """Write what the contest starts from: the file as given, and every value of every contender's study."""
    if not folder.keep("study.toml"):
        folder.write_text("study.toml", read_input_text(contest.path))
    folder.write_json("resolved.json", {entry.name: entry.study.resolved() for entry in contest.contenders})
    folder.write_json("environment.json", with_session(folder.path / "environment.json", environment(threads)))
    freeze(folder, CONTEST, contest.path, contest.table, contest.digest(), None)


def prepare_all(contest: Contest, folder: Folder, watcher: Watcher, threads: int | None) -> list[Prepared]:
    """Tune every contender that has something to tune, one after the other."""
    prepared = []
    for number, contender in enumerate(contest.contenders):
        if contender.tuned:
            watcher.on_contender(contender.name, number + 1, len(contest.contenders))
        prepared.append(prepare(contest, contender, folder, watcher, threads))
    return prepared


def warnings_of(result: Result) -> list[str]:
    """Return what a reader must know before believing the numbers."""
    common = few_scenarios(result.contest.base)
    tuned = [own for own in result.prepared if own.contender.tuned]
    warnings = [text for text in common if tuned or HELD_OUT in text]
    warnings += [f"{own.contender.name}: {text}" for own in tuned for text in own.warnings if text not in common]
    warnings += broken_again(result)
    if len({own.contender.study.search for own in tuned}) > 1:
        warnings.append("The contenders were not tuned with the same budget; see budget in contest.json.")
    given = [own.contender.name for own in result.prepared if not own.contender.tuned]
    if tuned and given:
        warnings.append(f"Flown as given, beside contenders that were tuned: {', '.join(given)}.")
    return warnings


def broken_again(result: Result) -> list[str]:
    """Say how many points of a held-out front broke a constraint on the flights of the comparison, and count no longer."""
    return [
        f"{own.contender.name}: on the confirmation flights {front.broken} of the {len(own.offered)} points of its "
        "held-out front break a constraint and count no longer; raise held_out, or ask for a reserve."
        for own, front in zip(result.prepared, result.fronts, strict=False)
        if own.offered is not None and front.broken
    ]


def write_result(result: Result, folder: Folder, watcher: Watcher) -> None:
    """Write numbers, tables, responses, figures and report."""
    document = contest_document(result, warnings_of(result))
    folder.write_table("scores.parquet", scores_table(result))
    folder.write_table("differences.csv", listed_table(document["differences"]))
    if result.cells:
        folder.write_table("published.csv", listed_table(document["published"]))
    if result.fronts:
        folder.write_table("fronts.csv", fronts_table(result))
    watcher.on_writing("responses")
    fans, traces = response_tables(result)
    folder.write_table("responses.parquet", fans)
    folder.write_table("traces.parquet", traces)
    folder.write_table("wind.parquet", wind_table(result))
    folder.write_json("contest.json", document)
    write_report(folder.path, watcher)
    folder.written("report.html", "figures/*")


def write_report(folder: Path, watcher: Watcher) -> None:
    """Write figures and report of a contest's folder."""
    from tuner.report.contest import write_contest_figures, write_contest_report

    watcher.on_writing("figures")
    write_contest_figures(folder)
    watcher.on_writing("report")
    write_contest_report(folder)


def default_folder(contest: Contest) -> Path:
    """Return the folder a contest's results go to unless another is given: results/NAME."""
    return Path("results") / contest.path.stem
