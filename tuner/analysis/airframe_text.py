"""An airframe file as text: every number with its unit and source, and the [uncertainty] of them together."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from plant.quadrotor.airframes.geometry import FRAMES
from plant.quadrotor.airframes.schema import OPTIONAL, SENSORS, Sourced, number_fields
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.texts import check_name
from tuner.text.toml_text import quoted

DIGITS = 5
"""Significant digits of numbers, deviations and correlations in the file."""
# Correlations are rounded, which may leave a matrix with an eigenvalue below zero by less than this.
SHRUNK = 1e-4


def uncertainty_from(names: tuple[str, ...], covariance: NDArray[np.float64]) -> Uncertainty:
    """Return deviations and correlation of a covariance (n, n) in a file's units.

    The covariance is of logarithms, of places [m], of the dead time [s] and of thrust_linear [1].
    """
    deviations = np.sqrt(np.diag(covariance))
    correlation = (1.0 - SHRUNK) * covariance / np.outer(deviations, deviations) + SHRUNK * np.eye(len(names))
    symmetric = np.round(0.5 * (correlation + correlation.T), DIGITS)
    np.fill_diagonal(symmetric, 1.0)
    sizes = tuple(min(rounded(value), 1.0) for value in deviations.tolist())
    return Uncertainty(names, sizes, tuple(map(tuple, symmetric.tolist())))


def airframe_text(
    title: str, frame: str, spin: str, values: Mapping[str, Sourced], uncertainty: Uncertainty, source: str
) -> str:
    """Return the text of a TOML file that `plant.quadrotor.airframes.load` reads.

    Args:
        title: Title of the airframe.
        frame: Name in `airframes.geometry`.
        spin: Name in `airframes.geometry`.
        values: Every number by its dotted key.
        uncertainty: Deviations and their correlation.
        source: Source of the uncertainty.
    """
    lines, section = [f"title = {quoted(title)}", f"frame = {quoted(frame)}", f"spin = {quoted(spin)}", ""], ""
    # Numbers of no group stand before all tables.
    given = [*number_fields(FRAMES[frame].lengths), *(key for key in OPTIONAL | SENSORS if key in values)]
    for key in sorted(given, key=lambda entry: "." in entry):
        group, dot, name = key.rpartition(".")
        if group != section:
            lines += ["", f"[{group}]"]
            section = group
        lines.append(f"{name if dot else key} = {_entry(values[key])}")
    lines += [
        "",
        "# Standard deviations: of centre.x and centre.y in m, of dead_time in s, of thrust_linear in 1, of all others relative;",
        "# and their correlation.",
        "[uncertainty]",
        f"source = {quoted(source)}",
        f"names = [{', '.join(quoted(name) for name in uncertainty.names)}]",
        f"deviations = [{', '.join(f'{value:g}' for value in uncertainty.deviations)}]",
        "correlation = [",
        *[f"    [{', '.join(f'{value:g}' for value in row)}]," for row in uncertainty.correlation],
        "]",
    ]
    return "\n".join(lines) + "\n"


def rounded(value: float) -> float:
    """Return a number with the digits that a file holds."""
    return float(f"{value:.{DIGITS}g}")


def new_airframe_file(target: Path) -> Path:
    """Return a path that an airframe can be written to; InputError where something is there already, or its name is none."""
    if target.suffix != ".toml":
        raise InputError("an airframe file ends in .toml", file=target)
    check_name(target.stem, file=target, key="file name")
    if target.exists():
        raise InputError("is there already; give another name", file=target)
    if not target.parent.is_dir():
        raise InputError(f"there is no folder {target.parent}; make it first", file=target)
    return target


def _entry(number: Sourced) -> str:
    return f"{{ value = {number.value!r}, unit = {quoted(number.unit)}, source = {quoted(number.source)} }}"
