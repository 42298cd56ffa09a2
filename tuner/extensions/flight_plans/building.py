"""A planned experiment as its document."""

from collections.abc import Sequence

import numpy as np

from tuner.documents.parts import LawNames
from tuner.extensions.flight_plans.document import FlightPlanDocument, PlannedExcitation, PlannedNumber, PlannedPeak
from tuner.extensions.flight_plans.excitation import UNITS, Excitation, begins, length_of
from tuner.extensions.flight_plans.flying import FLIGHTS, HEATING
from tuner.extensions.flight_plans.informativeness import half_widths
from tuner.extensions.flight_plans.planning import MIN_WIDTH_RATIO, Experiment
from tuner.extensions.vehicle_fit.identifiability import GIVEN
from tuner.text.numbers import per_cent
from tuner.text.sentences import counted, listing

PEAKS = {
    "tilt": ("tilt", "rad"),
    "rate": ("largest body rate", "rad/s"),
    "height": ("off the hover height", "m"),
    "motors": ("motors, of the way from hover to idle or full", "1"),
    "rotor_rms": (f"acceleration of a rotor over its hover speed, RMS over {HEATING:g} s", "1/s"),
    "rotor_peak": ("acceleration of a rotor over its hover speed", "1/s"),
    "drift": ("drift over ground without position control", "m"),
}
"""Name of a peak -> meaning, unit."""


def flight_plan_document(
    made: Experiment, target: str, notes: Sequence[str], files: Sequence[str]
) -> FlightPlanDocument:
    """Return the document; notes: of the target; files: names of those that are written."""
    cascade, rows = made.task.simulated.system.cascade, numbers_of(made)
    return FlightPlanDocument(
        airframe=made.task.airframe.name,
        laws=LawNames(position=cascade.position.name, attitude=cascade.attitude.name),
        scenario=made.task.simulated.spec.name,
        target=target,
        duration=length_of(made.excitations),
        flights=FLIGHTS,
        excitations=[
            _excitation(entry, begin) for entry, begin in zip(made.excitations, begins(made.excitations), strict=True)
        ],
        numbers=rows,
        peaks=peaks_of(made),
        notes=list(notes),
        files=list(files),
        verdict=verdict(rows, is_named=bool(made.request.numbers)),
    )


def _excitation(entry: Excitation, begin: float) -> PlannedExcitation:
    return PlannedExcitation(
        axis=entry.axis,
        wave=entry.wave,
        quantity=entry.quantity,
        unit=UNITS[entry.quantity],
        amplitude=entry.amplitude,
        first=entry.first,
        last=entry.last,
        begin=begin,
        duration=entry.duration,
    )


def numbers_of(made: Experiment) -> list[PlannedNumber]:
    """Return the numbers of the vehicle with their intervals before and after."""
    space, fit = made.task.space, made.proof.fit
    before, expected, obtained = (
        half_widths(space, deviations)
        for deviations in (space.prior_std, made.expected.deviations, np.sqrt(np.diag(fit.covariance)))
    )
    targets = _target_half_widths(made).tolist()
    target = {name: width for name, width in zip(space.names, targets, strict=True) if name in made.wanted}
    off = fit.estimate - made.task.truth
    return [
        PlannedNumber(
            name=entry.name,
            meaning=entry.meaning,
            unit=entry.unit,
            value=entry.number(float(made.task.truth[k])),
            relative=entry.positive,
            asked=target.get(entry.name),
            before=float(before[k]),
            foreseen=float(expected[k]),
            obtained=float(obtained[k]),
            error=float(np.expm1(off[k]) if entry.positive else off[k]),
            reason=made.expected.reasons.get(entry.name, ""),
        )
        for k, entry in enumerate(space.parameters[: space.physical])
    ]


def _target_half_widths(made: Experiment) -> np.ndarray:
    """Return the target half-widths (n,), 0 of parameters without a target."""
    std = np.zeros(len(made.task.space.names))
    std[made.accuracy.places] = made.accuracy.deviations
    return half_widths(made.task.space, std)


def peaks_of(made: Experiment) -> list[PlannedPeak]:
    """Return the peaks of the checked flights and their limits."""
    limits = made.request.limits
    return [
        PlannedPeak(name=name, meaning=PEAKS[name][0], unit=PEAKS[name][1], peak=peak, limit=limits.get(name))
        for name, peak in made.checked.peaks.items()
    ]


def width_text(row: PlannedNumber, width: float) -> str:
    """Return a parameter with its expected and its target width."""
    if row.relative:
        return f"{row.name} ({per_cent(row.foreseen)} foreseen, {per_cent(width)} asked)"
    return f"{row.name} ({row.foreseen / width:.2g} times)"


def verdict(rows: Sequence[PlannedNumber], is_named: bool = False) -> str:
    """Return sentences on the expected accuracy, missed targets, and a simulated identification.

    is_named: true where the numbers to be known are named, so that others are not mentioned.
    """
    targets = [(row, row.target) for row in rows if row.target is not None]
    missed = [(row, width) for row, width in targets if row.foreseen > width and not row.reason]
    reached = sum(1 for row, width in targets if row.foreseen <= width and not row.reason)
    sentences = [f"The flight is to tell {counted(reached, 'number')} as narrowly as asked."]
    judged = [row for row in rows if row.target is not None or not is_named]
    untold = [row for row in judged if row.reason and row.name not in GIVEN]
    near = [row.name for row, width in missed if row.foreseen <= MIN_WIDTH_RATIO * width]
    if near:
        sentences.append(f"A little wider than asked: {listing(near)}.")
    wide = [width_text(row, width) for row, width in missed if row.name not in near]
    if wide:
        sentences.append(f"Wider than asked: {listing(wide)}.")
    if untold:
        names, interval = (
            listing([row.name for row in untold]),
            "its interval" if len(untold) == 1 else "their intervals",
        )
        sentences.append(
            f"It does not tell {names}: {interval} would not shrink to half. Allow more (--tilt, --rate), measure on a test "
            "stand, or ask for the others alone (--numbers)."
        )
    ratio = float(np.median([row.obtained / row.foreseen for row, _ in targets]))
    sentences.append(
        f"Identified from a simulated log of it, intervals were {per_cent(ratio)} as wide as foreseen in the median."
    )
    off = [row.name for row, _ in targets if abs(row.error) > 1.5 * row.obtained]
    if off:
        sentences.append(
            f"Of {listing(off)} the truth lay outside by more than half: at that width the sampling of the log counts."
        )
    return " ".join(sentences)
