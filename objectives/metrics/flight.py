"""Metrics of a whole flight: what the rotors were asked for, and whether the flight reached its end.

Commands are in hover thrusts of one rotor, between 0 and the peak P of the limits: a period moves the four by at most
4 P, and none is further from hover than max(P - 1, 1).
"""

import numpy as np

from objectives.metrics.metric import Metric

FLIGHT_METRICS = (
    Metric(
        name="travel",
        symbol="TV",
        title="rotor travel",
        unit="1/s",
        scope="flight",
        definition="total variation of the commands per second, over all rotors in hover thrusts or inputs in their scales",
        value=lambda view: view.meters.travel / view.context.duration,
        bound=lambda view: view.context.limits.travel / view.context.h,
    ),
    Metric(
        name="effort",
        symbol="J_u",
        title="rotor effort",
        unit="1",
        scope="flight",
        definition="mean over the flight of the squared commands, of rotors as their departure from hover, summed over inputs",
        value=lambda view: view.meters.effort / view.context.duration,
        bound=lambda view: view.context.limits.effort,
    ),
    Metric(
        name="saturation",
        symbol="D_sat",
        title="saturation",
        unit="1",
        scope="flight",
        definition="share of the flight with any rotor or input at a limit",
        value=lambda view: view.meters.saturated / view.context.duration,
        bound=lambda view: 1.0,
        highest=1.0,
        reaches_zero=True,
    ),
    Metric(
        name="command_peak",
        symbol="u_max",
        title="largest rotor command",
        unit="1",
        scope="flight",
        definition="largest command, of a rotor in hover thrusts, of an input in its scale",
        value=lambda view: view.meters.command_peak,
        bound=lambda view: view.context.limits.command_peak,
    ),
    Metric(
        name="failure",
        symbol="p_fail",
        title="failed flights",
        unit="1",
        scope="flight",
        definition="1 if the flight failed, else 0; its mean over scenarios is the failure rate",
        value=lambda view: np.zeros_like(view.meters.travel),
        bound=lambda view: 1.0,
        graded=False,
        highest=1.0,
        reaches_zero=True,
        is_binary=True,
        combine="max",
    ),
)
