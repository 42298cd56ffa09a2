"""Margins and the axis that rings of a Betaflight profile with ADRC."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from plant.input_files import InputFile, given_content
from tuner.api.frames import Documented, frame
from tuner.api.gains import read_gains
from tuner.extensions.betaflight.presets import WHAT
from tuner.extensions.betaflight_adrc.designing import DEFAULT_NOISE, design_front, designed_settings
from tuner.extensions.betaflight_adrc.document import AdrcDocument, ChangeRow, DesignRow, PlantRow, RingRow
from tuner.extensions.betaflight_adrc.export import command_lines_of, settings_of_gains
from tuner.extensions.betaflight_adrc.reading import Profile, changed, read_adrc
from tuner.extensions.betaflight_adrc.ringing import DEFAULT_GROWTH, changes, rings, worst_ring
from tuner.extensions.betaflight_adrc.settings import SCHEDULE, SCHEDULES
from tuner.extensions.betaflight_adrc.vehicle_plants import VehicleAxis, VehiclePlants, vehicle_plants
from tuner.store.document import taken
from tuner.store.folder import put

if TYPE_CHECKING:
    import pandas as pd

PACK_RANGE = (0.3, 3.0)
"""Voltage of a pack over the usual one."""
MIN_MARGIN = 1.0
"""Gain margin below which a loop rings."""
MIN_QUIET_MARGIN = 1.5
"""Gain margin below which a gust or a fresh pack may ring it."""
MIN_UNMEASURED_MARGIN = 2.0
"""Gain margin to aim for with plants scaled by b0: `MIN_QUIET_MARGIN` on a craft whose plant has 35 % more gain."""


@dataclass(frozen=True)
class AdrcForecast(Documented):
    """Forecast of a tune.

    Attributes:
        document: Output of `tuner adrc --json`.
        profile: Profile as read, with its changes.
        lines: Command lines of the tune, written by `out`.
    """

    document: AdrcDocument
    profile: Profile
    lines: str

    @property
    def table(self) -> "pd.DataFrame":
        """A row for each axis and condition."""
        return frame(self.document.rings, ["axis", "schedule", "throttle", "gate"])


def adrc(
    file: str | Path,
    *,
    plants: str | Path | None = None,
    log: str | Path | None = None,
    profile: int | None = None,
    build: str = "",
    gyro_rate: float = 0.0,
    growth: float = DEFAULT_GROWTH,
    gains: str | Path | None = None,
    settings: Mapping[str, float | str] | None = None,
    packs: Sequence[float] = (),
    design: float | None = None,
    max_noise: float = DEFAULT_NOISE,
    front: str | Path | None = None,
    out: str | Path | None = None,
) -> AdrcForecast:
    """Forecast which axis of a Betaflight profile with ADRC rings, and where.

    Args:
        file: Output of `diff all` or `dump all` of the vehicle.
        plants: Table (TOML) of the craft's own plants by axis, or the command lines whose b0 scales them; by default `file`.
        log: Flight log (.bbl or CSV) with setpoints, out of which the plants are identified.
        profile: Number of the PID profile; by default the selected one.
        build: Name of the build: pr-august, b10.1, b11, pr or mp2; by default recognized.
        gyro_rate: Rate of the gyro [Hz]; by default 8000.
        growth: Exponent of the acceleration gain over the collective.
        gains: File gains.json of a study with the law `betaflight_adrc`, whose settings replace those of the file.
        settings: Other values of settings, such as {"adrc_wo_yaw": 80}.
        packs: Voltages of other packs over that of the plants, such as 0.85 for an empty one.
        design: Gain margin that wc and wo of each axis are to keep at every throttle and with every pack.
        max_noise: Largest noise of a designed tune's output over that of the present tune.
        front: PNG or PDF to draw bandwidth against margin and noise in; it must not be there yet.
        out: File of command lines to write; it must not be there yet.

    Returns:
        Margins by axis, throttle and schedule of b0, the axis that rings, and the changes that help.

    Raises:
        InputError: A file or a setting cannot be used.

    Examples:
        >>> tuner.adrc("diff_all.txt", settings={"adrc_wo_yaw": 80}).document.sentence  # doctest: +SKIP
    """
    if not 0.0 <= growth <= 2.0:
        raise InputError(f"given {growth:g}; allowed 0 to 2", key="growth")
    path = Path(file)
    read = read_adrc(InputFile(path, given_content(path, f"give {WHAT}")), profile, build, gyro_rate)
    edits = {name: value if isinstance(value, str) else f"{value:g}" for name, value in (settings or {}).items()}
    if gains is not None:
        searched = read_gains(gains)
        of_law = settings_of_gains(searched.laws["attitude"], searched, read.tune)
        edits = of_law | edits
    # The plants belong to the craft, so they follow the b0 that it flies now.
    table, flight = (None if each is None else Path(each) for each in (plants, log))
    craft = vehicle_plants(read, table, flight)
    read, voltages = changed(read, edits), checked_packs(packs)
    rows: list[DesignRow] = []
    if design is not None:
        rows = design_front(read.tune, craft, read.sampling, growth, voltages, design, max_noise)
        edits = edits | designed_settings(rows, design)
        read = changed(read, edits)
    document = forecast_document(str(file), read, craft, growth, voltages, rows)
    lines = command_lines_of(read, edits, craft.origin(table, flight), document.sentence)
    if front is not None:
        draw_front(Path(front), rows, design)
    if out is not None:
        write_lines(Path(out), read, lines)
    return AdrcForecast(document, read, lines)


def checked_packs(packs: Sequence[float]) -> tuple[float, ...]:
    """Return the voltages of all packs, the usual one first; raises InputError for one out of range."""
    for pack in packs:
        if not PACK_RANGE[0] <= pack <= PACK_RANGE[1]:
            message = f"given {pack:g}; give a voltage over the usual one, from {PACK_RANGE[0]:g} to {PACK_RANGE[1]:g}"
            raise InputError(message, key="--pack")
    return tuple(dict.fromkeys((1.0, *packs)))


def draw_front(path: Path, rows: Sequence[DesignRow], design: float | None) -> None:
    """Draw the front into a new file; raises InputError without a design."""
    if design is None:
        raise InputError("needs --design, the gain margin of the tunes", key="--front")
    # The drawing library takes a second to load.
    from tuner.extensions.betaflight_adrc.figure import write_front

    write_front(path, rows, design)


def write_lines(path: Path, profile: Profile, lines: str) -> None:
    """Write command lines into a new file; raises InputError for a build that is not known."""
    if not profile.is_known:
        raise InputError("the build is not recognized, so its settings are not known; name it by --build", key="--out")
    if path.exists():
        raise taken(path)
    put(path.parent, path.name, lines.encode())


def forecast_document(
    file: str,
    profile: Profile,
    craft: VehiclePlants,
    growth: float,
    packs: Sequence[float] = (1.0,),
    design: Sequence[DesignRow] = (),
) -> AdrcDocument:
    """Return the forecast of a profile.

    Args:
        file: Name of its file.
        profile: Profile as read.
        craft: Plants of the craft.
        growth: Exponent of the acceleration gain over the collective.
        packs: Voltages of the packs, over that of the plants.
        design: Front of tunes by margin.
    """
    tune, sampling, plants = profile.tune, profile.sampling, craft.plants
    schedules = tuple(SCHEDULES) if tune.build.has(SCHEDULE) else (tune.schedule,)
    conditions = list(rings(tune, plants, sampling, growth, schedules, packs=packs))
    worst = worst_ring(conditions, tune.schedule)
    ground = worst_ring(conditions, tune.schedule, "shut")
    options = changes(tune, plants[worst.axis], sampling, worst, growth)
    return AdrcDocument(
        format="gainproof-adrc",
        version="0.1",
        file=file,
        profile=profile.number,
        build=tune.build.name,
        revision=profile.revision,
        schedule=tune.schedule,
        is_limit=craft.is_measured,
        loop_rate=1.0 / sampling.period,
        growth=growth,
        plants=[_plant_row(axis, entry) for axis, entry in craft.axes.items()],
        rings=conditions,
        worst=conditions.index(worst),
        changes=options,
        design=list(design),
        sentence=sentence(worst, ground, options, is_limit=craft.is_measured),
        notes=[*profile.notes, *craft.notes],
    )


def _plant_row(axis: str, entry: VehicleAxis) -> PlantRow:
    plant = entry.plant
    return PlantRow(
        axis=axis,
        gain=plant.gain,
        lag=plant.lag,
        dead_time=plant.dead_time,
        zero=plant.zero,
        b0=plant.b0,
        intervals={name: [low, high] for name, (low, high) in entry.intervals.items()},
        source=entry.source,
    )


def sentence(worst: RingRow, ground: RingRow, options: list[ChangeRow], *, is_limit: bool) -> str:
    """Return the answer: the axis that rings first, on the ground too, and the change that helps most."""
    parts = [
        f"{worst.axis.capitalize()} rings first, at {worst.ring or 0.0:.0f} Hz: gain margin {worst.gain_margin or inf:.2f} "
        f"at {100.0 * worst.throttle:.0f} % throttle{'' if worst.pack == 1.0 else f', pack x {worst.pack:g}'}."
    ]
    if is_limit:
        parts.append(_verdict(worst.gain_margin or inf))
    else:
        parts.append(
            "The plants are scaled by b0, 20 to 35 % off for a craft: this number compares tunes on the same plants, it is no "
            "limit. Another b0 in the file is another plant: keep the first one's by --plant FILE. Without a log aim for a "
            f"margin of {MIN_UNMEASURED_MARGIN:g}."
        )
    parts.append(
        f"On the ground: {ground.axis}, {ground.ring or 0.0:.0f} Hz, gain margin {ground.gain_margin or inf:.2f}."
    )
    if options:
        best = options[0]
        change = ", ".join(f"{name} = {value:.0f}" for name, value in best.settings.items())
        parts.append(
            f"Of single changes {change} helps most: gain margin {best.gain_margin:.2f}, stiffness at 2 Hz x "
            f"{best.stiffness:.2f}, noise x {best.noise:.2f}."
        )
    return " ".join(parts)


def _verdict(gain: float) -> str:
    if gain < MIN_MARGIN:
        return "The loop rings in flight."
    return "The margin is small." if gain < MIN_QUIET_MARGIN else "The loop is quiet."
