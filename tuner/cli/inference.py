"""What `tuner run` prints of an inference: a contest with unknowns."""

import json
from typing import TYPE_CHECKING, Any

from plant.input_files import read_input_text
from tuner.cli.tables import Table, say_files
from tuner.cli.terminal import Console
from tuner.text.numbers import significant

if TYPE_CHECKING:
    from tuner.experiments.registry import CompletedRun


def print_inference(done: "CompletedRun", console: Console) -> None:
    """Print what an inference found."""
    findings = done.found
    document = json.loads(read_input_text(done.document))
    console.print(cells_table(document))
    console.print(unknowns_table(document))
    for sentence in document["words"]:
        console.print(f"- {sentence}", highlight=False)
    console.print(f"{findings.flights:,} flights in {findings.seconds:.1f} s.", highlight=False)
    say_files(console, Figure=done.path / "figures" / "inference.png", Study=done.path / "inferred.toml")


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
