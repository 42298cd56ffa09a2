"""Autopilots whose own loops are a law of ours: every gain is a parameter, to the letter, and a file comes back as it went.

The law's `authority` is what a unit of the autopilot's output makes of the vehicle. If the autopilot has the same thrust curve,
gains are its parameters; otherwise those that count in its unit of output are scaled by the quotient.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from plant.errors import InputError
from plant.law_registry import law
from plant.quadrotor.cascade import ATTITUDE_AXES, Cascade
from plant.quadrotor.gains import gain_addresses
from tuner.extensions.autopilots.parameters import Values
from tuner.gains import Controller

# Quotients of units this close to 1 are rounding.
SAME = 1e-9
AUTHORITY = "authority"
LIKE = {"y": "x"}
"""Axes that have the parameters of another one."""


@dataclass(frozen=True)
class NativeLaw:
    """A law that is a native loop of the autopilot.

    Attributes:
        law: Name of the law.
        names: Parameter of each gain by axis, several axes may share one.
        scaled: Gains that count in the unit of output.
    """

    law: str
    names: Mapping[str, Mapping[str, str]]
    scaled: frozenset[str]

    @property
    def parameters(self) -> frozenset[str]:
        """Every parameter that its gains are."""
        return frozenset(name for names in self.names.values() for name in names.values())

    @property
    def addresses(self) -> dict[str, str]:
        """Name of a parameter of one axis -> address of its gain."""
        by_name: dict[str, list[str]] = {}
        for axis, names in self.names.items():
            for gain, name in names.items():
                by_name.setdefault(name, []).append(f"{axis}.{gain}")
        return {name: gains[0] for name, gains in by_name.items() if len(gains) == 1}

    def flies_attitude(self, controller: Controller) -> bool:
        """Return true where a controller's attitude loops are this law."""
        return controller.cascade.attitude.name == self.law

    def factor(self, gain: str, quotient: float) -> float:
        """Return the parameter over the gain; quotient: of the gains' authority and the autopilot's unit."""
        return quotient if gain in self.scaled else 1.0

    def to_parameters(self, controller: Controller, units: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters of a controller; units: acceleration per unit of output, by axis.

        Raises InputError naming the gain where axes that share a parameter differ.
        """
        values: dict[str, tuple[float, str]] = {}
        for axis, gains in native_gains(controller, self.law).items():
            names = self.names.get(LIKE.get(axis, axis), {})
            quotient = _near_one(gains[AUTHORITY] / units[LIKE.get(axis, axis)])
            for gain, name in names.items():
                value, address = self.factor(gain, quotient) * gains[gain], f"{axis}.{gain}"
                before, first = values.setdefault(name, (value, address))
                if abs(before - value) > SAME * max(abs(before), abs(value)):
                    raise InputError(
                        f"given {gains[gain]:g}, and {first} makes another {name}: axes that share a parameter are tuned "
                        "together, as one group in the study's [gains]",
                        key=address,
                    )
        return {name: value for name, (value, _) in values.items()}

    def to_gains(self, values: Values, units: Mapping[str, float], controller: Controller) -> dict[str, Any]:
        """Return the gains by axis from parameters; others stay as in the controller."""
        kind, by_axis = law(self.law).Gains, dict[str, Any]()
        for axis, gains in native_gains(controller, self.law).items():
            quotient = _near_one(gains[AUTHORITY] / units[LIKE.get(axis, axis)])
            read = {
                gain: values[name] / self.factor(gain, quotient)
                for gain, name in self.names.get(LIKE.get(axis, axis), {}).items()
            }
            by_axis[axis] = kind(**{**gains, **read})
        return by_axis


def native_gains(controller: Controller, name: str) -> dict[str, dict[str, float]]:
    """Return the gains of a law's axes, by axis and gain."""
    laws = (controller.cascade.position.name, controller.cascade.attitude.name)
    by_axis: dict[str, dict[str, float]] = {}
    for gain in gain_addresses(controller.cascade):
        if laws[gain.axis in ATTITUDE_AXES] == name:
            by_axis.setdefault(gain.axis, {})[gain.info.name] = controller.gains[gain.column]
    return by_axis


def with_authorities(controller: Controller, units: Mapping[str, float]) -> Controller:
    """Return the controller with native loops' authorities; units: acceleration per unit of output, by axis."""
    row = list(controller.gains)
    for gain in gain_addresses(controller.cascade):
        if gain.info.name == AUTHORITY:
            row[gain.column] = units[LIKE.get(gain.axis, gain.axis)]
    return replace(controller, gains=tuple(row))


def flown(native: tuple[NativeLaw, ...], cascade: Cascade) -> tuple[NativeLaw, ...]:
    """Return an autopilot's native laws that a cascade flies in their loops."""
    position, attitude = cascade.position.name, cascade.attitude.name
    return tuple(entry for entry in native if entry.law == (attitude if "roll" in entry.names else position))


def _near_one(quotient: float) -> float:
    return 1.0 if abs(quotient - 1.0) <= SAME else quotient
