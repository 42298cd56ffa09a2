"""Rows of single flights in the document, and sentences on their agreement."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plant.errors import InputError, check_name
from tuner.extensions.identification.document import FlightNumber, FlightRow
from tuner.extensions.identification.identify import Identified
from tuner.extensions.vehicle_fit.parameters import EarlierPosterior, Parameter
from tuner.extensions.vehicle_fit.random_effects import (
    CAUSES,
    QUANTILE,
    FlightEstimate,
    HomogeneityTest,
    between_flight_std,
)
from tuner.text.numbers import per_cent, significant
from tuner.text.sentences import listing

PAYLOAD = (
    "a payload changes the mass, which no log shows: weigh the vehicle, write the mass into a copy of the airframe file, and "
    "identify the new logs with it, without --update"
)
SHOWN_SCATTER = 0.5
"""Scatter is mentioned above this share of a parameter's standard deviation within flights."""


def flight_rows(identified: Identified) -> list[FlightRow]:
    """Return the row of every flight, earlier ones first."""
    parameters = {entry.name: entry for entry in identified.space.parameters}
    untested: list[HomogeneityTest | None] = [None] * (len(identified.all_flights) - len(identified.flights))
    tests = [*untested, *(identified.tests or [None] * len(identified.flights))]
    return [_row(flight, parameters, test) for flight, test in zip(identified.all_flights, tests, strict=True)]


def _row(flight: FlightEstimate, parameters: dict[str, Parameter], test: HomogeneityTest | None) -> FlightRow:
    numbers = []
    for name, value, std in zip(flight.names, flight.point.tolist(), flight.std.tolist(), strict=True):
        low, middle, high = (parameters[name].number(value + k * QUANTILE * std) for k in (-1.0, 0.0, 1.0))
        difference = None if test is None else test.differences.get(name)
        numbers.append(FlightNumber(name=name, value=middle, low=low, high=high, difference=difference))
    return FlightRow(
        flight=flight.flight,
        numbers=numbers,
        statistic=None if test is None else test.statistic,
        degrees=None if test is None else test.degrees,
        probability=None if test is None else test.probability,
    )


def estimate_from(row: FlightRow, parameters: Sequence[Parameter], file: Path) -> FlightEstimate:
    """Return the estimate of a row; InputError where it names others than these parameters or has impossible intervals."""
    by_name = {entry.name: entry for entry in parameters}
    points, variances = [], []
    for number in row.numbers:
        entry = by_name.get(number.name)
        ends = (number.low, number.value, number.high)
        if entry is None or not number.low < number.high or (entry.positive and min(ends) <= 0.0):
            raise InputError(
                f"its flight {row.flight} has a number {number.name} that cannot be; identify the logs again",
                file=file,
                key="flights",
            )
        low, value, high = (np.log(end) if entry.positive else end for end in ends)
        points.append(float(value))
        variances.append(float(((high - low) / (2.0 * QUANTILE)) ** 2))
    names = tuple(number.name for number in row.numbers)
    return FlightEstimate(row.flight, names, np.array(points), np.diag(variances))


def flight_words(identified: Identified) -> list[str]:
    """Return sentences on the agreement of the flights and their scatter."""
    tests = identified.tests
    if not tests:
        return []
    names = [flight.flight for flight in identified.flights]
    has_earlier = identified.space.earlier is not None
    against = "the earlier logs" if has_earlier else "the other flights"
    # Of two flights either contradicts the other: one sentence.
    pairs = list(zip(names, tests, strict=True))[: 1 if len(tests) == 2 and not has_earlier else None]
    rejected = [contradiction_words(name, against, test) for name, test in pairs if test.is_rejected]
    least = min(test.probability for test in tests)
    agreement = [] if rejected else [f"The flights agree (chi-square test, smallest probability {least:.2g})."]
    return [*rejected, *agreement, *_scatter_words(identified)]


def contradiction_words(flight: str, against: str, test: HomogeneityTest) -> str:
    """Return the sentence on a flight that contradicts others; against: what they are."""
    differences = listing([f"{name} by {value:+.1f}" for name, value in test.differences.items()])
    causes = " or ".join(test.causes)
    return (
        f"{flight} contradicts {against} (chi-square {test.statistic:.1f} of {test.degrees:.1f} degrees of freedom, probability "
        f"{test.probability:.1g}): {differences} standard deviations. Possible changes: {causes}."
    )


def _scatter_words(identified: Identified) -> list[str]:
    parameters = {entry.name: entry for entry in identified.space.parameters}
    stds = dict(zip(identified.space.names, np.sqrt(np.diag(identified.fit.covariance)).tolist(), strict=True))
    shown = [
        f"{name} by {per_cent(std) if entry.positive else f'{significant(std, 2)} {entry.unit}'}"
        for name, std in between_flight_std(identified.all_flights).items()
        for entry in [parameters[name]]
        if std > SHOWN_SCATTER * stds[name]
    ]
    return [f"Between flights scatter {listing(shown)}; the intervals hold that."] if shown else []


def check_agreement(identified: Identified, file: Path) -> None:
    """Raise InputError for a flight that contradicts earlier logs."""
    for flight, test in zip(identified.flights, identified.tests, strict=True):
        if test.is_rejected:
            raise InputError(
                f"{contradiction_words(flight.flight, file.name, test)} Name the change, as --changed propellers, and its "
                "numbers are identified again; or identify the log alone",
                file=flight.flight,
                key="update",
            )


def after_change(earlier: EarlierPosterior, cause: str) -> EarlierPosterior:
    """Return the earlier posterior without what a change moves; InputError for an unknown one, or a payload."""
    check_name("change", cause, tuple(CAUSES), key="changed")
    if cause == "payload":
        raise InputError(PAYLOAD, key="changed")
    return earlier.without(CAUSES[cause])
