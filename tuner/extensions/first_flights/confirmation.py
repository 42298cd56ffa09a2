"""Comparison of a firmware with simulation, through the same scenarios."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from objectives.problem import Objective, seen_scores
from objectives.risk import binary_difference, replicates_on, resampled_scenarios, within
from plant.seeds import generator
from tuner.documents.parts import Estimate
from tuner.extensions.first_flights.confirmation_document import ConfirmedPoint, ConfirmedQuantity, ConfirmedValue

REPLICATES, ENDS = 2000, (0.025, 0.975)
Pair = tuple[np.ndarray, np.ndarray]
# Finalists from which on ranks say something.
MIN_RANKED_FINALISTS = 3


@dataclass(frozen=True)
class PairedFlights:
    """Flights of finalists in the firmware and in simulation.

    Attributes:
        points (n,): Names of the finalists.
        quantities (q,): Compared quantities.
        firmware, model: Scores (n, q, flights).
        lost_firmware, lost_model (n, flights): Masks of the lost flights.
        origin (flights,): Name of the scenario of each flight.
        repeated: Scores (q, flights) of the first finalist, flown once more in the firmware.
    """

    points: tuple[str, ...]
    quantities: tuple[Objective, ...]
    firmware: np.ndarray
    model: np.ndarray
    lost_firmware: np.ndarray
    lost_model: np.ndarray
    origin: np.ndarray
    repeated: np.ndarray | None
    root: int

    @cached_property
    def drawn(self) -> np.ndarray:
        """Resampled scenarios (replicates, flights), the same for every number of the confirmation."""
        return resampled_scenarios(generator(self.root, "bootstrap/confirm", 0), REPLICATES, self.origin)


def confirmed_quantities(flown: PairedFlights) -> list[ConfirmedQuantity]:
    """Return correlation, gap and jitter of every quantity.

    Each has a 95 % interval over resampled scenarios.
    """
    return [_quantity(flown, i) for i in range(len(flown.quantities))]


def confirmed_points(flown: PairedFlights) -> list[ConfirmedPoint]:
    """Return every finalist with its values and paired differences of each quantity."""
    columns = [_values(flown, i) for i in range(len(flown.quantities))]
    return [
        ConfirmedPoint(
            point=point,
            lost_firmware=int(np.sum(flown.lost_firmware[k], axis=0)),
            lost_model=int(np.sum(flown.lost_model[k], axis=0)),
            values=[column[k] for column in columns],
        )
        for k, point in enumerate(flown.points)
    ]


def rank_correlation(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return Spearman's rank correlation over the first axis (n, ...); NaN where one side's ranks are all the same."""
    a, b = (_ranks(part) for part in (first, second))
    a, b = a - np.mean(a, axis=0), b - np.mean(b, axis=0)
    with np.errstate(invalid="ignore"):
        return np.sum(a * b, axis=0) / np.sqrt(np.sum(a * a, axis=0) * np.sum(b * b, axis=0))


def _ranks(values: np.ndarray) -> np.ndarray:
    """Ranks along the first axis, of equal values the mean of theirs."""
    below = np.sum(values[None] < values[:, None], axis=1)
    same = np.sum(values[None] == values[:, None], axis=1)
    return below + 0.5 * (same + 1.0)


def _seen(flown: PairedFlights, i: int) -> Pair:
    scenario = flown.quantities[i].scenario
    return (
        seen_scores(flown.firmware, i, flown.origin, scenario),
        seen_scores(flown.model, i, flown.origin, scenario),
    )


def _quantity(flown: PairedFlights, i: int) -> ConfirmedQuantity:
    quantity = flown.quantities[i]
    part = within(flown.drawn, flown.origin, quantity.scenario)
    both = _seen(flown, i)
    firmware, model = (quantity.risk.apply(scores) for scores in both)
    often = [replicates_on(scores, quantity.risk, part) for scores in both]
    gap = float(np.mean(firmware - model, axis=0))
    size = float(np.mean(model, axis=0))
    return ConfirmedQuantity(
        label=quantity.label,
        metric=quantity.metric.text,
        definition=quantity.metric.metric.definition,
        unit=quantity.metric.unit,
        scenario=quantity.scenario,
        correlation=_correlation(firmware, model, *often),
        gap=Estimate(gap, *_gap_ends(quantity, both, often)),
        relative=gap / size if size else None,
        jitter=None
        if flown.repeated is None
        else float(np.max(np.abs(flown.repeated[i] - flown.firmware[0, i]), axis=0)),
    )


def _gap_ends(quantity: Objective, both: Pair, often: list[np.ndarray]) -> tuple[float, float]:
    """Return the interval of the mean gap over finalists; of shares from those of the finalists (Bonferroni)."""
    if not quantity.is_binary:
        return _ends(np.mean(often[0] - often[1], axis=0))
    low, high = binary_difference(*both, quantity.risk, 1.0 - 0.05 / len(both[0]))
    return float(np.mean(low, axis=0)), float(np.mean(high, axis=0))


def _correlation(firmware: np.ndarray, model: np.ndarray, often: np.ndarray, predicted: np.ndarray) -> Estimate:
    value = float(rank_correlation(firmware, model))
    if len(firmware) < MIN_RANKED_FINALISTS or not np.isfinite(value):
        return Estimate(None, None, None)
    correlation = rank_correlation(often, predicted)
    return Estimate(value, *_ends(correlation[np.isfinite(correlation)]))


def _ends(correlation: np.ndarray) -> tuple[float, float]:
    low, high = np.quantile(correlation, ENDS, axis=0)
    return float(low), float(high)


def _values(flown: PairedFlights, i: int) -> list[ConfirmedValue]:
    quantity = flown.quantities[i]
    firmware, model = _seen(flown, i)
    difference = quantity.difference(firmware, model, within(flown.drawn, flown.origin, quantity.scenario))
    risks = zip(quantity.risk.apply(firmware), quantity.risk.apply(model), *difference, strict=True)
    return [
        ConfirmedValue(firmware=float(flown_risk), model=float(model_risk), gap=Estimate(*map(float, gap)))
        for flown_risk, model_risk, *gap in risks
    ]
