"""The charts of a tuning page: responses and loops of every finalist, shown for whichever is picked."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tuner.documents.tables import Fan
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.documents.tuning_tables import Loop
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Mark, Panel
from tuner.report.charts.look import role_look, worst_look
from tuner.report.charts.loops import axes_of, bode_marks, loop_panels, nyquist_marks
from tuner.report.charts.shaded import ShadedLimit, shaded_limits
from tuner.report.charts.spectra import spectrum_mark, spectrum_panel
from tuner.report.labels import titles_of

# Bytes that all fans together may take in the page, and the instants of a fan: at most as many as a small chart has pixels.
BUDGET = 4.0e6
MAX_INSTANTS, MIN_INSTANTS = 200, 60
# Bytes of an instant of one signal: four series in sixteen bits, in base64, and a fifth of some.
INSTANT = 4.4 * 2 * 4 / 3
# A bound counts where default or tuned come within reach of it, as a share of the bound. It is drawn as far as it lies within
# what they span, with this much air around: beyond, it would press the signal flat.
NEAR, AIR = 0.6, 0.25


def response_panels(results: TuningFolder) -> list[Panel]:
    """Return a panel a signal with the fans of as many points as there is room for; none where there are no responses."""
    if not results.fans:
        return []
    points = kept_points(results)
    most = instants(len(results.fans) * len(points) // len(results.flown_points))
    recorded = [fans.thinned(fan, most) for fan in results.fans if fan.point in points]
    names = sorted(dict.fromkeys(fan.signal for fan in recorded), key=fans.is_rotor)
    shown = common_range(recorded)
    panels = [
        _signal(results, [fan for fan in recorded if fan.signal == name], k, shown) for k, name in enumerate(names)
    ]
    return [*panels, *top_view(results, recorded)]


def top_view(results: TuningFolder, recorded: Sequence[Fan]) -> list[Panel]:
    """Return the tracks of flights in x and y against their reference; none of plants and of attitude mode."""
    by_signal = {(fan.scenario, fan.point, fan.signal): fan for fan in recorded}
    marks, references = list[Mark](), list[Mark]()
    for (scenario, point, signal), x in sorted(by_signal.items(), key=lambda item: item[0][1] != DEFAULT):
        y = by_signal.get((scenario, point, "y"))
        if not results.has_rotors or signal != "x" or y is None:
            continue
        if point == results.tuned and np.isfinite([x.reference, y.reference]).all():
            references += fans.reference(x.reference, y.reference, {"scenario": scenario})
        show = {"point": point, "scenario": scenario}
        marks += fans.track_marks(x, y, role_look(results.held_out_front.role(point)), _title(results, point), show)
    aid = "Thick: medians of x and y over flights; thin: the worst flight; dotted: reference."
    panel = Panel(
        "top-view",
        "Top view",
        Axis("x [m]"),
        Axis("y [m]"),
        [*marks, *references],
        form="plot top",
        aid=aid,
        square=True,
    )
    return [panel] if marks else []


def spectrum_panels(results: TuningFolder) -> list[Panel]:
    """Return a panel with the spectra of the commands, none where the folder holds none."""
    if not results.spectra:
        return []
    marks = [
        spectrum_mark(entry, role_look(results.held_out_front.role(entry.point)), _title(results, entry.point))
        for entry in results.spectra
    ]
    return [replace(spectrum_panel(marks), form="plot")]


def margin_panels(results: TuningFolder) -> list[Panel]:
    """Return Bode and Nyquist panels of all points and loops, none where the folder holds no loops."""
    if not results.loops:
        return []
    parts: tuple[list[Mark], list[Mark], list[Mark]] = ([], [], [])
    for loops in (*_alike(results.worst_loops), *_alike(results.loops)):
        first, show = loops[0], {"point": loops[0].point, "channel": [loop.channel for loop in loops]}
        look, name = role_look(results.held_out_front.role(first.point)), _title(results, first.point)
        if first.state:
            look, name, show["part"] = worst_look(look), f"{name} in {first.state}", "worst"
        curve = first.frequency, first.response, look, name, show
        for part, marks in zip(parts, (*bode_marks(*curve), nyquist_marks(*curve)), strict=True):
            part += marks
    judged = [loop for loop in results.loops if results.held_out_front.role(loop.point)]
    axes = axes_of([(loop.frequency, loop.response) for loop in judged or results.loops])
    return [replace(panel, form="plot") for panel in loop_panels(*parts, axes, study_limits(results))]


def study_limits(results: TuningFolder) -> list[ShadedLimit]:
    """Return the limits on margins that the charts of loops shade."""
    given = [(row.label, row.limit) for row in results.requirements]
    return shaded_limits(given, [loop.channel for loop in results.loops])


def _title(results: TuningFolder, point: str) -> str:
    return titles_of(results).get(point, point)


def instants(count: int) -> int:
    """Return the number of instants of each of so many fans."""
    return int(np.clip(BUDGET / (INSTANT * max(count, 1)), MIN_INSTANTS, MAX_INSTANTS))


def kept_points(results: TuningFolder) -> set[str]:
    """Return the points whose fans fit in at least so few instants: default and tuned first, the others evenly spread."""
    points = results.flown_points
    each = MIN_INSTANTS * INSTANT * len(results.fans) / len(points)
    room = max(int(BUDGET / each), 2)
    if len(points) <= room:
        return set(points)
    others = points[2:]
    chosen = np.unique(np.linspace(0, len(others) - 1, room - 2).round().astype(int)) if room > 2 else []
    return {*points[:2], *(others[int(i)] for i in chosen)}


def common_range(recorded: list[Fan]) -> tuple[float, float] | None:
    """Return one range for all rotors, so that they can be compared; None where there are none."""
    rotors = [fan for fan in recorded if fans.is_rotor(fan.signal)]
    series = [part for fan in rotors for part in (fan.low, fan.high, fan.worst) if part is not None]
    if not series:
        return None
    low, high = min(float(part.min()) for part in series), max(float(part.max()) for part in series)
    margin = 0.05 * (high - low) or 0.1
    return low - margin, high + margin


def bound_of(results: TuningFolder, signal: str, scenario: str) -> tuple[float, str] | None:
    """Return the bound on a signal in shown units, and its origin; None where nothing limits it."""
    peaks = [
        entry
        for entry in results.constraints
        if entry.metric == f"peak.{signal}" and entry.scenario in (None, scenario)
    ]
    if peaks and peaks[0].limit is not None:
        return peaks[0].limit, f"{peaks[0].label} at most {peaks[0].limit:.3g} {peaks[0].unit}"
    limits = results.resolved.limits
    key, words = ("position", "m") if signal in "xyz" else ("tilt_deg", "°")
    if signal in ("x", "y", "z", "roll", "pitch") and isinstance(limits.get(key), int | float):
        return float(limits[key]), f"failure beyond {limits[key]:g} {words}"
    return None


def _signal(results: TuningFolder, recorded: list[Fan], k: int, rotors: tuple[float, float] | None) -> Panel:
    signal, marks = recorded[0].signal, []
    for scenario in results.scenarios:
        mine = [fan for fan in recorded if fan.scenario == scenario]
        if mine:
            marks += _scenario(results, mine, scenario)
    rotor = fans.is_rotor(signal)
    y = Axis("", *rotors) if rotor and rotors else Axis("")
    title, form = fans.title(signal, recorded[0].unit), "plot rotor" if rotor else "plot"
    return Panel(f"response-{k}", title, fans.TIME, y, marks, form=form, across=True)


def _scenario(results: TuningFolder, mine: list[Fan], scenario: str) -> list[Mark]:
    marks: list[Mark] = []
    shared = fans.agree(mine)
    # The default first: the picked point is drawn over it.
    for fan in sorted(mine, key=lambda fan: results.held_out_front.role(fan.point) != "default"):
        show = {"point": fan.point, "scenario": scenario}
        look = role_look(results.held_out_front.role(fan.point))
        if not shared:
            marks += fans.reference(fan.time, fan.reference, show)
        marks += fans.fan_marks(fan, look, _title(results, fan.point), show)
    first = mine[0]
    if shared:
        marks += fans.reference(first.time, first.reference, {"scenario": scenario})
    bound = bound_of(results, first.signal, scenario)
    if bound is not None:
        reference = first.reference if shared and np.isfinite(first.reference).all() else np.zeros_like(first.time)
        judged = [fan for fan in mine if results.held_out_front.role(fan.point) and len(fan.time) == len(reference)]
        farthest = max(
            (float(np.abs(edge - reference).max()) for fan in judged for edge in (fan.low, fan.high)), default=0.0
        )
        if farthest > NEAR * bound[0]:
            marks += fans.bounds(first.time, reference, *bound, _span(judged), {"scenario": scenario})
    return marks


def _span(judged: list[Fan]) -> tuple[float, float]:
    """Return the ends of some fans, with a margin."""
    parts = [series for fan in judged for series in (fan.low, fan.high, fan.worst, fan.reference) if series is not None]
    values = np.concatenate([part[np.isfinite(part)] for part in parts])
    low, high = float(values.min()), float(values.max())
    margin = AIR * (high - low)
    return low - margin, high + margin


def _alike(loops: list[Loop]) -> list[list[Loop]]:
    """Return the loops of each point, those with the same curve together."""
    groups: dict[tuple[str, bytes], list[Loop]] = {}
    for loop in loops:
        groups.setdefault((loop.point, loop.response.tobytes()), []).append(loop)
    return list(groups.values())
