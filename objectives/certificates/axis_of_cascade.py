"""An axis of a cascade, as the certificates and the designs see it: its law, its gains and what it acts through."""

from collections.abc import Sequence
from dataclasses import replace

from objectives.certificates.channel_model import AxisLoop, RotorLag, TiltLoop
from plant.cascade import ATTITUDE_AXES, Cascade
from plant.loop import Timing
from plant.nominal import Nominal, yaw_lead
from plant.records import pack
from plant.vehicle import late_periods

# The attitude axis that turns the thrust towards a horizontal position axis.
TILTED_BY = {"x": "pitch", "y": "roll"}


def rotor_lag(nominal: Nominal, timing: Timing, order: int = 1) -> RotorLag:
    """Return the rotors as an actuator: mean lag of the vehicle, half a period of hold, computing and dead time."""
    vehicle, h = nominal.vehicle, timing.control_period
    lag = 0.5 * (vehicle.lag_up + vehicle.lag_down)
    late = late_periods(vehicle, h)
    # Of the first order the approximant lags too little where a dead time of whole periods is added.
    return RotorLag(lag, (0.5 + nominal.delay + late) * h, nominal.position_achieved > 0.5, order + (late > 0))


def yaw_actuator(nominal: Nominal, timing: Timing, order: int = 1) -> RotorLag:
    """Return the rotors as they turn the vehicle: with the lead of their inertia, behind the low-pass on yaw torque."""
    kept = 1.0 - nominal.yaw_smoothing
    smoothing = timing.control_period * kept / nominal.yaw_smoothing
    return replace(rotor_lag(nominal, timing, order), lead=1.0 / yaw_lead(nominal.vehicle), smoothing=smoothing)


def axis_loop(
    cascade: Cascade, row: Sequence[float], nominal: Nominal, timing: Timing, axis: str, order: int = 1
) -> AxisLoop:
    """Return one axis ("x" to "yaw") of a gains row; order: of the Pade approximant of its dead time."""
    gains = pack(cascade.Gains, map(float, row))
    rotors = (yaw_actuator if axis == "yaw" else rotor_lag)(nominal, timing, order)
    attitude = axis in ATTITUDE_AXES
    law = cascade.attitude if attitude else cascade.position
    observed = nominal.attitude_observer if attitude else nominal.position_observer
    actuator: RotorLag | TiltLoop = rotors
    if axis in TILTED_BY:
        inner = axis_loop(cascade, row, nominal, timing, TILTED_BY[axis], order)
        actuator = TiltLoop(inner, nominal.position_achieved > 0.5)
    return AxisLoop(law.name, getattr(gains, axis), actuator, "attitude" if attitude else "position", observed > 0.5)
