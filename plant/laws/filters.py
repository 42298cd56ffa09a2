"""Sampled filters of autopilots as model functions: low-passes of first, second and third order, and notches.

A first-order stage is y += share (x - y), share = w h/(1 + w h), which PX4, ArduPilot and Betaflight have alike; Betaflight's
PT2 and PT3 are two and three of them, faster so that the whole is 3 dB down at the cut-off. A second-order section is the
bilinear transform with its frequency exact, in transposed direct form II. Memory goes in and comes out; a cut-off of 0, or from
half the sampling rate on, passes the signal through.

A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, 3rd ed., sections 6.3 and 7.3.
"""

from typing import NamedTuple

from plant.primitives import both, cos, select, sin, sqrt

PI = 3.141592653589793
# Cut-off of one stage over that of n of them in series: 1/sqrt(2^(1/n) - 1).
STAGE_OF_TWO = 1.5537739740300374
STAGE_OF_THREE = 1.9614591767006363
# Frequencies over the sampling rate that a section may have.
HALF = 0.4999


class Section(NamedTuple):
    """Second-order section y = (b0 + b1/z + b2/z2)/(1 + a1/z + a2/z2) x."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Delays(NamedTuple):
    """The two numbers that a second-order section keeps."""

    first: float
    second: float


class Stages(NamedTuple):
    """Outputs of three first-order stages in series."""

    first: float
    second: float
    third: float


def stage_share(cutoff: float, h: float) -> float:
    """Share [1] of a new sample that a first-order stage takes over in a period h [s]; cutoff [Hz], 0 for all of it."""
    angle = 2.0 * PI * cutoff * h
    return select(cutoff > 0.0, angle / (angle + 1.0), 1.0)


def stages_share(cutoff: float, order: float, h: float) -> float:
    """Share [1] of each of `order` stages (1, 2 or 3) that together are 3 dB down at a cutoff [Hz]."""
    faster = select(order > 2.5, STAGE_OF_THREE, select(order > 1.5, STAGE_OF_TWO, 1.0))
    return stage_share(faster * cutoff, h)


def step_stage(state: float, x: float, share: float) -> float:
    """Output of a first-order stage, which is also what it keeps."""
    return state + share * (x - state)


def step_stages(state: Stages, x: float, share: float, order: float) -> tuple[float, Stages]:
    """Output of the first `order` (0 to 3) of three stages in series, and what they keep."""
    first = step_stage(state.first, x, share)
    second = step_stage(state.second, first, share)
    third = step_stage(state.third, second, share)
    chosen = select(order > 2.5, third, select(order > 1.5, second, select(order > 0.5, first, x)))
    return chosen, Stages(first, second, third)


def settled_stages(x: float) -> Stages:
    """Memory of stages that a constant has gone through for long."""
    return Stages(x, x, x)


def low_pass(cutoff: float, h: float) -> Section:
    """Butterworth low-pass of second order at a cutoff [Hz]."""
    is_active = both(cutoff > 0.0, cutoff * h < HALF)
    angle = PI * select(is_active, cutoff * h, 0.25)
    t = sin(angle) / cos(angle)
    scale = 1.0 / (1.0 + sqrt(2.0) * t + t * t)
    gain = t * t * scale
    return _or_through(
        is_active, Section(gain, 2.0 * gain, gain, 2.0 * (t * t - 1.0) * scale, (1.0 - sqrt(2.0) * t + t * t) * scale)
    )


def notch(centre: float, width: float, h: float) -> Section:
    """Notch at a centre [Hz]; width [Hz]: between the frequencies where it is 3 dB down, exact with tan(pi width h)."""
    is_active = both(both(centre > 0.0, centre * h < HALF), both(width > 0.0, width * h < HALF))
    angle = PI * select(is_active, width * h, 0.1)
    return _notch_of(is_active, sin(angle) / cos(angle), select(is_active, centre * h, 0.25))


def notch_by_q(centre: float, q: float, h: float) -> Section:
    """Notch at a centre [Hz] of quality q [1], its bandwidth counted before the bilinear transform as most programs do."""
    is_active = both(both(centre > 0.0, centre * h < HALF), q > 0.0)
    turn = select(is_active, centre * h, 0.25)
    return _notch_of(is_active, sin(2.0 * PI * turn) / (2.0 * select(is_active, q, 1.0)), turn)


def _notch_of(is_active: bool, alpha: float, turn: float) -> Section:
    """Notch of half its pole's damping alpha at a centre of `turn` turns a sample."""
    scale, middle = 1.0 / (1.0 + alpha), -2.0 * cos(2.0 * PI * turn)
    return _or_through(is_active, Section(scale, middle * scale, scale, middle * scale, (1.0 - alpha) * scale))


def _or_through(is_active: bool, section: Section) -> Section:
    return Section(
        select(is_active, section.b0, 1.0),
        select(is_active, section.b1, 0.0),
        select(is_active, section.b2, 0.0),
        select(is_active, section.a1, 0.0),
        select(is_active, section.a2, 0.0),
    )


def mode(frequency: float, damping: float, gain: float, h: float) -> Section:
    """1 + gain s^2/(s^2 + 2 damping w s + w^2), w = 2 pi frequency [Hz]; passes the signal through for a frequency of 0."""
    is_active = both(frequency > 0.0, frequency * h < HALF)
    turn = select(is_active, frequency * h, 0.25)
    t = sin(PI * turn) / cos(PI * turn)
    scale = 1.0 / (1.0 + 2.0 * damping * t + t * t)
    a1, a2 = 2.0 * (t * t - 1.0) * scale, (1.0 - 2.0 * damping * t + t * t) * scale
    push = gain * scale
    return _or_through(is_active, Section(1.0 + push, a1 - 2.0 * push, a2 + push, a1, a2))


def step_section(state: Delays, x: float, section: Section) -> tuple[float, Delays]:
    """Output of a second-order section, and what it keeps."""
    y = section.b0 * x + state.first
    return y, Delays(section.b1 * x - section.a1 * y + state.second, section.b2 * x - section.a2 * y)


def settled_section(x: float, section: Section) -> Delays:
    """Memory of a section that a constant has gone through for long; its gain at rest is 1."""
    return Delays(x - section.b0 * x, (section.b2 - section.a2) * x)
