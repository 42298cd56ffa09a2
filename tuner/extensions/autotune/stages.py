"""Stages of an autotune: their files, all that they read, and their results in a sentence."""

from pathlib import Path
from shutil import rmtree

from plant.input_files import read_input
from plant.quadrotor.airframes import load
from tuner.api.exporting import export
from tuner.api.gains import quadrotor_gains, read_gains
from tuner.api.results import TuningResults, open_results
from tuner.api.runs import resume, run
from tuner.documents.assessment import AssessmentDocument
from tuner.documents.export import ExportDocument
from tuner.documents.summary import ComparedRow
from tuner.extensions.autotune.stage import (
    CONFIRMATION,
    EXPORT,
    EXPORTED,
    FIRST_FLIGHTS,
    FIT,
    FIT_PAGE,
    GAINS,
    OPINION,
    PLAN,
    PLAN_PAGE,
    PRESENT,
    RUN,
    STUDY,
    VEHICLE,
    Setup,
    Stage,
    input_at,
)
from tuner.extensions.autotune.study import autotune_study
from tuner.extensions.first_flights.approach_api import approach
from tuner.extensions.first_flights.approach_document import ApproachDocument
from tuner.extensions.first_flights.confirmation_api import confirm, program_digest
from tuner.extensions.first_flights.confirmation_document import ConfirmationDocument
from tuner.extensions.first_flights.confirmation_page import verdicts
from tuner.extensions.flight_plans.api import plan_flight
from tuner.extensions.identification.api import check_logs, identify
from tuner.extensions.identification.checks import SILENT
from tuner.extensions.identification.document import IdentificationDocument
from tuner.extensions.judge.api import judge
from tuner.extensions.judge.vehicle_files import read_parameter_file
from tuner.extensions.step_records.key_inputs import DIGEST, Inputs
from tuner.study.layers import read_layers
from tuner.text.numbers import significant
from tuner.text.toml_text import with_paths
from tuner.text.units import after_number
from tuner.text.version import version

NEEDED = ("inertia.x", "inertia.y")
"""Numbers without which no gains of roll and pitch can be tuned."""


class IdentificationStage(Stage):
    """Identification of the vehicle from the logs."""

    name = "identification"
    outputs = (FIT, VEHICLE, FIT_PAGE, PLAN, PLAN_PAGE)

    def inputs(self) -> Inputs:
        """Return logs, mapping and prior."""
        setup = self.setup
        logs: dict[str, str] = {"number": str(len(setup.logs))}
        digests = [log.digest for log in setup.logs]
        for i, log in enumerate(setup.logs, start=1):
            logs[f"part of log {i}"] = f"{log.time[0]:g} to {log.time[-1]:g} s"
        prior = load(setup.airframe, allow_unphysical=True)
        inputs = {
            "version of the product": {"version": version()},
            "logs": logs | {DIGEST: " ".join(digests)},
            "airframe file": input_at(Path(prior.path)),
            "firmware": {"name": setup.source},
        }
        return inputs if setup.mapping is None else inputs | {"mapping file": input_at(Path(setup.mapping))}

    def make(self) -> str | None:
        """Identify the vehicle, or plan the flight that would."""
        setup = self.setup
        findings = check_logs(setup.logs, airframe=setup.airframe).document.findings
        useless = [finding for finding in findings if finding.severity == "useless"]
        if useless and all(finding.text == SILENT for finding in useless):
            return self._plan(
                "The log does not identify the vehicle: rotation and lift are uncorrelated with the motors."
            )
        fit = identify(
            setup.logs,
            airframe=setup.airframe,
            out=self.out / VEHICLE,
            report=self.out / FIT_PAGE,
            watcher=self.watcher,
        )
        missing = [row.name for row in fit.document.numbers if row.name in NEEDED and not row.identified]
        if missing:
            return self._plan(
                f"The log does not identify {', '.join(missing)}, without which roll and pitch cannot be tuned."
            )
        self.folder.write_json(FIT, fit.document)
        return None

    def _plan(self, reason: str) -> str:
        """Plan the flight that would identify the vehicle; return the reason for the end with its verdict."""
        source = self.setup.source
        target = source if source in ("ardupilot", "betaflight") else "csv"
        planned = plan_flight(
            self.setup.airframe, to=target, out=self.out / PLAN, report=self.out / PLAN_PAGE, watcher=self.watcher
        )
        return f"{reason} {planned.document.verdict} Fly {PLAN}/ and give its log."

    def sentence(self) -> str:
        """Return the verdict on the fit."""
        return IdentificationDocument.read(self.out / FIT).verdict.partition(". ")[0] + "."


