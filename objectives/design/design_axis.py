"""Input and output of a designer: one axis, and its gains."""

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from objectives.design.frequency import actuator_response, closed_matrix, peaks
from objectives.design.requirements import DesignRequirements
from objectives.linear_axis.channel_model import AxisLoop, RotorLag, TiltLoop, is_stable
from plant.laws.law import Law
from plant.quadrotor.gains import MAX_BANDWIDTH_PERIODS

Array = np.ndarray

# A loop's peaks lie between these shares of its largest bandwidth and of one over its actuator's delay; what is found is
# checked at so many frequencies, up to Nyquist.
SLOWEST, FASTEST, CHECKED = 0.02, 6.0, 1500
# Frequencies [rad/s] among which the speed of an actuator is looked for.
SURVEY = np.geomspace(1e-2, 1e4, 1201)
# A peak may be exceeded by this share between the frequencies of the design.
SLACK = 0.01


@dataclass(frozen=True)
class DesignAxis:
    """One axis to be designed: the law, the loop "attitude" or "position", what it acts through, where its rate comes from,
    control period [s] and the largest acceleration of the axis at hover, rad/s2 or m/s2.
    """

    law: Law
    loop: str
    actuator: RotorLag | TiltLoop
    from_observer: bool
    control_period: float
    authority: float

    def closed(self, gains: Any) -> AxisLoop:
        """Return the axis with gains."""
        return AxisLoop(self.law.name, gains, self.actuator, self.loop, self.from_observer)

    def range(self, name: str) -> tuple[float, float]:
        """Return a gain's range; the control period limits an observer's bandwidth."""
        info = next(gain for gain in self.law.gains if gain.name == name)
        span = info.span(self.loop)
        high = min(span.high, MAX_BANDWIDTH_PERIODS / self.control_period) if info.observer else span.high
        return min(span.low, high), high

    def record(self, **gains: float) -> Any:
        """Return the law's Gains; a solver's answer may lie outside a range by its tolerance, a gain may not."""
        return self.law.Gains(**{name: float(np.clip(value, *self.range(name))) for name, value in gains.items()})

    def default(self, name: str) -> float:
        """Return the default of a gain."""
        return self.law.defaults(self.loop)[name]

    def unit(self) -> float:
        """Return the unit of time that its loop's speed scales with [s].

        It is one over the frequency at which the actuator is late by one radian.
        """
        phase = np.unwrap(np.angle(self.responses(SURVEY)[0]))
        return float(1.0 / SURVEY[(phase < -1.0).argmax(axis=0)])

    def frequencies(self, points: int, requirements: DesignRequirements) -> Array:
        """Return frequencies [rad/s] among which a loop through this actuator has its peaks."""
        return np.geomspace(self._slowest(requirements), min(FASTEST / self.unit(), self.nyquist()), points)

    def all_frequencies(self, points: int, requirements: DesignRequirements) -> Array:
        """Return frequencies [rad/s] from below any peak to that of Nyquist."""
        return np.geomspace(0.3 * self._slowest(requirements), self.nyquist(), points)

    def nyquist(self) -> float:
        """Return the frequency of Nyquist [rad/s]."""
        return np.pi / self.control_period

    def _slowest(self, requirements: DesignRequirements) -> float:
        """Return the lowest bandwidth of its loops [rad/s].

        The actuator's delay or what it can do about the largest step limits bandwidths.
        """
        return SLOWEST * min(1.0 / self.unit(), sqrt(self.authority / requirements.step(self.loop)))

    def responses(self, omega: Array) -> tuple[Array, Array]:
        """Return (delivered, known) at frequencies [rad/s]."""
        return actuator_response(self.actuator, 1j * omega)


@dataclass(frozen=True)
class AxisDesign:
    """Result of the design of an axis.

    Attributes:
        gains: A Gains record.
        designed: Whether it is a design, not the default.
        load_rejection: Integral gain that a slow disturbance meets, 0 where there is none [1/s3].
        ms: Peak of the sensitivity, computed afterwards.
        mt: Peak of the complementary sensitivity, computed afterwards.
        why: One sentence.
    """

    gains: Any
    designed: bool
    load_rejection: float
    ms: float
    mt: float
    why: str


def fall_back(axis: DesignAxis, why: str) -> AxisDesign:
    """Return the default gains; an observer's bandwidth within its limit."""
    defaults = axis.law.defaults(axis.loop)
    limited = {name: min(value, axis.range(name)[1]) for name, value in defaults.items()}
    return AxisDesign(axis.law.Gains(**limited), False, 0.0, np.inf, np.inf, why)


def judged(
    axis: DesignAxis,
    gains: Any,
    load_rejection: float,
    requirements: DesignRequirements,
    powers: tuple[float, ...] = (0.0,),
) -> AxisDesign | None:
    """Return the design if it passes the final check, else None.

    It is stable and keeps its peaks on a much finer grid, at every equivalent gain.
    """
    closed = axis.closed(gains)
    if not all(is_stable(closed_matrix(closed, power)) for power in powers):
        return None
    omega = axis.all_frequencies(CHECKED, requirements)
    pairs = np.array([peaks(closed, omega, power) for power in powers])
    worst_s, worst_t = pairs.max(axis=0).tolist()
    if worst_s > (1.0 + SLACK) * requirements.ms or worst_t > (1.0 + SLACK) * requirements.mt:
        return None
    return AxisDesign(
        gains, True, load_rejection, worst_s, worst_t, "load rejection as large as the requirements allow"
    )
