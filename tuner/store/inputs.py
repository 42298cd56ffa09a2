"""Inputs of a run, stored for continuation anywhere: run.json, and inputs/ with study and files.

inputs/NAME.toml is the study with every change of the command line in it and with paths to copies next to it; run alone, it
gives the same results.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, model_validator

from objectives.engine import LANES
from objectives.memory import model_key
from plant.backends.processor import Arithmetic, Processor, arithmetic, compute_as
from plant.errors import StoreError
from plant.input_files import MAX_TABLE_BYTES, read_input, read_input_text
from plant.own_code import sources_of
from plant.texts import PlainTable, PlainValue
from tuner.store.advice import RECORD, restart_hint
from tuner.store.document import Document, DocumentPart, explained
from tuner.store.folder import Folder
from tuner.study.layers import read_layers
from tuner.text.product import READ_FORMER
from tuner.text.toml_text import toml_text, with_paths

FORMAT, VERSION = "gainproof-run", 5
# Version of folders whose limits known without flying stand in the units of the study, not in SI units.
BEFORE_SI = 1
# Versions of folders whose study may leave the plant step [s] and the search open, and what was flown then.
LEFT_OPEN = (1, 2)
FLOWN_THEN = {
    "controller": {"plant_step": 0.001},
    "search": {"algorithm": "nsga2", "population": 48, "generations": 15, "first": 1_000_000},
}
# Version from which on a folder's study names its starting points; one that named none began from none.
NAMES_STARTS, NO_STARTS = 4, {"search": {"starts": list[PlainValue]()}}


class RecordedMachine(DocumentPart):
    """Processor of the kernels, by name and features, and libraries that drew the air."""

    name: Annotated[str, Field(pattern=r"^[\w.-]{1,60}$")]
    features: Annotated[str, Field(pattern=r"^([+-][\w.-]{1,60}(,|$))*$")]
    libraries: Annotated[str, Field(max_length=199)]

    @model_validator(mode="after")
    def _printable(self) -> Self:
        if not self.libraries.isprintable():
            raise ValueError("'machine.libraries' holds signs that cannot be printed")
        return self

    @property
    def arithmetic(self) -> Arithmetic:
        """The arithmetic to compute with."""
        return Arithmetic(Processor(self.name, self.features), self.libraries)


class RunRecord(Document):
    """Content of run.json.

    Attributes:
        kind: Kind of study.
        study: Its file in the folder.
        digest: Digest of all that decides the result.
        generations: Generations that were asked for; None where a study has no such number.
        search_flights: Flights of each scenario in the search, where `resume` asked for more than the study.
        model: `model_key` of the flights.
        arithmetic: Arithmetic of the engine that makes them.
        machine: Machine that the kernels were compiled for and draws made with; None where an earlier version did not say.
    """

    format: Annotated[Literal["gainproof-run"], READ_FORMER]
    version: Literal[1, 2, 3, 4, 5]
    kind: str
    # In the folder, whatever it says: what is in it is not trusted to name files elsewhere.
    study: Annotated[str, Field(pattern=r"^inputs/[^/\\]+$")]
    digest: str
    generations: int | None
    search_flights: Annotated[int, Field(ge=1)] | None = None
    model: str
    arithmetic: str = LANES
    machine: RecordedMachine | None = None

    @property
    def si(self) -> bool:
        """Whether limits known without flying stand in the folder in SI units; before, they stood in the units of the study."""
        return self.version != BEFORE_SI


def freeze(
    folder: Folder,
    kind: str,
    source: Path,
    table: PlainTable,
    digest: str,
    generations: int | None,
    engine: str = LANES,
) -> None:
    """Write the inputs of a run, table: content of the study with paths from the folder of `source`; run.json comes last."""
    name, version, search_flights = f"inputs/{source.stem}.toml", VERSION, None
    if (folder.path / RECORD).exists() and folder.keep(name):
        earlier = read_record(folder.path)
        version, search_flights = earlier.version, earlier.search_flights
        for copy in sorted((folder.path / "inputs").iterdir()):
            folder.keep(f"inputs/{copy.name}")
    else:
        taken = {f"{source.stem}.toml": source}
        folder.write_text(name, toml_text(with_paths(table, lambda path: _copied(folder, source.parent / path, taken))))
    record = RunRecord(
        format=FORMAT,
        version=version,
        kind=kind,
        study=name,
        digest=digest,
        generations=generations,
        search_flights=search_flights,
        model=model_key(),
        arithmetic=engine,
        machine=RecordedMachine(**arithmetic().processor._asdict(), libraries=arithmetic().libraries),
    )
    folder.write_json(RECORD, record)


def read_record(path: Path) -> RunRecord:
    """Read the run.json of a results folder; StoreError where it is missing or damaged."""
    if not path.is_dir():
        raise StoreError(f"{path}: there is no such results folder; give a folder that `tuner run` wrote")
    text = ""
    try:
        text = read_input_text(path / RECORD)
        return RunRecord.parse(text)
    except FileNotFoundError:
        nothing = not (path / "flights").exists()
        what = "nothing was recorded yet, so remove it and run the study again" if nothing else restart_hint(path)
        raise StoreError(f"{path} holds no {RECORD}, so it cannot be continued; {what}") from None
    except (OSError, ValueError) as error:
        what = explained(error, text) if isinstance(error, ValidationError) else str(error)
        raise StoreError(f"{path / RECORD} is damaged ({what}); {restart_hint(path)}") from None


def as_recorded(record: RunRecord, file: Path) -> PlainTable:
    """Return a study file's changes for a run, in dotted keys.

    With them it is read as it was for the run.
    file: the study, of the run or another to be read alike. Raises InputError where it cannot be read.
    """
    changes: PlainTable = {} if record.generations is None else {"search.generations": record.generations}
    if record.search_flights is not None:
        listed = [entries for layer in read_layers(file) if isinstance(entries := layer.table.get("scenario"), list)]
        scenarios = max(map(len, listed), default=0)
        changes |= {f"scenario.{i}.search": record.search_flights for i in range(scenarios)}
    if record.version in LEFT_OPEN:
        changes = {**flown_then(file, record.generations is not None), **changes}
    return {**left_open(file, NO_STARTS), **changes} if record.version < NAMES_STARTS else changes


def flown_then(file: Path, searches: bool) -> PlainTable:
    """Return the keys that a study leaves open, with early versions' values.

    The keys are dotted; the study may be one that searches.
    """
    return left_open(file, {table: keys for table, keys in FLOWN_THEN.items() if searches or table != "search"})


def left_open(file: Path, values: Mapping[str, Mapping[str, PlainValue]]) -> PlainTable:
    """Return values that a study lacks, by dotted key."""
    layers = read_layers(file)

    def is_given(table: str, key: str) -> bool:
        tables = [layer.table.get(table) for layer in layers]
        return any(isinstance(entry, Mapping) and key in entry for entry in tables)

    return {
        f"{table}.{key}": value
        for table, entries in values.items()
        for key, value in entries.items()
        if not is_given(table, key)
    }


def check_unchanged(path: Path, record: RunRecord, digest: str) -> None:
    """Refuse a run whose study is no longer what it was."""
    if digest != record.digest:
        raise StoreError(
            f"{path / record.study} is not what the run began with, or this version reads it in another way; {restart_hint(path)}"
        )


def check_model(path: Path, record: RunRecord) -> None:
    """Raise StoreError for a run that was flown with other sources.

    Half of it would have other bits.
    """
    if model_key() != record.model:
        raise StoreError(
            f"{path} was flown with another version of the model or of its compilers, whose bits may differ; "
            f"run the study again, or use the version named in {path / 'environment.json'}"
        )


def compute_as_recorded(path: Path, record: RunRecord, instead: str | None = None) -> None:
    """Have this process compute with the recorded arithmetic of a run.

    A run keeps its arithmetic to the end; StoreError where this process cannot.
    instead: what else can be done, by default to have the run computed again.
    """
    try:
        if record.machine is not None:
            compute_as(record.machine.arithmetic)
    except StoreError as error:
        raise StoreError(
            f"{path} was computed on another machine ({record.machine.arithmetic.label if record.machine else ''}): {error}; "
            f"go on there, or {instead or f'recompute all of it on this machine with `tuner resume {path} --here`'}"
        ) from None


def _copied(folder: Folder, source: Path, taken: dict[str, Path]) -> str:
    """Copy a study's file and imports into inputs/; return its name.

    taken: the files copied before, by name.
    """
    if source.suffix == ".py":
        _copy_imports(folder, source, taken)
    name, number = source.name, 1
    while taken.setdefault(name, source) != source:
        number += 1
        name = f"{source.stem}-{number}{source.suffix}"
    try:
        content = read_input(source, MAX_TABLE_BYTES)
    except OSError as error:
        raise StoreError(f"{source} cannot be read ({error.strerror})") from None
    folder.write_bytes(f"inputs/{name}", content)
    return name


def _copy_imports(folder: Folder, code: Path, taken: dict[str, Path]) -> None:
    """Copy the files next to a file of code that it imports; they keep their names, by which it imports them."""
    for source in sources_of(code)[:-1]:
        name = source.file.name
        if taken.setdefault(name, source.file) != source.file:
            raise StoreError(
                f"{source.file} and {taken[name]} are copied into one folder; give one of them another name"
            )
        folder.write_bytes(f"inputs/{name}", source.content)
