"""Identification as a document."""

from collections.abc import Sequence
from math import exp
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from tuner.extensions.identification.checks import LogIssue
from tuner.extensions.identification.document import (
    IdentificationDocument,
    IdentifiedNumber,
    LogRow,
    Posterior,
    PredictionRow,
    RegressionRow,
    ResponseRow,
)
from tuner.extensions.identification.flight_rows import estimate_from, flight_rows, flight_words
from tuner.extensions.identification.identify import Identified
from tuner.extensions.identification.onward import uncertainty_of
from tuner.extensions.identification.response_comparison import (
    DECIBELS,
    ResponseComparison,
    compare_responses,
    difference_words,
)
from tuner.extensions.identification.white_noise import gyro_noise, white_noise
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.identifiability import GIVEN
from tuner.extensions.vehicle_fit.parameters import NODES, THRUSTS, EarlierPosterior, Parameter, space_of
from tuner.extensions.vehicle_fit.prediction import HORIZON, OF, PART, cut
from tuner.extensions.vehicle_fit.random_effects import QUANTILE
from tuner.extensions.vehicle_fit.samples import OUTPUTS
from tuner.text.numbers import per_cent
from tuner.text.sentences import listing

Array = NDArray[np.float64]

POOR = 0.5
"""Share of an output's variance below which its prediction on windows kept from the fit is called poor."""
MIN_COVERAGE = 0.8
"""Share of the measurement in the 95 % band below which the band counts as too narrow."""
MAX_CORRELATED_SHARE = 0.25
"""Share of autocorrelations beyond their bound above which residuals do not count as white."""
MAX_DOCUMENTED_VALUE = 1e4
"""Largest number of decibels or degrees in the document."""
NO_WINDOW_ADVICE = (
    f"No window was kept from the fit, because no flight without a pause lasts {PART * OF + HORIZON:g} s: its prediction is not "
    "validated. Fly longer."
)
UNITS = ("rad/s", "rad/s", "rad/s", "m/s2")
WEIGH = (
    "Weigh the vehicle and measure its arms: no log identifies mass and arm, and if they are wrong by 5 %, inertias and thrust "
    "are wrong by as much, without a sign in the log."
)


def identification_document(
    identified: Identified, warnings: Sequence[str], file: str | None, before: Sequence[LogRow] = ()
) -> IdentificationDocument:
    """Return the document; file: of the airframe that was written; before: earlier logs, whose posterior was the prior."""
    fit, uncertainty = identified.fit, uncertainty_of(identified)
    deviations = np.sqrt(np.diag(identified.covariance)).tolist()
    reasons = identified.wider | identified.reasons
    noise = gyro_noise(identified.logs)
    lift_noise = white_noise([log.acceleration[:, 2:] for log in identified.logs])
    rate = min(log.rate for log in identified.logs)
    compared = compare_responses(identified.fit, identified.problem, [*noise, *lift_noise], rate)
    rows = zip(
        identified.space.unweighed.parameters[: identified.space.physical],
        fit.estimate.tolist(),
        deviations,
        strict=False,
    )
    return IdentificationDocument(
        airframe=identified.airframe.name,
        file=file,
        logs=[log_row(log) for log in identified.logs],
        numbers=[_number(entry, value, deviation, reasons.get(entry.name, "")) for entry, value, deviation in rows],
        curve=_curve(identified),
        uncertainty=list(uncertainty.names),
        deviations=list(uncertainty.deviations),
        correlation=[list(row) for row in uncertainty.correlation],
        horizon=HORIZON,
        prediction=prediction_rows(identified),
        regressions=[
            RegressionRow(axis=axis, acceleration_on_torque=ways[0], torque_on_acceleration=ways[1])
            for axis, ways in zip("xyz", identified.regressions, strict=True)
        ],
        gyro_noise=noise,
        warnings=list(warnings),
        verdict=" ".join([*flight_words(identified), verdict(identified), *difference_words(compared)]),
        before=list(before),
        posterior=posterior_of(identified),
        responses=response_rows(compared),
        flights=flight_rows(identified),
    )


def posterior_of(identified: Identified) -> Posterior:
    """Return the posterior of the coordinates of the vehicle."""
    n = identified.space.physical
    return Posterior(
        names=list(identified.space.names[:n]),
        point=identified.fit.estimate[:n].tolist(),
        covariance=identified.fit.covariance[:n, :n].tolist(),
        wide=identified.space.initial_std[:n].tolist(),
    )


