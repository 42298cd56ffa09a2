"""`tuner run` and `tuner check` of an inference: a contest with unknowns."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plant.input_files import read_input_text
from tuner.cli.display import TerminalWatcher
from tuner.cli.tables import Table, say_files
from tuner.cli.terminal import Console
from tuner.search.watcher import Watcher
from tuner.study.inference_reading import load_inference
from tuner.text.numbers import significant

if TYPE_CHECKING:
    from tuner.store.folder import Folder
    from tuner.study.inference import Inference


def run_inference_command(
    study: Path, out: Path | None, threads: int | None, changes: dict[str, Any], as_json: bool
) -> None:
    """Infer the unknowns and print cells, unknowns and what they say."""
    asked = load_inference(study, changes)
    from tuner.experiments.inference.run import default_folder
    from tuner.store.folder import Folder

    folder = Folder.create(out or default_folder(asked))
    print_inference(asked, folder, threads, as_json)


def print_inference(asked: "Inference", folder: "Folder", threads: int | None, as_json: bool) -> None:
    """Infer in a folder with progress on the terminal and print what it found, or its document as JSON."""
    from tuner.experiments.inference.run import run_inference

    if as_json:
        with folder:
            run_inference(asked, folder, Watcher(), threads)
        print(read_input_text(folder.path / "inference.json"))
        return
    console = Console()
    console.print(f"{asked.contest.title}  (seed {asked.contest.seed})", style="bold", highlight=False)
    with folder, TerminalWatcher(console) as watcher:
        findings = run_inference(asked, folder, watcher, threads)
    document = json.loads(read_input_text(folder.path / "inference.json"))
    console.print(cells_table(document))
    console.print(unknowns_table(document))
    for sentence in document["words"]:
        console.print(f"- {sentence}", highlight=False)
    console.print(f"{findings.flights:,} flights in {findings.seconds:.1f} s.", highlight=False)
    say_files(console, Figure=folder.path / "figures" / "inference.png", Study=folder.path / "inferred.toml")


def check_inference(path: Path) -> dict[str, Any]:
    """Return what an inference would fly; InputError where it is wrong."""
    asked = load_inference(path)
    search = asked.contest.base.search
    flown = {(cell.contender, cell.scenario) for cell in asked.cells}
    return {
        "title": asked.contest.title,
        "contenders": [contender.name for contender in asked.contest.contenders],
        "unknowns": [unknown.variable.name for unknown in asked.unknowns],
        "cells": [cell.label for cell in asked.cells],
        "search_flights": search.population * search.generations * len(flown) * asked.flights,
    }


VERDICTS = (("yes", "inside"), ("near by", "consistent"), ("elsewhere", "reproducible"), ("never", "published"))
"""What the table says of a cell: the first whose key holds."""


def cells_table(document: dict[str, Any]) -> Table:
    """Return published beside ours."""
    held_out = document["settings"]["held_out"]
    table = Table(f"Published cells and {held_out} held-out flights at the inferred setting")
    for name in ("cell", "published", "median", "95 % of ours", "inside"):
        table.add_column(name, justify="left" if name == "cell" else "right", no_wrap=name != "cell")
    for row in document["cells"]:
        ours = row["ours"]
        span = f"{significant(ours['low95'], 3)}–{significant(ours['high95'], 3)}"
        inside = next(word for word, key in VERDICTS if row[key])
        name = f"{row['contender']} {row['metric']} {row['unit']}"
        table.add_row(name, significant(row["published"]), significant(ours["median"], 3), span, inside)
    return table


def unknowns_table(document: dict[str, Any]) -> Table:
    """Return the unknowns with their ranges."""
    table = Table("Unknowns")
    for name in ("", "inferred", f"within {100 * document['settings']['near']:g} %", "one draw leaves", "told"):
        table.add_column(name, justify="left" if name == "" else "right", no_wrap=name != "")
    for row in document["unknowns"]:
        spans = [
            f"{significant(row[low], 2)}–{significant(row[high], 2)}"
            for low, high in (("near_low", "near_high"), ("low68", "high68"))
        ]
        verdict = {"told": "yes", "loosely": "partly", "not": "no"}[row["verdict"]]
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        table.add_row(f"{row['name']}{unit}", significant(row["inferred"], 2), *spans, verdict)
    return table
