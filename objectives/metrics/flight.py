"""Metrics of a whole flight: what the rotors were asked for, and whether the flight reached its end.

Commands are in hover thrusts of one rotor, between 0 and the peak P of the limits: a period moves the four by at most
4 P, and none is further from hover than max(P - 1, 1).
"""

import numpy as np

from objectives.metrics.metric import Metric

FLIGHT_METRICS = (
    Metric(
        "travel", "TV", "1/s", "flight",
        "total variation of the commands per second, over all rotors in hover thrusts or inputs in their scales",
        lambda view: view.meters.travel / view.context.duration,
        lambda view: view.context.limits.travel / view.context.h, title="rotor travel",
    ),
    Metric(
        "effort", "J_u", "1", "flight",
        "mean over the flight of the squared commands, of rotors as their departure from hover, summed over inputs",
        lambda view: view.meters.effort / view.context.duration, lambda view: view.context.limits.effort,
        title="rotor effort",
    ),
    Metric(
        "saturation", "D_sat", "1", "flight",
        "share of the flight with any rotor or input at a limit",
        lambda view: view.meters.saturated / view.context.duration, lambda view: 1.0, highest=1.0, reaches_zero=True,
        title="saturation",
    ),
    Metric(
        "command_peak", "u_max", "1", "flight",
        "largest command, of a rotor in hover thrusts, of an input in its scale",
        lambda view: view.meters.command_peak, lambda view: view.context.limits.command_peak,
        title="largest rotor command",
    ),
    Metric(
        "failure", "p_fail", "1", "flight",
        "1 if the flight failed, else 0; its mean over scenarios is the failure rate",
        lambda view: np.zeros_like(view.meters.travel), lambda view: 1.0,
        graded=False, highest=1.0, reaches_zero=True, is_binary=True, combine="max", title="failed flights",
    ),
)  # fmt: skip
