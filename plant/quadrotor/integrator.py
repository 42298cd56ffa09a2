"""Classical fourth-order Runge-Kutta step of the plant, command and disturbance held over the step.

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, table II.1.2. The quaternion is
normalised after the step: its length drifts at the order of the method, and nothing else in the state is projected.
"""

from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Body, Dynamics, axpy_body, body_rate
from plant.vectors import Rotors, renormalize


def runge_kutta_step(body: Body, command: Rotors, disturbance: Disturbance, f: Dynamics, h: float) -> Body:
    """Advance the plant by h seconds; command: rotor speeds asked for [rad/s]."""
    k1 = body_rate(body, command, disturbance, f)
    k2 = body_rate(axpy_body(body, 0.5 * h, k1), command, disturbance, f)
    k3 = body_rate(axpy_body(body, 0.5 * h, k2), command, disturbance, f)
    k4 = body_rate(axpy_body(body, h, k3), command, disturbance, f)
    end = axpy_body(axpy_body(axpy_body(axpy_body(body, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4)
    return Body(end.position, end.velocity, renormalize(end.attitude), end.rate, end.rotor_speed)
