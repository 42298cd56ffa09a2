"""Rules of a firmware's own tools on a change of gains.

Betaflight App: src/js/blackbox/spectral_analysis.js after betaflight-configurator #5259 and #5406. The peak sensitivity of a
recommendation is at most 2, a D-term low-pass is never raised, and no gain changes by more than a factor of 2 at once.
ArduPilot: AC_AutoTune_Heli.cpp leaves 6 dB where the open loop has a phase of -161 deg; there it is that of the rate P alone,
here that of the loop as it flies. PX4: its guide to tuning rate controllers advises steps of 20 to 30 %.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf

import numpy as np

from objectives.margins.quantities import QUANTITIES
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.analysis.margins.curves import curves_of
from tuner.analysis.margins.readings import Subject
from tuner.documents.assessment import RuleRow

APP = "Betaflight App, betaflight-configurator"
HELI = "ArduPilot, AC_AutoTune_Heli.cpp"
PX4_GUIDE = "PX4 guide, Multicopter PID Tuning"
MAX_MS, MAX_STEP, PX4_STEP, MARGIN, PHASE = 2.0, 2.0, 1.3, 6.0, -161.0
D_FILTERS, STEPPED = ("d_lpf1", "d_lpf2"), ("p", "i", "d")
GROWTH = 1.05
"""Factor by which a figure must grow before it counts as changed."""


@dataclass(frozen=True)
class AssessedLoops:
    """Loops with their gains by address."""

    subject: Subject
    gains: Mapping[str, float]

    def ms(self, axis: str) -> float:
        """Return the peak sensitivity of a loop, infinite where it is unstable."""
        return self.subject.value(QUANTITIES["ms"], axis)


def firmware_rules(source: str, after: AssessedLoops, before: AssessedLoops | None, noise_rises: bool) -> list[RuleRow]:
    """Return the rules of a firmware's tools on a change.

    Args:
        source: Firmware, as in `tuner list sources`.
        after: Loops of the change.
        before: Loops before it, None if unknown.
        noise_rises: Whether flights show more noise in the commands after it.
    """
    rules = {"betaflight": betaflight_rules, "ardupilot": ardupilot_rules, "px4": px4_rules}
    return [] if source not in rules else list(rules[source](after, before, noise_rises))


def betaflight_rules(after: AssessedLoops, before: AssessedLoops | None, noise_rises: bool) -> Iterator[RuleRow]:
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
    yield from _steps("change of a gain at once", APP, after, before, MAX_STEP)


def ardupilot_rules(after: AssessedLoops, before: AssessedLoops | None, _: bool) -> Iterator[RuleRow]:
    """Yield the rule of ArduPilot's autotune by frequency response."""
    for axis in ATTITUDE_AXES:
        value, earlier = (None if loops is None else margin_at_phase(loops.subject, axis) for loops in (after, before))
        has_shrunk = earlier is not None and value is not None and GROWTH * value < earlier
        note = "" if earlier is None else f"{earlier:.3g} dB before"
        rule = f"gain left at a phase of {PHASE:g} deg"
        yield _row(
            rule, HELI, axis, inf if value is None else value, MARGIN, "min", "dB", refuses=has_shrunk, note=note
        )


def px4_rules(after: AssessedLoops, before: AssessedLoops | None, _: bool) -> Iterator[RuleRow]:
    """Yield the advice of PX4's guide."""
    if before is not None:
        yield from _steps("change of a gain at once (advice)", PX4_GUIDE, after, before, PX4_STEP)


def margin_at_phase(subject: Subject, axis: str) -> float | None:
    """Return the gain margin [dB] at a phase of -161 deg.

    It is that of the open loop beyond its last crossover, the least over amplitudes; None where the phase stays above.
    """
    curves = curves_of(subject, axis)
    margins: list[float] = []
    for gain, phase in zip(curves.gain, curves.phase, strict=True):
        above = np.flatnonzero(gain > 0.0)
        start = int(above[-1]) if len(above) else 0
        behind = np.flatnonzero(phase[start:] <= PHASE)
        margins += [-float(gain[start + behind[0]])] if len(behind) else []
    return min(margins, default=None)


def _steps(rule: str, source: str, after: AssessedLoops, before: AssessedLoops, limit: float) -> Iterator[RuleRow]:
    """Yield the largest factor between gains of an axis before and after."""
    for axis in ATTITUDE_AXES:
        factors = {
            name: max(after.gains[address] / was, was / after.gains[address])
            for name in STEPPED
            if (address := f"{axis}.{name}") in after.gains
            and (was := before.gains.get(address, 0.0)) > 0.0
            and after.gains[address] > 0.0
        }
        if factors:
            name = max(factors, key=lambda key: factors[key])
            yield _row(rule, source, axis, factors[name], limit, refuses=False, note=f"largest: {axis}.{name}")


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
