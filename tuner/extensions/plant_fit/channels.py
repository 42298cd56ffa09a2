"""Loops that a study of a fitted plant begins with: gains by Skogestad's rule, and ranges around them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from plant.texts import PlainTable
from tuner.extensions.plant_fit.intervals import FittedPlant

Array = np.ndarray
Gains = dict[str, float]
LAWS: Mapping[str, tuple[str, str]] = {
    "pi": ("pid", "pid"), "pid": ("pid", "pid"), "adrc": ("adrc1", "ladrc"), "ladrc": ("ladrc", "ladrc"),
}  # fmt: skip
"""Law on the command line -> law of the channel of a plant of first order, and of one of a higher order."""
RANGE = (1.0 / 30.0, 10.0)
"""Ends of a gain's range over its default."""
MAX_BANDWIDTH = 0.28
"""Largest bandwidth of an observer times the control period."""
CLOSE = 1.6
"""Ratio of a zero to a smaller lag below which they cancel."""
MIN_RATIO = 0.5
"""Second over first term of a plant's denominator, at an observer's bandwidth, from which it is of second order."""
LIMIT_STEPS = 20.0
"""Error, in steps of the reference, from which a flight has failed."""


def round_to(value: float, digits: int = 3) -> float:
    """Return a value of so many significant digits."""
    return float(f"{value:.{digits}g}")


@dataclass(frozen=True)
class Loop:
    """A channel: an output, the input that moves it, and the range of the output in the data."""

    plant: FittedPlant
    j: int
    output: str
    input: str
    moved: float

    @property
    def step(self) -> float:
        """Step of the reference: a quarter of what the data show, in two digits."""
        return round_to(0.25 * self.moved, 2)

    @property
    def gain(self) -> float:
        """Gain of the plant, its stable zeros cancelled."""
        return self._reduced[0]

    @cached_property
    def _reduced(self) -> tuple[float, Array]:
        """Gain, and denominator from the lowest power, without stable zeros."""
        solution = self.plant.solution
        rising = solution.denominators[self.j][::-1][solution.structure.integrators :]
        return cancel_zeros(solution.numerators[self.j], rising, self._late)

    @property
    def _late(self) -> float:
        """Dead time [s], for the controller with half a sampling interval."""
        return float(self.plant.solution.dead_times[self.j]) + 0.5 * self.plant.chosen.problem.period

    @property
    def times(self) -> tuple[float, float, float]:
        """First and second coefficient of s, and effective dead time [s].

        Further poles, zeros in the right half-plane and half a sampling interval count as dead time.
        """
        rising, late = self._reduced[1], self._late
        first = float(rising[1]) if len(rising) > 1 else 0.0
        second = float(rising[2]) if len(rising) > 2 else 0.0
        for zero in np.roots(self.plant.solution.numerators[self.j][::-1]):
            if zero.real > 0.0:
                late += 1.0 / float(abs(zero))
        if len(rising) > 3:
            late += float(rising[-1] / rising[-2])
        return first, second, late


def cancel_zeros(numerator: Array, denominator: Array, late: float) -> tuple[float, Array]:
    """Return gain and denominator of a plant whose stable zeros are cancelled.

    Those are the real ones in the left half-plane. A zero that a rule for gains neglects makes a plant faster than the rule
    assumes, and the loop unstable. Each is cancelled by a lag of about its size (rules T1 to T5 of Skogestad 2003).

    Args:
        numerator: Coefficients from the lowest power of s.
        denominator: The same, without integrators.
        late: Dead time [s].
    """
    gain, roots = float(numerator[0]), np.roots(denominator[::-1])
    zeros = [-1.0 / float(each.real) for each in np.roots(numerator[::-1]) if each.real < 0.0 == each.imag]
    lags = sorted(-1.0 / float(each.real) for each in roots if each.imag == 0.0)
    if not zeros or not lags:
        return gain, denominator
    for zero in sorted(zeros, reverse=True)[: len(lags)]:
        lag = _nearest(lags, zero)
        lags.remove(lag)
        share, rest = _ratio(zero, lag, late)
        gain *= share
        lags += [rest] if rest > 0.0 else []
    rising = np.ones(1)
    for each in lags:
        rising = np.convolve(rising, [1.0, each])
    for pole in roots[roots.imag > 0.0]:
        rising = np.convolve(rising, [1.0, -2.0 * pole.real / abs(pole) ** 2, 1.0 / abs(pole) ** 2])
    return gain, rising


def _nearest(lags: list[float], zero: float) -> float:
    """Return the lag that a zero is cancelled by: the next larger one, unless a smaller one is close."""
    larger = min((each for each in lags if each >= zero), default=np.inf)
    smaller = max((each for each in lags if each < zero), default=0.0)
    is_close = smaller > 0.0 and zero / smaller < min(larger / zero, CLOSE)
    return smaller if is_close or np.isinf(larger) else larger


