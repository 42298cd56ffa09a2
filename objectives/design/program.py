"""The nonlinear program behind designs with an observer: make k_i kp^speed large, keep peaks, command noise and step.

The unknowns are logarithms of gains. Every requirement is brought to the form "at most 1". IPOPT solves it with first and second
derivatives by CasADi, mapped over frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from objectives.design.design_axis import DesignAxis
from objectives.design.expressions import Feedback, sensitivities
from objectives.design.frequency import mean_delays
from objectives.design.requirements import DesignRequirements
from plant.laws.observer import triple_pole

Array = np.ndarray

# Frequencies at which peaks are kept, and at which command noise is summed.
POINTS, NOISE_POINTS = 100, 60
OPTIONS = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 100,
    "show_eval_warnings": False,
}


@dataclass(frozen=True)
class Program:
    """Maximise the objective over x, logarithms of gains, with `most` <= 1; low, high: ranges of the gains."""

    x: Any
    objective: Any
    most: Sequence[Any]
    low: Array
    high: Array

    def answers(self, starts: Sequence[Sequence[float]]) -> list[list[float]]:
        """Return the gains to which the starts converge, best first."""
        nlp = {"x": self.x, "f": -self.objective, "g": ca.vertcat(*self.most)}
        solver = ca.nlpsol("design", "ipopt", nlp, OPTIONS)
        low, high = np.log(self.low), np.log(self.high)
        solutions = []
        for start in starts:
            answer = solver(x0=np.clip(np.log(start), low, high), lbx=low, ubx=high, lbg=-ca.inf, ubg=1.0)
            if solver.stats()["success"]:
                solutions.append((float(answer["f"]), np.exp(np.array(answer["x"]).ravel()).tolist()))
        return [gains for _, gains in sorted(solutions)]


class LoopLimits:
    """Limits of an axis' loop, for any feedback of one kind."""

    def __init__(self, axis: DesignAxis, requirements: DesignRequirements, value_too: bool, rate_too: bool) -> None:
        self._axis, self._requirements = axis, requirements
        self._peaks = axis.frequencies(POINTS, requirements)
        self._noise = axis.all_frequencies(NOISE_POINTS, requirements)
        self._squares = sensitivities(value_too, rate_too, ("S", "T"))
        self._noises = sensitivities(value_too, rate_too, ("value noise", "rate noise"))

    def of(self, law: Feedback) -> list[Any]:
        """Return the constraints, at most 1 each: |S|^2 and |T|^2 over their limits at each frequency, command noise, step."""
        requirements, axis = self._requirements, self._axis
        step = law.kp * requirements.step(axis.loop) / axis.authority
        peaks = self._mapped(self._squares, self._peaks, law)
        limits = ca.DM([requirements.ms**2, requirements.mt**2])
        return [ca.vec(peaks / ca.repmat(limits, 1, len(self._peaks))), self._noise_of(law), step]

    def _noise_of(self, law: Feedback) -> Any:
        """White noise at every sample spreads evenly up to Nyquist."""
        axis, omega = self._axis, self._noise
        share = ca.DM(np.gradient(omega) / axis.nyquist())
        variances = ca.DM(np.square(self._requirements.noises(axis.loop)))
        power = ca.dot(variances, ca.mtimes(self._mapped(self._noises, omega, law), share))
        return power / (self._requirements.noise * axis.authority) ** 2

    def _mapped(self, function: ca.Function, omega: Array, law: Feedback) -> Any:
        delivered, applied = self._axis.responses(omega)
        rows = [omega, *(part(response) for response in (delivered, applied) for part in (np.real, np.imag))]
        gains = ca.vertcat(law.kp, law.kd, law.omega_o)
        return function.map(len(omega))(ca.repmat(gains, 1, len(omega)), ca.DM(np.stack(rows)))


def load_rejection(law: Feedback, known_delay: float) -> Any:
    """Return k_i [1/s3], the limit of s C; known_delay: of the observer's input from the command [s]."""
    b1, b2, b3 = triple_pole(law.omega_o)
    estimated = (law.kp if law.value_too else 0.0) + (law.kd * b1 if law.rate_too else 0.0)
    return law.kp * b3 / (b2 + b3 * known_delay + estimated)


def merit(axis: DesignAxis, requirements: DesignRequirements, law: Feedback) -> Any:
    """Return the merit: the logarithm of k_i kp^speed."""
    rejection = load_rejection(law, mean_delays(axis.actuator)[1])
    return ca.log(rejection) + requirements.speed * ca.log(law.kp)
