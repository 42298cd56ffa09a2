"""Torque [N m] of one unit of an autopilot's outputs, from its rotors.

Each autopilot divides its output among the motors by factors of its own, without knowing arms and thrusts; what a unit of output
does is therefore a matter of the airframe:  G = diag(B T F)  with B the torque of each rotor for one unit of its thrust [m], T
its thrust for a full command [N], F the factors of the autopilot. If B T F is not diagonal, a unit of roll turns the vehicle
about other axes too, and no three numbers describe the loops: such an airframe is refused.

Body axes FRD (x forward, y right, z down), as in the autopilots. Diagonal gains are the same in FRD and FLU, for error and torque
change their signs together.
"""

from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import Actuation, RotorMount
from plant.quadrotor.vehicle import Vehicle

# Coupling between axes, relative to the smallest entry of the diagonal, above which an airframe is refused.
MAX_COUPLING = 1e-6
# A coordinate below this share of the largest counts as 0: rotors of a plus frame stand on the axes.
ON_AXIS = 1e-6
# PX4's default CA_ROTORi_CT; it cancels, but entries of the mixer below 1e-3 count as 0 there.
PX4_CT, PX4_ZERO = 6.5, 1e-3


# An autopilot's own numbers of our rotors 1 to 4: front left, front right, rear left, rear right; in a plus frame front, right,
# left, rear.
Motors = tuple[int, int, int, int]
PLACES_X = ("front left", "front right", "rear left", "rear right")
PLACES_PLUS = ("front", "right", "left", "rear")


def is_plus(actuation: Actuation) -> bool:
    """Return True if rotors lie on the body axes."""
    first = actuation.rotors[0]
    return abs(first.y) <= ON_AXIS * abs(first.x)


def turns(spin: float) -> str:
    """Return the sense in which a propeller turns, seen from above."""
    return "clockwise" if spin > 0.0 else "counter-clockwise"


def motors(actuation: Actuation, numbers: Motors) -> list[tuple[int, str, RotorMount]]:
    """Return number, place and rotor of every motor by its number."""
    places = PLACES_PLUS if is_plus(actuation) else PLACES_X
    return sorted(zip(numbers, places, actuation.rotors, strict=True), key=lambda motor: motor[0])


def motors_text(actuation: Actuation, numbers: Motors) -> str:
    """Return every motor with the autopilot's number, its place and its sense: 'motor 1 rear right clockwise, ...'."""
    text = ", ".join(
        f"motor {number} {place} {turns(rotor.spin)}" for number, place, rotor in motors(actuation, numbers)
    )
    return f"{text}, seen from above"


class TorqueScale(NamedTuple):
    """Torque about each axis for one unit of output [N m]."""

    roll: float
    pitch: float
    yaw: float


def torque_arms(actuation: Actuation) -> np.ndarray:
    """Matrix (4, 4): roll, pitch, yaw torque [m] and upward force [1] of each rotor for one unit of thrust, body FRD."""
    rotors = actuation.rotors
    return np.array(
        [
            [rotor.y for rotor in rotors],
            [rotor.x for rotor in rotors],
            [-rotor.spin * rotor.torque_ratio for rotor in rotors],
            [1.0 for _ in rotors],
        ]
    )


def px4_factors(actuation: Actuation) -> np.ndarray:
    """Matrix (4 motors, 3 axes) of PX4's control allocation, ControlAllocationPseudoInverse.cpp.

    Columns of the pseudo-inverse of the effectiveness matrix: roll and pitch divided by the larger of their root mean squares
    times sqrt 2, yaw by its largest entry.
    """
    moments = PX4_CT * torque_arms(actuation)[:3]
    forces = np.zeros((3, 4))
    forces[2] = -PX4_CT
    mix = np.linalg.pinv(np.vstack((moments, forces)))[:, :3]
    scale = [np.sqrt(np.sum(mix[:, axis] ** 2, axis=0) / (_used(mix[:, axis]) / 2.0)) for axis in (0, 1)]
    return mix / np.array([max(scale), max(scale), np.max(mix[:, 2], axis=0)])


