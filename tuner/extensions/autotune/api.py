"""Autotune: from flight logs and present parameters to tuned ones.

Each stage is a function of this interface and leaves its files, which the next one reads. The same call goes on where an earlier
one ended, and a file that was edited between two stages is used as it is. A stage is on record with all that it read.
"""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from plant.errors import InputError, check_name
from plant.own_code import refuse_program
from plant.quadrotor.airframes import load
from tuner.api.frames import Documented, frame, shown
from tuner.api.results import TuningResults, open_results
from tuner.extensions.autopilots.process import BINARY
from tuner.extensions.autopilots.sources import GAINS, guess_source
from tuner.extensions.autotune.document import (
    AUTOTUNE_FORMAT,
    AUTOTUNE_VERSION,
    DONE,
    STOPPED,
    AutotuneDocument,
    StageRow,
)
from tuner.extensions.autotune.page import autotune_page
from tuner.extensions.autotune.stage import FIRST_FLIGHTS, RUN, Setup, Stage
from tuner.extensions.autotune.stages import STAGES
from tuner.extensions.identification.api import LogLike, read_logs
from tuner.extensions.judge.vehicle_files import find_source, read_parameter_file
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.step_records.key_inputs import Inputs, step_key
from tuner.extensions.step_records.keyed_folder import KeyedFolder, StepState
from tuner.search.watcher import Watcher, default_watcher
from tuner.text.tables import Table

KIND = "autotune"
"""Kind of the folder."""
DOCUMENT, PAGE = "autotune.json", "index.html"
"""Names in the folder."""
KINDS = {"Crazyflie": "crazyflie", "PX4": "px4", "ArduPilot": "ardupilot", "Betaflight": "betaflight"}
"""First word of a kind of log -> firmware."""


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
        """True if all stages are done."""
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
    restart: str | None = None,
    threads: int | None = None,
    watcher: Watcher | None = None,
) -> Autotuned:
    """Tune a vehicle from its flight logs and its parameter file.

    Stages: identification, import, study, search, export, opinion, confirmation where the firmware is at hand, first flights.
    A call with the same arguments goes on with the folder. A stage is on record with all that it read: where an input changed
    since, the call is refused and names it.

    Args:
        logs: Flight logs of the vehicle, as of `identify`.
        vehicle: Parameter file of what it flies: PX4, ArduPilot, Betaflight or Crazyflie.
        out: Folder.
        airframe: Prior: a bundled airframe or a TOML file. Its mass and lengths are taken as given.
        source: Firmware of the file; guessed from its content by default.
        mapping: TOML file that says what the columns of CSV logs are.
        binary: Program or checkout of the firmware, to fly finalists in it, as of `confirm`.
        restart: Stage that is done again with all after it; edits of its files in the folder are lost.
        threads: Threads, by default one for each core.
        watcher: Callbacks that hear of progress.

    Returns:
        The stages with their results; the way may end early, with a sentence on the reason.

    Raises:
        InputError: A file is wrong, or a log is of another firmware than the parameters.
        StoreError: The folder holds something else, or an input was changed after a stage had read it.

    Examples:
        >>> tuner.autotune("log15@55:90", "present.yaml", "tuned", airframe="crazyflie-pybullet")  # doctest: +SKIP
        >>> tuner.autotune("log15", "quad.params", "tuned", airframe="crazyflie-pybullet")
        Traceback (most recent call last):
        plant.errors.InputError: log15: is a log of crazyflie, and quad.params holds parameters of px4; give those of one vehicle

    """
    if binary is not None:
        refuse_program(binary, BINARY)
    given = [logs] if isinstance(logs, str | Path) else list(logs)
    chosen = _firmware_of(Path(vehicle), source)
    read = read_logs(given, mapping)
    # Wrong arguments are refused before a folder is made.
    _check_kinds(read, Path(vehicle), chosen)
    read_parameter_file(Path(vehicle), chosen, load(airframe, allow_unphysical=True))
    if restart is not None:
        check_name("stage", restart, [stage.name for stage in STAGES], key="--restart")
    with KeyedFolder.begin(Path(out), KIND) as keyed:
        setup = Setup(
            given, read, Path(vehicle), Path(out), keyed.folder, airframe, chosen, mapping, binary, threads,
            watcher or default_watcher(),
        )  # fmt: skip
        chain = _Chain(keyed, setup)
        if restart is not None:
            chain.restart(restart)
        return chain.carry_out()


