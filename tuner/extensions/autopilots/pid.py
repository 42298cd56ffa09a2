"""Our PID as a proportional loop around a PI loop, and back.

Ours is on an angle (or position), the inner loop on its rate, the form of most autopilots.

Ours, in acceleration units:        kp (r - y) + ki int (r - y) + kd (r' - y')
Theirs, on the rate, with a outside: P (a (r - y) - y') + I int (a (r - y) - y') = (P a + I) (..) with y alone as follows:

    feedback of y:  kp = P a + I,   of its integral:  ki = I a,   of its rate:  kd = P

so a is a root of kd a^2 - kp a + ki = 0, and I/P the other one: the larger, which gives the reference more weight, or for a
vehicle that flies already the one nearer to its own. The feedback, and with it every margin, is the same; the reference enters
with P a instead of kp, a setpoint weight of P a / kp (K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, section 3.4).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt

from plant.errors import InputError
from plant.laws.pid import Gains
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import MAX_CUTOFF, MIN_CUTOFF
from tuner.gains import Controller

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


def rate_loop(gains: Gains, axis: str, present: RateLoop | None = None) -> RateLoop:
    """Return the cascaded form; present: that of the vehicle, which stays where it gives these gains and else chooses the root.

    Raises InputError naming the axis where there is none (4 kd ki > kp^2 or kd = 0).
    """
    if present is not None and same_feedback(parallel(present, gains.t_f), gains):
        return present
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
    if present is not None and abs(present.outer - smaller) < abs(present.outer - larger):
        return RateLoop(smaller, kd, kd * larger)
    return RateLoop(larger, kd, kd * smaller)


def same_feedback(one: Gains, other: Gains) -> bool:
    """Return true for gains that are equal but for rounding; filters do not count."""
    return all(abs(a - b) <= SAME * max(abs(a), abs(b)) for a, b in zip(one[:3], other[:3], strict=True))


def parallel(loop: RateLoop, t_f: float) -> Gains:
    """Return our gains for the cascaded form; t_f: filter time constant of the rate [s]."""
    return Gains(loop.p * loop.outer + loop.i, loop.i * loop.outer, loop.p, t_f)


# Our tilt limit, where a vehicle's lies outside [rad].
MIN_TILT, MAX_TILT = 0.05, 1.05


def axis_gains(controller: Controller, axis: str) -> Gains:
    """Return the PID gains of one axis."""
    held = {
        gain.info.name: controller.gains[gain.column]
        for gain in gain_addresses(controller.cascade)
        if gain.axis == axis
    }
    return Gains(**held)


def with_gains(controller: Controller, gains: Mapping[str, Gains]) -> Controller:
    """Return the controller with the PID gains of some axes replaced; other axes may have other laws."""
    row = list(controller.gains)
    for gain in gain_addresses(controller.cascade):
        if gain.axis in gains:
            row[gain.column] = getattr(gains[gain.axis], gain.info.name)
    return replace(controller, gains=tuple(row))


def with_measured_rates(controller: Controller, yaw_filter: bool = False) -> Controller:
    """Return the controller with gyro and velocity as rates: as autopilots have them.

    yaw_filter: the target has a low-pass on yaw torque, which is left out otherwise.
    """
    cutoff = controller.options.yaw_torque_cutoff if yaw_filter else 0.0
    options = replace(controller.options, attitude_rate="measured", position_rate="measured", yaw_torque_cutoff=cutoff)
    return replace(controller, options=options)


def check_horizontal(controller: Controller, target: str) -> None:
    """Refuse position gains that differ between x and y; raises InputError naming the gain."""
    x, y = axis_gains(controller, "x"), axis_gains(controller, "y")
    for name in ("kp", "ki", "kd"):
        one, other = getattr(x, name), getattr(y, name)
        if abs(one - other) > SAME * max(abs(one), abs(other)):
            raise InputError(
                f"given {other:g}, and x.{name} = {one:g}; {target} has one set for x and y: tune them together, as "
                f'"horizontal.{name}" in the study\'s [gains]',
                key=f"y.{name}",
            )


def rate_sources(controller: Controller, yaw_filter: bool = False) -> tuple[str, ...]:
    """Return sentences on observed rates, and on a lost yaw low-pass."""
    options, cutoff = controller.options, controller.options.yaw_torque_cutoff
    loops = (("attitude", options.attitude_rate, "the gyro"), ("position", options.position_rate, "estimated velocity"))
    lost = f"The low-pass on yaw torque at {cutoff:g} Hz has no counterpart; what is verified flies without it."
    observed = tuple(
        f"The {loop} loops were tuned with differenced rates (observer); the target takes {source}, and so does what is verified."
        for loop, rate, source in loops
        if rate == "observer"
    )
    return observed if yaw_filter or cutoff == 0.0 else (*observed, lost)


def setpoint_weights(weights: Mapping[str, float]) -> str:
    """Return the sentence on the setpoint weights."""
    shares = ", ".join(f"{axis} {100.0 * weight:.0f} %" for axis, weight in weights.items())
    return (
        "The reference enters through the outer loop alone: feedback and margins are the same, but the proportional action gets "
        f"this share of the reference: {shares}, and no reference rate."
    )


def rate_filters(controller: Controller, axes: tuple[str, ...]) -> str:
    """Return our derivative filters as text: 'roll 5 ms'."""
    return ", ".join(f"{axis} {1000.0 * axis_gains(controller, axis).t_f:.3g} ms" for axis in axes)


def held_tilt(tilt: float) -> float:
    """Return a vehicle's largest tilt as our controller holds it [rad]."""
    return min(max(tilt, MIN_TILT), MAX_TILT)


def held_cutoff(cutoff: float) -> float:
    """Return a vehicle's yaw low-pass within our range [Hz], 0 for none."""
    return min(max(cutoff, MIN_CUTOFF), MAX_CUTOFF) if cutoff > 0.0 else 0.0


def written_cutoff(controller: Controller, present: float | None) -> float:
    """Return the low-pass on yaw torque for the vehicle [Hz]: unchanged where ours follows from it."""
    cutoff = controller.options.yaw_torque_cutoff
    return present if present is not None and abs(held_cutoff(present) - cutoff) <= SAME * cutoff else cutoff


def weighted(gains: Gains, factor: float) -> Gains:
    """Return a loop's gains for a multiple of inertia or mass."""
    return Gains(factor * gains.kp, factor * gains.ki, factor * gains.kd, gains.t_f)
