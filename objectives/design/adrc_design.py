"""LADRC and the hybrid by nonlinear programming: the largest load rejection that keeps its distance from -1.

    maximize log k_i   subject to   |S(jw)| <= Ms,   |T(jw)| <= Mt,   command noise, largest kp, ranges

over (wc, zeta, wo) or (lambda, k, wo), with k_i = lim s C(s), the integral gain that a slow disturbance meets: kp/(3/wo + T)
with measured rate and an observer that knows an actuator of mean delay T. C is not affine in wo, so this is a smooth program
in the logarithms of the gains, solved by IPOPT with derivatives by CasADi, from several starts; the best answer that is
stable and keeps its peaks on a finer grid counts. |1 + L| >= 1/Ms alone does not exclude encirclement, hence the check.

The hybrid's power-rate term makes its gain depend on amplitude: k(A) = k2 + k1 N(A), from k2 up to k2 + 0.9265 k1/sqrt(delta),
N being its describing function. The peaks are kept at all gains between; k_i counts at the smallest, which any small
disturbance meets. delta stays at its default: it is an amplitude, which no linear design can choose. The steepest slope,
k2 + 1.5 k1/sqrt(delta), must be stable.

G. Herbst, "Transfer function analysis and implementation of active disturbance rejection control", Control Theory and
Technology 2021, for C; sampling enters as dead time.
"""

from math import sqrt
from typing import Any

import casadi as ca
import numpy as np

from objectives.design.design_axis import AxisDesign, DesignAxis, fall_back, judged
from objectives.design.expressions import Feedback
from objectives.design.frequency import closed_matrix, responses
from objectives.design.program import LoopLimits, Program, merit
from objectives.design.requirements import DesignRequirements
from objectives.linear_axis.channel_model import is_stable

# Bandwidths of feedback and observer to start from, over one by the delay of the actuator.
STARTS = ((0.05, 0.25), (0.3, 0.4), (0.1, 1.5))
# Largest value of sqrt(delta) N(A), at A = 1.08 delta; largest slope of |S|^(1/2) sat(S/delta), over 1/sqrt(delta).
LARGEST_DESCRIBING, LARGEST_SLOPE = 0.9265, 1.5
# Equivalent gains at which the hybrid keeps its peaks, from the smallest (0) to the largest (1), evenly in the logarithm; and how
# many of them are checked afterwards.
BETWEEN, CHECKED_GAINS = (0.0, 0.5, 1.0), 6


def ladrc_program(axis: DesignAxis, requirements: DesignRequirements) -> Program:
    """Return the program over (wc, zeta, wo)."""
    x, estimated = ca.MX.sym("x", 3), axis.from_observer
    wc, zeta, wo = ca.vertsplit(ca.exp(x))
    law = Feedback(wc * wc, 2.0 * zeta * wc, wo, estimated, estimated)
    low, high = np.array([axis.range(name) for name in ("omega_c", "zeta", "omega_o")]).T
    high[1] = min(high[1], max(requirements.damping, low[1]))
    most = LoopLimits(axis, requirements, estimated, estimated).of(law)
    return Program(x, merit(axis, requirements, law), most, low, high)


def hybrid_program(axis: DesignAxis, requirements: DesignRequirements) -> Program:
    """Return the program over (lambda, k, wo), k [1/s] the largest equivalent gain."""
    x, share = ca.MX.sym("x", 3), requirements.power_share
    lam, k, wo = ca.vertsplit(ca.exp(x))
    parts = [(1.0 - share) ** (1.0 - between) * k for between in (BETWEEN if share > 0.0 else BETWEEN[:1])]
    laws = [Feedback(lam * part, lam + part, wo, False, axis.from_observer) for part in parts]
    limits = LoopLimits(axis, requirements, False, axis.from_observer)
    most = [lam / parts[0], *(entry for law in laws for entry in limits.of(law))]
    low, high = np.array([axis.range("lambda_"), largest_gain_range(axis, share), axis.range("omega_o")]).T
    return Program(x, merit(axis, requirements, laws[0]), most, low, high)


def largest_gain_range(axis: DesignAxis, share: float) -> tuple[float, float]:
    """Return the range of the hybrid's largest equivalent gain.

    In it k1 and k2 stay within their ranges.
    """
    low, high = (end / (1.0 - share) for end in axis.range("k2"))
    if share == 0.0:
        return low, high
    most = axis.range("k1")[1] * LARGEST_DESCRIBING / (share * sqrt(axis.default("delta")))
    return min(low, most), min(high, most)


def hybrid_gains(axis: DesignAxis, share: float, lam: float, k: float, omega_o: float) -> Any:
    """Return the hybrid's gains whose largest equivalent gain is k."""
    delta = axis.default("delta")
    k1 = share * k / LARGEST_DESCRIBING * sqrt(delta)
    return axis.record(omega_o=omega_o, lambda_=lam, k1=k1, k2=(1.0 - share) * k, delta=delta)


def design_ladrc(axis: DesignAxis, requirements: DesignRequirements) -> AxisDesign:
    """Return the linear ADRC gains of an axis, or its defaults.

    They are the defaults where no start leads to a design that keeps everything.
    """
    unit = 1.0 / axis.unit()
    starts = [(unit * wc, 1.0, unit * wo) for wc, wo in STARTS]
    for wc, zeta, wo in ladrc_program(axis, requirements).answers(starts):
        gains = axis.record(omega_c=wc, zeta=zeta, omega_o=wo)
        design = judged(axis, gains, integral_gain(axis, gains), requirements)
        if design is not None:
            return design
    return fall_back(axis, "no linear ADRC within the ranges of its gains keeps the requirements")


def design_hybrid(axis: DesignAxis, requirements: DesignRequirements) -> AxisDesign:
    """Return the gains of the hybrid for an axis, or its defaults.

    They are the defaults where no start leads to a design that keeps everything.
    """
    unit, share = 1.0 / axis.unit(), requirements.power_share
    starts = [(0.5 * unit * wc, 2.0 * unit * wc, unit * wo) for wc, wo in STARTS]
    for lam, k, wo in hybrid_program(axis, requirements).answers(starts):
        gains = hybrid_gains(axis, share, lam, k, wo)
        sector = gains.k1 / sqrt(gains.delta)
        powers = tuple(float(p) for p in np.linspace(0.0, LARGEST_DESCRIBING * sector, CHECKED_GAINS))
        design = judged(axis, gains, integral_gain(axis, gains), requirements, powers)
        # Stable with the steepest slope in place of the power-rate term, too.
        if design is not None and is_stable(closed_matrix(axis.closed(gains), LARGEST_SLOPE * sector)):
            return design
    return fall_back(axis, "no hybrid within the ranges of its gains keeps the requirements")


def integral_gain(axis: DesignAxis, gains: Any) -> float:
    """Return k_i [1/s3] of a law with observer at small amplitude: the limit of s C(s), by extrapolation from small s."""
    s = np.array([1e-4, 2e-4]) / axis.unit()
    near, far = np.real(responses(axis.closed(gains), s).feedback_gain() * s)
    return float(2.0 * near - far)
