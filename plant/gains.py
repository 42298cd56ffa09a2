"""The gains of a cascade by address: "roll.lambda", "x.kp"; and what is known of each."""

from dataclasses import dataclass

from plant.cascade import ATTITUDE_AXES, AXES, POSITION_AXES, Cascade
from plant.laws.law import GainInfo, Span
from plant.records import paths
from plant.vehicle import Vehicle

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
    """One gain of one axis: its address, column in a gains row, axis, loop ("position" or "attitude") and description; span: its
    default and range there.
    """

    address: str
    column: int
    axis: str
    loop: str
    info: GainInfo
    span: Span

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return self.info.unit_in(self.loop)

    @property
    def default(self) -> float:
        """Default value."""
        return self.span.default


def gain_addresses(cascade: Cascade) -> tuple[GainAddress, ...]:
    """Return all gains of a cascade in the column order of a gains row."""
    found = []
    for column, path in enumerate(paths(cascade.Gains)):
        axis, name = path.split(".")
        loop = "position" if axis in POSITION_AXES else "attitude"
        law = cascade.position if loop == "position" else cascade.attitude
        info = next(gain for gain in law.gains if gain.name == name)
        span = law.span(info, axis, loop)
        found.append(GainAddress(f"{axis}.{name.rstrip('_')}", column, axis, loop, info, span))
    return tuple(found)


def default_row(cascade: Cascade, vehicle: Vehicle | None = None) -> list[float]:
    """Return the default gains of a cascade as a gains row; vehicle: on which those stand that are facts of an airframe."""
    facts = {} if vehicle is None else airframe_gains(cascade, vehicle)
    return [facts.get(gain.address, gain.default) for gain in gain_addresses(cascade)]


def airframe_gains(cascade: Cascade, vehicle: Vehicle) -> dict[str, float]:
    """Return the gains that are facts of a vehicle, by address."""
    known = {law.name: law.on_airframe(vehicle) for law in (cascade.position, cascade.attitude) if law.on_airframe}
    laws = {axis: cascade.position if axis in POSITION_AXES else cascade.attitude for axis in AXES}
    return {
        gain.address: known[laws[gain.axis].name].get(gain.info.name, {}).get(gain.axis, gain.default)
        for gain in gain_addresses(cascade)
        if gain.info.airframe and laws[gain.axis].name in known
    }