class ImportStage(Stage):
    """Import of the present gains; SI units of a parameter depend on the vehicle, so the identified one is taken."""

    name = "import"
    reads = (VEHICLE,)

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.outputs = (PRESENT, setup.present)

    def inputs(self) -> Inputs:
        """Return the parameter file and the vehicle."""
        return {**super().inputs(), "parameter file": input_at(self.setup.vehicle)}

    def make(self) -> None:
        """Copy the parameter file and read it."""
        setup = self.setup
        self.folder.write_bytes(setup.present, read_input(setup.vehicle))
        present = read_parameter_file(self.out / setup.present, setup.source, load(self.out / VEHICLE))
        present.gains.write(self.out / PRESENT)

    def sentence(self) -> str:
        """Return the origin of the gains."""
        setup = self.setup
        return f"Gains of {setup.source}'s loops, read from {setup.vehicle.name} with the identified vehicle."


class StudyStage(Stage):
    """Study over the vehicles that the logs leave open."""

    name = "study"
    outputs = (STUDY,)
    reads = (PRESENT, VEHICLE)

    def make(self) -> None:
        """Write the study."""
        present = quadrotor_gains(read_gains(self.out / PRESENT))
        airframe = load(self.out / VEHICLE)
        text = autotune_study(self.setup.source, airframe, Path(VEHICLE), present, Path(PRESENT))
        self.folder.write_text(STUDY, text)

    def sentence(self) -> str:
        """Return the advice to edit it."""
        return f"{STUDY}; edit it and give the command again."


class SearchStage(Stage):
    """Search of the study."""

    name = "search"
    outputs = (RUN,)
    reads = (STUDY, PRESENT, VEHICLE)

    def inputs(self) -> Inputs:
        """Return the study with all files that it and its bases name."""
        files: dict[str, Path] = {}

        def note(name: str) -> str:
            files[name] = self.out / name
            return name

        for layer in read_layers(self.out / STUDY):
            files[layer.path.name] = layer.path
            with_paths(layer.table, note)
        named = {name: input_at(path) for name, path in files.items()}
        return {**named, **super().inputs()}

    def clear(self, to_go_on: bool) -> None:
        """Remove the run, unless it can be resumed."""
        if not (to_go_on and (self.out / RUN / "run.json").exists()):
            super().clear(to_go_on)

    def make(self) -> str | None:
        """Run the study, or resume its run."""
        folder, threads = self.out / RUN, self.setup.threads
        if folder.exists():
            results = resume(folder, watcher=self.watcher, threads=threads)
        else:
            results = run(self.out / STUDY, folder, watcher=self.watcher, threads=threads)
        return None if results.feasible else " ".join(getattr(results.document, "ending", []))

    def sentence(self) -> str:
        """Return the objectives of the default and of the recommended point."""
        summary = open_results(self.out / RUN, kind=TuningResults).document
        rows = [row for row in summary.table if isinstance(row, ComparedRow) and row.kind == "objective"]
        changes = [
            f"{row.label} {significant(row.default.value, 3)} to {significant(row.tuned.value, 3)}{after_number(row.unit)}"
            for row in rows
        ]
        return f"Point {summary.tuned}, {summary.held_out} flights: {', '.join(changes)}."


