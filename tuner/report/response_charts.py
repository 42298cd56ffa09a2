"""The signals of time responses: what they are called, and how many of their instants are shown."""

import numpy as np

from tuner.documents.results import Fan
from tuner.text.units import bracketed

TITLES = {
    **{axis: f"position {axis}" for axis in "xyz"},
    **{angle: f"{angle} angle" for angle in ("roll", "pitch", "yaw")},
    **{f"rotor{i}": f"rotor {i}" for i in range(1, 5)},
}
ROTOR_UNIT = "hover thrust"
# Instants drawn of a fan at most; the width of a small figure in pixels.
MOST_INSTANTS = 400


def title(fan: Fan) -> str:
    """Return the heading of a signal with its unit."""
    unit = ROTOR_UNIT if is_rotor(fan.signal) else fan.unit
    return bracketed(TITLES.get(fan.signal, fan.signal), unit)


def is_rotor(signal: str) -> bool:
    """Say whether a signal is a rotor command, in hover thrusts, and not an axis."""
    return signal.startswith("rotor")


def thinned(fan: Fan, most: int = MOST_INSTANTS) -> Fan:
    """Return a fan with at most so many instants; the band keeps the extremes of the instants left out."""
    step = -(-len(fan.time) // most)
    if step <= 1:
        return fan
    starts = np.arange(0, len(fan.time), step)
    return Fan(
        fan.point, fan.scenario, fan.signal, fan.unit, fan.time[starts], fan.reference[starts],
        np.minimum.reduceat(fan.low, starts), fan.median[starts], np.maximum.reduceat(fan.high, starts),
        None if fan.worst is None else fan.worst[starts], fan.flight,
    )  # fmt: skip
