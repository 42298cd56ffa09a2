"""PID by the convex-concave procedure: the largest integral gain that keeps its distance from -1.

    maximize ki   subject to   |1 + L(jw)| >= 1/Ms,   |L(jw) - c| >= r,   command noise, largest kp

with c = -Mt^2/(Mt^2 - 1) and r = Mt/(Mt^2 - 1), on w from below the bandwidth to Nyquist. L is affine in (kp, ki, kd), so
staying out of a disc is the complement of a convex set; it is replaced by the half-plane that touches the disc on the side of
the last iterate, Re(conj(L_j - c)/|L_j - c| (L - c)) >= r. Each step is a cone program whose answer keeps the true constraint
too, and along the way from one iterate to the next no L(jw) meets the disc, so the number of encirclements stays that of the
start: a PD law slow enough to be stable. M. Hast, K. J. Astrom, B. Bernhardsson, S. Boyd, "PID design by convex-concave
optimization", European Control Conference 2013.

The time constant of the derivative filter stays at its default, for which L is affine. A large ki means a small integrated
error, 1/ki per unit of a load step, and with the peaks bounded also a small integrated absolute error.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from objectives.design.design_axis import AxisDesign, DesignAxis, fall_back, judged
from objectives.design.requirements import DesignRequirements
from objectives.lmi import solve_again

Array = np.ndarray

POINTS, ITERATIONS = 200, 30
# Largest factor by which a step changes a gain; keeps the cone programs well scaled.
STRIDE = 5.0
# What is made large has settled where a step adds less than this to its logarithm.
SETTLED = 1e-4
# What a damping without end allows: the square of a step of kd over one of kp.
UNDAMPED = 1e3
# Bandwidths wc of the starts, over one by the delay of the actuator; kd as a share of that of critical or of the largest damping,
# ki as a share of wc^3.
STARTS = (0.3, 0.1, 0.03, 0.01)
START_DAMPING, START_INTEGRAL = 0.9, 0.05


def discs(requirements: DesignRequirements) -> tuple[tuple[float, float], ...]:
    """Return (center, radius) of the discs that L keeps out of."""
    mt2 = requirements.mt**2
    return (-1.0, 1.0 / requirements.ms), (-mt2 / (mt2 - 1.0), requirements.mt / (mt2 - 1.0))


def parts(axis: DesignAxis, omega: Array) -> Array:
    """Return the columns (k, 3) of which kp, ki and kd make L."""
    s = 1j * omega
    plant = axis.responses(omega)[0] / s**2
    return np.stack([plant, plant / s, plant * s * derivative(axis, omega)], axis=1)


def derivative(axis: DesignAxis, omega: Array) -> Array:
    """Return the filter of the derivative; differencing y delays it by half a period and weakens it besides."""
    s = 1j * omega
    differencing = -np.expm1(-s * axis.control_period) / (s * axis.control_period) if axis.from_observer else 1.0
    return differencing / (axis.default("t_f") * s + 1.0)


def noise_root(axis: DesignAxis, requirements: DesignRequirements) -> Array:
    """Return the root (2, 2) of the command noise's power.

    Its product with (kp, kd) has the RMS of the command noise as its length.
    Exact for white noise at every sample and the filter as sampled, f+ = f + a (rate - f); the rate is measured with noise of its
    own, or it is the difference of two values.
    """
    value, rate = requirements.noises(axis.loop)
    a, h = -np.expm1(-axis.control_period / axis.default("t_f")), axis.control_period
    if axis.from_observer:
        together, alone = a / h, 2.0 * a**2 / (h**2 * (2.0 - a))
        return value * np.array([[1.0, together], [0.0, sqrt(alone - together**2)]])
    return np.diag([value, rate * sqrt(a / (2.0 - a))])


class ConeProgram:
    """One step of the procedure: a cone program over the factors x by which (kp, ki, kd) change, compiled once.

    maximize x_i x_p^speed   subject to   rows x >= least,   low <= x <= high,   |noise (x_p, x_d)| <= 1,   x_d^2 <= damping x_p
    """

    def __init__(self, rows: int, speed: float) -> None:
        self._x: Any = cp.Variable(3)
        self._given: dict[str, Any] = {
            "rows": cp.Parameter((rows, 3)),
            "least": cp.Parameter(rows),
            "low": cp.Parameter(3),
            "high": cp.Parameter(3),
            "noise": cp.Parameter((2, 2)),
            "damping": cp.Parameter(nonneg=True),
        }
        x, given = self._x, self._given
        inside = [given["rows"] @ x >= given["least"], x >= given["low"], x <= given["high"]]
        inside += [cp.norm(given["noise"] @ x[[0, 2]]) <= 1.0, cp.square(x[2]) <= given["damping"] * x[0]]
        # A product of powers as a tower of second-order cones; the exponential cone of a logarithm often fails here.
        aim = cp.geo_mean(cp.hstack([x[1], x[0]]), [1.0, speed]) if speed > 0.0 else x[1]
        self._problem = cp.Problem(cp.Maximize(aim), inside)

    def factors(self, **given: Any) -> Array | None:
        """Return x, or None where the solver fails."""
        for name, value in given.items():
            self._given[name].value = value
        return self._x.value if solve_again(self._problem) else None


@dataclass(frozen=True)
class PidTask:
    """Terms of the convex-concave procedure; gains are (kp, ki, kd).

    Attributes:
        parts: Responses that the gains make L of, at k frequencies (k, 3).
        discs: Pairs (center, radius) of the discs that L keeps out of.
        noise: Matrix whose product with (kp, kd) is at most one long (2, 2).
        damping: Largest ratio of the PD part, infinite for none.
        speed: Power of kp in the merit ki kp^speed.
        low: Lower ends of the ranges.
        high: Upper ends of the ranges.
    """

    parts: Array
    discs: tuple[tuple[float, float], ...]
    noise: Array
    damping: float
    speed: float
    low: Array
    high: Array


class Procedure:
    """The procedure from a start that keeps everything."""

    def __init__(self, task: PidTask) -> None:
        self._parts, self._discs, self._noise = task.parts, task.discs, task.noise
        self._damping, self._speed, self._low, self._high = task.damping, task.speed, task.low, task.high
        self._step = ConeProgram(len(task.discs) * len(task.parts), task.speed)

    def settle(self, gains: Array) -> Array:
        """Return the gains to which the steps from a start converge."""
        for _ in range(ITERATIONS):
            better = self.improve(gains)
            if better is None or self.merit(better) <= self.merit(gains) + SETTLED:
                return gains if better is None else better
            gains = better
        return gains

    def merit(self, gains: Array) -> float:
        """Return the merit: the logarithm of ki kp^speed."""
        return float(np.log(gains[1]) + self._speed * np.log(gains[0]))

    def improve(self, gains: Array) -> Array | None:
        """Return the gains after one step."""
        loop = self._parts @ gains
        rows, least = [], []
        for center, radius in self._discs:
            outward = np.conj(loop - center) / np.abs(loop - center)
            row = (outward[:, None] * self._parts * gains).real
            bound = radius + outward.real * center
            size = np.abs(row).max(axis=1) + np.abs(bound)
            rows.append(row / size[:, None])
            least.append(bound / size)
        factors = self._step.factors(
            rows=np.concatenate(rows, axis=0),
            least=np.concatenate(least, axis=0),
            low=np.maximum(self._low / gains, 1.0 / STRIDE),
            high=np.minimum(self._high / gains, STRIDE),
            noise=self._noise * gains[[0, 2]],
            damping=min(4.0 * self._damping**2 * gains[0] / gains[2] ** 2, UNDAMPED),
        )
        return None if factors is None else gains * factors

    def keeps(self, gains: Array) -> bool:
        """Return True if gains keep everything."""
        loop, (kp, _, kd) = self._parts @ gains, gains
        is_outside = all(bool((np.abs(loop - center) >= radius).all(axis=0)) for center, radius in self._discs)
        quiet = float(np.linalg.norm(self._noise @ np.array([kp, kd]))) <= 1.0
        damped = bool(kd**2 <= 4.0 * self._damping**2 * kp)
        return is_outside and quiet and damped and bool((gains <= self._high).all(axis=0))


def task_of(axis: DesignAxis, requirements: DesignRequirements) -> PidTask:
    """Return the task of one axis of a quadrotor."""
    low, high = np.array([axis.range(name) for name in ("kp", "ki", "kd")]).T
    high[0] = min(high[0], axis.authority / requirements.step(axis.loop))
    noise = noise_root(axis, requirements) / (requirements.noise * axis.authority)
    of_gains = parts(axis, axis.frequencies(POINTS, requirements))
    return PidTask(of_gains, discs(requirements), noise, requirements.damping, requirements.speed, low, high)


def starts(axis: DesignAxis, task: PidTask) -> list[Array]:
    """Return the starts of an axis, in the ranges of its gains."""
    points, damping = [], START_DAMPING * min(task.damping, 1.0)
    for share in STARTS:
        bandwidth = min(share / axis.unit(), sqrt(task.high[0]))
        gains = [bandwidth**2, START_INTEGRAL * bandwidth**3, 2.0 * damping * bandwidth]
        points.append(np.clip(gains, task.low, task.high))
    return points


def design_pid(axis: DesignAxis, requirements: DesignRequirements) -> AxisDesign:
    """Return the PID gains of an axis, or its defaults.

    They are the defaults where no start keeps the requirements.
    """
    task = task_of(axis, requirements)
    procedure = Procedure(task)
    settled = [procedure.settle(start) for start in starts(axis, task) if procedure.keeps(start)]
    for gains in sorted(settled, key=procedure.merit, reverse=True):
        kp, ki, kd = gains.tolist()
        record = axis.record(kp=kp, ki=ki, kd=kd, t_f=axis.default("t_f"))
        design = judged(axis, record, ki, requirements)
        if design is not None:
            return design
    return fall_back(axis, "no PID law within the ranges of its gains keeps the requirements")
