"""A study of a fitted plant: its numbers, a joint spread with their covariance, the noise found, and loops to begin with."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plant.errors import check_name
from plant.texts import PlainTable
from tuner.extensions.plant_fit.channels import LAWS, Loop, bandwidths, channel_tables, round_to
from tuner.extensions.plant_fit.intervals import FittedPlant
from tuner.extensions.plant_fit.noise import NoiseParts
from tuner.extensions.plant_fit.realization import realized
from tuner.text.toml_text import toml_text

Array = np.ndarray
WIDTH_OF_DEVIATION = float(np.sqrt(3.0))
"""Half-width of a uniform number over its standard deviation."""
MAX_WIDTH = 0.9
"""Largest half-width of a parameter that is written."""
NEGLIGIBLE = 1e-3
"""Half-width below which a direction is left out."""
MAX_DIRECTIONS = 6
"""Most directions of a spread at whose ends margins are limited: all 64 ends are judged."""
PERIODS = 120.0
"""Control periods in the time that a plant takes at most, so that flights stay short."""
MAX_LATE = 100
"""Most control periods of a dead time."""
SPAN = 8.0
"""Duration of a flight over the time that the plant takes, and over that of a slower first loop."""


@dataclass(frozen=True)
class Signals:
    """Names, units, ranges and noise of inputs and outputs.

    Attributes:
        inputs: Names of the inputs.
        outputs: Names of the outputs.
        units: Unit by name.
        ranges: Lowest and highest value (inputs, 2) of each input, from its middle.
        moved: Range of each output (outputs,).
        noise: Noise of each output.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, str]
    ranges: Array
    moved: Array
    noise: tuple[NoiseParts, ...]


def study_text(plants: Sequence[FittedPlant], signals: Signals, law: str, title: str) -> str:
    """Return a study of fitted plants, one for each output, as TOML; law: of all channels."""
    check_name("law", law, LAWS, key="law")
    period = control_period(plants)
    plant, joint, delays = plant_table(plants, signals, period)
    loops = _loops(plants, signals)
    actuators = [
        {"name": name, "low": round_to(2.0 * low), "high": round_to(2.0 * high), **({"delay": late} if late else {})}
        for name, (low, high), late in zip(signals.inputs, signals.ranges, delays, strict=True)
    ]
    channels, gains = channel_tables(loops, law, period)
    slow = max(float(slowness(plants)), *(1.0 / each for each in bandwidths(gains)), 0.0)
    table: PlainTable = {
        "title": title,
        "description": "Written by tuner fit. Signals count from the working point of the data. Check the limits of "
        "actuators, the scenarios and the objectives before you use its gains.",
        "seed": 1,
        "plant": plant,
        "actuator": actuators,
        "channel": channels,
        "gains": gains,
        "scenario": [_scenario(kind, loops, signals, joint, period, slow) for kind in ("set point", "load")],
        "objective": [{"metric": f"iae.{loop.output}"} for loop in loops] + [{"metric": "travel"}],
        "margin": _margins(plants, period, len(joint)),
        "search": {"population": 16, "generations": 10},
    }
    return toml_text(table)


def _margins(plants: Sequence[FittedPlant], period: float, n_spread: int) -> list[PlainTable]:
    """Return limits on margins at the ends of the spread.

    A dead time is a line of whole control periods that is the same in all flights, so no spread can move it: the limit on the
    delay margin makes loops tolerate its longest value.

    Args:
        plants: Plant of each output.
        period: Control period [s].
        n_spread: Number of directions of the joint spread.
    """
    above = [
        high - round(late / period) * period
        for each in plants
        if each.solution.structure.has_dead_time
        for late, (_, high) in zip(each.solution.dead_times, each.dead_time_ends, strict=True)
        if np.isfinite(high)
    ]
    least = round_to(max(above, default=0.0) / period, 2)
    limits: list[PlainTable] = [{"quantity": "ms", "max": 2.0}]
    if least > 0.0:
        limits.append({"quantity": "delay_periods", "min": least})
    # Limits on the fitted plant alone can be violated by the true one. Ends of more directions at once are too far from both.
    return [{**each, "spread": True} for each in limits] if 0 < n_spread <= MAX_DIRECTIONS else limits


def control_period(plants: Sequence[FittedPlant]) -> float:
    """Return a control period [s]: the sampling interval, or longer where that would make flights long."""
    sampled = plants[0].chosen.problem.period
    longest = max(sampled, slowness(plants) / PERIODS / 4.0)
    late = max(float(each.solution.dead_times.max()) for each in plants)
    if late < 0.5 * longest:
        return round_to(longest)
    count = min(max(round(late / longest), 1), MAX_LATE)
    return round_to(late / count)


