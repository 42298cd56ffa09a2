"""`tuner sensitivity`: which gains decide an objective, and how much of it is turbulence."""

import json
from pathlib import Path
from typing import Any

from tuner.analysis.sensitivity.analysis import Analysis
from tuner.analysis.sensitivity.document import FAILURE, outputs
from tuner.analysis.sensitivity.scales import RANK
from tuner.cli.display import TerminalWatcher
from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.experiments.sensitivity import analyse_sensitivity
from tuner.search.watcher import Watcher
from tuner.study.kinds import load_tuning
from tuner.study.study import Study


def sensitivity_command(path: Path, samples: int, out: Path | None, threads: int | None, as_json: bool) -> None:
    """Sample, fly, print, and write tables and chart if a folder is given."""
    study = load_tuning(path, "tuner sensitivity")
    if as_json:
        found = analyse_sensitivity(study, samples, out, Watcher(), threads)
        print(json.dumps(found.document, indent=2, allow_nan=False))
        return
    console = Console()
    with TerminalWatcher(console) as watcher:
        found = analyse_sensitivity(study, samples, out, watcher, threads)
    show(study, found.analysis, found.document, console)
    if out is not None:
        print(f"Tables and chart: {out}")


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
