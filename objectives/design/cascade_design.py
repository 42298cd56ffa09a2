"""Gains of a whole cascade from requirements on its loops: roll, pitch and yaw first, then the position loops around them.

    row = design(cascade, nominal, timing)                      # a gains row, as `plant.quadrotor.gains.default_row` returns one
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
from functools import lru_cache

import numpy as np

from objectives.design.adrc_design import design_hybrid, design_ladrc
from objectives.design.design_axis import AxisDesign, DesignAxis, fall_back
from objectives.design.pid_ccp import design_pid
from objectives.design.requirements import DesignRequirements
from objectives.linear_axis.axis_of_cascade import TILTED_BY, open_axis
from objectives.linear_axis.channel_model import MODELLED, AxisLoop, closed_loop, is_stable
from plant.laws import hybrid, ladrc, pid
from plant.loop import Timing
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, MIN_LIFT, POSITION_AXES, Cascade
from plant.quadrotor.nominal import Nominal
from plant.records import flatten

Designer = Callable[[DesignAxis, DesignRequirements], AxisDesign]

DESIGNERS: dict[str, Designer] = {pid.FAMILY: design_pid, ladrc.FAMILY: design_ladrc, hybrid.FAMILY: design_hybrid}
"""Designers by the family of laws that they work out gains for (`Law.family`)."""


def authority(nominal: Nominal, axis: str) -> float:
    """Return the largest acceleration of an axis at hover [rad/s2 or m/s2].

    Both signs can have it.
    """
    vehicle, hover = nominal.vehicle, nominal.hover
    room = min(hover - nominal.thrust_min, nominal.thrust_max - hover)
    if axis in ATTITUDE_AXES:
        share = max(abs(float(part)) for part in getattr(nominal.allocation, axis))
        inertia = getattr(vehicle.inertia, {"roll": "x", "pitch": "y", "yaw": "z"}[axis])
        return room / share / inertia
    if axis == "z":
        return min(4.0 * room / vehicle.mass, (1.0 - MIN_LIFT) * vehicle.gravity)
    return vehicle.gravity * nominal.tilt_tangent


def design_axes(
    cascade: Cascade, nominal: Nominal, timing: Timing, requirements: DesignRequirements | None = None
) -> dict[str, AxisDesign]:
    """Return the design of every axis, "roll", "pitch", "yaw" first."""
    requirements = requirements or DesignRequirements()
    designs: dict[str, AxisDesign] = {}
    loops: dict[str, AxisLoop] = {}
    for axis in (*ATTITUDE_AXES, *POSITION_AXES):
        attitude = loops.get(TILTED_BY.get(axis, ""))
        loop = open_axis(cascade, nominal, timing, axis, 2, attitude)
        law = cascade.attitude if loop.loop == "attitude" else cascade.position
        given = DesignAxis(
            law, loop.loop, loop.actuator, loop.from_observer, timing.control_period, authority(nominal, axis)
        )
        if attitude is not None and not (attitude.law in MODELLED and is_stable(closed_loop(attitude).a)):
            designs[axis] = fall_back(given, "nothing is known of the attitude loop it acts through")
        elif law.family not in DESIGNERS:
            designs[axis] = fall_back(given, f"there is no designer for the law {law.name}")
        else:
            designs[axis] = _designed(law.family, given, requirements)
        loops[axis] = given.closed(designs[axis].gains)
    return designs


@lru_cache(maxsize=64)
def _designed(family: str, given: DesignAxis, requirements: DesignRequirements) -> AxisDesign:
    """Return the design of an axis: once for axes that do not differ, and for the start and the end of a run."""
    return DESIGNERS[family](given, requirements)


def design(
    cascade: Cascade, nominal: Nominal, timing: Timing, requirements: DesignRequirements | None = None
) -> np.ndarray:
    """Return gains by requirements on the linear loops, without any search.

    Args:
        cascade: The cascade with its two laws; axes of a law without a designer keep its defaults.
        nominal: The controller's knowledge of the vehicle.
        timing: Control period and plant step [s].
        requirements: Limits that every loop keeps; the usual ones by default.

    Returns:
        The gains row (gains,), in the order of `plant.quadrotor.gains.gain_addresses`.
    """
    designs = design_axes(cascade, nominal, timing, requirements)
    return np.array(flatten(cascade.Gains(**{axis: designs[axis].gains for axis in AXES})))
