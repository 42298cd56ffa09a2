"""From thrust and torque to rotor commands within limits, yaw given up first.

Thrust, roll and pitch are allocated first; yaw gets the largest share (0 to 1) that keeps every rotor inside its limits;
what still exceeds them is clipped.
"""

from plant.primitives import absolute, clip, either, maximum, minimum, select, sqrt
from plant.quadrotor.nominal import Allocation, Nominal
from plant.vectors import Rotors, Vec3, axpy_rotors

# Keeps the quotient finite where no yaw torque is asked for [N m].
MIN_TORQUE = 1e-15
# A command this close to a limit, as a share of the range, stands at it: where yaw is scaled to fit, rounding would decide else.
AT_LIMIT = 1e-6


def headroom(base: float, extra: float, low: float, high: float) -> float:
    """Room that `base` has in the direction of `extra` before it leaves [low, high]; negative where base is outside."""
    return select(extra > 0.0, high - base, base - low)


def allocate(thrust: float, torque: Vec3, nominal: Nominal) -> Rotors:
    """Rotor thrusts [N] within limits for a total thrust [N] and a body torque [N m]."""
    inverse: Allocation = nominal.allocation
    low, high = nominal.thrust_min, nominal.thrust_max
    base = axpy_rotors(
        axpy_rotors(axpy_rotors(Rotors(0.0, 0.0, 0.0, 0.0), thrust, inverse.thrust), torque.x, inverse.roll),
        torque.y,
        inverse.pitch,
    )
    yaw = axpy_rotors(Rotors(0.0, 0.0, 0.0, 0.0), torque.z, inverse.yaw)
    reach = nominal.yaw_reach
    front = minimum(reach.r1 * headroom(base.r1, yaw.r1, low, high), reach.r2 * headroom(base.r2, yaw.r2, low, high))
    rear = minimum(reach.r3 * headroom(base.r3, yaw.r3, low, high), reach.r4 * headroom(base.r4, yaw.r4, low, high))
    share = minimum(front, rear) / maximum(absolute(torque.z), MIN_TORQUE)
    wanted = axpy_rotors(base, clip(share, 0.0, 1.0), yaw)
    return Rotors(
        clip(wanted.r1, low, high), clip(wanted.r2, low, high), clip(wanted.r3, low, high), clip(wanted.r4, low, high)
    )


def speed_commands(thrust: Rotors, nominal: Nominal) -> Rotors:
    """Rotor speeds [rad/s] that give the rotor thrusts [N] on the nominal vehicle: w = sqrt(T / k_f)."""
    k_f = nominal.vehicle.thrust_coefficient
    return Rotors(sqrt(thrust.r1 / k_f), sqrt(thrust.r2 / k_f), sqrt(thrust.r3 / k_f), sqrt(thrust.r4 / k_f))


def saturated(thrust: Rotors, nominal: Nominal) -> float:
    """1 where any rotor command stands at a limit, else 0."""
    lowest = minimum(minimum(thrust.r1, thrust.r2), minimum(thrust.r3, thrust.r4))
    highest = maximum(maximum(thrust.r1, thrust.r2), maximum(thrust.r3, thrust.r4))
    margin = AT_LIMIT * (nominal.thrust_max - nominal.thrust_min)
    low, high = nominal.thrust_min + margin, nominal.thrust_max - margin
    return select(either(lowest <= low, highest >= high), 1.0, 0.0)
