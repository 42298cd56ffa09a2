"""Time responses: bands that hold 5 to 95 % of flights, medians, single flights, references and bounds."""

import numpy as np

from tuner.documents.tables import Fan
from tuner.report.charts.chart import Axis, Band, Line, Mark, Show, Words
from tuner.report.charts.look import BOUND, REFERENCE, Look, worst_look
from tuner.text.units import bracketed

TITLES = {
    **{axis: f"position {axis}" for axis in "xyz"},
    **{angle: f"{angle} angle" for angle in ("roll", "pitch", "yaw")},
    **{f"rotor{i}": f"rotor {i}" for i in range(1, 5)},
}
ROTOR_UNIT = "hover thrust"
TIME = Axis("time [s]")
# Instants drawn of a fan at most; the width of a small chart in pixels.
MAX_INSTANTS = 400


def title(signal: str, unit: str) -> str:
    """Return the heading of a signal with its unit."""
    return bracketed(TITLES.get(signal, signal), ROTOR_UNIT if is_rotor(signal) else unit)


def is_rotor(signal: str) -> bool:
    """Say whether a signal is a rotor command, in hover thrusts, and not an axis."""
    return signal.startswith("rotor")


def shown_signals(signals: list[str]) -> list[str]:
    """Return positions, the first rotor (the others look alike) and angles: a row of positions, a row of angles on paper."""
    names = list(dict.fromkeys(signals))
    rotors = [name for name in names if is_rotor(name)]
    axes = [name for name in names if not is_rotor(name)]
    return axes[:3] + rotors[:1] + axes[3:]


def fan_marks(fan: Fan, look: Look, name: str, show: Show, parts: bool = False) -> list[Mark]:
    """Return band and median of a fan, and its worst flight; parts: the page switches band and median one by one."""
    both = {
        "look": look._replace(opacity=0.2),
        "show": {**show, "part": "band"},
        "coarse": not parts,
    }
    line = {"look": look._replace(width=1.1) if parts else look, "show": {**show, "part": "median"} if parts else show}
    tip = "%{y:.3~g}" if parts else "%{y:.3~f} [%{customdata[0]:.3~f}, %{customdata[1]:.3~f}]"
    tips = None if parts else (fan.low, fan.high)
    marks: list[Mark] = [
        Band(x=fan.time, low=fan.low, high=fan.high, **both),
        Line(name=name, x=fan.time, y=fan.median, tips=tips, tip=tip, coarse=not parts, **line),
    ]
    if fan.worst is not None and np.isfinite(fan.worst).all():
        thin = {"look": worst_look(look), "show": {**show, "part": "worst"}, "coarse": True}
        worst = Line(name=f"worst case of {name}", x=fan.time, y=fan.worst, tip="%{y:.3~f}", **thin)
        marks.insert(1, worst)
    return marks


def reference(time: np.ndarray, values: np.ndarray, show: Show) -> list[Mark]:
    """Return the line of a reference; nothing where it is not known throughout."""
    if not np.isfinite(values).all():
        return []
    return [Line(name="reference", look=REFERENCE, x=time, y=values, tip="%{y:.3~f}", show=show)]


def track_marks(x: Fan, y: Fan, look: Look, name: str, show: Show) -> list[Mark]:
    """Return tracks seen from above: of the medians, and of the worst flight.

    Args:
        x: Position along x.
        y: Position along y at the same instants.
        look: Look of the point.
        name: Name of the point.
        show: When the page shows the marks.
    """
    tip = "%{x:.2f}, %{y:.2f} m"
    marks: list[Mark] = [Line(name=name, look=look, x=x.median, y=y.median, tip=tip, coarse=True, show=show)]
    if x.worst is not None and y.worst is not None:
        worst, thin = {**show, "part": "worst"}, worst_look(look)
        marks.append(
            Line(name=f"worst case of {name}", look=thin, x=x.worst, y=y.worst, tip=tip, coarse=True, show=worst)
        )
    return marks


def bounds(
    time: np.ndarray, values: np.ndarray, limit: float, name: str, shown: tuple[float, float], show: Show
) -> list[Mark]:
    """Return the limits of a signal: lines, or a note where both are off-scale.

    Args:
        time: Instants (n,).
        values: Reference (n,), to whose either side the lines are.
        limit: Distance of the lines from the reference.
        name: Text of the limit.
        shown: Ends of the values that are shown.
        show: When the page shows the marks.
    """
    ends = [np.where((end >= shown[0]) & (end <= shown[1]), end, np.nan) for end in (values - limit, values + limit)]
    seen = [end for end in ends if np.isfinite(end).any()]
    if not seen:
        return [Words(look=BOUND, x=0.99, y=1.0, text=f"↕ off-scale: {name}", place="inside", show=show)]
    return [Line(name=name, look=BOUND, x=time, y=end, tip="%{y:.3~f}", show=show) for end in seen]


def agree(fans: list[Fan]) -> bool:
    """Say whether fans share their reference; the setpoints of roll and pitch from a position loop differ from point to point."""
    first = fans[0].reference
    return all(np.array_equal(fan.reference, first, equal_nan=True) for fan in fans)


def thinned(fan: Fan, most: int = MAX_INSTANTS) -> Fan:
    """Return a fan with at most so many instants; the band keeps the extremes of the instants left out."""
    step = -(-len(fan.time) // most)
    if step <= 1:
        return fan
    starts = np.arange(0, len(fan.time), step)
    return Fan(
        fan.point,
        fan.scenario,
        fan.signal,
        fan.unit,
        fan.time[starts],
        fan.reference[starts],
        np.minimum.reduceat(fan.low, starts),
        fan.median[starts],
        np.maximum.reduceat(fan.high, starts),
        None if fan.worst is None else fan.worst[starts],
        fan.flight,
    )
