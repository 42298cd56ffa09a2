"""`tuner sensitivity`: which gains decide an objective, and how much of it is turbulence."""

import json
from contextlib import nullcontext
from pathlib import Path
from time import perf_counter
from typing import Any

from objectives.problem import Problem
from tuner.analysis.sensitivity.analysis import Analysis
from tuner.analysis.sensitivity.design import checked_base
from tuner.analysis.sensitivity.document import FAILURE, outputs, sensitivity_document
from tuner.analysis.sensitivity.scales import RANK
from tuner.cli.display import TerminalWatcher
from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.experiments.sensitivity import Budget, budget, study_problem, study_sensitivity
from tuner.experiments.tuning.run import warm_up
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.kinds import load_tuning
from tuner.study.study import Study


def sensitivity_command(path: Path, samples: int, out: Path | None, threads: int | None, as_json: bool) -> None:
    """Sample, fly, print, and write tables and chart if a folder is given."""
    base = checked_base(samples)
    study = load_tuning(path, "tuner sensitivity")
    problem = study_problem(study, threads)
    folder = None if out is None else Folder.create(out, inside="figures")
    with folder or nullcontext():
        begin = perf_counter()
        if as_json:
            warm_up(problem, study, Watcher())
            analysis = study_sensitivity(problem, study, base)
        else:
            analysis = watched(problem, study, base)
        document = sensitivity_document(study, analysis, perf_counter() - begin)
        if folder is not None:
            write(study, analysis, document, folder)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
        return
    show(study, analysis, document, Console())
    if folder is not None:
        print(f"Tables and chart: {folder.path}")


def watched(problem: Problem, study: Study, base: int) -> Analysis:
    """Analyse with a progress display; what it will take is said first."""
    console = Console()
    with TerminalWatcher(console) as bar:
        warm_up(problem, study, bar)
        expected = budget(problem, study, base)
        console.print(announced(study, expected, base, problem.flyer.threads), highlight=False)
        bar.on_stage("Sampling", expected.flights)
        return study_sensitivity(problem, study, base, bar.on_flights_done)


def announced(study: Study, expected: Budget, base: int, threads: int) -> str:
    """Return the sentence on what is about to be flown."""
    flights = sum(entry.search for entry in study.scenarios)
    return (
        f"{base} base samples of {len(study.space.variables)} variables: {expected.candidates:,} candidates, "
        f"{flights} search scenarios each, {expected.flights:,} flights, about {expected.seconds:.0f} s on {threads} threads "
        f"(seed {study.seed})."
    )


def write(study: Study, analysis: Analysis, document: dict[str, Any], folder: Folder) -> None:
    """Write sensitivity.json, indices.csv, variance.csv, samples.csv and figures/sensitivity.png and .pdf."""
    from tuner.analysis.sensitivity.document import index_table, sample_table, variance_table
    from tuner.report.sensitivity_figure import write_figure

    folder.write_json("sensitivity.json", document)
    folder.write_table("indices.csv", index_table(study, analysis))
    folder.write_table("variance.csv", variance_table(study, analysis))
    folder.write_table("samples.csv", sample_table(study, analysis))
    write_figure(study, analysis, folder.path)
    folder.written("figures/*")
    folder.seal()


def show(study: Study, analysis: Analysis, document: dict[str, Any], console: Console) -> None:
    """Print both tables and the notes."""
    for q, output in enumerate(outputs(study)):
        if analysis.indices[RANK].total.value[q].any():
            console.print(index_table_of(study, analysis, q, output))
    console.print(variance_table_of(document["variance"]))
    for note in document["notes"]:
        console.print(f"Note: {note}", style="yellow", highlight=False)
    console.print(f"{document['flights']:,} flights in {document['seconds']:.1f} s.", highlight=False)


def index_table_of(study: Study, analysis: Analysis, output: int, name: str) -> Table:
    """Return the indices of one output, the variable that decides most first."""
    what = name if name == FAILURE else f"rank of {name}"
    table = Table(f"{what}: shares of its variance, 95 % intervals", keys=1)
    table.add_column("variable", no_wrap=True)
    for heading in ("alone (first order)", "with all others (total)"):
        table.add_column(heading, justify="right", no_wrap=True)
    orders = analysis.indices[RANK]
    for i in (-orders.total.value[output]).argsort(kind="stable"):
        cells = [
            f"{spans.value[output, i]:.2f} [{spans.low[output, i]:.2f}, {spans.high[output, i]:.2f}]"
            for spans in orders
        ]  # fmt: skip
        table.add_row(study.space.variables[i].name, *cells)
    return table


def variance_table_of(rows: list[dict[str, Any]]) -> Table:
    """Return what gains and air make of the variance of each metric."""
    count = rows[0]["candidates"]
    title = f"Variance of a single flight's metric, over {count:,} samples that completed every flight [%]"
    table = Table(title, keys=1)
    table.add_column("metric of", no_wrap=True)
    for heading in ("gains", "scenario", "gains x scenario", "turbulence: the last two"):
        table.add_column(heading, justify="right")
    for row in rows:
        parts = row["components_percent"]
        cells = ["-"] * 4 if parts is None else [f"{x:.1f}" for x in (*parts.values(), row["turbulence_percent"])]
        table.add_row(row["objective"], *cells)
    return table
