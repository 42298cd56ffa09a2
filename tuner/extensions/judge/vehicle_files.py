"""Files of gains as vehicles have them: source guessed, loops of the firmware, the vehicle that they are judged on."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from plant.errors import InputError, one_line, shortened
from plant.input_files import InputFile, ReadableFile, file_sha256
from plant.quadrotor.airframes import Airframe, load
from tuner.api.gains import QuadrotorGains, gains_of, quadrotor_gains, read_gains
from tuner.documents.assessment import AssessedAirframe, AssessedFile, ParameterChange
from tuner.exchange.registry import import_parameters
from tuner.exchange.registry import importer as find_importer
from tuner.exchange.texts import WRITTEN_BY
from tuner.extensions.autopilots.resolution import MAX_LOG_BYTES, Resolved, plain_file
from tuner.extensions.autopilots.sources import (
    GAINS,
    Values,
    changed_values,
    check_versions,
    guess_source,
    overlaid,
    sources,
    version_fault,
)
from tuner.extensions.autopilots.vehicle_facts import VehicleFact
from tuner.extensions.judge.vehicle_class import class_airframe, ranges_text
from tuner.extensions.judge.vehicle_facts import Contradiction, contradictions, narrowed

HEADING_BYTES = 2000
"""Length of the beginning of a file in which an export has its heading."""


@dataclass(frozen=True)
class GainsFile:
    """A file with the gains that a vehicle flies after loading it.

    Attributes:
        path: The file.
        part: Its entry in the document.
        gains: Gains of the loops.
        notes: Differences of the model's loops, and assumptions.
        values: Parameters of the vehicle after loading the file.
        wiring: Its settings that are no parameters.
    """

    path: ReadableFile
    part: AssessedFile
    gains: QuadrotorGains
    notes: tuple[str, ...] = ()
    values: Values = field(default_factory=dict[str, str | float])
    wiring: Values = field(default_factory=dict[str, str | float])


@dataclass(frozen=True)
class Subjects:
    """Subjects of an opinion: the file, that of the present gains or None, and the vehicle.

    Attributes:
        after: File to judge.
        before: File of the present gains, or None.
        airframe: The vehicle.
        guessed: Sentence on the source, None where it was named.
        contradictions: Numbers of the files that the airframe contradicts.
    """

    after: GainsFile
    before: GainsFile | None
    airframe: AssessedAirframe
    guessed: str | None
    contradictions: Sequence[Contradiction] = ()

    @property
    def source(self) -> str:
        """Firmware of the files, or "gains"."""
        return self.after.part.source

    @property
    def unmodeled_changes(self) -> list[ParameterChange]:
        """Changed parameters that no loop of the model has."""
        record = self.after.gains.controller.vehicle
        if self.source == GAINS or record is None:
            return []
        kind = sources()[self.source]
        modeled = (set(record.parameters) - set(record.untuned) - kind.left_out) | kind.scaling
        return [row for row in self.changed_parameters if row.name not in modeled]

    @property
    def not_restored(self) -> list[str]:
        """Parameters of the file that the earlier one does not hold."""
        return [row.name for row in self.changed_parameters if row.before is None]

    @cached_property
    def changed_parameters(self) -> list[ParameterChange]:
        """Parameters that differ on the vehicle after loading the file."""
        if self.before is None:
            return []
        changed = changed_values(self.before.values, self.after.values)
        return [parameter_change(name, *values) for name, values in changed.items()]


@dataclass(frozen=True)
class GivenFiles:
    """Files to judge before their gains are read.

    Attributes:
        source: Firmware of both, or "gains".
        after: File to judge.
        before: File of the present gains, or None.
        airframe: Name or file of the vehicle, or None.
        guessed: Sentence on the source, None where it was named.
    """

    source: str
    after: InputFile
    before: InputFile | None
    airframe: str | None
    guessed: str | None

    @cached_property
    def read_after(self) -> InputFile:
        """The file to judge as text, with its includes."""
        return plain_file(self.after, self.resolved_after)

    @cached_property
    def read_before(self) -> InputFile | None:
        """The present gains likewise, loadable as a rollback."""
        return None if self.before is None else plain_file(self.before, _resolved(self.before, self.source))

    @cached_property
    def resolved_after(self) -> Resolved | None:
        """A log, a script or a preset with includes as text."""
        return _resolved(self.after, self.source)

    @cached_property
    def chosen(self) -> Airframe:
        """The airframe of parameter files: as named, or the class of the firmware."""
        if self.airframe is None:
            return class_airframe(self.source)
        return load(self.airframe, allow_unphysical=True)

    @cached_property
    def facts(self) -> Sequence[VehicleFact]:
        """Facts on the vehicle, those of the present file first."""
        return [fact for _, facts in self._facts_by_file for fact in facts]

    @cached_property
    def vehicle(self) -> Airframe:
        """The airframe, narrowed by the facts of the files; where both have one, by that of the present file.

        An export of this tool has the numbers of the airframe that it was made for: no vehicle was measured.
        """
        measured = [fact for file, facts in self._facts_by_file if not is_export(file) for fact in facts]
        first = {fact.quantity: fact for fact in reversed(measured)}
        return narrowed(self.chosen, list(first.values()))

    @cached_property
    def _facts_by_file(self) -> list[tuple[InputFile, Sequence[VehicleFact]]]:
        # Names mean what they mean in a known version only.
        if self.version_fault:
            return []
        kind, files = sources()[self.source], (self.read_before, self.read_after)
        return [(file, kind.facts(kind.values(file))) for file in files if file is not None]

    @cached_property
    def version_fault(self) -> str:
        """The fault in the version of the firmware, "" without one."""
        files = [file for file in (self.read_after, self.read_before) if file is not None]
        return "" if self.source == GAINS else version_fault(sources()[self.source], files)

    @property
    def assumed(self) -> AssessedAirframe:
        """The entry of the vehicle of parameter files in a document."""
        return _airframe_part(self.vehicle, self.airframe is not None)


def is_export(file: InputFile) -> bool:
    """Whether this tool wrote a file, by its heading."""
    return WRITTEN_BY.encode() in file.content[:HEADING_BYTES]


def name_files(given: Path, present: Path | None, source: str | None, airframe: str | None) -> GivenFiles:
    """Return files with their source, to be read once; InputError where they are of two firmwares.

    Args:
        given: The file to judge.
        present: Gains of the vehicle at present, or None.
        source: Firmware of both, or "gains"; None to guess it.
        airframe: Name or file of the vehicle, None if none is named.
    """
    after, before = (None if path is None else InputFile(path, most=MAX_LOG_BYTES) for path in (given, present))
    assert after is not None
    name = guess_source(after) if source is None else find_source(source)
    guessed = f"Read as a file of {name}, guessed from its lines." if source is None else None
    if before is not None and source is None and (other := guess_source(before)) != name:
        raise InputError(f"is a file of {other}, and {after} one of {name}; give files of one firmware", file=before)
    return GivenFiles(name, after, before, airframe, guessed)


def read_subjects(given: GivenFiles) -> Subjects:
    """Read the gains of files; InputError where two files are not of one vehicle."""
    name, after, before = given.source, given.after, given.before
    if name == GAINS:
        return _read_gains_files(after, before, given.airframe, given.guessed)
    vehicle, assumed, contradicted = given.vehicle, given.assumed, contradictions(given.facts, given.chosen)
    alone = _with_part_of(after, read_parameter_file(given.read_after, name, vehicle))
    notes = () if given.resolved_after is None else given.resolved_after.notes
    if before is None or given.read_before is None:
        return Subjects(replace(alone, notes=(*notes, *alone.notes)), None, assumed, given.guessed, contradicted)
    earlier = _with_part_of(before, read_parameter_file(given.read_before, name, vehicle))
    check_versions(sources()[name], given.read_before, given.read_after)
    merged = InputFile(after.path, overlaid(sources()[name], given.read_before, given.read_after).encode())
    together = read_parameter_file(merged, name, vehicle)
    later = replace(together, path=after, part=alone.part, notes=(*notes, *together.notes))
    return Subjects(later, earlier, assumed, given.guessed, contradicted)


def _resolved(file: InputFile, source: str) -> Resolved | None:
    return None if source == GAINS else sources()[source].resolved(file)


def _with_part_of(given: InputFile, read: GainsFile) -> GainsFile:
    """Return a resolved file with path and digest of the given one."""
    return replace(read, path=given, part=file_part(given, read.part.source, read.part.version))


def find_source(name: str) -> str:
    """Return a source by its name; UnknownNameError where there is none."""
    return name if name == GAINS else find_importer(name).name


def read_parameter_file(path: ReadableFile, source: str, airframe: Airframe) -> GainsFile:
    """Return the gains of a parameter file in the firmware's own loops."""
    options = [f"{name}={value}" for name, value in sources()[source].options(path).items()]
    imported = import_parameters(source, path, airframe, options)
    record = imported.controller.vehicle
    version = None if record is None else record.target_version
    kind = sources()[source]
    return GainsFile(
        path,
        file_part(path, source, version),
        gains_of(imported.controller, {}),
        imported.notes,
        kind.values(path),
        kind.wiring(path),
    )


