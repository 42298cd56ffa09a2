"""Meters of a user's plant: those of an axis for every channel and watched signal, and those of all commands.

The axis is judged by the functions that judge a quadrotor's (`objectives.meters`). Commands are counted in the scale of their
input, from where the flight began.
"""

from objectives.meters import AxisMeter, start_axis, update_axis
from plant.loop import MeterModel
from plant.model.functions import written
from plant.model.plan import LoopPlan
from plant.primitives import absolute, maximum
from plant.records import record_type


def meters_of(plan: LoopPlan) -> MeterModel:
    """Return the meters of a plan: an `AxisMeter` for all that is judged, then travel, effort, saturated, command_peak."""
    axes = plan.judged
    of_flight = {"travel": float, "effort": float, "saturated": float, "command_peak": float}
    Meters = record_type("PlantMeters", {**dict.fromkeys(axes, AxisMeter), **of_flight})
    names = {
        "Meters": Meters,
        "start_axis": start_axis,
        "update_axis": update_axis,
        "absolute": absolute,
        "maximum": maximum,
    }
    started = ", ".join(f"start_axis(sample.{name}, targets.{name})" for name in axes)
    start = ["def start(sample, targets):", f"    return Meters({started}, 0.0, 0.0, 0.0, 0.0)"]
    return MeterModel(Meters, written("start", start, names), written("update", _update_lines(plan), names))


def _update_lines(plan: LoopPlan) -> list[str]:
    sizes = {name: 1.0 / scale for name, scale in plan.scales.items()}
    moved = " + ".join(f"{s!r} * absolute(sample.command.{n} - sample.previous.{n})" for n, s in sizes.items())
    squares = " + ".join(f"{s * s!r} * sample.command.{n} * sample.command.{n}" for n, s in sizes.items())
    largest = "meters.command_peak"
    for name, scale in sizes.items():
        largest = f"maximum({largest}, {scale!r} * absolute(sample.command.{name}))"
    updated = [f"update_axis(meters.{n}, sample.{n}, targets.{n}, sample.time, h)" for n in plan.judged]
    return [
        "def update(meters, sample, targets, h):",
        f"    moved = {moved}",
        f"    squares = {squares}",
        f"    return Meters({', '.join(updated)}, meters.travel + moved, meters.effort + h * squares,",
        f"        meters.saturated + h * sample.saturated, {largest})",
    ]
