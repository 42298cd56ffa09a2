"""Speed and robustness of a quadrotor's loops, by similarity in time.

A loop whose time constants are all divided by a factor needs gains times a power of it: that of 1/s in their units. The poles of
a rigid body are then that factor further out, and its flight is the same in another time:

    N m/rad and s^-2 -> speed^2,   s^-1 and rad/s -> speed,   rad^(1/2) s^(-3/2) -> speed^(3/2),   s -> 1/speed,   1 -> as it is

Rotor lag, delay, control period and the sensors' filters stay, so margins shrink with speed. The design of cascades
(`objectives/design`) has no closed-loop time and takes 1 to 4 s, so it can follow no hand.

Robustness slows the observers of ADRC; without one the position loops, by similarity at the same attitude loops; if those are
fixed, the integral action of attitude.
"""

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from plant.quadrotor.gains import GainAddress
from tuner.extensions.studio.design import ROBUSTNESS, SLOWING_POWERS, Slider, offer, within
from tuner.extensions.studio.messages import PageRequest
from tuner.extensions.studio.session import Session

SPEED = Slider("speed", "Speed", 0.25, 4.0, 1.0)
"""Factor on the speed of all loops."""
SETTING_POWERS = {"angle_p": 1, "angle_i": 2, "p": 1, "i": 2, "ff": 1, "sigma": 1}
"""Power of the speed in firmware's gains without a unit, by name; PX4 states it in the units of the same names."""
OBSERVERS = ("omega_o", "wo")
"""Bandwidths of observers."""
MODELS = ("k_m", "t_m", "l_m", "a0", "a1", "a2", "tau", "b0")
"""Gains that describe the vehicle, not the speed of its loop; limits do so too."""
_QUOTIENT = re.compile(r"/(?![^(]*\))")
_SECONDS = re.compile(r"(?<![A-Za-z])s(?:\^(?:\(([^)]*)\)|(-?\d+)))?(?![A-Za-z])")


class Similarity:
    """Sliders that scale the gains at hand of a quadrotor."""

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
        names = dict[str, list[str]]()
        for gain in self._fixed:
            names.setdefault(gain.axis, []).append(gain.address.partition(".")[2])
        by_axis = [f"{axis} {', '.join(each)}" for axis, each in names.items()]
        note = "Factors on the setting at hand."
        note += f" Fixed in the study, so not scaled: {'; '.join(by_axis)}." if by_axis else ""
        return offer("similarity", sliders, note) if sliders else None

    def designed(self, request: PageRequest, message: dict[str, Any]) -> dict[str, Any]:
        """Return the setting, scaled by the sliders over their values before."""
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
    """Return the power of the second in a unit."""
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
    observed = {gain.axis for gain in gains if gain.info.name in OBSERVERS}
    has_outer = any(gain.loop == "position" for gain in searched)

    def power(gain: GainAddress) -> float:
        if gain.axis in observed:
            return -1.0 if gain.info.name in OBSERVERS else 0.0
        if gain.loop == "position":
            return 0.0 - speed_power(gain, gains)
        return 0.0 if has_outer else SLOWING_POWERS.get(gain.info.name, 0.0)

    return np.array([power(gain) for gain in searched])
