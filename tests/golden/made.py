"""Outputs of the commands of this checkout: documents, tables, JSON on standard output and help, ready for comparison."""

import contextlib
import json
import re
import shutil
import tomllib
import zipfile
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any, cast
from unittest.mock import patch

from typer.main import get_command

from tests.golden.steps import LOG, STUDIES, Step
from tests.tuner.in_process import called
from tests.undrawn import undrawn
from tuner.cli.main import app
from tuner.exchange.c99.golden import golden

ROOT = Path(__file__).parents[2]
FEW_ROWS = 2
"""Rows of a table that are kept, its first ones."""
LONG_LIST = 12
"""Entries of a list of numbers or names that are kept, its first ones."""

MASK = "<masked>"
MASKED = (
    # Times and speeds of this machine.
    "[a-z_]*seconds[a-z_]*",
    "[a-z_]*_per_s(econd)?",
    "memory_bytes",
    # Compressed files: their bytes follow the last bits of this machine's processor.
    "disk_bytes_at_most",
    "bench.json",
    # The machine, the libraries and the code.
    "environment.json",
    "run.json.machine",
    "start.json.machine",
    "run.json.model",
    "run.json.arithmetic",
    "threads",
    "commit",
    "generator.version",
    "stages.json.steps.key",
    "version of the product",
    # Whether the kernel was compiled before.
    "check-study.json.json.plant_step",
    # What follows from any of them, to the last bit.
    "[a-z_]*sha256",
    "digest",
    "manifest.json.files",
    "export.json.files",
    "export-[a-z0-9]+.json.json.files",
)
"""Names or paths, as regular expressions, below which values belong to a machine, an hour or a version: keys alone are compared."""
IS_MASKED = re.compile(rf"(?:.*[./])?(?:{'|'.join(MASKED)})(?:\..*)?")
REPLACED = (
    (re.compile(r"-[0-9a-f]{12,64}(?=\.npz)"), "-DIGEST"),
    (re.compile(r"(?<=from the gains )[0-9a-f]{64}|(?<=guid=\"\{)[0-9a-f-]{36}"), "DIGEST"),
    (re.compile(r"(?<=gainproof )\d+\.\d+\.\d+"), "VERSION"),
    (re.compile(re.escape(str(ROOT))), "REPOSITORY"),
)
"""Parts of names and texts that differ from machine to machine, and what stands for them."""


def commands() -> dict[str, Any]:
    """Return the commands of the console script by name."""
    return cast(Any, get_command(app)).commands


ELSEWHERE = frozenset({"confirm", "autotune"})
"""Commands that fly a firmware or take minutes, see tests/tuner/extensions/autopilots and tests/tuner/extensions/autotune/test_autotuning.py."""


def commands_with_json() -> set[str]:
    """Return the names of the commands that have --json and take seconds alone."""
    return {
        name for name, found in commands().items() if any("--json" in option.opts for option in found.params)
    } - ELSEWHERE


def help_texts() -> dict[str, str]:
    """Return the help of the application and of every command by the name of its file, at 80 columns."""
    asked = {"help/tuner.txt": (), **{f"help/{name}.txt": (name,) for name in sorted(commands())}}
    return {name: called(*arguments, "--help")[1] for name, arguments in asked.items()}


def documents(folder: Path, steps: Iterable[Step]) -> dict[str, Any]:
    """Run steps in a folder, which is made with the studies in it where there is none; return documents by name."""
    if not folder.exists():
        shutil.copytree(STUDIES, folder)
        shutil.copy(LOG, folder)
    made = {}
    # Not every machine has a compiler of C, and its bytes are its own.
    uncompiled = patch("tuner.extensions.fmi.archive.compiler", return_value=None)
    # Points a side of maps that are drawn and kept nowhere else: five of the nine seconds of margins.
    coarse = patch("tuner.analysis.margins.mismatch.POINTS", 3)
    # Vectors of bundles are kept nowhere either.
    few = patch("tuner.exchange.c99.export.golden", partial(golden, steps=16))
    with contextlib.chdir(folder), undrawn(), uncompiled, coarse, few:
        for step in steps:
            code, said, told = called(*step.arguments)
            answer = {"command": " ".join(("tuner", *step.arguments)), "exit": code}
            made[f"json/{step.name}.json"] = answer | ({"json": json.loads(said)} if said else {"error": told})
            made |= {} if step.folder is None else results(step.name, Path(step.folder))
    return {portable(name, folder): comparable(document, name, folder) for name, document in made.items()}


def results(run: str, folder: Path) -> dict[str, Any]:
    """Return the documents and tables of a results folder and the names of its files, as `results/RUN/FILE.json`."""
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    found = {name: READERS[Path(name).suffix](folder / name) for name in names if Path(name).suffix in READERS}
    documents = {f"results/{run}/{name.removesuffix('.json')}.json": document for name, document in found.items()}
    return {**documents, f"results/{run}/names.json": dict.fromkeys(names, "file")}


def table(path: Path) -> dict[str, Any]:
    """Return columns with their kinds, the number of rows and the first of them."""
    from tuner.documents.tables import read_frame

    frame = read_frame(path)
    kinds = {"f": "float", "i": "int", "u": "int", "b": "bool"}
    first = json.loads(frame.head(FEW_ROWS).to_json(orient="records", double_precision=15) or "[]")
    return {
        "columns": {str(name): kinds.get(kind.kind, "text or list") for name, kind in frame.dtypes.items()},
        "rows": len(frame),
        "first": first,
    }


def mock_up(path: Path) -> dict[str, Any]:
    """Return the names of the files in an FMU and what a simulator reads of it first."""
    with zipfile.ZipFile(path) as archive:
        description = archive.read("modelDescription.xml").decode()
        return {"files": sorted(archive.namelist()), "modelDescription.xml": description.splitlines()}


READERS = {
    ".fmu": mock_up,
    ".json": lambda path: json.loads(path.read_text(encoding="utf-8")),
    ".toml": lambda path: tomllib.loads(path.read_text(encoding="utf-8")),
    ".csv": table,
    ".npz": table,
}
"""Suffix -> how its files are read."""


def comparable(value: Any, path: str, work: Path) -> Any:
    """Return a document with long lists cut and what belongs to a machine masked; work: the folder that stands as WORK."""
    if isinstance(value, dict):
        made = {portable(key, work): comparable(entry, f"{path}.{key}", work) for key, entry in value.items()}
        return dict(sorted(made.items())) if path.endswith("manifest.json.files") else made
    if IS_MASKED.fullmatch(path):
        return MASK
    if isinstance(value, list):
        return [comparable(entry, path, work) for entry in shortened(value)]
    return portable(value, work) if isinstance(value, str) else value


def shortened(entries: list[Any]) -> list[Any]:
    """Return the first entries of a long list, and a sentence that says how many there were; rows with names stay whole."""
    if len(entries) <= LONG_LIST or any(isinstance(entry, dict | str) for entry in entries):
        return entries
    return [*entries[:LONG_LIST], f"{len(entries)} entries in all"]


def portable(text: str, work: Path) -> str:
    """Return a text with digests and folders of this machine replaced."""
    text = text.replace(str(work), "WORK")
    for pattern, sign in REPLACED:
        text = pattern.sub(sign, text)
    return text
