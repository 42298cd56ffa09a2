"""Speed and robustness of a quadrotor's loops, by similarity in time.

A loop whose time constants are all divided by a factor needs gains times a power of it: that of 1/s in their units. The poles of
a rigid body are then that factor further out, and its flight is the same in another time:

    N m/rad and s^-2 -> speed^2,   s^-1 and rad/s -> speed,   rad^(1/2) s^(-3/2) -> speed^(3/2),   s -> 1/speed,   1 -> as it is

Rotor lag, delay, control period and the sensors' filters stay, so margins shrink with speed. The design of cascades
(`objectives/design`) has no closed-loop time and takes 1 to 4 s, so it can follow no hand.

Robustness slows what surrounds the fastest part of a loop: the observer of ADRC, the loops around the innermost one by the same
similarity, the integral action if there is neither.
"""

import re
from collections.abc import Collection, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from plant.quadrotor.gains import GainAddress
from tuner.extensions.studio.design import ROBUSTNESS, Slider, offer, within
from tuner.extensions.studio.messages import PageRequest
from tuner.extensions.studio.session import Session

SPEED = Slider("speed", "Speed", 0.25, 4.0, 1.0)
"""Factor on the speed of all loops."""
SETTING_POWERS = {"angle_p": 1, "angle_i": 2, "p": 1, "i": 2, "ff": 1, "sigma": 1}
"""Power of the speed in firmware's gains without a unit, by name; PX4 states it in the units of the same names."""
INNER_TO_OUTER = ("angle_p", "angle_i", "position_p")
"""Gains of an outer loop within a firmware's law."""
MODELS = ("k_m", "t_m", "l_m", "a0", "a1", "a2", "tau", "b0")
"""Gains that describe the vehicle, not the speed of its loop; limits do so too."""
_QUOTIENT = re.compile(r"/(?![^(]*\))")
_SECONDS = re.compile(r"(?<![A-Za-z])s(?:\^(?:\(([^)]*)\)|(-?\d+)))?(?![A-Za-z])")


class Similarity:
    """Sliders that scale the gains at hand.

    Args:
        session: The opened study of a quadrotor.
    """

    def __init__(self, session: Session) -> None:
        self._session, space = session, session.study.space
        gains: Sequence[GainAddress] = session.study.system.gains
        searched = [gains[columns[0]] for columns in space.columns]
        self._speed = np.array([speed_power(gain, gains) for gain in searched])
        self._robustness = robustness_powers(searched, gains)
        moved = {column for columns in space.columns for column in columns}
        fixed = [gain for gain in gains if gain.column not in moved and session.default.row[gain.column]]
        self._fixed = [gain for gain in fixed if speed_power(gain, gains) != 0.0]

    @property
    def offers(self) -> dict[str, Any] | None:
        """Description of the sliders; None if no searched gain has a time in its unit."""
        sliders = [
            slider for slider, powers in ((SPEED, self._speed), (ROBUSTNESS, self._robustness)) if np.any(powers != 0.0)
        ]
        note = f"Fixed in the study, so not scaled: {by_axis(self._fixed)}." if self._fixed else ""
        return offer("similarity", sliders, note) if sliders else None

    def designed(self, request: PageRequest, message: dict[str, Any]) -> dict[str, Any]:
        """Return the setting of the request, scaled by the sliders' values over those before."""
        before, now = (self._factors(message.get(key, {}), key) for key in ("from", "at"))
        scale = (now[0] / before[0]) ** self._speed * (now[1] / before[1]) ** self._robustness
        values = self._session.values(request.settings[0].row)
        scaled = {name: values[name] * factor for name, factor in zip(values, scale, strict=True) if factor != 1.0}
        held, notes = within(self._session, scaled)
        return {"values": values | held, "text": " ".join(notes)}

    def _factors(self, content: Any, key: str) -> tuple[float, float]:
        offered = {"speed": 1.0, "robustness": 1.0} | content if isinstance(content, dict) else content
        return SPEED.read(offered, key), ROBUSTNESS.read(offered, key)


def seconds_in(unit: str) -> Fraction:
    """Return the power of the second in a unit, such as -3/2 of "rad^(1/2) s^(-3/2)"."""
    top, *below = _QUOTIENT.split(unit)
    return _power(top) - sum((_power(part) for part in below), Fraction(0))


def _power(factors: str) -> Fraction:
    return sum((Fraction(match[1] or match[2] or 1) for match in _SECONDS.finditer(factors)), Fraction(0))


def speed_power(gain: GainAddress, gains: Sequence[GainAddress]) -> float:
    """Return the power of the speed that multiplies a gain.

    gains: all of the cascade, among them the `authority` that turns a firmware's output into acceleration.
    """
    info = gain.info
    if info.airframe or info.firmware or info.name in MODELS or info.name.endswith("limit"):
        return 0.0
    if gain.unit == "1":
        return float(SETTING_POWERS.get(info.name, 0))
    power = seconds_in(gain.unit)
    if info.of_output:
        power += sum(seconds_in(each.unit) for each in gains if each.address == f"{gain.axis}.authority")
    return float(-power)


def robustness_powers(searched: Sequence[GainAddress], gains: Sequence[GainAddress]) -> np.ndarray:
    """Return the power of the robustness (n,) that multiplies each searched gain."""
    observed = {gain.axis for gain in gains if gain.info.observer}
    powers = np.array([_robustness_power(gain, gains, observed) for gain in searched])
    if np.any(powers != 0.0):
        return powers
    return np.array([-1.0 if gain.info.integrals == 1 else 0.0 for gain in searched])


def _robustness_power(gain: GainAddress, gains: Sequence[GainAddress], observed: Collection[str]) -> float:
    if gain.axis in observed:
        return -1.0 if gain.info.observer else 0.0
    surrounds = gain.loop == "position" or gain.info.name in INNER_TO_OUTER
    return 0.0 - speed_power(gain, gains) if surrounds else 0.0


def by_axis(gains: Sequence[GainAddress]) -> str:
    """Return gains as text, axes with the same gains together."""
    names = dict[str, list[str]]()
    for gain in gains:
        names.setdefault(gain.axis, []).append(gain.address.partition(".")[2])
    axes = dict[str, list[str]]()
    for axis, each in names.items():
        axes.setdefault(", ".join(each), []).append(axis)
    return "; ".join(f"{each} of {', '.join(group)}" for each, group in axes.items())
