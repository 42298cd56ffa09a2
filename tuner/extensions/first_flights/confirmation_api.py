"""Confirmation of a run's finalists in a real firmware."""

from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from objectives.own_meters import metering
from objectives.problem import FlightBatch, Objective, score_flights
from objectives.system import System
from plant.errors import InputError
from plant.input_files import file_sha256
from plant.own_code import refuse_program
from plant.quadrotor.airframes.actuation import actuation
from plant.ties import increasing_order
from tuner.api.frames import Documented, frame, shown
from tuner.api.studies import of_class
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import Bundle, Request
from tuner.experiments.compare.entrants import Entrant, read_folder
from tuner.extensions.autopilots.firmware import Bench, Firmware
from tuner.extensions.autopilots.flying import FirmwareFlights
from tuner.extensions.autopilots.process import BINARY
from tuner.extensions.autopilots.registry import firmware_of
from tuner.extensions.first_flights.confirmation import PairedFlights, confirmed_points, confirmed_quantities
from tuner.extensions.first_flights.confirmation_document import (
    CONFIRMATION_FORMAT,
    CONFIRMATION_VERSION,
    ConfirmationDocument,
)
from tuner.extensions.first_flights.confirmation_page import confirmation_page, verdicts
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation, default_watcher
from tuner.store.folder import Folder
from tuner.study.study import Study

if TYPE_CHECKING:
    import pandas as pd

STREAM = "confirm"
"""Name of the stream of scenarios, which no search and no held-out check flies."""
FINALISTS, FLIGHTS, MIN_FLIGHTS = 8, 16, 2
STAGE = "Flying the firmware"
# What the exporter writes the hash of the gains into, for gains that stand in no file.
NO_DIGEST = "0" * 64
# A firmware's program is some megabytes.
LARGEST_PROGRAM = 1_000_000_000


@dataclass(frozen=True)
class Confirmation(Documented):
    """Finalists flown in a firmware.

    Attributes:
        document: Output of `tuner confirm --json`.
        folder: Folder of confirm.json and confirm.md, None if none was written.

    """

    document: ConfirmationDocument
    folder: Path | None = None

    @property
    def page(self) -> str:
        """The findings as Markdown, content of confirm.md."""
        return confirmation_page(self.document)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each finalist and metric: firmware, model, and their difference with its interval."""
        rows = [
            {
                "finalist": point.point,
                "metric": quantity.label,
                "firmware": value.firmware,
                "model": value.model,
                "gap": value.gap.value,
                "gap low": value.gap.low,
                "gap high": value.gap.high,
            }
            for point in self.document.points
            for quantity, value in zip(self.document.quantities, point.values, strict=True)
        ]
        return frame(rows, ["finalist", "metric"])

    def _repr_html_(self) -> str:
        return shown(f"Flown in {self.document.firmware}", verdicts(self.document), self.table)


def confirm(
    results: str | Path,
    firmware: str,
    binary: str | Path,
    *,
    finalists: int = FINALISTS,
    flights: int = FLIGHTS,
    out: str | Path | None = None,
    threads: int = 1,
    watcher: Watcher | None = None,
) -> Confirmation:
    """Fly finalists of a run in a real firmware, and in simulation.

    The firmware flies on our plant in our turbulence; its flights are compared with our simulation's.

    Args:
        results: Folder of a tuning run whose attitude law is the firmware's own, such as one of the study betaflight.
        firmware: Name of a firmware; see `docs/how_to/confirm.md`.
        binary: The firmware's program, built by you from its source; of the Crazyflie its module,
            or the folder that holds it; of ArduPilot and PX4 the folder
            of their sources.
        finalists: How many points of the front fly, the recommended one among them.
        flights: Flights of each scenario and finalist.
        out: New folder for confirm.json and confirm.md.
        threads: Boards that fly at once.
        watcher: Callbacks that hear of compilation and flights.

    Returns:
        Rank correlation of the finalists between firmware and model, and the gap in each metric, with intervals.

    Raises:
        InputError: The run flies another law, or the firmware is missing, silent, dead or answers nonsense.
        StoreError: The run is not finished, or the folder holds something already.

    Examples:
        >>> made = tuner.confirm("results/betaflight", "betaflight", "betaflight_SITL", flights=4)  # doctest: +SKIP
        >>> made.document.quantities[0].correlation.value  # doctest: +SKIP
        1.0
        >>> tuner.confirm("results/betaflight", "betaflight", "not_built")
        Traceback (most recent call last):
            ...
        plant.errors.InputError: not_built: --binary: cannot be read: No such file or directory

    """
    chosen, heard = firmware_of(firmware), watcher or default_watcher()
    if flights < MIN_FLIGHTS or finalists < 1:
        message = f"given {finalists} finalists and {flights} flights; allowed: at least 1 and {MIN_FLIGHTS}"
        raise InputError(message, key="--flights")
    refuse_program(binary, BINARY)
    program = chosen.program(Path(binary))
    digest = _digest(program)
    entrant, study = _entrant(Path(results), chosen)
    folder = None if out is None else Folder.create(Path(out), inside="", empty=True)
    with folder or nullcontext():
        rows = _spread(entrant, finalists)
        bundles = [_bundle(study.controller(entrant.rows[row]), chosen) for row in rows]
        begin = perf_counter()
        flown = _flown(study, chosen, program, [entrant.points[row] for row in rows], bundles, flights, threads, heard)
        document = ConfirmationDocument(
            format=CONFIRMATION_FORMAT,
            version=CONFIRMATION_VERSION,
            title=study.title,
            firmware=chosen.title,
            target_version=bundles[0].target_version,
            program=digest,
            lockstep=chosen.lockstep,
            seed=study.seed,
            stream=STREAM,
            flights=flights,
            quantities=confirmed_quantities(flown),
            points=confirmed_points(flown),
            notes=[*chosen.loses, *bundles[0].differences],
            seconds=perf_counter() - begin,
        )
        made = Confirmation(document, None if folder is None else folder.path)
        if folder is not None:
            folder.write_json("confirm.json", document)
            folder.write_text("confirm.md", made.page)
    return made


def program_digest(firmware: str, binary: str | Path) -> str:
    """Return the digest of a firmware's program; a checkout is compiled for it."""
    return _digest(firmware_of(firmware).program(Path(binary)))