def ardupilot_factors(actuation: Actuation) -> np.ndarray:
    """Matrix (4 motors, 3 axes) of ArduPilot's frames X and plus after AP_MotorsMatrix::normalise_rpy_factors: +-0.5 or 0."""
    return 0.5 * _signs(actuation)


def betaflight_factors(actuation: Actuation) -> np.ndarray:
    """Matrix (4 motors, 3 axes) of Betaflight's mixers QUADX and QUADP: +-1 or 0."""
    return _signs(actuation)


def crazyflie_factors(actuation: Actuation) -> np.ndarray:
    """Matrix (4 motors, 3 axes) of the Crazyflie's X mixing, power_distribution_quadrotor.c: +-0.5, yaw +-1."""
    return _signs(actuation) * np.array([0.5, 0.5, 1.0])


def torque_scale(actuation: Actuation, factors: np.ndarray, thrust: float, target: str) -> TorqueScale:
    """Return the torque for one unit of output; thrust: of one rotor for one unit of motor command [N].

    Raises InputError where one axis acts on another, or on the lift.
    """
    reach = thrust * (torque_arms(actuation) @ factors)
    diagonal = np.diag(reach[:3])
    coupling = np.max(np.abs(reach - np.vstack((np.diag(diagonal), np.zeros(3)))), axis=(0, 1))
    if not np.min(diagonal, axis=0) > 0.0 or coupling > MAX_COUPLING * np.min(diagonal, axis=0):
        raise InputError(
            f"a unit of roll, pitch or yaw of {target} turns this airframe about another axis too ({coupling:.3g} N m against "
            f"{np.min(diagonal, axis=0):.3g} N m); allowed: rotors that stand symmetrically about the centre of mass",
            key="airframe",
        )
    return TorqueScale(*[float(entry) for entry in diagonal])


def accelerations(
    actuation: Actuation, factors: np.ndarray, thrust: float, vehicle: Vehicle, target: str
) -> dict[str, float]:
    """Return the angular acceleration for one unit of output by axis [rad/s2]; thrust, target: as of `torque_scale`."""
    torque = torque_scale(actuation, factors, thrust, target)
    return {
        axis: getattr(torque, axis) / inertia for axis, inertia in zip(torque._fields, vehicle.inertia, strict=True)
    }


def _used(column: np.ndarray) -> int:
    return int(np.sum(np.abs(column) > PX4_ZERO, axis=0))


def _signs(actuation: Actuation) -> np.ndarray:
    """Return the signs (4 motors, 3 axes) of each rotor's torques.

    A rotor on an axis has 0.
    """
    arms = torque_arms(actuation)[:3]
    size = np.max(np.abs(arms), axis=1, keepdims=True)
    return np.where(np.abs(arms) > ON_AXIS * size, np.sign(arms), 0.0).T


def command_slope(actuation: Actuation, model: float) -> float:
    """Thrust [N] of a rotor for one unit of command, at hover.

    model: factor F of the curve  command = F u^2 + (1 - F) u  that the autopilot undoes before its motors (THR_MDL_FAC,
    MOT_THST_EXPO). With F the rotor's own factor the thrust is proportional and this is the largest thrust.
    """
    hover = actuation.hover_command
    return actuation.hover_slope / (2.0 * model * hover + 1.0 - model)


def linearizing_model(actuation: Actuation) -> float:
    """Return the factor F of the rotors' curve, 1 at most."""
    return min(actuation.curve, 1.0)


def linearized_slope(actuation: Actuation) -> float:
    """Return the thrust at hover per unit of a linearized command [N]."""
    return actuation.thrust_max if actuation.curve <= 1.0 else command_slope(actuation, linearizing_model(actuation))


def hover_share(actuation: Actuation, model: float) -> float:
    """Command of the autopilot at hover [1], with the model of `command_slope`."""
    hover = actuation.hover_command
    return model * hover * hover + (1.0 - model) * hover
