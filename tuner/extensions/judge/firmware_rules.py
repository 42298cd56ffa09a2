"""Rules of a firmware's own tools on a change of gains.

Betaflight App: src/js/blackbox/spectral_analysis.js after betaflight-configurator #5259 and #5406. The peak sensitivity of a
recommendation is at most 2, and a D-term low-pass is never raised. ArduPilot: AC_AutoTune_Heli.cpp leaves 6 dB where the open
loop has a phase of -161 deg; there it is that of the rate P alone, here that of the loop as it flies. It is a rule of
helicopters, and ArduPilot's own autotune of multicopters leaves 1.9 dB: it warns and refuses nothing.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf

import numpy as np

from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.analysis.margins.curves import curves_of
from tuner.analysis.margins.readings import Loops
from tuner.documents.assessment import LoopFigures, RuleRow
from tuner.documents.margins import MarginsDocument

APP = "Betaflight App, betaflight-configurator"
HELI = "ArduPilot, AC_AutoTune_Heli.cpp"
MAX_MS, MARGIN, PHASE = 2.0, 6.0, -161.0
D_FILTERS = ("d_lpf1", "d_lpf2")
FIGURES = ("gain_up", "gain_down", "phase_margin", "delay_margin", "ms")
GROWTH = 1.1
"""Factor by which a figure must grow to count: gains 2 % apart moved an Ms of 2.45 by 5 %, which no flight in PX4 shows."""


@dataclass(frozen=True)
class LoopSet:
    """Loops of one file with their margins, and its gains by address."""

    loops: Loops
    document: MarginsDocument
    gains: Mapping[str, float]

    def figures(self, channel: str) -> LoopFigures:
        """Return the margins of a loop."""
        row = next(row for row in self.document.channels if row.channel == channel)
        return LoopFigures(stable=row.stable, **{name: row.quantities[name].value for name in FIGURES})

    def ms(self, channel: str) -> float:
        """Return the peak sensitivity of a loop, infinite where it is unstable."""
        ms = self.figures(channel).ms
        return inf if ms is None else ms


def firmware_rules(source: str, after: LoopSet, before: LoopSet | None, noise_rises: bool) -> list[RuleRow]:
    """Return the rules of a firmware's tools on a change.

    Args:
        source: Firmware, as in `tuner list sources`.
        after: Loops of the change.
        before: Loops before it, None if unknown.
        noise_rises: Whether flights show more noise in the commands after it.
    """
    return list(RULES[source](after, before, noise_rises)) if source in RULES else []


def betaflight_rules(after: LoopSet, before: LoopSet | None, noise_rises: bool) -> Iterator[RuleRow]:
    """Yield the rules of the Betaflight App."""
    for axis in ATTITUDE_AXES:
        value = after.ms(axis)
        note = "" if before is None else f"{_number(before.ms(axis))} before"
        has_grown = before is not None and value > GROWTH * before.ms(axis)
        yield _row("peak sensitivity Ms", f"{APP} #5406", axis, value, MAX_MS, refuses=has_grown, note=note)
    if before is None:
        return
    # One setting holds for all axes.
    for name in D_FILTERS:
        was, now = (_cutoff(loops.gains[f"roll.{name}"]) for loops in (before, after))
        if was < inf:
            noise = ", noise of the commands rises" if noise_rises else ""
            note = f"{_hertz(was)} before, {_hertz(now)} after{noise}"
            rule = f"D-term low-pass {name[-1]} over that before"
            yield _row(rule, f"{APP} #5259", "all axes", now / was, 1.0, refuses=noise_rises, note=note)


def ardupilot_rules(after: LoopSet, before: LoopSet | None, _: bool) -> Iterator[RuleRow]:
    """Yield the rule of ArduPilot's autotune by frequency response."""
    for axis in ATTITUDE_AXES:
        value, earlier = (None if each is None else margin_at_phase(each.loops, axis) for each in (after, before))
        note = "" if earlier is None else f"{earlier:.3g} dB before"
        rule = f"gain left at a phase of {PHASE:g} deg"
        yield _row(rule, HELI, axis, inf if value is None else value, MARGIN, "min", "dB", refuses=False, note=note)


RULES = {"betaflight": betaflight_rules, "ardupilot": ardupilot_rules}
"""Rules of each firmware that has some."""


def margin_at_phase(loops: Loops, axis: str) -> float | None:
    """Return the gain margin [dB] at a phase of -161 deg.

    It is that of the open loop beyond its last crossover, the least over amplitudes; None where the phase stays above.
    """
    curves = curves_of(loops, axis)
    margins: list[float] = []
    for gain, phase in zip(curves.gain, curves.phase, strict=True):
        above = np.flatnonzero(gain > 0.0)
        start = int(above[-1]) if len(above) else 0
        behind = np.flatnonzero(phase[start:] <= PHASE)
        margins += [-float(gain[start + behind[0]])] if len(behind) else []
    return min(margins, default=None)


def _row(
    rule: str,
    source: str,
    axis: str,
    value: float,
    limit: float,
    sense: str = "max",
    unit: str = "1",
    *,
    refuses: bool,
    note: str,
) -> RuleRow:
    is_satisfied = value >= limit if sense == "min" else value <= limit
    return RuleRow(
        rule=rule,
        source=source,
        axis=axis,
        value=value if np.isfinite(value) else None,
        limit=limit,
        unit=unit,
        sense=sense,
        verdict="satisfied" if is_satisfied else "violated",
        refuses=refuses and not is_satisfied,
        note=note,
    )


def _cutoff(value: float) -> float:
    """Return a cut-off [Hz]; 0 is no filter."""
    return value if value > 0.0 else inf


def _hertz(value: float) -> str:
    return "off" if value == inf else f"{value:.4g} Hz"


def _number(value: float) -> str:
    return "unstable" if value == inf else f"{value:.3g}"
