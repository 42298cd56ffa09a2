"""Gains: read from a file, a law's defaults, designed, or those of a run's point; with units, airframe and origin."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeAlias

from plant.airframes import load as load_airframe
from plant.cascade import close_cascade
from plant.errors import StoreError
from plant.gains import default_row, gain_addresses
from plant.input_files import read_input_text
from plant.laws import law as find_law
from plant.nominal import ControlOptions
from plant.output_files import make_folders, write_new_file
from tuner.api import AIRFRAME, POSITION_LAW
from tuner.api.frames import frame, shown
from tuner.gains import Controller, to_document
from tuner.gains import read_gains as read_controller
from tuner.store.document import json_text

if TYPE_CHECKING:
    import pandas as pd

Document = dict[str, Any]

CONTROL_PERIOD, PLANT_STEP = 0.004, 0.001


@dataclass(frozen=True)
class Gains:
    """Gains of a controller with the airframe that they are for.

    Attributes:
        controller: Laws, options, periods [s], airframe, and the gains as a row.
        document: What gains.json holds: every gain with its unit, and where the gains come from.
        path: The file they were read from, None for gains that stand in no file.

    """

    controller: Controller
    document: Document
    path: Path | None = None

    @property
    def airframe(self) -> str:
        """Name of the airframe."""
        return self.controller.airframe.name

    @property
    def laws(self) -> dict[str, str]:
        """Names of the position and the attitude law."""
        cascade = self.controller.cascade
        return {"position": cascade.position.name, "attitude": cascade.attitude.name}

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each gain, by address: value, unit, and the ends of the range that a search had, where one had one."""
        given = self.document["gains"]
        rows = [
            {
                "gain": gain.address, "value": self.controller.gains[gain.column], "unit": gain.unit,
                "low": given[gain.address].get("low"), "high": given[gain.address].get("high"),
            }
            for gain in gain_addresses(self.controller.cascade)
        ]  # fmt: skip
        return frame(rows, "gain")

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
        return f"{self.laws['position']} / {self.laws['attitude']} for {self.airframe}"


GainsLike: TypeAlias = Gains | str | Path


def read_gains(path: str | Path, airframe: str | None = None) -> Gains:
    """Read a gains.json.

    Args:
        path: The file.
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
    controller = read_controller(path, airframe)
    return Gains(controller, json.loads(read_input_text(path)), path)


def default_gains(attitude: str, position: str = POSITION_LAW, airframe: str = AIRFRAME) -> Gains:
    """Return the default gains of two laws.

    Args:
        attitude: Name of the attitude law; see `catalogue("laws")`.
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
    cascade = close_cascade(find_law(position), find_law(attitude))
    vehicle = load_airframe(airframe)
    row = tuple(default_row(cascade, vehicle.vehicle))
    return gains_of(Controller(vehicle, cascade, ControlOptions(), CONTROL_PERIOD, PLANT_STEP, row), {})


def gains_of(controller: Controller, provenance: Mapping[str, Any]) -> Gains:
    """Return the gains of a controller; provenance: what gains.json says of their origin."""
    return Gains(controller, to_document(controller, dict(provenance)))


def as_gains(gains: GainsLike, airframe: str | None = None) -> Gains:
    """Return gains as they are, or those of a file."""
    return gains if isinstance(gains, Gains) else read_gains(gains, airframe)


def write_new(path: Path, document: Document, parents: bool = False) -> Path:
    """Write a JSON file that must not exist yet, with the folders above it if asked to; StoreError where that cannot be."""
    try:
        if parents:
            make_folders(path.parent)
        write_new_file(path, json_text(document).encode())
    except FileExistsError:
        raise taken(path) from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror}); choose another file with --out") from error
    return path


def taken(path: Path) -> StoreError:
    """Return the error for a file that exists already."""
    return StoreError(f"{path} exists already and was not touched; choose another file with --out")
