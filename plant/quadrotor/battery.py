"""Battery whose voltage falls with current and charge, and the controller's compensation.

    V (V0(q) - V)/R = P,    V0(q) = full - (full - empty) q/capacity,    P = hover_power sum w_i^3 / (4 w_hover^3),    q' = P/V

V is the voltage under load, the upper root of the first equation; q is the charge that has been used. A speed controller turns a
command into a share of the voltage, so a rotor turns towards w_c V/V_ref, where V_ref is V in hover on a full battery: there
thrust and speeds hold as the airframe's file gives them. Power goes with the cube of speed, as that of a propeller at one advance
ratio does.

The compensation multiplies commands by 1 + c (V_ref/V_f - 1), c from 0 to 1 and V_f the measured voltage behind a first-order
low-pass, up to the command that is full throttle. ArduPilot (MOT_BAT_VOLT_MAX, 0.5 Hz) and PX4 (MC_BAT_SCALE_EN) scale their
outputs by the voltage so; Betaflight (vbat_sag_compensation, 5 Hz) takes throttle away on the full battery instead.
"""

from collections.abc import Callable
from math import sqrt as root
from typing import Any, NamedTuple

from plant.errors import InputError
from plant.laws.filters import stage_share, step_stage
from plant.primitives import maximum, minimum, sqrt
from plant.quadrotor.gyro import NoState
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors


class Battery(NamedTuple):
    """Numbers of a battery as kernels read them.

    Attributes:
        full: voltage at rest [V].
        fall: loss of voltage with the used charge [V/(A s)].
        resistance [ohm].
        power over the sum of the cubed rotor speeds [W s3].
        reference: voltage in hover on a full battery [V].
        used: charge at the start [A s].
        compensation [1], and share [1] of a new voltage that its low-pass takes over in a period.
    """

    full: float
    fall: float
    resistance: float
    power: float
    reference: float
    used: float
    compensation: float
    share: float


class Charge(NamedTuple):
    """used: charge taken from the battery [A s]; seen: voltage behind the low-pass of the compensation [V]."""

    used: float
    seen: float


class Supply(NamedTuple):
    """A supply of the rotors as model functions.

    Memory: what it keeps. start(speed, nominal) -> Memory. feed(memory, asked, speed, nominal, h) -> (speeds [rad/s] that rotors
    turn towards, Memory); asked: speeds of a full battery [rad/s]; speed: present ones [rad/s].
    """

    Memory: Any
    start: Callable[..., Any]
    feed: Callable[..., Any]


def has_battery(vehicle: Vehicle) -> bool:
    """Return True if a vehicle's file gives a battery."""
    return vehicle.battery_full > 0.0


def battery_of(vehicle: Vehicle, compensation: float, cutoff: float, control_period: float) -> Battery:
    """Return the numbers of a vehicle's battery; all 0 where it has none.

    compensation [1], cutoff [Hz]: of the controller, at a control period [s]. InputError where it cannot carry the hover.
    """
    share = stage_share(cutoff, control_period)
    if not has_battery(vehicle):
        return Battery(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, compensation, share)
    full, resistance = vehicle.battery_full, vehicle.battery_resistance
    room = full * full - 4.0 * resistance * vehicle.hover_power
    if room <= 0.0:
        raise InputError(
            f"given {resistance:g} ohm; at most {full * full / (4.0 * vehicle.hover_power):g} ohm give {vehicle.hover_power:g} W "
            f"at {full:g} V: correct one of the three",
            key="battery_resistance",
        )
    hover = root(0.25 * vehicle.mass * vehicle.gravity / vehicle.thrust_coefficient)
    return Battery(
        full,
        (full - vehicle.battery_empty) / vehicle.battery_capacity,
        resistance,
        vehicle.hover_power / (4.0 * hover**3),
        0.5 * (full + root(room)),
        vehicle.battery_used,
        compensation,
        share,
    )


def power_of(speed: Rotors, battery: Battery) -> float:
    """Electrical power [W] of rotors at speeds [rad/s]."""
    a, b, c, d = speed.r1, speed.r2, speed.r3, speed.r4
    return battery.power * (a * a * a + b * b * b + c * c * c + d * d * d)


def voltage_of(used: float, power: float, battery: Battery) -> float:
    """Voltage [V] under a load [W] with a charge used [A s]; half of that at rest where the load is beyond what it can give."""
    rest = battery.full - battery.fall * used
    return 0.5 * (rest + sqrt(maximum(rest * rest - 4.0 * battery.resistance * power, 0.0)))


def times(speed: Rotors, factor: float) -> Rotors:
    """Speeds times a factor."""
    return Rotors(factor * speed.r1, factor * speed.r2, factor * speed.r3, factor * speed.r4)


def up_to(speed: Rotors, most: float) -> Rotors:
    """Speeds [rad/s], none above the most."""
    return Rotors(minimum(speed.r1, most), minimum(speed.r2, most), minimum(speed.r3, most), minimum(speed.r4, most))


def fed(speed_command: Rotors, voltage: float, seen: float, nominal: Any) -> Rotors:
    """Speeds [rad/s] that rotors turn towards at a voltage [V], where the compensation sees another."""
    battery = nominal.battery
    wanted = times(speed_command, 1.0 + battery.compensation * (battery.reference / seen - 1.0))
    return times(up_to(wanted, nominal.vehicle.speed_max), voltage / battery.reference)


def mains_start(speed: Rotors, nominal: Any) -> NoState:  # noqa: ARG001
    """Keep nothing."""
    return NoState()


def mains(state: NoState, speed_command: Rotors, speed: Rotors, nominal: Any, h: float) -> tuple[Rotors, NoState]:  # noqa: ARG001
    """Feed rotors with a voltage that never changes."""
    return speed_command, state


def battery_start(speed: Rotors, nominal: Any) -> Charge:
    """Charge as the file gives it, and a compensation that has seen the voltage for long."""
    battery = nominal.battery
    return Charge(battery.used, voltage_of(battery.used, power_of(speed, battery), battery))


def discharge(state: Charge, speed_command: Rotors, speed: Rotors, nominal: Any, h: float) -> tuple[Rotors, Charge]:
    """Feed rotors for a period h [s] and take the charge out of the battery."""
    battery = nominal.battery
    power = power_of(speed, battery)
    voltage = voltage_of(state.used, power, battery)
    seen = step_stage(state.seen, voltage, battery.share)
    return fed(speed_command, voltage, seen, nominal), Charge(state.used + h * power / voltage, seen)


def hold_charge(state: Charge, speed_command: Rotors, speed: Rotors, nominal: Any, h: float) -> tuple[Rotors, Charge]:  # noqa: ARG001
    """Feed rotors from a battery that stays as full as it is."""
    battery = nominal.battery
    voltage = voltage_of(state.used, power_of(speed, battery), battery)
    seen = step_stage(state.seen, voltage, battery.share)
    return fed(speed_command, voltage, seen, nominal), Charge(state.used, seen)


MAINS = Supply(NoState, mains_start, mains)
DRAINING = Supply(Charge, battery_start, discharge)
HELD = Supply(Charge, battery_start, hold_charge)
