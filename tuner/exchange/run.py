"""One export from beginning to end: carry gains over, verify what the target holds, write the folder."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Generic

from plant.errors import InputError
from plant.input_files import read_input
from plant.quadrotor.cascade import Cascade
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tuner.documents.export import ExportDocument
from tuner.documents.parts import LawNames
from tuner.exchange.aboard import remembered
from tuner.exchange.advice import bundle_or_advise
from tuner.exchange.registry import exporters, settings_of
from tuner.exchange.target import (
    Bundle,
    C,
    ExportBundle,
    ExportRequest,
    ExportTarget,
    PlantBundle,
    PlantRequest,
    Request,
)
from tuner.exchange.verification import FLIGHTS, Loops, plant_loops, quadrotor_loops, verify_export
from tuner.exchange.writing import LoopNames, check_free, export_document, export_records, write_export
from tuner.gains import Controller, content_hash
from tuner.gains.sections import Row
from tuner.search.watcher import Watcher
from tuner.store.document import json_text
from tuner.study.plant_controller import PlantController
from tuner.text.sentences import counted

QUIET = Watcher()


@dataclass(frozen=True)
class Export:
    """Result of an export: content of export.json, the folder, and the title of the airframe or plant."""

    document: ExportDocument
    folder: Path
    airframe: str


@dataclass(frozen=True)
class ExportSubject(Generic[C]):
    """Gains on their way to a target.

    Attributes:
        controller: The gains with what they fly.
        content: Content of their gains.json.
        digest: Digest of the content (64 hex digits).
        title: Title of the airframe or the plant.
        names: Names of vehicle and laws.
        loops: Return a controller to be verified.
        check: Refuse a target that does not take such gains.
        bundle: Return what a target makes of a request.
    """

    controller: C
    content: Row
    digest: str
    title: str
    names: LoopNames
    loops: Callable[[C], Loops]
    check: Callable[[ExportTarget, ExportRequest[C]], None]
    bundle: Callable[[ExportTarget, ExportRequest[C]], ExportBundle[C]]

    def export(
        self,
        target: ExportTarget,
        given: Sequence[str],
        previous: Path | None,
        out: Path,
        flights: int = FLIGHTS,
        watcher: Watcher = QUIET,
        force: bool = False,
    ) -> Export:
        """Export the gains into a new folder.

        Args:
            target: Target of the export.
            given: NAME=VALUE options.
            previous: See `ExportRequest`.
            out: The folder.
            flights: Flights before and after rounding.
            watcher: Hears of compilation and flights.
            force: Whether gains of a run where nothing was feasible are exported, too.

        Raises:
            InputError: The target cannot hold something.
            StoreError: The folder cannot be written.
        """
        check_free(out)
        check_feasible(self.content, force)
        request = ExportRequest(self.controller, self.digest, {}, previous)
        self.check(target, request)
        settings = settings_of(target, remembered(self.controller, target, list(given)))
        request = replace(request, settings=settings)
        bundle = bundle_or_advise(target, request, self.bundle)
        loops = self.loops(self.controller), self.loops(bundle.held)
        verification = verify_export(*loops, flights, watcher, bundle.gyro)
        document = export_document(target, request, bundle, verification, self.names)
        content = self.content | {"exports": [*self.content.get("exports", []), *export_records(document)]}
        write_export(out, bundle, document, content)
        return Export(document, out, self.title)


def quadrotor_subject(controller: Controller, content: Row) -> ExportSubject[Controller]:
    """Return the gains of a quadrotor with the content of their file."""
    cascade, airframe = controller.cascade, controller.airframe
    names: LoopNames = {
        "airframe": airframe.name,
        "laws": LawNames(position=cascade.position.name, attitude=cascade.attitude.name),
    }
    return ExportSubject(
        controller, content, content_hash(content), airframe.title, names, quadrotor_loops, check_laws, bundle_of
    )


def plant_subject(controller: PlantController, content: Row, file: Path | None) -> ExportSubject[PlantController]:
    """Return a plant's gains with the content of their file; file: None where there is none."""
    system = controller.study.system
    names: LoopNames = {
        "plant": system.plant.name,
        "channel_laws": {each.name: each.law.name for each in system.plan.channels},
    }
    digest = sha256(json_text(content).encode() if file is None else read_input(file)).hexdigest()
    return ExportSubject(
        controller, content, digest, system.plant.title, names, plant_loops, check_plants, bundle_of_plant
    )


