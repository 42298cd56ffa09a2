"""Gains to a target and from a vehicle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

from plant.quadrotor.airframes import load
from plant.texts import PlainTable
from tuner.api.frames import Documented, frame, json_text, shown
from tuner.api.gains import GainsLike, QuadrotorGains, as_gains, gains_of
from tuner.api.studies import StudyLike
from tuner.documents.export import ExportDocument
from tuner.exchange.registry import exporter as find_exporter
from tuner.exchange.registry import import_parameters
from tuner.exchange.run import Export
from tuner.exchange.verification import FLIGHTS
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.document import taken, write_new

if TYPE_CHECKING:
    import pandas as pd

Options: TypeAlias = Mapping[str, object] | Sequence[str]
"""Options by name, or as NAME=VALUE texts."""


@dataclass(frozen=True)
class Exported(Documented):
    """Files and findings of an export; made: the export with its document, export.json."""

    made: Export

    @property
    def folder(self) -> Path:
        """The folder with the target's files, rollback/, export.json and gains.json."""
        return self.made.folder

    @property
    def document(self) -> ExportDocument:
        """Content of export.json."""
        return self.made.document

    @property
    def json(self) -> str:
        """The document as JSON, with the folder."""
        return json_text({**self.document.content(), "folder": str(self.folder)})

    @property
    def passed(self) -> bool:
        """True if rounding breaks no satisfied limit and no flight is lost."""
        return self.document.verification.passed

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each parameter of the target: asked, held, allowed range, and what the vehicle has; empty for code."""
        return frame(self.document.parameters, "name")

    def _repr_html_(self) -> str:
        return shown(f"{self.document.target_version}: {self.folder}", self.document.lossy, self.table)


def export(
    gains: GainsLike,
    target: str,
    out: str | Path | None = None,
    *,
    options: Options = MappingProxyType({}),
    previous: str | Path | None = None,
    study: StudyLike | None = None,
    flights: int = FLIGHTS,
    force: bool = False,
    watcher: Watcher | None = None,
) -> Exported:
    """Write gains for a target and verify them after rounding.

    The present parameters are stored for a rollback.

    Args:
        gains: Gains, a gains.json or a results folder; of a plant, name its code with `use` or give the study.
        target: Name of a target; see `catalogue("targets")`. A plant goes to c99 alone.
        out: New folder; by default export/TARGET next to the gains.
        options: Options of the target, such as `{"firmware": "1.15"}`.
        previous: Parameter file of what the vehicle flies at present, or a gains.json, for the rollback.
        study: Study that closes the loops around a plant; by default that of its results folder.
        flights: Flights before and after rounding.
        force: Whether to write gains of a run that found nothing feasible all the same.
        watcher: Callbacks that hear of progress.

    Returns:
        Files, and findings of the verification.

    Raises:
        InputError: The target cannot hold the gains, or does not carry their laws.
        StoreError: The folder holds something already, or cannot be written.

    Examples:
        >>> made = tuner.export(gains, "c99", "export/c99", flights=2)
        >>> made.passed, (made.folder / "export.json").exists()
        (True, True)

    """
    exporter, given = find_exporter(target), as_gains(gains)
    home = (given.path or Path("gains.json")).resolve().parent
    folder = home / "export" / exporter.name if out is None else Path(out)
    before = None if previous is None else Path(previous)
    subject = given.to_export(study)
    made = subject.export(exporter, texts(options), before, folder, flights, watcher or default_watcher(), force)
    return Exported(made)


@dataclass(frozen=True)
class Imported(Documented):
    """Gains that a vehicle flies.

    Attributes:
        gains: The gains.
        notes: A sentence for each thing that was taken as default or left out.
        untouched: Parameters in the file that do not act in these loops.

    """

    gains: QuadrotorGains
    notes: tuple[str, ...]
    untouched: tuple[str, ...]
    source: str
    parameters: Path

    @property
    def document(self) -> PlainTable:
        """Everything as data, as `tuner import --json` prints it."""
        content = self.gains.document
        stated = {key: content[key] for key in ("gains", "vehicle") if key in content}
        rest = {"untouched": list(self.untouched), "notes": list(self.notes), "file": str(self.gains.path)}
        return {**stated, **rest}

    def _repr_html_(self) -> str:
        return shown("Imported gains", self.notes, self.gains.table)


def import_gains(
    parameters: str | Path,
    source: str,
    airframe: str,
    out: str | Path | None = None,
    *,
    options: Options = MappingProxyType({}),
) -> Imported:
    """Read the gains that a vehicle flies already from its parameter file.

    Args:
        parameters: The file.
        source: Name of a source; see `catalogue("sources")`.
        airframe: Bundled name or TOML file of the vehicle's airframe.
        out: A gains.json to write; it must not exist.
        options: Options of the source, such as `{"firmware": "1.15"}`.

    Returns:
        The gains, and notes on what did not fit.

    Raises:
        InputError: The file is wrong; the message names the parameter.
        StoreError: The gains.json exists already, or cannot be written.

    Examples:
        >>> imported = tuner.import_gains("quad.params", "px4", "iris")
        >>> imported.gains.laws
        {'position': 'pid', 'attitude': 'pid'}

    """
    if out is not None and Path(out).exists():
        raise taken(Path(out))
    vehicle = load(airframe, allow_unphysical=True)
    imported = import_parameters(source, Path(parameters), vehicle, texts(options))
    gains = gains_of(imported.controller, {})
    if out is not None:
        gains = replace(gains, path=write_new(Path(out), gains.document, parents=True))
    return Imported(gains, imported.notes, imported.untouched, source, Path(parameters))


def texts(options: Options) -> list[str]:
    """Return options as NAME=VALUE texts."""
    return [f"{name}={value}" for name, value in options.items()] if isinstance(options, Mapping) else list(options)
