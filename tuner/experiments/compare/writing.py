"""The folder of a comparison: numbers, tables, figures and one offline page; the form is that of a contest's folder."""

from pathlib import Path
from typing import Any

from plant.backends.flyer import available_threads
from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.experiments.contest.records import response_tables, wind_table
from tuner.experiments.contest.result import Result
from tuner.experiments.contest.tables import fronts_table, listed_table, scores_table
from tuner.search.watcher import Watcher
from tuner.store.environment import environment
from tuner.store.folder import Folder

DOCUMENT = "comparison.json"


def check_free(out: Path) -> None:
    """Refuse a folder that exists, before anything flies."""
    if out.exists():
        raise StoreError(
            f"{out} exists already and nothing in it was touched; choose another folder with --out, or remove it"
        )


def write_comparison(
    out: Path, result: Result, document: dict[str, Any], threads: int | None, watcher: Watcher
) -> None:
    """Write everything that a comparison found into a folder that does not exist yet."""
    check_free(out)
    with Folder.create(out, inside="figures") as folder:
        write_files(folder, result, document, threads, watcher)


def write_files(
    folder: Folder, result: Result, document: dict[str, Any], threads: int | None, watcher: Watcher
) -> None:
    """Write the files of a comparison into its folder."""
    from tuner.report.contest import write_contest_figures, write_contest_report
    from tuner.report.values_figure import write_values_figure

    folder.write_text("study.toml", read_input_text(result.contest.path))
    folder.write_json("environment.json", environment(threads or available_threads()))
    folder.write_table("scores.parquet", scores_table(result))
    folder.write_table("differences.csv", listed_table(document["differences"]))
    if result.fronts:
        folder.write_table("fronts.csv", fronts_table(result))
    watcher.on_writing("responses")
    fans, traces = response_tables(result)
    folder.write_table("responses.parquet", fans)
    folder.write_table("traces.parquet", traces)
    folder.write_table("wind.parquet", wind_table(result))
    folder.write_json(DOCUMENT, document)
    watcher.on_writing("figures")
    write_contest_figures(folder.path)
    write_values_figure(folder.path)
    watcher.on_writing("report")
    write_contest_report(folder.path)
    folder.written("report.html", "figures/*")
    folder.seal()
