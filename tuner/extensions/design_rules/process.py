"""The process that a design rule is for: a gain, a lag and a dead time, fitted to a channel's own step response.

The plant is taken at rest, between the input of a channel and its output, all other inputs held. Its dead time is the delay of
the actuator, half a control period of hold, and what the step response waits.

K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, section 2.7: the tangent of steepest slope crosses 0 at the dead time
L, and 63 % are reached at L + T. S. Skogestad, Simple analytic rules for model reduction and PID controller tuning, J. Process
Control 13 (2003) 291-309: the half rule.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf

import numpy as np
from scipy.linalg import expm

from objectives.plant_system import PlantSystem
from plant.model.plan import Actuator, Channel
from plant.model.slope import linear_equations
from plant.records import paths

Array = np.ndarray
# A pole nearer to 0 than this share of the fastest one is an integrator; one with a smaller imaginary share is real.
INTEGRATING, REAL = 1e-9, 1e-2
# Instants of a step response, and its length in time constants of the slowest pole.
INSTANTS, TIME_CONSTANTS = 4000, 25.0


class NoProcessError(Exception):
    """A channel that rules do not take, with the reason."""


@dataclass(frozen=True)
class Path:
    """The linear path from a command to an output: x' = a x + b u, y = c x, u late by `delay` [s]."""

    a: Array
    b: Array
    c: Array
    delay: float

    def response(self, omega: Array) -> Array:
        """Return the frequency response (k,) at omega [rad/s]."""
        identity = np.eye(len(self.a))
        values = [self.c @ np.linalg.solve(1j * w * identity - self.a, self.b) for w in omega.tolist()]
        return np.array(values) * np.exp(-1j * omega * self.delay)


@dataclass(frozen=True)
class Process:
    """A lag or an integrator with dead time.

    Attributes:
        path: The path that it approximates.
        gain: Steady output per command; of an integrator the rate per command.
        time_constant: Lag [s], infinite for an integrator.
        dead_time: Dead time [s].
        lags: Lags of the path [s], largest first, where it has real poles and no zeros; else none.
    """

    path: Path
    gain: float
    time_constant: float
    dead_time: float
    lags: tuple[float, ...]

    @property
    def is_integrating(self) -> bool:
        """Whether the output has no steady value under a constant command."""
        return self.time_constant == inf

    @property
    def damping(self) -> float:
        """Smallest damping ratio of the poles, 1 if all are real."""
        poles = np.linalg.eigvals(self.path.a)
        swinging = poles[np.abs(poles.imag) > INTEGRATING * np.abs(poles)]
        return float((-swinging.real / np.abs(swinging)).min(initial=1.0))

    @property
    def words(self) -> str:
        """The process in words."""
        late = f"dead time {self.dead_time:.4g} s"
        if self.is_integrating:
            return f"integrator of rate {self.gain:.4g}, {late}"
        return f"gain {self.gain:.4g}, time constant {self.time_constant:.4g} s, {late}"


def process_of(system: PlantSystem, channel: Channel) -> Process:
    """Return the process of a channel; NoProcessError where rules do not take it."""
    path = path_of(system, channel)
    poles: Array = np.linalg.eigvals(path.a)
    fastest = max(float(np.abs(poles).max(initial=0.0)), 1e-300)
    integrators = int(np.count_nonzero(np.abs(poles) < INTEGRATING * fastest))
    if not len(poles):
        raise NoProcessError("its output answers at once; a rule takes a lag or an integrator")
    if integrators > 1 or np.any(np.real(poles) > INTEGRATING * fastest):
        raise NoProcessError(
            "its plant is not stable, or integrates twice; rules take lags and one integrator: design without --method"
        )
    gain, time_constant, waited = _fitted(path, poles, fastest, bool(integrators))
    if channel.b0 * gain <= 0.0:
        raise NoProcessError(f"b0 = {channel.b0:g} has the other sign than the plant's gain; write b0 with that sign")
    return Process(path, gain, time_constant, path.delay + waited, () if integrators else _lags(path, poles))


