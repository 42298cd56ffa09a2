"""What was identified as an airframe file: its numbers, each with its source, and their [uncertainty]."""

from collections.abc import Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes.geometry import SPINS
from plant.quadrotor.airframes.schema import OPTIONAL, Sourced
from plant.quadrotor.airframes.uncertainty import CENTRE, NAMES, Uncertainty
from tuner.analysis.airframe_text import airframe_text, rounded, uncertainty_from
from tuner.analysis.identification.identify import Identified
from tuner.analysis.identification.parameters import NODES, PhysicalParameters
from tuner.documents.identification import LogRow

Array = NDArray[np.float64]
INFLOW = "estimated: the drag of a climb at the places of the rotors, or the airframe's own where larger; no log is asked for it"


def uncertainty_of(identified: Identified) -> Uncertainty:
    """Return deviations and correlation of the airframe's numbers.

    An airframe has its centre of mass in the middle, so what was found of it counts as a deviation.
    """
    space = identified.space
    numbers = space.numbers(identified.fit.estimate)
    rows = _rows(space.names, numbers, _hover_weights(identified, numbers))
    names = tuple(name for name in NAMES if name in rows)
    jacobian = np.array([rows[name] for name in names])
    covariance = jacobian @ identified.covariance @ jacobian.T
    for k, name in enumerate(names):
        if name in CENTRE:
            covariance[k, k] += numbers.center[CENTRE.index(name)] ** 2
    return uncertainty_from(names, covariance)


def _rows(names: tuple[str, ...], numbers: PhysicalParameters, weights: Array) -> dict[str, Array]:
    """Return the gradient (n,) of each airframe number, or of its logarithm."""
    unit = dict(zip(names, np.eye(len(names)), strict=True))
    x, y, _ = numbers.inertia
    rows = {name: unit[name] for name in NAMES if name in unit}
    rows["inertia.z"] = unit["inertia_share"] + (x * unit["inertia.x"] + y * unit["inertia.y"]) / (x + y)
    rows["thrust_coefficient"] = sum(
        (w * unit[f"thrust.{100 * u:.0f}"] for w, u in zip(weights.tolist(), NODES.tolist(), strict=True)),
        np.zeros(len(names)),
    )
    return rows


def _hover_weights(identified: Identified, numbers: PhysicalParameters) -> Array:
    """Return the sensitivity (3,) of hover thrust to the nodes: d log / d log."""
    c0, c1, c2 = numbers.curve
    vehicle = identified.airframe.vehicle
    weight = 0.25 * vehicle.mass * vehicle.gravity
    hover = (-c1 + sqrt(max(c1 * c1 - 4.0 * c2 * (c0 - weight), 0.0))) / (2.0 * c2)
    shares = np.array([1.0, hover, hover**2]) @ np.linalg.inv(np.vander(NODES, 3, increasing=True))
    return shares * numbers.thrust / float(shares @ numbers.thrust)


def identified_values(identified: Identified, read: Sequence[tuple[str, str]]) -> dict[str, Sourced]:
    """Return every number of the airframe with its source: the logs where identified, else as before.

    read: name and digest of every log.
    """
    numbers, vehicle = identified.space.numbers(identified.fit.estimate), identified.airframe.vehicle
    source = f"identified from {', '.join(f'{_stem(name)} (sha256 {digest[:12]})' for name, digest in read)}"
    full = float(numbers.thrust[-1])
    values = {
        "inertia.x": numbers.inertia.x,
        "inertia.y": numbers.inertia.y,
        "inertia.z": numbers.inertia.z,
        "lag_up": numbers.lag_up,
        "lag_down": numbers.lag_down,
        "torque_ratio": numbers.torque_ratio,
        "rotor_inertia": numbers.rotor * vehicle.rotor_inertia,
        "drag_linear.z": numbers.climb_drag,
        "rate_damping.x": numbers.rate_damping,
        "rate_damping.y": numbers.rate_damping,
        "dead_time": max(numbers.dead_time, 0.0),
        "speed_max": sqrt(full / vehicle.thrust_coefficient),
    }
    notes = {
        "inertia.z": f"{source}: its share of x + y" + (" as before" if "inertia_share" in identified.reasons else ""),
        "speed_max": f"{source}: thrust of {full:.4g} N at full command, at the thrust_coefficient given",
        **dict.fromkeys(("rate_damping.x", "rate_damping.y"), INFLOW),
        "dead_time": f"{source}: from a logged command to the rotor; controller.delay ends at the logged command. "
        f"The delay of the gyro, {1e3 * numbers.gyro_delay:.2g} ms, is left to the filters of the study, or gyro_cutoff here",
    }
    sources = identified.airframe.sources
    units = {key: field.unit for key, field in OPTIONAL.items()} | {key: entry.unit for key, entry in sources.items()}
    return sources | {
        key: Sourced(rounded(value), units[key], notes.get(key, source))
        for key, value in values.items()
        if key not in identified.reasons
    }


def identified_text(identified: Identified, title: str, before: Sequence[LogRow] = ()) -> str:
    """Return the text of an airframe file; before: earlier logs."""
    airframe = identified.airframe
    spin = next(name for name, signs in SPINS.items() if signs == airframe.vehicle.spin)
    read = [(row.file, row.sha256) for row in before] + [(log.name, log.digest) for log in identified.logs]
    logs = ", ".join(f"{_stem(name)} (sha256 {digest})" for name, digest in read)
    source = f"identified from {logs}"
    return airframe_text(
        title, airframe.frame, spin, identified_values(identified, read), uncertainty_of(identified), source
    )


def _stem(name: str) -> str:
    return name.replace("\\", "/").rsplit("/", 1)[-1][:60]
