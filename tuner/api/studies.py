"""Studies from a file, from a name, or put together in Python."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from plant.errors import InputError
from plant.model.plant_model import plant_from
from tuner.study import Study
from tuner.study.build import study_from_table
from tuner.study.files import study_file
from tuner.study.kinds import STUDY_KINDS, AnyStudy, load_any, load_gains_study, load_tuning, of_another_kind
from tuner.study.plant_study import PlantStudy, plant_study_from_table
from tuner.study.study import TuningStudy
from tuner.text.toml_text import toml_text

StudyLike: TypeAlias = AnyStudy | str | Path


def load_study(study: str | Path, changes: Mapping[str, Any] | None = None) -> Any:
    """Read and check a study.

    Args:
        study: A TOML file, or the name of a shipped study; see `catalogue("studies")`.
        changes: Values that replace those of the file, by dotted key.

    Returns:
        A `Study`; where the file has contenders a contest, and where it has unknowns an inference. `run` takes all three.

    Raises:
        InputError: The study is missing or wrong; the message names file, key and what is allowed.

    Examples:
        >>> study = tuner.load_study("quickstart", {"search.generations": 20})
        >>> [objective.label for objective in study.objectives]
        ['cvar80(itae.position)', 'mean(travel)']

    """
    return load_any(study_file(Path(study)), changes)


def make_study(
    tables: Mapping[str, Any],
    name: str = "study",
    folder: str | Path = ".",
    plant: Mapping[str, Any] | None = None,
) -> Any:
    """Check a study that is put together in Python.

    Args:
        tables: What a study file holds, in its units: `{"title": ..., "gains": {...}, "scenario": [{...}], ...}`.
        name: Name of the study, which is that of its results folder unless another is given.
        folder: Folder that paths in the tables are relative to.
        plant: Names that describe a plant of your own, such as `globals()` of a notebook, where the tables have a `[plant]`
            without a file; see `docs/own_plant.md`. A run of it cannot be resumed, for no file holds its code.

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
    kind = next(kind for kind in STUDY_KINDS if kind.table is None or kind.table in tables)
    if kind.name == PlantStudy.kind:
        model = None if plant is None else plant_from(plant, name)
        return replace(plant_study_from_table(path, tables, model), given=toml_text(tables))
    if kind.table is not None:
        raise InputError(f"this is {kind.noun}; write it to a file and load it", file=path, key=kind.table)
    return replace(study_from_table(path, tables), given=toml_text(tables))


def loaded(study: StudyLike) -> AnyStudy:
    """Return a study as it is, or the one of a file or a name."""
    return load_any(study_file(Path(study))) if isinstance(study, str | Path) else study


def gains_study(study: StudyLike, asking: str) -> TuningStudy:
    """Return a study that searches gains, of a quadrotor or of a plant of one's own; InputError where it is of another kind."""
    if isinstance(study, str | Path):
        return load_gains_study(study_file(Path(study)), asking)
    if isinstance(study, TuningStudy):
        return study
    raise of_another_kind(study.kind, study.path, asking)


def tuning_study(study: StudyLike, asking: str) -> Study:
    """Return a study that tunes one controller; InputError where it is of another kind. asking: who takes no other."""
    if isinstance(study, str | Path):
        return load_tuning(study_file(Path(study)), asking)
    if isinstance(study, Study):
        return study
    raise of_another_kind(study.kind, study.path, asking)
