"""Features of a vehicle and its controller: they decide which states the closed loop has besides the body and the cascade's."""

from typing import NamedTuple

from plant.errors import InputError
from plant.quadrotor.battery import DRAINING, HELD, MAINS, Supply, has_battery
from plant.quadrotor.gyro import Gyro, gyro_of
from plant.quadrotor.notches import Notches, notches_of
from plant.quadrotor.rotor_line import RotorLine, rotor_line, rotor_line_up_to
from plant.quadrotor.thrust_curve import CURVED, PROPORTIONAL, RotorDrive
from plant.quadrotor.vehicle import Vehicle, late_periods, most_late_periods

# The bilinear transform of a mode keeps its frequency up to here, over the control rate.
MAX_RATE_SHARE = 0.4


class VehicleFeatures(NamedTuple):
    """Features of a vehicle and its controller.

    Attributes:
        delay_steps: Control periods by which rotors feel a command late.
        most_delay_steps: The same of any vehicle that is drawn, 0 where all have one dead time.
        has_vibration: True if the gyro signal has rotor lines.
        has_flexible_mode: Whether the frame has a mode.
        has_low_pass: Whether the gyro has a low-pass below half the control rate.
        harmonics: Harmonics of the rotors' speed, at each of which the controller has a notch.
        supply: Supply of the rotors.
        drive: From commanded to held rotor speeds.
    """

    delay_steps: int = 0
    most_delay_steps: int = 0
    has_vibration: bool = False
    has_flexible_mode: bool = False
    has_low_pass: bool = False
    harmonics: int = 0
    supply: Supply = MAINS
    drive: RotorDrive = PROPORTIONAL

    @property
    def gyro(self) -> Gyro:
        """The gyro."""
        return gyro_of(
            has_vibration=self.has_vibration, has_flexible_mode=self.has_flexible_mode, has_low_pass=self.has_low_pass
        )

    @property
    def line(self) -> RotorLine:
        """The delay line of the rotors."""
        return rotor_line_up_to(self.most_delay_steps) if self.most_delay_steps else rotor_line(self.delay_steps)

    @property
    def notches(self) -> Notches:
        """The notches that follow the rotors."""
        return notches_of(self.harmonics)

    @property
    def feedback(self) -> "VehicleFeatures":
        """The part that is feedback, of one vehicle: lines of rotors return nothing of a small signal, charge goes too slowly."""
        return self._replace(most_delay_steps=0, has_vibration=False, supply=MAINS if self.supply is MAINS else HELD)

    @property
    def name(self) -> str:
        """End of the names of kernels, "" for none of it."""
        sags = self.supply is not MAINS
        words = {
            "vibrates": self.has_vibration,
            "flexes": self.has_flexible_mode,
            "filters": self.has_low_pass,
            "sags": sags,
            "curved": self.drive is not PROPORTIONAL,
        }
        delay = f"_late{self.delay_steps}" if self.delay_steps else ""
        if self.most_delay_steps:
            delay = f"_upto{self.most_delay_steps}late"
        notches = f"_notches{self.harmonics}" if self.harmonics else ""
        return delay + "".join(f"_{word}" for word, is_present in words.items() if is_present) + notches


BARE = VehicleFeatures()
"""Features of a vehicle whose file has none of them."""


def hears_rotors(vehicle: Vehicle) -> bool:
    """Return True if a vehicle's gyro measures lines of the rotors."""
    return any((vehicle.vibration_1, vehicle.vibration_2, vehicle.vibration_3))


def vehicle_features(
    vehicle: Vehicle, control_period: float, harmonics: float = 0.0, assumed: Vehicle | None = None
) -> VehicleFeatures:
    """Return the features of a vehicle and its controller.

    Args:
        vehicle: The vehicle that flies.
        control_period: Control period [s].
        harmonics: Harmonics of the rotor notches.
        assumed: The vehicle that the controller assumes, by default the one that flies.

    Raises:
        InputError: The loop cannot be sampled so slowly.
    """
    has_flexible_mode = vehicle.mode_gain != 0.0
    if has_flexible_mode and vehicle.mode_frequency * control_period > MAX_RATE_SHARE:
        raise InputError(
            f"given {vehicle.mode_frequency:g} Hz with a control period of {control_period:g} s; at most {MAX_RATE_SHARE:g} of "
            f"the control rate, {MAX_RATE_SHARE / control_period:g} Hz, is sampled: take a shorter period, or leave mode_gain "
            "out",
            key="mode_frequency",
        )
    has_low_pass = 0.0 < vehicle.gyro_cutoff * control_period < 0.5
    supply = DRAINING if has_battery(vehicle) else MAINS
    return VehicleFeatures(
        late_periods(vehicle, control_period),
        most_late_periods(vehicle, control_period),
        hears_rotors(vehicle),
        has_flexible_mode,
        has_low_pass,
        int(harmonics),
        supply,
        CURVED if any(each.thrust_linear for each in (vehicle, assumed or vehicle)) else PROPORTIONAL,
    )
