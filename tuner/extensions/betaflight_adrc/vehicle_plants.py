"""The plants of a craft: from its log, from a table, or scaled by the b0 of its profile."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from plant.errors import InputError
from plant.input_files import InputFile, given_content
from tuner.extensions.betaflight_adrc.identifying import IdentifiedAxis, identify_axes
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, margins, scaled
from tuner.extensions.betaflight_adrc.reading import Profile, read_adrc, read_plants
from tuner.extensions.betaflight_adrc.ringing import plants_of_b0

GIVEN, BY_LOG, BY_B0 = "given", "log", "b0"


@dataclass(frozen=True)
class VehicleAxis:
    """The plant of an axis, and its origin.

    Attributes:
        plant: Plant at hover.
        source: "given", "log" or "b0".
        intervals: 95 % intervals of its numbers out of a log, by name.
    """

    plant: AxisPlant
    source: str
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])


@dataclass(frozen=True)
class VehiclePlants:
    """The plants of a craft.

    Attributes:
        axes: Plant of each axis.
        notes: Sentences on axes that a log does not identify.
    """

    axes: dict[str, VehicleAxis]
    notes: tuple[str, ...] = ()

    @property
    def plants(self) -> dict[str, AxisPlant]:
        """Plant of each axis at hover."""
        return {axis: entry.plant for axis, entry in self.axes.items()}

    @property
    def is_measured(self) -> bool:
        """Whether every plant is the craft's own."""
        return all(entry.source != BY_B0 for entry in self.axes.values())

    def origin(self, plants: Path | None, log: Path | None) -> str:
        """Return the text that names the origin of the plants."""
        if log is not None:
            ends = [(axis, entry.intervals["b0"]) for axis, entry in self.axes.items() if entry.intervals]
            shown = ", ".join(f"b0 of {axis} {low:.0f} to {high:.0f}" for axis, (low, high) in ends)
            return f"log {log.name}: {shown or 'no axis identified'}"
        return "plants scaled by b0" if plants is None else f"plants of {plants.name}"


def vehicle_plants(profile: Profile, plants: Path | None, log: Path | None) -> VehiclePlants:
    """Return the plants of a craft; axes that neither file shows are scaled by b0.

    Args:
        profile: Profile as the craft flies it.
        plants: Table of plants, or the command lines whose b0 scales them.
        log: Flight log.
    """
    if plants is not None and log is not None:
        raise InputError("cannot be combined with --plant", key="--log")
    axes = _by_b0(profile)
    if plants is not None and plants.suffix == ".toml":
        given = read_plants(plants, profile.sampling)
        return VehiclePlants(axes | {axis: VehicleAxis(plant, GIVEN) for axis, plant in given.items()})
    if plants is not None:
        file = InputFile(plants, given_content(plants, "give a table of plants (.toml), or a file of command lines"))
        build, gyro_rate = profile.tune.build.name, 1.0 / profile.sampling.gyro_period
        return VehiclePlants(_by_b0(read_adrc(file, profile.number, build, gyro_rate)))
    if log is None:
        return VehiclePlants(axes)
    identified = identify_axes(log, profile.sampling)
    refused = {axis: text for axis, entry in identified.items() if (text := _refusal(profile, axis, entry))}
    shown = {axis: _of_log(profile, entry) for axis, entry in identified.items() if axis not in refused}
    return VehiclePlants(axes | shown, tuple(_with_remedy(refused)))


def _by_b0(profile: Profile) -> dict[str, VehicleAxis]:
    """Return the plants scaled by the b0 of a profile."""
    return {axis: VehicleAxis(plant, BY_B0) for axis, plant in profile.plants(plants_of_b0(profile.tune)).items()}


def _of_log(profile: Profile, entry: IdentifiedAxis) -> VehicleAxis:
    """Return a plant for outputs of the PID sum: motors idle above 0, and thrust_linear multiplies."""
    factor = profile.linear * (1.0 - profile.idle)
    intervals = {
        name: (factor * low, factor * high) if name in ("gain", "b0") else (low, high)
        for name, (low, high) in entry.intervals.items()
    }
    return VehicleAxis(scaled(entry.plant, factor), BY_LOG, intervals)


def _refusal(profile: Profile, axis: str, entry: IdentifiedAxis) -> str:
    """Return the sentence on an axis without a plant, or ""."""
    if entry.reason:
        return entry.reason
    plant = _of_log(profile, entry).plant
    margin = margins(profile.tune, axis, plant, profile.sampling)
    # With little gain the crossover of yaw lies at a few hertz, which sticks reach; its margin is read far above.
    needed = max(0.5 * margin.ring, margin.crossover)
    if entry.excited < needed:
        return f"{axis}: the log moves the output up to {entry.excited:.0f} Hz, the loop needs {needed:.0f} Hz; fly a chirp."
    return ""


def _with_remedy(refused: dict[str, str]) -> Iterator[str]:
    for text in refused.values():
        yield f"{text} Its plant is scaled by b0."
