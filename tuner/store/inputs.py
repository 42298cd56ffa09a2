"""What a run starts from, kept so that it can be continued anywhere: run.json, and inputs/ with the study and its files.

inputs/NAME.toml is the study with every change of the command line in it and with paths to copies beside it; run alone, it
gives the same results.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from objectives.engine import LANES
from objectives.memory import model_key
from plant.backends.processor import Arithmetic, Processor, arithmetic, compute_as
from plant.errors import StoreError
from plant.input_files import MOST_TABLE, read_input, read_input_text
from tuner.store.advice import RECORD, again
from tuner.store.folder import Folder
from tuner.text.paths import with_paths
from tuner.text.toml_text import toml_text

FORMAT, VERSION = "holdfast-run", 2
# Version of folders whose limits known without flying stand in the units of the study, not in SI units.
BEFORE_SI = 1


@dataclass(frozen=True)
class RunRecord:
    """kind: of study. study: its file in the folder. digest: of all that decides the result. generations: asked for; None
    where a study has no such number. model: `model_key` of the flights. arithmetic: of the engine that makes them. machine:
    what its kernels were compiled for and its draws made with; None where an earlier version did not say. si: whether limits
    known without flying stand in its files in SI units; before, they stood there in the units of the study.
    """

    kind: str
    study: Path
    digest: str
    generations: int | None
    model: str
    arithmetic: str = LANES
    machine: Arithmetic | None = None
    si: bool = True


def freeze(
    folder: Folder, kind: str, source: Path, table: dict[str, Any], digest: str, generations: int | None,
    engine: str = LANES, si: bool = True,
) -> None:  # fmt: skip
    """Write the inputs of a run, table: content of the study with paths from the folder of `source`; run.json comes last."""
    name = f"inputs/{source.stem}.toml"
    if folder.keep(name):
        for copy in sorted((folder.path / "inputs").iterdir()):
            folder.keep(f"inputs/{copy.name}")
    else:
        taken = {f"{source.stem}.toml": source}
        folder.write_text(name, toml_text(with_paths(table, lambda path: _copied(folder, source.parent / path, taken))))
    write_record(folder, RunRecord(kind, Path(name), digest, generations, model_key(), engine, arithmetic(), si))


def write_record(folder: Folder, record: RunRecord) -> None:
    """Write run.json."""
    folder.write_json(
        RECORD,
        {
            "format": FORMAT,
            "version": VERSION if record.si else BEFORE_SI,
            "kind": record.kind,
            "study": record.study.as_posix(),
            "digest": record.digest,
            "generations": record.generations,
            "model": record.model,
            "arithmetic": record.arithmetic,
            **({} if record.machine is None else {"machine": _told(record.machine)}),
        },
    )


def read_record(path: Path) -> RunRecord:
    """Read the run.json of a results folder; StoreError where it is missing or damaged."""
    if not path.is_dir():
        raise StoreError(f"{path}: there is no such results folder; give a folder that `tuner run` wrote")
    try:
        content = json.loads(read_input_text(path / RECORD))
        if content["format"] != FORMAT or content["version"] not in (VERSION, BEFORE_SI):
            raise ValueError
        generations = content["generations"]
        if not (generations is None or isinstance(generations, int)):
            raise ValueError
        texts = [content[key] for key in ("kind", "study", "digest", "model")] + [content.get("arithmetic", LANES)]
        if not all(isinstance(text, str) for text in texts):
            raise ValueError
        machine = _read_machine(content["machine"]) if "machine" in content else None
    except FileNotFoundError:
        nothing = not (path / "flights").exists()
        what = "nothing was recorded yet, so remove it and run the study again" if nothing else again(path)
        raise StoreError(f"{path} holds no {RECORD}, so it cannot be continued; {what}") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise StoreError(f"{path / RECORD} is damaged; {again(path)}") from None
    kind, study, digest, model, engine = texts
    return RunRecord(kind, Path(study), digest, generations, model, engine, machine, content["version"] == VERSION)


def _told(machine: Arithmetic) -> dict[str, str]:
    return {**machine.processor._asdict(), "libraries": machine.libraries}


def _read_machine(content: dict[str, Any]) -> Arithmetic:
    name, features, libraries = (content[key] for key in ("name", "features", "libraries"))
    if not (re.fullmatch(r"[\w.-]{1,60}", name) and re.fullmatch(r"([+-][\w.-]{1,60}(,|$))*", features)):
        raise ValueError
    if not (libraries.isprintable() and len(libraries) < 200):
        raise ValueError
    return Arithmetic(Processor(name, features), libraries)


def check_unchanged(path: Path, record: RunRecord, digest: str) -> None:
    """Refuse to go on with a run whose study or model is no longer what it was."""
    if digest != record.digest:
        raise StoreError(
            f"{path / record.study} is not what the run began with, or this version reads it in another way; {again(path)}"
        )
    if model_key() != record.model:
        raise StoreError(
            f"{path} was flown with another version of the model or of its compilers, whose bits may differ; "
            f"run the study again, or use the version named in {path / 'environment.json'}"
        )


def compute_as_recorded(path: Path, record: RunRecord, instead: str | None = None) -> None:
    """Have this process compute with the arithmetic of a run, which it keeps to the end; StoreError where it cannot.

    instead: what else can be done, by default to have the run computed anew.
    """
    try:
        if record.machine is not None:
            compute_as(record.machine)
    except StoreError as error:
        raise StoreError(
            f"{path} was computed on another machine ({record.machine.label if record.machine else ''}): {error}; go on "
            f"there, or {instead or f'have all of it computed anew for this machine with `tuner resume {path} --here`'}"
        ) from None


def _copied(folder: Folder, source: Path, taken: dict[str, Path]) -> str:
    """Copy a file that a study names into inputs/ and return its name there; taken: what lies there, by name."""
    name, number = source.name, 1
    while taken.setdefault(name, source) != source:
        number += 1
        name = f"{source.stem}-{number}{source.suffix}"
    try:
        content = read_input(source, MOST_TABLE)
    except OSError as error:
        raise StoreError(f"{source} cannot be read ({error.strerror})") from None
    folder.write_bytes(f"inputs/{name}", content)
    return name