def _ratio(zero: float, lag: float, late: float) -> tuple[float, float]:
    """Return gain and lag for (zero s + 1) / (lag s + 1) behind a dead time."""
    if zero >= lag:
        return max(zero, late) / max(lag, late), 0.0
    if zero >= 5.0 * late:
        return zero / lag, 0.0
    short = min(lag, 5.0 * late)
    return short / lag, max(short - zero, 0.0)


def channel_tables(loops: Sequence[Loop], law: str, period: float) -> tuple[list[PlainTable], PlainTable]:
    """Return [[channel]] and [gains] of loops under a law."""
    channels: list[PlainTable] = []
    gains: PlainTable = {}
    for loop in loops:
        name_of_law = _law(loop, law, period)
        is_pid = name_of_law == "pid"
        b0 = float(np.sign(loop.gain)) if is_pid else round_to(_high_frequency_gain(loop, name_of_law == "adrc1"))
        table: PlainTable = {"name": loop.output, "law": name_of_law, "output": loop.output, "to": loop.input}
        if b0 != 1.0:
            table["b0"] = b0
        table["lost_beyond"] = round_to(LIMIT_STEPS * loop.step, 2)
        channels.append(table)
        searched, fixed = _pid(loop, law == "pi", period) if is_pid else _observer(loop, period)
        fixed = fixed if name_of_law != "adrc1" else {}
        for name, value in searched.items():
            low, high = (round_to(value * end) for end in RANGE)
            if name == "omega_o":
                high = min(high, round_to(MAX_BANDWIDTH / period, 2))
            gains[f"{loop.output}.{name}"] = {"low": low, "high": high, "default": round_to(value)}
        gains |= {f"{loop.output}.{name}": round_to(value) for name, value in fixed.items()}
    return channels, gains


def _law(loop: Loop, law: str, period: float) -> str:
    """Return the law of a channel.

    A loop with an observer of second order that is slower than the lags of a plant is far slower than its bandwidth.
    """
    first_order, higher = LAWS[law]
    structure = loop.plant.solution.structure
    if structure.order > 1 and not structure.integrators:
        first, second, late = loop.times
        bandwidth = _observer(loop, period)[0]["omega_o"]
        return higher if bandwidth * (second + first * late) >= MIN_RATIO * first else first_order
    return higher if structure.order > 1 else first_order


def bandwidths(gains: PlainTable) -> list[float]:
    """Return the first bandwidths of loops under ADRC [rad/s]."""
    tables = [value for name, value in gains.items() if name.endswith(".omega_c")]
    return [float(cast("dict[str, float]", each)["default"]) for each in tables]


def _pid(loop: Loop, is_pi: bool, period: float) -> tuple[Gains, Gains]:
    """Return searched and fixed gains by Skogestad's rule.

    S. Skogestad, "Simple analytic rules for model reduction and PID controller tuning", J. Process Control 13, 2003.
    """
    first, second, late = loop.times
    size = abs(loop.gain)
    # A closed loop at four times the dead time leaves room for what the data do not show.
    speed = 4.0 * max(late, period)
    if loop.plant.solution.structure.integrators:
        kp, reset = 1.0 / (size * speed), 4.0 * speed
        derivative = max(first, 0.25 * late)
    else:
        speed = max(speed, 0.1 * first)
        # An oscillating plant is led by the integral, whose reset time is that of its first coefficient.
        reset = min(max(first, 0.2 * speed), 4.0 * speed)
        kp = max(first, 0.2 * speed) / (size * speed)
        derivative = second / max(first, 0.2 * speed) if second else 0.25 * late
    searched = {"kp": kp, "ki": kp / reset}
    filtered = max(0.1 * derivative, 2.0 * period)
    if is_pi:
        return searched, {"kd": 0.0, "t_f": filtered}
    return searched | {"kd": kp * derivative}, {"t_f": filtered}


def _high_frequency_gain(loop: Loop, is_first: bool) -> float:
    """Return the gain from command to first or second derivative.

    Args:
        loop: Channel.
        is_first: Whether it is that of the first; for the second a dead time counts as a lag.
    """
    first, second, late = loop.times
    if is_first:
        return loop.gain / (first or 1.0)
    if loop.plant.solution.structure.integrators:
        return loop.gain / max(first + late, 1e-12)
    return loop.gain / max(second + first * late, 1e-12)


def _observer(loop: Loop, period: float) -> tuple[Gains, Gains]:
    """Return gains of a disturbance observer whose bandwidth the dead time allows (Gao, 2003)."""
    first, _, late = loop.times
    # An observer three times as fast has to be slow beside the control period.
    bandwidth = min(0.2 / (max(late, period) + 0.05 * first), 0.2 * MAX_BANDWIDTH / period)
    return {"omega_c": bandwidth, "omega_o": 3.0 * bandwidth}, {"zeta": 1.0}
