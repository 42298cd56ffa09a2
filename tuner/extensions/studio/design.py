"""Two further sliders for plants: speed and robustness, through the rules of `tuner design`.

Speed is the closed-loop time of the rule: SIMC's for PID, Herbst's settling time for first-order ADRC. Robustness slows what
makes a loop oscillate at a given speed: the integral action of PID, the observer of ADRC.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import log10
from typing import Any, NamedTuple, cast

import numpy as np

from plant.errors import InputError
from tuner.api.designing import Proposal
from tuner.extension import added, load
from tuner.extensions.studio.messages import PageRequest, values_of
from tuner.extensions.studio.session import Session
from tuner.study.plant_study import PlantStudy

METHODS = ("simc", "herbst")
"""Rules with a closed-loop time, in the order in which they are tried."""
SLOWING_POWERS = {"t_i": 1.0, "ki": -1.0, "i": -1.0, "angle_i": -1.0, "omega_o": -1.0}
"""Name of a gain -> power of the robustness that multiplies it."""
PERIODS = 4.0
"""Shortest closed-loop time in control periods."""


class Slider(NamedTuple):
    """A slider of the page: key in messages, label, ends, value at the beginning, and unit, "" for none."""

    key: str
    label: str
    low: float
    high: float
    at: float
    unit: str = ""

    def read(self, content: Any, key: str) -> float:
        """Return its value in a message's table; InputError outside the slider."""
        value = values_of(content).get(self.key, 0.0)
        if not self.low * (1.0 - 1e-9) <= value <= self.high * (1.0 + 1e-9):
            raise InputError(f"given {value:g}; allowed: {self.low:g} to {self.high:g}", key=f"{key}.{self.key}")
        return value


ROBUSTNESS = Slider("robustness", "Robustness", 0.5, 4.0, 1.0)
"""Factor by which parts of a loop are slower; 1 is the rule's own."""


class Rules:
    """Design rules of a session's plant."""

    def __init__(self, session: Session) -> None:
        self._session = session

    @property
    def offers(self) -> dict[str, Any] | None:
        """Description of the sliders; None without a rule."""
        return offer(self._method, [self._time(), ROBUSTNESS]) if self._method else None

    def designed(self, _: PageRequest, message: dict[str, Any]) -> dict[str, Any]:
        """Return the gains of the rule.

        Raises InputError for numbers outside the sliders, or where no rule designs a channel.
        """
        if not self._method:
            raise InputError("no rule of `tuner design` takes a channel of this study; move the gains instead")
        time, robustness = (slider.read(message.get("at", {}), "at") for slider in (self._time(), ROBUSTNESS))
        proposal = self._proposal(self._method, time)
        row = np.array(proposal.row, dtype=float)
        for gain in self._study.system.gains:
            if gain.axis in proposal.channels and proposal.channels[gain.axis].designed:
                row[gain.column] *= robustness ** SLOWING_POWERS.get(gain.info.name, 0.0)
        values, notes = within(self._session, self._session.values(row))
        return {"values": values, "text": " ".join(notes)}

    @property
    def _study(self) -> PlantStudy:
        return cast("PlantStudy", self._session.study)

    @cached_property
    def _method(self) -> str:
        """First rule that designs a channel, "" without one."""
        return next((name for name in METHODS if self._designs(name)), "")

    def _designs(self, method: str) -> bool:
        if method not in added("designs"):
            return False
        try:
            proposal = self._proposal(method, self._time().at)
        except InputError:
            return False
        return any(each.designed for each in proposal.channels.values())

    def _proposal(self, method: str, time: float) -> Proposal:
        return load(added("designs")[method])(self._study, time)

    def _time(self) -> Slider:
        study = self._session.study
        low = rounded(PERIODS * study.system.timing.control_period)
        high = rounded(max(entry.spec.duration for entry in study.scenarios))
        return Slider("time", "Closed-loop time", low, high, (low * high) ** 0.5, "s")


def offer(method: str, sliders: Sequence[Slider], note: str = "") -> dict[str, Any]:
    """Return the description of sliders for the page; note: shown below them."""
    return {"method": method, "sliders": [slider._asdict() for slider in sliders], "note": note}


def within(session: Session, values: Mapping[str, float]) -> tuple[dict[str, float], list[str]]:
    """Return values within their ranges, and notes on those that end there."""
    held, notes = dict[str, float](), list[str]()
    for variable in [each for each in session.study.space.variables if each.name in values]:
        name, value = variable.name, values[variable.name]
        inside = min(max(value, variable.low), variable.high)
        held[name] = float(variable.value(np.array(variable.unit(inside)))) if variable.step else inside
        # Within rounding an end of the range is not beyond it.
        if abs(inside - value) > 1e-9 * (variable.high - variable.low):
            notes.append(f"{name}: the rule gives {value:.4g}, the range ends at {inside:g}.")
    return held, notes


def rounded(value: float) -> float:
    """Return a number to two digits, as the end of a slider."""
    return round(value, 1 - int(np.floor(log10(value))))
