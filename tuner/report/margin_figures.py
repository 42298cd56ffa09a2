"""Figures of `tuner margins --out`: each loop over the amplitudes of its nonlinear terms, and how wrong its vehicle may be."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.analysis.margins.curves import Curves, curves_of, groups
from tuner.analysis.margins.limits import LIMITS
from tuner.analysis.margins.linear import Linear
from tuner.analysis.margins.mismatch import (
    CRITERIA,
    REACH,
    RobustnessMap,
    ToleranceRange,
    mismatch_map,
    tolerance_ranges,
)
from tuner.analysis.margins.readings import Loops as Readings
from tuner.analysis.margins.readings import Subject
from tuner.analysis.margins.time_response import LinearResponses, time_responses
from tuner.report.charts.chart import (
    Array,
    Axis,
    AxisRange,
    Band,
    Disc,
    Line,
    Mark,
    Panel,
    Points,
    Region,
    Rule,
    Words,
)
from tuner.report.charts.fans import TIME
from tuner.report.charts.files import save
from tuner.report.charts.look import RULE, Look
from tuner.report.charts.loops import FREQUENCY, NYQUIST, loop_panels
from tuner.report.charts.paper import Figure, figure_of, style

Loops = Mapping[tuple[str, ...], Curves]
"""Curves of every loop, by the names of the channels that share them."""

# How the first case (small signals), the last (steepest slope), those between and the range of all are drawn.
FIRST, LAST = Look("tuned", width=2.0), Look("default", dash=(7, 3), width=2.0)
BETWEEN, RANGE = Look("faint", width=0.8), Look("faint", opacity=0.25)
# Where gain and phase margins are met, which part of the plane is forbidden, and what the disk margin keeps free of it.
GAIN_MET, PHASE_MET = Look("ink", dash=(5, 2, 2, 2), width=1.1), Look("ink", dash=(10, 3), width=1.1)
FORBIDDEN, FREE = Look("ink", "/", opacity=0.6), Look("front", dash=(5, 2, 2, 2), opacity=0.3)
CRITICAL = Look("ink", "cross-thin", size=20)
# Part of the plane that Nichols curves are shown in, and the most that is shown of phases [deg].
NICHOLS = Axis("phase of L [deg]", -300.0, -60.0, step=30.0), Axis("gain of L [dB]", -30.0, 30.0)
PHASE_SHOWN = (-630.0, 90.0)
# Responses that differ by less than this at no time are one: the loop depends on no amplitude.
ALIKE = 1e-9
# The two maps of factors, the ticks of their axes and what the factors are called.
MAPS = (("mass", "inertia"), ("thrust", "lag"))
TICKS = tuple((value, f"{value:g}") for value in (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0))
TITLES = {"mass": "mass", "inertia": "inertia", "thrust": "rotor thrust", "lag": "rotor lag"}
SATISFIED, BROKEN = Look("front", dash=(7, 3), opacity=0.4), Look("faint", width=0.0, opacity=0.17)
UNSTABLE, GROUNDED = Look("muted", "x", opacity=0.25), Look("faint", ".", width=0.0, opacity=0.0)
NOMINAL = Look("ink", "cross", size=11)


def write_margin_figures(subject: Subject, folder: Path) -> list[ToleranceRange]:
    """Write bode, nyquist, nichols, responses and mismatch into an existing folder; return how far single factors may go."""
    loops = loops_of(subject)
    responses = time_responses(subject.controller, subject.trim, tuple(group[0] for group in loops))
    linear = Linear(subject.controller, subject.trim)
    ends = tolerance_ranges(linear)
    maps = [mismatch_map(linear, across, up, ends) for across, up in MAPS]
    labels = tuple(case.label for case in linear.cases)
    write_loop_figures(subject, folder)
    with style():
        save(response_figure(dict(zip(loops, responses, strict=True)), labels), folder, "responses")
        save(mismatch_figure(maps, ends), folder, "mismatch")
    return ends


def write_loop_figures(subject: Readings, folder: Path) -> None:
    """Write bode, nyquist and nichols into an existing folder."""
    loops = loops_of(subject)
    with style():
        save(bode_figure(subject, loops), folder, "bode")
        save(nyquist_figure(subject, loops), folder, "nyquist")
        save(nichols_figure(subject, loops), folder, "nichols")


def loops_of(subject: Readings) -> Loops:
    """Return the curves of every loop, once for loops that do not differ."""
    return {group: curves_of(subject, group[0]) for group in groups(subject)}


def bode_figure(subject: Readings, loops: Loops) -> Figure:
    """Return gain above phase for each loop, with the crossings that its margins are met at."""
    low = min(float(curves.phase.min(axis=None)) for curves in loops.values())
    high = max(float(curves.phase.max(axis=None)) for curves in loops.values())
    ends = max(90.0 * np.floor(low / 90.0), PHASE_SHOWN[0]), min(90.0 * np.ceil(high / 90.0), PHASE_SHOWN[1])
    over, under = [], []
    for group, curves in loops.items():
        w, met = curves.frequency, _crossings(subject, group[0])
        gain, phase, _ = loop_panels(
            [*_range(w, curves.gain), *_cases(w, curves.gain, curves.labels), *met],
            [*_range(w, curves.phase), *_cases(w, curves.phase, curves.labels), *met],
            [],
        )
        across = AxisRange(w[0], w[-1], True).axis(FREQUENCY)
        y = Axis("phase of L [deg]", *ends, step=90.0, bare=bool(over))
        gain_y = gain.y._replace(title="gain of L [dB]", bare=bool(over))
        over.append(replace(gain, title=" and ".join(group), x=across._replace(bare=True), y=gain_y))
        under.append(replace(phase, title="", x=across, y=y))
    return figure_of([*over, *under], len(loops), 2.1, titled=True)


def nyquist_figure(subject: Readings, loops: Loops) -> Figure:
    """Return the curve of each loop, the circle of the largest Ms allowed, and the disk that its disk margin keeps free."""
    peak, x, y = largest_peak(), Axis("Re L", *NYQUIST[0]), Axis("Im L", *NYQUIST[1])
    panels = []
    for group, curves in loops.items():
        marks: list[Mark] = [
            Disc(name=f"Ms > {peak:g}", look=FORBIDDEN, x=-1.0, y=0.0, radius=1.0 / peak, fill="hatched"),
            *_free_disk(subject, group[0]),
            *_cases(np.real(curves.loop), np.imag(curves.loop), curves.labels),
            Points(look=CRITICAL, x=np.array([-1.0]), y=np.zeros(1)),
        ]
        panels.append(Panel("", " and ".join(group), x, y, marks, square=True))
    return figure_of(panels, 2, 3.3, titled=True)


def nichols_figure(subject: Readings, loops: Loops) -> Figure:
    """Return gain over phase of each loop, with the region of too large a sensitivity."""
    panels = []
    for group, curves in loops.items():
        cross = Points(look=CRITICAL, x=np.array([-180.0]), y=np.zeros(1))
        marks: list[Mark] = [_forbidden_gains(), *_cases(curves.phase, curves.gain, curves.labels), cross]
        panels.append(Panel("", " and ".join(group), *NICHOLS, marks))
    return figure_of(panels, 2, 2.7, titled=True)


def response_figure(responses: Mapping[tuple[str, ...], LinearResponses], labels: Sequence[str]) -> Figure:
    """Return steps of the set point above steps of the load; labels: of the amplitudes, one for loops that depend on none."""
    over, under = [], []
    for group, response in responses.items():
        x = TIME._replace(low=0.0, high=float(response.time[-1]))
        top = max(1.3, min(float(np.nanmax(np.append(response.step, 1.0))) + 0.1, 3.0))
        y = Axis("output after a\nunit step of the set point", -0.1, top, bare=bool(over))
        unit = "rad per rad/s²" if group[0] in ATTITUDE_AXES else "m per m/s²"
        load = Axis("" if over else "output after a\nunit step of the load")
        marks = [
            [*_stable_cases(response.time, values, labels), Rule(look=RULE, axis="y", value=end)]
            for values, end in ((response.step, 1.0), (response.load, 0.0))
        ]
        over.append(Panel("", " and ".join(group), x._replace(title=""), y, marks[0]))
        under.append(Panel("", unit, x, load, marks[1]))
    return figure_of([*over, *under], len(responses), 1.9, titled=True)


def mismatch_figure(maps: Sequence[RobustnessMap], ends: Sequence[ToleranceRange]) -> Figure:
    """Return maps of where the loop stays stable and keeps the limits; above each how far its factors may go by themselves."""
    return figure_of([_map_panel(entry, ends) for entry in maps], 2, 3.5, titled=True)


def largest_peak() -> float:
    """Return the largest Ms that is allowed."""
    return next(limit.limit for limit in LIMITS if limit.quantity == "ms")


def disk_circle(low: float, high: float) -> tuple[float, float]:
    """Return centre and radius of the disk from -1/low to -1/high that L keeps free for factors of the gain from low to high."""
    far, near = -1.0 / low, -1.0 / high
    return 0.5 * (far + near), 0.5 * (near - far)


def _range(x: Array, values: Array) -> list[Mark]:
    return [Band(look=RANGE, x=x, low=values.min(axis=0), high=values.max(axis=0))]


def _cases(x: Array, y: Array, labels: Sequence[str]) -> list[Mark]:
    """Return a line for each amplitude (cases, n), x the same for all (n,) or not; the first and the last lie on top."""
    last = len(y) - 1
    if last == 0:
        return [Line(look=FIRST, x=np.atleast_2d(x)[0], y=y[0])]
    looks = [FIRST, *[BETWEEN] * (last - 1), LAST]
    names = [labels[0], *["amplitudes between"] * (last - 1), labels[last]]
    across = np.broadcast_to(x, y.shape)
    return [Line(name=names[i], look=looks[i], x=across[i], y=y[i]) for i in range(last + 1) if np.isfinite(y[i]).all()]


def _stable_cases(time: Array, values: Array, labels: Sequence[str]) -> list[Mark]:
    """Return the cases that are stable, and words on those that are not."""
    is_stable, count = np.isfinite(values).all(axis=1), len(values)
    marks: list[Mark] = []
    if not is_stable.all():
        words = f"stable at {is_stable.sum()} of\n{count} amplitudes" if is_stable.any() else "not stable"
        marks.append(Words(look=CRITICAL, x=0.97, y=0.6, text=words, place="inside"))
    if not is_stable.any():
        return marks
    if np.ptp(values[is_stable], axis=0).max(initial=0.0) < ALIKE:
        return [*marks, *_cases(time, values[is_stable][:1], labels)]
    return [*marks, *_range(time, values[is_stable]), *_cases(time, values, labels)]


def _crossings(subject: Readings, channel: str) -> list[Mark]:
    """Return lines at the frequencies where the worst gain and phase margins are met."""
    i, margins = subject.place(channel), subject.margins
    met = (
        ("gain margins met here", margins.gain_up, GAIN_MET),
        ("gain margins met here", margins.gain_down, GAIN_MET),
        ("phase margin met here", margins.phase, PHASE_MET),
    )
    return [
        Rule(name=name, look=look, axis="x", value=float(worst.frequency[0, i]))
        for name, worst, look in met
        if worst.frequency[0, i] > 0.0
    ]


def _free_disk(subject: Readings, channel: str) -> list[Mark]:
    i, disk = subject.place(channel), subject.margins.disk_range
    low, high = float(disk.low[0, i]), float(disk.high[0, i])
    if not 0.0 < low < 1.0:
        return []
    centre, radius = disk_circle(low, high)
    return [Disc(name="disk margin, kept free", look=FREE, x=centre, y=0.0, radius=radius, fill="filled")]


def _forbidden_gains() -> Band:
    """Return the disk |1 + L| < 1/Ms: the gains between which a ray from the origin at some phase passes through it."""
    radius = 1.0 / largest_peak()
    # Close together at the ends, where the two gains meet.
    off = np.arcsin(radius) * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 181))
    half = np.sqrt(np.maximum(radius**2 - np.sin(off) ** 2, 0.0))
    low, high = (20.0 * np.log10(np.cos(off) + side * half) for side in (-1.0, 1.0))
    return Band(name=f"Ms > {largest_peak():g}", look=FORBIDDEN, x=-180.0 + np.degrees(off), low=low, high=high)


def _map_panel(entry: RobustnessMap, ends: Sequence[ToleranceRange]) -> Panel:
    everywhere = np.zeros_like(entry.stability)
    regions = (
        ("no steady flight", GROUNDED, everywhere, (-np.inf, np.inf)),
        ("stable, a limit violated", BROKEN, entry.stability, (-np.inf, np.inf)),
        ("not stable", UNSTABLE, entry.stability, (-np.inf, 0.0)),
        ("limits satisfied", SATISFIED, entry.limits, (0.0, np.inf)),
    )
    marks: list[Mark] = [
        Region(name=name, look=look, x=entry.x, y=entry.y, values=values, low=span[0], high=span[1])
        for name, look, values, span in regions
    ]
    marks.append(Points(look=NOMINAL, x=np.ones(1), y=np.ones(1)))
    x, y = (
        Axis(f"{TITLES[name]}, actual over assumed", float(values[0]), float(values[-1]), True, TICKS)
        for name, values in ((entry.across, entry.x), (entry.up, entry.y))
    )
    title = "\n".join(line for factor in (entry.across, entry.up) for line in _extent_lines(factor, ends))
    return Panel("", title, x, y, marks)


def _extent_lines(factor: str, ends: Sequence[ToleranceRange]) -> list[str]:
    """Return the range of a factor by itself, in words."""
    stable, limits = (next(end for end in ends if (end.factor, end.criterion) == (factor, name)) for name in CRITERIA)
    broken = limits.low == limits.high == 1.0
    limits_text = "limits violated from the start" if broken else f"limits satisfied from {_extent(limits)}"
    return [f"{TITLES[factor]} alone: stable from {_extent(stable)}", limits_text]


def _extent(extent: ToleranceRange) -> str:
    low = f"below {1.0 / REACH:g}" if extent.low is None else f"{extent.low:.2f}"
    high = f"above {REACH:g}" if extent.high is None else f"{extent.high:.2f}"
    return f"{low} to {high}"
