"""Gains of every kind: from a file, a results folder, a law's defaults or a design; with units, origin, and what they fly."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NotRequired, Self, TypeAlias, TypedDict, cast, overload

import numpy as np

from objectives.margins.trim import Trim
from plant.errors import InputError
from plant.law_registry import law as find_law
from plant.quadrotor.airframes import load as load_airframe
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import gain_addresses
from plant.texts import PlainTable
from tuner.analysis.margins.judging import Judged, judge_plant, judge_quadrotor
from tuner.api import AIRFRAME, POSITION_LAW
from tuner.api.border import checked
from tuner.api.changed_gains import changed_values, reread
from tuner.api.flight_setup import FlightSetup, plant_setup, quadrotor_setup
from tuner.api.frames import frame, shown
from tuner.api.studies import StudyLike, gains_study, plant_study, study_in, tuning_study
from tuner.gains import Controller, TunedLoops, plant_gains_document, to_document
from tuner.gains import read_gains as read_controller
from tuner.gains.parsing import parsed
from tuner.gains.sections import PLANT_FORMAT
from tuner.store.advice import POINTS, RECORD
from tuner.store.document import write_new
from tuner.study.files import named_study
from tuner.study.kinds import AnyStudy
from tuner.study.plant_controller import PlantController
from tuner.study.plant_study import PlantStudy

if TYPE_CHECKING:
    import pandas as pd

    from tuner.exchange.run import ExportSubject


VARIABLES_FORMAT = "gainproof-variables"
MADE_ELSEWHERE = "these are values of variables of another program"


class GainTable(TypedDict):
    """A gain in gains.json, checked when it was read.

    low, high: its range, where a search had one.
    """

    value: float
    unit: str
    low: NotRequired[float]
    high: NotRequired[float]


class PlantTable(TypedDict):
    """The plant in gains.json. digest: of its code or FMU."""

    name: str
    digest: str


class Refusals:
    """Steps of calls that gains of some kind do not take: each refuses with a sentence, unless the kind has its own."""

    path: Path | None

    def with_study(self, study: AnyStudy | None) -> Self:
        """Return the gains with the in-memory study of their plant's code."""
        return self

    def quadrotor(self, otherwise: str) -> Controller:
        """Return the controller of a quadrotor; InputError, with a sentence, for other gains."""
        raise InputError(otherwise, file=self.path)

    def flight_setup(self, study: StudyLike | None, scenario: int, seed: int) -> FlightSetup:
        """Return the flights of a study's scenario, or of the usual one.

        scenario: number from 0; seed: root seed of the usual one.
        """
        raise InputError(f"{MADE_ELSEWHERE}, and it alone can fly them", file=self.path)

    def judge_margins(self, trim: Trim, study: StudyLike | None, certified: bool) -> Judged:
        """Return the loops in a steady flight and their margins."""
        raise InputError(f"{MADE_ELSEWHERE}, so no loops are there to have margins", file=self.path)

    def to_export(self, study: StudyLike | None = None) -> "ExportSubject[Controller] | ExportSubject[PlantController]":
        """Return the gains on their way to a target; study: of the plant, where they do not lie in its results folder."""
        raise InputError(f"{MADE_ELSEWHERE}; take them over from the file, which has their units", file=self.path)


