"""Pass through given points at given times, at rest at the first and the last: flights planned elsewhere.

Between them runs the curve of least integrated squared jerk: the quintic spline through the points, continuous up to
the fourth derivative, with zero velocity and acceleration at both ends (the via-point movement of Flash & Hogan, J.
Neurosci. 5(7), 1985, with given times). Where points ask for sudden changes of pace it swings out between them; add
points there.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from plant.references.spec import ReferenceSpec, Track, motion
from plant.references.waypoint_file import read_waypoints


@dataclass(frozen=True, kw_only=True)
class Waypoints(ReferenceSpec):
    """Points at given times from a CSV file, joined by the smoothest (minimum-jerk) curve; rests at the last one.

    points: one row t [s], x, y, z [m], yaw [deg] per point, read from the file when the reference is made.
    """

    kind: ClassVar[str] = "waypoints"

    path: str = field(metadata={"unit": "path", "meaning": "CSV file with the header t,x,y,z or t,x,y,z,yaw_deg"})
    points: tuple[tuple[float, ...], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Read and check the file; InputError names file and line."""
        super().__post_init__()
        object.__setattr__(self, "points", read_waypoints(Path(self.path)))

    def track(self, t: np.ndarray) -> Track:
        """Return the spline with its analytic derivatives, then rest at the last point."""
        # SciPy's interpolation takes 0.3 s to import, which only flights through waypoints should pay.
        from scipy.interpolate import make_interp_spline

        table = np.array(self.points)
        rest = [(1, np.zeros(4)), (2, np.zeros(4))]
        spline = make_interp_spline(table[:, 0], table[:, 1:], k=5, bc_type=(rest, rest))
        last = table[-1, 0]
        moving = (t <= last)[:, None]
        clamped = np.minimum(t, last)
        position, velocity, acceleration = spline(clamped), spline(clamped, 1) * moving, spline(clamped, 2) * moving
        yaw, yaw_rate = np.radians(position[:, 3]), np.radians(velocity[:, 3])
        return motion(position[:, :3], velocity[:, :3], acceleration[:, :3], yaw, yaw_rate)
