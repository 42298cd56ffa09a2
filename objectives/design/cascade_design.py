"""Gains of a whole cascade from requirements on its loops: roll, pitch and yaw first, then the position loops around them.

    row = design(cascade, nominal, timing)                      # a gains row, as `plant.gains.default_row` returns one
    for axis, found in design_axes(cascade, nominal, timing).items(): print(axis, found.gains, found.why)

`design` is a starting point for a search: `space.point(row)` of a `DecisionSpace` is its point of the unit cube, so a search
that begins at "default" and at "design" takes both `space.point(default_row)` and `space.point(design(...))` into its first
generation. A command prints `design_axes` and writes the row with the study's other gains. It takes 1 to 4 s of
one core, and the import of cvxpy and CasADi another 2 s, so import this package where it is used.

Sampling enters as dead time, saturation as the requirement on kp. An attitude loop is designed by itself: with the position
loop closed around it, its peak Mt was found at 1.7 to 1.85 where 1.5 was asked for, so check the margins of the whole loop as
sampled afterwards. An axis whose law has no designer, or whose requirements cannot be met, keeps the law's defaults; so do x and
y where nothing is known of the attitude loop they act through.
"""

from collections.abc import Callable

import numpy as np

from objectives.certificates.axis_of_cascade import TILTED_BY, rotor_lag, yaw_actuator
from objectives.certificates.channel_model import MODELLED, AxisLoop, RotorLag, TiltLoop, closed_loop, is_stable
from objectives.design.adrc_design import design_hybrid, design_ladrc
from objectives.design.design_axis import AxisDesign, DesignAxis, fall_back
from objectives.design.pid_ccp import design_pid
from objectives.design.requirements import DesignRequirements
from plant.cascade import ATTITUDE_AXES, AXES, LEAST_LIFT, POSITION_AXES, Cascade
from plant.laws import hybrid, ladrc, pid
from plant.loop import Timing
from plant.nominal import Nominal
from plant.records import flatten

Designer = Callable[[DesignAxis, DesignRequirements], AxisDesign]

DESIGNERS: dict[str, Designer] = {pid.FAMILY: design_pid, ladrc.FAMILY: design_ladrc, hybrid.FAMILY: design_hybrid}
"""Designers by the family of laws that they work out gains for (`Law.family`)."""


def authority(nominal: Nominal, axis: str) -> float:
    """Return the largest acceleration of an axis at hover that both signs can have [rad/s2 or m/s2]."""
    vehicle, hover = nominal.vehicle, nominal.hover
    room = min(hover - nominal.thrust_min, nominal.thrust_max - hover)
    if axis in ATTITUDE_AXES:
        share = max(abs(float(part)) for part in getattr(nominal.allocation, axis))
        inertia = getattr(vehicle.inertia, {"roll": "x", "pitch": "y", "yaw": "z"}[axis])
        return room / share / inertia
    if axis == "z":
        return min(4.0 * room / vehicle.mass, (1.0 - LEAST_LIFT) * vehicle.gravity)
    return vehicle.gravity * nominal.tilt_tangent


def design_axes(
    cascade: Cascade, nominal: Nominal, timing: Timing, requirements: DesignRequirements | None = None
) -> dict[str, AxisDesign]:
    """Return the design of every axis, "roll", "pitch", "yaw" first."""
    requirements = requirements or DesignRequirements()
    rotors = rotor_lag(nominal, timing, order=2)
    observed = {"attitude": nominal.attitude_observer > 0.5, "position": nominal.position_observer > 0.5}
    designs: dict[str, AxisDesign] = {}
    known: dict[DesignAxis, AxisDesign] = {}
    for axis in (*ATTITUDE_AXES, *POSITION_AXES):
        loop = "attitude" if axis in ATTITUDE_AXES else "position"
        law = cascade.attitude if loop == "attitude" else cascade.position
        actuator: RotorLag | TiltLoop | None = yaw_actuator(nominal, timing, order=2) if axis == "yaw" else rotors
        if axis in TILTED_BY:
            gains = designs[TILTED_BY[axis]].gains
            attitude = AxisLoop(cascade.attitude.name, gains, rotors, "attitude", observed["attitude"])
            actuator = tilt_loop(attitude, rotors.lag_aware)
        given = DesignAxis(
            law, loop, actuator or rotors, observed[loop], timing.control_period, authority(nominal, axis)
        )
        if actuator is None:
            designs[axis] = fall_back(given, "nothing is known of the attitude loop it acts through")
        elif law.family not in DESIGNERS:
            designs[axis] = fall_back(given, f"there is no designer for the law {law.name}")
        else:
            # Axes that do not differ, such as roll and pitch of a symmetric frame, are designed once.
            if given not in known:
                known[given] = DESIGNERS[law.family](given, requirements)
            designs[axis] = known[given]
    return designs


def tilt_loop(attitude: AxisLoop, lag_aware: bool) -> TiltLoop | None:
    """Return the attitude loop as an actuator, or None where there is no model of its law or the loop is not stable."""
    if attitude.law not in MODELLED or not is_stable(closed_loop(attitude).a):
        return None
    return TiltLoop(attitude, lag_aware)


def design(
    cascade: Cascade, nominal: Nominal, timing: Timing, requirements: DesignRequirements | None = None
) -> np.ndarray:
    """Return gains that requirements on the linear loops lead to, without any search.

    Args:
        cascade: The cascade with its two laws; axes of a law without a designer keep its defaults.
        nominal: The controller's knowledge of the vehicle.
        timing: Control period and plant step [s].
        requirements: Limits that every loop keeps; the usual ones by default.

    Returns:
        The gains row (gains,), in the order of `plant.gains.gain_addresses`.
    """
    designs = design_axes(cascade, nominal, timing, requirements)
    return np.array(flatten(cascade.Gains(**{axis: designs[axis].gains for axis in AXES})))