@dataclass(frozen=True, eq=False, repr=False)
class Gains(Refusals, Mapping[str, float]):
    """Gains of a controller, by address: `gains["roll.kp"]`.

    Attributes:
        document: Content of gains.json: every gain with its unit, and where the gains come from.
        path: The file they were read from, None for gains that stand in no file.

    """

    document: PlainTable
    path: Path | None = None

    @property
    @abstractmethod
    def flown(self) -> str:
        """Name of the airframe, the plant, or another program's study."""

    @property
    def airframe(self) -> str:
        """Name of the airframe; InputError where no quadrotor is flown."""
        return self.quadrotor("these gains are not a quadrotor's, so they have no airframe").airframe.name

    @property
    @abstractmethod
    def laws(self) -> dict[str, str]:
        """Name of the law of each loop."""

    @property
    def _tables(self) -> dict[str, GainTable]:
        return cast("dict[str, GainTable]", self.document["gains"])

    @cached_property
    def values_by_address(self) -> dict[str, float]:
        """The gains."""
        return {address: entry["value"] for address, entry in self._tables.items()}

    @property
    def units(self) -> dict[str, str]:
        """Unit of each gain."""
        return {address: entry["unit"] for address, entry in self._tables.items()}

    def __getitem__(self, address: str) -> float:
        return self.values_by_address[address]

    def __iter__(self) -> Iterator[str]:
        return iter(self.values_by_address)

    def __len__(self) -> int:
        return len(self.values_by_address)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each gain, by address: value, unit, and the ends of the range that a search had, where one had one."""
        given, units, ends = self._tables, self.units, ("low", "high")
        rows = [
            {"gain": address, "value": value, "unit": units[address], **{end: given[address].get(end) for end in ends}}
            for address, value in self.items()
        ]
        return frame(rows, "gain")

    @checked
    def replace(self, values: Mapping[str, float] | None = None, **named: float) -> Self:
        """Return the gains with other values.

        Args:
            values: Value of each gain to change, by address.
            named: Value of each gain to change, by the last part of an address that one loop alone has.

        Returns:
            Gains in no file, checked as those of a file.

        Raises:
            InputError: A name is unknown or several loops have it, or a value is out of range.

        Examples:
            >>> tuner.default_gains("hybrid").replace({"roll.k1": 9.0})["roll.k1"]
            9.0

        """
        changed = reread(self.document, changed_values(self, {**(values or {}), **named}), read_gains)
        return cast("Self", self._at_home(changed))

    def _at_home(self, changed: "Gains") -> "Gains":
        return replace(changed, path=None)

    def write(self, path: str | Path) -> Path:
        """Write a gains.json.

        Args:
            path: The file; it must not exist.

        Returns:
            The path.

        Raises:
            StoreError: The file exists already, or cannot be written.

        Examples:
            >>> tuner.default_gains("hybrid").write("hybrid.json").name
            'hybrid.json'

        """
        return write_new(Path(path), self.document)

    @contextmanager
    def file(self) -> Iterator[Path]:
        """Yield a file that holds the gains: their own, or one that is gone afterwards."""
        if self.path is not None:
            yield self.path
            return
        with TemporaryDirectory() as folder:
            yield write_new(Path(folder) / "gains.json", self.document)

    def __repr__(self) -> str:
        return f"Gains({self._title})"

    def _repr_html_(self) -> str:
        return shown(f"Gains: {self._title}", (), self.table)

    @property
    def _title(self) -> str:
        return f"{' / '.join(self.laws.values())} for {self.flown}"


@dataclass(frozen=True, eq=False, repr=False)
class QuadrotorGains(Gains):
    """Gains of a quadrotor. controller: laws, options, periods [s], airframe, and the gains as a row."""

    controller: Controller = field(kw_only=True)

    @property
    def flown(self) -> str:
        """Name of the airframe."""
        return self.controller.airframe.name

    @property
    def laws(self) -> dict[str, str]:
        """Names of the position and the attitude law."""
        cascade = self.controller.cascade
        return {"position": cascade.position.name, "attitude": cascade.attitude.name}

    @cached_property
    def values_by_address(self) -> dict[str, float]:
        """The gains, in the order of their columns."""
        return {gain.address: self.controller.gains[gain.column] for gain in gain_addresses(self.controller.cascade)}

    @property
    def units(self) -> dict[str, str]:
        """Unit of each gain."""
        return {gain.address: gain.unit for gain in gain_addresses(self.controller.cascade)}

    def quadrotor(self, otherwise: str) -> Controller:
        """Return the controller."""
        return self.controller

    def flight_setup(self, study: StudyLike | None, scenario: int, seed: int) -> FlightSetup:
        """Return the flight and limits of a study, or the usual ones."""
        return quadrotor_setup(self.controller, study, scenario, seed)

    def judge_margins(self, trim: Trim, study: StudyLike | None, certified: bool) -> Judged:
        """Return the margins in a trim, or in the study's steady states."""
        judging = None if study is None else tuning_study(study, "tuner margins --study")
        return judge_quadrotor(self.controller, trim, judging, certified)

    def to_export(self, study: StudyLike | None = None) -> "ExportSubject[Controller]":
        """Return the controller with its document and its content hash."""
        # What verifies an export is imported with it, which a run that ends here does not wait for.
        from tuner.exchange.run import quadrotor_subject

        return quadrotor_subject(self.controller, self.document)