class ExportStage(Stage):
    """Export of the recommended gains as parameters, with a rollback."""

    name = "export"
    outputs = (EXPORT,)

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.reads = (GAINS, setup.present)

    def make(self) -> None:
        """Export the gains."""
        setup = self.setup
        export(
            self.out / GAINS,
            setup.source,
            self.out / EXPORT,
            options=setup.export_options,
            previous=self.out / setup.present,
            watcher=self.watcher,
        )

    def sentence(self) -> str:
        """Return the files and the verdict after rounding."""
        document = ExportDocument.read(self.out / EXPORTED)
        verdict = "rounding breaks no limit" if document.verification.passed else "rounding breaks a limit"
        return f"{', '.join(document.files)} for {document.target_version}; {verdict}."


class OpinionStage(Stage):
    """Second opinion on the export against the present parameters."""

    name = "opinion"
    outputs = (OPINION,)

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.reads = (EXPORTED, setup.present, VEHICLE)

    def inputs(self) -> Inputs:
        """Return export, present parameters and vehicle."""
        return {**super().inputs(), "exported parameters": input_at(self._exported)}

    @property
    def _exported(self) -> Path:
        (file, *_) = ExportDocument.read(self.out / EXPORTED).files
        return self.out / EXPORT / file

    def make(self) -> str | None:
        """Judge the exported parameters; those that are refused are not left to be loaded."""
        setup = self.setup
        opinion = judge(
            self._exported,
            self.out / setup.present,
            airframe=str(self.out / VEHICLE),
            source=setup.source,
            out=self.out / OPINION,
            threads=setup.threads,
            watcher=self.watcher,
        )
        if opinion.passed:
            return None
        rmtree(self.out / EXPORT)
        return f"{opinion.document.sentence} No export is left, and no flight is planned; the gains are in {GAINS}."

    def sentence(self) -> str:
        """Return the sentence of the opinion."""
        return read_opinion(self.out).sentence


class ConfirmationStage(Stage):
    """Flights of finalists in the firmware."""

    name = "confirmation"
    outputs = (CONFIRMATION,)
    reads = (GAINS, f"{RUN}/front.csv")
    is_leaf = True

    @property
    def is_wanted(self) -> bool:
        """True if the firmware is at hand."""
        return self.setup.binary is not None

    def inputs(self) -> Inputs:
        """Return the firmware's program and the result of the search."""
        binary = self.setup.binary
        assert binary is not None
        return {**super().inputs(), "program of the firmware": {DIGEST: program_digest(self.setup.source, binary)}}

    def make(self) -> None:
        """Fly the finalists in the firmware."""
        setup = self.setup
        assert setup.binary is not None
        confirm(self.out / RUN, setup.source, setup.binary, out=self.out / CONFIRMATION, watcher=self.watcher)

    def sentence(self) -> str:
        """Return the verdicts."""
        return " ".join(verdicts(ConfirmationDocument.read(self.out / CONFIRMATION / "confirm.json")))


class FirstFlightsStage(Stage):
    """Steps from the present gains to the tuned ones."""

    name = "first flights"
    outputs = (FIRST_FLIGHTS,)

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.reads = (GAINS, PRESENT, STUDY, setup.present)

    def make(self) -> None:
        """Plan the steps."""
        setup = self.setup
        approach(
            self.out / PRESENT,
            self.out / GAINS,
            study=self.out / STUDY,
            to=setup.source,
            options=setup.export_options,
            previous=self.out / setup.present,
            out=self.out / FIRST_FLIGHTS,
            watcher=self.watcher,
        )

    def sentence(self) -> str:
        """Return the number of steps and their verdict."""
        document = ApproachDocument.read(self.out / FIRST_FLIGHTS / "approach.json")
        short = "a margin falls short, or flights are lost, on the way"
        verdict = "every one keeps its margins" if document.passed else short
        return f"{len(document.steps) - 1} steps from the present to the tuned gains; {verdict}."


STAGES: tuple[type[Stage], ...] = (
    IdentificationStage,
    ImportStage,
    StudyStage,
    SearchStage,
    ExportStage,
    OpinionStage,
    ConfirmationStage,
    FirstFlightsStage,
)
"""Stages in their order."""


def read_opinion(out: Path) -> AssessmentDocument:
    """Return the document of the opinion in a folder."""
    return AssessmentDocument.read(out / OPINION / "assessment.json")
