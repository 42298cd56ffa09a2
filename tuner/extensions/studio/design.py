"""Two further sliders for plants: speed and robustness, through the rules of `tuner design`.

Speed is the closed-loop time of the rule: SIMC's for PID, Herbst's settling time for first-order ADRC. Robustness slows what
makes a loop oscillate at a given speed: the integral action of PID, the observer of ADRC.
"""

from math import log10
from typing import Any, cast

import numpy as np

from plant.errors import InputError
from tuner.api.designing import Proposal
from tuner.extension import added, load
from tuner.extensions.studio.messages import values_of
from tuner.extensions.studio.session import Session
from tuner.study.plant_study import PlantStudy

METHODS = ("simc", "herbst")
"""Rules with a closed-loop time, in the order in which they are tried."""
SLOWING_POWERS = {"t_i": 1.0, "ki": -1.0, "omega_o": -1.0}
"""Name of a gain -> power of the robustness that multiplies it."""
ROBUSTNESS = (0.5, 4.0)
"""Range of the robustness; 1 is the rule's own."""
PERIODS = 4.0
"""Shortest closed-loop time in control periods."""


class Rules:
    """Design rules of a session's plant.

    Args:
        session: The opened study.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._method: str | None = None

    @property
    def offers(self) -> dict[str, Any] | None:
        """Method and ranges of the sliders; None without a rule."""
        method = self._first_method()
        if not method:
            return None
        low, high = self._times()
        return {"method": method, "low": low, "high": high, "robustness": list(ROBUSTNESS)}

    def designed(self, _: Any, message: dict[str, Any]) -> dict[str, Any]:
        """Return the gains of the rule at a speed and a robustness."""
        numbers = values_of({name: message.get(name, 0.0) for name in ("time", "robustness")})
        values, notes = self.values(**numbers)
        return {"values": values, "text": " ".join(notes)}

    def values(self, time: float, robustness: float) -> tuple[dict[str, float], list[str]]:
        """Return values by variable, and notes on ends of ranges.

        time: closed-loop time [s]. Raises InputError for numbers outside the sliders, or where no rule designs a channel.
        """
        method, (low, high) = self._first_method(), self._times()
        if not method:
            raise InputError("no rule of `tuner design` takes a channel of this study; move the gains instead")
        for name, value, ends in (("time", time, (low, high)), ("robustness", robustness, ROBUSTNESS)):
            if not ends[0] * (1.0 - 1e-9) <= value <= ends[1] * (1.0 + 1e-9):
                raise InputError(f"given {value:g}; allowed: {ends[0]:g} to {ends[1]:g}", key=name)
        proposal = self._proposal(method, time)
        row = slowed(
            self._study, proposal.row, robustness, {n for n, each in proposal.channels.items() if each.designed}
        )
        return self._within(row)

    @property
    def _study(self) -> PlantStudy:
        # `_first_method` finds none for a quadrotor.
        return cast("PlantStudy", self._session.study)

    def _first_method(self) -> str:
        """Return the first rule that designs a channel, "" without one."""
        if self._method is None:
            self._method = next((name for name in METHODS if self._designs(name)), "")
        return self._method

    def _designs(self, method: str) -> bool:
        if self._session.has_rotors or method not in added("designs"):
            return False
        low, high = self._times()
        try:
            proposal = self._proposal(method, (low * high) ** 0.5)
        except InputError:
            return False
        return any(each.designed for each in proposal.channels.values())

    def _proposal(self, method: str, time: float) -> Proposal:
        return load(added("designs")[method])(self._study, time)

    def _times(self) -> tuple[float, float]:
        study = self._session.study
        longest = max(entry.spec.duration for entry in study.scenarios)
        return rounded(PERIODS * study.system.timing.control_period), rounded(longest)

    def _within(self, row: np.ndarray) -> tuple[dict[str, float], list[str]]:
        """Return values within their ranges, and notes on moved ones."""
        values, notes = self._session.values(row), list[str]()
        for variable in self._study.space.variables:
            value = values[variable.name]
            held = min(max(value, variable.low), variable.high)
            if held != value:
                notes.append(f"{variable.name}: the rule gives {value:.4g}, the range ends at {held:g}.")
            values[variable.name] = held
        return values, notes


def slowed(study: PlantStudy, row: np.ndarray, robustness: float, channels: set[str]) -> np.ndarray:
    """Return a gains row (g,) with slower integral action and observers.

    robustness: factor by which they are slower. channels: names of those that are changed.
    """
    out = np.array(row, dtype=float)
    for gain in study.system.gains:
        if gain.axis in channels and gain.info.name in SLOWING_POWERS:
            out[gain.column] *= robustness ** SLOWING_POWERS[gain.info.name]
    return out


def rounded(value: float) -> float:
    """Return a number to two digits, as the end of a slider."""
    return round(value, 1 - int(np.floor(log10(value))))