def earlier_posterior(document: IdentificationDocument, airframe: Airframe, file: Path) -> EarlierPosterior:
    """Return the posterior of an earlier identification; InputError where it is of another airframe, or cannot be used."""
    parameters = space_of(airframe.vehicle, []).parameters
    names = [entry.name for entry in parameters]
    posterior = document.posterior
    if posterior is None or document.airframe != airframe.name:
        raise InputError(
            f"identifies '{document.airframe}'{'' if posterior else ' without its posterior'}, and this log is read with "
            f"'{airframe.name}'; give the document that identify --json printed with the same airframe",
            file=file,
        )
    is_square = [len(row) for row in posterior.covariance] == [len(names)] * len(names)
    covariance = np.array(posterior.covariance, dtype=float) if is_square else None
    sized = posterior.names == names and len(posterior.point) == len(posterior.wide) == len(names)
    if covariance is None or not sized or not _is_covariance(covariance) or min(posterior.wide) <= 0.0:
        raise InputError(
            "its posterior is not that of this airframe's numbers; identify the first log again",
            file=file,
            key="posterior",
        )
    flights = tuple(estimate_from(row, parameters, file) for row in document.flights)
    return EarlierPosterior(tuple(names), np.array(posterior.point), covariance, np.array(posterior.wide), flights)


def _is_covariance(matrix: Array) -> bool:
    """Return true for a symmetric matrix (n, n) whose correlation matrix is positive definite."""
    sizes = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    if not np.all(sizes > 0.0):
        return False
    correlation = matrix / np.outer(sizes, sizes)
    return bool(np.allclose(correlation, correlation.T, atol=1e-6) and np.linalg.eigvalsh(correlation)[0] > 0.0)


def prediction_rows(identified: Identified) -> list[PredictionRow]:
    """Return the held-out prediction of each output of the fit: none where the flights are too short to hold windows out."""
    validation, windows = identified.validation, identified.windows
    if windows.is_empty:
        return []
    fitted_on = cut(identified.problem, [part.measured for part in identified.problem.samples], 1.0)
    moved = np.sqrt(np.mean(windows.measured**2, axis=(0, 1)) / np.mean(fitted_on**2, axis=(0, 1)))
    return [
        PredictionRow(
            output=name,
            explained=float(windows.explained[k]),
            error=float(windows.errors[k]),
            unit=UNITS[k],
            covered=float(validation.covered[k]),
            correlated=float(validation.correlated[k]),
            reach=float(validation.reach[k]),
            moved=float(moved[k]),
        )
        for k, name in enumerate(OUTPUTS)
        if identified.problem.outputs[k]
    ]


def log_row(log: FlightLog) -> LogRow:
    """Return the row of a log."""
    return LogRow(
        file=log.name,
        kind=log.kind,
        sha256=log.digest,
        begin=float(log.time[0]),
        end=float(log.time[-1]),
        rate=log.rate,
        lost=log.lost,
        said=list(log.notes),
    )


def warnings_of(findings: Sequence[tuple[FlightLog, LogIssue]]) -> list[str]:
    """Return findings as texts with the file in front."""
    return [f"{log.name}: {finding.text}" for log, finding in findings]


def response_rows(compared: Sequence[ResponseComparison]) -> list[ResponseRow]:
    """Return the frequency responses as rows of the document."""
    rows = []
    for entry in compared:
        phase, off = np.unwrap(np.angle(entry.modeled)), entry.difference
        magnitude = np.log(np.abs(entry.modeled))
        rows.append(
            ResponseRow(
                output=entry.output,
                instrument="setpoint" if entry.has_instrument else "",
                averages=entry.measured.averages,
                frequency=_rounded(entry.measured.frequency),
                magnitude=_rounded(DECIBELS * (magnitude + off.real)),
                phase=_rounded(np.degrees(phase + off.imag)),
                coherence=_rounded(entry.measured.coherence),
                half_width=_rounded(DECIBELS * entry.measured.half_width),
                model_magnitude=_rounded(DECIBELS * magnitude),
                model_phase=_rounded(np.degrees(phase)),
                model_half_width=_rounded(DECIBELS * QUANTILE * entry.model_deviation[0]),
                model_phase_half_width=_rounded(np.degrees(QUANTILE * entry.model_deviation[1])),
                compared=entry.trusted.tolist(),
            )
        )
    return rows


def _rounded(series: Array) -> list[float]:
    """Return numbers for a chart, without an infinite one."""
    return (
        np.round(np.nan_to_num(series, posinf=MAX_DOCUMENTED_VALUE, neginf=-MAX_DOCUMENTED_VALUE), 4)
        .clip(-MAX_DOCUMENTED_VALUE, MAX_DOCUMENTED_VALUE)
        .tolist()
    )


