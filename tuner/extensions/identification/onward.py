"""The identified airframe as a file: its numbers, each with its source, and their [uncertainty]."""

from collections.abc import Sequence
from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes.geometry import SPINS
from plant.quadrotor.airframes.schema import OPTIONAL, SENSORS, Sourced
from plant.quadrotor.airframes.uncertainty import CENTRE, NAMES, Uncertainty
from tuner.analysis.airframe_text import airframe_text, rounded, uncertainty_from
from tuner.extensions.identification.document import LogRow
from tuner.extensions.identification.hover_curve import HoverCurve, hover_curve
from tuner.extensions.identification.identify import Identified
from tuner.extensions.identification.rotor_lines import RotorLine, rotor_lines
from tuner.extensions.identification.white_noise import gyro_density
from tuner.extensions.vehicle_fit.identifiability import NARROWED
from tuner.extensions.vehicle_fit.parameters import THRUSTS
from tuner.extensions.vehicle_fit.random_effects import QUANTILE

Array = NDArray[np.float64]
INFLOW = "estimated: the drag of a climb at the places of the rotors, or the airframe's own where larger; no log is asked for it"


def uncertainty_of(identified: Identified) -> Uncertainty:
    """Return deviations and correlation of the airframe's numbers.

    An airframe has its centre of mass in the middle, so what was found of it counts as a deviation.
    """
    numbers = identified.space.numbers(identified.fit.estimate)
    rows = _rows(identified)
    names = tuple(name for name in NAMES if name in rows)
    jacobian = np.array([rows[name] for name in names])
    covariance = jacobian @ identified.covariance @ jacobian.T
    for k, name in enumerate(names):
        if name in CENTRE:
            covariance[k, k] += numbers.center[CENTRE.index(name)] ** 2
    return uncertainty_from(names, covariance)


def _rows(identified: Identified) -> dict[str, Array]:
    """Return the gradient (n,) of each airframe number, or of its logarithm."""
    names = identified.space.names
    unit = dict(zip(names, np.eye(len(names)), strict=True))
    x, y, _ = identified.space.numbers(identified.fit.estimate).inertia
    rows = {name: unit[name] for name in NAMES if name in unit}
    rows["inertia.z"] = unit["inertia_share"] + (x * unit["inertia.x"] + y * unit["inertia.y"]) / (x + y)
    curve, nodes = _hover_curve(identified), np.array([unit[name] for name in THRUSTS])
    rows["thrust_coefficient"] = curve.by_thrust @ nodes
    if _is_slope_identified(identified, curve):
        rows["thrust_linear"] = curve.by_linear @ nodes
        # Full command and its speed stay as in the file, so a steeper curve has another thrust at hover.
        rows["thrust_coefficient"] -= curve.thrust_by_linear(curve.linear) * rows["thrust_linear"]
    return rows


def _hover_curve(identified: Identified) -> HoverCurve:
    vehicle = identified.airframe.vehicle
    weight = 0.25 * vehicle.mass * vehicle.gravity
    return hover_curve(identified.space.numbers(identified.fit.estimate), weight)


def _is_slope_identified(identified: Identified, curve: HoverCurve) -> bool:
    """Return True if logs halve the interval of `thrust_linear`; the weight alone does not."""
    space = identified.space
    if space.weighed is not None:
        return False
    nodes = [space.names.index(name) for name in THRUSTS]
    variance = curve.by_linear @ identified.covariance[np.ix_(nodes, nodes)] @ curve.by_linear
    before = float(np.linalg.norm(curve.by_linear * space.initial_std[nodes]))
    return curve.linear != 0.0 and sqrt(float(variance)) <= NARROWED * before


def identified_values(identified: Identified, read: Sequence[tuple[str, str]]) -> dict[str, Sourced]:
    """Return every number of the airframe with its source: the logs where identified, else as before.

    read: name and digest of every log.
    """
    numbers, vehicle = identified.space.numbers(identified.fit.estimate), identified.airframe.vehicle
    source = f"identified from {', '.join(f'{_stem(name)} (sha256 {digest[:12]})' for name, digest in read)}"
    curve = _hover_curve(identified)
    has_slope = _is_slope_identified(identified, curve)
    linear = curve.linear if has_slope else vehicle.thrust_linear
    full = curve.thrust / curve.share(linear)
    lines = rotor_lines(identified)
    has_thrust = not set(THRUSTS) <= set(identified.reasons)
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
        **({"speed_max": sqrt(full / vehicle.thrust_coefficient)} if has_thrust else {}),
        **({"thrust_linear": linear} if has_slope else {}),
        **{f"vibration_{line.harmonic}": line.amplitude for line in lines},
        "gyro_noise": gyro_density(identified.logs),
    }
    notes = {
        "inertia.z": f"{source}: its share of x + y" + (" as before" if "inertia_share" in identified.reasons else ""),
        "speed_max": f"{source}: thrust of {full:.4g} N at full command, at the thrust_coefficient given, and hover at "
        f"{curve.command:.4g} of full command",
        "thrust_linear": f"{source}: slope of the thrust at hover",
        **{f"vibration_{line.harmonic}": f"{source}: {_line_words(line)}" for line in lines},
        **dict.fromkeys(("rate_damping.x", "rate_damping.y"), INFLOW),
        "gyro_noise": f"{source}: white noise as logged; a study flies it unless [scenario.sensors] gives a rate",
        "dead_time": f"{source}: from a logged command to the rotor; controller.delay ends at the logged command. "
        f"The delay of the gyro, {1e3 * numbers.gyro_delay:.2g} ms, is left to the filters of the study, or gyro_cutoff here",
    }
    sources = identified.airframe.sources
    units = {key: field.unit for key, field in (OPTIONAL | SENSORS).items()} | {
        key: entry.unit for key, entry in sources.items()
    }
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


def _line_words(line: RotorLine) -> str:
    factor = exp(QUANTILE * line.deviation)
    return (
        f"{line.logged:.2g} rad/s at {line.frequency:.3g} Hz as logged; before the gyro's low-pass, which is known by its delay, "
        f"{line.amplitude / factor:.2g} to {line.amplitude * factor:.2g} (95 %)"
    )


def _stem(name: str) -> str:
    return name.replace("\\", "/").rsplit("/", 1)[-1][:60]
