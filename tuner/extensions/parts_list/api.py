"""A vehicle without a flight log: an airframe with wide ranges from a parts list."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from plant.quadrotor.airframes.rules import THRUST_TO_WEIGHT
from tuner.analysis.airframe_text import airframe_text, new_airframe_file
from tuner.api.frames import Documented, frame, shown
from tuner.extensions.parts_list.document import EstimatedNumber, EstimateDocument
from tuner.extensions.parts_list.estimate import INCH, Estimate, PartsList, Propeller, estimated
from tuner.store.folder import put

if TYPE_CHECKING:
    import pandas as pd

PROPELLER = re.compile(r"(?P<diameter>\d+(\.\d+)?)x(?P<pitch>\d+(\.\d+)?)(x(?P<blades>\d))?")
"""DIAMETERxPITCH or DIAMETERxPITCHxBLADES, lengths in inches."""
RANGES = {
    "mass": (0.01, 50.0, "kg"), "wheelbase": (0.04, 3.0, "m"), "kv": (50.0, 50000.0, "rpm/V"), "cells": (1, 14, "cells"),
    "hover": (0.1, 0.85, "of full command"),
}  # fmt: skip
DIAMETERS, PITCHES, BLADES = (1.0, 40.0), (0.2, 1.5), (2, 6)
"""Diameters [inch], pitches over the diameter, numbers of blades."""
VERDICT = (
    "These ranges are wide: gains that hold for all of them will be cautious. A flight log narrows them: tuner identify LOG "
    "--airframe {file}"
)


@dataclass(frozen=True)
class EstimatedAirframe(Documented):
    """An airframe from a parts list.

    Attributes:
        document: Output of `tuner new NAME --mass ... --json`.
        estimate: Its numbers and their uncertainty.

    """

    document: EstimateDocument
    estimate: Estimate

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each number with a range: value, 95 % interval, unit, source."""
        return frame(self.document.numbers, "name")

    def _repr_html_(self) -> str:
        return shown("Estimated airframe", [self.document.verdict], self.table)


def estimate_airframe(
    out: str | Path,
    *,
    mass: float,
    wheelbase: float,
    propeller: str,
    kv: float,
    cells: int,
    hover: float | None = None,
) -> EstimatedAirframe:
    """Estimate an airframe from a parts list and write its file.

    Its ranges are wide; studies can fly it.

    Args:
        out: Airframe file (TOML) to write; it must not be there yet.
        mass: Mass in flight, with battery [kg].
        wheelbase: Distance from a motor to the one opposite [m]; the frame is taken as a square X.
        propeller: Diameter and pitch in inches, "10x4.5"; of other than two blades their number too, "5.1x4.8x3".
        kv: Speed constant of the motors [rpm/V].
        cells: Lithium cells of the battery in series.
        hover: Motor command at hover as a share of full command, where it is known; it narrows the thrust sevenfold.

    Returns:
        Each number with its 95 % interval and where it comes from.

    Raises:
        InputError: A number is out of range, or such parts would not lift the vehicle.
        StoreError: The file cannot be written.

    Examples:
        >>> estimate = tuner.estimate_airframe("quad.toml", mass=1.4, wheelbase=0.45, propeller="10x4.5", kv=920, cells=3)
        >>> estimate.table.loc["lag_up", ["low", "high"]].round(3).tolist()
        [0.014, 0.112]

    """
    given = {"mass": mass, "wheelbase": wheelbase, "kv": kv, "cells": cells}
    for key, value in (given if hover is None else given | {"hover": hover}).items():
        _check(key, value)
    target = new_airframe_file(Path(out))
    estimate = estimated(PartsList(mass, wheelbase, propeller_of(propeller), kv, cells, hover))
    title = f"{target.stem}, estimated from a parts list"
    source = "estimated from a parts list: propeller data, momentum theory, published airframes"
    text = airframe_text(title, "x", "+--+", estimate.values, estimate.uncertainty, source)
    put(target.parent, target.name, text.encode())
    return EstimatedAirframe(_document(estimate, target, hover), estimate)


def propeller_of(text: str) -> Propeller:
    """Return the propeller of a text such as "10x4.5" or "5.1x4.8x3"; InputError where it is none."""
    read = PROPELLER.fullmatch(text.strip().lower())
    if read is None:
        raise InputError(
            f"given '{text[:40]}'; write diameter and pitch in inches, 10x4.5, and blades if there are more than two, 5.1x4.8x3",
            key="propeller",
        )
    diameter, pitch, blades = float(read["diameter"]), float(read["pitch"]), int(read["blades"] or 2)
    for value, (low, high), what in (
        (diameter, DIAMETERS, "inches of diameter"),
        (pitch / diameter, PITCHES, "of the diameter as pitch"),
        (blades, BLADES, "blades"),
    ):
        if not low <= value <= high:
            raise InputError(f"given {value:.3g} {what}; allowed: {low:g} to {high:g}", key="propeller")
    return Propeller(diameter * INCH, pitch * INCH, blades)


def _check(key: str, value: float) -> None:
    low, high, unit = RANGES[key]
    if not low <= value <= high:
        raise InputError(f"given {value:g} {unit}; allowed: {low:g} to {high:g}", key=key)


def _document(estimate: Estimate, file: Path, hover: float | None) -> EstimateDocument:
    rows = []
    for name in estimate.uncertainty.names:
        low, high = estimate.interval(name)
        value, unit, source = estimate.values[name]
        rows.append(EstimatedNumber(name=name, unit=unit, value=value, low=low, high=high, source=source))
    lowered = _lowered(estimate, hover) if estimate.is_lowered else ""
    return EstimateDocument(
        file=str(file),
        thrust_to_weight=estimate.thrust_to_weight,
        numbers=rows,
        verdict=lowered + VERDICT.format(file=file),
    )


def _lowered(estimate: Estimate, hover: float | None) -> str:
    """Return the sentence that speed_max was lowered, with its reason and remedy; hover: command, None where it is not given."""
    cause = "These parts would lift" if hover is None else f"A hover at {hover:g} of full command means"
    remedy = (
        "give the motor command at hover, if you have it: --hover 0.3"
        if hover is None
        else "check the motor command at hover"
    )
    return (
        f"{cause} {estimate.thrust_of_parts:.3g} times the weight; speed_max was lowered to "
        f"{estimate.thrust_to_weight:.3g} times, the most that an airframe may have ({THRUST_TO_WEIGHT[1]:g}): {remedy}. "
    )
