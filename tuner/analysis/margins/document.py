"""Margins of one controller as JSON-able data, the schema of `tuner margins --json`.

    format "holdfast-margins", version "0.2"; airframe; laws {position, attitude}; control_period {value, unit}
    trim {yaw, velocity, wind: {value, unit}, position_held}      velocity and wind in world axes (east, north, up)
    channels [{channel, stable, growth, amplitude_dependent, quantities {NAME: reading}, disk_range {low, high, phase}}]
    multiloop {disk: reading, disk_range}                         all plant inputs (z, roll, pitch, yaw) at once
    requirements [{label, channel, quantity, value, unit, shown_unit, limit, sense, hard, kept, note}]
    passed                                                        whether every hard requirement is kept
    mismatch [{factor, criterion, low, high}]                     with --out only, see `mismatch`
    certificates [{axis, name, value, unit, verified, why, source}]   with --certificates only

Values and limits are in SI units: rad, s, rad/s, gains as factors; shown_unit: in which a limit is written and printed, where it
is another one. A reading is {value, unit, frequency, case, note}: frequency [rad/s] where it is met; case: amplitude at which it
is worst, null for loops that depend on none. An infinite value is null, and `note` says what that means; note is null
otherwise. A channel without a loop is not listed. Channels are x, y, z, roll, pitch, yaw.
"""

from math import inf, isfinite
from typing import Any

from objectives.margins.disk import disk_range
from objectives.margins.period import CHANNELS
from objectives.margins.quantities import QUANTITIES, REPORTED, MarginQuantity
from objectives.margins.results import Worst
from objectives.scales import units_of
from tuner.analysis.margins.limits import LIMITS, Limit
from tuner.analysis.margins.readings import Subject

FORMAT, VERSION = "holdfast-margins", "0.2"
UNSTABLE, WITHOUT_END = "the loop is not stable", "no bound"

Row = dict[str, Any]


def margins_document(subject: Subject, requirements: list[Row]) -> Row:
    """Return the document without mismatch and certificates."""
    controller, trim = subject.controller, subject.trim
    return {
        "format": FORMAT,
        "version": VERSION,
        "airframe": controller.airframe.name,
        "laws": {"position": controller.cascade.position.name, "attitude": controller.cascade.attitude.name},
        "control_period": {"value": controller.control_period, "unit": "s"},
        "trim": {
            "yaw": {"value": trim.yaw, "unit": "rad"},
            "velocity": {"value": list(trim.velocity), "unit": "m/s"},
            "wind": {"value": list(trim.wind), "unit": "m/s"},
            "position_held": trim.hold,
        },
        "channels": [_channel(subject, channel) for channel in subject.looped],
        "multiloop": _multiloop(subject),
        "requirements": requirements,
        "passed": all(row["kept"] for row in requirements if row["hard"]),
    }


def default_requirements(subject: Subject, limits: tuple[Limit, ...] = LIMITS) -> list[Row]:
    """Return how every loop stands to the limits: stable, each limit as a hard requirement, each target as a soft one."""
    rows = []
    for channel in subject.looped:
        stable = float(subject.margins.stable[0, CHANNELS.index(channel)])
        rows.append(
            requirement_row(
                f"stable({channel})", "stable", {"unit": "1"}, stable, 1.0, stable == 1.0, "least", channel=channel
            )
        )
        for limit in limits:
            entry = QUANTITIES[limit.quantity]
            value, label = subject.value(entry, channel), f"{entry.name}({channel})"
            rows.append(limited_row(label, entry, value, limit, True, channel))
            if limit.target is not None:
                rows.append(
                    limited_row(
                        f"{label} target", entry, value, Limit(entry.name, limit.sense, limit.target), False, channel
                    )
                )
    return rows


def limited_row(
    label: str, entry: MarginQuantity, value: float, limit: Limit, hard: bool, channel: str | None = None
) -> Row:  # fmt: skip
    """Return how a value in SI units stands to a limit in the quantity's unit of limits."""
    kept, least = limit.kept(float(entry.to_limit(value))), float(entry.from_limit(limit.limit))
    units = units_of(entry.limit_unit, entry.limited)
    return requirement_row(label, entry.name, units, value, least, kept, limit.sense, hard, channel)


def requirement_row(
    label: str, quantity: str, units: dict[str, str], value: float, limit: float, kept: bool, sense: str, hard: bool = True,
    channel: str | None = None,
) -> Row:  # fmt: skip
    """Return one requirement in SI units; channel: the column of the table that it is about, None for several loops at once."""
    return {
        "label": label,
        "channel": channel,
        "quantity": quantity,
        "value": _finite(value),
        **units,
        "limit": limit,
        "sense": sense,
        "hard": hard,
        "kept": kept,
        "note": None if isfinite(value) else WITHOUT_END,
    }


def _channel(subject: Subject, channel: str) -> Row:
    margins, i = subject.margins, CHANNELS.index(channel)
    growth = float(margins.growth[0, i])
    return {
        "channel": channel,
        "stable": bool(margins.stable[0, i]),
        "growth": {
            "value": _finite(growth), "unit": "1/s", "note": None if isfinite(growth) else "no steady flight was found",
        },
        "amplitude_dependent": subject.swept(channel),
        "quantities": {name: _reading(subject, QUANTITIES[name], channel) for name in REPORTED},
        "disk_range": _range(float(margins.disk.value[0, i]), margins.skew),
    }  # fmt: skip


def _reading(subject: Subject, quantity: MarginQuantity, channel: str) -> Row:
    i, margins = CHANNELS.index(channel), subject.margins
    worst: Worst = getattr(margins, quantity.field)
    value, case = subject.value(quantity, channel), int(worst.case[0, i])
    note = None if isfinite(value) else quantity.unlimited if margins.stable[0, i] else UNSTABLE
    label = margins.cases[case].label if case >= 0 else None
    return _entry(value, quantity.unit, float(worst.frequency[0, i]), label, note)


def _multiloop(subject: Subject) -> Row:
    worst, margins = subject.margins.multiloop, subject.margins
    value, case = float(worst.value[0]), int(worst.case[0])
    label = margins.cases[case].label if case >= 0 else None
    note = None if isfinite(value) else "no loop is closed at a plant input"
    return {
        "disk": _entry(value, "1", float(worst.frequency[0]), label, note),
        "disk_range": _range(value, margins.skew),
    }


def _entry(value: float, unit: str, frequency: float, case: str | None, note: str | None) -> Row:
    where = {"value": frequency, "unit": "rad/s"} if frequency > 0.0 else None
    return {"value": _finite(value), "unit": unit, "frequency": where, "case": case, "note": note}


def _range(alpha: float, skew: float) -> Row:
    """Return the factors of the gain and the phase that a disk guarantees; an infinite disk is as large as they come."""
    found = disk_range(min(alpha, 1e9), skew)
    low, high, phase = (float(part) for part in found)
    return {
        "low": {"value": low, "unit": "1", "note": None},
        "high": {"value": _finite(high), "unit": "1", "note": None if high < inf else WITHOUT_END},
        "phase": {"value": phase, "unit": "rad", "note": None},
    }


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
