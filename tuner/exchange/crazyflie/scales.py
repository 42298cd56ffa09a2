"""What the firmware's outputs do on an airframe: torque for one count of its rate loops, force for one count of thrust.

In legacy mode the motors get thrust -+ roll/2 +- pitch/2 +- yaw, in counts of which 65535 are the full thrust of a motor
(power_distribution_quadrotor.c); battery compensation makes thrust proportional to counts. For a square X this is
4 l/2 T/65535 N m for a count of roll, 4 k_m T/65535 for a count of yaw. Signs are those of body FRD.
"""

import numpy as np

from plant.airframes.actuation import Actuation
from plant.errors import InputError
from tuner.exchange.autopilot.scales import Motors, TorqueScale, torque_scale
from tuner.exchange.crazyflie.table import UINT16

# The firmware's numbers of our rotors 1 to 4.
MOTORS: Motors = (4, 1, 3, 2)
# Motors in our order (front left, front right, rear left, rear right) by roll, pitch, yaw.
FACTORS = np.array([[0.5, 0.5, -1.0], [-0.5, 0.5, 1.0], [0.5, -0.5, 1.0], [-0.5, -0.5, -1.0]])
SPIN = (1.0, -1.0, -1.0, 1.0)


def check_mixing(actuation: Actuation) -> None:
    """Refuse an airframe that the firmware's fixed X mixing does not fit; raises InputError naming what of it."""
    if tuple(rotor.spin for rotor in actuation.rotors) != SPIN:
        message = (
            "given '-++-'; the Crazyflie's firmware mixes for '+--+' (the front left propeller, motor 4, turns clockwise seen "
            "from above): with the other sense its yaw loop would be unstable"
        )
        raise InputError(message, key="airframe.spin")
    torque_per_count(actuation, actuation.thrust_max)


def torque_per_count(actuation: Actuation, full: float) -> TorqueScale:
    """Return the torque for one count of roll, pitch and yaw [N m]; full: thrust of one motor at 65535 counts [N].

    Raises InputError where the mixing couples axes on this airframe.
    """
    return torque_scale(actuation, FACTORS, full / UINT16, "the Crazyflie's X mixing")


def force_per_count(full: float) -> float:
    """Return the force of all motors for one count of thrust [N]."""
    return 4.0 * full / UINT16
