"""The gains of a cascade by address: "roll.lambda", "x.kp"; and what is known of each."""

from dataclasses import dataclass

from plant.laws.law import GainInfo, Span
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, POSITION_AXES, Cascade
from plant.quadrotor.vehicle import Vehicle
from plant.records import paths

# Largest product of an observer's bandwidth and the control period: beyond it the margins of the sampled loop leave those of the
# continuous design, and measurement noise passes straight through.
MAX_BANDWIDTH_PERIODS = 0.3
# The axes behind every name of an axis or a group in an address.
GROUPS: dict[str, tuple[str, ...]] = {
    **{axis: (axis,) for axis in AXES},
    "position": POSITION_AXES,
    "horizontal": POSITION_AXES[:2],
    "attitude": ATTITUDE_AXES,
    "tilt": ATTITUDE_AXES[:2],
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
    """Return the gains of a cascade in the order of columns."""
    addresses: list[GainAddress] = []
    for column, path in enumerate(paths(cascade.Gains)):
        axis, name = path.split(".")
        loop = "position" if axis in POSITION_AXES else "attitude"
        law = cascade.position if loop == "position" else cascade.attitude
        info = next(gain for gain in law.gains if gain.name == name)
        span = law.span(info, axis, loop)
        addresses.append(GainAddress(f"{axis}.{name.rstrip('_')}", column, axis, loop, info, span))
    return tuple(addresses)


def default_row(cascade: Cascade, vehicle: Vehicle | None = None) -> list[float]:
    """Return the default gains of a cascade as a gains row; vehicle: on which those stand that are facts of an airframe."""
    facts = {} if vehicle is None else airframe_gains(cascade, vehicle)
    return [facts.get(gain.address, gain.default) for gain in gain_addresses(cascade)]


def airframe_gains(cascade: Cascade, vehicle: Vehicle) -> dict[str, float]:
    """Return the gains that are facts of a vehicle, by address."""
    derived = {law.name: law.on_airframe(vehicle) for law in (cascade.position, cascade.attitude) if law.on_airframe}
    laws = {axis: cascade.position if axis in POSITION_AXES else cascade.attitude for axis in AXES}
    return {
        gain.address: derived[laws[gain.axis].name].get(gain.info.name, {}).get(gain.axis, gain.default)
        for gain in gain_addresses(cascade)
        if gain.info.airframe and laws[gain.axis].name in derived
    }