def _firmware_of(vehicle: Path, source: str | None) -> str:
    """Return the firmware of a parameter file; InputError where it is of none."""
    name = guess_source(vehicle) if source is None else find_source(source)
    if name == GAINS:
        raise InputError("is no parameter file of a firmware; give what the vehicle's own tool saves", file=vehicle)
    return name


def _check_kinds(logs: Sequence[FlightLog], vehicle: Path, source: str) -> None:
    """Raise InputError for a log of another firmware than the parameters."""
    for log in logs:
        if (other := KINDS.get(log.kind.split()[0], source)) != source:
            message = f"is a log of {other}, and {vehicle} holds parameters of {source}; give those of one vehicle"
            raise InputError(message, file=log.name)


class _Chain:
    """The stages of one call.

    Args:
        keyed: Folder with their record.
        setup: Arguments.
    """

    def __init__(self, keyed: KeyedFolder, setup: Setup) -> None:
        self._keyed, self._setup = keyed, setup
        self._stages = [stage(setup) for stage in STAGES]

    def restart(self, name: str) -> None:
        """Forget a stage and all after it, and remove their files."""
        names = [stage.name for stage in self._stages]
        removed = self._stages[names.index(name) :]
        self._keyed.forget(stage.name for stage in removed)
        for stage in removed:
            stage.clear(to_go_on=False)

    def carry_out(self) -> Autotuned:
        """Carry out all stages, write document and page, and return both."""
        setup = self._setup
        document = self._document(list(self._rows()))
        setup.folder.write_json(DOCUMENT, document)
        setup.folder.write_bytes(PAGE, autotune_page(document, setup.out, _choice(setup.out)).text().encode())
        return Autotuned(document, setup.out)

    def _rows(self) -> Iterator[StageRow]:
        """Yield the rows of the stages, to the end of the way."""
        before = ""
        wanted = [stage for stage in self._stages if stage.is_wanted]
        for number, stage in enumerate(wanted, 1):
            inputs = stage.inputs()
            reason, seconds = self._carried_out(stage, inputs, before, f"Stage {number} of {len(wanted)}: {stage.name}")
            yield StageRow(
                stage=stage.name,
                state=DONE if reason is None else STOPPED,
                sentence=stage.sentence() if reason is None else reason,
                folder=stage.outputs[0],
                seconds=round(seconds, 2),
            )
            if reason is not None:
                return
            if not stage.is_leaf:
                before = step_key(inputs, before)

    def _carried_out(self, stage: Stage, inputs: Inputs, before: str, text: str) -> tuple[str | None, float]:
        """Make a stage unless it is on record; return the reason for an end here, and its time [s].

        text: what its messages begin with.
        """
        on_message = self._setup.watcher.on_message
        state = self._keyed.state(stage.name, inputs, before, f"--restart {shlex.quote(stage.name)}")
        if state == StepState.DONE and (self._setup.out / stage.outputs[0]).exists():
            on_message(f"{text}, on record")
            return None, 0.0
        on_message(f"{text} ...")
        begin = perf_counter()
        stage.clear(to_go_on=state in (StepState.BEGUN, StepState.STOPPED))
        self._keyed.start(stage.name, inputs, before)
        reason = stage.make()
        self._keyed.end(stage.name, StepState.DONE if reason is None else StepState.STOPPED)
        return reason, perf_counter() - begin

    def _document(self, rows: list[StageRow]) -> AutotuneDocument:
        setup, last = self._setup, rows[-1]
        is_done = last.state == DONE
        opinion = next((row.sentence for row in rows if row.stage == "opinion"), "")
        steps = f"load {setup.out / FIRST_FLIGHTS}/step1 first, fly it, and go on step by step"
        return AutotuneDocument(
            format=AUTOTUNE_FORMAT,
            version=AUTOTUNE_VERSION,
            source=setup.source,
            airframe=setup.airframe,
            logs=[str(log) for log in setup.given_logs],
            vehicle=str(setup.vehicle),
            stages=rows,
            is_complete=is_done,
            sentence=f"{opinion} Next: {steps}." if is_done else last.sentence,
            commands=[f"tuner show {setup.out / RUN}"] if is_done else [],
        )


def _choice(out: Path) -> list[Table]:
    """Return objectives and limits of the result, nothing without one."""
    if not (out / RUN / "summary.json").exists():
        return []
    results = open_results(out / RUN, kind=TuningResults)
    return [results.view(name) for name in ("objectives", "limits")]
