"""An axis of a cascade for certificates and designs: its law, its gains and its actuator."""

from collections.abc import Sequence
from dataclasses import replace

from objectives.linear_axis.channel_model import AxisLoop, RotorLag, TiltLoop
from plant.loop import Timing
from plant.quadrotor.cascade import ATTITUDE_AXES, Cascade
from plant.quadrotor.nominal import Nominal, yaw_lead
from plant.quadrotor.vehicle import late_periods
from plant.records import pack

# The attitude axis that turns the thrust towards a horizontal position axis.
TILTED_BY = {"x": "pitch", "y": "roll"}


def rotor_lag(nominal: Nominal, timing: Timing, order: int = 1) -> RotorLag:
    """Return the rotors as an actuator: mean lag of the vehicle, half a period of hold, computing and dead time."""
    vehicle, control_period = nominal.vehicle, timing.control_period
    lag = 0.5 * (vehicle.lag_up + vehicle.lag_down)
    late = late_periods(vehicle, control_period)
    # Of the first order the approximant lags too little where a dead time of whole periods is added.
    order = max(order, 2 if late else 1)
    return RotorLag(lag, (0.5 + nominal.delay + late) * control_period, nominal.position_achieved > 0.5, order)


def yaw_actuator(nominal: Nominal, timing: Timing, order: int = 1) -> RotorLag:
    """Return the rotors as they turn the vehicle: with the lead of their inertia, behind the low-pass on yaw torque."""
    memory = 1.0 - nominal.yaw_smoothing
    smoothing = timing.control_period * memory / nominal.yaw_smoothing
    return replace(rotor_lag(nominal, timing, order), lead=1.0 / yaw_lead(nominal.vehicle), smoothing=smoothing)


def open_axis(
    cascade: Cascade, nominal: Nominal, timing: Timing, axis: str, order: int, attitude: AxisLoop | None = None
) -> AxisLoop:
    """Return one axis without gains.

    Args:
        cascade: The cascade with its two laws.
        nominal: The controller's knowledge of the vehicle.
        timing: Control period and plant step [s].
        axis: "x" to "yaw".
        order: Order of the Pade approximant of its dead time.
        attitude: The attitude loop that x and y act through.
    """
    loop = "attitude" if axis in ATTITUDE_AXES else "position"
    is_observed = getattr(nominal, f"{loop}_observer") > 0.5
    actuator: RotorLag | TiltLoop = (yaw_actuator if axis == "yaw" else rotor_lag)(nominal, timing, order)
    if attitude is not None:
        actuator = TiltLoop(attitude, actuator.lag_aware)
    return AxisLoop(getattr(cascade, loop).name, None, actuator, loop, is_observed)


def axis_loop(
    cascade: Cascade, row: Sequence[float], nominal: Nominal, timing: Timing, axis: str, order: int = 1
) -> AxisLoop:
    """Return one axis ("x" to "yaw") of a gains row; order: of the Pade approximant of its dead time."""
    tilting = TILTED_BY.get(axis)
    attitude = None if tilting is None else axis_loop(cascade, row, nominal, timing, tilting, order)
    gains = getattr(pack(cascade.Gains, map(float, row)), axis)
    return replace(open_axis(cascade, nominal, timing, axis, order, attitude), gains=gains)
