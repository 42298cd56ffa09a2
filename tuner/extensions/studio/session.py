"""An opened study: its gains with their ranges, default and tuned settings, and the front of a run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from objectives.decisions import Variable
from plant.errors import InputError, shortened
from tuner.api.gains import Gains, gains_of, gains_of_plant, read_gains
from tuner.api.studies import StudyLike, gains_study
from tuner.documents.opening import kind_in
from tuner.documents.tuning import TuningFolder
from tuner.store.advice import RECORD
from tuner.store.inputs import read_record
from tuner.study.files import named_study, study_file
from tuner.study.kinds import load_any
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.tuning_study import TuningStudy

DEFAULT_STUDY = "quickstart"
"""Name of the study that opens without an argument."""
MAX_PINS = 4
"""Settings that may be pinned next to the one at hand."""
ROUNDING = 1e-9
"""Share of a range by which a value may lie outside: an end that a browser rounded."""


class Setting(NamedTuple):
    """A gains row (g,) with its name in charts and tables; key: of its look and of its switch on the page."""

    name: str
    row: np.ndarray
    key: str


@dataclass(frozen=True, eq=False)
class Session:
    """An opened study.

    Attributes:
        study: Study whose flights, limits and ranges count.
        start: Setting that the page opens with.
        default: Default gains of the study.
        tuned: Recommended gains of a run, None without one.
        results: Results of the run, None without one.
        folder: Folder of a run that may still grow, None without one.
        pins: Settings that the page opens with next to the one at hand.
    """

    study: TuningStudy
    start: Setting
    default: Setting
    tuned: Setting | None = None
    results: TuningFolder | None = None
    folder: Path | None = None
    pins: tuple[Setting, ...] = ()

    @property
    def fixed(self) -> list[Setting]:
        """Settings that never move: the default, and the tuned gains if there are any."""
        return [self.default, *([] if self.tuned is None else [self.tuned])]

    def row(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the gains row (g,) of values by variable.

        Gains without a value keep that of the opened setting. Raises InputError for an unknown name or a value outside its range.
        """
        row, space = np.array(self.start.row, dtype=float), self.study.space
        by_name = {variable.name: i for i, variable in enumerate(space.variables)}
        for name, value in values.items():
            if name not in by_name:
                raise InputError(f"no gain of this study; its gains are {', '.join(by_name)}", key=shortened(name))
            columns = list(space.columns[by_name[name]])
            # Columns that one variable moves together may differ in a fixed setting, such as p of roll and pitch.
            settings = (self.start, *self.fixed, *self.pins)
            rows = (each.row[columns] for each in settings if value == each.row[columns[0]])
            exact = next(rows, None)
            row[columns] = self._checked(space.variables[by_name[name]], value) if exact is None else exact
        return row

    def _checked(self, variable: Variable, value: float) -> float:
        """Return a value within its range."""
        room = ROUNDING * (variable.high - variable.low)
        if not isfinite(value) or not variable.low - room <= value <= variable.high + room:
            raise InputError(
                f"given {value:g}; allowed: {variable.low:g} to {variable.high:g}. Widen the range in the study's [gains] "
                "to go further",
                key=variable.name,
            )
        return min(max(value, variable.low), variable.high)

    def values(self, row: np.ndarray) -> dict[str, float]:
        """Return the values of the variables in a gains row (g,)."""
        space = self.study.space
        return {each.name: float(row[columns[0]]) for each, columns in zip(space.variables, space.columns, strict=True)}

    def gains(self, row: np.ndarray) -> Gains:
        """Return a gains row (g,) as gains of the Python API."""
        return GAINS[self.study.kind](self.study, row)

    @property
    def has_rotors(self) -> bool:
        """Whether a quadrotor is flown, not a plant."""
        return self.study.kind == Study.kind


GAINS: Mapping[str, Callable[[Any, np.ndarray], Gains]] = {
    Study.kind: lambda study, row: gains_of(study.controller(row), {"study": study.origin("studio")}),
    PlantStudy.kind: gains_of_plant,
}
"""Kind of study -> function that returns a gains row as gains."""


def open_session(given: Path | None, study: StudyLike | None = None) -> Session:
    """Open a study, a results folder, or gains with their study; given: None for the first study of the tool.

    Raises InputError for a file of another kind or gains without a study, StoreError for a damaged folder.
    """
    path = Path(DEFAULT_STUDY) if given is None else given
    if path.is_dir():
        return _of_folder(path)
    if path.suffix == ".json":
        return session_of_gains(path, study)
    if path.suffix in (".py", ".fmu"):
        raise InputError(
            "a plant alone has no loops, ranges and scenarios; name it in a study ([plant] file = ...) and open that, see "
            "docs/own_plant.md",
            file=path,
        )
    return session_of_study(named_study(path) or study_file(path))


def _searched(study: TuningStudy) -> TuningStudy:
    if not study.space.variables:
        raise InputError("no gain has a range, so nothing can be moved; give one a range", file=study.path, key="gains")
    if study.kind not in GAINS:
        raise InputError("has no flights of its own; open a study of a quadrotor or of a plant", file=study.path)
    return study


def session_of_study(study: StudyLike) -> Session:
    """Open a study."""
    return _of_study(_searched(gains_study(study, "tuner studio")))


def _of_study(study: TuningStudy) -> Session:
    default = Setting("default", np.array(study.default_row, dtype=float), "default")
    return Session(study, default, default)


def _of_folder(folder: Path) -> Session:
    """Open a results folder: of a run that has ended, or of one at work."""
    if not (folder / RECORD).exists():
        raise InputError("is no results folder; give one that `tuner run` wrote, a study or a gains.json", file=folder)
    study = _searched(gains_study(load_any(folder / read_record(folder).study), "tuner studio"))
    session = _of_study(study)
    if kind_in(folder) is not TuningFolder:
        return Session(study, session.default, session.default, folder=folder)
    results = TuningFolder(folder)
    gains = study.read_row(folder / results.document.gains_file)
    tuned = Setting(results.shown_as, gains, "tuned")
    return Session(study, tuned, session.default, tuned, results, folder)


def session_of_gains(path: Path, study: StudyLike | None) -> Session:
    """Open gains with their study; by default that of their results folder."""
    home = path.resolve().parent
    if study is None and (home / RECORD).exists():
        session = _of_folder(home)
    elif study is None:
        raise InputError(
            "gains hold no scenarios and no ranges; add --study FILE, for instance --study quickstart", file=path
        )
    else:
        session = session_of_study(study)
    read_gains(path)
    row = session.study.read_row(path)
    return Session(
        session.study, Setting("file", row, "here"), session.default, session.tuned, session.results, session.folder
    )


def with_pins(session: Session, files: Sequence[Path]) -> Session:
    """Return a session with the gains of files as pins."""
    if len(files) > MAX_PINS:
        raise InputError(f"given {len(files)} files; allowed: at most {MAX_PINS}", key="--pin")
    rows = [session.study.read_row(file) for file in files]
    pins = [Setting(file.stem, row, f"pin{i}") for i, (file, row) in enumerate(zip(files, rows, strict=True), 1)]
    out = replace(session, pins=tuple(pins))
    for file, row in zip(files, rows, strict=True):
        if not np.array_equal(row, out.row(session.values(row))):
            raise InputError(
                "differs in a gain that the study does not search; open it by itself", file=file, key="--pin"
            )
    return out