def path_of(system: PlantSystem, channel: Channel) -> Path:
    """Return the path of a channel, its actuator included."""
    if system.plan.cascades(channel):
        raise NoProcessError("it commands another channel, and a rule takes one between an input and an output")
    plant = system.equations
    equations = linear_equations(plant, system.parameters)
    actuator = next(each for each in system.plan.actuators if each.name == channel.to)
    a, b = equations.a, equations.b[:, paths(plant.Input).index(channel.to)]
    row = paths(plant.Output).index(channel.output)
    a, b, c = _behind(actuator, a, b, equations.c[row])
    used = _used(a, b, c)
    period = channel.every * system.timing.control_period
    return Path(a[used][:, used], b[used], c[used], actuator.delay + 0.5 * period)


def _behind(actuator: Actuator, a: Array, b: Array, c: Array) -> tuple[Array, Array, Array]:
    """Return a path behind the lag of its actuator."""
    if actuator.lag == 0.0:
        return a, b, c
    n = len(a)
    wide = np.zeros((n + 1, n + 1))
    wide[:n, :n], wide[:n, n], wide[n, n] = a, b, -1.0 / actuator.lag
    return wide, np.append(np.zeros(n), 1.0 / actuator.lag), np.append(c, 0.0)


def _used(a: Array, b: Array, c: Array) -> Array:
    """Return the mask of states between input and output."""
    links = (a != 0.0) | np.eye(len(a), dtype=bool)
    reached, seen = b != 0.0, c != 0.0
    for _ in range(len(a)):
        reached, seen = links @ reached, seen @ links
    return reached & seen


def _fitted(path: Path, poles: Array, fastest: float, integrating: bool) -> tuple[float, float, float]:
    """Return gain, time constant and dead time of the step response; of an integrator those of its rate."""
    slow = np.abs(np.real(poles)[np.abs(poles) >= INTEGRATING * fastest])
    horizon = TIME_CONSTANTS / float(slow.min(initial=inf)) if len(slow) else 1.0
    t, y, rate = _step_response(path, horizon)
    if integrating:
        final = float(rate[-1])
        lost = float(np.sum(0.5 * (1.0 - rate[1:] / final + 1.0 - rate[:-1] / final)) * (t[1] - t[0]))
        return final, inf, max(lost, 0.0)
    final = float(y[-1])
    share = y / final
    steepest = int(np.argmax(rate / final))
    waited = max(float(t[steepest] - share[steepest] * final / rate[steepest]), 0.0)
    reached = int(np.argmax(share >= 1.0 - exp(-1.0)))
    before = (1.0 - exp(-1.0) - share[reached - 1]) / (share[reached] - share[reached - 1])
    sixty_three = float(t[reached - 1] + before * (t[1] - t[0]))
    return final, max(sixty_three - waited, t[1] - t[0]), waited


def _step_response(path: Path, horizon: float) -> tuple[Array, Array, Array]:
    """Return times, output and its rate (k,) after a step, without delay."""
    n, t = len(path.a), np.linspace(0.0, horizon, INSTANTS + 1)
    generator = np.zeros((n + 1, n + 1))
    generator[:n, :n], generator[:n, n] = path.a, path.b
    moved, state = expm(t[1] * generator), np.append(np.zeros(n), 1.0)
    states = [state]
    for _ in range(INSTANTS):
        states.append(moved @ states[-1])
    rows = np.array(states)
    return t, rows[:, :n] @ path.c, (rows @ generator.T)[:, :n] @ path.c


def _lags(path: Path, poles: Array) -> tuple[float, ...]:
    """Return the lags of a path, largest first.

    None for a path with zeros or complex poles.
    """
    if np.any(np.abs(np.imag(poles)) > REAL * np.abs(poles)):
        return ()
    moments, column = [], path.b
    for _ in range(len(poles) - 1):
        moments.append(abs(float(path.c @ column)) / max(float(np.abs(path.c) @ np.abs(column)), 1e-300))
        column = path.a @ column
    return (
        () if max(moments, default=0.0) > INTEGRATING else tuple(sorted((1.0 / np.abs(poles)).tolist(), reverse=True))
    )


def half_rule(lags: Sequence[float], dead_time: float, order: int) -> tuple[tuple[float, ...], float]:
    """Return lags and dead time of a model of lower order.

    Half of the first lag that is left out goes to either. lags: at least one, largest first; order: 1 or 2.
    """
    model, left = list(lags[:order]), lags[order:]
    if left:
        model[-1] += 0.5 * left[0]
        dead_time += 0.5 * left[0] + sum(left[1:])
    return tuple(model), dead_time
