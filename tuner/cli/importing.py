"""`tuner import`: the gains that a vehicle flies already, from its parameter file, as a gains.json."""

import json
import sys
from pathlib import Path

from plant.airframes import load
from plant.errors import StoreError
from plant.gains import gain_addresses
from tuner.cli.tables import say_files
from tuner.cli.terminal import Console
from tuner.exchange.registry import importer as find_importer
from tuner.exchange.target import settings_of
from tuner.gains import to_document


def import_command(
    parameters: Path, source: str, airframe: str, out: Path, firmware: str | None, options: list[str], as_json: bool
) -> None:
    """Read, write gains.json, say what was assumed."""
    if out.exists():
        raise StoreError(f"{out} exists already and was not touched; choose another file with --out")
    importer = find_importer(source)
    given = [*options, *([f"firmware={firmware}"] if firmware is not None else [])]
    imported = importer.read(parameters, load(airframe), settings_of(importer, given))
    document = to_document(imported.controller, {})
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise StoreError(f"{out} cannot be written ({error.strerror}); choose another file with --out") from error
    if as_json:
        found = {key: document[key] for key in ("gains", "vehicle") if key in document}
        rest = {"untouched": list(imported.untouched), "notes": list(imported.notes), "file": str(out)}
        print(json.dumps({**found, **rest}, indent=2))
        return
    console = Console(soft_wrap=not sys.stdout.isatty())
    for gain in gain_addresses(imported.controller.cascade):
        console.print(f"{gain.address:>12} {imported.controller.gains[gain.column]:10.5g} {gain.unit}", highlight=False)
    for note in imported.notes:
        console.print(f"- {note}", highlight=False)
    say_files(console, Wrote=out)
    console.print(f'In a study: [controller] default = "{out.name}"', highlight=False)
    if imported.controller.vehicle is not None:
        back = f"tuner export results/STUDY/gains.json --to {source} --previous {parameters}"
        console.print(f"What a study then changes on the vehicle: {back}", highlight=False, soft_wrap=True)