def slowness(plants: Sequence[FittedPlant]) -> float:
    """Return the time that the slowest plant takes [s]: the sum of its time constants and dead time."""
    times = []
    for each in plants:
        late = float(each.solution.dead_times.max())
        for denominator in each.solution.denominators:
            integrators = each.solution.structure.integrators
            slow = float(
                np.sum(1.0 / np.maximum(np.abs(np.roots(denominator[: len(denominator) - integrators])), 1e-12))
            )
            times.append(slow + late if slow + late > 0.0 else 100.0 * each.chosen.problem.period)
    return max(times)


def plant_table(
    plants: Sequence[FittedPlant], signals: Signals, period: float
) -> tuple[PlainTable, list[dict[str, float]], list[float]]:
    """Return [plant], its joint spread, and the delay of each input's actuator [s]."""
    numbers, names, covariance, delays = realized(plants, period)
    values = {name: value for name, value in names.items() if value != 0.0}
    joint = joint_spread(list(names), np.array(list(names.values())), covariance)
    table: PlainTable = dict(numbers)
    if "transfer_function" in numbers and delays[0]:
        table["dead_time"] = delays[0]
        delays = [0.0]
    table |= {"inputs": list(signals.inputs), "outputs": list(signals.outputs)}
    units = {name: unit for name, unit in signals.units.items() if unit != "1"}
    if units:
        table["units"] = dict(units)
    table["control_period"] = period
    return table, [{name: width for name, width in row.items() if name in values} for row in joint], delays


def joint_spread(names: Sequence[str], values: Array, covariance: Array) -> list[dict[str, float]]:
    """Return tables of half-widths with the covariance of the parameters."""
    used = [int(i) for i in np.flatnonzero(values)]
    relative = covariance[np.ix_(used, used)] / np.outer(values[used], values[used])
    variances, directions = np.linalg.eigh(0.5 * (relative + relative.T))
    widths = WIDTH_OF_DEVIATION * directions * np.sqrt(np.maximum(variances, 0.0))
    total = np.abs(widths).sum(axis=1).max(initial=0.0)
    widths *= min(1.0, MAX_WIDTH / max(total, 1e-300))
    rows = []
    for column in widths.T[::-1]:
        if np.abs(column).max() > NEGLIGIBLE:
            # A parameter that hardly moves in a direction is left out of it.
            share = 1e-3 * np.abs(column).max()
            rows.append(
                {
                    names[i]: round_to(float(width), 3)
                    for i, width in zip(used, column, strict=True)
                    if abs(width) > share
                }
            )
    return rows


def _loops(plants: Sequence[FittedPlant], signals: Signals) -> list[Loop]:
    """Return loops of the strongest pairs of input and output."""
    ranges = np.ptp(signals.ranges, axis=1)
    rows = [np.abs(each.solution.numerators[:, 0]) * ranges for each in plants]
    strength = np.array(rows) / np.maximum(signals.moved, 1e-300)[:, None]
    loops = {}
    for _ in range(min(strength.shape)):
        i, j = divmod(int(np.argmax(strength)), strength.shape[1])
        loops[i] = Loop(plants[i], j, signals.outputs[i], signals.inputs[j], float(signals.moved[i]))
        strength[i], strength[:, j] = -1.0, -1.0
    return [loops[i] for i in sorted(loops)]


def _scenario(
    kind: str, loops: Sequence[Loop], signals: Signals, joint: list[dict[str, float]], period: float, slow: float
) -> PlainTable:
    duration = period * max(round(SPAN * slow / period), 50)
    start = period * max(round(0.02 * duration / period), 1)
    disturbance: PlainTable = {}
    for name, noise in zip(signals.outputs, signals.noise, strict=True):
        if noise.coloured > 0.0:
            disturbance[f"{name}_shift"] = {
                "kind": "coloured",
                "rms": round_to(noise.coloured, 3),
                "correlation_time": round_to(noise.correlation_time, 3),
            }
    if kind == "load":
        for loop in loops:
            low, high = signals.ranges[signals.inputs.index(loop.input)]
            disturbance[f"{loop.input}_load"] = {
                "kind": "step",
                "size": round_to(0.25 * (high - low), 2),
                "time": start,
            }
    table: PlainTable = {"name": kind, "duration": round(duration, 9), "search": 8, "held_out": 64}
    if kind == "set point":
        table["reference"] = {
            loop.output: {"kind": "step", "size": loop.step, "time": round(start, 9)} for loop in loops
        }
    if disturbance:
        table["disturbance"] = disturbance
    table["sensors"] = {
        name: {"rms": round_to(noise.white, 3)} for name, noise in zip(signals.outputs, signals.noise, strict=True)
    }
    if joint:
        table["joint_spread"] = [dict(row) for row in joint]
    return table
