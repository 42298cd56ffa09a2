"""Studies from a file, from a name, or put together in Python."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias, TypeVar, overload

from plant.errors import InputError, StoreError
from plant.model.linear import numbers_of
from plant.model.plant_model import plant_from
from plant.texts import PlainValue
from tuner.store.advice import RECORD, is_codeless
from tuner.store.inputs import read_record
from tuner.study.build import study_from_table
from tuner.study.files import study_file
from tuner.study.kinds import AnyStudy, load_any, load_gains_study, load_tuning, of_another_kind, study_kinds
from tuner.study.plant_study import PlantStudy, plant_study_from_table
from tuner.study.study import Study, TuningStudy
from tuner.text.toml_text import toml_text

StudyLike: TypeAlias = AnyStudy | str | Path
S = TypeVar("S")
A = TypeVar("A", bound=AnyStudy)


@overload
def load_study(study: str | Path, changes: Mapping[str, PlainValue] | None = None) -> AnyStudy: ...
@overload
def load_study(study: str | Path, changes: Mapping[str, PlainValue] | None = None, *, kind: type[S]) -> S: ...
def load_study(
    study: str | Path, changes: Mapping[str, PlainValue] | None = None, *, kind: type[S] | None = None
) -> AnyStudy | S:
    """Read and check a study.

    Args:
        study: A TOML file, or the name of a shipped study; see `catalogue("studies")`.
        changes: Values that replace those of the file, by dotted key.
        kind: Class that the study must have, such as `tuner.Study`, so that type checkers know it; by default any.

    Returns:
        A `Study`, or a `PlantStudy` where the file has a plant; where it has contenders a contest. `run` takes them all.

    Raises:
        InputError: The study is missing, wrong or of another kind; the message names file, key and what is allowed.

    Examples:
        >>> study = tuner.load_study("quickstart", {"search.generations": 20})
        >>> [objective.label for objective in study.objectives]
        ['cvar80(itae.position)', 'mean(travel)']

    """
    return of_kind(load_any(study_file(Path(study)), changes), kind)


@overload
def make_study(
    tables: Mapping[str, PlainValue], name: str = "study", folder: str | Path = ".", plant: None = None
) -> Study | PlantStudy: ...
@overload
def make_study(
    tables: Mapping[str, PlainValue],
    name: str = "study",
    folder: str | Path = ".",
    *,
    plant: Mapping[str, object] | object,
) -> PlantStudy: ...
@overload
def make_study(
    tables: Mapping[str, PlainValue],
    name: str = "study",
    folder: str | Path = ".",
    plant: Mapping[str, object] | object | None = None,
    *,
    kind: type[S],
) -> S: ...
def make_study(
    tables: Mapping[str, PlainValue],
    name: str = "study",
    folder: str | Path = ".",
    plant: Mapping[str, object] | object | None = None,
    *,
    kind: type[S] | None = None,
) -> Study | PlantStudy | S:
    """Check a study that is put together in Python.

    Args:
        tables: Content of a study file, in its units: `{"title": ..., "gains": {...}, "scenario": [{...}], ...}`.
        name: Name of the study, which is that of its results folder unless another is given.
        folder: Folder that paths in the tables are relative to.
        plant: Names that describe a plant of your own, such as `globals()` of a notebook, where the tables have a `[plant]`
            without a file; see `docs/own_plant.md`. A run of it cannot be resumed, for no file holds its code. Or a linear
            system in continuous time of python-control or scipy.signal, whose numbers go into the tables.
        kind: Class that the study must have, as of `load_study`.

    Returns:
        The study, ready to run.

    Raises:
        InputError: A table or a value is missing or wrong; the message names its key.

    Examples:
        >>> study = tuner.make_study({
        ...     "title": "A metre to the side",
        ...     "seed": 1,
        ...     "airframe": {"name": "hummingbird"},
        ...     "controller": {"attitude": "hybrid", "position": "ladrc"},
        ...     "gains": {"position.omega_c": {"low": 1.0, "high": 4.0}},
        ...     "scenario": [{
        ...         "name": "step", "duration": 3.0, "search": 4, "held_out": 32,
        ...         "reference": {"kind": "steps", "x": 1.0, "time": 0.5},
        ...         "air": {"intensity": "light", "altitude": 10.0},
        ...     }],
        ...     "objective": [{"metric": "itae.position"}],
        ...     "search": {"algorithm": "differential_evolution", "population": 8, "generations": 3},
        ... })
        >>> study.space.variables[0].name
        'position.omega_c'

    """
    path = Path(folder) / f"{name}.toml"
    form = next(form for form in study_kinds() if form.table is None or form.table in tables)
    if form.name == PlantStudy.kind:
        if plant is not None and not isinstance(plant, Mapping):
            tables, plant = _with_numbers(tables, plant), None
        model = None if plant is None else plant_from(plant, name)
        return of_kind(replace(plant_study_from_table(path, tables, model), given=toml_text(tables)), kind)
    if form.table is not None:
        raise InputError(f"this is {form.noun}; write it to a file and load it", file=path, key=form.table)
    return of_kind(replace(study_from_table(path, tables), given=toml_text(tables)), kind)


def _with_numbers(tables: Mapping[str, PlainValue], plant: object) -> Mapping[str, PlainValue]:
    """Return tables with the numbers of a linear system in [plant]; unchanged where that is no table."""
    table = tables["plant"]
    return {**tables, "plant": {**table, **numbers_of(plant)}} if isinstance(table, Mapping) else tables


def of_kind(study: A, kind: type[S] | None) -> A | S:
    """Return a study as it is; InputError where it is not of the class that was wanted."""
    if kind is None:
        return study
    refusal = f"its class is {type(study).__name__}, and kind = {kind.__name__}; leave kind out, or give that class"
    return of_class(study, kind, lambda: InputError(refusal, file=study.path, key="kind"))


def loaded(study: StudyLike) -> AnyStudy:
    """Return a study unchanged, or that of a file or a name."""
    return load_any(study_file(Path(study))) if isinstance(study, str | Path) else study


def gains_study(study: StudyLike, asking: str) -> TuningStudy:
    """Return a study that searches gains, of a quadrotor or a plant.

    Raises InputError where it is of another kind.
    """
    given = load_gains_study(study_file(Path(study)), asking) if isinstance(study, str | Path) else study
    return of_class(given, TuningStudy, lambda: of_another_kind(given.kind, given.path, asking))


def plant_study(study: StudyLike, asking: str) -> PlantStudy:
    """Return a study of a plant; InputError where it is of another kind. asking: who takes no other."""
    given = gains_study(study, asking)
    refusal = "this is a study of a quadrotor, and the gains are those of a plant; give the study of the plant"
    return of_class(given, PlantStudy, lambda: InputError(refusal, file=given.path, key="plant"))


def tuning_study(study: StudyLike, asking: str) -> Study:
    """Return a study that tunes one controller; InputError where it is of another kind. asking: who takes no other."""
    given = load_tuning(study_file(Path(study)), asking) if isinstance(study, str | Path) else study
    return of_class(given, Study, lambda: of_another_kind(given.kind, given.path, asking))


def of_class(study: object, kind: type[S], refusal: Callable[[], InputError]) -> S:
    """Return a study of the class that a command takes; raises the refusal for another."""
    if isinstance(study, kind):
        return study
    raise refusal()


def study_in(folder: Path | None, gains: Path | None) -> PlantStudy:
    """Return the study that a results folder keeps.

    Raises InputError where there is no folder, or where the code of the plant, which the folder may not run, has not been named.
    """
    if folder is None:
        raise InputError(
            f"lies in no results folder, whose {RECORD} names the study; give that of a results folder, or the study too",
            file=gains,
        )
    refuse_codeless(folder)
    return plant_study(load_any(folder / read_record(folder).study), "gains of a plant of one's own")


def refuse_codeless(folder: Path) -> None:
    """Raise StoreError for the folder of a plant without a code file."""
    if is_codeless(folder):
        raise StoreError(
            f"no file holds the plant that was run into {folder}, as in a notebook; give its gains with the study that you made"
        )