def file_part(path: ReadableFile, source: str, version: str | None = None) -> AssessedFile:
    """Return the entry of a file in a document."""
    return AssessedFile(file=str(path), source=source, version=version, sha256=file_sha256(path, MAX_LOG_BYTES))


def parameter_change(name: str, before: str | float | None, after: str | float | None) -> ParameterChange:
    """Return a parameter that differs, with its values as texts."""
    return ParameterChange(name=name, before=_text(before), after=_text(after))


def _text(value: str | float | None) -> str | None:
    if value is None:
        return None
    return shortened(one_line(value)) if isinstance(value, str) else f"{value:.9g}"


def _read_gains_files(
    after: InputFile, before: InputFile | None, airframe: str | None, guessed: str | None
) -> Subjects:
    """Return gains.json files with their airframe; InputError where it is not one and the same."""
    later = _read_gains(after, airframe)
    earlier = None if before is None else _read_gains(before, airframe)
    vehicle = later.gains.controller.airframe
    if earlier is not None and (other := earlier.gains.controller.airframe).vehicle != vehicle.vehicle:
        message = f"flies {other.name}, and {after} flies {vehicle.name}; give one for both with --airframe"
        raise InputError(message, file=before)
    return Subjects(later, earlier, _airframe_part(vehicle, True), guessed)


def _read_gains(file: InputFile, airframe: str | None) -> GainsFile:
    return GainsFile(file, file_part(file, GAINS), quadrotor_gains(read_gains(file.path, airframe)))


def _airframe_part(airframe: Airframe, is_known: bool) -> AssessedAirframe:
    return AssessedAirframe(name=airframe.name, title=airframe.title, is_known=is_known, ranges=ranges_text(airframe))
