"""The gains of a cascade by address: "roll.lambda", "x.kp"; and what is known of each."""

from dataclasses import dataclass

from plant.cascade import ATTITUDE_AXES, AXES, POSITION_AXES, Cascade
from plant.laws.law import GainInfo
from plant.records import paths

# Largest product of an observer's bandwidth and the control period: beyond it the margins of the sampled loop leave those of the
# continuous design, and measurement noise passes straight through.
MOST_OBSERVER = 0.3
# Names that stand for several axes in an address.
GROUPS: dict[str, tuple[str, ...]] = {
    **{axis: (axis,) for axis in AXES},
    "tilt": ("roll", "pitch"),
    "attitude": ATTITUDE_AXES,
    "horizontal": ("x", "y"),
    "position": POSITION_AXES,
}


@dataclass(frozen=True)
class GainAddress:
    """One gain of one axis: its address, column in a gains row, axis, loop ("position" or "attitude") and description."""

    address: str
    column: int
    axis: str
    loop: str
    info: GainInfo

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return self.info.unit_in(self.loop)

    @property
    def default(self) -> float:
        """Default value."""
        return self.info.span(self.loop).default


def gain_addresses(cascade: Cascade) -> tuple[GainAddress, ...]:
    """Return all gains of a cascade in the column order of a gains row."""
    found = []
    for column, path in enumerate(paths(cascade.Gains)):
        axis, name = path.split(".")
        loop = "position" if axis in POSITION_AXES else "attitude"
        law = cascade.position if loop == "position" else cascade.attitude
        info = next(gain for gain in law.gains if gain.name == name)
        found.append(GainAddress(f"{axis}.{name.rstrip('_')}", column, axis, loop, info))
    return tuple(found)


def default_row(cascade: Cascade) -> list[float]:
    """Return the default gains of a cascade as a gains row."""
    return [gain.default for gain in gain_addresses(cascade)]
