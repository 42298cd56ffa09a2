"""Sentences on a vehicle's rotors, gyro, frame, battery and notches."""

from math import pi

from objectives.system import System
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.battery import Battery, has_battery, voltage_of
from plant.quadrotor.notches import RpmNotches, weight_of
from plant.quadrotor.vehicle import Vehicle
from tuner.text.sentences import counted, listing


def fitted_texts(system: System) -> list[str]:
    """Return a sentence on each unusual number of the vehicle's file."""
    vehicle, h = system.vehicle, system.timing.control_period
    sentences = [
        *_dead_time(vehicle, system.fitted.delay_steps, h),
        *_curve(vehicle),
        *_lines(vehicle, h),
        *_low_pass(vehicle, h),
        *_mode(vehicle),
    ]
    sentences += _notches(vehicle, system.fitted.harmonics, system.nominal.notches)
    return [*sentences, *_battery(vehicle, system.nominal.battery)]


def _dead_time(vehicle: Vehicle, late: int, h: float) -> list[str]:
    if not vehicle.dead_time:
        return []
    flown = f"{counted(late, 'control period')} of {1e3 * h:.3g} ms"
    return [f"Dead time of the rotors: {1e3 * vehicle.dead_time:.3g} ms, flown as {flown}."]


def _curve(vehicle: Vehicle) -> list[str]:
    if not vehicle.thrust_linear:
        return []
    return [
        f"{vehicle.thrust_linear:.3g} of the full thrust is linear in the motor command; hover takes "
        f"{actuation(vehicle).hover_command:.3g} of full command. The controller inverts that curve."
    ]


def _lines(vehicle: Vehicle, h: float) -> list[str]:
    levels = (vehicle.vibration_1, vehicle.vibration_2, vehicle.vibration_3)
    speed = hover_speed(vehicle) / (2.0 * pi)
    tones = [_line(n * speed, level, 1.0 / h) for n, level in enumerate(levels, 1) if level]
    return [f"The gyro signal has a line of each rotor, at hover speed with {listing(tones)}."] if tones else []


def _line(frequency: float, level: float, rate: float) -> str:
    """One line in words; rate: at which the gyro is sampled [Hz]."""
    beyond = frequency % rate
    seen = min(beyond, rate - beyond)
    folded = f" (sampled at {rate:.4g} Hz it is heard at {seen:.3g} Hz)" if frequency > 0.5 * rate else ""
    return f"{level:.3g} rad/s at {frequency:.3g} Hz{folded}"


def _low_pass(vehicle: Vehicle, h: float) -> list[str]:
    if not vehicle.gyro_cutoff:
        return []
    beyond = "; the control rate is too low for it to delay the rate" if vehicle.gyro_cutoff * h >= 0.5 else ""
    return [f"The gyro has a low-pass of its own at {vehicle.gyro_cutoff:.3g} Hz{beyond}."]


def _mode(vehicle: Vehicle) -> list[str]:
    if not vehicle.mode_gain:
        return []
    return [
        f"The frame has a mode at {vehicle.mode_frequency:.3g} Hz, damping {vehicle.mode_damping:.3g}, gain "
        f"{vehicle.mode_gain:.3g}, in the gyro signal; flights and margins have it."
    ]


def _notches(vehicle: Vehicle, harmonics: int, notches: RpmNotches) -> list[str]:
    if not harmonics:
        return []
    speed = hover_speed(vehicle) / (2.0 * pi)
    frequencies = [f"{n * speed:.3g} Hz ({weight_of(n * speed, notches.least):.0%})" for n in range(1, harmonics + 1)]
    return [f"Notches follow the rotors; at hover speed they stand, with their share, at {listing(frequencies)}."]


def _battery(vehicle: Vehicle, battery: Battery) -> list[str]:
    if not has_battery(vehicle):
        return []
    voltage = voltage_of(battery.used, vehicle.hover_power, battery)
    share = (voltage / battery.reference) ** 2
    made_good = f", of which {battery.compensation:.0%} is made good" if battery.compensation else ""
    return [
        f"The battery gives {voltage:.3g} V in hover when a flight begins, {battery.reference:.3g} V when it is full: "
        f"{share:.0%} of a command's thrust{made_good}."
    ]
