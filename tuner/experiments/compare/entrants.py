"""Entrants of a comparison: a results folder brings its recommended point and its front, a gains file its one controller."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plant.errors import InputError, StoreError, UnnamedCodeError
from tuner.documents.opening import kind_in
from tuner.documents.summary import GAINS as GAINS_FILE
from tuner.documents.summary import INFEASIBLE, is_recommended
from tuner.documents.tuning import TuningFolder
from tuner.gains import Controller, TunedLoops, read_gains, read_loops
from tuner.gains.parsing import parsed
from tuner.gains.sections import PLANT_FORMAT
from tuner.store.advice import JUDGEMENT, PLANT, TUNING
from tuner.store.inputs import as_recorded, read_record
from tuner.study.kinds import load_gains_study
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy

GAINS = "gains"
"""Name of the point of a gains file."""


@dataclass(frozen=True)
class Entrant:
    """One controller to compare.

    Args:
        name: Unique.
        source: Source as given.
        controller: Controller of a quadrotor, or the loops of a plant of the user's own.
        flies: Noun of what it controls, with its article.
        point: Its name in its own run.
        study: Study of the run, None for a gains file.
        points: Names of the front of the run, none for a gains file.
        rows: Gains rows (n, gains) of the front.
        picked: Held-out values (n, objectives) of the front.
        feasible: Whether its run recommends the controller.
    """

    name: str
    source: Path
    controller: Controller | TunedLoops
    flies: str
    point: str
    study: TuningStudy | None
    points: tuple[str, ...]
    rows: np.ndarray
    picked: np.ndarray
    feasible: bool = True

    @property
    def why(self) -> str:
        """Reason of its point, as the end of a sentence."""
        if self.study is None:
            return "its gains are given"
        return "recommended by its run" if self.feasible else "nearest to feasible in its run"


def read_entrants(paths: list[Path]) -> list[Entrant]:
    """Read what is to be compared; InputError or StoreError names the argument that cannot be."""
    if len(paths) < 2:
        raise InputError(
            f"given {len(paths)}; give at least two results folders or gains files", key="RESULTS... | GAINS..."
        )
    for i, path in enumerate(paths):
        if path.resolve() in [other.resolve() for other in paths[:i]]:
            raise InputError("given twice; leave one out", file=path)
    return [
        read_folder(path, name) if path.is_dir() else read_file(path, name)
        for path, name in zip(paths, names_of(paths), strict=True)
    ]


def names_of(paths: list[Path]) -> list[str]:
    """Return short names: of the folder, or of the file where it is not called gains.json; the whole path for namesakes."""
    short = [_short(path) for path in paths]
    return [name if short.count(name) == 1 else str(path) for name, path in zip(short, paths, strict=True)]


def _short(path: Path) -> str:
    file = path.resolve()
    if path.is_dir():
        return file.name
    return file.parent.name if file.name in (GAINS_FILE, INFEASIBLE) else file.stem


def read_file(path: Path, name: str) -> Entrant:
    """Read a gains file."""
    of_plant = parsed(path).get("format") == PLANT_FORMAT
    kind, read = (PlantStudy, read_loops) if of_plant else (Study, read_gains)
    controller = read(path)
    none = np.empty((0, len(controller.gains)))
    return Entrant(name, path, controller, kind.flies, GAINS, None, (), none, np.empty((0, 0)), is_recommended(path))


def read_folder(path: Path, name: str) -> Entrant:
    """Read the folder of a finished tuning run."""
    kind = kind_in(path)
    if kind is not None and kind is not TuningFolder:
        raise InputError(
            f"this is the folder of {kind.noun}; give that of a tuning run, such as one in a contest's contenders/, or a gains "
            "file",
            file=path,
        )
    study = study_of(path)
    if kind is None:
        raise StoreError(f"{path}: the run is not finished; go on with it: tuner resume {path}")
    results = TuningFolder(path)
    front = results.held_out_front
    rows = rows_of(study, front.gains)
    best = np.flatnonzero(front.non_dominated & front.feasible)
    points = tuple(front.points[k] for k in best)
    picked = front.held_out[best]
    controller, point = study.controller(rows[front.recommended]), front.points[front.recommended]
    return Entrant(name, path, controller, study.flies, point, study, points, rows[best], picked, results.feasible)


def rows_of(study: TuningStudy, values: np.ndarray) -> np.ndarray:
    """Return the gains rows (n, gains) of values of the study's variables (n, variables)."""
    rows = np.tile(study.default_row, (len(values), 1))
    for i, columns in enumerate(study.space.columns):
        rows[:, list(columns)] = values[:, i, None]
    return rows


def study_of(path: Path) -> TuningStudy:
    """Return the study that a results folder keeps; which version of the model flew it does not matter here."""
    record = read_record(path)
    if record.kind not in (TUNING, PLANT, JUDGEMENT):
        raise StoreError(f"{path} is the folder of a {record.kind}; give that of a tuning run")
    try:
        return load_gains_study(path / record.study, "tuner compare", as_recorded(record, path / record.study))
    except UnnamedCodeError:
        raise
    except InputError as error:
        raise StoreError(f"the inputs of this run are damaged: {error}") from None
