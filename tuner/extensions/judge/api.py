"""A second opinion before arming, and parameters read back from a vehicle."""

import warnings
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

from plant.errors import InputError
from plant.input_files import InputFile
from plant.output_files import make_folders, write_new_file
from tuner.api.checking import check_requirements
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import Gains, GainsLike
from tuner.api.margins import announce_compilation
from tuner.api.studies import StudyLike
from tuner.documents.assessment import EXIT_CODES, REFUSED, AssessmentDocument
from tuner.exchange.aboard import plain_name
from tuner.extensions.autopilots.resolution import MAX_LOG_BYTES
from tuner.extensions.autopilots.sources import GAINS, differing_values, guess_source, sources
from tuner.extensions.judge.assessing import Stages, assess
from tuner.extensions.judge.document import ReadBackDocument
from tuner.extensions.judge.page import assessment_page
from tuner.extensions.judge.vehicle_files import file_part, find_source, name_files, parameter_change, read_subjects
from tuner.extensions.judge.verdict_basis import missing_basis, unjudged_document
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.folder import Folder
from tuner.study.files import shipped_studies

if TYPE_CHECKING:
    import pandas as pd

FLIGHTS, SEED = 256, 1
MIN_FLIGHTS = 2


@dataclass(frozen=True)
class Assessment(Documented):
    """A second opinion on gains.

    Attributes:
        document: Document as `tuner judge --json` prints it.
        folder: With judge.md, assessment.json and rollback/, None where nothing was written.

    """

    document: AssessmentDocument
    folder: Path | None = None

    @property
    def verdict(self) -> str:
        """The verdict in a word, such as "better" or "worse"."""
        return str(self.document.verdict)

    @property
    def exit_code(self) -> int:
        """Exit code of `tuner judge` with this verdict: 0 no objection, 1 worse or do not fly, 3 not judged."""
        return EXIT_CODES[self.verdict]

    @property
    def passed(self) -> bool:
        """Whether the verdict does not speak against flying."""
        return self.verdict not in REFUSED

    @property
    def page(self) -> str:
        """The opinion as Markdown, content of judge.md."""
        return assessment_page(self.document)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each metric: mean before and after, and their difference as a share with its 95 % interval."""
        rows = [
            {
                "metric": row.label,
                "unit": row.unit,
                "before": row.before,
                "after": row.after,
                **dict(zip(("difference", "low", "high"), row.difference or (None,) * 3, strict=True)),
                "verdict": row.verdict,
            }
            for row in self.document.metrics
        ]
        return frame(rows, "metric")

    def _repr_html_(self) -> str:
        return shown(f"Verdict: {self.verdict}", [self.document.sentence], self.table)


@dataclass(frozen=True)
class ReadBackComparison(Documented):
    """Parameters of a file against what a vehicle holds; document: as `tuner judge --read-back --json` prints it."""

    document: ReadBackDocument

    @property
    def passed(self) -> bool:
        """Whether the vehicle holds everything that was written."""
        return not self.document.differing

    def _repr_html_(self) -> str:
        return shown("Read back", [self.document.sentence], frame(self.document.differing, "name"))


def judge(
    after: GainsLike,
    before: GainsLike | None = None,
    *,
    airframe: str | None = None,
    source: str | None = None,
    flights: int | None = None,
    seed: int = SEED,
    out: str | Path | None = None,
    threads: int | None = None,
    watcher: Watcher | None = None,
) -> Assessment:
    """Judge gains of any tool before a vehicle is armed with them.

    Loops are those of the firmware with their filters. Both files fly the same vehicles in the same air.

    Args:
        after: Parameter file of PX4, ArduPilot, Betaflight or the Crazyflie, gains or a gains.json. With `before`, parameters
            that it does not name stay as there.
        before: The same of what the vehicle flies at present.
        airframe: Bundled name or TOML file of the vehicle; without it that of gains.json, or the class of the firmware.
        source: "px4", "ardupilot", "betaflight", "crazyflie" or "gains"; guessed from the content by default.
        flights: Flights of each file, by default 256.
        seed: Root seed of vehicles, air and noise.
        out: New folder for judge.md, assessment.json and, with `before`, rollback/.
        threads: Threads, by default one for each core.
        watcher: Callbacks that hear of compilation and flights.

    Returns:
        The verdict with its reasons; "not judged" where no gain of a rate loop is in a file, its version is not known, a
        setting differs that decides sense, order, orientation, scale or limits, a number of a file contradicts the airframe, or
        losses come from the airframe's ranges.

    Raises:
        InputError: A file is wrong, or of another firmware or frame, or of two versions, or the airframe cannot be.
        StoreError: The folder holds something already, or cannot be written.

    Examples:
        >>> opinion = tuner.judge("quad.params", airframe="iris", flights=16)
        >>> opinion.document.after.source
        'px4'

    """
    if before is not None and is_study(before):
        warnings.warn("by a study, tuner.judge is tuner.check_requirements now", DeprecationWarning, stacklevel=2)
        return check_requirements(after, cast(StudyLike, before), flights=flights, watcher=watcher, threads=threads)  # pyright: ignore[reportReturnType]
    count = FLIGHTS if flights is None else flights
    if count < MIN_FLIGHTS:
        raise InputError(f"given {count}; allowed: at least {MIN_FLIGHTS}", key="--flights")
    stages, heard = Stages(), watcher or default_watcher()
    folder = None if out is None else Folder.create(Path(out), inside="", empty=True)
    with ExitStack() as stack:
        stack.enter_context(folder or nullcontext())
        with stages.measure("reading"):
            present = None if before is None else file_of(before, stack)
            given = name_files(file_of(after, stack), present, source, airframe)
            fault = given.version_fault
            subjects = None if fault else read_subjects(given)
            reasons = [fault] if subjects is None else missing_basis(subjects)
        if subjects is None or reasons:
            document = unjudged_document(given, subjects, reasons, seed, stages.seconds)
        else:
            announce_compilation(heard)
            document = assess(subjects, count, seed, threads, stages, heard)
        if folder is not None:
            document = write(document, given.read_before, folder)
    return Assessment(document, None if folder is None else folder.path)


def is_study(before: object) -> bool:
    """Return True for a study: in memory, a TOML file or a name."""
    if isinstance(before, str | Path):
        return Path(before).suffix == ".toml" or str(before) in shipped_studies()
    return not isinstance(before, Gains)


def file_of(gains: GainsLike, stack: ExitStack) -> Path:
    """Return the file of gains; that of gains in memory is gone with the stack."""
    return stack.enter_context(gains.file()) if isinstance(gains, Gains) else Path(gains)


def read_back(written: str | Path, dump: str | Path, *, source: str | None = None) -> ReadBackComparison:
    """Compare a vehicle's parameters with the file written to it.

    Args:
        written: Parameter file of PX4, ArduPilot, Betaflight or the Crazyflie.
        dump: The same, read back from the vehicle; it may hold more.
        source: Firmware of both; guessed from the content by default.

    Returns:
        The parameters that differ by more than the firmware's rounding, or are missing.

    Raises:
        InputError: A file is wrong, or they are of two firmwares.

    Examples:
        >>> tuner.read_back("quad.params", "quad.params").passed
        True

    """
    files = InputFile(Path(written), most=MAX_LOG_BYTES), InputFile(Path(dump), most=MAX_LOG_BYTES)
    names = [find_source(source) if source is not None else guess_source(file) for file in files]
    if names[0] != names[1]:
        raise InputError(
            f"is a file of {names[1]}, and {written} one of {names[0]}; give one firmware's", file=files[1]
        )
    if GAINS in names:
        raise InputError(
            "is a gains.json, and a vehicle holds parameters; give the file that was written", file=files[0]
        )
    kind = sources()[names[0]]
    wanted, held = map(kind.values, files)
    rows = [parameter_change(name, *values) for name, values in differing_values(kind, wanted, held).items()]
    missing, compared = sum(row.after is None for row in rows), len(wanted)
    finding = (
        f"{len(rows)} of {compared} differ, {missing} of them missing" if rows else f"all {compared} are as written"
    )
    document = ReadBackDocument(
        format="gainproof-read-back",
        version="0.1",
        written=file_part(files[0], names[0]),
        dump=file_part(files[1], names[0]),
        compared=compared,
        differing=rows,
        sentence=f"Parameters on the vehicle: {finding}.",
    )
    return ReadBackComparison(document)


def write(document: AssessmentDocument, before: InputFile | None, folder: Folder) -> AssessmentDocument:
    """Write page, document and the file to go back to."""
    if before is not None:
        name = f"rollback/{plain_name(before)}"
        make_folders(folder.path / "rollback")
        write_new_file(folder.path / name, before.content)
        document = document.model_copy(update={"rollback": name})
    folder.write_json("assessment.json", document)
    folder.write_text("judge.md", assessment_page(document))
    return document
