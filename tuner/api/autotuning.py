"""Autotune: from flight logs and present parameters to tuned ones.

Each stage is a function of this interface and leaves its files, which the next one reads. The same call goes on where an earlier
one ended, and a file that was edited between two stages is used as it is.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from time import perf_counter
from typing import NamedTuple

from plant.errors import InputError, StoreError
from plant.input_files import file_sha256, parse_json, read_input, read_input_text
from plant.own_code import refuse_program
from plant.quadrotor.airframes import load
from tuner.analysis.identification.checks import SILENT
from tuner.api.approaching import approach
from tuner.api.autotune_study import autotune_study
from tuner.api.confirming import confirm
from tuner.api.exporting import export
from tuner.api.flight_plans import plan_flight
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import quadrotor_gains, read_gains
from tuner.api.identifying import LogLike, check_logs, identify, read_logs
from tuner.api.judging import judge
from tuner.api.results import TuningResults, open_results
from tuner.api.runs import resume, run
from tuner.api.vehicle_files import find_source, read_parameter_file
from tuner.documents.approach import ApproachDocument
from tuner.documents.assessment import REFUSED, AssessmentDocument
from tuner.documents.autotune import AUTOTUNE_FORMAT, AUTOTUNE_VERSION, DONE, STOPPED, AutotuneDocument, StageRow
from tuner.documents.confirmation import ConfirmationDocument
from tuner.documents.export import ExportDocument
from tuner.documents.identification import IdentificationDocument
from tuner.documents.summary import ComparedRow
from tuner.engines.firmware.process import BINARY
from tuner.exchange.sources import GAINS, SOURCES, guess_source
from tuner.exchange.target import FIRMWARE
from tuner.report.autotune_page import autotune_page
from tuner.report.confirmation_page import verdicts
from tuner.search.watcher import Watcher
from tuner.store.advice import QUESTION
from tuner.store.folder import Folder
from tuner.text.numbers import significant
from tuner.text.tables import Table
from tuner.text.units import after_number

PRESENT, VEHICLE, FIT, FIT_PAGE = "present.json", "vehicle.toml", "identification.json", "vehicle.html"
STUDY, RUN, EXPORT, OPINION = "study.toml", "run", "export", "opinion"
CONFIRMATION, FIRST_FLIGHTS, PLAN, PLAN_PAGE = "confirmation", "first_flights", "plan", "plan.html"
DOCUMENT, PAGE, RECORD = "autotune.json", "index.html", "stages.json"
"""Names in the folder."""
NEEDED = ("inertia.x", "inertia.y")
"""Numbers without which no gains of roll and pitch can be tuned."""
KINDS = {"Crazyflie": "crazyflie", "PX4": "px4", "ArduPilot": "ardupilot", "Betaflight": "betaflight"}
"""First word of a kind of log -> firmware."""


class Stage(NamedTuple):
    """A stage.

    Attributes:
        name: of the stage.
        output: file or folder that it writes.
        inputs: files that it reads, below the folder.
        make: function that writes the output; it returns a sentence where the way ends here.
        result: function that returns the output's result in a sentence.
    """

    name: str
    output: str
    inputs: tuple[str, ...]
    make: Callable[[], str | None]
    result: Callable[[], str]


@dataclass(frozen=True)
class Autotuned(Documented):
    """Result of an autotune.

    Attributes:
        document: Content of autotune.json.
        folder: Folder with the files of every stage and index.html.
    """

    document: AutotuneDocument
    folder: Path

    @property
    def passed(self) -> bool:
        """True if all stages are done and the opinion does not object."""
        return self.document.is_complete

    def _repr_html_(self) -> str:
        return shown("Autotune", [self.document.sentence], frame(self.document.stages, "stage"))


def autotune(
    logs: LogLike | Sequence[LogLike],
    vehicle: str | Path,
    out: str | Path,
    *,
    airframe: str,
    source: str | None = None,
    mapping: str | Path | None = None,
    binary: str | Path | None = None,
    threads: int | None = None,
    watcher: Watcher | None = None,
) -> Autotuned:
    """Tune a vehicle from its flight logs and its parameter file.

    Stages: identification, import, study, search, export, opinion, confirmation where the firmware is at hand, first flights.
    A call with the same arguments goes on with the folder.

    Args:
        logs: Flight logs of the vehicle, as of `identify`.
        vehicle: Parameter file of what it flies: PX4, ArduPilot, Betaflight or Crazyflie.
        out: Folder.
        airframe: What is known beforehand: a bundled airframe or a TOML file. Its mass and lengths are taken as given.
        source: Firmware of the file; guessed from its content by default.
        mapping: TOML file that says what the columns of CSV logs are.
        binary: Program or checkout of the firmware, to fly finalists in it, as of `confirm`.
        threads: Threads, by default one for each core.
        watcher: Callbacks that hear of progress.

    Returns:
        The stages with their results; the way may end early, with a sentence on the reason.

    Raises:
        InputError: A file is wrong, or a log is of another firmware than the parameters.
        StoreError: The folder holds something else, or a file was changed after a stage had read it.

    Examples:
        >>> tuner.autotune("log15@55:90", "present.yaml", "tuned", airframe="crazyflie-pybullet")  # doctest: +SKIP
        >>> tuner.autotune("log15", "quad.params", "tuned", airframe="crazyflie-pybullet")
        Traceback (most recent call last):
        plant.errors.InputError: log15: is a log of crazyflie, and quad.params holds parameters of px4; give those of one vehicle

    """
    if binary is not None:
        refuse_program(binary, BINARY)
    given = [logs] if isinstance(logs, str | Path) else list(logs)
    chain = _Chain(given, Path(vehicle), Path(out), airframe, source, mapping, binary, threads, watcher or Watcher())
    return chain.carry_out()


class _Chain:
    """The stages of one call."""

    def __init__(
        self,
        logs: Sequence[LogLike],
        vehicle: Path,
        out: Path,
        airframe: str,
        source: str | None,
        mapping: str | Path | None,
        binary: str | Path | None,
        threads: int | None,
        watcher: Watcher,
    ) -> None:
        self._logs, self._given, self._out, self._airframe = logs, vehicle, out, airframe
        self._mapping, self._binary, self._threads, self._watcher = mapping, binary, threads, watcher
        self._source = guess_source(vehicle) if source is None else find_source(source)
        if self._source == GAINS:
            raise InputError("is no parameter file of a firmware; give what the vehicle's own tool saves", file=vehicle)
        self._read = read_logs(logs, mapping)
        for log in self._read:
            if (other := KINDS.get(log.kind.split()[0], self._source)) != self._source:
                message = (
                    f"is a log of {other}, and {vehicle} holds parameters of {self._source}; give those of one vehicle"
                )
                raise InputError(message, file=log.name)
        # Wrong files are refused before a folder is made.
        read_parameter_file(vehicle, self._source, load(airframe, allow_unphysical=True))

    def carry_out(self) -> Autotuned:
        """Carry out all stages, write document and page, and return both."""
        with self._begun() as folder:
            self._folder = folder
            rows = list(self._rows())
            document = self._document(rows)
            folder.write_json(DOCUMENT, document)
            folder.write_bytes(PAGE, autotune_page(document, self._out, self._choice()).text().encode())
        return Autotuned(document, self._out)

    def _begun(self) -> Folder:
        """Make the folder, or go on with it; StoreError where it holds another autotune."""
        digests = [*(log.digest for log in self._read), file_sha256(self._given)]
        times = [[float(log.time[0]), float(log.time[-1])] for log in self._read]
        question = json.dumps([digests, times, self._airframe, self._source])
        file = self._out / QUESTION
        if not file.exists():
            folder = Folder.create(self._out, inside="", empty=True)
            folder.write_text(QUESTION, question)
            folder.write_bytes(self._present, read_input(self._given))
            return folder
        folder = Folder.open(self._out)
        if read_input_text(file) != question:
            folder.close()
            raise StoreError(f"{self._out} holds an autotune of other files; choose another folder with --out")
        return folder

    @property
    def _present(self) -> str:
        """Name of the copy of the parameter file."""
        return f"present{self._given.suffix}"

    @property
    def _options(self) -> dict[str, str]:
        """Options of the exports: the firmware's version, where names depend on it."""
        options = SOURCES[self._source].options(self._given)
        return {FIRMWARE: options[FIRMWARE]} if FIRMWARE in options else {}

    @cached_property
    def _stages(self) -> tuple[Stage, ...]:
        stages = (
            Stage("identification", FIT, (), self._identify, self._identified),
            Stage("import", PRESENT, (self._present, VEHICLE), self._import, self._imported),
            Stage(
                "study",
                STUDY,
                (PRESENT, VEHICLE),
                self._write_study,
                lambda: f"{STUDY}; edit it and give the command again.",
            ),
            Stage("search", RUN, (STUDY, PRESENT, VEHICLE), self._search, self._searched),
            Stage("export", EXPORT, (f"{RUN}/gains.json",), self._export, self._exported),
            Stage("opinion", OPINION, (f"{EXPORT}/export.json",), self._judge, lambda: self._opinion.sentence),
            Stage("confirmation", CONFIRMATION, (f"{RUN}/gains.json",), self._confirm, self._confirmed),
            Stage("first flights", FIRST_FLIGHTS, (f"{RUN}/gains.json", PRESENT), self._approach, self._approached),
        )
        return tuple(stage for stage in stages if stage.output != CONFIRMATION or self._binary is not None)

    def _rows(self) -> Iterator[StageRow]:
        """Yield the rows of the stages, to the end of the way."""
        file = self._out / RECORD
        record: dict[str, str] = parse_json(read_input_text(file)) if file.exists() else {}
        for stage in self._stages:
            inputs = "".join(file_sha256(self._out / name) for name in stage.inputs)
            begin, key = perf_counter(), sha256(inputs.encode()).hexdigest()
            output, reason, seconds = self._out / stage.output, None, 0.0
            if record.get(stage.name) == key and output.exists():
                self._watcher.on_message(f"{stage.name}: on record")
            else:
                self._check_unread(stage, record)
                self._watcher.on_message(f"{stage.name} ...")
                reason, seconds = stage.make(), perf_counter() - begin
                if reason is None:
                    record[stage.name] = key
                    self._folder.write_json(RECORD, record)
            yield StageRow(
                stage=stage.name,
                state=DONE if reason is None else STOPPED,
                sentence=stage.result() if reason is None else reason,
                folder=stage.output,
                seconds=round(seconds, 2),
            )
            if reason is not None:
                return

    def _check_unread(self, stage: Stage, record: dict[str, str]) -> None:
        """Raise StoreError where a stage is on record with other files; remove what an interrupted one left."""
        output = self._out / stage.output
        if stage.name in record and output.exists():
            changed = ", ".join(stage.inputs)
            raise StoreError(
                f"{changed} changed after the {stage.name}; remove {output} and all later ones to make them again"
            )
        if output.is_dir() and stage.output != RUN:
            rmtree(output)

    def _import(self) -> None:
        # What a parameter means in SI units depends on the vehicle, so it is read with the identified one.
        (self._out / PRESENT).unlink(missing_ok=True)
        read_parameter_file(self._out / self._present, self._source, load(self._out / VEHICLE)).gains.write(
            self._out / PRESENT
        )

    def _imported(self) -> str:
        return f"Gains of {self._source}'s loops, read from {self._given.name} with the identified vehicle."

    def _identify(self) -> str | None:
        findings = check_logs(self._logs, airframe=self._airframe, mapping=self._mapping).document.findings
        useless = [finding for finding in findings if finding.severity == "useless"]
        if useless and all(finding.text == SILENT for finding in useless):
            return self._plan("The log tells nothing of this vehicle: neither turning nor lift follow the motors.")
        for name in (VEHICLE, FIT_PAGE):
            (self._out / name).unlink(missing_ok=True)
        fit = identify(
            self._logs, airframe=self._airframe, mapping=self._mapping, out=self._out / VEHICLE, report=self._out / FIT_PAGE,
            watcher=self._watcher,
        )  # fmt: skip
        missing = [row.name for row in fit.document.numbers if row.name in NEEDED and not row.identified]
        if missing:
            return self._plan(
                f"The log tells nothing of {', '.join(missing)}, without which roll and pitch cannot be tuned."
            )
        self._folder.write_json(FIT, fit.document)
        return None

    def _plan(self, reason: str) -> str:
        """Return the reason for the end, with the planned flight."""
        rmtree(self._out / PLAN, ignore_errors=True)
        (self._out / PLAN_PAGE).unlink(missing_ok=True)
        target = self._source if self._source in ("ardupilot", "betaflight") else "csv"
        planned = plan_flight(
            self._airframe, to=target, out=self._out / PLAN, report=self._out / PLAN_PAGE, watcher=self._watcher
        )
        return f"{reason} {planned.document.verdict} Fly {PLAN}/ and give its log."

    def _identified(self) -> str:
        return IdentificationDocument.read(self._out / FIT).verdict.partition(". ")[0] + "."

    def _write_study(self) -> None:
        present = quadrotor_gains(read_gains(self._out / PRESENT))
        airframe = load(self._out / VEHICLE)
        text = autotune_study(self._source, airframe, Path(VEHICLE), present, Path(PRESENT))
        self._folder.write_text(STUDY, text)

    def _search(self) -> str | None:
        folder = self._out / RUN
        if folder.exists():
            results = resume(folder, watcher=self._watcher, threads=self._threads)
        else:
            results = run(self._out / STUDY, folder, watcher=self._watcher, threads=self._threads)
        return None if results.feasible else " ".join(getattr(results.document, "ending", []))

    def _searched(self) -> str:
        summary = open_results(self._out / RUN, kind=TuningResults).document
        rows = [row for row in summary.table if isinstance(row, ComparedRow) and row.kind == "objective"]
        changes = [
            f"{row.label} {significant(row.default.value, 3)} to {significant(row.tuned.value, 3)}{after_number(row.unit)}"
            for row in rows
        ]
        return f"Point {summary.tuned}, {summary.held_out} flights: {', '.join(changes)}."

    def _choice(self) -> list[Table]:
        """Return objectives and limits of the result, nothing without one."""
        if not (self._out / RUN / "summary.json").exists():
            return []
        results = open_results(self._out / RUN, kind=TuningResults)
        return [results.view(name) for name in ("objectives", "limits")]

    def _export(self) -> None:
        export(
            self._out / RUN / "gains.json",
            self._source,
            self._out / EXPORT,
            options=self._options,
            previous=self._out / self._present,
            watcher=self._watcher,
        )

    def _exported(self) -> str:
        document = ExportDocument.read(self._out / EXPORT / "export.json")
        verdict = "rounding breaks no limit" if document.verification.passed else "rounding breaks a limit"
        return f"{', '.join(document.files)} for {document.target_version}; {verdict}."

    def _judge(self) -> None:
        (file, *_) = ExportDocument.read(self._out / EXPORT / "export.json").files
        judge(
            self._out / EXPORT / file,
            self._out / self._present,
            airframe=str(self._out / VEHICLE),
            source=self._source,
            out=self._out / OPINION,
            threads=self._threads,
            watcher=self._watcher,
        )

    @property
    def _opinion(self) -> AssessmentDocument:
        return AssessmentDocument.read(self._out / OPINION / "assessment.json")

    def _confirm(self) -> None:
        assert self._binary is not None
        confirm(self._out / RUN, self._source, self._binary, out=self._out / CONFIRMATION, watcher=self._watcher)

    def _confirmed(self) -> str:
        return " ".join(verdicts(ConfirmationDocument.read(self._out / CONFIRMATION / "confirm.json")))

    def _approach(self) -> None:
        approach(
            self._out / PRESENT,
            self._out / RUN / "gains.json",
            study=self._out / STUDY,
            to=self._source,
            options=self._options,
            previous=self._out / self._present,
            out=self._out / FIRST_FLIGHTS,
            watcher=self._watcher,
        )

    def _approached(self) -> str:
        document = ApproachDocument.read(self._out / FIRST_FLIGHTS / "approach.json")
        short = "a margin falls short, or flights are lost, on the way"
        verdict = "every one keeps its margins" if document.passed else short
        return f"{len(document.steps) - 1} steps from the present to the tuned gains; {verdict}."

    def _document(self, rows: list[StageRow]) -> AutotuneDocument:
        last = rows[-1]
        is_done = last.state == DONE
        objection = next((row.sentence for row in rows if row.stage == "opinion"), "") if is_done else ""
        is_refused = is_done and self._opinion.verdict in REFUSED
        steps = f"load {self._out / FIRST_FLIGHTS}/step1 first, fly it, and go on step by step"
        return AutotuneDocument(
            format=AUTOTUNE_FORMAT,
            version=AUTOTUNE_VERSION,
            source=self._source,
            airframe=self._airframe,
            logs=[str(log) for log in self._logs],
            vehicle=str(self._given),
            stages=rows,
            is_complete=is_done and not is_refused,
            sentence=last.sentence if not is_done else objection if is_refused else f"{objection} Next: {steps}.",
            commands=[f"tuner show {self._out / RUN}"] if is_done else [],
        )
