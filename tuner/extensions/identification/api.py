"""A vehicle out of flight logs."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError, StoreError, UnphysicalError
from plant.quadrotor.airframes import Airframe, load
from plant.quadrotor.airframes.uncertainty import Uncertainty
from tuner.analysis.airframe_text import new_airframe_file
from tuner.api.frames import Documented, figures, frame, shown
from tuner.extensions.identification.building import earlier_posterior, identification_document, log_row, warnings_of
from tuner.extensions.identification.checks import SILENT, LogIssue, check_flight, is_silent
from tuner.extensions.identification.document import IdentificationDocument, LogCheckDocument, LogFinding, LogRow
from tuner.extensions.identification.flight_rows import after_change, check_agreement
from tuner.extensions.identification.identify import Identified, identify_vehicle
from tuner.extensions.identification.onward import identified_text, uncertainty_of
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit.flights import flights_of
from tuner.extensions.vehicle_fit.parameters import ARM, MASS, EarlierPosterior
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.folder import put

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

LogLike = str | Path
GivenLog = LogLike | FlightLog
"""A log by its file, or one that is read already."""
SPAN = re.compile(r"(?P<file>.+)@(?P<begin>\d+(\.\d+)?):(?P<end>\d+(\.\d+)?)")
"""A log of which a part counts: FILE@BEGIN:END, in seconds of its own clock."""
LARGEST_DEVIATION = 0.5


@dataclass(frozen=True)
class LogCheck(Documented):
    """Problems of logs.

    Attributes:
        document: Output of `tuner identify LOG --check --json`.

    """

    document: LogCheckDocument

    @property
    def usable(self) -> bool:
        """Whether all logs can be identified from."""
        return self.document.usable


@dataclass(frozen=True)
class Identification(Documented):
    """A vehicle out of logs.

    Attributes:
        document: Output of `tuner identify --json`.
        fit: The fit behind it.

    """

    document: IdentificationDocument
    fit: Identified

    @property
    def uncertainty(self) -> Uncertainty:
        """Deviations and correlation of the airframe's numbers."""
        return uncertainty_of(self.fit)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each number: value, 95 % interval, prior, identified or not, with the reason."""
        return frame(self.document.numbers, "name")

    def figure(self) -> "Figure":
        """Draw measurement over prediction on windows held out of the fit.

        Returns:
            The figure, made without pyplot.

        """
        return figures("identification", self.fit).draw("prediction")

    def _repr_html_(self) -> str:
        return shown(f"Identified from {len(self.document.logs)} logs", [self.document.verdict], self.table)


def identify(
    logs: GivenLog | Sequence[GivenLog],
    *,
    airframe: str | Path,
    out: str | Path | None = None,
    mapping: str | Path | None = None,
    mass: float = MASS,
    arm: float = ARM,
    force: bool = False,
    report: str | Path | None = None,
    update: str | Path | None = None,
    changed: str | None = None,
    watcher: Watcher | None = None,
) -> Identification:
    """Identify a vehicle from flight logs and write its airframe file.

    Its numbers have intervals.

    Args:
        logs: Files of flights of one vehicle, or logs read already; FILE@35:65 for the part from 35 to 65 s of the log's clock.
        airframe: Prior: a bundled airframe or a TOML file. Its mass and lengths are taken as given.
        out: Airframe file (TOML) to write, with the numbers found and their [uncertainty]; it must not be there yet.
        mapping: TOML file that says what the columns of CSV logs are.
        mass: Relative standard deviation of the airframe's mass [1].
        arm: Relative standard deviation of the airframe's lengths [1].
        force: Go on where a check says that a log is useless.
        report: Page (HTML) to write: predictions with their band, what is left over, intervals; it must not be there yet.
        update: Document of an earlier identification (JSON) with the same airframe, whose posterior is the prior of these logs.
        changed: Changes since the earlier logs: battery, propellers or firmware. Its numbers are as wide as before any
            log.
        watcher: Callbacks that hear of progress.

    Returns:
        Numbers with intervals and correlations, what the data do not tell, and predictions on windows kept from the fit.

    Raises:
        InputError: A log cannot be read, holds no flight, is useless, or contradicts the earlier ones; or the file to write is
            there already.

    Examples:
        >>> fit = tuner.identify("log15@55:90", airframe="crazyflie-pybullet", out="mine.toml")  # doctest: +SKIP
        >>> fit.table  # doctest: +SKIP

    """
    check_deviation(mass, "mass")
    check_deviation(arm, "arm")
    if update is not None and (mass, arm) != (MASS, ARM):
        raise InputError("takes mass and arm as the earlier logs left them; leave --mass and --arm out", key="update")
    if update is None and changed is not None:
        raise InputError("says what changed since earlier logs; give them as update, or leave it out", key="changed")
    target = None if out is None else new_airframe_file(Path(out))
    page = None if report is None else new_page(Path(report))
    prior, heard = load(airframe, allow_unphysical=True), watcher or default_watcher()
    read = read_logs(logs, mapping)
    posterior, before = _earlier(update, prior, read)
    if posterior is not None and changed is not None:
        posterior = after_change(posterior, changed)
    problems = _problems(read, prior)
    useless = [(log, finding) for log, finding in problems if finding.fatal]
    if useless and not force:
        log, finding = useless[0]
        raise InputError(f"{finding.text} (or use it with --force)", file=log.name)
    steps = _Steps(heard)
    fit = identify_vehicle(read, prior, mass=mass, arm=arm, earlier=posterior, on_progress=steps)
    if update is not None:
        check_agreement(fit, Path(update))
    warnings = warnings_of(problems)
    if target is not None:
        title = f"{prior.title}, identified from flight logs"
        put(target.parent, target.name, identified_text(fit, title, before).encode())
        warnings += refusals_of(target)
    document = identification_document(fit, warnings, None if target is None else str(target), before)
    if page is not None:
        # The library that draws its charts takes a second to import.
        from tuner.extensions.identification.page import identification_page
        from tuner.report.page import put_page

        put_page(page.parent, identification_page(fit, document), page.name)
    return Identification(document, fit)


def check_logs(
    logs: GivenLog | Sequence[GivenLog], *, airframe: str | Path, mapping: str | Path | None = None
) -> LogCheck:
    """Check flight logs before an identification from them.

    Args:
        logs: Files, as of `identify`.
        airframe: About what flew: a bundled airframe or a TOML file.
        mapping: TOML file that says what the columns of CSV logs are.

    Returns:
        Time base, rates, units, axes and order of motors, as far as they contradict physics.

    Raises:
        InputError: A log cannot be read or holds no flight.

    Examples:
        >>> tuner.check_logs("log15", airframe="crazyflie-pybullet").usable
        True

    """
    prior = load(airframe, allow_unphysical=True)
    read = read_logs(logs, mapping)
    problems = _problems(read, prior)
    rows = [
        LogFinding(file=log.name, severity="useless" if finding.fatal else "mind", text=finding.text)
        for log, finding in problems
    ]
    usable = not any(finding.fatal for _, finding in problems)
    return LogCheck(
        LogCheckDocument(airframe=prior.name, logs=[log_row(log) for log in read], findings=rows, usable=usable)
    )


def refusals_of(file: Path) -> list[str]:
    """Return the reason and the remedy where studies refuse an airframe file."""
    try:
        load(file)
    except UnphysicalError as error:
        return [f"{file.name} was written, but studies refuse it as it stands: {error.message}"]
    return []


def _earlier(
    update: str | Path | None, airframe: Airframe, logs: Sequence[FlightLog]
) -> tuple[EarlierPosterior | None, list[LogRow]]:
    """Return an earlier identification and its logs; InputError where one of these logs is among them."""
    if update is None:
        return None, []
    file = Path(update)
    try:
        document = IdentificationDocument.read(file)
    except StoreError:
        raise InputError(
            "is not what `tuner identify --json` prints of earlier logs; print it again", file=file
        ) from None
    before = [*document.before, *document.logs]
    for log in logs:
        if any(log.digest == row.sha256 and _overlaps(log, row.begin, row.end) for row in before):
            raise InputError(f"is in {file.name} already, and would count twice; give the logs after it", file=log.name)
    return earlier_posterior(document, airframe, file), before


def check_deviation(value: float, key: str) -> None:
    """Raise InputError for an implausible relative standard deviation; key: named by the error."""
    if not 0.0 < value <= LARGEST_DEVIATION:
        raise InputError(f"given {value:g}; a relative deviation is above 0, up to {LARGEST_DEVIATION:g}", key=key)


def new_page(page: Path) -> Path:
    """Return the file of a page that is to be written; InputError where it is there already, or is no HTML."""
    if page.suffix not in (".html", ".htm"):
        raise InputError("the page is HTML; give a name that ends in .html", file=page)
    if page.exists():
        raise InputError("is there already; give another name", file=page)
    return page


class _Steps:
    """Progress of the fits, for a watcher."""

    def __init__(self, watcher: Watcher) -> None:
        self._watcher = watcher
        self._is_announced = False

    def __call__(self, step: int, steps: int) -> None:
        if not self._is_announced:
            self._watcher.on_message("Identifying; a minute of flight takes some 20 s.")
            self._is_announced = True


def read_logs(logs: GivenLog | Sequence[GivenLog], mapping: str | Path | None) -> list[FlightLog]:
    """Return logs, or the parts of them that are asked for; InputError where one cannot be read or is given twice."""
    given = [logs] if isinstance(logs, GivenLog) else list(logs)
    if not given:
        raise InputError("no log given; give at least one")
    flight_logs = [_log(entry, None if mapping is None else Path(mapping)) for entry in given]
    for first, second in combinations(flight_logs, 2):
        if first.digest == second.digest and _overlaps(first, float(second.time[0]), float(second.time[-1])):
            raise InputError(
                "is given twice, in parts that overlap, which would make its intervals too narrow; leave one out",
                file=second.name,
            )
    return flight_logs


def _overlaps(log: FlightLog, begin: float, end: float) -> bool:
    return float(log.time[0]) < end and begin < float(log.time[-1])


def _log(given: GivenLog, mapping: Path | None) -> FlightLog:
    if isinstance(given, FlightLog):
        return given
    span = None if Path(given).exists() else SPAN.fullmatch(str(given))
    if span is None:
        return read_log(Path(given), mapping)
    return read_log(Path(span["file"]), mapping).between(float(span["begin"]), float(span["end"]))


def _problems(logs: Sequence[FlightLog], airframe: Airframe) -> list[tuple[FlightLog, LogIssue]]:
    flights = [flight for log in logs for flight in flights_of(log, airframe)]
    problems = [(flight, finding) for flight in flights for finding in check_flight(flight, airframe)]
    silent = [flight for flight in flights if is_silent(flight)]
    # A calm flight beside one that tells is no reason to refuse both.
    problems = [*[(flight, LogIssue(len(silent) == len(flights), SILENT)) for flight in silent], *problems]
    return list({(flight.name, finding): (flight, finding) for flight, finding in problems}.values())
