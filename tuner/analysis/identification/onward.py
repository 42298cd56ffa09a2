"""What was identified as an airframe file: its numbers, each with its source, and their [uncertainty]."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from plant.airframes.geometry import FRAMES, SPINS
from plant.airframes.schema import Sourced, number_fields
from plant.airframes.uncertainty import CENTRE, NAMES, Uncertainty
from tuner.analysis.identification.identify import Identified
from tuner.analysis.identification.parameters import NODES, Numbers
from tuner.text.toml_text import quoted

Array = NDArray[np.float64]

DIGITS = 5
"""Significant digits of numbers and deviations in the file."""
# Correlations are rounded, which may leave a matrix with an eigenvalue below zero by less than this.
SHRUNK = 1e-4


def uncertainty_of(found: Identified) -> Uncertainty:
    """Return deviations and correlation of the airframe's numbers.

    An airframe has its centre of mass in the middle, so what was found of it counts as a deviation.
    """
    space = found.space
    numbers = space.numbers(found.fit.point)
    rows = _rows(space.names, numbers, _hover_weights(found, numbers))
    names = tuple(name for name in NAMES if name in rows)
    jacobian = np.array([rows[name] for name in names])
    covariance = jacobian @ found.fit.covariance @ jacobian.T
    for k, name in enumerate(names):
        if name in CENTRE:
            covariance[k, k] += numbers.centre[CENTRE.index(name)] ** 2
    deviations = np.sqrt(np.diag(covariance))
    correlation = (1.0 - SHRUNK) * covariance / np.outer(deviations, deviations) + SHRUNK * np.eye(len(names))
    rounded = np.round(0.5 * (correlation + correlation.T), DIGITS)
    np.fill_diagonal(rounded, 1.0)
    return Uncertainty(
        names, tuple(min(_rounded(v), 1.0) for v in deviations.tolist()), tuple(map(tuple, rounded.tolist()))
    )


def _rows(names: tuple[str, ...], numbers: Numbers, weights: Array) -> dict[str, Array]:
    """Return the derivative (n,) of each of the airframe's numbers, or of its logarithm, after the coordinates."""
    unit = dict(zip(names, np.eye(len(names)), strict=True))
    x, y, _ = numbers.inertia
    rows = {name: unit[name] for name in NAMES if name in unit}
    rows["inertia.z"] = unit["inertia_share"] + (x * unit["inertia.x"] + y * unit["inertia.y"]) / (x + y)
    rows["thrust_coefficient"] = sum(
        (w * unit[f"thrust.{100 * u:.0f}"] for w, u in zip(weights.tolist(), NODES.tolist(), strict=True)),
        np.zeros(len(names)),
    )
    return rows


def _hover_weights(found: Identified, numbers: Numbers) -> Array:
    """Return the derivative (3,) of the logarithm of the thrust at hover after those at the nodes."""
    c0, c1, c2 = numbers.curve
    vehicle = found.airframe.vehicle
    weight = 0.25 * vehicle.mass * vehicle.gravity
    hover = (-c1 + sqrt(max(c1 * c1 - 4.0 * c2 * (c0 - weight), 0.0))) / (2.0 * c2)
    shares = np.array([1.0, hover, hover**2]) @ np.linalg.inv(np.vander(NODES, 3, increasing=True))
    return shares * numbers.thrust / float(shares @ numbers.thrust)


def identified_values(found: Identified) -> dict[str, Sourced]:
    """Return every number of the airframe: what was identified with its logs as source, the rest as it was."""
    numbers, vehicle = found.space.numbers(found.fit.point), found.airframe.vehicle
    told = f"identified from {', '.join(f'{_stem(log.name)} (sha256 {log.digest[:12]})' for log in found.logs)}"
    full = float(numbers.thrust[-1])
    values = {
        "inertia.x": numbers.inertia.x,
        "inertia.y": numbers.inertia.y,
        "inertia.z": numbers.inertia.z,
        "lag_up": numbers.lag_up,
        "lag_down": numbers.lag_down,
        "torque_ratio": numbers.torque_ratio,
        "drag_linear.z": numbers.climb_drag,
        "speed_max": sqrt(full / vehicle.thrust_coefficient),
    }
    notes = {
        "inertia.z": f"{told}: its share of x + y" + (" as before" if "inertia_share" in found.reasons else ""),
        "speed_max": f"{told}: thrust of {full:.4g} N at full command, at the thrust_coefficient given",
    }
    kept = [key for key in values if key in found.reasons]
    return found.airframe.sources | {
        key: Sourced(_rounded(value), found.airframe.sources[key].unit, notes.get(key, told))
        for key, value in values.items()
        if key not in kept
    }


def airframe_text(found: Identified, title: str) -> str:
    """Return the airframe as the text of a TOML file that `plant.airframes.load` reads."""
    airframe, uncertainty = found.airframe, uncertainty_of(found)
    spin = next(name for name, signs in SPINS.items() if signs == airframe.vehicle.spin)
    lines = [f"title = {quoted(title)}", f"frame = {quoted(airframe.frame)}", f"spin = {quoted(spin)}", ""]
    values, section = identified_values(found), ""
    # Numbers of no group stand before all tables.
    for key in sorted(number_fields(FRAMES[airframe.frame].lengths), key=lambda entry: "." in entry):
        group, dot, name = key.rpartition(".")
        if group != section:
            lines += ["", f"[{group}]"]
            section = group
        lines.append(f"{name if dot else key} = {_entry(values[key])}")
    logs = ", ".join(f"{_stem(log.name)} (sha256 {log.digest})" for log in found.logs)
    lines += [
        "",
        "# Standard deviations: of centre.x and centre.y in m, of all others relative; and how they hang together.",
        "[uncertainty]",
        f"source = {quoted(f'identified from {logs}')}",
        f"names = [{', '.join(quoted(name) for name in uncertainty.names)}]",
        f"deviations = [{', '.join(f'{value:g}' for value in uncertainty.deviations)}]",
        "correlation = [",
        *[f"    [{', '.join(f'{value:g}' for value in row)}]," for row in uncertainty.correlation],
        "]",
    ]
    return "\n".join(lines) + "\n"


def _entry(number: Sourced) -> str:
    return f"{{ value = {number.value!r}, unit = {quoted(number.unit)}, source = {quoted(number.source)} }}"


def _stem(name: str) -> str:
    return name.replace("\\", "/").rsplit("/", 1)[-1][:60]


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