@dataclass(frozen=True, eq=False, repr=False)
class PlantGains(Gains):
    """Gains of a plant of the user's own.

    Attributes:
        loops: Its loops with their gains.
        study: Study in memory, closes the loops around the plant, such as one of a notebook.
        folder: Results folder that keeps the study, whose code or FMU is named with `use`.

    """

    loops: TunedLoops = field(kw_only=True)
    study: PlantStudy | None = field(default=None, kw_only=True)
    folder: Path | None = field(default=None, kw_only=True)

    @property
    def _plant(self) -> PlantTable:
        return cast("PlantTable", self.document["plant"])

    @property
    def flown(self) -> str:
        """Name of the plant."""
        return self._plant["name"]

    @property
    def digest(self) -> str:
        """Digest of the code or the FMU that the gains belong to."""
        return self._plant["digest"]

    @property
    def laws(self) -> dict[str, str]:
        """Name of the law of each channel."""
        return {channel.name: channel.law.name for channel in self.loops.channels}

    @property
    def units(self) -> dict[str, str]:
        """Unit of each gain."""
        if self.study is not None:
            return {gain.address: gain.unit for gain in self.study.system.gains}
        return {address: unit.strip("{}") for address, unit in super().units.items()}

    def _at_home(self, changed: Gains) -> Gains:
        return replace(cast("Self", changed), path=None, study=self.study, folder=self.folder)

    def with_study(self, study: AnyStudy | None) -> Self:
        """Return the gains with the study of their plant."""
        return self if study is None else replace(self, study=plant_study(study, "gains of a plant"))

    def closed(self, study: StudyLike | None, command: str) -> PlantController:
        """Return the controller with the study that closes its loops.

        Args:
            study: Study of the gains; by default the one in memory, or that of the results folder.
            command: Who needs it, for errors.

        Raises:
            InputError: Its loops are others, no study is there, or its code has not been named.
        """
        named = self.study if study is None else plant_study(study, command)
        closing = study_in(self.folder, self.path) if named is None else named
        return PlantController(closing, tuple(self.loops.checked_row(closing.system, self.path).tolist()))

    def flight_setup(self, study: StudyLike | None, scenario: int, seed: int) -> FlightSetup:
        """Return the flight of a scenario of the study."""
        return plant_setup(self.closed(study, "tuner fly --study"), scenario)

    def judge_margins(self, trim: Trim, study: StudyLike | None, certified: bool) -> Judged:
        """Return the margins at rest."""
        if trim != Trim():
            raise InputError(
                "yaw, speed, wind and attitude mode are those of quadrotors; leave them out: a plant is linearised where it rests"
            )
        return judge_plant(self.closed(study, "tuner margins --study"), study is not None, certified)

    def to_export(self, study: StudyLike | None = None) -> "ExportSubject[PlantController]":
        """Return the controller with its document and the digest of its file."""
        from tuner.exchange.run import plant_subject

        return plant_subject(self.closed(study, "tuner export"), self.document, self.path)


class VariableValues(Gains):
    """Values of the variables of a study whose trials another program makes."""

    @property
    def flown(self) -> str:
        """Title of the study."""
        return str(self.document["title"])

    @property
    def laws(self) -> dict[str, str]:
        """No laws: another program has them."""
        return {}

    @property
    def _title(self) -> str:
        return self.flown


GainsLike: TypeAlias = Gains | str | Path


