"""Kinds of study files, told apart by their tables."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import cast

from plant.errors import InputError
from plant.texts import PlainValue
from tuner.extension import objects, refuse_lacking
from tuner.study.build import study_from_table
from tuner.study.comparison import ComparisonStudy
from tuner.study.files import check_file_name
from tuner.study.layers import Layer, read_layers
from tuner.study.plant_study import PlantStudy, plant_study_from_table
from tuner.study.reading import put
from tuner.study.searched import SearchedStudy
from tuner.study.study import Study, TuningStudy

AnyStudy = ComparisonStudy | SearchedStudy
Overrides = Mapping[str, PlainValue]


@dataclass(frozen=True)
class StudyKind:
    """One kind of study file.

    Attributes:
        name: Name in `run.json`, where a study with choices is the contest that it becomes.
        noun: With its article.
        table: Table that identifies the kind, None for the kind of all other files.
        build: Function from path, layers and overrides to the checked study.
    """

    name: str
    noun: str
    table: str | None
    build: Callable[[Path, tuple[Layer, ...], Overrides], AnyStudy]


def _of_one_file(build: Callable[[Path, Mapping[str, PlainValue]], AnyStudy]) -> Callable[..., AnyStudy]:
    """Return the reader of studies that are built from one file."""

    def read(path: Path, layers: tuple[Layer, ...], overrides: Overrides) -> AnyStudy:
        # Such a study has no base: the key `base` is refused with all others that it does not know.
        table = layers[0].table
        for key, value in overrides.items():
            put(table, key, value, path)
        return build(path, table)

    return read


@cache
def study_kinds() -> tuple[StudyKind, ...]:
    """Return the kinds from the most special to the most general: the first whose table a file holds is its kind."""
    return (
        *objects("studies").values(),
        StudyKind(PlantStudy.kind, "a study of a plant of one's own", "plant", _of_one_file(plant_study_from_table)),
        StudyKind(Study.kind, "a study", None, _of_one_file(study_from_table)),
    )


def kind_of_layers(layers: tuple[Layer, ...]) -> StudyKind:
    """Return the kind of a study of these layers; InputError where only an extension that is not installed reads a table."""
    for layer in layers:
        for table in layer.table:
            refuse_lacking("tables", table, file=layer.path, key=table)
    tables = {key for layer in layers for key in layer.table}
    return next(kind for kind in study_kinds() if kind.table is None or kind.table in tables)


def load_any(path: Path, overrides: Overrides | None = None) -> AnyStudy:
    """Read and check a study file of any kind, parsed once.

    overrides: dotted keys that replace values of the file, for a contest contender.NAME.KEY among them. Raises InputError naming
    file and key.
    """
    check_file_name(path)
    layers = read_layers(path)
    return kind_of_layers(layers).build(path, layers, overrides or {})


def load_tuning(path: Path, command: str, overrides: Overrides | None = None) -> Study:
    """Read and check a study that tunes one controller; InputError, naming the command, where the file is of another kind."""
    return cast(Study, load_one(path, command, (Study.kind,), overrides))


def load_gains_study(path: Path, command: str, overrides: Overrides | None = None) -> TuningStudy:
    """Read and check a study of gains, of a quadrotor or plant.

    Raises InputError where the file is of another kind.
    """
    return cast(TuningStudy, load_one(path, command, (Study.kind, PlantStudy.kind), overrides))


def load_one(path: Path, command: str, kinds: tuple[str, ...], overrides: Overrides | None = None) -> AnyStudy:
    """Read and check a study of some kinds; InputError, naming the command, where the file is of another."""
    layers = read_layers(path)
    kind = kind_of_layers(layers)
    if kind.name not in kinds:
        raise of_another_kind(kind.name, path, command)
    return kind.build(path, layers, overrides or {})


def of_another_kind(name: str, path: Path, command: str) -> InputError:
    """Return the error of a study whose kind a command rejects."""
    kind = next(kind for kind in study_kinds() if kind.name == name)
    return InputError(f"this is {kind.noun}; `{command}` takes a study of one controller", file=path, key=kind.table)