def _digest(program: Path) -> str:
    try:
        return file_sha256(program, LARGEST_PROGRAM)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=program, key="--binary") from None


def _entrant(results: Path, firmware: Firmware) -> tuple[Entrant, Study]:
    entrant = read_folder(results, results.name)
    refusal = "this run flew no quadrotor; a firmware flies finalists of a quadrotor's tuning run"
    study = of_class(entrant.study, Study, lambda: InputError(refusal, file=results))
    flown = study.system.cascade.attitude.name
    if flown != firmware.law:
        raise InputError(
            f"the attitude law of this run is {flown}; {firmware.title} flies its own loops alone, law '{firmware.law}': tune a "
            f'study with target = "{firmware.target}"',
            file=results,
        )
    if not entrant.points:
        raise InputError("no finalist of this run is feasible, so there is nothing to confirm", file=results)
    firmware.check(study.system.timing.control_period)
    return entrant, study


def _spread(entrant: Entrant, count: int) -> list[int]:
    """Return rows of `count` finalists, evenly along the first objective.

    The recommended one takes the place of its neighbor.
    """
    order = increasing_order(entrant.picked[:, 0])
    places = np.unique(np.linspace(0, len(order) - 1, min(count, len(order))).round().astype(int))
    rows = [int(order[place]) for place in places]
    if entrant.point in entrant.points and (best := entrant.points.index(entrant.point)) not in rows:
        wanted = int(np.flatnonzero(order == best)[0])
        rows[int(np.argmin(np.abs(places - wanted)))] = best
    return rows


def _bundle(controller: Controller, firmware: Firmware) -> Bundle:
    """Return the export of a finalist."""
    target = exporter(firmware.target)
    request = Request(controller, NO_DIGEST, settings_of(target, firmware.options), None)
    check_laws(target, request)
    return bundle_of(target, request)


def _flown(
    study: Study,
    firmware: Firmware,
    program: Path,
    points: list[str],
    bundles: list[Bundle],
    flights: int,
    threads: int,
    watcher: Watcher,
) -> PairedFlights:
    quantities = (*study.objectives, *(constraint.objective for constraint in study.constraints))
    system = metering(study.system, [quantity.metric for quantity in quantities])
    batches = [FlightBatch(scenario.spec, STREAM, flights) for scenario in study.scenarios]
    with compilation(watcher):
        in_firmware = FirmwareFlights(system, firmware, study.seed, threads)
        flyer = system.flyer(threads)
    watcher.on_stage(STAGE, (len(bundles) + 1) * flights * len(batches))
    rows = np.array([bundle.held.gains for bundle in bundles])
    first_flights: list[np.ndarray] = []
    second: list[np.ndarray] = []
    with TemporaryDirectory(prefix="gainproof-") as place:
        for k, bundle in enumerate(bundles):
            bench = Bench(
                program,
                Path(place) / str(k),
                actuation(system.nominal.vehicle, firmware.curve),
                system.timing.control_period,
            )
            power_up = firmware.install(bench, bundle.files[firmware.file])
            for to in (first_flights, second) if k == 0 else (first_flights,):
                parts = [in_firmware.fly(rows[k], power_up, batch, watcher.on_flights_done) for batch in batches]
                to.append(np.array(parts))
    inputs = [system.sample(batch.spec, study.seed, STREAM, range(flights)) for batch in batches]
    simulated = np.stack([flyer.fly(rows, system.nominal, each) for each in inputs], axis=1)
    scores, lost = _scored(system, quantities, np.array(first_flights), batches)
    model, lost_model = _scored(system, quantities, simulated, batches)
    return PairedFlights(
        tuple(points),
        quantities,
        scores,
        model,
        lost,
        lost_model,
        np.repeat([batch.spec.name for batch in batches], flights),
        _scored(system, quantities, np.array(second), batches)[0][0],
        study.seed,
    )


def _scored(
    system: System, quantities: tuple[Objective, ...], results: np.ndarray, batches: list[FlightBatch]
) -> tuple[np.ndarray, np.ndarray]:
    """Return scores (n, quantities, flights) and failures (n, flights) of results (n, batches, flights, rows)."""
    metrics = [quantity.metric for quantity in quantities]
    scored = [
        score_flights(system, metrics, results[:, i], batch.spec, system.targets(batch.spec))
        for i, batch in enumerate(batches)
    ]
    scores, lost = zip(*scored, strict=True)
    return np.concatenate([np.moveaxis(part, 0, 1) for part in scores], axis=-1), np.concatenate(lost, axis=-1)
