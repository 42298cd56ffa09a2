"""A delay line of up to 64 control periods in a law.

Its length is a number. Blocks of eight numbers in a row; number i is what comes out in i periods. A new sample is written behind
the last number in use, and the numbers behind it, which nothing reads, take it too: one comparison for each number.
"""

from typing import NamedTuple

from plant.primitives import select

MAX_PERIODS = 64


class Eight(NamedTuple):
    """Eight samples, the next one first."""

    p0: float
    p1: float
    p2: float
    p3: float
    p4: float
    p5: float
    p6: float
    p7: float


class Line(NamedTuple):
    """Eight blocks, the next one first."""

    b0: Eight
    b1: Eight
    b2: Eight
    b3: Eight
    b4: Eight
    b5: Eight
    b6: Eight
    b7: Eight


def _filled(x: float) -> Eight:
    return Eight(x, x, x, x, x, x, x, x)


def filled(x: float) -> Line:
    """Return a line that a constant has gone through for long."""
    e = _filled(x)
    return Line(e, e, e, e, e, e, e, e)


def first(line: Line) -> float:
    """Return the sample that comes out."""
    return line.b0.p0


def _shifted(block: Eight, following: float, x: float, last: float) -> Eight:
    """Return a block one period later; last: place in it of the newest sample."""
    return Eight(
        select(last < 0.5, x, block.p1),
        select(last < 1.5, x, block.p2),
        select(last < 2.5, x, block.p3),
        select(last < 3.5, x, block.p4),
        select(last < 4.5, x, block.p5),
        select(last < 5.5, x, block.p6),
        select(last < 6.5, x, block.p7),
        select(last < 7.5, x, following),
    )


def pushed(line: Line, x: float, periods: float) -> Line:
    """Return the line with a new sample.

    periods: those after which it comes out, at most 64.
    """
    last = periods - 1.0
    return Line(
        _shifted(line.b0, line.b1.p0, x, last),
        _shifted(line.b1, line.b2.p0, x, last - 8.0),
        _shifted(line.b2, line.b3.p0, x, last - 16.0),
        _shifted(line.b3, line.b4.p0, x, last - 24.0),
        _shifted(line.b4, line.b5.p0, x, last - 32.0),
        _shifted(line.b5, line.b6.p0, x, last - 40.0),
        _shifted(line.b6, line.b7.p0, x, last - 48.0),
        _shifted(line.b7, x, x, last - 56.0),
    )
