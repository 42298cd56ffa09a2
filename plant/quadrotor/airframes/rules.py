"""Sanity rules that the numbers of any real quadrotor obey: they catch shifted rows and wrong units, not bad designs.

The bounds leave room around every bundled vehicle but `paper-literal`: thrust to weight 1.33..3.68, k_m / k_f
0.006..0.060 m, 0.066..0.455 of the diameter, lag 5..25 ms (0.1 s of small brushed motors that slow down), Iz / mean(Ix, Iy)
1.55..1.92. The last has no upper bound of its own: Iz <= Ix + Iy, the triangle inequality, already says 2.
"""

from collections.abc import Callable
from math import inf, pi, sqrt

from plant.quadrotor.vehicle import Vehicle

THRUST_TO_WEIGHT = (1.2, 15.0)
"""Racing quadrotors have the most: 5-inch ones of 0.5 to 0.6 kg, with four motors of 1.5 to 1.8 kgf on a bench, 10 to 14. A
speed in rpm that was meant in rad/s is 91 times too much.
"""
TORQUE_RATIO = (0.02, 0.5)
"""k_m / k_f over the diameter of a propeller with this k_f. Momentum theory asks for sqrt(C_T / (2 pi^3)) over the figure of
merit (J. G. Leishman, Principles of Helicopter Aerodynamics, chapter 2): 0.04 at the least with the C_T below.
"""
THRUST = 0.1 * 1.225
"""C_T rho [kg/m3] by which a thrust coefficient tells a diameter; C_T of 0.05 to 0.2 is 16 % up to 19 % of it."""
HOVER_SPEED_SHARE = 0.9
"""Largest hover speed as a share of the maximum speed: thrust must leave room to control with."""
LAG = (0.005, 0.200)
"""[s]; the rotors of a Crazyflie slow down with 0.1 s."""
YAW_INERTIA_RATIO = 1.2
"""Smallest Iz / mean(Ix, Iy): rotors on arms in one plane put their mass far from z. A lamina has exactly 2."""

Rule = Callable[[Vehicle], str | None]


def hover_speed(vehicle: Vehicle) -> float:
    """Return the rotor speed [rad/s] at which four equal rotors carry the weight."""
    return sqrt(vehicle.mass * vehicle.gravity / (4.0 * vehicle.thrust_coefficient))


def thrust_to_weight(vehicle: Vehicle) -> float:
    """Return the thrust of all rotors at speed_max over the weight."""
    return (vehicle.speed_max / hover_speed(vehicle)) ** 2


def propeller_diameter(vehicle: Vehicle) -> float:
    """Return the diameter [m] of a usual propeller with the thrust coefficient of a vehicle: k_f = C_T rho D^4 / (2 pi)^2."""
    return (4.0 * pi**2 * vehicle.thrust_coefficient / THRUST) ** 0.25


def torque_ratios(vehicle: Vehicle) -> tuple[float, float]:
    """Return the least and the largest k_m / k_f [m] of propellers as large as those of a vehicle."""
    low, high = TORQUE_RATIO
    return low * propeller_diameter(vehicle), high * propeller_diameter(vehicle)


def broken_rules(vehicle: Vehicle) -> tuple[str, ...]:
    """Return one sentence with numbers per broken rule; empty where all hold. Non-finite numbers break rules."""
    wrong_sign = _signs(vehicle)
    if wrong_sign is not None:  # the other rules divide by these numbers
        return (wrong_sign,)
    return tuple(sentence for rule in RULES if (sentence := rule(vehicle)) is not None)


def _signs(vehicle: Vehicle) -> str | None:
    numbers = {
        "mass": vehicle.mass,
        **{f"inertia.{axis}": value for axis, value in vehicle.inertia._asdict().items()},
        "thrust_coefficient": vehicle.thrust_coefficient,
        "torque_ratio": vehicle.torque_ratio,
        "lag_up": vehicle.lag_up,
        "lag_down": vehicle.lag_down,
        "speed_max": vehicle.speed_max,
        "gravity": vehicle.gravity,
    }
    wrong = [f"{name} = {value:g}" for name, value in numbers.items() if not 0.0 < value < inf]
    return f"must be positive and finite: {', '.join(wrong)}" if wrong else None


def _triangle(vehicle: Vehicle) -> str | None:
    axes = vehicle.inertia._asdict()
    largest = max(axes, key=lambda axis: axes[axis])
    rest = sum(axes.values()) - axes[largest]
    # The allowance of a few ulp lets a lamina through, for which equality holds.
    if axes[largest] <= rest * (1.0 + 1e-12):
        return None
    others = " + ".join(f"I{axis}" for axis in axes if axis != largest)
    return f"triangle inequality: I{largest} = {axes[largest]:g} exceeds {others} = {rest:g} kg m2"


def _yaw_inertia(vehicle: Vehicle) -> str | None:
    ratio = 2.0 * vehicle.inertia.z / (vehicle.inertia.x + vehicle.inertia.y)
    if ratio >= YAW_INERTIA_RATIO:
        return None
    return f"yaw inertia: Iz / mean(Ix, Iy) = {ratio:.3g}, a quadrotor has {YAW_INERTIA_RATIO:g} to 2"


def _thrust_to_weight(vehicle: Vehicle) -> str | None:
    ratio = thrust_to_weight(vehicle)
    low, high = THRUST_TO_WEIGHT
    if low <= ratio <= high:
        return None
    return f"thrust to weight: {ratio:.3g} at speed_max = {vehicle.speed_max:g} rad/s, allowed {low:g} to {high:g}"


def _torque_ratio(vehicle: Vehicle) -> str | None:
    low, high = torque_ratios(vehicle)
    if low <= vehicle.torque_ratio <= high:
        return None
    return (
        f"torque ratio: k_m / k_f = {vehicle.torque_ratio:.3g} m; propellers of this thrust coefficient, about "
        f"{1000.0 * propeller_diameter(vehicle):.2g} mm, have {low:.2g} to {high:.2g} m"
    )


def _hover_speed(vehicle: Vehicle) -> str | None:
    hover, highest = hover_speed(vehicle), HOVER_SPEED_SHARE * vehicle.speed_max
    if vehicle.speed_min < hover < highest:
        return None
    return (
        f"hover speed: {hover:.4g} rad/s must lie between speed_min = {vehicle.speed_min:.4g} and "
        f"{HOVER_SPEED_SHARE:g} speed_max = {highest:.4g} rad/s"
    )


def _lag(vehicle: Vehicle) -> str | None:
    low, high = LAG
    if low <= vehicle.lag_up <= high and low <= vehicle.lag_down <= high:
        return None
    return f"motor lag: up {vehicle.lag_up:g} s, down {vehicle.lag_down:g} s, allowed {low:g} to {high:g} s"


RULES: tuple[Rule, ...] = (_triangle, _yaw_inertia, _thrust_to_weight, _torque_ratio, _hover_speed, _lag)
