"""Small vectors of scalars, and the operations on them.

Every field is one scalar: a float in the python backend, an array in numpy, a SIMD lane in lanes, an expression in casadi.
"""

from typing import NamedTuple

from plant.primitives import sqrt


class Vec3(NamedTuple):
    """Components along x, y, z of a frame."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """Unit quaternion, scalar first, rotating body (FLU) into world (ENU) coordinates."""

    w: float
    x: float
    y: float
    z: float


class Rotors(NamedTuple):
    """One scalar for each rotor: 1 front left, 2 front right, 3 rear left, 4 rear right.

    In a plus frame: 1 front, 2 right, 3 left, 4 rear.
    """

    r1: float
    r2: float
    r3: float
    r4: float


def axpy3(a: Vec3, s: float, b: Vec3) -> Vec3:
    """Return a + s b."""
    return Vec3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z)


def axpy_quaternion(a: Quaternion, s: float, b: Quaternion) -> Quaternion:
    """Return a + s b, not normalised."""
    return Quaternion(a.w + s * b.w, a.x + s * b.x, a.y + s * b.y, a.z + s * b.z)


def axpy_rotors(a: Rotors, s: float, b: Rotors) -> Rotors:
    """Return a + s b."""
    return Rotors(a.r1 + s * b.r1, a.r2 + s * b.r2, a.r3 + s * b.r3, a.r4 + s * b.r4)


def rotors_sum(a: Rotors) -> float:
    """Return the sum over the four rotors."""
    return a.r1 + a.r2 + a.r3 + a.r4


def rotors_dot(a: Rotors, b: Rotors) -> float:
    """Return sum_i a_i b_i."""
    return a.r1 * b.r1 + a.r2 * b.r2 + a.r3 * b.r3 + a.r4 * b.r4


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Return a x b."""
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def norm3(a: Vec3) -> float:
    """Return the Euclidean length of a."""
    return sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


def renormalize(q: Quaternion) -> Quaternion:
    """Return q scaled to unit length, for a q that is already close to it: one Newton step, s = (3 - |q|^2)/2.

    For |q|^2 = 1 + d the result has length 1 - 3 d^2/8, and one Runge-Kutta step of 1 ms leaves |d| below 1e-9 even at 20 rad/s.
    """
    s = 1.5 - 0.5 * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z)
    return Quaternion(s * q.w, s * q.x, s * q.y, s * q.z)


def to_world(q: Quaternion, a: Vec3) -> Vec3:
    """Rotate a from body (FLU) to world (ENU): R(q) a, from v' = v + 2 w (u x v) + 2 u x (u x v) with u = (x, y, z) of q."""
    u = Vec3(q.x, q.y, q.z)
    t = cross(u, a)
    return axpy3(axpy3(a, 2.0 * q.w, t), 2.0, cross(u, t))


def to_body(q: Quaternion, a: Vec3) -> Vec3:
    """Rotate a from world (ENU) to body (FLU): R(q)' a."""
    return to_world(Quaternion(q.w, -q.x, -q.y, -q.z), a)


def quaternion_rate(q: Quaternion, rate: Vec3) -> Quaternion:
    """Return dq/dt = q (0, rate) / 2 for body rates in rad/s."""
    return Quaternion(
        -0.5 * (q.x * rate.x + q.y * rate.y + q.z * rate.z),
        0.5 * (q.w * rate.x + q.y * rate.z - q.z * rate.y),
        0.5 * (q.w * rate.y - q.x * rate.z + q.z * rate.x),
        0.5 * (q.w * rate.z + q.x * rate.y - q.y * rate.x),
    )
