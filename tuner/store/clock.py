"""The time a run took, over all its sessions: what a resumed run replays counts with the time it took when it was flown."""

import csv
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from plant.input_files import read_input_text


@dataclass(frozen=True)
class ElapsedTimes:
    """Seconds from the search's start to a generation's end: total, screening, flying."""

    seconds: float
    screening: float
    flights: float


class Clock:
    """Clock of a run's seconds, over all its sessions.

    It counts from its making, plus what earlier sessions took longer over what this one replayed.
    """

    def __init__(self) -> None:
        self._begin = perf_counter()
        self._earlier = 0.0

    def now(self) -> float:
        """Return the seconds so far."""
        return perf_counter() - self._begin + self._earlier

    def at_least(self, seconds: float) -> None:
        """Advance the clock to the recorded time of a replayed part."""
        self._earlier += max(seconds - self.now(), 0.0)


def recorded(history: Path) -> list[ElapsedTimes]:
    """Return the times in a history.csv; empty where it is missing or damaged, for they decide nothing."""
    try:
        rows = list(csv.DictReader(read_input_text(history).splitlines()))
        return [
            ElapsedTimes(*(float(row[key]) for key in ("seconds", "screening_seconds", "flight_seconds")))
            for row in rows
        ]
    except (OSError, ValueError, KeyError, TypeError):
        return []
