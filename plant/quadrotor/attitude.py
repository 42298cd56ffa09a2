"""Angles and directions of an attitude quaternion (body FLU -> world ENU, ZYX Euler angles)."""

from plant.primitives import asin, atan2, clip, floor, sqrt
from plant.vectors import Quaternion, Vec3

TWO_PI = 6.283185307179586


def euler_angles(q: Quaternion) -> Vec3:
    """Roll, pitch, yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll); pitch in [-pi/2, pi/2]."""
    return Vec3(
        atan2(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (q.x * q.x + q.y * q.y)),
        asin(clip(2.0 * (q.w * q.y - q.z * q.x), -1.0, 1.0)),
        atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)),
    )


def thrust_direction(q: Quaternion) -> Vec3:
    """Body z axis in world coordinates: third column of R(q)."""
    return Vec3(2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x), 1.0 - 2.0 * (q.x * q.x + q.y * q.y))


def heading_direction(q: Quaternion) -> Vec3:
    """Horizontal unit vector of the yaw angle: (cos yaw, sin yaw, 0); undefined only where the nose points straight up."""
    x = 1.0 - 2.0 * (q.y * q.y + q.z * q.z)
    y = 2.0 * (q.w * q.z + q.x * q.y)
    s = 1.0 / sqrt(x * x + y * y)
    return Vec3(s * x, s * y, 0.0)


def nearest_turn(angle: float, reference: float) -> float:
    """Return the angle [rad] unwrapped to within half a turn of the reference."""
    return angle - TWO_PI * floor((angle - reference) / TWO_PI + 0.5)
