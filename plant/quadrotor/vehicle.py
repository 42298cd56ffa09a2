"""The numbers of one quadrotor, as the model's kernels read them. Files and their checks: `plant.quadrotor.airframes`."""

from typing import NamedTuple

from plant.errors import InputError
from plant.vectors import Rotors, Vec3

# Each control period of dead time is four numbers of the state.
MAX_LATE_PERIODS = 64
# Longest dead time that is drawn, in standard deviations above the file's: 1 of 740 vehicles is beyond.
FARTHEST = 3.0


class Vehicle(NamedTuple):
    """Physical parameters of one airframe.

    Attributes:
        mass [kg].
        inertia about the body axes [kg m2].
        rotor_x, rotor_y: rotor positions in body FLU [m].
        spin: +1 where the reaction torque on the body is about +z, else -1.
        thrust_coefficient k_f [N s2]: T = k_f w2.
        torque_ratio k_m / k_f [m].
        rotor_inertia of one rotor about its axis [kg m2].
        lag_up, lag_down: first-order time constants of rotor speed rising and falling [s].
        speed_min, speed_max [rad/s].
        drag_linear [N s/m], drag_quadratic [N s2/m2]: along body axes.
        drag_height: centre of pressure above the centre of mass [m].
        rate_damping [N m s].
        gravity [m/s2].
        dead_time from a command to the first change of rotor speed [s], see `late_periods`.
        dead_time_deviation: standard deviation of the dead time between the vehicles that are drawn [s].
        thrust_linear: share of the thrust at full command that is linear in the command [1], see `thrust_curve.py`.

    Of the gyro (`gyro.py`), 0 for none:
        vibration_1 to vibration_3: lines at 1, 2 and 3 times the speed of a rotor, of each at hover speed [rad/s].
        gyro_cutoff of its own low-pass [Hz].
        mode_frequency [Hz], mode_damping [1], mode_gain [1]: of the frame's mode.

    Of the battery (`battery.py`), 0 for one whose voltage never changes:
        battery_full, battery_empty: voltages at rest [V].
        battery_resistance [Ohm].
        battery_capacity, battery_used: the latter is gone when a flight begins [A s].
        hover_power, electrical, in hover [W].
    """

    mass: float
    inertia: Vec3
    rotor_x: Rotors
    rotor_y: Rotors
    spin: Rotors
    thrust_coefficient: float
    torque_ratio: float
    rotor_inertia: float
    lag_up: float
    lag_down: float
    speed_min: float
    speed_max: float
    drag_linear: Vec3
    drag_quadratic: Vec3
    drag_height: float
    rate_damping: Vec3
    gravity: float
    dead_time: float = 0.0
    dead_time_deviation: float = 0.0
    thrust_linear: float = 0.0
    vibration_1: float = 0.0
    vibration_2: float = 0.0
    vibration_3: float = 0.0
    gyro_cutoff: float = 0.0
    mode_frequency: float = 0.0
    mode_damping: float = 0.0
    mode_gain: float = 0.0
    battery_full: float = 0.0
    battery_empty: float = 0.0
    battery_resistance: float = 0.0
    battery_capacity: float = 0.0
    battery_used: float = 0.0
    hover_power: float = 0.0


def late_periods(vehicle: Vehicle, control_period: float) -> int:
    """Return the control periods by which rotors feel a command late: the dead time, rounded.

    InputError where these are more than `MAX_LATE_PERIODS`.
    """
    periods = round(vehicle.dead_time / control_period)
    if periods > MAX_LATE_PERIODS:
        raise InputError(
            f"given {vehicle.dead_time:g} s, {periods} control periods of {control_period:g} s; at most {MAX_LATE_PERIODS} are "
            "kept: take a longer period or correct the airframe",
            key="dead_time",
        )
    return periods


def most_late_periods(vehicle: Vehicle, control_period: float) -> int:
    """Return the control periods of the longest dead time that is drawn.

    At most `MAX_LATE_PERIODS`; 0 where none is drawn.
    """
    if vehicle.dead_time_deviation == 0.0:
        return 0
    longest = vehicle.dead_time + FARTHEST * vehicle.dead_time_deviation
    return min(round(longest / control_period), MAX_LATE_PERIODS)