def read_gains(path: str | Path, airframe: str | None = None) -> Gains:
    """Read a gains.json.

    Args:
        path: The file, of a quadrotor or of a plant, or the results folder that it lies in; a study file, for its default.
        airframe: Bundled name or TOML file of an airframe that flies instead of the file's own.

    Returns:
        The gains.

    Raises:
        InputError: The file is missing, wrong, or edited without removing its hash; the message names the key.

    Examples:
        >>> tuner.read_gains("results/first/gains.json").laws
        {'position': 'ladrc', 'attitude': 'hybrid'}

    """
    path = Path(path)
    if (study := named_study(path)) is not None:
        if airframe is not None:
            raise InputError("a study names its airframe; leave the other out", file=study)
        return default_of(study)
    if path.is_dir():
        # Documents of all kinds of folders, which a file alone needs not.
        from tuner.documents.opening import gains_file

        path = gains_file(path)
    document = parsed(path)
    if document.get("format") not in (PLANT_FORMAT, VARIABLES_FORMAT):
        return QuadrotorGains(document, path, controller=read_controller(path, airframe))
    if airframe is not None:
        raise InputError("flies no quadrotor, so no other airframe can fly instead; leave it out", file=path)
    return gains_in(document, path, path.resolve().parent)


def default_of(study: StudyLike) -> Gains:
    """Return the default gains of a study."""
    given = gains_study(study, "gains of its default")
    document = given.gains_document(given.default_row, {})
    if document["format"] == PLANT_FORMAT:
        return gains_in(document, None, given.path.parent).with_study(given)
    return QuadrotorGains(document, controller=given.controller(given.default_row))


def gains_in(document: PlainTable, path: Path | None, folder: Path) -> Gains:
    """Return gains of a plant, or another program's variables, from their content.

    Args:
        document: The content.
        path: The file, None where none holds it.
        folder: Folder of the file; a results folder, which may hold it in `points`, keeps its study.
    """
    if document["format"] == VARIABLES_FORMAT:
        return VariableValues(document, path)
    folders = (folder, folder.parent) if folder.name == POINTS else (folder,)
    home = next((each for each in folders if (each / RECORD).exists()), None)
    return PlantGains(document, path, loops=TunedLoops.read(document, path), folder=home)


@overload
def default_gains(attitude: str, position: str = POSITION_LAW, airframe: str = AIRFRAME) -> QuadrotorGains: ...
@overload
def default_gains(attitude: AnyStudy | Path) -> Gains: ...
def default_gains(attitude: StudyLike, position: str = POSITION_LAW, airframe: str = AIRFRAME) -> Gains:
    """Return the default gains of two laws, or of a study.

    Args:
        attitude: Name of the attitude law; see `catalogue("laws")`. Or a study, or its TOML file.
        position: Name of the position law.
        airframe: Bundled name or TOML file of an airframe.

    Returns:
        The gains, at a control period of 4 ms.

    Raises:
        InputError: There is no law or airframe of that name.

    Examples:
        >>> gains = tuner.default_gains("hybrid")
        >>> gains.table.loc["roll.k1", "unit"]
        'rad^(1/2) s^(-3/2)'

    """
    if not isinstance(attitude, str) or attitude.endswith(".toml"):
        return default_of(attitude)
    cascade = close_cascade(find_law(position), find_law(attitude))
    return gains_of(Controller.default(load_airframe(airframe, allow_unphysical=True), cascade), {})


def gains_of(controller: Controller, provenance: Mapping[str, object]) -> QuadrotorGains:
    """Return the gains of a controller; provenance: sections of gains.json on their origin."""
    return QuadrotorGains(to_document(controller, dict(provenance)), controller=controller)


def gains_of_plant(study: PlantStudy, row: np.ndarray) -> PlantGains:
    """Return a gains row (g,) of a plant."""
    document = plant_gains_document(study.system, row, study.code_digest)
    return PlantGains(document, loops=TunedLoops.of(study.system, row), study=study)


def as_gains(gains: GainsLike) -> Gains:
    """Return gains unchanged, or those of a file or a results folder."""
    return gains if isinstance(gains, Gains) else read_gains(gains)


def quadrotor_gains(gains: GainsLike) -> QuadrotorGains:
    """Return gains of a quadrotor; InputError where they are others."""
    given = as_gains(gains)
    controller = given.quadrotor(
        "holds gains of a plant of one's own; this is for quadrotors, whose first flights go in steps"
    )
    return QuadrotorGains(given.document, given.path, controller=controller)
