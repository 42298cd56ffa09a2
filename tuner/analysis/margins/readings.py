"""The quantities of each loop as they are shown, under the names and in the units of [[margin]] tables."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from objectives.margins.results import Margins, Worst, decibel
from objectives.margins.trim import Trim
from plant.closed_loop import Timing
from plant.nominal import nominal
from tuner.gains import Controller

Array = np.ndarray


@dataclass(frozen=True)
class Shown:
    """A quantity as it is shown: name and unit as in [[margin]] tables; label; source: field of `Margins`; shown: its value in
    that unit, given the control period; unlimited: what an infinite value of a stable loop means.
    """

    name: str
    label: str
    unit: str
    source: str
    shown: Callable[[Array, float], Array]
    unlimited: str = ""


def _plain(value: Array, _: float) -> Array:
    return value


SHOWN = (
    Shown("gain_up", "gain margin up", "dB", "gain_up", lambda v, _: decibel(v), "no rise of the gain makes it unstable"),
    Shown("gain_down", "gain margin down", "dB", "gain_down", lambda v, _: decibel(v), "no fall of the gain makes it unstable"),
    Shown("phase_margin", "phase margin", "deg", "phase", lambda v, _: np.degrees(v), "the loop gain crosses 1 nowhere"),
    Shown("delay_margin", "delay margin", "s", "delay", _plain, "the loop gain crosses 1 nowhere"),
    Shown("delay_periods", "delay margin", "1", "delay", lambda v, h: v / h, "the loop gain crosses 1 nowhere"),
    Shown("ms", "peak of S, Ms", "1", "sensitivity", _plain),
    Shown("mt", "peak of T, Mt", "1", "complementary", _plain),
    Shown("disk", "disk margin", "1", "disk", _plain, "nothing limits it"),
    Shown("bandwidth", "bandwidth", "rad/s", "bandwidth", _plain),
    Shown("load_index", "load index", "s^-3", "load_index", _plain),
)  # fmt: skip


@dataclass(frozen=True)
class Subject:
    """Gains whose margins are judged: controller, trim, margin model of its airframe, and the margins of its row."""

    controller: Controller
    trim: Trim
    model: MarginModel
    margins: Margins

    @property
    def row(self) -> Array:
        """Gains row (g,)."""
        return np.array(self.controller.gains)

    @property
    def looped(self) -> tuple[str, ...]:
        """Channels that have a loop, in the order of `CHANNELS`."""
        closed = {channel for block in self.model.blocks for channel in block}
        return tuple(channel for channel in CHANNELS if channel in closed)

    def swept(self, channel: str) -> bool:
        """Whether the loop of a channel depends on amplitude."""
        return bool(self.margins.sensitivity.case[0, CHANNELS.index(channel)] >= 0)

    def value(self, shown: Shown, channel: str) -> float:
        """Value of a quantity of a loop in the unit it is shown in."""
        worst: Worst = getattr(self.margins, shown.source)
        return float(shown.shown(worst.value[0, CHANNELS.index(channel)], self.margins.period))


def subject_of(controller: Controller, trim: Trim) -> Subject:
    """Judge a controller on its own airframe; raises InputError where there is no steady flight in this trim."""
    vehicle = controller.airframe.vehicle
    known = nominal(vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    model = MarginModel(controller.cascade, known, timing, vehicle, trim)
    return Subject(controller, trim, model, model.evaluate(np.array([controller.gains])))
