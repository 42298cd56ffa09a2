"""Metrics of one axis: of its error e = reference - actual, and of the step that it makes.

Every bound follows from |e| <= E, the limit at which a flight ends, and from its duration T = N h: for instance 2/T^2
h sum k h |e| <= E (N - 1)/N. For overshoot it holds where the reference stays between the two levels of the step.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.meters import TIME_TOLERANCE
from objectives.metrics.metric import AxisView, Metric


def _step(view: AxisView) -> NDArray[Any]:
    return np.abs(np.asarray(view.target.final) - view.target.start)


def _at_end(view: AxisView, last: float) -> NDArray[Any]:
    """Return True where a flight ends outside a band; times of instants differ by h."""
    return np.asarray(last) > view.context.duration - 0.5 * view.context.h


def _per_cent_of_step(view: AxisView, size: float, without_step: float) -> NDArray[Any]:
    step = _step(view)
    return np.where(step > 0.0, 100.0 * size / np.where(step > 0.0, step, 1.0), without_step)


def _risen(view: AxisView) -> NDArray[Any]:
    return np.asarray(view.meter.rise_high_time) >= 0.0


def _rise(view: AxisView) -> NDArray[Any]:
    left = np.maximum(view.context.duration - np.asarray(view.target.time), 0.0)
    return np.where(_risen(view), view.meter.rise_high_time - view.meter.rise_low_time, left)


def _steady_error(view: AxisView) -> NDArray[Any]:
    first = np.ceil(np.asarray(view.target.steady_from) / view.context.h - TIME_TOLERANCE)
    periods = view.context.periods - np.maximum(first, 0.0)
    return np.where(periods > 0.0, np.abs(view.meter.steady_sum) / (view.context.h * np.maximum(periods, 1.0)), 0.0)


def _limit(view: AxisView) -> float:
    return view.limit


def _duration(view: AxisView) -> float:
    return view.context.duration


AXIS_METRICS = (
    Metric(
        "itae", "ITAE*", "{}", "axis",
        "time-weighted mean of |e|: integral of t|e| over T^2/2, t from the start of the flight",
        lambda view: 2.0 * view.meter.itae / view.context.duration**2, _limit, title="error (ITAE)",
    ),
    Metric(
        "iae", "IAE", "{} s", "axis",
        "integral of |e|",
        lambda view: view.meter.iae, lambda view: view.limit * view.context.duration, title="error (IAE)",
    ),
    Metric(
        "ise", "ISE", "{}^2 s", "axis",
        "integral of e^2",
        lambda view: view.meter.ise, lambda view: view.limit**2 * view.context.duration, title="error (ISE)",
    ),
    Metric(
        "rms", "e_rms", "{}", "axis",
        "root of the mean of e^2 over the flight",
        lambda view: np.sqrt(view.meter.ise / view.context.duration), _limit, combine="rss", title="RMS error",
    ),
    Metric(
        "peak", "e_max", "{}", "axis",
        "largest |e|, including that of a step at its first instant",
        lambda view: view.meter.peak, _limit, combine="max", title="peak error",
    ),
    Metric(
        "overshoot", "M_p", "%", "axis",
        "furthest excursion past the final level, in per cent of the step; 0 if never past it",
        lambda view: _per_cent_of_step(view, view.meter.overshoot_extreme, 0.0),
        lambda view: _per_cent_of_step(view, view.limit, 100.0),
        combine="max", window="time", needs_step=True, reaches_zero=True, title="overshoot",
    ),
    Metric(
        "rise", "t_r", "s", "axis",
        "time between first passing 10 % and 90 % of the step; the time left after the step if it never did",
        _rise, _duration,
        combine="max", window="time", needs_step=True, censored=lambda view: ~_risen(view), title="rise time",
    ),
    Metric(
        "settling", "t_s", "s", "axis",
        "time from the step until |e| stays within the band; the time left after the step if it never did",
        lambda view: view.meter.last_outside - view.target.time, _duration,
        combine="max", window="time", censored=lambda view: _at_end(view, view.meter.last_outside), reaches_zero=True,
        title="settling time",
    ),
    Metric(
        "recovery", "t_rec", "s", "axis",
        "time from the end of the gust until |e| stays within the band; the time left if it never did",
        lambda view: view.meter.last_unrecovered - view.target.recovery_from, _duration,
        combine="max", window="recovery_from", censored=lambda view: _at_end(view, view.meter.last_unrecovered),
        reaches_zero=True, title="recovery time",
    ),
    Metric(
        "steady_error", "e_ss", "{}", "axis",
        "|mean of e| over the steady-state window",
        _steady_error, _limit, combine="rss", window="steady_from", title="steady error",
    ),
)  # fmt: skip
