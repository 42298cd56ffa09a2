"""Our PID on an angle (or position) as a proportional loop around a PI loop on its rate, the form of most autopilots, and back.

Ours, in acceleration units:        kp (r - y) + ki int (r - y) + kd (r' - y')
Theirs, on the rate, with a outside: P (a (r - y) - y') + I int (a (r - y) - y') = (P a + I) (..) with y alone as follows:

    feedback of y:  kp = P a + I,   of its integral:  ki = I a,   of its rate:  kd = P

so a is a root of kd a^2 - kp a + ki = 0, and I/P the other one: the larger, which gives the reference more weight, or for a
vehicle that flies already the one nearer to its own. The feedback, and with it every margin, is the same; the reference enters
with P a instead of kp, a setpoint weight of P a / kp (K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, section 3.4).
"""

from dataclasses import dataclass
from math import sqrt

from plant.errors import InputError
from plant.laws.pid import Gains

# Gains this close to each other, relatively, are one: both ways of the conversion round.
SAME = 1e-9


@dataclass(frozen=True)
class RateLoop:
    """outer [1/s]: proportional gain outside; p [1/s], i [1/s2]: gains of the rate loop, acceleration per rate and angle."""

    outer: float
    p: float
    i: float

    @property
    def setpoint_weight(self) -> float:
        """Share of the proportional action that the reference gets [1]."""
        return self.p * self.outer / (self.p * self.outer + self.i)


def rate_loop(gains: Gains, axis: str, own: RateLoop | None = None) -> RateLoop:
    """Return the cascaded form; own: that of the vehicle, which stays where it gives these gains and else chooses the root.

    Raises InputError naming the axis where there is none (4 kd ki > kp^2 or kd = 0).
    """
    if own is not None and same_feedback(parallel(own, gains.t_f), gains):
        return own
    kp, ki, kd = gains.kp, gains.ki, gains.kd
    if kd <= 0.0:
        message = f"given {kd:g} 1/s; a target with a loop on the rate needs kd above 0: tune with kd as a gain"
        raise InputError(message, key=f"{axis}.kd")
    square = kp * kp - 4.0 * kd * ki
    if square < -SAME * kp * kp:
        most = kp * kp / (4.0 * kd)
        message = (
            f"given {ki:g} s^-3; an angle loop around a rate loop carries at most kp^2/(4 kd) = {most:g} s^-3 with these "
            f"kp and kd: bound ki in the study's [gains]"
        )
        raise InputError(message, key=f"{axis}.ki")
    twice = kp + sqrt(max(square, 0.0))
    larger, smaller = twice / (2.0 * kd), 2.0 * ki / twice
    if own is not None and abs(own.outer - smaller) < abs(own.outer - larger):
        return RateLoop(smaller, kd, kd * larger)
    return RateLoop(larger, kd, kd * smaller)


def same_feedback(one: Gains, other: Gains) -> bool:
    """Return whether two sets of gains are one but for rounding; the filter does not count."""
    return all(abs(a - b) <= SAME * max(abs(a), abs(b)) for a, b in zip(one[:3], other[:3], strict=True))


def parallel(loop: RateLoop, t_f: float) -> Gains:
    """Return our gains for the cascaded form; t_f: filter time constant of the rate [s]."""
    return Gains(loop.p * loop.outer + loop.i, loop.i * loop.outer, loop.p, t_f)
