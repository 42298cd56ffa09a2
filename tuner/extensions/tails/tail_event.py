"""Estimate of an event as a part of documents."""

from collections.abc import Sequence

from objectives.risk import upper_bound
from tuner.documents.parts import SampledValue, ShareCount
from tuner.documents.tail import TailEvent, TailLevel, TailMode, TailPoint
from tuner.extensions.tails.estimation.limit_function import Method, TailEstimate
from tuner.extensions.tails.events import Event

MIN_LEVEL = 0.05
"""Least demand over capacity of a curve: below lie levels of modes that nothing comes near."""


def tail_event(event: Event, estimate: TailEstimate, points: Sequence[TailPoint | None] = ()) -> TailEvent:
    """Return an estimate as documents hold it; points: design points of all modes, by default none."""
    curve = estimate.curve
    levels = zip(curve.levels, curve.probability, curve.low, curve.high, strict=True)
    return TailEvent(
        event=event.text,
        metric=None if event.metric is None else event.metric.text,
        unit="1" if event.metric is None else event.metric.unit,
        limit=event.limit,
        status=str(estimate.status),
        method=str(estimate.method),
        probability=float(estimate.probability),
        low=float(estimate.low),
        high=float(estimate.high),
        flights=estimate.evaluations,
        count=count_of(estimate),
        replicas=len(estimate.replicas),
        modes=[
            TailMode(
                mode=mode.name,
                probability=SampledValue(float(mode.probability), *map(float, mode.interval)),
                share=SampledValue(float(mode.share), *map(float, mode.share_interval)),
                point=point,
            )
            for mode, point in zip(estimate.modes, points or [None] * len(estimate.modes), strict=True)
        ],
        curve=[
            TailLevel(level=float(level) * event.limit, probability=float(p), low=float(low), high=float(high))
            for level, p, low, high in levels
            if level >= MIN_LEVEL
        ],
    )


def count_of(estimate: TailEstimate) -> ShareCount | None:
    """Return the count of independent flights, None of others."""
    if estimate.method is not Method.CRUDE:
        return None
    flights = sum(replica.evaluations for replica in estimate.replicas)
    events = round(estimate.probability * flights)
    return ShareCount(events=events, flights=flights, upper=upper_bound(events, flights))
