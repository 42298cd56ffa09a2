"""Loops in the frequency domain: Bode and Nyquist curves with the margins that can be read off them marked."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tuner.report.charts.chart import Array, Axis, Disc, Line, Mark, Panel, Points, Rule, Show
from tuner.report.charts.look import RULE, Look
from tuner.report.charts.shaded import ShadedLimit, limit_marks

FREQUENCY = "frequency [rad/s]"
# Part of the plane that Nyquist curves are shown in, and gains [dB] that Bode curves are.
NYQUIST = ((-3.2, 1.2), (-2.2, 2.2))
GAIN_SHOWN = (-60.0, 60.0)
# Part of the plane around -1 that is shown of any loop, air around it, and how far a margin may lie off that is shown as well.
AROUND = ((-1.6, 0.6), (-1.1, 1.1))
AIR, FARTHEST = 1.15, 2.5
REACH = "; it must reach out of the shaded part."
PHASE_SHOWN, PHASE_STEPS, MAX_STEPS = (-720.0, 180.0), (90.0, 180.0), 6


class Crossing(NamedTuple):
    """Point of a curve at which a margin is read: frequency [rad/s], gain [dB] and phase [deg] there, and the margin itself."""

    frequency: float
    gain: float
    phase: float
    margin: float

    @property
    def point(self) -> complex:
        """Place in the complex plane."""
        return complex(10.0 ** (self.gain / 20.0) * np.exp(1j * np.radians(self.phase)))


def gain_of(loop: Array) -> Array:
    """Return the gain [dB] of a transfer function (f,)."""
    return 20.0 * np.log10(np.maximum(np.abs(loop), 1e-12))


def phase_of(loop: Array) -> Array:
    """Return the phase [deg] of a transfer function (f,), unwrapped, in (-360, 0] where the gain last falls through 0 dB."""
    unwrapped = np.degrees(np.unwrap(np.angle(loop)))
    above = np.flatnonzero(np.abs(loop) > 1.0)
    return unwrapped - 360.0 * np.ceil(unwrapped[above[-1] if len(above) else 0] / 360.0)


def phase_crossing(frequency: Array, loop: Array) -> Crossing | None:
    """Return the gain crossover nearest to -180 deg, with the phase margin [deg]."""
    gain, phase = gain_of(loop), phase_of(loop)
    crossings = [_at(frequency, gain, phase, i, gain) for i in _changes(gain)]
    return min(
        (entry._replace(margin=abs((entry.phase % 360.0) - 180.0)) for entry in crossings),
        default=None,
        key=lambda entry: entry.margin,
    )


def gain_crossing(frequency: Array, loop: Array) -> Crossing | None:
    """Return the phase crossover nearest to 0 dB, with the gain margin [dB]."""
    gain, phase = gain_of(loop), phase_of(loop)
    crossings = []
    for turn in range(int(np.floor((phase.min() + 180.0) / 360.0)), int(np.ceil((phase.max() + 180.0) / 360.0)) + 1):
        away = phase + 180.0 - 360.0 * turn
        crossings += [_at(frequency, gain, phase, i, away) for i in _changes(away)]
    return min(
        (entry._replace(margin=-entry.gain) for entry in crossings), default=None, key=lambda entry: abs(entry.margin)
    )


def bode_marks(frequency: Array, loop: Array, look: Look, name: str, show: Show) -> tuple[list[Mark], list[Mark]]:
    """Return the marks of gain and of phase: the curve, and a bar as long as the margin where it is met."""
    gain, phase = gain_of(loop), phase_of(loop)
    tip = "%{y:.1f} at %{x:.3~g} rad/s"
    over: list[Mark] = [Line(name=name, look=look, x=frequency, y=gain, tip=tip, show=show)]
    under: list[Mark] = [Line(name=name, look=look, x=frequency, y=phase, tip=tip, show=show)]
    met = gain_crossing(frequency, loop)
    if met is not None and abs(met.margin) < GAIN_SHOWN[1]:
        over.append(_margin(met.frequency, met.gain, 0.0, look, f"{name}: gain margin {met.margin:.1f} dB", show))
    met = phase_crossing(frequency, loop)
    if met is not None:
        foot = 360.0 * np.round((met.phase + 180.0) / 360.0) - 180.0
        under.append(_margin(met.frequency, met.phase, foot, look, f"{name}: phase margin {met.margin:.1f}°", show))
    return over, under


def nyquist_marks(frequency: Array, loop: Array, look: Look, name: str, show: Show) -> list[Mark]:
    """Return the curve, and marks where it meets the unit circle and the negative real axis."""
    tip = "%{x:.2f} %{y:+.2f}i at %{customdata[0]:.3~g} rad/s"
    curve = Line(
        name=name, look=look, x=np.real(loop), y=np.imag(loop), tips=(frequency, frequency), tip=tip, show=show
    )
    marks: list[Mark] = [curve]
    read = (phase_crossing, "phase margin {:.1f}°"), (gain_crossing, "gain margin {:.1f} dB")
    for crossing, words in read:
        met = crossing(frequency, loop)
        if met is not None and abs(met.point) < 20.0:
            at = (np.array([met.point.real]), np.array([met.point.imag]))
            hover = [f"{name}: {words.format(met.margin)}"]
            marks.append(Points(look=look._replace(size=8), x=at[0], y=at[1], hover=hover, show=show))
    return marks


class LoopAxes(NamedTuple):
    """Axes of loops: frequency, phase, and the two of the plane."""

    frequency: Axis
    phase: Axis
    real: Axis
    imaginary: Axis


LOOP_AXES = LoopAxes(
    Axis(FREQUENCY, log=True, step=1),
    Axis("phase [°]", step=90),
    Axis("real part", *NYQUIST[0]),
    Axis("imaginary part", *NYQUIST[1]),
)


def axes_of(curves: Sequence[tuple[Array, Array]]) -> LoopAxes:
    """Return axes that hold what matters of some loops.

    Frequencies and phases are those where the gain is shown; the plane is that around -1, with the margins.

    Args:
        curves: Frequencies (f,) and transfer functions (f,).
    """
    seen = [(w, loop, (np.abs(gain_of(loop)) <= GAIN_SHOWN[1])) for w, loop in curves]
    seen = [(w[mask], phase_of(loop)[mask]) for w, loop, mask in seen if mask.sum() > 1]
    points = [
        met.point
        for w, loop in curves
        for met in (phase_crossing(w, loop), gain_crossing(w, loop))
        if met is not None and abs(met.point) < FARTHEST
    ]
    plane = [
        Axis(
            axis.title, min([ends[0], *(AIR * part for part in parts)]), max([ends[1], *(AIR * part for part in parts)])
        )
        for axis, ends, parts in (
            (LOOP_AXES.real, AROUND[0], [point.real for point in points]),
            (LOOP_AXES.imaginary, AROUND[1], [point.imag for point in points]),
        )
    ]
    if not seen:
        return LOOP_AXES._replace(real=plane[0], imaginary=plane[1])
    low, high = min(float(w[0]) for w, _ in seen), max(float(w[-1]) for w, _ in seen)
    across = LOOP_AXES.frequency._replace(low=low, high=high)
    bottom = max(PHASE_SHOWN[0], min(-180.0, *(float(phase.min()) for _, phase in seen)))
    top = min(PHASE_SHOWN[1], max(-180.0, *(float(phase.max()) for _, phase in seen)))
    step = next((step for step in PHASE_STEPS if (top - bottom) / step <= MAX_STEPS), PHASE_STEPS[-1])
    margin = 0.06 * (top - bottom) or step
    up = Axis(LOOP_AXES.phase.title, bottom - margin, top + margin, step=step)
    return LoopAxes(across, up, *plane)


def loop_panels(
    gain: list[Mark],
    phase: list[Mark],
    plane: list[Mark],
    axes: LoopAxes = LOOP_AXES,
    limits: Sequence[ShadedLimit] = (),
) -> list[Panel]:
    """Return the three panels of loops around their marks, with shaded limits."""
    across = axes.frequency
    over, under, around = limit_marks(limits, across, axes.phase)
    minus_one = Points(look=Look("ink", "cross-thin", size=11), x=np.array([-1.0]), y=np.zeros(1), hover=["−1"])
    unit_circle = Disc(look=RULE._replace(colour="line"), x=0.0, y=0.0, radius=1.0)
    return [
        Panel(
            "loop-gain",
            "Bode: gain",
            across,
            Axis("gain [dB]", *GAIN_SHOWN),
            [*over, Rule(look=RULE, axis="y", value=0.0), *gain],
            aid=f"Above 0 dB the loop tracks and rejects. Bar: gain margin, read at −180°{REACH if over else '.'}",
        ),
        Panel(
            "loop-phase",
            "Bode: phase",
            across,
            axes.phase,
            [*under, Rule(look=RULE, axis="y", value=-180.0), *phase],
            aid=f"Bar: phase margin, read at 0 dB{REACH if under else '.'}",
        ),
        Panel(
            "loop-nyquist",
            "Nyquist",
            axes.real,
            axes.imaginary,
            [unit_circle, *around, *plane, minus_one],
            square=True,
            aid="Marks: gain and phase margin. A curve in a shaded disc around −1, or across a dashed line, violates a limit.",
        ),
    ]


def _margin(x: float, y: float, foot: float, look: Look, hover: str, show: Show) -> Points:
    ends = np.array([min(y, foot)]), np.array([max(y, foot)])
    return Points(
        look=look._replace(size=8, width=2.2), x=np.array([x]), y=np.array([y]), y_ends=ends, hover=[hover], show=show
    )


def _changes(values: Array) -> Array:
    """Return the places i (n,) at which a series changes its sign before i + 1."""
    return np.flatnonzero(np.diff(np.signbit(values)) != 0)


def _at(frequency: Array, gain: Array, phase: Array, i: int, crossed: Array) -> Crossing:
    """Return the place between i and i + 1 where a series is zero."""
    share = float(crossed[i] / (crossed[i] - crossed[i + 1]))
    gains, phases = (float(series[i] + share * (series[i + 1] - series[i])) for series in (gain, phase))
    return Crossing(float(frequency[i] * (frequency[i + 1] / frequency[i]) ** share), gains, phases, 0.0)
