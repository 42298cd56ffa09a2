"""Tails in words: a line for an event, a mode, a design point and a ratio."""

from collections.abc import Sequence

from tuner.documents.parts import SampledValue
from tuner.documents.summary import ComparedRow
from tuner.documents.tail import TailEvent, TailMode, TailPoint
from tuner.extensions.tails.document import TailRatio
from tuner.text.numbers import count, fixed, per_cent, significant

# Shares of a distance that are told.
MIN_SHARE = 0.005
MIN_DEVIATION = 0.3
"""Smallest deviation of a single number that is printed."""


def probability_text(value: float, low: float, high: float) -> str:
    """Return a probability with its interval: "1.0e-4 [0.7e-4, 1.5e-4]"; from 1 in 1,000 on as it stands."""
    if value >= 1e-3 or value <= 0.0:
        return f"{value:.3g} [{low:.2g}, {high:.2g}]"
    power = int(f"{value:e}".partition("e")[2])
    return "{:.1f}e{p} [{:.1f}e{p}, {:.1f}e{p}]".format(*(part * 10.0**-power for part in (value, low, high)), p=power)


def event_line(event: TailEvent, smallest: float) -> str:
    """Return probability, interval and flights of an event; smallest: down to which was looked."""
    spent = f"{count(event.flights)} flights, {event.method}"
    if event.count is not None:
        spent = f"{count(event.count.events)} of {count(event.count.flights)} flights"
    if event.status == "below":
        return f"{event.event}: rarer than {smallest:.1e}, at most {event.high:.1e} ({spent})"
    if event.status == "unreached":
        return f"{event.event}: at most {event.high:.1e}; no flight came near it, it may be impossible ({spent})"
    if event.status == "certain":
        return f"{event.event}: at least {event.low:.3g}; every flight has it ({spent})"
    if event.status == "deterministic":
        return f"{event.event}: {event.probability:g}; nothing of this scenario is drawn, so all flights are the same"
    more = "; the flights allowed were too few for the width" if event.status == "wide" else ""
    return f"{event.event}: {probability_text(event.probability, event.low, event.high)} ({spent}{more})"


def tail_words(table: Sequence[ComparedRow], point: str) -> list[str]:
    """Return sentences on the estimates in place of shares of flights.

    Args:
        table: Default and tuned values.
        point: Name of the tuned one.
    """
    words = []
    for row in table:
        value, low, high = row.tuned.parts
        if row.tail_flights is None or value is None or low is None or high is None:
            continue
        share = probability_text(value, low, high)
        spent = count(row.tail_flights)
        words.append(
            f"{point} has {row.metric} with a probability of {share}, by {spent} flights of their own; at most {row.limit:g} "
            "is allowed."
        )
    return words


def counted_line(event: TailEvent) -> str:
    """Return the line of an event in independent flights: its interval, or the bound where none has it."""
    if event.count is None or event.count.events:
        return event_line(event, event.probability)
    return f"{event.event}: {event.count.words}"


def mode_line(mode: TailMode) -> str:
    """Return share and probability of a mode."""
    low, high = mode.share.low, mode.share.high
    share = f"{per_cent(mode.share.value)} [{per_cent(low)}, {per_cent(high)}] of it"
    return f"by {mode.mode}: {share}, {probability_text(*mode.probability)}"


def point_line(point: TailPoint) -> str:
    """Return distance and shares of a design point."""
    shares = sorted(point.shares.items(), key=lambda entry: -entry[1])
    listed = ", ".join(f"{part} {per_cent(share)}" for part, share in shares if share >= MIN_SHARE)
    numbers = sorted(point.numbers.items(), key=lambda entry: -abs(entry[1]))
    single = [f"; {name} {fixed(value, 1, signed=True)}" for name, value in numbers if abs(value) >= MIN_DEVIATION]
    distance = significant(point.distance, 3)
    return f"most likely so: {point.name}, {distance} deviations off, of it squared {listed}{''.join(single)}"


def ratio_line(ratio: TailRatio) -> str:
    """Return the ratio of an event's probabilities."""
    whose = f"{ratio.event}, {ratio.gains} over {ratio.first}"
    if ratio.ratio is None:
        return f"{whose}: not known, because one of the two may be 0"
    return f"{whose}: {_factor(ratio.ratio)}"


def _factor(ratio: SampledValue) -> str:
    value, low, high = ratio
    return f"{significant(value, 3)} times [{significant(low, 2)}, {significant(high, 2)}]"