def verdict(identified: Identified) -> str:
    """Return sentences on the identified and unidentified parameters, and the remedy."""
    names = [entry.name for entry in identified.space.parameters[: identified.space.physical]]
    identifiable = [name for name in names if name not in identified.reasons and name not in identified.wider]
    left = [name for name in names if name in identified.reasons and name not in GIVEN]
    sentences = (
        [f"{len(identifiable)} numbers identified: {', '.join(identifiable)}."]
        if identifiable
        else ["The data do not identify this vehicle."]
    )
    if left:
        sentences.append(f"Left at the prior: {', '.join(left)}; a flight that excites them would identify them.")
    if identified.space.weighed is not None:
        sentences.append(
            "The thrusts are those that carry the weight at the mean command, because lift hardly follows the commands."
        )
    if wider := [name for name in identified.wider if name not in THRUSTS]:
        sentences.append(f"No better known than before: {', '.join(wider)}.")
    at = names.index("dead_time")
    dead_time, deviation = identified.fit.estimate[at], np.sqrt(identified.covariance[at, at])
    if "dead_time" in identifiable and dead_time + QUANTILE * deviation < 0.0:
        sentences.append(
            f"dead_time is negative, {1000.0 * dead_time:.2g} ms: in the log the time stamps of the gyro lead those of the "
            "commands by more than the rotors' delay."
        )
    predicted = [NO_WINDOW_ADVICE] if identified.windows.is_empty else prediction_words(prediction_rows(identified))
    return " ".join([*sentences, *predicted, WEIGH])


def prediction_words(rows: Sequence[PredictionRow]) -> list[str]:
    """Return sentences on the accuracy of the predictions."""
    if not rows:
        return []
    quiet = [row.output for row in rows if row.is_quiet]
    poor = [row.output for row in rows if row.explained < POOR and row.output not in quiet]
    excited = [row for row in rows if row.output not in quiet]
    sentences = (
        [f"Windows kept from the fit hold hardly any {listing(quiet)}: they say nothing of its prediction."]
        if quiet
        else []
    )
    if not excited:
        return sentences
    sentences += [
        f"On windows kept from the fit, {listing(poor)} is predicted poorly: mind these numbers, and fly once more with more "
        "excitation."
        if poor
        else "On windows kept from the fit the model explains "
        f"{per_cent(min(row.explained for row in excited))} or more of what it uses."
    ]
    narrow = [row for row in excited if row.covered < MIN_COVERAGE]
    if narrow:
        held = listing([f"{per_cent(row.covered)} of {row.output}" for row in narrow])
        sentences.append(
            f"Its 95 % band holds only {held} there: parts of the flight are rougher than those of the fit."
        )
    coloured = [row.output for row in excited if row.correlated > MAX_CORRELATED_SHARE]
    sentences.append(
        f"The residual of {listing(coloured)} is not white: the vehicle has dynamics there that the model lacks."
        if coloured
        else "The residual is white behind the noise model."
    )
    return sentences


def _number(entry: Parameter, value: float, deviation: float, reason: str) -> IdentifiedNumber:
    low, middle, high = (entry.number(value + k * QUANTILE * deviation) for k in (-1.0, 0.0, 1.0))
    before = [entry.number(entry.coordinate + k * QUANTILE * entry.deviation) for k in (-1.0, 0.0, 1.0)]
    return IdentifiedNumber(
        name=entry.name,
        meaning=entry.meaning,
        unit=entry.unit,
        value=middle,
        low=low,
        high=high,
        prior=before[1],
        prior_low=before[0],
        prior_high=before[2],
        identified=not reason,
        reason=reason,
    )


def _curve(identified: Identified) -> list[IdentifiedNumber]:
    """Return the coefficients of the thrust curve: intervals from the same covariance, to first order."""
    at = identified.space.names.index("thrust.30")
    part = slice(at, at + len(NODES))
    inverse = np.linalg.inv(np.vander(NODES, 3, increasing=True))
    space = identified.space.unweighed
    prior = np.array([exp(entry.coordinate) for entry in space.parameters[part]])
    thrust = np.exp(identified.fit.estimate[part])
    now, before = (
        (inverse @ nodes, np.sqrt(np.diag(inverse @ (np.outer(nodes, nodes) * matrix) @ inverse.T)))
        for nodes, matrix in (
            (thrust, identified.covariance[part, part]),
            (prior, np.diag(space.prior_std[part] ** 2)),
        )
    )
    unknown = identified.reasons.keys() | identified.wider.keys()
    is_missing = not unknown.isdisjoint(identified.space.names[part])
    reason = "a node of the curve is not identified" if is_missing else ""
    return [
        IdentifiedNumber(
            name=f"thrust u^{k}",
            meaning="coefficient of the thrust of a rotor over the command",
            unit="N",
            value=now[0][k],
            low=now[0][k] - QUANTILE * now[1][k],
            high=now[0][k] + QUANTILE * now[1][k],
            prior=before[0][k],
            prior_low=before[0][k] - QUANTILE * before[1][k],
            prior_high=before[0][k] + QUANTILE * before[1][k],
            identified=not reason,
            reason=reason,
        )
        for k in range(3)
    ]
