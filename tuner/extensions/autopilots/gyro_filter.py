"""Phase lag of a target's gyro low-pass, which rounding does not show.

Both autopilots filter the gyro by a second-order Butterworth low-pass, where our law has its derivative filter of first order.
So the margins are worked out once more with our filter such that it lags at each attitude loop's crossover w as theirs does:

    t_f = tan(phi)/w,    tan(phi) = sqrt(2) r/(1 - r^2),    r = w/(2 pi f_c)

Its amplitude at the crossover is cos(phi), theirs is close to 1, so a little gain is missing. The position loops follow, for
their margins hold the attitude loops.
"""

from math import isfinite, pi, radians, sqrt

from objectives.margins.period import CHANNELS
from objectives.margins.trim import Trim
from plant.errors import InputError
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.vectors import Vec3
from tuner.analysis.margins.limits import LIMITS
from tuner.analysis.margins.readings import Subject, subject_of
from tuner.documents.export import FilteredLoop
from tuner.extensions.autopilots.pid import axis_gains, with_gains
from tuner.gains import Controller

# Usual limit of the phase margin [rad].
LIMIT = radians(next(limit.limit for limit in LIMITS if limit.quantity == "phase_margin"))
# Crossovers from this share of the cut-off on lag by more than the filter of first order can.
MAX_SHARE = 0.9


def filter_rows(controller: Controller, cutoff: float) -> list[FilteredLoop]:
    """Return phase margins [rad] with our filter and the target's; none where it is off or nothing hovers."""
    if cutoff <= 0.0:
        return []
    still = Vec3(0.0, 0.0, 0.0)
    trim = Trim(0.0, still, still, True)
    try:
        before = subject_of(controller, trim)
        after = subject_of(with_filter(controller, before, cutoff), trim)
    except InputError:
        return []
    return [_row(before, after, channel) for channel in before.looped if isfinite(_phase(before, channel))]


def with_filter(controller: Controller, subject: Subject, cutoff: float) -> Controller:
    """Return the controller with the target's lag at every attitude loop's crossover; cutoff [Hz]."""
    gains = {}
    for axis in ATTITUDE_AXES:
        crossover = float(subject.margins.crossover.value[0, CHANNELS.index(axis)])
        gains[axis] = axis_gains(controller, axis)._replace(t_f=equal_lag(crossover, cutoff))
    return with_gains(controller, gains)


def equal_lag(crossover: float, cutoff: float) -> float:
    """Return the time constant [s] of a first-order low-pass of equal lag: at a crossover [rad/s].

    cutoff [Hz]: of a second-order Butterworth low-pass.
    """
    corner = 2.0 * pi * cutoff
    share = min(crossover / corner, MAX_SHARE)
    return sqrt(2.0) / (corner * (1.0 - share * share))


def _phase(subject: Subject, channel: str) -> float:
    return float(subject.margins.phase.value[0, CHANNELS.index(channel)])


def _row(before: Subject, after: Subject, channel: str) -> FilteredLoop:
    ours, theirs = _phase(before, channel), _phase(after, channel)
    return FilteredLoop(
        loop=channel,
        unit="rad",
        limit=LIMIT,
        ours=ours,
        theirs=theirs,
        taken=ours - theirs,
        spare=ours - LIMIT,
        breaks=ours >= LIMIT > theirs,
    )
