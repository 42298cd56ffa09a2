"""Fittings of a vehicle and its controller: they decide which states the closed loop has beside the body and the cascade's."""

from typing import NamedTuple

from plant.battery import DRAINING, HELD, MAINS, Supply, has_battery
from plant.errors import InputError
from plant.gyro import Gyro, gyro_of
from plant.notches import Notches, notches_of
from plant.vehicle import Vehicle, late_periods

# The bilinear transform of a mode keeps its frequency up to here, over the control rate.
MOST_OF_RATE = 0.4


class Fittings(NamedTuple):
    """late: control periods by which rotors feel a command late. vibrates: whether the gyro hears rotors. flexes: whether the
    frame has a mode. filters: whether the gyro has a low-pass below half the control rate. harmonics: of the rotors' speed, at
    each of which the controller has a notch. supply: of the rotors.
    """

    late: int = 0
    vibrates: bool = False
    flexes: bool = False
    filters: bool = False
    harmonics: int = 0
    supply: Supply = MAINS

    @property
    def gyro(self) -> Gyro:
        """The gyro."""
        return gyro_of(vibrates=self.vibrates, flexes=self.flexes, filters=self.filters)

    @property
    def notches(self) -> Notches:
        """The notches that follow the rotors."""
        return notches_of(self.harmonics)

    @property
    def feedback(self) -> "Fittings":
        """The part that is feedback: lines of rotors return nothing of a small signal, and charge goes too slowly to."""
        return self._replace(vibrates=False, supply=MAINS if self.supply is MAINS else HELD)

    @property
    def name(self) -> str:
        """End of the names of kernels, "" for none of it."""
        sags = self.supply is not MAINS
        words = {"vibrates": self.vibrates, "flexes": self.flexes, "filters": self.filters, "sags": sags}
        late = f"_late{self.late}" if self.late else ""
        notches = f"_notches{self.harmonics}" if self.harmonics else ""
        return late + "".join(f"_{word}" for word, there in words.items() if there) + notches


BARE = Fittings()
"""Of a vehicle whose file says nothing of it."""


def hears_rotors(vehicle: Vehicle) -> bool:
    """Return whether lines of the rotors are in what a vehicle's gyro measures."""
    return any((vehicle.vibration_1, vehicle.vibration_2, vehicle.vibration_3))


def fittings(vehicle: Vehicle, h: float, harmonics: float = 0.0) -> Fittings:
    """Return the fittings of a vehicle and its controller, with notches at so many harmonics of the rotors, at a period h [s].

    InputError where its loop cannot be sampled so slowly.
    """
    flexes = vehicle.mode_gain != 0.0
    if flexes and vehicle.mode_frequency * h > MOST_OF_RATE:
        raise InputError(
            f"given {vehicle.mode_frequency:g} Hz with a control period of {h:g} s; at most {MOST_OF_RATE:g} of the control "
            f"rate, {MOST_OF_RATE / h:g} Hz, is sampled: take a shorter period, or leave mode_gain out",
            key="mode_frequency",
        )
    filters = 0.0 < vehicle.gyro_cutoff * h < 0.5
    supply = DRAINING if has_battery(vehicle) else MAINS
    return Fittings(late_periods(vehicle, h), hears_rotors(vehicle), flexes, filters, int(harmonics), supply)
