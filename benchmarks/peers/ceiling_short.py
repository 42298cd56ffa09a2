"""The loop by hand in C with what only a hand knows about this course, see `ceiling.c`."""

from pathlib import Path

from benchmarks.course import Course
from benchmarks.peers.ceiling import flights
from benchmarks.peers.contestant import Work


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Compile with the shortcuts."""
    return flights(course, batch, periods, threads, scratch, "-DSHORTCUTS=1")