def check_feasible(content: Row, force: bool) -> None:
    """Refuse gains marked as breaking limits of their study, unless forced."""
    study = content.get("study", {})
    if study.get("feasible", True) or force:
        return
    raise InputError(
        f"infeasible gains: {study.get('point', 'the point')} violates limits of its study; do not fly them. Tune again, or use "
        "--force to export for a test bench",
        key="study.feasible",
    )


def check_laws(target: ExportTarget, request: Request) -> None:
    """Refuse laws that a target does not have: what it would fly is then another controller."""
    cascade = request.controller.cascade
    for loop, law, carried in (
        ("attitude", cascade.attitude.name, target.attitude_laws),
        ("position", cascade.position.name, target.position_laws),
    ):
        if carried and law not in carried:
            raise InputError(
                f"the {loop} law is {law}, and '{target.name}' carries {', '.join(carried)} only; export it with "
                f"--to {' or '.join(carriers(cascade))}, or tune a controller that the target has",
                key=f"controller.{loop}",
            )


def carriers(cascade: Cascade) -> list[str]:
    """Return the targets that have the laws of a cascade."""
    return [
        name
        for name, target in exporters().items()
        if cascade.attitude.name in (target.attitude_laws or [cascade.attitude.name])
        and cascade.position.name in (target.position_laws or [cascade.position.name])
    ]


def check_plants(target: ExportTarget, _: PlantRequest) -> None:
    """Refuse a target that takes quadrotors alone."""
    if target.export_plant is None:
        raise InputError(
            f"given {target.name}, which takes the loops of a quadrotor; user plants are written in c99: --to c99",
            key="--to",
        )


def bundle_of_plant(target: ExportTarget, request: PlantRequest) -> PlantBundle:
    """Return the bundle of a plant's controller."""
    assert target.export_plant is not None, "see `check_plants`"
    return target.export_plant(request)


def bundle_of(target: ExportTarget, request: Request) -> Bundle:
    """Return the bundle of a controller; gains are finite before, numbers in the target's ranges after it."""
    controller = request.controller
    for gain in gain_addresses(controller.cascade):
        value = controller.gains[gain.column]
        if not isfinite(value):
            raise InputError(f"given {value}; a gain must be a finite number in {gain.unit}", key=gain.address)
    bundle = target.export(request)
    for parameter in bundle.parameters:
        if not parameter.fits:
            raise InputError(
                f"{parameter.name} would be {parameter.held:g} {parameter.unit}; '{target.name}' allows {parameter.low:g} to "
                f"{parameter.high:g} {parameter.unit}",
                key=parameter.name,
            )
    by_hand = (*(() if bundle.notches else notch_texts(controller.options)), *battery_texts(controller.options))
    return replace(bundle, differences=(*bundle.differences, *by_hand))


def notch_texts(options: ControlOptions) -> tuple[str, ...]:
    """Return settings by hand for notches that follow the rotors, if any."""
    if not options.rpm_notches:
        return ()
    harmonics, quality, least = options.rpm_notches, options.rpm_notch_q, options.rpm_notch_min
    return (
        f"Notches at {counted(harmonics, 'harmonic')} of the speed of each rotor (Q {quality:g}, from {least:g} Hz on) stand "
        "before the laws and are not written; flights and margins have them, so set them: in Betaflight rpm_filter_harmonics = "
        f"{harmonics}, rpm_filter_q = {100.0 * quality:.0f}, rpm_filter_min_hz = {least:.0f}, rpm_filter_fade_range_hz = "
        f"{0.5 * least:.0f}, elsewhere its own.",
    )


def battery_texts(options: ControlOptions) -> tuple[str, ...]:
    """Return settings by hand for the compensation of battery sag, if any."""
    if not options.battery_compensation:
        return ()
    return (
        f"The compensation of the battery's sag, {options.battery_compensation:.0%} of it, is not written; flights and margins "
        "have it, so set the target's: MC_BAT_SCALE_EN in PX4, MOT_BAT_VOLT_MAX and MOT_BAT_VOLT_MIN in ArduPilot.",
    )
