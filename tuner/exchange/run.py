"""One export from beginning to end: read the gains, carry them over, verify what the target holds, write the folder."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

from plant.errors import InputError
from plant.gains import gain_addresses
from plant.input_files import read_input_text
from plant.nominal import ControlOptions
from tuner.documents.export import ExportDocument
from tuner.exchange.aboard import remembered
from tuner.exchange.autopilot.parameters import fits
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Bundle, ExportTarget, Request
from tuner.exchange.verification import FLIGHTS, Verification, verify_export
from tuner.exchange.writing import check_free, export_document, export_records, write_export
from tuner.gains import content_sha256, read_gains
from tuner.search.watcher import Watcher
from tuner.text.sentences import counted

QUIET = Watcher()


@dataclass(frozen=True)
class Export:
    """Result of an export: content of export.json, its verification, the folder, and the title of the airframe."""

    document: ExportDocument
    verification: Verification
    folder: Path
    airframe: str


def export_gains(
    gains: Path, target: ExportTarget, given: Sequence[str], previous: Path | None, out: Path, flights: int = FLIGHTS,
    watcher: Watcher = QUIET, force: bool = False,
) -> Export:  # fmt: skip
    """Export a gains.json; given: NAME=VALUE options; previous: see `Request`; watcher hears of compilation and flights; force:
    export gains of a run that found nothing feasible, too.

    Raises InputError naming what the target cannot hold, StoreError where the folder cannot be written.
    """
    check_free(out)
    controller = read_gains(gains)
    content = json.loads(read_input_text(gains))
    check_feasible(content, force)
    settings = settings_of(target, remembered(controller, target, list(given)))
    request = Request(controller, content_sha256(gains), settings, previous)
    check_laws(target, request)
    bundle = bundle_of(target, request)
    verification = verify_export(request, bundle, flights, watcher)
    document = export_document(target, request, bundle, verification)
    content |= {"exports": [*content.get("exports", []), *export_records(document)]}
    write_export(out, bundle, document, content)
    return Export(document, verification, out, request.controller.airframe.title)


def check_feasible(content: dict[str, Any], force: bool) -> None:
    """Refuse gains that say themselves that they break limits of their study, unless forced."""
    study = content.get("study", {})
    if study.get("feasible", True) or force:
        return
    raise InputError(
        f"these gains are of a run that found nothing feasible: {study.get('point', 'the point')} breaks limits of its study, so "
        "it is not to be flown; tune again until something is feasible, or add --force to write it for a test bench all the same",
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
                f"the {loop} law is {law}, and '{target.name}' carries {', '.join(carried)} only; export it as code instead "
                "(--to c99, crazyflie or fmi), or tune a controller that the target has",
                key=f"controller.{loop}",
            )


def bundle_of(target: ExportTarget, request: Request) -> Bundle:
    """Return what a target makes of a controller; gains are finite before, numbers in the target's ranges after it."""
    controller = request.controller
    for gain in gain_addresses(controller.cascade):
        value = controller.gains[gain.column]
        if not isfinite(value):
            raise InputError(f"given {value}; a gain must be a finite number in {gain.unit}", key=gain.address)
    bundle = target.export(request)
    for parameter in bundle.parameters:
        if not fits(parameter):
            raise InputError(
                f"{parameter.name} would be {parameter.held:g} {parameter.unit}; '{target.name}' allows {parameter.low:g} to "
                f"{parameter.high:g} {parameter.unit}",
                key=parameter.name,
            )
    by_hand = (*(() if bundle.notches else notch_texts(controller.options)), *battery_texts(controller.options))
    return replace(bundle, differences=(*bundle.differences, *by_hand))


def notch_texts(options: ControlOptions) -> tuple[str, ...]:
    """Return what is to be set by hand for notches that follow the rotors, nothing where there are none."""
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
    """Return what is to be set by hand for the compensation of a battery's sag, nothing where there is none."""
    if not options.battery_compensation:
        return ()
    return (
        f"The compensation of the battery's sag, {options.battery_compensation:.0%} of it, is not written; flights and margins "
        "have it, so set the target's: MC_BAT_SCALE_EN in PX4, MOT_BAT_VOLT_MAX and MOT_BAT_VOLT_MIN in ArduPilot.",
    )
