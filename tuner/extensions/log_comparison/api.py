"""Comparison of two flight logs with each other and with the prediction."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from plant.quadrotor.airframes import load
from tuner.api.flying import fly
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import GainsLike, as_gains
from tuner.api.studies import StudyLike
from tuner.extensions.identification.api import LogLike, read_logs
from tuner.extensions.identification.building import log_row
from tuner.extensions.log_comparison.comparison import MEASURES, Spread, measured, ratio_of
from tuner.extensions.log_comparison.document import ComparedMeasure, Estimated, LogComparisonDocument
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.flights import longest_flight
from tuner.search.watcher import Watcher
from tuner.text.sentences import listing

if TYPE_CHECKING:
    import pandas as pd

FLIGHTS = 256
"""Flights that a prediction rests on."""


@dataclass(frozen=True)
class LogComparison(Documented):
    """Two flights side by side.

    Attributes:
        document: Output of `tuner compare-logs --json`.

    """

    document: LogComparisonDocument

    @property
    def is_as_predicted(self) -> bool:
        """True if the second log agrees with all predictions, if any."""
        return all(row.is_as_predicted is not False for row in self.document.measures)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each measure: both values, their ratio with its 95 % interval, and what it tells."""
        rows = [
            {
                "name": row.name,
                "unit": row.unit,
                "before": row.before.value,
                "after": row.after.value,
                "ratio": row.ratio.value,
                "ratio low": row.ratio.low,
                "ratio high": row.ratio.high,
                "told": row.change,
            }
            for row in self.document.measures
        ]
        return frame(rows, "name")

    def _repr_html_(self) -> str:
        return shown("Two logs", [self.document.verdict], self.table)


def compare_logs(
    before: LogLike,
    after: LogLike,
    *,
    airframe: str | Path,
    gains: GainsLike | None = None,
    study: StudyLike | None = None,
    mapping: str | Path | None = None,
    watcher: Watcher | None = None,
) -> LogComparison:
    """Compare two flights of a vehicle: whether the second is better, and whether it did what was predicted.

    Args:
        before: Log of the first flight; FILE@35:65 for a part.
        after: Log of the second one, of a like flight in like air.
        airframe: About what flew: a bundled airframe or a TOML file.
        gains: Gains of the second flight; with them and a study, flights predict its rotor commands.
        study: Study whose first scenario is about what was flown, best one that draws its vehicles from the airframe.
        mapping: TOML file that says what the columns of CSV logs are.
        watcher: Callbacks that hear of compilation.

    Returns:
        Each measure of both, their ratio with its 95 % interval, and a verdict.

    Raises:
        InputError: A log cannot be read, or holds no flight that is long enough; or only one of gains and study is given.

    Examples:
        >>> found = tuner.compare_logs("log15@70:77", "log15@78:85", airframe="crazyflie-pybullet")
        >>> found.table.loc["rate.yaw", "told"]
        'not told apart'

    """
    if (gains is None) != (study is None):
        raise InputError("a prediction needs gains and a study; give both, or neither", key="--gains")
    prior = load(airframe, allow_unphysical=True)
    logs = [longest_flight(log, prior) for log in read_logs([before, after], mapping)]
    predicted = {} if gains is None else _predicted(gains, study, logs[1], watcher)
    first, second = (measured(log) for log in logs)
    rows = [_row(name, first[name], second[name], predicted.get(name)) for name in MEASURES]
    flights = FLIGHTS if predicted else 0
    return LogComparison(
        LogComparisonDocument(
            airframe=prior.name,
            before=log_row(logs[0]),
            after=log_row(logs[1]),
            flights=flights,
            measures=rows,
            verdict=_verdict(rows),
        )
    )


def _predicted(gains: GainsLike, study: StudyLike | None, log: FlightLog, watcher: Watcher | None) -> dict[str, float]:
    """Return 95 % quantiles of flights by measures that are also metrics."""
    given = as_gains(gains)
    period = given.quadrotor(
        "these are gains of a plant of one's own; a flight log is predicted by a quadrotor's"
    ).control_period
    flown = fly(given, study=study, flights=FLIGHTS, watcher=watcher)
    if log.period > 1.2 * period:
        raise InputError(
            f"has {log.rate:.0f} samples a second of {1.0 / period:.0f} commands that the predicted loop makes; log them all",
            file=log.name,
        )
    return {row.metric: row.q95 for row in flown.document.metrics if row.metric in MEASURES}


def _row(name: str, before: Spread, after: Spread, predicted: float | None) -> ComparedMeasure:
    ratio, low, high = ratio_of(after, before)
    return ComparedMeasure(
        name=name,
        meaning=MEASURES[name].meaning,
        unit=MEASURES[name].unit,
        before=Estimated(value=before.value, low=before.low, high=before.high),
        after=Estimated(value=after.value, low=after.low, high=after.high),
        ratio=Estimated(value=ratio, low=low, high=high),
        told="less" if high < 1.0 else "more" if low > 1.0 else "not told apart",
        predicted=predicted,
        kept=None if predicted is None else after.low <= predicted,
    )


def _verdict(rows: list[ComparedMeasure]) -> str:
    """Return sentences on the second flight's changes and the predictions."""
    sentences = []
    for change in ("less", "more"):
        names = [row.name for row in rows if row.change == change]
        if names:
            sentences.append(f"The second flight has {change} {listing(names)}.")
    if not sentences:
        sentences = ["The two flights do not differ significantly."]
    predicted = [row for row in rows if row.is_as_predicted is not None]
    over = [row.name for row in predicted if not row.is_as_predicted]
    if over:
        sentences.append(
            f"Its {listing(over)} is above what 95 % of the predicted flights have: the vehicle or its air is not that of the "
            "study."
        )
    elif predicted:
        sentences.append(f"Its {listing([row.name for row in predicted])} is as predicted.")
    return " ".join([*sentences, "It is the gains' doing only where both flew the same in the same air."])
