"""A PD law with disturbance observer at one frequency, in CasADi.

Its expressions are in its gains:

    u = -(N_y y + N_v y')/D,   L = G_a (N_y + s N_v)/(s^2 D)

CasADi has no complex type, so numbers are pairs of real and imaginary part. N_y, N_v and D are multiplied by (s + wo)^3: nothing
divides, and all is smooth in the gains. G. Herbst, "Transfer function analysis and implementation of active disturbance
rejection control", Control Theory and Technology 2021, has C = (N_y + s N_v)/D for the case that all states are estimates.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca

from plant.laws.observer import triple_pole


class Complex(NamedTuple):
    """Real and imaginary part."""

    re: Any
    im: Any

    def plus(self, other: "Complex") -> "Complex":
        """Return the sum."""
        return Complex(self.re + other.re, self.im + other.im)

    def times(self, other: "Complex") -> "Complex":
        """Return the product."""
        return Complex(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)

    def scaled(self, factor: Any) -> "Complex":
        """Return a real multiple."""
        return Complex(factor * self.re, factor * self.im)

    def square(self) -> Any:
        """Return the squared size."""
        return self.re * self.re + self.im * self.im


ZERO, ONE = Complex(0.0, 0.0), Complex(1.0, 0.0)


@dataclass(frozen=True)
class Feedback:
    """kp [1/s2], kd [1/s], omega_o [rad/s] as expressions; value_too, rate_too: whether the P and the D part act on the
    estimates z1 and z2 instead of on what is measured.
    """

    kp: Any
    kd: Any
    omega_o: Any
    value_too: bool
    rate_too: bool


class Observed(NamedTuple):
    """N_y, N_v and D of a law."""

    from_value: Complex
    from_rate: Complex
    command: Complex


def observed(law: Feedback, s: Complex, applied: Complex) -> Observed:
    """Return the law at s.

    applied: share of its command that its observer uses.
    """
    kp, kd, omega_o = law.kp, law.kd, law.omega_o
    b1, b2, b3 = triple_pole(omega_o)
    s2 = s.times(s)
    # (s + wo)^3 z = what y leads to + what the known command leads to, for z1, z2 and z3.
    poles = s2.times(s).plus(s2.scaled(b1)).plus(s.scaled(b2)).plus(ONE.scaled(b3))
    z1 = s2.scaled(b1).plus(s.scaled(b2)).plus(ONE.scaled(b3)), s
    z2 = s2.scaled(b2).plus(s.scaled(b3)), s2.plus(s.scaled(b1))
    z3 = s2.scaled(b3), ONE.scaled(-b3)
    value, by_command, rate = z3[0], z3[1], ZERO
    if law.value_too:
        value, by_command = value.plus(z1[0].scaled(kp)), by_command.plus(z1[1].scaled(kp))
    else:
        value = value.plus(poles.scaled(kp))
    if law.rate_too:
        value, by_command = value.plus(z2[0].scaled(kd)), by_command.plus(z2[1].scaled(kd))
    else:
        rate = poles.scaled(kd)
    return Observed(value, rate, poles.plus(by_command.times(applied)))


def sensitivities(value_too: bool, rate_too: bool, names: tuple[str, ...]) -> ca.Function:
    """Return the function whose rows are the named squared responses.

    Its arguments are (kp, kd, wo) and (omega, G_a re, im, G_k re, im).
    "S", "T": the sensitivities; "value noise", "rate noise": from errors of the measured value and rate to the command.
    """
    gains, point = ca.SX.sym("gains", 3), ca.SX.sym("point", 5)
    omega, law = point[0], Feedback(gains[0], gains[1], gains[2], value_too, rate_too)
    s, delivered, applied = Complex(0.0, omega), Complex(point[1], point[2]), Complex(point[3], point[4])
    seen = observed(law, s, applied)
    back = s.times(s).times(seen.command)
    ahead = delivered.times(seen.from_value.plus(seen.from_rate.times(s)))
    total = back.plus(ahead).square()
    squares = {
        "S": back.square() / total,
        "T": ahead.square() / total,
        "value noise": omega**4 * seen.from_value.square() / total,
        "rate noise": omega**4 * seen.from_rate.square() / total,
    }
    return ca.Function("sensitivities", [gains, point], [ca.vertcat(*[squares[name] for name in names])])
